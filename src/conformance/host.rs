//! A host that integrates a model by itself: the method of Dormand and Prince (1980), J. Computational and Applied
//! Mathematics 6(1):19-26, with events located by steps of its own.

use super::Course;
use crate::model_exchange::Exchange;

const TIMES: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const STAGES: [[f64; 6]; 7] = [
    [0.0; 6],
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Weights of the fifth order less the weights of the fourth.
const ERRORS: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];

/// A model and its host.
pub struct Host {
    /// The model.
    pub model: Box<dyn Exchange>,
    course: Course,
    u: Vec<f64>,
    time: f64,
    states: Vec<f64>,
    nominals: Vec<f64>,
    indicators: usize,
    next_time_event: f64,
    step: f64,
    tolerance: f64,
}

impl std::fmt::Debug for Host {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Host").field("time", &self.time).field("states", &self.states).finish_non_exhaustive()
    }
}

impl Host {
    /// A host at the start of a model with numbers of states and indicators, under start values and courses of its inputs, at a
    /// tolerance relative to the nominal values of the states.
    ///
    /// # Panics
    /// As [`advance`](Self::advance).
    pub fn new(
        model: Box<dyn Exchange>,
        inputs: &[f64],
        [states, indicators]: [usize; 2],
        course: Course,
        tolerance: f64,
    ) -> Self {
        let mut nominals = vec![0.0; states];
        model.nominals(&mut nominals);
        let mut host = Self {
            time: model.time(),
            model,
            course,
            u: inputs.to_vec(),
            states: vec![0.0; states],
            nominals,
            indicators,
            next_time_event: f64::INFINITY,
            step: 1e-6,
            tolerance,
        };
        host.model.states(&mut host.states);
        (host.course)(host.time, &mut host.u);
        host.model.set_inputs(&host.u);
        host.update();
        host
    }

    /// The indicators at the present point.
    pub fn indicators(&self) -> Vec<f64> {
        let mut indicators = vec![0.0; self.indicators];
        self.model.indicators(&mut indicators);
        indicators
    }

    /// The states as the model has them.
    pub fn states(&self) -> &[f64] {
        &self.states
    }

    /// Updates the model; all indicators are positive then, and a second update has nothing left to do.
    fn update(&mut self) {
        let update = self.model.update().expect("an update");
        let before = self.states.clone();
        self.model.states(&mut self.states);
        let time = self.time;
        assert!(
            update.changes_states || before == self.states,
            "states change without notice by an update at {time} s"
        );
        for (number, indicator) in self.indicators().into_iter().enumerate() {
            assert!(indicator > 0.0, "event indicator {number} is {indicator} after an update at {time} s");
        }
        let again = self.model.update().expect("an update");
        assert!(!again.changes_states, "a second update at {time} s changes states");
        self.next_time_event = again.next_time_event.unwrap_or(f64::INFINITY);
        assert!(
            self.next_time_event > time,
            "the next time event is at {} s, not after {time} s",
            self.next_time_event
        );
    }

    /// Puts the model at a point.
    fn go(&mut self, time: f64, states: &[f64]) {
        (self.course)(time, &mut self.u);
        self.model.set_time(time);
        self.model.set_inputs(&self.u);
        self.model.set_states(states);
    }

    /// The end of a step from the present point, and its error relative to the tolerance.
    fn attempt(&mut self, h: f64) -> Option<(Vec<f64>, f64)> {
        let (start, x) = (self.time, self.states.clone());
        let mut rates = vec![vec![0.0; x.len()]; 7];
        let mut end = x.clone();
        for stage in 0..7 {
            for i in 0..x.len() {
                end[i] = x[i] + h * (0..stage).map(|j| STAGES[stage][j] * rates[j][i]).sum::<f64>();
            }
            self.go(start + TIMES[stage] * h, &end);
            self.model.rates(&mut rates[stage]).ok()?;
        }
        let mut norm = 0.0f64;
        for i in 0..x.len() {
            let error = h * (0..7).map(|j| ERRORS[j] * rates[j][i]).sum::<f64>();
            let relative = error.abs() / self.nominals[i].max(x[i].abs());
            assert!(!relative.is_nan(), "state {i} at {start} s: {relative}");
            norm = norm.max(relative);
        }
        Some((end, norm / self.tolerance))
    }

    /// The smallest indicator at the end of a step, and that end.
    fn smallest(&mut self, h: f64) -> (f64, Vec<f64>) {
        let (end, _) = self.attempt(h).expect("a part of a step that is possible");
        self.go(self.time + h, &end);
        let indicators = self.indicators();
        assert!(!indicators.iter().any(|z| z.is_nan()), "{indicators:?}");
        (indicators.into_iter().fold(f64::INFINITY, f64::min), end)
    }

    /// Integrates to a time in s; inputs have a kink at most there.
    ///
    /// # Panics
    /// When no importer could follow the model: an indicator that is not positive after an update, a change that is not
    /// announced, a rate that is not a number, a time event that is past, an update that fails.
    pub fn advance(&mut self, end: f64) {
        while self.time < end {
            let limit = end.min(self.next_time_event);
            let h = self.step.min(limit - self.time);
            let target = if h == limit - self.time { limit } else { self.time + h };
            let Some((states, error)) = self.attempt(h).filter(|(_, error)| *error <= 1.0) else {
                self.step = 0.3 * h;
                assert!(self.step > 1e-14, "the step vanishes at {}", self.time);
                continue;
            };
            self.go(target, &states);
            if self.indicators().iter().any(|z| *z <= 0.0) {
                self.locate(h);
                continue;
            }
            (self.time, self.states) = (target, states);
            self.model.accept_step().expect("a state with a meaning");
            let best = h * (0.9 * error.max(1e-4).powf(-0.2)).min(4.0);
            // A step that was cut short says little about the next one.
            self.step = if h < self.step { self.step.max(best) } else { best };
            if self.time == self.next_time_event {
                self.update();
            }
        }
    }

    /// Moves just behind the first event within a step, found by false position and bisection in turn, and updates.
    fn locate(&mut self, h: f64) {
        let (mut low, mut high) = ((0.0, self.smallest(0.0).0), (h, self.smallest(h).0));
        let resolution = 1e-13 * (1.0 + self.time);
        for count in 0.. {
            if high.0 - low.0 <= resolution {
                break;
            }
            let chord = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1) + 0.4 * resolution;
            let middle = 0.5 * (low.0 + high.0);
            let at = if count % 2 == 0 && chord > low.0 && chord < high.0 { chord } else { middle };
            let value = self.smallest(at).0;
            *(if value > 0.0 { &mut low } else { &mut high }) = (at, value);
        }
        let (_, states) = self.smallest(high.0);
        (self.time, self.states) = (self.time + high.0, states);
        self.model.accept_step().expect("a state with a meaning");
        self.update();
    }
}
