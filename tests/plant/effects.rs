//! Nothing that a model offers is without effect: each input, parameter, option and item of an enumeration, changed alone,
//! changes what some run shows.

use std::collections::BTreeMap;

use pneumatic_servo::model::{Model, Setup};
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Table, Variable};

use crate::cases::{Changes, rigs, start};
use pneumatic_servo::conformance::Random;

/// A single change of a model: an input by its index, or a parameter with its value.
#[derive(Clone, Copy)]
enum Change {
    Input(usize),
    Parameter(&'static str, f64),
}

/// Every change of a model that must have an effect, by name. The parameters of the friction laws are the same in all models:
/// the bench's.
fn changes(model: &Model) -> Vec<(String, Vec<Change>)> {
    let table = model.table();
    let inputs = table.inputs().enumerate().map(|(place, input)| (input.name.clone(), vec![Change::Input(place)]));
    let is_of_law = |variable: &Variable| law_of(table, &variable.name).is_some();
    let own = table.parameters().filter(|variable| model.name == "FrictionBench" || !is_of_law(variable));
    let parameters = own.flat_map(|variable| {
        let name = variable.name.as_str();
        let alone = |value: f64| Change::Parameter(name, value);
        let start = variable.start.expect("a start value");
        match variable.kind {
            Kind::Enumeration(of) => {
                let items =
                    of.items.iter().map(|(id, item, _)| (format!("{name}={item}"), vec![alone(f64::from(*id))]));
                items.collect()
            }
            Kind::Boolean => vec![(name.to_owned(), vec![alone(1.0 - start)])],
            Kind::Integer if variable.chooses.is_some() => {
                // Items are compared above: here it is whether numbers choose at all.
                let items = 1..=variable.max.map_or(1, |max| max as i32);
                vec![(name.to_owned(), items.map(|id| alone(f64::from(id))).collect())]
            }
            Kind::Integer => {
                let values = [start + 1.0, start - 1.0, variable.min.unwrap_or(start - 2.0)];
                vec![(name.to_owned(), values.map(alone).to_vec())]
            }
            Kind::Real(_) => {
                let nominal = variable.nominal.unwrap_or(1.0);
                // More or less than the default, or the default itself where a rig has another value; what is off, on.
                let near = [0.5 * start, 0.97 * start, 1.5 * start, start];
                let values = [&near[..], &[0.01 * nominal, nominal, -nominal]].concat();
                vec![(name.to_owned(), values.into_iter().map(alone).collect())]
            }
        }
    });
    inputs.chain(parameters).collect()
}

/// Rigs on which a change may have an effect; the rigs of the variable itself come first.
fn contexts(model: &Model, name: &str) -> Vec<Changes> {
    let table = model.table();
    let variable = name.split('=').next().expect("a name");
    let own: Vec<Changes> = match variable.split('.').collect::<Vec<_>>()[..] {
        ["friction", group, _, ..] if law_of(table, variable).is_some() => {
            let law: Changes = law_of(table, variable).into_iter().collect();
            let with = |rig: Changes| law.iter().copied().chain(rig).collect::<Changes>();
            return [vec![]].into_iter().chain(of_laws(group)).chain(rigs(model)).map(with).collect();
        }
        ["sensor", part] if part.starts_with("end") => {
            let hysteresis = [("sensor.endDistance[1]", 0.249), ("position0", 0.249), ("velocity0", 0.5)];
            vec![vec![("position0", 0.003)], vec![("position0", 0.497)], hysteresis.to_vec()]
        }
        ["sensor", ..] => {
            const NOISY: [[&str; 2]; 4] = [
                ["sensor.position.noise", "sensor.position.sampleTime"],
                ["sensor.pressureA.noise", "sensor.pressureA.sampleTime"],
                ["sensor.pressureB.noise", "sensor.pressureB.sampleTime"],
                ["sensor.force.noise", "sensor.force.sampleTime"],
            ];
            vec![NOISY.into_iter().flat_map(|[noise, sampling]| [(noise, 1e-4), (sampling, 2e-3)]).collect()]
        }
        ["coupling", "damping"] => vec![vec![("motion", 2.0), ("coupling.compliance", 1e-5)]],
        ["leakage", "b"] => vec![vec![("chamberA.leakage", 1e-9)]],
        ["twoValves", ..] => vec![vec![("actuation", 4.0), ("valveVoltageA", 8.0), ("valveVoltageB", 2.0)]],
        ["twoRegulators", ..] => vec![vec![("actuation", 5.0)]],
        [input] if input.starts_with("coil") => vec![vec![("actuation", 3.0), ("switching.command", 3.0)]],
        ["valveVoltageA" | "valveVoltageB"] => vec![vec![("actuation", 4.0)]],
        ["imposedPosition" | "imposedVelocity"] => vec![vec![("motion", 2.0)]],
        ["switching", ..] | ["switching.centreNumber"] => vec![vec![("actuation", 3.0)]],
        ["valve", part, ..] if part.starts_with("table") => {
            let table = [("valve.characteristic", 2.0), ("valve.tableA.points", 11.0), ("valve.tableB.points", 11.0)];
            [0.0, 2.0, 5.0, 8.0, 10.0].map(|voltage| [&table[..], &[("valveVoltage", voltage)]].concat()).to_vec()
        }
        ["friction", "position", part, ..] if !["amplitude", "period"].contains(&part) => {
            const FACTORS: [&str; 4] = [
                "friction.position.factor[2]",
                "friction.position.factor[4]",
                "friction.position.factor[6]",
                "friction.position.factor[8]",
            ];
            let table = FACTORS.map(|factor| (factor, 3.0)).into_iter().chain([("friction.position.points", 9.0)]);
            let at = |place: i32| [("valveVoltage", 7.0), ("position0", 0.01 + 0.06 * f64::from(place))];
            (0..9).map(|place| table.clone().chain(at(place)).collect()).collect()
        }
        ["friction", "guide", "lever"] => vec![vec![("friction.guide.coefficient", 0.1)]],
        ["walk", ..] => vec![vec![("tray.velocityAmplitude", 0.2), ("walk.stepsPerPeriod", 2.0)]],
        ["feedForward", ..] | ["referenceVelocity"] => vec![vec![("feedForward.source", 2.0)]],
        ["dimensionless", ..] => vec![vec![("form", 2.0), ("dimensionless.fr", 0.01)]],
        ["solver", "step"] => vec![vec![("solver.scheme", 2.0), ("friction.law", 7.0)]],
        _ => vec![],
    };
    [vec![]].into_iter().chain(own).chain(rigs(model)).chain(of_options(model)).collect()
}

/// Id of the drive of the bench by a prescribed velocity.
const PRESCRIBED: f64 = 2.0;

/// The law that a parameter is of, if it is of one.
fn law_of(table: &Table, parameter: &str) -> Option<(&'static str, f64)> {
    let ["friction", group, _, ..] = parameter.split('.').collect::<Vec<_>>()[..] else { return None };
    let Kind::Enumeration(laws) = table.find("friction.law")?.variable.kind else { return None };
    let law = laws.items.iter().find(|(_, law, _)| law.eq_ignore_ascii_case(group));
    law.map(|(id, ..)| ("friction.law", f64::from(*id)))
}

/// A mass that sticks and slips under a law whose break-away force grows at rest.
fn resting(growth: &'static str) -> Vec<Changes> {
    vec![vec![("mass", 0.02), ("spring.stiffness", 2e3), (growth, 0.5)]]
}

/// Conditions under which parameters of a law have an effect.
fn of_laws(group: &str) -> Vec<Changes> {
    match group {
        // A mass that sticks and slips.
        "stribeck" => vec![vec![
            ("mass", 0.02),
            ("spring.stiffness", 2e3),
            ("friction.stribeck.Fs", 4.0),
            ("friction.stribeck.Fc", 3.0),
            ("friction.stribeck.FsInf", 6.0),
            ("friction.stribeck.sigma2", 0.0),
        ]],
        "coulomb" => resting("friction.coulomb.restGrowth"),
        "coulombStiction" => resting("friction.coulombStiction.restGrowth"),
        "polito" => resting("friction.polito.restGrowth"),
        "gms" => {
            const SHARES: [&str; 6] = [
                "friction.gms.alpha[5]",
                "friction.gms.alpha[6]",
                "friction.gms.alpha[7]",
                "friction.gms.alpha[8]",
                "friction.gms.alpha[9]",
                "friction.gms.alpha[10]",
            ];
            vec![SHARES.map(|share| (share, 0.1)).into_iter().chain([("friction.gms.N", 10.0)]).collect()]
        }
        "maxwellSlip" => {
            const LIMITS: [&str; 6] = [
                "friction.maxwellSlip.W[5]",
                "friction.maxwellSlip.W[6]",
                "friction.maxwellSlip.W[7]",
                "friction.maxwellSlip.W[8]",
                "friction.maxwellSlip.W[9]",
                "friction.maxwellSlip.W[10]",
            ];
            vec![LIMITS.map(|limit| (limit, 1.0)).into_iter().chain([("friction.maxwellSlip.N", 10.0)]).collect()]
        }
        // Speeds at which the film is squeezed out as at rest, and faster.
        "revisedLuGre" => vec![vec![("friction.revisedLuGre.v0", 0.05), ("bench.drive", PRESCRIBED)]],
        "table" => {
            // Both directions, at speeds between all points.
            const SPEEDS: [[&str; 2]; 10] = [
                ["friction.table.outwards.speed[2]", "friction.table.inwards.speed[2]"],
                ["friction.table.outwards.speed[3]", "friction.table.inwards.speed[3]"],
                ["friction.table.outwards.speed[4]", "friction.table.inwards.speed[4]"],
                ["friction.table.outwards.speed[5]", "friction.table.inwards.speed[5]"],
                ["friction.table.outwards.speed[6]", "friction.table.inwards.speed[6]"],
                ["friction.table.outwards.speed[7]", "friction.table.inwards.speed[7]"],
                ["friction.table.outwards.speed[8]", "friction.table.inwards.speed[8]"],
                ["friction.table.outwards.speed[9]", "friction.table.inwards.speed[9]"],
                ["friction.table.outwards.speed[10]", "friction.table.inwards.speed[10]"],
                ["friction.table.outwards.speed[11]", "friction.table.inwards.speed[11]"],
            ];
            let spread = SPEEDS.into_iter().enumerate();
            let spread: Changes =
                spread.flat_map(|(k, sides)| sides.map(|it| (it, 0.015 * (k as f64 + 1.0)))).collect();
            let last = [("friction.table.outwards.force[11]", 9.0), ("friction.table.inwards.force[11]", 9.0)];
            let at =
                |velocity| [&spread[..], &last, &[("bench.drive", PRESCRIBED), ("driveVelocity", velocity)]].concat();
            [0.0, 0.08, -0.08, 0.13, -0.13].map(at).into_iter().chain(resting("friction.table.restGrowth")).collect()
        }
        "dnlrx" => {
            // Springs and their coefficients need each other.
            const SPRINGS: [[&str; 2]; 6] = [
                ["friction.dnlrx.limit[5]", "friction.dnlrx.chi0[5]"],
                ["friction.dnlrx.limit[6]", "friction.dnlrx.chi0[6]"],
                ["friction.dnlrx.limit[7]", "friction.dnlrx.chi0[7]"],
                ["friction.dnlrx.limit[8]", "friction.dnlrx.chi0[8]"],
                ["friction.dnlrx.limit[9]", "friction.dnlrx.chi0[9]"],
                ["friction.dnlrx.limit[10]", "friction.dnlrx.chi0[10]"],
            ];
            let taps = [("friction.dnlrx.N", 10.0), ("friction.dnlrx.nx", 4.0), ("friction.dnlrx.nchi", 2.0)];
            let springs = SPRINGS.into_iter().flat_map(|[limit, coefficient]| [(limit, 1e-5), (coefficient, 1e5)]);
            vec![taps.into_iter().chain([("friction.dnlrx.chi1[1]", 1e5)]).chain(springs).collect()]
        }
        _ => vec![],
    }
}

/// Rigs of the cylinder that need no law of their own.
fn of_options(model: &Model) -> Vec<Changes> {
    if model.name != "PneumaticServoCylinder" {
        return vec![];
    }
    let both = [("hoseA.length", 1.0), ("hoseB.length", 1.0)];
    vec![
        [&both[..], &[("throttleA.C", 2e-9), ("throttleB.C", 2e-9)]].concat(),
        [&both[..], &[("cushion.length", 0.26), ("cushion.C", 1e-9), ("chamberA.pressure0", 6e5)]].concat(),
        vec![("quickExhaustA.C", 1e-8), ("quickExhaustB.C", 1e-8)],
        vec![("load.stiffness", 100.0)],
        vec![("incline", 0.3)],
        vec![("supply.volume", 1e-5), ("supply.C", 1e-10)],
        vec![("position0", 0.0), ("velocity0", -0.1)],
    ]
}

/// A digest of all that a run of 0.16 s shows but for the work of the solver, under inputs that swing, of which one may be
/// held: Fowler, Noll and Vo's hash (FNV-1a, 64 bits). Where the run ends, the reason is part of it.
fn digest(model: &Model, changes: &Changes, held: Option<usize>) -> u64 {
    let table = model.table();
    let (mut simulation, _, starts) = start(model, changes);
    let shown: Vec<bool> = table.computed().map(|variable| !variable.name.starts_with("solver.")).collect();
    let mut computed = vec![0.0; shown.len()];
    let slopes = vec![0.0; starts.len()];
    let (mut random, mut hash, mut time) = (Random(1), 0xcbf2_9ce4_8422_2325u64, 0.0);
    for step in 0..48 {
        let swing = |(place, (variable, start)): (usize, (&Variable, &f64))| {
            let drawn = 0.7 * variable.nominal.unwrap_or(1.0) * random.next();
            if held == Some(place) { *start } else { variable.nearest(start + drawn) }
        };
        let inputs: Vec<f64> = table.inputs().zip(&starts).enumerate().map(swing).collect();
        if step % 4 == 0 {
            simulation.set_inputs(&inputs, &slopes);
        }
        time += if step % 4 == 3 { 1e-2 } else { 1e-3 };
        let outcome = simulation.advance(time);
        simulation.values(&mut computed);
        let shown = computed.iter().zip(&shown).filter(|(_, shown)| **shown).map(|(value, _)| value.to_bits());
        for byte in shown.flat_map(u64::to_le_bytes).chain(outcome.is_err().then_some(1)) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
        if outcome.is_err() {
            break;
        }
    }
    hash
}

/// Whether a model starts with changes.
fn is_legal(model: &'static Model, changes: &Changes) -> bool {
    let mut setup = Setup::new(model);
    changes.iter().all(|(name, value)| setup.change(name, *value).is_ok()) && setup.start(0.0).is_ok()
}

/// Of the values that something can be changed to, whether one has an effect on some rig.
fn has_effect(
    model: &'static Model,
    name: &str,
    values: &[Change],
    digests: &mut BTreeMap<String, Option<u64>>,
) -> bool {
    for context in contexts(model, name) {
        let before = *digests
            .entry(format!("{context:?}"))
            .or_insert_with(|| is_legal(model, &context).then(|| digest(model, &context, None)));
        let Some(before) = before else { continue };
        for value in values {
            let after = match *value {
                Change::Input(place) => digest(model, &context, Some(place)),
                Change::Parameter(parameter, value) => {
                    let others = context.iter().copied().filter(|(name, _)| *name != parameter);
                    let changed: Changes = others.chain([(parameter, value)]).collect();
                    if changed == context || !is_legal(model, &changed) {
                        continue;
                    }
                    digest(model, &changed, None)
                }
            };
            if after != before {
                // A variable with an effect counts, before or after the change.
                let variable =
                    model.table().find(name.split('=').next().expect("a name")).expect("the variable").variable;
                let changed = match *value {
                    Change::Parameter(parameter, value) => vec![(parameter, value)],
                    Change::Input(_) => vec![],
                };
                let after = context.iter().copied().filter(|(name, _)| changed.iter().all(|(own, _)| own != name));
                let after = after.chain(changed.iter().copied()).collect();
                let lacks = [&context, &after].map(|rig| model.table().lack(variable, &values_with(model, rig)));
                assert!(lacks.contains(&None), "{} with {context:?}: {name} counts; {lacks:?}", model.name);
                return true;
            }
        }
    }
    false
}

/// The values of all parameters of a model with changes.
fn values_with(model: &'static Model, changes: &Changes) -> Vec<f64> {
    let mut setup = Setup::new(model);
    changes.iter().for_each(|(name, value)| setup.change(name, *value).expect("a legal value"));
    setup.parameters().to_vec()
}

/// Another legal value of a parameter for a rig.
fn another(model: &'static Model, rig: &Changes, variable: &'static Variable) -> Option<(&'static str, f64)> {
    let (start, nominal) = (variable.start?, variable.nominal.unwrap_or(1.0));
    let near = [0.97 * start, 1.1 * start, 0.1 * nominal, -0.1 * nominal, start + 1.0, start - 1.0];
    let legal = |value: &f64| *value != start && is_legal(model, &[&rig[..], &[(&variable.name, *value)]].concat());
    Some((variable.name.as_str(), near.into_iter().find(legal)?))
}

/// Variables without effect, by the table, leave every bit of a run when all are changed at once.
#[test]
fn variables_that_lack_a_condition_have_no_effect() {
    let mut tried = 0;
    for model in models::ALL {
        let table = model.table();
        assert_eq!(table.problem(), None);
        let more =
            [vec![("actuation", 3.0), ("switching.command", 3.0)], vec![("actuation", 4.0)], vec![("actuation", 5.0)]];
        let more = more.into_iter().filter(|_| model.name == "PneumaticServoCylinder");
        for rig in [vec![]].into_iter().chain(rigs(model)).chain(of_options(model)).chain(more) {
            let parameters = values_with(model, &rig);
            let idle = table.parameters().filter(|it| table.lack(it, &parameters).is_some() && it.chooses.is_none());
            let idle = idle.filter(|variable| rig.iter().all(|(name, _)| *name != variable.name));
            let mut changed = rig.clone();
            for variable in idle {
                changed.extend(another(model, &changed, variable));
            }
            tried += changed.len() - rig.len();
            let before = digest(model, &rig, None);
            if digest(model, &changed, None) != before {
                let alone = changed[rig.len()..].iter().copied();
                let found = alone.filter(|it| digest(model, &[&rig[..], &[*it]].concat(), None) != before);
                panic!("{} with {rig:?}: an effect of {:?}", model.name, found.collect::<Vec<_>>());
            }
            for (place, _) in table.inputs().enumerate().filter(|(_, it)| table.lack(it, &parameters).is_some()) {
                let name = &table.inputs().nth(place).expect("the input").name;
                assert_eq!(
                    digest(model, &rig, Some(place)),
                    before,
                    "{} with {rig:?}: an effect of {name}",
                    model.name
                );
            }
        }
    }
    assert!(tried > 1000, "{tried}");
}

/// An output that lacks a condition is 0 all along.
#[test]
fn outputs_that_lack_a_condition_are_0() {
    for model in models::ALL {
        let table = model.table();
        for rig in [vec![]].into_iter().chain(rigs(model)).chain(of_options(model)) {
            let parameters = values_with(model, &rig);
            let idle: Vec<bool> = table.computed().map(|it| table.lack(it, &parameters).is_some()).collect();
            let (mut simulation, ..) = start(model, &rig);
            let mut computed = vec![0.0; idle.len()];
            for time in [0.0, 0.01, 0.02] {
                if simulation.advance(time).is_err() {
                    break;
                }
                simulation.values(&mut computed);
                for ((variable, value), _) in table.computed().zip(&computed).zip(&idle).filter(|(_, idle)| **idle) {
                    assert_eq!(*value, 0.0, "{} with {rig:?}: {}", model.name, variable.name);
                }
            }
        }
    }
}

fn default_item(table: &Table, name: &str) -> bool {
    let Some((variable, item)) = name.split_once('=') else { return false };
    let Some(entry) = table.find(variable) else { return false };
    let Kind::Enumeration(of) = entry.variable.kind else { return false };
    of.items.iter().any(|(id, text, _)| *text == item && entry.variable.start == Some(f64::from(*id)))
}

/// An item that is the default has an effect where another was chosen, which is what the others show.
#[test]
fn every_input_parameter_and_item_has_an_effect() {
    let mut without = Vec::new();
    for model in models::ALL {
        let mut digests = BTreeMap::new();
        let table = model.table();
        for (name, values) in changes(model).into_iter().filter(|(name, _)| !default_item(table, name)) {
            if !has_effect(model, &name, &values, &mut digests) {
                without.push(format!("{}: {name}", model.name));
            }
        }
    }
    assert!(without.is_empty(), "no run shows an effect of\n{}", without.join("\n"));
}
