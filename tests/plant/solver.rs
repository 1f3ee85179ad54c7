//! The hybrid solver on problems with closed solutions, none of which is a cylinder.

use std::cell::Cell;
use std::f64::consts::PI;

use crate::bounds::close;
use crate::problem::{self, problem};
use pneumatic_servo::numbers::{Real, Scalar, Varying};
use pneumatic_servo::solver::{Run, Scheme, Settings, StepError};
use pneumatic_servo::system::{Hints, LongestSteps, StateIndex, System, UNUSED};

const ADAPTIVE: Settings =
    Settings { scheme: Scheme::Adaptive, tolerance: 1e-8, step: 1e-3, max_steps: 100_000, keeps_balance: false };

/// `x'' = -x`, with a motion around the unit circle; counts its evaluations.
#[derive(Clone)]
struct Oscillator {
    is_non_stiff: bool,
    evaluations: Cell<u32>,
}

impl Oscillator {
    fn new(is_non_stiff: bool) -> Self {
        Self { is_non_stiff, evaluations: Cell::new(0) }
    }
}

impl System<1> for Oscillator {
    problem!();
    type Memory<S: Varying> = ();
    type Indicators<S: Varying> = [S; 0];
    fn derivatives<S: Scalar, const N: usize>(&self, _time: S, x: &[S; N], _u: &[S; 1], _memory: &()) -> [S; N] {
        self.evaluations.update(|count| count + 1);
        problem::all([x[1], -x[0]])
    }
    fn hints<S: Varying, const N: usize>(&self, _: &[S; N], _: &Self::Memory<S>) -> Hints {
        Hints { explicit: self.is_non_stiff.then_some(LongestSteps::UNLIMITED), ..Hints::default() }
    }
}

/// The same motion, and a state that comes closer to its position at a rate of 1e4: `z' = 1e4*(x - z)`.
#[derive(Clone)]
struct Follower(Oscillator);

const FOLLOWING: f64 = 1e4;

impl System<1> for Follower {
    problem!();
    type Memory<S: Varying> = ();
    type Indicators<S: Varying> = [S; 0];
    const RELAXING: Option<StateIndex> = Some(StateIndex::Back(0));
    fn states(&self) -> usize {
        3
    }
    fn derivatives<S: Scalar, const N: usize>(&self, time: S, x: &[S; N], u: &[S; 1], (): &()) -> [S; N] {
        let [rate, acceleration] = self.0.derivatives(time, &[x[0], x[1]], u, &());
        problem::all([rate, acceleration, (x[0] - x[2]) * FOLLOWING])
    }
    fn hints<S: Varying, const N: usize>(&self, _: &[S; N], _: &Self::Memory<S>) -> Hints {
        Hints { explicit: Some(LongestSteps::UNLIMITED), ..Hints::default() }
    }
    fn relaxation_rate<S: Varying, const N: usize>(&self, _: S, _: &[S; N], _: &[S; N], _: &[S; 1], (): &()) -> f64 {
        FOLLOWING
    }
}

/// A mass between two springs, `x'' = -x` for `x > 0` and `x'' = -4*x` for `x < 0`: half a period of pi and one of pi/2.
#[derive(Clone)]
struct TwoSprings;

impl System<1> for TwoSprings {
    problem!();
    type Memory<S: Varying> = ();
    type Indicators<S: Varying> = [S; 0];
    fn derivatives<S: Scalar, const N: usize>(&self, _time: S, x: &[S; N], _u: &[S; 1], _memory: &()) -> [S; N] {
        problem::all([x[1], if x[0].value() > 0.0 { -x[0] } else { -x[0] * 4.0 }])
    }
    fn hints<S: Varying, const N: usize>(&self, _: &[S; N], _: &Self::Memory<S>) -> Hints {
        Hints { explicit: Some(LongestSteps::UNLIMITED), ..Hints::default() }
    }
    fn is_smooth<S: Varying, const N: usize>(
        &self,
        [x, end]: [&[f64; N]; 2],
        _: [&[f64; 1]; 2],
        (): &(),
        _: f64,
    ) -> bool {
        (x[0] > 0.0) == (end[0] > 0.0)
    }
}

/// `x' = -rate*(x - cos(t)) - sin(t)`: the solution `cos(t)` hides the stiffness (Prothero, Robinson, 1974).
#[derive(Clone)]
struct Stiff {
    rate: f64,
    /// Whether it claims to be non-stiff.
    is_non_stiff: bool,
}

impl System<1> for Stiff {
    problem!();
    type Memory<S: Varying> = ();
    type Indicators<S: Varying> = [S; 0];
    fn derivatives<S: Scalar, const N: usize>(&self, time: S, x: &[S; N], _u: &[S; 1], _memory: &()) -> [S; N] {
        problem::all([-(x[0] - time.cos()) * self.rate - time.sin()])
    }
    fn depends_on_time(&self) -> bool {
        true
    }
    fn hints<S: Varying, const N: usize>(&self, _: &[S; N], _: &Self::Memory<S>) -> Hints {
        Hints { explicit: self.is_non_stiff.then_some(LongestSteps::UNLIMITED), ..Hints::default() }
    }
}

/// A ball that falls with unit acceleration and bounces with a coefficient of restitution; remembers the impacts.
#[derive(Clone)]
struct Ball {
    restitution: f64,
}

impl System<1> for Ball {
    problem!();
    type Memory<S: Varying> = Vec<S>;
    type Indicators<S: Varying> = [S; 1];
    fn derivatives<S: Scalar, const N: usize>(
        &self,
        _time: S,
        x: &[S; N],
        _u: &[S; 1],
        _memory: &Vec<S::Held>,
    ) -> [S; N] {
        problem::all([x[1], S::constant(-1.0)])
    }
    fn indicators<S: Varying, const N: usize>(&self, _: S, x: &[S; N], _: &[S; 1], _: &Vec<S>) -> [S; 1] {
        [x[0]]
    }
    fn switch<S: Varying, const N: usize>(&self, _: usize, time: S, x: &mut [S; N], _: &[S; 1], memory: &mut Vec<S>) {
        *x = problem::all([S::zero(), -x[1] * self.restitution]);
        memory.push(time);
    }
}

fn oscillator_error(settings: Settings, end: f64) -> f64 {
    let mut run = problem::run(Oscillator::new(false), settings, [1.0, 0.0], (), 0.0);
    run.advance(end).unwrap();
    let x = problem::states(&run);
    (x[0] - end.cos()).hypot(x[1] + end.sin())
}

/// Halving the step divides the error by 2 to the power of the order, within a fifth for the terms of higher order.
#[test]
fn fixed_step_schemes_have_their_order() {
    for (scheme, order, step) in [
        (Scheme::ExplicitEuler, 1, 1e-3),
        (Scheme::ImplicitEuler, 1, 1e-3),
        (Scheme::RK3, 3, 0.02),
        (Scheme::RK4, 4, 0.05),
    ] {
        let error = |step: f64| oscillator_error(Settings { scheme, step, ..ADAPTIVE }, 2.0);
        let ratio = error(step) / error(step / 2.0);
        let expected = f64::from(1 << order);
        close(ratio / expected, 1.0, 2e-3, format_args!("{scheme:?}: {ratio}, not {expected}"));
    }
}

/// The error after 10 s stays within ten times the tolerance per step, at any tolerance: steps are about 0.1 to 1 s.
#[test]
fn adaptive_scheme_keeps_the_tolerance() {
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
        let error = oscillator_error(Settings { tolerance, ..ADAPTIVE }, 10.0);
        assert!(error < 100.0 * tolerance, "{error} at {tolerance}");
    }
}

/// A method of order 4 with an error estimate of order 3 needs `10^(1/4)` times the steps per decade of tolerance.
#[test]
fn work_grows_with_the_fourth_root_of_the_tolerance() {
    let steps = |tolerance: f64| {
        let mut run = problem::run(Oscillator::new(false), Settings { tolerance, ..ADAPTIVE }, [1.0, 0.0], (), 0.0);
        run.advance(100.0).unwrap();
        run.counters().steps as f64
    };
    let growth = steps(1e-11) / steps(1e-7);
    close(growth / 10.0, 1.0, 0.02, format_args!("{growth}, not 10"));
}

/// Stiffness far beyond the step size costs neither accuracy nor steps: a million times stiffer, the same work.
#[test]
fn stiffness_does_not_limit_the_step() {
    let run = |rate: f64| {
        let mut run = problem::run(Stiff { rate, is_non_stiff: false }, ADAPTIVE, [1.0], (), 0.0);
        run.advance(10.0).unwrap();
        let x = problem::states(&run);
        ((x[0] - 10.0f64.cos()).abs(), run.counters().steps)
    };
    let (mild_error, mild_steps) = run(1e2);
    let (stiff_error, stiff_steps) = run(1e8);
    assert!(mild_error < 1e-7 && stiff_error < 1e-7, "{mild_error}, {stiff_error}");
    assert!(stiff_steps < 2 * mild_steps, "{stiff_steps} steps, {mild_steps} for the mild problem");
}

/// Non-stiff equations are solved without Jacobians, and as accurately.
#[test]
fn non_stiff_equations_need_no_jacobian() {
    for tolerance in [1e-3, 1e-4, 1e-5, 1e-6] {
        let settings = Settings { tolerance, ..ADAPTIVE };
        let mut run = problem::run(Oscillator::new(true), settings, [1.0, 0.0], (), 0.0);
        for point in 1..=100 {
            run.advance(0.1 * f64::from(point)).unwrap();
        }
        let x = problem::states(&run);
        let error = (x[0] - 10.0f64.cos()).hypot(x[1] + 10.0f64.sin());
        assert!(error < 100.0 * tolerance, "{error} at {tolerance}");
        assert_eq!(run.counters().jacobians, 0, "{:?} at {tolerance}", run.counters());
    }
}

/// Steps of 0.02, which the midpoint rule takes with two evaluations where the tolerance allows an error of some 1e-6 in
/// each, the classical method with four; and one more since communication points begin anew. Its error over 10 s is
/// `10*h^2/6`: 6.7e-4.
#[test]
fn loose_tolerance_spares_evaluations_in_short_steps() {
    for (tolerance, each, error) in [(1e-5, 5, 1e-6), (1e-4, 3, 7e-4)] {
        let mut run = problem::run(Oscillator::new(true), Settings { tolerance, ..ADAPTIVE }, [1.0, 0.0], (), 0.0);
        let mut before = 0;
        for point in 1..=500 {
            // The classical method begins with short steps.
            before = if point == 10 { run.system().evaluations.get() } else { before };
            run.advance(0.02 * f64::from(point)).unwrap();
        }
        let x = problem::states(&run);
        let found = (x[0] - 10.0f64.cos()).hypot(x[1] + 10.0f64.sin());
        assert!(found < error, "{found} at {tolerance}");
        assert_eq!(run.system().evaluations.get() - before, 491 * each, "at {tolerance}");
    }
}

/// A state that relaxes a hundred times within a step takes no more evaluations, and is nearly as accurate as what it follows,
/// which with half the evaluations is `10*h^2/6`: it lags by its time constant, `z = cos(t) + sin(t)/r` but for the square of
/// that, and what it does within a step bends by `h^2/4`.
#[test]
fn state_that_relaxes_within_a_step_costs_nothing() {
    for (tolerance, each, error) in [(1e-5, 5, 2e-6), (1e-4, 3, 1.9e-4)] {
        let start = [1.0, 0.0, 1.0];
        let mut run = problem::run(Follower(Oscillator::new(true)), Settings { tolerance, ..ADAPTIVE }, start, (), 0.0);
        let (mut before, evaluations) = (0, |run: &Run<Follower, 3, 1>| run.system().0.evaluations.get());
        for point in 1..=1000 {
            before = if point == 10 { evaluations(&run) } else { before };
            run.advance(0.01 * f64::from(point)).unwrap();
        }
        let x = problem::states(&run);
        let found = (x[2] - 10.0f64.cos() - 10.0f64.sin() / FOLLOWING).abs();
        assert!(found < error, "{found} at {tolerance}");
        assert_eq!(evaluations(&run) - before, 991 * each, "at {tolerance}");
        assert_eq!(run.counters().jacobians, 0, "at {tolerance}");
    }
}

/// Where steps are too long for it, the midpoint rule is tried now and then: in one communication step of seven or so.
#[test]
fn midpoint_rule_leaves_long_steps_to_the_classical_method() {
    let settings = Settings { tolerance: 1e-4, ..ADAPTIVE };
    let mut run = problem::run(Oscillator::new(true), settings, [1.0, 0.0], (), 0.0);
    for point in 1..=500 {
        run.advance(0.2 * f64::from(point)).unwrap();
    }
    let x = problem::states(&run);
    let error = (x[0] - 100.0f64.cos()).hypot(x[1] + 100.0f64.sin());
    assert!(error < 0.01, "{error}, more than the tolerance of 1e-4 for each of 100 s");
    assert!(run.counters().rejected <= 75, "{:?}", run.counters());
}

/// Each of the 200 kinks may cost two steps that are not accepted: one that meets it, and one that finds it again. So may
/// each try of the implicit method.
#[test]
fn steps_end_on_kinks() {
    let mut run = problem::run(TwoSprings, ADAPTIVE, [0.0, 1.0], (), 0.0);
    for period in 1..=100 {
        run.advance(f64::from(period) * 1.5 * PI).expect("a smooth motion");
    }
    let [x, v] = problem::states(&run);
    // A hundred times the tolerance of a step, in some twenty steps a period.
    close(x, 0.0, 1e-6, "x");
    close(v, 1.0, 1e-6, "v");
    let counters = run.counters();
    assert!(counters.rejected <= 400 + counters.jacobians, "{counters:?}");
}

/// At loose tolerances the midpoint rule takes the way to a kink, and that behind it: of the 20 kinks each costs one step that
/// is not accepted, and one more that is.
#[test]
fn midpoint_rule_ends_on_kinks_itself() {
    let mut run = problem::run(TwoSprings, Settings { tolerance: 1e-4, ..ADAPTIVE }, [0.0, 1.0], (), 0.0);
    let points = 2350_u32;
    for point in 1..=points {
        run.advance(0.02 * f64::from(point)).expect("a smooth motion");
    }
    let [x, v] = problem::states(&run);
    let rest = 15.0 * PI - 0.02 * f64::from(points);
    let [exact_x, exact_v] = [-0.5 * (2.0 * rest).sin(), (2.0 * rest).cos()];
    // The phase of the faster half lags by `(2*h)^2/6` of its angle, 31 rad in all; the slower half's lags by a quarter.
    assert!((x - exact_x).hypot(v - exact_v) < 0.012, "{x} and {v}, not {exact_x} and {exact_v}");
    let counters = run.counters();
    assert!(counters.rejected <= 20 && counters.steps <= u64::from(points) + 20, "{counters:?}");
}

/// An explicit method is stable up to steps of some 3 us here, which would take 350 000 of them: the implicit one takes
/// over after a few. It sees only steps that it must shorten a million times, so that a hundred per call are many.
#[test]
fn stiffness_where_none_was_said_to_be_costs_some_steps_and_no_accuracy() {
    let settings = Settings { tolerance: 1e-5, ..ADAPTIVE };
    let mut run = problem::run(Stiff { rate: 1e6, is_non_stiff: true }, settings, [1.0], (), 0.0);
    for point in 1..=10 {
        run.advance(0.1 * f64::from(point)).unwrap();
    }
    let (x, counters) = (problem::states(&run), run.counters());
    close(x[0], 1.0f64.cos(), 2e-9, format_args!("{}", x[0]));
    assert!(counters.jacobians > 0 && counters.steps + counters.rejected < 1000, "{counters:?}");
}

/// Dropped from 1/2 m, the ball lands at 1 s and bounces for 2 e, 2 e^2, ... seconds.
#[test]
fn impacts_are_located_to_rounding() {
    let mut run = problem::run(Ball { restitution: 0.8 }, ADAPTIVE, [0.5, 0.0], Vec::new(), 0.0);
    run.advance(6.0).unwrap();
    let (_, impacts) = run.state();
    let mut expected = 1.0;
    for (index, impact) in impacts.iter().enumerate() {
        close(impact.value, expected, 5e-11, format_args!("impact {index}"));
        expected += 2.0 * 0.8f64.powi(index as i32 + 1);
    }
    assert!(expected > 6.0, "an impact is missing: {impacts:?}");
}

/// Communication points between and at the impacts change nothing.
#[test]
fn communication_points_do_not_matter() {
    let impacts = |interval: f64| {
        let mut run = problem::run(Ball { restitution: 0.8 }, ADAPTIVE, [0.5, 0.0], Vec::new(), 0.0);
        for step in 1..=(4.0 / interval).round() as usize {
            run.advance(step as f64 * interval).unwrap();
        }
        run.state().1.clone()
    };
    let (coarse, fine) = (impacts(0.5), impacts(1e-3));
    assert_eq!(coarse.len(), fine.len());
    assert!(coarse.iter().zip(&fine).all(|(a, b)| (*a - *b).abs().value < 1e-10));
}

/// The integral of a ramp is a parabola, which the method reproduces to rounding.
#[test]
fn inputs_with_a_slope_are_integrated_exactly() {
    let mut run = problem::run(Vessel, ADAPTIVE, [0.0], (), 0.0);
    run.set_inputs([Real::of(0.1)], [0.2]);
    run.advance(2.0).unwrap();
    close(run.state().0[0].value, 0.6, 1e-14, "inputs with a slope are integrated exactly");
    close(run.inputs().0[0].value, 0.5, 1e-15, "inputs with a slope are integrated exactly");
}

/// The derivatives of `cos(t)`, towards which the solution comes at a rate of 1, are taken at the time of each stage, by the
/// midpoint rule and by the classical method.
#[test]
fn explicit_stages_know_their_time() {
    for tolerance in [1e-3, 1e-6] {
        let settings = Settings { tolerance, ..ADAPTIVE };
        let mut run = problem::run(Stiff { rate: 1.0, is_non_stiff: true }, settings, [1.0], (), 0.0);
        for point in 1..=100 {
            run.advance(0.1 * f64::from(point)).unwrap();
        }
        let error = (run.state().0[0].value - 10.0f64.cos()).abs();
        // The error of a step of 0.1 decays before ten others have been made.
        assert!(error < 10.0 * tolerance, "{error} at {tolerance}");
        assert_eq!(run.counters().jacobians, 0, "{:?} at {tolerance}", run.counters());
    }
}

#[test]
fn work_within_one_call_is_bounded() {
    let mut run = problem::run(Oscillator::new(false), Settings { max_steps: 10, ..ADAPTIVE }, [1.0, 0.0], (), 0.0);
    let StepError::TooManySteps { time, limit: 10, .. } = run.advance(100.0).unwrap_err() else {
        panic!("another error")
    };
    assert!(time > 0.0 && time < 100.0 && time == run.time());
}

#[test]
fn an_explicit_scheme_beyond_its_stability_is_an_error() {
    let settings = Settings { scheme: Scheme::ExplicitEuler, step: 0.1, ..ADAPTIVE };
    let mut run = problem::run(Stiff { rate: 1e6, is_non_stiff: false }, settings, [2.0], (), 0.0);
    let error = run.advance(100.0).unwrap_err();
    let StepError::Diverged { step, .. } = error else { panic!("{error}") };
    close(step, 0.1, 1e-15, "an explicit scheme beyond its stability is an error");
    assert!(error.to_string().contains("diverges: the magnitude of an internal state goes beyond"), "{error}");
}

/// `x' = 1e16*(t - 0.9995e-3)^2` from the time in the brackets on, an event that begins half a microsecond before a communication
/// point; 0 before.
#[derive(Clone)]
struct Surge;

const SURGE: f64 = 0.9995e-3;

impl System<1> for Surge {
    problem!();
    type Memory<S: Varying> = bool;
    type Indicators<S: Varying> = [S; 1];
    fn derivatives<S: Scalar, const N: usize>(&self, time: S, _x: &[S; N], _u: &[S; 1], surges: &bool) -> [S; N] {
        let since = time - SURGE;
        problem::all([if *surges { since * since * 1e16 } else { S::constant(0.0) }])
    }
    fn indicators<S: Varying, const N: usize>(&self, time: S, _: &[S; N], _: &[S; 1], surges: &bool) -> [S; 1] {
        [if *surges { S::constant(1.0) } else { -time + SURGE }]
    }
    fn switch<S: Varying, const N: usize>(&self, _: usize, _: S, _: &mut [S; N], _: &[S; 1], surges: &mut bool) {
        *surges = true;
    }
    fn depends_on_time(&self) -> bool {
        true
    }
    fn hints<S: Varying, const N: usize>(&self, _: &[S; N], _: &Self::Memory<S>) -> Hints {
        Hints { explicit: Some(LongestSteps::UNLIMITED), ..Hints::default() }
    }
}

/// The rest is too much for one step of the midpoint rule, though it is shorter than any of its first steps: the classical
/// method takes it. `x = 1e16*(0.5e-6)^3/3` in the end.
#[test]
fn midpoint_rule_leaves_short_remainders_to_the_classical_method() {
    let mut run = problem::run(Surge, Settings { tolerance: 1e-4, ..ADAPTIVE }, [0.0], false, 0.0);
    run.advance(1e-3).unwrap();
    close(run.state().0[0].value, 1e16 * 0.125e-18 / 3.0, 1e-6, "what the surge brings");
}

/// A latch that an input of more than 1 sets, whose indicator stays as it is where no input is as much; remembers when it was set.
#[derive(Clone)]
struct Latch;

impl System<1> for Latch {
    problem!();
    type Memory<S: Varying> = Option<S>;
    type Indicators<S: Varying> = [S; 1];
    fn derivatives<S: Scalar, const N: usize>(
        &self,
        _time: S,
        _x: &[S; N],
        _u: &[S; 1],
        _: &Option<S::Held>,
    ) -> [S; N] {
        problem::all([S::constant(1.0)])
    }
    fn indicators<S: Varying, const N: usize>(&self, _: S, _: &[S; N], u: &[S; 1], set: &Option<S>) -> [S; 1] {
        [if set.is_some() { S::constant(1.0) } else { -u[0] + 1.0 }]
    }
    fn indicators_hold<S: Varying>(&self, inputs: [&[S; 1]; 2]) -> bool {
        inputs.iter().all(|u| u[0].value() < 1.0)
    }
    fn switch<S: Varying, const N: usize>(&self, _: usize, time: S, _: &mut [S; N], _: &[S; 1], set: &mut Option<S>) {
        *set = Some(time);
    }
}

/// The same inputs again, or other ones below the limit, do not hide that the next ones are above it.
#[test]
fn inputs_set_off_events_whichever_were_set_before() {
    for before in [vec![], vec![0.5], vec![0.6], vec![0.5, 0.5], vec![2.0, 0.5]] {
        let mut run = problem::run(Latch, ADAPTIVE, [0.0], None, 0.5);
        run.advance(1.0).unwrap();
        before.iter().for_each(|input| run.set_inputs([Real::of(*input)], [0.0]));
        run.set_inputs([Real::of(2.0)], [0.0]);
        run.advance(2.0).unwrap();
        assert_eq!(run.state().1, &Some(Real::of(1.0)), "after {before:?}");
    }
}

/// `x' = 1` and an event in a place of its own whenever `x` is a whole number, for the first forty.
#[derive(Clone)]
struct Steps;

const STEPS: usize = 40;

impl System<1> for Steps {
    problem!();
    /// The number of the events so far.
    type Memory<S: Varying> = usize;
    type Indicators<S: Varying> = [S; STEPS];
    fn derivatives<S: Scalar, const N: usize>(&self, _time: S, _x: &[S; N], _u: &[S; 1], _: &usize) -> [S; N] {
        problem::all([S::constant(1.0)])
    }
    fn indicators<S: Varying, const N: usize>(&self, _: S, x: &[S; N], _: &[S; 1], past: &usize) -> [S; STEPS] {
        let mut indicators = [S::constant(UNUSED); STEPS];
        if let Some(next) = indicators.get_mut(*past) {
            *next = -x[0] + (*past as f64 + 1.0);
        }
        indicators
    }
    fn switch<S: Varying, const N: usize>(&self, event: usize, _: S, _: &mut [S; N], _: &[S; 1], past: &mut usize) {
        assert_eq!(event, *past);
        *past += 1;
    }
}

/// More than the lengths of arrays that have a `Default`.
#[test]
fn system_may_have_forty_events() {
    let mut run = problem::run(Steps, ADAPTIVE, [0.0], 0, 0.0);
    run.advance(0.5 + STEPS as f64 / 2.0).unwrap();
    assert_eq!(run.state().1, &(STEPS / 2));
    run.advance(2.0 * STEPS as f64).unwrap();
    assert_eq!(run.state().1, &STEPS);
}

/// A system without conserved quantities has no account.
#[test]
fn account_without_conserved_quantities_is_empty() {
    let mut run = problem::run(Oscillator::new(false), ADAPTIVE.keeping_balance(true), [1.0, 0.0], (), 0.0);
    let start = run.system().content(&Real::all(&[1.0, 0.0]), &());
    run.advance(0.3).unwrap();
    assert!(start.iter().chain(&run.residuals()).all(|amount| *amount == 0.0));
}

/// A vessel that is filled at the rate that the input says: what it holds is what it has received.
#[derive(Clone)]
struct Vessel;

impl System<1> for Vessel {
    problem!();
    type Memory<S: Varying> = ();
    type Indicators<S: Varying> = [S; 0];
    fn derivatives<S: Scalar, const N: usize>(&self, _time: S, _x: &[S; N], u: &[S; 1], (): &()) -> [S; N] {
        problem::all([u[0]])
    }
    fn content<S: Varying, const N: usize>(&self, x: &[S; N], (): &()) -> [f64; 2] {
        [x[0].value(), 0.0]
    }
    fn inflow<S: Varying, const N: usize>(&self, _: S, _: &[S; N], u: &[S; 1], (): &()) -> [f64; 2] {
        [u[0].value(), 0.0]
    }
}

/// The account takes inputs with a slope where they are within a step: of `0.1 + 0.2*t` it receives 0.6 in 2 s, as the vessel does,
/// but for rounding.
#[test]
fn account_follows_inputs_with_a_slope() {
    let mut run = problem::run(Vessel, ADAPTIVE.keeping_balance(true), [0.0], (), 0.0);
    run.set_inputs([Real::of(0.1)], [0.2]);
    run.advance(2.0).unwrap();
    close(run.state().0[0].value, 0.6, 5e-15, "what the vessel holds");
    close(run.residuals()[0], 0.0, 5e-15, "what it holds beyond what it has received");
}

/// `x'' = -x` that counts how often a step was accepted.
#[derive(Clone)]
struct Counting;

impl System<1> for Counting {
    problem!();
    type Memory<S: Varying> = u64;
    type Indicators<S: Varying> = [S; 0];
    fn derivatives<S: Scalar, const N: usize>(&self, time: S, x: &[S; N], _u: &[S; 1], _memory: &u64) -> [S; N] {
        // A kick that no step foresees.
        let kick = if time.value() > 0.5 { 1e3 } else { 0.0 };
        problem::all([x[1], -x[0] + kick])
    }
    fn follow<S: Varying, const N: usize>(&self, _: S, _: &[S; N], _: &[S; 1], follows: &mut u64) -> bool {
        *follows += 1;
        false
    }
    fn max_step(&self) -> f64 {
        0.01
    }
}

/// The system follows every accepted step, and the inputs once at the start of a call. Rejected steps are counted apart,
/// and no step exceeds the largest that the system allows.
#[test]
fn accepted_steps_are_those_the_system_follows() {
    let mut run = problem::run(Counting, Settings { tolerance: 1e-4, ..ADAPTIVE }, [0.0, 1.0], 0, 0.0);
    run.advance(2.0).unwrap();
    let (_, follows) = run.state();
    let counters = run.counters();
    assert_eq!(counters.steps, follows - 1);
    assert!(counters.rejected > 0, "the kick must take the solver by surprise");
    assert!(counters.steps >= 200, "{} steps of at most 0.01 s within 2 s", counters.steps);
}
