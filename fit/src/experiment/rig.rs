//! The whole rig: the voltage is given, position and pressures are compared.

use std::f64::consts::PI;

use super::{Begin, Experiment, Forces, Given, MeasuredSegment};
use crate::arrays::{mean, span};
use crate::parameter::Values;
use crate::record::{Record, Signals};
use crate::smoothing::{noise, parabolas};

const COMPARED: [&str; 4] = ["position", "velocity", "chamberA.pressure", "chamberB.pressure"];
const GIVEN: [&str; 3] = ["valveVoltage", "supplyPressure", "externalForce"];
const PRESSURES: [&str; 2] = ["chamberA.pressure", "chamberB.pressure"];
const MACHINE: [&str; 6] =
    ["supplyPressure", "cylinder.bore", "cylinder.rod", "cylinder.stroke", "mass.moving", "valve.C"];
const GRAVITY: f64 = 9.80665;
/// Multiple of its noise within which the position of a resting carriage stays.
const RESTING: f64 = 8.0;
/// Samples whose mean a pressure begins with.
const FIRST: usize = 5;

/// PneumaticServoCylinder, open loop from the beginning of each segment.
pub struct Rig {
    given: Given,
    compared: Vec<&'static str>,
}

impl Rig {
    /// The experiment for signals.
    pub(super) fn new(given: Given) -> Self {
        let compared = COMPARED.into_iter().filter(|signal| given.signals.contains(*signal)).collect();
        Self { given, compared }
    }

    /// Velocity at the communication points: measured, or the slope of the position over a width in s.
    fn velocity(&self, record: &Record, width: f64) -> Vec<f64> {
        if record.signals.contains_key("velocity") {
            return record.on_grid("velocity");
        }
        parabolas(&record.on_grid("position"), record.step, width).1
    }
}

impl Experiment for Rig {
    fn given(&self) -> &Given {
        &self.given
    }

    fn compared(&self) -> &[&'static str] {
        &self.compared
    }

    fn driving(&self) -> Vec<&'static str> {
        GIVEN.into_iter().filter(|signal| self.given.signals.contains(*signal)).collect()
    }

    fn machine(&self) -> &'static [&'static str] {
        &MACHINE
    }

    fn outputs(&self) -> Vec<&'static str> {
        self.compared.clone()
    }

    /// Compares all samples.
    fn prepare(&self, record: &Record) -> (Signals, Vec<bool>, Vec<String>) {
        let driven = record.signals.keys().map(|signal| (signal.clone(), record.on_grid(signal))).collect();
        (driven, vec![true; record.time.len()], vec![])
    }

    /// Begins with the smoothed position and its slope, and with the pressures; a carriage at rest has the velocity 0.
    fn begin(&self, record: &Record, driven: &Signals) -> Begin {
        let width = self.given.options.width;
        let position = record.of("position");
        let half = ((0.5 * width / record.step).round_ties_even() as usize).max(1);
        let rests = span(&position[..(half + 1).min(position.len())]) <= RESTING * noise(position);
        let speed = if rests { 0.0 } else { self.velocity(record, width)[0] };
        let smooth = parabolas(&record.on_grid("position"), record.step, width).0;
        let mut values = Values::from([("position0".to_owned(), smooth[0]), ("velocity0".to_owned(), speed)]);
        for pressure in PRESSURES {
            if let Some(course) = driven.get(pressure) {
                values.insert(format!("{pressure}0"), mean(&course[..FIRST.min(course.len())]));
            }
        }
        let estimated = values.keys().filter(|name| *name != "velocity0" || speed != 0.0).cloned().collect();
        Begin { values, estimated }
    }

    fn inputs(&self, segment: &MeasuredSegment, values: &Values) -> Vec<(&'static str, Vec<f64>)> {
        self.driving().into_iter().map(|signal| (signal, self.given.measured(segment, signal, values))).collect()
    }

    fn settings(&self, values: &Values) -> Values {
        let mut settings = self.given.of_model(values);
        settings.insert("friction.law".to_owned(), f64::from(self.given.law));
        settings
    }

    fn predict(&self, _: &MeasuredSegment, outputs: Vec<Vec<f64>>, _: &Values) -> Vec<Vec<f64>> {
        outputs
    }

    /// Force that the acceleration leaves of the pressures, while moving.
    fn forces(&self, segment: &MeasuredSegment, values: &Values) -> Option<Forces> {
        if !PRESSURES.iter().all(|signal| segment.driven.contains_key(*signal)) {
            return None;
        }
        let (record, given) = (&segment.record, &self.given);
        let width = 2.0 * given.options.width;
        let value = |name: &str| given.value(name, values);
        let is_measured = given.signals.contains("velocity");
        let pace = given.beside(if is_measured { "gain.velocity" } else { "gain.position" }, &Values::new(), 1.0);
        let speed: Vec<f64> = self.velocity(record, width).iter().map(|speed| pace * speed).collect();
        let (_, acceleration) = parabolas(&speed, record.step, width);
        let [a, b] = PRESSURES.map(|signal| given.measured(segment, signal, values));
        let external =
            segment.driven.contains_key("externalForce").then(|| given.measured(segment, "externalForce", values));
        let [bore, rod] = ["bore", "rod"]
            .map(|name| 0.25 * PI * value(&format!("cylinder.{name}")) * value(&format!("cylinder.{name}")));
        let (mass, ambient) = (value("mass.moving"), value("ambientPressure"));
        let dead = value("wireForce") + mass * GRAVITY * libm::sin(value("incline"));
        let [kappa_a, kappa_b] = ["A", "B"].map(|chamber| value(&format!("friction.kappa{chamber}")));
        let force = |point: usize| {
            let applied = a[point] * bore - b[point] * (bore - rod) - ambient * rod - dead;
            applied + external.as_ref().map_or(0.0, |force| force[point]) - mass * acceleration[point]
        };
        let level = |point: usize| (1.0 + kappa_a * (a[point] - ambient) + kappa_b * (b[point] - ambient)).max(0.0);
        let points = || 0..speed.len();
        Some(Forces { force: points().map(force).collect(), level: points().map(level).collect(), speed })
    }
}
