//! A seal or a tribometer: the motion is prescribed, the force is measured.

use super::{Begin, Experiment, Forces, Given, MeasuredSegment, seal};
use crate::arrays::{gradient, interpolate};
use crate::numerals::significant;
use crate::parameter::Values;
use crate::record::{Record, Signals};
use crate::smoothing::{follow, noise};

/// Steps whose mean velocity a motion keeps beyond the ends of its record.
const PACED: usize = 5;

/// FrictionBench under a prescribed position; `force = pressure * area + friction` where a seal is under pressure. The load factor
/// is `normalForce / rated`, grows with the pressure by `friction.kappaA`, and is `friction.direction.factor` times as large
/// outwards as inwards.
pub struct Motion {
    given: Given,
    compared: [&'static str; 1],
}

impl Motion {
    /// The experiment for signals.
    pub(super) fn new(given: Given) -> Self {
        let compared = [seal::compared(&given)];
        Self { given, compared }
    }

    /// The signal that the motion is taken from.
    fn moving(&self) -> &'static str {
        if self.given.has("position") { "position" } else { "velocity" }
    }

    /// Load factor at the communication points.
    fn level(&self, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
        seal::level(&self.given, segment, values, || outwards(&self.path(segment, values)).collect())
    }

    /// Position at the communication points, from where the segment begins. A late reading that has not yet told the end of a
    /// record is taken to go on as fast as before.
    fn path(&self, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
        let (given, moving) = (&self.given, self.moving());
        let mut seen = given.reading(segment, "position", moving, values);
        let delay = given.beside(&format!("delay.{moving}"), values, 0.0);
        let (whole, grid) = (&segment.whole, &segment.record.grid);
        let path = &whole.driven["position"];
        let number = PACED.min(path.len() - 1);
        let pace = |from: usize| (path[from + number] - path[from]) / (number as f64 * segment.record.step);
        let (first, last) = (whole.grid[0], whole.grid[whole.grid.len() - 1]);
        for (value, time) in seen.iter_mut().zip(grid) {
            let late = whole.begin + time + delay;
            *value += (late - first).min(0.0) * pace(0);
            *value += (late - last).max(0.0) * pace(path.len() - 1 - number);
        }
        let gain = given.beside(&format!("gain.{moving}"), values, 1.0);
        let offset = if moving == "velocity" { given.beside("offset.velocity", values, 0.0) } else { 0.0 };
        let begin = seen[0];
        seen.iter().zip(grid).map(|(value, time)| gain * (value - begin - offset * time)).collect()
    }
}

impl Experiment for Motion {
    fn given(&self) -> &Given {
        &self.given
    }

    fn compared(&self) -> &[&'static str] {
        &self.compared
    }

    fn driving(&self) -> Vec<&'static str> {
        let has = |signal: &&str| self.given.has(signal);
        std::iter::once(self.moving()).chain(seal::LOADS.into_iter().filter(has)).collect()
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

    /// Hides the jitter of the position, and leaves out samples at rest: friction at rest answers the drive.
    fn prepare(&self, record: &Record) -> (Signals, Vec<bool>, Vec<String>) {
        let mut notes = Vec::new();
        let position = match record.signals.get("position") {
            Some(measured) => {
                let play = self.given.options.play.unwrap_or_else(|| 3.0 * noise(measured));
                notes.push(format!("the position is followed with a play of {} um", significant(1e6 * play, 3)));
                let from: Vec<f64> = record.on_grid("position").iter().map(|value| value - measured[0]).collect();
                follow(&from, play)
            }
            None => integral(&record.on_grid("velocity"), record.step),
        };
        let at = |time: &f64| ((time / record.step - 1e-6).ceil().max(0.0) as usize).min(position.len() - 1);
        let moves = |time: &f64| at(time) > 0 && position[at(time)] != position[at(time) - 1];
        let used = record.time.iter().map(moves).collect();
        let mut driven = seal::loads(record);
        driven.insert("position".to_owned(), position);
        (driven, used, notes)
    }

    fn begin(&self, _: &Record, _: &Signals) -> Begin {
        Begin::default()
    }

    /// The position at the end of each step, and the load factor.
    fn inputs(&self, segment: &MeasuredSegment, values: &Values) -> Vec<(&'static str, Vec<f64>)> {
        let mut position = self.path(segment, values);
        position.rotate_left(1);
        let last = position.len() - 1;
        position[last] = position[last - 1];
        vec![("prescribedPosition", position), ("friction.level", self.level(segment, values))]
    }

    /// Starts at rest at the first sample.
    fn settings(&self, _: &MeasuredSegment, values: &Values) -> Values {
        let prescribed = self.given.item("bench.drive", "PrescribedPosition");
        self.given.run(values, &[("bench.drive", prescribed), ("driveVelocity", 0.0), ("position0", 0.0)])
    }

    /// Adds the force of the pressure.
    fn predict(&self, segment: &MeasuredSegment, outputs: Vec<Vec<f64>>, values: &Values) -> Vec<Vec<f64>> {
        seal::with_pressure_force(&self.given, segment, outputs, values)
    }

    /// At the samples that are fitted.
    fn forces(&self, segment: &MeasuredSegment, values: &Values) -> Option<Forces> {
        let record = &segment.record;
        let at_samples = |course: &[f64]| interpolate(record.time.iter().copied(), &record.grid, course);
        let speed = at_samples(&gradient(&self.path(segment, values), record.step));
        let level = at_samples(&self.level(segment, values));
        let force = seal::friction(&self.given, record, values);
        let fitted = |course: Vec<f64>| segment.fitted().map(|row| course[row]).collect();
        Some(Forces { speed: fitted(speed), force: fitted(force), level: fitted(level) })
    }
}

/// Whether each step of a path leads outwards, or the last motion before it did.
fn outwards(path: &[f64]) -> impl Iterator<Item = bool> {
    let mut is_outwards = false;
    let last = path.len() - 1;
    (0..path.len()).map(move |place| {
        let step = path[(place + 1).min(last)] - path[place];
        is_outwards = step > 0.0 || (step == 0.0 && is_outwards);
        is_outwards
    })
}

/// Integral of a velocity on straight lines.
fn integral(speed: &[f64], step: f64) -> Vec<f64> {
    let mut place = 0.0;
    let each = |pair: &[f64]| {
        place += 0.5 * step * (pair[0] + pair[1]);
        place
    };
    std::iter::once(0.0).chain(speed.windows(2).map(each)).collect()
}
