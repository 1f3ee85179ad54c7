//! Facts about a shared library, independent of its format.

use std::collections::BTreeSet;

use object::Architecture;

use super::Version;
use crate::platform::Platform;

/// The facts about a library for one processor.
#[derive(Debug)]
pub struct Facts {
    /// Platform of the file's format.
    pub platform: Platform,
    /// The processor.
    pub architecture: Architecture,
    /// The symbols it defines for others.
    pub exports: BTreeSet<String>,
    /// The libraries that must be there when it is loaded.
    pub libraries: BTreeSet<String>,
    /// Symbols and debugging information that a stripped library lacks.
    pub debris: BTreeSet<String>,
    /// The version of glibc or macOS that it needs.
    pub needs: Option<Version>,
    /// Defect of its signature, where it must have one.
    pub signature: Option<String>,
}

/// A name, with a sign in place of bytes that are not UTF-8.
pub fn text(bytes: impl AsRef<[u8]>) -> String {
    String::from_utf8_lossy(bytes.as_ref()).into_owned()
}
