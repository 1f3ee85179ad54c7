//! The sources of an FMU in C (feature `sources`).

#[cfg(feature = "sources")]
mod build_description;
#[cfg(feature = "sources")]
mod generate;
#[cfg(feature = "sources")]
mod model_table;

use std::collections::BTreeMap;
use std::str::FromStr;

use anyhow::{Error, Result, bail};

#[cfg(feature = "sources")]
pub use self::generate::{loop_sources, module, sources};

/// The sources of an FMU.
#[derive(Default)]
pub struct Sources {
    /// The files by their names.
    pub files: BTreeMap<String, String>,
    /// Files that an importer compiles.
    pub compiled: Vec<String>,
}

/// Size of the sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Compiled for size, with few sizes of the vector of states.
    Small,
    /// Compiled for speed, as the shared library is.
    Full,
}

impl FromStr for Size {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text {
            "small" => Ok(Self::Small),
            "full" => Ok(Self::Full),
            _ => bail!("`{text}` is no size of the sources; there are small and full"),
        }
    }
}

#[cfg(not(feature = "sources"))]
mod none {
    use pneumatic_servo::model::Model;

    use super::*;
    use crate::description::Version;
    use crate::workspace::Workspace;

    const REASON: &str = "sources in C need the feature `sources` of pneumatic-servo-packaging";

    /// There are none.
    ///
    /// # Errors
    /// Always.
    pub fn module(_: &Workspace, _: &Model, _: Size) -> Result<Vec<u8>> {
        bail!(REASON)
    }

    /// There are none.
    ///
    /// # Errors
    /// Always.
    pub fn sources(_: &Workspace, _: &'static Model, _: &[Version], _: &[u8]) -> Result<Sources> {
        bail!(REASON)
    }

    /// There are none.
    ///
    /// # Errors
    /// Always.
    pub fn loop_sources(_: &Workspace, _: &'static Model, _: &[u8]) -> Result<Sources> {
        bail!(REASON)
    }
}
#[cfg(not(feature = "sources"))]
pub use self::none::{loop_sources, module, sources};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_is_named() {
        assert_eq!(["small", "full"].map(|text| text.parse::<Size>().ok()), [Some(Size::Small), Some(Size::Full)]);
        let problem = "tiny".parse::<Size>().map_err(|error| error.to_string());
        assert!(problem.is_err_and(|text| text.contains("`tiny` is no size")));
    }
}
