//! A carriage with measured pressures: the mechanical half alone, without valve and gas.

use super::cylinder::{self, KAPPAS, PRESSURES, on_grids};
use super::pushed::{FACTOR, LENGTH, Pushed, directed, direction};
use super::{Begin, Experiment, Forces, Given, Inputs, MeasuredSegment, measured};
use crate::numerals::significant;
use crate::parameter::Values;
use crate::record::{Record, Signals};
use crate::smoothing::parabolas;

/// A free mass on FrictionBench, pushed by the measured pressures; its position is compared.
pub struct Mechanical {
    given: Given,
}

impl Mechanical {
    /// The experiment for signals.
    pub(super) fn new(given: Given) -> Self {
        Self { given }
    }
}

impl Experiment for Mechanical {
    fn given(&self) -> &Given {
        &self.given
    }

    fn compared(&self) -> &[&'static str] {
        &["position"]
    }

    /// Measured forces on the carriage.
    fn driving(&self) -> Vec<&'static str> {
        let external = ["externalForce"].into_iter().filter(|signal| self.given.has(signal));
        PRESSURES.into_iter().chain(external).collect()
    }

    /// It has the load factor of both chambers, no spring, and moves freely.
    fn lacks(&self, name: &str) -> bool {
        let is_known = KAPPAS.contains(&name) || name == FACTOR || self.given.model.table().find(name).is_some();
        let is_of_contact = name.starts_with("friction.");
        (is_of_contact && !is_known) || name == "motion" || name.starts_with("load.") || name.starts_with("coupling.")
    }

    fn length(&self, _: f64) -> Option<f64> {
        Some(self.given.options.length.unwrap_or(LENGTH))
    }

    /// Smooths the pressures, whose noise would break the carriage away before its time; compares all samples.
    fn prepare(&self, record: &Record) -> (Signals, Vec<bool>, Vec<String>) {
        let (mut driven, width, mut notes) = (on_grids(record), self.given.options.width, vec![]);
        driven.insert("direction".to_owned(), direction(&self.given, record));
        if self.given.options.smooths() {
            for pressure in PRESSURES {
                let smooth = parabolas(&driven[pressure], record.step, width).0;
                driven.insert(pressure.to_owned(), smooth);
            }
            notes.push(format!("the pressures are smoothed over {} ms", significant(1e3 * width, 3)));
        }
        (driven, vec![true; record.time.len()], notes)
    }

    fn begin(&self, record: &Record, _: &Signals) -> Begin {
        measured::begin(record, self.given.options.width)
    }

    /// Pressures of a gas are never held.
    fn has_lines(&self) -> bool {
        true
    }

    fn inputs(&self, segment: &MeasuredSegment, values: &Values) -> Vec<(&'static str, Vec<f64>)> {
        let applied = Inputs::Smooth.ends(self.applied(segment, values));
        vec![("appliedForce", applied), ("friction.level", self.level(segment, values))]
    }

    fn settings(&self, _: &MeasuredSegment, values: &Values) -> Values {
        let given = &self.given;
        let free = given.item("bench.drive", "Free");
        let mass = self.inertia(values);
        given.run(values, &[("bench.drive", free), ("driveVelocity", 0.0), ("mass", mass)])
    }

    fn forces(&self, segment: &MeasuredSegment, values: &Values) -> Option<Forces> {
        cylinder::forces(&self.given, segment, values, || self.level(segment, values))
    }
}

impl Pushed for Mechanical {
    fn applied(&self, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
        cylinder::applied(&self.given, segment, values)
    }

    /// It grows with the pressures, and may differ by direction.
    fn level(&self, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
        directed(self, cylinder::level(&self.given, segment, values), segment, values)
    }

    fn inertia(&self, values: &Values) -> f64 {
        self.given.value("mass.moving", values)
    }
}
