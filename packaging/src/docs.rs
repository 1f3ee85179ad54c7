//! `cargo xtask docs`: the reference pages of the Python package, from its docstrings.

use anyhow::Result;
use clap::Args;

use crate::process::{self, heading};
use crate::venv::{Requirements, Venv};
use crate::wheel;
use crate::workspace::Workspace;

/// Build the reference pages of the Python package into target/docs; needs `package`.
#[derive(Args)]
#[command(after_help = "\
Example:
  cargo xtask package && cargo xtask docs     then open target/docs/pneumatic_servo.html")]
pub struct Docs {}

/// pdoc, once the package has loaded what it otherwise loads when it is asked for: pdoc does not ask.
const PDOC: &str = "
import pneumatic_servo
for name in pneumatic_servo.__all__:
    setattr(pneumatic_servo, name, getattr(pneumatic_servo, name))
from pdoc.__main__ import cli
cli()
";

impl Docs {
    /// Builds and installs the wheel, and reads its docstrings.
    ///
    /// # Errors
    /// When the wheel cannot be built or the pages cannot be made.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        let venv = Venv::prepare(workspace, Requirements::TESTS)?;
        wheel::install(&venv, &wheel::build(workspace)?)?;
        heading("Reference pages of the Python package");
        let folder = workspace.target.join("docs");
        let pages = ["pneumatic_servo", "pneumatic_servo.envs", "pneumatic_servo.identification"];
        process::run(venv.command().args(["-c", PDOC, "--docformat", "numpy", "-o"]).arg(&folder).args(pages))?;
        println!("{}", folder.join("pneumatic_servo.html").display());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::files;
    use crate::stand_in::{self, StandIn};

    /// Of the package that is installed from the wheel.
    #[test]
    fn pages_are_made_of_the_installed_package() -> Result<()> {
        let folder = files::scratch("docs");
        let workspace = Workspace::made_up(&folder);
        files::write(&workspace.fmus().join("Model.fmu"), "")?;
        let machine = StandIn::new(stand_in::wheel);
        let (outcome, started) = machine.lacking("npm").does(|| Docs {}.run(&workspace));
        outcome?;
        let [.., installed, made] = &started[..] else { panic!("{started:?}") };
        assert!(installed.says("--force-reinstall") && installed.line().ends_with("a.whl"), "{installed:?}");
        assert!(
            made.line().ends_with("pneumatic_servo pneumatic_servo.envs pneumatic_servo.identification"),
            "{made:?}"
        );
        assert_eq!(Path::new(made.after("-o")), workspace.target.join("docs"));
        Ok(std::fs::remove_dir_all(&folder)?)
    }
}
