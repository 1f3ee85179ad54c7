//! darwin64: one file for both processors of the Mac.
//!
//! On a Mac, Apple's linker makes it; elsewhere LLVM's, with the list of system functions that comes with Zig.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use fat_macho::FatWriter;

use super::recipe::Recipe;
use super::toolchain::{Target, Toolchain};
use super::tools::Tool;
use crate::gates;
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
    let mut universal = FatWriter::new();
    for triple in TRIPLES {
        universal.add(thin(workspace, triple)?).with_context(|| format!("cannot join {triple}"))?;
    }
    let mut bytes = Vec::new();
    universal.write_to(&mut bytes).context("cannot write a universal library")?;
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
    Ok(Toolchain::in_use()?.rust_lld().or_else(|| which::which("ld64.lld").ok()))
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
