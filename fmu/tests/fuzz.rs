//! Random calls with random arguments, compared with a reference that drives the model without the C interface.
//!
//! `SERVO_FUZZ_CALLS` sets the number of calls (millions for a release), `SERVO_FUZZ_SEED` the first seed.

#![allow(unsafe_code, reason = "a C interface is called")]

mod common;

use std::cell::Cell;
use std::collections::{BTreeSet, VecDeque};
use std::env;
use std::ffi::{c_int, c_void};
use std::ptr;

use common::{DISCARD, ERROR, Instance, LIBRARY, OK, is_input, is_real};
use pneumatic_servo::co_simulation::{Direction, Simulation, Snapshot};
use pneumatic_servo::model::{Model, Start};
use pneumatic_servo::models;
use pneumatic_servo::variables::{Chosen, Kind, Role, Variable};

const INSTANCES: usize = 3;
const DEFAULT_CALLS: u64 = 20_000;
/// Calls with one set of instances.
const CALLS_PER_ROUND: u64 = 2_000;
/// Keeps steps with absurd parameters short.
const SOLVER_STEPS: i32 = 60;

/// What has to occur among the calls.
const OUTCOMES: [(&str, &[c_int]); 14] = [
    ("experiment", &[OK, ERROR]),
    ("enter", &[OK, ERROR]),
    ("exit", &[OK, ERROR]),
    ("terminate", &[OK, ERROR]),
    ("reset", &[OK]),
    ("set", &[OK, ERROR]),
    ("get", &[OK, ERROR]),
    ("slopes", &[OK, ERROR]),
    ("step", &[OK, DISCARD, ERROR]),
    ("restore", &[OK, ERROR]),
    ("free", &[OK, ERROR]),
    ("transport", &[OK]),
    ("d", &[OK, ERROR]),
    ("rates", &[OK, ERROR]),
];

fn setting(name: &str, default: u64) -> u64 {
    env::var(name).map_or(default, |text| text.parse().unwrap_or_else(|_| panic!("{name} must be a number")))
}

#[test]
fn random_calls_do_what_the_reference_does() {
    let calls = setting("SERVO_FUZZ_CALLS", DEFAULT_CALLS);
    let first_seed = setting("SERVO_FUZZ_SEED", 1);
    let mut outcomes = BTreeSet::new();
    for round in 0..calls.div_ceil(CALLS_PER_ROUND) {
        MODEL.set(&models::ALL[round as usize % models::ALL.len()]);
        let mut fuzzer = Fuzzer::new(first_seed + round);
        (0..CALLS_PER_ROUND).for_each(|_| fuzzer.call());
        outcomes.extend(fuzzer.outcomes);
    }
    // A fuzzer that never gets anywhere would agree with anything.
    for (call, statuses) in OUTCOMES {
        for status in statuses {
            assert!(outcomes.contains(&(call.to_owned(), *status)), "{call} never returned {status}");
        }
    }
}

thread_local! {
    /// The model of this round.
    static MODEL: Cell<&'static Model> = const { Cell::new(&models::ALL[0]) };
}

fn variables() -> &'static [Variable] {
    (MODEL.get().variables)()
}

/// The parameter that bounds the work of a step.
fn limit() -> &'static Variable {
    let bounds = |variable: &&Variable| variable.name.ends_with("PerCommunicationStep");
    variables().iter().find(bounds).expect("the parameter of every model")
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound as u64) as usize
    }

    fn one_in(&mut self, bound: usize) -> bool {
        self.below(bound) == 0
    }

    fn fraction(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    /// Any number: small, large, special, or any bits.
    fn number(&mut self) -> f64 {
        match self.below(8) {
            0 => self.pick(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, f64::MAX, f64::MIN_POSITIVE]),
            1 => f64::from_bits(self.next()),
            2 => 10f64.powi(self.below(40) as i32 - 20),
            _ => 20.0 * self.fraction() - 10.0,
        }
    }

    /// A value for a variable, mostly legal.
    fn value_for(&mut self, variable: &Variable) -> f64 {
        let start = variable.start.unwrap_or(1.0);
        if let Kind::Enumeration(of) = variable.kind
            && !self.one_in(8)
        {
            return of.items[self.below(of.items.len())].0.into();
        }
        if let Some(Chosen { of, .. }) = variable.chooses {
            return self.below(of.items.len() + 2) as f64;
        }
        match self.below(12) {
            0 => self.number(),
            1 => variable.min.unwrap_or(start),
            2 => variable.max.unwrap_or(start),
            3 => start,
            4 => start * 10f64.powf(2.0 * self.fraction() - 1.0),
            _ => start * (0.9 + 0.2 * self.fraction()),
        }
    }
}

/// What the instance should be.
#[derive(Clone)]
struct Expected {
    state: char,
    start: f64,
    stop: Option<f64>,
    tolerance: Option<f64>,
    parameters: Vec<f64>,
    inputs: Vec<f64>,
    slopes: Vec<f64>,
    failed: bool,
    successful_until: f64,
}

impl Expected {
    fn new() -> Self {
        let starts = |of: fn(&Variable) -> bool| -> Vec<f64> {
            variables().iter().filter(|variable| of(variable)).filter_map(|variable| variable.start).collect()
        };
        let inputs = starts(is_input);
        Self {
            state: 'I',
            start: 0.0,
            stop: None,
            tolerance: None,
            parameters: starts(Variable::is_parameter),
            slopes: vec![0.0; inputs.len()],
            inputs,
            failed: false,
            successful_until: 0.0,
        }
    }

    fn simulation(&self) -> Option<Box<dyn Simulation>> {
        let (time, tolerance) = (self.start, self.tolerance);
        let start = Start { time, parameters: &self.parameters, inputs: &self.inputs, tolerance };
        let mut simulation = (MODEL.get().start)(&start).ok()?;
        simulation.set_inputs(&self.inputs, &self.slopes);
        Some(simulation)
    }

    fn runs(&self) -> bool {
        "CFT".contains(self.state)
    }
}

/// An instance, what it should be, and its saved states with what they should be.
struct Pair {
    instance: Instance,
    expected: Expected,
    simulation: Option<Box<dyn Simulation>>,
    saved: Vec<(*mut c_void, Expected, Option<Snapshot>)>,
}

/// The place of a variable among those of its kind.
fn place(variable: &Variable, of: impl Fn(&Variable) -> bool) -> usize {
    let mut group = variables().iter().filter(|other| of(other));
    group.position(|other| other.reference == variable.reference).expect("a variable of the kind")
}

fn find(reference: u32) -> Option<&'static Variable> {
    variables().iter().find(|variable| variable.reference == reference)
}

fn is_computed_real(variable: &Variable) -> bool {
    variable.is_computed() && is_real(variable)
}

impl Pair {
    fn new() -> Self {
        let instance = Instance::of(MODEL.get());
        let mut pair = Self { instance, expected: Expected::new(), simulation: None, saved: Vec::new() };
        pair.limit_steps();
        pair
    }

    fn limit_steps(&mut self) {
        let limit = limit();
        assert_eq!(self.instance.set_integer(&[limit.reference], &[SOLVER_STEPS]), OK);
        self.expected.parameters[place(limit, Variable::is_parameter)] = SOLVER_STEPS.into();
    }

    fn time(&self) -> f64 {
        match &self.simulation {
            Some(simulation) if self.expected.runs() => simulation.time(),
            _ => self.expected.start,
        }
    }

    /// The computed values, if there are any.
    fn computed(&mut self) -> Option<Vec<f64>> {
        let mut computed = vec![f64::NAN; variables().iter().filter(|variable| variable.is_computed()).count()];
        match self.expected.state {
            'I' => return None,
            'M' => self.expected.simulation()?.values(&mut computed),
            _ => {
                let simulation = self.simulation.as_mut().expect("a running simulation");
                simulation.set_inputs(&self.expected.inputs, &self.expected.slopes);
                simulation.values(&mut computed);
            }
        }
        Some(computed)
    }

    /// The value of a variable, if it can be read.
    fn value(&mut self, variable: &Variable) -> Option<f64> {
        let value = match variable.role {
            Role::Time => self.time(),
            Role::Input => self.expected.inputs[place(variable, is_input)],
            Role::Fixed | Role::Tunable => {
                (MODEL.get().variables)().in_use(place(variable, Variable::is_parameter), &self.expected.parameters)
            }
            Role::Output | Role::Local => self.computed()?[place(variable, Variable::is_computed)],
        };
        value.is_finite().then_some(value)
    }

    fn can_set(&self, variable: &Variable, value: f64) -> bool {
        let states = match variable.role {
            Role::Input | Role::Tunable => "IMC",
            Role::Fixed => "IM",
            _ => "",
        };
        let item = match (variable.kind, variable.chooses) {
            (Kind::Enumeration(of), _) => of.has(value),
            (_, Some(Chosen { of, .. })) => value == 0.0 || of.has(value),
            _ => true,
        };
        states.contains(self.expected.state)
            && value.is_finite()
            && variable.min.is_none_or(|min| value >= min)
            && variable.max.is_none_or(|max| value <= max)
            && item
    }

    /// Sets values in the reference; tells whether they are legal.
    fn set(&mut self, references: &[u32], values: &[f64], of: impl Fn(&Variable) -> bool) -> bool {
        if !"IMC".contains(self.expected.state) {
            return false;
        }
        let mut candidate = self.expected.clone();
        let mut tunes = false;
        for (reference, value) in references.iter().zip(values) {
            let Some(variable) = find(*reference).filter(|variable| of(variable)) else { return false };
            if !self.can_set(variable, *value) {
                return false;
            }
            if is_input(variable) {
                candidate.inputs[place(variable, is_input)] = *value;
            } else {
                candidate.parameters[place(variable, Variable::is_parameter)] = *value;
                tunes = true;
            }
        }
        if let Some(simulation) = self.simulation.as_mut().filter(|_| tunes && self.expected.runs())
            && simulation.retune(&candidate.parameters).is_err()
        {
            return false;
        }
        self.expected = candidate;
        true
    }

    fn step(&mut self, point: f64, size: f64) -> c_int {
        let start = self.time();
        let end = point + size;
        let is_here = point == start || point == start.next_up();
        let is_size = size > 0.0 && size.is_finite();
        let rounding = |stop: f64| (1e-9 * stop.abs().max(size)).min(0.5 * size).max(4.0 * f64::EPSILON * stop.abs());
        let stops = self.expected.stop.is_some_and(|stop| end > stop + rounding(stop));
        if self.expected.state != 'C' || !is_here || !is_size || !end.is_finite() || end <= start || stops {
            return ERROR;
        }
        let inputs = variables().iter().filter(|variable| is_input(variable));
        for (index, variable) in inputs.enumerate() {
            let reached = self.expected.inputs[index] + self.expected.slopes[index] * (end - start);
            if self.expected.slopes[index] != 0.0 && !self.can_set(variable, reached) {
                return ERROR;
            }
        }
        let simulation = self.simulation.as_mut().expect("a running simulation");
        simulation.set_inputs(&self.expected.inputs, &self.expected.slopes);
        let outcome = simulation.advance(end);
        let (reached, is_finite) = (simulation.time(), simulation.is_finite());
        for (input, slope) in self.expected.inputs.iter_mut().zip(&mut self.expected.slopes) {
            if *slope != 0.0 {
                *input += *slope * (reached - start);
            }
            *slope = 0.0;
        }
        self.expected.failed = outcome.is_err() || !is_finite;
        self.expected.successful_until = if outcome.is_ok() && !is_finite { start } else { reached };
        self.expected.state = if self.expected.failed { 'F' } else { 'C' };
        if self.expected.failed { DISCARD } else { OK }
    }
}

struct Fuzzer {
    random: Random,
    seed: u64,
    pairs: Vec<Pair>,
    history: VecDeque<String>,
    /// Kinds of calls, and what they returned.
    outcomes: BTreeSet<(String, c_int)>,
}

impl Fuzzer {
    fn new(seed: u64) -> Self {
        Self {
            random: Random(seed),
            seed,
            pairs: (0..INSTANCES).map(|_| Pair::new()).collect(),
            history: VecDeque::new(),
            outcomes: BTreeSet::new(),
        }
    }

    fn compare(&mut self, what: String, expected: c_int, actual: c_int) {
        self.outcomes.insert((what.split(' ').nth(1).unwrap_or_default().to_owned(), expected));
        self.history.push_back(format!("{what} -> {expected}"));
        if self.history.len() > 30 {
            self.history.pop_front();
        }
        if expected != actual {
            let messages: Vec<_> = self.pairs.iter().map(|pair| pair.instance.messages().pop()).collect();
            panic!("seed {}: returned {actual}; {messages:#?} after {:#?}", self.seed, self.history);
        }
    }

    /// One random call, compared with the reference; a refused one must not change anything.
    fn call(&mut self) {
        let index = self.random.below(INSTANCES);
        let before = self.pairs[index].instance.fingerprint();
        let refused = match self.random.below(100) {
            0 => self.replace(index),
            1..=6 => self.experiment(index),
            7..=14 => self.enter(index),
            15..=24 => self.exit(index),
            25 => self.terminate(index),
            26..=27 => self.reset(index),
            28..=42 => self.set_reals(index),
            43..=46 => self.set_integers(index),
            47..=50 => self.set_slopes(index),
            51..=57 => self.get_reals(index),
            58..=60 => self.save(index),
            61..=64 => self.restore(index),
            65..=66 => self.forget(index),
            67..=69 => self.transport(index),
            70..=71 => self.corrupt(index),
            72..=75 => self.directional(index),
            76..=77 => self.output_derivatives(index),
            78..=81 => self.status(index),
            82 => self.nonsense(index),
            _ => self.step(index),
        };
        let pair = &self.pairs[index];
        if refused {
            assert!(before == pair.instance.fingerprint(), "seed {}: changed by {:#?}", self.seed, self.history.back());
        }
        self.look(index);
        self.pairs[index].instance.messages();
    }

    /// Compares some values that can be seen.
    fn look(&mut self, index: usize) {
        for _ in 0..2 {
            let variable = &variables()[self.random.below(variables().len())];
            let pair = &mut self.pairs[index];
            let expected = pair.value(variable);
            let (mut real, mut integer) = ([f64::NAN], [0]);
            let reference = [variable.reference];
            let status = match variable.kind {
                Kind::Real(_) => pair.instance.get_real(&reference, &mut real),
                Kind::Boolean => pair.instance.get_boolean(&reference, &mut integer),
                _ => pair.instance.get_integer(&reference, &mut integer),
            };
            if status == OK && !is_real(variable) {
                real[0] = integer[0].into();
            }
            let (seen, wanted) = ((status == OK).then(|| real[0].to_bits()), expected.map(f64::to_bits));
            assert_eq!(
                seen, wanted,
                "seed {}: {} = {real:?}, not {expected:?}, after {:#?}",
                self.seed, variable.name, self.history
            );
        }
    }

    fn replace(&mut self, index: usize) -> bool {
        self.pairs[index] = Pair::new();
        self.history.push_back(format!("{index}: a new instance"));
        false
    }

    fn experiment(&mut self, index: usize) -> bool {
        let random = &mut self.random;
        let start = if random.one_in(6) { random.number() } else { random.pick(&[0.0, 1.0, -3.7, 256.0]) };
        let stop = random.one_in(2).then(|| if random.one_in(4) { random.number() } else { start + 0.05 });
        let tolerance = random.one_in(3).then(|| if random.one_in(3) { random.number() } else { 1e-5 });
        let pair = &mut self.pairs[index];
        let legal = pair.expected.state == 'I'
            && start.is_finite()
            && stop.is_none_or(|stop| stop.is_finite() && stop >= start)
            && tolerance.is_none_or(|tolerance| tolerance.is_finite() && tolerance > 0.0);
        if legal {
            (pair.expected.start, pair.expected.stop, pair.expected.tolerance) = (start, stop, tolerance);
        }
        // SAFETY: of the component, as everywhere below.
        let actual = unsafe {
            (LIBRARY.fmi2SetupExperiment)(
                pair.instance.component,
                tolerance.is_some().into(),
                tolerance.unwrap_or_default(),
                start,
                stop.is_some().into(),
                stop.unwrap_or_default(),
            )
        };
        let expected = if legal { OK } else { ERROR };
        self.compare(format!("{index}: experiment {start} {stop:?} {tolerance:?}"), expected, actual);
        !legal
    }

    fn enter(&mut self, index: usize) -> bool {
        let pair = &mut self.pairs[index];
        let legal = pair.expected.state == 'I';
        if legal {
            pair.expected.state = 'M';
        }
        let actual = pair.instance.enter();
        self.compare(format!("{index}: enter"), if legal { OK } else { ERROR }, actual);
        !legal
    }

    fn exit(&mut self, index: usize) -> bool {
        let pair = &mut self.pairs[index];
        let is_finite = |values: Vec<f64>| values.iter().all(|value| value.is_finite());
        let legal = pair.expected.state == 'M' && pair.computed().is_some_and(is_finite);
        if legal {
            pair.simulation = pair.expected.simulation();
            pair.expected.state = 'C';
            (pair.expected.failed, pair.expected.successful_until) = (false, pair.expected.start);
        }
        let actual = pair.instance.exit();
        self.compare(format!("{index}: exit"), if legal { OK } else { ERROR }, actual);
        !legal
    }

    fn terminate(&mut self, index: usize) -> bool {
        let pair = &mut self.pairs[index];
        let legal = "CF".contains(pair.expected.state);
        if legal {
            pair.expected.state = 'T';
        }
        let actual = pair.instance.terminate();
        self.compare(format!("{index}: terminate"), if legal { OK } else { ERROR }, actual);
        !legal
    }

    fn reset(&mut self, index: usize) -> bool {
        let pair = &mut self.pairs[index];
        pair.expected = Expected::new();
        pair.simulation = None;
        let actual = pair.instance.reset();
        pair.limit_steps();
        self.compare(format!("{index}: reset"), OK, actual);
        false
    }

    /// References, mostly of variables of a kind, and values for them.
    fn assignment(&mut self, usual: impl Fn(&Variable) -> bool) -> (Vec<u32>, Vec<f64>) {
        let usual: Vec<_> = variables().iter().filter(|variable| usual(variable)).collect();
        let random = &mut self.random;
        let count = 1 + random.below(3);
        let choose = |_| match random.below(16) {
            0 => (random.next() as u32, 1.0),
            1 => (variables()[random.below(variables().len())].reference, random.number()),
            _ => {
                let variable = usual[random.below(usual.len())];
                (variable.reference, random.value_for(variable))
            }
        };
        (0..count).map(choose).unzip()
    }

    fn set_reals(&mut self, index: usize) -> bool {
        let only_inputs = self.random.one_in(2);
        let (references, values) = self.assignment(|variable| {
            is_real(variable) && (is_input(variable) || (variable.is_parameter() && !only_inputs))
        });
        let pair = &mut self.pairs[index];
        let legal = pair.set(&references, &values, is_real);
        let actual = pair.instance.set_real(&references, &values);
        self.compare(format!("{index}: set {references:?} {values:?}"), if legal { OK } else { ERROR }, actual);
        !legal
    }

    fn set_integers(&mut self, index: usize) -> bool {
        let limit = limit().reference;
        let is_integer = |variable: &Variable| {
            matches!(variable.kind, Kind::Integer | Kind::Enumeration(_)) && variable.reference != limit
        };
        let (references, values) = self.assignment(|variable| is_integer(variable) && variable.is_parameter());
        let values: Vec<_> = values.into_iter().map(|value| value as c_int).collect();
        let pair = &mut self.pairs[index];
        let legal = !references.contains(&limit)
            && pair.set(&references, &values.iter().map(|value| f64::from(*value)).collect::<Vec<_>>(), is_integer);
        if references.contains(&limit) {
            return false;
        }
        let actual = pair.instance.set_integer(&references, &values);
        self.compare(format!("{index}: set {references:?} {values:?}"), if legal { OK } else { ERROR }, actual);
        !legal
    }

    fn set_slopes(&mut self, index: usize) -> bool {
        let (references, values) = self.assignment(is_input);
        let order = if self.random.one_in(10) { self.random.below(4) as c_int - 1 } else { 1 };
        let pair = &mut self.pairs[index];
        let is_legal = |(reference, value): (&u32, &f64)| find(*reference).is_some_and(is_input) && value.is_finite();
        let legal = "IMC".contains(pair.expected.state) && order == 1 && references.iter().zip(&values).all(is_legal);
        if legal {
            for (reference, value) in references.iter().zip(&values) {
                pair.expected.slopes[place(find(*reference).expect("an input"), is_input)] = *value;
            }
        }
        let actual = pair.instance.set_input_derivatives(&references, &vec![order; references.len()], &values);
        self.compare(format!("{index}: slopes {references:?} {values:?}"), if legal { OK } else { ERROR }, actual);
        !legal
    }

    fn get_reals(&mut self, index: usize) -> bool {
        let (references, _) = self.assignment(is_real);
        let pair = &mut self.pairs[index];
        let found: Vec<_> = references.iter().map(|reference| find(*reference).filter(|it| is_real(it))).collect();
        let expected: Option<Vec<f64>> = found.into_iter().map(|variable| pair.value(variable?)).collect();
        let untouched = vec![-7.5; references.len()];
        let mut values = untouched.clone();
        let actual = pair.instance.get_real(&references, &mut values);
        let is_legal = expected.is_some();
        let wanted = expected.unwrap_or(untouched);
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&values), bits(&wanted), "seed {}: {references:?}", self.seed);
        self.compare(format!("{index}: get {references:?}"), if is_legal { OK } else { ERROR }, actual);
        !is_legal
    }

    fn save(&mut self, index: usize) -> bool {
        let pair = &mut self.pairs[index];
        if pair.saved.len() < 6 {
            let snapshot = pair.simulation.as_ref().filter(|_| pair.expected.runs()).map(|it| it.save());
            pair.saved.push((pair.instance.save(), pair.expected.clone(), snapshot));
            self.history.push_back(format!("{index}: save"));
        }
        false
    }

    fn restore(&mut self, index: usize) -> bool {
        if self.random.one_in(5) {
            let other = self.pairs[(index + 1) % INSTANCES].saved.first().map_or(ptr::null_mut(), |saved| saved.0);
            let actual = self.pairs[index].instance.restore(other);
            self.compare(format!("{index}: restore a foreign state"), ERROR, actual);
            return true;
        }
        let choice = self.random.next() as usize;
        let pair = &mut self.pairs[index];
        if pair.saved.is_empty() {
            return false;
        }
        let (handle, expected, snapshot) = &pair.saved[choice % pair.saved.len()];
        pair.expected = expected.clone();
        pair.simulation = snapshot.as_ref().map(|snapshot| {
            let mut simulation = expected.simulation().expect("parameters that were legal");
            simulation.restore(snapshot).expect("a snapshot of the same model");
            simulation
        });
        let actual = pair.instance.restore(*handle);
        self.compare(format!("{index}: restore"), OK, actual);
        false
    }

    fn forget(&mut self, index: usize) -> bool {
        let pair = &mut self.pairs[index];
        let Some((mut handle, ..)) = pair.saved.pop() else { return false };
        let mut stale = handle;
        let actual = pair.instance.forget(&mut handle);
        self.compare(format!("{index}: free a state"), OK, actual);
        let again = self.pairs[index].instance.forget(&mut stale);
        self.compare(format!("{index}: free it again"), ERROR, again);
        true
    }

    /// Moves a saved state into another instance as bytes.
    fn transport(&mut self, index: usize) -> bool {
        let target = (index + 1) % INSTANCES;
        let Some((handle, expected, snapshot)) = self.pairs[index].saved.last().cloned() else { return false };
        if self.pairs[target].saved.len() >= 6 {
            return false;
        }
        let bytes = self.pairs[index].instance.serialize(handle);
        let (actual, copy) = self.pairs[target].instance.deserialize(&bytes);
        self.compare(format!("{index}: transport"), OK, actual);
        self.pairs[target].saved.push((copy, expected, snapshot));
        true
    }

    fn corrupt(&mut self, index: usize) -> bool {
        let mut bytes = self.pairs[index].instance.fingerprint();
        let place = self.random.below(bytes.len());
        if self.random.one_in(2) {
            bytes[place] ^= 1 << self.random.below(8);
        } else {
            bytes.truncate(place);
        }
        let (actual, state) = self.pairs[index].instance.deserialize(&bytes);
        assert!(state.is_null());
        self.compare(format!("{index}: corrupt bytes at {place}"), ERROR, actual);
        true
    }

    fn directional(&mut self, index: usize) -> bool {
        let (unknowns, _) = self.assignment(is_computed_real);
        let (knowns, seeds) = self.assignment(|variable| {
            is_input(variable)
                || variable.role == Role::Time
                || variables().iter().any(|other| other.derivative_of == Some(variable.reference))
        });
        let pair = &mut self.pairs[index];
        let expected = directional(pair, &unknowns, &knowns, &seeds);
        let untouched = vec![-7.5; unknowns.len()];
        let mut values = untouched.clone();
        let actual = pair.instance.directional(&unknowns, &knowns, &seeds, &mut values);
        let is_legal = expected.is_some();
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&values), bits(&expected.unwrap_or(untouched)), "seed {}: {unknowns:?} {knowns:?}", self.seed);
        self.compare(format!("{index}: d {unknowns:?} / d {knowns:?}"), if is_legal { OK } else { ERROR }, actual);
        true
    }

    fn output_derivatives(&mut self, index: usize) -> bool {
        let is_output = |variable: &Variable| is_real(variable) && variable.role == Role::Output;
        let (references, _) = self.assignment(is_output);
        let pair = &mut self.pairs[index];
        let places: Option<Vec<_>> = references
            .iter()
            .map(|reference| Some(place(find(*reference).filter(|it| is_output(it))?, Variable::is_computed)))
            .collect();
        let expected = places.filter(|_| pair.expected.runs()).and_then(|places| {
            let mut rates = pair.computed()?;
            pair.simulation.as_ref()?.rates(&mut rates);
            places
                .into_iter()
                .map(|place| Some(rates[place]).filter(|rate| rate.is_finite()))
                .collect::<Option<Vec<_>>>()
        });
        let mut values = vec![-7.5; references.len()];
        let actual = pair.instance.output_derivatives(&references, &vec![1; references.len()], &mut values);
        let is_legal = expected.is_some();
        if let Some(expected) = expected {
            assert_eq!(values, expected, "seed {}", self.seed);
        }
        self.compare(format!("{index}: rates {references:?}"), if is_legal { OK } else { ERROR }, actual);
        true
    }

    fn status(&mut self, index: usize) -> bool {
        let pair = &self.pairs[index];
        let (component, mut integer, mut real) = (pair.instance.component, -1, f64::NAN);
        // SAFETY: as above.
        let statuses = unsafe {
            [
                (LIBRARY.fmi2GetStatus)(component, 0, &mut integer),
                (LIBRARY.fmi2GetRealStatus)(component, 2, &mut real),
                (LIBRARY.fmi2CancelStep)(component),
            ]
        };
        let runs = pair.expected.runs();
        if runs {
            assert_eq!(integer, if pair.expected.failed { DISCARD } else { OK });
            assert_eq!(real.to_bits(), pair.expected.successful_until.to_bits());
            assert_eq!(pair.instance.wants_to_terminate(), pair.expected.failed);
        }
        let expected = if runs { [OK, OK, ERROR] } else { [ERROR; 3] };
        for (expected, actual) in expected.into_iter().zip(statuses) {
            self.compare(format!("{index}: status"), expected, actual);
        }
        true
    }

    fn nonsense(&mut self, index: usize) -> bool {
        let component = self.pairs[index].instance.component;
        let number = 1 + self.random.below(1 << 20);
        // SAFETY: NULL is allowed to be passed.
        let statuses = unsafe {
            [
                (LIBRARY.fmi2GetReal)(component, ptr::null(), number, ptr::null_mut()),
                (LIBRARY.fmi2SetReal)(component, ptr::null(), number, ptr::null()),
                (LIBRARY.fmi2SetInteger)(component, ptr::null(), number, ptr::null()),
                (LIBRARY.fmi2SetString)(component, &(number as u32), 1, ptr::null()),
                (LIBRARY.fmi2SetRealInputDerivatives)(component, ptr::null(), number, ptr::null(), ptr::null()),
                (LIBRARY.fmi2SetFMUstate)(component, ptr::without_provenance_mut(number)),
                (LIBRARY.fmi2DeSerializeFMUstate)(component, ptr::null(), number, ptr::null_mut()),
                (LIBRARY.fmi2SetDebugLogging)(component, 1, number, ptr::null()),
            ]
        };
        for actual in statuses {
            self.compare(format!("{index}: nonsense"), ERROR, actual);
        }
        true
    }

    fn step(&mut self, index: usize) -> bool {
        let random = &mut self.random;
        let size = if random.one_in(12) { random.number() } else { random.pick(&[1e-3, 0.01, 1.0 / 60.0, 1e-5]) };
        let now = self.pairs[index].time();
        let point = match random.below(20) {
            0 => random.pick(&[now + 1.0, now - 2.0, f64::NAN, f64::INFINITY]),
            1 => now.next_up(),
            _ => now,
        };
        // The borders between rounding and error are tested elsewhere.
        let is_far = (point - now).abs() > size.max(1e-15 * now.abs()) || point.is_nan();
        let is_clear = point == now || point == now.next_up() || is_far;
        if !is_clear {
            return false;
        }
        let pair = &mut self.pairs[index];
        let expected = pair.step(point, size);
        let actual = pair.instance.step(point, size);
        self.compare(format!("{index}: step {point} {size}"), expected, actual);
        expected == ERROR
    }
}

/// A directional derivative of the reference, if it is defined.
fn directional(pair: &mut Pair, unknowns: &[u32], knowns: &[u32], seeds: &[f64]) -> Option<Vec<f64>> {
    let places: Option<Vec<_>> = unknowns
        .iter()
        .map(|reference| Some(place(find(*reference).filter(|it| is_computed_real(it))?, Variable::is_computed)))
        .collect();
    let states: Vec<u32> = variables().iter().filter_map(|variable| variable.derivative_of).collect();
    let (mut input_seeds, mut state_seeds) = (vec![0.0; pair.expected.inputs.len()], vec![0.0; states.len()]);
    let mut time_seed = 0.0;
    for (known, seed) in knowns.iter().zip(seeds).filter(|_| pair.expected.state != 'I') {
        if !seed.is_finite() {
            return None;
        }
        if let Some(place) = states.iter().position(|state| state == known) {
            state_seeds[place] += seed;
        } else if find(*known).is_some_and(|variable| variable.role == Role::Time) {
            time_seed += seed;
        } else {
            input_seeds[place(find(*known).filter(|it| is_input(it))?, is_input)] += seed;
        }
    }
    let mut derivatives = pair.computed()?;
    let during_initialization = pair.expected.simulation().filter(|_| pair.expected.state == 'M');
    let simulation = during_initialization.as_ref().or(pair.simulation.as_ref())?;
    let direction = Direction { time: time_seed, inputs: &input_seeds, states: &state_seeds };
    simulation.directional_derivative(direction, &mut derivatives);
    places?.into_iter().map(|place| Some(derivatives[place]).filter(|value| value.is_finite())).collect()
}
