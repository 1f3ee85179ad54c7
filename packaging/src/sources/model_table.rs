//! `model.h` and `model.c`: the table of a model for the C around its module.

use std::fmt::Write;

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Kind, Role, Table, Variable};
use pneumatic_servo_fmu::guid_of_source;
use pneumatic_servo_fmu::self_test::{STEP, STEPS, fingerprint, inputs};

/// The header: names, GUID, the fingerprint of the self-test, value references, and structures of inputs and outputs. A library that
/// is not the project's has the fingerprint of a source of its own, a loop alone has the size of its heap.
///
/// # Errors
/// When the run of the self-test fails.
pub fn header(model: &'static Model, source: Option<&str>, heap: Option<usize>) -> Result<String> {
    let (name, table) = (model.name, model.table());
    let fingerprint = fingerprint(model).with_context(|| format!("the self-test of {name} fails here"))?;
    let (inputs, outputs) = (of_role(table, Role::Input), of_role(table, Role::Output));
    let mut text = format!(
        "/** @file model.h\n *  @brief {name}: {}.\n *\n *  The licences are in the folder documentation/licenses of the FMU. */\n\
         #ifndef MODEL_H\n\
         #define MODEL_H\n\n\
         #include <stdbool.h>\n\
         #include <stdint.h>\n\n\
         /** @brief What all symbols begin with, so that models do not get into each other's way. */\n\
         #define MODEL_PREFIX {name}_\n\
         #define PLANT_NAME(symbol) {name}_##symbol\n\
         /* CMake defines this where it makes a shared library, in which functions have the names of the standard. */\n\
         #ifdef {name}_EXPORTS\n\
         #define MODEL_IS_SHARED\n\
         #endif\n\
         #define MODEL_GUID \"{}\"\n\
         /* What the self-test gives where numbers are computed exactly. */\n\
         #define MODEL_FINGERPRINT 0x{fingerprint:016x}ull\n\n\
         /* How many variables, inputs, parameters, computed variables and outputs there are. */\n\
         #define PLANT_VARIABLES {}u\n#define PLANT_INPUTS {}u\n#define PLANT_PARAMETERS {}u\n#define PLANT_COMPUTED {}u\n\
         #define PLANT_OUTPUTS {}u\n\n\
         /** @brief Value references. */\n\
         enum {{\n",
        model.description,
        guid_of_source(model, source),
        listed(table).count(),
        inputs.len(),
        table.parameters().filter(|variable| variable.chooses.is_none()).count(),
        table.computed().count(),
        outputs.len(),
    );
    if let Some(heap) = heap {
        text = text.replace("/** @brief Value references", &format!("/* Bytes for what a run takes; PLANT_HEAP is another number of them. */\n#define MODULE_HEAP {heap}u\n\n/** @brief Value references"));
    }
    let references =
        table.iter().map(|variable| format!("    REF_{} = {}", identifier(&variable.name), variable.reference));
    text += &references.collect::<Vec<_>>().join(",\n");
    text += "\n};\n\n";
    for (structure, what, fields) in [("PlantInputs", "All inputs", &inputs), ("PlantOutputs", "All outputs", &outputs)]
    {
        writeln!(text, "/** @brief {what}. */\ntypedef struct {{")?;
        for variable in fields {
            let unit = unit(variable);
            let unit = if unit.is_empty() { String::new() } else { format!(", in {unit}") };
            let (of, name) = (type_in_c(variable.kind), identifier(&variable.name));
            writeln!(text, "    {of} {name}; /**< {}{unit}. */", in_comment(&variable.description))?;
        }
        if fields.is_empty() {
            text += "    char none; /**< There are none. */\n";
        }
        writeln!(text, "}} {structure};\n")?;
    }
    text += "#endif\n";
    Ok(text)
}

/// The table of the variables in the order of their value references, what is in the structures, and the inputs of the self-test.
///
/// # Errors
/// When a table has more values than a slot can number.
pub fn table(model: &'static Model) -> Result<String> {
    let table = model.table();
    let mut text =
        "/* Made from the model in Rust. */\n#include \"plant.h\"\n\nconst PlantVariable plant_variables[] = {\n"
            .to_owned();
    let slots = Slots::of(table);
    let mut variables: Vec<&Variable> = listed(table).collect();
    variables.sort_by_key(|variable| variable.reference);
    for variable in variables {
        let (min, max) = range(variable);
        let role = match variable.role {
            Role::Time => "PLANT_TIME",
            Role::Input => "PLANT_INPUT",
            Role::Fixed => "PLANT_FIXED",
            Role::Tunable => "PLANT_TUNABLE",
            Role::Output => "PLANT_OUTPUT",
            Role::Local => "PLANT_LOCAL",
        };
        let of = match variable.kind {
            Kind::Real(_) => "PLANT_REAL",
            Kind::Integer => "PLANT_INTEGER",
            Kind::Boolean => "PLANT_BOOLEAN",
            Kind::Enumeration(_) => "PLANT_ENUMERATION",
        };
        let slot = u16::try_from(slots.of_variable(variable)).context("more values than a slot can number")?;
        let (name, unit, reference) = (&variable.name, unit(variable), variable.reference);
        let start = if variable.is_computed() { 0.0 } else { variable.start.unwrap_or_default() };
        let [start, min, max] = [start, min, max].map(number);
        writeln!(text, "    {{\"{name}\", \"{unit}\", {start}, {min}, {max}, {reference}u, {slot}u, {role}, {of}}},")?;
    }
    text += "};\n\n";
    let outputs = of_role(table, Role::Output);
    let places: Vec<String> = outputs.iter().map(|variable| slots.of_variable(variable).to_string()).collect();
    writeln!(text, "const uint16_t plant_output_slots[] = {{{}}};\n", listed_or_zero(&places))?;
    text += "void plant_inputs_of(const PlantInputs *inputs, double *values) {\n    (void)inputs, (void)values;\n";
    for (place, variable) in of_role(table, Role::Input).into_iter().enumerate() {
        writeln!(text, "    values[{place}] = (double)inputs->{};", identifier(&variable.name))?;
    }
    text +=
        "}\n\nvoid plant_outputs_of(const double *values, PlantOutputs *outputs) {\n    (void)outputs, (void)values;\n";
    for (place, variable) in outputs.into_iter().enumerate() {
        let value = match variable.kind {
            Kind::Real(_) => format!("values[{place}]"),
            Kind::Boolean => format!("values[{place}] != 0.0"),
            Kind::Integer | Kind::Enumeration(_) => format!("(int32_t)values[{place}]"),
        };
        writeln!(text, "    outputs->{} = {value};", identifier(&variable.name))?;
    }
    text += "}\n\n";
    let tested: Vec<String> = (0..STEPS).flat_map(|step| inputs(model, step)).map(number).collect();
    writeln!(text, "#if PLANT_SELF_TEST\nconst double plant_test_step = {};", number(STEP))?;
    writeln!(text, "const unsigned plant_test_steps = {STEPS}u;")?;
    writeln!(text, "const double plant_test_inputs[] = {{{}}};\n#endif", listed_or_zero(&tested))?;
    Ok(text)
}

/// Numbers one behind another; C has no array without any.
fn listed_or_zero(numbers: &[String]) -> String {
    if numbers.is_empty() { "0".to_owned() } else { numbers.join(", ") }
}

/// The places of the values of all variables, one behind another: of inputs, of parameters, of what is computed.
struct Slots<'a>(Vec<&'a str>);

impl<'a> Slots<'a> {
    fn of(table: &'a Table) -> Self {
        let parameters = table.parameters().filter(|variable| variable.chooses.is_none());
        Self(table.inputs().chain(parameters).chain(table.computed()).map(|variable| &*variable.name).collect())
    }

    /// The index of a variable; 0 for the time, which has none.
    fn of_variable(&self, variable: &Variable) -> usize {
        self.0.iter().position(|name| *name == variable.name).unwrap_or_default()
    }
}

/// The variables that C knows: all but the integers that choose by number, since in C all choices are numbers.
fn listed(table: &Table) -> impl Iterator<Item = &Variable> {
    table.iter().filter(|variable| variable.chooses.is_none())
}

fn of_role(table: &Table, role: Role) -> Vec<&Variable> {
    table.iter().filter(|variable| variable.role == role).collect()
}

fn type_in_c(kind: Kind) -> &'static str {
    match kind {
        Kind::Real(_) => "double",
        Kind::Boolean => "bool",
        Kind::Integer | Kind::Enumeration(_) => "int32_t",
    }
}

fn unit(variable: &Variable) -> &'static str {
    match variable.kind {
        Kind::Real(unit) => unit.name,
        _ => "",
    }
}

/// The smallest and the largest value that is accepted.
fn range(variable: &Variable) -> (f64, f64) {
    let (min, max) = match variable.kind {
        Kind::Real(_) => (-f64::MAX, f64::MAX),
        Kind::Boolean => (0.0, 1.0),
        Kind::Integer => (f64::from(i32::MIN), f64::from(i32::MAX)),
        Kind::Enumeration(of) => {
            let ids = || of.items.iter().map(|(id, ..)| f64::from(*id));
            (ids().fold(f64::INFINITY, f64::min), ids().fold(f64::NEG_INFINITY, f64::max))
        }
    };
    (variable.min.unwrap_or(min), variable.max.unwrap_or(max))
}

/// A number as C reads it, with all its bits.
fn number(value: f64) -> String {
    format!("{value:e}")
}

fn in_comment(text: &str) -> String {
    text.replace("*/", "* /")
}

/// A name as an identifier of C: `friction.law` is `friction_law`, `der(position)` is `der_position`.
fn identifier(name: &str) -> String {
    let words = name.split(|letter: char| !letter.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("_")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use pneumatic_servo::models;

    #[test]
    fn every_variable_has_an_identifier_of_its_own() -> Result<()> {
        assert_eq!(identifier("friction.gms.k[10]"), "friction_gms_k_10");
        assert_eq!(identifier("der(position)"), "der_position");
        for model in models::ALL {
            let names: Vec<_> = model.table().iter().map(|variable| identifier(&variable.name)).collect();
            assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "{}", model.name);
            let text = header(model, None, None)?;
            let (_, listed) = text.split_once("enum {\n").context("no references")?;
            let (listed, _) = listed.split_once("\n};\n").context("no end")?;
            let lines = names.iter().zip(model.table()).map(|(name, it)| format!("    REF_{name} = {}", it.reference));
            assert_eq!(listed.split(",\n").collect::<Vec<_>>(), lines.collect::<Vec<_>>());
        }
        Ok(())
    }

    /// Every variable has its line, in the order in which they are looked up, and every value a slot of its own.
    #[test]
    fn table_has_every_variable_in_order() -> Result<()> {
        for model in models::ALL {
            let text = table(model)?;
            let lines: Vec<&str> = text.lines().filter(|line| line.starts_with("    {\"")).collect();
            let fields: Vec<Vec<&str>> = lines.iter().map(|line| line.split(", ").collect()).collect();
            let numbers = |place: usize| {
                fields
                    .iter()
                    .map(|fields| fields[place].trim_end_matches('u').parse::<usize>())
                    .collect::<Result<Vec<_>, _>>()
            };
            let (references, slots) = (numbers(5)?, numbers(6)?);
            assert!(references.is_sorted() && references.len() == listed(model.table()).count(), "{}", model.name);
            // The time has the first slot, too, and uses none.
            assert_eq!(slots[1..].iter().collect::<BTreeSet<_>>().len(), slots.len() - 1, "{}", model.name);
            assert_eq!(slots.iter().max(), Some(&(slots.len() - 2)), "{}", model.name);
        }
        Ok(())
    }
}
