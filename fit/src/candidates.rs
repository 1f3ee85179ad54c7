//! Fixed settings, sensors and clock of an experiment as candidates of what explains its residuals.

use pneumatic_servo::variables::{Kind, Role};

use crate::causes::{Candidates, Change, Changeable, Choice, DAMPING_SPEED, MODEL, is_clocked, suspected};
use crate::experiment::parameter;
use crate::parameter::{Parameter, SPAN, Values};
use crate::problem::{Interrupted, Simulated};
use crate::record::unit_of;
use crate::runs::Runs;

/// SI units of the parameters of a law that a fit usually estimates.
const OF_LAW: [&str; 6] = ["N", "N/m", "N.s/m", "m/s", "1/m", "m"];

/// Candidates of an experiment: what is neither estimated nor measured, nor, of a sensor, known.
pub fn candidates(runs: &Runs<'_>) -> Candidates {
    let given = runs.experiment.given();
    let is_estimated = |name: &str| runs.parameters.iter().any(|one| one.name == name);
    let is_fixed = |name: &&String| !given.signals.contains(*name) && !is_estimated(name);
    let settings = settings(runs);
    let settings = settings.iter().filter(is_fixed).filter_map(|name| freed(runs, name)).collect();
    let sensors = sensors(runs);
    let sensors = sensors.iter().filter(is_fixed).filter(|name| !given.known.contains_key(*name));
    let sensors = sensors.filter_map(|name| freed(runs, name)).collect();
    let is_thermal = runs.parameters.iter().any(|one| one.name.starts_with("thermal."));
    let model = model(runs).filter(|_| !is_thermal);
    let damping = damping(runs).filter(|_| !is_estimated(DAMPING_SPEED));
    let choices = model.into_iter().chain(damping).collect();
    Candidates { settings, sensors, choices, has_clock: is_clocked(experiment(runs)) }
}

/// Name of the experiment.
fn experiment(runs: &Runs<'_>) -> &'static str {
    if runs.experiment.given().model.name == "FrictionBench" { "motion" } else { "rig" }
}

/// Names of settings of the machine and of parameters of its law.
fn settings(runs: &Runs<'_>) -> Vec<String> {
    let given = runs.experiment.given();
    let group = given.law_group();
    let is_usual = |name: &str, unit: &str, start: Option<f64>| {
        name.starts_with(&group) && !name.contains('[') && OF_LAW.contains(&unit) && start != Some(0.0)
    };
    let of_law = given.model.table().parameters().filter_map(|variable| match variable.kind {
        Kind::Real(unit) if is_usual(&variable.name, unit.name, variable.start) => Some(variable.name.to_string()),
        _ => None,
    });
    let of_machine = suspected(experiment(runs)).into_iter().map(str::to_owned);
    of_machine.chain(of_law.filter(|_| !group.is_empty())).collect()
}

/// Names of the properties of all sensors.
fn sensors(runs: &Runs<'_>) -> Vec<String> {
    let compared = runs.experiment.compared().to_vec();
    let both = [compared.clone(), runs.experiment.driving()].concat();
    let of = |kinds: &[&str], signals: &[&str]| -> Vec<String> {
        signals.iter().flat_map(|signal| kinds.iter().map(move |kind| format!("{kind}.{signal}"))).collect()
    };
    [of(&["gain", "offset", "delay"], &both), of(&["lag"], &compared)].concat()
}

/// The thermal model of a rig and the others.
fn model(runs: &Runs<'_>) -> Option<Choice> {
    let given = runs.experiment.given();
    let Kind::Enumeration(models) = given.model.table().find(MODEL)?.variable.kind else { return None };
    let own = given.value(MODEL, &Values::new());
    let (fixed, others): (Vec<_>, Vec<_>) = models.items.iter().partition(|(id, ..)| f64::from(*id) == own);
    let (_, name, _) = fixed.first()?;
    let others = others.into_iter().map(|(_, name, _)| (*name).to_owned()).collect();
    Some(Choice { name: MODEL.to_owned(), fixed: (*name).to_owned(), others })
}

/// Both forms of LuGre: with a damping of the bristles that decays with speed, and with a constant one.
fn damping(runs: &Runs<'_>) -> Option<Choice> {
    let given = runs.experiment.given();
    if given.law_name() != "LuGre" {
        return None;
    }
    let usual = given.model.table().find(DAMPING_SPEED)?.variable.start?;
    let own = given.value(DAMPING_SPEED, &Values::new());
    let other = if own == 0.0 { usual } else { 0.0 };
    Some(Choice { name: DAMPING_SPEED.to_owned(), fixed: own.to_string(), others: vec![other.to_string()] })
}

/// A fixed property as an estimated one; nothing for one that is off, as a volume of 0.
fn freed(runs: &Runs<'_>, name: &str) -> Option<Parameter> {
    let given = runs.experiment.given();
    if let Some(entry) = given.model.table().find(name)
        && entry.variable.role == Role::Input
    {
        let start = given.value(name, &Values::new());
        let bounds = [start / SPAN, start * SPAN];
        return (start > 0.0).then(|| Parameter::of_input(name, unit_of(name), start, bounds));
    }
    let free = parameter(runs.experiment, name).ok()?;
    let start = given.beside(name, &Values::new(), free.start);
    if free.is_logarithmic() && start <= 0.0 { None } else { Some(free.at(start)) }
}

impl Changeable for Runs<'_> {
    fn signals(&self) -> Vec<String> {
        self.experiment.compared().iter().map(|signal| (*signal).to_owned()).collect()
    }

    fn changed<'a>(&'a self, change: Change<'a>) -> Result<Box<dyn Simulated + 'a>, Interrupted> {
        let mut runs = Runs {
            parameters: self.parameters.clone(),
            segments: self.segments.clone(),
            fixed: self.fixed.clone(),
            ..*self
        };
        match change {
            Change::Estimated(parameter) => runs.parameters.push(parameter.clone()),
            Change::Clock(clock) => runs.clock = clock,
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
        Ok(Box::new(runs))
    }
}
