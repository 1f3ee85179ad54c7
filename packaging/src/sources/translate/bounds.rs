//! Which addresses of a function are known to be within the bounds of the memory.
//!
//! Behind the memory is a margin: one comparison serves all that is at small offsets from an address, until the variable that
//! holds it changes, and as far as all paths have passed it.

use std::collections::HashSet;

use super::value::{Entry, Variable};

/// Bytes behind the memory that nothing uses.
pub const MARGIN: u64 = 4096;

/// What is known at a place of a function.
pub struct Bounds {
    /// How many bytes of memory there are from the start on.
    memory: u64,
    /// The addresses that are within bounds.
    within: HashSet<Variable>,
    /// Those that were when each of the open blocks began, and have not changed since.
    at_begin: Vec<HashSet<Variable>>,
    /// Whether anything was compared.
    pub is_compared: bool,
}

impl Bounds {
    /// At the begin of a function.
    pub fn of(memory: u64) -> Self {
        Self { memory, within: HashSet::new(), at_begin: Vec::new(), is_compared: false }
    }

    /// The statement that traps unless there are so many bytes from an address on, which is a variable or a constant; nothing
    /// if they are known to be there.
    pub fn ensure(&mut self, address: &Entry, bytes: u64) -> Option<String> {
        let constant = address.text.strip_suffix('u').and_then(|digits| digits.parse::<u64>().ok());
        if constant.is_some_and(|address| address + bytes <= self.memory) {
            return None;
        }
        let variable = address.needs.first().copied().filter(|_| bytes <= MARGIN);
        if variable.is_some_and(|variable| self.within.contains(&variable)) {
            return None;
        }
        self.within.extend(variable);
        self.is_compared = true;
        Some(format!("within({},{bytes}u);", address.text))
    }

    /// A variable takes a value, of which is known what is known of the variable that it comes from.
    pub fn becomes(&mut self, variable: Variable, value: &Entry) {
        let is_within = self.within.iter().any(|other| other.name() == value.text);
        self.forget(variable);
        if is_within {
            self.within.insert(variable);
        }
    }

    /// Whatever was known of a variable is not known any more.
    pub fn forget(&mut self, variable: Variable) {
        for within in self.at_begin.iter_mut().chain([&mut self.within]) {
            within.remove(&variable);
        }
    }

    /// A block begins.
    pub fn begin(&mut self, is_loop: bool) {
        self.at_begin.push(self.within.clone());
        if is_loop {
            // What changes in it is not known yet, and it comes back to here.
            self.within.clear();
        }
    }

    /// The second part of a block begins, with what was known before the first.
    pub fn begin_else(&mut self) {
        if let Some(at_begin) = self.at_begin.last() {
            self.within.clone_from(at_begin);
        }
    }

    /// A block ends: behind its last statement alone, or also from elsewhere.
    pub fn end(&mut self, is_left_at_its_end_alone: bool) {
        let at_begin = self.at_begin.pop().unwrap_or_default();
        if is_left_at_its_end_alone {
            self.within.extend(at_begin);
        } else {
            self.within = at_begin;
        }
    }
}
