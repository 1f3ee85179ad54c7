//! One function of WebAssembly as a function in C.
//!
//! The stack of WebAssembly is followed while reading: an entry is an expression in C, which is written where it is taken,
//! or into a variable of its place before anything changes what it depends on. Products of floating-point numbers always go
//! into a variable: the standard of C lets a compiler contract a product and a sum within one expression only.
//! Addresses become variables, too, so that each is compared with the bounds of the memory by a statement of its own.

use std::fmt::Write;

use anyhow::{Context, Result, bail, ensure};
use wasmparser::{BlockType, FunctionBody, MemArg, Operator as Op};

use super::bounds::{Bounds, MARGIN};
use super::operators::{Access, Type, access, operator};
use super::signature::{Signature, value_type};
use super::value::{Entry, Variable};

/// What a function may ask of its module.
pub struct Surroundings<'a> {
    /// The signatures of all functions, imported ones first.
    pub functions: &'a [usize],
    /// The names of the imported functions.
    pub imports: &'a [String],
    /// The signatures that functions refer to.
    pub signatures: &'a [Signature],
    /// The types of the global variables.
    pub globals: &'a [Type],
    /// How many bytes of memory there are from the start on.
    pub memory: u64,
}

/// A function in C.
pub struct Function {
    /// Its text.
    pub text: String,
    /// The functions that it calls by name, by their numbers.
    pub calls: Vec<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Function,
    Block,
    Loop,
    If { has_else: bool },
}

/// A block that is open.
#[derive(Debug)]
struct Frame {
    shape: Shape,
    /// The number of its label.
    label: usize,
    /// Where the text of a loop begins.
    begin: usize,
    /// The height of the stack below it.
    height: usize,
    result: Option<Type>,
    is_left_by_branch: bool,
    /// Whether the first part of an `if` with two ends by itself.
    first_part_ends: bool,
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
    /// How many blocks are open that are never reached; nothing is written then.
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
            bounds: Bounds::of(surroundings.memory),
            unreached: None,
        }
    }

    fn line(&mut self, line: impl Into<String>) {
        self.lines.push(line.into());
    }

    /// The expressions that are longer are computed at once, so that none grows without limit.
    const LONGEST: usize = 160;

    fn push(&mut self, entry: Entry) {
        let is_long = entry.text.len() > Self::LONGEST;
        self.stack.push(entry);
        if is_long {
            self.compute(self.stack.len() - 1);
        }
    }

    fn pop(&mut self) -> Result<Entry> {
        let floor = self.frames.last().map_or(0, |frame| frame.height);
        ensure!(self.stack.len() > floor, "the stack is empty");
        self.stack.pop().context("the stack is empty")
    }

    /// Computes an entry into the variable of its place. Entries above it never depend on that variable.
    fn compute(&mut self, place: usize) {
        let entry = &self.stack[place];
        let variable = Variable::Place(entry.of, place);
        if entry.is_constant() || entry.text == variable.name() {
            return;
        }
        self.compute_what_needs(variable, place);
        let entry = Entry::of_variable(variable, self.stack[place].of);
        let old = std::mem::replace(&mut self.stack[place], entry);
        self.assign(variable, &old);
    }

    /// Computes the entries below a height that depend on a variable, which is about to change.
    fn compute_what_needs(&mut self, variable: Variable, height: usize) {
        for place in 0..height {
            if self.stack[place].needs.contains(&variable) {
                self.compute(place);
            }
        }
    }

    fn compute_all(&mut self) {
        for place in 0..self.stack.len() {
            self.compute(place);
        }
    }

    /// Computes what depends on memory or global variables, which are about to change.
    fn compute_reads(&mut self) {
        for place in 0..self.stack.len() {
            if self.stack[place].reads {
                self.compute(place);
            }
        }
    }

    fn assign(&mut self, variable: Variable, entry: &Entry) {
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
    fn push_computed(&mut self, text: String, of: Type) {
        let variable = Variable::Place(of, self.stack.len());
        self.compute_what_needs(variable, self.stack.len());
        self.assign(variable, &Entry::plain(text, of));
        self.stack.push(Entry::of_variable(variable, of));
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
                    // What is as in the default needs no case of its own.
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
                let text = decimal(f64::from(f32::from_bits(value.bits())));
                let text = text.map_or_else(|| format!("of_bits32({}u)", value.bits()), |text| format!("{text}f"));
                self.push(Entry::plain(text, Type::F32));
            }
            Op::F64Const { value } => {
                let text = decimal(f64::from_bits(value.bits()));
                let text = text.unwrap_or_else(|| format!("of_bits64({}ull)", value.bits()));
                self.push(Entry::plain(text, Type::F64));
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
            return self.access(access, place(op)?);
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

    fn combine(&mut self, text: String, of: Type, compares: bool, from: &[&Entry]) {
        let needs = from.iter().flat_map(|entry| entry.needs.iter().copied()).collect();
        let reads = from.iter().any(|entry| entry.reads);
        self.push(Entry { text, of, compares, needs, reads });
    }

    fn access(&mut self, access: Access, place: MemArg) -> Result<()> {
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

    /// Traps unless there are so many bytes from an address on; what is not known to be there is compared, as a variable.
    fn ensure_within(&mut self, place: usize, bytes: u64) {
        if self.bounds.has(&self.stack[place], bytes) {
            return;
        }
        if !self.stack[place].is_variable() {
            self.compute(place);
        }
        let comparison = self.bounds.compare(&self.stack[place], bytes);
        self.line(comparison);
    }

    /// Copies or fills memory, by a function whose first arguments are so many addresses. Mostly it is known how much, that of
    /// a structure: then addresses are compared as for any access.
    fn on_memory(&mut self, function: &str, addresses: usize) -> Result<()> {
        let known = self.stack.last().and_then(Entry::number).filter(|bytes| *bytes <= MARGIN);
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

    fn set_local(&mut self, number: u32) -> Result<Type> {
        let value = self.pop()?;
        let variable = Variable::Local(number);
        self.compute_what_needs(variable, self.stack.len());
        self.assign(variable, &value);
        Ok(self.locals[number as usize])
    }

    fn call(&mut self, function: u32) -> Result<()> {
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

    fn call_through_table(&mut self, signature: u32) -> Result<()> {
        let index = self.pop()?;
        let name = format!("((t{signature})entry(s,{signature}u,{}))", index.value());
        // The index is evaluated with the arguments, none of which changes anything.
        self.call_by(&name, signature as usize)
    }

    fn call_by(&mut self, name: &str, signature: usize) -> Result<()> {
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

    fn begin(&mut self, shape: Shape, blockty: BlockType) -> Result<()> {
        let result = match blockty {
            BlockType::Empty => None,
            BlockType::Type(of) => Some(value_type(of)?),
            BlockType::FuncType(_) => bail!("blocks with arguments or several results are not translated"),
        };
        self.compute_all();
        self.labels += 1;
        let begin = self.lines.len();
        if shape == Shape::Loop {
            self.line("");
        }
        self.frames.push(Frame {
            shape,
            label: self.labels,
            begin,
            height: self.stack.len(),
            result,
            is_left_by_branch: false,
            first_part_ends: false,
        });
        self.bounds.begin(shape == Shape::Loop);
        Ok(())
    }

    /// The statement that leaves the block so many blocks up, with its result.
    fn branch(&mut self, depth: u32) -> Result<String> {
        let target = self.frames.len().checked_sub(1 + depth as usize).context("a branch out of the function")?;
        let frame = &mut self.frames[target];
        let height = frame.height;
        if frame.shape == Shape::Loop {
            frame.is_left_by_branch = true;
            return Ok(format!("goto L{};", frame.label));
        }
        let value = match frame.result {
            Some(of) => Some((of, self.stack.last().context("the stack is empty")?.value())),
            None => None,
        };
        if frame.shape == Shape::Function {
            return Ok(value.map_or_else(|| "return;".to_owned(), |(_, value)| format!("return {value};")));
        }
        frame.is_left_by_branch = true;
        let leave = format!("goto L{};", frame.label);
        let Some((of, value)) = value else { return Ok(leave) };
        let variable = Variable::Place(of, height);
        self.bounds.forget(variable);
        if !self.places.contains(&(of, height)) {
            self.places.push((of, height));
        }
        Ok(if value == variable.name() { leave } else { format!("{{{}={value};{leave}}}", variable.name()) })
    }

    /// Writes the result of a block into its variable, where its end is reached.
    fn settle(&mut self) -> Result<()> {
        let frame = self.frames.last().context("no block is open")?;
        let (height, result) = (frame.height, frame.result);
        if let (None, Some(of)) = (self.unreached, result) {
            let value = self.pop()?;
            let text = value.value();
            self.assign(Variable::Place(of, height), &Entry { text, compares: false, ..value });
        }
        self.stack.truncate(height);
        Ok(())
    }

    fn begin_else(&mut self) -> Result<()> {
        self.settle()?;
        self.line("}else{");
        let frame = self.frames.last_mut().context("no block is open")?;
        frame.first_part_ends = self.unreached.is_none();
        frame.shape = Shape::If { has_else: true };
        self.bounds.begin_else();
        self.unreached = None;
        Ok(())
    }

    fn end(&mut self) -> Result<()> {
        let frame = self.frames.last().context("no block is open")?;
        if frame.shape == Shape::Function {
            if let (None, Some(_)) = (self.unreached, frame.result) {
                let value = self.pop()?.value();
                self.line(format!("return {value};"));
            }
            self.frames.pop();
            return Ok(());
        }
        self.settle()?;
        let frame = self.frames.pop().context("no block is open")?;
        let label = format!("L{}:;", frame.label);
        self.bounds.end(match frame.shape {
            Shape::Loop => true,
            Shape::Block => !frame.is_left_by_branch,
            _ => false,
        });
        let is_reached = match frame.shape {
            Shape::Loop => {
                if frame.is_left_by_branch {
                    self.lines[frame.begin] = label;
                }
                self.unreached.is_none()
            }
            Shape::If { has_else } => {
                self.line("}");
                if frame.is_left_by_branch {
                    self.line(label);
                }
                self.unreached.is_none() || frame.is_left_by_branch || frame.first_part_ends || !has_else
            }
            _ => {
                if frame.is_left_by_branch {
                    self.line(label);
                }
                self.unreached.is_none() || frame.is_left_by_branch
            }
        };
        self.unreached = if is_reached { None } else { Some(0) };
        if let Some(of) = frame.result {
            self.stack.push(Entry::of_variable(Variable::Place(of, frame.height), of));
        }
        Ok(())
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

/// A number with as many digits as give its bits back; nothing for what has no digits.
fn decimal(value: f64) -> Option<String> {
    value.is_finite().then(|| if value.is_sign_negative() { format!("({value:?})") } else { format!("{value:?}") })
}

/// Where an access to memory begins, counted from its address, and how that is aligned.
fn place(op: &Op) -> Result<MemArg> {
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

#[cfg(test)]
mod tests {
    use wasmparser::BinaryReader;

    use super::*;

    /// The lines of a function of one address, with a memory of one page.
    fn lines(operators: &[&[u8]]) -> Result<Vec<String>> {
        let code = [&[0][..], &operators.concat(), &[0x0b]].concat();
        let signatures = [Signature { parameters: vec![Type::I32], result: None }];
        let surroundings =
            Surroundings { functions: &[0], imports: &[], signatures: &signatures, globals: &[], memory: 65_536 };
        let function = translate(&FunctionBody::new(BinaryReader::new(&code, 0)), 0, &surroundings)?;
        Ok(function.text.lines().map(str::to_owned).collect())
    }

    /// Those that compare an address with the bounds.
    fn comparisons(operators: &[&[u8]]) -> Result<Vec<String>> {
        Ok(lines(operators)?.into_iter().filter(|line| line.starts_with("within(")).collect())
    }

    const ADDRESS: &[u8] = &[0x20, 0];
    const LOAD: &[u8] = &[0x2b, 3, 0, 0x1a];
    const LOAD_AT_16: &[u8] = &[0x2b, 3, 16, 0x1a];
    const LOAD_AT_16368: &[u8] = &[0x2b, 3, 0xf0, 0x7f, 0x1a];
    const LOAD_AT_20000: &[u8] = &[0x2b, 3, 0xa0, 0x9c, 0x01, 0x1a];
    const PLUS_16: &[u8] = &[0x41, 16, 0x6a];
    const SET: &[u8] = &[0x21, 0];
    const COPY: &[u8] = &[0xfc, 10, 0, 0];
    const CHANGE: &[u8] = &[0x41, 1, 0x21, 0];
    const BLOCK: &[u8] = &[0x02, 0x40];
    const LOOP: &[u8] = &[0x03, 0x40];
    const IF: &[u8] = &[0x20, 0, 0x04, 0x40];
    const ELSE: &[u8] = &[0x05];
    const LEAVE_IF: &[u8] = &[0x20, 0, 0x0d, 0];
    const END: &[u8] = &[0x0b];

    #[test]
    fn an_address_is_compared_once_until_it_changes() -> Result<()> {
        let once = ["within(l0,8u);"];
        assert_eq!(comparisons(&[ADDRESS, LOAD, ADDRESS, LOAD_AT_16])?, once);
        let again = ["within(l0,8u);", "within(l0,24u);"];
        assert_eq!(comparisons(&[ADDRESS, LOAD, CHANGE, ADDRESS, LOAD_AT_16])?, again);
        // What is far from the address, and a constant in the memory and not.
        assert_eq!(comparisons(&[ADDRESS, LOAD, ADDRESS, LOAD_AT_20000])?, ["within(l0,8u);", "within(l0,20008u);"]);
        assert_eq!(comparisons(&[&[0x41, 8], LOAD])?, [""; 0]);
        assert_eq!(comparisons(&[&[0x41, 0x7c], LOAD])?, ["within(4294967292u,8u);"]);
        Ok(())
    }

    #[test]
    fn sums_of_an_address_and_a_number_are_known_as_far_as_the_margin() -> Result<()> {
        let once = ["within(l0,8u);"];
        assert_eq!(comparisons(&[ADDRESS, LOAD, ADDRESS, PLUS_16, LOAD])?, once);
        assert_eq!(comparisons(&[ADDRESS, LOAD, ADDRESS, PLUS_16, SET, ADDRESS, LOAD_AT_16])?, once);
        // The last byte of the margin, and one that is beyond it by 8, and a number that is no small one.
        assert_eq!(comparisons(&[ADDRESS, LOAD, ADDRESS, LOAD_AT_16368])?, once);
        let far = [ADDRESS, LOAD, ADDRESS, PLUS_16, SET, ADDRESS, LOAD_AT_16368];
        assert_eq!(comparisons(&far)?, ["within(l0,8u);", "within(l0,16376u);"]);
        let below = comparisons(&[ADDRESS, LOAD, ADDRESS, &[0x41, 0x70, 0x6a], LOAD])?;
        assert_eq!(below, ["within(l0,8u);", "within(i0,8u);"]);
        // What an address was before it changed says nothing.
        assert_eq!(comparisons(&[ADDRESS, PLUS_16, SET, ADDRESS, LOAD])?, once);
        Ok(())
    }

    #[test]
    fn copying_and_filling_of_a_known_size_compares_as_other_accesses_do() -> Result<()> {
        let of = |from: &[u8], size: &[u8]| lines(&[ADDRESS, from, size, COPY]);
        let small = of(&[0x20, 0, 0x41, 16, 0x6a], &[0x41, 40])?;
        assert_eq!(small[2..4], ["within(l0,40u);", "copy_known(m,l0,(l0+16u),40u);"]);
        let filled = lines(&[ADDRESS, &[0x41, 0, 0x41, 40, 0xfc, 11, 0]])?;
        assert_eq!(filled[2..4], ["within(l0,40u);", "fill_known(m,l0,0u,40u);"]);
        // A size of 20,000 bytes, and one that is not known.
        assert_eq!(of(ADDRESS, &[0x41, 0xa0, 0x9c, 0x01])?[1], "copy(s,l0,l0,20000u);");
        assert_eq!(of(ADDRESS, ADDRESS)?[1], "copy(s,l0,l0,l0);");
        Ok(())
    }

    #[test]
    fn an_address_is_compared_again_where_a_path_comes_in_that_did_not_or_changed_it() -> Result<()> {
        let twice = ["within(l0,8u);", "within(l0,24u);"];
        let of = |before: &[&[u8]]| comparisons(&[&before.concat(), ADDRESS, LOAD_AT_16]);
        assert_eq!(of(&[BLOCK, LEAVE_IF, ADDRESS, LOAD, END])?, twice);
        assert_eq!(of(&[ADDRESS, LOAD, BLOCK, LEAVE_IF, CHANGE, END])?, twice);
        assert_eq!(of(&[IF, ADDRESS, LOAD, END])?, twice);
        assert_eq!(of(&[ADDRESS, LOAD, IF, CHANGE, END])?, twice);
        assert_eq!(of(&[IF, ADDRESS, LOAD, ELSE, END])?, twice);
        assert_eq!(of(&[IF, ELSE, ADDRESS, LOAD, END])?, twice);
        // A loop comes back to its begin, and ends behind its last statement.
        assert_eq!(comparisons(&[ADDRESS, LOAD, LOOP, ADDRESS, LOAD_AT_16, CHANGE, LEAVE_IF, END])?, twice);
        assert_eq!(of(&[ADDRESS, LOAD, LOOP, CHANGE, END])?, twice);
        // Nothing changes it on these.
        let once = ["within(l0,8u);"];
        assert_eq!(of(&[ADDRESS, LOAD, BLOCK, LEAVE_IF, END])?, once);
        assert_eq!(of(&[ADDRESS, LOAD, IF, ELSE, END])?, once);
        assert_eq!(of(&[ADDRESS, LOAD, LOOP, LEAVE_IF, END])?, once);
        assert_eq!(of(&[LOOP, ADDRESS, LOAD, LEAVE_IF, END])?, once);
        Ok(())
    }

    const DEAD: &[u8] = &[0x00];

    /// Behind a trap nothing is reached until the end of its block, whatever blocks are within.
    #[test]
    fn what_is_never_reached_is_left_out_with_the_blocks_within() -> Result<()> {
        let alive = lines(&[BLOCK, LEAVE_IF, DEAD, END, ADDRESS, LOAD])?;
        assert!(alive.iter().any(|line| line.starts_with("within(l0,")), "{alive:?}");
        for dead in [&[BLOCK, END][..], &[LOOP, BLOCK, END, END], &[IF, ELSE, END], &[BLOCK, END, BLOCK, END]] {
            let nested = [&[BLOCK, LEAVE_IF, DEAD][..], dead, &[END, ADDRESS, LOAD]].concat();
            assert_eq!(lines(&nested)?, alive);
        }
        Ok(())
    }

    #[test]
    fn branches_lead_to_the_end_of_the_block_that_they_count_to() -> Result<()> {
        let to = |depth: u8| lines(&[BLOCK, BLOCK, &[0x20, 0, 0x0d, depth], END, CHANGE, END, ADDRESS, LOAD]);
        let place = |text: &[String], what: &str| text.iter().position(|line| line.contains(what));
        for (depth, is_after_change) in [(0, false), (1, true)] {
            let text = to(depth)?;
            let label =
                text.iter().find_map(|line| line.split("goto ").nth(1)?.split(';').next()).context("no branch")?;
            let end = place(&text, &format!("{label}:")).context("no label")?;
            let change = place(&text, "l0=1u;").context("no change")?;
            assert_eq!(end > change, is_after_change, "{text:?}");
        }
        let problem = lines(&[BLOCK, &[0x0c, 7], END]).err().map(|error| format!("{error:#}")).unwrap_or_default();
        assert!(problem.contains("a branch out of the function"), "{problem}");
        Ok(())
    }

    /// Numbers of 64 bits are written with all their bits, as unsigned ones.
    #[test]
    fn constants_have_all_their_bits() -> Result<()> {
        for (bytes, expected) in [(0x05, "5ull"), (0x7f, "18446744073709551615ull")] {
            let text = lines(&[ADDRESS, &[0x42, bytes], &[0x37, 3, 0]])?;
            assert!(text.iter().any(|line| line.contains(expected)), "{text:?}");
        }
        Ok(())
    }

    const RETURN: &[u8] = &[0x0f];

    #[test]
    fn a_return_ends_the_function_however_deep_it_is() -> Result<()> {
        let text = lines(&[IF, RETURN, END, CHANGE])?;
        assert_eq!(text[1..], ["if(l0){", "return;", "}", "l0=1u;", "}"]);
        let deep = lines(&[BLOCK, LOOP, IF, RETURN, END, END, END, CHANGE])?;
        assert_eq!(deep, text);
        Ok(())
    }

    #[test]
    fn a_choice_has_both_its_parts() -> Result<()> {
        const OTHER: &[u8] = &[0x41, 2, 0x21, 0];
        assert_eq!(lines(&[IF, CHANGE, ELSE, OTHER, END])?[1..], ["if(l0){", "l0=1u;", "}else{", "l0=2u;", "}", "}"]);
        // The second part is reached also where the first one leaves.
        assert_eq!(lines(&[IF, RETURN, ELSE, OTHER, END])?[1..], ["if(l0){", "return;", "}else{", "l0=2u;", "}", "}"]);
        Ok(())
    }

    /// The function at place 3 of the table, with the signature 0.
    #[test]
    fn a_function_of_the_table_is_called_with_its_arguments() -> Result<()> {
        let call = |table| lines(&[ADDRESS, &[0x41, 3, 0x11, 0, table]]);
        assert_eq!(call(0)?[1..], ["((t0)entry(s,0u,3u))(s,l0);", "}"]);
        assert!(call(1).is_err(), "there is one table");
        Ok(())
    }
}
