//! `cargo deny`: licences, sources and known weaknesses of the packages that the crates depend on, as `deny.toml` demands.

use std::path::PathBuf;

use anyhow::Result;
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::workspace::{self, Workspace};

/// Checks dependencies without a network: advisories only where their database was fetched before. Where there is
/// no cargo-deny this says so and is no error: it is no part of Rust, and takes minutes to compile.
///
/// # Errors
/// When a package is refused.
pub fn check(workspace: &Workspace) -> Result<()> {
    heading("Dependencies: licences, bans, sources, advisories");
    if process::find("cargo-deny").is_none() {
        println!("left out: it needs cargo-deny (cargo install --locked cargo-deny)");
        return Ok(());
    }
    let mut deny = process::cargo();
    deny.args(["deny", "--offline", "--workspace", "check", "--hide-inclusion-graph", "licenses", "bans", "sources"]);
    if database().is_some_and(|folder| folder.is_dir()) {
        deny.arg("advisories");
    } else {
        println!("left out: advisories, whose database is not there (cargo deny fetch)");
    }
    process::run(deny.current_dir(&workspace.root))
}

/// Where cargo-deny keeps the database.
fn database() -> Option<PathBuf> {
    workspace::cargo_home().map(|home| home.join("advisory-dbs"))
}
