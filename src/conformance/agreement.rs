//! Co-simulation and model exchange of the same equations, compared.

use super::{Host, described};
use crate::model::Setup;
use crate::variables::{Place, Variable};

/// Inputs over time in s: written over their start values, continuous, straight between communication points.
pub type Course = fn(f64, &mut [f64]);

/// Quantities in which co-simulation and model exchange have to agree.
#[derive(Clone, Copy, Debug)]
pub struct Agreement {
    /// Tolerance of co-simulation.
    pub inside: f64,
    /// Tolerance of the host, relative to the nominal values of the states.
    pub outside: f64,
    /// By how much a variable of that value may differ; nothing if it is not compared.
    pub bound: fn(&Variable, f64) -> Option<f64>,
    /// The share by which the numbers of events may differ.
    pub events: f64,
}

impl Agreement {
    /// Variables that have a nominal value, to a hundred-thousandth of it or of themselves, and the number of events.
    pub const DEFAULT: Self = Self {
        inside: 1e-10,
        outside: 1e-9,
        bound: |variable, value| Some(1e-5 * variable.nominal?.max(value.abs())),
        events: 0.0,
    };
}

/// Runs both ways from communication point to communication point and compares. The host demands that indicators are positive
/// while a mode is valid. Nothing is to be done for a model without continuous states.
///
/// # Panics
/// When both ways do not agree, or one of them fails.
pub fn both_ways(setup: &Setup, agreement: &Agreement, course: Course, step: f64, count: u32) {
    let setup = setup.clone().tolerance(agreement.inside);
    let table = setup.table();
    let told = described(&setup);
    let exchange = setup.exchange(0.0).unwrap_or_else(|error| panic!("{told}: {error}"));
    let Some(exchange) = exchange else { return };
    let numbers = [table.number_of_states(), setup.model().indicators().len()];
    let mut host = Host::new(exchange, setup.inputs(), numbers, course, agreement.outside);
    let mut inside = setup.start(0.0).unwrap_or_else(|error| panic!("{told}: {error}"));
    let mut seen = vec![0.0; table.computed().count()];
    for index in 0..count {
        let (start, end) = (f64::from(index) * step, f64::from(index + 1) * step);
        let [from, to] = [start, end].map(|time| {
            let mut inputs = setup.inputs().to_vec();
            course(time, &mut inputs);
            inputs
        });
        for (place, input) in table.inputs().enumerate() {
            inside.set(&input.name, from[place]).expect("an input");
            inside.set_slope(&input.name, (to[place] - from[place]) / (end - start)).expect("an input");
        }
        inside.advance_to(end).unwrap_or_else(|error| panic!("{told}, inside: {error}"));
        host.advance(end);
        host.model.values(&mut seen);
        for ((variable, one), other) in table.computed().zip(inside.computed()).zip(&seen) {
            let Some(bound) = (agreement.bound)(variable, *one) else { continue };
            let name = &variable.name;
            assert!(
                (one - other).abs() <= bound,
                "{told}: {name} is {other} with the solver outside and {one} inside, at {end} s; it may differ by {bound:.1e}"
            );
        }
    }
    let Some(Place::Computed(events)) = table.find("solver.events").map(|entry| entry.place) else {
        panic!("every model has a counter of events")
    };
    let [one, other] = [inside.computed()[events], seen[events]];
    let (allowed, end) = (agreement.events * one, f64::from(count) * step);
    assert!(
        (one - other).abs() <= allowed,
        "{told}: {other} events with the solver outside and {one} inside, until {end} s; they may differ by {allowed}"
    );
}
