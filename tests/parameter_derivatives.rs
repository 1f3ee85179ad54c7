//! Derivatives with respect to tunable parameters, compared with differences: of every model, under every law, on every
//! rig, in motion and at rest.

mod cases;

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use pneumatic_servo::co_simulation::{Direction, Simulation};
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Model;
use pneumatic_servo::model_exchange::Exchange;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Role, Table, Variable};

use cases::{Changes, cases, rigs, start};

/// A tunable real parameter, with its place among all parameters.
type Parameter = (usize, &'static Variable);

/// The tunable real parameters but those of the friction laws that are not chosen.
fn tunable(table: &Table, law: Option<&str>) -> Vec<Parameter> {
    let is_real = |variable: &Variable| variable.role == Role::Tunable && matches!(variable.kind, Kind::Real(_));
    let is_chosen = |variable: &Variable| {
        let group = variable.name.strip_prefix("friction.").and_then(|name| name.split_once('.'));
        let laws = LAWS.items.iter().map(|(_, law, _)| *law);
        let of = group.and_then(|(group, _)| laws.into_iter().find(|law| law.eq_ignore_ascii_case(group)));
        of.is_none() || law.is_none() || of == law
    };
    table.parameters().enumerate().filter(|(_, variable)| is_real(variable) && is_chosen(variable)).collect()
}

/// The law that is chosen among the changes.
fn law(changes: &Changes) -> Option<&'static str> {
    let (_, id) = changes.iter().find(|(name, _)| *name == "friction.law")?;
    LAWS.items.iter().find(|(number, ..)| f64::from(*number) == *id).map(|(_, name, _)| *name)
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

/// A difference by values of a parameter that are whole steps from the present one: the steps and the weight of each.
type Stencil = [(f64, f64); 3];

/// The difference of both sides, and those of one side by a parabola: where the other is not legal, or where the values
/// have a corner, as at rest against the play of the valve, whose derivative is that of a side.
const STENCILS: [Stencil; 3] = [
    [(0.0, 0.0), (1.0, 0.5), (-1.0, -0.5)],
    [(0.0, -1.5), (1.0, 2.0), (2.0, -0.5)],
    [(0.0, 1.5), (-1.0, -2.0), (-2.0, 0.5)],
];

/// An exchange and its parameters, which can be changed one by one.
struct Bench<'a> {
    table: &'static Table,
    exchange: &'a mut dyn Exchange,
    parameters: &'a [f64],
}

impl Bench<'_> {
    /// All computed values with a parameter changed, if that is legal.
    fn values(&mut self, place: usize, value: f64) -> Option<Vec<f64>> {
        let mut changed = self.parameters.to_vec();
        changed[place] = value;
        self.exchange.retune(&changed).ok()?;
        let mut values = vec![0.0; self.table.computed().count()];
        self.exchange.values(&mut values);
        self.exchange.retune(self.parameters).expect("the present parameters");
        Some(values)
    }

    /// The differences of all computed values by a parameter, if the values they need are legal.
    fn difference(&mut self, (place, variable): Parameter, step: f64, stencil: &Stencil) -> Option<Vec<f64>> {
        let mut sum = vec![0.0; self.table.computed().count()];
        for (steps, weight) in stencil.iter().filter(|(_, weight)| *weight != 0.0) {
            let value = self.parameters[place] + steps * step;
            variable.check(value).ok()?;
            let values = self.values(place, value)?;
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value / step);
        }
        Some(sum)
    }

    /// Compares the derivatives by a parameter with differences; tells what differs, and whether there is any effect.
    fn check(&mut self, (place, parameter): Parameter) -> (Vec<String>, bool) {
        let value = self.parameters[place];
        let exact =
            by_parameter(self.table, place, |direction, out| self.exchange.directional_derivative(direction, out));
        let now = self.values(place, value).expect("the present value");
        // A ten-thousandth of the value; where that is 0, of what is little in view of the largest.
        let step = 1e-4 * if value == 0.0 { 1e-3 * parameter.max.unwrap_or(1.0).min(1.0) } else { value.abs() };
        let is_near = |(index, variable): (usize, &Variable), difference: f64| {
            let rounding = 1e-13 * (now[index].abs() + variable.nominal.unwrap_or(1.0)) / step;
            let error = (exact[index] - difference).abs();
            error <= 1e-5 * exact[index].abs().max(difference.abs()) + rounding
        };
        // What no difference confirms is left.
        let mut wrong: Vec<(usize, &Variable)> = self.table.computed().enumerate().collect();
        let mut differences = Vec::new();
        for stencil in &STENCILS {
            if wrong.is_empty() {
                break;
            }
            let Some(difference) = self.difference((place, parameter), step, stencil) else { continue };
            wrong.retain(|it| !is_near(*it, difference[it.0]));
            differences.push(difference);
        }
        // A value that stands for "none" has no neighbours, and nothing follows it.
        wrong.retain(|(index, _)| !differences.is_empty() || exact[*index] != 0.0);
        let tell = |(index, variable): (usize, &Variable)| {
            let found: Vec<f64> = differences.iter().map(|difference| difference[index]).collect();
            format!("d {} / d {} = {}, not one of {found:?}", variable.name, parameter.name, exact[index])
        };
        let wrong = wrong.into_iter().map(tell).collect();
        (wrong, exact.iter().any(|derivative| *derivative != 0.0))
    }
}

/// What is found of all parameters: what differs, and which have an effect.
#[derive(Default)]
struct Found {
    wrong: Vec<String>,
    effective: BTreeSet<&'static str>,
}

/// A run with moving inputs, looked at now and then.
fn run(model: &'static Model, changes: &Changes, found: &mut Found) {
    let table = (model.variables)();
    let (mut simulation, parameters, starts) = start(model, changes);
    let duration = (0.1 * model.experiment.stop_time).min(1.0);
    for look in 0..4 {
        let phase = TAU * f64::from(look) / 3.5;
        let moved = |(input, start): (&Variable, &f64)| start + 0.7 * input.nominal.unwrap_or(1.0) * phase.sin();
        let inputs: Vec<f64> = table.inputs().zip(&starts).map(moved).collect();
        simulation.set_inputs(&inputs, &vec![0.0; inputs.len()]);
        let end = duration * f64::from(look + 1) / 4.0;
        simulation.advance(end).unwrap_or_else(|error| panic!("{} {changes:?}: {error}", model.name));
        let Some(mut exchange) = simulation.exchange(model) else { return };
        let told = format!("{} {changes:?} at {end} s", model.name);
        assert_same_inside(table, law(changes), simulation.as_ref(), exchange.as_ref(), &told);
        let mut bench = Bench { table, exchange: exchange.as_mut(), parameters: &parameters };
        for parameter in tunable(table, law(changes)) {
            let (wrong, is_effective) = bench.check(parameter);
            found.wrong.extend(wrong.into_iter().map(|wrong| format!("{told}: {wrong}")));
            found.effective.extend(is_effective.then_some(parameter.1.name.as_str()));
        }
    }
}

/// With the solver inside the derivatives are the same, bit for bit.
fn assert_same_inside(table: &Table, law: Option<&str>, inside: &dyn Simulation, outside: &dyn Exchange, told: &str) {
    let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
    for (place, parameter) in tunable(table, law) {
        let inside = by_parameter(table, place, |direction, out| inside.directional_derivative(direction, out));
        let outside = by_parameter(table, place, |direction, out| outside.directional_derivative(direction, out));
        assert_eq!(bits(inside), bits(outside), "{told}: {}", parameter.name);
    }
}

/// What acts through events and memories alone: while neither changes, nothing follows it.
const WITHOUT_DERIVATIVES: [&str; 10] = [
    "friction.armstrong.FsInf",
    "friction.armstrong.gamma",
    "friction.bristle.deltaS",
    "friction.bristle.window",
    "friction.coulombStiction.Fs",
    "friction.dnlrx.",
    "friction.karnopp.DV",
    "friction.stickSlipSpring.Fs",
    "friction.stribeck.FsInf",
    "friction.stribeck.gamma",
];

/// Elements beyond the four in use.
fn is_unused(name: &str) -> bool {
    let number = name.strip_prefix("friction.maxwellSlip.").and_then(|name| name[1..].strip_prefix('['));
    number.and_then(|number| number.strip_suffix(']')?.parse().ok()).is_some_and(|number: u32| number > 4)
}

/// Two rigs of every law, so that all rigs are tried under some, and the rigs of one law.
#[test]
fn derivatives_by_parameters_match_differences() {
    let (mut found, mut names) = (Found::default(), BTreeSet::new());
    for model in models::ALL.iter().filter(|model| (model.variables)().number_of_states() > 0) {
        let rigs = rigs(model).len();
        for (law, of_law) in cases(model).chunks(rigs).enumerate() {
            let all = 0..of_law.len();
            let chosen =
                all.filter(|rig| of_law.len() < rigs || [law, law + rigs / 2].iter().any(|it| it % rigs == *rig));
            chosen.for_each(|rig| run(model, &of_law[rig], &mut found));
        }
        names.extend(tunable((model.variables)(), None).into_iter().map(|(_, variable)| variable.name.as_str()));
    }
    assert!(found.wrong.is_empty(), "{} differ: {:#?}", found.wrong.len(), &found.wrong[..found.wrong.len().min(20)]);
    let has_none = |name: &&str| WITHOUT_DERIVATIVES.iter().any(|prefix| name.starts_with(prefix)) || is_unused(name);
    let without: BTreeSet<_> = names.iter().copied().filter(has_none).collect();
    assert_eq!(names.difference(&found.effective).copied().collect::<BTreeSet<_>>(), without);
}

/// The controller holds what it has computed, but shows its voltage from the neutral one on.
#[test]
fn voltage_of_the_controller_follows_the_neutral_one_alone() {
    let model = models::find("PositionController").expect("a model");
    let table = (model.variables)();
    let (mut controller, ..) = start(model, &Changes::new());
    controller.advance(0.01).expect("steps");
    for (place, parameter) in tunable(table, None) {
        let derivatives =
            by_parameter(table, place, |direction, out| controller.directional_derivative(direction, out));
        for (derivative, variable) in derivatives.into_iter().zip(table.computed()) {
            let expected = f64::from(parameter.name == "valve.neutral" && variable.name == "valveVoltage");
            assert_eq!(derivative, expected, "d {} / d {}", variable.name, parameter.name);
        }
    }
}
