//! Simulation of measured segments.

use pneumatic_servo::model::{Plant, Setup};
use pneumatic_servo::variables::Place;

use crate::experiment::{Experiment, MeasuredSegment};
use crate::expression::Tie;
use crate::law::viscous;
use crate::parameter::{Parameter, Values, values};
use crate::problem::Segment;
use crate::refused::Refused;
use crate::steady;

/// Limit of the solver steps of a run, relative to the start's; one that takes more is given up. Far from plausible values, say
/// where a bristle is all damping, a run may take a thousand times as long, and tells no more than that.
pub(crate) const WORK: f64 = 20.0;
/// Steps between two looks at the work that was done, and whether to go on.
const LOOK: usize = 16;
/// Counters of the solver that are its work.
pub(crate) const COUNTED: [&str; 2] = ["solver.steps", "solver.rejectedSteps"];
/// Magnitudes of the changes of start values, in SI units.
const MAGNITUDES: [(&str, f64); 4] =
    [("position0", 1e-4), ("velocity0", 1e-2), ("chamberA.pressure0", 1e3), ("chamberB.pressure0", 1e3)];
/// Input of a bench that multiplies all friction but the viscous one.
pub(crate) const LOAD_FACTOR: &str = "friction.level";

/// Segments of an experiment, as they are simulated.
#[derive(Clone)]
pub struct Runs<'a> {
    /// The experiment.
    pub experiment: &'a dyn Experiment,
    /// Its segments.
    pub segments: &'a [MeasuredSegment],
    /// Estimated parameters.
    pub parameters: Vec<Parameter>,
    /// Values that take the place of known ones.
    pub fixed: Values,
    /// Parameters that follow from others, each from those before it.
    pub ties: &'a [Tie],
    /// True time over the time of the records.
    pub clock: f64,
    /// Factor of all friction, where the load factor is an input of the model.
    pub scale: f64,
    /// Factor of the tolerance of the solver.
    pub exactness: f64,
    /// Solver steps after which a run is given up.
    pub most: f64,
}

/// What a vector stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Values of the parameters.
    pub values: Values,
    /// Start values of each segment.
    pub begins: Vec<Values>,
}

/// A run: its settings, and its inputs at the communication points.
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    /// Settings.
    pub settings: Values,
    /// Inputs.
    pub inputs: Vec<(&'static str, Vec<f64>)>,
}

/// Recorded variables of a run at the communication points, NaN from where it failed on.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The variables, in their order.
    pub outputs: Vec<Vec<f64>>,
    /// Solver steps, rejected ones included.
    pub steps: f64,
    /// Why it did not come to its end.
    pub failure: Option<Refused>,
}

impl<'a> Runs<'a> {
    /// Runs with the usual choices: the clock of the record, friction and tolerance as they are, and no limit of the work.
    pub fn new(experiment: &'a dyn Experiment, segments: &'a [MeasuredSegment], parameters: Vec<Parameter>) -> Self {
        let (clock, scale, exactness, most) = (1.0, 1.0, 1.0, f64::INFINITY);
        Self { experiment, segments, parameters, fixed: Values::new(), ties: &[], clock, scale, exactness, most }
    }

    /// Layout of the segments.
    pub fn layout(&self) -> Vec<Segment> {
        let of = |segment: &MeasuredSegment| Segment {
            samples: segment.fitted().count(),
            begins: segment.begin.estimated.len(),
            record: segment.number,
        };
        self.segments.iter().map(of).collect()
    }

    /// What a vector stands for. A vector of the parameters alone leaves the segments their measured start values.
    pub fn point(&self, x: &[f64]) -> Point {
        Point { values: self.values(x), begins: self.begins(x) }
    }

    /// Start values of the segments.
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

    /// Values of the estimated parameters, those that take the place of known ones, and those that follow from others.
    pub fn values(&self, x: &[f64]) -> Values {
        let mut values = values(&self.parameters, x);
        values.extend(self.fixed.iter().map(|(name, value)| (name.clone(), *value)));
        self.experiment.given().follow(self.ties, &mut values);
        values
    }

    /// Why a vector cannot be simulated; nothing if it can be.
    pub fn refusal(&self, x: &[f64], tolerance: f64) -> Option<Refused> {
        let point = self.point(x);
        (0..self.segments.len()).find_map(|place| self.run(place, &point, tolerance, &|_| true).failure)
    }

    /// Settings and inputs of the run of a segment.
    pub fn given(&self, place: usize, point: &Point) -> Given {
        let (segment, values) = (&self.segments[place], &point.values);
        let mut settings = point.begins[place].clone();
        settings.extend(self.experiment.settings(segment, values));
        let mut inputs = self.experiment.inputs(segment, values);
        if self.scale != 1.0 {
            let given = self.experiment.given();
            let scaled = |name: String| {
                let value = self.scale * given.value(&name, values);
                (name, value)
            };
            settings.extend(viscous(given.table, given.law).into_iter().map(scaled));
            let levels = inputs.iter_mut().filter(|(name, _)| *name == LOAD_FACTOR);
            levels.for_each(|(_, course)| course.iter_mut().for_each(|level| *level *= self.scale));
        }
        Given { settings, inputs }
    }

    /// Runs a segment; now and then asks, with the share that is done, whether to go on.
    pub fn run(&self, place: usize, point: &Point, tolerance: f64, goes_on: &dyn Fn(f64) -> bool) -> Run {
        self.recorded(place, &self.given(place, point), &self.experiment.outputs(), tolerance, goes_on)
    }

    /// Runs a segment, and records variables by their names.
    pub fn recorded(
        &self,
        place: usize,
        given: &Given,
        outputs: &[&str],
        tolerance: f64,
        goes_on: &dyn Fn(f64) -> bool,
    ) -> Run {
        if self.experiment.is_steady() {
            return steady::recorded(self.experiment, given, outputs, self.exactness * tolerance, self.most, goes_on);
        }
        let points = self.segments[place].record.grid.len();
        let mut run = Run { outputs: vec![vec![f64::NAN; points]; outputs.len()], steps: 0.0, failure: None };
        let mut row = |plant: &mut Plant, places: &[Place], point: usize| {
            run.outputs.iter_mut().zip(places).for_each(|(course, place)| course[point] = plant.value(*place));
        };
        let mut steps = 0.0;
        let failure = self.go(place, given, outputs, tolerance, goes_on, &mut steps, &mut row, &mut |_| Ok(())).err();
        Run { steps, failure, ..run }
    }

    /// Runs a segment; `row` reads variables at a communication point, `begun` prepares a plant that has started.
    #[expect(clippy::too_many_arguments, reason = "a run and what is recorded of it")]
    fn go(
        &self,
        place: usize,
        given: &Given,
        outputs: &[&str],
        tolerance: f64,
        goes_on: &dyn Fn(f64) -> bool,
        steps: &mut f64,
        row: &mut dyn FnMut(&mut Plant, &[Place], usize),
        begun: &mut dyn FnMut(&mut Plant) -> Result<(), Refused>,
    ) -> Result<(), Refused> {
        let Given { settings, inputs } = given;
        let record = &self.segments[place].record;
        let model = self.experiment.given().model;
        let mut setup = Setup::new(model);
        setup.change("solver.relativeTolerance", self.exactness * tolerance)?;
        for (name, value) in settings {
            setup.change(name, *value)?;
        }
        for (name, course) in inputs {
            setup.change(name, course[0])?;
        }
        let refused = |error: &dyn std::fmt::Display| Refused(error.to_string());
        let mut plant = setup.start(0.0).map_err(|error| refused(&error))?;
        begun(&mut plant)?;
        let place_of = |name: &str| model.table().find(name).expect("a variable of the model").place;
        let read: Vec<Place> = outputs.iter().map(|name| place_of(name)).collect();
        let counted = COUNTED.map(place_of);
        let places = inputs.iter().map(|(name, _)| match place_of(name) {
            Place::Input(place) => place,
            _ => unreachable!("{name} is an input"),
        });
        let driven: Vec<(usize, &Vec<f64>)> = places.zip(inputs.iter().map(|(_, course)| course)).collect();
        let (last, step, has_lines) = (record.grid.len() - 1, self.clock * record.step, self.experiment.has_lines());
        row(&mut plant, &read, 0);
        for point in 0..last {
            *steps = counted.iter().map(|place| plant.value(*place)).sum();
            if point % LOOK == 0 {
                if *steps > self.most {
                    let (time, most) = (plant.time(), self.most);
                    return Err(Refused(format!(
                        "at t = {time} s the run was given up after {steps} solver steps of {most}"
                    )));
                }
                if !goes_on(point as f64 / last as f64) {
                    return Err(Refused("interrupted".to_owned()));
                }
            }
            for (place, course) in &driven {
                if has_lines {
                    plant.slope_input(*place, (course[point + 1] - course[point]) / step);
                } else if point > 0 {
                    plant.set_input(*place, course[point]).map_err(|error| refused(&error))?;
                }
            }
            plant.advance_to(point as f64 * step + step).map_err(|error| refused(&error))?;
            for (place, course) in driven.iter().filter(|_| has_lines) {
                plant.set_input(*place, course[point + 1]).map_err(|error| refused(&error))?;
            }
            row(&mut plant, &read, point + 1);
        }
        *steps = counted.iter().map(|place| plant.value(*place)).sum();
        Ok(())
    }

    /// Readings of the sensors at all samples of a segment, signal by signal; NaN where a run failed.
    pub fn readings(
        &self,
        place: usize,
        point: &Point,
        tolerance: f64,
        goes_on: &dyn Fn(f64) -> bool,
    ) -> Vec<Vec<f64>> {
        self.read(place, self.run(place, point, tolerance, goes_on).outputs, point)
    }

    /// The same of recorded variables.
    fn read(&self, place: usize, outputs: Vec<Vec<f64>>, Point { values, .. }: &Point) -> Vec<Vec<f64>> {
        let segment = &self.segments[place];
        let predicted = self.experiment.predict(segment, outputs, values);
        let read = |(signal, truth): (&&'static str, Vec<f64>)| {
            self.experiment.given().read(&segment.record, self.clock, signal, &truth, values)
        };
        self.experiment.compared().iter().zip(predicted).map(read).collect()
    }

    /// Measured minus simulated readings at all samples of a segment, signal by signal; NaN where a run failed.
    pub fn differences(
        &self,
        place: usize,
        point: &Point,
        tolerance: f64,
        goes_on: &dyn Fn(f64) -> bool,
    ) -> Vec<Vec<f64>> {
        self.compared(place, self.readings(place, point, tolerance, goes_on))
    }

    /// The same of readings.
    fn compared(&self, place: usize, mut readings: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        for (signal, readings) in self.experiment.compared().iter().zip(&mut readings) {
            let measured = self.segments[place].record.of(signal);
            readings.iter_mut().zip(measured).for_each(|(seen, measured)| *seen = measured - *seen);
        }
        readings
    }

    /// Differences at the fitted samples, or at the validation samples: segment by segment, and within a segment signal by signal.
    pub fn stacked(&self, differences: &[Vec<Vec<f64>>], is_validation: bool) -> Vec<f64> {
        let mut found = Vec::new();
        for (segment, signals) in self.segments.iter().zip(differences) {
            let rows = |row: &usize| segment.used[*row] && segment.is_validation[*row] == is_validation;
            for signal in signals {
                found.extend((0..signal.len()).filter(rows).map(|row| signal[row]));
            }
        }
        found
    }
}

/// Derivatives of runs take the place of runs nearby.
#[cfg(feature = "sensitivities")]
mod tangents {
    use std::collections::BTreeMap;

    use pneumatic_servo::model::Plant;
    use pneumatic_servo::sensitivity::{DirectionError, NoDerivative};
    use pneumatic_servo::variables::Place;

    use super::{Given, Point, Runs};
    use crate::refused::Refused;
    use crate::simulation::Underivable;

    /// Recorded variables at the communication points, or their derivatives by a setting.
    type Courses = Vec<Vec<f64>>;

    /// Derivatives by a setting, and where they end.
    type Slope = (Courses, Option<NoDerivative>);

    impl Runs<'_> {
        /// Differences of a segment at points near another one, by the derivatives of the run there. Where that has none by what
        /// differs, a run is made.
        pub fn near(
            &self,
            place: usize,
            at: &Point,
            points: &[Point],
            tolerance: f64,
            goes_on: &dyn Fn(f64) -> bool,
            underivable: &mut Underivable,
        ) -> Vec<Vec<Vec<f64>>> {
            let first = self.given(place, at);
            let every: Vec<Given> = points.iter().map(|point| self.given(place, point)).collect();
            let is_moved = |name: &str, value: f64| first.settings.get(name).is_some_and(|own| *own != value);
            let moved = |given: &Given| -> Vec<(String, f64)> {
                let changed = given.settings.iter().filter(|(name, value)| is_moved(name, **value));
                changed.map(|(name, value)| (name.clone(), value - first.settings[name])).collect()
            };
            let moves: Vec<Vec<(String, f64)>> = every.iter().map(moved).collect();
            let mut by: Vec<String> = Vec::new();
            for (name, _) in moves.iter().flatten() {
                if !by.contains(name) {
                    by.push(name.clone());
                }
            }
            let found = self.derived(place, &first, by, tolerance, goes_on, underivable);
            let of_point = |((point, given), moves): ((&Point, &Given), &Vec<(String, f64)>)| {
                let Some((outputs, slopes)) = found.as_ref().filter(|(_, slopes)| {
                    given.inputs == first.inputs && moves.iter().all(|(name, _)| slopes.contains_key(name))
                }) else {
                    let outputs = self.recorded(place, given, &self.experiment.outputs(), tolerance, goes_on).outputs;
                    return self.compared(place, self.read(place, outputs, point));
                };
                let of_output = |(output, course): (usize, &Vec<f64>)| {
                    let change =
                        |point: usize| moves.iter().map(|(name, by)| by * slopes[name][output][point]).sum::<f64>();
                    course.iter().enumerate().map(|(point, value)| value + change(point)).collect()
                };
                self.compared(place, self.read(place, outputs.iter().enumerate().map(of_output).collect(), point))
            };
            points.iter().zip(&every).zip(&moves).map(of_point).collect()
        }

        /// Recorded variables of a run, if it comes to its end, and their derivatives by those names that have them.
        fn derived(
            &self,
            place: usize,
            given: &Given,
            mut by: Vec<String>,
            tolerance: f64,
            goes_on: &dyn Fn(f64) -> bool,
            underivable: &mut Underivable,
        ) -> Option<(Courses, BTreeMap<String, Courses>)> {
            if self.experiment.is_steady() {
                let why = "each point is a run of its own, until friction is steady";
                underivable.extend(by.into_iter().map(|name| (name, why.to_owned())));
                return None;
            }
            let outputs = self.experiment.outputs();
            let points = self.segments[place].record.grid.len();
            let empty = vec![vec![f64::NAN; points]; outputs.len()];
            loop {
                let mut courses = empty.clone();
                let mut slopes: Vec<Slope> = by.iter().map(|_| (empty.clone(), None)).collect();
                let mut row = |plant: &mut Plant, places: &[Place], point: usize| {
                    courses.iter_mut().zip(places).for_each(|(course, place)| course[point] = plant.value(*place));
                    for (direction, (own, lost)) in
                        slopes.iter_mut().enumerate().filter(|(_, (_, lost))| lost.is_none())
                    {
                        match plant.sensitivities(direction) {
                            Ok(found) => own.iter_mut().zip(places).for_each(|(course, place)| {
                                course[point] = match place {
                                    Place::Computed(place) => found[*place],
                                    // What is given does not change with a setting.
                                    _ => 0.0,
                                };
                            }),
                            Err(why) => *lost = Some(why),
                        }
                    }
                };
                let mut refused: Option<(usize, String)> = None;
                let mut begun = |plant: &mut Plant| {
                    let names: Vec<&str> = by.iter().map(String::as_str).collect();
                    plant.carry_sensitivities(&names).map_err(|error| {
                        let told = error.to_string();
                        if let DirectionError::Refused { name, .. } = &error {
                            refused = by.iter().position(|own| own == name).map(|own| (own, told.clone()));
                        }
                        Refused(told)
                    })
                };
                let ended = self.go(place, given, &outputs, tolerance, goes_on, &mut 0.0, &mut row, &mut begun);
                if let Some((own, told)) = refused {
                    underivable.insert(by.remove(own), told);
                    continue;
                }
                if ended.is_err() {
                    return None;
                }
                let mut known = BTreeMap::new();
                for (name, (slope, lost)) in by.into_iter().zip(slopes) {
                    if lost.is_none() && slope.iter().flatten().all(|value| value.is_finite()) {
                        known.insert(name, slope);
                        continue;
                    }
                    let told = lost
                        .map_or("outputs are rounded".to_owned(), |NoDerivative { time, event, reason, .. }| {
                            format!("at {time} s, {event}: {reason}")
                        });
                    underivable.insert(name, told);
                }
                return Some((courses, known));
            }
        }
    }
}
