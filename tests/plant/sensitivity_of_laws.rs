//! Sensitivities under every law, compared with central differences of runs: the table of `docs/sensitivities-method.md`.
//!
//! `SERVO_RECORD=1 cargo test --test plant sensitivity_of_laws` writes its numbers anew; the last column, why a law is not as close as
//! others, is written by hand.

use std::f64::consts::TAU;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::{Plant, Setup};
use pneumatic_servo::models::pneumatic_servo_cylinder;
use pneumatic_servo::variables::{Kind, Meaning};

const PAGE: &str = "docs/sensitivities-method.md";
const HEAD: &str = "| law | `valve.C` | `mass.moving` | `supplyPressure` | its own | why more than 1e-5 |";
/// Parameters of the derivatives under every law; each law also by the first of its own parameters.
const NAMES: [&str; 3] = ["valve.C", "mass.moving", "supplyPressure"];
/// Communication steps of 1 ms: the carriage breaks away, stops and breaks away again.
const STEPS: u32 = 700;
/// Shares of a parameter by which runs differ. Large ones reach across more events, small ones show what the tolerance leaves: the
/// best of them counts.
const SHARES: [f64; 3] = [1e-4, 1e-5, 1e-6];
/// Above this deviation the table says why.
const CLOSE: f64 = 1e-5;

fn setup(law: &str) -> Setup {
    let setup = Setup::new(&pneumatic_servo_cylinder::MODEL).set("friction.law", law).expect("a law");
    setup.set("solver.relativeTolerance", 1e-10).expect("legal")
}

/// Runs the default experiment, and looks after every step.
fn experiment(plant: &mut Plant, mut look: impl FnMut(&mut Plant)) {
    for k in 0..STEPS {
        plant.set("valveVoltage", 5.0 + 2.0 * (TAU * f64::from(k) * 1e-3).sin()).expect("legal");
        plant.advance_to(f64::from(k + 1) * 1e-3).expect("advances");
        look(plant);
    }
}

fn positions(setup: &Setup) -> Vec<f64> {
    let mut found = Vec::new();
    experiment(&mut setup.start(0.0).expect("starts"), |plant| found.push(plant.get("position").expect("a variable")));
    found
}

/// Sensitivities of the position after every step; nothing where the run comes to a point without any, or the law
/// has none.
fn sensitivities(setup: &Setup, names: &[&str]) -> Vec<Option<Vec<f64>>> {
    let mut plant = setup.start(0.0).expect("starts");
    if plant.carry_sensitivities(names).is_err() {
        return vec![None; names.len()];
    }
    let place = plant.table().computed().position(|variable| variable.name == "position").expect("computed");
    let mut slopes = vec![Some(Vec::new()); names.len()];
    experiment(&mut plant, |plant| {
        for (direction, slopes) in slopes.iter_mut().enumerate() {
            match plant.sensitivities(direction) {
                Ok(found) => slopes.iter_mut().for_each(|slopes: &mut Vec<f64>| slopes.push(found[place])),
                Err(_) => *slopes = None,
            }
        }
    });
    slopes
}

/// The largest distance between sensitivities and central differences of runs, relative to the largest of these.
fn distance(setup: &Setup, name: &str, slopes: &[f64], share: f64) -> f64 {
    let value = setup.get(name).expect("a parameter");
    let run = |sign: f64| positions(&setup.clone().set(name, value * (1.0 + sign * share)).expect("legal"));
    let difference = |(above, below): (f64, f64)| (above - below) / (2.0 * share * value);
    let differences: Vec<f64> = run(1.0).into_iter().zip(run(-1.0)).map(difference).collect();
    let largest = differences.iter().fold(0.0f64, |largest, slope| largest.max(slope.abs()));
    let apart = differences.iter().zip(slopes).map(|(one, other)| (one - other).abs());
    apart.fold(0.0f64, f64::max) / largest
}

/// The first real parameter of a law; `None` has none.
fn own(law: &str) -> Option<String> {
    let is_own = |name: &str| name.split('.').nth(1).is_some_and(|group| group.eq_ignore_ascii_case(law));
    let mut parameters = setup("None").table().parameters().filter(|it| it.name.starts_with("friction."));
    let is_varied = |kind: &Kind, meaning| matches!(kind, Kind::Real(_)) && meaning != Some(Meaning::Sampling);
    parameters.find(|it| is_varied(&it.kind, it.meaning) && is_own(&it.name)).map(|variable| variable.name.clone())
}

/// The largest of the distances by each name that some share brings about; nothing where there are no sensitivities.
fn distances(law: &str) -> Vec<Option<f64>> {
    let (setup, own) = (setup(law), own(law));
    let names: Vec<&str> = NAMES.into_iter().chain(own.as_deref()).collect();
    let closest = |(name, slopes): (&&str, Option<Vec<f64>>)| {
        let slopes = slopes?;
        Some(SHARES.map(|share| distance(&setup, name, &slopes, share)).into_iter().fold(f64::INFINITY, f64::min))
    };
    names.iter().zip(sensitivities(&setup, &names)).map(closest).collect()
}

/// Errors of all laws, on all cores.
fn of_all_laws() -> Vec<(&'static str, Vec<Option<f64>>)> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        while let Some((_, law, _)) = LAWS.items.get(next.fetch_add(1, Ordering::Relaxed)) {
            done.push((*law, distances(law)));
        }
        done
    };
    let workers = thread::available_parallelism().map_or(1, |cores| cores.get());
    thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("distances")).collect()
    })
}

/// Every number of the table is what is found, and what is not close or not there has a reason.
#[test]
fn table_of_all_laws_is_what_is_found() {
    let page = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    let text = std::fs::read_to_string(&page).expect(PAGE);
    let (mut renewed, mut without_reason) = (text.clone(), Vec::new());
    let (before, rest) = text.split_once(HEAD).expect(HEAD);
    let first = before.lines().count() + 2;
    let rows: Vec<&str> = rest.lines().skip(2).take_while(|line| line.starts_with('|')).collect();
    assert_eq!(rows.len(), LAWS.items.len(), "a row for each law behind line {first} of {PAGE}");
    for (law, found) in of_all_laws() {
        let row = rows.iter().find(|row| row.starts_with(&format!("| {law} |"))).expect("a row");
        let reason = row.trim_end_matches('|').rsplit('|').next().unwrap_or_default().trim();
        let cell = |place: usize| match found.get(place) {
            Some(Some(distance)) => format!("{distance:.0e}"),
            Some(None) => "none".to_owned(),
            None => String::new(),
        };
        let cells: Vec<String> = (0..=NAMES.len()).map(cell).collect();
        renewed = renewed.replace(*row, &format!("| {law} | {} | {reason} |", cells.join(" | ")));
        if reason.is_empty() && found.iter().any(|it| it.is_none_or(|distance| distance >= CLOSE)) {
            without_reason.push(law);
        }
    }
    if std::env::var_os("SERVO_RECORD").is_some() {
        assert!(std::env::var_os("CI").is_none(), "SERVO_RECORD renews what is expected, which CI must not");
        std::fs::write(&page, &renewed).expect(PAGE);
    } else {
        assert!(renewed == text, "the table should be\n{}", renewed.split_once(HEAD).expect(HEAD).1);
    }
    assert!(without_reason.is_empty(), "{without_reason:?}");
}

/// The springs of a law come back to their limits all at a time, and what is left of forces is little beside what each of them does: there
/// a kink of a hundredth of a slope moves the events behind it by a fifth.
#[test]
fn springs_at_their_limits_delay_events_as_differences_tell() {
    const SHARE: f64 = 1e-5;
    let setup = setup("MaxwellSlip");
    let value = setup.get("valve.C").expect("a parameter");
    let crossings = |offset: f64| {
        let mut plant = setup.clone().set("valve.C", value + offset).expect("legal").start(0.0).expect("starts");
        plant.carry_sensitivities(&["valve.C"]).expect("a parameter");
        experiment(&mut plant, |_| {});
        plant.crossings().to_vec()
    };
    let [here, later, sooner] = [0.0, SHARE * value, -SHARE * value].map(crossings);
    assert_eq!(here.len(), 11, "four elements slip, stop, slip, stop, and slip one by one");
    for (crossing, (later, sooner)) in here.iter().zip(later.iter().zip(&sooner)) {
        let expected = (later.time - sooner.time) / (2.0 * SHARE * value);
        let apart = (crossing.delays[0] / expected - 1.0).abs();
        // Slopes of forces are known to 1e-9, and a thousandth of the forces is what is left to move the carriage.
        assert!(apart < 3e-4, "{} at {} s: {apart:e}", crossing.event, crossing.time);
    }
}
