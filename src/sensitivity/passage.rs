//! What a companion does where its run does something to states and memory: events, samples, changes of the inputs.

use super::bend::ROUGH;
use super::companion::Companion;
use super::difference::{Move, Outcome, TIME_SCALE};
use super::equations::{Act, At, Equations};
use super::leaves::Leaves;
use super::slopes::{along, any};
use super::way::Way;
use super::{Crossing, NoDerivative};

/// Events that one change sets off, before a run gives up.
const MAX_SWITCHES: usize = 100;
/// Rate in 1/s of an indicator relative to its nominal value below which the motion grazes the limit.
const GRAZING: f64 = 1e-7;
/// Distance from its limit, relative to its nominal value, at which an indicator is at it.
const AT_LIMIT: f64 = 1e-10;
/// Distances from a state, relative to its scale, at which slopes by it are compared, and by how much they grow from one to the next
/// where a motion may leave that state in many ways: with a rate that grows as the root of the distance it is 32, and with one that
/// grows as its power 0.6, where the way is the only one, 16.
const NEARER: [f64; 3] = [1e-7, 1e-10, 1e-13];
const STEEPER: f64 = 24.0;
/// How far behind its limit, relative to its nominal value, an indicator is where both sides of it are.
const BEHIND: f64 = 1e-7;

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
        let is_bent = rate.is_err();
        let rate = match (rate, coincident) {
            (Ok(rate), _) if rate.abs() < GRAZING * nominal => {
                Err(format!("the motion only grazes its limit, at {rate:e} of its unit per second"))
            }
            (Ok(_), Some((other, _))) => {
                Err(format!("{} happens at the same instant", self.equations.event_name(other)))
            }
            (rate, _) => rate,
        };
        let edge = (rate.is_ok() || is_bent && coincident.is_none()).then_some((&flow, event));
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
            let delay = delay
                .or_else(|reason| edge.and_then(|edge| self.delay_at_edge(edge, direction, &movement)).ok_or(reason));
            delays.push(self.or_lose(direction, delay, name));
        }
        let rate = rate.unwrap_or_else(|_| match edge {
            Some(_) => self.sides_along(&flow, None, &base, &indicator).map_or(f64::NAN, |([before, _], _)| before),
            None => f64::NAN,
        });
        self.crossings.push(Crossing { time, event: name, rate, delays: delays.clone() });
        let ahead = if rate.is_finite() { BEHIND * nominal / rate.abs() } else { 0.0 };
        self.pass_ahead(acts, true, Some(&delays), ahead);
        if (0..self.x.len()).any(|state| flow.x[state] == 0.0 && self.is_steep(state)) {
            let reason = "behind it rates have an infinite slope by a state that was held";
            for slopes in self.slopes.iter_mut().filter(|slopes| slopes.lost.is_none()) {
                slopes.lost = Some(NoDerivative { time, event: name.to_owned(), reason: reason.to_owned() });
            }
        }
    }

    /// The delay of an event whose indicator is the least of several that come to their limits together, as those of the elements
    /// of a friction law do: the slopes of the least differ from one side to the other, the delay need not.
    ///
    /// With more of the direction another indicator may be the least than with less of it, and other ones are the least before and
    /// behind the event. A delay is right if it leaves the least at its limit to both sides.
    fn delay_at_edge(&mut self, (flow, event): (&Move, usize), direction: usize, movement: &Move) -> Option<f64> {
        let indicator = |equations: &mut dyn Equations, at: At| Outcome::of(equations.indicators(at)[event]);
        let u = self.inputs.at(self.time);
        let base = Outcome::of(self.equations.indicators(At { time: self.time, x: &self.x, u: &u })[event]);
        let ([before, behind], _) = self.sides_along(flow, None, &base, &indicator).ok()?;
        let ([below, above], share) = self.sides_along(movement, Some(direction), &base, &indicator).ok()?;
        // An event that happens later is reached with the rate before it, one that happens earlier with that behind it.
        let above = -above / if above > 0.0 { before } else { behind };
        let below = -below / if below > 0.0 { behind } else { before };
        let delay = 0.5 * (above + below);
        if !delay.is_finite() {
            return None;
        }
        let along_limit = Move {
            time: delay,
            x: along(&movement.x, &flow.x, delay),
            inputs: along(&movement.inputs, &flow.inputs, delay),
            memory: movement.memory.clone(),
        };
        let (residuals, _) = self.sides_along(&along_limit, Some(direction), &base, &indicator).ok()?;
        let most = ROUGH * delay.abs() * before.abs().min(behind.abs()) + f64::EPSILON * self.nominal(event) / share;
        residuals.iter().all(|residual| residual.abs() <= most).then_some(delay)
    }

    /// Whether rates have an infinite slope by a state at the present point: it grows and grows, the nearer one comes.
    fn is_steep(&self, state: usize) -> bool {
        let (n, u) = (self.x.len(), self.inputs.at(self.time));
        let columns = NEARER.map(|share| {
            let mut x = self.x.clone();
            x[state] += share * self.scales[state];
            self.equations.jacobian(At { time: self.time, x: &x, u: &u })[n * state..][..n].to_vec()
        });
        let grows = |row: usize| columns.windows(2).all(|two| two[1][row].abs() > STEEPER * two[0][row].abs());
        (0..n).any(grows)
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

    /// The derivatives of the numbers of the memory behind a sample that the present equations have taken, where they are a formula.
    fn sample_slopes(&mut self, direction: usize, u: &[f64]) -> Option<Result<Vec<f64>, String>> {
        let way = &mut self.ways[direction];
        if way.has_beside() && way.varied.is_none() {
            return None;
        }
        let equations = way.varied.as_mut().unwrap_or(&mut self.spare);
        equations.remember(&self.memory);
        let slopes = equations.sample_slopes([u, &way.inputs], &self.slopes[direction].memory);
        equations.adopt(self.equations.held());
        slopes
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

    /// Ends the slopes that move an input which has come from another value, or may have from anywhere, and rests where more of it
    /// does something else than less: a voltage just at an end of the range that a valve heeds.
    fn refuse_bends(&mut self, acts: &[Act], before: Option<&[f64]>) {
        let (time, u) = (self.time, self.inputs.at(self.time));
        let has_come = |input: &usize| before.is_none_or(|before| before[*input] != u[*input]);
        let rests = |input: &usize| self.inputs.slopes[*input] == 0.0;
        let is_moved = self.ways.iter().any(Way::has_beside);
        let matters = |input: &usize| is_moved || self.ways.iter().any(|way| way.inputs[*input] != 0.0);
        let inputs: Vec<usize> = (0..u.len()).filter(|it| has_come(it) && rests(it) && matters(it)).collect();
        let rates = |equations: &mut dyn Equations, at: At| {
            let mut x = at.x.to_vec();
            acts.iter().for_each(|act| equations.enact(*act, at.time, &mut x, at.u));
            Outcome::of_all(equations.rates(At { x: &x, ..at }))
        };
        if inputs.is_empty() {
            return;
        }
        self.spare.adopt(self.mirror.held());
        let base = rates(self.spare.as_mut(), At { time, x: &self.x, u: &u });
        for input in inputs {
            let mut added = vec![0.0; u.len()];
            added[input] = 1.0;
            let alone = Move { inputs: added, ..self.still() };
            if !self.bends(&alone, &base, &rates) {
                continue;
            }
            for direction in 0..self.ways.len() {
                if self.slopes[direction].lost.is_none() {
                    let movement = Move { x: self.stillness.clone(), ..self.movement(direction) };
                    let slopes = self.slope_along(&movement, Some(direction), (&base, &[]), &rates);
                    let reason = || "more of it does something else than less".to_owned();
                    self.or_lose(direction, slopes.map(|_| 0.0).map_err(|_| reason()), self.input_names[input]);
                }
            }
        }
    }

    /// Hands on the slopes of the directions for which acts on the memory alone do nothing else, and tells which these are, with the
    /// memory behind the acts; `None` if these do more.
    fn hand_on(&mut self, acts: &[Act]) -> Option<(Vec<bool>, Leaves)> {
        let mut after = Vec::with_capacity(self.memory.count());
        if self.equations.numbers(&mut after) != self.form {
            return None;
        }
        let kept = self.handed_on(acts, &after)?;
        let mut is_done = Vec::with_capacity(self.ways.len());
        for direction in 0..self.ways.len() {
            is_done.push(self.heeds_neither(direction, acts) || self.slopes[direction].lost.is_some());
            if is_done[direction] {
                let slopes = self.slopes[direction].memory.iter_mut().zip(&kept);
                slopes.filter(|(_, kept)| !**kept).for_each(|(slope, _)| *slope = 0.0);
            }
        }
        Some((is_done, self.memory.with(|leaf| after[leaf])))
    }

    /// Lets the equations with the memory before do acts that leave the states alone, too.
    fn catch_up(&mut self, acts: &[Act]) {
        let (mut states, u) = (self.x.clone(), self.inputs.at(self.time));
        acts.iter().for_each(|act| self.mirror.enact(*act, self.time, &mut states, &u));
    }

    /// Does something to states and memory, with what it sets off, at a time that moves with delays or stays.
    pub(super) fn pass(&mut self, acts: Vec<Act>, settles: bool, delays: Option<&[f64]>) {
        self.pass_ahead(acts, settles, delays, 0.0);
    }

    /// The same; where it depends on being behind the limit of an event, a time in s later.
    fn pass_ahead(&mut self, mut acts: Vec<Act>, settles: bool, delays: Option<&[f64]>, ahead: f64) {
        let (time, u) = (self.time, self.inputs.at(self.time));
        let before = if delays.is_some() { self.equations.rates(At { time, x: &self.x, u: &u }) } else { Vec::new() };
        let mut x = self.x.clone();
        acts.iter().for_each(|act| self.equations.enact(*act, time, &mut x, &u));
        let jumped_from = self.jumped_from.clone();
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
            self.equations.enact(Act::Switch(event), time, &mut x, &u);
            acts.push(Act::Switch(event));
        }
        // What is added to inputs is followed from the begin on, even where they rest.
        let is_first = acts.first() == Some(&Act::Follow) && std::mem::take(&mut self.is_new);
        if settles && delays.is_none() && (is_first || jumped_from.is_some()) {
            self.refuse_bends(&acts, if is_first { None } else { jumped_from.as_deref() });
        }
        let is_changed = !self.equations.holds(self.mirror.held());
        // A sample that changes nothing may do so just here.
        let is_sample = matches!(acts[..], [Act::Sample { .. }, ..]);
        if delays.is_none() && !is_changed && x == self.x && !is_first && !is_sample {
            return;
        }
        let does_little = delays.is_none() && x == self.x;
        let handed_on = if does_little { self.hand_on(&acts) } else { None };
        let is_handed_on = handed_on.is_some();
        let (is_done, after) = handed_on.unwrap_or_else(|| {
            let after = if is_changed { self.equations.memory() } else { self.memory.clone() };
            (vec![false; self.ways.len()], after)
        });
        if is_done.iter().all(|is_done| *is_done) {
            if is_handed_on {
                self.catch_up(&acts);
            }
            (self.memory, self.here) = (after, None);
            self.forget_rounded();
            return;
        }
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
        for direction in 0..self.ways.len() {
            if self.slopes[direction].lost.is_some() || is_done[direction] {
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
            let exact = match acts[..] {
                [Act::Sample { .. }] if delays.is_none() => self.sample_slopes(direction, &u),
                _ => None,
            };
            let mut landed =
                exact.unwrap_or_else(|| self.slope_along(&movement, Some(direction), (&base, &scales), &landing));
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
        match is_handed_on {
            true => self.catch_up(&acts),
            false => {
                self.neighbours = None;
                self.remember();
            }
        }
        self.forget_rounded();
    }
}
