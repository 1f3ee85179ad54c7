//! A machine that tests make up: it is told which programs are to be started, notes them, and answers in their place.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
#[cfg(unix)]
use std::os::unix::process::ExitStatusExt;
#[cfg(windows)]
use std::os::windows::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Output};
use std::sync::{Arc, Mutex, PoisonError};

use serde_json::json;

use crate::files;

/// A command that was to be started.
#[derive(Clone, Debug)]
pub struct Started {
    /// The program with its folder, as it was named.
    pub path: PathBuf,
    /// What it is told.
    pub arguments: Vec<String>,
    /// Where it runs, unless here.
    pub folder: Option<PathBuf>,
    /// The variables that are set for it.
    pub variables: BTreeMap<String, String>,
}

impl Started {
    fn of(command: &Command) -> Self {
        let text = |it: &OsStr| it.to_string_lossy().into_owned();
        let set = |(name, value): (&OsStr, Option<&OsStr>)| Some((text(name), text(value?)));
        Self {
            path: command.get_program().into(),
            arguments: command.get_args().map(text).collect(),
            folder: command.get_current_dir().map(Path::to_owned),
            variables: command.get_envs().filter_map(set).collect(),
        }
    }

    /// The program without its folder, and its arguments.
    pub fn line(&self) -> String {
        let program = self.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        std::iter::once(program).chain(self.arguments.iter().cloned()).collect::<Vec<_>>().join(" ")
    }

    /// Whether these words stand in its line.
    pub fn says(&self, words: &str) -> bool {
        format!(" {} ", self.line()).contains(&format!(" {words} "))
    }

    /// What follows an argument.
    pub fn after(&self, argument: &str) -> &str {
        let place = self.arguments.iter().position(|it| it == argument);
        let next = place.and_then(|place| self.arguments.get(place + 1));
        next.unwrap_or_else(|| panic!("nothing follows {argument} in {self:?}"))
    }

    /// The value of a variable, empty where it is not set.
    pub fn variable(&self, name: &str) -> &str {
        self.variables.get(name).map_or("", String::as_str)
    }
}

/// What becomes of a command.
pub enum Answer {
    /// It ends well and prints this.
    Prints(String),
    /// It ends with an error.
    Fails,
    /// It is started indeed, which is for what every machine with Cargo has.
    Starts,
}

/// It ends well and prints nothing.
pub const DONE: Answer = Answer::Prints(String::new());

/// It ends well once it has written a file.
pub fn writes(file: impl AsRef<Path>, contents: impl AsRef<[u8]>) -> Answer {
    files::write(file.as_ref(), contents).expect("a file of a test");
    DONE
}

/// The wheel `a.whl`, where one is to be built.
pub fn wheel(command: &Started) -> Option<Answer> {
    command.says("maturin build").then(|| writes(Path::new(command.after("--out")).join("a.whl"), ""))
}

/// What Cargo reports of a library that it is to build, which is in a file.
pub fn built(command: &Started, library: &Path) -> Answer {
    let name = command.after("--package").replace('-', "_");
    let target = json!({"name": name, "kind": ["cdylib"], "crate_types": ["cdylib"], "src_path": "/lib.rs"});
    let profile = json!({"opt_level": "3", "debug_assertions": false, "overflow_checks": false, "test": false});
    let report = json!({
        "reason": "compiler-artifact", "package_id": name, "target": target, "profile": profile, "features": [],
        "filenames": [library], "executable": null, "fresh": true,
    });
    Answer::Prints(report.to_string())
}

/// What a test answers, if it does.
type AnswerTo = dyn Fn(&Started) -> Option<Answer> + Send + Sync;

/// The machine.
pub struct StandIn {
    answer: Box<AnswerTo>,
    lacking: Vec<&'static str>,
    sysroot: Option<PathBuf>,
    variables: BTreeMap<&'static str, OsString>,
    started: Mutex<Vec<Started>>,
}

thread_local! {
    static PRESENT: RefCell<Option<Arc<StandIn>>> = const { RefCell::new(None) };
}

impl StandIn {
    /// A machine that has all programs, and no variables. What there is no answer for ends well and prints nothing, but
    /// for questions about the sources and the toolchain, which are asked indeed.
    pub fn new(answer: impl Fn(&Started) -> Option<Answer> + Send + Sync + 'static) -> Self {
        let (lacking, sysroot, variables, started) = Default::default();
        Self { answer: Box::new(answer), lacking, sysroot, variables, started }
    }

    /// Without a program.
    pub fn lacking(mut self, program: &'static str) -> Self {
        self.lacking.push(program);
        self
    }

    /// With a toolchain in a folder of a test, which has standard libraries for some targets.
    pub fn compiling_for(mut self, sysroot: &Path, targets: &[&str]) -> Self {
        for target in targets {
            let library = sysroot.join("lib/rustlib").join(target).join("lib");
            std::fs::create_dir_all(library).expect("a folder of a test");
        }
        self.sysroot = Some(sysroot.to_owned());
        self
    }

    /// With a variable.
    pub fn with(mut self, variable: &'static str, value: impl Into<OsString>) -> Self {
        self.variables.insert(variable, value.into());
        self
    }

    fn answer(&self, command: &Started) -> Option<Answer> {
        if self.lacking.iter().any(|program| command.path == Path::new(program)) {
            return Some(Answer::Fails);
        }
        let sysroot = self.sysroot.as_ref().map(|folder| folder.display().to_string());
        match (&*command.line(), sysroot) {
            ("rustc --print sysroot", Some(folder)) => Some(Answer::Prints(folder)),
            ("rustc --version --verbose", Some(_)) => Some(Answer::Prints("commit-hash: c0ffee\n".to_owned())),
            _ => (self.answer)(command),
        }
    }

    /// Does something on this machine, in a thread that knows of no failure before, and tells which commands were to be
    /// started, without the questions.
    pub fn does<T: Send>(self, work: impl FnOnce() -> T + Send) -> (T, Vec<Started>) {
        let machine = Arc::new(self);
        let done = std::thread::scope(|scope| {
            let machine = Some(Arc::clone(&machine));
            let thread = scope.spawn(|| {
                put(machine);
                work()
            });
            thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        let started = machine.started.lock().unwrap_or_else(PoisonError::into_inner).clone();
        (done, started)
    }
}

/// The machine that is put in the place of the real one, in this thread.
pub fn present() -> Option<Arc<StandIn>> {
    PRESENT.with_borrow(Clone::clone)
}

/// Puts a machine in the place of the real one, in this thread.
pub fn put(machine: Option<Arc<StandIn>>) {
    PRESENT.set(machine);
}

/// What a command comes to, unless it is to be started. What it prints is both its output and its messages.
pub fn answer(command: &Command) -> Option<Output> {
    let machine = present()?;
    let started = Started::of(command);
    let is_question =
        ["cargo metadata", "cargo -vV", "rustc --", "git log"].iter().any(|it| started.line().starts_with(it));
    let answer = machine.answer(&started);
    if !is_question {
        machine.started.lock().unwrap_or_else(PoisonError::into_inner).push(started);
    }
    let (status, printed) = match answer.unwrap_or(if is_question { Answer::Starts } else { DONE }) {
        Answer::Prints(text) => (0, text.into_bytes()),
        // An error, whether the lowest byte is a signal or belongs to the code.
        Answer::Fails => (256, Vec::new()),
        Answer::Starts => return None,
    };
    Some(Output { status: ExitStatus::from_raw(status), stdout: printed.clone(), stderr: printed })
}

/// Where programs of a name are, in two folders of the search path, unless the real machine is asked.
pub fn find_all(program: &str) -> Option<Vec<PathBuf>> {
    let is_lacking = present()?.lacking.contains(&program);
    let folders: &[&str] = if is_lacking { &[] } else { &["/machine/first", "/machine/second"] };
    Some(folders.iter().map(|folder| Path::new(folder).join(program)).collect())
}

/// The value of a variable, unless the real machine is asked.
pub fn variable(name: &str) -> Option<Option<OsString>> {
    present().map(|machine| machine.variables.get(name).cloned())
}

/// What Cargo tells of a workspace at a root with packages, each with a name, a version and a folder below the root.
pub fn metadata(root: &Path, target: &Path, packages: &[(&str, &str, &str)]) -> Answer {
    let package = |(name, version, folder): &(&str, &str, &str)| {
        json!({
            "name": name, "version": version, "id": format!("{name} {version}"), "source": null, "dependencies": [],
            "features": {}, "manifest_path": root.join(folder).join("Cargo.toml"),
            "targets": [{"name": name, "kind": ["bin"], "crate_types": ["bin"], "src_path": root.join(folder).join("main.rs")}],
        })
    };
    let ids: Vec<_> = packages.iter().map(|(name, version, _)| format!("{name} {version}")).collect();
    let node = |id: &String| json!({"id": id, "dependencies": [], "deps": [], "features": []});
    let nodes: Vec<_> = ids.iter().map(node).collect();
    let packages: Vec<_> = packages.iter().map(package).collect();
    let told = json!({
        "packages": packages, "workspace_members": ids, "resolve": {"nodes": nodes, "root": null}, "version": 1,
        "workspace_root": root, "target_directory": target,
    });
    Answer::Prints(told.to_string())
}
