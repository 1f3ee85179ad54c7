//! Facts about a library of macOS.

use anyhow::{Result, ensure};
use object::macho::{CS_ADHOC, CS_HASHTYPE_SHA256, LC_CODE_SIGNATURE, LinkeditDataCommand, PLATFORM_MACOS};
use object::read::macho::{CodeDirectory, MachOFile64};
use object::{BigEndian, Endianness, Object, ObjectSymbol};
use sha2::{Digest, Sha256};

use super::Version;
use super::facts::{Facts, text};

/// Completes the facts that all formats share.
pub fn facts(file: &MachOFile64<'_, Endianness>, bytes: &[u8], common: Facts) -> Result<Facts> {
    let signature = signature(file, bytes).err().map(|problem| problem.to_string());
    let mut facts = Facts { needs: macos(file)?, signature, ..common };
    // The names begin with an underscore that the source has not.
    facts.exports = facts.exports.iter().map(|name| name.strip_prefix('_').unwrap_or(name).to_owned()).collect();
    let mut commands = file.macho_load_commands()?;
    while let Some(command) = commands.next()? {
        if let Some(library) = command.dylib()? {
            facts.libraries.insert(text(command.string(file.endian(), library.dylib.name)?));
        }
    }
    if file.symbols().any(|symbol| symbol.is_definition() && !symbol.is_global()) {
        facts.debris.insert("local symbols".to_owned());
    }
    if file.has_debug_symbols() {
        facts.debris.insert("debugging information".to_owned());
    }
    Ok(facts)
}

/// The oldest macOS that the library says it is for.
fn macos(file: &MachOFile64<'_, Endianness>) -> Result<Option<Version>> {
    let Some((version, _)) = file.build_version()? else {
        return Ok(None);
    };
    let oldest = version.minos.get(file.endian()).0;
    let is_macos = version.platform.get(file.endian()) == PLATFORM_MACOS;
    Ok(is_macos.then_some((oldest >> 16, oldest >> 8 & 0xff)))
}

/// Every page must have the hash that the signature says, or the Mac ends the process.
fn signature(file: &MachOFile64<'_, Endianness>, bytes: &[u8]) -> Result<()> {
    let mut commands = file.macho_load_commands()?;
    while let Some(command) = commands.next()? {
        if command.cmd() != LC_CODE_SIGNATURE {
            continue;
        }
        let place: &LinkeditDataCommand<Endianness> = command.data()?;
        let signature = place.code_signature(file.endian(), bytes)?;
        let mut blobs = signature.blobs();
        while let Some(blob) = blobs.next()? {
            if let Some(directory) = blob.code_directory()? {
                return pages(&directory, bytes, place.dataoff.get(file.endian()).into());
            }
        }
    }
    anyhow::bail!("there is none")
}

fn pages(directory: &CodeDirectory<'_>, bytes: &[u8], signed: u64) -> Result<()> {
    let header = directory.header();
    ensure!(header.flags.get(BigEndian).0 & CS_ADHOC.0 != 0, "it is not ad hoc");
    ensure!(header.hash_type == CS_HASHTYPE_SHA256, "its hashes are not SHA-256");
    ensure!(directory.code_limit() == signed, "it does not cover the file");
    let code = &bytes[..usize::try_from(signed)?.min(bytes.len())];
    let pages = code.chunks(1 << header.page_size);
    ensure!(pages.len() == header.n_code_slots.get(BigEndian) as usize, "it has another number of pages");
    for (page, index) in pages.zip(0..) {
        ensure!(Sha256::digest(page)[..] == *directory.code_hash(index)?, "page {index} was changed after signing");
    }
    Ok(())
}
