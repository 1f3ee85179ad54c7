//! `ModelStructure`: outputs and state derivatives, their dependencies, and the unknowns of initialization.

use std::collections::BTreeSet;

use anyhow::{Context, Result};
use pneumatic_servo::variables::{Meaning, Role, Table, Variable};

/// The three lists of the section; variables are named by their index, which counts from 1.
pub struct Structure {
    /// The outputs.
    pub outputs: Vec<Unknown>,
    /// The derivatives of the continuous states.
    pub derivatives: Vec<Unknown>,
    /// Variables computed at initialization.
    pub initial_unknowns: Vec<Unknown>,
}

/// A variable and those it depends on.
#[derive(Debug, PartialEq)]
pub struct Unknown {
    /// Its index.
    pub index: usize,
    /// Their indices, in ascending order.
    pub dependencies: Vec<usize>,
}

/// The index of the variable with this value reference, counted from 1.
pub fn index_of(variables: &[Variable], reference: u32) -> Option<usize> {
    variables.iter().position(|variable| variable.reference == reference).map(|position| position + 1)
}

impl Structure {
    /// Reads the lists from the table.
    ///
    /// # Errors
    /// When a variable refers to one that the table does not have.
    pub fn new(variables: &Table) -> Result<Self> {
        let select = |wanted: &dyn Fn(&Variable) -> bool| -> Result<Vec<Unknown>> {
            let numbered = (1..).zip(variables).filter(|(_, variable)| wanted(variable));
            numbered.map(|(index, variable)| Unknown::new(variables, index, variable)).collect()
        };
        let outputs = select(&|variable| variable.role == Role::Output)?;
        let derivatives = select(&|variable| variable.derivative_of.is_some())?;
        let states = derivatives.iter().filter_map(|unknown| {
            let state = variables[unknown.index - 1].derivative_of?;
            index_of(variables, state)
        });
        // All of them are calculated at initialization; there are no calculated parameters.
        let initial: BTreeSet<usize> =
            outputs.iter().chain(&derivatives).map(|unknown| unknown.index).chain(states).collect();
        let initial_unknowns = initial.into_iter().map(|index| Unknown::initial(variables, index)).collect();
        Ok(Self { outputs, derivatives, initial_unknowns })
    }

    /// The same for variables of which the one with an index is not listed: neither as a dependency, nor where the indices are
    /// counted.
    pub fn without(&self, left_out: usize) -> Self {
        let shifted = |index: usize| if index > left_out { index - 1 } else { index };
        let unknown = |it: &Unknown| {
            let dependencies = it.dependencies.iter().filter(|index| **index != left_out);
            Unknown { index: shifted(it.index), dependencies: dependencies.map(|index| shifted(*index)).collect() }
        };
        let [outputs, derivatives, initial_unknowns] =
            [&self.outputs, &self.derivatives, &self.initial_unknowns].map(|list| list.iter().map(unknown).collect());
        Self { outputs, derivatives, initial_unknowns }
    }
}

impl Unknown {
    fn new(variables: &Table, index: usize, variable: &Variable) -> Result<Self> {
        let find = |reference: u32| {
            index_of(variables, reference)
                .with_context(|| format!("{} refers to the unknown value reference {reference}", variable.name))
        };
        variable.derivative_of.map(find).transpose()?;
        let dependencies: BTreeSet<usize> =
            variables.dependencies(variable).into_iter().map(find).collect::<Result<_>>()?;
        Ok(Self { index, dependencies: dependencies.into_iter().collect() })
    }

    /// The same at initialization: it depends on inputs and time as the table says, and on all parameters except the
    /// solver's, since each may act under some law and on some rig.
    fn initial(variables: &Table, index: usize) -> Self {
        let known = variables.initial_dependencies(&variables[index - 1]);
        let is_used = |variable: &Variable| {
            known.contains(&variable.reference) || variable.is_parameter() && variable.meaning != Some(Meaning::Solving)
        };
        let dependencies = (1..).zip(variables).filter(|(_, variable)| is_used(variable)).map(|(index, _)| index);
        Self { index, dependencies: dependencies.collect() }
    }
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::variables::units;

    use super::*;

    /// Time, an input, a state that is an output, its derivative, a local variable and two parameters.
    fn table() -> Table {
        Table::new(vec![
            Variable::time(),
            Variable::input(10, "flow", units::CUBIC_METRE, 0.0),
            Variable::output(30, "level", units::METRE).depends_on(&[30]),
            Variable::output(31, "rise", units::METRE_PER_SECOND).local().derivative_of(30).depends_on(&[30, 10]),
            Variable::output(32, "spill", units::METRE).local(),
            Variable::parameter(40, "width", units::METRE, 1.0),
            Variable::parameter(41, "solver.step", units::SECOND, 1.0).meaning(Meaning::Solving),
        ])
    }

    #[test]
    fn outputs_derivatives_and_initial_unknowns_are_found() -> Result<()> {
        let structure = Structure::new(&table())?;
        assert_eq!(structure.outputs, [Unknown { index: 3, dependencies: vec![3] }]);
        assert_eq!(structure.derivatives, [Unknown { index: 4, dependencies: vec![2, 3] }]);
        Ok(())
    }

    #[test]
    fn variable_that_is_left_out_is_no_dependency_and_not_counted() {
        let unknown = |index, dependencies: &[usize]| Unknown { index, dependencies: dependencies.to_vec() };
        let all = Structure {
            outputs: vec![unknown(1, &[1]), unknown(4, &[1, 2, 3])],
            derivatives: vec![unknown(3, &[2])],
            initial_unknowns: Vec::new(),
        };
        let some = all.without(2);
        assert_eq!(some.outputs, [unknown(1, &[1]), unknown(3, &[1, 2])]);
        assert_eq!((some.derivatives, some.initial_unknowns), (vec![unknown(2, &[])], Vec::new()));
    }

    /// Otherwise a plant and its controller would make an algebraic loop at initialization.
    #[test]
    fn initial_unknowns_depend_on_parameters_and_on_no_other_inputs_than_they_must() -> Result<()> {
        let [level, rise] =
            [Unknown { index: 3, dependencies: vec![6] }, Unknown { index: 4, dependencies: vec![2, 6] }];
        assert_eq!(Structure::new(&table())?.initial_unknowns, [level, rise]);
        Ok(())
    }
}
