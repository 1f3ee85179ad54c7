//! Signatures of functions.

use anyhow::{Result, bail};
use wasmparser::{FuncType, ValType};

use super::operators::Type;

/// What a function takes and returns.
#[derive(Clone, Debug, PartialEq)]
pub struct Signature {
    /// The types of its arguments.
    pub parameters: Vec<Type>,
    /// The type of what it returns.
    pub result: Option<Type>,
}

impl Signature {
    /// A signature as the parser has it.
    ///
    /// # Errors
    /// When a type is not translated, or there are several results.
    pub fn of(function: &FuncType) -> Result<Self> {
        let parameters = function.params().iter().map(|of| value_type(*of)).collect::<Result<_>>()?;
        let result = match function.results() {
            [] => None,
            [of] => Some(value_type(*of)?),
            _ => bail!("several results are not translated"),
        };
        Ok(Self { parameters, result })
    }

    /// The declaration of a function in C, with the names of its arguments or without.
    pub fn declaration(&self, name: &str, is_named: bool) -> String {
        let result = self.result.map_or("void", Type::in_c);
        let mut text = format!("{result} {name}(Module*{}", if is_named { "s" } else { "" });
        for (place, of) in self.parameters.iter().enumerate() {
            text += ",";
            text += of.in_c();
            if is_named {
                text += &format!(" l{place}");
            }
        }
        text + ")"
    }
}

/// The type of a value.
///
/// # Errors
/// When it is not translated.
pub fn value_type(of: ValType) -> Result<Type> {
    Ok(match of {
        ValType::I32 => Type::I32,
        ValType::I64 => Type::I64,
        ValType::F32 => Type::F32,
        ValType::F64 => Type::F64,
        _ => bail!("values of type {of} are not translated"),
    })
}
