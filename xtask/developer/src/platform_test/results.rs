//! Output of the host, compared with the expected one.

use anyhow::{Context, Result, bail, ensure};

use super::experiment::{EVENTS, FMI2, FMI3};

/// The results must contain every run of the experiments to its end.
///
/// # Errors
/// When runs are missing.
pub fn complete(experiments: &str, results: &str) -> Result<()> {
    let wanted = experiments.matches("run ").count();
    let found = results.lines().filter(|line| line.starts_with("run ")).count();
    ensure!(found == wanted && results.lines().last() == Some("done"), "{found} of {wanted} runs came to their end");
    Ok(())
}

/// Every bit of the results of two machines must agree.
///
/// # Errors
/// Names the first run and line where they differ.
pub fn same(machine: &str, reference: &str, results: &str) -> Result<()> {
    let (mut run, mut runs, mut numbers) = ("", 0, 0_usize);
    let mut ours = results.lines();
    for expected in reference.lines() {
        if let Some(name) = expected.strip_prefix("run ") {
            (run, runs) = (name, runs + 1);
        }
        numbers += expected.split(' ').count();
        let found = ours.next().unwrap_or("nothing");
        if found != expected {
            bail!("{machine} departs from linux64 in {run}:\n  linux64: {expected}\n  {machine}: {found}");
        }
    }
    ensure!(ours.next().is_none(), "{machine} gave more than linux64");
    println!("{machine}: {runs} runs, {numbers} numbers, saved states included, equal linux64's bit for bit");
    Ok(())
}

/// Both versions of the standard, and steps with and without event mode, must give the same outputs, as far as the shorter
/// of two runs goes.
///
/// # Errors
/// Names the first run and line where they differ, or a run by FMI 3.0 alone.
pub fn versions_agree(results: &str) -> Result<()> {
    let runs: Vec<_> = results.split("run ").skip(1).map(|run| run.split_once('\n').unwrap_or((run, ""))).collect();
    let (mut compared, mut points) = (0, 0);
    for (name, by_fmi3) in &runs {
        let Some((face, label)) = name.split_once(' ').filter(|(face, _)| [FMI3, EVENTS].contains(face)) else {
            continue;
        };
        let twin = runs.iter().find(|(name, _)| *name == format!("{FMI2} {label}"));
        let (_, by_fmi2) = twin.with_context(|| format!("{label} was run by FMI 3.0 only"))?;
        for (found, expected) in outputs(by_fmi3).zip(outputs(by_fmi2)) {
            ensure!(
                found == expected,
                "{face} departs from {FMI2} in {label}:\n  {FMI2}: {expected}\n  {face}: {found}"
            );
            points += 1;
        }
        compared += 1;
    }
    ensure!(points > 0, "there is nothing to compare");
    println!("{compared} runs by FMI 3.0, {points} communication points, are those by FMI 2.0 bit for bit");
    Ok(())
}

/// The rows of a run without the saved state.
fn outputs(run: &str) -> impl Iterator<Item = &str> {
    run.lines().filter(|line| !line.starts_with("state") && *line != "done")
}
