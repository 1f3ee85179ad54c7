//! Errors that end a run of the hybrid solver, and their messages.

use std::cell::Cell;

use crate::bounds::close;
use crate::problem::{self, problem};
use pneumatic_servo::numbers::{Scalar, Varying};
use pneumatic_servo::solver::{Rejection, Scheme, Settings, StepError};
use pneumatic_servo::system::System;

const ADAPTIVE: Settings =
    Settings { scheme: Scheme::Adaptive, tolerance: 1e-8, step: 1e-3, max_steps: 100_000, keeps_balance: false };

/// `x' = u`, whose only mode is invalid as soon as `x > 1`.
#[derive(Clone)]
struct Trap;

impl System<1> for Trap {
    problem!();
    type Memory<S: Varying> = ();
    type Indicators<S: Varying> = [S; 1];
    fn derivatives<S: Scalar, const N: usize>(&self, _time: S, _x: &[S; N], u: &[S; 1], _memory: &()) -> [S; N] {
        problem::all([u[0]])
    }
    fn indicators<S: Varying, const N: usize>(&self, _: S, x: &[S; N], _: &[S; 1], (): &()) -> [S; 1] {
        [-x[0] + 1.0]
    }
    fn switch<S: Varying, const N: usize>(&self, _: usize, _: S, _: &mut [S; N], _: &[S; 1], _: &mut ()) {}
}

#[test]
fn events_without_end_are_an_error_and_the_time_is_named() {
    let mut run = problem::run(Trap, ADAPTIVE, [0.0], (), 1.0);
    let error = run.advance(2.0).unwrap_err();
    let StepError::Chattering { time, .. } = error else { panic!("{error}") };
    close(time, 1.0, 5e-14, "events without end are an error and the time is named");
    // The system has no names.
    let expected = format!("at t = {time} s events follow each other without end, the last of them an event");
    assert_eq!(error.to_string(), expected);
}

/// `x' = 1`, with an event at each multiple of a spacing in s, whose indicator is flat in front of it; counts how often it
/// is asked for its rate.
#[derive(Clone)]
struct Fence {
    spacing: f64,
    evaluations: Cell<u32>,
}

impl System<1> for Fence {
    problem!();
    type Memory<S: Varying> = f64;
    type Indicators<S: Varying> = [S; 1];
    fn derivatives<S: Scalar, const N: usize>(&self, _time: S, _x: &[S; N], _u: &[S; 1], _memory: &f64) -> [S; N] {
        self.evaluations.update(|count| count + 1);
        problem::all([S::constant(1.0)])
    }
    fn indicators<S: Varying, const N: usize>(&self, _: S, x: &[S; N], _: &[S; 1], passed: &f64) -> [S; 1] {
        let ahead = (-x[0] + (passed + self.spacing)) / self.spacing;
        [if ahead.value() > 0.0 { ahead.powf(9.0) } else { ahead }]
    }
    fn switch<S: Varying, const N: usize>(&self, _: usize, _: S, _: &mut [S; N], _: &[S; 1], passed: &mut f64) {
        *passed += self.spacing;
    }
}

/// A step of the adaptive scheme asks seven times for the rates, for the Jacobian once more, and at an event once more.
#[test]
fn steps_that_locate_events_are_within_the_bound() {
    let system = Fence { spacing: 1e-3, evaluations: Cell::new(0) };
    let mut run = problem::run(system, Settings { max_steps: 500, ..ADAPTIVE }, [0.0], 0.0, 0.0);
    let error = run.advance(1.0).unwrap_err();
    assert!(matches!(error, StepError::TooManySteps { limit: 500, .. }), "{error}");
    assert!(run.counters().events > 5, "{} events", run.counters().events);
    let evaluations = run.system().evaluations.get();
    // The last event may be located beyond it.
    assert!(evaluations < 9 * (500 + 60), "{evaluations} evaluations");
}

/// `x' = -1`, which has no meaning from `x = 0` on.
#[derive(Clone)]
struct Tank;

impl System<1> for Tank {
    problem!();
    type Memory<S: Varying> = ();
    type Indicators<S: Varying> = [S; 0];
    fn derivatives<S: Scalar, const N: usize>(&self, _time: S, _x: &[S; N], _u: &[S; 1], _memory: &()) -> [S; N] {
        problem::all([S::constant(-1.0)])
    }
    fn admit<const N: usize>(&self, x: &[f64; N]) -> Result<(), &'static str> {
        if x[0] > 0.0 { Ok(()) } else { Err("the tank is empty") }
    }
}

#[test]
fn error_says_what_stands_in_the_way() {
    let mut run = problem::run(Tank, ADAPTIVE, [0.5], (), 0.0);
    let error = run.advance(1.0).unwrap_err();
    let StepError::StepSizeTooSmall { time, reason: Rejection::Meaningless("the tank is empty"), .. } = error else {
        panic!("{error}")
    };
    close(time, 0.5, 1e-14, "error says what stands in the way");
    let settings = Settings { scheme: Scheme::RK4, ..ADAPTIVE };
    let error = problem::run(Tank, settings, [0.5], (), 0.0).advance(1.0).unwrap_err();
    assert!(error.to_string().contains("the tank is empty; solver.step = 0.001 s"), "{error}");
}

/// A tank and a jet, which are still until 0.5 s and then set out so fast that no step is short enough: in 1 s the tank by a
/// millionfold of its scale, the jet by the hundredfold of that.
#[derive(Clone)]
struct Burst;

impl System<1> for Burst {
    problem!("tank", "jet");
    type Memory<S: Varying> = ();
    type Indicators<S: Varying> = [S; 0];
    fn derivatives<S: Scalar, const N: usize>(&self, time: S, _x: &[S; N], _u: &[S; 1], (): &()) -> [S; N] {
        let rates = if time.value() > 0.5 { [1e9, 1e5] } else { [0.0; 2] };
        problem::all(rates.map(S::constant))
    }
    fn scales<const N: usize>(&self) -> [f64; N] {
        problem::all([1e3, 1e-3])
    }
}

/// The state that an error names is the one that is farthest off for its scale, not the one with the largest number.
#[test]
fn error_names_the_state_that_is_farthest_off_for_its_scale() {
    let error = problem::run(Burst, ADAPTIVE, [0.0; 2], (), 0.0).advance(1.0).unwrap_err();
    let StepError::StepSizeTooSmall { reason: Rejection::Inaccurate(state), .. } = error else { panic!("{error}") };
    assert_eq!((state.name, state.value, state.rate), ("jet", 0.0, 0.0));
}
