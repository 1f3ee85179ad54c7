//! Simulation of measured segments.

use pneumatic_servo::model::{Plant, Setup};
use pneumatic_servo::variables::Place;

use crate::experiment::{Experiment, MeasuredSegment};
use crate::parameter::{Parameter, Values, values};
use crate::problem::{Interrupted, Segment, Simulated, TOLERANCE};
use crate::refused::Refused;

/// Limit of the solver steps of a run, relative to the start's; one that takes more is given up. Far from plausible values, say
/// where a bristle is all damping, a run may take a thousand times as long, and tells no more than that.
const WORK: f64 = 20.0;
/// Steps between two looks at the work that was done.
const LOOK: usize = 256;
const COUNTED: [&str; 2] = ["solver.steps", "solver.rejectedSteps"];
/// Magnitudes of the changes of start values, in SI units.
const MAGNITUDES: [(&str, f64); 4] =
    [("position0", 1e-4), ("velocity0", 1e-2), ("chamberA.pressure0", 1e3), ("chamberB.pressure0", 1e3)];

/// Segments of an experiment, simulated one after the other.
pub struct Runs<'a> {
    /// The experiment.
    pub experiment: &'a dyn Experiment,
    /// Its segments.
    pub segments: Vec<MeasuredSegment>,
    /// Estimated parameters.
    pub parameters: Vec<Parameter>,
    /// Values that take the place of known ones.
    pub fixed: Values,
    /// True time over the time of the records.
    pub clock: f64,
    /// Solver steps after which a run is given up.
    pub most: f64,
    /// Observer of each run, with the share of it that is done.
    pub told: &'a dyn Fn(f64),
}

/// Recorded variables of a run at the communication points, and solver steps.
struct Run {
    outputs: Vec<Vec<f64>>,
    steps: f64,
}

impl Runs<'_> {
    /// Layout of the segments.
    pub fn layout(&self) -> Vec<Segment> {
        let of = |segment: &MeasuredSegment| Segment {
            samples: segment.fitted().count(),
            begins: segment.begin.estimated.len(),
            record: segment.number,
        };
        self.segments.iter().map(of).collect()
    }

    /// Start values of the segments. A vector of the parameters alone leaves them as they were measured.
    pub fn begins(&self, x: &[f64]) -> Vec<Values> {
        let mut inner = x.iter().skip(self.parameters.len());
        let is_speed_measured = self.experiment.given().signals.contains("velocity");
        let begin = |segment: &MeasuredSegment| {
            let mut values = segment.begin.values.clone();
            for name in &segment.begin.estimated {
                let magnitude =
                    MAGNITUDES.iter().find(|(known, _)| known == name).map_or(1.0, |(_, magnitude)| *magnitude);
                if let (Some(value), Some(by)) = (values.get_mut(name), inner.next()) {
                    *value += magnitude * by;
                }
            }
            // It is a slope of the measured position.
            if let Some(speed) = values.get_mut("velocity0").filter(|_| !is_speed_measured) {
                *speed /= self.clock;
            }
            values
        };
        self.segments.iter().map(begin).collect()
    }

    /// Values of the estimated parameters, and those that take the place of known ones.
    fn values(&self, x: &[f64]) -> Values {
        let mut values = values(&self.parameters, x);
        values.extend(self.fixed.iter().map(|(name, value)| (name.clone(), *value)));
        values
    }

    /// Gives up runs that take many times the steps of the start from now on.
    ///
    /// # Errors
    /// [`Refused`], if the start cannot be simulated.
    pub fn limit_work(&mut self, start: &[f64]) -> Result<(), Refused> {
        let (values, begins) = (self.values(start), self.begins(start));
        let mut steps: f64 = 1.0;
        for (segment, begin) in self.segments.iter().zip(&begins) {
            steps = steps.max(self.run(segment, &values, begin, TOLERANCE)?.steps);
        }
        self.most = WORK * steps;
        Ok(())
    }

    /// Readings of the sensors at all samples, for each segment signal by signal; nothing where a run failed.
    pub fn readings(&self, x: &[f64], tolerance: f64) -> Vec<Option<Vec<Vec<f64>>>> {
        let (values, begins) = (self.values(x), self.begins(x));
        let of_segment = |(segment, begin): (&MeasuredSegment, &Values)| {
            let run = self.run(segment, &values, begin, tolerance).ok()?;
            let predicted = self.experiment.predict(segment, run.outputs, &values);
            let read = |(signal, truth): (&&'static str, Vec<f64>)| {
                self.experiment.given().read(&segment.record, self.clock, signal, &truth, &values)
            };
            Some(self.experiment.compared().iter().zip(predicted).map(read).collect())
        };
        self.segments.iter().zip(&begins).map(of_segment).collect()
    }

    /// Runs a segment.
    fn run(&self, segment: &MeasuredSegment, values: &Values, begin: &Values, tolerance: f64) -> Result<Run, Refused> {
        let inputs = self.experiment.inputs(segment, values);
        let model = self.experiment.given().model;
        let table = model.table();
        let mut setup = Setup::new(model);
        setup.change("solver.relativeTolerance", tolerance)?;
        for (name, value) in begin.iter().chain(&self.experiment.settings(segment, values)) {
            setup.change(name, *value)?;
        }
        for (name, course) in &inputs {
            setup.change(name, course[0])?;
        }
        let mut plant = setup.start(0.0).map_err(|error| Refused(error.to_string()))?;
        (self.told)(0.0);
        let place = |name: &str| table.find(name).expect("a variable of the model").place;
        let outputs = self.experiment.outputs();
        let read: Vec<Place> = outputs.iter().map(|name| place(name)).collect();
        let counted = COUNTED.map(place);
        let steps = |plant: &Plant| counted.iter().map(|place| plant.value(*place)).sum::<f64>();
        let places = inputs.iter().map(|(name, _)| match place(name) {
            Place::Input(place) => place,
            _ => unreachable!("{name} is an input"),
        });
        let places: Vec<usize> = places.collect();
        let (points, step, has_lines) = (segment.record.grid.len(), segment.record.step, self.experiment.has_lines());
        let mut found: Vec<Vec<f64>> = outputs.iter().map(|_| Vec::with_capacity(points)).collect();
        for point in 0..points {
            if point > 0 {
                let end = self.clock * (segment.record.grid[point - 1] + step);
                plant.advance_to(end).map_err(|error| Refused(error.to_string()))?;
            }
            found.iter_mut().zip(&read).for_each(|(course, place)| course.push(plant.value(*place)));
            for ((_, course), place) in inputs.iter().zip(&places).filter(|_| point > 0) {
                plant.set_input(*place, course[point]).map_err(|error| Refused(error.to_string()))?;
            }
            if has_lines && point + 1 < points {
                for ((_, course), place) in inputs.iter().zip(&places) {
                    plant.slope_input(*place, (course[point + 1] - course[point]) / (self.clock * step));
                }
            }
            if point % LOOK == LOOK - 1 {
                if steps(&plant) > self.most {
                    return Err(Refused(format!("the solver took more than {} steps", self.most)));
                }
                (self.told)(point as f64 / points as f64);
            }
        }
        Ok(Run { outputs: found, steps: steps(&plant) })
    }
}

impl Simulated for Runs<'_> {
    fn differences(&self, vectors: &[Vec<f64>], tolerance: f64) -> Result<Vec<Vec<f64>>, Interrupted> {
        let of_vector = |x: &Vec<f64>| {
            let mut found = Vec::new();
            for (segment, readings) in self.segments.iter().zip(self.readings(x, tolerance)) {
                for (signal, name) in self.experiment.compared().iter().enumerate() {
                    let measured = segment.record.of(name);
                    let seen = |row: usize| readings.as_ref().map_or(f64::NAN, |readings| readings[signal][row]);
                    found.extend(segment.fitted().map(|row| measured[row] - seen(row)));
                }
            }
            found
        };
        Ok(vectors.iter().map(of_vector).collect())
    }
}
