//! Requirements that a shared library must meet before it goes into an FMU.

mod elf;
mod exports;
mod facts;
mod mach_o;
mod paths;
mod pe;
mod read;
#[cfg(test)]
mod samples;
mod system;

use std::collections::BTreeSet;

use anyhow::{Result, bail};
use object::Architecture;

use self::facts::Facts;
use crate::platform::Platform;

/// The newest version of glibc that linux64 may need: of 2012, in every Linux still in use.
pub const NEWEST_GLIBC: Version = (2, 17);

/// The oldest macOS that darwin64 is for: the first on both processors.
pub const OLDEST_MACOS: Version = (11, 0);

/// Major and minor.
pub type Version = (u32, u32);

/// Whom a library is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// Every machine of the platform.
    Everybody,
    /// Machines like the one that built it: its processor, its version of the system or newer.
    ThisMachine,
}

/// Checks a library and describes it in a few words.
///
/// `private` are paths of this machine that must not be in it.
///
/// # Errors
/// When the file cannot be read as a shared library, or with everything that is wrong with it.
pub fn check(platform: Platform, reach: Reach, bytes: &[u8], private: &[String]) -> Result<String> {
    let slices = read::read(bytes)?;
    let mut problems = wrong_architectures(platform, reach, &slices);
    for facts in &slices {
        let found = rules(platform, reach, facts);
        problems.extend(found.into_iter().map(|problem| format!("{}: {problem}", name(facts.architecture))));
    }
    problems.extend(paths::problems(bytes, private));
    if !problems.is_empty() {
        bail!("the library for {platform} does not pass:\n  {}", problems.join("\n  "));
    }
    Ok(report(platform, &slices, bytes.len()))
}

/// Checks the compiled part of the Python package and describes it in a few words.
///
/// # Errors
/// When the file cannot be read as a shared library, or with everything that is wrong with it.
pub fn check_module(platform: Platform, processors: &[&str], bytes: &[u8]) -> Result<String> {
    let slices = read::read(bytes)?;
    let found: BTreeSet<_> = slices.iter().map(|facts| name(facts.architecture)).collect();
    let wanted = processors.iter().map(|&processor| processor.to_owned()).collect();
    let mut problems = foreign_processors(&found, &wanted);
    for facts in &slices {
        let found = module_rules(platform, facts);
        problems.extend(found.into_iter().map(|problem| format!("{}: {problem}", name(facts.architecture))));
    }
    if !problems.is_empty() {
        bail!("the module for {platform} does not pass:\n  {}", problems.join("\n  "));
    }
    Ok(report(platform, &slices, bytes.len()))
}

/// Rules for the compiled part of the Python package for one processor: its only export is the entry for the interpreter,
/// and it needs only symbols that every version of Python 3 has.
fn module_rules(platform: Platform, facts: &Facts) -> Vec<String> {
    const ENTRY: &str = "PyInit__native";
    if facts.platform != platform {
        return vec![format!("it is a library for {}", facts.platform)];
    }
    let mut problems = Vec::new();
    if facts.exports != BTreeSet::from([ENTRY.to_owned()]) {
        problems.push(format!("exports {}, not {ENTRY} alone", list(&facts.exports)));
    }
    problems.extend(foreign_libraries(platform, facts, &["python3.dll"]));
    problems.extend(too_new(platform, facts.needs));
    problems.extend(facts.signature.iter().map(|problem| format!("has no valid signature: {problem}")));
    problems
}

/// The names of the processors that a library is for.
///
/// # Errors
/// When the file cannot be read as a shared library.
pub fn architectures(bytes: &[u8]) -> Result<BTreeSet<String>> {
    Ok(read::read(bytes)?.iter().map(|facts| name(facts.architecture)).collect())
}

/// The processors must match the platform.
fn wrong_architectures(platform: Platform, reach: Reach, slices: &[Facts]) -> Vec<String> {
    let found: BTreeSet<_> = slices.iter().map(|facts| name(facts.architecture)).collect();
    let wanted = match (reach, platform) {
        (Reach::ThisMachine, _) => BTreeSet::from([std::env::consts::ARCH.to_owned()]),
        (Reach::Everybody, Platform::Darwin64) => BTreeSet::from(["aarch64".to_owned(), "x86_64".to_owned()]),
        (Reach::Everybody, _) => BTreeSet::from(["x86_64".to_owned()]),
    };
    foreign_processors(&found, &wanted)
}

fn foreign_processors(found: &BTreeSet<String>, wanted: &BTreeSet<String>) -> Vec<String> {
    if found == wanted { vec![] } else { vec![format!("it is for {}, not for {}", list(found), list(wanted))] }
}

/// Libraries that a system may lack, and that nobody else brings.
fn foreign_libraries(platform: Platform, facts: &Facts, brought: &[&str]) -> Option<String> {
    let ours = |library: &&String| system::has(platform, library) || brought.contains(&library.as_str());
    let foreign: BTreeSet<_> = facts.libraries.iter().filter(|library| !ours(library)).cloned().collect();
    (!foreign.is_empty()).then(|| format!("needs libraries that are no part of the system: {}", list(&foreign)))
}

/// Rules for the library for one processor.
fn rules(platform: Platform, reach: Reach, facts: &Facts) -> Vec<String> {
    if facts.platform != platform {
        return vec![format!("it is a library for {}", facts.platform)];
    }
    let mut problems = exports::problems(&facts.exports);
    problems.extend(foreign_libraries(platform, facts, &[]));
    if !facts.debris.is_empty() {
        problems.push(format!("is not stripped: {}", list(&facts.debris)));
    }
    if reach == Reach::Everybody {
        problems.extend(too_new(platform, facts.needs));
    }
    problems.extend(facts.signature.iter().map(|problem| format!("has no valid signature: {problem}")));
    problems
}

fn too_new(platform: Platform, needs: Option<Version>) -> Option<String> {
    match (platform, needs) {
        (Platform::Linux64, Some(needs)) if needs > NEWEST_GLIBC => {
            Some(format!("needs glibc {}, newer than {}", text(needs), text(NEWEST_GLIBC)))
        }
        (Platform::Darwin64, Some(needs)) if needs != OLDEST_MACOS => {
            Some(format!("is for macOS {} and newer, not {}", text(needs), text(OLDEST_MACOS)))
        }
        (Platform::Darwin64, None) => Some("does not say which macOS it is for".to_owned()),
        _ => None,
    }
}

fn report(platform: Platform, slices: &[Facts], size: usize) -> String {
    let architectures: BTreeSet<_> = slices.iter().map(|facts| name(facts.architecture)).collect();
    let mut words = vec![format!("{} KiB", size.div_ceil(1024)), list(&architectures)];
    if let Some(needs) = slices.iter().filter_map(|facts| facts.needs).max() {
        let system = if platform == Platform::Darwin64 { "macOS" } else { "glibc" };
        words.push(format!("{system} {} and newer", text(needs)));
    }
    let libraries: BTreeSet<_> = slices.iter().flat_map(|facts| facts.libraries.iter().cloned()).collect();
    words.push(format!("needs {}", list(&libraries)));
    words.join("; ")
}

fn list(names: &BTreeSet<String>) -> String {
    names.iter().map(String::as_str).collect::<Vec<_>>().join(", ")
}

fn name(architecture: Architecture) -> String {
    match architecture {
        Architecture::X86_64 => "x86_64".to_owned(),
        Architecture::Aarch64 => "aarch64".to_owned(),
        other => format!("{other:?}"),
    }
}

fn text((major, minor): Version) -> String {
    format!("{major}.{minor}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn good(platform: Platform) -> Facts {
        Facts {
            platform,
            architecture: Architecture::X86_64,
            exports: exports::standard(),
            libraries: BTreeSet::new(),
            debris: BTreeSet::new(),
            needs: match platform {
                Platform::Linux64 => Some(NEWEST_GLIBC),
                Platform::Win64 => None,
                Platform::Darwin64 => Some(OLDEST_MACOS),
            },
            signature: None,
        }
    }

    /// The one problem that a change of a good library makes.
    fn problem(platform: Platform, change: impl FnOnce(&mut Facts)) -> String {
        let mut facts = good(platform);
        change(&mut facts);
        let problems = rules(platform, Reach::Everybody, &facts);
        assert_eq!(problems.len(), 1, "{problems:?}");
        problems[0].clone()
    }

    #[test]
    fn good_libraries_pass() {
        for platform in Platform::ALL {
            assert_eq!(rules(platform, Reach::Everybody, &good(platform)), Vec::<String>::new());
        }
    }

    #[test]
    fn a_library_for_another_platform_is_refused() {
        assert_eq!(problem(Platform::Win64, |facts| facts.platform = Platform::Linux64), "it is a library for linux64");
    }

    #[test]
    fn libraries_that_users_may_lack_are_refused() {
        let needs = |platform, library: &str| problem(platform, |facts| facts.libraries = [library.to_owned()].into());
        assert!(needs(Platform::Linux64, "libssl.so.3").ends_with("no part of the system: libssl.so.3"));
        assert!(needs(Platform::Win64, "libgcc_s_seh-1.dll").ends_with("libgcc_s_seh-1.dll"));
        assert!(needs(Platform::Win64, "VCRUNTIME140.dll").ends_with("VCRUNTIME140.dll"));
        assert!(needs(Platform::Darwin64, "@rpath/libc++.1.dylib").ends_with("@rpath/libc++.1.dylib"));
    }

    #[test]
    fn a_library_for_newer_systems_is_refused() {
        let needs = |platform, version| problem(platform, |facts| facts.needs = version);
        assert_eq!(needs(Platform::Linux64, Some((2, 18))), "needs glibc 2.18, newer than 2.17");
        assert_eq!(needs(Platform::Darwin64, Some((12, 0))), "is for macOS 12.0 and newer, not 11.0");
        assert_eq!(needs(Platform::Darwin64, None), "does not say which macOS it is for");
        let mut facts = good(Platform::Linux64);
        facts.needs = Some((2, 35));
        assert_eq!(rules(Platform::Linux64, Reach::ThisMachine, &facts), Vec::<String>::new());
    }

    #[test]
    fn remains_of_symbols_and_of_signatures_are_refused() {
        let debris = |facts: &mut Facts| facts.debris = [".symtab".to_owned()].into();
        assert_eq!(problem(Platform::Linux64, debris), "is not stripped: .symtab");
        let signature = |facts: &mut Facts| facts.signature = Some("there is none".to_owned());
        assert_eq!(problem(Platform::Darwin64, signature), "has no valid signature: there is none");
    }

    #[test]
    fn a_module_shows_its_entry_alone_and_may_need_the_interpreter() {
        let mut module = good(Platform::Win64);
        module.exports = ["PyInit__native".to_owned()].into();
        module.libraries = ["python3.dll".to_owned(), "KERNEL32.dll".to_owned()].into();
        assert_eq!(module_rules(Platform::Win64, &module), Vec::<String>::new());
        // The library of one version of Python.
        module.libraries.insert("python311.dll".to_owned());
        module.exports.insert("rust_eh_personality".to_owned());
        let problems = module_rules(Platform::Win64, &module);
        assert_eq!(problems.len(), 2, "{problems:?}");
        assert_eq!(problems[0], "exports PyInit__native, rust_eh_personality, not PyInit__native alone");
        assert!(problems[1].ends_with("no part of the system: python311.dll"), "{problems:?}");
        assert_eq!(module_rules(Platform::Linux64, &module), ["it is a library for win64"]);
    }

    #[test]
    fn the_mac_needs_both_processors() {
        let intel = good(Platform::Darwin64);
        let problems = wrong_architectures(Platform::Darwin64, Reach::Everybody, &[intel]);
        assert_eq!(problems, ["it is for x86_64, not for aarch64, x86_64"]);
        let arm = Facts { architecture: Architecture::Aarch64, ..good(Platform::Darwin64) };
        assert!(wrong_architectures(Platform::Darwin64, Reach::Everybody, &[arm, good(Platform::Darwin64)]).is_empty());
    }

    /// The required system is the newest that a processor's slice requires, called by its name.
    #[test]
    fn report_says_the_processors_and_the_oldest_system() {
        let other = Facts { architecture: Architecture::Aarch64, needs: Some((11, 3)), ..good(Platform::Darwin64) };
        let mac = [Facts { needs: Some((11, 1)), ..good(Platform::Darwin64) }, other];
        assert_eq!(report(Platform::Darwin64, &mac, 1025), "2 KiB; aarch64, x86_64; macOS 11.3 and newer; needs ");
        let mut linux = Facts { needs: Some((2, 17)), ..good(Platform::Linux64) };
        linux.libraries.insert("libc.so.6".to_owned());
        let text = report(Platform::Linux64, &[linux], 1024);
        assert_eq!(text, "1 KiB; x86_64; glibc 2.17 and newer; needs libc.so.6");
    }

    fn facts(library: &[u8]) -> Result<Facts> {
        let mut slices = read::read(library)?;
        assert_eq!(slices.len(), 1, "{slices:?}");
        Ok(slices.remove(0))
    }

    #[test]
    fn a_library_of_the_mac_says_which_system_it_is_for() -> Result<()> {
        let needs = |platform| Ok::<_, anyhow::Error>(facts(&samples::mac(samples::INTEL, platform, true))?.needs);
        assert_eq!(needs(samples::MACOS)?, Some((11, 3)));
        assert_eq!(needs(samples::IOS)?, None);
        Ok(())
    }

    #[test]
    fn a_signature_holds_while_no_byte_changes() -> Result<()> {
        let signature = |library: &[u8]| Ok::<_, anyhow::Error>(facts(library)?.signature);
        let mut library = samples::mac(samples::ARM, samples::MACOS, true);
        assert_eq!(signature(&library)?, None);
        library[5000] ^= 1;
        assert_eq!(signature(&library)?.as_deref(), Some("page 1 was changed after signing"));
        assert_eq!(signature(&samples::mac(samples::ARM, samples::MACOS, false))?.as_deref(), Some("there is none"));
        Ok(())
    }

    #[test]
    fn a_module_for_both_processors_of_the_mac_is_read_as_two() -> Result<()> {
        let both =
            [samples::ARM, samples::INTEL].map(|processor| (processor, samples::mac(processor, samples::MACOS, true)));
        let module = samples::universal(both);
        let slices = read::read(&module)?;
        let processors: Vec<_> = slices.iter().map(|facts| facts.architecture).collect();
        assert_eq!(processors, [Architecture::Aarch64, Architecture::X86_64]);
        assert!(slices.iter().all(|facts| facts.exports.iter().eq(["PyInit__native"])), "{slices:?}");
        // Both are for a newer system than the package.
        let problem = check_module(Platform::Darwin64, &["aarch64", "x86_64"], &module).map_err(|it| it.to_string());
        let expected = "the module for darwin64 does not pass:\n  \
                        aarch64: is for macOS 11.3 and newer, not 11.0\n  \
                        x86_64: is for macOS 11.3 and newer, not 11.0";
        assert_eq!(problem, Err(expected.to_owned()));
        Ok(())
    }

    #[test]
    fn symbols_and_debugging_information_of_windows_are_seen() -> Result<()> {
        let debris = |symbols, size| Ok::<_, anyhow::Error>(facts(&samples::windows(symbols, size))?.debris);
        assert_eq!(debris(0, 0)?, BTreeSet::new());
        assert_eq!(debris(0, 28)?, BTreeSet::from(["debug directory".to_owned()]));
        assert_eq!(debris(1, 0)?, BTreeSet::from(["symbol table".to_owned()]));
        Ok(())
    }

    /// Symbols that the library defines and does not show are remains; those that it shows or needs are not.
    #[test]
    fn local_symbols_of_the_mac_are_seen() -> Result<()> {
        let (shown, local, needed) = (0x0f, 0x0e, 0x01);
        let debris = |types: &[u8]| Ok::<_, anyhow::Error>(facts(&samples::mac_with_symbols(types))?.debris);
        assert_eq!(debris(&[shown, needed])?, BTreeSet::new());
        assert_eq!(debris(&[shown, local, needed])?, BTreeSet::from(["local symbols".to_owned()]));
        Ok(())
    }

    #[test]
    fn format_says_the_platform() -> Result<()> {
        assert_eq!(facts(&samples::windows(0, 0))?.platform, Platform::Win64);
        assert_eq!(facts(&samples::mac(samples::ARM, samples::MACOS, true))?.platform, Platform::Darwin64);
        Ok(())
    }
}
