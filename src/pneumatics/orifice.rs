//! The orifice of ISO 6358.

use std::ops::{Add, Mul};

use super::gas::GasState;
use crate::numbers::{Number, Pair, Real, Scalar, Tangent, Tangents};
use crate::variables::Tunable;

/// Pressure ratio above which the flow is taken as laminar, so that its slope stays finite at equal pressures.
pub const LAMINAR_RATIO: f64 = 0.995;

/// An orifice of given critical pressure ratio and variable sonic conductance, or two of them side by side.
///
/// ```text
/// mdot = C*p1*rho0*sqrt(T0/T1)*psi(r),   r = p2/p1, p1 the higher pressure   [kg/s]
/// psi  = 1                               r <= b              choked
///      = sqrt(1 - ((r - b)/(1 - b))^2)   b < r < 0.995       subsonic
///      = linear in r, 0 at r = 1         0.995 <= r <= 1     laminar
/// ```
///
/// # Source
/// ISO 6358-1:2013, Pneumatic fluid power - Determination of flow-rate characteristics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orifice<K = Tangent> {
    critical_ratio: K,
    /// `1/(1 - b)`.
    subsonic_scale: K,
    /// Slope of the laminar part, positive.
    laminar_slope: K,
}

/// A mass flow and the temperature it brings along.
#[derive(Clone, Copy, Debug)]
pub struct Flow<S> {
    /// Mass flow in kg/s, positive from the first to the second state.
    pub mass: S,
    /// Temperature in K of the upstream gas.
    pub temperature: S,
}

/// Flow into a volume.
#[derive(Clone, Copy, Debug)]
pub struct Inflow<N> {
    /// Net mass flow in kg/s.
    pub mass: N,
    /// Sum of the mass flows times the temperatures they bring along, in kg K/s.
    pub carried: N,
}

impl<N: Number> Inflow<N> {
    /// The same in other numbers.
    #[inline(always)]
    pub fn map<M>(self, rule: impl Fn(N) -> M) -> Inflow<M> {
        Inflow { mass: rule(self.mass), carried: rule(self.carried) }
    }
}

impl<N: Number> From<Flow<N>> for Inflow<N> {
    #[inline(always)]
    fn from(flow: Flow<N>) -> Self {
        Self { mass: flow.mass, carried: flow.mass * flow.temperature }
    }
}

impl<N: Number> Add for Inflow<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { mass: self.mass + other.mass, carried: self.carried + other.carried }
    }
}

impl<K: Scalar> Orifice<K> {
    fn of(critical_ratio: K) -> Self {
        let subsonic_scale = K::constant(1.0) / (-critical_ratio + 1.0);
        let at_laminar = (-critical_ratio + LAMINAR_RATIO) * subsonic_scale;
        let laminar_slope = (-at_laminar * at_laminar + 1.0).sqrt() / (1.0 - LAMINAR_RATIO);
        Self { critical_ratio, subsonic_scale, laminar_slope }
    }
}

impl Orifice<Tangent> {
    /// An orifice with critical pressure ratio `b` in `[0, 0.99]`.
    pub fn new(critical_ratio: impl Into<Tangent>) -> Self {
        Self::of(critical_ratio.into())
    }

    /// Derivative in kg/(s Pa) of laminar flow, which is the steepest, with respect to a pressure, through a sonic
    /// conductance in m3/(s Pa) at the reference temperature, for a gas of a [choked density](super::gas::Gas::choked_density).
    pub(crate) fn steepest(&self, conductance: f64, choked_density: f64) -> f64 {
        conductance * choked_density * self.laminar_slope.value
    }
}

impl Orifice<Tangents> {
    /// Two orifices side by side, each with its critical pressure ratio.
    pub fn pair(critical_ratios: [Tunable; 2]) -> Self {
        let both = critical_ratios.map(Orifice::of);
        Self {
            critical_ratio: both.map(|orifice| orifice.critical_ratio).into(),
            subsonic_scale: both.map(|orifice| orifice.subsonic_scale).into(),
            laminar_slope: both.map(|orifice| orifice.laminar_slope).into(),
        }
    }
}

/// The number, from 0 to 3, of the smooth region of a flow in which two pressures lie: one way or the other, laminar or not.
///
/// Equal pressures are a non-smooth point: the upstream gas changes, with another temperature. Where the flow becomes
/// choked its derivative is continuous.
#[inline(always)]
pub fn smooth_region<N: Number>(from: N, to: N) -> N {
    is_above(to, from * LAMINAR_RATIO) + is_above(to, from) + is_above(to * LAMINAR_RATIO, from)
}

/// 1 where the first number is above the second, otherwise 0.
#[inline(always)]
pub fn is_above<N: Number>(high: N, low: N) -> N {
    N::if_at_least(low, high, N::zero(), N::constant(1.0))
}

/// The numbers, from 0 to 15, of the pieces of the flows from two ports into each of two chambers.
#[inline(always)]
pub fn edge_pieces(ports: [Real; 2], chambers: Pair<Real>) -> Pair<Real> {
    let [supply, exhaust] = ports.map(|port| smooth_region(Pair([port; 2]), chambers));
    supply + exhaust * 4.0
}

impl<K: Copy> Orifice<K> {
    /// Flow between two states through a sonic conductance in m3/(s Pa).
    #[inline(always)]
    pub fn flow<N: Number + Mul<K, Output = N>>(&self, conductance: N, from: GasState<N>, to: GasState<N>) -> Flow<N> {
        let forward = |yes: N, no: N| N::if_at_least(from.pressure, to.pressure, yes, no);
        // At equal pressures, too, the difference has a derivative, since the gases differ.
        let (upstream, downstream) = (from.pressure.max(to.pressure), to.pressure.min(from.pressure));
        let sonic = conductance * forward(from.sonic_density, to.sonic_density);
        let mass = sonic * self.effective_pressure(upstream, downstream);
        Flow { mass: forward(mass, -mass), temperature: forward(from.temperature, to.temperature) }
    }

    /// `p1*psi` for pressures `p1 >= p2`.
    ///
    /// Without a branch, since the laminar line lies above the ellipse wherever the flow is not laminar; without a
    /// division, since `p1` goes under the root.
    #[inline(always)]
    fn effective_pressure<N: Number + Mul<K, Output = N>>(&self, p1: N, p2: N) -> N {
        let laminar = (p1 - p2) * self.laminar_slope;
        let beyond = (p2 - p1 * self.critical_ratio).max(N::zero()) * self.subsonic_scale;
        // Rounding may make the difference negative where the flow is laminar.
        laminar.min((p1 * p1 - beyond * beyond).max(N::zero()).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pneumatics::gas::Gas;

    fn state(pressure: f64, temperature: f64) -> GasState<Real> {
        Gas::AIR.at(Real::of(pressure), Real::of(temperature))
    }

    /// Mass flow and temperature.
    fn flow(orifice: &Orifice, conductance: f64, from: GasState<Real>, to: GasState<Real>) -> [f64; 2] {
        let Flow { mass, temperature } = orifice.flow(Real::of(conductance), from, to);
        [mass.value, temperature.value]
    }

    /// Choked flow at reference temperature is `C*p1*rho0`, independent of the downstream pressure.
    #[test]
    fn choked_flow_is_that_of_the_sonic_conductance() {
        let orifice = Orifice::new(Tangent::still(0.3));
        for behind in [0.0, 1e5, 1.8e5] {
            let [mass, temperature] = flow(&orifice, 2e-9, state(6e5, 293.15), state(behind, 350.0));
            assert!((mass - 2e-9 * 6e5 * 1.185).abs() < 1e-18);
            assert_eq!(temperature, 293.15);
        }
    }

    /// Halfway between critical ratio and 1 the ellipse gives `sqrt(3)/2`.
    #[test]
    fn subsonic_flow_follows_the_ellipse() {
        let [mass, _] = flow(&Orifice::new(Tangent::still(0.3)), 1e-9, state(1e6, 293.15), state(0.65e6, 293.15));
        assert!((mass / (1e-9 * 1e6 * 1.185) - 0.75f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn flow_is_continuous_and_odd_around_equal_pressures() {
        let orifice = Orifice::new(Tangent::still(0.4));
        let mass = |from: f64, to: f64| flow(&orifice, 1e-9, state(from, 300.0), state(to, 300.0))[0];
        let flow = |ratio: f64| mass(5e5, 5e5 * ratio);
        for kink in [0.4, 0.995, 1.0] {
            assert!((flow(kink * (1.0 - 1e-12)) - flow(kink * (1.0 + 1e-12))).abs() < 1e-9 * flow(0.4));
        }
        assert_eq!(mass(6e5, 5e5), -mass(5e5, 6e5));
    }

    #[test]
    fn pieces_end_where_the_flow_becomes_laminar_and_where_it_turns() {
        let numbers = [0.1, 0.99, 0.996, 0.999, 1.001, 1.004, 1.01, 10.0]
            .map(|ratio| smooth_region(Real::of(5e5), Real::of(5e5 * ratio)).value);
        assert_eq!(numbers, [0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0]);
    }

    #[test]
    fn pieces_of_two_flows_have_numbers_of_their_own() {
        let ratios = [0.5, 0.999, 1.001, 2.0];
        let pairs = ratios.iter().flat_map(|supply| ratios.map(|exhaust| [1e5 / supply, 1e5 / exhaust]));
        let mut numbers: Vec<f64> =
            pairs.map(|ports| edge_pieces(Real::all(&ports), Pair([Real::of(1e5); 2])).0[0].value).collect();
        numbers.sort_by(f64::total_cmp);
        assert_eq!(numbers, (0..16).map(f64::from).collect::<Vec<_>>());
    }

    /// At equal pressures the flow vanishes but not its derivative, which is the laminar line's on both sides.
    #[test]
    fn slope_is_continuous_at_equal_pressures() {
        use crate::numbers::Dual;
        let orifice = Orifice::new(Tangent::still(0.3));
        let slope = |pressure: f64| {
            let from = Gas::AIR.at(Dual::<1>::variable(pressure, 0), Dual::constant(300.0));
            let to = Gas::AIR.at(Dual::constant(5e5), Dual::constant(300.0));
            orifice.flow(Dual::constant(1e-9), from, to).mass.slope[0]
        };
        let expected = 1e-9 * 1.185 * (293.15f64 / 300.0).sqrt() * (1.0 - (0.695f64 / 0.7).powi(2)).sqrt() / 0.005;
        for pressure in [5e5 * (1.0 - 1e-9), 5e5, 5e5 * (1.0 + 1e-9)] {
            assert!((slope(pressure) / expected - 1.0).abs() < 1e-12, "{} at {pressure}", slope(pressure));
        }
    }
}
