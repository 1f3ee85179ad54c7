//! `cargo xtask stress`: whether every model runs under every law with any legal parameters, in a bounded number of solver
//! steps.
//!
//! A seeded search: the same seed draws the same sets, and finds the same on every machine.
//!
//! | file | what it does |
//! |---|---|
//! | `draw` | random sets of parameters and inputs |
//! | `search` | a search, and its goals |
//! | `findings` | what it finds |

mod draw;
mod findings;
mod search;

use anyhow::{Result, bail, ensure};
use clap::Args;

use self::search::{SEARCHES, Search};
use crate::process::heading;

/// Search for legal parameters that a model cannot run with, or not in a bounded number of solver steps.
///
/// Seeded and repeatable: every model under every law with random options, within factors of 3 and 30 of the defaults and in
/// the whole legal range, under moving and under constant inputs, from time 0 and from 1.7e9 s. A large search is quicker in
/// an optimised program: `cargo run --release --package pneumatic-servo-packaging -- stress`.
#[derive(Args)]
pub struct Stress {
    /// Sets for each model and law.
    #[arg(long, default_value_t = 20)]
    sets: u32,
    /// Length of a run in s.
    #[arg(long, default_value_t = 2.0)]
    seconds: f64,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many of the searches to run, the narrowest first.
    #[arg(long, default_value_t = SEARCHES.len())]
    searches: usize,
    /// Only the runs whose name, as it is printed, contains this; shows what they change of the defaults.
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
}

impl Stress {
    /// What the gate can afford: one short run of every model under every law near the defaults. The whole legal range
    /// takes minutes, and an optimised program.
    pub const SHORT: Self = Self { sets: 1, seconds: 0.1, seed: 1, searches: 4, only: None };

    /// Searches, and prints a table by law and cause.
    ///
    /// # Errors
    /// When a goal is missed, or nothing is run.
    pub fn run(&self) -> Result<()> {
        self.meet(SEARCHES.iter().take(self.searches))
    }

    fn meet<'a>(&self, searches: impl Iterator<Item = &'a Search>) -> Result<()> {
        let mut missed = Vec::new();
        for search in searches {
            heading(&format!("Stress: {}", search.name));
            let findings = search.run(self)?;
            println!("{findings}");
            let only = self.only.as_deref().unwrap_or_default();
            ensure!(findings.runs > 0, "{}: no run of {} sets has a name with \"{only}\"", search.name, self.sets);
            missed.extend(search.missed(&findings));
        }
        if !missed.is_empty() {
            bail!("{}", missed.join("\n"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One short run; no step takes less than one solver step, and none more than the goal of the project.
    #[test]
    fn missed_goals_of_all_searches_are_told() {
        let stress = Stress { seconds: 0.01, only: Some("FrictionBench LuGre 0".into()), ..Stress::SHORT };
        let [near, wider] = [&SEARCHES[0], &SEARCHES[3]];
        stress.meet([near, wider].into_iter()).expect("all goals are met");
        let strict = |search: &Search| Search { most: 0, ..*search };
        let problem = stress.meet([&strict(near), wider, &strict(wider)].into_iter()).expect_err("a goal is missed");
        let text = problem.to_string();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2, "{text}");
        assert!(
            lines[0].starts_with("within a factor of 3: ") && lines[1].starts_with("within a factor of 30: "),
            "{text}"
        );
        assert!(
            lines.iter().all(|line| line.ends_with(" in one communication step of FrictionBench LuGre 0")),
            "{text}"
        );
    }

    /// As many searches as are asked for, each under its heading.
    #[test]
    fn searches_are_run_from_the_narrowest_on() {
        let only = Some("FrictionBench LuGre".to_owned());
        let effort = Stress { sets: 1, seconds: 0.002, searches: 2, only, ..Stress::SHORT };
        assert!(effort.run().is_ok());
        let headings: Vec<_> = crate::process::sections().into_iter().map(|section| section.text).collect();
        let is_run = |search: &Search| headings.contains(&format!("Stress: {}", search.name));
        assert!(SEARCHES[..2].iter().all(is_run) && !is_run(&SEARCHES[2]), "{headings:?}");
    }

    /// Goals that nothing has tried are not met.
    #[test]
    fn search_without_a_run_is_refused() {
        let problem = |stress: Stress| stress.run().expect_err("a refusal").to_string();
        let misspelt = Stress { only: Some("Frictionbench".into()), ..Stress::SHORT };
        assert_eq!(problem(misspelt), "within a factor of 3: no run of 1 sets has a name with \"Frictionbench\"");
        let none = Stress { sets: 0, ..Stress::SHORT };
        assert_eq!(problem(none), "within a factor of 3: no run of 0 sets has a name with \"\"");
    }
}
