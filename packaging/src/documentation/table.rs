//! Tables of variables, parameters and enumerations.

use std::collections::BTreeSet;

use pneumatic_servo::variables::{Kind, Role, Variable};

use super::text::{escape, number, quantity, unit};
use crate::description::enumerations as used;

/// The tags of a table that can be scrolled sideways, by the keyboard too.
pub const TABLE: &str = "<div class=\"scroll\" tabindex=\"0\">\n<table>";
/// The end of such a table.
pub const END: &str = "</table>\n</div>";

/// A section with one table of variables that are not parameters.
pub fn interface(id: &str, title: &str, variables: &[&Variable]) -> String {
    if variables.is_empty() {
        return String::new();
    }
    format!("<section id=\"{id}\">\n<h2>{title}</h2>\n{}</section>\n", rows(variables))
}

/// A section with one table per group of parameters; those of the friction laws can be opened.
pub fn parameters(variables: &[&Variable]) -> String {
    let mut groups: Vec<&str> = variables.iter().map(|variable| group(&variable.name)).collect();
    // In the order of the table, but parameters without a group first.
    groups.sort_by_key(|name| !name.is_empty());
    let mut seen = BTreeSet::new();
    groups.retain(|name| seen.insert(*name));
    let tables = groups.into_iter().map(|name| {
        let members: Vec<_> = variables.iter().copied().filter(|variable| group(&variable.name) == name).collect();
        match (name, escape(name)) {
            ("", _) => rows(&members),
            (group, name) if is_law(group) => {
                format!(
                    "<details id=\"{name}\">\n<summary><code>{name}</code></summary>\n{}</details>\n",
                    rows(&members)
                )
            }
            (_, name) => format!("<h3><code>{name}</code></h3>\n{}", rows(&members)),
        }
    });
    format!(
        "<section id=\"parameters\">\n<h2>Parameters</h2>\n<p>Tunable parameters may be changed between steps; all \
         others are fixed once initialization ends.{}</p>\n{}</section>\n",
        if variables.iter().any(|variable| is_law(group(&variable.name))) { LAWS_ARE_FOLDED } else { "" },
        tables.collect::<String>()
    )
}

const LAWS_ARE_FOLDED: &str =
    " Each friction law has a group of its own, which counts for that law alone: open the one you have chosen.";

/// Whether a group belongs to a single friction law.
fn is_law(group: &str) -> bool {
    group.starts_with("friction.")
}

/// A section with the items of every enumeration that the variables use.
pub fn enumerations(variables: &[Variable]) -> String {
    let tables = used(variables).into_iter().map(|enumeration| {
        let items = enumeration.items.iter().map(|(id, name, description)| {
            format!("<tr><td>{id}</td><td><code>{}</code></td><td>{}</td></tr>\n", escape(name), escape(description))
        });
        format!(
            "<h3><code>{}</code></h3>\n<p>{}</p>\n{TABLE}\n<thead><tr><th>Value</th><th>Name</th><th>Meaning</th></tr>\
             </thead>\n<tbody>\n{}</tbody>\n{END}\n",
            escape(enumeration.name),
            escape(enumeration.description),
            items.collect::<String>()
        )
    });
    let tables: String = tables.collect();
    if tables.is_empty() { tables } else { format!("<section id=\"choices\">\n<h2>Choices</h2>\n{tables}</section>\n") }
}

/// Everything before the last dot of a structured name.
fn group(name: &str) -> &str {
    name.rsplit_once('.').map_or("", |(group, _)| group)
}

fn rows(variables: &[&Variable]) -> String {
    let with_start = variables.iter().any(|variable| variable.start.is_some());
    let start = if with_start { "<th>Default</th><th>Range</th>" } else { "" };
    let rows = variables.iter().map(|variable| {
        let start = if with_start {
            format!("<td class=\"value\">{}</td><td class=\"value\">{}</td>", default(variable), range(variable))
        } else {
            String::new()
        };
        format!(
            "<tr><td><code>{}</code></td><td>{}</td>{start}<td>{}{}</td></tr>\n",
            escape(&variable.name),
            kind(variable),
            escape(&variable.description),
            if variable.role == Role::Tunable { " <em>Tunable.</em>" } else { "" },
        )
    });
    format!(
        "{TABLE}\n<thead><tr><th>Name</th><th>Unit</th>{start}<th>Meaning</th></tr></thead>\n<tbody>\n{}</tbody>\n\
         {END}\n",
        rows.collect::<String>()
    )
}

/// The unit, or the type of a variable without one.
fn kind(variable: &Variable) -> String {
    match variable.kind {
        Kind::Real(of) => unit(of.name),
        Kind::Integer => "integer".to_owned(),
        Kind::Boolean => "Boolean".to_owned(),
        Kind::Enumeration(of) => escape(of.name),
    }
}

fn default(variable: &Variable) -> String {
    let Some(start) = variable.start else { return String::new() };
    match variable.kind {
        Kind::Real(of) => quantity(start, of, variable),
        Kind::Enumeration(of) => {
            let item = of.items.iter().find(|(id, ..)| f64::from(*id) == start);
            item.map_or_else(|| number(start), |(_, name, _)| escape(name))
        }
        Kind::Integer | Kind::Boolean => number(start),
    }
}

fn range(variable: &Variable) -> String {
    match (variable.min, variable.max) {
        (Some(min), Some(max)) => format!("{} … {}", number(min), number(max)),
        (Some(min), None) => format!("≥ {}", number(min)),
        (None, Some(max)) => format!("≤ {}", number(max)),
        (None, None) => String::new(),
    }
}
