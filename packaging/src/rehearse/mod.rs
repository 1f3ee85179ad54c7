//! `cargo xtask release --rehearse`: what can be tried of a release before its tag is pushed.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use cargo_metadata::MetadataCommand;

use crate::files;
use crate::new;
use crate::package;
use crate::process::{self, heading};
use crate::venv::{Requirements, Venv};
use crate::wheel;
use crate::workspace::Workspace;

mod contents;
mod elsewhere;

/// The crate that is published; the others are parts of what is handed out in other forms.
const CRATE: &str = "pneumatic-servo";
/// Versions of Python that the package says it runs with.
const PYTHONS: [&str; 5] = ["3.10", "3.11", "3.12", "3.13", "3.14"];

/// What a user does first; the FMUs and the playground are in wheels only.
const PROGRAM: &str = "
import platform, sys
import pneumatic_servo as ps
run = ps.Model('PneumaticServoCylinder').simulate({'friction.law': 'LuGre'}, inputs={'valveVoltage': 6.0}, stop=0.5)
assert run['position'][-1] > 0.25, run['position'][-1]
if sys.argv[1] == 'wheel':
    assert ps.play(browser=False).stat().st_size > 1_000_000 and len(ps.fmus()) > 5
bits = float(run['position'][-1]).hex()
print('Python', sys.version.split()[0], 'on', platform.machine(), 'runs the plant of the', sys.argv[1], 'to', bits)
";

/// Checks versions, packs the crate, and installs wheel and source distribution in fresh environments.
///
/// # Errors
/// When something would go wrong with the release.
pub fn run(workspace: &Workspace) -> Result<()> {
    let wheel = wheel::build(workspace)?;
    heading("Release: one version everywhere");
    versions(workspace, &wheel)?;
    contents::citation(workspace)?;
    heading("Release: the crate, built of its package alone");
    let mut cargo = process::cargo();
    cargo.args(["package", "--locked", "--package", CRATE]).current_dir(&workspace.root);
    process::run(cargo.env("CARGO_TARGET_DIR", &workspace.target))?;
    new::check(workspace, &workspace.target.join(format!("package/{CRATE}-{}", env!("CARGO_PKG_VERSION"))))?;
    heading("Release: what is inside");
    let mut left = contents::list(workspace)?;
    heading("Release: the wheel in fresh environments");
    for version in PYTHONS {
        match python(version) {
            Some(python) => try_out(workspace, &python, version, "wheel", &wheel)?,
            None => left.push(format!("the wheel with Python {version}, which is not on this machine")),
        }
    }
    heading("Release: the source distribution in a fresh environment");
    let sources = source_distribution(workspace)?;
    let newest = PYTHONS.into_iter().rev().find_map(|version| Some((version, python(version)?)));
    let (version, python) = newest.context("no Python from 3.10 on is on the search path")?;
    try_out(workspace, &python, version, "source distribution", &sources)?;
    heading("Release: wheels for other systems and processors");
    left.extend(elsewhere::try_out(workspace)?);

    heading("Release: not tried here");
    left.push("the upload".to_owned());
    left.iter().for_each(|what| println!("- {what}"));
    Ok(())
}

/// Everything that states a version, with what it states.
fn versions(workspace: &Workspace, wheel: &Path) -> Result<()> {
    let wanted = env!("CARGO_PKG_VERSION");
    let mut stated = Vec::new();
    let metadata =
        process::metadata(MetadataCommand::new().manifest_path(workspace.root.join("Cargo.toml")).no_deps())?;
    for package in &metadata.packages {
        stated.push((format!("the crate {}", package.name), package.version.to_string()));
    }
    let name = wheel.file_name().unwrap_or_default().to_string_lossy();
    stated.push(("the wheel".to_owned(), name.split('-').nth(1).unwrap_or_default().to_owned()));
    for fmu in package::fmus(workspace) {
        stated.push((fmu.display().to_string(), of_description(&entry(&fmu, "modelDescription.xml")?).to_owned()));
    }
    let citation = files::text(workspace.root.join("CITATION.cff"))?;
    stated.push(("CITATION.cff".to_owned(), between(&citation, "\nversion: ", "\n").to_owned()));
    let changes = files::text(workspace.root.join("CHANGELOG.md"))?;
    stated.push(("CHANGELOG.md".to_owned(), between(&changes, "\n## [", "]").to_owned()));
    let site = workspace.target.join("site/index.html");
    if site.is_file() {
        let title = between(&files::text(&site)?, "<title>", "</title>").to_owned();
        stated.push(("the site".to_owned(), title.rsplit(' ').next().unwrap_or_default().to_owned()));
    } else {
        println!("left out: the site, which `cargo xtask site` builds");
    }
    agree(wanted, &stated)?;
    println!("{wanted} in {} places", stated.len());
    Ok(())
}

/// # Errors
/// Names every place that states another version.
fn agree(wanted: &str, stated: &[(String, String)]) -> Result<()> {
    let others: Vec<_> = stated.iter().filter(|(_, version)| version != wanted).collect();
    let lines: Vec<_> = others.iter().map(|(place, version)| format!("  {place}: {version:?}")).collect();
    ensure!(others.is_empty(), "the version is {wanted}, but not everywhere:\n{}", lines.join("\n"));
    Ok(())
}

/// The version of a model by its description; that of XML stands before it.
fn of_description(description: &str) -> &str {
    let model = description.split_once("<fmiModelDescription").map_or("", |(_, model)| model);
    between(model.split_once('>').map_or("", |(attributes, _)| attributes), " version=\"", "\"")
}

/// What is between two texts, or nothing.
fn between<'a>(text: &'a str, before: &str, after: &str) -> &'a str {
    let rest = text.split_once(before).map_or("", |(_, rest)| rest);
    rest.split_once(after).map_or("", |(found, _)| found)
}

fn entry(archive: &Path, name: &str) -> Result<String> {
    let file = fs::File::open(archive).with_context(|| format!("cannot open {}", archive.display()))?;
    let mut text = String::new();
    zip::ZipArchive::new(file)?.by_name(name)?.read_to_string(&mut text)?;
    Ok(text)
}

/// A Python of a version, if it starts and can make environments.
fn python(version: &str) -> Option<PathBuf> {
    let check =
        format!("import sys, ensurepip, venv; sys.exit(sys.version_info[:2] != ({}))", version.replace('.', ", "));
    let works = |python: &PathBuf| process::works(Command::new(python).args(["-c", &check]));
    // The first may be a stand-in of a version manager, for a version that is not switched on.
    process::find_all(&format!("python{version}")).into_iter().find(works)
}

/// Installs a package with what it asks for into an environment that holds nothing else, and runs the plant.
fn try_out(workspace: &Workspace, python: &Path, version: &str, kind: &str, package: &Path) -> Result<()> {
    let folder = workspace.target.join("rehearsal").join(format!("{}-{version}", kind.replace(' ', "-")));
    process::run(Command::new(python).args(["-m", "venv", "--clear"]).arg(&folder))?;
    let programs = folder.join(if cfg!(windows) { "Scripts" } else { "bin" });
    let python = programs.join("python").with_extension(std::env::consts::EXE_EXTENSION);
    let mut pip = Command::new(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).arg(package);
    process::run(pip.env("CARGO_TARGET_DIR", workspace.target.join("rehearsal/build")))?;
    let mut program = Command::new(&python);
    program.args(["-c", PROGRAM, kind]).current_dir(&folder);
    process::run(program.env_remove("PYTHONPATH").env("PYTHONNOUSERSITE", "1").env("MPLBACKEND", "Agg"))
}

/// Packs the sources of the package, which are built where there is no wheel for a machine.
fn source_distribution(workspace: &Workspace) -> Result<PathBuf> {
    let folder = workspace.target.join("sdist");
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("cannot remove the old {}", folder.display()))?;
    }
    let venv = Venv::prepare(workspace, Requirements::ZIG)?;
    let mut maturin = venv.command();
    maturin.args(["-m", "maturin", "sdist", "--out"]).arg(&folder).current_dir(workspace.root.join("python"));
    process::run(&mut maturin)?;
    let files = fs::read_dir(&folder)?.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
    match &files[..] {
        [file] => Ok(file.clone()),
        found => bail!("{} files in {}, not one source distribution", found.len(), folder.display()),
    }
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::models;

    use super::*;
    use crate::archive::Archive;
    use crate::moment::Moment;
    use crate::stand_in::{self, Answer, StandIn, Started};

    const VERSION: &str = env!("CARGO_PKG_VERSION");

    /// A workspace with everything that states a version, of which one place states another, unless that is none.
    fn stating(folder: &Path, other: &str) -> Result<Workspace> {
        let mut workspace = Workspace::made_up(folder);
        workspace.product.models = &models::ALL[..1];
        let version = |place: &str| if place == other { "9.9.9" } else { VERSION };
        let write = |name: &str, text: String| files::write(&workspace.root.join(name), text);
        write("CITATION.cff", format!("cff-version: 1.2.0\nversion: {}\n", version("CITATION.cff")))?;
        write("CHANGELOG.md", format!("# Changes\n\n## [{}]\n", version("CHANGELOG.md")))?;
        if other != "no site" {
            files::write(
                &workspace.target.join("site/index.html"),
                format!("<title>Plant {}</title>", version("the site")),
            )?;
        }
        let mut fmu = Archive::default();
        let description = format!("<?xml version=\"1.0\"?><fmiModelDescription version=\"{}\">", version(".fmu"));
        fmu.add("modelDescription.xml", description)?;
        fmu.write(&package::fmus(&workspace).next().context("no model")?, Moment::of_source(&workspace.root)?)?;
        Ok(workspace)
    }

    /// A machine with the programs of a rehearsal, whose crates have a version; of Python there are some, each behind a
    /// stand-in of a version manager.
    fn machine(workspace: &Workspace, version: &'static str) -> StandIn {
        let root = workspace.root.clone();
        StandIn::new(move |command| {
            let into = |name: String| Some(stand_in::writes(Path::new(command.after("--out")).join(name), ""));
            match command {
                _ if command.says("metadata") => {
                    let parts = [CRATE, "pneumatic-servo-builtin", "pneumatic-servo-python"];
                    Some(stand_in::metadata(&root, &root, &parts.map(|name| (name, version, name))))
                }
                _ if command.says("maturin build") => into(format!("pneumatic_servo-{VERSION}-cp310-abi3-any.whl")),
                _ if command.says("maturin sdist") => into(format!("pneumatic_servo-{VERSION}.tar.gz")),
                _ => command.path.starts_with("/machine/first").then_some(Answer::Fails),
            }
        })
    }

    /// Versions, the crate from its package, the wheel with every Python there is, and the source distribution with the newest.
    #[test]
    fn a_rehearsal_tries_the_crate_the_wheel_and_the_source_distribution() -> Result<()> {
        let folder = files::scratch("rehearsal");
        let workspace = stating(&folder, "")?;
        let machine =
            machine(&workspace, VERSION).compiling_for(&folder, &[]).lacking("npm").lacking("cargo-cyclonedx");
        let (outcome, started) = machine.lacking("python3.10").lacking("python3.14").does(|| run(&workspace));
        outcome?;
        let place = |words: &str| {
            let found = started.iter().position(|it| it.line().contains(words));
            found.with_context(|| format!("{words} is not among {started:#?}"))
        };
        let crates = format!("package/{CRATE}-{VERSION}");
        let order = [
            "maturin build",
            "cffconvert --validate",
            "cargo package --locked",
            "cargo test",
            "-m venv --clear",
            "maturin sdist",
        ];
        // The first environments are those that maturin and cffconvert are in.
        let places = order.map(|words| match words {
            "-m venv --clear" => place("wheel-3.11").unwrap(),
            _ => place(words).unwrap(),
        });
        assert!(places.is_sorted(), "{places:?} of {started:#?}");
        assert_eq!(started[place("cargo package")?].after("--package"), CRATE);
        let law = files::text(workspace.target.join("new-law/Cargo.toml"))?;
        assert!(law.contains(&format!("{:?}", workspace.target.join(crates))), "{law}");
        let tried = |kind: &str| {
            let runs = started
                .iter()
                .filter(|it| it.says("import platform, sys") || it.line().contains("pneumatic_servo as ps"));
            runs.filter(|it| it.line().ends_with(kind)).count()
        };
        assert_eq!((tried(" wheel"), tried(" source distribution")), (3, 1));
        let newest = &started[place("source-distribution-3.13")?];
        assert_eq!(newest.path, Path::new("/machine/second/python3.13"));
        let installed: Vec<_> = started.iter().filter(|it| it.says("pip install --quiet")).map(Started::line).collect();
        assert_eq!(installed.iter().filter(|line| line.ends_with(".whl")).count(), 3);
        assert_eq!(installed.iter().filter(|line| line.ends_with(".tar.gz")).count(), 1);
        Ok(fs::remove_dir_all(&folder)?)
    }

    /// Where nothing is wrong, the same without a site; otherwise the place is named.
    #[test]
    fn every_place_that_states_a_version_is_looked_at() -> Result<()> {
        let folder = files::scratch("versions");
        let wheel = |version: &str| PathBuf::from(format!("pneumatic_servo-{version}-cp310-abi3-any.whl"));
        for other in [
            "",
            "no site",
            "CITATION.cff",
            "CHANGELOG.md",
            "the site",
            ".fmu",
            "the wheel",
            "the crate pneumatic-servo",
        ] {
            let workspace = stating(&folder, other)?;
            let crates = if other.starts_with("the crate") { "9.9.9" } else { VERSION };
            let wheel = wheel(if other == "the wheel" { "9.9.9" } else { VERSION });
            let (outcome, _) = machine(&workspace, crates).does(|| versions(&workspace, &wheel));
            match other {
                "" | "no site" => outcome?,
                _ => {
                    let problem = outcome.map_or_else(|problem| problem.to_string(), |()| String::new());
                    assert!(problem.contains(&format!("{other}: \"9.9.9\"")), "{other}: {problem}");
                }
            }
            fs::remove_dir_all(&folder)?;
        }
        Ok(())
    }

    #[test]
    fn a_python_is_one_that_starts() {
        let find = |fails: fn(&Started) -> bool| {
            let machine = StandIn::new(move |it| fails(it).then_some(Answer::Fails)).lacking("python3.10");
            machine.does(|| ["3.10", "3.12"].map(python)).0
        };
        let path = |folder: &str| Some(Path::new(folder).join("python3.12"));
        assert_eq!(find(|_| false), [None, path("/machine/first")]);
        assert_eq!(find(|it| it.path.starts_with("/machine/first")), [None, path("/machine/second")]);
        assert_eq!(find(|it| it.line().contains("(3, 12)")), [None, None]);
    }

    #[test]
    fn source_distribution_is_the_only_one() -> Result<()> {
        let folder = files::scratch("sdist");
        let workspace = Workspace::made_up(&folder);
        files::write(&workspace.target.join("sdist/old.tar.gz"), "")?;
        let (file, started) = machine(&workspace, VERSION).does(|| source_distribution(&workspace));
        let name = format!("pneumatic_servo-{VERSION}.tar.gz");
        assert_eq!(file?, workspace.target.join("sdist").join(name));
        assert_eq!(started.last().and_then(|it| it.folder.clone()), Some(workspace.root.join("python")));
        let nothing = StandIn::new(|_| None).does(|| source_distribution(&workspace)).0;
        assert!(nothing.is_err());
        Ok(fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn entry_of_an_archive_is_read() -> Result<()> {
        let folder = files::scratch("entry");
        stating(&folder, "")?;
        let fmu = folder.join("target/fmu").join(format!("{}.fmu", models::ALL[0].name));
        assert_eq!(of_description(&entry(&fmu, "modelDescription.xml")?), VERSION);
        assert!(entry(&fmu, "none").is_err() && entry(&folder.join("none"), "none").is_err());
        Ok(fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn another_version_is_named_with_its_place() {
        let stated = |version: &str| {
            vec![("the wheel".to_owned(), "1.2.3".to_owned()), ("CITATION.cff".to_owned(), version.to_owned())]
        };
        assert!(agree("1.2.3", &stated("1.2.3")).is_ok());
        let problem = agree("1.2.3", &stated("1.2.2")).unwrap_err().to_string();
        assert!(problem.contains("CITATION.cff: \"1.2.2\"") && !problem.contains("wheel"), "{problem}");
        assert!(agree("1.2.3", &stated("")).is_err(), "a place without a version");
    }

    /// What a stranger's crate and its author need.
    #[test]
    fn the_published_crate_has_what_laws_and_models_of_ones_own_need() -> Result<()> {
        let mut cargo = process::cargo();
        let arguments = ["package", "--list", "--offline", "--allow-dirty", "--package", CRATE];
        let files = process::output(cargo.args(arguments).current_dir(crate::workspace::home()))?;
        for wanted in [
            "src/prelude.rs",
            "src/conformance/mod.rs",
            "src/friction/catalogue.rs",
            "src/pneumatics/actuator.rs",
            "src/system/mod.rs",
            "docs/own.md",
            "README.md",
            "CHANGELOG.md",
            "LICENSE-APACHE",
            "LICENSE-MIT",
        ] {
            assert!(files.lines().any(|file| file == wanted), "{wanted} is not among\n{files}");
        }
        assert!(!files.lines().any(|file| file.starts_with("target") || file.ends_with(".fmu")), "{files}");
        Ok(())
    }

    #[test]
    fn versions_are_found_in_the_texts_that_state_them() {
        assert_eq!(between("cff-version: 1.2.0\nversion: 0.1.0\nlicense:", "\nversion: ", "\n"), "0.1.0");
        assert_eq!(between("# Changes\n\n## [0.1.0]\n", "\n## [", "]"), "0.1.0");
        assert_eq!(between("# Changes\n", "\n## [", "]"), "");
        let description = "<?xml version=\"1.0\"?>\n<fmiModelDescription fmiVersion=\"2.0\" version=\"0.1.0\">";
        assert_eq!(of_description(description), "0.1.0");
        assert_eq!(of_description("<?xml version=\"1.0\"?>\n<fmiModelDescription><Tool version=\"3\"/>"), "");
    }
}
