//! What a companion does where its run does something to states and memory: events, samples, changes of the inputs.

use super::Crossing;
use super::companion::Companion;
use super::difference::{Evaluation, Move, Outcome, SHARE, TIME_SCALE};
use super::equations::{Act, At, Equations};
use super::leaves::Leaves;
use super::memory::moved_apart;
use super::slopes::{along, any};

/// Events that one change sets off, before a run gives up.
const MAX_SWITCHES: usize = 100;
/// Rate in 1/s of an indicator relative to its nominal value below which the motion grazes the limit.
const GRAZING: f64 = 1e-7;
/// Distance from its limit, relative to its nominal value, at which an indicator is at it.
const AT_LIMIT: f64 = 1e-10;
/// How far behind its limit, relative to its nominal value, an indicator is where both sides of it are.
const BEHIND: f64 = 1e-7;

/// An act that hands numbers on as they are or sets them.
struct Carried {
    /// States and memory at the points by which it is known.
    points: [(Vec<f64>, Leaves); 2],
    /// What it leads to from there.
    outcomes: [Outcome; 2],
    /// Which states and numbers of the memory stay in their places.
    kept: Vec<bool>,
}

impl Companion {
    /// An event happens: the later, the later its indicator comes to zero.
    pub(super) fn happen(&mut self, event: usize, acts: Vec<Act>) {
        let (name, time, u) = (self.equations.event_name(event), self.time, self.inputs.at(self.time));
        let at = At { time, x: &self.x, u: &u };
        let indicators = self.equations.indicators(at);
        let base = Outcome::of(indicators[event]);
        let indicator = |equations: &mut dyn Equations, at: At| Outcome::of(equations.indicators(at)[event]);
        let nominal = self.nominal(event);
        let flow = Move { time: 1.0, x: self.equations.rates(at), inputs: self.inputs.slopes.clone(), ..self.still() };
        let rate = self.slope_along(&flow, None, (&base, &[nominal]), &indicator).map(|slopes| slopes[0]);
        let is_at_limit =
            |(other, value): &(usize, &f64)| *other != event && **value <= AT_LIMIT * self.nominal(*other);
        let coincident = indicators.iter().enumerate().find(is_at_limit);
        let rate = match (rate, coincident) {
            (Ok(rate), _) if rate.abs() < GRAZING * nominal => {
                Err(format!("the motion only grazes its limit, at {rate:e} of its unit per second"))
            }
            (Ok(_), Some((other, _))) => {
                Err(format!("{} happens at the same instant", self.equations.event_name(other)))
            }
            (rate, _) => rate,
        };
        let mut delays = Vec::with_capacity(self.ways.len());
        for direction in 0..self.ways.len() {
            if self.slopes[direction].lost.is_some() {
                delays.push(f64::NAN);
                continue;
            }
            let movement = self.movement(direction);
            let delay = rate.clone().and_then(|rate| {
                let fall = self.slope_along(&movement, Some(direction), (&base, &[nominal]), &indicator)?[0];
                Ok(-fall / rate)
            });
            delays.push(self.or_lose(direction, delay, name));
        }
        let rate = rate.unwrap_or(f64::NAN);
        self.crossings.push(Crossing { time, event: name, rate, delays: delays.clone() });
        let ahead = if rate.is_finite() { BEHIND * nominal / rate.abs() } else { 0.0 };
        self.pass_ahead(acts, true, Some(&delays), ahead);
    }

    /// Takes a sample of a time in s: the later, the later it is due.
    pub(super) fn sample(&mut self, due: f64) {
        let now = self.time;
        let base = Outcome::of(self.equations.next_sample());
        let time = |equations: &mut dyn Equations, _: At| Outcome::of(equations.next_sample());
        let mut delays = Vec::with_capacity(self.ways.len());
        for direction in 0..self.ways.len() {
            let movement = Move { memory: self.slopes[direction].memory.clone(), ..self.still() };
            let is_still = !self.ways[direction].has_beside() && !any(&movement.memory);
            let delay = if is_still {
                Ok(0.0)
            } else {
                self.slope_along(&movement, Some(direction), (&base, &[TIME_SCALE]), &time).map(|slopes| slopes[0])
            };
            delays.push(self.or_lose(direction, delay, "a sample"));
        }
        let moves = delays.iter().any(|delay| *delay != 0.0);
        self.pass(vec![Act::Sample { due, now }], true, moves.then_some(&delays[..]));
    }

    /// Numbers of the memory that are rounded change in jumps: they have no slopes.
    pub(super) fn forget_rounded(&mut self) {
        self.rounded = self.equations.rounded();
        for leaf in &self.rounded {
            self.slopes.iter_mut().for_each(|slopes| slopes.memory[*leaf] = f64::NAN);
        }
    }

    /// Ends the slopes that move indicators at their limits, to which inputs have brought them from others: their events happen to
    /// one side alone.
    fn refuse_limits(&mut self, before: &[f64], limits: &[usize]) {
        let (time, u) = (self.time, self.inputs.at(self.time));
        self.spare.remember(&self.memory);
        let earlier = self.spare.indicators(At { time, x: &self.x, u: before });
        for &event in limits {
            let indicator = |equations: &mut dyn Equations, at: At| {
                let mut x = at.x.to_vec();
                equations.enact(Act::Follow, at.time, &mut x, at.u);
                Outcome::of(equations.indicators(At { x: &x, ..at })[event])
            };
            self.spare.remember(&self.memory);
            let base = indicator(self.spare.as_mut(), At { time, x: &self.x, u: &u });
            if base.numbers[0] == earlier[event] {
                continue;
            }
            let (name, nominal) = (self.equations.event_name(event), self.nominal(event));
            for direction in 0..self.ways.len() {
                if self.slopes[direction].lost.is_some() {
                    continue;
                }
                let movement = self.movement(direction);
                let moved = self.slope_along(&movement, Some(direction), (&base, &[nominal]), &indicator);
                let outcome = moved.and_then(|slopes| match slopes[0] {
                    0.0 => Ok(0.0),
                    _ => Err("an input brings it exactly to its limit: it happens to one side alone".to_owned()),
                });
                self.or_lose(direction, outcome, name);
            }
        }
    }

    /// What an act hands on as it is or sets, if it does nothing else: seen by points to both sides, at which all states and numbers
    /// of the memory are others.
    fn carried(&mut self, base: &Outcome, landing: Evaluation) -> Option<Carried> {
        let (time, u) = (self.time, self.inputs.at(self.time));
        let shifts: Vec<f64> =
            self.scales.iter().enumerate().map(|(i, scale)| scale * (1.0 + 0.1 * i as f64)).collect();
        let points = [SHARE, -SHARE].map(|share| (along(&self.x, &shifts, share), moved_apart(&self.memory, share)));
        let outcomes = points.each_ref().map(|(x, memory)| {
            self.spare.remember(memory);
            landing(self.spare.as_mut(), At { time, x, u: &u })
        });
        let [above, below] = outcomes.each_ref().map(|outcome| outcome.kept(base));
        let kept = above.filter(|above| Some(above) == below.as_ref())?;
        Some(Carried { points, outcomes, kept })
    }

    /// Hands on the slopes of a direction, if its parameter does not matter either; `false`, and nothing is changed, otherwise.
    fn carry(&mut self, direction: usize, carried: &Carried, landing: Evaluation) -> bool {
        let (way, u) = (&mut self.ways[direction], self.inputs.at(self.time));
        if any(&way.inputs) || way.one_sided.is_some() && way.has_beside() {
            return false;
        }
        if way.has_beside() {
            for ((x, memory), (outcome, share)) in
                carried.points.iter().zip(carried.outcomes.iter().zip([SHARE, -SHARE]))
            {
                let offset = share * way.magnitude;
                let Some(beside) = way.beside(offset) else { return false };
                beside.remember(memory);
                if landing(beside, At { time: self.time, x, u: &u }).numbers != outcome.numbers {
                    return false;
                }
            }
        }
        let slopes = &mut self.slopes[direction];
        let before = [&slopes.states[..], &slopes.memory].concat();
        let after: Vec<f64> =
            carried.kept.iter().enumerate().map(|(place, kept)| if *kept { before[place] } else { 0.0 }).collect();
        let (states, memory) = after.split_at(slopes.states.len());
        (slopes.states, slopes.memory) = (states.to_vec(), memory.to_vec());
        true
    }

    /// Does something to states and memory, with what it sets off, at a time that moves with delays or stays.
    pub(super) fn pass(&mut self, acts: Vec<Act>, settles: bool, delays: Option<&[f64]>) {
        self.pass_ahead(acts, settles, delays, 0.0);
    }

    /// The same; where it depends on being behind the limit of an event, a time in s later.
    fn pass_ahead(&mut self, mut acts: Vec<Act>, settles: bool, delays: Option<&[f64]>, ahead: f64) {
        let (time, u) = (self.time, self.inputs.at(self.time));
        let before = if delays.is_some() { self.equations.rates(At { time, x: &self.x, u: &u }) } else { Vec::new() };
        let (mut x, mut is_changed) = (self.x.clone(), false);
        for act in &acts {
            is_changed |= self.equations.enact(*act, time, &mut x, &u);
        }
        for _ in 0..if settles { MAX_SWITCHES } else { 0 } {
            let indicators = self.equations.indicators(At { time, x: &x, u: &u });
            if let Some(before) = self.jumped_from.take() {
                let is_at_limit = |event: &usize| indicators[*event].abs() <= AT_LIMIT * self.nominal(*event);
                let limits: Vec<usize> = (0..indicators.len()).filter(is_at_limit).collect();
                if !limits.is_empty() {
                    self.refuse_limits(&before, &limits);
                }
            }
            let Some(event) = indicators.iter().position(|value| *value < 0.0) else { break };
            is_changed |= self.equations.enact(Act::Switch(event), time, &mut x, &u);
            acts.push(Act::Switch(event));
        }
        // What is added to inputs is followed from the begin on, even where they rest.
        let is_first = acts.first() == Some(&Act::Follow) && std::mem::take(&mut self.is_new);
        if delays.is_none() && !is_changed && x == self.x && !is_first {
            return;
        }
        let after = if is_changed { self.equations.memory() } else { self.memory.clone() };
        let behind = if delays.is_some() { self.equations.rates(At { time, x: &x, u: &u }) } else { Vec::new() };
        let base = Outcome::landing(At { time, x: &self.x, u: &u }, &self.memory, &x, after.clone());
        let memory = self.memory.clone();
        let landing = |equations: &mut dyn Equations, at: At| {
            let (mut states, before) = (at.x.to_vec(), equations.memory_like(&memory));
            for act in &acts {
                equations.enact(*act, at.time, &mut states, at.u);
            }
            Outcome::landing(at, &before, &states, equations.memory_like(&after))
        };
        let (n, scales) = (x.len(), self.scales.clone());
        let is_in_place = delays.is_none() && after.is_alike(&memory);
        let carried = if is_in_place { self.carried(&base, &landing) } else { None };
        for direction in 0..self.ways.len() {
            if self.slopes[direction].lost.is_some() {
                continue;
            }
            if carried.as_ref().is_some_and(|carried| self.carry(direction, carried, &landing)) {
                continue;
            }
            let delay = delays.map_or(0.0, |delays| delays[direction]);
            let still = self.movement(direction);
            let movement = Move {
                time: delay,
                x: along(&still.x, &before, delay),
                inputs: along(&still.inputs, &self.inputs.slopes, delay),
                memory: still.memory,
            };
            let mut landed = self.slope_along(&movement, Some(direction), (&base, &scales), &landing);
            if landed.is_err() && ahead > 0.0 {
                let (time, x) = (time + ahead, along(&self.x, &before, ahead));
                let at = At { time, x: &x, u: &self.inputs.at(time) };
                self.spare.remember(&memory);
                let base = landing(self.spare.as_mut(), at);
                landed = self.slope_at(at, &movement, Some(direction), (&base, &scales), &landing);
            }
            let landed = landed.and_then(|slopes| {
                let is_finite =
                    slopes.iter().all(|slope| !slope.is_infinite()) && slopes[..n].iter().all(|slope| !slope.is_nan());
                if is_finite { Ok(slopes) } else { Err("a slope is infinite".to_owned()) }
            });
            match landed {
                Ok(landed) => {
                    let slopes = &mut self.slopes[direction];
                    (slopes.states, slopes.memory) = (along(&landed[..n], &behind, -delay), landed[n..].to_vec());
                }
                Err(reason) => {
                    let event = self.describe(&acts);
                    self.or_lose(direction, Err(reason), &event);
                }
            }
        }
        for slopes in &mut self.slopes {
            slopes.memory.resize(after.count(), 0.0);
        }
        if !after.is_alike(&self.memory) {
            (self.of_rates, self.of_outputs) = Default::default();
        }
        (self.x, self.memory, self.here) = (x, after, None);
        self.remember();
        self.forget_rounded();
    }
}
