//! Searches and intervals on problems whose answers are known.

use std::cell::Cell;

use pneumatic_servo::numbers::random;
use pneumatic_servo_fit::intervals::{Ends, bootstrap, certainty, hidden, linearised};
use pneumatic_servo_fit::parameter::{Parameter, Values};
use pneumatic_servo_fit::problem::{Interrupted, Problem, STEP, Segment, Simulated};
use pneumatic_servo_fit::search::{FINE, Loss, ROUGH, Unwatched, Watch, refine, scattered, solve, with_likely_sensors};
use pneumatic_servo_fit::sensor::Sensor;

const NOISE: f64 = 0.01;

/// A function of time and parameters against samples of it; the vector holds the parameters, and for each
/// segment a start value that is added to the function.
struct Curve<F> {
    of: F,
    time: Vec<f64>,
    measured: Vec<Vec<f64>>,
    parameters: Vec<Parameter>,
}

impl<F: Fn(f64, &[f64]) -> f64> Simulated for Curve<F> {
    fn differences(&self, vectors: &[Vec<f64>], _: f64) -> Result<Vec<Vec<f64>>, Interrupted> {
        let one = |x: &Vec<f64>| {
            let count = self.parameters.len();
            let values: Vec<f64> = self.parameters.iter().zip(x).map(|(one, x)| one.outer(*x)).collect();
            let of_segment = |(segment, measured): (usize, &Vec<f64>)| -> Vec<f64> {
                let begin = x.get(count + segment).copied().unwrap_or(0.0);
                self.time.iter().zip(measured).map(|(time, y)| y - begin - (self.of)(*time, &values)).collect()
            };
            self.measured.iter().enumerate().flat_map(of_segment).collect()
        };
        Ok(vectors.iter().map(one).collect())
    }
}

impl<F: Fn(f64, &[f64]) -> f64> Curve<F> {
    /// Noisy samples of the function, with a start value for each segment.
    fn new(of: F, parameters: &[Parameter], truth: &[f64], begins: &[f64], seed: u64) -> Self {
        let mut state = seed;
        let time: Vec<f64> = (0..200).map(|k| 0.02 * f64::from(k)).collect();
        let mut noisy = |begin: &f64| {
            time.iter().map(|t| of(*t, truth) + begin + NOISE * random::normal(&mut state)).collect::<Vec<f64>>()
        };
        let measured = begins.iter().map(&mut noisy).collect();
        Self { of, time, measured, parameters: parameters.to_vec() }
    }

    fn problem(&self, begins: usize) -> Problem<'_> {
        let segment = |record| Segment { samples: self.time.len(), begins, record };
        Problem {
            parameters: self.parameters.clone(),
            segments: (0..self.measured.len()).map(segment).collect(),
            sensors: vec![Sensor { noise: NOISE, step: 0.0, is_coarse: false }],
            simulated: self,
            step: STEP,
        }
    }
}

fn parameter(name: &str, start: f64, bounds: [f64; 2]) -> Parameter {
    Parameter {
        name: name.to_owned(),
        unit: "1".to_owned(),
        start,
        bounds,
        scale: 0.0,
        is_given: false,
        is_bounded: false,
        legal: [0.0, f64::INFINITY],
    }
}

fn linear(name: &str, start: f64) -> Parameter {
    let none = [f64::NEG_INFINITY, f64::INFINITY];
    Parameter { scale: 1.0, bounds: none, legal: none, ..parameter(name, start, none) }
}

fn decay(time: f64, values: &[f64]) -> f64 {
    values[0] * libm::exp(-values[1] * time)
}

/// Coverage of 95 % intervals: of 100 repetitions the truth lies within in 88 to 100 (three standard deviations and more).
#[test]
fn intervals_hold_the_truth_as_often_as_they_promise() {
    let parameters = [parameter("size", 1.0, [1e-3, 1e3]), parameter("rate", 3.0, [3e-3, 3e3])];
    let mut inside = [[0; 2]; 2];
    for seed in 0..100 {
        let curve = Curve::new(decay, &parameters, &[2.0, 0.7], &[0.3, -0.2, 0.1], seed);
        let problem = curve.problem(1);
        let found = solve(&problem, 8, 0, Loss::Linear, &Unwatched).expect("nobody interrupts");
        let (problem, found) =
            with_likely_sensors(problem, found, Loss::Linear, &Unwatched).expect("nobody interrupts");
        assert!(found.converged, "{}", found.message);
        let ends = bootstrap(&linearised(&problem, &found.x).expect("nobody interrupts"), &found.x, 1, 200);
        let ends = ends.iter().zip(&parameters).map(|(ends, one)| ends.map(|end| one.outer(end)));
        let sure = certainty(&problem, &found.x, Ends::Jacobian).expect("nobody interrupts");
        assert!(sure.reasons.iter().all(Option::is_none), "{:?}", sure.reasons);
        for (place, (jacobian, bootstrap)) in sure.intervals.iter().zip(ends).enumerate() {
            let truth = [2.0, 0.7][place];
            for (method, [low, high]) in [*jacobian, bootstrap].into_iter().enumerate() {
                inside[method][place] += i32::from(low <= truth && truth <= high);
            }
        }
    }
    assert!(inside[0].iter().all(|count| (88..=100).contains(count)), "{inside:?}");
    assert!(inside[1].iter().all(|count| *count >= 80), "bootstrap, of few blocks: {inside:?}");
}

/// The projected columns of the parameters are the residuals of their regression on the columns of the start values: orthogonal to
/// these, and what a regression on both kinds finds is what one on the projected columns alone finds.
#[test]
fn start_values_are_taken_out_of_the_derivatives() {
    let parameters = [linear("slope", 1.0), linear("bend", 0.5)];
    let line = |time: f64, values: &[f64]| values[0] * time + values[1] * time * time;
    let curve = Curve::new(line, &parameters, &[2.0, 0.7], &[0.3, -0.2], 5);
    let found = linearised(&curve.problem(1), &[1.0, 0.5, 0.0, 0.0]).expect("nobody interrupts");
    let count = curve.time.len();
    assert_eq!(found.derivatives.shape(), (2 * count, 2));
    for (place, column) in found.derivatives.column_iter().enumerate() {
        let of: Vec<f64> = curve.time.iter().map(|time| time.powi(place as i32 + 1)).collect();
        let mean = of.iter().sum::<f64>() / count as f64;
        for (row, slope) in column.iter().enumerate() {
            // A start value is a constant over its segment.
            let expected = (mean - of[row % count]) / NOISE;
            assert!((slope - expected).abs() < 1e-6 / NOISE, "{slope} at row {row}, not {expected}");
        }
    }
    assert_eq!(found.scores.len(), 2 * count);
    assert_eq!(found.records, [vec![0; count], vec![1; count]].concat());
}

#[test]
fn a_bound_holds_and_is_named() {
    let parameters = [parameter("size", 1.0, [1e-3, 1.5]), parameter("rate", 3.0, [3e-3, 3e3])];
    let curve = Curve::new(decay, &parameters, &[2.0, 0.7], &[0.0], 1);
    let problem = curve.problem(0);
    let found = refine(&problem, &problem.start(), Loss::Linear, FINE, &Unwatched).expect("nobody interrupts");
    assert!(parameters[0].outer(found.x[0]) <= 1.5);
    let sure = certainty(&problem, &found.x, Ends::Jacobian).expect("nobody interrupts");
    assert_eq!(sure.reasons, [Some("it is at a bound"), None]);
}

#[test]
fn parameters_that_only_act_together_are_not_identifiable() {
    let product = |time: f64, values: &[f64]| values[0] * values[1] * time + values[2];
    let parameters = [parameter("a", 1.0, [1e-3, 1e3]), parameter("b", 1.0, [1e-3, 1e3]), linear("c", 0.0)];
    let curve = Curve::new(product, &parameters, &[2.0, 3.0, 1.0], &[0.0], 1);
    let problem = curve.problem(0);
    let found = solve(&problem, 4, 0, Loss::Linear, &Unwatched).expect("nobody interrupts");
    let sure = certainty(&problem, &found.x, Ends::Jacobian).expect("nobody interrupts");
    let is_named: Vec<bool> = sure.reasons.iter().map(Option::is_some).collect();
    assert_eq!(is_named, [true, true, false]);
    assert_eq!(hidden(&problem).expect("nobody interrupts"), sure.reasons);
    assert!((found.x[0] + found.x[1] - libm::log(6.0)).abs() < 1e-2, "their product is told");
}

/// A frequency has a valley for each number of periods; the first start is in a wrong one.
#[test]
fn another_start_leaves_a_local_minimum() {
    let wave = |time: f64, values: &[f64]| libm::sin(values[0] * time);
    let parameters = [parameter("frequency", 2.0, [0.5, 20.0])];
    let curve = Curve::new(wave, &parameters, &[7.0], &[0.0], 1);
    let problem = curve.problem(0);
    let alone = solve(&problem, 0, 0, Loss::Linear, &Unwatched).expect("nobody interrupts");
    assert!((parameters[0].outer(alone.x[0]) - 7.0).abs() > 1.0, "the first start leads there by itself");
    let found = solve(&problem, 32, 0, Loss::Linear, &Unwatched).expect("nobody interrupts");
    assert!((parameters[0].outer(found.x[0]) - 7.0).abs() < 0.01, "{found:?}");
    assert_eq!(scattered(&problem, 32, 5), scattered(&problem, 32, 5));
    assert_ne!(scattered(&problem, 32, 5), scattered(&problem, 32, 6));
}

#[test]
fn robust_losses_do_not_follow_outliers() {
    let line = |time: f64, values: &[f64]| values[0] * time + values[1];
    let parameters = [linear("slope", 0.0), linear("zero", 0.0)];
    let mut curve = Curve::new(line, &parameters, &[2.0, 1.0], &[0.0], 1);
    curve.measured[0].iter_mut().step_by(10).for_each(|value| *value += 5.0);
    let problem = curve.problem(0);
    let zero = |loss| {
        let found = refine(&problem, &problem.start(), loss, FINE, &Unwatched).expect("nobody interrupts");
        assert!(found.converged, "{loss:?}: {}", found.message);
        found.x[1]
    };
    assert!((zero(Loss::Linear) - 1.5).abs() < 0.1);
    for loss in [Loss::SoftL1, Loss::Huber, Loss::Cauchy] {
        assert!((zero(loss) - 1.0).abs() < 0.02, "{loss:?}: {}", zero(loss));
    }
}

/// A run that fails is worse than any other, and the side that does not fail gives the derivative.
#[test]
fn a_refused_side_is_left() {
    let refused = |time: f64, values: &[f64]| if values[0] > 1.0 { f64::NAN } else { values[0] * time };
    let parameters = [linear("slope", 1.0)];
    let curve = Curve::new(refused, &parameters, &[0.999_5], &[0.0], 1);
    let problem = curve.problem(0);
    let found = refine(&problem, &problem.start(), Loss::Linear, FINE, &Unwatched).expect("nobody interrupts");
    assert!((found.x[0] - 0.999_5).abs() < 2e-3, "{found:?}");
}

#[test]
fn an_interrupt_ends_a_search() {
    struct Impatient(Cell<usize>);
    impl Watch for Impatient {
        fn see(&self, _: &[f64], _: &Values, _: f64) -> Result<(), Interrupted> {
            self.0.set(self.0.get() + 1);
            if self.0.get() > 2 { Err(Interrupted) } else { Ok(()) }
        }
    }
    let parameters = [parameter("size", 1.0, [1e-3, 1e3]), parameter("rate", 3.0, [3e-3, 3e3])];
    let curve = Curve::new(decay, &parameters, &[2.0, 0.7], &[0.0], 1);
    let watch = Impatient(Cell::new(0));
    assert_eq!(solve(&curve.problem(0), 4, 0, Loss::Linear, &watch), Err(Interrupted));
    assert_eq!(watch.0.get(), 3);
}

/// The first step from 0 is one of a magnitude, however small the noise.
#[test]
fn a_start_at_zero_is_left() {
    let parameters = [linear("slope", 0.0), linear("zero", 0.0)];
    let line = |time: f64, values: &[f64]| 1e3 * (values[0] * time + values[1]);
    let curve = Curve::new(line, &parameters, &[2.0, 40.0], &[0.0], 1);
    let problem = curve.problem(0);
    for effort in [ROUGH, FINE] {
        let found = refine(&problem, &problem.start(), Loss::Linear, effort, &Unwatched).expect("nobody interrupts");
        assert!(found.converged && (found.x[1] - 40.0).abs() < 1e-4, "{found:?}");
    }
}

/// The solver moves a start off its bound before the first step: that ends no search.
#[test]
fn a_start_at_a_bound_is_searched_from() {
    let parameters = [Parameter { bounds: [0.0, 10.0], ..linear("slope", 0.0) }];
    for truth in [0.0, 3.0] {
        let curve = Curve::new(|time: f64, values: &[f64]| values[0] * time, &parameters, &[truth], &[0.0], 1);
        let problem = curve.problem(0);
        let found = refine(&problem, &problem.start(), Loss::Linear, ROUGH, &Unwatched).expect("nobody interrupts");
        assert!((found.x[0] - truth).abs() < 0.01, "{found:?}");
    }
}

/// A valley that winds: each step leads a little farther along it, and the end is far away.
#[test]
fn a_rough_search_gives_up_where_steps_gain_little() {
    let winding = |time: f64, values: &[f64]| {
        if time < 2.0 { 1e3 * (values[1] - libm::sin(20.0 * values[0])) } else { values[0] }
    };
    let parameters = [linear("along", 0.0), linear("across", 0.0)];
    let curve = Curve::new(winding, &parameters, &[10.0, libm::sin(200.0)], &[0.0], 1);
    let problem = curve.problem(0);
    let found = refine(&problem, &problem.start(), Loss::Linear, ROUGH, &Unwatched).expect("nobody interrupts");
    assert!(!found.converged && found.message.contains("have gained little"), "{found:?}");
    assert!((0.0..9.0).contains(&found.x[0]), "{found:?}");
}
