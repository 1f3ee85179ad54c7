//! The tables of README and docs, made from the variable tables.

use anyhow::{Context, Result, ensure};
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::models::{self, friction_observer};
use pneumatic_servo::variables::{Kind, Meaning, Role, Table as Variables, Variable};

/// A table in a page, between a mark with its name and the end mark.
struct Table {
    page: &'static str,
    name: &'static str,
    of: fn(&Variables) -> String,
}

/// Generated tables and their pages; all are about the cylinder, and made from its variables.
const TABLES: [Table; 7] = [
    Table { page: "README.md", name: "trajectories", of: trajectories },
    Table { page: "README.md", name: "names of the laws", of: names_of_laws },
    Table { page: "docs/friction-laws.md", name: "laws", of: laws },
    Table { page: "docs/parameters.md", name: "inputs", of: |variables| interface(variables, Role::Input) },
    Table { page: "docs/parameters.md", name: "outputs", of: |variables| interface(variables, Role::Output) },
    Table { page: "docs/parameters.md", name: "parameters", of: parameters },
    Table { page: "docs/observer.md", name: "ports", of: ports },
];

/// Cases of `tests/reference` of the cylinder, of its sensors and of the other models, each with a trajectory.
const CASES: [&str; 3] = [
    include_str!("../../../tests/reference/cases.json"),
    include_str!("../../../tests/reference/sensors.json"),
    include_str!("../../../tests/reference/systems.json"),
];

const END: &str = "<!-- end -->";

/// The pages with tables, as paths in the repository.
pub fn pages() -> Vec<&'static str> {
    let mut pages: Vec<_> = TABLES.iter().map(|table| table.page).collect();
    pages.dedup();
    pages
}

/// A page with its tables renewed.
///
/// # Errors
/// When the marks of a table are missing.
pub fn renewed(page: &str, text: &str) -> Result<String> {
    let variables = models::ALL[0].table();
    TABLES.iter().filter(|table| table.page == page).try_fold(text.to_owned(), |text, table| {
        let mark = format!("<!-- {}: written by `cargo xtask describe` -->", table.name);
        replace(&text, &mark, &(table.of)(variables)).with_context(|| page.to_owned())
    })
}

/// Puts a table between a mark and the end mark that follows it.
fn replace(text: &str, mark: &str, table: &str) -> Result<String> {
    let (before, rest) = text.split_once(mark).with_context(|| format!("the line {mark} is missing"))?;
    let end = rest.find(END).with_context(|| format!("{mark} is not followed by {END}"))?;
    ensure!(!rest[..end].contains("<!--"), "{mark} is not followed by its own {END}");
    Ok(format!("{before}{mark}\n{table}{}", &rest[end..]))
}

/// How many trajectories were computed independently.
fn trajectories(_: &Variables) -> String {
    let [cylinder, sensors, systems] = CASES.map(|cases| cases.matches("\"name\":").count());
    format!(
        "{} trajectories, computed independently of this code, are reproduced to 1 µm and 1 Pa at the default tolerance:\n\
         {cylinder} of the cylinder, {sensors} of its sensors, {systems} of the other models \
         ([how](tests/reference/README.md)).\n",
        cylinder + sensors + systems
    )
}

/// The names in one paragraph, in the order of their ids.
fn names_of_laws(_: &Variables) -> String {
    let names: Vec<_> = LAWS.items.iter().map(|(id, law, _)| format!("{id} `{law}`")).collect();
    wrapped(&names.join(", ")) + ".\n"
}

/// Lines of at most 118 characters.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_inclusive(", ") {
        if lines.last().is_some_and(|line| line.len() + word.trim_end().len() > 118) {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            line.push_str(word);
        }
    }
    lines.iter().map(|line| line.trim_end()).collect::<Vec<_>>().join("\n")
}

fn laws(variables: &Variables) -> String {
    let rows = LAWS.items.iter().map(|(id, law, summary)| {
        let members: Vec<_> = variables.parameters().filter(|it| of_law(variables, it) == Some(*id)).collect();
        let list: Vec<_> = members.iter().filter_map(|variable| parameter(variable, &members)).collect();
        format!("| {id} | `{law}` | {summary} | {} |\n", list.join(", "))
    });
    format!(
        "| id | `friction.law` | what it is | parameters (`friction.<group>.`) |\n|---|---|---|---|\n{}",
        rows.collect::<String>()
    )
}

/// The id of the law that a parameter belongs to.
fn of_law(variables: &Variables, parameter: &Variable) -> Option<i32> {
    let case = parameter.counts_for?;
    let (choice, _) = variables.case(case)?;
    (choice.meaning == Some(Meaning::FrictionLaw)).then_some(case.item)
}

/// A parameter and its default; an array stands where its first element is.
fn parameter(variable: &Variable, members: &[&Variable]) -> Option<String> {
    // Behind `friction.<group>.`; the points of a table have a side, too.
    let name = variable.name.splitn(3, '.').last().unwrap_or(&variable.name);
    match name.split_once('[') {
        None => Some(format!("`{name}` {}", shown(variable))),
        Some((array, "1]")) => Some(format!("`{array}[...]` {}", elements(variable, members))),
        Some(_) => None,
    }
}

/// The elements of an array from its first on; those at the end that are all the same are shown once.
fn elements(first: &Variable, members: &[&Variable]) -> String {
    let array = first.name.trim_end_matches("1]");
    let mut all: Vec<_> = members.iter().filter(|member| member.name.starts_with(array)).collect();
    while let [.., before, last] = all[..]
        && before.start == last.start
    {
        all.pop();
    }
    let (last, others) = all.split_last().map_or((first, &[][..]), |(last, others)| (**last, others));
    let others = others.iter().map(|member| number(member.start.unwrap_or_default()) + "; ");
    others.collect::<String>() + &shown(last)
}

/// Inputs or outputs with their units; inputs with their defaults.
fn interface(variables: &Variables, role: Role) -> String {
    let with_start = role == Role::Input;
    let rows = variables.iter().filter(|variable| variable.role == role).map(|variable| {
        let value = if with_start { shown(variable) } else { kind(variable) };
        format!("| `{}` | {value} | {} |\n", variable.name, variable.description)
    });
    let value = if with_start { "default" } else { "unit" };
    format!(
        "| {} | {value} | |\n|---|---|---|\n{}",
        if with_start { "input" } else { "output" },
        rows.collect::<String>()
    )
}

/// What the observer of the cylinder has beside the inputs and parameters of the cylinder, with units, or defaults where there are any.
fn ports(cylinder: &Variables) -> String {
    let own = friction_observer::MODEL.table().iter().filter(|it| cylinder.by_reference(it.reference).is_none());
    let row = |variable: &Variable| {
        let role = match variable.role {
            Role::Input => "input",
            Role::Output | Role::Local => "output",
            _ => "parameter",
        };
        let value = if variable.start.is_some() { shown(variable) } else { kind(variable) };
        format!("| {role} | `{}` | {value} | {} |\n", variable.name, variable.description)
    };
    format!("| | variable | unit, or default | |\n|---|---|---|---|\n{}", own.map(row).collect::<String>())
}

/// The unit of a real variable, the kind of any other.
fn kind(variable: &Variable) -> String {
    match variable.kind {
        Kind::Real(unit) if unit.name == "1" => String::new(),
        Kind::Real(unit) => unit.name.to_owned(),
        Kind::Integer => "integer".to_owned(),
        Kind::Boolean => "Boolean".to_owned(),
        Kind::Enumeration(of) => of.name.to_owned(),
    }
}

fn parameters(variables: &Variables) -> String {
    let own = variables.parameters().filter(|parameter| of_law(variables, parameter).is_none());
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
    use super::*;

    #[test]
    fn tables_of_all_pages_are_up_to_date() -> Result<()> {
        assert_eq!(pages(), ["README.md", "docs/friction-laws.md", "docs/parameters.md", "docs/observer.md"]);
        for page in pages() {
            let text = std::fs::read_to_string(pneumatic_servo_packaging::workspace::home().join(page))?;
            assert!(text == renewed(page, &text)?, "{page} is out of date: run `cargo xtask describe`");
        }
        Ok(())
    }

    #[test]
    fn missing_mark_is_named() {
        let error = renewed("docs/friction-laws.md", "no tables here").unwrap_err();
        assert!(format!("{error:#}").contains("docs/friction-laws.md: the line <!-- laws: written by"), "{error:#}");
    }

    #[test]
    fn lines_break_between_names() {
        let text = wrapped(&["twenty characters ab"; 7].join(", "));
        let lengths: Vec<_> = text.lines().map(str::len).collect();
        assert_eq!(lengths, [109, 42], "{text}");
        // 60 and 56 letters with a comma and a space make 118, the most that there are in a line.
        let longest = |second: usize| wrapped(&format!("{}, {}", "a".repeat(60), "b".repeat(second))).lines().count();
        assert_eq!([longest(56), longest(57)], [1, 2]);
    }
}
