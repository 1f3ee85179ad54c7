//! Random calls of FMI 2.0 for co-simulation, each compared with the reference.

use std::collections::{BTreeSet, VecDeque};
use std::ffi::c_int;
use std::ptr;

use pneumatic_servo::variables::Kind;

use crate::common::{DISCARD, ERROR, LIBRARY, OK, is_real};
use crate::random::Random;
use crate::reference::{Expected, Pair};
use crate::{INSTANCES, variables};

pub struct Fuzzer {
    pub random: Random,
    pub seed: u64,
    pub pairs: Vec<Pair>,
    pub history: VecDeque<String>,
    /// Kinds of calls, and what they returned.
    pub outcomes: BTreeSet<(String, c_int)>,
}

impl Fuzzer {
    pub fn new(random: Random) -> Self {
        Self {
            seed: if let Random::Seeded(seed) = random { seed } else { 0 },
            random,
            pairs: (0..INSTANCES).map(|_| Pair::new()).collect(),
            history: VecDeque::new(),
            outcomes: BTreeSet::new(),
        }
    }

    pub fn compare(&mut self, what: String, expected: c_int, actual: c_int) {
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
    pub fn call(&mut self) {
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
            43..=45 => self.set_integers(index),
            46 => self.set_booleans(index),
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
                seen,
                wanted,
                "seed {}: {} = {real:?} with status {status}, not {expected:?}; {:?}; after {:#?}",
                self.seed,
                variable.name,
                pair.instance.messages(),
                self.history
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
        let pair = &mut self.pairs[index];
        let is_at_the_stop = pair.expected.stop.is_some_and(|stop| {
            let beyond = point + size - stop;
            0.0 < beyond && beyond <= (0.5 * size).max(1e-15 * stop.abs())
        });
        if !is_clear || is_at_the_stop {
            return false;
        }
        let expected = pair.step(point, size);
        let actual = pair.instance.step(point, size);
        self.compare(format!("{index}: step {point} {size}"), expected, actual);
        expected == ERROR
    }
}
