//! What is said of a release: what is inside it (SBOM), and how it is cited.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use cargo_metadata::MetadataCommand;

use crate::files;
use crate::process;
use crate::venv::{Requirements, Venv};
use crate::workspace::Workspace;

/// What is handed out: the library of the FMUs, the compiled part of the Python package, the crate.
const PARTS: [&str; 3] = ["pneumatic-servo-builtin", "pneumatic-servo-python", "pneumatic-servo"];
/// What a list is called at first.
const NAME: &str = "sbom-of-the-rehearsal";

/// Lists what each part holds, in CycloneDX, into target/sbom, and checks the lists against the schema. Returns what was
/// left out.
///
/// # Errors
/// When a list cannot be made or is not valid.
pub fn list(workspace: &Workspace) -> Result<Vec<String>> {
    if process::find("cargo-cyclonedx").is_none() {
        return Ok(vec!["the SBOM: cargo-cyclonedx is missing (cargo install --locked cargo-cyclonedx)".to_owned()]);
    }
    let folder = workspace.target.join("sbom");
    files::renew(&folder)?;
    write_beside_manifests(workspace)?;
    let metadata =
        process::metadata(MetadataCommand::new().manifest_path(workspace.root.join("Cargo.toml")).no_deps())?;
    let mut lists = Vec::new();
    for package in &metadata.packages {
        let written = package.manifest_path.with_file_name(format!("{NAME}.json")).into_std_path_buf();
        let text = files::text(&written)?;
        std::fs::remove_file(&written).with_context(|| format!("cannot remove {}", written.display()))?;
        if PARTS.contains(&package.name.as_str()) {
            let list = folder.join(format!("{}.cdx.json", package.name));
            files::write(&list, without_paths(&text, &workspace.root))?;
            lists.push(list);
        }
    }
    ensure!(lists.len() == PARTS.len(), "cargo cyclonedx made {} lists, not {}", lists.len(), PARTS.len());
    let venv = Venv::prepare(workspace, Requirements::RELEASE)?;
    process::run(venv.command().arg(workspace.python().join("sbom.py")).args(lists))?;
    Ok(Vec::new())
}

/// The tool writes a list for each package of the workspace, beside its manifest, under a name by which to find them again.
fn write_beside_manifests(workspace: &Workspace) -> Result<()> {
    let mut cargo = process::cargo();
    // What a system of its users needs, not what this machine does.
    cargo.args(["cyclonedx", "--quiet", "--target", "all", "--no-build-deps", "--format", "json"]);
    process::run(cargo.args(["--spec-version", "1.5", "--override-filename", NAME]).current_dir(&workspace.root))
}

/// A list names packages of the workspace by where they are, which is nobody's business.
fn without_paths(list: &str, root: &Path) -> String {
    list.replace(&format!("path+file://{}", root.display()), "workspace")
}

/// Checks CITATION.cff against the schema of its format.
///
/// # Errors
/// When it is not valid.
pub fn citation(workspace: &Workspace) -> Result<()> {
    let venv = Venv::prepare(workspace, Requirements::RELEASE)?;
    let mut cffconvert = Command::new(venv.program("cffconvert"));
    process::run(cffconvert.args(["--validate", "-i"]).arg(workspace.root.join("CITATION.cff")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stand_in::{self, StandIn, Started};

    /// The result, and what is started, where the tool writes a list for each of some packages.
    fn listed(
        folder: &Path,
        packages: &'static [&'static str],
        lacking: &'static str,
    ) -> (Result<Vec<String>>, Vec<Started>) {
        let root = folder.to_owned();
        let workspace = Workspace { root: root.clone(), ..Workspace::of_a_test(&root.join("target")) };
        let machine = StandIn::new(move |command| {
            if command.says("metadata") {
                let all: Vec<_> = packages.iter().map(|name| (*name, "0.1.0", *name)).collect();
                return Some(stand_in::metadata(&root, &root, &all));
            }
            if command.says("cyclonedx") {
                let name = format!("{}.json", command.after("--override-filename"));
                for package in packages {
                    stand_in::writes(
                        root.join(package).join(&name),
                        format!("{package} of path+file://{}", root.display()),
                    );
                }
            }
            None
        });
        machine.lacking(lacking).does(|| list(&workspace))
    }

    /// The lists of what is handed out are kept, without the places of this machine, and checked; nothing stays in the sources.
    #[test]
    fn lists_of_what_is_handed_out_are_kept_and_checked() -> Result<()> {
        const ALL: &[&str] = &["pneumatic-servo", "benchmark", "pneumatic-servo-python", "pneumatic-servo-builtin"];
        let folder = files::scratch("sbom");
        files::write(&folder.join("target/sbom/old.cdx.json"), "")?;
        let (left, started) = listed(&folder, ALL, "");
        assert_eq!(left?, Vec::<String>::new());
        let lists = PARTS.map(|name| folder.join("target/sbom").join(format!("{name}.cdx.json")));
        for (list, name) in lists.iter().zip(PARTS) {
            assert_eq!(files::text(list)?, format!("{name} of workspace"));
        }
        assert_eq!(std::fs::read_dir(folder.join("target/sbom"))?.count(), PARTS.len());
        assert!(ALL.iter().all(|name| !folder.join(name).join(format!("{NAME}.json")).exists()));
        let made = started.iter().find(|it| it.says("cyclonedx")).context("no list")?;
        assert!(made.says("--target all --no-build-deps") && made.folder.as_ref() == Some(&folder), "{made:?}");
        let checked = started.last().context("no check")?;
        assert!(checked.line().contains("sbom.py") && lists.iter().all(|it| checked.says(&it.display().to_string())));

        let (left, _) = listed(&folder, &ALL[..3], "");
        assert!(left.is_err_and(|error| error.to_string().contains("made 2 lists, not 3")));
        let (left, started) = listed(&folder, ALL, "cargo-cyclonedx");
        assert!(left?[0].starts_with("the SBOM: cargo-cyclonedx is missing") && started.is_empty());
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn citation_is_validated() -> Result<()> {
        let folder = files::scratch("citation");
        let workspace = Workspace::of_a_test(&folder);
        let (outcome, started) = StandIn::new(|_| None).does(|| citation(&workspace));
        outcome?;
        let last = started.last().context("nothing is started")?;
        assert!(
            last.line().starts_with("cffconvert --validate -i ") && last.line().ends_with("CITATION.cff"),
            "{last:?}"
        );
        let fails = StandIn::new(|command| command.says("--validate").then_some(stand_in::Answer::Fails));
        assert!(fails.does(|| citation(&workspace)).0.is_err());
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn a_list_does_not_tell_where_it_was_made() {
        let list = r#"{"bom-ref": "path+file:///home/ann/plant/fmu#pneumatic-servo-fmu@0.1.0"}"#;
        let expected = r#"{"bom-ref": "workspace/fmu#pneumatic-servo-fmu@0.1.0"}"#;
        assert_eq!(without_paths(list, Path::new("/home/ann/plant")), expected);
    }
}
