//! The metering edges: their opening by the spool, and their flow.

use crate::enumeration;
use crate::numbers::{MonotoneCurve, Number, Pair, Real, Scalar, Tangents, Varying};
use crate::pneumatics::gas::GasState;
use crate::pneumatics::orifice::{Flow, Orifice, is_above};
use crate::variables::Tunable;

enumeration! {
    /// The choice of a valve characteristic; ids are never reused.
    Characteristic "ValveCharacteristic": "Opening of the metering edges over the spool" {
        1 Linear: "Straight line from the end of the dead zone to full travel";
        2 Table: "Smooth monotone curve through the points of valve.tableA and valve.tableB";
    }
}

/// Opening of the edges by the spool, as fractions of their full opening.
#[derive(Clone, Debug, PartialEq)]
pub enum Opening {
    /// `clamp((s - d)/(1 - d), 0, 1)` with the dead zone `d` as a fraction of the spool travel, both ways.
    Linear {
        /// Dead zone `d`.
        dead_zone: Tunable,
        /// `1/(1 - d)`.
        per_travel: Tunable,
    },
    /// A curve over the travel towards chamber A, and one over that towards chamber B.
    Table(Box<[MonotoneCurve; 2]>),
}

impl Opening {
    /// A straight line behind a dead zone.
    pub fn linear(dead_zone: Tunable) -> Self {
        Self::Linear { dead_zone, per_travel: Tunable::still(1.0) / (-dead_zone + 1.0) }
    }

    /// Openings, without leakage, of the edges that feed the chambers A and B; those that vent them open the other way
    /// round.
    #[inline(always)]
    pub fn at<S: Scalar>(&self, spool: S) -> Pair<S> {
        let travel = Pair([spool, -spool]);
        match self {
            Self::Linear { dead_zone, per_travel } => {
                let opening = ((travel - *dead_zone) * *per_travel).max(Pair::zero()).min(Pair::constant(1.0));
                if !S::Held::VARIES {
                    return opening;
                }
                // At the end of the zone each side counts by half; a zone of 0 can only grow.
                let zone = if dead_zone.value == 0.0 { Tunable::still(0.0) } else { *dead_zone };
                let half = (travel - zone) * *per_travel * 0.5;
                let is_there = |side: usize| travel.0[side].value() == dead_zone.value;
                Pair(std::array::from_fn(|side| if is_there(side) { half.0[side] } else { opening.0[side] }))
            }
            Self::Table(curves) => Pair(std::array::from_fn(|side| curves[side].at(travel.0[side]))),
        }
    }

    /// The number, from 0 to 15, of the smooth region in which a spool lies.
    #[inline(always)]
    pub fn smooth_region(&self, spool: f64) -> Real {
        let [towards_a, towards_b] = match self {
            Self::Linear { dead_zone, .. } => {
                let corners = Real::all(&[dead_zone.value, 1.0]);
                let passed = |travel| corners.map(|corner| is_above(travel, corner));
                Real::all(&[spool, -spool]).map(passed).map(|[opens, is_open]| opens + is_open)
            }
            Self::Table(curves) => {
                [curves[0].smooth_region(spool), curves[1].smooth_region(-spool)].map(f64::from).map(Real::of)
            }
        };
        towards_a + towards_b * 4.0
    }
}

/// A metering edge as a data sheet states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Port {
    /// Sonic conductance in m3/(s Pa) when fully open.
    pub conductance: Tunable,
    /// Critical pressure ratio.
    pub critical_ratio: Tunable,
}

/// The edges between both chambers and one port of the valve, side by side.
///
/// ```text
/// C = C_full*(leak + (1 - leak)*opening)   [m3/(s Pa)]
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edges {
    orifice: Orifice<Tangents>,
    /// Sonic conductances in m3/(s Pa): closed, and fully open beyond that.
    closed: Tangents,
    range: Tangents,
}

impl Edges {
    /// The edges of the chambers A and B, with the opening `leak` when closed.
    pub fn new(ports: [Port; 2], leakage: Tunable) -> Self {
        let conductances = ports.map(|port| port.conductance);
        Self {
            orifice: Orifice::pair(ports.map(|port| port.critical_ratio)),
            closed: conductances.map(|conductance| conductance * leakage).into(),
            range: conductances.map(|conductance| conductance * (-leakage + 1.0)).into(),
        }
    }

    /// Sonic conductances in m3/(s Pa) at openings without leakage.
    #[inline(always)]
    pub fn conductance<S: Scalar>(&self, opening: Pair<S>) -> Pair<S> {
        opening * self.range + self.closed
    }

    /// Flow from a gas at the port into the chambers.
    #[inline(always)]
    pub fn flow<S: Scalar>(&self, opening: Pair<S>, port: GasState<Pair<S>>, gas: GasState<Pair<S>>) -> Flow<Pair<S>> {
        self.orifice.flow(self.conductance(opening), port, gas)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pneumatics::gas::Gas;

    fn port(conductance: f64, critical_ratio: f64) -> Port {
        Port { conductance: Tunable::still(conductance), critical_ratio: Tunable::still(critical_ratio) }
    }

    fn through(points: &[(f64, f64)]) -> MonotoneCurve {
        let points: Vec<_> = points.iter().map(|(x, f)| (Tunable::still(*x), Tunable::still(*f))).collect();
        MonotoneCurve::through(&points)
    }

    #[test]
    fn at_the_end_of_a_dead_zone_each_side_counts_by_half_and_a_zone_of_zero_only_grows() {
        let (of_zone, of_spool) = ([1.0, 0.0], [0.0, 1.0]);
        let at = |zone: f64, spool: f64| {
            let opening = Opening::linear(Tunable { value: zone, slopes: of_zone });
            opening.at(Tunable { value: spool, slopes: of_spool }).0.map(|it| (it.value, it.slopes))
        };
        assert_eq!(at(0.0, 0.0), [(0.0, [0.0, 0.5]), (0.0, [0.0, -0.5])]);
        assert_eq!(at(0.5, 0.5), [(0.0, [-1.0, 1.0]), (0.0, [0.0, 0.0])]);
        assert_eq!(at(0.5, -0.75), [(0.0, [0.0, 0.0]), (0.5, [-1.0, -2.0])]);
    }

    #[test]
    fn edge_leaks_when_closed_and_is_full_at_full_travel() {
        let edges = Edges::new([port(4e-9, 0.3); 2], Tunable::still(0.002));
        let opening = Opening::linear(Tunable::still(0.1));
        let conductance = |spool: f64| edges.conductance(opening.at(Real::of(spool)));
        assert_eq!([-1.0, 0.1].map(|spool| conductance(spool).0[0].value), [0.002 * 4e-9; 2]);
        assert!((conductance(1.0).0[0].value - 4e-9).abs() < 1e-24);
        assert_eq!(conductance(1.0), conductance(-1.0).swapped());
    }

    #[test]
    fn pieces_end_at_the_corners_of_the_opening() {
        let curve = through(&[(0.1, 0.0), (0.5, 0.3), (1.0, 1.0)]);
        let table = Opening::Table(Box::new([curve.clone(), curve]));
        for (opening, corners) in [(Opening::linear(Tunable::still(0.1)), vec![0.1, 1.0]), (table, vec![0.1, 1.0])] {
            for side in [1.0, -1.0] {
                let mut before = opening.smooth_region(0.0).value;
                for corner in &corners {
                    let [below, above] = [-1e-12, 1e-12].map(|off| opening.smooth_region(side * (corner + off)).value);
                    assert!(below == before && above != below, "at {corner}: {before}, {below}, {above}");
                    before = above;
                }
            }
        }
    }

    #[test]
    fn every_edge_has_its_own_conductance_and_ratio() {
        let ports = [port(4e-9, 0.2), port(3e-9, 0.4)];
        let gas = |pressure: f64| Gas::AIR.at(Pair([Real::of(pressure); 2]), Pair([Real::of(293.15); 2]));
        let both = Edges::new(ports, Tunable::still(0.0)).flow(Pair(Real::all(&[1.0, 0.5])), gas(6e5), gas(4e5)).mass;
        let alone = |port: Port, opening: f64| {
            let gas = |pressure: f64| Gas::AIR.at(Real::of(pressure), Real::of(293.15));
            Orifice::new(port.critical_ratio).flow(Real::of(opening) * port.conductance, gas(6e5), gas(4e5)).mass
        };
        assert_eq!(both, Pair([alone(ports[0], 1.0), alone(ports[1], 0.5)]));
    }

    /// Of a table that is the line itself; the two travels have a curve each.
    #[test]
    fn table_of_a_line_is_the_line() {
        let line = through(&[(0.08, 0.0), (0.5, 0.42 / 0.92), (1.0, 1.0)]);
        let steep = through(&[(0.0, 0.0), (0.5, 1.0)]);
        let table = Opening::Table(Box::new([line, steep]));
        for spool in [-1.0, 0.0, 0.05, 0.1, 0.7, 1.0, 1.04] {
            let (Pair([found, other]), Pair([expected, _])) =
                (table.at(Real::of(spool)), Opening::linear(Tunable::still(0.08)).at(Real::of(spool)));
            let [found, other, expected] = [found, other, expected].map(Real::value);
            assert!((found - expected).abs() < 1e-15, "{found} at {spool}, not {expected}");
            assert_eq!(other, (-2.0f64 * spool).clamp(0.0, 1.0));
        }
    }
}
