//! The report, the measured points and the figure.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use anyhow::{Context, Result, bail};

use crate::latency::Latency;
use crate::precision::{Curve, Solver, ratio};

/// Results of one case of the comparison.
pub struct Comparison {
    /// Name of the case.
    pub name: String,
    /// One curve per solver, ours first.
    pub curves: Vec<Curve>,
}

/// The folder of the results, `bench` in the target folder.
///
/// # Errors
/// When it cannot be made.
pub fn folder() -> Result<PathBuf> {
    // A benchmark runs in the folder of its package; the program itself is in target/release/deps.
    let program = env::current_exe()?;
    let target = program.ancestors().nth(3).context("the target folder")?;
    let folder = target.join("bench");
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    Ok(folder)
}

/// The table of communication steps.
pub fn latency_table(rows: &[(String, f64, Latency)]) -> String {
    let mut text = String::from(
        "| law | step | mean | median | 99.9 % | maximum | 99.9 % / median | solver steps | rejected | Jacobians | events |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (name, size, it) in rows {
        let [steps, rejected, jacobians, events] = it.counters;
        let micro = |nanoseconds: f64| nanoseconds * 1e-3;
        let _ = writeln!(
            text,
            "| {name} | {:.0} ms | {:.2} us | {:.2} us | {:.1} us | {:.1} us | {:.1} | {steps} | {rejected} | {jacobians} | {events} |",
            size * 1e3,
            micro(it.mean),
            micro(it.median),
            micro(it.rare),
            micro(it.worst),
            it.rare / it.median,
        );
    }
    text
}

/// The table of ratios at the errors of a rival at a tolerance.
pub fn ratio_table(comparisons: &[Comparison], tolerance: f64) -> String {
    let rivals = &Solver::ALL[1..];
    let names: Vec<String> = rivals.iter().map(|rival| rival.name()).collect();
    let mut text = format!("| law | {} |\n|---|{}\n", names.join(" | "), "---|".repeat(rivals.len()));
    for Comparison { name, curves } in comparisons {
        let cells = curves[1..].iter().map(|rival| match ratio(&curves[0], rival, tolerance) {
            Some([position, friction]) => format!(
                "**{:.1}** ({position:.1}, {friction:.1}; {:.1} us)",
                position.min(friction),
                rival.near(tolerance).cost * 1e-3
            ),
            None => "-".to_owned(),
        });
        let _ = writeln!(text, "| {name} | {} |", cells.collect::<Vec<_>>().join(" | "));
    }
    text
}

/// Rivals at the head of docs/performance.md: what they are called there, and what their numbers mean.
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

/// The table at the head of docs/performance.md, with a column for each law that was compared: costs at a tolerance of the
/// rivals and at our default one, and how many times more they are at equal errors.
pub fn head_table(comparisons: &[Comparison], tolerance: f64, ours: f64) -> String {
    let laws: Vec<_> = comparisons.iter().map(|it| format!("law {}", it.name)).collect();
    let own: Vec<_> = comparisons.iter().map(|it| micro(it.curves[0].near(ours).cost)).collect();
    let mut text = format!(
        "| what | {} | at equal errors | what it means |\n|---|{}--:|---|\n| this library | {} | 1 | a step of 1 ms with a \
         fresh input, mean over 3 s, through `fmi2SetReal` and `fmi2DoStep` |\n",
        laws.join(" | "),
        "--:|".repeat(laws.len()),
        own.join(" | "),
    );
    for (solver, name, meaning) in HEAD {
        let curves: Vec<_> = comparisons
            .iter()
            .filter_map(|it| Some((&it.curves[0], it.curves.iter().find(|curve| curve.solver.name() == solver)?)))
            .collect();
        if curves.len() < comparisons.len() || curves.is_empty() {
            continue;
        }
        let costs: Vec<_> = curves.iter().map(|(_, rival)| micro(rival.near(tolerance).cost)).collect();
        let mut ratios: Vec<_> = curves
            .iter()
            .map(|(ours, rival)| match ratio(ours, rival, tolerance) {
                Some([position, friction]) => format!("{:.0}", position.min(friction)),
                None => "-".to_owned(),
            })
            .collect();
        ratios.dedup();
        let _ = writeln!(text, "| {name} | {} | {} times | {meaning} |", costs.join(" | "), ratios.join(" and "));
    }
    text
}

/// Nanoseconds as microseconds with two digits.
fn micro(nanoseconds: f64) -> String {
    let digits = if nanoseconds < 1e3 { 2 } else { usize::from(nanoseconds < 1e4) };
    format!("{:.digits$} µs", nanoseconds * 1e-3)
}

/// Every measured point.
pub fn points(comparisons: &[Comparison]) -> String {
    let mut text = String::from("law,solver,tolerance,nanoseconds per step,position error in m,friction error in N\n");
    for Comparison { name, curves } in comparisons {
        for Curve { solver, points } in curves {
            for it in points {
                let (solver, name) = (solver.name(), name.replace(',', ""));
                let (position, friction) = (it.deviation.position, it.deviation.friction);
                let _ =
                    writeln!(text, "{name},{solver},{:e},{:.0},{position:.3e},{friction:.3e}", it.tolerance, it.cost);
            }
        }
    }
    text
}

/// Draws the points with the Python environment that the packaging makes in the target folder.
///
/// # Errors
/// When that environment is missing or the drawing fails.
pub fn draw(points: &Path, figure: &Path) -> Result<()> {
    let target = figure.ancestors().nth(2).context("the target folder")?;
    let python = target.join("venv").join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    if !python.exists() {
        bail!("{} is missing: `cargo xtask package` makes it", python.display());
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("figure.py");
    let status = Command::new(python).env("MPLBACKEND", "Agg").arg(script).arg(points).arg(figure).status()?;
    if !status.success() {
        bail!("the figure cannot be drawn");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Deviation;
    use crate::precision::Point;
    use crate::rival::{Coupling, Method, Rival};

    fn curve(solver: Solver, points: &[(f64, f64, f64)]) -> Curve {
        let point = |&(tolerance, cost, error): &(f64, f64, f64)| {
            let deviation = Deviation { position: error, friction: 1e3 * error };
            Point { tolerance, cost, deviation }
        };
        Curve { solver, points: points.iter().map(point).collect() }
    }

    /// At the error of the rival, 1e-7, ours costs 500 ns: half way, in logarithms, between 250 and 1000 ns.
    #[test]
    fn the_table_of_the_page_has_costs_and_ratios_of_each_law() {
        let rival = Solver::Rival(Rival { method: Method::Bdf, coupling: Coupling::Smooth });
        let ours = curve(Solver::Ours, &[(1e-5, 250.0, 1e-6), (1e-6, 1000.0, 1e-8)]);
        let comparison = |name: &str, cost: f64| Comparison {
            name: name.to_owned(),
            curves: vec![ours.clone(), curve(rival, &[(1e-5, 900.0, 1e-6), (1e-6, cost, 1e-7)])],
        };
        let table = head_table(&[comparison("Stribeck", 2000.0), comparison("LuGre", 15_000.0)], 1e-6, 1e-6);
        let lines: Vec<_> = table.lines().collect();
        assert_eq!(lines[0], "| what | law Stribeck | law LuGre | at equal errors | what it means |");
        assert!(lines[2].starts_with("| this library | 1.0 µs | 1.0 µs | 1 |"), "{table}");
        let wanted =
            "| diffsol, *free*, smooth input | 2.0 µs | 15 µs | 4 and 30 times | the same by the crate diffsol |";
        assert_eq!(lines[3..], [wanted]);
    }
}
