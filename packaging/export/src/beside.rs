//! The values of a machine for other tools.

use std::collections::BTreeMap;
use std::fmt::Write;

use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Kind, Variable};
use pneumatic_servo_ssp::xml::real;
use pneumatic_servo_variant::{Resolved, Variant, given};

use crate::page::values;

/// The files by name: JSON (which is YAML, too), a record of Modelica, and a script of MATLAB that adds the FMU to a model of
/// Simulink.
pub fn files(model: &Model, variant: &Variant, resolved: &Resolved) -> BTreeMap<String, String> {
    let stem = identifier(&variant.name);
    let values: Vec<_> = values(model, variant, resolved).collect();
    [
        (format!("{stem}.json"), json(variant, &values)),
        (format!("{stem}.mo"), modelica(&stem, variant, &values)),
        (format!("{stem}.m"), simulink(&stem, variant, &values)),
    ]
    .into()
}

/// A name as an identifier of all these languages.
fn identifier(name: &str) -> String {
    let plain: String = name.chars().map(|it| if it.is_ascii_alphanumeric() { it } else { '_' }).collect();
    if plain.starts_with(|first: char| first.is_ascii_alphabetic()) { plain } else { format!("M{plain}") }
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// A value, with items of enumerations as texts.
fn shown(variable: &Variable, value: f64) -> String {
    match variable.kind {
        Kind::Enumeration(_) => quoted(&given(variable, value).to_string()),
        Kind::Boolean => (value != 0.0).to_string(),
        Kind::Real(_) => real(value),
        Kind::Integer => format!("{value:.0}"),
    }
}

fn json(variant: &Variant, values: &[(&'static Variable, f64)]) -> String {
    let lines: Vec<_> =
        values.iter().map(|(it, value)| format!("    {}: {}", quoted(&it.name), shown(it, *value))).collect();
    format!(
        "{{\n  \"name\": {},\n  \"model\": {},\n  \"values\": {{\n{}\n  }}\n}}\n",
        quoted(&variant.name),
        quoted(&variant.model),
        lines.join(",\n")
    )
}

/// A record whose components are named as the variables, with underscores for what an identifier cannot have.
fn modelica(stem: &str, variant: &Variant, values: &[(&'static Variable, f64)]) -> String {
    let mut text = format!("record {stem} {}\n", quoted(&format!("Parameters of {}, in SI units", variant.name)));
    for (variable, value) in values {
        let typed = match variable.kind {
            Kind::Real(unit) => format!("Real {}(unit={})", identifier(&variable.name), quoted(unit.name)),
            Kind::Integer => format!("Integer {}", identifier(&variable.name)),
            Kind::Boolean => format!("Boolean {}", identifier(&variable.name)),
            Kind::Enumeration(_) => format!("String {}", identifier(&variable.name)),
        };
        let comment = quoted(&format!("{}: {}", variable.name, variable.description));
        let _ = writeln!(text, "  parameter {typed} = {} {comment};", shown(variable, *value));
    }
    text + &format!("end {stem};\n")
}

/// Three lines that add the FMU, then those that set what stays settable, as an example.
fn simulink(stem: &str, variant: &Variant, values: &[(&'static Variable, f64)]) -> String {
    let mut text = format!(
        "% Adds {name} to a model of Simulink.\nnew_system('{stem}_model');\n\
         add_block('simulink_extras/FMU Import/FMU', '{stem}_model/{stem}', 'FMUName', '{stem}.fmu');\n\
         open_system('{stem}_model');\n",
        name = variant.name
    );
    let settable = values.iter().filter(|(it, _)| variant.parameters.contains(&it.name));
    for (variable, value) in settable {
        let _ = writeln!(text, "% {} = {}", variable.name, shown(variable, *value));
    }
    text
}
