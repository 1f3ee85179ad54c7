//! Accesses to memory, with the comparisons of their addresses.

use anyhow::{Context, Result, bail};
use wasmparser::{MemArg, Operator as Op};

use super::super::operators::Access;
use super::super::value::Entry;
use super::Translation;

impl Translation<'_> {
    pub(super) fn access(&mut self, access: Access, place: MemArg) -> Result<()> {
        self.uses_memory = true;
        let arguments = if access.loads.is_some() { 1 } else { 2 };
        let address = self.stack.len().checked_sub(arguments).context("the stack is empty")?;
        self.ensure_within(address, place.offset + (1 << place.max_align));
        let value = if access.loads.is_none() { Some(self.pop()?) } else { None };
        let address = self.pop()?;
        // Rust's compiler says of each access how its address is aligned; some processors need that.
        let function = format!("{}{}", access.function, if place.align < place.max_align { "u" } else { "" });
        let there = format!("m,{},{}u", address.value(), place.offset);
        match (access.loads, value) {
            (Some(of), _) => {
                self.combine(format!("{function}({there})"), of, false, &[&address]);
                if let Some(entry) = self.stack.last_mut() {
                    entry.reads = true;
                }
            }
            (None, value) => {
                self.compute_reads();
                let value = value.map(|value| value.value()).unwrap_or_default();
                self.line(format!("{function}({there},{value});"));
            }
        }
        Ok(())
    }

    /// Traps unless `bytes` bytes from an address are in memory; compares only where that is not known.
    pub(super) fn ensure_within(&mut self, place: usize, bytes: u64) {
        if self.bounds.has(&self.stack[place], bytes) {
            return;
        }
        if !self.stack[place].is_variable() {
            self.compute(place);
        }
        let comparison = self.bounds.compare(&self.stack[place], bytes);
        self.line(comparison);
    }

    /// Copies or fills memory, by a function whose first arguments are addresses. Usually the size, of a structure, is known: then
    /// addresses are compared as for any access.
    pub(super) fn on_memory(&mut self, function: &str, addresses: usize) -> Result<()> {
        let known = self.stack.last().and_then(Entry::number).filter(|bytes| *bytes <= self.surroundings.margin);
        if let Some(bytes) = known {
            self.uses_memory = true;
            let first = self.stack.len().checked_sub(3).context("the stack is empty")?;
            for place in first..first + addresses {
                self.ensure_within(place, bytes);
            }
        }
        let (third, second, first) = (self.pop()?, self.pop()?, self.pop()?);
        self.compute_reads();
        let arguments = format!("{},{},{}", first.value(), second.value(), third.value());
        self.line(match known {
            Some(_) => format!("{function}_known(m,{arguments});"),
            None => format!("{function}(s,{arguments});"),
        });
        Ok(())
    }
}

/// Where an access to memory begins, counted from its address, and how that is aligned.
pub fn place(op: &Op) -> Result<MemArg> {
    macro_rules! place {
        ($($name:ident)*) => {
            match op {
                $(Op::$name { memarg } => Ok(*memarg),)*
                _ => bail!("it is no access to memory"),
            }
        };
    }
    place! {
        I32Load I64Load F32Load F64Load I32Load8S I32Load8U I32Load16S I32Load16U I64Load8S I64Load8U I64Load16S
        I64Load16U I64Load32S I64Load32U I32Store I64Store F32Store F64Store I32Store8 I32Store16 I64Store8 I64Store16
        I64Store32
    }
}
