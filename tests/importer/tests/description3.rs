//! The description for FMI 3.0, read by another implementation, says what the variable table says.

mod roles;

use anyhow::{Context, Result};
use fmi::fmi3::import::Fmi3Import;
use fmi::fmi3::schema::{Fmi3Unknown, InitializableVariableTrait};
use fmi::schema::fmi3::Variable as Read;
use fmi::traits::FmiImport;
use importer::fmi3::open;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Role, Variable, array_name};

/// The variables that the crate reads: it passes over enumerations.
fn is_read(variable: &Variable) -> bool {
    !matches!(variable.kind, Kind::Enumeration(_))
}

#[test]
fn every_variable_and_indicator_has_the_name_reference_and_causality_of_the_table() -> Result<()> {
    for model in models::ALL {
        let import = open(model.name)?;
        let table = model.table();
        let indicators = model.indicator_variables();
        let mut read = import.model_description().model_variables.iter_abstract();
        let mut variables: Vec<(usize, &Variable)> = table.arrays().collect();
        variables.extend(indicators.iter().map(|indicator| (1, indicator)));
        for (length, variable) in variables.into_iter().filter(|(_, first)| is_read(first)) {
            let name = if length > 1 { array_name(&variable.name).context("an array")? } else { &variable.name };
            let found = read.next().with_context(|| format!("no {name}"))?;
            assert_eq!(found.name(), name);
            assert_eq!(found.value_reference(), variable.reference, "{name}");
            assert_eq!(found.causality(), causality(variable), "{name}");
            assert_eq!(found.variability(), variability(variable), "{name}");
        }
        assert!(read.next().is_none(), "{}", model.name);
    }
    Ok(())
}

#[test]
fn every_start_value_has_the_bits_of_the_table() -> Result<()> {
    for model in models::ALL {
        let import = open(model.name)?;
        let read = import.model_description().model_variables.variables.iter().flat_map(starts);
        let started = model.started_variables()?;
        let expected = started.iter().filter(|variable| is_read(variable)).filter_map(|variable| variable.start);
        let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        assert_eq!(bits(read.collect()), bits(expected.collect()), "{}", model.name);
    }
    Ok(())
}

fn starts(read: &Read) -> Vec<f64> {
    match read {
        Read::Float64(real) => real.start().unwrap_or_default().to_vec(),
        Read::Int32(integer) => integer.start().unwrap_or_default().iter().map(|it| f64::from(*it)).collect(),
        Read::Boolean(boolean) => boolean.start().unwrap_or_default().iter().map(|it| f64::from(*it)).collect(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn structure_names_outputs_derivatives_and_indicators() -> Result<()> {
    for model in models::ALL {
        let import = open(model.name)?;
        let structure = &import.model_description().model_structure;
        let table = model.table();
        let references = |of: &dyn Fn(&Variable) -> bool| -> Vec<u32> {
            table.iter().filter(|variable| of(variable)).map(|variable| variable.reference).collect()
        };
        assert_eq!(named(structure.outputs()), references(&|variable| variable.role == Role::Output));
        let derivatives = named(structure.continuous_state_derivatives());
        assert_eq!(derivatives, references(&|variable| variable.derivative_of.is_some()));
        let indicators = model.indicator_variables();
        let expected: Vec<u32> = indicators.iter().map(|indicator| indicator.reference).collect();
        assert_eq!(named(structure.event_indicators()), expected);
    }
    Ok(())
}

fn named<'a>(unknowns: impl Iterator<Item = &'a Fmi3Unknown>) -> Vec<u32> {
    unknowns.map(|unknown| unknown.value_reference).collect()
}

#[test]
fn capabilities_and_default_experiment_are_read() -> Result<()> {
    for model in models::ALL {
        let import = open(model.name)?;
        let description = import.model_description();
        assert_eq!(description.fmi_version, "3.0");
        let co_simulation = description.co_simulation.as_ref().context("no co-simulation")?;
        assert_eq!(co_simulation.model_identifier, model.name);
        assert_eq!(co_simulation.can_get_and_set_fmu_state, Some(true));
        let has_states = model.table().number_of_states() > 0;
        assert_eq!(description.model_exchange.is_some(), has_states, "{}", model.name);
        let experiment = description.default_experiment.as_ref().context("no default experiment")?;
        assert_eq!(experiment.stop_time, Some(model.experiment.stop_time));
        assert_eq!(experiment.step_size, Some(model.experiment.step_size));
    }
    Ok(())
}

/// Once the crate reads units, `importer::fmi3::open` need not leave them out.
#[test]
fn crate_refuses_units_that_the_standard_has() {
    let file = importer::fmus().join("fmi3/PneumaticServoCylinder.fmu");
    let error = fmi::import::from_path::<Fmi3Import>(&file).expect_err("units");
    assert!(format!("{error:?}").contains("UnknownField"), "{error:?}");
}

roles::in_schema!(fmi::fmi3::schema);
