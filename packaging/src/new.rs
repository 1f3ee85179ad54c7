//! `cargo xtask new law`: a crate with a friction law of one's own, to begin with.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::{Args, Subcommand};

use crate::files;
use crate::process::{self, heading};
use crate::workspace::Workspace;

/// Begin a crate of one's own: the law, its line in a catalogue and its test.
#[derive(Args)]
#[command(after_help = "\
Example:
  cargo xtask new law QuadraticDrag ../quadratic-drag     then `cargo test` in that folder; docs/own.md tells the rest")]
pub struct New {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// A friction law in the cylinder and the friction bench.
    Law {
        /// Its name, as the enumeration shows it: `QuadraticDrag`.
        name: String,
        /// The folder of the crate, which is made.
        folder: PathBuf,
    },
}

/// Files of the crate, with what is put in for `@...@`.
const FILES: [(&str, &str); 4] = [
    ("Cargo.toml", include_str!("../templates/law/Cargo.toml.txt")),
    ("src/lib.rs", include_str!("../templates/law/lib.rs.txt")),
    ("src/@module@.rs", include_str!("../templates/law/law.rs.txt")),
    ("tests/@module@.rs", include_str!("../templates/law/test.rs.txt")),
];

impl New {
    /// Writes the crate.
    ///
    /// # Errors
    /// When the name is none of a law, the folder is there already, or a file cannot be written.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        let What::Law { name, folder } = &self.what;
        for file in write(name, folder, &workspace.home)? {
            println!("{}", file.display());
        }
        println!("\nNow: cd {} && cargo test", folder.display());
        Ok(())
    }
}

/// Writes the crate of a law, which depends on the plant in a folder.
fn write(name: &str, folder: &Path, plant: &Path) -> Result<Vec<PathBuf>> {
    let letters =
        name.starts_with(|first: char| first.is_ascii_uppercase()) && name.chars().all(|it| it.is_ascii_alphanumeric());
    ensure!(letters, "{name} is no name of a law: it begins with a capital letter, and letters and digits follow");
    ensure!(!folder.exists(), "{} is there already", folder.display());
    let snake = words(name).join("_");
    let plant = plant.to_str().with_context(|| format!("{} is no text", plant.display()))?;
    let group = format!("{}{}", name[..1].to_lowercase(), &name[1..]);
    let places = [
        ("@Law@", name.to_owned()),
        ("@group@", group),
        ("@module@", snake.clone()),
        ("@crate_name@", format!("own_{snake}")),
        ("@crate@", format!("own-{}", words(name).join("-"))),
        ("@path@", format!("{plant:?}")),
    ];
    let fill = |text: &str| places.iter().fold(text.to_owned(), |text, (place, value)| text.replace(place, value));
    let one = |(file, text): &(&str, &str)| {
        let file = folder.join(fill(file));
        files::write(&file, fill(text))?;
        Ok(file)
    };
    FILES.iter().map(one).collect()
}

/// The words of a name in capitals: `quadratic`, `drag`.
fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = ' ';
    for letter in name.chars() {
        if words.is_empty() || letter.is_ascii_uppercase() && !before.is_ascii_uppercase() {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut() {
            word.push(letter.to_ascii_lowercase());
        }
        before = letter;
    }
    words
}

/// Begins a crate with a law in an empty folder, as a user does, and runs its tests against the plant in a folder.
///
/// # Errors
/// When it cannot be written, or a test fails.
pub fn check(workspace: &Workspace, plant: &Path) -> Result<()> {
    heading("A law of one's own, begun in an empty folder");
    let folder = workspace.target.join("new-law");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).with_context(|| format!("cannot remove the old {}", folder.display()))?;
    }
    write("RootedCoulomb", &folder, plant)?;
    // The versions of the other crates from outside: the plant is compiled once for all.
    let lock = workspace.home.join("examples/own/Cargo.lock");
    std::fs::copy(&lock, folder.join("Cargo.lock")).with_context(|| format!("cannot copy {}", lock.display()))?;
    let mut cargo = process::cargo();
    cargo.args(["test", "--target-dir"]).arg(&workspace.target).current_dir(&folder);
    process::run(&mut cargo)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stand_in::{Answer, StandIn};

    #[test]
    fn a_crate_is_begun_that_depends_on_the_project() -> Result<()> {
        let (folder, workspace) = (files::scratch("new"), Workspace::of_a_test(Path::new("/target")));
        let what = What::Law { name: "Drag".to_owned(), folder: folder.clone() };
        let (outcome, started) = StandIn::new(|_| None).does(|| New { what }.run(&workspace));
        outcome?;
        assert!(started.is_empty() && folder.join("src/drag.rs").is_file());
        assert!(files::text(folder.join("Cargo.toml"))?.contains(&format!("path = {:?}", workspace.home)));
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// Its tests are run where it is, with the versions of the other crates, in place of what was begun before.
    #[test]
    fn a_crate_is_tried_in_an_empty_folder() -> Result<()> {
        let target = files::scratch("new-check");
        let workspace = Workspace::of_a_test(&target);
        let folder = target.join("new-law");
        files::write(&folder.join("src/old.rs"), "")?;
        let (outcome, started) = StandIn::new(|_| None).does(|| check(&workspace, Path::new("/plant")));
        outcome?;
        let [cargo] = &started[..] else { panic!("{started:?}") };
        assert!(cargo.line().starts_with("cargo test ") && cargo.folder.as_ref() == Some(&folder), "{cargo:?}");
        assert_eq!(Path::new(cargo.after("--target-dir")), target);
        assert!(files::text(folder.join("Cargo.toml"))?.contains("path = \"/plant\""));
        assert_eq!(
            files::text(folder.join("Cargo.lock"))?,
            files::text(workspace.home.join("examples/own/Cargo.lock"))?
        );
        assert!(folder.join("src/rooted_coulomb.rs").is_file() && !folder.join("src/old.rs").exists());
        let fails = StandIn::new(|_| Some(Answer::Fails));
        assert!(fails.does(|| check(&workspace, Path::new("/plant"))).0.is_err());
        Ok(std::fs::remove_dir_all(&target)?)
    }

    #[test]
    fn names_are_taken_apart_where_capitals_begin() {
        assert_eq!(words("QuadraticDrag").join("_"), "quadratic_drag");
        assert_eq!(words("LuGre2").join("-"), "lu-gre2");
        assert_eq!(words("GMS"), ["gms"]);
    }

    #[test]
    fn a_crate_has_the_law_its_line_and_its_test() -> Result<()> {
        let folder = files::scratch("new-law");
        let written = write("QuadraticDrag", &folder, Path::new("/plant"))?;
        let read = |name: &str| files::text(folder.join(name));
        assert_eq!(written.len(), 4);
        assert!(
            read("src/lib.rs")?
                .contains("1000 QuadraticDrag \"quadraticDrag\" OfVelocity<quadratic_drag::QuadraticDrag>")
        );
        assert!(read("src/quadratic_drag.rs")?.contains("impl VelocityLaw for QuadraticDrag"));
        assert!(read("tests/quadratic_drag.rs")?.contains("use own_quadratic_drag::catalogue::Friction;"));
        assert!(read("Cargo.toml")?.contains("pneumatic-servo = { path = \"/plant\" }"));
        let left = written.iter().map(files::text).collect::<Result<String>>()?;
        assert!(!left.contains('@'), "{left}");
        let again = write("QuadraticDrag", &folder, Path::new("/plant"))
            .map_or_else(|error| error.to_string(), |_| String::new());
        assert!(again.contains("is there already"), "{again}");
        std::fs::remove_dir_all(&folder)?;
        Ok(())
    }

    #[test]
    fn what_is_no_name_is_refused() {
        for name in ["", "drag", "My Law", "Drag-2", "Größe"] {
            let refused = write(name, Path::new("nowhere"), Path::new("/plant"));
            assert!(refused.is_err_and(|error| error.to_string().contains("is no name of a law")), "{name}");
        }
    }
}
