//! What the gates look at, whatever the format of the file.

use std::collections::BTreeSet;

use anyhow::{Context, Result, bail};
use object::read::macho::{FatArch, MachOFatFile32};
use object::{Architecture, File, FileKind, Object, ObjectSection};

use super::{Version, elf, mach_o, pe};
use crate::platform::Platform;

/// The facts about a library for one processor.
#[derive(Debug)]
pub struct Facts {
    /// Whose format it has.
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
    /// What is wrong with its signature, where it must have one.
    pub signature: Option<String>,
}

/// Reads a shared library; a universal one of the Mac is several.
///
/// # Errors
/// When it is none, or damaged.
pub fn read(bytes: &[u8]) -> Result<Vec<Facts>> {
    match FileKind::parse(bytes).context("not a shared library")? {
        FileKind::MachOFat32 => {
            let universal = MachOFatFile32::parse(bytes).context("damaged universal library")?;
            let slices = universal.arches().iter().map(|arch| slice(arch.data(bytes).context("damaged slice")?));
            slices.collect()
        }
        _ => Ok(vec![slice(bytes)?]),
    }
}

fn slice(bytes: &[u8]) -> Result<Facts> {
    let file = File::parse(bytes).context("not a shared library")?;
    let common = Facts {
        platform: Platform::Linux64,
        architecture: file.architecture(),
        exports: exports(&file)?,
        libraries: BTreeSet::new(),
        debris: debugging(&file),
        needs: None,
        signature: None,
    };
    match &file {
        File::Elf64(elf) => elf::facts(elf, common).context("damaged ELF file"),
        File::Pe64(pe) => pe::facts(pe, common).context("damaged PE file"),
        File::MachO64(mach_o) => mach_o::facts(mach_o, bytes, common).context("damaged Mach-O file"),
        _ => bail!("not a 64-bit shared library of Linux, Windows or macOS"),
    }
}

fn exports(file: &File<'_>) -> Result<BTreeSet<String>> {
    let mut names = BTreeSet::new();
    for export in file.exports().context("unreadable table of exports")? {
        let name = export.context("unreadable export")?.into_name().into_name();
        names.insert(name.map_or_else(|| "(a number)".to_owned(), text));
    }
    Ok(names)
}

fn debugging(file: &File<'_>) -> BTreeSet<String> {
    let names = file.sections().filter_map(|section| section.name().ok().map(str::to_owned));
    names.filter(|name| name.contains("debug_")).collect()
}

/// A name, with a sign in place of what is no UTF-8.
pub fn text(bytes: impl AsRef<[u8]>) -> String {
    String::from_utf8_lossy(bytes.as_ref()).into_owned()
}
