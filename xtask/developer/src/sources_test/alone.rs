//! A cylinder with one law in a control loop, `examples/own/loop`: made as its author makes it, and compiled and run on this machine
//! and on a Cortex-M7. Instances are refused unless they give the fingerprint of the run in Rust.

use anyhow::{Result, ensure};
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::workspace::Workspace;

use super::compiled::Written;
use super::target::Target;

/// The laws that the crate can be compiled for: the feature, and the name of the law.
const LAWS: [(&str, &str); 3] = [("stribeck", "Stribeck"), ("", "LuGre"), ("gms", "GMS")];
/// The number of the one law.
const NUMBER: i32 = 1000;

/// Makes, compiles and runs the loop with each law.
///
/// # Errors
/// When a tool fails, a bit differs, or the page says something else of what a microcontroller needs.
pub fn run(workspace: &Workspace) -> Result<()> {
    let mut needs = Ok(());
    for (feature, law) in LAWS {
        heading(&format!("Sources in C: a control loop under {law} alone"));
        let mut cargo = process::cargo();
        cargo
            .args(["run", "--profile", "quick", "--example", "package", "--features"])
            .arg(format!("package,{feature}"));
        cargo.args(["--manifest-path", "examples/own/loop/Cargo.toml", "--target-dir"]).arg(&workspace.target);
        if !feature.is_empty() {
            cargo.args(["--", "--features", feature]);
        }
        process::run(cargo.current_dir(&workspace.home).env("CARGO_TARGET_DIR", &workspace.target))?;
        let written = Written::of_loop(workspace.target.join("loop/PneumaticServoCylinder"))?;
        let mut bits = Vec::new();
        for target in [Target::Linux, Target::CortexM7] {
            let compiler = target.compiler().refusing();
            let plant = written.plant(&compiler)?;
            let found = target.run(workspace, &written, &plant, &(NUMBER..NUMBER + 1))?;
            if target.has_no_system() {
                needs = needs.and(found.needs.compare_alone(workspace, law, &compiler));
            }
            bits.push(found.bits);
        }
        ensure!(
            bits[0] == bits[1],
            "{} computes other bits:\n{}\ninstead of\n{}",
            Target::CortexM7.name(),
            bits[1],
            bits[0]
        );
        print!("{}", bits[0]);
    }
    needs
}
