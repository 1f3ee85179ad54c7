//! Checks of the runs of a model under co-simulation.

use super::{described, moved, started};
use crate::co_simulation::Simulation;
use crate::model::Setup;
use crate::numbers::Tangent;
use crate::sensitivity::Along;
use crate::variables::{Kind, Variable};

/// The derivative of each state is the variable that the table says, by central differences between fine steps around a time
/// in s.
///
/// # Panics
/// When it is another one.
pub fn rates(setup: &Setup, middle: f64) {
    const SIZE: f64 = 1e-6;
    let computed: Vec<&Variable> = setup.table().computed().collect();
    let place = |reference: u32| computed.iter().position(|variable| variable.reference == reference);
    let mut run = started(setup);
    let [before, now, after] = [-1.0, 0.0, 1.0].map(|side| {
        advance(setup, run.as_mut(), middle + side * SIZE);
        values(run.as_ref(), computed.len())
    });
    for (index, variable) in computed.iter().enumerate() {
        let Some(state) = variable.derivative_of.and_then(place) else { continue };
        let difference = (after[state] - before[state]) / (2.0 * SIZE);
        let allowed = 1e-4 * now[index].abs() + 1e-6 + 1e-15 * now[state].abs() / SIZE;
        assert!(
            (now[index] - difference).abs() <= allowed,
            "{}: {} is {} at {middle} s, where {} changes by {difference} per second; they may differ by {allowed:.1e}",
            described(setup),
            variable.name,
            now[index],
            computed[state].name,
        );
    }
}

/// Many communication steps and one lead to the same end, at a time in s, but for the solver's tolerance: all states agree to
/// a share of their nominal values or of themselves.
///
/// # Panics
/// When they do not.
pub fn steps(setup: &Setup, end: f64, share: f64) {
    let values_after = |steps: u32| {
        let mut run = started(setup);
        (1..=steps).for_each(|step| advance(setup, run.as_mut(), end * f64::from(step) / f64::from(steps)));
        values(run.as_ref(), setup.table().computed().count())
    };
    let (one, many) = (values_after(1), values_after(97));
    for ((variable, one), many) in setup.table().computed().zip(one).zip(many) {
        if setup.table().find(&variable.name).is_some_and(|entry| entry.state.is_some()) {
            let (name, allowed) = (&variable.name, share * one.abs().max(variable.nominal.unwrap_or(1.0)));
            assert!(
                (one - many).abs() < allowed,
                "{}: {name} is {one} after one communication step of {end} s, and {many} after 97 steps; they may differ by \
                 {allowed:.1e}",
                described(setup),
            );
        }
    }
}

/// A run in numbers with slopes has the values of a plain one, bit for bit, to a time in s; inputs move all the time. They are
/// exact derivatives of the run only then. Without the feature `sensitivities` there are no such runs, and nothing is checked.
///
/// # Panics
/// When a bit is another one.
pub fn numbers(setup: &Setup, end: f64) {
    if !cfg!(feature = "sensitivities") {
        return;
    }
    const UNWRITTEN: u64 = 0x7ff8_0000_dead_beef;
    let varies = |(variable, value): (&Variable, &f64)| {
        variable.varies && matches!(variable.kind, Kind::Real(_)) && variable.meaning.is_none() && *value != 0.0
    };
    let parameter = setup.table().parameters().zip(setup.parameters()).position(varies);
    let mut along: Vec<Along> = parameter.map(Along::Parameter).into_iter().collect();
    along.extend((!setup.inputs().is_empty()).then_some(Along::Input(0)));
    let mut plain = started(setup);
    let mut varied = setup.varied(0.0, &along).unwrap_or_else(|error| panic!("{}: {error}", described(setup)));
    for step in 0..20 {
        let inputs = moved(setup, f64::sin(f64::from(step)));
        plain.set_inputs(&inputs, &vec![0.0; inputs.len()]);
        varied.set_inputs(&inputs, &vec![0.0; inputs.len()]);
        let time = end * f64::from(step + 1) / 20.0;
        advance(setup, plain.as_mut(), time);
        varied.advance(time).unwrap_or_else(|error| panic!("{}, in numbers with slopes: {error}", described(setup)));
        let expected = values(plain.as_ref(), setup.table().computed().count());
        let mut computed = vec![Tangent::still(f64::from_bits(UNWRITTEN)); expected.len()];
        varied.outputs(&mut computed);
        for ((variable, expected), Tangent { value, .. }) in setup.table().computed().zip(expected).zip(computed) {
            assert!(
                value.to_bits() == expected.to_bits() || value.to_bits() == UNWRITTEN,
                "{}: {} is {value} at {time} s in numbers with slopes, and {expected} without; a decision may look at slopes",
                described(setup),
                variable.name,
            );
        }
    }
}

/// A run that is saved at a time in s, continued, restored and continued again repeats every bit, and so does another one that
/// is restored; inputs move all the time.
///
/// # Panics
/// When a bit is another one.
pub fn repeats(setup: &Setup, half: f64) {
    let count = setup.table().computed().count();
    let mut run = started(setup);
    let play = |run: &mut dyn Simulation, from: i32| -> Vec<u64> {
        let step = |step: i32| {
            let inputs = moved(setup, f64::sin(f64::from(step)));
            run.set_inputs(&inputs, &vec![0.0; inputs.len()]);
            advance(setup, run, half * f64::from(step + 1) / 20.0);
            values(run, count).into_iter().map(f64::to_bits)
        };
        (from..from + 20).flat_map(step).collect()
    };
    play(run.as_mut(), 0);
    let saved = run.save();
    let first = play(run.as_mut(), 20);
    let mut other = started(setup);
    for (run, which) in [(&mut run, "the run"), (&mut other, "another run")] {
        run.restore(&saved).unwrap_or_else(|error| panic!("{}: {error}", described(setup)));
        assert!(
            run.save() == saved,
            "{}: {which} is restored to another state than that at {half} s",
            described(setup)
        );
        let again = play(run.as_mut(), 20);
        let Some(place) = first.iter().zip(&again).position(|(first, again)| first != again) else { continue };
        let variable = setup.table().computed().nth(place % count).map_or("?", |variable| &variable.name);
        panic!(
            "{}: {which}, restored at {half} s, comes to {variable} = {} and not {} at {} s",
            described(setup),
            f64::from_bits(again[place]),
            f64::from_bits(first[place]),
            half * (21 + place / count) as f64 / 20.0,
        );
    }
}

fn advance(setup: &Setup, run: &mut dyn Simulation, end: f64) {
    run.advance(end).unwrap_or_else(|error| panic!("{}: {error}", described(setup)));
}

fn values(run: &dyn Simulation, count: usize) -> Vec<f64> {
    let mut values = vec![f64::NAN; count];
    run.values(&mut values);
    values
}
