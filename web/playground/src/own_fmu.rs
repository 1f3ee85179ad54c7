//! The machine of the page as an FMU of its own, as the Python package writes it.

use std::collections::BTreeMap;

use pneumatic_servo::models;
use pneumatic_servo_export::{
    Experiment, Interface, Machine, Preset, Refused, export, export_system, is_system, model,
};
use pneumatic_servo_variant::Given;
use serde_json::Value;

/// The file for a released one: an FMU for an FMU, a system for a system. The question has `name`, `preset`, `values` by model and
/// variable in SI units and numbers of items, `parts` with the model of each component of a system, `sections` of HTML for the
/// documentation page, and, unless the preset says them, lists of names `inputs`, `outputs`, `parameters`.
///
/// # Errors
/// In words for the visitor, for a question that is none, and what the export refuses.
pub fn own_fmu(question: &str, source: &[u8]) -> Result<Vec<u8>, String> {
    let question: Value =
        serde_json::from_str(question).map_err(|error| format!("the question is no JSON: {error}"))?;
    let asked = read(&question).ok_or("the question is incomplete")?;
    asked.answer(source).map_err(|Refused(reason)| reason)
}

struct Asked {
    name: String,
    preset: String,
    values: BTreeMap<String, BTreeMap<String, f64>>,
    parts: BTreeMap<String, String>,
    kept: [Option<Vec<String>>; 3],
    sections: String,
}

impl Asked {
    fn answer(self, source: &[u8]) -> Result<Vec<u8>, Refused> {
        let models: Vec<_> = models::ALL.iter().collect();
        let of = |model: &str| self.values.get(model).into_iter().flatten();
        if is_system(source)? {
            let own = self.parts.iter().flat_map(|(part, model)| {
                of(model).map(move |(name, value)| (format!("{part}.{name}"), Given::Number(*value)))
            });
            return export_system(source, &models, &self.name, &own.collect());
        }
        let model = model(source, &models)?;
        let [inputs, outputs, parameters] = self.kept;
        let machine = Machine {
            name: self.name,
            values: of(model.name).map(|(name, value)| (name.clone(), Given::Number(*value))).collect(),
            interface: Interface { preset: Preset::named(&self.preset)?, inputs, outputs, parameters },
            experiment: Experiment::default(),
            sections: self.sections,
        };
        Ok(export(source, &models, &machine)?.fmu)
    }
}

fn read(question: &Value) -> Option<Asked> {
    let text = |key: &str| question[key].as_str().map(str::to_owned);
    let names = |key: &str| match &question[key] {
        Value::Null => Some(None),
        list => list.as_array()?.iter().map(|name| name.as_str().map(str::to_owned)).collect::<Option<_>>().map(Some),
    };
    let numbers = |of: &Value| {
        let values = of.as_object()?.iter();
        values.map(|(name, value)| Some((name.clone(), value.as_f64()?))).collect::<Option<_>>()
    };
    let (values, parts) = (question["values"].as_object()?.iter(), question["parts"].as_object()?.iter());
    Some(Asked {
        name: text("name")?,
        preset: text("preset")?,
        values: values.map(|(model, of)| Some((model.clone(), numbers(of)?))).collect::<Option<_>>()?,
        parts: parts.map(|(part, model)| Some((part.clone(), model.as_str()?.to_owned()))).collect::<Option<_>>()?,
        kept: [names("inputs")?, names("outputs")?, names("parameters")?],
        sections: text("sections")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUESTION: &str = r#"{"name": "Axis7", "preset": "all", "values": {"PneumaticServoCylinder": {"mass.moving": 2}},
        "parts": {"plant": "PneumaticServoCylinder"}, "sections": ""}"#;

    #[test]
    fn what_is_no_question_or_no_fmu_is_refused() {
        let refused = |question: &str| own_fmu(question, b"no archive").expect_err("a refusal");
        assert!(refused("{").starts_with("the question is no JSON"));
        for wrong in [
            "{}",
            QUESTION.replace("2}", "\"2\"}").as_str(),
            QUESTION.replace("\"all\"", "\"all\", \"inputs\": [1]").as_str(),
        ] {
            assert_eq!(refused(wrong), "the question is incomplete", "{wrong}");
        }
        assert!(refused(QUESTION).starts_with("the FMU cannot be read"));
    }
}
