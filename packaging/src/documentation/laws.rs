//! The table of friction laws, written by hand without what the registry knows.

use pneumatic_servo::friction::LAWS;

use super::table::{END, TABLE};

/// A page whose tables can be scrolled, with the id of each law before its name.
pub fn numbered(source: &str) -> String {
    let page = source.replace("<table>", TABLE).replace("</table>", END);
    let page = page.replace("<thead><tr><th>Law</th>", "<thead><tr><th>Id</th><th>Law</th>");
    LAWS.items.iter().fold(page, |page, (id, name, _)| {
        page.replace(&format!("<tr><td>{name}</td>"), &format!("<tr><td>{id}</td><td><code>{name}</code></td>"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_law_has_its_id() {
        let rows: String =
            LAWS.items.iter().map(|(_, name, _)| format!("<tr><td>{name}</td><td></td></tr>\n")).collect();
        let page = numbered(&format!("<table>\n<thead><tr><th>Law</th></tr></thead>\n{rows}</table>"));
        assert!(page.contains("<th>Id</th><th>Law</th>"), "{page}");
        for (id, name, _) in LAWS.items {
            assert!(page.contains(&format!("<td>{id}</td><td><code>{name}</code></td>")), "{name}");
        }
    }
}
