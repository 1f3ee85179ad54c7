//! Gives the library a fingerprint of its source, from which the GUIDs are made.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

#[path = "src/fmi2/fnv.rs"]
mod fnv;

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=Cargo.toml");
    println!("cargo::rerun-if-changed=src");
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let mut files = vec!["Cargo.toml".to_owned()];
    collect(&root, "src", &mut files)?;
    files.sort();
    let mut hash = fnv::Hash::new();
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
