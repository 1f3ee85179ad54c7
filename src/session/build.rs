//! Equations built from all parameters of a model, and checked before a run of them begins.

use super::Start;
use crate::numbers::{Real, Scalar};
use crate::solver::{Counters, Settings, Tuning};
use crate::system::{System, shared_table};
use crate::variables::{ParameterError, ParameterSet, StateSet, Values};

/// Reads the parts of the equations from all parameters of a model, which vary with the seeds of its start, and the solver
/// settings of a run.
///
/// # Errors
/// [`ParameterError`] when values that are legal one by one do not fit together, or the table of the model has a problem.
pub fn read<E: System<U>, const U: usize, P>(
    start: &Start,
    read: impl FnOnce(&mut Values) -> Result<P, ParameterError>,
) -> Result<(P, Settings), ParameterError> {
    let table = shared_table::<E, U>();
    if let Some(problem) = table.problem() {
        return Err(problem.clone());
    }
    let values = table.chosen(start.parameters, start.seeds.parameters);
    let (own, tuning) = values.split_at(values.len() - Tuning::LEN);
    let mut own = Values::new(own);
    let parts = read(&mut own)?;
    if own.left() > 0 {
        let reason = "the equations do not read this number of values of the table";
        return Err(ParameterError::new("parameters", own.left() as f64, reason));
    }
    Ok((parts, Settings::new(&Tuning::read(tuning)?, start.tolerance)))
}

/// Builds equations and the solver settings of a run in the same way.
///
/// # Errors
/// As [`read`].
pub fn build<E: System<U>, const U: usize>(start: &Start) -> Result<(E, Settings), ParameterError> {
    let (equations, settings) = read::<E, U, E>(start, E::new)?;
    let keeps_balance = equations.keeps_balance();
    Ok((equations, settings.keeping_balance(keeps_balance)))
}

/// Checks that a run can begin with equations: every state has a magnitude and a rate.
///
/// # Errors
/// [`ParameterError`] with the name of a state that has none.
pub fn check<E: System<U>, const U: usize>(equations: &E) -> Result<(), ParameterError> {
    let table = shared_table::<E, U>();
    for state in E::State::ALL {
        // Models that count references from elsewhere have a state several times, or leave it out: a trolley that is not there.
        let (n, reference) = (equations.states(), state.reference());
        let is_counted_here = equations.state_at(reference, n) == Some(state.at(n));
        if is_counted_here && !table.states().any(|other| other == reference) {
            let reason = "no variable is the derivative of this state";
            return Err(ParameterError::new("the value reference", reference.into(), reason));
        }
        let scale = state.scale(equations.parameters());
        if !(scale.is_finite() && scale > 0.0) {
            let reference = table.states().find(|reference| E::State::of(*reference) == Some(*state));
            let name = reference.and_then(|reference| table.by_reference(reference)).map(|entry| &*entry.variable.name);
            let name = format!("the magnitude of {}", name.unwrap_or("a state without a variable"));
            return Err(ParameterError::new(&name, scale, "it must be a positive number"));
        }
    }
    Ok(())
}

/// Checks that the equations write as many values as the table has computed variables.
pub(crate) fn check_outputs<E: System<U>, const N: usize, const U: usize>(
    equations: &E,
    x: &[f64; N],
    u: &[f64; U],
    memory: &E::Memory<Real>,
) -> Result<(), ParameterError> {
    // No arithmetic yields this number.
    const UNWRITTEN: f64 = f64::from_bits(0x7ff8_0000_dead_beef);
    let listed = shared_table::<E, U>().computed().count() - Counters::COUNT - E::RESIDUALS;
    let mut computed = vec![Real::of(UNWRITTEN); 2 * listed + 100];
    equations.outputs(Real::of(0.0), &Real::all(x), &Real::all(u), memory, &mut computed);
    let is_written = |number: &Real| number.value.to_bits() != UNWRITTEN.to_bits();
    let written = computed.iter().filter(|value| is_written(value)).count();
    // Missing values may be filled with zeros, to the end of the buffer.
    let is_complete = written == listed || written == computed.len();
    if is_complete && computed[..listed].iter().all(is_written) {
        return Ok(());
    }
    let reason = format!("the equations write {written} of this number in the table");
    Err(ParameterError::new("computed variables", listed as f64, &reason))
}
