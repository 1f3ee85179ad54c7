//! Machines that run a library, here or in an emulator.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};
use pneumatic_servo_packaging::build::aarch64;
use pneumatic_servo_packaging::process;
use pneumatic_servo_packaging::tools::Tool;
use pneumatic_servo_packaging::venv::{Requirements, Venv};
use pneumatic_servo_packaging::workspace::Workspace;

/// A machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Machine {
    /// This one, with Linux.
    Linux,
    /// Wine.
    Windows,
    /// QEMU, which runs programs of Linux on Arm.
    Arm,
}

impl Machine {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Linux, Self::Windows, Self::Arm];

    /// Name of the machine.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linux => "linux64",
            Self::Windows => "win64 under Wine",
            Self::Arm => "Linux on Arm under QEMU",
        }
    }

    /// The tools it needs and this machine lacks.
    pub fn missing(self) -> Vec<Tool> {
        let (compiler, package) = self.compiler();
        let emulator = match self {
            Self::Linux if cfg!(all(target_os = "linux", target_arch = "x86_64")) => None,
            Self::Linux => Some(Tool::new("Linux on x86_64", "run this test there")),
            Self::Windows => wine().is_none().then(|| Tool::new("wine64", "apt install wine64")),
            Self::Arm => Tool::unless_found(QEMU, "qemu-user"),
        };
        Tool::unless_found(compiler, package).into_iter().chain(emulator).collect()
    }

    /// Runs experiments on a library and returns the output of the host.
    ///
    /// # Errors
    /// When the host cannot be compiled, or a call of the library fails.
    pub fn run(self, workspace: &Workspace, library: &[u8], experiments: &str) -> Result<String> {
        let folder = workspace.target.join("platform-test").join(format!("{self:?}"));
        std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        let write = |name: &str, bytes: &[u8]| {
            std::fs::write(folder.join(name), bytes).with_context(|| format!("cannot write {name}"))
        };
        write(self.library(), library)?;
        write("experiments", experiments.as_bytes())?;
        self.compile(workspace, &folder)?;
        let input = File::open(folder.join("experiments")).context("cannot read the experiments")?;
        let begin = Instant::now();
        let results = process::output(self.host(&folder)?.arg(self.library()).current_dir(&folder).stdin(input))?;
        println!("{}: {:.1} s", self.name(), begin.elapsed().as_secs_f64());
        Ok(results)
    }

    /// The library, as a path from the folder where it is.
    fn library(self) -> &'static str {
        if self == Self::Windows { "./library.dll" } else { "./library.so" }
    }

    fn compile(self, workspace: &Workspace, folder: &Path) -> Result<()> {
        let mut compiler = Command::new(self.compiler().0);
        // A compiler that joins a product and a sum into one operation where the processor has it gives other bits.
        compiler.args(["-std=gnu11", "-O1", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-o", "host"]);
        // The headers of the standard as FMPy has them.
        let headers = Venv::prepare(workspace, Requirements::PACKAGE)?.module("fmpy")?.join("c-code");
        let sources = workspace.root.join("tests/platforms");
        compiler.arg("-I").arg(headers).args(["host.c", "fmi2.c", "fmi3.c"].map(|name| sources.join(name)));
        if self != Self::Windows {
            compiler.arg("-ldl");
        }
        process::run(compiler.current_dir(folder))
    }

    fn compiler(self) -> (&'static str, &'static str) {
        match self {
            Self::Linux => ("gcc", "gcc libc6-dev"),
            Self::Windows => ("x86_64-w64-mingw32-gcc", "gcc-mingw-w64-x86-64-posix"),
            Self::Arm => (aarch64::COMPILER, "gcc-aarch64-linux-gnu libc6-dev-arm64-cross"),
        }
    }

    /// The host, or the emulator with the host as its argument.
    fn host(self, folder: &Path) -> Result<Command> {
        match self {
            Self::Linux => Ok(Command::new(folder.join("host"))),
            Self::Windows => {
                let mut wine = Command::new(wine().context("wine64 was not found")?);
                // A home of its own, no windows, and no messages about missing parts of Wine that the library does not use.
                wine.env("WINEPREFIX", folder.join("wine")).env("WINEDEBUG", "-all").env_remove("DISPLAY");
                wine.env("WINEDLLOVERRIDES", "mscoree,mshtml=").arg("host.exe");
                Ok(wine)
            }
            Self::Arm => {
                let mut qemu = Command::new(QEMU);
                qemu.args(["-L", "/usr/aarch64-linux-gnu"]).arg(folder.join("host"));
                Ok(qemu)
            }
        }
    }
}

const QEMU: &str = "qemu-aarch64";

/// Debian keeps the program off the search path.
pub fn wine() -> Option<PathBuf> {
    ["wine64", "/usr/lib/wine/wine64"].into_iter().find_map(process::find)
}
