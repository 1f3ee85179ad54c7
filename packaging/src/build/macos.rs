//! darwin64: one file for both processors of the Mac.
//!
//! On a Mac, Apple's linker makes it; elsewhere LLVM's, with the list of system functions that comes with Zig.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use object::macho::FAT_MAGIC;

use super::recipe::Recipe;
use super::toolchain::{Target, Toolchain};
use crate::gates;
use crate::process;
use crate::tools::Tool;
use crate::venv::{self, Requirements, Venv};
use crate::workspace::Workspace;

const TRIPLES: [&str; 2] = ["x86_64-apple-darwin", "aarch64-apple-darwin"];

/// Two standard libraries and, off the Mac, a linker and Zig from PyPI.
pub fn missing() -> Result<Vec<Tool>> {
    let mut missing = Vec::new();
    for triple in TRIPLES {
        missing.extend(Target::find(triple, triple)?.missing());
    }
    if !cfg!(target_os = "macos") {
        missing.extend(venv::missing());
        if linker()?.is_none() {
            missing.push(Tool::new("rust-lld or ld64.lld", "a toolchain of rustup has it; or apt install lld"));
        }
    }
    Ok(missing)
}

/// Builds the library for both processors and joins them.
pub fn build(workspace: &Workspace) -> Result<Vec<u8>> {
    let libraries = TRIPLES.into_iter().map(|triple| thin(workspace, triple)).collect::<Result<Vec<_>>>()?;
    universal(&libraries).context("cannot join the libraries of both processors")
}

/// The libraries in one file, each at a page of its own, behind a list that says for which processor it is and where.
fn universal(libraries: &[Vec<u8>]) -> Result<Vec<u8>> {
    /// The largest page of either processor, as a power of 2.
    const PAGE: u32 = 14;
    const WORD: usize = size_of::<u32>();
    let mut list = vec![FAT_MAGIC, u32::try_from(libraries.len())?];
    let mut bytes = vec![0; WORD * (list.len() + 5 * libraries.len())];
    for library in libraries {
        let [processor, model] = [1, 2].map(|place| library.get(place * WORD..(place + 1) * WORD));
        let word =
            |bytes: Option<&[u8]>| Ok::<_, anyhow::Error>(u32::from_le_bytes(bytes.context("no library")?.try_into()?));
        bytes.resize(bytes.len().next_multiple_of(1 << PAGE), 0);
        list.extend([word(processor)?, word(model)?, u32::try_from(bytes.len())?, u32::try_from(library.len())?, PAGE]);
        bytes.extend(library);
    }
    // The list is big-endian for every processor.
    for (slot, word) in bytes.chunks_exact_mut(WORD).zip(list) {
        slot.copy_from_slice(&word.to_be_bytes());
    }
    Ok(bytes)
}

fn thin(workspace: &Workspace, triple: &'static str) -> Result<Vec<u8>> {
    let (toolchain, triple) = Target::find(triple, triple)?.found()?;
    let (major, minor) = gates::OLDEST_MACOS;
    // A library that is stripped after it was signed has no valid signature, so the linker does both.
    let mut recipe = Recipe::for_target(workspace, toolchain, triple)
        .stripped_by_linker()
        .variable("MACOSX_DEPLOYMENT_TARGET", format!("{major}.{minor}"));
    let arguments = ["-x", "-S", "-adhoc_codesign", "-install_name", "@rpath/pneumatic_servo_fmu.dylib"];
    if cfg!(target_os = "macos") {
        let joined = format!("-Wl,{}", arguments.join(","));
        return recipe.link(&joined).run();
    }
    for argument in arguments {
        recipe = recipe.link(argument);
    }
    let linker = linker()?.context("no linker for macOS was found")?;
    recipe.flag("-Clinker-flavor=ld64.lld").linker(triple, linker).variable("SDKROOT", sdk(workspace)?).run()
}

fn linker() -> Result<Option<PathBuf>> {
    Ok(Toolchain::in_use()?.rust_lld().or_else(|| process::find("ld64.lld")))
}

/// A folder in the form of Apple's SDK with the one thing that is needed of it.
fn sdk(workspace: &Workspace) -> Result<PathBuf> {
    let zig = Venv::prepare(workspace, Requirements::ZIG)?.module("ziglang")?.join("lib/libc/darwin");
    let sdk = workspace.target.join("macos-sdk");
    let libraries = sdk.join("usr/lib");
    std::fs::create_dir_all(&libraries).with_context(|| format!("cannot make {}", libraries.display()))?;
    copy(&zig.join("SDKSettings.json"), &sdk.join("SDKSettings.json"))?;
    // The C library and the mathematical one are parts of libSystem.
    for name in ["libSystem.tbd", "libc.tbd", "libm.tbd"] {
        copy(&zig.join("libSystem.tbd"), &libraries.join(name))?;
    }
    Ok(sdk)
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    std::fs::copy(from, to).with_context(|| format!("cannot copy {} to {}", from.display(), to.display()))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use object::read::macho::{FatArch, MachOFatFile32};
    use object::{Architecture, Object};

    use super::*;

    /// A header without any commands: magic number, processor and its model, kind of file, sizes and flags.
    fn library(processor: u32, model: u32, length: usize) -> Vec<u8> {
        let words = [0xfeed_facf, processor, model, 6, 0, 0, 0, 0];
        let mut bytes: Vec<u8> = words.into_iter().flat_map(u32::to_le_bytes).collect();
        bytes.resize(length, 7);
        bytes
    }

    #[test]
    fn joined_libraries_are_found_again_each_at_a_page_of_its_own() -> Result<()> {
        let libraries = [library(0x0100_0007, 3, 20_000), library(0x0100_000c, 0, 33)];
        let bytes = universal(&libraries)?;
        let file = MachOFatFile32::parse(&*bytes)?;
        let found: Vec<_> = file.arches().iter().map(|arch| (arch.architecture(), arch.data(&*bytes))).collect();
        assert_eq!(found, [(Architecture::X86_64, Ok(&*libraries[0])), (Architecture::Aarch64, Ok(&*libraries[1]))]);
        assert!(file.arches().iter().all(|arch| arch.offset.get(object::BigEndian) % (1 << 14) == 0));
        assert_eq!(object::File::parse(found[0].1?)?.architecture(), Architecture::X86_64);
        Ok(())
    }

    #[test]
    fn what_has_no_header_is_refused() {
        assert!(universal(&[vec![0; 5]]).is_err());
    }
}
