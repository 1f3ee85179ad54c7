//! `cargo xtask mutants`: whether the tests notice when the source is wrong in one place.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use clap::Args;

use crate::process::{self, heading};
use crate::workspace::Workspace;

/// Share of viable mutants that the tests must notice.
const GOAL: f64 = 0.95;
/// Of a normal distribution, what lies within so many standard deviations is 95 %.
const DEVIATIONS: f64 = 1.96;
/// What `cargo mutants` returns when it has come to its end: all caught, some missed, or some not ended in time.
const ENDED: [i32; 3] = [0, 2, 3];

/// Put mistakes into the plant and the instances of the FMU, one at a time, and count those that a test notices.
///
/// There are more than six thousand of these mutants, and each costs a build and tests: all of them take days, so a run
/// takes a sample, one shard of many. Shards are spread evenly over the source; together they are all mutants. What is
/// changed, and which tests are run, is set in .cargo/mutants.toml and .config/nextest.toml.
#[derive(Args)]
#[command(after_help = "\
Examples:
  cargo xtask mutants                                    one mutant of 61, an hour or two
  cargo xtask mutants --shard 1 --shard 2                two other samples, counted together
  cargo xtask mutants --of 1 -- --file src/sensor.rs     all mutants of a file
It needs two tools: cargo install --locked cargo-mutants cargo-nextest")]
pub struct Mutants {
    /// Number of shards that all mutants are dealt out to.
    #[arg(long, default_value_t = 61)]
    of: u32,
    /// Which of them to run, counted from 0.
    #[arg(long, default_value = "0")]
    shard: Vec<u32>,
    /// What else `cargo mutants` is told: which files, which mutants.
    #[arg(last = true)]
    more: Vec<String>,
}

impl Mutants {
    /// Runs the shards, and prints what became of the mutants. What happened to each is in target/mutation, by shard.
    ///
    /// # Errors
    /// When a tool is missing, the tests fail without any mutant, or too few mutants are caught.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        for tool in ["cargo-mutants", "cargo-nextest"] {
            ensure!(which::which(tool).is_ok(), "{tool} is missing (cargo install --locked {tool})");
        }
        let mut found = Outcomes::default();
        for shard in &self.shard {
            heading(&format!("Mutants, shard {shard} of {}", self.of));
            let folder = workspace.target.join(format!("mutation/{shard}-of-{}", self.of));
            std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
            self.test(workspace, *shard, &folder)?;
            found.add(&folder.join("mutants.out"))?;
        }
        found.judge()
    }

    fn test(&self, workspace: &Workspace, shard: u32, folder: &Path) -> Result<()> {
        let mut cargo = process::cargo();
        cargo.args(["mutants", "--package", "pneumatic-servo", "--package", "pneumatic-servo-fmu"]);
        cargo.args(["--caught", "--unviable", "--shard", &format!("{shard}/{}", self.of)]);
        cargo.arg("--output").arg(folder).args(&self.more).current_dir(&workspace.root);
        // Builds of mutants stay away from those of the source.
        cargo.env("CARGO_TARGET_DIR", workspace.target.join("mutation/build"));
        let status = cargo.status().context("cannot start cargo mutants")?;
        if !status.code().is_some_and(|code| ENDED.contains(&code)) {
            bail!("cargo mutants failed ({status})");
        }
        Ok(())
    }
}

/// What became of mutants.
#[derive(Default)]
struct Outcomes {
    caught: usize,
    /// Those whose tests do not end: someone would notice.
    timeout: usize,
    missed: Vec<String>,
    /// Those that do not compile.
    unviable: usize,
}

impl Outcomes {
    /// Adds what a run has left in a folder: a list of names for each outcome.
    fn add(&mut self, folder: &Path) -> Result<()> {
        let read = |name: &str| {
            let file = folder.join(name);
            let text = std::fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
            Ok::<_, anyhow::Error>(text.lines().map(str::to_owned).collect::<Vec<_>>())
        };
        self.caught += read("caught.txt")?.len();
        self.timeout += read("timeout.txt")?.len();
        self.missed.extend(read("missed.txt")?);
        self.unviable += read("unviable.txt")?.len();
        Ok(())
    }

    fn judge(&self) -> Result<()> {
        let noticed = self.caught + self.timeout;
        let viable = noticed + self.missed.len();
        ensure!(viable > 0, "there is no viable mutant");
        heading("Mutants that no test noticed");
        self.missed.iter().for_each(|name| println!("{name}"));
        let share = noticed as f64 / viable as f64;
        let (least, most) = confidence(noticed, viable);
        println!(
            "\n{} caught, {} not ended in time, {} missed, {} did not compile: {:.1} % of {viable} viable ones noticed \
             (95 % confidence: {:.1} to {:.1} % of all)",
            self.caught,
            self.timeout,
            self.missed.len(),
            self.unviable,
            100.0 * share,
            100.0 * least,
            100.0 * most
        );
        ensure!(share >= GOAL, "fewer than {:.0} % of the mutants are noticed", 100.0 * GOAL);
        Ok(())
    }
}

/// Between what the share of a whole lies with 95 % confidence, when `count` of a sample of `size` have a property.
///
/// # Source
/// Wilson (1927): Probable inference, the law of succession, and statistical inference. Journal of the American
/// Statistical Association 22(158), 209-212.
fn confidence(count: usize, size: usize) -> (f64, f64) {
    let (size, square) = (size as f64, DEVIATIONS * DEVIATIONS);
    let share = count as f64 / size;
    let centre = share + square / (2.0 * size);
    let half = DEVIATIONS * libm::sqrt(share * (1.0 - share) / size + square / (4.0 * size * size));
    let scale = 1.0 + square / size;
    ((centre - half) / scale, (centre + half) / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn confidence_is_the_published_one() {
        // Newcombe (1998): Two-sided confidence intervals for the single proportion: comparison of seven methods.
        // Statistics in Medicine 17, 857-872, table I, method 3, to four digits.
        let published =
            [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)];
        for (count, size, least, most) in published {
            let (low, high) = confidence(count, size);
            assert!((low - least).abs() < 6e-5 && (high - most).abs() < 6e-5, "{count} of {size}: {low} to {high}");
        }
    }
}
