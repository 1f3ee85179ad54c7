//! `documentation/licenses`: the licences of the project and of all packages linked into the library.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package, TargetKind};

use crate::files;
use crate::process;
use crate::workspace::Workspace;

/// The files of the folder by name; `license.txt` is the one that hosts open.
///
/// # Errors
/// When a licence file is missing, or Cargo cannot tell what the library depends on.
pub fn files(workspace: &Workspace) -> Result<BTreeMap<String, String>> {
    let product = &workspace.product;
    let metadata = metadata(workspace)?;
    let mut files = BTreeMap::new();
    let folder = folder_of(package(&metadata, &product.package)?)?;
    for file in nearest(folder, &workspace.root).unwrap_or_default() {
        files.insert(format!("{}.txt", file_name(&file).trim_end_matches(".txt")), read(&file)?);
    }
    let own = match (product.is_of_the_project(), &*product.licence) {
        (true, _) => "This FMU is licensed under the MIT License or the Apache License 2.0, at your choice:\n\
                      LICENSE-MIT.txt, LICENSE-APACHE.txt.\n"
            .to_owned(),
        (false, "") => "Its author states no licence of this FMU.\n".to_owned(),
        (false, licence) => format!("The licence of this FMU: {licence}.\n"),
    };
    files.insert("license.txt".to_owned(), own + OVERVIEW);
    files.insert("third-party.txt".to_owned(), third_party(&metadata, &product.package)?);
    Ok(files)
}

const OVERVIEW: &str = "
Its library, and its sources in C if it has them, contain the Rust standard library, under the same two licences, copyright the Rust project developers, and
the packages listed in third-party.txt with their licences.
";

fn metadata(workspace: &Workspace) -> Result<Metadata> {
    let version = process::output(process::cargo().arg("-vV"))?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).context("cargo names no host")?;
    let mut command = MetadataCommand::new();
    // The library depends on the same packages on every platform.
    command.manifest_path(workspace.root.join("Cargo.toml"));
    command.other_options(["--locked", "--filter-platform", host].map(str::to_owned));
    process::metadata(&command)
}

/// The packages of others that the library of a package of this workspace contains, with their licences.
///
/// # Errors
/// When a licence file is missing, or Cargo cannot tell what the library depends on.
pub fn of_package(workspace: &Workspace, package: &str) -> Result<String> {
    third_party(&metadata(workspace)?, package)
}

/// Name, version, licence and licence texts of each package.
fn third_party(metadata: &Metadata, library: &str) -> Result<String> {
    let mut text = format!("Packages that the library of {library} contains.\n");
    for package in linked(metadata, library)? {
        let (name, version) = (&package.name, &package.version);
        let (licence, source) = (package.license.as_deref(), package.repository.as_deref());
        let folder = folder_of(package)?;
        let _ = write!(
            text,
            "\n{}\n{name} {version}\nLicence: {}\nSource: {}\n",
            "=".repeat(80),
            licence.unwrap_or_default(),
            source.unwrap_or_default()
        );
        let files = match package.source {
            Some(_) => licence_files(folder),
            None => nearest(folder, &workspace_of(folder)),
        };
        for file in files.with_context(|| format!("{name} {version}"))? {
            let _ = write!(text, "\n--- {} ---\n\n{}\n", file_name(&file), read(&file)?.trim_end());
        }
    }
    Ok(text)
}

/// The packages of others whose code is in the library, sorted by name: normal dependencies, without procedural macros,
/// which run in the compiler.
fn linked<'a>(metadata: &'a Metadata, library: &str) -> Result<Vec<&'a Package>> {
    let resolve = metadata.resolve.as_ref().context("cargo metadata resolves nothing")?;
    let mut found = vec![package(metadata, library)?];
    let mut next = 0;
    while next < found.len() {
        let node = resolve.nodes.iter().find(|node| node.id == found[next].id).context("an unresolved package")?;
        for dependency in &node.deps {
            let package = &metadata[&dependency.pkg];
            let is_normal = dependency.dep_kinds.iter().any(|kind| kind.kind == DependencyKind::Normal);
            let is_macro = package.targets.iter().any(|target| target.kind.contains(&TargetKind::ProcMacro));
            if is_normal && !is_macro && !found.iter().any(|known| known.id == package.id) {
                found.push(package);
            }
        }
        next += 1;
    }
    // The licence of the project itself stands beside this list.
    found.retain(|package| !metadata.workspace_members.contains(&package.id));
    found.sort_by_key(|package| (package.name.to_string(), package.version.clone()));
    Ok(found)
}

/// A package of this name.
fn package<'a>(metadata: &'a Metadata, name: &str) -> Result<&'a Package> {
    let found = metadata.packages.iter().find(|package| package.name == name);
    found.with_context(|| format!("Cargo knows no package {name}"))
}

fn folder_of(package: &Package) -> Result<&Path> {
    Ok(package.manifest_path.parent().context("a manifest without a folder")?.as_std_path())
}

/// The licence files of a folder or of the nearest above it up to a root: those that a package of a workspace has in common with
/// the others are at the top.
fn nearest(folder: &Path, root: &Path) -> Result<Vec<PathBuf>> {
    let folders = folder.ancestors().take_while(|above| above.starts_with(root));
    let found = folders.map(licence_files).find(Result::is_ok);
    found.unwrap_or_else(|| licence_files(folder))
}

/// The root of the workspace that a folder is in.
fn workspace_of(folder: &Path) -> PathBuf {
    let is_root = |above: &&Path| {
        let manifest = std::fs::read_to_string(above.join("Cargo.toml"));
        manifest.is_ok_and(|manifest| manifest.lines().any(|line| line.trim() == "[workspace]"))
    };
    folder.ancestors().find(is_root).unwrap_or(folder).to_path_buf()
}

/// The licence files of a folder, sorted: those in it by their names, and all in its folder `LICENSES`.
fn licence_files(folder: &Path) -> Result<Vec<PathBuf>> {
    const BEGINNINGS: [&str; 5] = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"];
    let mut files = entries(folder)?;
    let is_licence = |name: String| BEGINNINGS.iter().any(|beginning| name.to_uppercase().starts_with(beginning));
    files.retain(|file| file.is_file() && is_licence(file_name(file)));
    if folder.join("LICENSES").is_dir() {
        files.extend(entries(&folder.join("LICENSES"))?);
    }
    files.sort();
    ensure!(!files.is_empty(), "{} has no licence file", folder.display());
    Ok(files)
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?;
    entries.map(|entry| Ok(entry?.path())).collect()
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// With line ends that do not depend on the platform.
fn read(file: &Path) -> Result<String> {
    Ok(files::text(file)?.replace("\r\n", "\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::PACKAGE;

    #[test]
    fn every_package_is_there_with_a_licence_text() -> Result<()> {
        let files = files(&Workspace::of_the_project()?)?;
        assert_eq!(
            files.keys().collect::<Vec<_>>(),
            ["LICENSE-APACHE.txt", "LICENSE-MIT.txt", "license.txt", "third-party.txt"]
        );
        let text = &files["third-party.txt"];
        for package in ["libm", "nalgebra", "num-traits", "postcard", "serde_core"] {
            assert!(text.contains(&format!("\n{package} ")), "{package}");
        }
        for other in
            ["syn", "serde_derive", "quick-xml", "serde_json", "pneumatic-servo", "pneumatic-servo-fmu", PACKAGE]
        {
            assert!(!text.contains(&format!("\n{other} ")), "{other} is not in the library");
        }
        assert!(!text.contains("/home/") && !text.contains(env!("CARGO_MANIFEST_DIR")), "a path of this machine");
        Ok(())
    }

    #[test]
    fn packages_of_a_library_are_listed_by_its_name() -> Result<()> {
        let workspace = Workspace::of_the_project()?;
        let text = of_package(&workspace, "pneumatic-servo-playground")?;
        assert!(text.starts_with("Packages that the library of pneumatic-servo-playground contains.\n"), "{text}");
        assert!(text.contains("\nlibm ") && text.contains("\nLicence: MIT"));
        assert!(of_package(&workspace, "no-such").is_err_and(|error| error.to_string().contains("no-such")));
        Ok(())
    }

    #[test]
    fn a_licence_is_copied_with_plain_line_ends() -> Result<()> {
        let folder = files::scratch("licence-text");
        files::write(&folder.join("LICENSE"), "one\r\ntwo\r\n")?;
        assert_eq!(read(&folder.join("LICENSE"))?, "one\ntwo\n");
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn a_package_is_in_the_nearest_workspace_above() -> Result<()> {
        let root = files::scratch("licences");
        let package = root.join("crates/part");
        crate::files::write(&root.join("Cargo.toml"), "[workspace]\nmembers = [\"crates/part\"]\n")?;
        crate::files::write(&package.join("Cargo.toml"), "[package]\nname = \"part\"\n")?;
        assert_eq!(workspace_of(&package), root);
        // A package that is one by itself.
        crate::files::write(&package.join("Cargo.toml"), "[package]\nname = \"part\"\n\n[workspace]\n")?;
        assert_eq!(workspace_of(&package), package);
        std::fs::remove_dir_all(&root)?;
        Ok(())
    }
}
