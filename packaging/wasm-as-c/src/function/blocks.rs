//! Blocks, and branches out of them.

use anyhow::{Context, Result, bail};
use wasmparser::BlockType;

use super::super::operators::Type;
use super::super::signature::value_type;
use super::super::value::{Entry, Variable};
use super::Translation;

/// Kind of the block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    Function,
    Block,
    Loop,
    If { has_else: bool },
}

/// A block that is open.
#[derive(Debug)]
pub struct Frame {
    pub shape: Shape,
    /// The number of its label.
    pub label: usize,
    /// Where the text of a loop begins.
    pub begin: usize,
    /// The height of the stack below it.
    pub height: usize,
    pub result: Option<Type>,
    pub is_left_by_branch: bool,
    /// Whether the first part of an `if` with two ends by itself.
    pub first_part_ends: bool,
}

impl Translation<'_> {
    pub(super) fn begin(&mut self, shape: Shape, blockty: BlockType) -> Result<()> {
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

    /// The statement that leaves the block at a depth, with its result.
    pub(super) fn branch(&mut self, depth: u32) -> Result<String> {
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
    pub(super) fn settle(&mut self) -> Result<()> {
        let frame = self.frames.last().context("no block is open")?;
        let (height, result) = (frame.height, frame.result);
        if let (None, Some(of)) = (self.unreached, result) {
            let value = self.pop()?;
            self.assign(Variable::Place(of, height), &value);
        }
        self.stack.truncate(height);
        Ok(())
    }

    pub(super) fn begin_else(&mut self) -> Result<()> {
        self.settle()?;
        self.line("}else{");
        let frame = self.frames.last_mut().context("no block is open")?;
        frame.first_part_ends = self.unreached.is_none();
        frame.shape = Shape::If { has_else: true };
        self.bounds.begin_else();
        self.unreached = None;
        Ok(())
    }

    pub(super) fn end(&mut self) -> Result<()> {
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
}
