//! Tables of variables, parameters and enumerations.

use pneumatic_servo::variables::{Case, Kind, Role, Table, Variable};

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

/// A section with one table per group of parameters. Groups that count for one choice alone can be opened; the default
/// choice's is open.
pub fn parameters(variables: &Table) -> String {
    let parameters: Vec<_> = variables.parameters().collect();
    fn place(variable: &Variable) -> (&str, Option<Case>) {
        (variable.group_and_name().0, variable.counts_for)
    }
    let mut places = Vec::new();
    for variable in &parameters {
        if !places.contains(&place(variable)) {
            places.push(place(variable));
        }
    }
    // In the order of the table, but parameters without a group first.
    places.sort_by_key(|(group, _)| !group.is_empty());
    let tables = places.iter().map(|(group, case)| {
        let members: Vec<_> = parameters.iter().copied().filter(|it| place(it) == (group, *case)).collect();
        let (name, rows) = (escape(group), rows(&members));
        match case.and_then(|case| Some((case, variables.case(case)?))) {
            Some((case, (choice, item))) => {
                let open = if choice.start == Some(case.item.into()) { " open" } else { "" };
                let (choice, item) = (escape(&choice.name), escape(item));
                format!(
                    "<details id=\"{name}\"{open}>\n<summary><code>{name}</code> for <code>{choice}</code> = \
                     <code>{item}</code></summary>\n{rows}</details>\n"
                )
            }
            None if group.is_empty() => rows,
            None => format!("<h3><code>{name}</code></h3>\n{rows}"),
        }
    });
    format!(
        "<section id=\"parameters\">\n<h2>Parameters</h2>\n<p>Tunable parameters may be changed between steps; all \
         others are fixed once initialization ends.{}</p>\n{}</section>\n",
        if places.iter().any(|(_, case)| case.is_some()) { SOME_ARE_FOLDED } else { "" },
        tables.collect::<String>()
    )
}

const SOME_ARE_FOLDED: &str =
    " Some groups count for one choice alone, named beside them: open the group of your choice.";

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

#[cfg(test)]
mod tests {
    use pneumatic_servo::friction::Law;
    use pneumatic_servo::variables::units;

    use super::*;

    /// Names do not decide: the groups of any model are folded by the choices that they count for.
    #[test]
    fn groups_that_count_for_one_choice_are_folded() {
        let [lugre, dahl] = [Law::LuGre, Law::Dahl].map(pneumatic_servo::variables::Choice::id);
        let parameter = |reference, name| Variable::parameter(reference, name, units::ONE, 1.0);
        let table = Table::new(vec![
            Variable::choice(1, "tyre.law", Law::LuGre),
            parameter(2, "rubber.stiffness").counts_for(1, lugre),
            parameter(3, "rubber.wear"),
            parameter(4, "cord.stiffness").counts_for(1, dahl),
            parameter(5, "friction.pads.width"),
        ]);
        assert_eq!(table.problem(), None);
        let section = parameters(&table);
        let folded = |group: &str, law: &str| format!("<details id=\"{group}\"{law}</code></summary>");
        for title in [
            folded("rubber", " open>\n<summary><code>rubber</code> for <code>tyre.law</code> = <code>LuGre"),
            folded("cord", ">\n<summary><code>cord</code> for <code>tyre.law</code> = <code>Dahl"),
            "<h3><code>rubber</code></h3>".to_owned(),
            "<h3><code>friction.pads</code></h3>".to_owned(),
        ] {
            assert_eq!(section.matches(&title).count(), 1, "{title}\n{section}");
        }
        assert_eq!(section.matches("<details").count(), 2, "{section}");
        assert!(section.contains(SOME_ARE_FOLDED) && !parameters(&Table::new(Vec::new())).contains(SOME_ARE_FOLDED));
    }

    #[test]
    fn each_enumeration_that_is_used_is_listed_once_with_its_items() {
        let table = [Variable::choice(1, "tyre.law", Law::LuGre), Variable::choice(2, "seal.law", Law::Dahl)];
        let section = enumerations(&table);
        assert!(section.starts_with("<section id=\"choices\">"), "{section}");
        for (id, name) in [(1, "None"), (2, "Coulomb"), (14, "LuGre")] {
            assert_eq!(section.matches(&format!("<tr><td>{id}</td><td><code>{name}</code></td>")).count(), 1, "{name}");
        }
        assert_eq!(enumerations(&[Variable::parameter(1, "gap", units::METRE, 1.0)]), "");
    }

    /// The parameters without a group come first, without a heading; each group has its own, and no others.
    #[test]
    fn parameters_are_below_the_headings_of_their_groups() {
        let parameter = |reference, name| Variable::parameter(reference, name, units::METRE, 1.0);
        let table = Table::new(vec![parameter(1, "rubber.wear"), parameter(2, "gap"), parameter(3, "cord.width")]);
        let section = parameters(&table);
        let row = |name: &str| {
            format!(
                "<tr><td><code>{name}</code></td><td>m</td><td class=\"value\">1 m</td><td class=\"value\"></td><td></td></tr>\n"
            )
        };
        let of = |name: &str| {
            let head =
                "<thead><tr><th>Name</th><th>Unit</th><th>Default</th><th>Range</th><th>Meaning</th></tr></thead>";
            format!("{TABLE}\n{head}\n<tbody>\n{}</tbody>\n{END}\n", row(name))
        };
        let expected = [
            &*of("gap"),
            "<h3><code>rubber</code></h3>\n",
            &*of("rubber.wear"),
            "<h3><code>cord</code></h3>\n",
            &*of("cord.width"),
            "</section>\n",
        ];
        assert_eq!(section.split_once("</p>\n").map(|(_, tables)| tables), Some(&*expected.concat()));
    }

    /// The rows, each with what stands for the unit, the default, the range and the meaning.
    #[test]
    fn variables_of_each_kind_have_a_row() {
        let length = Variable::parameter(1, "a", units::METRE, 0.25).shown_in("mm").text("A & B").tunable();
        for (variable, cells) in [
            (length.clone(), ["m", "0.25 m <small>(250 mm)</small>", "", "A &amp; B <em>Tunable.</em>"]),
            (
                length.clone().range(0.0, 2.0),
                ["m", "0.25 m <small>(250 mm)</small>", "0 … 2", "A &amp; B <em>Tunable.</em>"],
            ),
            (Variable::parameter(1, "a", units::ONE, 0.5).at_least(0.1), ["", "0.5", "≥ 0.1", ""]),
            (Variable { max: Some(-3.0), ..Variable::count(1, "a", -4) }, ["integer", "−4", "≤ −3", ""]),
            (Variable { start: Some(1.0), ..Variable::flag(1, "a") }, ["Boolean", "1", "", ""]),
            (Variable::choice(1, "a", Law::Dahl), ["FrictionLaw", "Dahl", "", ""]),
            (Variable { start: Some(0.5), ..Variable::choice(1, "a", Law::Dahl) }, ["FrictionLaw", "0.5", "", ""]),
        ] {
            let [unit, default, range, text] = cells;
            let row = format!(
                "<tr><td><code>a</code></td><td>{unit}</td><td class=\"value\">{default}</td><td class=\"value\">{range}</td>\
                 <td>{text}</td></tr>"
            );
            let found = rows(&[&variable]);
            assert!(found.contains(&row), "{row}\n{found}");
        }
        // A variable without default in a table with defaults, and a table without any.
        let output = Variable::output(2, "b", units::METRE);
        let empty =
            "<tr><td><code>b</code></td><td>m</td><td class=\"value\"></td><td class=\"value\"></td><td></td></tr>";
        assert!(rows(&[&length, &output]).contains(empty));
        let plain = rows(&[&output]);
        assert!(plain.contains("<tr><td><code>b</code></td><td>m</td><td></td></tr>"), "{plain}");
        assert!(plain.contains("<th>Name</th><th>Unit</th><th>Meaning</th>"), "{plain}");
    }

    #[test]
    fn a_section_without_variables_is_left_out() {
        assert_eq!(interface("inputs", "Inputs", &[]), "");
        let output = Variable::output(2, "b", units::METRE);
        let section = interface("outputs", "Outputs", &[&output]);
        assert!(section.starts_with("<section id=\"outputs\">\n<h2>Outputs</h2>\n<div"), "{section}");
        assert!(section.ends_with("</div>\n</section>\n"), "{section}");
    }
}
