//! The tables of the README, made from the variable tables.

use anyhow::{Context, Result, ensure};
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Role, Variable};

const END: &str = "<!-- end -->";

/// The README with its tables renewed.
///
/// # Errors
/// When the marks of a table are missing.
pub fn renewed(text: &str) -> Result<String> {
    let variables = (models::ALL[0].variables)();
    let text = replace(text, "<!-- laws: written by `cargo xtask describe` -->", &laws(variables))?;
    replace(&text, "<!-- parameters: written by `cargo xtask describe` -->", &parameters(variables))
}

/// Puts a table between a mark and the end mark that follows it.
fn replace(text: &str, mark: &str, table: &str) -> Result<String> {
    let (before, rest) = text.split_once(mark).with_context(|| format!("the README lacks the line {mark}"))?;
    let end = rest.find(END).with_context(|| format!("{mark} is not followed by {END}"))?;
    ensure!(!rest[..end].contains("<!--"), "{mark} is not followed by its own {END}");
    Ok(format!("{before}{mark}\n{table}{}", &rest[end..]))
}

fn laws(variables: &[Variable]) -> String {
    let rows = LAWS.items.iter().map(|(id, law, summary)| {
        let group = group_of(variables, *id);
        let members = variables.iter().filter(|variable| in_group(variable, &group));
        let list: Vec<_> = members.filter_map(|variable| parameter(variable, &group)).collect();
        format!("| {id} | `{law}` | {summary} | {} |\n", list.join(", "))
    });
    format!(
        "| id | `friction.law` | what it is | parameters (`friction.<group>.`) |\n|---|---|---|---|\n{}",
        rows.collect::<String>()
    )
}

/// The group of a law's parameters, by its value references; empty for a law without any.
fn group_of(variables: &[Variable], id: i32) -> String {
    let law =
        variables.iter().find(|variable| variable.name == "friction.law").map_or(0, |variable| variable.reference);
    let block = law + 100 * id.unsigned_abs()..law + 100 * (id.unsigned_abs() + 1);
    let first = variables.iter().find(|variable| block.contains(&variable.reference));
    first.and_then(|variable| variable.name.rsplit_once('.')).map_or(String::new(), |(group, _)| group.to_owned())
}

fn in_group(variable: &Variable, group: &str) -> bool {
    !group.is_empty() && variable.name.rsplit_once('.').is_some_and(|(own, _)| own == group)
}

/// A parameter and its default; of an array the first element stands for all.
fn parameter(variable: &Variable, group: &str) -> Option<String> {
    let name = &variable.name[group.len() + 1..];
    let name = match name.split_once('[') {
        None => name.to_owned(),
        Some((array, "1]")) => format!("{array}[...]"),
        Some(_) => return None,
    };
    Some(format!("`{name}` {}", shown(variable)))
}

fn parameters(variables: &[Variable]) -> String {
    let own = variables.iter().filter(|variable| variable.is_parameter() && variable.reference < 10_000);
    let rows = own.map(|variable| {
        let tunable = if variable.role == Role::Tunable { " (tunable)" } else { "" };
        format!("| `{}` | {} | {}{tunable} |\n", variable.name, shown(variable), variable.description)
    });
    format!("| parameter | default | |\n|---|---|---|\n{}", rows.collect::<String>())
}

/// The default with its unit.
fn shown(variable: &Variable) -> String {
    let start = variable.start.unwrap_or_default();
    match variable.kind {
        Kind::Real(unit) if unit.name == "1" => number(start),
        Kind::Real(unit) => format!("{} {}", number(start), unit.name),
        Kind::Integer => format!("{start}"),
        Kind::Boolean => format!("{}", start != 0.0),
        Kind::Enumeration(of) => of
            .items
            .iter()
            .find(|(id, ..)| f64::from(*id) == start)
            .map_or(String::new(), |(_, name, _)| (*name).to_owned()),
    }
}

/// A number as an engineer writes it.
fn number(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) { format!("{value:e}") } else { format!("{value}") }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn readme_is_up_to_date() -> Result<()> {
        let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md"))?;
        assert!(text == renewed(&text)?, "README.md is out of date: run `cargo xtask describe`");
        Ok(())
    }

    #[test]
    fn missing_mark_is_named() {
        let error = renewed("no tables here").unwrap_err();
        assert!(error.to_string().contains("laws: written by"), "{error}");
    }
}
