//! The stack of WebAssembly while a function is read: what is on it as an expression, and what has become a variable.

use anyhow::{Context, Result, ensure};

use super::super::operators::Type;
use super::super::value::{Entry, Variable};
use super::Translation;

impl Translation<'_> {
    /// The expressions that are longer are computed at once, so that none grows without limit. Those that may trap are, too: they
    /// trap in order, and also where nothing uses their value.
    const LONGEST: usize = 160;

    pub(super) fn push(&mut self, entry: Entry) {
        let is_due = entry.text.len() > Self::LONGEST || entry.may_trap();
        self.stack.push(entry);
        if is_due {
            self.compute(self.stack.len() - 1);
        }
    }

    pub(super) fn pop(&mut self) -> Result<Entry> {
        let floor = self.frames.last().map_or(0, |frame| frame.height);
        ensure!(self.stack.len() > floor, "the stack is empty");
        self.stack.pop().context("the stack is empty")
    }

    /// Computes an entry into the variable of its place. Entries above it never depend on that variable.
    pub(super) fn compute(&mut self, place: usize) {
        let entry = &self.stack[place];
        let variable = Variable::Place(entry.of, place);
        if entry.is_constant() && !entry.may_trap() || entry.text == variable.name() {
            return;
        }
        self.compute_what_needs(variable, place);
        let entry = Entry::of_variable(variable, self.stack[place].of);
        let old = std::mem::replace(&mut self.stack[place], entry);
        self.assign(variable, &old);
    }

    /// Computes the entries below a height that depend on a variable, which is about to change.
    pub(super) fn compute_what_needs(&mut self, variable: Variable, height: usize) {
        for place in 0..height {
            if self.stack[place].needs.contains(&variable) {
                self.compute(place);
            }
        }
    }

    pub(super) fn compute_all(&mut self) {
        for place in 0..self.stack.len() {
            self.compute(place);
        }
    }

    /// Computes what depends on memory or global variables, which are about to change.
    pub(super) fn compute_reads(&mut self) {
        for place in 0..self.stack.len() {
            if self.stack[place].reads {
                self.compute(place);
            }
        }
    }

    pub(super) fn assign(&mut self, variable: Variable, entry: &Entry) {
        if let Variable::Place(of, place) = variable
            && !self.places.contains(&(of, place))
        {
            self.places.push((of, place));
        }
        if entry.text != variable.name() {
            self.bounds.becomes(variable, entry);
            self.line(format!("{}={};", variable.name(), entry.text));
        }
    }

    /// Puts what a call returns on the stack.
    pub(super) fn push_computed(&mut self, text: String, of: Type) {
        let variable = Variable::Place(of, self.stack.len());
        self.compute_what_needs(variable, self.stack.len());
        self.assign(variable, &Entry::plain(text, of));
        self.stack.push(Entry::of_variable(variable, of));
    }

    pub(super) fn combine(&mut self, text: String, of: Type, compares: bool, from: &[&Entry]) {
        let needs = from.iter().flat_map(|entry| entry.needs.iter().copied()).collect();
        let reads = from.iter().any(|entry| entry.reads);
        self.push(Entry { text, of, compares, needs, reads });
    }
}
