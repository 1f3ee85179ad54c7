//! Values of a function while it is translated: variables in C, and entries of the stack of WebAssembly.

use super::operators::Type;

/// A variable in C.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Variable {
    /// A local one of the function.
    Local(u32),
    /// That of a place on the stack, for values of a type.
    Place(Type, usize),
}

impl Variable {
    /// What it is called.
    pub fn name(self) -> String {
        match self {
            Self::Local(number) => format!("l{number}"),
            Self::Place(of, place) => format!("{}{place}", of.letter()),
        }
    }
}

/// A value on the stack that is not computed yet.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The expression in C.
    pub text: String,
    /// The type of the value.
    pub of: Type,
    /// Whether it is an `int` in C.
    pub compares: bool,
    /// The variables in it.
    pub needs: Vec<Variable>,
    /// Whether it depends on memory or global variables.
    pub reads: bool,
}

impl Entry {
    /// An expression without variables.
    pub fn plain(text: String, of: Type) -> Self {
        Self { text, of, compares: false, needs: Vec::new(), reads: false }
    }

    /// The value of a variable.
    pub fn of_variable(variable: Variable, of: Type) -> Self {
        Self { needs: vec![variable], ..Self::plain(variable.name(), of) }
    }

    /// Whether it is the value of a variable, and nothing more.
    pub fn is_variable(&self) -> bool {
        matches!(self.needs[..], [variable] if variable.name() == self.text)
    }

    /// Whether it never changes.
    pub fn is_constant(&self) -> bool {
        self.needs.is_empty() && !self.reads
    }

    /// The text as a number.
    pub fn value(&self) -> String {
        if self.compares { format!("(u32){}", self.text) } else { self.text.clone() }
    }
}
