//! The public interface of the plant, as its documentation shows it, compared with what is recorded: a change of it is seen.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Result, bail, ensure};

use crate::files;
use crate::workspace::Workspace;

/// The record: a line for each item, and for each of its methods, fields and variants.
const RECORD: &str = "tests/recorded/public.txt";

/// Kinds of what a page shows of an item, as its anchors name them.
const PARTS: [&str; 6] = ["method", "tymethod", "variant", "structfield", "associatedconstant", "associatedtype"];

/// Compares the interface with the record, after `cargo doc`.
///
/// # Errors
/// When it differs; the present one is in target/public.txt then.
pub fn check(workspace: &Workspace) -> Result<()> {
    let found = interface(&workspace.target.join("doc/pneumatic_servo"))?;
    let recorded = files::text(workspace.home.join(RECORD))?;
    let (now, before): (BTreeSet<_>, BTreeSet<_>) =
        (found.iter().map(String::as_str).collect(), recorded.lines().collect());
    if now == before {
        println!("the public interface is the recorded one: {} lines", now.len());
        return Ok(());
    }
    let file = workspace.target.join("public.txt");
    files::write(&file, found.iter().map(|line| format!("{line}\n")).collect::<String>())?;
    bail!(
        "the public interface has changed:\n{}{}if that is meant, copy {} to {RECORD}",
        lines("+ ", now.difference(&before)),
        lines("- ", before.difference(&now)),
        file.display()
    )
}

fn lines<'a>(sign: &str, of: impl Iterator<Item = &'a &'a str>) -> String {
    of.map(|line| format!("  {sign}{line}\n")).collect()
}

/// All items that the documentation in a folder shows, with their parts.
fn interface(folder: &Path) -> Result<BTreeSet<String>> {
    let mut found = BTreeSet::new();
    for (page, name) in items(&files::text(folder.join("all.html"))?) {
        let text = files::text(folder.join(&page))?;
        let kind = page.rsplit('/').next().and_then(|file| file.split('.').next()).unwrap_or_default();
        found.insert(format!("{name} ({kind})"));
        found.extend(parts(&text).into_iter().map(|part| format!("{name}::{part}")));
    }
    ensure!(!found.is_empty(), "the documentation in {} shows nothing", folder.display());
    Ok(found)
}

/// The pages of all items and their names.
fn items(all: &str) -> Vec<(String, String)> {
    let of_line = |entry: &str| {
        // Anchors lead to the kinds of items on the same page.
        let (page, rest) = entry.split_once('"').filter(|(page, _)| !page.starts_with('#'))?;
        let (_, name) = rest.split_once('>')?;
        Some((page.to_owned(), name.split('<').next()?.to_owned()))
    };
    all.split("<li><a href=\"").skip(1).filter_map(of_line).collect()
}

/// What the page of an item shows of it itself; what traits of others add is left out.
fn parts(page: &str) -> BTreeSet<String> {
    let ends = [
        "id=\"trait-implementations\"",
        "id=\"synthetic-implementations\"",
        "id=\"deref-methods",
        "id=\"implementors\"",
    ];
    let end = ends.iter().filter_map(|end| page.find(end)).min().unwrap_or(page.len());
    let anchors = page[..end].split(" id=\"").skip(1).filter_map(|rest| rest.split_once('"')).map(|(anchor, _)| anchor);
    let part = |anchor: &str| {
        let (kind, name) = anchor.split_once('.')?;
        // A second implementation of the same name has a number behind it.
        let name =
            name.rsplit_once('-').filter(|(_, number)| number.parse::<u32>().is_ok()).map_or(name, |(name, _)| name);
        (PARTS.contains(&kind) && !name.contains('.')).then(|| name.to_owned())
    };
    anchors.filter_map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is new and what is gone is named, and the present one is left to be copied.
    #[test]
    fn a_change_of_the_interface_is_named() -> Result<()> {
        let folder = files::scratch("public");
        let workspace = Workspace { home: folder.clone(), ..Workspace::of_a_test(&folder) };
        let documentation = |all: &str| files::write(&folder.join("doc/pneumatic_servo/all.html"), all);
        let record = |lines: &str| files::write(&folder.join(RECORD), lines);
        let problem = || check(&workspace).map_or_else(|problem| problem.to_string(), |()| String::new());
        record("model::Model (struct)\nmodel::Model::of\n")?;
        documentation("<ul></ul>")?;
        assert!(problem().contains("shows nothing"));
        documentation("<li><a href=\"model/struct.Model.html\">model::Model</a></li>")?;
        let page = folder.join("doc/pneumatic_servo/model/struct.Model.html");
        files::write(&page, "<section id=\"method.of\" class=\"method\">")?;
        assert_eq!(problem(), "");
        assert!(!folder.join("public.txt").exists());
        record("model::Model (struct)\nmodel::Model::before\n")?;
        assert!(
            problem().contains("changed:\n  + model::Model::of\n  - model::Model::before\nif that is meant"),
            "{}",
            problem()
        );
        assert_eq!(files::text(folder.join("public.txt"))?, "model::Model (struct)\nmodel::Model::of\n");
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn items_and_their_parts_are_read_from_the_pages() {
        let all = "<ul><li><a href=\"#macros\" title=\"Macros\">Macros</a></li></ul><ul class=\"all-items\"><li><a href=\"model/struct.Model.html\">model::Model</a></li>\
                   <li><a href=\"macro.laws.html\">laws</a></li></ul>";
        let pair = |page: &str, name: &str| (page.to_owned(), name.to_owned());
        assert_eq!(items(all), [pair("model/struct.Model.html", "model::Model"), pair("macro.laws.html", "laws")]);
        let page = "<span id=\"structfield.name\" class=\"structfield\"></span><section id=\"method.of\" class=\"method\">\
                    <section id=\"method.of-1\" class=\"method\">\
                    <section id=\"impl.Model\"><span id=\"variant.Of.field.0\"></span><h2 id=\"trait-implementations\"></h2>\
                    <section id=\"method.clone\" class=\"method\">";
        assert_eq!(parts(page).into_iter().collect::<Vec<_>>(), ["name", "of"]);
    }
}
