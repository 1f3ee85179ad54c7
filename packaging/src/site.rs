//! `cargo xtask site`: everything there is to read, as one folder that needs no server: `target/site`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;

use crate::gallery::Gallery;
use crate::package;
use crate::playground;
use crate::process::{self, heading};
use crate::tools::{self, Tool};
use crate::venv::{Requirements, Venv};
use crate::wheel;
use crate::workspace::Workspace;

/// Build the site into target/site and check its links; needs `package`.
///
/// The landing page with the live plant, starting points, tutorial, all pages of docs, the models, the gallery of the
/// laws, the references of Python and Rust, and a search, without a server: open target/site/index.html.
#[derive(Args)]
#[command(after_help = "\
Example:
  cargo xtask package && cargo xtask site     about eight minutes, five of which are the gallery")]
pub struct Site {
    /// Show the figures of target/gallery as they are, instead of drawing them anew.
    #[arg(long)]
    keep_gallery: bool,
}

impl Site {
    /// Draws the gallery, which installs the Python package, and builds the site.
    ///
    /// # Errors
    /// When the FMUs or a tool are missing, or a page is wrong.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        let page = playground::page(workspace)?;
        if !self.keep_gallery {
            Gallery {}.run(workspace)?;
        }
        let venv = Venv::prepare(workspace, Requirements::SITE)?;
        if self.keep_gallery {
            wheel::install(&venv, &wheel::build(workspace)?)?;
        }
        println!("{}", build(workspace, &venv, &page)?.display());
        Ok(())
    }
}

/// Builds the site of the products that are there, and looks at it in Chromium; where a tool is missing, that is an error
/// under CI and otherwise said. The environment has the package.
///
/// # Errors
/// When a tool is missing under CI, or a page is wrong.
pub fn check(workspace: &Workspace) -> Result<()> {
    let mut missing = playground::needed()?;
    missing.extend(Tool::unless_found("chromium", "chromium"));
    if let Err(problem) = tools::require([("the site", missing)]) {
        return process::leave_out("Site", &problem.to_string());
    }
    let venv = Venv::prepare(workspace, Requirements::SITE)?;
    let site = build(workspace, &venv, &workspace.target.join("playground/index.html"))?;
    heading("Site: look at it in Chromium, and elsewhere where there are other browsers");
    let tests = workspace.root.join("tests/site");
    playground::install(&tests)?;
    process::run(playground::npm().args(["test", "--silent"]).current_dir(&tests).env("SITE", site))
}

/// Lays out the pages, makes the site of them and checks its links.
fn build(workspace: &Workspace, venv: &Venv, page: &Path) -> Result<PathBuf> {
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
    let own = workspace.root.join("site");
    let mut gather = venv.command();
    gather.arg(own.join("gather.py")).arg("--fmus").arg(workspace.fmus()).arg("--gallery").arg(workspace.gallery());
    gather.arg("--playground").arg(page).arg("--rustdoc").arg(rustdoc.join("doc")).arg("--out").arg(&sources);
    process::run(&mut gather)?;
    let mut sphinx = venv.command();
    sphinx.args(["-m", "sphinx", "--builder", "html", "--fail-on-warning", "--keep-going", "--quiet", "--doctree-dir"]);
    sphinx.arg(workspace.target.join("site-doctrees"));
    process::run(sphinx.arg(&sources).arg(&site).env("PATH", venv.path()?))?;
    process::run(venv.command().arg(own.join("links.py")).arg(&site))?;
    Ok(site)
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::models;

    use super::*;
    use crate::build::wasm;
    use crate::files;
    use crate::stand_in::{self, StandIn, Started};

    /// A workspace with the FMU of one model, and a machine that makes page and wheel.
    fn workshop(folder: &Path) -> Result<(Workspace, StandIn)> {
        let mut workspace = Workspace::made_up(folder);
        workspace.product.models = &models::ALL[..1];
        for fmu in package::fmus(&workspace) {
            files::write(&fmu, "")?;
        }
        let (root, module) = (workspace.root.clone(), folder.join("module.wasm"));
        files::write(&module, "")?;
        let machine = StandIn::new(move |command| match command {
            _ if command.says("metadata") => {
                Some(stand_in::metadata(&root, &root, &[(wasm::PACKAGE, "0.1.0", "playground")]))
            }
            _ if command.says("rustc --release") => Some(stand_in::built(command, &module)),
            _ if command.says("bundle") => command.arguments.last().map(|page| stand_in::writes(page, "page")),
            _ => stand_in::wheel(command),
        });
        Ok((workspace, machine.compiling_for(&folder.join("sysroot"), &["wasm32-unknown-unknown"])))
    }

    /// Which of some steps were started, in their order.
    fn steps(started: &[Started]) -> Vec<&'static str> {
        const ALL: [&str; 9] = [
            "npm run --silent bundle",
            "maturin build",
            "install --quiet",
            "gallery.py",
            "cargo doc",
            "gather.py",
            "sphinx",
            "links.py",
            "npm test",
        ];
        let step = |it: &Started| ALL.into_iter().find(|step| it.line().contains(step));
        let mut steps: Vec<_> = started.iter().filter_map(step).collect();
        // The wheel holds the page, too.
        steps.dedup();
        steps
    }

    /// The page, the gallery unless it is kept, and then the pages, whose links are checked; the wheel is installed for them.
    #[test]
    fn site_is_made_of_what_is_there() -> Result<()> {
        const BUNDLE: &str = "npm run --silent bundle";
        let pages = ["cargo doc", "gather.py", "sphinx", "links.py"];
        let folder = files::scratch("site");
        for (keep_gallery, drawn) in [(false, &["gallery.py"][..]), (true, &[])] {
            let (workspace, machine) = workshop(&folder)?;
            files::write(&workspace.target.join("site/old.html"), "")?;
            let (outcome, started) = machine.does(|| Site { keep_gallery }.run(&workspace));
            outcome?;
            let expected = [&[BUNDLE, "maturin build", "install --quiet"], drawn, &pages].concat();
            assert_eq!(steps(&started), expected);
            let of = |words: &str| started.iter().find(|it| it.line().contains(words)).context(words.to_owned());
            let (gather, links) = (of("gather.py")?, of("links.py")?);
            let page = workspace.target.join("playground/index.html");
            assert_eq!(
                (Path::new(gather.after("--playground")), Path::new(gather.after("--fmus"))),
                (&*page, &*workspace.fmus())
            );
            assert!(of("sphinx")?.line().ends_with(&format!(
                "{} {}",
                gather.after("--out"),
                workspace.target.join("site").display()
            )));
            assert!(links.line().ends_with(&workspace.target.join("site").display().to_string()), "{links:?}");
            assert!(!workspace.target.join("site/old.html").exists());
            fs::remove_dir_all(&folder)?;
        }
        Ok(())
    }

    /// Without FMUs there is no site, and without Chromium none is looked at.
    #[test]
    fn site_is_looked_at_where_there_is_a_browser() -> Result<()> {
        let folder = files::scratch("site-check");
        let (workspace, machine) = workshop(&folder)?;
        let (outcome, started) = machine.does(|| check(&workspace));
        outcome?;
        assert_eq!(steps(&started), ["cargo doc", "gather.py", "sphinx", "links.py", "npm test"]);
        let test = started.last().context("no test")?;
        assert_eq!(Path::new(test.variable("SITE")), workspace.target.join("site"));
        assert_eq!(test.folder, Some(workspace.root.join("tests/site")));
        for is_ci in [false, true] {
            let machine = workshop(&folder)?.1.lacking("chromium").with("CI", is_ci.to_string());
            let (outcome, started) = machine.does(|| check(&workspace));
            assert!(outcome.is_err() == is_ci && started.is_empty(), "{started:?}");
        }
        let machine = workshop(&folder)?.1;
        fs::remove_dir_all(workspace.fmus())?;
        let (outcome, started) = machine.does(|| check(&workspace));
        assert!(outcome.is_err_and(|error| error.to_string().contains("run `cargo xtask package` first")));
        assert_eq!(steps(&started), Vec::<&str>::new());
        Ok(fs::remove_dir_all(&folder)?)
    }
}
