//! Targets that the sources are compiled for and run on.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};
use pneumatic_servo_packaging::process;
use pneumatic_servo_packaging::tools::Tool;
use pneumatic_servo_packaging::workspace::Workspace;

use super::compiled::{Compiler, Written};
use super::footprint::Needs;
use crate::platform_test::{Machine, wine};

/// Result of the programs on a target.
pub struct Outcome {
    /// The bits of all results.
    pub bits: String,
    /// Memory and instructions that it needed.
    pub needs: Needs,
}

/// A target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// This machine.
    Linux,
    /// This machine, with another compiler.
    Clang,
    /// A Cortex-M7 with double precision, without an operating system.
    CortexM7,
    /// A Cortex-M4, which computes double precision by calls, without an operating system.
    CortexM4,
    /// A Cortex-M4 with hardware for single precision, without an operating system.
    CortexM4Single,
    /// Linux on 32-bit Arm with hardware for floating-point numbers.
    Arm32,
    /// Linux on IBM Z, which keeps the big end of numbers first.
    BigEndian,
    /// Linux on 64-bit Arm.
    Arm64,
    /// Windows.
    Windows,
}

/// An emulator, and the Debian package that has it.
type Emulator = Option<(&'static str, &'static str)>;

impl Target {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Linux,
        Self::CortexM7,
        Self::CortexM4,
        Self::CortexM4Single,
        Self::Arm32,
        Self::BigEndian,
        Self::Arm64,
        Self::Windows,
        Self::Clang,
    ];

    /// Name of the target.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linux => "Linux on x86_64",
            Self::Clang => "Linux on x86_64, compiled by Clang",
            Self::CortexM7 => "Cortex-M7",
            Self::CortexM4 => "Cortex-M4 without floating-point unit",
            Self::CortexM4Single => "Cortex-M4 with single precision",
            Self::Arm32 => "Linux on 32-bit Arm under QEMU",
            Self::BigEndian => "Linux on IBM Z (big-endian) under QEMU",
            Self::Arm64 => "Linux on 64-bit Arm under QEMU",
            Self::Windows => "Windows under Wine",
        }
    }

    /// The machine that runs a shared library for it.
    pub fn machine(self) -> Option<Machine> {
        match self {
            Self::Linux => Some(Machine::Linux),
            Self::Arm64 => Some(Machine::Arm),
            Self::Windows => Some(Machine::Windows),
            _ => None,
        }
    }

    /// Its compiler. For a microcontroller it makes small code, as its users do, since that is measured.
    pub fn compiler(self) -> Compiler {
        let of = |program, folder, always, compiling, linking| Compiler {
            program,
            folder,
            always,
            compiling,
            linking,
            is_refusing: false,
        };
        const NO_SYSTEM: &[&str] = &["--specs=rdimon.specs"];
        match self {
            // With operations that join a product and a sum.
            Self::Linux => of("gcc", "linux", &[], &["-fPIC", "-march=x86-64-v3"], &[]),
            Self::Clang => of("clang", "clang", &[], &["-march=x86-64-v3"], &[]),
            Self::Arm64 => of("aarch64-linux-gnu-gcc", "arm64", &[], &["-fPIC"], &[]),
            Self::Arm32 => of("arm-linux-gnueabihf-gcc", "arm32", &["-mfpu=vfpv4"], &[], &["-static"]),
            Self::BigEndian => of("s390x-linux-gnu-gcc", "s390x", &[], &[], &["-static"]),
            Self::Windows => {
                of("x86_64-w64-mingw32-gcc", "windows", &["-D__USE_MINGW_ANSI_STDIO=1"], &[], &["-static-libgcc"])
            }
            Self::CortexM7 => of(
                "arm-none-eabi-gcc",
                "cortex-m7",
                &["-Os", "-mcpu=cortex-m7", "-mfloat-abi=hard", "-mfpu=fpv5-d16", "-mthumb", "-DPLANT_INSTANCES=1"],
                &[],
                NO_SYSTEM,
            ),
            Self::CortexM4 => of(
                "arm-none-eabi-gcc",
                "cortex-m4",
                &["-Os", "-mcpu=cortex-m4", "-mfloat-abi=soft", "-mthumb", "-DPLANT_INSTANCES=1"],
                &[],
                NO_SYSTEM,
            ),
            Self::CortexM4Single => of(
                "arm-none-eabi-gcc",
                "cortex-m4-single",
                &["-Os", "-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-mthumb", "-DPLANT_INSTANCES=1"],
                &[],
                NO_SYSTEM,
            ),
        }
    }

    /// Whether it is a microcontroller, whose needs the page lists.
    pub fn has_no_system(self) -> bool {
        matches!(self, Self::CortexM7 | Self::CortexM4 | Self::CortexM4Single)
    }

    /// The Debian packages of its compiler.
    fn package(self) -> &'static str {
        match self {
            Self::Linux => "gcc libc6-dev",
            Self::Clang => "clang",
            Self::Arm64 => "gcc-aarch64-linux-gnu libc6-dev-arm64-cross",
            Self::Arm32 => "gcc-arm-linux-gnueabihf libc6-dev-armhf-cross",
            Self::BigEndian => "gcc-s390x-linux-gnu libc6-dev-s390x-cross",
            Self::Windows => "gcc-mingw-w64-x86-64-posix",
            Self::CortexM7 | Self::CortexM4 | Self::CortexM4Single => "gcc-arm-none-eabi libnewlib-arm-none-eabi",
        }
    }

    fn emulator(self) -> Emulator {
        match self {
            Self::Linux | Self::Clang | Self::Windows => None,
            Self::Arm64 => Some(("qemu-aarch64", "qemu-user")),
            Self::Arm32 => Some(("qemu-arm", "qemu-user")),
            Self::BigEndian => Some(("qemu-s390x", "qemu-user")),
            Self::CortexM7 | Self::CortexM4 | Self::CortexM4Single => Some(("qemu-system-arm", "qemu-system-arm")),
        }
    }

    /// The tools it needs and this machine lacks.
    pub fn missing(self) -> Vec<Tool> {
        let emulator = self.emulator().and_then(|(program, package)| Tool::unless_found(program, package));
        let wine = (self == Self::Windows && wine().is_none()).then(|| Tool::new("wine64", "apt install wine64"));
        let compiler = Tool::unless_found(self.compiler().program, self.package());
        compiler.into_iter().chain(emulator).chain(wine).collect()
    }

    /// Runs accesses to memory, many sums and products, the control loop of `examples/target`, and laws by their numbers.
    ///
    /// # Errors
    /// When a program cannot be compiled, or ends with an error.
    pub fn run(
        self,
        workspace: &Workspace,
        written: &Written,
        plant: &[PathBuf],
        laws: &Range<i32>,
    ) -> Result<Outcome> {
        let mut outcome = Outcome { bits: String::new(), needs: Needs::of_objects(&self.compiler(), plant)? };
        for (name, file) in PROGRAMS {
            let program = self.program(workspace, written, (name, &workspace.root.join(file)), plant, laws)?;
            let printed = process::output(&mut self.start(&written.folder, &program))?.replace('\r', "");
            for line in printed.lines() {
                match line.strip_prefix("measured ") {
                    Some(measured) => outcome.needs.add(measured)?,
                    None => outcome.bits += &format!("{line}\n"),
                }
            }
        }
        let run = outcome.bits.lines().filter(|line| line.starts_with("law ")).count();
        ensure!(run == laws.len(), "{} ran {run} laws:\n{}", self.name(), outcome.bits);
        Ok(outcome)
    }

    fn program(
        self,
        workspace: &Workspace,
        written: &Written,
        (name, file): (&str, &Path),
        plant: &[PathBuf],
        laws: &Range<i32>,
    ) -> Result<PathBuf> {
        let board = workspace.root.join("examples/target/cortex-m7");
        let laws = [format!("-DFIRST_LAW={}", laws.start), format!("-DLAWS={}", laws.len())];
        let mut files: Vec<PathBuf> = laws.into_iter().map(PathBuf::from).chain([file.to_owned()]).collect();
        if self.has_no_system() {
            files.extend([format!("-DINSTRUCTIONS_PER_TICK={INSTRUCTIONS_PER_TICK}").into(), board.join("start.c")]);
            files.extend(["-T".into(), board.join("memory.ld")]);
        }
        written.program(&self.compiler(), name, &files, plant)
    }

    fn start(self, folder: &Path, program: &Path) -> Command {
        let mut command = match (self, self.emulator()) {
            (Self::CortexM7 | Self::CortexM4 | Self::CortexM4Single, _) => {
                // The board of the Cortex-M7 runs code for the Cortex-M4, too.
                let mut qemu = Command::new("qemu-system-arm");
                qemu.args(["-M", "mps2-an500", "-nographic", "-monitor", "none", "-serial", "none"]);
                qemu.args(["-icount", "shift=0", "-semihosting-config", "enable=on,target=native", "-kernel"]);
                qemu
            }
            (Self::Windows, _) => {
                let mut command = Command::new(wine().unwrap_or_else(|| "wine64".into()));
                command.env("WINEPREFIX", folder.join("wine")).env("WINEDEBUG", "-all").env_remove("DISPLAY");
                command.env("WINEDLLOVERRIDES", "mscoree,mshtml=");
                command
            }
            (_, Some((emulator, _))) => {
                let mut qemu = Command::new(emulator);
                if self == Self::Arm64 {
                    qemu.args(["-L", "/usr/aarch64-linux-gnu"]);
                }
                qemu
            }
            (_, None) => return Command::new(program),
        };
        command.arg(program);
        command
    }
}

/// Programs that run on each target.
const PROGRAMS: [(&str, &str); 4] = [
    ("memory", "tests/sources/memory.c"),
    ("arithmetic", "tests/sources/arithmetic.c"),
    ("loop", "examples/target/main.c"),
    ("laws", "tests/sources/laws.c"),
];

/// QEMU lets an instruction take 1 ns, and the timer of the board ticks with 25 MHz.
const INSTRUCTIONS_PER_TICK: u32 = 40;
