//! A table of a seal bench: friction at points of velocity and load, without time.

use super::{Begin, Experiment, Forces, Given, MeasuredSegment, Options, seal};
use crate::parameter::Values;
use crate::record::{Record, Signals};
use crate::refused::Refused;

/// Laws whose friction at a constant velocity is no function of velocity and load, and why.
const WITHOUT_CURVE: [(&str, &str); 2] = [
    ("Bristle", "its bonds break and form at random, so that its friction at a constant velocity is a mean over time"),
    ("Polito", "it has one curve for rising and another one for falling speeds, and a point is of neither"),
];

/// FrictionBench, which slides at the velocity and the load of each point until its friction is steady.
///
/// Pressure, normal force and direction load it as in a [motion](super::motion::Motion). Points at velocity 0 are not compared:
/// friction at rest answers the drive.
pub struct Points {
    given: Given,
    compared: [&'static str; 1],
}

impl Points {
    /// The experiment for signals.
    ///
    /// # Errors
    /// [`Refused`] for a law without a steady curve, and for options that only a course over time has.
    pub(super) fn new(given: Given) -> Result<Self, Refused> {
        let law = given.law_name();
        if let Some((_, why)) = WITHOUT_CURVE.iter().find(|(name, _)| *name == law) {
            return Err(Refused(format!(
                "law = {law} is refused: {why}; record the motion over time, for the experiment motion"
            )));
        }
        let Options { play, length, inputs, smoothing, .. } = given.options;
        let is_given = [
            ("play", play.is_some()),
            ("segment", length.is_some()),
            ("inputs", inputs.is_some()),
            ("smoothing", smoothing.is_some()),
        ];
        if let Some((name, _)) = is_given.iter().find(|(_, is)| *is) {
            return Err(Refused(format!("{name} is refused: experiment points has no course over time; leave it out")));
        }
        let compared = [seal::compared(&given)];
        Ok(Self { given, compared })
    }

    /// Velocity of each point.
    fn velocity(&self, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
        self.given.measured(segment, "velocity", values)
    }

    /// Load factor of each point.
    fn level(&self, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
        let outwards = || self.velocity(segment, values).into_iter().map(|velocity| velocity > 0.0).collect();
        seal::level(&self.given, segment, values, outwards)
    }
}

impl Experiment for Points {
    fn given(&self) -> &Given {
        &self.given
    }

    fn is_steady(&self) -> bool {
        true
    }

    fn compared(&self) -> &[&'static str] {
        &self.compared
    }

    fn driving(&self) -> Vec<&'static str> {
        let has = |signal: &&str| self.given.has(signal);
        std::iter::once("velocity").chain(seal::LOADS.into_iter().filter(has)).collect()
    }

    fn of_bench(&self) -> Vec<&'static str> {
        seal::of_bench(&self.given)
    }

    fn unknown(&self) -> Vec<&'static str> {
        self.of_bench()
    }

    fn outputs(&self) -> Vec<&'static str> {
        vec!["frictionForce"]
    }

    fn length(&self, _: f64) -> Option<f64> {
        None
    }

    /// Leaves out points at rest.
    fn prepare(&self, record: &Record) -> (Signals, Vec<bool>, Vec<String>) {
        let used: Vec<bool> = record.of("velocity").iter().map(|velocity| *velocity != 0.0).collect();
        let resting = used.iter().filter(|is_used| !**is_used).count();
        let mut driven = seal::loads(record);
        driven.insert("velocity".to_owned(), record.on_grid("velocity"));
        let note = format!("{resting} of {} points are left out: at velocity 0 friction answers the drive", used.len());
        (driven, used, if resting > 0 { vec![note] } else { vec![] })
    }

    fn begin(&self, _: &Record, _: &Signals) -> Begin {
        Begin::default()
    }

    fn inputs(&self, segment: &MeasuredSegment, values: &Values) -> Vec<(&'static str, Vec<f64>)> {
        vec![("driveVelocity", self.velocity(segment, values)), ("friction.level", self.level(segment, values))]
    }

    fn settings(&self, _: &MeasuredSegment, values: &Values) -> Values {
        self.given.run(values, &[("bench.drive", self.given.item("bench.drive", "PrescribedMotion"))])
    }

    fn predict(&self, segment: &MeasuredSegment, outputs: Vec<Vec<f64>>, values: &Values) -> Vec<Vec<f64>> {
        seal::with_pressure_force(&self.given, segment, outputs, values)
    }

    /// At the points that are fitted.
    fn forces(&self, segment: &MeasuredSegment, values: &Values) -> Option<Forces> {
        let fitted = |course: Vec<f64>| segment.fitted().map(|row| course[row]).collect();
        Some(Forces {
            speed: fitted(self.velocity(segment, values)),
            force: fitted(seal::friction(&self.given, &segment.record, values)),
            level: fitted(self.level(segment, values)),
        })
    }
}
