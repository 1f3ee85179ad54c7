//! `cargo deny`: licences, sources and known weaknesses of the packages that the crates depend on, as `deny.toml` demands.

use std::path::PathBuf;

use anyhow::Result;

use crate::process::{self, heading};
use crate::workspace::{self, Workspace};

/// Checks what can be checked without a network: advisories only where their database was fetched before. Where there is
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stand_in::{Answer, StandIn};

    /// Advisories only where their database is; nothing where there is no cargo-deny.
    #[test]
    fn what_can_be_checked_without_a_network_is_checked() -> Result<()> {
        let home = crate::files::scratch("deny");
        let workspace = Workspace::of_a_test(&home);
        let machine = || StandIn::new(|_| None).with("CARGO_HOME", &home);
        for has_database in [false, true] {
            let (outcome, started) = machine().does(|| check(&workspace));
            outcome?;
            let [deny] = &started[..] else { panic!("{started:?}") };
            assert!(deny.line().starts_with("cargo deny --offline") && deny.says("licenses bans sources"), "{deny:?}");
            assert_eq!((deny.says("advisories"), deny.folder.as_ref()), (has_database, Some(&workspace.root)));
            std::fs::create_dir_all(home.join("advisory-dbs"))?;
        }
        std::fs::remove_dir_all(&home)?;
        let (outcome, started) = machine().lacking("cargo-deny").does(|| check(&workspace));
        assert!(outcome.is_ok() && started.is_empty());
        assert!(StandIn::new(|_| Some(Answer::Fails)).does(|| check(&workspace)).0.is_err());
        Ok(())
    }
}
