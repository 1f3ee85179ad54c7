//! `cargo xtask package`: the FMUs, checked, with results and figures beside them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo_fmu::fmi2;

use crate::archive::Archive;
use crate::build;
use crate::description::{self, Stamp};
use crate::documentation;
use crate::library::{self, Library};
use crate::licences;
use crate::moment::Moment;
use crate::parameter_sets;
use crate::platform::{Binary, Platform, Platforms};
use crate::process::{self, heading};
use crate::ssp;
use crate::venv::{Requirements, Venv};
use crate::workspace::Workspace;

/// `cargo xtask package`: builds what was not handed in, joins, validates every FMU, runs its default experiment and
/// draws the figures.
///
/// Without a choice of platforms the FMU is for machines like this one.
///
/// # Errors
/// When a tool is missing, or any of these steps fails or finds something.
pub fn run(workspace: &Workspace, platforms: Option<&Platforms>, binaries: &[Binary]) -> Result<()> {
    let mut libraries = library::handed_in(workspace, binaries)?;
    match platforms {
        Some(Platforms(platforms)) => {
            let wanted = platforms.iter().copied().filter(|platform| !libraries.contains_key(platform)).collect();
            libraries
                .extend(build::libraries(workspace, &wanted)?.into_iter().map(|library| (library.platform, library)));
        }
        None if !libraries.contains_key(&Platform::host()?) => {
            heading("Build the shared library");
            let library = Library::for_this_machine(workspace)?;
            libraries.insert(library.platform, library);
        }
        None => (),
    }

    heading("Join the FMUs");
    let libraries: Vec<_> = libraries.into_values().collect();
    let fmus = join(workspace, &libraries)?;
    check(workspace, &libraries, &fmus)
}

/// `cargo xtask join`: takes the libraries that were handed in, and those that `cargo xtask build` left.
///
/// # Errors
/// When a library is not there or does not pass the gates, or an FMU cannot be written.
pub fn join_built(workspace: &Workspace, platforms: Option<&Platforms>, binaries: &[Binary]) -> Result<()> {
    let mut libraries = library::handed_in(workspace, binaries)?;
    for &platform in platforms.iter().flat_map(|Platforms(platforms)| platforms) {
        if libraries.contains_key(&platform) {
            continue;
        }
        let file = library::kept(workspace, platform);
        let built = Library::read(workspace, &Binary { platform, file });
        let advice =
            || format!("build it with `cargo xtask build --platforms {platform}` or add `--binary {platform}=PATH`");
        libraries.insert(platform, built.with_context(advice)?);
    }
    join(workspace, &libraries.into_values().collect::<Vec<_>>())?;
    Ok(())
}

/// Validates FMUs; runs and draws them if they hold a library for this machine.
fn check(workspace: &Workspace, libraries: &[Library], fmus: &[PathBuf]) -> Result<()> {
    heading("Prepare the Python environment");
    let venv = Venv::prepare(workspace, Requirements::Checks)?;
    println!("{}", venv.python().display());

    let host = Platform::host()?;
    let runs = libraries.iter().any(|library| library.platform == host);
    for fmu in fmus {
        heading(&format!("Validate {}", file_name(fmu)));
        process::run(venv.command().arg(workspace.python().join("check.py")).arg(fmu))?;
        if runs {
            heading(&format!("Run the default experiment of {}", file_name(fmu)));
            process::run(venv.command().arg(workspace.python().join("experiment.py")).arg(fmu))?;
        }
    }
    if !runs {
        println!("not run here: the FMUs hold no library for {host}");
        return Ok(());
    }
    let drive = workspace.fmus().join(format!("{}.ssp", ssp::NAME));
    heading(&format!("Validate and run {}", file_name(&drive)));
    process::run(venv.command().arg(workspace.python().join("check.py")).arg(&drive))?;
    process::run(venv.command().arg(workspace.python().join("drive.py")).arg(&drive))?;

    heading("Compare the friction laws");
    let of = |model: &str| workspace.fmus().join(format!("{model}.fmu"));
    let catalogue = workspace.python().join("catalogue.py");
    process::run(venv.command().arg(catalogue).arg(of("FrictionBench")).arg(of("PneumaticServoCylinder")))
}

/// Puts libraries for any number of platforms into one FMU per model, and returns the files.
///
/// # Errors
/// When a source file is missing or an FMU cannot be written.
pub fn join(workspace: &Workspace, libraries: &[Library]) -> Result<Vec<PathBuf>> {
    let folder = workspace.fmus();
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let moment = Moment::of_source(&workspace.root)?;
    let licences = licences::files(workspace)?;
    let mut fmus = Vec::new();
    for model in models::ALL {
        let fmu = folder.join(format!("{}.fmu", model.name));
        contents(workspace, model, libraries, &licences, moment)?.write(&fmu, moment)?;
        println!("{} ({} KiB)", fmu.display(), std::fs::metadata(&fmu)?.len().div_ceil(1024));
        fmus.push(fmu);
    }
    println!("{}", ssp::write(&folder, &workspace.descriptions(), moment)?.display());
    Ok(fmus)
}

/// Everything that is in the FMU of a model.
fn contents(
    workspace: &Workspace,
    model: &Model,
    libraries: &[Library],
    licences: &BTreeMap<String, String>,
    moment: Moment,
) -> Result<Archive> {
    let mut archive = Archive::default();
    let stamp = Stamp { guid: fmi2::guid(model), date: moment.iso() };
    archive.add("modelDescription.xml", description::xml(model, &stamp)?)?;
    for library in libraries {
        let (folder, extension) = (library.platform.folder(), library.platform.extension());
        archive.add(&format!("binaries/{folder}/{}.{extension}", model.name), library.bytes.clone())?;
    }
    archive.add("documentation/index.html", documentation::page(model, &workspace.descriptions())?)?;
    for (name, text) in licences {
        archive.add(&format!("documentation/licenses/{name}"), text.as_bytes())?;
    }
    for set in parameter_sets::of(model.name, &workspace.descriptions())? {
        archive.add(&format!("resources/{}.json", set.name), set.json()?)?;
        archive.add(&format!("resources/{}.ssv", set.name), set.ssv(moment)?)?;
    }
    archive.add("model.png", bytes(&workspace.descriptions().join("model.png"))?)?;
    Ok(archive)
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn bytes(file: &Path) -> Result<Vec<u8>> {
    std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))
}
