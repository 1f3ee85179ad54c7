//! The sources of a model in a folder, and their compilation.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use pneumatic_servo_packaging::description::Version;
use pneumatic_servo_packaging::process;
use pneumatic_servo_packaging::sources::{self, Size};
use pneumatic_servo_packaging::venv::{Requirements, Venv};
use pneumatic_servo_packaging::workspace::Workspace;

/// The sources of both faces of a model.
pub struct Written {
    /// Where they are.
    pub folder: PathBuf,
    /// The module that they are made of.
    pub module: Vec<u8>,
    /// The files that an importer compiles.
    compiled: Vec<PathBuf>,
    /// The headers of the standard, as FMPy has them.
    headers: PathBuf,
}

impl Written {
    /// Builds the module of a model and writes its sources into a folder of their own.
    ///
    /// # Errors
    /// When a tool fails or a file cannot be written.
    pub fn of(workspace: &Workspace, model: &'static Model) -> Result<Self> {
        let folder = workspace.target.join("sources-test").join(model.name);
        // In a folder of its own it does not wait for other libraries.
        let module = sources::module(&workspace.inside("sources-test"), model, Size::Small)?;
        let sources = sources::sources(workspace, model, &Version::ALL, &module)?;
        if folder.exists() {
            std::fs::remove_dir_all(&folder).with_context(|| format!("cannot remove the old {}", folder.display()))?;
        }
        std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        for (name, text) in &sources.files {
            std::fs::write(folder.join(name), text).with_context(|| format!("cannot write {name}"))?;
        }
        let size: usize = sources.files.values().map(String::len).sum();
        println!("{}: {} KB of C", folder.display(), size / 1000);
        let compiled = sources.compiled.iter().map(|name| folder.join(name)).collect();
        let headers = Venv::prepare(workspace, Requirements::PACKAGE)?.module("fmpy")?.join("c-code");
        Ok(Self { folder, module, compiled, headers })
    }

    /// The sources of a control loop alone, which are in a folder.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub fn of_loop(folder: PathBuf) -> Result<Self> {
        let mut compiled = Vec::new();
        for entry in std::fs::read_dir(&folder).with_context(|| format!("cannot list {}", folder.display()))? {
            let file = entry?.path();
            let is_of_loop = file.file_name().is_some_and(|name| name == "loop.c" || name == "model.c");
            if file.extension().is_some_and(|extension| extension == "c") && !is_of_loop {
                compiled.push(file);
            }
        }
        compiled.sort();
        Ok(Self { headers: folder.clone(), folder, module: Vec::new(), compiled })
    }

    /// The objects of the plant, without the functions of FMI, and of the loop.
    ///
    /// # Errors
    /// When a file does not compile without a warning.
    pub fn plant(&self, compiler: &Compiler) -> Result<Vec<PathBuf>> {
        let plant = self.compiled.iter().filter(|file| !is_face(file)).cloned();
        let files: Vec<_> = plant.chain(["loop.c", "model.c"].map(|name| self.folder.join(name))).collect();
        self.objects(compiler, &files)
    }

    /// The objects of the functions of FMI, with their plain names, as a shared library has them.
    ///
    /// # Errors
    /// When a file does not compile without a warning.
    pub fn faces(&self, compiler: &Compiler) -> Result<Vec<PathBuf>> {
        let faces: Vec<_> = self.compiled.iter().filter(|file| is_face(file)).cloned().collect();
        self.objects(compiler, &faces)
    }

    /// A program of some files of its own and the plant.
    ///
    /// # Errors
    /// When it does not compile without a warning, or cannot be linked.
    pub fn program(&self, compiler: &Compiler, name: &str, files: &[PathBuf], objects: &[PathBuf]) -> Result<PathBuf> {
        let program = self.folder.join(compiler.folder).join(name).with_extension("exe");
        let mut command = compiler.command();
        // The program computes in the same way everywhere, too: in C99 proper nothing is contracted.
        command.arg("-std=c99").arg("-I").arg(&self.folder).arg("-I").arg(&self.headers);
        command.args(files).args(objects).args(compiler.linking).arg("-lm").arg("-o").arg(&program);
        process::run(&mut command)?;
        Ok(program)
    }

    /// A shared library of objects.
    ///
    /// # Errors
    /// When it cannot be linked or read.
    pub fn library(&self, compiler: &Compiler, objects: &[PathBuf]) -> Result<PathBuf> {
        let library = self.folder.join(compiler.folder).join("library.so");
        let mut command = compiler.command();
        process::run(command.arg("-shared").args(objects).args(compiler.linking).arg("-lm").arg("-o").arg(&library))?;
        Ok(library)
    }

    /// Two files at a time, since there are many.
    fn objects(&self, compiler: &Compiler, files: &[PathBuf]) -> Result<Vec<PathBuf>> {
        let folder = self.folder.join(compiler.folder);
        std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        let compile = |files: &[PathBuf]| {
            let objects = files.iter().map(|file| self.object(compiler, &folder, file));
            objects.collect::<Result<Vec<_>>>()
        };
        let (one, other) = files.split_at(files.len() / 2);
        let (one, other) = process::both(|| compile(one), || compile(other))?;
        Ok([one, other].concat())
    }

    fn object(&self, compiler: &Compiler, folder: &Path, file: &Path) -> Result<PathBuf> {
        let object = folder.join(file.file_name().unwrap_or_default()).with_extension("o");
        let mut command = compiler.command();
        // Contracted operations are what the sources must keep out by themselves: GNU's C has them, ISO's has not.
        command.args(["-std=gnu99", "-fvisibility=hidden"]).args(compiler.compiling).arg("-I").arg(&self.headers);
        command.args(["-DFMI2_OVERRIDE_FUNCTION_PREFIX", "-DFMI3_OVERRIDE_FUNCTION_PREFIX"]);
        process::run(command.arg("-c").arg(file).arg("-o").arg(&object))?;
        Ok(object)
    }
}

fn is_face(file: &Path) -> bool {
    file.file_name().is_some_and(|name| name == "fmi2.c" || name == "fmi3.c")
}

/// A compiler and its arguments.
pub struct Compiler {
    /// The program.
    pub program: &'static str,
    /// The folder of its output.
    pub folder: &'static str,
    /// Arguments of every call.
    pub always: &'static [&'static str],
    /// Arguments of compiling.
    pub compiling: &'static [&'static str],
    /// Arguments of linking.
    pub linking: &'static [&'static str],
    /// Whether an instance that fails the self-test is refused.
    pub is_refusing: bool,
}

impl Compiler {
    /// Which version it is.
    ///
    /// # Errors
    /// When it does not answer.
    pub fn version(&self) -> Result<String> {
        process::output(Command::new(self.program).arg("-dumpversion"))
    }

    /// The same, where an instance that fails the self-test is refused.
    pub fn refusing(mut self) -> Self {
        self.is_refusing = true;
        self
    }

    fn command(&self) -> Command {
        let mut command = Command::new(self.program);
        command.args(["-O1", "-Wall", "-Wextra", "-Werror"]).args(self.always);
        if self.is_refusing {
            command.arg("-DPLANT_SELF_TEST=2");
        }
        command
    }
}
