//! Claims of the docs about the solver's work: steps and events are counts, the same on every machine.
//!
//! `cargo xtask record` writes them anew where a change is meant to change them.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::PathBuf;

use crate::bounds::{farthest, largest};
use crate::rig::{Rig, Value};
use serde_json::Value as Json;

const LAWS: &str = "docs/performance/laws.csv";
const RATIOS: &str = "docs/performance/ratios.csv";
const PERFORMANCE: &str = "docs/performance.md";
const SOLVER: &str = "docs/solver.md";

/// The rows of `docs/solver.md` whose last cell is of the present solver, with their reference case.
const TRAJECTORIES: [(&str, &str); 11] = [
    ("Stribeck, default experiment", "default-Stribeck"),
    ("the same at 4 Hz", "frequency-4Hz-Stribeck"),
    ("Polito, 7 bar", "transition-Polito"),
    ("Stribeck, full command", "full-command-Stribeck"),
    ("GMS", "default-GMS"),
    ("MaxwellSlip", "default-MaxwellSlip"),
    ("LuGre", "default-LuGre"),
    ("LuGre, `sigma0` 8 MN/m", "lugre-stiff"),
    ("ElastoPlastic", "default-ElastoPlastic"),
    ("Leuven", "default-Leuven"),
    ("Dahl", "default-Dahl"),
];

/// Accepted steps, rejected steps, Jacobians and events.
type Counts = [u64; 4];

fn path(file: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(file)
}

fn read(file: &str) -> String {
    std::fs::read_to_string(path(file)).expect(file)
}

/// The counts of a run in communication steps under held voltages.
fn counts(rig: &Rig, step: f64, duration: f64, voltage: impl Fn(f64) -> f64) -> Counts {
    let mut running = rig.start().expect("a legal case");
    let mut time = 0.0;
    for index in 0..(duration / step).round() as u32 {
        running.set("valveVoltage", voltage(f64::from(index) * step));
        time += step;
        running.advance(time).expect("a run without a discarded step");
    }
    ["steps", "rejectedSteps", "jacobians", "events"].map(|name| running.get(&format!("solver.{name}")) as u64)
}

/// Of the default experiment under a law, or under LuGre with a stiff bristle.
fn of_law(law: &str, step: f64) -> Counts {
    let rig = match law.strip_suffix(" stiff") {
        Some(law) => {
            let stiff = [("sigma0", 8e6), ("sigma1", 500.0), ("vd", 1e3)];
            stiff
                .iter()
                .fold(Rig::cylinder(law), |rig, (name, value)| rig.set(&format!("friction.lugre.{name}"), *value))
        }
        None => Rig::cylinder(law),
    };
    counts(&rig, step, 3.0, |time| 5.0 + 2.0 * (TAU * time).sin())
}

/// Of a case of `tests/reference`.
fn of_reference(name: &str) -> Counts {
    let cases: Vec<Json> = serde_json::from_str(&read("tests/reference/cases.json")).expect("well-formed cases");
    let case = cases.iter().find(|case| case["name"] == name).expect(name);
    let parameters: BTreeMap<String, Value> = serde_json::from_value(case["parameters"].clone()).expect("parameters");
    let number = |value: &Json| value.as_f64().expect("a number");
    let supply = number(&case["inputs"]["supplyPressure"]);
    let rig = Rig::new("PneumaticServoCylinder").with(&parameters).set("supplyPressure", supply);
    let [offset, amplitude, frequency] =
        ["offset", "amplitude", "frequency"].map(|part| number(&case["inputs"]["valveVoltage"][part]));
    let voltage = |time: f64| offset + amplitude * (TAU * frequency * time).sin();
    counts(&rig, number(&case["communicationStep"]), number(&case["stopTime"]), voltage)
}

/// The cells of a row between bars.
fn cells(line: &str) -> Vec<&str> {
    line.trim_matches('|').split('|').map(str::trim).collect()
}

/// `laws.csv` with the counts of the present solver.
fn laws(text: &str) -> String {
    let rows = text.lines().skip(1).map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        let counts = of_law(cells[0], 1e-3 * cells[1].parse::<f64>().expect("a step in ms"));
        [cells[..7].join(","), counts.map(|count| count.to_string()).join(",")].join(",")
    });
    let header = text.lines().next().expect("a header").to_owned();
    std::iter::once(header).chain(rows).map(|line| line + "\n").collect()
}

/// The table "Every law" with the counts of `laws.csv`.
fn performance(text: &str, laws: &str) -> String {
    let find = |law: &str| {
        let row = laws.lines().map(|line| line.split(',').collect::<Vec<_>>());
        row.into_iter().find(|cells| cells[0] == law && cells[1] == "1")
    };
    let mut within = false;
    let lines = text.lines().map(|line| {
        within = if line.starts_with('#') { line == "## Every law" } else { within };
        let found = cells(line);
        match find(found[0]).filter(|_| within && found.len() == 7) {
            Some(of) => {
                let [steps, rejected, events] = [of[7], of[8], of[10]];
                format!("| {} | {steps} | {rejected} | {events} |", found[..4].join(" | "))
            }
            None => line.to_owned(),
        }
    });
    lines.map(|line| line + "\n").collect()
}

/// The table of trajectories with the counts of the present solver.
fn solver(text: &str) -> String {
    let mut seen = 0;
    let lines = text.lines().map(|line| {
        let found = cells(line);
        match TRAJECTORIES.iter().find(|(row, _)| found.len() == 5 && *row == found[0]) {
            Some((_, case)) => {
                seen += 1;
                let [steps, rejected, ..] = of_reference(case);
                let (before, _) = line.trim_end_matches('|').rsplit_once('|').expect("five cells");
                format!("{before}| {steps}, {rejected} |")
            }
            None => line.to_owned(),
        }
    });
    let text = lines.map(|line| line + "\n").collect();
    assert_eq!(seen, TRAJECTORIES.len(), "rows of {SOLVER}");
    text
}

#[test]
fn counts_in_the_docs_are_those_of_the_solver() {
    let counted = laws(&read(LAWS));
    let pages = [
        (PERFORMANCE, performance(&read(PERFORMANCE), &counted)),
        (SOLVER, solver(&read(SOLVER))),
        (LAWS, counted.clone()),
    ];
    if std::env::var_os("SERVO_RECORD").is_some() {
        assert!(std::env::var_os("CI").is_none(), "SERVO_RECORD renews what is expected, which CI must not");
        pages.iter().for_each(|(file, text)| std::fs::write(path(file), text).expect(file));
        return;
    }
    for (file, expected) in pages {
        for (found, expected) in read(file).lines().zip(expected.lines()) {
            assert_eq!(found, expected, "{file}; if a change of the solver is meant: cargo xtask record");
        }
    }
}

/// The table of the page is a part of the table of all laws.
#[test]
fn times_of_the_page_are_those_of_the_table() {
    let (laws, page) = (read(LAWS), read(PERFORMANCE));
    let (_, section) = page.split_once("## Every law").expect("the section");
    let (section, _) = section.split_once("\n## ").expect("what follows the table");
    let mut rows = 0;
    for row in laws.lines().map(|line| line.split(',').collect::<Vec<_>>()).filter(|row| row[1] == "1") {
        let Some(line) = section.lines().find(|line| cells(line)[0] == row[0]) else { continue };
        let micro: Vec<String> = row[2..5].iter().map(|time| format!("{time} µs")).collect();
        assert_eq!(cells(line)[1..4], micro, "{}", row[0]);
        rows += 1;
    }
    assert_eq!(rows, 9);
}

/// The ratios of the page belong to one tolerance.
#[test]
fn ratios_of_the_page_are_those_of_the_table() {
    let (ratios, page) = (read(RATIOS), read(PERFORMANCE));
    let (_, section) = page.split_once("## Result").expect("the section");
    let rows: Vec<Vec<&str>> = ratios.lines().map(|line| line.split(',').collect()).collect();
    let of_page: Vec<_> = rows.iter().filter(|row| row[1] == "1e-6").collect();
    assert_eq!(of_page.len(), 6);
    for row in of_page {
        let line = section.lines().find(|line| cells(line)[0].replace(',', "") == row[0]).expect(row[0]);
        let expected: Vec<String> = row[2..].chunks(2).map(|it| format!("**{}** ({} µs)", it[0], it[1])).collect();
        assert_eq!(cells(line)[1..], expected, "{}", row[0]);
    }
}

/// Times in s of the break-away under constant voltages, in communication steps of a size.
fn break_away(tolerance: f64, step: f64) -> [f64; 3] {
    [("Stribeck", 5.6), ("Stribeck", 6.0), ("Coulomb", 7.0)].map(|(law, voltage)| {
        let rig = Rig::cylinder(law).set("solver.relativeTolerance", tolerance).set("valveVoltage", voltage);
        let mut running = rig.start().expect("a legal case");
        let mut ends = (1..).map(|index| f64::from(index) * step).take_while(|end| *end <= 1.0);
        let found = ends.find_map(|end| {
            let broken = running.simulation().advance_to_event(end).expect("a run");
            broken.then(|| running.simulation().time())
        });
        found.expect("a break-away within a second")
    })
}

/// The figures of `docs/interfaces.md`, to their one digit: the largest distances from the times at a tolerance of 1e-12.
#[test]
fn break_away_is_located_as_closely_as_the_page_says() {
    let page = read("docs/interfaces.md").replace('\n', " ");
    let exact = break_away(1e-12, 1e-3);
    assert_eq!(exact.map(|time| format!("{time:.2}")), ["0.36", "0.10", "0.03"]);
    for (tolerance, stated) in [(1e-6, "1e-8"), (1e-7, "2e-9"), (1e-8, "1e-9"), (1e-10, "6e-11")] {
        let found = [1e-3, 1e-2, 0.1, 1.0].map(|step| {
            let times = break_away(tolerance, step);
            farthest(&times, &exact)
        });
        assert_eq!(format!("{:.0e}", largest(found)), stated, "s, at {tolerance:e}: {found:?}");
        assert!(page.contains(&format!("{stated} s at ")), "{stated} s is on the page");
    }
}

/// The column "drift" of the table of laws.
fn stated_drift() -> BTreeMap<String, String> {
    let page = read("docs/friction-laws.md");
    let rows = page.lines().map(cells).filter(|row| row.len() == 9 && row[0].parse::<u32>().is_ok());
    rows.map(|row| (row[1].to_owned(), row[7].to_owned())).collect()
}

/// Displacement in m of a free mass on the bench in one second (ten periods, after twenty others) under a load that
/// oscillates between 1 and 5 N, below every break-away force and the elastic limit of ElastoPlastic.
fn drift(law: &str) -> f64 {
    let mut running = Rig::bench(law, "Free").set("appliedForce", 3.0).start().expect("a legal case");
    let mut swing = |begin: f64, seconds: f64| {
        for step in 0..(seconds * 1e3).round() as u32 {
            let time = begin + 1e-3 * f64::from(step);
            running.set("appliedForce", 3.0 + 2.0 * (TAU * 10.0 * time).sin());
            running.advance(time + 1e-3).expect("a run");
        }
        running.get("position")
    };
    let before = swing(0.0, 2.0);
    swing(2.0, 1.0) - before
}

/// A law that drifts or creeps moves by more than 0.1 um each second, another by less than a thousandth of a picometre.
#[test]
fn drift_is_what_the_table_of_laws_says() {
    let stated = stated_drift();
    assert_eq!(stated.len(), 26, "{stated:?}");
    let mut wrong = Vec::new();
    for (law, column) in stated {
        let found = drift(&law).abs();
        println!("{law}: {column}, {found:.1e} m/s");
        let fits = match column.as_str() {
            "" => true,
            "creeps" | "a free mass drifts" | "drifts" | "the force never, the position for finite `n`" => found > 1e-7,
            "none" | "none below its elastic limit" => found < 1e-15,
            "small" => found < 1e-7,
            other => panic!("{law}: {other} has no measure"),
        };
        if !fits {
            wrong.push(format!("{law}: {column}, yet {found:.1e} m/s"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
