//! Derivatives with respect to tunable parameters, compared with differences: of every model, under every law, on every
//! rig, in motion and at rest.

use std::collections::BTreeSet;

use pneumatic_servo::co_simulation::Direction;
use pneumatic_servo::conformance::Slopes;
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Role, Table, Variable};

use crate::cases::{Changes, cases, rigs, setup, start};

/// Whether a parameter is a tunable real one.
fn is_tunable(variable: &Variable) -> bool {
    variable.role == Role::Tunable && matches!(variable.kind, Kind::Real(_))
}

/// Whether a parameter is none of a friction law that is not chosen.
fn is_chosen(variable: &Variable, changes: &[(&str, f64)]) -> bool {
    let chosen = changes.iter().find(|(name, _)| *name == "friction.law");
    let law = LAWS.items.iter().find(|(number, ..)| chosen.is_some_and(|(_, id)| f64::from(*number) == *id));
    let law = law.map(|(_, law, _)| *law);
    let group = variable.name.strip_prefix("friction.").and_then(|name| name.split_once('.'));
    let laws = LAWS.items.iter().map(|(_, law, _)| *law);
    let of = group.and_then(|(group, _)| laws.into_iter().find(|law| law.eq_ignore_ascii_case(group)));
    of.is_none() || law.is_none() || of == law
}

/// The derivatives of all computed variables by a parameter.
fn by_parameter(table: &Table, place: usize, differentiate: impl Fn(Direction, &mut [f64])) -> Vec<f64> {
    let (inputs, states) = (vec![0.0; table.inputs().count()], vec![0.0; table.number_of_states()]);
    let mut parameters = vec![0.0; table.parameters().count()];
    parameters[place] = 1.0;
    let mut derivatives = vec![f64::NAN; table.computed().count()];
    differentiate(Direction { time: 0.0, inputs: &inputs, states: &states, parameters: &parameters }, &mut derivatives);
    derivatives
}

/// Parameters that act through events and discrete states alone: while neither changes, the derivative is 0.
const WITHOUT_DERIVATIVES: [&str; 8] = [
    "friction.armstrong.FsInf",
    "friction.bristle.deltaS",
    "friction.bristle.window",
    "friction.coulombStiction.Fs",
    "friction.dnlrx.",
    "friction.karnopp.DV",
    "friction.stickSlipSpring.Fs",
    "friction.stribeck.FsInf",
];

/// Growth of the break-away force with the time at rest: so does it.
fn is_of_rest(name: &str) -> bool {
    name.starts_with("friction.") && [".restGrowth", ".gamma"].iter().any(|end| name.ends_with(end))
}

/// Elements beyond the four in use.
fn is_unused(name: &str) -> bool {
    let number = name.strip_prefix("friction.maxwellSlip.").and_then(|name| name[1..].strip_prefix('['));
    number.and_then(|number| number.strip_suffix(']')?.parse().ok()).is_some_and(|number: u32| number > 4)
}

/// Two rigs of every law, so that all rigs are tried under some, and the rigs of one law.
#[test]
fn derivatives_by_parameters_match_differences() {
    let (mut found, mut names) = (Slopes::default(), BTreeSet::new());
    for model in models::ALL.iter().filter(|model| model.table().number_of_states() > 0) {
        let rigs = rigs(model).len();
        for (law, of_law) in cases(model).chunks(rigs).enumerate() {
            let all = 0..of_law.len();
            let chosen =
                all.filter(|rig| law >= LAWS.items.len() || [law, law + rigs / 2].iter().any(|it| it % rigs == *rig));
            chosen.for_each(|rig| found.run(&setup(model, &of_law[rig]), &|it| is_chosen(it, of_law[rig].as_slice())));
        }
        names.extend(model.table().parameters().filter(|it| is_tunable(it)).map(|variable| variable.name.as_str()));
    }
    assert!(found.wrong.is_empty(), "{} differ: {:#?}", found.wrong.len(), &found.wrong[..found.wrong.len().min(20)]);
    let is_stated = |name: &str| WITHOUT_DERIVATIVES.iter().any(|prefix| name.starts_with(prefix));
    let has_none = |name: &&str| is_stated(name) || is_of_rest(name) || is_unused(name);
    let without: BTreeSet<_> = names.iter().copied().filter(has_none).collect();
    let effective: BTreeSet<_> = found.effective.into_iter().filter(|name| names.contains(name)).collect();
    // A run passes the speeds of some points of a table only.
    let is_point = |name: &&str| name.starts_with("friction.table.") && name.ends_with(']');
    for side in ["friction.table.outwards.force[", "friction.table.inwards.force["] {
        let passed = effective.iter().filter(|name| name.starts_with(side)).count();
        assert!(passed > 8, "{passed} points of {side}");
    }
    let idle: BTreeSet<_> = names.difference(&effective).copied().filter(|name| !is_point(name)).collect();
    assert_eq!(idle, without);
}

/// The controller holds what it has computed, but shows its voltage from the neutral one on.
#[test]
fn voltage_of_the_controller_follows_the_neutral_one_alone() {
    let model = models::find("PositionController").expect("a model");
    let table = model.table();
    let (mut controller, ..) = start(model, &Changes::new());
    controller.advance(0.01).expect("steps");
    for (place, parameter) in table.parameters().enumerate().filter(|(_, it)| is_tunable(it)) {
        let derivatives =
            by_parameter(table, place, |direction, out| controller.directional_derivative(direction, out));
        for (derivative, variable) in derivatives.into_iter().zip(table.computed()) {
            let expected = f64::from(parameter.name == "valve.neutral" && variable.name == "valveVoltage");
            assert_eq!(derivative, expected, "d {} / d {}", variable.name, parameter.name);
        }
    }
}
