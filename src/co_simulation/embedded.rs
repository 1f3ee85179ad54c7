//! A run without the table of its variables, for machines with little memory: values have places, and no names.

use crate::numbers::{Real, Scalar};
use crate::solver::{Counters, Run, Settings, StepError, Tuning};
use crate::system::System;
use crate::variables::{ParameterError, ParameterSet, Tunable, Values};

/// A run of equations with `U` inputs and at most `N` states, from time 0.
///
/// Values are in the order of the table of the model, parameters without the integers at its end that choose by number. Whether
/// each value is within its range is the caller's to check, who has the table.
pub struct Embedded<E: System<U>, const N: usize, const U: usize> {
    run: Box<Run<E, N, U>>,
    /// The computed variables as the equations write them.
    written: Vec<Real>,
}

impl<E: System<U>, const N: usize, const U: usize> Embedded<E, N, U> {
    /// A run from its start, with room for a number of computed variables. It allocates; steps do not.
    ///
    /// # Errors
    /// [`ParameterError`] when parameters do not fit together, or have more than `N` states.
    #[inline(never)]
    pub fn new(parameters: &[f64], inputs: &[f64; U], computed: usize) -> Result<Self, ParameterError> {
        let (equations, settings) = build::<E, U>(parameters)?;
        let states = equations.states();
        if states > N {
            return Err(ParameterError::new("states", states as f64, "the run is compiled for fewer"));
        }
        let inputs = inputs.map(Real::of);
        let begin = Box::new(equations.start(&inputs));
        let written = vec![Real::of(0.0); computed - Counters::COUNT - E::RESIDUALS];
        Ok(Self { run: Run::boxed(equations, settings, begin, inputs), written })
    }

    /// Current time in s.
    pub fn time(&self) -> f64 {
        self.run.time()
    }

    /// Sets the inputs at the current time; they are held until they are set again.
    pub fn set_inputs(&mut self, inputs: &[f64; U]) {
        self.run.set_inputs(inputs.map(Real::of), [0.0; U]);
    }

    /// Replaces tunable parameters: all are given, and fixed ones must be unchanged.
    ///
    /// # Errors
    /// [`ParameterError`] when they do not fit together; nothing is changed then.
    pub fn retune(&mut self, parameters: &[f64]) -> Result<(), ParameterError> {
        let (equations, _) = build::<E, U>(parameters)?;
        self.run.replace_system(equations);
        Ok(())
    }

    /// Integrates to a time in s.
    ///
    /// # Errors
    /// [`StepError`] when it cannot be reached; the state is then the last accepted one.
    pub fn advance(&mut self, end: f64) -> Result<(), StepError> {
        self.run.advance(end)
    }

    /// Writes all computed variables, consistent with the current inputs.
    pub fn values(&mut self, computed: &mut [f64]) {
        let (inputs, _) = self.run.inputs();
        let (own, rest) = computed.split_at_mut(self.written.len());
        let (residuals, counters) = rest.split_at_mut(E::RESIDUALS);
        let (run, written) = (&self.run, &mut self.written);
        run.consistent(|x, memory| {
            run.system().outputs(Real::of(run.time()), x, &inputs, memory, written);
        });
        own.iter_mut().zip(written).for_each(|(slot, number)| *slot = number.value);
        residuals.copy_from_slice(&run.residuals()[..E::RESIDUALS]);
        run.counters().write(counters);
    }
}

/// Equations and the solver settings, from all parameters.
fn build<E: System<U>, const U: usize>(parameters: &[f64]) -> Result<(E, Settings), ParameterError> {
    let all: Vec<_> = parameters.iter().copied().map(Tunable::still).collect();
    let (own, tuning) = all.split_at(parameters.len().saturating_sub(Tuning::LEN));
    let mut own = Values::new(own);
    let equations = E::new(&mut own)?;
    if own.left() > 0 {
        return Err(ParameterError::new("parameters", own.left() as f64, "this number of values is not read"));
    }
    let settings = Settings::new(&Tuning::read(tuning)?, None).keeping_balance(equations.keeps_balance());
    Ok((equations, settings))
}
