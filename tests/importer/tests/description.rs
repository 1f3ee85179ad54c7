//! The description for FMI 2.0, read by another implementation, says what the variable table says.

mod roles;

use anyhow::{Context, Result};
use fmi::schema::fmi2::ScalarVariableElement;
use fmi::traits::FmiImport;
use importer::fmi2::open;
use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Role, Variable};

/// The variables of a model without the independent one, which FMI 2.0 does not ask for.
fn listed(model: &Model) -> Vec<&'static Variable> {
    model.table().iter().filter(|variable| variable.role != Role::Time).collect()
}

#[test]
fn every_variable_has_the_name_reference_and_causality_of_the_table() -> Result<()> {
    for model in models::ALL {
        let import = open(model.name)?;
        let read = &import.model_description().model_variables.variables;
        let table = listed(model);
        assert_eq!(read.len(), table.len());
        for (found, variable) in read.iter().zip(table) {
            assert_eq!(found.name, variable.name);
            assert_eq!(found.value_reference, variable.reference, "{}", variable.name);
            assert_eq!(found.causality, causality(variable), "{}", variable.name);
            assert_eq!(found.variability, Some(variability(variable)), "{}", variable.name);
        }
    }
    Ok(())
}

#[test]
fn every_start_value_has_the_bits_of_the_table() -> Result<()> {
    for model in models::ALL {
        let import = open(model.name)?;
        let started = model.started_variables()?.into_iter().filter(|variable| variable.role != Role::Time);
        for (found, variable) in import.model_description().model_variables.variables.iter().zip(started) {
            let start = match (&found.elem, variable.kind) {
                (ScalarVariableElement::Real(real), Kind::Real(_)) => real.start,
                (ScalarVariableElement::Integer(integer), Kind::Integer) => integer.start.map(f64::from),
                (ScalarVariableElement::Boolean(boolean), Kind::Boolean) => boolean.start.map(f64::from),
                // The crate reads no start value here.
                (ScalarVariableElement::Enumeration, Kind::Enumeration(_)) => variable.start,
                (found, _) => panic!("{} is read as {found:?}", variable.name),
            };
            assert_eq!(start.map(f64::to_bits), variable.start.map(f64::to_bits), "{}", variable.name);
        }
    }
    Ok(())
}

#[test]
fn structure_names_every_output_and_derivative() -> Result<()> {
    for model in models::ALL {
        let import = open(model.name)?;
        let description = import.model_description();
        let named = |index: u32| listed(model)[index as usize - 1];
        let structure = &description.model_structure;
        let outputs: Vec<_> = structure.outputs.unknowns.iter().map(|unknown| &named(unknown.index).name).collect();
        let expected = model.table().iter().filter(|variable| variable.role == Role::Output);
        assert_eq!(outputs, expected.map(|variable| &variable.name).collect::<Vec<_>>());
        for unknown in &structure.derivatives.unknowns {
            assert!(named(unknown.index).derivative_of.is_some(), "{}", named(unknown.index).name);
        }
        for unknown in structure.outputs.unknowns.iter().chain(&structure.derivatives.unknowns) {
            assert_eq!(unknown.dependencies.len(), unknown.dependencies_kind.len());
            let known = |index: &u32| {
                let variable = named(*index);
                let is_state = model.table().iter().any(|v| v.derivative_of == Some(variable.reference));
                variable.role == Role::Input || is_state
            };
            assert!(unknown.dependencies.iter().all(known), "{}", named(unknown.index).name);
        }
    }
    Ok(())
}

#[test]
fn capabilities_and_default_experiment_are_read() -> Result<()> {
    for model in models::ALL {
        let import = open(model.name)?;
        let description = import.model_description();
        let co_simulation = description.co_simulation.as_ref().context("no co-simulation")?;
        assert_eq!(co_simulation.model_identifier, model.name);
        assert_eq!(description.fmi_version, "2.0");
        // A model without continuous states has nothing that a host could integrate.
        let has_states = model.table().iter().any(|variable| variable.derivative_of.is_some());
        assert_eq!(description.model_exchange.is_some(), has_states, "{}", model.name);
        let experiment = description.default_experiment.as_ref().context("no default experiment")?;
        assert_eq!(experiment.stop_time, Some(model.experiment.stop_time));
        assert_eq!(experiment.step_size, Some(model.experiment.step_size));
    }
    Ok(())
}

roles::in_schema!(fmi::schema::fmi2);
