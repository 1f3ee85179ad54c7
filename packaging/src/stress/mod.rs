//! `cargo xtask stress`: whether every model runs under every law with any legal parameters, in bounded time.
//!
//! A seeded search: the same seed draws the same sets.

mod draw;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use clap::Args;
use pneumatic_servo::co_simulation::Plant;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models;
use pneumatic_servo::solver::{Rejection, StepError};
use pneumatic_servo::variables::{Kind, Variable};

use self::draw::{Random, Spread, Swing};
use crate::process::heading;

/// Communication step in s.
const STEP: f64 = 1e-3;
/// Time between two signs of life.
const SIGN_OF_LIFE: Duration = Duration::from_secs(4);
/// Repetitions of a run with a slow step.
const MOST_REPETITIONS: usize = 3;

/// What is searched, and what must come out.
struct Search {
    name: &'static str,
    spread: Spread,
    /// Clock at the start in s.
    start: f64,
    /// Largest share of discarded runs.
    discarded: f64,
    /// Longest time a step may take.
    longest: Duration,
}

/// The searches. Times leave room for a busy machine; an optimised program is far below them.
const SEARCHES: [Search; 5] = [
    Search { name: "within a factor of 3", spread: Spread::Factor(3.0), start: 0.0, discarded: 0.0, longest: FIRM },
    Search {
        name: "within a factor of 3, at 1.7e9 s",
        spread: Spread::Factor(3.0),
        start: 1.7e9,
        discarded: 0.0,
        longest: FIRM,
    },
    Search { name: "within a factor of 30", spread: Spread::Factor(30.0), start: 0.0, discarded: 0.01, longest: LOOSE },
    Search { name: "whole legal range", spread: Spread::Legal, start: 0.0, discarded: 1.0, longest: LOOSE },
    Search {
        name: "whole legal range, at 1.7e9 s",
        spread: Spread::Legal,
        start: 1.7e9,
        discarded: 1.0,
        longest: LOOSE,
    },
];
const FIRM: Duration = Duration::from_millis(50);
const LOOSE: Duration = Duration::from_millis(500);

/// Search for legal parameters that a model cannot run with, or not in bounded time.
///
/// Seeded and repeatable: every model under every law, within factors of 3 and 30 of the defaults and in the whole legal
/// range, from time 0 and from 1.7e9 s. The time of steps is judged by an optimised program only: `cargo run --release
/// --package pneumatic-servo-packaging -- stress`.
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
    pub const SHORT: Self = Self { sets: 1, seconds: 0.1, seed: 1, searches: 3, only: None };

    /// Searches, and prints a table by law and cause.
    ///
    /// # Errors
    /// When a goal is missed.
    pub fn run(&self) -> Result<()> {
        let mut missed = Vec::new();
        for search in SEARCHES.iter().take(self.searches) {
            heading(&format!("Stress: {}", search.name));
            let findings = search.run(self)?;
            findings.print();
            if findings.share_discarded() > search.discarded {
                missed.push(format!("{}: {} of {} runs discarded", search.name, findings.discarded, findings.runs));
            }
            if !cfg!(debug_assertions) && findings.slowest.0 > search.longest {
                missed.push(format!("{}: a step took {:?}", search.name, findings.slowest.0));
            }
        }
        if !missed.is_empty() {
            bail!("{}", missed.join("\n"));
        }
        Ok(())
    }
}

/// What a search found.
#[derive(Default)]
struct Findings {
    runs: u32,
    discarded: u32,
    /// Runs whose equations have no bounded solution.
    unstable: u32,
    /// The longest step, and where.
    slowest: (Duration, String),
    /// Number of discarded runs by law and cause, and the first of them.
    causes: BTreeMap<(String, String), (u32, String)>,
}

impl Findings {
    fn share_discarded(&self) -> f64 {
        f64::from(self.discarded) / f64::from(self.runs.max(1))
    }

    fn print(&self) {
        println!("{} unstable under the sampled law DNLRX", self.unstable);
        println!(
            "{} runs, {} discarded; longest step {:?} ({})",
            self.runs, self.discarded, self.slowest.0, self.slowest.1
        );
        for ((law, cause), (count, first)) in &self.causes {
            println!("{count:5}  {law:20} {cause}\n{:28}first: {first}", "");
        }
    }

    fn note(&mut self, law: &str, place: &str, outcome: &Outcome) {
        self.runs += 1;
        if is_unstable(law, outcome) {
            self.unstable += 1;
            return;
        }
        if outcome.slowest() > self.slowest.0 {
            self.slowest = (outcome.slowest(), place.to_owned());
        }
        if let Some(error) = outcome.error {
            self.discarded += 1;
            let first = || (0, format!("{place}: {error}"));
            self.causes.entry((law.to_owned(), cause(&error))).or_insert_with(first).0 += 1;
        }
    }
}

/// An error without its time and without the figures of a state.
fn cause(error: &StepError) -> String {
    let text = error.to_string();
    let cause = text.split_once(" s ").map_or(&*text, |(_, rest)| rest);
    cause.split_once(", from ").map_or(cause, |(cause, _)| cause).to_owned()
}

/// The parameters of a set that are not at their defaults.
fn changes(setup: &Setup) -> Result<String> {
    let defaults = Setup::of(setup.model());
    let mut changed = Vec::new();
    for Variable { name, .. } in setup.table().parameters() {
        let (value, default) = (setup.get(name)?, defaults.get(name)?);
        if value != default {
            changed.push(format!("{name}={value}"));
        }
    }
    Ok(changed.join(" "))
}

/// Whether a run ended because a mass under a sampled law gained speed without bound. That is the solution: the law is a
/// regression, whose coefficients, drawn one by one, may push where they should brake.
fn is_unstable(law: &str, outcome: &Outcome) -> bool {
    let unbounded = |error| matches!(error, StepError::StepSizeTooSmall { reason: Rejection::Unbounded { .. }, .. });
    law == "DNLRX" && outcome.error.is_some_and(unbounded)
}

/// How a run went.
struct Outcome {
    /// How long each step took.
    times: Vec<Duration>,
    error: Option<StepError>,
}

impl Outcome {
    fn slowest(&self) -> Duration {
        self.times.iter().copied().max().unwrap_or_default()
    }

    /// Takes the times of the same steps in a repetition where they are shorter.
    fn keep_faster(&mut self, again: &Self) {
        for (time, repeated) in self.times.iter_mut().zip(&again.times) {
            *time = (*time).min(*repeated);
        }
    }
}

impl Search {
    fn run(&self, effort: &Stress) -> Result<Findings> {
        let mut findings = Findings::default();
        let mut last_sign = Instant::now();
        for model in models::ALL {
            let laws = (model.variables)().iter().find(|variable| variable.name == "friction.law");
            let Some(Kind::Enumeration(laws)) = laws.map(|variable| variable.kind) else { continue };
            for (law, name, _) in laws.items {
                for set in 0..effort.sets {
                    let place = format!("{} {name} {set}", model.name);
                    if effort.only.as_ref().is_some_and(|only| !place.contains(only)) {
                        continue;
                    }
                    let mut random = Random(effort.seed ^ (u64::from(set) << 32) ^ (law.unsigned_abs() as u64) << 16);
                    let setup = draw::setup(model, *law, self.spread, self.start, &mut random)?;
                    if effort.only.is_some() {
                        println!("{place}: {}", changes(&setup)?);
                    }
                    let swing = Swing::new(&setup, &mut random);
                    let mut outcome = self.simulate(&swing, &mut setup.start(self.start)?, effort.seconds);
                    // Runs repeat bit for bit: what is slow once only was held up by another program.
                    for _ in 0..MOST_REPETITIONS {
                        if outcome.slowest() <= self.longest {
                            break;
                        }
                        let again = self.simulate(&swing, &mut setup.start(self.start)?, effort.seconds);
                        outcome.keep_faster(&again);
                    }
                    findings.note(name, &place, &outcome);
                    if last_sign.elapsed() > SIGN_OF_LIFE {
                        eprintln!("  {place}: {} runs, {} discarded", findings.runs, findings.discarded);
                        last_sign = Instant::now();
                    }
                }
            }
        }
        Ok(findings)
    }

    fn simulate(&self, swing: &Swing, plant: &mut Plant, seconds: f64) -> Outcome {
        let mut times = Vec::new();
        for step in 0..(seconds / STEP).round() as u32 {
            for (place, value) in swing.at(f64::from(step) * STEP) {
                plant.set_input(place, value);
            }
            let clock = Instant::now();
            let outcome = plant.advance_to(self.start + f64::from(step + 1) * STEP);
            times.push(clock.elapsed());
            if let Err(error) = outcome {
                return Outcome { times, error: Some(error) };
            }
        }
        Outcome { times, error: None }
    }
}
