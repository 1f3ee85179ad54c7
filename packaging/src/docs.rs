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

impl Docs {
    /// Builds and installs the wheel, and reads its docstrings.
    ///
    /// # Errors
    /// When the wheel cannot be built or the pages cannot be made.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        Venv::prepare(workspace, Requirements::PACKAGE)?;
        let venv = Venv::prepare(workspace, Requirements::TESTS)?;
        wheel::install(&venv, &wheel::build(workspace)?)?;
        heading("Reference pages of the Python package");
        let folder = workspace.target.join("docs");
        let pages = ["pneumatic_servo", "pneumatic_servo.envs"];
        process::run(venv.command().args(["-m", "pdoc", "--docformat", "numpy", "-o"]).arg(&folder).args(pages))?;
        println!("{}", folder.join("pneumatic_servo.html").display());
        Ok(())
    }
}
