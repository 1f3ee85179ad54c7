//! Every bit of many short runs, as recorded: whoever changes numbers or the work of the solver comes to know it.
//!
//! The record says nothing about what is right; other tests do. What it shows is a change where none was meant: between
//! versions, compilers and platforms. `cargo xtask record` renews it where a change is meant, and CHANGELOG.md says
//! which numbers it changes.

mod cases;

use std::collections::BTreeMap;

use pneumatic_servo::co_simulation::{Direction, Simulation};
use pneumatic_servo::friction::Law;
use pneumatic_servo::model::{Model, Setup};
use pneumatic_servo::models;
use pneumatic_servo::solver::StepError;
use pneumatic_servo::variables::{Kind, Table, Variable};

use cases::{Changes, cases, start};
use pneumatic_servo::conformance::Random;

const RECORD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/recorded/runs.csv");
/// Parameters that some laws refuse: by which friction differs by direction, its lubrication follows pressures, or a guide is pressed on.
const REFUSED_BY_SOME: [&str; 8] = [
    "friction.direction.factor",
    "friction.kappaDriving",
    "friction.kappaResisting",
    "friction.stribeckVelocity.kappaDriving",
    "friction.stribeckVelocity.kappaResisting",
    "friction.viscous.kappaDriving",
    "friction.viscous.kappaResisting",
    "friction.guide.coefficient",
];
const HEADER: &str = "model;changes;steps;rejected;jacobians;events;digest\n";

#[test]
fn runs_repeat_those_of_the_record_bit_for_bit() {
    let runs = || {
        models::ALL.iter().flat_map(|model| {
            let stated = cases(model).into_iter().chain(settings(model)).chain(parameters(model));
            let stated = stated.map(|changes| (listed(&changes), changes));
            stated.chain(random_sets(model)).map(move |(name, changes)| run(model, &name, &changes))
        })
    };
    if std::env::var_os("SERVO_RECORD").is_some() {
        assert!(std::env::var_os("CI").is_none(), "SERVO_RECORD renews what is expected, which CI must not");
        let lines: Vec<_> = runs().collect();
        std::fs::write(RECORD, format!("{HEADER}{}\n", lines.join("\n"))).unwrap();
        return;
    }
    let recorded = std::fs::read_to_string(RECORD).unwrap();
    let lines = recorded.strip_prefix(HEADER).unwrap().lines();
    let mut before: BTreeMap<_, _> = lines.clone().map(name_and_result).collect();
    assert_eq!(before.len(), lines.count(), "a run stands twice in the record");
    let (mut changed, mut new) = (Vec::new(), Vec::new());
    for run in runs() {
        let (name, now) = name_and_result(&run);
        match before.remove(name) {
            Some(before) if before == now => {}
            Some(before) => changed.push(format!("{name}: {before}, now {now}")),
            None => new.push(name.to_owned()),
        }
        // Ten tell what is wrong, and that soon.
        if changed.len() == 10 {
            break;
        }
    }
    let gone: Vec<_> = if changed.len() < 10 { before.into_keys().collect() } else { Vec::new() };
    assert!(
        changed.is_empty() && new.is_empty() && gone.is_empty(),
        "runs differ from the record; if that is meant: cargo xtask record.\nThe first that changed: {changed:#?}\n\
         new: {new:#?}\ngone: {gone:#?}"
    );
}

/// The model with its changes, and what came of the run.
fn name_and_result(line: &str) -> (&str, &str) {
    let (place, _) = line.match_indices(';').nth(1).expect("a line of the record");
    (&line[..place], &line[place + 1..])
}

/// The other schemes, under a law without bristles, whose steps may be long, and other tolerances.
fn settings(model: &Model) -> Vec<Changes> {
    let table = model.table();
    let Some(Kind::Enumeration(schemes)) = table.find("solver.scheme").map(|entry| entry.variable.kind) else {
        return Vec::new();
    };
    let law = |law: Law| ("friction.law", f64::from(law as i32));
    let scheme = |id: i32| vec![law(Law::Stribeck), ("solver.scheme", f64::from(id)), ("solver.step", 1e-4)];
    let schemes = schemes.items.iter().map(|(id, ..)| scheme(*id));
    let tolerances = [1e-3, 1e-4, 1e-9].into_iter().flat_map(|tolerance| {
        [Law::Stribeck, Law::Dahl, Law::LuGre].map(|it| vec![law(it), ("solver.relativeTolerance", tolerance)])
    });
    schemes.chain(tolerances).collect()
}

/// Each parameter changed alone, if the model takes it so: halved, 0 no longer, or another item of an enumeration. Parameters
/// of a friction law are the same in all models, so they are changed on the bench alone. A limit of the work ends runs.
fn parameters(model: &'static Model) -> Vec<Changes> {
    let table = model.table();
    let law_of = |group: &str| {
        let Kind::Enumeration(laws) = table.find("friction.law")?.variable.kind else { return None };
        let law = laws.items.iter().find(|(_, name, _)| name.eq_ignore_ascii_case(group));
        law.map(|(id, ..)| ("friction.law", f64::from(*id)))
    };
    let changed = |variable: &'static Variable| {
        let law = match variable.name.split('.').collect::<Vec<_>>()[..] {
            ["friction", group, _, ..] => law_of(group),
            _ => None,
        };
        let is_stated = ["friction.law", "solver.scheme"].contains(&variable.name.as_str())
            || variable.name.starts_with("solver.max")
            || variable.chooses.is_some();
        let start = variable.start.filter(|_| !is_stated);
        let least = variable.nominal.unwrap_or(1.0) * 1e-2;
        let values = |start: f64| match variable.kind {
            Kind::Real(_) if start == 0.0 => vec![least],
            Kind::Real(_) => vec![0.5 * start],
            Kind::Boolean => vec![1.0 - start],
            Kind::Integer => vec![start + 1.0],
            Kind::Enumeration(of) => {
                of.items.iter().map(|(id, ..)| f64::from(*id)).filter(|item| *item != start).collect()
            }
        };
        let changes = move |value| law.into_iter().chain([(variable.name.as_str(), value)]).collect::<Changes>();
        let is_legal = move |changes: &Changes| {
            let mut setup = Setup::new(model);
            let is_set = changes.iter().all(|(name, value)| setup.change(name, *value).is_ok());
            is_set && setup.start(0.0).is_ok() && (law.is_none() || model.name == "FrictionBench")
        };
        start.map(values).unwrap_or_default().into_iter().map(changes).filter(is_legal)
    };
    table.parameters().flat_map(changed).collect()
}

/// Many parameters changed at once: four sets for each law (or for the model), each with factors of 1/2 to 2 on the
/// defaults and one in eight of the options; named by the law and the number of the set.
fn random_sets(model: &'static Model) -> Vec<(String, Changes)> {
    let table = model.table();
    let laws = match table.find("friction.law").map(|entry| entry.variable.kind) {
        Some(Kind::Enumeration(laws)) => laws.items.iter().map(|(id, name, _)| (Some(*id), *name)).collect(),
        _ => vec![(None, "")],
    };
    let sets = |(law, name): (Option<i32>, &'static str)| {
        let legal = (0..1000).filter_map(move |seed| random_set(model, law, name, seed)).enumerate();
        legal.take(4).map(move |(number, changes)| (format!("{name} set {number}").trim().to_string(), changes))
    };
    laws.into_iter().flat_map(sets).collect()
}

/// A set of parameters under a law, unless they do not fit together; the solver's stay.
fn random_set(model: &'static Model, law: Option<i32>, name: &str, seed: u64) -> Option<Changes> {
    let table = model.table();
    let mut random = Random(seed);
    random.next();
    let mut setup = Setup::new(model);
    let mut changes: Changes = law.into_iter().map(|law| ("friction.law", f64::from(law))).collect();
    changes.iter().for_each(|(name, value)| setup.change(name, *value).expect("a law"));
    let of_others = |group: &str| !group.eq_ignore_ascii_case(name) && has_law(table, group);
    for variable in table.parameters().filter(|it| it.chooses.is_none() && it.name != "friction.law") {
        let is_of_another =
            matches!(variable.name.split('.').collect::<Vec<_>>()[..], ["friction", group, _, ..] if of_others(group));
        if is_of_another || variable.name.starts_with("solver.") {
            continue;
        }
        let (start, by, is_chosen) = (variable.start.expect("a start value"), random.next(), random.next() > 0.75);
        let value = match variable.kind {
            Kind::Real(_) if start != 0.0 => start * (1.25 + 0.75 * by),
            _ if !is_chosen => continue,
            Kind::Real(_) => variable.nominal.unwrap_or(1.0) * 1e-2 * (1.25 + 0.75 * by),
            Kind::Boolean => 1.0 - start,
            Kind::Integer => start + 1.0,
            Kind::Enumeration(of) => f64::from(of.items[(0.5 * (1.0 + by) * of.items.len() as f64) as usize].0),
        };
        let mut changed = setup.clone();
        let is_refused = REFUSED_BY_SOME.contains(&variable.name.as_str())
            && (changed.change(&variable.name, value).is_err() || changed.start(0.0).is_err());
        if !is_refused && setup.change(&variable.name, value).is_ok() {
            changes.push((variable.name.as_str(), value));
        }
    }
    setup.start(0.0).is_ok().then_some(changes)
}

fn has_law(table: &Table, group: &str) -> bool {
    let laws = table.find("friction.law").map(|entry| entry.variable.kind);
    matches!(laws, Some(Kind::Enumeration(of)) if of.items.iter().any(|(_, name, _)| name.eq_ignore_ascii_case(group)))
}

/// Changes as the record names them; the elements of GMS, stated together in every case, only where they are alone.
fn listed(changes: &Changes) -> String {
    let is_stated = |(name, _): &&(&str, f64)| changes.len() == 2 || !name.starts_with("friction.gms.");
    let listed: Vec<String> =
        changes.iter().filter(is_stated).map(|(name, value)| format!("{name}={value:?}")).collect();
    listed.join(" ")
}

/// A line of the record: what is counted in a run, and its digest, or why it stops.
fn run(model: &'static Model, name: &str, changes: &Changes) -> String {
    let table = model.table();
    let (mut simulation, _, starts) = start(model, changes);
    let recorded = Recorded::of(model, table, changes);
    let outcome = go(&recorded, simulation.as_mut(), &starts);
    let found = outcome.map_or_else(|error| error.to_string().replace(';', ","), |digest| format!("{:016x}", digest.0));
    let counted = ["steps", "rejectedSteps", "jacobians", "events"].map(|name| {
        let name = format!("solver.{name}");
        let place = table.computed().position(|variable| variable.name == name);
        place.map_or(String::new(), |place| values(table, simulation.as_ref())[place].to_string())
    });
    format!("{};{name};{};{found}", model.name, counted.join(";"))
}

/// 60 steps of 1 ms and 12 of 10 ms, twice, with inputs that jump or ramp, go back to a saved state, and end a step at an
/// event.
fn go(recorded: &Recorded, simulation: &mut dyn Simulation, starts: &[f64]) -> Result<Digest, StepError> {
    let table = recorded.table;
    let mut digest = Digest::new();
    let mut random = Random(1);
    let mut time = 0.0;
    for index in 0..144 {
        let inputs: Vec<f64> = table
            .inputs()
            .zip(starts)
            .map(|(input, start)| match input.kind {
                Kind::Boolean => *start,
                _ => start + 0.7 * input.nominal.unwrap_or(1.0) * random.next(),
            })
            .collect();
        let slopes: Vec<f64> = inputs.iter().map(|input| if index % 3 == 0 { 2.0 * input } else { 0.0 }).collect();
        if index % 4 == 0 {
            simulation.set_inputs(&inputs, &slopes);
        }
        time += if index % 72 < 60 { 1e-3 } else { 1e-2 };
        if index % 9 == 0 && simulation.advance_to_event(time)? {
            digest.add_all(recorded, simulation);
            simulation.update()?;
        }
        let before = simulation.save();
        simulation.advance(time)?;
        if index % 24 == 23 {
            digest.add_all(recorded, simulation);
            simulation.restore(&before).unwrap();
            simulation.advance(time)?;
        }
        if index % 12 == 0 {
            digest.add_all(recorded, simulation);
        }
    }
    Ok(digest)
}

fn values(table: &Table, simulation: &dyn Simulation) -> Vec<f64> {
    let mut values = vec![0.0; table.computed().count()];
    simulation.values(&mut values);
    values
}

/// Number of indicators of events; indicators of kinks, which no run uses, follow.
fn events(model: &Model) -> usize {
    model
        .indicators()
        .iter()
        .filter(|it| !it.name.starts_with("cylinder.stop") && !it.name.starts_with("cushion"))
        .count()
}

/// The part of a model that is recorded: all but the states that laws other than the chosen one have named, which are always 0.
/// A new law thus leaves the records of others as they are.
struct Recorded {
    model: &'static Model,
    table: &'static Table,
    /// By computed variable and by state, whether it is recorded.
    computed: Vec<bool>,
    states: Vec<bool>,
}

impl Recorded {
    fn of(model: &'static Model, table: &'static Table, changes: &Changes) -> Self {
        let choice = table.find("friction.law").map(|entry| entry.variable);
        let stated = changes.iter().find(|(name, _)| *name == "friction.law").map(|(_, id)| *id);
        let is_of_another = |group: &str| {
            let Some(Kind::Enumeration(laws)) = choice.map(|it| it.kind) else { return false };
            let chosen = stated.or(choice.and_then(|it| it.start));
            let mut others = laws.items.iter().filter(|(id, ..)| Some(f64::from(*id)) != chosen);
            others.any(|(_, name, _)| name.eq_ignore_ascii_case(group))
        };
        let counts = |variable: &Variable| !variable.name.split('.').any(is_of_another);
        let state = |reference: u32| counts(table.by_reference(reference).expect("a state").variable);
        Self {
            model,
            table,
            computed: table.computed().map(counts).collect(),
            states: table.states().map(state).collect(),
        }
    }
}

/// Fowler, Noll and Vo's hash (FNV-1a, 64 bits) of numbers.
struct Digest(u64);

impl Digest {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// Adds all that a model tells at an instant: values, their rates and derivatives, indicators, and what a solver
    /// outside gets.
    fn add_all(&mut self, recorded: &Recorded, simulation: &mut dyn Simulation) {
        let Recorded { model, table, .. } = *recorded;
        let mut computed = values(table, simulation);
        self.add_some(&computed, &recorded.computed);
        simulation.rates(&mut computed);
        self.add_some(&computed, &recorded.computed);
        let ones = |count: usize| vec![1.0; count];
        let inputs = ones(table.inputs().count());
        let states = ones(table.states().count());
        let direction = Direction { time: 1.0, inputs: &inputs, states: &states, parameters: &[] };
        simulation.directional_derivative(direction, &mut computed);
        self.add_some(&computed, &recorded.computed);
        let mut indicators = vec![0.0; model.indicators().len()];
        simulation.indicators(&mut indicators);
        let events = events(model);
        self.add(&indicators[..events]);
        if let Some(exchange) = simulation.exchange(model.indicators()) {
            let mut states = ones(table.number_of_states());
            exchange.states(&mut states);
            self.add_some(&states, &recorded.states);
            exchange.nominals(&mut states);
            self.add_some(&states, &recorded.states);
            exchange.indicators(&mut indicators);
            self.add(&indicators[..events]);
            if exchange.rates(&mut states).is_ok() {
                self.add_some(&states, &recorded.states);
            }
        }
    }

    fn add_some(&mut self, numbers: &[f64], recorded: &[bool]) {
        let some: Vec<f64> = numbers.iter().zip(recorded).filter(|(_, is)| **is).map(|(number, _)| *number).collect();
        self.add(&some);
    }

    fn add(&mut self, numbers: &[f64]) {
        for byte in numbers.iter().flat_map(|number| number.to_bits().to_le_bytes()) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
