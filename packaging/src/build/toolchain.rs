//! The Rust toolchains of this machine, and which of them can compile for a target.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use crate::process;
use crate::tools::Tool;

/// The oldest Rust that compiles the workspace.
const OLDEST: &str = env!("CARGO_PKG_RUST_VERSION");
/// Packages of Debian that can compile for every target.
const DEBIAN: &str = "rustc-web cargo-web rust-web-src";

/// Whether a release comes before another; endings such as `-nightly` do not count.
fn is_older(release: &str, than: &str) -> bool {
    let numbers = |text: &str| {
        let numbers = text.split(['.', '-', '+']).map_while(|part| part.parse().ok());
        numbers.take(3).collect::<Vec<u32>>()
    };
    numbers(release) < numbers(than)
}

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
    /// Release of the compiler.
    pub release: String,
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
        let field = |name: &str| {
            let value = version.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "));
            value.with_context(|| format!("rustc --version --verbose names no {name}"))
        };
        let (source_name, release) = (format!("/rustc/{}", field("commit-hash")?), field("release")?.to_owned());
        Ok(Self { cargo, rustc, sysroot: sysroot.trim().into(), source_name, release, compiles_std: false })
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
        Ok(Self::of_debian(Toolchain::of_debian(), prebuilt, from_source))
    }

    /// Debian's toolchain if it is there and new enough, else what to install.
    fn of_debian(toolchain: Option<Toolchain>, prebuilt: &str, from_source: &'static str) -> Self {
        match toolchain {
            Some(debian) if is_older(&debian.release, OLDEST) => Self::Missing(Tool::new(
                format!(
                    "Rust {OLDEST} or newer for {prebuilt}; Debian's {} is {}",
                    debian.rustc.display(),
                    debian.release
                ),
                format!("apt-get update && apt-get install {DEBIAN}; or rustup target add {prebuilt}"),
            )),
            Some(debian) => Self::Found(debian, from_source),
            None => Self::Missing(Tool::new(
                format!("Rust's standard library for {prebuilt}"),
                format!("rustup target add {prebuilt}; or on Debian: apt-get update && apt-get install {DEBIAN}"),
            )),
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A compiler of Debian that is older than the workspace needs is not called, and the message has the remedy.
    #[test]
    fn old_compiler_of_debian_is_refused_with_the_remedy() {
        let debian = |release: &str| Toolchain {
            cargo: "/usr/bin/cargo".into(),
            rustc: "/usr/bin/rustc".into(),
            sysroot: "/usr".into(),
            source_name: String::new(),
            release: release.to_owned(),
            compiles_std: true,
        };
        let find = |release: &str| Target::of_debian(Some(debian(release)), "prebuilt", "from-source");
        assert_eq!(find(OLDEST).found().unwrap().1, "from-source");
        let error = find("1.63.0").found().map(|_| ()).unwrap_err().to_string();
        for part in ["Rust", OLDEST, "1.63.0", "apt-get update", "rustup target add prebuilt"] {
            assert!(error.contains(part), "{part} is missing: {error}");
        }
        assert!(Target::of_debian(None, "prebuilt", "from-source").found().is_err());
    }

    #[test]
    fn releases_are_compared_by_their_numbers() {
        for (release, is_too_old) in [
            ("1.63.0", true),
            ("1.89.0", false),
            ("1.9.0", true),
            ("1.100.0", false),
            ("1.89.0-nightly", false),
            ("2.0.0", false),
        ] {
            assert_eq!(is_older(release, "1.89"), is_too_old, "{release}");
        }
        let in_use = Toolchain::in_use().unwrap();
        assert!(!is_older(&in_use.release, OLDEST), "{} compiles this", in_use.release);
    }
}
