//! The table of friction laws, written by hand without what the catalogue of the model knows.

use anyhow::{Context, Result};
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Model;
use pneumatic_servo::variables::Enumeration;

use super::table::{END, TABLE};
use super::text::escape;
use crate::product::Parts;

/// Rows of the table for laws that the project does not have: a part of their crate.
const ROWS: &str = "friction-laws.html";

/// A page whose tables can be scrolled, with the id of each law before its name, and with a row for each law of the model.
///
/// # Errors
/// When there is no table for the rows of further laws, or theirs cannot be read.
pub fn numbered(source: &str, model: &Model, parts: &Parts) -> Result<String> {
    let laws = laws(model);
    let page = complete(source, laws, &parts.text(ROWS)?.unwrap_or_default())?;
    let page = page.replace("<table>", TABLE).replace("</table>", END);
    let page = page.replace("<thead><tr><th>Law</th>", "<thead><tr><th>Id</th><th>Law</th>");
    Ok(laws.items.iter().fold(page, |page, (id, name, _)| {
        page.replace(&row(name), &format!("<tr><td>{id}</td><td><code>{}</code></td>", escape(name)))
    }))
}

/// The beginning of the row of a law.
fn row(name: &str) -> String {
    format!("<tr><td>{}</td>", escape(name))
}

/// The laws that a model has; all of the project, if it has no choice.
fn laws(model: &Model) -> &'static Enumeration {
    model.table().friction_law().map_or(LAWS, |(_, laws)| laws)
}

/// The page with a row for each law: first the project's, then a user's, hand-written or with the sentence of the catalogue.
fn complete(source: &str, laws: &Enumeration, rows: &str) -> Result<String> {
    let Some((before, table)) = source.split_once("<th>Law</th>") else { return Ok(source.to_owned()) };
    let further = laws.items.iter().filter(|(_, name, _)| !table.contains(&row(name)));
    let written = |name: &str| {
        let start = rows.find(&row(name))?;
        let length = rows[start..].find("</tr>")? + "</tr>".len();
        Some(format!("{}\n", &rows[start..start + length]))
    };
    let further = further.map(|(_, name, text)| {
        written(name).unwrap_or_else(|| format!("{}<td>{}</td><td></td></tr>\n", row(name), escape(text)))
    });
    let (known, after) = table.split_once("</tbody>").context("the table of the friction laws has no end")?;
    Ok([before, "<th>Law</th>", known, &further.collect::<String>(), "</tbody>", after].concat())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use pneumatic_servo::models::friction_bench::MODEL;

    use super::*;

    #[test]
    fn every_law_has_its_id() -> Result<()> {
        let rows: String =
            LAWS.items.iter().map(|(_, name, _)| format!("<tr><td>{name}</td><td></td></tr>\n")).collect();
        let page = format!("<table>\n<thead><tr><th>Law</th></tr></thead>\n<tbody>{rows}</tbody></table>");
        let page = numbered(&page, &MODEL, &Parts::of_the_project(Path::new("no/such/folder")))?;
        assert!(page.contains("<th>Id</th><th>Law</th>"), "{page}");
        for (id, name, _) in LAWS.items {
            assert!(page.contains(&format!("<td>{id}</td><td><code>{name}</code></td>")), "{name}");
        }
        Ok(())
    }

    #[test]
    fn further_laws_follow_with_their_own_row_or_their_sentence() -> Result<()> {
        static MORE: Enumeration = Enumeration {
            name: "FrictionLaw",
            description: "",
            items: &[(1, "None", "No friction"), (1000, "Written", "unused"), (1001, "Told", "a < b")],
        };
        let page = "<table><thead><tr><th>Law</th></tr></thead><tbody><tr><td>None</td></tr>\n</tbody></table><p>";
        let rows = "<tr><td>Other</td></tr>\n<tr><td>Written</td><td>\\(x\\)</td></tr>\n";
        assert_eq!(
            complete(page, &MORE, rows)?,
            "<table><thead><tr><th>Law</th></tr></thead><tbody><tr><td>None</td></tr>\n\
             <tr><td>Written</td><td>\\(x\\)</td></tr>\n\
             <tr><td>Told</td><td>a &lt; b</td><td></td></tr>\n</tbody></table><p>"
        );
        Ok(())
    }
}
