//! The parameters of the proportional valve, and the conditions between them.

use super::edges::{Characteristic, Opening, Port};
use crate::numbers::MonotoneCurve;
use crate::parameters;
use crate::variables::{Condition, Fixed, ParameterError, Tunable, Variable, counted_by, units};

/// Points that a table of openings may have.
const POINTS: usize = 11;

/// Spool travels and openings of a table that is a straight line.
const TENTHS: [f64; POINTS] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

parameters! {
    /// The parameters of [`ProportionalValve`](super::ProportionalValve).
    Parameters {
        conductance: Tunable = Variable::parameter(1024, "valve.C", units::CUBIC_METRE_PER_SECOND_PASCAL, 3.93e-9).range(1e-13, 1e-5).shown_in("dm3/(s.bar)")
            .text("Sonic conductance of a fully open metering edge");
        critical_ratio: Tunable = Variable::parameter(1025, "valve.b", units::ONE, 0.3).range(0.0, 0.99)
            .text("Critical pressure ratio of the metering edges");
        dead_zone: Tunable = Variable::parameter(1026, "valve.deadZone", units::ONE, 0.08).counts_where(Condition::is(CHARACTERISTIC, &[Characteristic::Linear])).range(0.0, 0.9).plausible(0.0, 0.5)
            .text("Dead zone (overlap) of the metering edges as a fraction of the spool travel");
        leakage: Tunable = Variable::parameter(1027, "valve.leakage", units::ONE, 0.002).range(0.0, 1.0).plausible(0.0, 0.15)
            .text("Opening of a closed metering edge as a fraction of the full opening");
        bandwidth: Fixed = Variable::parameter(1028, "valve.bandwidth", units::HERTZ, 115.0).range(0.1, 1e4).plausible(2.0, 5e3)
            .text("Natural frequency of the spool");
        damping: Fixed = Variable::parameter(1029, "valve.damping", units::ONE, std::f64::consts::FRAC_1_SQRT_2).range(0.01, 100.0)
            .text("Damping ratio of the spool");
        hysteresis: Fixed = Variable::parameter(1030, "valve.hysteresis", units::ONE, 0.004).range(0.0, 1.0).plausible(0.0, 0.15)
            .text("Half width of the play between command and spool set point; it closes towards full command");
        polarity: i32 = Variable::count(1031, "valve.polarity", 1).range(-1.0, 1.0)
            .text("1: more than 5 V feeds chamber A through the proportional valve; -1: chamber B. Other actuators have no polarity");
        offset: Tunable = Variable::parameter(1100, "valve.offset", units::VOLT, 0.0).range(-5.0, 5.0)
            .text("Electrical zero offset of the proportional valve, added to its voltage: it is closed at 5 V less the offset. Other actuators have none");
        factor_supply_a: Fixed = factor(1101, "PA", "from the supply to chamber A");
        factor_supply_b: Fixed = factor(1102, "PB", "from the supply to chamber B");
        factor_exhaust_a: Fixed = factor(1103, "AR", "from chamber A to the exhaust");
        factor_exhaust_b: Fixed = factor(1104, "BR", "from chamber B to the exhaust");
        ratio_supply_a: Fixed = ratio(1105, "PA", "from the supply to chamber A");
        ratio_supply_b: Fixed = ratio(1106, "PB", "from the supply to chamber B");
        ratio_exhaust_a: Fixed = ratio(1107, "AR", "from chamber A to the exhaust");
        ratio_exhaust_b: Fixed = ratio(1108, "BR", "from chamber B to the exhaust");
        characteristic: Characteristic = Variable::choice(1109, CHARACTERISTIC, Characteristic::Linear)
            .text("How the metering edges open with the spool");
        points_a: usize = points(1110, "A");
        spool_a: [Fixed; POINTS] = spool(1111, "A");
        opening_a: [Fixed; POINTS] = opening(1122, "A");
        points_b: usize = points(1140, "B");
        spool_b: [Fixed; POINTS] = spool(1141, "B");
        opening_b: [Fixed; POINTS] = opening(1152, "B");
    }
}

const CHARACTERISTIC: &str = "valve.characteristic";

/// A variable of the table of a chamber.
fn of_table(variable: Variable) -> Variable {
    variable.counts_where(Condition::is(CHARACTERISTIC, &[Characteristic::Table]))
}

fn factor(reference: u32, edge: &str, way: &str) -> Variable {
    Variable::parameter(reference, &format!("valve.{edge}.factor"), units::ONE, 1.0)
        .range(0.0, 100.0)
        .text(&format!("Conductance of the metering edge {way} relative to valve.C"))
}

fn ratio(reference: u32, edge: &str, way: &str) -> Variable {
    Variable::parameter(reference, &format!("valve.{edge}.b"), units::ONE, -1.0)
        .range(-1.0, 0.99)
        .text(&format!("Critical pressure ratio of the metering edge {way}; below 0: valve.b"))
}

fn points(reference: u32, chamber: &str) -> Variable {
    of_table(Variable::count(reference, &format!("valve.table{chamber}.points"), POINTS as i32))
        .range(2.0, POINTS as f64)
        .text(&format!("Number of points of the table of openings for spool travel that feeds chamber {chamber}"))
}

fn spool(reference: u32, chamber: &str) -> [Variable; POINTS] {
    let points = of_table(Variable::parameter(reference, &format!("valve.table{chamber}.spool"), units::ONE, 0.0))
        .range(-1.0, 1.0)
        .text(&format!(
            "Spool travel that feeds chamber {chamber}, as a fraction of the whole, rising from point to point"
        ))
        .array(TENTHS);
    counted_by(&format!("valve.table{chamber}.points"), points)
}

fn opening(reference: u32, chamber: &str) -> [Variable; POINTS] {
    let points = of_table(Variable::parameter(reference, &format!("valve.table{chamber}.opening"), units::ONE, 0.0))
        .range(0.0, 1.0)
        .text(&format!("Opening at this spool travel of the edges that feed chamber {chamber} and vent the other: 0 closed but for leakage, 1 fully open; must not decrease from point to point"))
        .array(TENTHS);
    counted_by(&format!("valve.table{chamber}.points"), points)
}

impl Parameters {
    /// The edges that feed the chambers A and B, and those that vent them.
    pub(super) fn ports(&self) -> [[Port; 2]; 2] {
        let port = |factor: Tunable, ratio: Tunable| Port {
            conductance: self.conductance * factor,
            critical_ratio: if ratio < 0.0 { self.critical_ratio } else { ratio },
        };
        [
            [port(self.factor_supply_a, self.ratio_supply_a), port(self.factor_supply_b, self.ratio_supply_b)],
            [port(self.factor_exhaust_a, self.ratio_exhaust_a), port(self.factor_exhaust_b, self.ratio_exhaust_b)],
        ]
    }

    /// Opening of the edges by the spool.
    ///
    /// # Errors
    /// [`ParameterError`] for a table in use whose spool does not rise or whose opening falls.
    pub(super) fn opening(&self) -> Result<Opening, ParameterError> {
        if self.characteristic == Characteristic::Linear {
            return Ok(Opening::linear(self.dead_zone));
        }
        let a = curve("A", &self.spool_a[..self.points_a], &self.opening_a[..self.points_a])?;
        let b = curve("B", &self.spool_b[..self.points_b], &self.opening_b[..self.points_b])?;
        Ok(Opening::Table(Box::new([a, b])))
    }
}

/// The curve through the points of a table.
fn curve(chamber: &str, spools: &[Tunable], openings: &[Tunable]) -> Result<MonotoneCurve, ParameterError> {
    let refuse = |what: &str, place: usize, value: f64, least: String| {
        Err(ParameterError::new(&format!("valve.table{chamber}.{what}[{}]", place + 1), value, &least))
    };
    let [spool, opening] = [spools, openings].map(|points| points.iter().map(|it| it.value).collect::<Vec<_>>());
    for place in 1..spool.len() {
        if spool[place] <= spool[place - 1] {
            return refuse(
                "spool",
                place,
                spool[place],
                format!("it must exceed the one before, {}", spool[place - 1]),
            );
        }
        if opening[place] < opening[place - 1] {
            let least = format!("it must not be below the one before, {}", opening[place - 1]);
            return refuse("opening", place, opening[place], least);
        }
    }
    let points: Vec<_> = spools.iter().copied().zip(openings.iter().copied()).collect();
    Ok(MonotoneCurve::through(&points))
}
