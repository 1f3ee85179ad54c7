//! The continuous states of a friction law as variables of a model.

use crate::friction::{MAX_STATES, Observation};
use crate::numbers::Scalar;
use crate::variables::{Variable, units};

/// The states of a contact in a group and, after them, their derivatives; value references from `base`. `motion` lists
/// what the latter, like the friction force, depend on.
pub fn bristle_table(group: &str, base: u32, motion: &[u32]) -> Vec<Variable> {
    let count = MAX_STATES as u32;
    let states = (0..count).map(|i| {
        Variable::output(base + i, &format!("{group}.state[{}]", i + 1), units::ONE)
            .local()
            .depends_on(&[base + i])
            .text("Continuous state of the friction law (deflection in m, or force in N for GMS and Bliman-Sorine); 0 if unused")
    });
    let rates = (0..count).map(|i| {
        Variable::output(base + count + i, &format!("der({group}.state[{}])", i + 1), units::ONE)
            .local()
            .derivative_of(base + i)
            .depends_on(motion)
            .text("Rate per second of a continuous state of the friction law")
    });
    states.chain(rates).collect()
}

/// Writes the values of these variables, and returns the rest of the slots.
pub fn write_bristles<'s, S: Scalar>(contact: &Observation<S>, slots: &'s mut [S]) -> &'s mut [S] {
    let (states, rest) = slots.split_at_mut(MAX_STATES);
    states.copy_from_slice(&contact.states);
    let (rates, rest) = rest.split_at_mut(MAX_STATES);
    rates.copy_from_slice(&contact.rates);
    rest
}
