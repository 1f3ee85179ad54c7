//! `cargo xtask gallery`: what the FMUs do under every friction law.

use anyhow::{Result, ensure};
use clap::Args;

use crate::package;
use crate::process::{self, heading};
use crate::ssp;
use crate::venv::{Requirements, Venv};
use crate::wheel;
use crate::workspace::Workspace;

/// Run and draw every friction law in every model, compare the laws, and run the drive; needs `package`.
///
/// Results are in target/gallery, in a folder per model. The figures are those of the Python package, whose wheel this
/// builds and installs.
#[derive(Args)]
#[command(after_help = "\
Example:
  cargo xtask package && cargo xtask gallery     about five minutes; figures in target/gallery")]
pub struct Gallery {}

impl Gallery {
    /// Runs everything, one program after the other.
    ///
    /// # Errors
    /// When the FMUs are missing or a run fails.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        for fmu in package::fmus(workspace) {
            ensure!(fmu.is_file(), "{} is missing: run `cargo xtask package` first", fmu.display());
        }
        let venv = Venv::prepare(workspace, Requirements::FIGURES)?;
        wheel::install(&venv, &wheel::build(workspace)?)?;
        let script = |name: &str| {
            let mut command = venv.command();
            command.arg(workspace.python().join(name)).arg("--output").arg(workspace.gallery());
            command
        };
        heading("Run the default experiments under every friction law");
        process::run(script("gallery.py").args(package::fmus(workspace)))?;
        heading("Run the drive");
        process::run(script("drive.py").arg(workspace.fmus().join(format!("{}.ssp", ssp::NAME))))?;
        heading("Compare the friction laws");
        let of = |model: &str| workspace.fmus().join(format!("{model}.fmu"));
        process::run(script("catalogue.py").arg(of("FrictionBench")).arg(of("PneumaticServoCylinder")))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use pneumatic_servo::models;

    use super::*;
    use crate::files;
    use crate::stand_in::{self, StandIn};

    /// From the FMUs that are there, with the package that holds them, one program after the other.
    #[test]
    fn everything_is_drawn_from_the_fmus() -> Result<()> {
        let folder = files::scratch("gallery");
        let mut workspace = Workspace::made_up(&folder);
        workspace.product.models = &models::ALL[..1];
        let run = || {
            let machine = StandIn::new(stand_in::wheel);
            machine.lacking("npm").does(|| Gallery {}.run(&workspace))
        };
        let (outcome, started) = run();
        assert!(outcome.is_err_and(|error| error.to_string().contains("run `cargo xtask package` first")));
        assert!(started.is_empty(), "{started:?}");
        for fmu in package::fmus(&workspace) {
            files::write(&fmu, "")?;
        }
        let (outcome, started) = run();
        outcome?;
        let scripts: Vec<_> = started.iter().filter(|it| it.says("--output")).collect();
        let [gallery, drive, catalogue] = &scripts[..] else { panic!("{started:?}") };
        for (command, name, last) in [
            (gallery, "gallery.py", "PneumaticServoCylinder.fmu"),
            (drive, "drive.py", "PneumaticServoDrive.ssp"),
            (catalogue, "catalogue.py", "PneumaticServoCylinder.fmu"),
        ] {
            assert_eq!(Path::new(command.after("--output")), workspace.gallery());
            assert!(command.line().contains(name) && command.line().ends_with(last), "{command:?}");
        }
        Ok(std::fs::remove_dir_all(&folder)?)
    }
}
