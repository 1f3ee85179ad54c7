//! Building the shared library: quickly for this machine, or for everybody who has a platform.

pub mod aarch64;
mod linux;
mod macos;
mod recipe;
pub mod toolchain;
pub mod wasm;
mod windows;

use anyhow::Result;

use self::recipe::Recipe;
use self::toolchain::Toolchain;
use crate::platform::Platform;
use crate::tools::Tool;
use crate::workspace::Workspace;

/// The tools that the library of a platform needs and this machine lacks.
///
/// # Errors
/// When the Rust compiler in use does not answer.
pub fn missing(platform: Platform) -> Result<Vec<Tool>> {
    match platform {
        Platform::Linux64 => linux::missing(),
        Platform::Win64 => windows::missing(),
        Platform::Darwin64 => macos::missing(),
    }
}

/// The library that Cargo builds when nothing is asked of it but the machine it runs on.
///
/// # Errors
/// When Cargo fails.
pub fn for_this_machine(workspace: &Workspace) -> Result<Vec<u8>> {
    Recipe::of_the_user(workspace, Toolchain::in_use()?).run()
}

/// The library for every machine of a platform.
///
/// # Errors
/// When a step of the build fails.
pub fn for_everybody(workspace: &Workspace, platform: Platform) -> Result<Vec<u8>> {
    match platform {
        Platform::Linux64 => linux::build(workspace),
        Platform::Win64 => windows::build(workspace),
        Platform::Darwin64 => macos::build(workspace),
    }
}

#[cfg(test)]
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::files;
    use crate::stand_in::{self, Answer, StandIn, Started};

    const MAC: [&str; 2] = ["x86_64-apple-darwin", "aarch64-apple-darwin"];
    const LINUX: &str = "x86_64-unknown-linux-gnu";
    const WINDOWS: &str = "x86_64-pc-windows-gnu";
    const ARM: &str = "aarch64-unknown-linux-gnu";

    /// A machine with standard libraries for some targets, without some programs, whose libraries have two words before what
    /// Cargo was told, and whose Zig knows the Mac.
    fn machine(folder: &std::path::Path, targets: &[&str], lacking: &[&'static str]) -> StandIn {
        let (library, zig) = (folder.join("built.so"), folder.join("ziglang"));
        for name in ["SDKSettings.json", "libSystem.tbd"] {
            stand_in::writes(zig.join("lib/libc/darwin").join(name), name);
        }
        let machine = StandIn::new(move |command| {
            if command.line().contains("import ziglang") {
                return Some(Answer::Prints(zig.display().to_string()));
            }
            command.says("rustc --release").then(|| {
                stand_in::writes(&library, format!("magicintel{}", command.after("--target")));
                stand_in::built(command, &library)
            })
        });
        let machine = machine.compiling_for(&folder.join("sysroot"), targets);
        lacking.iter().fold(machine, |machine, program| machine.lacking(program))
    }

    /// The libraries that are built with Cargo, and what Cargo is told for each.
    fn built(
        name: &str,
        targets: &[&str],
        build: impl FnOnce(&Workspace) -> Result<Vec<u8>> + Send,
    ) -> Result<(PathBuf, Vec<u8>, Vec<Started>)> {
        let folder = files::scratch(name);
        let workspace = Workspace::of_a_test(&folder);
        let (bytes, started) = machine(&folder, targets, &[]).does(|| build(&workspace));
        let builds = started.into_iter().filter(|it| it.says("rustc --release")).collect();
        Ok((folder, bytes?, builds))
    }

    /// A standard library, and what links.
    #[test]
    fn what_a_platform_lacks_is_named() -> Result<()> {
        let folder = files::scratch("build-missing");
        type Ask = fn() -> Result<Vec<Tool>>;
        let asks: [(Ask, &[&str], &[&'static str], usize); 4] = [
            (|| missing(Platform::Linux64), &[LINUX], &["python3", "python"], 1),
            (|| missing(Platform::Win64), &[WINDOWS], &["x86_64-w64-mingw32-gcc"], 1),
            (|| missing(Platform::Darwin64), &MAC, &["ld64.lld"], 2),
            (aarch64::missing, &[ARM], &["aarch64-linux-gnu-gcc"], 1),
        ];
        for (place, (ask, targets, lacking, libraries)) in asks.into_iter().enumerate() {
            let (with, without) = (folder.join(format!("{place}-with")), folder.join(format!("{place}-without")));
            let names = |machine: StandIn| {
                Ok::<_, anyhow::Error>(machine.does(ask).0?.into_iter().map(|it| it.name).collect::<Vec<_>>())
            };
            assert_eq!(names(machine(&with, targets, &[]))?, Vec::<String>::new());
            let tool = names(machine(&with, targets, lacking))?;
            assert!(tool.len() == 1 && !tool[0].contains("standard library"), "{tool:?}");
            let library = names(machine(&without, &[], &[]))?;
            assert!(
                library.len() == libraries && library.iter().all(|it| it.contains("standard library")),
                "{library:?}"
            );
        }
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// By Zig against an old glibc, by MinGW without the time of day, by the linker of Arm.
    #[test]
    fn libraries_are_linked_for_their_platform() -> Result<()> {
        let (folder, bytes, started) = built("build-linux", &[LINUX], |it| for_everybody(it, Platform::Linux64))?;
        assert!(
            bytes.ends_with(b"x86_64-unknown-linux-gnu.2.17") && started[0].line().starts_with("cargo-zigbuild rustc ")
        );
        assert!(started[0].variable("PATH").starts_with(&folder.display().to_string()), "{started:?}");
        std::fs::remove_dir_all(&folder)?;
        let (folder, bytes, started) = built("build-windows", &[WINDOWS], |it| for_everybody(it, Platform::Win64))?;
        assert!(bytes.ends_with(WINDOWS.as_bytes()));
        assert_eq!(started[0].variable("CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER"), "x86_64-w64-mingw32-gcc");
        assert!(started[0].variable("CARGO_ENCODED_RUSTFLAGS").contains("--no-insert-timestamp"), "{started:?}");
        std::fs::remove_dir_all(&folder)?;
        let (folder, bytes, started) = built("build-arm", &[ARM], aarch64::build)?;
        assert!(bytes.ends_with(ARM.as_bytes()));
        assert_eq!(started[0].variable("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER"), aarch64::COMPILER);
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// Two libraries, each signed by its linker, in one file; the list of system functions is that of Zig.
    #[test]
    fn library_of_the_mac_is_for_both_processors() -> Result<()> {
        let (folder, bytes, started) = built("build-mac", &MAC, |it| for_everybody(it, Platform::Darwin64))?;
        assert_eq!(started.iter().map(|it| it.after("--target")).collect::<Vec<_>>(), MAC);
        for command in &started {
            let flags = command.variable("CARGO_ENCODED_RUSTFLAGS");
            assert!(flags.contains("-adhoc_codesign") && command.says("profile.release.strip='none'"), "{command:?}");
            assert_eq!(command.variable("MACOSX_DEPLOYMENT_TARGET"), "11.0");
            let sdk = PathBuf::from(command.variable("SDKROOT"));
            assert_eq!(files::text(sdk.join("usr/lib/libm.tbd"))?, "libSystem.tbd");
            assert!(sdk.join("SDKSettings.json").is_file() && sdk.starts_with(&folder));
        }
        assert_eq!(started[0].variable("CARGO_TARGET_X86_64_APPLE_DARWIN_LINKER"), "/machine/first/ld64.lld");
        let [intel, arm] = MAC.map(|triple| bytes.windows(triple.len()).position(|part| part == triple.as_bytes()));
        assert!(bytes.starts_with(&[0xca, 0xfe, 0xba, 0xbe]) && intel < arm && intel.is_some());
        Ok(std::fs::remove_dir_all(&folder)?)
    }
}
