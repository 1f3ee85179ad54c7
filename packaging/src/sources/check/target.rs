//! Targets that the control loop of `examples/target` is compiled for and run on.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use crate::build::tools::Tool;
use crate::platform_test::wine;
use crate::process;
use crate::workspace::Workspace;

/// A target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// This machine.
    Linux,
    /// Linux on 64-bit Arm.
    Arm64,
    /// Linux on 32-bit Arm with hardware for floating-point numbers.
    Arm32,
    /// A Cortex-M7 with double precision, without an operating system.
    CortexM7,
    /// Linux on IBM Z, which keeps the big end of numbers first.
    BigEndian,
    /// Windows.
    Windows,
}

/// A compiler, an emulator, and the Debian packages that have them.
struct Tools {
    compiler: &'static str,
    compiler_package: &'static str,
    emulator: Option<(&'static str, &'static str)>,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Linux, Self::CortexM7, Self::Arm32, Self::BigEndian, Self::Arm64, Self::Windows];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linux => "Linux on x86_64",
            Self::Arm64 => "Linux on 64-bit Arm under QEMU",
            Self::Arm32 => "Linux on 32-bit Arm under QEMU",
            Self::CortexM7 => "Cortex-M7 without operating system under QEMU",
            Self::BigEndian => "Linux on IBM Z (big-endian) under QEMU",
            Self::Windows => "Windows under Wine",
        }
    }

    fn tools(self) -> Tools {
        let of = |compiler, compiler_package, emulator| Tools { compiler, compiler_package, emulator };
        match self {
            Self::Linux => of("gcc", "gcc libc6-dev", None),
            Self::Arm64 => {
                let package = "gcc-aarch64-linux-gnu libc6-dev-arm64-cross";
                of("aarch64-linux-gnu-gcc", package, Some(("qemu-aarch64", "qemu-user")))
            }
            Self::Arm32 => {
                let package = "gcc-arm-linux-gnueabihf libc6-dev-armhf-cross";
                of("arm-linux-gnueabihf-gcc", package, Some(("qemu-arm", "qemu-user")))
            }
            Self::CortexM7 => {
                let package = "gcc-arm-none-eabi libnewlib-arm-none-eabi";
                of("arm-none-eabi-gcc", package, Some(("qemu-system-arm", "qemu-system-arm")))
            }
            Self::BigEndian => {
                let package = "gcc-s390x-linux-gnu libc6-dev-s390x-cross";
                of("s390x-linux-gnu-gcc", package, Some(("qemu-s390x", "qemu-user")))
            }
            Self::Windows => of("x86_64-w64-mingw32-gcc", "gcc-mingw-w64-x86-64-posix", None),
        }
    }

    /// The tools it needs and this machine lacks.
    pub fn missing(self) -> Vec<Tool> {
        let tools = self.tools();
        let emulator = tools.emulator.and_then(|(program, package)| Tool::unless_found(program, package));
        let wine = (self == Self::Windows && wine().is_none()).then(|| Tool::new("wine64", "apt install wine64"));
        let compiler = Tool::unless_found(tools.compiler, tools.compiler_package);
        compiler.into_iter().chain(emulator).chain(wine).collect()
    }

    /// Compiles the control loop with the sources in a folder, runs it, and returns what it prints.
    ///
    /// # Errors
    /// When it cannot be compiled, or ends with an error.
    pub fn run(self, workspace: &Workspace, folder: &Path, sources: &[PathBuf]) -> Result<String> {
        let example = workspace.root.join("examples/target");
        let program = folder.join(format!("{self:?}.exe"));
        let mut compiler = Command::new(self.tools().compiler);
        compiler.args(["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-I"]).arg(folder);
        match self {
            Self::Linux => {
                // All but the loop itself is in the library of the faces.
                compiler.arg("-Wl,-rpath,$ORIGIN").arg(example.join("main.c")).arg(super::library(folder)).arg("-o");
                process::run(compiler.arg(&program))?;
                return process::output(&mut self.start(folder, &program));
            }
            Self::Arm64 | Self::Arm32 | Self::BigEndian => compiler.args(["-std=gnu99", "-static"]),
            Self::CortexM7 => {
                let folder = example.join("cortex-m7");
                compiler.args(["-mcpu=cortex-m7", "-mfloat-abi=hard", "-mfpu=fpv5-d16", "-mthumb"]);
                compiler.args(["-DPLANT_INSTANCES=1", "--specs=rdimon.specs", "-T"]).arg(folder.join("memory.ld"));
                compiler.arg(folder.join("start.c"))
            }
            Self::Windows => compiler.arg("-D__USE_MINGW_ANSI_STDIO=1"),
        };
        let is_face = |file: &Path| file.file_name().is_some_and(|name| name == "fmi2.c" || name == "fmi3.c");
        compiler.arg(example.join("main.c")).arg(folder.join("loop.c"));
        compiler.args(sources.iter().filter(|file| !is_face(file))).arg("-lm").arg("-o").arg(&program);
        process::run(&mut compiler)?;
        Ok(process::output(&mut self.start(folder, &program))?.replace('\r', ""))
    }

    fn start(self, folder: &Path, program: &Path) -> Command {
        let mut command = match (self, self.tools().emulator) {
            (Self::CortexM7, _) => {
                let mut qemu = Command::new("qemu-system-arm");
                qemu.args(["-M", "mps2-an500", "-nographic", "-monitor", "none", "-serial", "none"]);
                qemu.args(["-semihosting-config", "enable=on,target=native", "-kernel"]);
                qemu
            }
            (Self::Windows, _) => {
                let mut wine = Command::new(wine().unwrap_or_else(|| "wine64".into()));
                wine.env("WINEPREFIX", folder.join("wine")).env("WINEDEBUG", "-all").env_remove("DISPLAY");
                wine.env("WINEDLLOVERRIDES", "mscoree,mshtml=");
                wine
            }
            (_, Some((emulator, _))) => Command::new(emulator),
            (_, None) => return Command::new(program),
        };
        command.arg(program);
        command
    }
}
