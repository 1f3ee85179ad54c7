//! An axis or a carriage that a measured force moves; no gas anywhere.

use nalgebra::{DMatrix, DVector};

use super::cylinder::{GRAVITY, on_grids};
use super::pushed::{LENGTH, Pushed, directed, direction};
use super::{Begin, Experiment, Forces, Given, MeasuredSegment, measured};
use crate::arrays::quantile;
use crate::matrix::pseudo_inverse;
use crate::numerals::significant;
use crate::parameter::Values;
use crate::record::{Record, Signals};
use crate::refused::Refused;
use crate::smoothing::parabolas;

const COMPARED: [&str; 2] = ["position", "velocity"];
const INCLINE: &str = "incline";
/// Fewest samples of a segment, unless another length is given: its start values are estimated as well.
const FEWEST: f64 = 30.0;
/// Fewest moving samples that tell a mass.
const MOVING: usize = 10;

/// A free mass on FrictionBench, pushed by the measured force; its position or its velocity, or both, are compared.
///
/// ```text
/// mass*dv/dt = gain.force*(force - offset.force) - mass*g*sin(incline) - spring*(position - springRest) - friction
/// level = normalForce/rated, times friction.direction.factor outwards
/// ```
///
/// The spring takes the position that was measured. Of a rotating machine mass is an inertia, force a torque, and position
/// an angle.
pub struct Force {
    given: Given,
    compared: Vec<&'static str>,
}

impl Force {
    /// The experiment for signals.
    ///
    /// # Errors
    /// [`Refused`] for an incline of a rotating machine.
    pub(super) fn new(given: Given) -> Result<Self, Refused> {
        if given.units.is_rotating
            && let Some(incline) = given.known.get(INCLINE)
        {
            let why = "a rotating machine has none; its mass is an inertia";
            return Err(Refused(format!("{INCLINE} = {incline} is refused: {why}")));
        }
        let compared = COMPARED.into_iter().filter(|signal| given.has(signal)).collect();
        Ok(Self { given, compared })
    }

    /// Smoothed velocity and acceleration at the communication points.
    fn motion(&self, record: &Record) -> (Vec<f64>, Vec<f64>) {
        let (width, pace) = (2.0 * self.given.options.width, self.given.pace());
        let speed: Vec<f64> = speed(record, width).into_iter().map(|speed| pace * speed).collect();
        let acceleration = parabolas(&speed, record.step, width).1;
        (speed, acceleration)
    }

    /// True position at the communication points.
    fn place(&self, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
        self.given.truth("position", segment.driven["position"].clone(), values)
    }
}

/// Smoothed velocity, or the slope of the position.
fn speed(record: &Record, width: f64) -> Vec<f64> {
    if record.signals.contains_key("velocity") {
        return measured::smoothed(record, "velocity", width);
    }
    measured::velocity(record, width)
}

impl Experiment for Force {
    fn given(&self) -> &Given {
        &self.given
    }

    fn compared(&self) -> &[&'static str] {
        &self.compared
    }

    /// The force, and the load.
    fn driving(&self) -> Vec<&'static str> {
        ["force", "normalForce"].into_iter().filter(|signal| self.given.has(signal)).collect()
    }

    fn of_bench(&self) -> Vec<&'static str> {
        // Rotating masses are balanced.
        let incline: &[&str] = if self.given.units.is_rotating { &[] } else { &[INCLINE] };
        let spring: &[&str] = if self.given.has("position") { &["spring", "springRest"] } else { &[] };
        [incline, spring].concat()
    }

    /// The bench's default says nothing of a machine, nor does a current of its force.
    fn unknown(&self) -> Vec<&'static str> {
        if self.given.units.of_gain("force") == "1" { vec!["mass"] } else { vec!["mass", "gain.force"] }
    }

    fn length(&self, step: f64) -> Option<f64> {
        Some(self.given.options.length.unwrap_or(LENGTH.max(FEWEST * step)))
    }

    /// Smooths the force, whose noise would break the mass away before its time; compares all samples.
    fn prepare(&self, record: &Record) -> (Signals, Vec<bool>, Vec<String>) {
        let (mut driven, width, mut notes) = (on_grids(record), self.given.options.width, vec![]);
        driven.insert("direction".to_owned(), direction(&self.given, record));
        if self.given.options.smooths() {
            let smooth = parabolas(&driven["force"], record.step, width).0;
            driven.insert("force".to_owned(), smooth);
            notes.push(format!("the force is smoothed over {} ms", significant(1e3 * width, 3)));
        }
        (driven, vec![true; record.time.len()], notes)
    }

    /// Begins with the smoothed position and its slope, or with the smoothed velocity.
    fn begin(&self, record: &Record, _: &Signals) -> Begin {
        let width = self.given.options.width;
        if record.signals.contains_key("position") {
            return measured::begin(record, width);
        }
        let speed = speed(record, width)[0];
        Begin {
            values: Values::from([("position0".to_owned(), 0.0), ("velocity0".to_owned(), speed)]),
            estimated: vec!["velocity0".to_owned()],
        }
    }

    fn has_lines(&self) -> bool {
        self.given.options.inputs().have_lines()
    }

    fn inputs(&self, segment: &MeasuredSegment, values: &Values) -> Vec<(&'static str, Vec<f64>)> {
        let applied = self.given.options.inputs().ends(self.applied(segment, values));
        vec![("appliedForce", applied), ("friction.level", self.level(segment, values))]
    }

    fn settings(&self, _: &MeasuredSegment, values: &Values) -> Values {
        let free = self.given.item("bench.drive", "Free");
        self.given.run(values, &[("bench.drive", free), ("driveVelocity", 0.0)])
    }

    fn forces(&self, segment: &MeasuredSegment, values: &Values) -> Option<Forces> {
        let (speed, acceleration) = self.motion(&segment.record);
        let mass = self.inertia(values);
        let applied = self.applied(segment, values);
        let force = applied.iter().zip(&acceleration).map(|(applied, acceleration)| applied - mass * acceleration);
        Some(Forces { speed, force: force.collect(), level: self.level(segment, values) })
    }

    /// Mass or gain, spring and offset by least squares, beside friction that is dry and viscous.
    fn guess(&self, segments: &[MeasuredSegment], values: &Values) -> Values {
        let has_spring = values.contains_key("spring");
        let width = if has_spring { 5 } else { 4 };
        let (mut table, mut right) = (Vec::new(), Vec::new());
        for segment in segments {
            let (speed, acceleration) = self.motion(&segment.record);
            let level = self.level(segment, values);
            let place = if has_spring { self.place(segment, values) } else { vec![] };
            for point in 0..speed.len() {
                let sign = if speed[point] == 0.0 { 0.0 } else { speed[point].signum() };
                let row = [acceleration[point], level[point] * sign, speed[point], 1.0];
                table.push((row, place.get(point).copied().unwrap_or(0.0)));
            }
            right.extend(&segment.driven["force"]);
        }
        let pace: Vec<f64> = table.iter().map(|(row, _)| row[2].abs()).collect();
        let least = 0.1 * if pace.is_empty() { 0.0 } else { quantile(&pace, 0.98) };
        let fast: Vec<usize> = (0..table.len()).filter(|row| pace[*row] > least).collect();
        if fast.len() < MOVING {
            return Values::new();
        }
        let of = |row: usize, column: usize| table[fast[row]].0.get(column).copied().unwrap_or(table[fast[row]].1);
        let matrix = DMatrix::from_fn(fast.len(), width, of);
        let force = DVector::from_iterator(fast.len(), fast.iter().map(|row| right[*row]));
        let found = pseudo_inverse(&matrix, f64::EPSILON * fast.len() as f64) * force;
        let (mass, offset) = (found[0], found[3]);
        let mut gain = self.given.beside("gain.force", values, 1.0);
        if values.contains_key("gain.force") && !values.contains_key("mass") && mass > 0.0 {
            gain = self.given.value("mass", values) / mass;
        }
        let mut starts = Values::new();
        if values.contains_key("offset.force") {
            starts.insert("offset.force".to_owned(), offset);
        }
        if has_spring && found[4] > 0.0 {
            starts.insert("spring".to_owned(), gain * found[4]);
        }
        if gain * mass > 0.0 {
            starts.extend([("mass".to_owned(), gain * mass), ("gain.force".to_owned(), gain)]);
        }
        starts
    }
}

impl Pushed for Force {
    /// Weight and spring included.
    fn applied(&self, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
        let given = &self.given;
        let weight = self.inertia(values) * GRAVITY * libm::sin(given.beside(INCLINE, values, 0.0));
        let mut applied = given.measured(segment, "force", values);
        applied.iter_mut().for_each(|force| *force -= weight);
        let spring = given.beside("spring", values, 0.0);
        if spring != 0.0 {
            let rest = given.beside("springRest", values, 0.0);
            let place = self.place(segment, values);
            applied.iter_mut().zip(place).for_each(|(force, place)| *force -= spring * (place - rest));
        }
        applied
    }

    fn level(&self, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
        let level = if segment.driven.contains_key("normalForce") {
            let load = self.given.measured(segment, "normalForce", values);
            load.into_iter().map(|load| (load / self.given.options.rated).max(0.0)).collect()
        } else {
            vec![1.0; segment.record.grid.len()]
        };
        directed(self, level, segment, values)
    }

    fn inertia(&self, values: &Values) -> f64 {
        self.given.value("mass", values)
    }
}
