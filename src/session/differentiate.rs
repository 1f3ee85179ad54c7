//! Derivatives of the computed variables of a model, exactly, by dual numbers.

use crate::numbers::{Dual, Real, STILL, Scalar, Tangent};
use crate::system::{System, varied};

/// Time in s, states, inputs and discrete state.
type At<'a, M, const N: usize, const U: usize> = (f64, &'a [f64; N], &'a [f64; U], &'a M);

/// Writes the derivatives of the computed variables of a model, the solver's counters included, in a direction of time,
/// states and inputs.
pub fn differentiate<E: System<U>, const N: usize, const U: usize>(
    equations: &E,
    at: At<E::Memory<Real>, N, U>,
    seeds: (f64, &[f64; N], &[f64; U]),
    computed: &mut [f64],
) {
    let dual = |value: f64, slope: f64| Dual::<1>::new(value, [slope]);
    write_slopes(equations, at, seeds, (dual, |number| number.slope[0]), computed);
}

/// The same in the first direction in which the parameters, with which the equations have been built, may vary, too.
pub fn differentiate_varied<E: System<U>, const N: usize, const U: usize>(
    equations: &E,
    at: At<E::Memory<Real>, N, U>,
    seeds: (f64, &[f64; N], &[f64; U]),
    computed: &mut [f64],
) {
    let (time, x, u, memory) = at;
    let memory = with_slopes::<E, U>(memory);
    write_slopes(equations, (time, x, u, &memory), seeds, (Tangent::varying, |number| number.slopes[0]), computed);
}

/// The discrete state with slopes, of which none varies. Its copies on the way here are off the stack when the equations are evaluated.
#[inline(never)]
fn with_slopes<E: System<U>, const U: usize>(memory: &E::Memory<Real>) -> Box<E::Memory<Tangent>> {
    Box::new(varied(memory, |_| STILL))
}

/// Evaluates the equations with numbers with derivatives, and writes the derivatives of the results.
fn write_slopes<E: System<U>, S: Scalar, const N: usize, const U: usize>(
    equations: &E,
    (time, x, u, memory): At<E::Memory<S::Held>, N, U>,
    (time_seed, x_seeds, u_seeds): (f64, &[f64; N], &[f64; U]),
    (number, slope): (impl Fn(f64, f64) -> S, impl Fn(S) -> f64),
    computed: &mut [f64],
) {
    // Residuals and counters, which the equations do not write, have no slopes.
    let mut values = vec![S::zero(); computed.len()];
    let x: [S; N] = std::array::from_fn(|i| number(x[i], x_seeds[i]));
    let u = std::array::from_fn(|i| number(u[i], u_seeds[i]));
    equations.outputs(number(time, time_seed), &x, &u, memory, &mut values);
    for (slot, value) in computed.iter_mut().zip(values) {
        *slot = slope(value);
    }
}
