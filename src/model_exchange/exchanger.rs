//! Lets a host integrate any model's equations.

use super::{Exchange, ExchangeError, Update};
use crate::numbers::{Real, Scalar};
use crate::session::{Direction, Session, Snapshot, SnapshotError};
use crate::solver::Counters;
use crate::system::{Indicator, Limits, MAX_KINKS, System, UNUSED, state_name};
use crate::variables::{Notices, ParameterError};

/// By how much, relative to its nominal value, an indicator is off zero at the exact instant of its event.
///
/// An event is seen a little late: when sliding has turned back with 1e-7 of the nominal velocity, when the applied
/// force exceeds the break-away force by 1e-7 of the nominal force.
pub const HYSTERESIS: f64 = 1e-7;

/// The value that a host sees of an indicator, which the equations have in its own unit and exactly 0 at an event.
pub fn seen(indicator: &Indicator, value: f64) -> f64 {
    if value == UNUSED { 1.0 } else { value / indicator.nominal + HYSTERESIS }
}

/// Time in s within which states beyond their [`Limits`] return.
const RETURN: f64 = 1e-2;

/// Switches or samples at one instant before the model gives up.
const MAX_SWITCHES: usize = 100;

/// A model's equations at states that a host integrates.
pub struct Exchanger<E: System<U>, const N: usize, const U: usize> {
    equations: E,
    session: Session,
    indicators: Vec<Indicator>,
    states: Vec<State>,
    /// Time in s of the equations.
    elapsed: f64,
    x: [f64; N],
    limits: [Limits; N],
    /// The states whose equations are taken: those nearest to `x` within the limits, or hardly beyond.
    near: [f64; N],
    /// Whether `x` is within the limits, and `near` is the same.
    is_within: bool,
    /// Apart, since it has kilobytes, which would be copied over the stack of the host on their way here.
    memory: Box<E::Memory<Real>>,
    /// Whether the equations are taken on the far side of each kink, where its quantity is negative.
    sides: Vec<bool>,
    inputs: [f64; U],
    counters: Counters,
}

/// A copy of a memory.
#[inline(never)]
fn copied<M: Clone>(memory: &M) -> Box<M> {
    Box::new(memory.clone())
}

/// A state of the table.
struct State {
    /// Its index among those that are integrated, or its value if it is not.
    place: Result<usize, f64>,
    nominal: f64,
    /// The place of its variable among the computed ones.
    value: usize,
    /// The place of its rate among the computed ones.
    rate: usize,
    /// The index of the state that is its rate, if there is one, as for a position.
    derivative: Option<usize>,
}

impl<E: System<U>, const N: usize, const U: usize> Exchanger<E, N, U> {
    /// Equations at a time since their start, with the indicators of their model.
    pub(crate) fn new(
        of: (E, Session),
        at: (f64, [f64; N], &E::Memory<Real>, [f64; U]),
        indicators: Vec<Indicator>,
    ) -> Box<Self> {
        let mut exchanger = Self::without_states(of, at, indicators);
        exchanger.look_around();
        exchanger.change_sides();
        let mut computed = vec![0.0; exchanger.session.table.computed().count()];
        exchanger.values(&mut computed);
        exchanger.states = exchanger.table_states(&computed);
        exchanger
    }

    /// The same before the table's states are known. It takes much of the stack: a frame of its own.
    #[inline(never)]
    fn without_states(
        (equations, session): (E, Session),
        (time, x, memory, inputs): (f64, [f64; N], &E::Memory<Real>, [f64; U]),
        indicators: Vec<Indicator>,
    ) -> Box<Self> {
        let (limits, memory) = (equations.limits(), copied(memory));
        Box::new(Self {
            equations,
            session,
            indicators,
            states: Vec::new(),
            elapsed: time,
            x,
            limits,
            near: x,
            is_within: true,
            memory,
            sides: vec![false; E::kink_list().len()],
            inputs,
            counters: Counters::default(),
        })
    }

    /// The states as the table lists them, with the start values of those that are not integrated.
    fn table_states(&self, computed: &[f64]) -> Vec<State> {
        let (table, scales): (_, [f64; N]) = (&self.session.table, self.equations.scales());
        let references = table.states();
        let states = references.filter_map(|reference| {
            let value = table.computed().position(|variable| variable.reference == reference)?;
            let rate = table.computed().position(|variable| variable.derivative_of == Some(reference))?;
            let variable = table.by_reference(reference)?.variable;
            let place = self.equations.state_at(reference, N).ok_or(computed[value]);
            let scale = place.map_or(1.0, |index| scales[index]);
            let derivative = table.computed().nth(rate).and_then(|rate| self.equations.state_at(rate.reference, N));
            Some(State { place, nominal: variable.nominal.unwrap_or(scale), value, rate, derivative })
        });
        states.collect()
    }

    /// Finds out where the states lie.
    fn look_around(&mut self) {
        self.is_within = self.x.iter().zip(&self.limits).all(|(value, limits)| limits.hold(*value));
        self.near = self.x;
        if !self.is_within {
            self.near = std::array::from_fn(|index| self.limits[index].nearest(self.x[index]).0);
        }
    }

    /// Takes over an event's changes of the nearest states.
    fn take_over(&mut self, changed: &[Real; N]) {
        for (index, number) in changed.iter().enumerate() {
            if number.value != self.near[index] {
                self.x[index] = number.value;
            }
        }
        self.look_around();
    }

    /// Addition to the rate of a state beyond the limits: it returns the state, or adds the excess of its rate, a state
    /// beyond its own limits.
    fn added_rate(&self, index: usize, derivative: Option<usize>) -> f64 {
        // A sum of finite numbers is kept one.
        let bounded = |rate: f64| rate.clamp(-f64::MAX, f64::MAX);
        match derivative {
            Some(rate) => bounded(self.x[rate] - self.near[rate]),
            None => bounded((self.near[index] - self.x[index]) / RETURN),
        }
    }

    /// Makes values of the equations at the nearest states those at the states themselves.
    fn carry_on(&self, computed: &mut [f64]) {
        for state in &self.states {
            let Ok(index) = state.place else { continue };
            computed[state.rate] += self.added_rate(index, state.derivative);
        }
        self.each_beyond(|index, value| computed[value] = self.x[index]);
    }

    /// Does something with the index of each state that is beyond its limits, and the place of its variable unless that is
    /// another state's rate.
    fn each_beyond(&self, mut act: impl FnMut(usize, usize)) {
        for state in &self.states {
            let is_rate = || self.states.iter().any(|other| other.place.is_ok() && other.rate == state.value);
            match state.place {
                Ok(index) if self.near[index] != self.x[index] && !is_rate() => act(index, state.value),
                _ => {}
            }
        }
    }

    /// The nearest states and the inputs.
    fn numbers(&self) -> ([Real; N], [Real; U]) {
        (Real::all(&self.near), Real::all(&self.inputs))
    }

    /// Indicators as the equations have them, in their own units and exactly 0 at an event.
    fn exact_indicators(&self) -> E::Indicators<Real> {
        let (x, u) = self.numbers();
        self.equations.indicators(Real::of(self.elapsed), &x, &u, &self.memory)
    }

    /// Distance to each kink: negative beyond it.
    fn to_kinks(&self) -> impl Iterator<Item = f64> {
        let mut kinks = [UNUSED; MAX_KINKS];
        self.equations.kinks(&self.near, &mut kinks[..self.sides.len()]);
        let turned = |(kink, is_far): (f64, &bool)| if *is_far && kink != UNUSED { -kink } else { kink };
        kinks.into_iter().zip(&self.sides).map(turned)
    }

    /// Takes the equations on the side of each kink on which the states are.
    fn change_sides(&mut self) {
        let mut is_passed = [false; MAX_KINKS];
        is_passed.iter_mut().zip(self.to_kinks()).for_each(|(passed, distance)| *passed = distance < 0.0);
        self.sides.iter_mut().zip(is_passed).for_each(|(side, passed)| *side ^= passed);
    }

    /// Lets the system switch until all modes are valid.
    fn settle(&mut self) -> Result<(), ExchangeError> {
        let mut last = Vec::new();
        for switches in 0..MAX_SWITCHES {
            let indicators = self.exact_indicators();
            let Some(event) = indicators.as_ref().iter().position(|number| number.value < 0.0) else { return Ok(()) };
            let (mut x, u) = self.numbers();
            self.equations.switch(event, Real::of(self.elapsed), &mut x, &u, &mut self.memory);
            self.take_over(&x);
            self.counters.events += 1;
            if switches >= MAX_SWITCHES / 2 && !last.contains(&event) {
                last.push(event);
            }
        }
        let indicators = last.into_iter().map(|event| self.indicators[event].name.clone()).collect();
        Err(ExchangeError::Chattering { time: self.session.time, indicators })
    }

    /// Takes the samples that are due.
    fn sample(&mut self) -> Result<(), ExchangeError> {
        for _ in 0..MAX_SWITCHES {
            let sample = self.equations.next_sample::<Real>(&self.memory).rounded(self.elapsed, self.session.start);
            if !sample.is_due_at(self.elapsed) {
                return Ok(());
            }
            // A sample that is due is taken, however the host has rounded its time.
            let ((mut x, u), time) = (self.numbers(), Real::of(self.elapsed.max(sample.time.value)));
            self.equations.sample(time, &mut x, &u, &mut self.memory);
            self.take_over(&x);
        }
        let due = self.equations.next_sample::<Real>(&self.memory).time.value;
        Err(ExchangeError::MissedTimeEvents { time: self.session.time, due: self.session.start + due })
    }

    /// The first time on the clock of the host at which a time of the equations has come.
    fn on_clock(&self, time: f64) -> f64 {
        let mut clock = self.session.start + time;
        while clock - self.session.start < time {
            clock = clock.next_up();
        }
        clock
    }

    fn follow(&mut self) {
        let (x, u) = self.numbers();
        let _ = self.equations.follow(Real::of(self.elapsed), &x, &u, &mut self.memory);
    }
}

impl<E: System<U>, const N: usize, const U: usize> Exchange for Exchanger<E, N, U> {
    fn time(&self) -> f64 {
        self.session.time
    }

    fn set_time(&mut self, time: f64) {
        (self.session.time, self.elapsed) = (time, time - self.session.start);
    }

    fn set_inputs(&mut self, values: &[f64]) {
        self.inputs.copy_from_slice(&values[..U]);
    }

    fn retune(&mut self, parameters: &[f64]) -> Result<(), ParameterError> {
        self.equations = self.session.retune(parameters)?;
        self.limits = self.equations.limits();
        self.look_around();
        Ok(())
    }

    fn states(&self, states: &mut [f64]) {
        for (slot, state) in states.iter_mut().zip(&self.states) {
            *slot = state.place.map_or_else(|value| value, |index| self.x[index]);
        }
    }

    fn set_states(&mut self, states: &[f64]) {
        for (value, state) in states.iter().zip(&self.states) {
            if let Ok(index) = state.place {
                self.x[index] = *value;
            }
        }
        self.look_around();
    }

    fn admit(&self) -> Result<(), ExchangeError> {
        let refuse = |cause| ExchangeError::NotAdmissible { time: self.session.time, cause };
        self.equations.admit(&self.x).map_err(|cause| refuse(cause.to_owned()))?;
        for (index, (value, limits)) in self.x.iter().zip(&self.limits).enumerate() {
            if let Some(passed) = limits.passed(*value) {
                return Err(refuse(format!("{} = {value} is {passed}", state_name::<E, U>(&self.equations, index, N))));
            }
        }
        Ok(())
    }

    fn nominals(&self, nominals: &mut [f64]) {
        for (slot, state) in nominals.iter_mut().zip(&self.states) {
            *slot = state.nominal;
        }
    }

    fn rates(&self, rates: &mut [f64]) -> Result<(), ExchangeError> {
        let (x, u) = self.numbers();
        let here = self.equations.derivatives(Real::of(self.elapsed), &x, &u, &self.memory).map(Real::value);
        if here.iter().any(|rate| !rate.is_finite()) {
            return Err(ExchangeError::NotFinite { time: self.session.time });
        }
        for (slot, state) in rates.iter_mut().zip(&self.states) {
            *slot = state.place.map_or(0.0, |index| here[index]);
            if let (false, Ok(index)) = (self.is_within, state.place) {
                *slot += self.added_rate(index, state.derivative);
            }
        }
        Ok(())
    }

    fn indicators(&self, indicators: &mut [f64]) {
        let exact = self.exact_indicators();
        let all = exact.as_ref().iter().map(|number| number.value).chain(self.to_kinks());
        for ((slot, value), indicator) in indicators.iter_mut().zip(all).zip(&self.indicators) {
            *slot = seen(indicator, value);
        }
    }

    fn update(&mut self) -> Result<Update, ExchangeError> {
        self.admit()?;
        let (before, memory, counters) = (self.x, self.memory.clone(), self.counters);
        self.follow();
        if let Err(error) = self.sample().and_then(|()| self.settle()) {
            (self.x, self.memory, self.counters) = (before, memory, counters);
            self.look_around();
            return Err(error);
        }
        self.change_sides();
        let next =
            self.equations.next_sample::<Real>(&self.memory).time.value.min(self.elapsed + self.equations.max_step());
        let next = Some(next).filter(|time| time.is_finite()).map(|time| self.on_clock(time));
        Ok(Update { changes_states: self.x != before, next_time_event: next })
    }

    fn accept_step(&mut self) -> Result<(), ExchangeError> {
        self.admit()?;
        self.counters.steps += 1;
        self.follow();
        Ok(())
    }

    fn values(&self, computed: &mut [f64]) {
        let (own, rest) = computed.split_at_mut(computed.len() - Counters::COUNT - E::RESIDUALS);
        let (residuals, counters) = rest.split_at_mut(E::RESIDUALS);
        self.session.outputs(&self.equations, (self.elapsed, &self.near, &self.inputs, &self.memory), own);
        // The host's integration has no account.
        residuals.fill(0.0);
        self.counters.write(counters);
        if !self.is_within {
            self.carry_on(computed);
        }
    }

    fn directional_derivative(&self, direction: Direction, computed: &mut [f64]) {
        let mut states = [0.0; N];
        for (seed, state) in direction.states.iter().zip(&self.states) {
            if let Ok(index) = state.place {
                states[index] = *seed;
            }
        }
        let of_near: [f64; N] =
            std::array::from_fn(|index| self.limits[index].nearest(self.x[index]).1 * states[index]);
        let inputs = std::array::from_fn(|i| direction.inputs[i]);
        let at = (self.elapsed, &self.near, &self.inputs, &*self.memory);
        let seeds = (direction.time, &of_near, &inputs);
        self.session.differentiate(&self.equations, at, seeds, direction.parameters, computed);
        if !self.is_within {
            for state in &self.states {
                let Ok(index) = state.place else { continue };
                computed[state.rate] += match state.derivative {
                    Some(rate) => states[rate] - of_near[rate],
                    None => (of_near[index] - states[index]) / RETURN,
                };
            }
            self.each_beyond(|index, value| computed[value] = states[index]);
        }
    }

    fn notices(&self) -> Notices {
        self.equations.notices(&self.inputs)
    }

    fn save(&self) -> Snapshot {
        let memory = (&self.memory, self.counters, self.session.start, &self.sides);
        self.session.save(&self.equations, &self.x, memory)
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let (x, (memory, counters, start, sides)) =
            snapshot.read::<_, (Box<E::Memory<Real>>, Counters, f64, Vec<bool>), N, U>(&self.equations, &self.x)?;
        if !start.is_finite() {
            return Err(SnapshotError::NotFinite);
        }
        if sides.len() != self.sides.len() || !self.equations.fits::<Real>(&memory) {
            return Err(SnapshotError::Foreign);
        }
        (self.session.start, self.x, self.counters, self.sides) = (start, x, counters, sides);
        self.memory = memory;
        self.look_around();
        self.set_time(snapshot.time);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Varying;
    use crate::session::{Seeds, Start};
    use crate::states;
    use crate::system::{Sample, System, Tables};
    use crate::variables::Values;

    /// A system with events at one instant only: a number of handled ones, each with its indicator, and of samples.
    #[derive(Clone)]
    struct Busy {
        switches: usize,
        samples: usize,
    }

    states! {
        /// None.
        State of () {}
    }

    impl System<0> for Busy {
        type Parameters = ();
        type State = State;
        /// Switches and samples so far.
        type Memory<S: Varying> = [usize; 2];
        type Indicators<S: Varying> = [S; 3];

        fn tables() -> Tables {
            Tables { inputs: Vec::new(), computed: Vec::new(), parameters: Vec::new() }
        }
        fn new(_: &mut Values) -> Result<Self, ParameterError> {
            unreachable!("nothing is tuned")
        }
        fn parameters(&self) -> &() {
            &()
        }
        fn start<S: Varying, const N: usize>(&self, _: &[S; 0]) -> ([S; N], [usize; 2]) {
            unreachable!("it is given")
        }
        fn derivatives<S: Scalar, const N: usize>(&self, _: S, x: &[S; N], _: &[S; 0], _: &[usize; 2]) -> [S; N] {
            *x
        }
        fn outputs<S: Scalar, const N: usize>(&self, _: S, _: &[S; N], _: &[S; 0], _: &[usize; 2], _: &mut [S]) {}
        /// The first one begins, then the last two take turns.
        fn indicators<S: Varying, const N: usize>(
            &self,
            _: S,
            _: &[S; N],
            _: &[S; 0],
            &[switches, _]: &[usize; 2],
        ) -> [S; 3] {
            let next = if switches == 0 { 0 } else { 1 + switches % 2 };
            let value = |place| if place == next && switches < self.switches { -1.0 } else { 0.0 };
            std::array::from_fn(|place| S::of(value(place)))
        }
        fn switch<S: Varying, const N: usize>(
            &self,
            event: usize,
            _: S,
            _: &mut [S; N],
            _: &[S; 0],
            memory: &mut [usize; 2],
        ) {
            assert_eq!(event, if memory[0] == 0 { 0 } else { 1 + memory[0] % 2 });
            memory[0] += 1;
        }
        fn next_sample<S: Varying>(&self, memory: &[usize; 2]) -> Sample<S> {
            if memory[1] < self.samples { Sample::exact(S::of(0.5)) } else { Sample::never() }
        }
        fn sample<S: Varying, const N: usize>(&self, _: S, _: &mut [S; N], _: &[S; 0], memory: &mut [usize; 2]) {
            memory[1] += 1;
        }
    }

    fn busy(switches: usize, samples: usize) -> Box<Exchanger<Busy, 0, 0>> {
        let indicators =
            ["first", "second", "third"].map(|name| Indicator { name: name.to_owned(), nominal: 1.0, text: "" });
        let start = Start { time: 10.0, parameters: &[], inputs: &[], tolerance: None, seeds: Seeds::NONE };
        let mut session = Session::begin::<Busy, 0>(&start);
        session.time = 11.0;
        Exchanger::new((Busy { switches, samples }, session), (1.0, [], &[0, 0], []), indicators.to_vec())
    }

    /// Steps and events that it has counted.
    fn counted(model: &Exchanger<Busy, 0, 0>) -> [f64; 2] {
        let mut values = [0.0; Counters::COUNT];
        model.values(&mut values);
        [values[0], values[3]]
    }

    #[test]
    fn events_and_accepted_steps_are_counted() {
        let mut model = busy(99, 99);
        assert_eq!(model.update(), Ok(Update { changes_states: false, next_time_event: None }));
        assert_eq!((*model.memory, counted(&model)), ([99, 99], [0.0, 99.0]));
        model.accept_step().expect("states with a meaning");
        model.accept_step().expect("states with a meaning");
        assert_eq!(counted(&model), [2.0, 99.0]);
    }

    #[test]
    fn restored_model_goes_on_counting_where_it_was_saved() {
        let mut model = busy(3, 0);
        model.accept_step().expect("states with a meaning");
        model.update().expect("three events");
        let saved = model.save();
        model.accept_step().expect("states with a meaning");
        model.set_time(12.0);
        *model.memory = [0, 0];
        model.update().expect("three events more");
        assert_eq!(counted(&model), [2.0, 6.0]);
        model.restore(&saved).expect("a state of its own");
        assert_eq!((model.session.time, model.elapsed, *model.memory), (11.0, 1.0, [3, 0]));
        assert_eq!(counted(&model), [1.0, 3.0]);
    }

    #[test]
    fn saved_state_that_no_model_can_have_had_is_refused() {
        let mut model = busy(0, 0);
        let own = model.save();
        model.session.start = f64::NAN;
        let without_start = model.save();
        model.restore(&own).expect("a state of its own");
        model.session.time = f64::INFINITY;
        let without_time = model.save();
        model.restore(&own).expect("a state of its own");
        model.sides.push(true);
        let with_another_indicator = model.save();
        model.sides.pop();
        for forged in [without_start, without_time, with_another_indicator] {
            assert!(model.restore(&forged).is_err());
            assert_eq!((model.session.start, model.session.time, model.sides.is_empty()), (10.0, 11.0, true));
        }
    }

    /// However the clock of the host rounds, a time event that it has reached is due.
    #[test]
    fn time_event_has_come_where_the_clock_says_so() {
        let mut model = busy(0, 0);
        for start in [0.0, 0.1, -0.3, 1.0 / 3.0, 1e4 / 3.0, -1e9 / 7.0, 1e9] {
            model.session.start = start;
            for count in 1..200 {
                let time = 1e-3 * f64::from(count);
                let clock = model.on_clock(time);
                model.set_time(clock);
                // A sum and a difference are rounded.
                let rounding = 2.0 * f64::EPSILON * clock.abs().max(start.abs());
                assert!(model.elapsed >= time && clock - (start + time) <= rounding, "{start} {time}");
            }
        }
    }

    #[test]
    fn events_without_end_are_refused_by_the_names_of_those_that_go_on() {
        let mut model = busy(usize::MAX, 0);
        let expected = "at t = 11 s events follow each other without end; indicators: second, third";
        assert_eq!(model.update().expect_err("no end").to_string(), expected);
        assert_eq!((*model.memory, counted(&model)), ([0, 0], [0.0, 0.0]));
    }

    #[test]
    fn time_events_that_the_host_has_passed_are_refused() {
        let mut model = busy(1, 200);
        let expected = "at t = 11 s the time event of 10.5 s is still due, and too many after it";
        assert_eq!(model.update().expect_err("too many").to_string(), expected);
        assert_eq!((*model.memory, counted(&model)), ([0, 0], [0.0, 0.0]));
    }
}
