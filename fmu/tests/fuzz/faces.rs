//! Random calls of FMI 3.0 for co-simulation, beside the same calls of FMI 2.0, which the reference has checked: both must
//! return the same, show the same and remember the same, bit for bit.

use std::collections::BTreeSet;
use std::ffi::c_int;

use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Kind, Variable};

use crate::common::fmi3::{Instance3, Way};
use crate::common::{DISCARD, ERROR, Instance, OK, is_input, is_real, served};
use crate::random::Random;
use crate::{CALLS_PER_ROUND, DEFAULT_CALLS, MODEL, SOLVER_STEPS, limit, setting, variables};

pub struct Twins {
    pub random: Random,
    two: Instance,
    three: Instance3,
    saved: Vec<Vec<u8>>,
    outcomes: BTreeSet<(&'static str, c_int)>,
    /// Kinds of values that have been set.
    set: BTreeSet<&'static str>,
}

/// Outcomes that have to occur among the calls.
const OUTCOMES: [(&str, &[c_int]); 10] = [
    ("enter", &[OK, ERROR]),
    ("exit", &[OK, ERROR]),
    ("terminate", &[OK, ERROR]),
    ("reset", &[OK]),
    ("set", &[OK, ERROR]),
    ("get", &[OK, ERROR]),
    ("directional", &[OK, ERROR]),
    ("step", &[OK, ERROR]),
    ("halted step", &[ERROR]),
    ("restore", &[OK]),
];

#[test]
fn random_calls_of_fmi_3_do_what_those_of_fmi_2_do() {
    let rounds = setting("SERVO_FUZZ_CALLS", DEFAULT_CALLS).div_ceil(CALLS_PER_ROUND);
    let models = served();
    let (mut outcomes, mut set) = (BTreeSet::new(), BTreeSet::new());
    for round in 0..rounds {
        let model = models[round as usize % models.len()];
        MODEL.set(model);
        let mut twins = Twins::new(model, Random::Seeded(setting("SERVO_FUZZ_SEED", 1) + round));
        (0..CALLS_PER_ROUND / 2).for_each(|_| twins.call());
        outcomes.extend(twins.outcomes);
        set.extend(twins.set);
    }
    // The bound of the work of a step is set once only.
    let settable = |it: &&Variable| is_settable(it) && !it.name.ends_with("PerCommunicationStep");
    let kinds = models.iter().flat_map(|model| model.table().iter()).filter(settable).map(kind);
    assert_eq!(set, kinds.collect());
    for (call, statuses) in OUTCOMES {
        for status in statuses {
            assert!(outcomes.contains(&(call, *status)), "{call} never returned {status}");
        }
    }
}

impl Twins {
    pub fn new(model: &Model, random: Random) -> Self {
        let (two, three) = (Instance::of(model), Instance3::of(model, Way::Steps));
        let twins = Self { random, two, three, saved: Vec::new(), outcomes: BTreeSet::new(), set: BTreeSet::new() };
        twins.limit_steps();
        twins
    }

    fn limit_steps(&self) {
        let limit = limit().reference;
        assert_eq!(self.two.set_integer(&[limit], &[SOLVER_STEPS]), OK);
        assert_eq!(self.three.set_int32(&[limit], &[SOLVER_STEPS]), OK);
    }

    pub fn call(&mut self) {
        let (call, two, three) = match self.random.below(20) {
            0 => self.enter(),
            1 => ("exit", self.two.exit(), self.three.exit()),
            2 if self.random.one_in(4) => ("terminate", self.two.terminate(), self.three.terminate()),
            3 if self.random.one_in(8) => {
                let statuses = ("reset", self.two.reset(), self.three.reset());
                self.limit_steps();
                statuses
            }
            4..=8 => self.set(),
            9..=11 => self.get(),
            12 => self.differentiate(),
            13 => self.save_or_restore(),
            _ => self.step(),
        };
        let (messages, others) = (self.two.messages(), self.three.messages());
        assert_eq!(two, three, "{call}: {messages:#?} and {others:#?}");
        self.outcomes.insert((call, two));
        assert!(self.two.fingerprint() == self.three.fingerprint(), "{call} has led to different states");
    }

    /// FMI 3.0 sets up the experiment where the initialization begins.
    fn enter(&self) -> (&'static str, c_int, c_int) {
        self.two.setup(0.0, None);
        ("enter", self.two.enter(), self.three.enter())
    }

    /// An element of an array, mostly of a variable that can be set, with a value, and the whole array around it.
    fn set(&mut self) -> (&'static str, c_int, c_int) {
        let mut settable: Vec<_> = variables().iter().filter(|it| is_settable(it)).collect();
        if self.random.one_in(4) {
            // Few variables are switches.
            let kinds: BTreeSet<_> = settable.iter().map(|it| kind(it)).collect();
            let wanted = kinds.iter().nth(self.random.below(kinds.len()));
            settable.retain(|it| Some(&kind(it)) == wanted);
        }
        let variable = settable[self.random.below(settable.len())];
        if variable.reference == limit().reference {
            return ("set", OK, OK);
        }
        let value = self.random.value_for(variable);
        let reference = [variable.reference];
        let (two, three) = match variable.kind {
            Kind::Real(_) => {
                let ((array, mut values), number) = (self.array(variable), place(variable));
                values[number] = value;
                (self.two.set_real(&reference, &[value]), self.three.set(&[array], &values))
            }
            Kind::Integer => {
                let value = value as i32;
                (self.two.set_integer(&reference, &[value]), self.three.set_int32(&reference, &[value]))
            }
            Kind::Enumeration(_) => {
                let value = value as i32;
                (self.two.set_integer(&reference, &[value]), self.three.set_int64(&reference, &[value.into()]))
            }
            Kind::Boolean => {
                let (value, byte) = (value as i32, value as u8);
                (self.two.set_boolean(&reference, &[value]), self.three.set_boolean(&reference, &[byte]))
            }
        };
        if two == OK {
            self.set.insert(kind(variable));
        }
        ("set", two, three)
    }

    /// The array around a variable, with its present values as FMI 2.0 tells them.
    fn array(&self, variable: &Variable) -> (u32, Vec<f64>) {
        let table = MODEL.get().table();
        let first = table.array_at(variable.reference).map_or(variable.reference, |(first, _)| first);
        let length = table.length_at(first).expect("the first element");
        let references: Vec<u32> = (first..).take(length).collect();
        let mut values = vec![0.0; length];
        self.two.get_real(&references, &mut values);
        (first, values)
    }

    fn get(&mut self) -> (&'static str, c_int, c_int) {
        let variable = &variables()[self.random.below(variables().len())];
        let reference = [variable.reference];
        let (mut integer, mut wide, mut byte) = ([-7], [-7], [9]);
        let statuses = match variable.kind {
            Kind::Real(_) => {
                let (first, mut values) = self.array(variable);
                let (mut other, mut one) = (vec![f64::NAN; values.len()], [f64::NAN]);
                let references: Vec<u32> = (first..).take(values.len()).collect();
                let statuses = (self.two.get_real(&references, &mut values), self.three.get(&[first], &mut other));
                if statuses.0 == OK {
                    let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
                    assert_eq!(bits(&values), bits(&other), "{}", variable.name);
                    assert_eq!(self.two.get_real(&reference, &mut one), OK);
                }
                statuses
            }
            Kind::Integer => {
                let mut other = [-7];
                let statuses =
                    (self.two.get_integer(&reference, &mut integer), self.three.get_int32(&reference, &mut other));
                assert_eq!(integer, other, "{}", variable.name);
                statuses
            }
            Kind::Enumeration(_) => {
                let statuses =
                    (self.two.get_integer(&reference, &mut integer), self.three.get_int64(&reference, &mut wide));
                assert_eq!(i64::from(integer[0]), wide[0], "{}", variable.name);
                statuses
            }
            Kind::Boolean => {
                let statuses =
                    (self.two.get_boolean(&reference, &mut integer), self.three.get_boolean(&reference, &mut byte));
                assert!(statuses.0 != OK || integer[0] == c_int::from(byte[0]), "{}", variable.name);
                statuses
            }
        };
        ("get", statuses.0, statuses.1)
    }

    /// With respect to an input or, which is refused, a parameter; directional and adjoint derivatives are the same number.
    fn differentiate(&mut self) -> (&'static str, c_int, c_int) {
        let scalars: Vec<_> = variables()
            .iter()
            .filter(|it| is_real(it) && MODEL.get().table().array_at(it.reference).is_none())
            .collect();
        let computed: Vec<_> = scalars.iter().filter(|it| it.is_computed()).collect();
        let unknown = [computed[self.random.below(computed.len())].reference];
        let known = [scalars[self.random.below(scalars.len())].reference];
        let (mut two, mut three, mut adjoint) = ([-7.0], [-7.0], [-7.0]);
        let status = self.two.directional(&unknown, &known, &[1.0], &mut two);
        let other = self.three.directional(&unknown, &known, &[1.0], &mut three);
        assert_eq!(self.three.adjoint(&unknown, &known, &[1.0], &mut adjoint), other);
        let messages = (self.two.messages(), self.three.messages());
        assert_eq!((status, two, two), (other, three, adjoint), "{messages:?}");
        ("directional", status, other)
    }

    fn save_or_restore(&mut self) -> (&'static str, c_int, c_int) {
        if self.saved.len() < 5 || self.random.one_in(2) {
            self.saved.push(self.two.fingerprint());
            return ("save", OK, OK);
        }
        let bytes = self.saved.swap_remove(self.random.below(self.saved.len()));
        let ((one, mut state), (other, copy)) = (self.two.deserialize(&bytes), self.three.deserialize(&bytes));
        assert_eq!((one, other), (OK, OK));
        let statuses = ("restore", self.two.restore(state), self.three.restore(copy));
        assert_eq!(self.two.forget(&mut state), OK);
        statuses
    }

    fn step(&mut self) -> (&'static str, c_int, c_int) {
        let random = &mut self.random;
        let size = if random.one_in(12) { random.number() } else { random.pick(&[1e-3, 0.01, 1.0 / 60.0, 1e-5]) };
        let mut now = [f64::NAN];
        assert_eq!(self.two.get_real(&[0], &mut now), OK);
        let point = if random.one_in(20) { now[0] + 1.0 } else { now[0] };
        let (two, (three, step)) = (self.two.step(point, size), self.three.step(point, size));
        let is_halted = two == DISCARD;
        if two == OK || is_halted {
            assert_eq!(step.time.to_bits(), self.two.last_successful_time().to_bits());
            assert_eq!((step.event, step.early, step.terminate == 1), (0, 0, self.two.wants_to_terminate()));
        }
        // FMI 3.0 discards only what leaves no trace.
        if is_halted { ("halted step", ERROR, three) } else { ("step", two, three) }
    }
}

/// The name of the kind of a variable.
fn is_settable(variable: &Variable) -> bool {
    variable.is_parameter() || is_input(variable) || variable.derivative_of.is_some()
}

fn kind(variable: &Variable) -> &'static str {
    match variable.kind {
        Kind::Real(_) => "Real",
        Kind::Integer => "Integer",
        Kind::Enumeration(_) => "Enumeration",
        Kind::Boolean => "Boolean",
    }
}

/// The place of a variable in its array.
fn place(variable: &Variable) -> usize {
    MODEL.get().table().array_at(variable.reference).map_or(0, |(_, number)| number - 1)
}
