//! Memory and instructions of the plant on a target, and the table of them in `docs/target.md`.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use pneumatic_servo_packaging::process;
use pneumatic_servo_packaging::workspace::Workspace;

use super::compiled::Compiler;

/// The page that has the table.
const PAGE: &str = "docs/target.md";
/// The major version of the compiler with which the table was made: others make code of another size.
const VERSION: &str = "12";

/// Memory and instructions that the plant needs.
#[derive(Debug, Default, PartialEq)]
pub struct Needs {
    /// Bytes of code and constants.
    text: u64,
    /// Bytes of variables, among them the static instances.
    data: u64,
    /// Bytes up to which a run uses the memory of an instance.
    memory: u64,
    /// Bytes of the plant's stack, inside that memory.
    inner_stack: u64,
    /// Bytes of the stack of C.
    stack: u64,
    /// Instructions of a step for each law: in the mean, and at most.
    instructions: Vec<(u64, u64)>,
}

impl Needs {
    /// Needs of objects by themselves.
    ///
    /// # Errors
    /// When their size is not told.
    pub fn of_objects(compiler: &Compiler, objects: &[PathBuf]) -> Result<Self> {
        let tool = compiler.program.strip_suffix("gcc").map_or_else(|| "size".to_owned(), |of| format!("{of}size"));
        let printed = process::output(Command::new(tool).arg("--totals").args(objects))?;
        Self::of_sizes(&printed).with_context(|| format!("no size of objects: {printed}"))
    }

    /// Sums of the output of `size`: code, variables and zeros in the first columns of the last line.
    fn of_sizes(printed: &str) -> Option<Self> {
        let mut columns = printed.lines().last()?.split_whitespace().map(|word| word.parse::<u64>().ok());
        let (text, data, zeros) = (columns.next()??, columns.next()??, columns.next()??);
        Some(Self { text, data: data + zeros, ..Self::default() })
    }

    /// Adds the measurements of a program.
    ///
    /// # Errors
    /// When it is not known.
    pub fn add(&mut self, measured: &str) -> Result<()> {
        let mut words = measured.split_whitespace();
        let what = words.next().unwrap_or_default();
        let numbers: Vec<u64> = words.map(str::parse).collect::<Result<_, _>>().context("no number was measured")?;
        match (what, &numbers[..]) {
            ("instructions", &[mean, most]) => self.instructions.push((mean, most)),
            ("memory", &[end, stack]) => (self.memory, self.inner_stack) = (end, stack),
            ("stack", &[bytes]) => self.stack = bytes,
            _ => bail!("`{measured}` is nothing that is measured"),
        }
        Ok(())
    }

    /// Its row of the table.
    fn row(&self, name: &str) -> String {
        let means = || self.instructions.iter().map(|(mean, _)| *mean);
        let most = self.instructions.iter().map(|(_, most)| *most).max();
        let [least, greatest, most] = [means().min(), means().max(), most].map(|it| thousands(it.unwrap_or_default()));
        let bytes = [self.text, self.data, self.memory, self.inner_stack, self.stack].map(kilobytes);
        format!("| {name} | {} | {least} to {greatest} | {most} |", bytes.join(" | "))
    }

    /// Its row of the table of loops alone, which have one law and no more memory than the variables.
    fn row_alone(&self, law: &str) -> String {
        let (mean, most) = self.instructions.first().copied().unwrap_or_default();
        let bytes = [self.text, self.data, self.inner_stack, self.stack].map(kilobytes);
        format!("| *{law}* | {} | {} | {} |", bytes.join(" | "), thousands(mean), thousands(most))
    }

    /// Compares with the row of a loop alone under a law.
    ///
    /// # Errors
    /// As [`compare`](Self::compare).
    pub fn compare_alone(&self, workspace: &Workspace, law: &str, compiler: &Compiler) -> Result<()> {
        Self::compare_row(workspace, &self.row_alone(law), compiler)
    }

    /// Compares with the row of a target on the page, where the compiler is the one that the page is about.
    ///
    /// # Errors
    /// When the page says something else.
    pub fn compare(&self, workspace: &Workspace, name: &str, compiler: &Compiler) -> Result<()> {
        Self::compare_row(workspace, &self.row(name), compiler)
    }

    fn compare_row(workspace: &Workspace, row: &str, compiler: &Compiler) -> Result<()> {
        println!("{row}");
        let version = compiler.version()?;
        let version = version.trim();
        if version.split('.').next() != Some(VERSION) {
            return process::leave_out(
                "Comparison with the page",
                &format!("{} is of version {version}", compiler.program),
            );
        }
        let page = std::fs::read_to_string(workspace.root.join(PAGE)).with_context(|| format!("cannot read {PAGE}"))?;
        ensure!(page.lines().any(|line| line == row), "{PAGE} should say\n{row}");
        Ok(())
    }
}

/// Bytes in KB of 1000, so coarse that a patch of a compiler does not show.
fn kilobytes(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{:.1} KB", bytes as f64 / 1e3),
        10_000..1_000_000 => format!("{} KB", bytes.div_ceil(1000)),
        _ => format!("{:.2} MB", bytes as f64 / 1e6),
    }
}

/// A number of instructions in thousands.
fn thousands(instructions: u64) -> String {
    let thousands = (instructions + 500) / 1000;
    match thousands {
        0..1000 => format!("{thousands},000"),
        _ => format!("{},{:03},000", thousands / 1000, thousands % 1000),
    }
}
