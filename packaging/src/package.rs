//! `cargo xtask package` and `cargo xtask join`: the FMUs, checked, with the results of their default experiments.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use pneumatic_servo::model::Model;
use pneumatic_servo_fmu::guid_of_source;

use crate::archive::Archive;
use crate::build::wasm;
use crate::describe;
use crate::description::{self, Stamp, Version};
use crate::documentation;
use crate::experiment::Run;
use crate::files;
use crate::libraries;
use crate::library::{self, Library};
use crate::licences;
use crate::moment::Moment;
use crate::parameter_sets;
use crate::platform::{Binary, Platform, Platforms};
use crate::process::{self, heading};
use crate::sources::{self, Size, Sources};
use crate::ssp;
use crate::tools;
use crate::venv::{Requirements, Venv};
use crate::workspace::Workspace;

/// Build the FMUs and the SSP, validate them and run the default experiment of each.
///
/// Results are in target/fmu: an FMU per model, its results as CSV and its figure, and the SSP; in target/fmu/fmi3 the same
/// FMUs for FMI 3.0.
#[derive(Args, Default)]
#[command(after_help = EXAMPLES)]
pub struct Package {
    /// What the FMUs run on: `linux64,win64,darwin64` or `all`; otherwise machines like this one.
    #[arg(long)]
    platforms: Option<Platforms>,
    /// A library that was built elsewhere, taken instead of building one.
    #[arg(long = "binary", value_name = "PLATFORM=PATH")]
    binaries: Vec<Binary>,
    /// Add the sources in C, for targets that compile: `small`, or `full` for larger and faster ones.
    #[arg(long, value_name = "SIZE", num_args = 0..=1, require_equals = true, default_missing_value = "small")]
    sources: Option<Size>,
}

const EXAMPLES: &str = "\
Examples:
  cargo xtask package                                     for machines like this one
  cargo xtask package --platforms all                     for Linux, Windows and macOS (docs/platforms.md)
  cargo xtask package --binary darwin64=out/plant.dylib   and a library that was built on another machine
  cargo xtask package --sources                           and sources in C for any other target (docs/target.md)

After it:
  cargo xtask wheel                                       the Python package that examples and studies use
  cargo xtask gallery                                     all friction laws, compared";

impl Package {
    /// For all platforms, with libraries that were built elsewhere, and with sources for others.
    pub fn for_everybody(binaries: &[Binary]) -> Self {
        let platforms = Some(Platforms(Platform::ALL.into()));
        Self { platforms, binaries: binaries.to_vec(), sources: Some(Size::Small) }
    }

    /// Builds what was not handed in, joins, validates and runs.
    ///
    /// # Errors
    /// When a tool is missing, or any of these steps fails or finds something.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        if self.sources.is_some() {
            tools::require([("the sources in C", wasm::missing()?)])?;
        }
        let handed_in = library::handed_in(workspace, &self.binaries)?;
        let libraries = match &self.platforms {
            Some(Platforms(platforms)) => {
                library::complete(handed_in, platforms.clone(), |missing| libraries::build(workspace, missing))?
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
        check(workspace, libraries.iter().map(|library| library.platform))
    }
}

/// Put shared libraries that are built into the FMUs, the second half of `package`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  cargo xtask join --platforms linux64,win64                     what `cargo xtask build` left in target/binaries
  cargo xtask join --platforms linux64 --binary win64=plant.dll  and what was built elsewhere, from the same source")]
pub struct Join {
    /// Platforms whose libraries are in target/binaries: `linux64,win64,darwin64` or `all`.
    #[arg(long, required_unless_present = "binaries")]
    platforms: Option<Platforms>,
    /// A library that was built elsewhere.
    #[arg(long = "binary", value_name = "PLATFORM=PATH")]
    binaries: Vec<Binary>,
}

impl Join {
    /// Takes the libraries that were handed in, and those that `cargo xtask build` left.
    ///
    /// # Errors
    /// When a library is not there or does not pass the gates, or an FMU cannot be written.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        let handed_in = library::handed_in(workspace, &self.binaries)?;
        let wanted = self.platforms.iter().flat_map(|Platforms(platforms)| platforms.clone()).collect();
        let kept = |&platform: &Platform| {
            let file = library::kept(workspace, platform);
            let built = Library::read(workspace, &Binary { platform, file });
            built.with_context(|| {
                format!("build it with `cargo xtask build --platforms {platform}` or add `--binary {platform}=PATH`")
            })
        };
        let libraries = library::complete(handed_in, wanted, |missing| missing.iter().map(kept).collect())?;
        join(workspace, &libraries)
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

/// Validates FMUs and SSP; runs them and draws what came out if they hold a library for this machine.
fn check(workspace: &Workspace, mut platforms: impl Iterator<Item = Platform>) -> Result<()> {
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
    validation.args(all);
    if workspace.product.is_of_the_project() {
        validation.arg(workspace.fmus().join(format!("{}.ssp", ssp::NAME)));
    }
    process::run(&mut validation)?;

    let host = Platform::host()?;
    if !platforms.any(|platform| platform == host) {
        println!("not run here: the FMUs hold no library for {host}");
        return Ok(());
    }
    heading("Run the default experiments");
    let stated = workspace.target.join("experiments.json");
    files::write(&stated, describe::experiments(workspace.product.models)?)?;
    process::run(script("experiment.py").arg("--experiments").arg(&stated).args(fmus(workspace)))?;
    for model in workspace.product.models {
        let file = workspace.fmus().join(format!("{}.csv", model.name));
        let run = Run::read(model, &files::text(&file)?).with_context(|| file.display().to_string())?;
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
        let sources = |version| module.map(|module| sources::of(workspace, model, &[version], module)).transpose();
        for fmu in write(workspace, model, libraries, sources, &workspace.fmus())? {
            println!("{} ({} KiB)", fmu.display(), std::fs::metadata(&fmu)?.len().div_ceil(1024));
        }
    }
    if workspace.product.is_of_the_project() {
        let moment = Moment::of_source(&workspace.root)?;
        println!("{}", ssp::write(&workspace.fmus(), &workspace.descriptions(), moment)?.display());
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
    let moment = Moment::of_source(&workspace.root)?;
    let licences = licences::files(workspace)?;
    let experiment = documentation::experiment(model)?;
    let write = |version: Version| {
        let mut archive = contents(workspace, model, version, (libraries, sources(version)?), &licences, moment)?;
        archive
            .add("documentation/index.html", documentation::page(model, version, &workspace.product, &experiment)?)?;
        let fmu = folder.join(version.folder()).join(format!("{}.fmu", model.name));
        archive.write(&fmu, moment)?;
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
    moment: Moment,
) -> Result<Archive> {
    let mut archive = Archive::default();
    let product = &workspace.product;
    let (files, sources) = sources.map(|sources| (sources.files, sources.compiled)).unwrap_or_default();
    let stamp = Stamp {
        guid: guid_of_source(model, product.source.as_deref()),
        date: moment.iso(),
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
            archive.add(&format!("binaries/{folder}/{}.{extension}", model.name), library.bytes.clone())?;
        }
    }
    for (name, text) in licences {
        archive.add(&format!("documentation/licenses/{name}"), text.as_bytes())?;
    }
    for set in parameter_sets::of(model, &product.parts)? {
        archive.add(&format!("resources/{}.json", set.name), set.json()?)?;
        archive.add(&format!("resources/{}.ssv", set.name), set.ssv(moment)?)?;
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
    use pneumatic_servo::models::{pneumatic_servo_cylinder, position_controller};

    use super::*;
    use crate::gates;
    use crate::stand_in::{self, Answer, StandIn, Started};

    /// Those that the SSP is made of.
    static SYSTEM: [Model; 2] = [pneumatic_servo_cylinder::MODEL, position_controller::MODEL];
    static ONE: [Model; 1] = [position_controller::MODEL];

    /// A workspace of a test, with few models, and a machine that builds a library, and whose hosts write results.
    fn workshop(name: &str, models: &'static [Model]) -> Result<(PathBuf, Workspace, StandIn)> {
        let folder = files::scratch(name);
        let mut workspace = Workspace::of_a_test(&folder);
        workspace.product.models = models;
        let (library, fmus) = (folder.join("built.so"), workspace.fmus());
        files::write(&library, gates::made::linux())?;
        let tables = models.iter().map(|model| Ok((model.name, Run::table_of_a_host(model)?)));
        let tables: Vec<_> = tables.collect::<Result<_>>()?;
        let machine = StandIn::new(move |command| {
            if command.says("rustc --release") {
                return Some(stand_in::built(command, &library));
            }
            if command.line().contains("experiment.py") {
                for (model, table) in &tables {
                    stand_in::writes(fmus.join(format!("{model}.csv")), table);
                }
            }
            None
        });
        Ok((folder, workspace, machine))
    }

    /// The steps of a package, as far as they were started.
    fn steps(started: &[Started]) -> Vec<&'static str> {
        let name = |it: &Started| {
            let all = ["rustc --release", "check.py", "experiment.py"];
            all.into_iter().find(|step| it.line().contains(step))
        };
        started.iter().filter_map(name).collect()
    }

    /// The names of what is in an archive.
    fn names(fmu: &Path) -> Result<Vec<String>> {
        let archive = zip::ZipArchive::new(std::fs::File::open(fmu)?)?;
        let names = archive.file_names().map(|name| Ok(name?.into_owned()));
        names.collect()
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn fmus_are_built_joined_validated_and_then_run() -> Result<()> {
        let (folder, workspace, machine) = workshop("package-all", &SYSTEM)?;
        let (outcome, started) = machine.does(|| Package::default().run(&workspace));
        outcome?;
        assert_eq!(steps(&started), ["rustc --release", "check.py", "experiment.py"]);
        let of = |name: &str| started.iter().find(|it| it.line().contains(name)).context(name.to_owned());
        assert!(of("rustc --release")?.says("--package pneumatic-servo-builtin"));
        let files = ["fmu/PneumaticServoCylinder.fmu", "fmu/PositionController.fmu"].map(|name| folder.join(name));
        let of_fmi3 = files.clone().map(|file| folder.join("fmu/fmi3").join(file.file_name().unwrap_or_default()));
        let system = folder.join("fmu").join(format!("{}.ssp", ssp::NAME));
        let has = |command: &Started, file: &PathBuf| command.arguments.contains(&file.display().to_string());
        for file in files.iter().chain(&of_fmi3).chain([&system]) {
            assert!(file.is_file() && has(of("check.py")?, file), "{}", file.display());
        }
        assert!(files.iter().all(|file| has(of("experiment.py").unwrap(), file)));
        let stated = files::text(of("experiment.py")?.after("--experiments"))?;
        assert!(stated.contains("PositionController") && !stated.contains("FrictionBench"), "{stated}");
        for file in &files {
            assert!(files::text(file.with_extension("svg"))?.contains("<svg"));
            let names = names(file)?;
            let library = format!("binaries/linux64/{}.so", file.file_stem().unwrap_or_default().to_string_lossy());
            assert!(names.contains(&library) && !names.iter().any(|name| name.starts_with("sources/")), "{names:?}");
        }
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// A crate of one's own has no SSP; its bits are those of the plant, or that is said.
    #[test]
    #[cfg(target_os = "linux")]
    fn a_crate_of_ones_own_is_held_to_the_bits_of_its_models() -> Result<()> {
        let (folder, mut workspace, machine) = workshop("package-own", &ONE)?;
        workspace.product.source = Some("0123".to_owned());
        let (outcome, started) = machine.does(|| Package::default().run(&workspace));
        outcome?;
        assert!(!started.iter().any(|it| it.line().contains(".ssp")));
        let built = started.iter().find(|it| it.says("rustc --release")).context("no library")?;
        assert_eq!(built.variable("FMU_SOURCE_FINGERPRINT"), "0123");

        let (csv, built) = (workspace.fmus().join("PositionController.csv"), folder.join("built.so"));
        let mut table = files::text(&csv)?;
        let end = table.rfind(',').context("no number")?;
        table.replace_range(end + 1.., "0.12345\n");
        let other = StandIn::new(move |command| match command {
            _ if command.says("rustc --release") => Some(stand_in::built(command, &built)),
            _ if command.line().contains("experiment.py") => Some(stand_in::writes(&csv, &table)),
            _ => None,
        });
        let problem = other.does(|| Package::default().run(&workspace)).0.map_err(|error| format!("{error:#}"));
        assert!(problem.is_err_and(|text| text.contains("is 0.12345 in the host")));
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// What fails ends it; what follows is not begun.
    #[test]
    #[cfg(target_os = "linux")]
    fn what_does_not_build_is_not_joined_and_what_is_not_valid_not_run() -> Result<()> {
        for (failing, expected) in
            [("rustc --release", vec!["rustc --release"]), ("check.py", vec!["rustc --release", "check.py"])]
        {
            let (folder, workspace, _) = workshop("package-failing", &ONE)?;
            let library = folder.join("built.so");
            let mut product = workspace.clone();
            product.product.source = Some("0123".to_owned());
            let machine = StandIn::new(move |command| match command {
                _ if command.line().contains(failing) => Some(Answer::Fails),
                _ => command.says("rustc --release").then(|| stand_in::built(command, &library)),
            });
            let (outcome, started) = machine.does(|| Package::default().run(&product));
            assert!(outcome.is_err_and(|error| format!("{error:#}").contains(failing)));
            assert_eq!(steps(&started), expected);
            assert_eq!(workspace.fmus().exists(), failing == "check.py");
            std::fs::remove_dir_all(&folder)?;
        }
        Ok(())
    }

    #[test]
    fn sources_without_their_tools_and_libraries_that_are_none_are_refused_before_anything_is_built() -> Result<()> {
        let (folder, workspace, _) = workshop("package-refused", &ONE)?;
        let everything = StandIn::new(|_| None).compiling_for(&folder, &[]).lacking("wasm-ld");
        let package = Package { sources: Some(Size::Small), ..Package::default() };
        let (outcome, started) = everything.does(|| package.run(&workspace));
        assert!(outcome.is_err_and(|error| error.to_string().contains("for the sources in C: ")));
        assert!(started.is_empty(), "{started:?}");
        let package = Package { binaries: vec!["win64=no/such.dll".parse()?], ..Package::default() };
        let (outcome, started) = StandIn::new(|_| None).does(|| package.run(&workspace));
        assert!(outcome.is_err_and(|error| format!("{error:#}").contains("no/such.dll")));
        assert!(started.is_empty(), "{started:?}");
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn everybody_gets_all_platforms_and_small_sources() -> Result<()> {
        let binary: Binary = "win64=a.dll".parse()?;
        let package = Package::for_everybody(std::slice::from_ref(&binary));
        assert_eq!(package.platforms, Some("all".parse()?));
        assert_eq!((package.binaries, package.sources), (vec![binary], Some(Size::Small)));
        Ok(())
    }

    /// FMUs for other machines are validated, and cannot be run here.
    #[test]
    #[cfg(target_os = "linux")]
    fn fmus_without_a_library_for_this_machine_are_not_run() -> Result<()> {
        let (folder, mut workspace, machine) = workshop("package-other", &ONE)?;
        workspace.product.source = Some("0123".to_owned());
        let library =
            |platform| Library { platform, architectures: ["x86_64".to_owned()].into(), bytes: vec![1, 2, 3] };
        let both = [library(Platform::Win64), library(Platform::Linux64)];
        let (outcome, started) = StandIn::new(|_| None).does(|| Package::default().finish(&workspace, &both[..1]));
        outcome?;
        assert_eq!(steps(&started), ["check.py"]);
        let names = names(&workspace.fmus().join("fmi3/PositionController.fmu"))?;
        assert!(names.contains(&"binaries/x86_64-windows/PositionController.dll".to_owned()), "{names:?}");
        let (outcome, started) = machine.does(|| Package::default().finish(&workspace, &both));
        outcome?;
        assert_eq!(steps(&started), ["check.py", "experiment.py"]);
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// A small module is compiled for size, and a full one for speed, each of its own model.
    #[test]
    fn a_module_is_built_for_each_model() -> Result<()> {
        let folder = files::scratch("package-modules");
        let mut workspace = Workspace::of_a_test(&folder);
        workspace.product.models = &SYSTEM;
        let module = |model: &str| format!("module of {model}").into_bytes();
        for (size, is_small) in [(Size::Small, true), (Size::Full, false)] {
            let file = folder.join("built.wasm");
            let machine = StandIn::new(move |command| {
                command.says("rustc --release").then(|| {
                    stand_in::writes(&file, module(command.variable("ONLY_MODEL")));
                    stand_in::built(command, &file)
                })
            });
            let machine = machine.compiling_for(&folder.join("sysroot"), &["wasm32-unknown-unknown"]);
            let (built, started) = machine.does(|| modules(&workspace, size));
            let expected = SYSTEM.iter().map(|model| (model.name, module(model.name))).collect();
            assert_eq!(built?, expected);
            assert!(started.iter().all(|it| it.says("--target wasm32-unknown-unknown")));
            assert!(started.iter().all(|it| it.says("--features small") == is_small), "{started:?}");
        }
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// Libraries that were built before, or come from elsewhere; nothing is built.
    #[test]
    #[cfg(target_os = "linux")]
    fn what_was_built_before_is_joined() -> Result<()> {
        let (folder, mut workspace, _) = workshop("package-join", &ONE)?;
        workspace.product.source = Some("0123".to_owned());
        let join = Join { platforms: Some("linux64".parse()?), binaries: Vec::new() };
        let machine = || StandIn::new(|_| Some(Answer::Starts));
        let problem = machine().does(|| join.run(&workspace)).0.map_err(|error| format!("{error:#}"));
        assert!(problem.is_err_and(|text| text.contains("`cargo xtask build --platforms linux64`")));
        assert!(!workspace.fmus().exists());
        files::write(&library::kept(&workspace, Platform::Linux64), gates::made::linux())?;
        let (outcome, started) = machine().does(|| join.run(&workspace));
        outcome?;
        assert!(started.is_empty(), "{started:?}");
        let names = names(&workspace.fmus().join("PositionController.fmu"))?;
        assert!(names.contains(&"binaries/linux64/PositionController.so".to_owned()), "{names:?}");
        Ok(std::fs::remove_dir_all(&folder)?)
    }

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
