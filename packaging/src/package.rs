//! The FMUs, checked, with the results of their default experiments.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use pneumatic_servo_fmu::guid_of_source;

use crate::archive::Archive;
use crate::build::wasm;
use crate::description::{self, Stamp, Version};
use crate::documentation;
use crate::experiment::{self, Recording};
use crate::files;
use crate::library::{self, Library};
use crate::licences;
use crate::machine::{self, Machine};
use crate::parameter_sets;
use crate::platform::{Binary, Platform, Platforms};
use crate::process::{self, heading};
use crate::sources::{self, Size, Sources};
use crate::ssp;
use crate::timestamp::Timestamp;
use crate::tools;
use crate::venv::{Requirements, Venv};
use crate::workspace::Workspace;

/// Contents of the FMUs, and their platforms.
#[derive(Debug, Default, PartialEq)]
pub struct Package {
    /// Platforms of the FMUs; otherwise machines like this one.
    pub platforms: Option<Platforms>,
    /// Libraries that were built elsewhere, taken instead of building them.
    pub binaries: Vec<Binary>,
    /// Sources in C for targets that compile, and how large they may be.
    pub sources: Option<Size>,
    /// The name of the one model that is packed; otherwise all are.
    pub model: Option<String>,
    /// A configured machine, of which FMUs of its own are made from those of the model, the first one unless it is named.
    pub machine: Option<Machine>,
}

impl Package {
    /// For all platforms, with libraries that were built elsewhere, and with sources for others.
    pub fn for_everybody(binaries: &[Binary]) -> Self {
        let platforms = Some(Platforms(Platform::ALL.into()));
        Self { platforms, binaries: binaries.to_vec(), sources: Some(Size::Small), model: None, machine: None }
    }

    /// Builds the libraries that were not handed in, joins, validates and runs.
    ///
    /// # Errors
    /// When a tool is missing, or any of these steps fails or finds something.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        let mut workspace = workspace.clone();
        if let Some(name) = &self.model {
            workspace.product = workspace.product.only(name)?;
        }
        self.run_all(&workspace)
    }

    /// Packs all models of the product.
    fn run_all(&self, workspace: &Workspace) -> Result<()> {
        if self.sources.is_some() {
            tools::require([("the sources in C", wasm::missing()?)])?;
        }
        let handed_in = library::handed_in(workspace, &self.binaries)?;
        let libraries = match &self.platforms {
            Some(Platforms(platforms)) => {
                library::complete(handed_in, platforms.clone(), |missing| library::build(workspace, missing))?
            }
            None => library::complete(handed_in, [Platform::host()?].into(), |missing| {
                let this_machine = missing.iter().map(|_| {
                    heading("Build the shared library");
                    Library::for_this_machine(workspace)
                });
                this_machine.collect()
            })?,
        };
        self.finish(workspace, &libraries)
    }

    /// Joins libraries, validates and runs.
    ///
    /// # Errors
    /// When any of these steps fails or finds something.
    pub fn finish(&self, workspace: &Workspace, libraries: &[Library]) -> Result<()> {
        let modules = self.sources.map_or(Ok(BTreeMap::new()), |size| modules(workspace, size))?;
        heading("Join the FMUs");
        join_with(workspace, libraries, &modules)?;
        let own = self.machine.as_ref().map_or(Ok(Vec::new()), |machine| machine::write(workspace, machine))?;
        check(workspace, libraries.iter().map(|library| library.platform), &own)
    }
}

/// The FMU files of FMI 2.0, in the order of the models.
pub fn fmus(workspace: &Workspace) -> impl Iterator<Item = PathBuf> {
    fmus_of(workspace, Version::Fmi2)
}

/// The FMU files of a version, in the order of the models.
pub fn fmus_of(workspace: &Workspace, version: Version) -> impl Iterator<Item = PathBuf> {
    let folder = workspace.fmus().join(version.folder());
    workspace.product.models.iter().map(move |model| folder.join(format!("{}.fmu", model.name)))
}

/// Validates FMUs, also those of a machine, and SSP; runs them and draws the results if they hold a library for this machine.
fn check(workspace: &Workspace, mut platforms: impl Iterator<Item = Platform>, own: &[PathBuf]) -> Result<()> {
    heading("Prepare the Python environment");
    let venv = Venv::prepare(workspace, Requirements::PACKAGE)?;

    heading("Validate");
    let script = |name: &str| {
        let mut command = venv.command();
        command.arg(workspace.python().join(name));
        command
    };
    let all = Version::ALL.into_iter().flat_map(|version| fmus_of(workspace, version));
    let mut validation = script("check.py");
    validation.args(all).args(own);
    if workspace.product.has_system() {
        // FMPy has the schemas of SSP 1.0 alone; the tests validate the SSP 2.0 file by the schemas of pyssp-standard.
        validation.arg(ssp::file(&workspace.fmus(), Version::Fmi2));
    }
    process::run(&mut validation)?;

    let host = Platform::host()?;
    if !platforms.any(|platform| platform == host) {
        println!("not run here: the FMUs hold no library for {host}");
        return Ok(());
    }
    heading("Run the default experiments");
    let stated = workspace.target.join("experiments.json");
    files::write(&stated, experiment::stated(workspace.product.models)?)?;
    process::run(script("experiment.py").arg("--experiments").arg(&stated).args(fmus(workspace)))?;
    for model in workspace.product.models {
        let file = workspace.fmus().join(format!("{}.csv", model.name));
        let run = Recording::read(model, &files::text(&file)?).with_context(|| file.display().to_string())?;
        // The tests of the project compare its own FMUs with more.
        if !workspace.product.is_of_the_project() {
            run.ensure_bits(model)?;
            println!("{} gives the bits of the plant", model.name);
        }
        files::write(&file.with_extension("svg"), documentation::figure(model, &run)?)?;
    }
    println!("\nFMUs, results and figures: {}", workspace.fmus().display());
    Ok(())
}

/// Builds the modules from which sources are made, by the names of their models.
fn modules(workspace: &Workspace, size: Size) -> Result<BTreeMap<&'static str, Vec<u8>>> {
    let build = |model: &'static Model| {
        heading(&format!("Build {} for the sources in C", model.name));
        Ok((model.name, sources::module(workspace, model, size)?))
    };
    workspace.product.models.iter().map(build).collect()
}

/// Puts libraries for any number of platforms into one FMU per model and version.
///
/// # Errors
/// When a source file is missing or an FMU cannot be written.
pub fn join(workspace: &Workspace, libraries: &[Library]) -> Result<()> {
    join_with(workspace, libraries, &BTreeMap::new())
}

/// The same, with sources of those models that there is a module of.
fn join_with(workspace: &Workspace, libraries: &[Library], modules: &BTreeMap<&str, Vec<u8>>) -> Result<()> {
    for model in workspace.product.models {
        let module = modules.get(model.name);
        let sources = |version| module.map(|module| sources::sources(workspace, model, &[version], module)).transpose();
        for fmu in write(workspace, model, libraries, sources, &workspace.fmus())? {
            println!("{} ({} KiB)", fmu.display(), std::fs::metadata(&fmu)?.len().div_ceil(1024));
        }
    }
    if workspace.product.has_system() {
        let timestamp = Timestamp::of_source(&workspace.root)?;
        for version in Version::ALL {
            println!("{}", ssp::write(&workspace.fmus(), version, &workspace.descriptions(), timestamp)?.display());
        }
    }
    Ok(())
}

/// Writes the FMUs of a model below a folder, one for each version, and says where.
///
/// # Errors
/// When a source file is missing or an FMU cannot be written.
pub fn write(
    workspace: &Workspace,
    model: &'static Model,
    libraries: &[Library],
    sources: impl Fn(Version) -> Result<Option<Sources>>,
    folder: &Path,
) -> Result<Vec<PathBuf>> {
    let timestamp = Timestamp::of_source(&workspace.root)?;
    let licences = licences::files(workspace)?;
    let experiment = documentation::experiment(model)?;
    let write = |version: Version| {
        let mut archive = contents(workspace, model, version, (libraries, sources(version)?), &licences, timestamp)?;
        archive
            .add("documentation/index.html", documentation::page(model, version, &workspace.product, &experiment)?)?;
        let fmu = folder.join(version.folder()).join(format!("{}.fmu", model.name));
        archive.write(&fmu, timestamp)?;
        Ok(fmu)
    };
    Version::ALL.into_iter().map(write).collect()
}

/// Everything that is in the FMU of a model except its page.
fn contents(
    workspace: &Workspace,
    model: &Model,
    version: Version,
    (libraries, sources): (&[Library], Option<Sources>),
    licences: &BTreeMap<String, String>,
    timestamp: Timestamp,
) -> Result<Archive> {
    let mut archive = Archive::default();
    let product = &workspace.product;
    let (files, sources) = sources.map(|sources| (sources.files, sources.compiled)).unwrap_or_default();
    let stamp = Stamp {
        guid: guid_of_source(model, product.source.as_deref()),
        date: timestamp.iso(),
        version: product.version.clone(),
        licence: product.licence.clone(),
        sources,
    };
    for (name, text) in files {
        archive.add(&format!("sources/{name}"), text)?;
    }
    archive.add("modelDescription.xml", description::xml(model, version, &stamp)?)?;
    for library in libraries {
        let extension = library.platform.extension();
        for folder in library.folders(version) {
            let path = format!("binaries/{folder}/{}.{extension}", model.name);
            archive.add_compressed(&path, library.compressed(timestamp)?)?;
        }
    }
    for (name, text) in licences {
        archive.add(&format!("documentation/licenses/{name}"), text.as_bytes())?;
    }
    for set in parameter_sets::of(model, &product.parts)? {
        archive.add(&format!("resources/{}.json", set.name), set.json()?)?;
        archive.add(&format!("resources/{}.ssv", set.name), set.ssv(ssp::Version::One, timestamp)?)?;
    }
    let [png, svg] = ["png", "svg"].map(|extension| product.parts.read(&format!("icons/{}.{extension}", model.name)));
    let (png, svg) = (png?, svg?);
    match version {
        Version::Fmi2 => png.into_iter().try_for_each(|icon| archive.add("model.png", icon))?,
        Version::Fmi3 => {
            let terminals = description::terminals(model, png.is_some())?;
            archive.add("terminalsAndIcons/terminalsAndIcons.xml", terminals)?;
            png.into_iter().try_for_each(|icon| archive.add("terminalsAndIcons/icon.png", icon))?;
            svg.into_iter().try_for_each(|icon| archive.add("terminalsAndIcons/icon.svg", icon))?;
        }
    }
    Ok(archive)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_an_fmu_for_each_version_with_the_sources_for_it() -> Result<()> {
        let workspace = Workspace::of_the_project()?;
        let model = workspace.product.models.first().context("no model")?;
        let folder = files::scratch("package");
        let sources = |version| {
            let name = format!("{version:?}.c");
            Ok(Some(Sources { files: [(name.clone(), "int a;".to_owned())].into(), compiled: vec![name] }))
        };
        let fmus = write(&workspace, model, &[], sources, &folder)?;
        let name = format!("{}.fmu", model.name);
        assert_eq!(fmus, [folder.join(&name), folder.join("fmi3").join(&name)]);
        for (fmu, own) in fmus.iter().zip(["sources/Fmi2.c", "sources/Fmi3.c"]) {
            let archive = zip::ZipArchive::new(std::fs::File::open(fmu)?)?;
            let names = archive.file_names().collect::<Result<Vec<_>, _>>()?;
            let sources: Vec<_> = names.iter().filter(|name| name.starts_with("sources/")).collect();
            assert_eq!(sources, [own]);
            assert!(names.iter().any(|name| *name == "modelDescription.xml"), "{names:?}");
        }
        std::fs::remove_dir_all(&folder)?;
        Ok(())
    }
}
