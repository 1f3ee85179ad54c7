//! Runs of equations in numbers with slopes.

use std::any::Any;
use std::sync::Arc;

use crate::numbers::{DIRECTIONS, Real, STILL, Scalar, Slopes, Tangent};
use crate::sensitivity::{Along, Crossing, NoDerivative, Seed, Seeded, Varied, seeds};
use crate::session::{Seeds, Snapshot, SnapshotError, Start, build};
use crate::solver::{self, Progress, Run, Settings, StepError};
use crate::system::{
    IndicatorSet, LabelledNumber, Stilling, System, kept, labelled, plain, shared_table, slopes_of, still, varied,
};
use crate::variables::Table;

/// A model's equations in motion, in numbers with slopes.
pub struct VariedRun<E: System<U>, const N: usize, const U: usize> {
    run: Box<Run<E, N, U, Tangent>>,
    table: Arc<Table>,
    /// Places of the continuous states, numbered as in a [`Direction`](crate::session::Direction), among those that are integrated.
    places: Vec<Option<usize>>,
    /// Slopes of the inputs.
    seeds: [Slopes; U],
    /// Clock of the host in s at the start.
    start: f64,
    lost: [Option<NoDerivative>; DIRECTIONS],
    room: Stilling,
}

const DIFFERENT_MODES: &str = "the modes differ from one side of it to the other";

/// Share of a slope by which that on the other side of a bend differs.
const BENT: f64 = 1e-6;

/// Share of its magnitude by which a direction is followed to see whether the run begins in another mode there.
const BESIDE: f64 = 1e-7;

impl<E: System<U>, const N: usize, const U: usize> VariedRun<E, N, U> {
    /// A run from its start, with derivatives in the directions of the seeds.
    #[inline(never)]
    pub fn new(equations: E, settings: Settings, start: &Start) -> Self {
        let Seeds { inputs: seeds, .. } = start.seeds;
        let seeds = std::array::from_fn(|i| seeds.get(i).copied().unwrap_or_default());
        let u = std::array::from_fn(|i| Tangent { value: start.inputs[i], slopes: seeds[i] });
        let begin: Box<([Tangent; N], E::Memory<Tangent>)> = Box::new(equations.start(&u));
        let mut run = Run::boxed(equations, settings, begin, u);
        run.set_clock(start.time);
        let (table, lost) = (shared_table::<E, U>(), [const { None }; DIRECTIONS]);
        let places = table.states().map(|reference| run.system().state_at(reference, N)).collect();
        Self { run, table, places, seeds, start: start.time, lost, room: Stilling::default() }
    }

    /// The equations, whose parameters have slopes.
    pub(super) fn system(&self) -> &E {
        self.run.system()
    }

    /// Makes a step, and finds out why slopes are lost in it.
    fn go(&mut self, end: f64) -> Result<(), StepError> {
        let begin = self.run.time();
        let outcome = self.run.advance(end);
        for direction in 0..DIRECTIONS {
            if self.lost[direction].is_some() {
                continue;
            }
            let is_lost = || self.run.state().0.iter().any(|state| state.slopes[direction].is_nan());
            if self.run.is_silent() {
                let is_lost = self.run.lost(direction).is_some() || is_lost();
                self.lost[direction] = is_lost.then(|| self.nothing_told());
                continue;
            }
            self.lost[direction] = match self.run.lost(direction) {
                Some(lost) => Some(NoDerivative {
                    time: self.start + lost.time,
                    event: self.run.system().event_name(lost.event).to_owned(),
                    reason: lost.reason.clone(),
                }),
                None if is_lost() => Some(self.tied(begin).unwrap_or_else(|| self.depends_on_nothing("the equations"))),
                None => self.at_a_limit(direction, true),
            };
        }
        outcome.map_err(|error| error.later(self.start))
    }

    /// The reason why states that follow an input have no derivative at the start of a step: left and right derivatives differ.
    fn tied(&self, begin: f64) -> Option<NoDerivative> {
        /// A slope that nothing else has.
        const OWN: f64 = 0.723_161;
        let (system, u) = (self.run.system(), self.run.inputs().0);
        let (x, memory) = self.run.state();
        let (x, memory) = (x.map(|state| Tangent::still(state.value)), still(memory));
        // From where it rests, and back from both sides.
        let follows = |input: usize, way: f64| {
            let with = |value: f64, slope: f64| {
                std::array::from_fn(|i| {
                    if i == input { Tangent::varying(value, slope) } else { Tangent::still(u[i].value) }
                })
            };
            let (time, here) = (Tangent::still(self.run.time()), u[input].value);
            let mut memory = memory.clone();
            system.follow(time, &x, &with(here + way * (1.0 + here.abs()), 0.0), &mut memory);
            let mut memory = still(&memory);
            system.follow(time, &x, &with(here, OWN), &mut memory);
            kept(&memory).iter().any(|now| now.slopes[0].is_nan())
        };
        let input = (0..U).find(|input| [0.0, -0.5, 0.5].into_iter().any(|way| follows(*input, way)))?;
        let event = self.table.inputs().nth(input)?.name.clone();
        Some(NoDerivative {
            time: self.start + begin,
            event,
            reason: "its slope upwards differs from its slope downwards".to_owned(),
        })
    }

    /// A loss of which nothing is told, so that nothing is allocated.
    fn nothing_told(&self) -> NoDerivative {
        NoDerivative { time: self.start + self.run.time(), event: String::new(), reason: String::new() }
    }

    fn depends_on_nothing(&self, event: &str) -> NoDerivative {
        NoDerivative {
            time: self.start + self.run.time(),
            event: event.to_owned(),
            reason: "they depend on a number of the memory that has no slope".to_owned(),
        }
    }

    /// Drops slopes that are others on the other side of a sample which is just now, at an instant that varies.
    fn drop_bent(&self, computed: &mut [Tangent]) {
        let Some((x, memory)) = self.run.beside_sample() else { return };
        let mut beside = vec![Tangent::still(0.0); computed.len()];
        let (system, time, u) = (self.run.system(), Tangent::still(self.run.time()), self.run.inputs().0);
        system.outputs(time, &x, &u, &memory, &mut beside);
        for (here, there) in computed.iter_mut().zip(beside) {
            for (slope, other) in here.slopes.iter_mut().zip(there.slopes) {
                if (*slope - other).abs() > BENT * slope.abs().max(other.abs()) {
                    *slope = f64::NAN;
                }
            }
        }
    }

    /// Why there is no derivative along a direction: the motion is exactly at the limit of a mode, to one side of which the mode ends,
    /// or rests on a kink.
    fn at_a_limit(&self, direction: usize, at_kinks: bool) -> Option<NoDerivative> {
        let reason = if at_kinks { "the motion rests at its limit" } else { DIFFERENT_MODES };
        let is_asked_for = |event: &usize| self.run.system().is_kink(*event) == at_kinks;
        let mut events = (0..E::Indicators::<Tangent>::unused().as_ref().len()).filter(is_asked_for).peekable();
        events.peek()?;
        let indicators = self.run.indicators();
        let is_at_it = |event: &usize| {
            let it = &indicators.as_ref()[*event];
            it.value == 0.0 && it.slopes[direction] != 0.0
        };
        let event = events.find(is_at_it)?;
        Some(NoDerivative {
            time: self.start + self.run.time(),
            event: self.run.system().event_name(event).to_owned(),
            reason: reason.to_owned(),
        })
    }
}

/// Whether a run begins in another mode a little to one side of the present parameters and inputs in a direction.
fn begins_otherwise<E: System<U>, const N: usize, const U: usize>(
    table: &Table,
    start: &Start,
    direction: usize,
) -> bool {
    let is_moved = |seeds: &[Slopes], place: usize| seeds.get(place).is_some_and(|seed| seed[direction] != 0.0);
    let of_inputs = start.seeds.inputs;
    // None where no run begins, or one of more states: that of an option which is absent at 0.
    let begun = |share: f64| {
        let magnitude = |value: f64, typical: f64| if value == 0.0 { typical } else { value.abs() };
        let moved = |(place, value): (usize, &f64)| match is_moved(start.seeds.parameters, place) {
            true => {
                let typical = table.parameters().nth(place).map_or(1.0, |it| it.nominal.or(it.start).unwrap_or(1.0));
                value + share * magnitude(*value, if typical == 0.0 { 1.0 } else { typical })
            }
            false => *value,
        };
        let parameters: Vec<f64> = start.parameters.iter().enumerate().map(moved).collect();
        let is_legal = table.parameters().zip(&parameters).all(|(variable, value)| variable.check(*value).is_ok());
        let start = Start { parameters: &parameters, seeds: Seeds::NONE, ..*start };
        let (equations, _) = build::<E, U>(&start).ok().filter(|(it, _)| is_legal && it.states() <= N)?;
        let u = std::array::from_fn(|i| {
            let value = start.inputs[i];
            Real::of(if is_moved(of_inputs, i) { value + share * magnitude(value, 1.0) } else { value })
        });
        let memory = equations.start::<Real, N>(&u).1;
        Some((equations, memory))
    };
    if start.seeds.parameters.iter().chain(of_inputs).all(|seed| seed[direction] == 0.0) {
        return false;
    }
    let Some((equations, here)) = begun(0.0) else { return false };
    [BESIDE, -BESIDE].into_iter().filter_map(begun).any(|(_, beside)| !equations.are_alike(&here, &beside))
}

impl<E: System<U>, const N: usize, const U: usize> Varied for VariedRun<E, N, U> {
    fn check_start(&mut self, start: &Start) {
        for (direction, lost) in self.lost.iter_mut().enumerate() {
            *lost = begins_otherwise::<E, N, U>(&self.table, start, direction).then(|| NoDerivative {
                time: start.time,
                event: "the start".to_owned(),
                reason: DIFFERENT_MODES.to_owned(),
            });
        }
    }

    fn place(&mut self, snapshot: &Snapshot, seeds: &[Seed]) -> Result<(), SnapshotError> {
        let here = self.run.state().0.map(Tangent::value);
        let (states, (memory, progress, start)) =
            snapshot.read::<E, (Box<E::Memory<Real>>, Progress, f64), N, U>(self.run.system(), &here)?;
        let seeded = Seeded::new(seeds);
        let mut x = states.map(Tangent::still);
        let mut moved = [false; DIRECTIONS];
        for (number, place) in self.places.iter().enumerate() {
            if let Some(place) = place {
                x[*place].slopes = seeded.state(number);
                moved.iter_mut().zip(x[*place].slopes).for_each(|(moved, slope)| *moved |= slope != 0.0);
            }
        }
        let mut memory = varied(&*memory, |place| seeded.memory(place));
        self.run.restore(x, &mut memory, progress);
        self.seeds = std::array::from_fn(|i| seeded.input(i));
        self.run.set_clock(start);
        (self.start, self.lost) = (start, [const { None }; DIRECTIONS]);
        for (direction, _) in moved.iter().enumerate().filter(|(_, moved)| **moved && !self.run.is_silent()) {
            self.lost[direction] = self.at_a_limit(direction, false);
        }
        Ok(())
    }

    fn be_silent(&mut self) {
        self.run.be_silent();
    }

    fn save(&self) -> Snapshot {
        let (x, memory) = self.run.state();
        let (x, unused) = (x.map(Tangent::value), self.run.system().unused(N));
        let states = [&x[..unused.start], &x[unused.end..]].concat();
        let rest = postcard::to_allocvec(&(self.run.progress(), self.start)).expect("plain data");
        Snapshot { time: self.start + self.run.time(), states, memory: [plain(memory), rest].concat() }
    }

    fn reseed(&mut self, states: &[f64], along: &[Along], moved: Option<&dyn Varied>) {
        let (x, memory) = self.run.state();
        let mut x = x.map(|state| Tangent::still(state.value));
        for ((number, place), value) in self.places.iter().enumerate().zip(states) {
            if let Some(place) = *place {
                x[place] = Tangent { value: *value, slopes: seeds(along, Along::State(number)) };
            }
        }
        let moved: Option<&dyn Any> = moved.map(|run| run as _);
        let mut memory = match moved.and_then(|run| run.downcast_ref::<Self>()) {
            Some(moved) => moved.run.state().1.clone(),
            None => self.room.still(memory),
        };
        let progress = self.run.progress();
        self.run.restore(x, &mut memory, progress);
        self.seeds = std::array::from_fn(|i| seeds(along, Along::Input(i)));
        self.lost = [const { None }; DIRECTIONS];
    }

    fn set_inputs(&mut self, values: &[f64], slopes: &[f64]) {
        let u = std::array::from_fn(|i| Tangent { value: values[i], slopes: self.seeds[i] });
        self.run.set_inputs(u, std::array::from_fn(|i| slopes[i]));
    }

    fn advance(&mut self, end: f64) -> Result<(), StepError> {
        self.go(end - self.start)
    }

    fn step(&mut self, size: f64) -> Result<(), StepError> {
        self.go(self.run.time() + size)
    }

    fn outputs(&self, computed: &mut [Tangent]) -> [Option<NoDerivative>; DIRECTIONS] {
        let mut why = self.lost.clone();
        let (system, time, u) = (self.run.system(), Tangent::still(self.run.time()), self.run.inputs().0);
        self.run.consistent(|x, memory| {
            system.outputs(time, x, &u, memory, computed);
            if self.run.is_silent() {
                return;
            }
            for (direction, why) in why.iter_mut().enumerate().filter(|(_, why)| why.is_none()) {
                let is_lost = || {
                    let rounded = system.rounded();
                    kept(memory).iter().any(|it| it.slopes[direction].is_nan() && !rounded.contains(&it.name))
                };
                if computed.iter().any(|it| it.slopes[direction].is_nan()) && is_lost() {
                    *why = Some(self.depends_on_nothing("the computed variables"));
                }
            }
        });
        if !self.run.is_silent() {
            self.drop_bent(computed);
        }
        why
    }

    fn state(&self, state: usize) -> Slopes {
        self.places.get(state).copied().flatten().map_or(STILL, |place| self.run.state().0[place].slopes)
    }

    fn states(&self, states: &mut [Tangent]) {
        for (place, slot) in self.places.iter().zip(states) {
            if let Some(place) = place {
                *slot = self.run.state().0[*place];
            }
        }
    }

    fn memory(&self) -> Vec<LabelledNumber> {
        labelled(self.run.state().1, |fields| self.run.system().state_label(fields))
    }

    fn memory_slopes(&self) -> Vec<Slopes> {
        slopes_of(self.run.state().1)
    }

    fn crossings(&self) -> Vec<Crossing> {
        let system = self.run.system();
        let told = |it: &solver::Crossing| Crossing {
            time: it.time,
            event: system.event_name(it.event),
            rate: it.rate,
            delays: it.delays.to_vec(),
        };
        self.run.crossings().iter().map(told).collect()
    }

    fn lost(&self, direction: usize) -> Option<&NoDerivative> {
        self.lost[direction].as_ref()
    }
}
