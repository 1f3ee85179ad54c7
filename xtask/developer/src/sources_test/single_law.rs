//! A cylinder with one law in a control loop, `examples/own/loop`: made as its author makes it, and compiled and run on this machine
//! and on a Cortex-M7. Instances are refused unless they give the fingerprint of the run in Rust.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Result, ensure};
use pneumatic_servo_packaging::files;
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::tools::Tool;
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
        // Its own target directory, as an author has: this program holds the lock of the other.
        process::run(cargo.current_dir(&workspace.home).env("CARGO_TARGET_DIR", workspace.target.join("own")))?;
        let written = Written::of_loop(folder(workspace))?;
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
    misra(workspace)?;
    needs
}

/// Where the author's program leaves the sources.
fn folder(workspace: &Workspace) -> PathBuf {
    workspace.target.join("own/loop/PneumaticServoCylinder")
}

/// The files of the loop that are written by hand, or are tables.
const BY_HAND: [&str; 6] = ["loop.c", "loop.h", "plant.c", "plant.h", "model.c", "model.h"];

/// Compares the rules of MISRA C that the files written by hand do not keep with those that the page names.
fn misra(workspace: &Workspace) -> Result<()> {
    heading("Sources in C: rules of MISRA C");
    if let Some(tool) = Tool::unless_found("cppcheck", "cppcheck") {
        return process::leave_out("Rules of MISRA C", &tool.to_string());
    }
    let mut cppcheck = Command::new("cppcheck");
    cppcheck.args(["--addon=misra", "--std=c99", "--enable=style", "--suppress=missingIncludeSystem", "--quiet"]);
    cppcheck.args(["-DPLANT_INSTANCES=1", "--template={file} {id}", "--output-file=misra.txt"]);
    let folder = folder(workspace);
    process::run(cppcheck.args(["loop.c", "plant.c", "model.c"]).current_dir(&folder))?;
    let found = files::text(folder.join("misra.txt"))?;
    let page = files::text(workspace.home.join("docs/target.md"))?;
    let table = page.split_once("<!-- rules of MISRA C -->").map_or("", |(_, rest)| rest);
    let named: BTreeSet<&str> = table
        .lines()
        .skip_while(|line| !line.starts_with('|'))
        .take_while(|line| line.starts_with('|'))
        .filter_map(|line| line.split('|').nth(1))
        .flat_map(|rules| rules.split(',').map(str::trim))
        .collect();
    let broken: BTreeSet<&str> = found
        .lines()
        .filter_map(|line| line.split_once(" misra-c2012-"))
        .filter(|(file, _)| BY_HAND.contains(file))
        .map(|(_, rule)| rule)
        .collect();
    ensure!(broken.len() > 5, "cppcheck tells nothing of MISRA C: {found}");
    let unnamed: Vec<_> = broken.difference(&named).collect();
    ensure!(unnamed.is_empty(), "docs/target.md names no reason for the rules {unnamed:?}:\n{found}");
    println!("not kept, as the page says: {broken:?}");
    Ok(())
}
