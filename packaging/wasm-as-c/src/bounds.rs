//! Which addresses of a function are known to be within the bounds of the memory.
//!
//! Behind the memory is a margin: one comparison serves all that is at small offsets from an address, until the variable that
//! holds it changes, and as far as all paths have passed it. It serves variables that are a small sum of that one, too.

use std::collections::BTreeMap;

use super::value::{Entry, Variable};

/// Least number of bytes from an address; addresses not in it may be out of bounds.
type Reach = BTreeMap<Variable, u64>;

/// Known bounds at a point of a function.
pub struct Bounds {
    /// Bytes of memory from the start.
    memory: u64,
    /// Unused bytes behind the memory.
    margin: u64,
    /// Bounds known here.
    reach: Reach,
    /// Bounds known at the start of each open block, of variables that have not changed since.
    at_begin: Vec<Reach>,
    /// Whether anything was compared.
    pub is_compared: bool,
}

impl Bounds {
    /// At the begin of a function.
    pub fn of(memory: u64, margin: u64) -> Self {
        Self { memory, margin, reach: Reach::new(), at_begin: Vec::new(), is_compared: false }
    }

    /// The statement that traps unless `bytes` bytes from an address (a variable or a constant) are in memory: the address is
    /// before the margin, or the bytes are.
    pub fn compare(&mut self, address: &Entry, bytes: u64) -> String {
        if let Some((variable, 0)) = address.sum() {
            let in_memory = if bytes <= self.margin { 0 } else { bytes };
            self.reach.insert(variable, in_memory + self.margin);
        }
        self.is_compared = true;
        format!("within({},{bytes}u);", address.text)
    }

    /// Whether `bytes` bytes from an address are known to be in memory.
    pub fn has(&self, address: &Entry, bytes: u64) -> bool {
        match address.number() {
            Some(number) => number + bytes <= self.memory,
            None => self.reach_of(address).is_some_and(|reach| bytes <= reach),
        }
    }

    /// The number of bytes from an address that are known to be in memory.
    fn reach_of(&self, address: &Entry) -> Option<u64> {
        let (variable, offset) = address.sum()?;
        self.reach.get(&variable)?.checked_sub(offset)
    }

    /// A variable takes a value.
    pub fn becomes(&mut self, variable: Variable, value: &Entry) {
        let reach = self.reach_of(value);
        self.forget(variable);
        self.reach.extend(reach.map(|reach| (variable, reach)));
    }

    /// Discards the known reach of a variable.
    pub fn forget(&mut self, variable: Variable) {
        for reach in self.at_begin.iter_mut().chain([&mut self.reach]) {
            reach.remove(&variable);
        }
    }

    /// A block begins.
    pub fn begin(&mut self, is_loop: bool) {
        self.at_begin.push(self.reach.clone());
        if is_loop {
            // The loop's changes are not known yet, and it comes back to here.
            self.reach.clear();
        }
    }

    /// The second part of a block begins, with what was known before the first.
    pub fn begin_else(&mut self) {
        if let Some(at_begin) = self.at_begin.last() {
            self.reach.clone_from(at_begin);
        }
    }

    /// A block ends: behind its last statement alone, or also from elsewhere.
    pub fn end(&mut self, is_left_at_its_end_alone: bool) {
        let at_begin = self.at_begin.pop().unwrap_or_default();
        if is_left_at_its_end_alone {
            // Where both know of a variable, it has been compared again, and reaches as far as any.
            for (variable, reach) in at_begin {
                let known = self.reach.entry(variable).or_default();
                *known = reach.max(*known);
            }
        } else {
            self.reach = at_begin;
        }
    }
}
