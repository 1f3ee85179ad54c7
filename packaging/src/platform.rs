//! The platforms of FMI 2.0 that a shared library can be for.

use anyhow::{Result, bail};

/// A platform, named by its folder in `binaries/`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Platform {
    /// Linux on 64 bit.
    Linux64,
    /// Windows on 64 bit.
    Win64,
    /// macOS on 64 bit.
    Darwin64,
}

impl Platform {
    /// The platform this program runs on.
    ///
    /// # Errors
    /// When FMI 2.0 has no folder for it.
    pub fn host() -> Result<Self> {
        match (std::env::consts::OS, std::env::consts::ARCH) {
            ("linux", "x86_64" | "aarch64") => Ok(Self::Linux64),
            ("windows", "x86_64") => Ok(Self::Win64),
            ("macos", "x86_64" | "aarch64") => Ok(Self::Darwin64),
            (os, arch) => bail!("FMI 2.0 has no platform folder for {os} on {arch}"),
        }
    }

    /// Its folder in `binaries/`.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Linux64 => "linux64",
            Self::Win64 => "win64",
            Self::Darwin64 => "darwin64",
        }
    }

    /// The extension of a shared library.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Linux64 => "so",
            Self::Win64 => "dll",
            Self::Darwin64 => "dylib",
        }
    }
}
