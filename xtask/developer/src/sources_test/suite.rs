//! The tests of the C interface, run on a library that is compiled from C.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
use pneumatic_servo_packaging::library::Library;
use pneumatic_servo_packaging::process;
use pneumatic_servo_packaging::workspace::Workspace;

/// Tests that need another model than the cylinder besides, of which its library knows nothing.
const OF_TWO_MODELS: [&str; 3] = [
    "derivatives_by_time_hold_inputs_and_states",
    "state_of_another_model_is_refused",
    "model_without_continuous_states_is_there_for_co_simulation_only",
];
/// Common parts of the names of tests of all models; most tests are about the cylinder.
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
        std::fs::write(&rust, Library::for_tests(workspace)?.bytes).context("cannot write the library in Rust")?;
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
    if model.table().number_of_states() == 0 {
        // Forged states need a model with states.
        fuzz.args(["--skip", "model_exchange", "--skip", "forged_states"]);
    }
    // Enough for every kind of call with a single model.
    process::run(fuzz.env("SERVO_FUZZ_CALLS", "60000").env("SERVO_FUZZ_SEED", (1 + 1000 * round).to_string()))
}

/// A test of the C interface, with a library of one model in the place of that in Rust.
fn of(workspace: &Workspace, test: &str, model: &Model, library: &Path) -> Command {
    let mut cargo = process::cargo();
    cargo.args(["test", "--test", test, "--"]);
    cargo.current_dir(&workspace.root).env("CARGO_TARGET_DIR", &workspace.target);
    cargo.env("FMU_LIBRARY", library).env("FMU_MODEL", model.name);
    cargo
}
