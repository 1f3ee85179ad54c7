//! win64: linked by MinGW-w64, or on Windows by Microsoft's linker.

use anyhow::Result;

use super::recipe::Recipe;
use super::toolchain::Target;
use crate::tools::Tool;
use crate::workspace::Workspace;

const LINKER: &str = "x86_64-w64-mingw32-gcc";

/// A standard library and a linker.
pub fn missing() -> Result<Vec<Tool>> {
    let linker = if cfg!(windows) { None } else { Tool::unless_found(LINKER, "gcc-mingw-w64-x86-64-posix") };
    Ok(target()?.missing().into_iter().chain(linker).collect())
}

/// Builds the library.
pub fn build(workspace: &Workspace) -> Result<Vec<u8>> {
    let (toolchain, triple) = target()?.found()?;
    let recipe = Recipe::for_target(workspace, toolchain, triple);
    if cfg!(windows) {
        // The C runtime of Microsoft's compiler is no part of Windows.
        return recipe.flag("-Ctarget-feature=+crt-static").link("/Brepro").link("/DEBUG:NONE").run();
    }
    recipe.linker(triple, LINKER).link("-Wl,--no-insert-timestamp").run()
}

fn target() -> Result<Target> {
    if cfg!(windows) {
        return Target::find("x86_64-pc-windows-msvc", "x86_64-pc-windows-msvc");
    }
    // Where the choice is free, the library also runs on Windows 7 and in Wine 8.
    Target::find("x86_64-pc-windows-gnu", "x86_64-win7-windows-gnu")
}
