//! Facts about a library of Linux.

use anyhow::Result;
use object::elf::{DT_NEEDED, SHT_SYMTAB};
use object::read::elf::{ElfFile64, SectionHeader};

use super::Version;
use super::facts::{Facts, text};
use crate::platform::Platform;

/// Completes what is common to all formats.
pub fn facts(file: &ElfFile64<'_>, common: Facts) -> Result<Facts> {
    let mut facts = Facts { platform: Platform::Linux64, needs: glibc(file)?, ..common };
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

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::path::PathBuf;
    use std::process::Command;

    use anyhow::{Context, ensure};

    use super::super::facts::read;
    use super::super::{Reach, check, exports};
    use super::*;

    /// A library with all functions of FMI and something more, linked with some flags of GCC.
    fn library(name: &str, more: &str, flags: &[&str]) -> Result<Vec<u8>> {
        let folder: PathBuf = std::env::temp_dir().join(format!("gate-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder)?;
        let (source, library) = (folder.join("library.c"), folder.join("library.so"));
        let functions: String =
            exports::standard().iter().map(|name| format!("int {name}(void) {{ return 0; }}\n")).collect();
        std::fs::write(&source, functions + more)?;
        let mut gcc = Command::new("gcc");
        gcc.args(["-shared", "-fPIC", "-nostdlib", "-x", "c", "-o"]).arg(&library).arg("library.c").args(flags);
        let status = gcc.current_dir(&folder).status().context("gcc was not found")?;
        ensure!(status.success(), "gcc failed");
        let bytes = std::fs::read(&library)?;
        std::fs::remove_dir_all(&folder)?;
        Ok(bytes)
    }

    /// What the gates say of it.
    fn verdict(name: &str, more: &str, flags: &[&str]) -> Result<String> {
        let checked = check(Platform::Linux64, Reach::ThisMachine, &library(name, more, flags)?, &[]);
        Ok(checked.unwrap_or_else(|problem| problem.to_string()))
    }

    #[test]
    fn a_plain_library_passes() -> Result<()> {
        let verdict = verdict("plain", "", &["-s"])?;
        assert!(verdict.contains(&format!("KiB; {}", std::env::consts::ARCH)), "{verdict}");
        Ok(())
    }

    #[test]
    fn symbols_and_debugging_information_are_seen() -> Result<()> {
        assert!(verdict("symbols", "", &[])?.contains("is not stripped: .symtab"));
        assert!(verdict("debug", "", &["-g"])?.contains(".debug_info"));
        Ok(())
    }

    #[test]
    fn foreign_exports_are_seen() -> Result<()> {
        let verdict = verdict("export", "int helper(void) { return 1; }", &["-s"])?;
        assert!(verdict.contains("no functions of FMI: helper"), "{verdict}");
        Ok(())
    }

    #[test]
    fn build_paths_are_seen() -> Result<()> {
        let verdict = verdict("path", "__attribute__((used)) static char path[] = \"/home/ann/lib.c\";", &["-s"])?;
        assert!(verdict.contains("holds a build path: /home/ann/lib.c"), "{verdict}");
        Ok(())
    }

    #[test]
    fn libraries_are_seen() -> Result<()> {
        let verdict = verdict("library", "", &["-s", "-Wl,--no-as-needed", "-lresolv"])?;
        assert!(verdict.contains("no part of the system: libresolv.so.2"), "{verdict}");
        Ok(())
    }

    #[test]
    fn the_version_of_glibc_is_seen() -> Result<()> {
        // `getrandom` came with glibc 2.25.
        let more = "long getrandom(void*, unsigned long, unsigned); long fmi2(void) { return getrandom(0, 0, 0); }";
        let bytes = library("glibc", more, &["-s", "-lc"])?;
        let facts = read(&bytes)?;
        assert!(facts[0].needs >= Some((2, 25)), "{facts:?}");
        assert!(facts[0].libraries.contains("libc.so.6"), "{facts:?}");
        let problem = check(Platform::Linux64, Reach::Everybody, &bytes, &[]).unwrap_err().to_string();
        assert!(problem.contains("needs glibc 2.25, newer than 2.17"), "{problem}");
        Ok(())
    }
}
