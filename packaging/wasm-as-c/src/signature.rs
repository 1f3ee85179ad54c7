//! Signatures of functions.

use anyhow::{Result, bail};
use wasmparser::{FuncType, ValType};

use super::operators::Type;

/// Parameters and results of a function.
#[derive(Clone, Debug, PartialEq)]
pub struct Signature {
    /// The types of its arguments.
    pub parameters: Vec<Type>,
    /// The type of what it returns.
    pub result: Option<Type>,
}

/// The first of some signatures that is equal to one: types of functions are equal by what they are, not by their numbers.
pub fn first_equal(signatures: &[Signature], number: usize) -> usize {
    signatures.iter().position(|other| *other == signatures[number]).unwrap_or(number)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_width_are_arguments_and_results() -> Result<()> {
        let all = [ValType::I32, ValType::I64, ValType::F32, ValType::F64];
        let results = ["u32", "u64", "f32", "f64"];
        for (of, result) in all.into_iter().zip(results) {
            let declaration = Signature::of(&FuncType::new(all, [of]))?.declaration("f", true);
            assert_eq!(declaration, format!("{result} f(Module*s,u32 l0,u64 l1,f32 l2,f64 l3)"));
        }
        assert!(value_type(ValType::V128).is_err());
        assert!(Signature::of(&FuncType::new([], all)).is_err());
        Ok(())
    }
}
