//! The variables that an exported FMU keeps.

use std::collections::BTreeMap;

use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Role, Table, Variable, array_name};
use pneumatic_servo_variant::{Given, Variant};

use crate::Refused;

/// A named choice of variables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preset {
    /// All variables.
    #[default]
    All,
    /// Inputs, outputs and parameters that have an effect on the configured machine.
    Rig,
    /// Commands in; motion, pressures and forces out; as parameters, the values of a data sheet.
    Minimal,
}

impl Preset {
    /// All of them, by name.
    pub const NAMES: [(&'static str, Self); 3] = [("minimal", Self::Minimal), ("rig", Self::Rig), ("all", Self::All)];

    /// The preset of a name.
    ///
    /// # Errors
    /// [`Refused`] for another name.
    pub fn named(name: &str) -> Result<Self, Refused> {
        let found = Self::NAMES.into_iter().find(|(own, _)| *own == name);
        found.map(|(_, preset)| preset).ok_or_else(|| {
            Refused(format!(
                "there is no preset {name}; it must be one of {}",
                Self::NAMES.map(|(own, _)| own).join(", ")
            ))
        })
    }
}

/// Variables of the cylinder in the preset `minimal`; inputs are those that command the actuator.
const COMMANDS: [&str; 6] =
    ["valveVoltage", "valveVoltageA", "valveVoltageB", "coil", "imposedPosition", "imposedVelocity"];
const OUTPUTS: [&str; 6] =
    ["position", "velocity", "chamberA.pressure", "chamberB.pressure", "pressureForce", "frictionForce"];
const DATA_SHEET: [&str; 10] = [
    "cylinder.bore",
    "cylinder.rod",
    "cylinder.stroke",
    "chamberA.deadVolume",
    "chamberB.deadVolume",
    "mass.moving",
    "valve.C",
    "valve.b",
    "ambientPressure",
    "position0",
];

/// The variables that stay: those of a preset, unless they are named.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interface {
    /// The preset for what is not named.
    pub preset: Preset,
    /// Inputs by name.
    pub inputs: Option<Vec<String>>,
    /// Outputs by name.
    pub outputs: Option<Vec<String>>,
    /// Parameters by name.
    pub parameters: Option<Vec<String>>,
}

impl Interface {
    /// The variant of a model with a name and values.
    pub(crate) fn variant(
        &self,
        model: &Model,
        name: &str,
        values: &BTreeMap<String, Given>,
    ) -> Result<Variant, Refused> {
        let table = model.table();
        let mut variant = Variant {
            model: model.name.to_owned(),
            name: name.to_owned(),
            values: values.clone(),
            ..Variant::default()
        };
        let parameters = variant.resolve(table)?.parameters;
        let acts = |variable: &Variable| table.lack(variable, &parameters).is_none();
        let is_minimal = self.preset == Preset::Minimal && table.find(OUTPUTS[2]).is_some();
        let chosen = |listed: &[&str], is: &dyn Fn(&Variable) -> bool| {
            let of_preset = |variable: &Variable| match self.preset {
                Preset::All => true,
                Preset::Minimal if is_minimal => listed.contains(&whole(&variable.name)) && acts(variable),
                Preset::Rig | Preset::Minimal => acts(variable),
            };
            names(table.iter().filter(|variable| is(variable) && of_preset(variable)))
        };
        let is_input = |variable: &Variable| variable.role == Role::Input;
        variant.inputs = self.named(&self.inputs).unwrap_or_else(|| chosen(&COMMANDS, &is_input));
        variant.outputs =
            self.named(&self.outputs).unwrap_or_else(|| chosen(&OUTPUTS, &|variable| variable.role == Role::Output));
        variant.parameters =
            self.named(&self.parameters).unwrap_or_else(|| chosen(&DATA_SHEET, &Variable::is_parameter));
        variant.resolve(table)?;
        if self.inputs.is_some() {
            check_commands(table, &variant, &parameters)?;
        }
        Ok(variant)
    }

    /// Names as they are given, elements by the names of their arrays.
    fn named(&self, given: &Option<Vec<String>>) -> Option<Vec<String>> {
        let mut names: Vec<String> = Vec::new();
        for name in given.as_ref()? {
            let own = whole(name).to_owned();
            // A name that is given twice is refused later on; elements of an array are not.
            if own == *name || !names.contains(&own) {
                names.push(own);
            }
        }
        Some(names)
    }
}

/// Refuses to leave out an input that commands the configured machine, unless it has a value.
fn check_commands(table: &Table, variant: &Variant, parameters: &[f64]) -> Result<(), Refused> {
    for variable in table.inputs() {
        let name = whole(&variable.name);
        let is_told =
            variant.inputs.iter().any(|own| own == name) || variant.values.keys().any(|own| whole(own) == name);
        if COMMANDS.contains(&name) && !is_told && table.lack(variable, parameters).is_none() {
            return Err(Refused(format!(
                "{name} is left out of the inputs, and the configured machine needs it: keep it, or give it a value"
            )));
        }
    }
    Ok(())
}

/// The name of an array for its elements.
fn whole(name: &str) -> &str {
    array_name(name).unwrap_or(name)
}

/// The names of variables, arrays once.
fn names<'a>(variables: impl Iterator<Item = &'a Variable>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for variable in variables {
        let name = whole(&variable.name);
        if names.last().is_none_or(|last| last != name) {
            names.push(name.to_owned());
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

    use super::*;

    #[test]
    fn presets_name_variables_of_the_cylinder() {
        let has = |name: &&str| MODEL.table().iter().any(|variable| whole(&variable.name) == *name);
        for name in COMMANDS.iter().chain(&OUTPUTS).chain(&DATA_SHEET) {
            assert!(has(name), "{name}");
        }
    }
}
