//! The FMU file: a zip archive whose bytes depend on its contents alone.

use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::Path;

use anyhow::{Context, Result, ensure};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::files;
use crate::moment::Moment;

/// The files of an FMU, sorted by their path.
#[derive(Default)]
pub struct Archive {
    files: BTreeMap<String, Vec<u8>>,
}

impl Archive {
    /// Puts a file in.
    ///
    /// # Errors
    /// When the path is taken, absolute, or not written with `/`.
    pub fn add(&mut self, path: &str, contents: impl Into<Vec<u8>>) -> Result<()> {
        ensure!(!path.starts_with('/') && !path.contains('\\'), "{path} is no relative path with forward slashes");
        ensure!(self.files.insert(path.to_owned(), contents.into()).is_none(), "{path} is in the FMU twice");
        Ok(())
    }

    /// The bytes of the archive.
    ///
    /// # Errors
    /// When the moment cannot be stored or a file is too large for the format.
    pub fn bytes(&self, moment: Moment) -> Result<Vec<u8>> {
        let common = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(9))
            .last_modified_time(moment.in_archive()?);
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for (path, contents) in &self.files {
            let mode = if path.starts_with("binaries/") { 0o755 } else { 0o644 };
            zip.start_file(path, common.unix_permissions(mode)).with_context(|| format!("cannot add {path}"))?;
            zip.write_all(contents).with_context(|| format!("cannot compress {path}"))?;
        }
        Ok(zip.finish().context("cannot finish the archive")?.into_inner())
    }

    /// Writes the archive.
    ///
    /// # Errors
    /// Those of [`Archive::bytes`], or when the file cannot be written.
    pub fn write(&self, file: &Path, moment: Moment) -> Result<()> {
        files::write(file, self.bytes(moment)?)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn entries_are_sorted_and_bytes_repeat() -> Result<()> {
        let moment = Moment::of_source(Path::new(env!("CARGO_MANIFEST_DIR")))?;
        let build = |paths: &[&str]| -> Result<Vec<u8>> {
            let mut archive = Archive::default();
            for path in paths {
                archive.add(path, path.as_bytes())?;
            }
            archive.bytes(moment)
        };
        let bytes = build(&["modelDescription.xml", "binaries/linux64/Model.so"])?;
        assert_eq!(bytes, build(&["binaries/linux64/Model.so", "modelDescription.xml"])?);
        let read = zip::ZipArchive::new(Cursor::new(bytes))?;
        let names = read.file_names().collect::<Result<Vec<_>, _>>()?;
        assert_eq!(names, ["binaries/linux64/Model.so", "modelDescription.xml"]);
        Ok(())
    }

    #[test]
    fn paths_that_hosts_cannot_read_are_refused() {
        let mut archive = Archive::default();
        assert!(archive.add("binaries\\win64\\Model.dll", "").is_err());
        assert!(archive.add("/modelDescription.xml", "").is_err());
        assert!(archive.add("modelDescription.xml", "").is_ok());
        assert!(archive.add("modelDescription.xml", "").is_err());
    }
}
