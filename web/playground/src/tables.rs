//! The variable tables of all models as JSON, for everything that the page says about variables.

use std::collections::BTreeMap;

use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Enumeration, Kind, Role, Table, Unit, Variable};
use pneumatic_servo_fit::experiment::{self, KINDS, Offered, Range};
use pneumatic_servo_fit::machine_units::ALSO;
use pneumatic_servo_fit::record::UNITS;
use pneumatic_servo_fit::units::{PARTS, WHOLE, WRITTEN_UNITS, WrittenUnit, written_unit};
use serde_json::{Value, json};

/// Models with their variables, enumerations and units; models and variables in the order in which they are numbered.
pub fn tables() -> Value {
    let variables = || models::ALL.iter().flat_map(|model| model.table().iter());
    let mut units = BTreeMap::new();
    let mut enumerations = BTreeMap::new();
    for variable in variables() {
        match variable.kind {
            Kind::Real(of) => drop(units.insert(of.name, unit(&of))),
            Kind::Enumeration(of) => drop(enumerations.insert(of.name, enumeration(of))),
            Kind::Integer | Kind::Boolean => {}
        }
    }
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "models": models::ALL.iter().map(model).collect::<Vec<_>>(),
        "units": units,
        "signals": UNITS.into_iter().collect::<BTreeMap<_, _>>(),
        "experiments": KINDS.iter().map(experiment).collect::<Vec<_>>(),
        "written": WRITTEN_UNITS.iter().map(written).collect::<Vec<_>>(),
        "spellings": { "parts": PARTS, "whole": WHOLE },
        "enumerations": enumerations,
    })
}

fn experiment(kind: &experiment::Kind) -> Value {
    json!({
        "name": kind.name,
        "about": kind.about,
        "model": kind.table,
        "signals": kind.signals().collect::<Vec<_>>(),
        "machine": kind.machine,
        "options": kind.options().map(option).collect::<Vec<_>>(),
        "also": if kind.may_rotate() { json!(BTreeMap::from(ALSO)) } else { json!({}) },
    })
}

/// An option of a fit: a number in a unit, or one of items.
fn option(of: &Offered) -> Value {
    let (unit, is_positive, items) = match of.range {
        Range::Numbers { unit, is_positive } => (Some(unit), is_positive, None),
        Range::Items(items) => (None, false, Some(items)),
    };
    let si = unit.and_then(written_unit).map(|unit| unit.si);
    json!({
        "name": of.name,
        "about": of.about,
        "usual": of.usual,
        "unit": unit,
        "si": si,
        "isPositive": is_positive,
        "items": items,
    })
}

fn model(model: &Model) -> Value {
    json!({
        "name": model.name,
        "description": model.description,
        "experiment": model.experiment,
        "variables": shown(model).map(|it| variable(model.table(), it)).collect::<Vec<_>>(),
    })
}

/// All variables but the numbers that stand for enumerations, which come last: the page has the names.
fn shown(model: &Model) -> impl Iterator<Item = &'static Variable> {
    model.table().into_iter().filter(|variable| variable.chooses.is_none())
}

fn variable(table: &Table, variable: &Variable) -> Value {
    let (kind, of) = match variable.kind {
        Kind::Real(unit) => ("Real", Some(unit.name)),
        Kind::Integer => ("Integer", None),
        Kind::Boolean => ("Boolean", None),
        Kind::Enumeration(of) => ("Enumeration", Some(of.name)),
    };
    let role = match variable.role {
        Role::Time => "time",
        Role::Input => "input",
        Role::Fixed => "fixed",
        Role::Tunable => "tunable",
        Role::Output => "output",
        Role::Local => "local",
    };
    json!({
        "name": variable.name,
        "kind": kind,
        "of": of,
        "role": role,
        "description": variable.description,
        "start": variable.start,
        "min": variable.min,
        "max": variable.max,
        "display": variable.display,
        "countsFor": variable.counts_for.and_then(|case| Some(json!({ "choice": table.case(case)?.0.name, "item": case.item }))),
    })
}

fn unit(unit: &Unit) -> Value {
    let display =
        unit.display.iter().map(|shown| json!({ "name": shown.name, "factor": shown.factor, "offset": shown.offset }));
    json!({ "display": display.collect::<Vec<_>>() })
}

/// A unit as people write it: `si = factor * written + offset`.
fn written(unit: &WrittenUnit) -> Value {
    json!({ "name": unit.name, "si": unit.si, "factor": unit.factor, "offset": unit.offset })
}

fn enumeration(enumeration: &Enumeration) -> Value {
    let items = enumeration
        .items
        .iter()
        .map(|(id, name, description)| json!({ "id": id, "name": name, "description": description }));
    json!({ "description": enumeration.description, "items": items.collect::<Vec<_>>() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variable_is_there_with_its_number() {
        let tables = tables();
        for (index, model) in models::ALL.iter().enumerate() {
            let listed = &tables["models"][index];
            assert_eq!(listed["name"], model.name);
            for (place, variable) in shown(model).enumerate() {
                assert_eq!(model.table()[place], *variable);
                assert_eq!(listed["variables"][place]["name"], variable.name);
                assert_eq!(listed["variables"][place]["start"].as_f64(), variable.start);
            }
        }
        assert_eq!(tables["units"]["Pa"]["display"][0]["name"], "bar");
        assert_eq!(tables["enumerations"]["FrictionLaw"]["items"][6]["name"], "Stribeck");
    }

    #[test]
    fn page_reads_units_with_the_table_of_the_fit() {
        let tables = tables();
        let written = tables["written"].as_array().expect("units");
        let gauge = written.iter().find(|unit| unit["name"] == "barg").expect("a gauge pressure");
        assert_eq!([&gauge["factor"], &gauge["offset"]], [1e5, 101_325.0]);
        assert_eq!(written.len(), WRITTEN_UNITS.len());
        assert_eq!(tables["spellings"]["whole"][0], json!(["Nm", "N.m"]));
    }

    #[test]
    fn page_knows_experiments_by_the_table_of_the_fit() {
        let tables = tables();
        let experiments = tables["experiments"].as_array().expect("experiments");
        assert_eq!(experiments.len(), KINDS.len());
        for experiment in experiments {
            let signals = experiment["signals"].as_array().expect("signals");
            for signal in signals {
                assert!(tables["signals"][signal.as_str().expect("a name")].is_string(), "{signal} has no unit");
            }
            let of = models::ALL.iter().find(|model| experiment["model"] == model.name).expect("a model");
            for name in experiment["machine"].as_array().expect("parameters") {
                assert!(of.table().find(name.as_str().expect("a name")).is_some(), "{name}");
            }
        }
        let of = |name: &str| experiments.iter().find(|one| one["name"] == name).expect("an experiment");
        let options = |name: &str| -> Vec<String> {
            let all = of(name)["options"].as_array().expect("options").iter();
            all.map(|option| option["name"].as_str().expect("a name").to_owned()).collect()
        };
        assert_eq!(options("points"), ["rated"]);
        assert_eq!(options("motion"), ["width", "rated", "play", "segment"]);
        assert_eq!(options("force"), ["width", "smoothing", "rated", "segment", "inputs"]);
        assert_eq!(options("mechanical"), ["width", "smoothing", "segment"]);
        assert_eq!(options("rig"), ["width", "segment", "inputs"]);
        assert_eq!(of("rig")["options"][1]["si"], "s");
        assert_eq!((&of("force")["also"]["position"], &of("rig")["also"]), (&json!(["rad"]), &json!({})));
        assert_eq!(of("force")["signals"], json!(["time", "force", "position", "velocity", "normalForce"]));
    }

    /// Some values in SI units, and as a visitor reads them.
    #[test]
    fn shown_values_are_factor_times_value_plus_offset() {
        let tables = tables();
        for (unit, value, name, shown) in [
            ("K", 293.15, "degC", 20.0),
            ("K", 273.15, "degC", 0.0),
            ("Pa", 6e5, "bar", 6.0),
            ("m", 0.25, "mm", 250.0),
            ("m3/(s.Pa)", 2.1e-8, "dm3/(s.bar)", 2.1),
            // 1.185 g of air are a litre at the reference conditions.
            ("kg/s", 1.185e-3, "l/min(ANR)", 60.0),
            ("rad", std::f64::consts::PI, "deg", 180.0),
        ] {
            let display = tables["units"][unit]["display"].as_array().expect("display units");
            let found = display.iter().find(|it| it["name"] == name).expect("the display unit");
            let [factor, offset] = ["factor", "offset"].map(|key| found[key].as_f64().expect("a number"));
            let seen = factor * value + offset;
            assert!((seen - shown).abs() <= 1e-12 * value.max(shown), "{value} {unit}: {seen} {name}, not {shown}");
        }
    }
}
