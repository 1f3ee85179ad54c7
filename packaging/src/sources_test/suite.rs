//! The tests of the C interface, run on a library that is compiled from C.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

use crate::process;
use crate::workspace::Workspace;

/// Tests that need another model than the cylinder besides, of which its library knows nothing.
const OF_TWO_MODELS: [&str; 3] = [
    "derivatives_by_time_hold_inputs_and_states",
    "state_of_another_model_is_refused",
    "model_without_continuous_states_is_there_for_co_simulation_only",
];
/// What the names of tests of all models have in common; most tests are about the cylinder.
const OF_ALL_MODELS: [&str; 6] =
    ["every_model", "all_models", "nominals_are_those", "start_values_of_states", "version_is", "version_and_platform"];

/// Runs the tests, and saves states in one library and goes on with them in the other, both ways.
///
/// # Errors
/// When a test fails.
pub fn run(workspace: &Workspace, model: &Model, library: &Path) -> Result<()> {
    let of_c = |test: &str| of(workspace, test, model, library);
    if model.name == MODEL.name {
        process::run(of_c("c_interface").args(OF_TWO_MODELS.iter().flat_map(|name| ["--skip", name])))?;
        let rust = library.with_file_name("native.so");
        std::fs::write(&rust, crate::build::for_this_machine(workspace)?)
            .context("cannot write the library in Rust")?;
        for (one, other) in [(library, rust.as_path()), (rust.as_path(), library)] {
            let mut both = of(workspace, "c_interface", model, one);
            process::run(both.arg("in_another_process").env("FMU_LIBRARY_OF_CHILD", other))?;
        }
    } else {
        process::run(of_c("c_interface").args(OF_ALL_MODELS))?;
    }
    fuzz(workspace, model, library, 0)
}

/// Random calls, other ones in each round.
///
/// # Errors
/// When a call does not do what the model does.
pub fn fuzz(workspace: &Workspace, model: &Model, library: &Path, round: u64) -> Result<()> {
    let mut fuzz = of(workspace, "fuzz", model, library);
    if (model.variables)().number_of_states() == 0 {
        // Forged states are those of models with states.
        fuzz.args(["--skip", "model_exchange", "--skip", "forged_states"]);
    }
    // So many that every kind of call comes about with a single model.
    process::run(fuzz.env("SERVO_FUZZ_CALLS", "60000").env("SERVO_FUZZ_SEED", (1 + 1000 * round).to_string()))
}

/// A test of the C interface, with a library of one model in the place of that in Rust.
fn of(workspace: &Workspace, test: &str, model: &Model, library: &Path) -> Command {
    let mut cargo = process::cargo();
    cargo.args(["test", "--package", "pneumatic-servo-fmu", "--test", test, "--"]);
    cargo.current_dir(&workspace.root).env("CARGO_TARGET_DIR", &workspace.target);
    cargo.env("FMU_LIBRARY", library).env("FMU_MODEL", model.name);
    cargo
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use pneumatic_servo::models::position_controller;

    use super::*;
    use crate::files;
    use crate::gates::made;
    use crate::stand_in::{self, Answer, StandIn, Started};

    /// What is started for the tests of a model.
    fn started(name: &str, model: &Model) -> Result<Vec<Started>> {
        let folder = files::scratch(name);
        let (workspace, built) = (Workspace::of_a_test(&folder), folder.join("built.so"));
        files::write(&built, made::linux())?;
        let machine =
            StandIn::new(move |command| command.says("rustc --release").then(|| stand_in::built(command, &built)));
        let (outcome, started) = machine.does(|| run(&workspace, model, &folder.join("library.so")));
        outcome?;
        std::fs::remove_dir_all(&folder)?;
        let tests = |it: &Started| it.line().starts_with("cargo test --package pneumatic-servo-fmu ");
        Ok(started.into_iter().filter(tests).collect())
    }

    /// All tests of the cylinder but those of two models, and random calls of every kind.
    #[test]
    fn cylinder_meets_the_tests_of_one_model() -> Result<()> {
        let started = started("suite-cylinder", &MODEL)?;
        let [first, one, other, fuzz] = &started[..] else { panic!("{started:#?}") };
        assert!(
            OF_TWO_MODELS.iter().all(|name| first.says(&format!("--skip {name}"))) && first.says("--test c_interface")
        );
        assert!(one.says("in_another_process") && other.says("in_another_process"));
        assert!(fuzz.line().ends_with("--test fuzz --"), "{fuzz:?}");
        for command in &started {
            assert_eq!(command.variable("FMU_MODEL"), MODEL.name);
        }
        assert!(first.variable("FMU_LIBRARY").ends_with("/library.so"));
        Ok(())
    }

    /// Only those that ask every model; no state is forged where there is none.
    #[test]
    fn another_model_meets_the_tests_of_every_model() -> Result<()> {
        let started = started("suite-controller", &position_controller::MODEL)?;
        let [first, fuzz] = &started[..] else { panic!("{started:#?}") };
        assert!(OF_ALL_MODELS.iter().all(|name| first.says(name)) && !first.says("--skip"), "{first:?}");
        assert!(fuzz.says("--skip model_exchange") && fuzz.says("--skip forged_states"), "{fuzz:?}");
        assert_eq!(fuzz.variable("SERVO_FUZZ_SEED"), "1");
        Ok(())
    }

    #[test]
    fn a_test_that_fails_is_an_error() {
        let workspace = Workspace::of_a_test("/target".as_ref());
        for model in [&MODEL, &position_controller::MODEL] {
            let failing = StandIn::new(|_| Some(Answer::Fails));
            assert!(failing.does(|| run(&workspace, model, Path::new("library.so"))).0.is_err());
        }
    }
}
