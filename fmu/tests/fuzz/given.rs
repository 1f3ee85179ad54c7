//! Calls chosen by the bytes of a fuzzer. `cargo xtask fuzz` looks for bytes that reach new code; the kept ones are replayed here.

use std::fs;
use std::path::Path;

use pneumatic_servo::model::Model;

use pneumatic_servo_fmu::{fmi2, fmi3};

use crate::common::fmi3::LIBRARY3;
use crate::common::{LIBRARY, served};
use crate::exchange::Triplets;
use crate::faces::Twins;
use crate::forged;
use crate::fuzzer::Fuzzer;
use crate::random::Random;
use crate::{MODEL, exchanged};

/// Per input: several inputs of few calls reach as much as one of many calls.
const MOST_CALLS: usize = 300;

/// Something that makes random calls.
trait Caller {
    fn random(&self) -> &Random;
    fn call(&mut self);
}

macro_rules! callers {
    ($($type:ty)*) => {
        $(impl Caller for $type {
            fn random(&self) -> &Random {
                &self.random
            }

            fn call(&mut self) {
                self.call();
            }
        })*
    };
}

callers! { Fuzzer Twins Triplets }

/// Replaces the functions of the loaded library by these during some work.
pub fn of(fmi2: &fmi2::exports::Functions, fmi3: &fmi3::exports::Functions, work: impl FnOnce()) {
    LIBRARY.replaced_by(fmi2, || LIBRARY3.replaced_by(fmi3, work));
}

fn make(mut caller: impl Caller) {
    for _ in 0..MOST_CALLS {
        if caller.random().is_exhausted() {
            return;
        }
        caller.call();
    }
}

/// Chooses one of the models for this thread.
fn choose(random: &mut Random, models: &[&'static Model]) -> &'static Model {
    let model = models[random.below(models.len())];
    MODEL.set(model);
    model
}

/// Co-simulation by FMI 2.0, beside the reference.
pub fn co_simulation(bytes: &[u8]) {
    let mut random = Random::given(bytes);
    choose(&mut random, &served());
    make(Fuzzer::new(random));
}

/// Co-simulation by FMI 3.0, beside FMI 2.0.
pub fn both_versions(bytes: &[u8]) {
    let mut random = Random::given(bytes);
    let model = choose(&mut random, &served());
    make(Twins::new(model, random));
}

/// Model exchange by both versions, beside the model.
pub fn model_exchange(bytes: &[u8]) {
    let mut random = Random::given(bytes);
    let model = choose(&mut random, &exchanged());
    make(Triplets::new(model, random));
}

/// Saved states whose checksum is right and whose content is not.
pub fn forged_states(bytes: &[u8]) {
    let mut random = Random::given(bytes);
    choose(&mut random, &exchanged());
    forged::restore(&mut random);
}

/// Does something with each input that is kept for a target.
fn with_kept(target: &str, work: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fuzz/kept").join(target);
    let files: Vec<_> =
        fs::read_dir(&folder).expect("the kept inputs").map(|file| file.expect("a file").path()).collect();
    assert!(files.len() > 10, "{} inputs in {}", files.len(), folder.display());
    for file in files {
        println!("{}", file.display());
        work(&fs::read(file).expect("an input"));
    }
}

#[test]
fn kept_calls_of_co_simulation_do_what_the_reference_does() {
    with_kept("co_simulation", co_simulation);
}

#[test]
fn kept_calls_of_both_versions_do_the_same() {
    with_kept("both_versions", both_versions);
}

#[test]
fn kept_calls_of_model_exchange_do_what_the_model_does() {
    with_kept("model_exchange", model_exchange);
}

#[test]
fn kept_forged_states_are_survived() {
    with_kept("forged_states", forged_states);
}
