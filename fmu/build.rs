//! Gives the library a fingerprint of its source, from which the GUIDs are made.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

#[path = "variant/src/fnv.rs"]
mod fnv;

/// Files that the library is made from, relative to the root of the repository: the plant, the interface, and the versions
/// of their dependencies.
const FILES: [&str; 4] = ["Cargo.toml", "Cargo.lock", "fmu/Cargo.toml", "fmu/variant/Cargo.toml"];
const FOLDERS: [&str; 3] = ["src", "fmu/src", "fmu/variant/src"];

fn main() -> io::Result<()> {
    let package = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let root = package.parent().ok_or_else(|| io::Error::other("the package has no folder above it"))?;
    let mut files = FILES.map(str::to_owned).to_vec();
    for folder in FOLDERS {
        collect(root, folder, &mut files)?;
    }
    for path in FILES.iter().chain(&FOLDERS) {
        println!("cargo::rerun-if-changed={}", root.join(path).display());
    }
    files.sort();
    let mut hash = fnv::Hash::default();
    for file in &files {
        hash.add(file.as_bytes());
        hash.add(&fs::read(root.join(file))?);
    }
    println!("cargo::rustc-env=SOURCE_FINGERPRINT={}", hash.digits());
    Ok(())
}

/// Lists the files below a folder by their paths with forward slashes, which are the same on every platform.
fn collect(root: &Path, folder: &str, files: &mut Vec<String>) -> io::Result<()> {
    for entry in fs::read_dir(root.join(folder))? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_str().ok_or_else(|| io::Error::other(format!("{folder} holds a name that is no text")))?;
        // Files of editors and of the operating system do not count.
        if name.starts_with('.') || name.ends_with('~') {
            continue;
        }
        let path = format!("{folder}/{name}");
        if entry.file_type()?.is_dir() {
            collect(root, &path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}
