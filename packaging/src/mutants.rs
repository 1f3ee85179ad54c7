//! `cargo xtask mutants`: whether the tests notice when the source is wrong in one place.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use clap::{Args, ValueEnum};

use crate::files;
use crate::process::{self, heading};
use crate::workspace::Workspace;

/// Share of viable mutants that the tests must notice.
const GOAL: f64 = 0.95;
/// Of a normal distribution, what lies within so many standard deviations is 95 %.
const DEVIATIONS: f64 = 1.96;
/// What `cargo mutants` returns when it has come to its end: all caught, some missed, or some not ended in time.
const ENDED: [i32; 3] = [0, 2, 3];

/// Where a run leaves, in the folder of a shard, what it has tested once it has come to its end.
const TESTED: &str = "tested.txt";

/// Put mistakes into the source, one at a time, and count those that a test notices.
///
/// There are more than six thousand of these mutants in the plant and the instances of the FMU, and each costs a build and
/// tests: all of them take days, so a run takes a sample, one shard of many. Shards are spread evenly over the source;
/// together they are all mutants. `--all` tests one shard after the other and can be ended at any time: begun again at the
/// same commit, it goes on with the first shard that has not come to its end. What is changed, and which tests are run,
/// is set in .cargo/mutants.toml, .cargo/mutants-tools.toml and .config/nextest.toml.
#[derive(Args)]
#[command(after_help = "\
Examples:
  cargo xtask mutants                                    one mutant of 61, an hour or two
  cargo xtask mutants --shard 1 --shard 2                two other samples, counted together
  cargo xtask mutants --all                              all of them, over some nights
  cargo xtask mutants --in tools                         in packaging and the library of the page
  cargo xtask mutants --of 1 -- --file src/sensor.rs     all mutants of a file
It needs two tools: cargo install --locked cargo-mutants cargo-nextest")]
pub struct Mutants {
    /// Number of shards that all mutants are dealt out to.
    #[arg(long, default_value_t = 61)]
    of: u32,
    /// Which of them to run, counted from 0.
    #[arg(long, default_value = "0", conflicts_with = "all")]
    shard: Vec<u32>,
    /// Run all shards, but those that have come to their end before at this commit.
    #[arg(long)]
    all: bool,
    /// Where the mistakes are.
    #[arg(long = "in", value_enum, default_value_t = Part::Plant)]
    part: Part,
    /// What else `cargo mutants` is told: which files, which mutants.
    #[arg(last = true)]
    more: Vec<String>,
}

/// A part of the source that has tests of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Part {
    /// The plant and the instances of the FMU.
    Plant,
    /// What builds, describes and checks the FMUs, the library of the page, and what both write as SSV.
    Tools,
}

impl Part {
    /// Its name in paths.
    fn name(self) -> &'static str {
        match self {
            Self::Plant => "plant",
            Self::Tools => "tools",
        }
    }

    /// Its packages.
    fn packages(self) -> &'static [&'static str] {
        match self {
            Self::Plant => &["pneumatic-servo", "pneumatic-servo-fmu"],
            Self::Tools => &["pneumatic-servo-packaging", "pneumatic-servo-playground", "pneumatic-servo-ssp"],
        }
    }

    /// The settings for them.
    fn settings(self) -> &'static str {
        match self {
            Self::Plant => ".cargo/mutants.toml",
            Self::Tools => ".cargo/mutants-tools.toml",
        }
    }

    /// What tells cargo-mutants of both.
    fn arguments(self) -> Vec<&'static str> {
        let packages = self.packages().iter().flat_map(|package| ["--package", package]);
        packages.chain(["--config", self.settings()]).collect()
    }
}

impl Mutants {
    /// Runs the shards, and prints what became of the mutants. What happened to each is in target/mutation, by shard.
    ///
    /// # Errors
    /// When a tool is missing, the tests fail without any mutant, or too few mutants are caught.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        for tool in ["cargo-mutants", "cargo-nextest"] {
            ensure!(process::find(tool).is_some(), "{tool} is missing (cargo install --locked {tool})");
        }
        let shards = if self.all { (0..self.of).collect() } else { self.shard.clone() };
        let tested = if self.all { Some(self.tested(workspace)?) } else { None };
        let mut found = Outcomes::default();
        for shard in shards {
            heading(&format!("Mutants, shard {shard} of {}", self.of));
            let folder = workspace.target.join(format!("mutation/{}/{shard}-of-{}", self.part.name(), self.of));
            std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
            match &tested {
                Some(tested) if has_ended(&folder, tested) => println!("tested before"),
                _ => {
                    forget_end(&folder)?;
                    self.test(workspace, shard, &folder)?;
                    if let Some(tested) = &tested {
                        files::write(&folder.join(TESTED), tested)?;
                    }
                }
            }
            found.add(&folder.join("mutants.out"))?;
        }
        found.judge()
    }

    /// What tells whether a shard is that of another source, or of other mutants: the commit and the arguments.
    fn tested(&self, workspace: &Workspace) -> Result<String> {
        let git =
            |arguments: &[&str]| process::output(Command::new("git").args(arguments).current_dir(&workspace.root));
        let changes = git(&["status", "--porcelain", "--untracked-files=no"])?;
        ensure!(changes.is_empty(), "--all goes on at the same commit; commit these changes first:\n{changes}");
        Ok(format!("{}{}\n", git(&["rev-parse", "HEAD"])?, self.more.join(" ")))
    }

    fn test(&self, workspace: &Workspace, shard: u32, folder: &Path) -> Result<()> {
        let mut cargo = process::cargo();
        cargo.arg("mutants").args(self.part.arguments());
        cargo.args(["--caught", "--unviable", "--shard", &format!("{shard}/{}", self.of)]);
        cargo.arg("--output").arg(folder).args(&self.more).current_dir(&workspace.root);
        // Builds of mutants stay away from those of the source.
        cargo.env("CARGO_TARGET_DIR", workspace.target.join("mutation/build"));
        let status = process::status(&mut cargo)?;
        if !status.code().is_some_and(|code| ENDED.contains(&code)) {
            bail!("cargo mutants failed ({status})");
        }
        Ok(())
    }
}

/// Whether a shard has come to its end with what is tested now.
fn has_ended(folder: &Path, tested: &str) -> bool {
    std::fs::read_to_string(folder.join(TESTED)).is_ok_and(|text| text == tested)
}

/// Lets a shard count as not ended from now on.
fn forget_end(folder: &Path) -> Result<()> {
    let file = folder.join(TESTED);
    match std::fs::remove_file(&file) {
        Err(problem) if problem.kind() != std::io::ErrorKind::NotFound => {
            Err(problem).with_context(|| format!("cannot remove {}", file.display()))
        }
        _ => Ok(()),
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
            let text = files::text(&file)?;
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
    use crate::stand_in::{self, Answer, StandIn, Started};

    const SAMPLE: Mutants = Mutants { of: 3, shard: Vec::new(), all: false, part: Part::Plant, more: Vec::new() };

    /// What comes of it where each shard has so many mutants that are caught, late, missed, and do not compile, at a commit
    /// and with some changes; and how `cargo mutants` is called.
    fn sampled(
        folder: &Path,
        mutants: &Mutants,
        counts: [usize; 4],
        [commit, changes]: [&'static str; 2],
    ) -> (String, Vec<Started>) {
        let workspace = Workspace::of_a_test(folder);
        let machine = StandIn::new(move |command| {
            let line = command.line();
            if line.starts_with("git ") {
                return Some(Answer::Prints(if command.says("rev-parse") { commit } else { changes }.to_owned()));
            }
            for (name, count) in ["caught", "timeout", "missed", "unviable"].iter().zip(counts) {
                let list = Path::new(command.after("--output")).join(format!("mutants.out/{name}.txt"));
                stand_in::writes(list, "a mutant\n".repeat(count));
            }
            None
        });
        let (outcome, started) = machine.does(|| mutants.run(&workspace));
        let runs = started.into_iter().filter(|it| it.says("cargo mutants")).collect();
        (outcome.map_or_else(|problem| problem.to_string(), |()| String::new()), runs)
    }

    const CLEAN: [&str; 2] = ["0123\n", ""];

    /// Those that are not ended in time count as noticed, and those that do not compile not at all.
    #[test]
    fn shards_are_counted_together() -> Result<()> {
        let folder = files::scratch("mutants-sample");
        let two = Mutants { shard: vec![1, 2], more: vec!["--file".to_owned(), "a.rs".to_owned()], ..SAMPLE };
        let (problem, started) = sampled(&folder, &two, [15, 4, 1, 30], CLEAN);
        let [one, other] = &started[..] else { panic!("{started:?}") };
        assert!(problem.is_empty() && one.says("--shard 1/3") && other.says("--shard 2/3"), "{problem} {started:?}");
        assert!(one.says("--file a.rs") && one.says("--package pneumatic-servo-fmu --config .cargo/mutants.toml"));
        assert_eq!(Path::new(one.after("--output")), folder.join("mutation/plant/1-of-3"));
        assert_eq!(Path::new(one.variable("CARGO_TARGET_DIR")), folder.join("mutation/build"));
        let (problem, _) = sampled(&folder, &two, [15, 3, 1, 0], CLEAN);
        assert_eq!(problem, "fewer than 95 % of the mutants are noticed");
        assert_eq!(sampled(&folder, &two, [0, 0, 0, 9], CLEAN).0, "there is no viable mutant");
        let tools = Mutants { shard: vec![0], part: Part::Tools, ..SAMPLE };
        let (_, started) = sampled(&folder, &tools, [1, 0, 0, 0], CLEAN);
        assert!(started[0].after("--output").contains("mutation/tools/0-of-3"), "{started:?}");
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// At the same commit with the same arguments, what has come to its end is not tested again.
    #[test]
    fn all_shards_are_gone_through_once_for_a_commit() -> Result<()> {
        let folder = files::scratch("mutants-all");
        let all = Mutants { all: true, ..SAMPLE };
        let run = |mutants: &Mutants, place| sampled(&folder, mutants, [20, 0, 1, 0], place).1.len();
        assert_eq!([run(&all, CLEAN), run(&all, CLEAN), run(&all, ["4567\n", ""])], [3, 0, 3]);
        let other = Mutants { more: vec!["--file=a.rs".to_owned()], ..all };
        assert_eq!([run(&other, CLEAN), run(&other, CLEAN)], [3, 0]);
        let (problem, started) = sampled(&folder, &other, [20, 0, 1, 0], ["0123\n", " M a.rs\n"]);
        assert!(problem.ends_with("commit these changes first:\n M a.rs\n") && started.is_empty(), "{problem}");
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn mutants_are_not_counted_where_tools_are_missing_or_fail() -> Result<()> {
        let folder = files::scratch("mutants-failing");
        let workspace = Workspace::of_a_test(&folder);
        let one = Mutants { shard: vec![0], ..SAMPLE };
        for tool in ["cargo-mutants", "cargo-nextest"] {
            let (outcome, started) = StandIn::new(|_| None).lacking(tool).does(|| one.run(&workspace));
            assert!(outcome.is_err_and(|error| error.to_string().starts_with(tool)) && started.is_empty());
        }
        let failing = StandIn::new(|_| Some(Answer::Fails)).does(|| one.run(&workspace)).0;
        assert!(failing.is_err_and(|error| error.to_string().starts_with("cargo mutants failed (")));
        // A file that cannot be removed.
        std::fs::create_dir_all(folder.join("taken").join(TESTED))?;
        assert!(forget_end(&folder.join("taken")).is_err());
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn shard_has_ended_for_the_source_that_it_was_tested_with_until_it_is_begun_again() -> Result<()> {
        let folder = files::scratch("mutants");
        std::fs::create_dir_all(&folder)?;
        assert!(!has_ended(&folder, "one commit"));
        forget_end(&folder)?;
        files::write(&folder.join(TESTED), "one commit")?;
        assert!(has_ended(&folder, "one commit") && !has_ended(&folder, "another commit"));
        forget_end(&folder)?;
        assert!(!has_ended(&folder, "one commit"));
        Ok(std::fs::remove_dir(&folder)?)
    }

    /// The settings are those of files that are there, and the packages those of the workspace.
    #[test]
    fn parts_name_packages_and_settings_of_the_repository() -> Result<()> {
        let workspace = Workspace::of_the_project()?;
        let metadata = cargo_metadata::MetadataCommand::new().no_deps().current_dir(&workspace.root).exec()?;
        for part in Part::value_variants() {
            for name in part.packages() {
                assert!(metadata.packages.iter().any(|package| package.name.as_str() == *name), "{name}");
            }
            assert!(workspace.root.join(part.settings()).is_file(), "{}", part.settings());
        }
        Ok(())
    }

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
