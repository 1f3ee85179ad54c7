//! Values of a function while it is translated: variables in C, and entries of the stack of WebAssembly.

use super::operators::Type;

/// A variable in C.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Variable {
    /// A local one of the function.
    Local(u32),
    /// The variable of a place on the stack, for values of a type.
    Place(Type, usize),
}

impl Variable {
    /// Name of the variable.
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

    /// The variable and the number that it is the sum of; of a variable alone the number 0.
    pub fn sum(&self) -> Option<(Variable, u64)> {
        let [variable] = self.needs[..] else { return None };
        let name = variable.name();
        if self.text == name {
            return Some((variable, 0));
        }
        let sum = self.text.strip_prefix('(')?.strip_prefix(&name)?.strip_prefix('+')?;
        Some((variable, sum.strip_suffix("u)")?.parse().ok()?))
    }

    /// Whether it is the value of a variable, and nothing more.
    pub fn is_variable(&self) -> bool {
        matches!(self.sum(), Some((_, 0)))
    }

    /// Whether it never changes.
    pub fn is_constant(&self) -> bool {
        self.needs.is_empty() && !self.reads
    }

    /// Whether its computation may trap: quotients and conversions are functions of the instance.
    pub fn may_trap(&self) -> bool {
        self.text.contains("(s,")
    }

    /// Which number it is, if it is a constant one of 32 bits.
    pub fn number(&self) -> Option<u64> {
        self.text.strip_suffix('u').and_then(|digits| digits.parse().ok())
    }

    /// The text as a number.
    pub fn value(&self) -> String {
        if self.compares { format!("(u32){}", self.text) } else { self.text.clone() }
    }
}
