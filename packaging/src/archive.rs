//! The FMU file: a zip archive whose bytes depend on its contents alone.

use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result, ensure};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::files;
use crate::timestamp::Timestamp;

/// The files of an FMU, sorted by their path.
#[derive(Default)]
pub struct Archive {
    files: BTreeMap<String, Entry>,
}

/// A file, or a file that is compressed already.
enum Entry {
    Plain(Vec<u8>),
    Compressed(Compressed),
}

/// A program that goes into several archives, compressed once: compressing takes most of the time of joining FMUs.
#[derive(Clone)]
pub struct Compressed(Arc<[u8]>);

impl Compressed {
    /// Compresses a program.
    ///
    /// # Errors
    /// When the timestamp cannot be stored or the program is too large for the format.
    pub fn program(contents: &[u8], timestamp: Timestamp) -> Result<Self> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        zip.start_file("program", options(timestamp)?.unix_permissions(PROGRAM))?;
        zip.write_all(contents)?;
        Ok(Self(zip.finish()?.into_inner().into()))
    }
}

/// Permissions of programs and of all else.
const PROGRAM: u32 = 0o755;
const DOCUMENT: u32 = 0o644;

/// Options of stored files.
fn options(timestamp: Timestamp) -> Result<SimpleFileOptions> {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    Ok(options.compression_level(Some(9)).last_modified_time(timestamp.in_archive()?))
}

impl Archive {
    /// Puts a file in.
    ///
    /// # Errors
    /// When the path is taken, absolute, or not written with `/`.
    pub fn add(&mut self, path: &str, contents: impl Into<Vec<u8>>) -> Result<()> {
        self.insert(path, Entry::Plain(contents.into()))
    }

    /// Puts a program in that is compressed already.
    ///
    /// # Errors
    /// As [`add`](Self::add).
    pub fn add_compressed(&mut self, path: &str, program: Compressed) -> Result<()> {
        self.insert(path, Entry::Compressed(program))
    }

    fn insert(&mut self, path: &str, entry: Entry) -> Result<()> {
        ensure!(!path.starts_with('/') && !path.contains('\\'), "{path} is no relative path with forward slashes");
        ensure!(self.files.insert(path.to_owned(), entry).is_none(), "{path} is in the FMU twice");
        Ok(())
    }

    /// The bytes of the archive.
    ///
    /// # Errors
    /// When the timestamp cannot be stored or a file is too large for the format.
    pub fn bytes(&self, timestamp: Timestamp) -> Result<Vec<u8>> {
        let common = options(timestamp)?;
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for (path, entry) in &self.files {
            match entry {
                Entry::Plain(contents) => {
                    let mode = if path.starts_with("binaries/") { PROGRAM } else { DOCUMENT };
                    zip.start_file(path, common.unix_permissions(mode))
                        .with_context(|| format!("cannot add {path}"))?;
                    zip.write_all(contents).with_context(|| format!("cannot compress {path}"))?;
                }
                Entry::Compressed(Compressed(archive)) => {
                    let mut archive = ZipArchive::new(Cursor::new(&archive[..]))?;
                    let program = archive.by_index_raw(0)?;
                    zip.raw_copy_file_rename(program, path).with_context(|| format!("cannot add {path}"))?;
                }
            }
        }
        Ok(zip.finish().context("cannot finish the archive")?.into_inner())
    }

    /// Writes the archive.
    ///
    /// # Errors
    /// As [`Archive::bytes`], or when the file cannot be written.
    pub fn write(&self, file: &Path, timestamp: Timestamp) -> Result<()> {
        files::write(file, self.bytes(timestamp)?)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn entries_are_sorted_and_bytes_repeat() -> Result<()> {
        let timestamp = Timestamp::of_source(Path::new(env!("CARGO_MANIFEST_DIR")))?;
        let build = |paths: &[&str]| -> Result<Vec<u8>> {
            let mut archive = Archive::default();
            for path in paths {
                archive.add(path, path.as_bytes())?;
            }
            archive.bytes(timestamp)
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

    #[test]
    fn a_program_that_was_compressed_before_gives_the_same_bytes() -> Result<()> {
        let timestamp = Timestamp::of_source(Path::new(env!("CARGO_MANIFEST_DIR")))?;
        let program: Vec<u8> =
            (0..100_000_u32).flat_map(|number| (number.wrapping_mul(number) / 7).to_le_bytes()).collect();
        let path = "binaries/linux64/Model.so";
        let (mut one, mut other) = (Archive::default(), Archive::default());
        for archive in [&mut one, &mut other] {
            archive.add("modelDescription.xml", "<a/>")?;
        }
        one.add(path, program.clone())?;
        other.add_compressed(path, Compressed::program(&program, timestamp)?)?;
        assert!(one.bytes(timestamp)? == other.bytes(timestamp)?);
        Ok(())
    }
}
