//! Runs communication steps of 1 ms with a new input sample: `steps <library> <law> <number> [<parameter>=<value> ...]`, for a
//! profiler that counts instructions of an FMU's shared library. The voltages are worked out beforehand, always as many: the
//! sine of a host is no part of a step.

use std::env;
use std::path::Path;
use std::process::ExitCode;

use benchmark::case::{Case, DURATION, STEP, voltage};
use benchmark::host::{Host, load};

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [library, law, number, changes @ ..] = arguments.as_slice() else {
        return usage("three arguments are expected");
    };
    let Some(mut case) = Case::of(law) else { return usage(&format!("{law} is no friction law")) };
    let Ok(number) = number.parse::<u32>() else { return usage(&format!("{number} is no number of steps")) };
    for change in changes {
        let parts = change.split_once('=').and_then(|(name, value)| Some((name, value.parse().ok()?)));
        let Some((name, value)) = parts else { return usage(&format!("{change} is no change of a parameter")) };
        case = case.with(name, value);
    }
    let functions = match load(Path::new(library)) {
        Ok(functions) => functions,
        Err(problem) => return usage(&format!("{problem:#}")),
    };
    let mut host = Host::start_in(functions, &case, 1e-6);
    let rows = (DURATION / STEP).round() as u32;
    let voltages: Vec<f64> = (0..rows).map(|index| voltage(f64::from(index) * STEP)).collect();
    for voltage in voltages.iter().cycle().take(number as usize) {
        host.step(*voltage, STEP);
    }
    ExitCode::SUCCESS
}

fn usage(problem: &str) -> ExitCode {
    eprintln!("{problem}; usage: steps <library> <law> <number> [<parameter>=<value> ...]");
    ExitCode::from(2)
}
