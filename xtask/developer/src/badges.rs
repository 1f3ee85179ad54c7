//! The badges of README as pictures, made from what the manifests state: no service draws them, so that they are true offline.

use anyhow::{Context, Result};

/// Where they are, as a path in the repository.
pub const FOLDER: &str = "docs/images/badges";

const PYTHON: &str = include_str!("../../../python/pyproject.toml");

/// Height of a badge and width of a character, in pixels.
const HEIGHT: usize = 20;
const CHARACTER: usize = 7;

/// File names and pictures.
///
/// # Errors
/// When the Python package does not state its oldest Python.
pub fn badges() -> Result<Vec<(&'static str, String)>> {
    let python = PYTHON.split_once("requires-python = \">=").and_then(|(_, rest)| rest.split_once('"'));
    let (python, _) = python.context("python/pyproject.toml: requires-python is missing")?;
    let licences = env!("CARGO_PKG_LICENSE").replace("OR", "or");
    let facts = [
        ("licence.svg", "licence", licences),
        ("fmi.svg", "FMI", "2.0, 3.0".to_owned()),
        ("python.svg", "Python", format!("{python}+")),
        ("rust.svg", "Rust", format!("{}+", env!("CARGO_PKG_RUST_VERSION"))),
    ];
    Ok(facts.into_iter().map(|(file, label, value)| (file, badge(label, &value))).collect())
}

/// A label on grey beside its value on blue; `textLength` gives the text its width in every font.
fn badge(label: &str, value: &str) -> String {
    let [left, right] = [label, value].map(|text| CHARACTER * (text.chars().count() + 2));
    let text = |x: usize, width: usize, text: &str| {
        let (x, width) = (x + CHARACTER, width - 2 * CHARACTER);
        format!("<text x=\"{x}\" y=\"14\" textLength=\"{width}\">{text}</text>\n")
    };
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{whole}\" height=\"{HEIGHT}\" role=\"img\" \
         aria-label=\"{label}: {value}\">\n\
         <rect width=\"{whole}\" height=\"{HEIGHT}\" rx=\"3\" fill=\"#444\"/>\n\
         <path d=\"M{left} 0H{edge}a3 3 0 0 1 3 3v{side}a3 3 0 0 1-3 3H{left}z\" fill=\"#0b5fa5\"/>\n\
         <g fill=\"#fff\" font-family=\"Verdana,DejaVu Sans,sans-serif\" font-size=\"11\">\n{}{}</g>\n</svg>\n",
        text(0, left, label),
        text(left, right, value),
        whole = left + right,
        edge = left + right - 3,
        side = HEIGHT - 6,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn committed_badges_are_up_to_date() -> Result<()> {
        let folder = pneumatic_servo_packaging::workspace::home().join(FOLDER);
        for (file, picture) in badges()? {
            let committed = std::fs::read_to_string(folder.join(file)).unwrap_or_default();
            assert!(committed == picture, "{FOLDER}/{file} is out of date: run `cargo xtask describe`");
        }
        Ok(())
    }
}
