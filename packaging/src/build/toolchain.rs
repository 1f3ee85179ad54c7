//! The Rust toolchains of this machine, and which of them can compile for a target.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use crate::process;
use crate::tools::Tool;

/// A Rust toolchain.
pub struct Toolchain {
    /// Its Cargo.
    pub cargo: PathBuf,
    /// Its compiler.
    pub rustc: PathBuf,
    /// Where its libraries are.
    pub sysroot: PathBuf,
    /// The name under which precompiled standard libraries know their source.
    pub source_name: String,
    /// Whether it compiles the standard library along, because it has none for the target.
    pub compiles_std: bool,
}

impl Toolchain {
    /// The toolchain whose Cargo runs this program.
    ///
    /// # Errors
    /// When its compiler does not answer.
    pub fn in_use() -> Result<Self> {
        let variable = |name: &str, otherwise: &str| process::variable(name).unwrap_or_else(|| otherwise.into()).into();
        Self::ask(variable("CARGO", "cargo"), variable("RUSTC", "rustc"))
    }

    /// Debian's toolchain with the source of the standard library, if both are installed.
    fn of_debian() -> Option<Self> {
        let toolchain = Self::ask(process::find("/usr/bin/cargo")?, process::find("/usr/bin/rustc")?).ok()?;
        let has_source = toolchain.source().join("library/Cargo.lock").is_file();
        has_source.then_some(Self { compiles_std: true, ..toolchain })
    }

    fn ask(cargo: PathBuf, rustc: PathBuf) -> Result<Self> {
        let sysroot = process::output(Command::new(&rustc).args(["--print", "sysroot"]))?;
        let version = process::output(Command::new(&rustc).args(["--version", "--verbose"]))?;
        let commit = version.lines().find_map(|line| line.strip_prefix("commit-hash: "));
        let commit = commit.context("rustc --version --verbose names no commit")?;
        let (sysroot, source_name) = (sysroot.trim().into(), format!("/rustc/{commit}"));
        Ok(Self { cargo, rustc, sysroot, source_name, compiles_std: false })
    }

    /// Where the source of the standard library is, if it is there.
    pub fn source(&self) -> PathBuf {
        self.sysroot.join("lib/rustlib/src/rust")
    }

    /// The linker that comes with the toolchain.
    pub fn rust_lld(&self) -> Option<PathBuf> {
        let host = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
        let file = self.sysroot.join("lib/rustlib").join(host).join("bin/rust-lld");
        file.is_file().then_some(file)
    }

    /// Lets a command that is, or calls, Cargo take this toolchain where it is not the one that started this program: its
    /// compiler keeps the standard library buildable, and libraries of the other are not for it.
    pub fn lead<'c>(&self, command: &'c mut Command) -> &'c mut Command {
        if self.compiles_std {
            command.env("CARGO", &self.cargo).env("RUSTC", &self.rustc).env("RUSTC_BOOTSTRAP", "1");
            command.env_remove("LD_LIBRARY_PATH");
        }
        command
    }

    /// Whether its standard library for a target is installed.
    pub fn has(&self, triple: &str) -> bool {
        self.sysroot.join("lib/rustlib").join(triple).join("lib").is_dir()
    }
}

/// Kind of compilation for a target: with an installed standard library, or with one compiled along.
pub enum Target {
    /// The toolchain and the triple it compiles for.
    Found(Toolchain, &'static str),
    /// No toolchain can, and this would help.
    Missing(Tool),
}

impl Target {
    /// Looks for a toolchain.
    ///
    /// `prebuilt` is a target of `rustup target add`; `from_source` what to take where the standard library is
    /// compiled along.
    ///
    /// # Errors
    /// When the compiler in use does not answer.
    pub fn find(prebuilt: &'static str, from_source: &'static str) -> Result<Self> {
        let in_use = Toolchain::in_use()?;
        if in_use.has(prebuilt) {
            return Ok(Self::Found(in_use, prebuilt));
        }
        Ok(match Toolchain::of_debian() {
            Some(debian) => Self::Found(debian, from_source),
            None => Self::Missing(Tool::new(
                format!("Rust's standard library for {prebuilt}"),
                format!("rustup target add {prebuilt}; or on Debian: apt install rustc-web cargo-web rust-web-src"),
            )),
        })
    }

    /// Missing tool.
    pub fn missing(self) -> Option<Tool> {
        match self {
            Self::Found(..) => None,
            Self::Missing(tool) => Some(tool),
        }
    }

    /// The toolchain and the triple.
    ///
    /// # Errors
    /// When there is none.
    pub fn found(self) -> Result<(Toolchain, &'static str)> {
        match self {
            Self::Found(toolchain, triple) => Ok((toolchain, triple)),
            Self::Missing(tool) => Err(anyhow::anyhow!("missing: {tool}")),
        }
    }
}
