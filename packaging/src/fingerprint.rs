//! A fingerprint of the source that a library is built from, for crates outside the project.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result};
use cargo_metadata::{Metadata, MetadataCommand, Package, TargetKind};
use sha2::{Digest, Sha256};

use crate::files;
use crate::process;

/// The fingerprint of a package with all that it depends on: of packages on this machine the manifest, the build script and
/// what lies beside and below the root of the library, and of all others what `Cargo.lock` says. It does not depend on where
/// the packages lie, nor on line ends.
///
/// # Errors
/// When Cargo does not know the package or a file cannot be read.
pub fn of(package: &Path) -> Result<String> {
    let mut command = MetadataCommand::new();
    let metadata = process::metadata(command.manifest_path(package.join("Cargo.toml")))?;
    let mut files = BTreeMap::new();
    for package in local(&metadata, &package.join("Cargo.toml"))? {
        add(package, &mut files)?;
    }
    let lock = metadata.workspace_root.join("Cargo.lock");
    files.insert("Cargo.lock".to_owned(), read(lock.as_std_path())?);
    let mut hash = Sha256::new();
    for (name, text) in &files {
        hash.update((name.len() as u64).to_le_bytes());
        hash.update(name);
        hash.update((text.len() as u64).to_le_bytes());
        hash.update(text);
    }
    let digits = hash.finalize().iter().take(16).fold(String::new(), |mut digits, byte| {
        let _ = write!(digits, "{byte:02x}");
        digits
    });
    Ok(digits)
}

/// The package of a manifest and the packages on this machine that it depends on, but for its tests.
fn local<'a>(metadata: &'a Metadata, manifest: &Path) -> Result<Vec<&'a Package>> {
    let manifest = std::fs::canonicalize(manifest).with_context(|| format!("cannot find {}", manifest.display()))?;
    let is_wanted = |package: &&Package| std::fs::canonicalize(&package.manifest_path).is_ok_and(|it| it == manifest);
    let first = metadata.packages.iter().find(is_wanted);
    let mut found = vec![first.with_context(|| format!("{} is no package", manifest.display()))?];
    let resolve = metadata.resolve.as_ref().context("cargo metadata resolves nothing")?;
    let mut next = 0;
    while next < found.len() {
        let node = resolve.nodes.iter().find(|node| node.id == found[next].id).context("an unresolved package")?;
        for dependency in &node.deps {
            let package = &metadata[&dependency.pkg];
            let is_linked =
                dependency.dep_kinds.iter().any(|it| it.kind != cargo_metadata::DependencyKind::Development);
            if is_linked && package.source.is_none() && !found.iter().any(|known| known.id == package.id) {
                found.push(package);
            }
        }
        next += 1;
    }
    Ok(found)
}

/// Adds the files of a package, by the name of the package and their path in it.
fn add(package: &Package, files: &mut BTreeMap<String, Vec<u8>>) -> Result<()> {
    let name = &package.name;
    files.insert(format!("{name}/Cargo.toml"), read(package.manifest_path.as_std_path())?);
    for target in &package.targets {
        let source = target.src_path.as_std_path();
        if target.kind.contains(&TargetKind::CustomBuild) {
            files.insert(format!("{name}/build.rs"), read(source)?);
        } else if !target.kind.iter().any(is_beside) {
            let folder = source.parent().context("a source without a folder")?;
            collect(folder, &format!("{name}/src"), files)?;
        }
    }
    Ok(())
}

/// Whether a target is no part of the library.
fn is_beside(kind: &TargetKind) -> bool {
    matches!(kind, TargetKind::Bin | TargetKind::Example | TargetKind::Test | TargetKind::Bench)
}

fn collect(folder: &Path, prefix: &str, files: &mut BTreeMap<String, Vec<u8>>) -> Result<()> {
    for entry in std::fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))? {
        let entry = entry?;
        let name = entry.file_name().into_string().ok();
        let name = name.with_context(|| format!("{} holds a name that is no text", folder.display()))?;
        // Files of editors and of the operating system do not count.
        if name.starts_with('.') || name.ends_with('~') {
            continue;
        }
        let (file, path) = (entry.path(), format!("{prefix}/{name}"));
        if file.is_dir() {
            collect(&file, &path, files)?;
        } else {
            files.insert(path, read(&file)?);
        }
    }
    Ok(())
}

/// The bytes of a file, with line ends that do not depend on the platform.
fn read(file: &Path) -> Result<Vec<u8>> {
    let bytes = files::read(file)?;
    let mut kept = Vec::with_capacity(bytes.len());
    for (index, byte) in bytes.iter().enumerate() {
        if !(*byte == b'\r' && bytes.get(index + 1) == Some(&b'\n')) {
            kept.push(*byte);
        }
    }
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A package that depends on another beside it.
    fn make(folder: &Path, law: &str) -> Result<()> {
        let manifest = |name: &str, more: &str| {
            format!("[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n[workspace]\n{more}")
        };
        let needs =
            "[dependencies]\nlaw = { path = \"../law\" }\n[dev-dependencies]\nbench = { path = \"../bench\" }\n";
        for (file, text) in [
            ("plant/Cargo.toml", &*manifest("plant", needs)),
            ("plant/src/lib.rs", ""),
            ("law/Cargo.toml", &manifest("law", "")),
            ("law/src/lib.rs", law),
            ("law/tests/law.rs", ""),
            ("bench/Cargo.toml", &manifest("bench", "")),
            ("bench/src/lib.rs", ""),
        ] {
            crate::files::write(&folder.join(file), text)?;
        }
        Ok(())
    }

    #[test]
    fn it_follows_the_source_of_what_is_linked_and_nothing_else() -> Result<()> {
        let folder = files::scratch("fingerprint");
        make(&folder.join("a"), "// one\n")?;
        make(&folder.join("b"), "// one\r\n")?;
        let of = |place: &str| super::of(&folder.join(place).join("plant"));
        let first = of("a")?;
        assert_eq!(first.len(), 32);
        assert_eq!(first, of("b")?, "the place and the line ends count");
        crate::files::write(&folder.join("a/law/tests/law.rs"), "// a test\n")?;
        assert_eq!(first, of("a")?, "a test counts");
        crate::files::write(&folder.join("a/bench/src/lib.rs"), "// what tests use\n")?;
        assert_eq!(first, of("a")?, "what only tests depend on counts");
        crate::files::write(&folder.join("a/plant/src/lib.rs"), "// the plant\n")?;
        assert_ne!(first, of("a")?, "the source of the package itself does not count");
        make(&folder.join("a"), "// other\n")?;
        assert_ne!(first, of("a")?, "the source of a dependency does not count");
        assert!(super::of(&folder).is_err());
        std::fs::remove_dir_all(&folder)?;
        Ok(())
    }

    #[test]
    fn files_of_editors_and_of_the_system_do_not_count() -> Result<()> {
        let folder = files::scratch("collected");
        for name in ["lib.rs", "parts/law.rs", "lib.rs~", ".DS_Store", "parts/.law.rs.swp"] {
            crate::files::write(&folder.join(name), "text")?;
        }
        let mut found = BTreeMap::new();
        collect(&folder, "src", &mut found)?;
        std::fs::remove_dir_all(&folder)?;
        assert_eq!(found.into_keys().collect::<Vec<_>>(), ["src/lib.rs", "src/parts/law.rs"]);
        Ok(())
    }
}
