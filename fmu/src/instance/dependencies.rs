//! Dependencies of variables on each other.

use super::Instance;
use crate::failure::Failure;
use pneumatic_servo::variables::{Kind, Role};

impl Instance {
    /// Value references on which a variable depends directly: of time, inputs and continuous states. What is set depends
    /// on nothing.
    pub fn dependencies(&self, reference: u32) -> Result<Vec<u32>, Failure> {
        let table = &self.layout.table;
        if self.layout.indicator(reference).is_some() {
            // Which of them enter depends on law and mode.
            let inputs = table.iter().filter(|it| it.role == Role::Input && matches!(it.kind, Kind::Real(_)));
            let time = table.iter().filter(|it| it.role == Role::Time);
            return Ok(time.chain(inputs).map(|it| it.reference).chain(table.states()).collect());
        }
        self.layout.elements(reference)?;
        Ok(table.by_reference(reference).map(|entry| table.dependencies(entry.variable)).unwrap_or_default())
    }
}
