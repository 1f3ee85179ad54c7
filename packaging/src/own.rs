//! FMUs of any other crate, packed by a program of two lines in it.

use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use pneumatic_servo::model::Model;

use crate::package::Package;
use crate::product::{Parts, Product};
use crate::workspace::{self, ENVIRONMENTS, Workspace};
use crate::{ended, fingerprint, lock, not_begun, process, soundness};

/// The crate whose models are packed, as [`package_fmus!`](crate::package_fmus) fills it in.
#[derive(Clone, Copy, Debug)]
pub struct Crate {
    /// Its models: those that its library serves.
    pub models: &'static [Model],
    /// Its folder.
    pub folder: &'static str,
    /// Its name.
    pub name: &'static str,
    /// Its version.
    pub version: &'static str,
    /// Its licence, as SPDX writes it; empty if it states none.
    pub licence: &'static str,
}

/// A `main` that packs the models of a crate into FMUs, from the library that [`export_fmu!`](pneumatic_servo_fmu::export_fmu)
/// makes of it. Its only line is in `examples/package.rs` of that crate:
///
/// ```ignore
/// pneumatic_servo_packaging::package_fmus!(quarter_car::LIBRARY);
/// ```
///
/// The crate depends on this one by a feature, so that nothing else takes the time to compile it:
///
/// ```toml
/// [features]
/// package = ["dep:pneumatic-servo-packaging"]
///
/// [[example]]
/// name = "package"
/// required-features = ["package"]
/// ```
///
/// `cargo run --features package --example package` then builds the library, describes the models in FMI 2.0 and 3.0, writes the page of each, zips,
/// validates with FMPy, runs the default experiments, compares their bits with the models themselves and draws them. Everything is
/// in `fmu` below the target folder. The variable `FMU_ENVIRONMENTS` names a folder for the Python environment, if several crates
/// are to share it.
///
/// Hand-written parts of the FMUs are in the folder `modelDescription` of the crate; none of them is needed:
///
/// | file | what it is |
/// |---|---|
/// | `<Model>.html` | the beginning of the page: sections of HTML, with equations in LaTeX between `\(` and `\)`, or `\[` and `\]` |
/// | `friction-laws.html` | rows for the table of friction laws, `<tr><td>Name</td><td>equations</td><td>source</td></tr>` |
/// | `parameter_sets.json` | sets of parameters, which become `resources` |
/// | `icons/<Model>.png`, `icons/<Model>.svg` | the icon |
///
/// Models that are named as those of the project have its parts where the crate has none.
#[macro_export]
macro_rules! package_fmus {
    ($library:path) => {
        fn main() -> std::process::ExitCode {
            let own = $crate::Crate {
                models: $library.models(),
                folder: env!("CARGO_MANIFEST_DIR"),
                name: env!("CARGO_PKG_NAME"),
                version: env!("CARGO_PKG_VERSION"),
                licence: env!("CARGO_PKG_LICENSE"),
            };
            $crate::package(&own, std::env::args_os())
        }
    };
}

/// Builds the FMUs of this crate, validates them and runs the default experiment of each.
///
/// Results are in target/fmu: an FMU per model, its results as CSV and its figure; in target/fmu/fmi3 the same FMUs for FMI 3.0.
#[derive(Parser)]
struct Arguments {
    #[command(flatten)]
    package: Package,
}

/// Packs the models of a crate; what the command line of the program says, after its name, is what `cargo xtask package` takes.
pub fn package(of: &Crate, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    match Arguments::try_parse_from(arguments) {
        Ok(arguments) => ended(run(of, &arguments.package)),
        Err(told) => not_begun(&told),
    }
}

/// Nothing is built or written before the models are known to be sound.
fn run(of: &Crate, package: &Package) -> Result<()> {
    soundness::check(of.models)?;
    for wrong in soundness::wrong_slopes(of.models) {
        eprintln!("warning: {wrong}; a plain number to the left of a parameter loses its slope");
    }
    let workspace = around(of)?;
    let _alone = lock::hold(&workspace.target)?;
    package.run(&workspace)
}

fn around(of: &Crate) -> Result<Workspace> {
    let folder = Path::new(of.folder);
    let product = Product {
        models: of.models,
        package: of.name.to_owned(),
        version: of.version.to_owned(),
        licence: of.licence.to_owned(),
        source: Some(fingerprint::of(folder)?),
        parts: Parts::of_a_crate(folder.join("modelDescription"), &workspace::home()),
    };
    Workspace::around(folder, product)
}

/// Packs the model of one's own among the examples, as its author does; its FMUs are in target/own/fmu. What compiles the
/// program is the target directory of the project, where most of it is compiled already. The library is compiled without
/// optimization, in a fifth of the time: its bits are the same, as the run shows, and what a step costs is asked elsewhere.
///
/// # Errors
/// When that fails.
pub fn check(workspace: &Workspace) -> Result<()> {
    process::heading("A model of one's own: pack its FMU");
    let mut cargo = process::cargo();
    cargo.args(["run", "--profile", "quick", "--features", "package", "--example", "package"]);
    cargo.args(["--manifest-path", "examples/own/model/Cargo.toml", "--target-dir"]).arg(&workspace.target);
    cargo.env("CARGO_TARGET_DIR", workspace.target.join("own")).env(ENVIRONMENTS, &workspace.environments);
    cargo.env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "0").env("CARGO_PROFILE_RELEASE_LTO", "off");
    process::run(cargo.current_dir(&workspace.home))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use anyhow::Context;
    use cargo_metadata::{DependencyKind, MetadataCommand, Target, TargetKind};

    use pneumatic_servo::models::position_controller;

    use super::*;
    use crate::files;
    use crate::stand_in::{self, StandIn, Started};

    static SOUND: [Model; 1] = [position_controller::MODEL];
    static UNSOUND: [Model; 1] = [Model { description: "", ..position_controller::MODEL }];
    const OWN: Crate = Crate {
        models: &SOUND,
        folder: concat!(env!("CARGO_MANIFEST_DIR"), "/../ssp"),
        name: "quarter-car",
        version: "1.2.3",
        licence: "MIT",
    };

    /// A machine on which no library can be built, and whose target directory is another one.
    fn machine(target: &Path) -> StandIn {
        let target = target.to_owned();
        StandIn::new(move |command| match command {
            // What the fingerprint asks is of all packages.
            _ if command.says("--no-deps") => Some(stand_in::metadata(&workspace::home(), &target, &[])),
            _ => command.says("rustc --release").then_some(stand_in::Answer::Fails),
        })
    }

    #[test]
    fn a_crate_is_packed_if_its_models_are_sound() -> Result<()> {
        let folder = files::scratch("own");
        let failure = format!("{:?}", ExitCode::FAILURE);
        let pack = |models, words: &str| {
            let arguments = words.split(' ').map(OsString::from);
            let (code, started) = machine(&folder).does(|| package(&Crate { models, ..OWN }, arguments));
            (format!("{code:?}"), started)
        };
        let (code, started) = pack(&SOUND, "package");
        assert_eq!(code, failure);
        let [built] = &started[..] else { panic!("{started:?}") };
        assert!(
            built.says("--package quarter-car") && built.variable("FMU_SOURCE_FINGERPRINT").len() == 32,
            "{built:?}"
        );
        for (models, words, expected) in [
            (&UNSOUND, "package", failure),
            (&SOUND, "package --platforms amiga", format!("{:?}", ExitCode::from(2))),
            (&SOUND, "package --help", format!("{:?}", ExitCode::SUCCESS)),
        ] {
            let (code, started) = pack(models, words);
            assert_eq!((code, started.len()), (expected, 0), "{words}");
        }
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn what_is_packed_is_what_the_crate_says_of_itself() -> Result<()> {
        let target = files::scratch("own-product");
        let (workspace, _) = machine(&target).with(ENVIRONMENTS, "/shared").does(|| around(&OWN));
        let Workspace { product, environments, .. } = workspace?;
        assert_eq!((&*product.package, &*product.version, &*product.licence), ("quarter-car", "1.2.3", "MIT"));
        assert!(!product.is_of_the_project() && product.models[0].name == "PositionController");
        assert_eq!(environments, Path::new("/shared"));
        let folders: Vec<_> = product.parts.folders().collect();
        assert_eq!(
            folders,
            [&*Path::new(OWN.folder).join("modelDescription"), &*workspace::home().join("modelDescription")]
        );
        Ok(())
    }

    /// The example is packed as its author does it, in a folder of its own, with the environments that are there already.
    #[test]
    fn the_example_is_packed_by_its_own_program() {
        let workspace = Workspace::of_a_test(Path::new("/target"));
        let (outcome, started) = StandIn::new(|_| None).does(|| check(&workspace));
        assert!(outcome.is_ok());
        let [cargo] = &started[..] else { panic!("{started:?}") };
        assert!(
            cargo.line().starts_with("cargo run ") && cargo.says("--features package --example package"),
            "{cargo:?}"
        );
        assert_eq!(cargo.after("--manifest-path"), "examples/own/model/Cargo.toml");
        assert_eq!(cargo.folder.as_deref(), Some(&*workspace::home()));
        assert_eq!((cargo.after("--target-dir"), cargo.variable("CARGO_TARGET_DIR")), ("/target", "/target/own"));
        assert_eq!(cargo.variable(ENVIRONMENTS), "/target/environments");
        let fails = StandIn::new(|_: &Started| Some(stand_in::Answer::Fails));
        assert!(fails.does(|| check(&workspace)).0.is_err());
    }

    /// What is downloaded, of a lock file: names with versions.
    fn downloaded(file: &Path) -> Result<BTreeSet<String>> {
        let text = files::text(file)?;
        let packages = text.split("[[package]]\n").filter(|package| package.contains("\nsource = "));
        Ok(packages.map(|package| package.lines().take(2).collect::<Vec<_>>().join(", ")).collect())
    }

    #[test]
    fn crates_from_outside_have_the_versions_of_everything_else() -> Result<()> {
        let ours = downloaded(&workspace::home().join("Cargo.lock"))?;
        let theirs = downloaded(&workspace::home().join("examples/own/Cargo.lock"))?;
        assert!(theirs.len() > 20, "{theirs:?}");
        // Otherwise what they share is compiled once more.
        let others: Vec<_> = theirs.difference(&ours).collect();
        assert!(others.is_empty(), "copy Cargo.lock to examples/own: {others:?}");
        Ok(())
    }

    /// A shared library has no hash in its file's name: that of a crate from outside, compiled into the same folder, would
    /// overwrite the library that this program is made of.
    #[test]
    fn nothing_that_this_program_is_made_of_is_a_shared_library() -> Result<()> {
        let metadata = MetadataCommand::new().no_deps().current_dir(workspace::home()).exec()?;
        let ours = |name: &str| metadata.packages.iter().find(|it| it.name.as_str() == name);
        let mut names = vec![env!("CARGO_PKG_NAME").to_owned()];
        let mut seen = 0;
        while let Some(name) = names.get(seen) {
            let package = ours(name).with_context(|| format!("no package {name}"))?;
            let is_shared = |it: &Target| it.is_kind(TargetKind::CDyLib) || it.is_kind(TargetKind::DyLib);
            assert!(!package.targets.iter().any(is_shared), "{name} is a shared library too");
            let needed = package.dependencies.iter().filter(|it| it.kind != DependencyKind::Development);
            let new: Vec<_> =
                needed.map(|it| &it.name).filter(|it| ours(it).is_some() && !names.contains(it)).cloned().collect();
            names.extend(new);
            seen += 1;
        }
        assert!(names.len() > 3, "{names:?}");
        Ok(())
    }
}
