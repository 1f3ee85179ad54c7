//! The solver's variables, which every table has: its parameters and its counters.

use serde::{Deserialize, Serialize};

use crate::variables::{Condition, ParameterSet, SOLVER, Variable, units};
use crate::{enumeration, parameters};

enumeration! {
    /// An integration scheme; ids are never reused.
    Scheme "SolverScheme": "Integration scheme" {
        1 Adaptive: "Error control, by a Rosenbrock method of order 4 or, where nothing is stiff, the classical Runge-Kutta method (recommended)";
        2 ExplicitEuler: "Explicit Euler method with fixed step";
        3 ImplicitEuler: "Implicit Euler method with fixed step";
        4 RK3: "Explicit Runge-Kutta method of order 3 with fixed step";
        5 RK4: "Classical Runge-Kutta method of order 4 with fixed step";
    }
}

/// The relative tolerance while nothing else is asked for.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;

parameters! {
    /// The solver's parameters as a host sets them.
    Tuning {
        scheme: Scheme = Variable::choice(0, "scheme", Scheme::Adaptive)
            .text("Integration scheme; all locate stick, slip and other events");
        relative_tolerance: f64 = Variable::parameter(1, "relativeTolerance", units::ONE, DEFAULT_TOLERANCE)
            .range(1e-12, 1e-2)
            .text("Tolerance of the adaptive scheme, and of the location of events; while at its default, a tolerance given by the host replaces it");
        step: f64 = Variable::parameter(2, "step", units::SECOND, 1e-5)
            .counts_where(Condition::is_not("scheme", &[Scheme::Adaptive]))
            .range(1e-9, 1.0).plausible(1e-9, 5e-3)
            .text("Step size of the fixed-step schemes");
        max_steps: u64 = Variable::count(3, "maxStepsPerCommunicationStep", 0)
            .range(0.0, f64::from(i32::MAX))
            .text("Bound on solver steps (rejected ones included) within one communication step; beyond it the step is discarded. 0: one per microsecond of the step, at least 5,000, at most 1,000,000");
    }
}

impl Tuning {
    /// The variables in the group `solver`, with value references from `base`.
    pub fn grouped(base: u32) -> Vec<Variable> {
        Self::table().into_iter().map(|variable| variable.within(SOLVER, base)).collect()
    }
}

/// Work of the solver since initialization.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Accepted steps.
    pub steps: u64,
    /// Steps rejected because of the error estimate or because a trial state was not admissible.
    pub rejected: u64,
    /// Evaluations of the Jacobian.
    pub jacobians: u64,
    /// Events: break-away, stop of sliding, and all other switches.
    pub events: u64,
}

impl Counters {
    /// Number of counters.
    pub const COUNT: usize = 4;

    /// The counters as variables; every model's table has them. Value references from `base`.
    pub fn table(base: u32) -> Vec<Variable> {
        let texts = [
            ("steps", "Accepted solver steps since initialization"),
            ("rejectedSteps", "Rejected solver steps since initialization"),
            ("jacobians", "Evaluations of the Jacobian since initialization"),
            ("events", "Events since initialization: break-away, stop of sliding and all other switches"),
        ];
        let counters = texts.iter().zip(0..);
        counters
            .map(|((name, text), index)| Variable::counter(index, name).depends_on(&[]).text(text).within(SOLVER, base))
            .collect()
    }

    /// Writes their values.
    pub fn write(self, slots: &mut [f64]) {
        let Self { steps, rejected, jacobians, events } = self;
        for (slot, count) in slots.iter_mut().zip([steps, rejected, jacobians, events]) {
            // FMI integers have 32 bits; a run that exceeds them shows the largest.
            *slot = f64::from(i32::try_from(count).unwrap_or(i32::MAX));
        }
    }
}
