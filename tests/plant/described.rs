//! Files of `modelDescription`: variables and experiments agree with the models.

use std::collections::BTreeMap;

use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Role, Table, Variable};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

/// Attributes of a variable and of its type, by name, numbers in one form; and the name of the type.
type Facts = BTreeMap<String, String>;

#[test]
fn descriptions_say_of_each_variable_what_its_table_says() {
    for model in models::ALL {
        let (table, described) = (model.table(), described(model));
        let started = model.started_variables().expect("defaults that fit");
        let mut told = described.iter();
        // The description for FMI 2.0 leaves the independent variable out.
        for variable in started.iter().filter(|variable| variable.role != Role::Time) {
            assert_eq!(told.next(), Some(&stated(table, variable)), "{}: cargo xtask describe", model.name);
        }
        assert_eq!(told.next(), None, "{}: cargo xtask describe", model.name);
    }
}

#[test]
fn experiments_are_those_of_the_models() {
    let text =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/modelDescription/experiments.json")).unwrap();
    let mut written: BTreeMap<String, serde_json::Value> = serde_json::from_str(&text).unwrap();
    for model in models::ALL {
        let stated = serde_json::to_value(model.experiment).unwrap();
        assert_eq!(written.remove(model.name), Some(stated), "{}", model.name);
    }
    assert!(written.is_empty(), "{written:?}");
}

/// Facts in the table about a variable.
fn stated(table: &Table, variable: &Variable) -> Facts {
    let causality = match variable.role {
        Role::Time => unreachable!("it is left out"),
        Role::Input => "input",
        Role::Fixed | Role::Tunable => "parameter",
        Role::Output => "output",
        Role::Local => "local",
    };
    let (kind, unit, of) = match variable.kind {
        Kind::Real(unit) => ("Real", Some(unit.name), None),
        Kind::Integer => ("Integer", None, None),
        Kind::Boolean => ("Boolean", None, None),
        Kind::Enumeration(of) => ("Enumeration", None, Some(of.name)),
    };
    let mut listed = table.iter().filter(|variable| variable.role != Role::Time);
    let place = |reference: u32| listed.position(|variable| variable.reference == reference);
    let number = |value: Option<f64>| value.map(|value| format!("{value:?}"));
    let texts = [
        ("name", Some(variable.name.as_str())),
        ("description", Some(variable.description.as_str())),
        ("causality", Some(causality)),
        ("type", Some(kind)),
        ("unit", unit),
        ("displayUnit", variable.display),
        ("declaredType", of),
    ];
    let numbers = [
        ("valueReference", number(Some(f64::from(variable.reference)))),
        ("min", number(variable.min.filter(|_| of.is_none()))),
        ("max", number(variable.max.filter(|_| of.is_none()))),
        ("nominal", number(variable.nominal)),
        ("start", number(variable.start)),
        // Counted from 1.
        ("derivative", number(variable.derivative_of.and_then(place).map(|place| place as f64 + 1.0))),
    ];
    let texts = texts.into_iter().map(|(name, text)| (name, text.map(str::to_string)));
    texts.chain(numbers).filter_map(|(name, value)| Some((name.to_string(), value?))).collect()
}

/// Facts in the description about each variable.
fn described(model: &Model) -> Vec<Facts> {
    let file = format!("{}/modelDescription/{}.xml", env!("CARGO_MANIFEST_DIR"), model.name);
    let text = std::fs::read_to_string(&file).expect(&file);
    let mut reader = Reader::from_str(&text);
    let (mut variables, mut own) = (Vec::new(), None);
    loop {
        match reader.read_event().expect(&file) {
            Event::Start(tag) if tag.name().as_ref() == "ScalarVariable" => own = Some(facts(&tag)),
            Event::Empty(tag) => variables.extend(own.take().map(|own| {
                let kind = [("type".to_string(), tag.name().as_ref().to_string())];
                own.into_iter().chain(facts(&tag)).chain(kind).collect::<Facts>()
            })),
            Event::Eof => return variables,
            _ => {}
        }
    }
}

/// The attributes of a tag, but for those that follow from the others.
fn facts(tag: &BytesStart) -> Facts {
    let all = tag.attributes().map(|attribute| {
        let attribute = attribute.expect("an attribute");
        let value = attribute.normalized_value(XmlVersion::Explicit1_0).expect("a value");
        let number = match &*value {
            "true" => Some(1.0),
            "false" => Some(0.0),
            number => number.parse::<f64>().ok(),
        };
        let name = attribute.key.as_ref().to_string();
        let is_number = !["unit", "name", "description"].contains(&name.as_str());
        let value = number.filter(|_| is_number).map_or(value.into_owned(), |number| format!("{number:?}"));
        (name, value)
    });
    all.filter(|(name, _)| !["variability", "initial", "reinit"].contains(&name.as_str())).collect()
}
