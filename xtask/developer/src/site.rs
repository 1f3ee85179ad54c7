//! `cargo xtask site`: all documentation as one folder that needs no server, `target/site`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use lexopt::Arg::{Long, Short};
use lexopt::Parser;
use pneumatic_servo_packaging::package;
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::tools::{self, Tool};
use pneumatic_servo_packaging::venv::{Requirements, Venv};
use pneumatic_servo_packaging::workspace::Workspace;

use crate::Work;
use crate::playground;
use crate::wheel;

/// The help of the command.
pub const HELP: &str = "\
Build the site into target/site and check its links; needs `package`.

Usage: cargo xtask site [--keep-gallery]

  --keep-gallery    show the figures of target/gallery as they are, instead of drawing them anew

The landing page with the live plant, starting points, tutorial, all pages of docs, the models, the gallery of the laws, the
references of Python and Rust, and a search, without a server: open target/site/index.html.

Example:
  cargo xtask package && cargo xtask site     about eight minutes, five of which are the gallery";

/// Reads the options.
///
/// # Errors
/// When one is unknown.
pub fn read(mut line: Parser) -> Result<Option<Work>> {
    let mut keeps_gallery = false;
    while let Some(argument) = line.next()? {
        match argument {
            Short('h') | Long("help") => return Ok(None),
            Long("keep-gallery") => keeps_gallery = true,
            other => return Err(other.unexpected().into()),
        }
    }
    Ok(Some(Box::new(move |workspace| run(workspace, keeps_gallery))))
}

/// Draws the gallery, which installs the Python package, and builds the site.
fn run(workspace: &Workspace, keeps_gallery: bool) -> Result<()> {
    let page = playground::page(workspace)?;
    let venv = Venv::prepare(workspace, Requirements::SITE)?;
    wheel::install(&venv, &wheel::build(workspace, Some(&page))?)?;
    if !keeps_gallery {
        heading("Site: draw the gallery");
        let mut study = venv.command();
        study.arg(workspace.root.join("docs/studies/gallery.py")).arg("--output").arg(gallery(workspace));
        process::run(&mut study)?;
    }
    println!("{}", build(workspace, &venv, &page, Some(&gallery(workspace)))?.display());
    Ok(())
}

/// Where the figures of all laws are.
fn gallery(workspace: &Workspace) -> PathBuf {
    workspace.target.join("gallery")
}

/// Builds the site of the products that are there, and looks at it in Chromium; where a tool is missing, that is an error
/// under CI and otherwise said. The environment has the package.
///
/// # Errors
/// When a tool is missing under CI, or a page is wrong.
pub fn check(workspace: &Workspace, page: &Path) -> Result<()> {
    let missing = Tool::unless_found("chromium", "chromium").into_iter().collect();
    if let Err(problem) = tools::require([("the site", missing)]) {
        return process::leave_out("Site", &problem.to_string());
    }
    let venv = Venv::prepare(workspace, Requirements::SITE)?;
    // Drawing takes five minutes; a test of the studies draws some laws.
    let site = build(workspace, &venv, page, None)?;
    heading("Site: look at it in Chromium, and elsewhere where there are other browsers");
    let tests = workspace.root.join("tests/site");
    playground::install(&tests)?;
    process::run(playground::npm().args(["test", "--silent"]).current_dir(&tests).env("SITE", site))
}

/// Lays out the pages, makes the site of them and checks its links.
fn build(workspace: &Workspace, venv: &Venv, page: &Path, gallery: Option<&Path>) -> Result<PathBuf> {
    for fmu in package::fmus(workspace) {
        ensure!(fmu.is_file(), "{} is missing: run `cargo xtask package` first", fmu.display());
    }
    heading("Site: documentation of the crate");
    let rustdoc = workspace.target.join("site-rustdoc");
    let mut doc = process::cargo();
    doc.args(["doc", "--no-deps", "--package", "pneumatic-servo", "--lib"]).current_dir(&workspace.root);
    process::run(doc.env("CARGO_TARGET_DIR", &rustdoc))?;

    heading("Site: make the pages");
    let sources = workspace.target.join("site-sources");
    let site = workspace.target.join("site");
    if site.exists() {
        fs::remove_dir_all(&site).with_context(|| format!("cannot remove the old {}", site.display()))?;
    }
    let own = workspace.root.join("web/site");
    playground::install(&own)?;
    let mut gather = venv.command();
    gather.arg(own.join("gather.py")).arg("--fmus").arg(workspace.fmus());
    if let Some(gallery) = gallery {
        gather.arg("--gallery").arg(gallery);
    }
    gather.arg("--playground").arg(page).arg("--rustdoc").arg(rustdoc.join("doc")).arg("--out").arg(&sources);
    process::run(&mut gather)?;
    let mut sphinx = venv.command();
    sphinx.args(["-m", "sphinx", "--builder", "html", "--fail-on-warning", "--keep-going", "--quiet", "--doctree-dir"]);
    sphinx.arg(workspace.target.join("site-doctrees"));
    process::run(sphinx.arg(&sources).arg(&site).env("PATH", venv.path()?))?;
    process::run(venv.command().arg(own.join("search_index.py")).arg(&site))?;
    process::run(venv.command().arg(own.join("links.py")).arg(&site))?;
    Ok(site)
}
