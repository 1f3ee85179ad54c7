//! `cargo xtask test --sources`: the sources in C, compiled for this machine and for others, and run there. Every result is
//! compared with the library in Rust, bit for bit.

mod compiled;
mod needs;
mod suite;
mod target;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Model;
use pneumatic_servo::models::{self, pneumatic_servo_cylinder::MODEL};
use pneumatic_servo_fmu::guid;

use self::compiled::Written;
use self::target::Target;
use crate::build::{self, wasm};
use crate::files;
use crate::library::Library;
use crate::package;
use crate::platform_test::{Machine, experiments_of, same};
use crate::process::{self, heading};
use crate::sources;
use crate::tools::{self, Tool};
use crate::valgrind;
use crate::venv::{Requirements, Venv};
use crate::workspace::Workspace;

/// Compiles and runs the sources of all models, and those of the cylinder for all targets, or only those of some models or for
/// some targets; a missing tool is an error.
///
/// # Errors
/// When a tool is missing, a step fails or a bit differs, or nothing is called as is asked for.
pub fn run(workspace: &Workspace, only: &[String]) -> Result<()> {
    let names = models::ALL.iter().map(|model| model.name).chain(Target::ALL.map(|target| target.compiler().folder));
    ensure_known(only, "no model and no target", names.collect())?;
    let models: Vec<_> = models::ALL.iter().filter(|model| is_wanted(only, model.name)).collect();
    let targets: Vec<_> = Target::ALL.into_iter().filter(|target| is_wanted(only, target.compiler().folder)).collect();
    tools::require(missing(&targets)?)?;
    let rust = build::for_this_machine(workspace)?;
    let mut cylinder = None;
    for model in models {
        let Made { written, plant, library } = on_this_machine(workspace, model, &rust)?;
        heading(&format!("Sources in C of {}: the tests of the C interface", model.name));
        suite::run(workspace, model, &library)?;
        heading(&format!("Sources in C of {}: FMUs that FMPy compiles", model.name));
        by_fmpy(workspace, model, &written.module)?;
        if model.name == MODEL.name {
            heading("Sources in C: instructions of a step");
            println!("law, instructions of a step in Rust, from C, ratio");
            println!("{}", speed(workspace, &written, &rust, &library)?.join("\n"));
            cylinder = Some((written, plant));
        }
    }
    if targets.is_empty() {
        return Ok(());
    }
    let (written, plant) = match cylinder {
        Some(made) => made,
        None => {
            let written = Written::of(workspace, &MODEL)?;
            let plant = written.plant(&Target::Linux.compiler())?;
            (written, plant)
        }
    };
    on_targets(workspace, &targets, &written, &plant, &rust)
}

/// The sources of the cylinder on this machine; where a tool is missing, that is an error under CI and otherwise said.
///
/// # Errors
/// When a tool is missing under CI, a step fails or a bit differs.
pub fn run_if_possible(workspace: &Workspace) -> Result<()> {
    match tools::require(missing(&[Target::Linux])?) {
        Ok(()) => on_this_machine(workspace, &MODEL, &build::for_this_machine(workspace)?).map(|_| ()),
        Err(problem) => process::leave_out("Sources in C", &format!("{problem:#}")),
    }
}

/// Random calls of the sources of all models, or of some, for so long at least, each time other ones.
///
/// # Errors
/// When a tool is missing, a step fails or a call does not do what the model does, or there is no such model.
pub fn fuzz(workspace: &Workspace, length: Duration, only: &[String]) -> Result<()> {
    ensure_known(only, "no model", models::ALL.iter().map(|model| model.name).collect())?;
    tools::require(missing(&[Target::Linux])?)?;
    let rust = build::for_this_machine(workspace)?;
    let mut libraries = Vec::new();
    for model in models::ALL.iter().filter(|model| is_wanted(only, model.name)) {
        libraries.push((model, on_this_machine(workspace, model, &rust)?.library));
    }
    heading("Sources in C: random calls");
    let begin = Instant::now();
    let mut rounds = 0;
    while !length.saturating_sub(begin.elapsed()).is_zero() {
        for (model, library) in &libraries {
            suite::fuzz(workspace, model, library, rounds)?;
        }
        rounds += 1;
    }
    let (models, seconds) = (libraries.len(), begin.elapsed().as_secs_f64());
    println!("{rounds} rounds with {models} of {} models in {seconds:.0} s, and nothing was found", models::ALL.len());
    Ok(())
}

/// Refuses a name that none of some has.
fn ensure_known(only: &[String], what: &str, names: Vec<&str>) -> Result<()> {
    match only.iter().find(|name| !names.contains(&name.as_str())) {
        Some(unknown) => bail!("`{unknown}` is {what}; there are {}", names.join(", ")),
        None => Ok(()),
    }
}

/// Whether a name is among those that are wanted, which all are where none is named.
fn is_wanted(only: &[String], name: &str) -> bool {
    only.is_empty() || only.iter().any(|only| only == name)
}

fn missing(targets: &[Target]) -> Result<Vec<(&'static str, Vec<Tool>)>> {
    let mut missing = vec![("the sources in C", wasm::missing()?), ("running them", Machine::Linux.missing())];
    missing.extend(targets.iter().map(|target| (target.name(), target.missing())));
    Ok(missing)
}

/// The sources of a model, compiled for this machine.
struct Made {
    written: Written,
    /// The objects without the functions of FMI.
    plant: Vec<PathBuf>,
    library: PathBuf,
}

/// Compiles the sources of a model, and runs their library.
fn on_this_machine(workspace: &Workspace, model: &'static Model, rust: &[u8]) -> Result<Made> {
    heading(&format!("Sources in C of {}: make and compile them", model.name));
    let written = Written::of(workspace, model)?;
    let compiler = Target::Linux.compiler();
    let plant = written.plant(&compiler)?;
    let library = written.library(&compiler, &[plant.clone(), written.faces(&compiler)?].concat())?;
    heading(&format!("Sources in C of {}: run every law through FMI", model.name));
    let experiments = experiments_of(model);
    let expected = Machine::Linux.run(workspace, rust, &experiments)?;
    same("the library from C", &expected, &Machine::Linux.run(workspace, &files::read(&library)?, &experiments)?)?;
    Ok(Made { written, plant, library })
}

/// The cylinder on this machine and on targets: a control loop and all laws on each, and FMI where a machine can load libraries.
fn on_targets(
    workspace: &Workspace,
    targets: &[Target],
    written: &Written,
    plant: &[PathBuf],
    rust: &[u8],
) -> Result<()> {
    heading(&format!("Sources in C: {}", Target::Linux.name()));
    let expected = Target::Linux.run(workspace, written, plant)?;
    print!("{}", expected.bits);
    let experiments = experiments_of(&MODEL);
    let reference = Machine::Linux.run(workspace, rust, &experiments)?;
    let mut needs = Ok(());
    for target in targets.iter().filter(|target| **target != Target::Linux) {
        heading(&format!("Sources in C: {}", target.name()));
        let compiler = target.compiler();
        let plant = written.plant(&compiler)?;
        let found = target.run(workspace, written, &plant)?;
        let (bits, others) = (found.bits, &expected.bits);
        ensure!(bits == *others, "{} computes other bits:\n{bits}instead of\n{others}", target.name());
        println!("{}: the same bits", target.name());
        if target.has_no_system() {
            // All rows are told before the first that the page does not have ends this.
            needs = needs.and(found.needs.compare(workspace, target.name(), &compiler));
        }
        if let Some(machine) = target.machine() {
            let library = written.library(&compiler, &[plant, written.faces(&compiler)?].concat())?;
            same(target.name(), &reference, &machine.run(workspace, &files::read(&library)?, &experiments)?)?;
        }
    }
    needs
}

/// FMPy compiles FMUs of both versions as it compiles those of others, and runs them beside the library in Rust.
fn by_fmpy(workspace: &Workspace, model: &'static Model, module: &[u8]) -> Result<()> {
    let library = Library::for_this_machine(workspace)?;
    let venv = Venv::prepare(workspace, Requirements::TESTS)?;
    let folder = workspace.target.join("sources-test/fmpy");
    let sources = |version| Ok(Some(sources::of(workspace, model, &[version], module)?));
    let fmus = package::write(workspace, model, &[library], sources, &folder)?;
    let stated = folder.join("experiments.json");
    files::write(&stated, crate::describe::experiments(workspace.product.models)?)?;
    let mut python = venv.command();
    python.arg(workspace.python().join("compiled.py")).args(fmus).arg("--experiments").arg(stated);
    process::run(python.env("PATH", venv.path()?))
}

/// How many instructions a step takes in the library in Rust and in that from C, as valgrind counts them, and their ratio: a
/// row for each law.
fn speed(workspace: &Workspace, written: &Written, rust: &[u8], library: &Path) -> Result<Vec<String>> {
    /// The difference between a long and a short run, so that the start does not count.
    const STEPS: [u64; 2] = [50, 350];
    let compiler = Target::Linux.compiler();
    let files = [workspace.root.join("tests/sources/speed.c"), "-ldl".into()];
    let program = written.program(&compiler, "speed", &files, &[])?;
    let native = written.folder.join("native.so");
    std::fs::write(&native, rust).context("cannot write the library in Rust")?;
    let measure = |library: &Path, law: usize| {
        let of = |steps: u64| {
            let mut command = Command::new(&program);
            valgrind::instructions(command.arg(library).arg(guid(&MODEL)).args([law.to_string(), steps.to_string()]))
        };
        Ok::<u64, anyhow::Error>((of(STEPS[1])? - of(STEPS[0])?) / (STEPS[1] - STEPS[0]))
    };
    let row = |(law, item): (usize, &(i32, &str, &str))| {
        let (native, compiled) = (measure(&native, law)?, measure(library, law)?);
        Ok(format!("{:>16} {native:>8} {compiled:>8} {:>6.2}", item.1, compiled as f64 / native as f64))
    };
    (1..).zip(LAWS.items).map(row).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::gates::made;
    use crate::stand_in::{self, Answer, DONE, StandIn, Started};

    fn only(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    /// What valgrind counts for so many steps of a library: 3,000 in Rust, and half as many again from C.
    fn instructions(library: &str, steps: u64) -> u64 {
        7_000 + steps * if library.ends_with("native.so") { 3_000 } else { 4_500 }
    }

    /// A machine whose compilers make files, and whose programs print the same wherever they run; what is answered first is
    /// what a test changes.
    fn laboratory(
        folder: &Path,
        first: impl Fn(&Started) -> Option<Answer> + Send + Sync + 'static,
    ) -> (Workspace, StandIn) {
        let (module, library) = (folder.join("module.wasm"), folder.join("built.so"));
        stand_in::writes(&module, sources::made_module());
        stand_in::writes(&library, made::linux());
        let machine = StandIn::new(move |command| {
            let line = command.line();
            let printed = |text: &str| Some(Answer::Prints(text.to_owned()));
            match first(command) {
                Some(answer) => Some(answer),
                None if command.says("--package pneumatic-servo-sources") => Some(stand_in::built(command, &module)),
                None if command.says("rustc --release") => Some(stand_in::built(command, &library)),
                None if line.starts_with("valgrind ") => {
                    let [library, _, _, steps] = &command.arguments[command.arguments.len() - 4..] else { return None };
                    printed(&format!("Collected : {}\n", instructions(library, steps.parse().ok()?)))
                }
                None if command.says("--totals") => printed("text data bss\n1000 20 300 1320 x\n"),
                None if command.says("-dumpversion") => printed("1.2.3\n"),
                None if command.says("-o") => {
                    let file = command.folder.clone().unwrap_or_default().join(command.after("-o"));
                    Some(stand_in::writes(file, "made"))
                }
                None if line.contains("import fmpy") => printed("/packages/fmpy\n"),
                None if line.contains("laws.exe") => printed(&"law by its name\r\n".repeat(LAWS.items.len())),
                None if line.contains("memory.exe") => printed("bits\nmeasured stack 4412\n"),
                None if command.says("./library.so") || command.says("./library.dll") => printed("run a\n1 2\ndone\n"),
                None => None,
            }
        });
        let workspace = Workspace::of_a_test(&folder.join("target"));
        (workspace, machine.compiling_for(&folder.join("sysroot"), &["wasm32-unknown-unknown"]))
    }

    /// Names that there are not, and tools that are missing for what is wanted.
    #[test]
    fn what_cannot_be_done_is_refused_before_anything_is_compiled() -> Result<()> {
        let folder = files::scratch("sources-refused");
        let (workspace, _) = laboratory(&folder, |_| None);
        let refused = |lacking, work: &(dyn Fn() -> Result<()> + Sync)| {
            let (outcome, started) = laboratory(&folder, |_| None).1.lacking(lacking).does(work);
            assert!(started.is_empty(), "{started:?}");
            outcome.map_or_else(|problem| problem.to_string(), |()| String::new())
        };
        assert!(
            refused("", &|| run(&workspace, &only(&["Bed"])))
                .starts_with("`Bed` is no model and no target; there are ")
        );
        assert!(
            refused("", &|| fuzz(&workspace, Duration::MAX, &only(&["linux"]))).starts_with("`linux` is no model;")
        );
        let missing = refused("arm-none-eabi-gcc", &|| run(&workspace, &only(&["cortex-m7"])));
        assert!(missing.contains("for Cortex-M7: arm-none-eabi-gcc"), "{missing}");
        assert!(refused("wasm-ld", &|| run(&workspace, &only(&["Festoon"]))).contains("for the sources in C: "));
        assert!(refused("gcc", &|| run(&workspace, &only(&["Festoon"]))).contains("for running them: gcc"));
        assert!(refused("gcc", &|| fuzz(&workspace, Duration::MAX, &[])).contains("for running them: gcc"));
        assert_eq!(refused("gcc", &|| run_if_possible(&workspace)), "", "it is left out");
        let (outcome, _) =
            laboratory(&folder, |_| None).1.lacking("gcc").with("CI", "1").does(|| run_if_possible(&workspace));
        assert!(outcome.is_err_and(|problem| problem.to_string().contains("for running them: gcc")));
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// A model without states beside the cylinder: its sources are compiled, run, tested through C and compiled by FMPy; only
    /// the sources of the cylinder are measured, and run on targets.
    #[test]
    fn sources_of_a_model_are_compiled_run_and_tested() -> Result<()> {
        let folder = files::scratch("sources-model");
        let (workspace, machine) = laboratory(&folder, |_| None);
        let (outcome, started) = machine.does(|| run(&workspace, &only(&["PositionController"])));
        outcome?;
        let place = |words: &str| {
            let found = started.iter().position(|it| it.line().contains(words));
            found.with_context(|| format!("{words} is not among {started:#?}"))
        };
        let order = [
            "pneumatic-servo-sources",
            "plant.o",
            "-shared",
            "host",
            "--test c_interface",
            "--test fuzz",
            "compiled.py",
        ];
        let places = order.iter().map(|words| place(words)).collect::<Result<Vec<_>>>()?;
        assert!(places.is_sorted(), "{places:?}");
        let fmpy = &started[place("compiled.py")?];
        for version in ["", "fmi3/"] {
            let fmu = workspace.target.join(format!("sources-test/fmpy/{version}PositionController.fmu"));
            assert!(fmu.is_file() && fmpy.says(&fmu.display().to_string()), "{fmpy:?}");
            let archive = zip::ZipArchive::new(std::fs::File::open(fmu)?)?;
            assert!(archive.file_names().flatten().any(|name| name == "sources/plant.c"));
        }
        assert!(files::text(fmpy.after("--experiments"))?.contains("PositionController"));
        assert!(!started.iter().any(|it| it.says("--totals") || it.line().starts_with("valgrind")), "{started:#?}");
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// The results from C are compared with those in Rust.
    #[test]
    fn bits_that_differ_are_an_error() -> Result<()> {
        let folder = files::scratch("sources-differ");
        let library = folder.join("target/platform-test/Linux/library.so");
        let (workspace, machine) = laboratory(&folder, move |command| {
            let is_from_c = command.says("./library.so") && std::fs::read(&library).is_ok_and(|bytes| bytes == b"made");
            is_from_c.then(|| Answer::Prints("run a\n1 3\ndone\n".to_owned()))
        });
        let problem = machine.does(|| run_if_possible(&workspace)).0.map_err(|error| error.to_string());
        assert!(problem.is_err_and(|text| text.starts_with("the library from C departs from linux64 in a")));
        let (workspace, machine) = laboratory(&folder, |command| {
            command.line().starts_with("qemu-arm ").then(|| Answer::Prints("law by its name\n".to_owned()))
        });
        let problem = machine.does(|| run(&workspace, &only(&["arm32"]))).0.map_err(|error| error.to_string());
        assert!(problem.is_err_and(|text| text.starts_with("Linux on 32-bit Arm under QEMU ran 4 laws")));
        let (workspace, machine) = laboratory(&folder, |command| {
            command.line().contains("s390x/loop.exe").then(|| Answer::Prints("other bits\n".to_owned()))
        });
        let problem = machine.does(|| run(&workspace, &only(&["s390x"]))).0.map_err(|error| error.to_string());
        assert!(problem.is_err_and(|text| text.contains("computes other bits:") && text.contains("\nother bits\n")));
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// The cylinder is the reference of all targets: its sources are compiled anew for each, and a library of them is run where
    /// a machine can load it. What a microcontroller needs is measured.
    #[test]
    fn cylinder_is_run_on_the_targets_that_are_named() -> Result<()> {
        let folder = files::scratch("sources-targets");
        let (workspace, machine) = laboratory(&folder, |_| None);
        let names = ["linux", "arm64", "clang", "cortex-m4"];
        let (outcome, started) = machine.does(|| run(&workspace, &only(&names)));
        outcome?;
        let full = |it: &Started| format!("{} {}", it.path.display(), it.line());
        let count = |words: &str| started.iter().filter(|it| full(it).contains(words)).count();
        for folder in names {
            // Compiled, and run.
            assert_eq!(count(&format!("/{folder}/laws.exe")), 2, "{folder}");
        }
        assert_eq!((count("arm64/library.so"), count("clang/library.so"), count("cortex-m4/library.so")), (1, 0, 0));
        assert!(
            started
                .iter()
                .any(|it| it.line().starts_with("qemu-aarch64 -L /usr/aarch64-linux-gnu ") && it.says("./library.so"))
        );
        assert_eq!(count("arm-none-eabi-gcc -dumpversion"), 1);
        assert_eq!(count("-dumpversion"), 1);
        assert_eq!(count("--test c_interface"), 0, "no model is named");
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// With its own tests: states go from the library in Rust into that from C, and back; instructions are counted.
    #[test]
    fn cylinder_meets_all_tests_and_is_measured() -> Result<()> {
        let folder = files::scratch("sources-cylinder");
        let (workspace, machine) = laboratory(&folder, |_| None);
        let (outcome, started) = machine.does(|| run(&workspace, &only(&[MODEL.name])));
        outcome?;
        let libraries = |it: &Started| ["FMU_LIBRARY", "FMU_LIBRARY_OF_CHILD"].map(|name| it.variable(name).to_owned());
        let handed: Vec<_> = started.iter().filter(|it| it.says("in_another_process")).map(libraries).collect();
        let [[library, native], [from, to]] = &handed[..] else { panic!("{handed:?}") };
        assert!(library.ends_with("/library.so") && native.ends_with("/native.so"), "{handed:?}");
        assert_eq!((from, to), (native, library));
        let counted = started.iter().filter(|it| it.line().starts_with("valgrind ")).count();
        assert_eq!(counted, 4 * LAWS.items.len());
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn instructions_of_a_step_are_told_without_those_of_the_start() -> Result<()> {
        let folder = files::scratch("sources-speed");
        let (workspace, machine) = laboratory(&folder, |_| None);
        let (rows, _) = machine.does(|| {
            let written = Written::of(&workspace, &MODEL)?;
            std::fs::create_dir_all(written.folder.join("linux"))?;
            speed(&workspace, &written, b"library", &written.folder.join("linux/library.so"))
        });
        let rows = rows?;
        assert_eq!(rows.len(), LAWS.items.len());
        assert!(rows.iter().all(|row| row.ends_with("    3000     4500   1.50")), "{rows:?}");
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// Other calls in each round, until the time is over; a call that fails ends it.
    #[test]
    fn random_calls_go_on_for_their_time() -> Result<()> {
        let folder = files::scratch("sources-fuzz");
        let length = Duration::from_millis(300);
        let (workspace, machine) = laboratory(&folder, move |command| {
            command.says("--test fuzz").then(|| {
                std::thread::sleep(length / 15);
                DONE
            })
        });
        let names = only(&["PositionController"]);
        let (outcome, started) = machine.does(|| fuzz(&workspace, length, &names));
        outcome?;
        let rounds = started.iter().filter(|it| it.says("--test fuzz"));
        let seeds: Vec<_> = rounds.map(|it| it.variable("SERVO_FUZZ_SEED").to_owned()).collect();
        let expected: Vec<_> = (0..seeds.len()).map(|round| (1 + 1000 * round).to_string()).collect();
        assert!(seeds == expected && (2..=15).contains(&seeds.len()), "{seeds:?}");
        let (workspace, machine) = laboratory(&folder, |command| command.says("--test fuzz").then_some(Answer::Fails));
        assert!(machine.does(|| fuzz(&workspace, length, &names)).0.is_err());
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn a_name_that_there_is_not_is_refused_with_those_that_there_are() {
        let refusal = ensure_known(&only(&["Bench", "Bed"]), "no model", vec!["Bench"]);
        assert!(refusal.is_err_and(|error| error.to_string() == "`Bed` is no model; there are Bench"));
        assert!(ensure_known(&only(&[]), "no model", vec!["Bench"]).is_ok());
        assert!(is_wanted(&only(&["Bench"]), "Bench") && !is_wanted(&only(&["Bench"]), "Bed") && is_wanted(&[], "Bed"));
    }
}
