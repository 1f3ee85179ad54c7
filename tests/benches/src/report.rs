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
