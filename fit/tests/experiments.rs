//! Fits of measured data: the values that the data were made with come out.

use std::collections::BTreeMap;

use pneumatic_servo::models;
use pneumatic_servo::numbers::random;
use pneumatic_servo_fit::NoAnswer;
use pneumatic_servo_fit::experiment::Options;
use pneumatic_servo_fit::fitting::{Answer, Question, fit};
use pneumatic_servo_fit::machine_units::MachineUnits;
use pneumatic_servo_fit::record::Signals;
use pneumatic_servo_fit::search::Unwatched;
use pneumatic_servo_fit::verdict::{Light, verdict};

fn law(name: &str) -> i32 {
    let model = models::find("FrictionBench").expect("a model of the library");
    let (_, laws) = model.table().friction_law().expect("a model with a law");
    laws.items.iter().find(|(_, own, _)| *own == name).expect("a law").0
}

/// The record of the documentation, a rig that an independent program has integrated (`docs/studies/synthetic_rig.py`).
fn rig() -> Signals {
    let text =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/rig.csv")).expect("the record");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    let names = [
        ("time", 1.0),
        ("valveVoltage", 1.0),
        ("position", 1e-3),
        ("chamberA.pressure", 1e5),
        ("chamberB.pressure", 1e5),
    ];
    let column = |(place, (name, factor)): (usize, (&str, f64))| {
        (name.to_owned(), rows.iter().map(|row| factor * row[place]).collect())
    };
    names.into_iter().enumerate().map(column).collect()
}

fn question(experiment: &str, law_name: &str, signals: Signals, estimated: &[&str], known: &[(&str, f64)]) -> Question {
    Question {
        file: "data.csv".to_owned(),
        experiment: experiment.to_owned(),
        law: law(law_name),
        signals,
        known: known.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
        estimated: estimated.iter().map(|name| (*name).to_owned()).collect(),
        validation: 0.3,
        starts: 0,
        options: Options::default(),
        units: MachineUnits::default(),
    }
}

fn answered(question: &Question) -> Answer {
    fit(question, &Unwatched, &|_| {}).unwrap_or_else(|why| panic!("{why:?}"))
}

/// Truths lie within intervals, or next to them: one interval in twenty misses.
fn assert_found(answer: &Answer, truths: &[(&str, f64)]) {
    let estimates: BTreeMap<&str, _> = answer.estimates.iter().map(|one| (one.parameter.0.as_str(), one)).collect();
    for (name, truth) in truths {
        let estimate = estimates[name];
        let [low, high] = estimate.interval;
        let beyond = (estimate.value - truth).abs() / (0.5 * (high - low));
        assert!(beyond < 1.6 && estimate.undetermined.is_none(), "{name}: {estimate:?}, not {truth}");
    }
}

const STRIBECK: [&str; 4] =
    ["friction.stribeck.Fs", "friction.stribeck.Fc", "friction.stribeck.vs", "friction.stribeck.sigma2"];

#[test]
fn a_rig_is_found_and_predicted() {
    let names = [&STRIBECK[..], &["valve.deadZone", "valve.C"]].concat();
    let answer = answered(&question("rig", "Stribeck", rig(), &names, &[("supplyPressure", 6e5)]));
    assert!(answer.converged, "{}", answer.message);
    assert_found(&answer, &[(STRIBECK[0], 12.4), (STRIBECK[1], 7.6), (STRIBECK[2], 0.018), (STRIBECK[3], 38.0)]);
    assert_found(&answer, &[("valve.deadZone", 0.065), ("valve.C", 4.4e-9)]);
    // Noise of 10 um and 500 Pa, with converters of 0.122 mm and 147 Pa.
    assert!(answer.rms["position"] < 6e-5 && answer.rms["chamberA.pressure"] < 600.0, "{:?}", answer.rms);
    assert!(answer.validation_rms["position"] < 6e-5, "{:?}", answer.validation_rms);
    let assumed = "not given, so that the default counts: cylinder.bore = ";
    assert!(
        answer.notes.iter().any(|note| note.starts_with(assumed) && !note.contains("valve.C")),
        "{:?}",
        answer.notes
    );
    assert!((answer.validation_from.expect("validation data") - 2.1).abs() < 2e-3);
    let (light, findings) = verdict(&answer);
    assert_eq!(light, Light::Green, "{findings:?}");
}

/// The supply, which is not asked for, is 6 bar in the data and none by default: the light is red, however the search ends.
#[test]
fn a_rig_with_a_wrong_supply_is_red() {
    let begin = rig().into_iter().map(|(signal, samples)| (signal, samples[..800].to_vec())).collect();
    let answer = answered(&question("rig", "Stribeck", begin, &STRIBECK[1..2], &[("supplyPressure", 5e5)]));
    assert_eq!(verdict(&answer).0, Light::Red, "{:?}", answer.rms);
}

/// A setting that is given wrong is named with the value that explains the data, before any sensor; so is a wrong gain.
#[test]
fn a_cause_of_the_residuals_is_named() {
    let names = [&STRIBECK[..], &["valve.deadZone", "valve.C"]].concat();
    let supply = ("supplyPressure", 6e5);
    let cause = |signals: Signals, known: &[(&str, f64)]| {
        let answer = answered(&Question { validation: 0.0, ..question("rig", "Stribeck", signals, &names, known) });
        let (light, findings) = verdict(&answer);
        assert_eq!(answer.cause.is_none(), light == Light::Green, "{findings:?}");
        if let Some(cause) = &answer.cause {
            assert!(findings.iter().any(|one| one.text == cause.text), "{findings:?}");
        }
        answer.cause
    };
    assert_eq!(cause(rig(), &[supply]), None);
    let gauge = [("supplyPressure", 6e5 - 101_325.0)];
    for (known, name, right) in [
        (&gauge[..], "supplyPressure", 6e5),
        (&[supply, ("cylinder.bore", 0.02)], "cylinder.bore", 0.016),
        (&[supply, ("mass.moving", 1.76)], "mass.moving", 0.88),
    ] {
        let found = cause(rig(), known).expect("a cause");
        let (value, [low, high]) = found.estimate.expect("a value");
        assert_eq!(found.name, name, "{}", found.text);
        assert!((value - right).abs() < high - low && high - low < 0.2 * right, "{}", found.text);
    }
    let isothermal = cause(rig(), &[supply, ("thermal.model", 2.0)]).expect("a cause");
    assert!(isothermal.text.contains("thermal.model were EnergyBalance"), "{}", isothermal.text);
    let mut weak = rig();
    weak.get_mut("chamberA.pressure").expect("a pressure").iter_mut().for_each(|value| *value /= 0.98);
    let fixed = [supply, ("valve.deadZone", 0.065), ("valve.C", 4.4e-9)];
    let question = Question { validation: 0.0, ..question("rig", "Stribeck", weak, &STRIBECK, &fixed) };
    let found = answered(&question).cause.expect("a cause");
    let (value, [low, high]) = found.estimate.expect("a value");
    assert_eq!(found.name, "gain.chamberA.pressure", "{}", found.text);
    assert!((value - 0.98).abs() < high - low && high - low < 0.01, "{}", found.text);
}

/// A seal: friction grows with the load and the pressure, and the pressure pushes on an area.
#[test]
fn a_seal_under_pressure_is_found() {
    let mut state = 1;
    let mut columns: [Vec<f64>; 4] = Default::default();
    for row in 0..3001 {
        let time = 1e-3 * f64::from(row);
        let speed = 0.03 * libm::cos(3.0 * time) + 0.012 * libm::cos(11.0 * time);
        let pressure = 2e5 + 1e5 * libm::sin(2.0 * time);
        let excess = 3.0 * libm::exp(-(speed / 0.01) * (speed / 0.01));
        let friction = (5.0 + excess) * libm::tanh(speed / 1e-5) + 40.0 * speed;
        let force = (1.0 + 1e-6 * pressure) * friction + 2e-4 * pressure + 0.1 * random::normal(&mut state);
        let position = 0.01 * libm::sin(3.0 * time) + 0.012 / 11.0 * libm::sin(11.0 * time);
        columns.iter_mut().zip([time, position, force, pressure]).for_each(|(column, value)| column.push(value));
    }
    let names = ["time", "position", "force", "pressure"];
    let signals = names.into_iter().map(str::to_owned).zip(columns).collect();
    let estimated = [&STRIBECK[..], &["area", "friction.kappaA"]].concat();
    let options = Options { play: Some(0.0), ..Options::default() };
    let asked = Question { options, ..question("motion", "Stribeck", signals, &estimated, &[]) };
    let answer = answered(&asked);
    assert_found(
        &answer,
        &[("friction.stribeck.Fc", 5.0), ("friction.stribeck.Fs", 8.0), ("friction.stribeck.vs", 0.01)],
    );
    assert_found(&answer, &[("area", 2e-4), ("friction.kappaA", 1e-6)]);
    let forgotten = Question { estimated: STRIBECK.map(str::to_owned).to_vec(), ..asked };
    assert!(refused(&forgotten).starts_with("area has no default"));
    let known = [("area", 2e-4), ("friction.kappaA", 1e-6)].map(|(name, value)| (name.to_owned(), value));
    let given = answered(&Question { known: known.into(), ..forgotten });
    assert_found(&given, &[("friction.stribeck.Fc", 5.0), ("friction.stribeck.Fs", 8.0)]);
}

/// Friction of 10 N outwards and 6 N inwards: a factor of the load factor, and no offset of the force.
#[test]
fn friction_that_differs_by_direction_is_found() {
    let (mut state, mut last) = (1, 0.0);
    let mut columns: [Vec<f64>; 3] = Default::default();
    for row in 0..3001 {
        let time = 2e-3 * f64::from(row);
        let position = 0.02 * libm::sin(2.0 * time) + 0.006 * libm::sin(7.0 * time);
        let speed = (position - last) / 2e-3;
        last = position;
        let force = if speed > 0.0 { 10.0 } else { -6.0 } + 30.0 * speed + 0.05 * random::normal(&mut state);
        columns.iter_mut().zip([time, position, force]).for_each(|(column, value)| column.push(value));
    }
    let signals = ["time", "position", "frictionForce"].into_iter().map(str::to_owned).zip(columns).collect();
    let names = ["friction.coulomb.Fc", "friction.coulomb.sigma2", "friction.direction.factor"];
    let options = Options { play: Some(0.0), ..Options::default() };
    let answer = answered(&Question { options, ..question("motion", "Coulomb", signals, &names, &[]) });
    for (estimate, truth) in answer.estimates.iter().zip([6.0, 30.0, 10.0 / 6.0]) {
        assert!((estimate.value / truth - 1.0).abs() < 0.01, "{estimate:?}, not {truth}");
    }
}

/// Three springs that slip.
#[test]
fn elements_of_a_presliding_bench_are_found() {
    let (mut state, mut last, mut forces) = (1, 0.0, [0.0; 3]);
    let mut columns: [Vec<f64>; 3] = Default::default();
    for row in 0..3001 {
        let time = 1e-3 * f64::from(row);
        let position = 25e-6 * libm::sin(3.0 * time) + 15e-6 * libm::sin(10.0 * time);
        for (force, (stiffness, limit)) in forces.iter_mut().zip([(2e5, 0.6), (1e5, 1.0), (4e4, 1.2)]) {
            *force = (*force + stiffness * (position - last)).max(-limit).min(limit);
        }
        last = position;
        let force = forces.iter().sum::<f64>() + 0.01 * random::normal(&mut state);
        columns.iter_mut().zip([time, position, force]).for_each(|(column, value)| column.push(value));
    }
    let signals = ["time", "position", "frictionForce"].into_iter().map(str::to_owned).zip(columns).collect();
    let group = "friction.maxwellSlip";
    let names: Vec<String> =
        ["k", "W"].iter().flat_map(|kind| (1..=3).map(move |k| format!("{group}.{kind}[{k}]"))).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let options = Options { play: Some(0.0), ..Options::default() };
    let known = [("friction.maxwellSlip.N", 3.0)];
    let asked = question("motion", "MaxwellSlip", signals, &names, &known);
    let answer = answered(&Question { options, ..asked });
    // The softest one slips only at the ends of the longest strokes: the data hardly tell its limit.
    for (estimate, truth) in answer.estimates[..2].iter().zip([2e5, 1e5]) {
        assert!((estimate.value / truth - 1.0).abs() < 0.1, "{estimate:?}, not {truth}");
    }
    assert!(answer.rms["frictionForce"] < 0.1, "{:?}", answer.rms);
}

fn refused(question: &Question) -> String {
    match fit(question, &Unwatched, &|_| {}) {
        Err(NoAnswer::Refused(refused)) => refused.0,
        other => panic!("{other:?}"),
    }
}

#[test]
fn choices_that_cannot_be_used_are_refused_by_name() {
    let asked = question("rig", "Stribeck", rig(), &STRIBECK, &[("supplyPressure", 6e5)]);
    let changed = |change: &dyn Fn(&mut Question)| {
        let mut question = asked.clone();
        change(&mut question);
        refused(&question)
    };
    let estimating = |name: &str| changed(&|question| question.estimated = vec![name.to_owned()]);
    assert!(changed(&|question| question.estimated.clear()).contains("choose at least one"));
    assert_eq!(estimating("friction.Fs"), "there is no parameter friction.Fs of PneumaticServoCylinder");
    assert!(estimating("position").contains("is no real parameter"));
    assert!(estimating("delay.velocity").contains("velocity is not compared or driving here, only position"));
    assert!(estimating("lag.valveVoltage").contains("valveVoltage is not compared here"));
    let negative = |question: &mut Question| question.known.extend([(STRIBECK[0].to_owned(), -1.0)]);
    assert!(changed(&negative).starts_with("friction.stribeck.Fs: the start -1 is not within"));
    let far = |question: &mut Question| {
        question.signals.get_mut("position").expect("a position").iter_mut().for_each(|x| *x *= 1e3)
    };
    assert!(changed(&far).contains("cylinder.stroke = 0.5 m, which is its default; is it in mm"));
    let outside = |question: &mut Question| question.known.extend([("position0".to_owned(), 9.0)]);
    assert!(changed(&outside).starts_with("the start values cannot be simulated: position0 = 9"));
    let rest = |question: &mut Question| question.signals.get_mut("position").expect("a position").fill(0.25);
    assert!(changed(&rest).contains("position never changes"));
    assert!(changed(&|question| drop(question.signals.remove("valveVoltage"))).contains("valveVoltage is missing"));
}

/// Points of a table in an arbitrary order, of the law itself in its closed form: both directions, three times each, at two pressures.
fn points(state: &mut u64) -> Signals {
    let mut rows = Vec::new();
    for repeat in 0..3 {
        for speed in [0.2, 0.5, 1.0, 2.0, 4.0, 7.0, 12.0, 20.0, 35.0, 60.0, 100.0] {
            for (side, pressure) in [(1.0, 0.0), (-1.0, 4e5), (1.0, 4e5), (-1.0, 0.0)] {
                let velocity = 1e-3 * side * speed;
                let dry = 8.0 + 4.0 * libm::exp(-(velocity / 0.01) * (velocity / 0.01));
                let friction = side * dry * (1.0 + 2e-6 * pressure) + 40.0 * velocity + 0.05 * random::normal(state);
                rows.push((random::uniform(state), [velocity, pressure, friction], repeat));
            }
        }
    }
    rows.sort_by(|one, other| one.0.total_cmp(&other.0));
    let column = |(place, name): (usize, &str)| (name.to_owned(), rows.iter().map(|(_, row, _)| row[place]).collect());
    ["velocity", "pressure", "frictionForce"].into_iter().enumerate().map(column).collect()
}

#[test]
fn points_without_a_time_are_found() {
    let mut state = 9;
    let signals = points(&mut state);
    for (law_name, group) in [("Stribeck", "friction.stribeck"), ("LuGre", "friction.lugre")] {
        let names: Vec<String> = ["Fs", "Fc", "vs", "sigma2"].map(|name| format!("{group}.{name}")).into();
        let estimated: Vec<&str> = names.iter().map(String::as_str).chain(["friction.kappaA"]).collect();
        let asked = question("points", law_name, signals.clone(), &estimated, &[("friction.kappaA", 1e-7)]);
        let answer = answered(&asked);
        assert!(answer.converged, "{}", answer.message);
        let truths = [(names[0].as_str(), 12.0), (&names[1], 8.0), (&names[2], 0.01), (&names[3], 40.0)];
        assert_found(&answer, &truths);
        assert_found(&answer, &[("friction.kappaA", 2e-6)]);
        let (noise, rms) = (answer.noise["frictionForce"], answer.rms["frictionForce"]);
        assert!((0.7..1.4).contains(&(noise / 0.05)) && (0.7..1.3).contains(&(rms / 0.05)), "{noise}, {rms}");
        assert_eq!(verdict(&answer).0, Light::Green, "{:?}", verdict(&answer).1);
    }
}

#[test]
fn points_that_cannot_be_meant_are_refused_by_name() {
    let signals = points(&mut 1);
    let told = |signals: Signals, law_name: &str| {
        let asked = question("points", law_name, signals, &[STRIBECK[1]], &[]);
        match fit(&asked, &Unwatched, &|_| {}) {
            Err(NoAnswer::Refused(refused)) => refused.0,
            other => panic!("{other:?}"),
        }
    };
    let with = |name: &str, values: Vec<f64>| {
        let mut changed = signals.clone();
        changed.insert(name.to_owned(), values);
        changed
    };
    let number = signals["velocity"].len();
    let timed = told(with("time", (0..number).map(|row| row as f64).collect()), "Stribeck");
    assert!(timed.contains("takes points without a time") && timed.contains("motion"), "{timed}");
    let resting = told(with("velocity", vec![0.0; number]), "Stribeck");
    assert!(resting.contains("velocity = 0 m/s at all points"), "{resting}");
    let mut broken = signals["frictionForce"].clone();
    broken[5] = f64::NAN;
    let missing = told(with("frictionForce", broken), "Stribeck");
    assert!(missing.contains("frictionForce is NaN at point 5"), "{missing}");
    let law = told(signals.clone(), "Polito");
    assert!(law.starts_with("law = Polito is refused"), "{law}");
}
