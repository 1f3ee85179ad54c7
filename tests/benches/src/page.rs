//! Results of a run in `docs/performance.md`: its tables as they stand there, and the files beside it.

use std::fmt::Write as _;

use crate::latency::Latency;
use crate::precision::{Curve, ratio};
use crate::report::Comparison;

/// Rivals of the page: the solver, and what it is called there.
const RIVALS: [(&str, &str); 6] = [
    ("cvode restarted", "CVODE restarted"),
    ("cvode smooth", "CVODE free smooth"),
    ("cvode free", "CVODE free staircase"),
    ("bdf restarted", "diffsol restarted"),
    ("bdf smooth", "diffsol free smooth"),
    ("bdf free", "diffsol free staircase"),
];

/// Rivals of the table at its head: the solver, what it is called there, and what its numbers mean.
const HEAD: [(&str, &str, &str); 4] = [
    (
        "cvode smooth",
        "CVODE, *free*, smooth input",
        "one run of a solver that is given the voltage as a function of time, as a modeller writes it, divided by the milliseconds",
    ),
    ("bdf smooth", "diffsol, *free*, smooth input", "the same by the crate diffsol"),
    (
        "cvode free",
        "CVODE, *free*, staircase",
        "one run of a solver that knows the whole staircase of inputs and crosses its jumps",
    ),
    (
        "cvode restarted",
        "CVODE, *restarted*",
        "the same step by a solver that starts afresh at each new input, as an FMU has to",
    ),
];
/// Laws with a column there.
const HEAD_LAWS: [&str; 2] = ["Stribeck", "LuGre"];

/// Laws with a row in the table of laws.
const LAWS: [&str; 9] = ["Coulomb", "Stribeck", "Polito", "Dahl", "Bristle", "LuGre", "Leuven", "GMS", "ElastoPlastic"];

/// Tolerances of the rivals in the file of ratios.
const TOLERANCES: [f64; 3] = [1e-5, 1e-6, 1e-7];

/// A law, the size of communication steps in s, and what these cost.
pub type Row = (String, f64, Latency);

/// The table at the head: costs at a tolerance of the rivals and at our default one, and how many times more they are at
/// equal errors.
pub fn head(comparisons: &[Comparison], tolerance: f64, ours: f64) -> String {
    let shown: Vec<_> = comparisons.iter().filter(|it| HEAD_LAWS.contains(&&*it.name)).collect();
    let laws: Vec<_> = shown.iter().map(|it| format!("law {}", it.name)).collect();
    let own: Vec<_> = shown.iter().map(|it| micro(it.curves[0].near(ours).cost)).collect();
    let mut text = format!(
        "| what | {} | at equal errors | what it means |\n|---|{}--:|---|\n| this library | {} | 1 | a step of 1 ms with a \
         fresh input, mean over 3 s, through `fmi2SetReal` and `fmi2DoStep` |\n",
        laws.join(" | "),
        "--:|".repeat(laws.len()),
        own.join(" | "),
    );
    for (solver, name, meaning) in HEAD {
        let curves: Vec<_> = shown.iter().filter_map(|it| Some((&it.curves[0], curve(it, solver)?))).collect();
        if curves.len() < shown.len() || curves.is_empty() {
            continue;
        }
        let costs: Vec<_> = curves.iter().map(|(_, rival)| micro(rival.near(tolerance).cost)).collect();
        let mut ratios: Vec<_> =
            curves.iter().map(|(ours, rival)| two_digits(least_ratio(ours, rival, tolerance))).collect();
        ratios.dedup();
        let _ = writeln!(text, "| {name} | {} | {} times | {meaning} |", costs.join(" | "), ratios.join(" and "));
    }
    text
}

/// The table of ratios at the errors of the rivals at a tolerance, with what a step costs these.
pub fn ratios(comparisons: &[Comparison], tolerance: f64) -> String {
    let names = RIVALS.map(|(_, name)| name).join(" | ");
    let mut text = format!("| law | {names} |\n|---|{}\n", "---|".repeat(RIVALS.len()));
    for comparison in comparisons {
        let cells = cells(comparison, tolerance).map(|cell| match cell {
            [Some(ratio), Some(cost)] => format!("**{ratio}** ({cost} µs)"),
            _ => "-".to_owned(),
        });
        let _ = writeln!(text, "| {} | {} |", comparison.name, cells.join(" | "));
    }
    text
}

/// The file of ratios.
pub fn ratio_file(comparisons: &[Comparison]) -> String {
    let names = RIVALS.map(|(_, name)| format!("{name} ratio,{name} us per step")).join(",");
    let mut text = format!("law,tolerance,{names}\n");
    for tolerance in TOLERANCES {
        for comparison in comparisons {
            let cells = cells(comparison, tolerance).map(|cell| cell.map(Option::unwrap_or_default).join(","));
            let _ = writeln!(text, "{},{tolerance:e},{}", comparison.name.replace(',', ""), cells.join(","));
        }
    }
    text
}

/// The table of laws, in communication steps of 1 ms.
pub fn laws(rows: &[Row]) -> String {
    let mut text = String::from(
        "| law | mean | median | 99.9 % | solver steps | rejected | events |\n|---|--:|--:|--:|--:|--:|--:|\n",
    );
    for (name, _, it) in rows.iter().filter(|(name, size, _)| *size == 1e-3 && LAWS.contains(&&**name)) {
        let [steps, rejected, _, events] = it.counters;
        let [mean, median, rare] = [it.mean, it.median, it.rare].map(|cost| cost * 1e-3);
        let _ = writeln!(
            text,
            "| {name} | {mean:.2} µs | {median:.2} µs | {rare:.1} µs | {steps} | {rejected} | {events} |"
        );
    }
    text
}

/// The file of laws.
pub fn law_file(rows: &[Row]) -> String {
    let mut text = String::from(
        "law,step in ms,mean in us,median in us,99.9 % in us,maximum in us,99.9 % / median,solver steps,rejected,Jacobians,\
         events\n",
    );
    for (name, size, it) in rows {
        let [mean, median, rare, worst] = [it.mean, it.median, it.rare, it.worst].map(|cost| cost * 1e-3);
        let _ = writeln!(
            text,
            "{},{:.0},{mean:.2},{median:.2},{rare:.1},{worst:.1},{:.1},{}",
            name.replace(',', ""),
            size * 1e3,
            rare / median,
            it.counters.map(|count| count.to_string()).join(","),
        );
    }
    text
}

fn curve<'a>(comparison: &'a Comparison, solver: &str) -> Option<&'a Curve> {
    comparison.curves.iter().find(|curve| curve.solver.name() == solver)
}

/// Of each rival how many times more a step costs at its errors at a tolerance, and what it costs in µs.
fn cells(comparison: &Comparison, tolerance: f64) -> [[Option<String>; 2]; RIVALS.len()] {
    RIVALS.map(|(solver, _)| {
        let rival = curve(comparison, solver);
        let ratio = rival.and_then(|rival| least_ratio(&comparison.curves[0], rival, tolerance));
        let cost = rival.map(|rival| rival.near(tolerance).cost * 1e-3);
        [ratio, cost].map(|number| number.map(|number| format!("{number:.1}")))
    })
}

/// The smaller of the ratios at equal errors of position and friction force.
fn least_ratio(ours: &Curve, rival: &Curve, tolerance: f64) -> Option<f64> {
    ratio(ours, rival, tolerance).map(|[position, friction]| position.min(friction))
}

fn two_digits(ratio: Option<f64>) -> String {
    let digits = |ratio: f64| usize::from(ratio < 10.0);
    ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.0$}", digits(ratio)))
}

/// Nanoseconds as microseconds with two digits.
fn micro(nanoseconds: f64) -> String {
    let digits = if nanoseconds < 1e3 { 2 } else { usize::from(nanoseconds < 1e4) };
    format!("{:.digits$} µs", nanoseconds * 1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Deviation;
    use crate::plant::Coupling;
    use crate::precision::{Point, Solver};
    use crate::rival::{Method, Rival};

    const SMOOTH: Solver = Solver::Rival(Rival { method: Method::Bdf, coupling: Coupling::Smooth });

    fn curve(solver: Solver, points: &[(f64, f64, f64)]) -> Curve {
        let point = |&(tolerance, cost, error): &(f64, f64, f64)| {
            let deviation = Deviation { position: error, friction: 1e3 * error };
            Point { tolerance, cost, deviation }
        };
        Curve { solver, points: points.iter().map(point).collect() }
    }

    /// At the error of the rival, 1e-7, ours costs 500 ns: half way, in logarithms, between 250 and 1000 ns.
    fn comparison(name: &str, cost: f64) -> Comparison {
        let ours = curve(Solver::Ours, &[(1e-5, 250.0, 1e-6), (1e-6, 1000.0, 1e-8)]);
        Comparison {
            name: name.to_owned(),
            curves: vec![ours, curve(SMOOTH, &[(1e-5, 900.0, 1e-6), (1e-6, cost, 1e-7)])],
        }
    }

    #[test]
    fn head_has_costs_and_ratios_of_its_laws() {
        let all = [("Stribeck", 2000.0), ("Dahl", 7000.0), ("LuGre", 15_000.0)];
        let table = head(&all.map(|(name, cost)| comparison(name, cost)), 1e-6, 1e-6);
        let lines: Vec<_> = table.lines().collect();
        assert_eq!(lines[0], "| what | law Stribeck | law LuGre | at equal errors | what it means |");
        assert!(lines[2].starts_with("| this library | 1.0 µs | 1.0 µs | 1 |"), "{table}");
        let wanted =
            "| diffsol, *free*, smooth input | 2.0 µs | 15 µs | 4.0 and 30 times | the same by the crate diffsol |";
        assert_eq!(lines[3..], [wanted]);
    }

    /// The rows of page and file have the same numbers; an unmeasured rival has none.
    #[test]
    fn ratios_of_page_and_file_are_the_same() {
        let comparisons = [comparison("LuGre, stiff", 2000.0)];
        let (page, file) = (ratios(&comparisons, 1e-6), ratio_file(&comparisons));
        assert!(page.ends_with("| LuGre, stiff | - | - | - | - | **4.0** (2.0 µs) | - |\n"), "{page}");
        assert_eq!(file.lines().nth(2), Some("LuGre stiff,1e-6,,,,,,,,,4.0,2.0,,"));
    }

    #[test]
    fn laws_of_page_and_file_are_the_same() {
        let found = Latency {
            mean: 284.0,
            median: 256.0,
            rare: 1410.0,
            worst: 1600.0,
            counters: [3106, 39, 0, 11],
            calls: 3000,
        };
        let rows = [("Stribeck", 1e-3), ("Stribeck", 1e-2), ("None", 1e-3)];
        let rows = rows.map(|(name, size)| (name.to_owned(), size, found.clone()));
        let (page, file) = (laws(&rows), law_file(&rows));
        let rows: Vec<_> = page.lines().skip(2).collect();
        assert_eq!(rows, ["| Stribeck | 0.28 µs | 0.26 µs | 1.4 µs | 3106 | 39 | 11 |"]);
        assert_eq!(file.lines().nth(1), Some("Stribeck,1,0.28,0.26,1.4,1.6,5.5,3106,39,0,11"));
        assert_eq!(file.lines().count(), 4);
    }
}
