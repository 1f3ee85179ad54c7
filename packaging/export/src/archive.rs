//! Archives in memory. A file is unpacked when it is asked for; files that stay are copied as they are compressed.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Write};

use flate2::Compression;
use flate2::bufread::DeflateDecoder;
use flate2::write::DeflateEncoder;
use rawzip::time::UtcDateTime;
use rawzip::{
    CompressionMethod, DataDescriptorOutput, ZipArchive, ZipArchiveEntryWayfinder, ZipArchiveWriter, ZipSliceArchive,
};

use crate::Refused;

/// More bytes than a file has that is read, unpacked.
const LIMIT: u64 = 64 << 20;

/// An archive.
pub struct Archive<'a> {
    archive: ZipSliceArchive<&'a [u8]>,
    entries: Vec<Entry>,
}

struct Entry {
    name: String,
    place: ZipArchiveEntryWayfinder,
    method: CompressionMethod,
    crc: u32,
    size: u64,
    time: Option<UtcDateTime>,
    mode: u32,
    is_folder: bool,
}

impl<'a> Archive<'a> {
    /// Reads the directory of an archive.
    pub fn read(bytes: &'a [u8]) -> Result<Self, Refused> {
        let archive = ZipArchive::from_slice(bytes)?;
        let (mut entries, mut found) = (Vec::new(), archive.entries());
        let mut names = BTreeSet::new();
        while let Some(header) = found.next_entry()? {
            let name = header.file_path().try_normalize()?.as_ref().to_owned();
            if !names.insert(name.clone()) {
                return Err(Refused(format!("{name} is in the archive twice")));
            }
            let time = header.last_modified();
            entries.push(Entry {
                name,
                place: header.wayfinder(),
                method: header.compression_method(),
                crc: header.crc32(),
                size: header.uncompressed_size_hint(),
                time: UtcDateTime::from_components(
                    time.year(),
                    time.month(),
                    time.day(),
                    time.hour(),
                    time.minute(),
                    time.second(),
                    0,
                ),
                mode: header.mode().value(),
                is_folder: header.is_dir(),
            });
        }
        Ok(Self { archive, entries })
    }

    /// Whether there is a file of that name.
    pub fn has(&self, name: &str) -> bool {
        self.entries.iter().any(|entry| entry.name == name)
    }

    /// The bytes of a file.
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>, Refused> {
        let missing = || Refused(format!("it is no FMU: there is no {name} in it"));
        let entry = self.entries.iter().find(|entry| entry.name == name).ok_or_else(missing)?;
        let local = self.archive.get_entry(entry.place)?;
        let mut bytes = Vec::new();
        let mut unpack = |reader: &mut dyn Read| reader.take(LIMIT + 1).read_to_end(&mut bytes);
        match entry.method {
            CompressionMethod::STORE => unpack(&mut local.verifying_reader(local.data()))?,
            CompressionMethod::DEFLATE => unpack(&mut local.verifying_reader(DeflateDecoder::new(local.data())))?,
            _ => return Err(Refused(format!("{name} is compressed in a way that FMUs do not have"))),
        };
        if bytes.len() as u64 > LIMIT {
            return Err(Refused(format!("{name} has more than {LIMIT} bytes")));
        }
        Ok(bytes)
    }

    /// The text of a file.
    pub fn text(&self, name: &str) -> Result<String, Refused> {
        String::from_utf8(self.bytes(name)?).map_err(|error| Refused(format!("{name} is no UTF-8: {error}")))
    }

    /// The archive with some files changed or added, and without others.
    pub fn rewritten(
        &self,
        mut changed: BTreeMap<String, Vec<u8>>,
        goes: impl Fn(&str) -> bool,
    ) -> Result<Vec<u8>, Refused> {
        let mut writer = ZipArchiveWriter::new(Vec::new());
        let (mut time, mut copied) = (None, 0);
        for entry in self.entries.iter().filter(|entry| !goes(&entry.name)) {
            time = entry.time.or(time);
            if entry.is_folder {
                writer.new_dir(&*entry.name).unix_permissions(entry.mode).create()?;
                continue;
            }
            if let Some(contents) = changed.remove(&entry.name) {
                write(&mut writer, &entry.name, &contents, time)?;
                continue;
            }
            let packed = self.archive.get_entry(entry.place)?.data();
            copied += packed.len();
            if copied > self.archive.get_ref().len() {
                return Err(Refused("files of the archive share their bytes".to_owned()));
            }
            let file = writer.new_file(&*entry.name).compression_method(entry.method).unix_permissions(entry.mode);
            let (mut file, _) = entry.time.into_iter().fold(file, |file, time| file.last_modified(time)).start()?;
            file.write_all(packed)?;
            file.finish(DataDescriptorOutput::new(entry.crc, entry.size))?;
        }
        for (name, contents) in changed {
            write(&mut writer, &name, &contents, time)?;
        }
        Ok(writer.finish()?)
    }
}

/// Writes an entry of the archive. The entry keeps the given modification time, so that the same request gives the same bytes.
fn write(
    writer: &mut ZipArchiveWriter<Vec<u8>>,
    name: &str,
    contents: &[u8],
    time: Option<UtcDateTime>,
) -> Result<(), Refused> {
    let file = writer.new_file(name).compression_method(CompressionMethod::DEFLATE).unix_permissions(0o100_644);
    let (mut file, config) = time.into_iter().fold(file, |file, time| file.last_modified(time)).start()?;
    let mut data = config.wrap(DeflateEncoder::new(&mut file, Compression::best()));
    data.write_all(contents)?;
    let (encoder, described) = data.finish()?;
    encoder.finish()?;
    file.finish(described)?;
    Ok(())
}
