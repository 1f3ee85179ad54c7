//! What the plant needs on a target, and the table of that in `docs/target.md`.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use super::compiled::Compiler;
use crate::process;
use crate::workspace::Workspace;

/// The page that has the table.
const PAGE: &str = "docs/target.md";
/// The major version of the compiler with which the table was made: others make code of another size.
const VERSION: &str = "12";

/// What the plant needs.
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
    /// What objects need by themselves.
    ///
    /// # Errors
    /// When their size is not told.
    pub fn of_objects(compiler: &Compiler, objects: &[PathBuf]) -> Result<Self> {
        let tool = compiler.program.strip_suffix("gcc").map_or_else(|| "size".to_owned(), |of| format!("{of}size"));
        let printed = process::output(Command::new(tool).arg("--totals").args(objects))?;
        Self::of_sizes(&printed).with_context(|| format!("no size of objects: {printed}"))
    }

    /// What `size` prints: code, variables and zeros in the first columns of the last line.
    fn of_sizes(printed: &str) -> Option<Self> {
        let mut columns = printed.lines().last()?.split_whitespace().map(|word| word.parse::<u64>().ok());
        let (text, data, zeros) = (columns.next()??, columns.next()??, columns.next()??);
        Some(Self { text, data: data + zeros, ..Self::default() })
    }

    /// Takes in what a program has measured.
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

    /// Compares with the row of a target on the page, where the compiler is the one that the page is about.
    ///
    /// # Errors
    /// When the page says something else.
    pub fn compare(&self, workspace: &Workspace, name: &str, compiler: &Compiler) -> Result<()> {
        let row = self.row(name);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stand_in::{Answer, StandIn};

    #[test]
    fn sizes_are_read_also_where_the_hexadecimal_sum_has_no_letter() {
        let sizes = |sum: &str| Needs::of_sizes(&format!("   text\t   data\t    bss\n{sum}\t(TOTALS)\n"));
        let of = |text, data| Some(Needs { text, data, ..Needs::default() });
        assert_eq!(sizes("1798047\t8\t1380584\t3178631\t308087"), of(1_798_047, 1_380_592));
        assert_eq!(sizes("1989\t0\t1380584\t1382573\t1518ad"), of(1989, 1_380_584));
        assert_eq!(sizes("none"), None);
    }

    #[test]
    fn what_is_measured_makes_a_row() -> Result<()> {
        let mut needs = Needs { text: 1_504_243, data: 1_380_584, ..Needs::default() };
        for line in ["instructions 31837 114000", "instructions 360700 94400", "memory 1114077 145200", "stack 4412"] {
            needs.add(line)?;
        }
        let row = "| Cortex | 1.50 MB | 1.38 MB | 1.11 MB | 146 KB | 4.4 KB | 32,000 to 361,000 | 114,000 |";
        assert_eq!(needs.row("Cortex"), row);
        assert_eq!([31_499, 1_830_440].map(thousands), ["31,000", "1,830,000"]);
        assert!(needs.add("stack many").is_err() && needs.add("heap 3").is_err());
        Ok(())
    }

    /// The row must stand on the page, for the compiler that the page is about; another is not compared,
    /// which is an error under CI.
    #[test]
    fn needs_are_compared_with_the_page() -> Result<()> {
        let folder = crate::files::scratch("needs");
        let workspace = Workspace { root: folder.clone(), ..Workspace::of_a_test(&folder.join("target")) };
        let compiler = Compiler { program: "arm-none-eabi-gcc", folder: "", always: &[], compiling: &[], linking: &[] };
        let compare = |version: &str, ci: &str| {
            let version = format!("{version}.3.1\n");
            let machine = StandIn::new(move |command| {
                let printed = if command.line().starts_with("arm-none-eabi-size --totals /a.o") {
                    "10 20 30 60 x\n"
                } else {
                    &version
                };
                Some(Answer::Prints(printed.to_owned()))
            });
            let ask = || Needs::of_objects(&compiler, &["/a.o".into()])?.compare(&workspace, "Cortex", &compiler);
            machine.with("CI", ci).does(ask).0.map_or_else(|problem| problem.to_string(), |()| String::new())
        };
        let row = Needs { text: 10, data: 50, ..Needs::default() }.row("Cortex");
        crate::files::write(&folder.join(PAGE), format!("# Needs\n{row}\n"))?;
        assert_eq!(compare(VERSION, ""), "");
        crate::files::write(&folder.join(PAGE), "# Needs\n")?;
        assert_eq!(compare(VERSION, ""), format!("{PAGE} should say\n{row}"));
        assert_eq!(compare("1", ""), "");
        let left_out =
            "Comparison with the page: arm-none-eabi-gcc is of version 1.3.1; with CI set nothing is left out";
        assert_eq!(compare("1", "1"), left_out);
        Ok(std::fs::remove_dir_all(&folder)?)
    }
}
