//! The house stands on floors: no room of the library uses one above it, and nowhere do neighbours in a folder use each
//! other in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The rooms of the library, from the ground up.
const FLOORS: [&str; 15] = [
    "numbers",
    "variables",
    "system",
    "solver",
    "friction",
    "pneumatics",
    "mechanics",
    "sensor",
    "session",
    "sensitivity",
    "model_exchange",
    "co_simulation",
    "model",
    "models",
    "conformance",
];

/// The room that stands over all and lets strangers in, and the library itself.
const ABOVE: [&str; 2] = ["prelude", ""];

/// Uses of the same crate in one of its files.
struct Uses {
    /// The modules on the way to the file, its own at last; a `mod.rs` is the module of its folder.
    module: Vec<String>,
    /// Paths from the root of the crate.
    paths: BTreeSet<Vec<String>>,
}

/// All files of a crate below the workspace.
fn files(krate: &str) -> Vec<Uses> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join(krate).join("src");
    let mut found = Vec::new();
    collect(&source, &source, &mut found);
    found
}

fn collect(source: &Path, folder: &Path, found: &mut Vec<Uses>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            collect(source, &path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let own = path.strip_prefix(source).unwrap().with_extension("");
            let mut module: Vec<String> = own.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
            module.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
            found.push(Uses { paths: paths(&module, &fs::read_to_string(&path).unwrap()), module });
        }
    }
}

/// The paths from the root that a file names by `crate` or `super`.
fn paths(module: &[String], text: &str) -> BTreeSet<Vec<String>> {
    // Tests at the end of a file may use everything, and what is said in comments is no use.
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap();
    let lines: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap()).collect();
    let code = lines.join("\n");
    let mut found = Vec::new();
    for start in ["crate::", "super::"] {
        for (place, _) in code.match_indices(start) {
            let before = &code[..place];
            if !before.ends_with(|last: char| last.is_alphanumeric() || "_:".contains(last)) {
                take_apart(&code[place..], &[], &mut found);
            }
        }
    }
    found.into_iter().map(|path| from_root(module, &path)).collect()
}

/// Reads a path, or several in braces that begin in the same way; returns what comes behind.
fn take_apart<'a>(mut text: &'a str, begin: &[&'a str], found: &mut Vec<Vec<&'a str>>) -> &'a str {
    let mut path = begin.to_vec();
    loop {
        if let Some(inside) = text.strip_prefix('{') {
            text = inside.trim_start();
            while !text.is_empty() && !text.starts_with('}') {
                text = take_apart(text, &path, found);
                text = text.trim_start_matches(|c: char| !c.is_alphanumeric() && !"_{}".contains(c));
            }
            return text.get(1..).unwrap_or_default();
        }
        let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
        path.push(&text[..end]);
        text = &text[end..];
        match text.strip_prefix("::") {
            Some(rest) => text = rest,
            None => break,
        }
    }
    found.push(path);
    text
}

fn from_root(module: &[String], path: &[&str]) -> Vec<String> {
    let up = path.iter().take_while(|part| **part == "super").count();
    let base = if up > 0 { &module[..module.len().saturating_sub(up)] } else { &[] };
    base.iter().cloned().chain(path[up.max(1)..].iter().map(|part| (*part).to_owned())).collect()
}

/// For each folder, which of its entries use which others: once for each use.
fn neighbours(files: &[Uses]) -> BTreeMap<&[String], BTreeSet<(&str, &str)>> {
    let entries: BTreeSet<&[String]> =
        files.iter().flat_map(|file| (1..=file.module.len()).map(|n| &file.module[..n])).collect();
    let mut found: BTreeMap<_, BTreeSet<_>> = BTreeMap::new();
    for file in files {
        for path in &file.paths {
            let common = file.module.iter().zip(path).take_while(|(own, other)| own == other).count();
            if common < file.module.len() && common < path.len() && entries.contains(&path[..=common]) {
                found.entry(&file.module[..common]).or_default().insert((&*file.module[common], &*path[common]));
            }
        }
    }
    found
}

/// Remaining uses after repeated removal of those that lead to no other or come from none.
fn circle<'a>(uses: &BTreeSet<(&'a str, &'a str)>) -> BTreeSet<(&'a str, &'a str)> {
    let mut left = uses.clone();
    loop {
        let (using, used): (BTreeSet<&str>, BTreeSet<&str>) = left.iter().copied().unzip();
        let before = left.len();
        left.retain(|(one, other)| used.contains(one) && using.contains(other));
        if left.len() == before {
            return left;
        }
    }
}

#[test]
fn no_room_uses_one_above_it() {
    let floor = |room: &str| FLOORS.iter().position(|other| *other == room);
    let (mut rooms, mut uses, mut upwards) = (BTreeSet::new(), 0, Vec::new());
    for file in files("") {
        let room = file.module.first().map_or("", String::as_str);
        if ABOVE.contains(&room) {
            continue;
        }
        let own = floor(room).unwrap_or_else(|| panic!("{room} has no floor"));
        rooms.insert(own);
        for path in &file.paths {
            let Some(other) = path.first().and_then(|room| floor(room)) else { continue };
            uses += 1;
            if other > own {
                upwards.push(format!("{}: uses {}, which stands above", file.module.join("::"), path.join("::")));
            }
        }
    }
    assert_eq!(rooms.len(), FLOORS.len());
    assert!(uses > 400, "{uses} uses seen");
    assert!(upwards.is_empty(), "{}", upwards.join("\n"));
}

#[test]
fn no_neighbours_use_each_other_in_a_circle() {
    let mut circles = Vec::new();
    for (krate, least) in
        [("", 100), ("fit", 30), ("fmu", 50), ("packaging", 100), ("xtask/developer", 10), ("python", 30)]
    {
        let files = files(krate);
        let neighbours = neighbours(&files);
        let seen: usize = neighbours.values().map(BTreeSet::len).sum();
        assert!(seen > least, "{krate}: {seen} uses seen");
        let left = neighbours.into_iter().map(|(folder, uses)| (folder, circle(&uses)));
        let left = left.filter(|(_, uses)| !uses.is_empty());
        circles.extend(left.map(|(folder, uses)| format!("{krate}/src/{}: {uses:?}", folder.join("/"))));
    }
    assert!(circles.is_empty(), "{}", circles.join("\n"));
}

/// A circle in each of the ways in which a file names another.
#[test]
fn a_circle_is_found() {
    let file = |module: &str, text: &str| {
        let module: Vec<String> = module.split("::").map(str::to_owned).collect();
        Uses { paths: paths(&module, text), module }
    };
    let circles = |second: &str| {
        let files =
            [file("air::gas", "use super::{orifice::{self, Flow as Mass}, *};\n"), file("air::orifice::flow", second)];
        neighbours(&files).values().any(|uses| !circle(uses).is_empty())
    };
    for second in [
        "use crate::air::gas::Gas;",
        "use super::super::gas;",
        "use crate::{\n    air::{gas, valve},\n};",
        "fn f(x: crate::air::gas::Gas) {}",
        "macro_rules! m { () => { $crate::air::gas::f() } }",
    ] {
        assert!(circles(second), "{second}");
    }
    for second in [
        "use super::shape::Shape;",
        "// use crate::air::gas::Gas;",
        "#[cfg(test)]\nmod tests {\n    use crate::air::gas::Gas;\n}",
    ] {
        assert!(!circles(second), "{second}");
    }
}
