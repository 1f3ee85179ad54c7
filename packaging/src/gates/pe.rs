//! Facts about a library of Windows.

use anyhow::Result;
use object::LittleEndian as LE;
use object::pe::IMAGE_DIRECTORY_ENTRY_DEBUG;
use object::read::pe::{ImageNtHeaders, PeFile64};

use super::facts::{Facts, text};

/// Completes the facts that all formats share.
pub fn facts(file: &PeFile64<'_>, common: Facts) -> Result<Facts> {
    let mut facts = common;
    if let Some(table) = file.import_table()? {
        let mut libraries = table.descriptors()?;
        while let Some(library) = libraries.next()? {
            facts.libraries.insert(text(table.name(library.name.get(LE))?));
        }
    }
    if let Some(table) = file.delay_load_import_table()? {
        let mut libraries = table.descriptors()?;
        while let Some(library) = libraries.next()? {
            facts.libraries.insert(text(table.name(library.dll_name_rva.get(LE))?));
        }
    }
    if file.nt_headers().file_header().number_of_symbols.get(LE) > 0 {
        facts.debris.insert("symbol table".to_owned());
    }
    // This directory would name the file with the debugging information.
    if file.data_directory(IMAGE_DIRECTORY_ENTRY_DEBUG).is_some_and(|directory| directory.size.get(LE) > 0) {
        facts.debris.insert("debug directory".to_owned());
    }
    Ok(facts)
}
