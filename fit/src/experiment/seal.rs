//! Load and pressure force of a seal or a tribometer, whose friction force is measured.

use super::{Given, MeasuredSegment};
use crate::parameter::Values;
use crate::record::{Record, Signals};

/// Signals that load the contact.
pub const LOADS: [&str; 2] = ["pressure", "normalForce"];

/// The signal that is compared.
pub fn compared(given: &Given) -> &'static str {
    if given.has("frictionForce") { "frictionForce" } else { "force" }
}

/// Whether the measured force includes the force of the pressure.
pub fn has_pressure_force(given: &Given) -> bool {
    compared(given) == "force" && given.has("pressure")
}

/// Properties of the bench that its model does not have.
pub fn of_bench(given: &Given) -> Vec<&'static str> {
    if has_pressure_force(given) { vec!["area"] } else { vec![] }
}

/// Measured loads at the communication points.
pub fn loads(record: &Record) -> Signals {
    let has = |signal: &&str| record.signals.contains_key(*signal);
    LOADS.into_iter().filter(has).map(|name| (name.to_owned(), record.on_grid(name))).collect()
}

/// Load factor at the communication points: `normalForce / rated`, grows with the pressure by `friction.kappaA`, and is
/// `friction.direction.factor` times as large outwards, which `outwards` tells of each point.
pub fn level(
    given: &Given,
    segment: &MeasuredSegment,
    values: &Values,
    outwards: impl FnOnce() -> Vec<bool>,
) -> Vec<f64> {
    let mut level = vec![1.0; segment.record.grid.len()];
    if segment.driven.contains_key("normalForce") {
        let load = given.measured(segment, "normalForce", values);
        level.iter_mut().zip(load).for_each(|(level, load)| *level = load / given.options.rated);
    }
    if segment.driven.contains_key("pressure") {
        let kappa = given.beside("friction.kappaA", values, 0.0);
        let pressure = given.measured(segment, "pressure", values);
        level.iter_mut().zip(pressure).for_each(|(level, pressure)| *level *= 1.0 + kappa * pressure);
    }
    let factor = given.beside("friction.direction.factor", values, 1.0);
    if factor != 1.0 {
        level.iter_mut().zip(outwards()).filter(|(_, is)| *is).for_each(|(level, _)| *level *= factor);
    }
    level.into_iter().map(|level| level.max(0.0)).collect()
}

/// Friction at the communication points with the force of the pressure, where the measured force includes it.
pub fn with_pressure_force(
    given: &Given,
    segment: &MeasuredSegment,
    mut friction: Vec<Vec<f64>>,
    values: &Values,
) -> Vec<Vec<f64>> {
    if has_pressure_force(given) {
        let area = given.beside("area", values, 0.0);
        let pressure = given.measured(segment, "pressure", values);
        friction[0].iter_mut().zip(pressure).for_each(|(force, pressure)| *force += area * pressure);
    }
    friction
}

/// Measured friction at the samples of a record: without an estimated offset, and without the force of the pressure.
pub fn friction(given: &Given, record: &Record, values: &Values) -> Vec<f64> {
    let signal = compared(given);
    let offset = values.get(&format!("offset.{signal}")).copied().unwrap_or(0.0);
    let mut force: Vec<f64> = record.of(signal).iter().map(|value| value - offset).collect();
    if has_pressure_force(given) {
        let area = given.beside("area", values, 0.0);
        let pressure = given.truth("pressure", record.of("pressure").to_vec(), values);
        force.iter_mut().zip(pressure).for_each(|(force, pressure)| *force -= area * pressure);
    }
    force
}
