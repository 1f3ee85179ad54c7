//! Random calls with random arguments, compared with a reference that drives the model without the C interface.
//!
//! `SERVO_FUZZ_CALLS` sets the number of calls (millions for a release), `SERVO_FUZZ_SEED` the first seed.

#![allow(unsafe_code, reason = "a C interface is called")]

#[path = "../common/mod.rs"]
mod common;
mod exchange;
mod faces;
mod forged;
mod fuzzer;
pub mod given;
mod random;
mod reference;
mod states;
mod values;

use std::cell::Cell;
use std::collections::BTreeSet;
use std::env;
use std::ffi::c_int;

use common::{DISCARD, ERROR, OK, served};
use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Variable};

use crate::fuzzer::Fuzzer;
use crate::random::Random;

const INSTANCES: usize = 3;
const DEFAULT_CALLS: u64 = 20_000;
/// Calls with one set of instances.
const CALLS_PER_ROUND: u64 = 2_000;
/// Keeps steps with absurd parameters short.
const SOLVER_STEPS: i32 = 60;

/// Outcomes that have to occur among the calls.
const OUTCOMES: [(&str, &[c_int]); 15] = [
    ("experiment", &[OK, ERROR]),
    ("enter", &[OK, ERROR]),
    ("exit", &[OK, ERROR]),
    ("terminate", &[OK, ERROR]),
    ("reset", &[OK]),
    ("set", &[OK, ERROR]),
    ("get", &[OK, ERROR]),
    ("choose", &[OK, ERROR]),
    ("slopes", &[OK, ERROR]),
    ("step", &[OK, DISCARD, ERROR]),
    ("restore", &[OK, ERROR]),
    ("free", &[OK, ERROR]),
    ("transport", &[OK]),
    ("d", &[OK, ERROR]),
    ("rates", &[OK, ERROR]),
];

fn setting(name: &str, default: u64) -> u64 {
    env::var(name).map_or(default, |text| text.parse().unwrap_or_else(|_| panic!("{name} must be a number")))
}

#[test]
fn random_calls_do_what_the_reference_does() {
    let calls = setting("SERVO_FUZZ_CALLS", DEFAULT_CALLS);
    let first_seed = setting("SERVO_FUZZ_SEED", 1);
    let models = served();
    let mut outcomes = BTreeSet::new();
    for round in 0..calls.div_ceil(CALLS_PER_ROUND) {
        MODEL.set(models[round as usize % models.len()]);
        let mut fuzzer = Fuzzer::new(Random::Seeded(first_seed + round));
        (0..CALLS_PER_ROUND).for_each(|_| fuzzer.call());
        outcomes.extend(fuzzer.outcomes);
    }
    // A fuzzer that never gets anywhere would agree with anything.
    // Where no model has a switch, none is chosen.
    let is_switch = |variable: &Variable| variable.kind == Kind::Boolean && variable.is_parameter();
    let has_switch = models.iter().any(|model| model.table().iter().any(is_switch));
    for (call, statuses) in OUTCOMES.iter().filter(|(call, _)| *call != "choose" || has_switch) {
        for status in *statuses {
            assert!(outcomes.contains(&((*call).to_owned(), *status)), "{call} never returned {status}");
        }
    }
}

thread_local! {
    /// The model of this round.
    pub static MODEL: Cell<&'static Model> = const { Cell::new(&models::ALL[0]) };
}

/// The models with states that can be exchanged.
fn exchanged() -> Vec<&'static Model> {
    served().into_iter().filter(|model| model.table().number_of_states() > 0).collect()
}

/// Its variables.
pub fn variables() -> &'static [Variable] {
    MODEL.get().table()
}

/// The parameter that bounds the work of a step.
pub fn limit() -> &'static Variable {
    let bounds = |variable: &&Variable| variable.name.ends_with("PerCommunicationStep");
    variables().iter().find(bounds).expect("the parameter of every model")
}
