//! A short run and its fingerprint. It is computed when the sources are made, and again where they are compiled: equal
//! fingerprints mean equal bits.

use pneumatic_servo::model::{Model, Setup};
use pneumatic_servo::variables::{Place, Variable};

/// Steps of the run.
pub const STEPS: u32 = 25;
/// Size of a step in s: large enough for several steps of the solver, an event, and end stops or break-away.
pub const STEP: f64 = 8e-3;

/// All inputs in a step, in the order of the table.
pub fn inputs(model: &'static Model, step: u32) -> Vec<f64> {
    let time = f64::from(step) * STEP;
    let at = |input: &Variable| {
        let signal = model.experiment.signal(&input.name);
        signal.map_or(input.start.unwrap_or_default(), |signal| signal.course.at(time))
    };
    model.table().inputs().map(at).collect()
}

/// The fingerprint of the first 0.2 s of the default experiment of a model: the 64-bit FNV-1a hash of the bits of all
/// computed variables, little end first, after every step. Nothing if the run fails, which on a machine that computes
/// exactly it does not.
pub fn fingerprint(model: &'static Model) -> Option<u64> {
    let mut plant = Setup::new(model).start(0.0).ok()?;
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let computed = model.table().computed().count();
    for step in 0..STEPS {
        for (place, value) in inputs(model, step).into_iter().enumerate() {
            plant.set_input(place, value).ok()?;
        }
        plant.advance_to(f64::from(step + 1) * STEP).ok()?;
        for place in 0..computed {
            for byte in plant.value(Place::Computed(place)).to_bits().to_le_bytes() {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
            }
        }
    }
    Some(hash)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneumatic_servo::models;

    #[test]
    fn every_model_has_a_fingerprint_of_its_own_that_repeats() {
        let fingerprints: Vec<_> =
            models::ALL.iter().map(|model| fingerprint(model).expect("a run without error")).collect();
        for (place, (model, print)) in models::ALL.iter().zip(&fingerprints).enumerate() {
            assert_eq!(fingerprint(model), Some(*print), "{}", model.name);
            assert!(!fingerprints[..place].contains(print), "{}", model.name);
        }
    }
}
