//! FMUs of any other crate, packed by a program of two lines in it.

use std::ffi::OsString;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow, ensure};
use pneumatic_servo::conformance::{self, undeclared_dependencies};
use pneumatic_servo::model::{Model, Setup};
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Variable};

use crate::build::wasm;
use crate::commands::LoopOptions;
use crate::package::Package;
use crate::product::{Parts, Product};
use crate::workspace::{self, Workspace};
use crate::{commands, files, fingerprint, lock, sources, tools};

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
/// Models with names of the project's models use its parts where the crate has none.
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

/// Packs the models of a crate; what the command line of the program says, after its name, is what `cargo xtask package` takes.
pub fn package(of: &Crate, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    commands::run_of_a_crate(arguments.into_iter().skip(1), |package| run(of, package))
}

/// A `main` that makes sources in C of a control loop from the module that `pneumatic_servo_loop::export_loop!` makes of a crate:
/// the plant without FMI, for machines with little memory. Its only line is in `examples/package.rs` of that crate, which depends on
/// this one as for [`package_fmus!`](crate::package_fmus), with the feature `sources`:
///
/// ```ignore
/// pneumatic_servo_packaging::package_loop!(own_loop::CYLINDER);
/// ```
///
/// `cargo run --features package --example package` then leaves the sources in the folder `loop/<Model>` below the target folder.
#[macro_export]
macro_rules! package_loop {
    ($model:path) => {
        fn main() -> std::process::ExitCode {
            let own = $crate::Crate {
                models: std::slice::from_ref(&$model),
                folder: env!("CARGO_MANIFEST_DIR"),
                name: env!("CARGO_PKG_NAME"),
                version: env!("CARGO_PKG_VERSION"),
                licence: env!("CARGO_PKG_LICENSE"),
            };
            $crate::package_loop(&own, std::env::args_os())
        }
    };
}

/// Makes sources of the loop of a crate.
pub fn package_loop(of: &Crate, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    commands::run_of_a_loop(arguments.into_iter().skip(1), |options| run_loop(of, options))
}

fn run_loop(of: &Crate, options: &LoopOptions) -> Result<()> {
    of.models.iter().try_for_each(ensure_sound)?;
    let workspace = around(of)?;
    let _alone = lock::hold(&workspace.target)?;
    tools::require([("the sources in C", wasm::missing()?)])?;
    for model in of.models {
        let module = wasm::of_loop(&workspace, options.stack, &options.features)?;
        let folder = workspace.target.join("loop").join(model.name);
        files::renew(&folder)?;
        for (name, text) in sources::loop_sources(&workspace, model, &module)?.files {
            files::write(&folder.join(name), text)?;
        }
        println!("{}", folder.display());
    }
    Ok(())
}

/// Nothing is built or written before the models are known to start.
fn run(of: &Crate, package: &Package) -> Result<()> {
    of.models.iter().try_for_each(ensure_sound)?;
    let workspace = around(of)?;
    let _alone = lock::hold(&workspace.target)?;
    package.run(&workspace)
}

/// Refuses a model that says nothing of itself, does not start with its defaults, whose default experiment is none, whose
/// equations depend on more than its table says, which would be the structure in the description, or whose runs break a promise.
/// The checks of `pneumatic_servo::conformance` that take longer are for the tests of the crate.
fn ensure_sound(model: &'static Model) -> Result<()> {
    let name = model.name;
    ensure!(!model.description.is_empty(), "{name} has no description");
    let started = Setup::new(model).start(0.0).with_context(|| format!("{name} does not start with its defaults"))?;
    drop(started);
    let problems = model.experiment.problems(model.table());
    ensure!(problems.is_empty(), "{name}: {}", problems.join("; "));
    ensure_structure(name, &Setup::new(model))?;
    ensure_promises(&Setup::new(model))?;
    for (choice, item) in own_items(model) {
        let chosen = Setup::new(model).set(&choice.name, item)?;
        // An item may need other parameters than the defaults; it is refused where it is chosen.
        if chosen.start(0.0).is_ok() {
            ensure_structure(&format!("{name} with {} = {item}", choice.name), &chosen)?;
            ensure_promises(&chosen)?;
        }
    }
    Ok(())
}

/// Refuses variables with undeclared dependences.
fn ensure_structure(name: &str, setup: &Setup) -> Result<()> {
    let missing = undeclared_dependencies(setup).with_context(|| name.to_owned())?;
    ensure!(
        missing.is_empty(),
        "{name}: `depends_on` or `couples_states` does not declare that these depend on each other: {}",
        missing.join(", ")
    );
    Ok(())
}

/// Refuses a model whose rates are not the derivatives of its states, whose runs depend on the communication steps, or do not
/// repeat after they have been restored, with the message of the check.
fn ensure_promises(setup: &Setup) -> Result<()> {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let outcome = panic::catch_unwind(AssertUnwindSafe(|| conformance::plain_runs(setup)));
    panic::set_hook(hook);
    outcome.map_err(|cause| {
        let message = cause.downcast_ref::<String>().map_or("a check of its runs fails", String::as_str);
        anyhow!("{message} (`pneumatic_servo::conformance::run` checks this, and more, in a test)")
    })
}

/// The items of choices that no model of the library has, such as friction laws of the user.
fn own_items(model: &'static Model) -> impl Iterator<Item = (&'static Variable, &'static str)> {
    let choices = |model: &'static Model| {
        model.table().parameters().filter_map(|variable| match variable.kind {
            Kind::Enumeration(of) => Some((variable, of)),
            _ => None,
        })
    };
    let items = choices(model).flat_map(|(variable, of)| of.items.iter().map(move |item| (variable, of.name, item)));
    let is_known = move |of: &str, item| {
        models::ALL.iter().flat_map(choices).any(|(_, other)| other.name == of && other.items.contains(item))
    };
    items.filter(move |(_, of, item)| !is_known(of, item)).map(|(variable, _, (_, item, _))| (variable, *item))
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::sync::atomic::{AtomicU32, Ordering};

    use cargo_metadata::{DependencyKind, MetadataCommand, Target, TargetKind};
    use pneumatic_servo::model::{Experiment, Functions};
    use pneumatic_servo::models::{friction_bench, position_controller};
    use pneumatic_servo::prelude::*;
    use pneumatic_servo::variables::ParameterError;

    use super::*;

    /// Named with what is wrong, before anything is built.
    #[test]
    fn models_that_do_not_start_or_show_nothing_are_refused() {
        static SOUND: Model = position_controller::MODEL;
        static SILENT: Model = Model { description: "", ..SOUND };
        static UNFIT: Model = Model {
            functions: Functions {
                start: |_| Err(ParameterError::new("lag", 1.0, "it must fit the gap")),
                ..SOUND.functions
            },
            ..SOUND
        };
        static BLIND: Model = Model { experiment: Experiment { panels: &[], ..SOUND.experiment }, ..SOUND };
        assert!(ensure_sound(&SOUND).is_ok());
        for (model, expected) in [
            (&SILENT, "PositionController has no description"),
            (&UNFIT, "lag = 1 is refused: it must fit the gap"),
            (&BLIND, "shows nothing"),
        ] {
            let problem = ensure_sound(model).map_or_else(|problem| format!("{problem:#}"), |()| String::new());
            assert!(problem.contains(expected), "{problem}");
        }
    }

    parameters! {
        /// Two elements in a row, whose law keeps quiet about it.
        Coupled {
            stiffness: Tunable = Variable::parameter(0, "k", units::NEWTON_PER_METRE, 1e4).text("Stiffness");
        }
    }

    impl FrictionLaw for Coupled {
        type Memory<S: Varying> = ();

        fn states(&self) -> usize {
            2
        }

        fn state_kind(&self) -> StateKind {
            StateKind::Force
        }

        fn start<S: Varying>(&self, _contact: &Contact<S>) {}

        fn force<S: Scalar>(&self, contact: &Contact<S>, f: &[S], _memory: &(), rates: &mut [S]) -> S {
            rates[0] = contact.velocity * self.stiffness - f[0];
            rates[1] = f[0] - f[1];
            f[1]
        }
    }

    laws! {
        /// The laws of the library, and one more.
        mod catalogue {
            ..builtin;
            1000 Coupled "coupled" Coupled, "Two elements in a row";
        }
    }

    /// Under a law that is not the default, too, before anything is built.
    #[test]
    fn laws_that_depend_on_more_than_the_table_says_are_refused() {
        static BENCH: Model = friction_bench::model::<catalogue::Friction>();
        let items: Vec<_> = own_items(&BENCH).map(|(variable, item)| (variable.name.as_str(), item)).collect();
        assert_eq!(items, [("friction.law", "Coupled")]);
        let problem = ensure_sound(&BENCH).map_or_else(|problem| format!("{problem:#}"), |()| String::new());
        let expected = "FrictionBench with friction.law = Coupled";
        let pair = "der(friction.elementForce[2]) on friction.elementForce[1]";
        assert!(problem.contains(expected) && problem.contains(pair), "{problem}");
    }

    static RUNS: AtomicU32 = AtomicU32::new(0);

    parameters! {
        /// A law that depends on what is no parameter: how many runs there were.
        Counting {
            damping: Tunable = Variable::parameter(0, "sigma2", units::NEWTON_SECOND_PER_METRE, 10.0).text("Viscous damping");
        }
    }

    impl FrictionLaw for Counting {
        type Memory<S: Varying> = ();

        fn start<S: Varying>(&self, _contact: &Contact<S>) {
            RUNS.fetch_add(1, Ordering::Relaxed);
        }

        fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], _memory: &(), _rates: &mut [S]) -> S {
            contact.velocity * (self.damping * f64::from(RUNS.load(Ordering::Relaxed)))
        }
    }

    laws! {
        /// The laws of the library, and one that repeats nothing.
        mod counting {
            ..builtin;
            1000 Counting "counting" Counting, "Counts its runs";
        }
    }

    #[test]
    fn laws_whose_runs_do_not_repeat_are_refused() {
        static BENCH: Model = friction_bench::model::<counting::Friction>();
        let problem = ensure_sound(&BENCH).map_or_else(|problem| format!("{problem:#}"), |()| String::new());
        assert!(problem.contains("FrictionBench under Counting") && problem.contains("conformance::run"), "{problem}");
    }

    /// Downloaded packages of a lock file: names with versions.
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
        // Otherwise shared dependencies are compiled twice.
        let others: Vec<_> = theirs.difference(&ours).collect();
        assert!(others.is_empty(), "copy Cargo.lock to examples/own: {others:?}");
        Ok(())
    }

    /// A shared library has no hash in its file's name: a crate from outside, compiled into the same folder, would
    /// overwrite a library of this program.
    #[test]
    fn nothing_that_cargo_xtask_is_made_of_is_a_shared_library() -> Result<()> {
        let metadata = MetadataCommand::new().no_deps().current_dir(workspace::home()).exec()?;
        let ours = |name: &str| metadata.packages.iter().find(|it| it.name.as_str() == name);
        let mut names = ["xtask", "xtask-developer"].map(str::to_owned).to_vec();
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
