//! `cargo xtask package`: the FMUs, checked, with results and figures beside them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use pneumatic_servo::simulation::Model;
use pneumatic_servo::{fmi2, models};

use crate::archive::Archive;
use crate::description::{self, Stamp};
use crate::documentation;
use crate::library::Library;
use crate::licences;
use crate::moment::Moment;
use crate::parameter_sets;
use crate::process::{self, heading};
use crate::ssp;
use crate::venv::Venv;
use crate::workspace::Workspace;

/// Builds every FMU, validates it, runs its default experiment and draws the figures.
///
/// # Errors
/// When a tool is missing, or any of these steps fails or finds something.
pub fn run(workspace: &Workspace) -> Result<()> {
    heading("Build the shared library");
    let library = Library::build(workspace)?;

    heading("Join the FMUs");
    let fmus = join(workspace, &[library])?;

    heading("Prepare the Python environment");
    let venv = Venv::prepare(workspace)?;
    println!("{}", venv.python().display());

    for fmu in &fmus {
        heading(&format!("Validate {}", file_name(fmu)));
        process::run(venv.command().arg(workspace.python().join("check.py")).arg(fmu))?;
        heading(&format!("Run the default experiment of {}", file_name(fmu)));
        process::run(venv.command().arg(workspace.python().join("experiment.py")).arg(fmu))?;
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
