//! Promises of every law and every model, as checks for their tests. The laws and models of this library pass the same.
//!
//! | check | promise |
//! |---|---|
//! | [`slopes`] | derivatives by states, inputs, time and parameters agree with finite differences, in the modes that a run passes |
//! | [`rates`] | the derivative of a state is the variable that the table says |
//! | [`dependencies`] | values follow from what `depends_on` says, and from nothing else |
//! | [`steps`] | two half steps are one: the end does not depend on the communication steps |
//! | [`repeats`] | a restored run repeats every bit |
//! | [`numbers`] | values have the same bits in numbers with slopes |
//! | [`both_ways`] | with a solver outside a run is the one with the solver inside; indicators are positive while a mode is valid |
//! | [`law::derivatives`] | the same of a friction law alone, in its modes |
//! | [`law::unchanged`] | where a law says that its force has not changed, it has not |
//! | [`law::yields`] | a contact that has broken away slides: friction at rest does not exceed the break-away force |
//! | [`law::mirrored`] | mirrored motion gives mirrored friction |
//! | [`law::passive`] | friction gives back no more energy than it can have stored |
//!
//! [`model`] and [`run`] do the checks of a model, and look whether the variables of its default experiment exist.
//! [`law()`] does the checks of a law and of the friction bench under it. All of them panic, as assertions of tests do, and say what
//! is wrong.
//!
//! ```
//! use pneumatic_servo::conformance;
//! use pneumatic_servo::friction::Friction;
//!
//! conformance::law::<Friction>("Stribeck", conformance::Claims { odd: true, stored: Some(0.0) });
//! ```

mod agreement;
mod dependencies;
mod experiment;
mod host;
pub mod law;
mod random;
mod runs;
mod slopes;

pub use self::agreement::{Agreement, Course, both_ways};
pub use self::dependencies::{dependencies, found_dependencies, undeclared_dependencies};
use self::experiment::experiment;
pub use self::host::Host;
pub use self::law::{Claims, law};
pub use self::random::Random;
pub use self::runs::{numbers, rates, repeats, steps};
pub use self::slopes::{Slopes, slopes};
use crate::co_simulation::Simulation;
use crate::model::Setup;
use crate::variables::{Kind, Meaning, Variable};

/// Checks all that is promised of a model under each of some settings, that together show all that its variables depend on. A
/// run lasts for a tenth of the default experiment, or a second if that is less.
///
/// # Panics
/// When a promise is not kept.
pub fn model(settings: &[Setup]) {
    settings.iter().for_each(run);
    dependencies(settings);
}

/// Checks all that is promised of a model under its present settings: all but that everything declared by `depends_on` has an
/// effect, which takes several.
///
/// # Panics
/// When a promise is not kept.
pub fn run(setup: &Setup) {
    experiment(setup.model().name, setup.table(), &setup.model().experiment);
    plain_runs(setup);
    numbers(setup, duration(setup));
    slopes(setup);
    found_dependencies(setup);
    both_ways(setup, &Agreement::DEFAULT, still, duration(setup) / 50.0, 50);
}

/// Checks [`rates`], [`steps`] and [`repeats`], which take plain runs only: packing makes them under each law of the user.
///
/// # Panics
/// When a promise is not kept.
pub fn plain_runs(setup: &Setup) {
    let end = duration(setup);
    rates(setup, 0.21 * end);
    // Ten times the default tolerance: stick-slip adds up the errors of its phases.
    steps(setup, end, 1e-5);
    repeats(setup, end);
}

/// Inputs that keep their start values.
fn still(_time: f64, _inputs: &mut [f64]) {}

/// A tenth of the default experiment, or a second if that is less.
fn duration(setup: &Setup) -> f64 {
    (0.1 * setup.model().experiment.stop_time).min(1.0)
}

/// Description of a run in messages: the model, the friction law and all other settings that are not defaults.
fn described(setup: &Setup) -> String {
    let (table, name) = (setup.table(), setup.model().name);
    let item = |variable: &Variable, value: f64| match variable.kind {
        Kind::Enumeration(of) => of.items.iter().find(|(id, ..)| f64::from(*id) == value).map(|(_, item, _)| *item),
        _ => None,
    };
    let (mut law, mut others) = (String::new(), Vec::new());
    let values = table.parameters().zip(setup.parameters()).chain(table.inputs().zip(setup.inputs()));
    for (variable, value) in values {
        let chosen = item(variable, *value);
        let shown = chosen.map_or_else(|| value.to_string(), str::to_owned);
        if chosen.is_some() && variable.meaning == Some(Meaning::FrictionLaw) {
            law = format!(" under {shown}");
        } else if variable.start != Some(*value) {
            others.push(format!("{} = {shown}", variable.name));
        }
    }
    let others = if others.is_empty() { String::new() } else { format!(" with {}", others.join(", ")) };
    format!("{name}{law}{others}")
}

/// A run from time 0.
fn started(setup: &Setup) -> Box<dyn Simulation> {
    setup.simulation(0.0).unwrap_or_else(|error| panic!("{}: {error}", described(setup)))
}

/// The inputs away from their start values by seven tenths of their magnitude times a number, as far as that is legal.
fn moved(setup: &Setup, by: f64) -> Vec<f64> {
    let moved = |(input, start): (&Variable, &f64)| input.nearest(start + 0.7 * input.nominal.unwrap_or(1.0) * by);
    setup.table().inputs().zip(setup.inputs()).map(moved).collect()
}
