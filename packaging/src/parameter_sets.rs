//! Sets of parameter values: read from `modelDescription/parameter_sets.json`, checked against the variable tables, and
//! written as JSON and as SSV, the parameter values of the standard SSP.

use std::io;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Kind, Role, Variable};
use pneumatic_servo_ssp::xml::{Xml, document};
use pneumatic_servo_ssp::{self as ssp, Parameter, Version};
use serde_json::{Map, Value, json};

use crate::description::TOOL;
use crate::files;
use crate::product::Parts;
use crate::timestamp::Timestamp;

/// Values for some variables of a model or of a system of models.
pub struct ParameterSet {
    /// The name, also of its files.
    pub name: String,
    /// Description of the set.
    description: String,
    /// Where the values are from, unless they are examples.
    source: Option<String>,
    /// The experiment that the values belong to: start, inputs, what is seen; every set with a source has one.
    experiment: Option<String>,
    values: Vec<Given>,
}

/// A value as the file states it.
struct Given {
    /// The variable, under the name that the set has for it.
    variable: Variable,
    value: Value,
    /// The number that stands for it.
    number: f64,
}

/// The sets of a model, in the order of the files of all folders.
///
/// # Errors
/// As [`of_owner`].
pub fn of(model: &Model, parts: &Parts) -> Result<Vec<ParameterSet>> {
    let mut sets = Vec::new();
    for folder in parts.folders().filter(|folder| folder.join(FILE).exists()) {
        sets.extend(of_owner(model.name, folder, |name| settable(model, name).cloned())?);
    }
    Ok(sets)
}

const FILE: &str = "parameter_sets.json";

/// The sets of a model or system, whose variables `find` knows by name.
///
/// # Errors
/// When the file cannot be read, or a set has a name or value that the variable tables do not allow.
pub fn of_owner(
    owner: &str,
    folder: &Path,
    find: impl Fn(&str) -> Result<Variable> + Copy,
) -> Result<Vec<ParameterSet>> {
    let file = folder.join(FILE);
    let text = files::text(&file)?;
    let sets: Vec<Value> = serde_json::from_str(&text).with_context(|| file.display().to_string())?;
    let sets = sets.iter().filter(|set| set["of"] == owner);
    sets.map(|set| ParameterSet::read(set, find)).collect::<Result<_>>().with_context(|| file.display().to_string())
}

impl ParameterSet {
    /// Reads a set whose variables `find` knows by name.
    ///
    /// # Errors
    /// When something is missing, or a name or value is not legal.
    pub fn read(set: &Value, find: impl Fn(&str) -> Result<Variable>) -> Result<Self> {
        let text = |key: &str| set[key].as_str().map(str::to_owned).with_context(|| format!("a set has no {key}"));
        let name = text("name")?;
        let values = set["values"].as_object().with_context(|| format!("{name} has no values"))?;
        let values = values.iter().map(|(variable, value)| {
            let variable = Variable { name: variable.clone(), ..find(variable)? };
            let number = number(&variable, value)?;
            Ok(Given { variable, value: value.clone(), number })
        });
        let values: Vec<_> = values.collect::<Result<_>>().with_context(|| format!("the set {name}"))?;
        ensure!(!values.is_empty(), "{name} is empty");
        let [source, experiment] = ["source", "experiment"].map(|key| text(key).ok());
        ensure!(source.is_none() || experiment.is_some(), "{name} has a source but no experiment");
        Ok(Self { name, description: text("description")?, source, experiment, values })
    }

    /// As JSON: names and values, with items of enumerations by name.
    ///
    /// # Errors
    /// When a value cannot be written.
    pub fn json(&self) -> Result<String> {
        let values: Map<String, Value> =
            self.values.iter().map(|given| (given.variable.name.clone(), given.value.clone())).collect();
        let set = json!({
            "name": self.name, "description": self.description, "source": self.source,
            "experiment": self.experiment, "values": values,
        });
        Ok(serde_json::to_string_pretty(&set)? + "\n")
    }

    /// As SSV.
    ///
    /// # Errors
    /// When the text cannot be written.
    pub fn ssv(&self, version: Version, timestamp: Timestamp) -> Result<String> {
        Ok(document(|xml| self.write(xml, version, "", timestamp))?)
    }

    /// Adds the start value of a variable under a name of its own.
    pub fn add_start(&mut self, name: &str, variable: &Variable) {
        let number = variable.start.unwrap_or_default();
        let variable = Variable { name: name.to_owned(), ..variable.clone() };
        self.values.push(Given { variable, value: json!(number), number });
    }

    /// Whether there are values for variables whose names start with `prefix`.
    pub fn has(&self, prefix: &str) -> bool {
        self.values.iter().any(|given| given.variable.name.starts_with(prefix))
    }

    /// The element of SSV with the values whose names start with `prefix`, which is left out.
    pub fn write(&self, xml: &mut Xml, version: Version, prefix: &str, timestamp: Timestamp) -> io::Result<()> {
        let parameters = self.values.iter().filter_map(|given| {
            let name = given.variable.name.strip_prefix(prefix)?;
            Some(Parameter::new(name, &given.variable, given.number))
        });
        let parameters = parameters.collect::<Result<_, _>>().map_err(io::Error::other)?;
        let parts = [Some(&self.description), self.source.as_ref(), self.experiment.as_ref()];
        let description = parts.into_iter().flatten().map(String::as_str).collect::<Vec<_>>().join("; ");
        let time = timestamp.iso();
        let (name, description, time) = (&self.name, &description, Some(&*time));
        ssp::ParameterSet { version, name, description, tool: TOOL, time, parameters }.write(xml)
    }
}

/// The parameter or input of a model.
///
/// # Errors
/// When the model has none of that name.
pub fn settable(model: &Model, name: &str) -> Result<&'static Variable> {
    let found = model.table().find(name).map(|entry| entry.variable);
    let found = found.filter(|variable| variable.is_parameter() || variable.role == Role::Input);
    found.with_context(|| format!("{} has no parameter or input {name}", model.name))
}

/// The value as a number, which the variable must accept.
fn number(variable: &Variable, value: &Value) -> Result<f64> {
    let number = match (variable.kind, value) {
        (Kind::Enumeration(of), Value::String(item)) => {
            let found = of.items.iter().find(|(_, name, _)| name == item);
            found.map(|(id, ..)| f64::from(*id)).with_context(|| format!("{} has no item {item}", of.name))?
        }
        (Kind::Real(_) | Kind::Integer, Value::Number(value)) => value.as_f64().context("a number out of range")?,
        (Kind::Boolean, Value::Bool(value)) => f64::from(*value),
        _ => bail!("{} cannot be {value}", variable.name),
    };
    variable.check(number)?;
    Ok(number)
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::models;

    use super::*;

    fn set(values: Value) -> Value {
        json!({ "name": "Test", "description": "", "source": "", "experiment": "", "values": values })
    }

    const CYLINDER: &Model = &models::pneumatic_servo_cylinder::MODEL;

    fn read(values: Value) -> Result<ParameterSet> {
        ParameterSet::read(&set(values), |name| settable(CYLINDER, name).cloned())
    }

    #[test]
    fn the_sets_of_the_repository_are_legal() -> Result<()> {
        let parts = Parts::of_the_project(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
        assert!(!of(CYLINDER, &parts)?.is_empty());
        let vibro_impact = of(&models::vibro_impact::MODEL, &parts)?;
        assert_eq!(vibro_impact.into_iter().map(|set| set.name).collect::<Vec<_>>(), ["Bifurcations"]);
        Ok(())
    }

    /// Identified values mean little without their source.
    #[test]
    fn set_with_a_source_states_its_experiment() {
        let mut set = set(json!({ "mass.moving": 0.88 }));
        set.as_object_mut().expect("an object").remove("experiment");
        let refused = ParameterSet::read(&set, |name| settable(CYLINDER, name).cloned());
        let error = refused.err().expect("a refusal");
        assert_eq!(error.to_string(), "Test has a source but no experiment");
    }

    #[test]
    fn unknown_names_and_illegal_values_are_named() {
        let cylinder = |values| read(values).err().map(|error| format!("{error:#}")).unwrap_or_default();
        assert!(cylinder(json!({ "mass.stuck": 1.0 })).contains("no parameter or input mass.stuck"));
        assert!(cylinder(json!({ "position": 1.0 })).contains("no parameter or input position"));
        assert!(cylinder(json!({ "friction.law": "Sticky" })).contains("FrictionLaw has no item Sticky"));
        assert!(cylinder(json!({ "friction.law": 7 })).contains("friction.law cannot be 7"));
        assert!(cylinder(json!({ "cylinder.bore": -0.016 })).contains("cylinder.bore = -0.016 is refused"));
    }

    /// The library's models have no switch, a user's may.
    #[test]
    fn switches_are_on_or_off() -> Result<()> {
        let switch = Variable { role: Role::Fixed, ..Variable::flag(1, "brake") };
        assert_eq!((number(&switch, &json!(true))?, number(&switch, &json!(false))?), (1.0, 0.0));
        let problem = number(&switch, &json!(1)).err().map(|error| error.to_string());
        assert_eq!(problem.as_deref(), Some("brake cannot be 1"));
        Ok(())
    }

    /// A connector of a system may have another name than its variable.
    #[test]
    fn start_value_is_added_under_its_own_name() -> Result<()> {
        let mut set = read(json!({ "mass.moving": 0.88 }))?;
        set.add_start("line", &Variable { start: Some(6.5e5), ..settable(CYLINDER, "supplyPressure")?.clone() });
        assert!(set.has("line") && !set.has("supplyPressure"));
        let written: Value = serde_json::from_str(&set.json()?)?;
        assert_eq!(written["values"], json!({ "mass.moving": 0.88, "line": 6.5e5 }));
        let ssv = set.ssv(Version::One, Timestamp::of_source(Path::new(env!("CARGO_MANIFEST_DIR")))?)?;
        assert!(
            ssv.contains("<ssv:Parameter name=\"line\">\n      <ssv:Real value=\"650000.0\" unit=\"Pa\"/>"),
            "{ssv}"
        );
        Ok(())
    }

    #[test]
    fn values_keep_their_bits_and_units() -> Result<()> {
        let values = json!({ "friction.law": "LuGre", "friction.lugre.sigma0": 1234.1, "valve.polarity": -1 });
        let set = read(values)?;
        let ssv = set.ssv(Version::One, Timestamp::of_source(Path::new(env!("CARGO_MANIFEST_DIR")))?)?;
        assert!(ssv.contains(r#"<ssv:Enumeration value="LuGre"/>"#), "{ssv}");
        assert!(ssv.contains(r#"<ssv:Real value="1234.1" unit="N/m"/>"#), "{ssv}");
        assert!(ssv.contains(r#"<ssv:Integer value="-1"/>"#), "{ssv}");
        assert!(ssv.contains(r#"<ssc:BaseUnit kg="1" s="-2"/>"#), "{ssv}");
        Ok(())
    }

    #[test]
    fn what_is_written_as_json_is_read_as_the_same_set() -> Result<()> {
        let given = set(json!({ "friction.law": "LuGre", "mass.moving": 0.88 }));
        let written = ParameterSet::read(&given, |name| settable(CYLINDER, name).cloned())?.json()?;
        assert_eq!(serde_json::from_str::<Value>(&written)?, given);
        Ok(())
    }
}
