//! Facts about a library of Linux.

use anyhow::Result;
use object::elf::{DT_NEEDED, SHT_SYMTAB};
use object::read::elf::{ElfFile64, SectionHeader};

use super::Version;
use super::facts::{Facts, text};

/// Completes the facts that all formats share.
pub fn facts(file: &ElfFile64<'_>, common: Facts) -> Result<Facts> {
    let mut facts = Facts { needs: glibc(file)?, ..common };
    let dynamic = file.elf_dynamic_table()?;
    for entry in dynamic.iter().filter(|entry| entry.tag == DT_NEEDED) {
        facts.libraries.insert(text(dynamic.string(entry)?));
    }
    if file.elf_section_table().iter().any(|section| section.sh_type(file.endian()) == SHT_SYMTAB) {
        facts.debris.insert(".symtab".to_owned());
    }
    Ok(facts)
}

/// The newest version of glibc that a symbol asks for.
fn glibc(file: &ElfFile64<'_>) -> Result<Option<Version>> {
    let sections = file.elf_section_table();
    let mut newest = None;
    let Some((mut libraries, link)) = sections.gnu_verneed(file.endian(), file.data())? else {
        return Ok(newest);
    };
    let strings = sections.strings(file.endian(), file.data(), link)?;
    while let Some((_, mut versions)) = libraries.next()? {
        while let Some(version) = versions.next()? {
            newest = newest.max(number(&text(version.name(file.endian(), strings)?)));
        }
    }
    Ok(newest)
}

/// The number in `GLIBC_2.17`.
fn number(name: &str) -> Option<Version> {
    let mut parts = name.strip_prefix("GLIBC_")?.split('.').map(str::parse);
    Some((parts.next()?.ok()?, parts.next()?.ok()?))
}
