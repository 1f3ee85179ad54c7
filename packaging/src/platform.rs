//! The platforms that a shared library can be for, and how the user names them.

use std::collections::BTreeSet;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{Context, Error, Result, bail, ensure};

/// A platform, named by its folder in `binaries/` of FMI 2.0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Platform {
    /// Linux on 64 bit.
    Linux64,
    /// Windows on 64 bit.
    Win64,
    /// macOS on 64 bit.
    Darwin64,
}

impl Platform {
    /// Every platform.
    pub const ALL: [Self; 3] = [Self::Linux64, Self::Win64, Self::Darwin64];

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

    /// Its operating system, by the name that folders of FMI 3.0 end with.
    pub fn system(self) -> &'static str {
        match self {
            Self::Linux64 => "linux",
            Self::Win64 => "windows",
            Self::Darwin64 => "darwin",
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

impl fmt::Display for Platform {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.folder())
    }
}

impl FromStr for Platform {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let platform = Self::ALL.into_iter().find(|platform| platform.folder() == text);
        platform.with_context(|| format!("`{text}` is no platform; there are {}", names(Self::ALL)))
    }
}

/// A choice of platforms: `linux64,win64` or `all`.
#[derive(Clone, Debug, PartialEq)]
pub struct Platforms(pub BTreeSet<Platform>);

impl FromStr for Platforms {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if text == "all" {
            return Ok(Self(Platform::ALL.into()));
        }
        let platforms = text.split(',').map(str::parse).collect::<Result<_>>();
        Ok(Self(platforms.context("name platforms as in `linux64,win64`, or say `all`")?))
    }
}

/// A library that was built before, here or elsewhere: `win64=PATH`.
#[derive(Clone, Debug, PartialEq)]
pub struct Binary {
    /// Platform that it runs on.
    pub platform: Platform,
    /// Where it is.
    pub file: PathBuf,
}

impl FromStr for Binary {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let (platform, file) = text.split_once('=').context("write it as in `win64=PATH`")?;
        ensure!(!file.is_empty(), "the path after `{platform}=` is empty");
        Ok(Self { platform: platform.parse()?, file: file.into() })
    }
}

/// Platforms as a sentence lists them.
pub fn names(platforms: impl IntoIterator<Item = Platform>) -> String {
    platforms.into_iter().map(Platform::folder).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem<T: FromStr<Err = Error> + fmt::Debug>(text: &str) -> String {
        format!("{:#}", text.parse::<T>().unwrap_err())
    }

    #[test]
    fn platforms_are_listed_with_commas() -> Result<()> {
        assert_eq!("win64,linux64".parse::<Platforms>()?.0, BTreeSet::from([Platform::Linux64, Platform::Win64]));
        assert_eq!("all".parse::<Platforms>()?.0, BTreeSet::from(Platform::ALL));
        Ok(())
    }

    #[test]
    fn an_unknown_platform_is_named() {
        assert!(problem::<Platforms>("linux64,win32").contains("`win32` is no platform; there are linux64, win64"));
        assert!(problem::<Platforms>("").contains("`` is no platform"));
        assert!(problem::<Binary>("win46=a.dll").contains("`win46` is no platform"));
    }

    #[test]
    fn a_binary_has_a_platform_and_a_path() -> Result<()> {
        let binary: Binary = "win64=out/a=b.dll".parse()?;
        assert_eq!(binary, Binary { platform: Platform::Win64, file: "out/a=b.dll".into() });
        assert!(problem::<Binary>("a.dll").contains("win64=PATH"));
        assert!(problem::<Binary>("win64=").contains("is empty"));
        Ok(())
    }

    /// As the systems themselves name them.
    #[test]
    fn each_platform_has_its_system_and_the_extension_of_its_libraries() {
        let named = Platform::ALL.map(|it| (it.folder(), it.system(), it.extension()));
        assert_eq!(named, [("linux64", "linux", "so"), ("win64", "windows", "dll"), ("darwin64", "darwin", "dylib")]);
    }
}
