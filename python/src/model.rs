//! Models and their variables.

use pneumatic_servo::model;
use pneumatic_servo::variables::{self, Following, Kind, Meaning, Role, Variable};
use pyo3::prelude::*;

use crate::failure::{refused, refused_value};
use crate::own;
use crate::simulation::Simulation;
use crate::value::{Setting, setup};

/// The names of all models.
#[pyfunction]
pub fn models() -> Vec<&'static str> {
    own::all().map(|model| model.name).collect()
}

/// The unit in which a value may be meant that is not between bounds in its SI unit, as the end of a sentence.
#[pyfunction]
#[pyo3(signature = (unit, value, low, high, shown, usual))]
pub fn meant(unit: &str, value: f64, low: f64, high: f64, shown: &str, usual: Option<f64>) -> String {
    variables::meant(unit, value, [low, high], shown, usual).unwrap_or_default()
}

/// The warning about variables without effect, or outputs that are 0 then, for what they lack.
#[pyfunction]
pub fn idle_warning(names: Vec<String>, lack: &str, are_outputs: bool) -> String {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    variables::idle_warning(&names, lack, are_outputs)
}

/// A model of the library.
#[pyclass(frozen, subclass)]
pub struct Model {
    pub model: &'static model::Model,
}

/// A variable as the Python package describes it.
#[derive(IntoPyObject)]
struct Description {
    name: &'static str,
    role: &'static str,
    kind: &'static str,
    unit: &'static str,
    start: Option<f64>,
    minimum: Option<f64>,
    maximum: Option<f64>,
    nominal: Option<f64>,
    /// Name, factor and offset of the unit to show the variable in.
    display: Option<(&'static str, f64, f64)>,
    /// Id, name and text of each item of an enumeration.
    items: &'static [(i32, &'static str, &'static str)],
    derivative_of: Option<&'static str>,
    /// What a parameter means to those that would know it by its name otherwise.
    meaning: Option<&'static str>,
    /// The enumeration parameter and its item for which alone a parameter counts.
    counts_for: Option<(&'static str, &'static str)>,
    /// The parameter that its default follows where it does not fit that, and whether in the proportion of both defaults.
    follows: Option<(&'static str, bool)>,
    /// Range of the values that rigs have.
    plausible: Option<(f64, f64)>,
    /// Whether it counts under conditions only.
    is_conditional: bool,
    text: &'static str,
}

#[pymethods]
impl Model {
    #[new]
    fn new(name: &str) -> PyResult<Self> {
        let found = own::all().find(|model| model.name == name);
        let model = found
            .ok_or_else(|| refused(format!("there is no model {name}; it must be one of {}", models().join(", "))))?;
        Ok(Self { model })
    }

    #[getter]
    fn name(&self) -> &'static str {
        self.model.name
    }

    #[getter]
    fn description(&self) -> &'static str {
        self.model.description
    }

    /// Stop time and step size in s of the default experiment.
    #[getter]
    fn experiment(&self) -> (f64, f64) {
        (self.model.experiment.stop_time, self.model.experiment.step_size)
    }

    /// All variables, in the order of the table; but not the numbers that stand for enumerations, which have names here.
    fn variables(&self) -> Vec<Description> {
        let shown = self.model.table().into_iter().filter(|variable| variable.chooses.is_none());
        shown.map(|variable| self.describe(variable)).collect()
    }

    /// The condition that each of some variables lacks to have an effect on runs with settings; empty where it counts.
    #[pyo3(signature = (settings, names))]
    fn lacks(&self, settings: Vec<Setting>, names: Vec<String>) -> PyResult<Vec<String>> {
        let (setup, table) = (setup(self.model, &settings)?, self.model.table());
        let lack = |name: &String| table.lack(table.find(name)?.variable, setup.parameters());
        Ok(names.iter().map(|name| lack(name).unwrap_or_default()).collect())
    }

    /// The warning about a legal value of a variable that is hardly meant; empty if there is none.
    fn doubt(&self, name: &str, value: f64) -> String {
        self.model.table().find(name).and_then(|entry| entry.variable.doubt(value)).unwrap_or_default()
    }

    /// The unit in which a value of a variable may be meant that is hardly plausible, as the end of a sentence.
    fn meant(&self, name: &str, value: f64) -> String {
        self.model.table().find(name).and_then(|entry| entry.variable.meant_beyond(value)).unwrap_or_default()
    }

    /// Starts a run at a time in s.
    #[pyo3(signature = (settings, time))]
    fn start(&self, settings: Vec<Setting>, time: f64) -> PyResult<Simulation> {
        let plant = setup(self.model, &settings)?.start(time).map_err(refused_value)?;
        Ok(Simulation::new(plant))
    }
}

impl Model {
    fn describe(&self, variable: &'static Variable) -> Description {
        let (kind, unit, items) = match variable.kind {
            Kind::Real(unit) => ("real", unit.name, &[][..]),
            Kind::Integer => ("integer", "1", &[][..]),
            Kind::Boolean => ("boolean", "1", &[][..]),
            Kind::Enumeration(of) => ("enumeration", "1", of.items),
        };
        let shown = match variable.kind {
            Kind::Real(unit) => {
                unit.display.iter().find(|shown| Some(shown.name) == variable.display).or(unit.display.first())
            }
            _ => None,
        };
        let table = self.model.table();
        let state = variable.derivative_of.and_then(|reference| table.by_reference(reference));
        Description {
            name: &variable.name,
            role: role(variable.role),
            kind,
            unit,
            start: variable.start,
            minimum: variable.min,
            maximum: variable.max,
            nominal: variable.nominal,
            display: shown.map(|shown| (shown.name, shown.factor, shown.offset)),
            items,
            derivative_of: state.map(|entry| entry.variable.name.as_str()),
            meaning: variable.meaning.map(meaning),
            counts_for: variable
                .counts_for
                .and_then(|case| table.case(case))
                .map(|(choice, item)| (choice.name.as_str(), item)),
            follows: table.leader(variable).map(|(leader, how)| (leader.name.as_str(), how == Following::InProportion)),
            plausible: variable.plausible.map(|[low, high]| (low, high)),
            is_conditional: variable.is_conditional(),
            text: &variable.description,
        }
    }
}

fn meaning(meaning: Meaning) -> &'static str {
    match meaning {
        Meaning::StaticFriction => "static friction",
        Meaning::CoulombFriction => "Coulomb friction",
        Meaning::StaticExcess => "static excess",
        Meaning::ViscousFriction => "viscous friction",
        Meaning::StribeckExponent => "Stribeck exponent",
        Meaning::FrictionLaw => "friction law",
        Meaning::Sampling => "sampling",
        Meaning::Solving => "solving",
    }
}

fn role(role: Role) -> &'static str {
    match role {
        Role::Time => "time",
        Role::Input => "input",
        Role::Fixed => "fixed",
        Role::Tunable => "tunable",
        Role::Output => "output",
        Role::Local => "local",
    }
}
