//! One function of WebAssembly as a function in C.
//!
//! The stack of WebAssembly is followed while reading: an entry is an expression in C, which is written where it is taken,
//! or into a variable of its place before anything changes what it depends on. Products of floating-point numbers always go
//! into a variable: the standard of C lets a compiler contract a product and a sum within one expression only.
//! Addresses become variables, too, so that each is compared with the bounds of the memory by a statement of its own.

//!
//! | file | what it does |
//! |---|---|
//! | `stack` | what is on the stack, and what becomes a variable |
//! | `blocks` | blocks and branches |
//! | `memory` | accesses to memory |
//! | `calls` | calls by name and through the table |

mod blocks;
mod calls;
mod memory;
mod stack;
#[cfg(test)]
mod tests;

use std::fmt::Write;

use anyhow::{Context, Result, bail};
use wasmparser::{FunctionBody, Operator as Op};

use self::blocks::{Frame, Shape};
use super::bounds::Bounds;
use super::operators::{Type, access, operator};
use super::signature::{Signature, value_type};
use super::value::{Entry, Variable};

/// Facts about the module of a function.
pub struct Surroundings<'a> {
    /// The signatures of all functions, imported ones first.
    pub functions: &'a [usize],
    /// The names of the imported functions.
    pub imports: &'a [String],
    /// The signatures that functions refer to.
    pub signatures: &'a [Signature],
    /// The types of the global variables.
    pub globals: &'a [Type],
    /// Bytes of memory from the start.
    pub memory: u64,
    /// Bytes behind the memory that nothing uses.
    pub margin: u64,
}

/// A function in C.
pub struct Function {
    /// Its text.
    pub text: String,
    /// The functions that it calls by name, by their numbers.
    pub calls: Vec<u32>,
}

/// Translates a function.
pub fn translate(body: &FunctionBody, number: u32, surroundings: &Surroundings) -> Result<Function> {
    let signature = &surroundings.signatures[surroundings.functions[number as usize]];
    let mut locals = signature.parameters.clone();
    let parameters = locals.len();
    for declared in body.get_locals_reader()? {
        let (count, of) = declared?;
        locals.extend(std::iter::repeat_n(value_type(of)?, count as usize));
    }
    let mut translation = Translation::new(surroundings, signature, locals);
    let mut operators = body.get_operators_reader()?;
    while !operators.eof() {
        let at = operators.original_position();
        let op = operators.read()?;
        translation.operator(&op).with_context(|| format!("operator {op:?} at byte {at}"))?;
    }
    Ok(translation.finish(number, parameters))
}

struct Translation<'a> {
    surroundings: &'a Surroundings<'a>,
    locals: Vec<Type>,
    /// The lines.
    lines: Vec<String>,
    stack: Vec<Entry>,
    frames: Vec<Frame>,
    labels: usize,
    /// The variables of places that are used.
    places: Vec<(Type, usize)>,
    calls: Vec<u32>,
    uses_memory: bool,
    bounds: Bounds,
    /// Number of open blocks that are unreachable; nothing is written then.
    unreached: Option<usize>,
}

impl<'a> Translation<'a> {
    fn new(surroundings: &'a Surroundings, signature: &Signature, locals: Vec<Type>) -> Self {
        let frame = Frame {
            shape: Shape::Function,
            label: 0,
            begin: 0,
            height: 0,
            result: signature.result,
            is_left_by_branch: false,
            first_part_ends: false,
        };
        Self {
            surroundings,
            locals,
            lines: Vec::new(),
            stack: Vec::new(),
            frames: vec![frame],
            labels: 0,
            places: Vec::new(),
            calls: Vec::new(),
            uses_memory: false,
            bounds: Bounds::of(surroundings.memory, surroundings.margin),
            unreached: None,
        }
    }

    fn line(&mut self, line: impl Into<String>) {
        self.lines.push(line.into());
    }

    fn operator(&mut self, op: &Op) -> Result<()> {
        if let Some(depth) = self.unreached {
            match op {
                Op::Block { .. } | Op::Loop { .. } | Op::If { .. } => self.unreached = Some(depth + 1),
                Op::End if depth > 0 => self.unreached = Some(depth - 1),
                Op::Else if depth == 0 => self.begin_else()?,
                Op::End => self.end()?,
                _ => (),
            }
            return Ok(());
        }
        match op {
            Op::Nop => (),
            Op::Unreachable => {
                self.line("trap(s,UNREACHABLE);");
                self.unreached = Some(0);
            }
            Op::Block { blockty } => self.begin(Shape::Block, *blockty)?,
            Op::Loop { blockty } => self.begin(Shape::Loop, *blockty)?,
            Op::If { blockty } => {
                let condition = self.pop()?;
                self.compute_all();
                self.line(format!("if({}){{", condition.text));
                self.begin(Shape::If { has_else: false }, *blockty)?;
            }
            Op::Else => self.begin_else()?,
            Op::End => self.end()?,
            Op::Br { relative_depth } => {
                let leave = self.branch(*relative_depth)?;
                self.line(leave);
                self.unreached = Some(0);
            }
            Op::BrIf { relative_depth } => {
                let condition = self.pop()?;
                let leave = self.branch(*relative_depth)?;
                self.line(format!("if({}){leave}", condition.text));
            }
            Op::BrTable { targets } => {
                let index = self.pop()?;
                let mut text = format!("switch({}){{", index.value());
                for (number, target) in targets.targets().enumerate() {
                    let leave = self.branch(target?)?;
                    // Cases equal to the default are omitted.
                    if leave != self.branch(targets.default())? {
                        write!(text, "case {number}:{leave}")?;
                    }
                }
                write!(text, "default:{}}}", self.branch(targets.default())?)?;
                self.line(text);
                self.unreached = Some(0);
            }
            Op::Return => {
                let depth = u32::try_from(self.frames.len() - 1)?;
                let leave = self.branch(depth)?;
                self.line(leave);
                self.unreached = Some(0);
            }
            Op::Call { function_index } => self.call(*function_index)?,
            Op::CallIndirect { type_index, table_index: 0 } => self.call_through_table(*type_index)?,
            Op::Drop => drop(self.pop()?),
            Op::Select | Op::TypedSelect { .. } => {
                let (condition, otherwise, first) = (self.pop()?, self.pop()?, self.pop()?);
                let text = format!("({}?{}:{})", condition.text, first.value(), otherwise.value());
                self.combine(text, first.of, false, &[&condition, &otherwise, &first]);
            }
            Op::LocalGet { local_index } => {
                let of = self.locals[*local_index as usize];
                self.push(Entry::of_variable(Variable::Local(*local_index), of));
            }
            Op::LocalSet { local_index } => drop(self.set_local(*local_index)?),
            Op::LocalTee { local_index } => {
                let of = self.set_local(*local_index)?;
                self.push(Entry::of_variable(Variable::Local(*local_index), of));
            }
            Op::GlobalGet { global_index } => {
                let of = self.surroundings.globals[*global_index as usize];
                self.push(Entry { reads: true, ..Entry::plain(format!("s->g{global_index}"), of) });
            }
            Op::GlobalSet { global_index } => {
                let value = self.pop()?;
                self.compute_reads();
                self.line(format!("s->g{global_index}={};", value.text));
            }
            Op::I32Const { value } => self.push(Entry::plain(format!("{}u", value.cast_unsigned()), Type::I32)),
            Op::I64Const { value } => self.push(Entry::plain(format!("{}ull", value.cast_unsigned()), Type::I64)),
            Op::F32Const { value } => {
                let text = decimal(f64::from(f32::from_bits(value.bits())), "f");
                self.push(Entry::plain(text.unwrap_or_else(|| format!("of_bits32({}u)", value.bits())), Type::F32));
            }
            Op::F64Const { value } => {
                let text = decimal(f64::from_bits(value.bits()), "");
                self.push(Entry::plain(text.unwrap_or_else(|| format!("of_bits64({}ull)", value.bits())), Type::F64));
            }
            Op::MemorySize { mem: 0 } => {
                self.push(Entry { reads: true, ..Entry::plain("s->pages".to_owned(), Type::I32) });
            }
            Op::MemoryGrow { mem: 0 } => {
                let pages = self.pop()?;
                self.compute_reads();
                self.push_computed(format!("grow(s,{})", pages.value()), Type::I32);
            }
            Op::MemoryCopy { dst_mem: 0, src_mem: 0 } => self.on_memory("copy", 2)?,
            Op::MemoryFill { mem: 0 } => self.on_memory("fill", 1)?,
            _ => self.by_table(op)?,
        }
        Ok(())
    }

    /// Operators that compute, and accesses to memory.
    fn by_table(&mut self, op: &Op) -> Result<()> {
        let described = format!("{op:?}");
        let name = described.split([' ', '{']).next().unwrap_or_default();
        if let Some(access) = access(name) {
            return self.access(access, memory::place(op)?);
        }
        let Some(operator) = operator(name) else { bail!("it is not translated") };
        let second = if operator.arguments == 2 { Some(self.pop()?) } else { None };
        let first = self.pop()?;
        // A comparison is negated as it is, and taken as a number by all others.
        let as_argument = |entry: &Entry| if name == "I32Eqz" { entry.text.clone() } else { entry.value() };
        let mut text = String::new();
        for letter in operator.text.chars() {
            match letter {
                'A' => text += &as_argument(&first),
                'B' => text += &second.as_ref().map(as_argument).unwrap_or_default(),
                _ => text.push(letter),
            }
        }
        let from: Vec<_> = std::iter::once(&first).chain(&second).collect();
        self.combine(text, operator.result, operator.compares, &from);
        if matches!(op, Op::F64Mul | Op::F32Mul) {
            self.compute(self.stack.len() - 1);
        }
        Ok(())
    }

    fn set_local(&mut self, number: u32) -> Result<Type> {
        let value = self.pop()?;
        let variable = Variable::Local(number);
        self.compute_what_needs(variable, self.stack.len());
        self.assign(variable, &value);
        Ok(self.locals[number as usize])
    }

    fn finish(mut self, number: u32, parameters: usize) -> Function {
        let signature = &self.surroundings.signatures[self.surroundings.functions[number as usize]];
        let mut text = signature.declaration(&format!("w{number}"), true) + "{\n";
        if self.uses_memory {
            text += "u8*const m=s->memory;\n";
        }
        self.places.sort_by_key(|(of, place)| (of.letter(), *place));
        for of in [Type::I32, Type::I64, Type::F32, Type::F64] {
            let locals = (parameters..self.locals.len()).filter(|place| self.locals[*place] == of);
            let locals = locals.map(|place| format!("l{place}=0"));
            let places = self.places.iter().filter(|(other, _)| *other == of);
            let places = places.map(|(of, place)| Variable::Place(*of, *place).name());
            let names: Vec<_> = locals.chain(places).collect();
            if !names.is_empty() {
                text += &format!("{} {};\n", of.in_c(), names.join(","));
            }
        }
        for line in self.lines.iter().filter(|line| !line.is_empty()) {
            text += line;
            text += "\n";
        }
        if self.bounds.is_compared {
            if signature.result.is_none() {
                text += "return;\n";
            }
            text += "X:trap(s,OUT_OF_BOUNDS);\n";
        }
        text += "}\n";
        Function { text, calls: self.calls }
    }
}

/// A number with as many digits as give its bits back, and with the letter of its type; nothing for what has no digits.
fn decimal(value: f64, letter: &str) -> Option<String> {
    let text = format!("{value:?}{letter}");
    value.is_finite().then(|| if value.is_sign_negative() { format!("({text})") } else { text })
}
