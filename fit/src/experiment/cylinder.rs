//! Forces on the carriage of a cylinder, from measured pressures.

use std::f64::consts::PI;

use super::{Begin, Forces, Given, MeasuredSegment, measured};
use crate::arrays::mean;
use crate::parameter::Values;
use crate::record::{Record, Signals};
use crate::smoothing::parabolas;

/// Standard gravity in m/s2.
pub const GRAVITY: f64 = 9.80665;
/// Signals of both chambers.
pub const PRESSURES: [&str; 2] = ["chamberA.pressure", "chamberB.pressure"];
/// Samples whose mean a pressure begins with.
const FIRST: usize = 5;

/// All signals at the communication points.
pub fn on_grids(record: &Record) -> Signals {
    record.signals.keys().map(|signal| (signal.clone(), record.on_grid(signal))).collect()
}

/// Adds the measured pressures to a start, to be estimated along.
pub fn begin_pressures(begin: &mut Begin, driven: &Signals) {
    for pressure in PRESSURES {
        if let Some(course) = driven.get(pressure) {
            let name = format!("{pressure}0");
            begin.values.insert(name.clone(), mean(&course[..FIRST.min(course.len())]));
            begin.estimated.push(name);
        }
    }
}

/// Means over the step that begins at each point, of a signal on straight lines.
pub fn middle(values: &[f64]) -> Vec<f64> {
    let last = values[values.len() - 1];
    values.windows(2).map(|pair| 0.5 * (pair[1] + pair[0])).chain([last]).collect()
}

/// Force of both chambers and of the atmosphere on the rod at the communication points.
pub fn pressure_force(given: &Given, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
    rod_force(given, &PRESSURES.map(|signal| given.measured(segment, signal, values)), values)
}

/// Force of absolute pressures in both chambers and of the atmosphere on the rod.
pub fn rod_force(given: &Given, [a, b]: &[Vec<f64>; 2], values: &Values) -> Vec<f64> {
    let [bore, rod, rod_a] = ["cylinder.bore", "cylinder.rod", "cylinder.rodA"].map(|name| given.value(name, values));
    let [bore, rod, rod_a] = [bore, rod, rod_a].map(|diameter| 0.25 * PI * (diameter * diameter));
    let ambient = given.value("ambientPressure", values);
    a.iter().zip(b).map(|(a, b)| a * (bore - rod_a) - b * (bore - rod) - ambient * (rod - rod_a)).collect()
}

/// Force on the carriage but for its friction, at the communication points.
pub fn applied(given: &Given, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
    let value = |name: &str| given.value(name, values);
    let dead = value("wireForce") + value("mass.moving") * GRAVITY * libm::sin(value("incline"));
    let mut applied = pressure_force(given, segment, values);
    applied.iter_mut().for_each(|force| *force -= dead);
    if segment.driven.contains_key("externalForce") {
        let external = given.measured(segment, "externalForce", values);
        applied.iter_mut().zip(external).for_each(|(force, external)| *force += external);
    }
    applied
}

/// Increases of the load factor by the pressures of both chambers.
pub const KAPPAS: [&str; 2] = ["friction.kappaA", "friction.kappaB"];

/// Load factor at the communication points: it grows with the pressures above ambient.
pub fn level(given: &Given, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
    let value = |name: &str| given.value(name, values);
    let ambient = value("ambientPressure");
    let [kappa_a, kappa_b] = KAPPAS.map(value);
    let [a, b] = PRESSURES.map(|signal| given.measured(segment, signal, values));
    a.iter().zip(&b).map(|(a, b)| (1.0 + kappa_a * (a - ambient) + kappa_b * (b - ambient)).max(0.0)).collect()
}

/// Force that the acceleration leaves of the applied one, while moving; nothing without position and pressures.
pub fn forces(
    given: &Given,
    segment: &MeasuredSegment,
    values: &Values,
    level: impl FnOnce() -> Vec<f64>,
) -> Option<Forces> {
    let measured = &segment.record.signals;
    if !PRESSURES.iter().chain(&["position"]).all(|signal| measured.contains_key(*signal)) {
        return None;
    }
    let (width, pace, step) = (2.0 * given.options.width, given.pace(), segment.record.step);
    let speed: Vec<f64> = measured::velocity(&segment.record, width).iter().map(|speed| pace * speed).collect();
    let (_, acceleration) = parabolas(&speed, step, width);
    let mass = given.value("mass.moving", values);
    let applied = applied(given, segment, values);
    let force =
        applied.iter().zip(&acceleration).map(|(applied, acceleration)| applied - mass * acceleration).collect();
    Some(Forces { speed, force, level: level() })
}
