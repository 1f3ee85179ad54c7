//! Calls, by name and through the table.

use anyhow::Result;

use super::super::signature::first_equal;
use super::Translation;

impl Translation<'_> {
    pub(super) fn call(&mut self, function: u32) -> Result<()> {
        let name = match self.surroundings.imports.get(function as usize) {
            Some(name) => name.clone(),
            None => {
                self.calls.push(function);
                format!("w{function}")
            }
        };
        let signature = self.surroundings.functions[function as usize];
        self.call_by(&name, signature)
    }

    pub(super) fn call_through_table(&mut self, signature: u32) -> Result<()> {
        let index = self.pop()?;
        let signature = first_equal(self.surroundings.signatures, signature as usize);
        let name = format!("((t{signature})entry(s,{signature}u,{}))", index.value());
        // The index is evaluated with the arguments, none of which changes anything.
        self.call_by(&name, signature)
    }

    pub(super) fn call_by(&mut self, name: &str, signature: usize) -> Result<()> {
        let signature = &self.surroundings.signatures[signature];
        let mut arguments = Vec::new();
        for _ in &signature.parameters {
            arguments.push(self.pop()?);
        }
        self.compute_reads();
        let mut text = format!("{name}(s");
        for argument in arguments.iter().rev() {
            text += ",";
            text += &argument.value();
        }
        text += ")";
        match signature.result {
            Some(of) => self.push_computed(text, of),
            None => self.line(text + ";"),
        }
        Ok(())
    }
}
