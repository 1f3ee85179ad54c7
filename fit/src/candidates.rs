//! Fixed settings, sensors and clock of an experiment as candidates of what explains its residuals.

use pneumatic_servo::variables::{Kind, Role};

use crate::causes::{
    ALL_GAUGE, Candidates, Change, Choice, DAMPING_SPEED, GAUGE, MODEL, PRESSURES, is_clocked, suspected,
};
use crate::experiment::{Experiment, Given, OF_LOAD, parameter, sensors};
use crate::parameter::{Parameter, SPAN, Values};
use crate::record::unit_of;
use crate::runs::Runs;
use crate::units::STANDARD_ATMOSPHERE;

const CHAMBERS: [&str; 2] = ["chamberA.pressure", "chamberB.pressure"];
const SUPPLY: &str = "supplyPressure";

/// Candidates of an experiment: what is neither estimated nor measured, nor, of a sensor, known. Sensors are told by their names.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// Settings of the machine and parameters of its law, each as an estimated one that starts at its fixed value.
    pub settings: Vec<Parameter>,
    /// Properties of sensors.
    pub sensors: Vec<String>,
    /// Choices.
    pub choices: Vec<Choice>,
    /// Whether a wrong clock shows.
    pub has_clock: bool,
}

/// Candidates of an experiment beside the names that are estimated.
pub fn named(experiment: &dyn Experiment, estimated: &[String]) -> Named {
    let given = experiment.given();
    let is_estimated = |name: &str| estimated.iter().any(|one| one == name);
    let has_friction = given.kind.name != "pneumatic";
    let of_law = if has_friction { given.kind.usual(given.table, given.law, &given.known) } else { vec![] };
    let mut settings: Vec<String> = suspected(given.kind.name).into_iter().map(str::to_owned).collect();
    settings.extend(of_law);
    settings.retain(|name| !given.has(name) && !is_estimated(name));
    let mut own = sensors(experiment);
    own.retain(|name| !is_estimated(name) && !given.known.contains_key(name));
    let is_thermal = estimated.iter().any(|name| name.starts_with("thermal."));
    let model = model(given).filter(|_| !is_thermal);
    let damping = damping(given).filter(|_| has_friction && !experiment.is_steady() && !is_estimated(DAMPING_SPEED));
    Named {
        settings: settings.iter().filter_map(|name| freed(experiment, name)).collect(),
        sensors: own,
        choices: model.into_iter().chain(damping).chain(gauge(given, estimated)).collect(),
        has_clock: is_clocked(given.kind.name),
    }
}

/// Candidates of simulated segments.
pub fn candidates(runs: &Runs<'_>) -> Candidates {
    let tied = runs.ties.iter().map(|tie| &tie.name);
    let estimated: Vec<String> = runs.parameters.iter().map(|one| &one.name).chain(tied).cloned().collect();
    let Named { settings, sensors, choices, has_clock } = named(runs.experiment, &estimated);
    let sensors = sensors.iter().filter_map(|name| freed(runs.experiment, name)).collect();
    Candidates { settings, sensors, choices, has_clock }
}

/// Names of what may be estimated beside the parameters of the model: of sensors, of a bench, and of a load factor.
pub fn estimable(experiment: &dyn Experiment) -> Vec<String> {
    let given = experiment.given();
    let of_load = OF_LOAD.into_iter().filter(|name| given.table.table().find(name).is_none());
    let is_of_seal = |name: &&str| ["area", "friction.kappaA"].contains(name);
    let of_bench = experiment.of_bench().into_iter().chain(of_load);
    let of_bench = of_bench.filter(|name| given.has("pressure") || !is_of_seal(name)).map(str::to_owned);
    sensors(experiment).into_iter().chain(of_bench).collect()
}

/// The thermal model of a rig and the others.
fn model(given: &Given) -> Option<Choice> {
    let Kind::Enumeration(models) = given.model.table().find(MODEL)?.variable.kind else { return None };
    let own = given.value(MODEL, &Values::new());
    let (fixed, others): (Vec<_>, Vec<_>) = models.items.iter().partition(|(id, ..)| f64::from(*id) == own);
    let (_, name, _) = fixed.first()?;
    let others = others.into_iter().map(|(_, name, _)| (*name).to_owned()).collect();
    Some(Choice { name: MODEL.to_owned(), fixed: (*name).to_owned(), others })
}

/// Measured pressures of both chambers that count from the atmosphere.
fn gauge(given: &Given, estimated: &[String]) -> Option<Choice> {
    let chambers = CHAMBERS.map(|signal| format!("offset.{signal}"));
    let is_told = chambers.iter().any(|name| estimated.contains(name) || given.known.contains_key(name));
    if is_told || !CHAMBERS.iter().all(|signal| given.has(signal)) {
        return None;
    }
    let has_supply = given.model.table().find(SUPPLY).is_some() && !estimated.iter().any(|name| name == SUPPLY);
    let others = [GAUGE].into_iter().chain(has_supply.then_some(ALL_GAUGE)).map(str::to_owned).collect();
    Some(Choice { name: PRESSURES.to_owned(), fixed: "absolute".to_owned(), others })
}

/// Values in place of the known ones, if measured pressures count from the atmosphere.
pub fn gauge_values(experiment: &dyn Experiment, item: &str) -> Values {
    let given = experiment.given();
    let mut values: Values = CHAMBERS.iter().map(|signal| (format!("offset.{signal}"), -STANDARD_ATMOSPHERE)).collect();
    if item == ALL_GAUGE && given.has(SUPPLY) {
        let name = format!("offset.{SUPPLY}");
        let own = given.beside(&name, &Values::new(), 0.0);
        values.insert(name, own - STANDARD_ATMOSPHERE);
    } else if item == ALL_GAUGE {
        values.insert(SUPPLY.to_owned(), given.value(SUPPLY, &Values::new()) + STANDARD_ATMOSPHERE);
    }
    values
}

/// Both forms of LuGre: with a damping of the bristles that decays with speed, and with a constant one.
fn damping(given: &Given) -> Option<Choice> {
    if given.law_name() != "LuGre" {
        return None;
    }
    let usual = given.table.table().find(DAMPING_SPEED)?.variable.start?;
    let own = given.value(DAMPING_SPEED, &Values::new());
    let other = if own == 0.0 { usual } else { 0.0 };
    Some(Choice { name: DAMPING_SPEED.to_owned(), fixed: own.to_string(), others: vec![other.to_string()] })
}

/// A fixed property as an estimated one; nothing for one that is off, as a volume of 0.
fn freed(experiment: &dyn Experiment, name: &str) -> Option<Parameter> {
    let given = experiment.given();
    if let Some(entry) = given.table.table().find(name)
        && entry.variable.role == Role::Input
    {
        let start = given.value(name, &Values::new());
        let bounds = [start / SPAN, start * SPAN];
        return (start > 0.0).then(|| Parameter::of_input(name, unit_of(name), start, bounds));
    }
    let free = parameter(experiment, name).ok()?;
    let start = given.beside(name, &Values::new(), free.start);
    if free.is_logarithmic() && start <= 0.0 { None } else { Some(free.at(start)) }
}

impl<'a> Runs<'a> {
    /// Runs with a change.
    pub fn changed(&self, change: Change<'_>) -> Self {
        let mut runs = self.clone();
        match change {
            Change::Estimated(parameter) => runs.parameters.push(parameter.clone()),
            Change::Clock(clock) => runs.clock = clock,
            Change::Chosen { name, item } if name == PRESSURES => {
                runs.fixed.extend(gauge_values(self.experiment, item));
            }
            Change::Chosen { name, item } => {
                let entry = self.experiment.given().model.table().find(name).expect("a setting of the model");
                let value = match entry.variable.kind {
                    Kind::Enumeration(items) => {
                        items.items.iter().find(|(_, own, _)| *own == item).map(|(id, ..)| f64::from(*id))
                    }
                    _ => item.parse().ok(),
                };
                runs.fixed.insert(name.to_owned(), value.expect("an item of the choice"));
            }
        }
        runs
    }
}
