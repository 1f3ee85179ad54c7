//! Tools that a build needs: whether they are there, and how to get them.

use std::fmt;

use anyhow::{Result, bail};

use crate::process;

/// A tool that is missing.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Name of the tool.
    pub name: String,
    /// Instructions to install it.
    pub install: String,
}

impl Tool {
    /// A tool and how to get it.
    pub fn new(name: impl Into<String>, install: impl Into<String>) -> Self {
        Self { name: name.into(), install: install.into() }
    }

    /// The tool, if no program of that name can be found.
    pub fn unless_found(program: &str, package: &str) -> Option<Self> {
        process::find(program).is_none().then(|| Self::new(program, format!("apt install {package}")))
    }
}

impl fmt::Display for Tool {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} ({})", self.name, self.install)
    }
}

/// Fails when anything is missing, and then says everything that is.
///
/// # Errors
/// Names each purpose, what is missing for it, and how to get that.
pub fn require<'a>(purposes: impl IntoIterator<Item = (&'a str, Vec<Tool>)>) -> Result<()> {
    let lines: Vec<_> = purposes.into_iter().flat_map(|(purpose, tools)| lines(purpose, &tools)).collect();
    if !lines.is_empty() {
        bail!("tools are missing (docs/platforms.md tells more):\n{}", lines.join("\n"));
    }
    Ok(())
}

fn lines(purpose: &str, tools: &[Tool]) -> Vec<String> {
    tools.iter().map(|tool| format!("  for {purpose}: {tool}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_missing_is_said_at_once() {
        let linker = || vec![Tool::new("a linker", "apt install lld")];
        let problem = require([("win64", linker()), ("linux64", vec![]), ("darwin64", linker())]).unwrap_err();
        let problem = problem.to_string();
        assert!(problem.contains("for win64: a linker (apt install lld)\n  for darwin64: a linker"), "{problem}");
        assert!(!problem.contains("linux64"), "{problem}");
        assert!(require([("linux64", vec![])]).is_ok());
    }

    #[test]
    fn programs_are_found_on_the_path() {
        assert_eq!(Tool::unless_found("cargo", "cargo"), None);
        assert_eq!(
            Tool::unless_found("no-such-program", "package"),
            Some(Tool::new("no-such-program", "apt install package"))
        );
    }
}
