//! The experiments that `tests/platforms/host.c` runs, as text: the default experiment of every model under every
//! friction law, and of cylinders with options, by FMI 2.0; parts of them by FMI 3.0.

use std::fmt::Write;

use pneumatic_servo::model::{Course, Experiment, Model};
use pneumatic_servo::models;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
use pneumatic_servo::variables::{Kind, Role, Variable};
use pneumatic_servo_fmu::guid;
use pneumatic_servo_packaging::description::is_exchanged;

/// Name of co-simulation by FMI 2.0 in the host's text.
pub const FMI2: &str = "fmi2";
/// Name of co-simulation by FMI 3.0.
pub const FMI3: &str = "fmi3";
/// The same with event mode, where steps return at events.
pub const EVENTS: &str = "fmi3-events";
/// Model exchange by FMI 3.0.
const EXCHANGE: &str = "fmi3-exchange";

/// The ways to run the library by FMI 3.0, and the parts of the experiment that they take.
const FACES: [(&str, Part); 3] = [(FMI3, 4), (EVENTS, 4), (EXCHANGE, 20)];
/// The laws under which FMI 3.0 is run: a set-valued one, one with memory and one with samples.
const LAWS_OF_FMI3: [&str; 3] = ["Stribeck", "LuGre", "DNLRX"];

/// A fraction of the experiment, 4 for the first quarter.
pub type Part = u32;

/// All of an experiment.
pub const WHOLE: Part = 1;
/// What shows whether bits agree: one reversal of the cylinder, and its stop.
pub const QUARTER: Part = 4;

/// Runs that would take more than half of the time together, in an emulator minutes, and their parts.
const LONG: [(&str, Part); 3] = [("Festoon_Bristle", 20), ("FrictionBench_Bristle", 20), ("Festoon_BlimanSorine", 4)];

/// The parameter that is varied, where a model has it.
const LAW: &str = "friction.law";

/// Simultaneous changes in a run with options: names and values.
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

/// The experiments of all models, or a part of each.
pub fn all(part: Part) -> String {
    models::ALL.iter().map(|model| part_of(model, part)).collect()
}

/// The whole experiments of a model.
pub fn of(model: &Model) -> String {
    part_of(model, WHOLE)
}

fn part_of(model: &Model, part: Part) -> String {
    let variables = model.table();
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
    for run in runs(model, part) {
        push_run(&mut text, model, &run);
    }
    text
}

/// A run: the kind of calls, the part of the experiment, and the settings that differ from the defaults.
struct Run {
    face: &'static str,
    label: String,
    steps: u32,
    changes: Vec<(&'static str, f64)>,
}

/// The runs of which no more than a part is wanted.
fn runs(model: &Model, most: Part) -> Vec<Run> {
    let steps = |part: Part| model.experiment.steps() / part.max(most);
    let all = variants(model);
    let of_fmi2 = all.iter().map(|(label, _, changes)| {
        let part = LONG.iter().find(|(long, _)| long == label).map_or(WHOLE, |(_, part)| *part);
        Run { face: FMI2, label: label.clone(), steps: steps(part), changes: changes.clone() }
    });
    let of_fmi3 = all.iter().filter(|(_, law, _)| law.is_none_or(|law| LAWS_OF_FMI3.contains(&law)));
    let of_fmi3 = of_fmi3.flat_map(|(label, _, changes)| {
        FACES.map(|(face, part)| Run { face, label: label.clone(), steps: steps(part), changes: changes.clone() })
    });
    of_fmi2.chain(of_fmi3.filter(|run| run.face != EXCHANGE || is_exchanged(model))).collect()
}

/// A label, the friction law where it is varied, and the settings that differ from the defaults.
type Variant = (String, Option<&'static str>, Vec<(&'static str, f64)>);

fn variants(model: &Model) -> Vec<Variant> {
    let mut variants = match model.table().find(LAW).map(|law| law.variable.kind) {
        Some(Kind::Enumeration(laws)) => {
            let of = |(id, name, _): &(i32, &'static str, _)| {
                (format!("{}_{name}", model.name), Some(*name), vec![(LAW, f64::from(*id))])
            };
            laws.items.iter().map(of).collect()
        }
        _ => vec![(model.name.to_owned(), None, Vec::new())],
    };
    if model.name == MODEL.name {
        variants.extend(OPTIONS.map(|(name, changes)| (format!("{}_{name}", model.name), None, changes.to_vec())));
    }
    variants
}

/// A run with changed parameters: the choices among them, then the real ones.
fn push_run(text: &mut String, model: &Model, run: &Run) {
    let entries = run.changes.iter().map(|(name, value)| {
        let entry = model.table().find(name).unwrap_or_else(|| panic!("{name} is no variable of {}", model.name));
        (entry.variable, *value)
    });
    let (reals, choices): (Vec<_>, Vec<_>) = entries.partition(|(variable, _)| is_real(variable));
    push_word(text, format_args!("run {} {} {} {}", run.face, run.label, run.steps, choices.len()));
    for (variable, value) in choices {
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
    let variables = model.table();
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
