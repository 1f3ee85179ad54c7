//! The default experiment of every model under every friction law, and of cylinders with options, as text for
//! `tests/platforms/host.c`, and what comes back.

use std::fmt::Write;

use anyhow::{Result, bail, ensure};
use pneumatic_servo::model::{Course, Experiment, Model};
use pneumatic_servo::models;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
use pneumatic_servo::variables::{Kind, Role, Variable};
use pneumatic_servo_fmu::guid;

/// The parameter that is varied, where a model has it.
const LAW: &str = "friction.law";

/// What changes together in a run with options: names and values.
type Changes = &'static [(&'static str, f64)];

/// Cylinders with options: everything a valve with hoses can have, and switching valves.
const OPTIONS: [(&str, Changes); 2] = [
    (
        "lines",
        &[
            ("friction.law", 14.0),
            ("valve.characteristic", 2.0),
            ("hoseA.length", 0.8),
            ("hoseB.length", 1.5),
            ("throttleA.C", 2e-9),
            ("cushion.length", 0.02),
            ("supply.volume", 1e-4),
            ("load.stiffness", 50.0),
            ("load.rest", 0.25),
            ("friction.position.amplitude", 0.2),
            ("friction.kappaDifference", 1e-6),
            ("sensor.position.lag", 5e-3),
            ("sensor.pressureA.noise", 500.0),
            ("sensor.pressureA.sampleTime", 2e-3),
        ],
    ),
    (
        "pulses",
        &[
            ("actuation", 3.0),
            ("friction.stribeck.FsInf", 14.0),
            ("friction.stribeck.kappaRatio", 1.5),
            ("friction.kappaA", 3e-7),
            ("sensor.force.resolution", 0.1),
            ("sensor.force.sampleTime", 1e-3),
        ],
    ),
];

/// The experiments of all models.
pub fn all() -> String {
    models::ALL.iter().map(experiment).collect()
}

fn experiment(model: &Model) -> String {
    let variables = (model.variables)();
    let (step, steps, courses) = (model.experiment.step_size, model.experiment.steps(), courses(model));
    let mut text = format!("experiment {} {steps} {:x} ", guid(model), step.to_bits());
    push(&mut text, courses.iter().map(|(reference, _)| *reference));
    for index in 0..steps {
        for (_, course) in &courses {
            push_word(&mut text, format_args!("{:x}", course.at(f64::from(index) * step).to_bits()));
        }
    }
    push(
        &mut text,
        variables
            .iter()
            .filter(|variable| variable.role == Role::Output && is_real(variable))
            .map(|variable| variable.reference),
    );
    match variables.find(LAW).map(|law| law.variable.kind) {
        Some(Kind::Enumeration(laws)) => {
            for (id, name, _) in laws.items {
                push_run(&mut text, &format!("{}_{name}", model.name), model, &[(LAW, f64::from(*id))]);
            }
        }
        _ => push_run(&mut text, model.name, model, &[]),
    }
    if model.name == MODEL.name {
        for (name, changes) in OPTIONS {
            push_run(&mut text, &format!("{}_{name}", model.name), model, changes);
        }
    }
    text
}

/// A run with changed parameters: the integers and choices among them, then the real ones.
fn push_run(text: &mut String, label: &str, model: &Model, changes: &[(&str, f64)]) {
    let entries = changes.iter().map(|(name, value)| {
        let entry = (model.variables)().find(name).unwrap_or_else(|| panic!("{name} is no variable of {}", model.name));
        (entry.variable, *value)
    });
    let (reals, others): (Vec<_>, Vec<_>) = entries.partition(|(variable, _)| is_real(variable));
    push_word(text, format_args!("run {label} {}", others.len()));
    for (variable, value) in others {
        push_word(text, format_args!("{} {value}", variable.reference));
    }
    push_word(text, format_args!("{}", reals.len()));
    for (variable, value) in reals {
        push_word(text, format_args!("{} {:x}", variable.reference, value.to_bits()));
    }
    text.push('\n');
}

/// The inputs that move, by their references. Where the default experiment moves none, the first one swings, so that
/// inputs are compared with every model.
fn courses(model: &Model) -> Vec<(u32, Course)> {
    let variables = (model.variables)();
    let Experiment { signals, stop_time, .. } = model.experiment;
    if signals.is_empty() {
        let swing = |input: &Variable| Course::Sine {
            mean: input.start.unwrap_or_default(),
            amplitude: input.nominal.unwrap_or(1.0),
            frequency: 3.0 / stop_time,
            delay: 0.0,
        };
        return variables.inputs().take(1).map(|input| (input.reference, swing(input))).collect();
    }
    let named = signals.iter().filter_map(|signal| Some((variables.find(signal.input)?, signal.course)));
    named.map(|(entry, course)| (entry.variable.reference, course)).collect()
}

fn is_real(variable: &Variable) -> bool {
    matches!(variable.kind, Kind::Real(_))
}

/// A list with its length before it.
fn push(text: &mut String, references: impl Iterator<Item = u32>) {
    let references: Vec<_> = references.collect();
    push_word(text, format_args!("{}", references.len()));
    for reference in references {
        push_word(text, format_args!("{reference}"));
    }
}

fn push_word(text: &mut String, word: std::fmt::Arguments<'_>) {
    write!(text, "{word} ").expect("a string takes any text");
}

/// The results must be those of every run to its end.
///
/// # Errors
/// When runs are missing.
pub fn complete(results: &str) -> Result<()> {
    let wanted = all().matches("run ").count();
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
    println!("{machine}: {runs} runs, {numbers} numbers, saved states included, are those of linux64 bit for bit");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const RESULTS: &str = "run A\n3ff0000000000000 0\nrun B\n0 1\ndone\n";

    #[test]
    fn equal_results_pass_whatever_their_line_ends() -> Result<()> {
        same("a machine", RESULTS, &RESULTS.replace('\n', "\r\n"))
    }

    #[test]
    fn a_bit_that_differs_is_shown() {
        let problem = same("a machine", RESULTS, &RESULTS.replace("0 1", "0 2")).unwrap_err().to_string();
        assert!(problem.contains("in B:") && problem.contains("a machine: 0 2"), "{problem}");
    }

    #[test]
    fn missing_and_surplus_lines_are_noticed() {
        assert!(same("a machine", RESULTS, "run A\n").is_err());
        assert!(same("a machine", "run A\n", RESULTS).is_err());
        assert!(complete(RESULTS).is_err());
    }

    #[test]
    fn every_model_has_its_experiment() {
        let text = all();
        assert_eq!(text.matches("experiment ").count(), models::ALL.len());
        assert!(text.contains("run PneumaticServoCylinder_LuGre 1 10000 14 0 \n"), "one choice, and no real parameter");
        assert!(text.contains("run PneumaticServoCylinder_pulses 1 1032 3 5 "), "one choice, and five real parameters");
        assert!(models::ALL.iter().all(|model| !courses(model).is_empty()));
    }
}
