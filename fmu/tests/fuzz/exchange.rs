//! Random calls for model exchange, of both versions of FMI and of the model itself: all three must see the same.

use std::collections::BTreeSet;
use std::ffi::c_int;

use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::{Model, Setup};
use pneumatic_servo::model_exchange::Exchange;
use pneumatic_servo_fmu::fmi2::types::EventInfo;

use crate::common::fmi3::{Instance3, LIBRARY3, Way};
use crate::common::{DISCARD, ERROR, Instance, LIBRARY, OK, is_input, is_real};
use crate::random::Random;
use crate::{CALLS_PER_ROUND, DEFAULT_CALLS, MODEL, exchanged, setting, variables};

/// Two instances after initialization, and the model.
pub struct Triplets {
    pub random: Random,
    two: Instance,
    three: Instance3,
    model: Box<dyn Exchange>,
    inputs: Vec<f64>,
    /// Event mode (E), continuous-time mode (X), terminated (T).
    mode: char,
    states: usize,
    indicators: usize,
    outcomes: BTreeSet<(&'static str, c_int)>,
}

/// Outcomes that have to occur among the calls.
const OUTCOMES: [(&str, &[c_int]); 8] = [
    ("event", &[OK, ERROR]),
    ("update", &[OK, ERROR]),
    ("integrate", &[OK, ERROR]),
    ("accept", &[OK, ERROR]),
    ("time", &[OK, ERROR]),
    ("states", &[OK, ERROR]),
    ("rates", &[OK]),
    ("input", &[OK, ERROR]),
];

#[test]
fn random_calls_of_model_exchange_do_what_the_model_does() {
    let rounds = setting("SERVO_FUZZ_CALLS", DEFAULT_CALLS).div_ceil(CALLS_PER_ROUND);
    let exchanged = exchanged();
    let mut outcomes = BTreeSet::new();
    for round in 0..rounds {
        let model = exchanged[round as usize % exchanged.len()];
        MODEL.set(model);
        let mut triplets = Triplets::new(model, Random::Seeded(setting("SERVO_FUZZ_SEED", 1) + round));
        (0..CALLS_PER_ROUND / 2).for_each(|_| triplets.call());
        outcomes.extend(triplets.outcomes);
    }
    for (call, statuses) in OUTCOMES {
        for status in statuses {
            assert!(outcomes.contains(&(call, *status)), "{call} never returned {status}");
        }
    }
}

impl Triplets {
    /// With a random friction law.
    pub fn new(model: &'static Model, mut random: Random) -> Self {
        let law = model.table().find("friction.law").expect("every model rubs").variable.reference;
        let id = 1 + random.below(LAWS.items.len()) as i32;
        let (two, three) = (Instance::for_exchange(model), Instance3::of(model, Way::Exchange));
        assert_eq!((two.set_integer(&[law], &[id]), three.set_int64(&[law], &[id.into()])), (OK, OK));
        two.initialize();
        assert_eq!((three.enter(), three.exit()), (OK, OK));
        let setup = Setup::new(model).set("friction.law", id).expect("a law");
        Self {
            random,
            two,
            three,
            model: setup.exchange(0.0).expect("legal parameters").expect("continuous states"),
            inputs: variables().iter().filter(|it| is_input(it)).filter_map(|it| it.start).collect(),
            mode: 'E',
            states: model.table().number_of_states(),
            indicators: model.indicators().len(),
            outcomes: BTreeSet::new(),
        }
    }

    pub fn call(&mut self) {
        let (call, expected, two, three) = match self.random.below(16) {
            0..=1 => self.enter_event_mode(),
            2..=3 => self.update(),
            4..=6 => self.integrate(),
            7 => self.accept(),
            8..=9 => self.set_time(),
            10..=12 => self.set_states(),
            13 if self.mode != 'T' && self.random.one_in(30) => {
                self.mode = 'T';
                ("terminate", OK, self.two.terminate(), self.three.terminate())
            }
            _ => self.set_input(),
        };
        let messages = (self.two.messages(), self.three.messages());
        assert_eq!((two, three), (expected, expected), "{call} in {}: {messages:#?}", self.mode);
        self.outcomes.insert((call, expected));
        self.look();
        assert!(self.two.fingerprint() == self.three.fingerprint(), "{call} has led to different states");
    }

    /// Compares all that a solver sees.
    fn look(&mut self) {
        let (mut wanted, mut two, mut three) =
            (vec![-7.0; self.states], vec![-7.0; self.states], vec![-7.0; self.states]);
        self.model.states(&mut wanted);
        self.vector(LIBRARY.fmi2GetContinuousStates, LIBRARY3.fmi3GetContinuousStates, OK, &mut two, &mut three);
        assert_eq!((bits(&two), bits(&three)), (bits(&wanted), bits(&wanted)));
        let (mut wanted, mut two, mut three) = (vec![-7.0; self.states], two.clone(), three.clone());
        two.fill(-7.0);
        three.fill(-7.0);
        let rates = if self.model.rates(&mut wanted).is_ok() { OK } else { DISCARD };
        self.vector(
            LIBRARY.fmi2GetDerivatives,
            LIBRARY3.fmi3GetContinuousStateDerivatives,
            rates,
            &mut two,
            &mut three,
        );
        self.outcomes.insert(("rates", rates));
        if rates == OK {
            assert_eq!((bits(&two), bits(&three)), (bits(&wanted), bits(&wanted)));
        }
        let (mut wanted, mut two) = (vec![-7.0; self.indicators], vec![-7.0; self.indicators]);
        let mut three = two.clone();
        self.model.indicators(&mut wanted);
        self.vector(LIBRARY.fmi2GetEventIndicators, LIBRARY3.fmi3GetEventIndicators, OK, &mut two, &mut three);
        assert_eq!((bits(&two), bits(&three)), (bits(&wanted), bits(&wanted)));
    }

    fn vector(
        &self,
        get: crate::common::fmi3::Vector,
        get3: crate::common::fmi3::Vector,
        expected: c_int,
        two: &mut [f64],
        three: &mut [f64],
    ) {
        // SAFETY: of the component; the array has its length.
        let status = unsafe { get(self.two.component, two.as_mut_ptr(), two.len()) };
        assert_eq!((status, self.three.vector(get3, three)), (expected, expected));
        self.two.messages();
        self.three.messages();
    }

    fn legal(&self, modes: &str) -> c_int {
        if modes.contains(self.mode) { OK } else { ERROR }
    }

    /// FMI 2.0 allows it from event mode too, where it changes nothing.
    fn enter_event_mode(&mut self) -> (&'static str, c_int, c_int, c_int) {
        let admitted = |legal| if legal == OK && self.model.admit().is_err() { ERROR } else { legal };
        let (expected, three) = (admitted(self.legal("X")), self.three.enter_event_mode());
        // SAFETY: of the component, as everywhere below.
        let two = unsafe { (LIBRARY.fmi2EnterEventMode)(self.two.component) };
        assert_eq!(two, admitted(self.legal("EX")), "{:#?}", self.two.messages());
        if expected == OK {
            self.mode = 'E';
        }
        ("event", expected, expected, three)
    }

    fn update(&mut self) -> (&'static str, c_int, c_int, c_int) {
        let mut info = EventInfo::default();
        let two = unsafe { (LIBRARY.fmi2NewDiscreteStates)(self.two.component, &mut info) };
        let (three, updated) = self.three.update();
        if self.mode != 'E' {
            return ("update", ERROR, two, three);
        }
        match self.model.update() {
            Ok(update) => {
                let time = update.next_time_event.unwrap_or_default();
                assert_eq!((info.next_event_time.to_bits(), updated.time.to_bits()), (time.to_bits(), time.to_bits()));
                let changes = update.changes_states;
                assert_eq!((info.values_of_continuous_states_changed == 1, updated.values == 1), (changes, changes));
                ("update", OK, two, three)
            }
            Err(_) => ("update", ERROR, two, three),
        }
    }

    fn integrate(&mut self) -> (&'static str, c_int, c_int, c_int) {
        let expected = self.legal("E");
        let two = unsafe { (LIBRARY.fmi2EnterContinuousTimeMode)(self.two.component) };
        let three = self.three.integrate();
        if expected == OK {
            self.mode = 'X';
        }
        ("integrate", expected, two, three)
    }

    fn accept(&mut self) -> (&'static str, c_int, c_int, c_int) {
        let mut expected = self.legal("X");
        if expected == OK && self.model.accept_step().is_err() {
            expected = ERROR;
        }
        let (mut enter, mut terminate) = (7, 7);
        let two = unsafe { (LIBRARY.fmi2CompletedIntegratorStep)(self.two.component, 1, &mut enter, &mut terminate) };
        ("accept", expected, two, self.three.accept_step())
    }

    fn set_time(&mut self) -> (&'static str, c_int, c_int, c_int) {
        let random = &mut self.random;
        let step = random.pick(&[0.0, 1e-6, 1e-4, 1e-3]);
        let time = if random.one_in(10) { random.number() } else { self.model.time() + step };
        // Times far ahead are legal, but samples of a law between here and there would be too many.
        let time = if time > self.model.time() + 1.0 { f64::NAN } else { time };
        let expected = if time.is_finite() && time >= 0.0 { self.legal("EX") } else { ERROR };
        if expected == OK {
            self.model.set_time(time);
        }
        let two = unsafe { (LIBRARY.fmi2SetTime)(self.two.component, time) };
        ("time", expected, two, self.three.set_time(time))
    }

    /// Near where they are, or anywhere.
    fn set_states(&mut self) -> (&'static str, c_int, c_int, c_int) {
        let mut states = vec![0.0; self.states];
        self.model.states(&mut states);
        let random = &mut self.random;
        for state in &mut states {
            *state = if random.one_in(200) { random.number() } else { *state + 1e-6 * random.fraction() };
        }
        let expected = if states.iter().all(|state| state.is_finite()) { self.legal("X") } else { ERROR };
        if expected == OK {
            self.model.set_states(&states);
        }
        let set = LIBRARY.fmi2SetContinuousStates;
        let two = unsafe { set(self.two.component, states.as_ptr(), states.len()) };
        ("states", expected, two, self.three.set_states(&states))
    }

    fn set_input(&mut self) -> (&'static str, c_int, c_int, c_int) {
        let inputs: Vec<_> = variables().iter().filter(|it| is_input(it)).collect();
        let place = self.random.below(inputs.len());
        let value = self.random.value_for(inputs[place]);
        let is_legal = inputs[place].check(value).is_ok();
        // Discrete inputs change in event mode only.
        let modes = if is_real(inputs[place]) { "EX" } else { "E" };
        let expected = if is_legal { self.legal(modes) } else { ERROR };
        if expected == OK {
            self.inputs[place] = value;
            self.model.set_inputs(&self.inputs);
        }
        let reference = [inputs[place].reference];
        if is_real(inputs[place]) {
            return ("input", expected, self.two.set_real(&reference, &[value]), self.three.set(&reference, &[value]));
        }
        let two = self.two.set_boolean(&reference, &[value as c_int]);
        ("coil", expected, two, self.three.set_boolean(&reference, &[value as u8]))
    }
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}
