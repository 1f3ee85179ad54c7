//! The gas half alone: motion and voltage are given, the pressures are compared.

use super::cylinder::{PRESSURES, begin_pressures, middle, on_grids, pressure_force};
use super::{Begin, Experiment, Forces, Given, MeasuredSegment, measured};
use crate::numerals::significant;
use crate::parameter::Values;
use crate::record::{Record, Signals};

/// Mass in kg of a carriage that the pressures cannot push off the measured path.
///
/// A force that accelerates it as measured carries it along; an error of the simulated pressures by 1 N moves it by 50 um in a
/// second, which no chamber notices.
const MASS: f64 = 1e4;
const GIVEN: [&str; 2] = ["valveVoltage", "supplyPressure"];

/// PneumaticServoCylinder without friction, with a carriage that goes where it was measured.
pub struct Pneumatic {
    given: Given,
}

impl Pneumatic {
    /// The experiment for signals.
    pub(super) fn new(given: Given) -> Self {
        Self { given }
    }

    fn inputs_given(&self) -> impl Iterator<Item = &'static str> {
        GIVEN.into_iter().filter(|signal| self.given.has(signal))
    }

    /// Speed or acceleration of the true motion at the communication points.
    fn slope(&self, segment: &MeasuredSegment, name: &str, values: &Values) -> Vec<f64> {
        let gain = self.given.beside("gain.position", values, 1.0);
        self.given.reading(segment, name, "position", values).iter().map(|slope| gain * slope).collect()
    }
}

impl Experiment for Pneumatic {
    fn given(&self) -> &Given {
        &self.given
    }

    fn compared(&self) -> &[&'static str] {
        &PRESSURES
    }

    fn driving(&self) -> Vec<&'static str> {
        std::iter::once("position").chain(self.inputs_given()).collect()
    }

    /// Smooths the position; its slopes move the carriage.
    fn prepare(&self, record: &Record) -> (Signals, Vec<bool>, Vec<String>) {
        let (mut driven, width, step) = (on_grids(record), self.given.options.width, record.step);
        let path = measured::smoothed(record, "position", width);
        // Velocities at the points that lead from one position to the next: those at their middle, averaged.
        let between: Vec<f64> = path.windows(2).map(|pair| (pair[1] - pair[0]) / step).collect();
        let inner = between.windows(2).map(|pair| 0.5 * (pair[1] + pair[0]));
        let speed: Vec<f64> = std::iter::once(between[0]).chain(inner).chain([between[between.len() - 1]]).collect();
        let acceleration = speed.windows(2).map(|pair| (pair[1] - pair[0]) / step).chain([0.0]).collect();
        let own = [("path", path), ("speed", speed), ("acceleration", acceleration)];
        driven.extend(own.map(|(name, course)| (name.to_owned(), course)));
        let note = format!("the position is smoothed over {} ms", significant(1e3 * width, 3));
        (driven, vec![true; record.time.len()], vec![note])
    }

    fn begin(&self, _: &Record, driven: &Signals) -> Begin {
        let mut begin = Begin::default();
        begin_pressures(&mut begin, driven);
        begin
    }

    /// Voltage and supply, of those that are not held the means over each step, and the force that carries the carriage against the
    /// measured pressures.
    fn inputs(&self, segment: &MeasuredSegment, values: &Values) -> Vec<(&'static str, Vec<f64>)> {
        let given = &self.given;
        let of_step = |signal: &'static str| {
            let course = given.measured(segment, signal, values);
            (signal, if given.options.inputs().have_lines() { middle(&course) } else { course })
        };
        let mut inputs: Vec<_> = self.inputs_given().map(of_step).collect();
        let wire = given.value("wireForce", values);
        let pushed = middle(&pressure_force(given, segment, values));
        let acceleration = self.slope(segment, "acceleration", values);
        let carrying =
            acceleration.iter().zip(pushed).map(|(acceleration, pushed)| MASS * acceleration - pushed + wire);
        inputs.push(("externalForce", carrying.collect()));
        inputs
    }

    /// Starts on the path.
    fn settings(&self, segment: &MeasuredSegment, values: &Values) -> Values {
        let given = &self.given;
        let path = given.truth("position", given.reading(segment, "path", "position", values), values);
        let speed = self.slope(segment, "speed", values)[0];
        let law = given.item("friction.law", "None");
        let mut settings = Values::from([("position0".to_owned(), path[0]), ("velocity0".to_owned(), speed)]);
        settings.extend(given.run(values, &[("friction.law", law), ("mass.moving", MASS), ("incline", 0.0)]));
        settings
    }

    /// Nothing of friction is asked here.
    fn forces(&self, _: &MeasuredSegment, _: &Values) -> Option<Forces> {
        None
    }
}
