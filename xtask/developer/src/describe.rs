//! `cargo xtask describe`: the committed descriptions and experiments, and the tables of README and docs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Result;
use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo_packaging::description::{self, Stamp, Version};
use pneumatic_servo_packaging::workspace::Workspace;
use pneumatic_servo_packaging::{experiment, files};

use crate::{badges, tables};

/// The help of the command.
pub const HELP: &str = "\
Rewrite what the variable tables and manifests say: XML and experiments below modelDescription, tables of README and docs,
badges of README.

Usage: cargo xtask describe";

/// Writes `modelDescription/<Model>.xml` for every model, `experiments.json`, the tables of README and docs, and the badges.
///
/// # Errors
/// When a file cannot be written.
pub fn run(workspace: &Workspace) -> Result<()> {
    for (file, text) in committed()? {
        write(&workspace.descriptions().join(file), &text)?;
    }
    write(&workspace.descriptions().join("experiments.json"), &experiment::stated(models::ALL)?)?;
    for page in tables::pages() {
        let file = workspace.root.join(page);
        let text = files::text(&file)?;
        write(&file, &tables::renewed(page, &text)?)?;
    }
    for (file, picture) in badges::badges()? {
        write(&workspace.root.join(badges::FOLDER).join(file), &picture)?;
    }
    Ok(())
}

fn write(file: &Path, text: &str) -> Result<()> {
    files::write(file, text)?;
    println!("{}", file.display());
    Ok(())
}

/// The descriptions for FMI 2.0 by their files, without parts that change from build to build. They show the interface; descriptions
/// for FMI 3.0 have the same tables, and are made when an FMU is packed.
fn committed() -> Result<BTreeMap<PathBuf, String>> {
    let [guid, date, version, licence] =
        ["@guid@", "@generationDateAndTime@", env!("CARGO_PKG_VERSION"), env!("CARGO_PKG_LICENSE")].map(str::to_owned);
    let stamp = Stamp { guid, date, version, licence, sources: Vec::new() };
    let file = |model: &Model| {
        Ok((PathBuf::from(format!("{}.xml", model.name)), description::xml(model, Version::Fmi2, &stamp)?))
    };
    models::ALL.iter().map(file).collect()
}

#[cfg(test)]
mod tests {
    use anyhow::Context;
    use pneumatic_servo_packaging::workspace;

    use super::*;

    fn assert_committed(name: &Path, expected: &str) -> Result<()> {
        let file = workspace::home().join("modelDescription").join(name);
        let found = files::text(&file)?;
        assert!(found == expected, "{} is out of date: run `cargo xtask describe`", file.display());
        Ok(())
    }

    /// Missing or edited files are written anew, as in the repository.
    #[test]
    fn descriptions_and_tables_are_written() -> Result<()> {
        let repository = workspace::home();
        let root = std::env::temp_dir().join(format!("describe-{}", std::process::id()));
        for page in tables::pages() {
            let text = files::text(repository.join(page))?;
            files::write(
                &root.join(page),
                text.replace("`friction.law`", "`friction.other`").replace("LuGre", "Logre"),
            )?;
        }
        let parts = pneumatic_servo_packaging::product::Product::of_the_project(&root);
        let [home, target, environments] = [root.clone(), root.join("target"), root.join("environments")];
        let workspace = Workspace { root: root.clone(), home, target, environments, product: parts };
        run(&workspace)?;
        for name in ["PneumaticServoCylinder.xml", "FrictionBench.xml", "experiments.json"] {
            let written = files::text(root.join("modelDescription").join(name))?;
            assert!(written == files::text(repository.join("modelDescription").join(name))?, "{name}");
        }
        let table = |text: &str| {
            text.split("<!-- laws: ").nth(1).and_then(|rest| rest.split("<!-- end -->").next()).map(str::to_owned)
        };
        let [written, expected] = [&root, &repository].map(|place| files::text(place.join("docs/friction-laws.md")));
        assert_eq!(table(&written?).context("a table")?, table(&expected?).context("a table")?);
        std::fs::remove_dir_all(&root)?;
        Ok(())
    }

    #[test]
    fn committed_descriptions_are_up_to_date() -> Result<()> {
        committed()?.iter().try_for_each(|(file, text)| assert_committed(file, text))
    }

    #[test]
    fn committed_experiments_are_up_to_date() -> Result<()> {
        assert_committed(Path::new("experiments.json"), &experiment::stated(models::ALL)?)
    }
}
