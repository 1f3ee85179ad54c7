//! Files that are there as a whole or not at all.

use std::path::Path;

use anyhow::{Context, Result};

/// The bytes of a file.
///
/// # Errors
/// When it cannot be read.
pub fn read(file: impl AsRef<Path>) -> Result<Vec<u8>> {
    let file = file.as_ref();
    std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))
}

/// The text of a file.
///
/// # Errors
/// When it cannot be read, or is no text.
pub fn text(file: impl AsRef<Path>) -> Result<String> {
    let file = file.as_ref();
    std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))
}

/// Writes a file under another name first, so that an interruption leaves the old file or the new one.
///
/// # Errors
/// When the folder cannot be made or the file cannot be written.
pub fn write(file: &Path, contents: impl AsRef<[u8]>) -> Result<()> {
    let folder = file.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let mut name = std::ffi::OsString::from(".");
    name.push(file.file_name().context("a file without a name")?);
    let partial = folder.join(name);
    std::fs::write(&partial, contents).with_context(|| format!("cannot write {}", partial.display()))?;
    std::fs::rename(&partial, file).with_context(|| format!("cannot write {}", file.display()))
}

/// Makes an empty folder, in place of an earlier one.
///
/// # Errors
/// When the earlier one cannot be removed, or the folder not be made.
pub fn renew(folder: &Path) -> Result<()> {
    if folder.exists() {
        std::fs::remove_dir_all(folder).with_context(|| format!("cannot remove the old {}", folder.display()))?;
    }
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))
}

/// A folder of a test, which makes and removes it; no other process has it.
#[cfg(test)]
pub fn scratch(name: &str) -> std::path::PathBuf {
    std::env::temp_dir().join(format!("{name}-{}", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_as_a_whole() -> Result<()> {
        let folder = scratch("files");
        let file = folder.join("deep/Model.fmu");
        write(&file, "old")?;
        write(&file, "new")?;
        assert_eq!(std::fs::read(&file)?, b"new");
        assert_eq!(std::fs::read_dir(folder.join("deep"))?.count(), 1, "something half-written is left");
        // A folder of that name: the new contents cannot take its place, and the message names the file.
        std::fs::create_dir_all(folder.join("taken/inside"))?;
        let problem = write(&folder.join("taken"), "new").map_err(|error| error.to_string());
        assert!(problem.is_err_and(|text| text.contains("cannot write") && text.contains("taken")));
        std::fs::remove_dir_all(&folder)?;
        Ok(())
    }
}
