//! `cargo xtask describe`: the committed descriptions and the tables of README and docs.

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use pneumatic_servo::models;

use crate::description::{self, Stamp};
use crate::tables;
use crate::workspace::Workspace;

/// Writes `modelDescription/<Model>.xml` for every model, and the tables of README and docs.
///
/// # Errors
/// When a file cannot be written.
pub fn run(workspace: &Workspace) -> Result<()> {
    for model in models::ALL {
        let file = workspace.descriptions().join(format!("{}.xml", model.name));
        std::fs::write(&file, committed(model)?).with_context(|| format!("cannot write {}", file.display()))?;
        println!("{}", file.display());
    }
    for page in tables::pages() {
        let file = workspace.root.join(page);
        let text = std::fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
        std::fs::write(&file, tables::renewed(page, &text)?)
            .with_context(|| format!("cannot write {}", file.display()))?;
        println!("{}", file.display());
    }
    Ok(())
}

/// The description without what changes from build to build.
fn committed(model: &Model) -> Result<String> {
    let stamp = Stamp { guid: "@guid@".to_owned(), date: "@generationDateAndTime@".to_owned() };
    description::xml(model, &stamp)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn committed_descriptions_are_up_to_date() -> Result<()> {
        for model in models::ALL {
            let name = format!("../modelDescription/{}.xml", model.name);
            let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
            let found = std::fs::read_to_string(&file).with_context(|| file.display().to_string())?;
            assert!(found == committed(model)?, "{} is out of date: run `cargo xtask describe`", file.display());
        }
        Ok(())
    }
}
