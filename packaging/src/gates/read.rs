//! Facts of a shared library of any format.

use std::collections::BTreeSet;

use anyhow::{Context, Result, bail};
use object::read::macho::{FatArch, MachOFatFile32};
use object::{File, FileKind, Object, ObjectSection};

use super::facts::{Facts, text};
use super::{elf, mach_o, pe};
use crate::platform::Platform;

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
    let (architecture, exports, debris) = (file.architecture(), exports(&file)?, debugging(&file));
    let libraries = BTreeSet::new();
    let common = |platform| Facts { platform, architecture, exports, libraries, debris, needs: None, signature: None };
    match &file {
        File::Elf64(elf) => elf::facts(elf, common(Platform::Linux64)).context("damaged ELF file"),
        File::Pe64(pe) => pe::facts(pe, common(Platform::Win64)).context("damaged PE file"),
        File::MachO64(mach_o) => {
            mach_o::facts(mach_o, bytes, common(Platform::Darwin64)).context("damaged Mach-O file")
        }
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

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::path::PathBuf;
    use std::process::Command;

    use anyhow::ensure;

    use super::super::{Reach, check, exports};
    use super::*;

    /// A library with all functions of FMI and something more, linked with some flags of GCC.
    fn library(name: &str, more: &str, flags: &[&str]) -> Result<Vec<u8>> {
        let folder: PathBuf = crate::files::scratch(&format!("gate-{name}"));
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

    /// Verdict of the gates.
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

    #[test]
    fn processors_of_a_library_are_named() -> Result<()> {
        let found = super::super::architectures(&library("processors", "", &["-s"])?)?;
        assert_eq!(found.into_iter().collect::<Vec<_>>(), [std::env::consts::ARCH]);
        assert!(super::super::architectures(b"no library").is_err());
        Ok(())
    }
}
