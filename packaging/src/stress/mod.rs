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

use anyhow::{Result, bail};
use clap::Args;

use self::search::SEARCHES;
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
    /// When a goal is missed.
    pub fn run(&self) -> Result<()> {
        let mut missed = Vec::new();
        for search in SEARCHES.iter().take(self.searches) {
            heading(&format!("Stress: {}", search.name));
            let findings = search.run(self)?;
            println!("{findings}");
            missed.extend(search.missed(&findings));
        }
        if !missed.is_empty() {
            bail!("{}", missed.join("\n"));
        }
        Ok(())
    }
}
