//! Variables as arrays, each by the value reference of its first element; single variables are arrays of one. Event
//! indicators are variables too.

use std::sync::Arc;

use super::Instance;
use super::layout::{Base, check_type};
use crate::calls::Mode;
use crate::failure::Failure;

impl Instance {
    /// The value references of all elements of arrays, one after the other; refused unless they are as many as the host
    /// has values for.
    pub fn elements<R: Iterator<Item = u32> + Clone>(
        &self,
        references: R,
        values: usize,
    ) -> Result<impl Iterator<Item = u32> + Clone + use<R>, Failure> {
        let layout = Arc::clone(&self.layout);
        let mut number = 0;
        for reference in references.clone() {
            number += layout.elements(reference)?.len();
        }
        check_number(number, values)?;
        Ok(references.flat_map(move |reference| layout.elements(reference).unwrap_or_default()))
    }

    /// The values of arrays of a type, after all of them have been found; refused unless they are as many as the host has
    /// room for.
    pub fn get_arrays(
        &mut self,
        base: Base,
        references: impl Iterator<Item = u32>,
        room: usize,
    ) -> Result<&[f64], Failure> {
        let mut answers = std::mem::take(&mut self.scratch.answers);
        answers.clear();
        let outcome = self.read_arrays(base, references, &mut answers);
        self.scratch.answers = answers;
        outcome?;
        check_number(self.scratch.answers.len(), room)?;
        Ok(&self.scratch.answers)
    }

    fn read_arrays(
        &mut self,
        base: Base,
        references: impl Iterator<Item = u32>,
        answers: &mut Vec<f64>,
    ) -> Result<(), Failure> {
        for reference in references {
            if let Some(number) = self.layout.indicator(reference) {
                answers.push(self.indicator(number, base)?);
                continue;
            }
            for element in self.layout.elements(reference)? {
                answers.push(self.read(element, base)?);
            }
        }
        Ok(())
    }

    /// The value of an event indicator.
    fn indicator(&mut self, number: usize, base: Base) -> Result<f64, Failure> {
        let variable = &self.layout.indicator_variables[number];
        check_type(variable, base)?;
        if self.record.mode == Mode::Instantiated {
            let name = &variable.name;
            return Err(Failure::error(format!("{name} is computed, from initialization mode on")));
        }
        self.run.indicators(&self.layout, &self.record, &mut self.scratch.indicators)?;
        Ok(self.scratch.indicators[number])
    }
}

fn check_number(elements: usize, values: usize) -> Result<(), Failure> {
    if elements == values {
        return Ok(());
    }
    Err(Failure::error(format!("the variables have {elements} elements, but there are {values} values")))
}
