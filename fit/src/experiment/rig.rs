//! The whole rig: the voltage is given, position and pressures are compared.

use super::cylinder::{self, begin_pressures, on_grids};
use super::{Begin, Experiment, Forces, Given, MeasuredSegment, measured};
use crate::parameter::Values;
use crate::record::{Record, Signals};

const COMPARED: [&str; 4] = ["position", "velocity", "chamberA.pressure", "chamberB.pressure"];
const GIVEN: [&str; 3] = ["valveVoltage", "supplyPressure", "externalForce"];

/// PneumaticServoCylinder, open loop from the beginning of each segment.
pub struct Rig {
    given: Given,
    compared: Vec<&'static str>,
}

impl Rig {
    /// The experiment for signals.
    pub(super) fn new(given: Given) -> Self {
        let compared = COMPARED.into_iter().filter(|signal| given.has(signal)).collect();
        Self { given, compared }
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
        GIVEN.into_iter().filter(|signal| self.given.has(signal)).collect()
    }

    /// Compares all samples.
    fn prepare(&self, record: &Record) -> (Signals, Vec<bool>, Vec<String>) {
        (on_grids(record), vec![true; record.time.len()], vec![])
    }

    /// Begins with the measured motion and the measured pressures.
    fn begin(&self, record: &Record, driven: &Signals) -> Begin {
        let mut begin = measured::begin(record, self.given.options.width);
        begin_pressures(&mut begin, driven);
        begin
    }

    fn has_lines(&self) -> bool {
        self.given.options.inputs().have_lines()
    }

    fn inputs(&self, segment: &MeasuredSegment, values: &Values) -> Vec<(&'static str, Vec<f64>)> {
        let course = |signal| self.given.options.inputs().ends(self.given.measured(segment, signal, values));
        self.driving().into_iter().map(|signal| (signal, course(signal))).collect()
    }

    fn settings(&self, _: &MeasuredSegment, values: &Values) -> Values {
        self.given.run(values, &[])
    }

    fn forces(&self, segment: &MeasuredSegment, values: &Values) -> Option<Forces> {
        cylinder::forces(&self.given, segment, values, || cylinder::level(&self.given, segment, values))
    }
}
