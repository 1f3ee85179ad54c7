//! `cargo xtask bounds`: how much room the bounds of the tests leave.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;

use crate::files;
use crate::process;
use crate::workspace::Workspace;

/// Number of bounds that a report lists.
pub const SHOWN: usize = 10;

/// Run the tests of plant and C interface, and list the bounds of which they use the least.
///
/// A bound is at most ten times what is observed, or says why it is wider. Bounds held by the helpers of `tests/bounds`
/// are known to the report.
#[derive(Args)]
#[command(after_help = "\
Examples:
  cargo xtask bounds                          run the tests, list the ten slackest bounds
  cargo xtask bounds --recorded --shown 50    list more of what the last tests recorded")]
pub struct Bounds {
    /// Number of bounds to list.
    #[arg(long, default_value_t = SHOWN)]
    shown: usize,
    /// Run no tests: list what those recorded that were run last, and before.
    #[arg(long)]
    recorded: bool,
}

impl Bounds {
    /// Runs the tests and prints the report.
    ///
    /// # Errors
    /// When a test fails, or nothing is recorded.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        if self.recorded {
            return report(workspace, self.shown).map(drop);
        }
        forget(workspace)?;
        let target = &workspace.target;
        process::run(process::cargo().arg("test").current_dir(&workspace.root).env("CARGO_TARGET_DIR", target))?;
        check(workspace, self.shown)
    }
}

/// The place in the sources of a bound.
type Place = (String, u32);

/// The largest share of a bound that was used.
#[derive(Clone, Debug, PartialEq)]
struct Use {
    test: String,
    observed: f64,
    bound: f64,
    /// Why it is wide, if somebody says so.
    reason: String,
}

impl Use {
    fn share(&self) -> f64 {
        self.observed / self.bound
    }

    /// Whether the bound is more than ten times what is observed, but for the rounding of a bound to one digit, without a reason.
    fn is_slack(&self) -> bool {
        self.reason.is_empty() && 11.0 * self.observed < self.bound
    }
}

/// Where the tests record what they use of their bounds.
fn folder(workspace: &Workspace) -> PathBuf {
    workspace.target.join("tmp/bounds")
}

/// Removes what earlier tests recorded.
///
/// # Errors
/// When the folder cannot be removed.
pub fn forget(workspace: &Workspace) -> Result<()> {
    let folder = folder(workspace);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).with_context(|| format!("cannot remove {}", folder.display()))?;
    }
    Ok(())
}

/// Prints the slackest bounds, after all tests have run.
///
/// # Errors
/// As [`report`], and when a bound is more than ten times what is observed, without a reason.
pub fn check(workspace: &Workspace, shown: usize) -> Result<()> {
    let uses = report(workspace, shown)?;
    let slack = uses.values().filter(|used| used.is_slack()).count();
    ensure!(slack == 0, "{slack} bounds are far wider than what is observed: narrow them, or say why they are wide");
    Ok(())
}

/// Prints the slackest bounds of the tests that have run.
///
/// # Errors
/// When nothing is recorded, or a record cannot be read.
fn report(workspace: &Workspace, shown: usize) -> Result<BTreeMap<Place, Use>> {
    let folder = folder(workspace);
    let mut uses = BTreeMap::new();
    if folder.exists() {
        for file in std::fs::read_dir(&folder).with_context(|| format!("cannot list {}", folder.display()))? {
            let file = file?.path();
            let text = files::text(&file)?;
            read(&text, &mut uses).with_context(|| format!("in {}", file.display()))?;
        }
    }
    ensure!(!uses.is_empty(), "{}: no bounds are recorded there; run the tests first", folder.display());
    println!("{}", text(&uses, shown));
    Ok(uses)
}

/// Takes the lines of a record.
fn read(text: &str, uses: &mut BTreeMap<Place, Use>) -> Result<()> {
    for line in text.lines() {
        let cells: Vec<&str> = line.splitn(6, ';').collect();
        let [file, place, test, observed, bound, reason] = cells[..] else {
            anyhow::bail!("`{line}` is no line of a record");
        };
        let used = Use {
            test: test.to_owned(),
            observed: observed.parse().with_context(|| format!("`{observed}` in `{line}`"))?,
            bound: bound.parse().with_context(|| format!("`{bound}` in `{line}`"))?,
            reason: reason.to_owned(),
        };
        let place = (file.to_owned(), place.parse().with_context(|| format!("`{place}` in `{line}`"))?);
        let most = uses.entry(place).or_insert_with(|| used.clone());
        if used.share() > most.share() {
            *most = used;
        }
    }
    Ok(())
}

/// The report.
fn text(uses: &BTreeMap<Place, Use>, shown: usize) -> String {
    let mut slack: Vec<(&Place, &Use)> = uses.iter().filter(|(_, used)| used.reason.is_empty()).collect();
    let mut lines = vec![format!(
        "{} bounds, {} of them wide for a stated reason; the slackest of the others:",
        uses.len(),
        uses.len() - slack.len(),
    )];
    slack.sort_by(|(_, one), (_, other)| one.share().total_cmp(&other.share()));
    lines.extend(slack.into_iter().take(shown).map(|((file, line), used)| {
        let Use { test, observed, bound, .. } = used;
        format!("{:8.3} times: {file}:{line}, {test}: observed {observed:.1e}, bound {bound:.1e}", 1.0 / used.share())
    }));
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::stand_in::{self, StandIn};

    const RECORD: &str = "\
tests/a.rs;7;tight;1e-9;1e-6;
tests/a.rs;7;tight;2e-7;1e-6;
tests/a.rs;7;other;1e-7;1e-6;
tests/a.rs;9;loose;1e-9;1e0;rounding; of another machine
tests/b.rs;1;unused;0e0;1e-3;
";

    /// The largest share at each place counts; the slackest comes first, and a reason takes a bound off the list.
    #[test]
    fn slackest_bounds_are_listed_first() {
        let mut uses = BTreeMap::new();
        read(RECORD, &mut uses).unwrap();
        let expected = "\
3 bounds, 1 of them wide for a stated reason; the slackest of the others:
     inf times: tests/b.rs:1, unused: observed 0.0e0, bound 1.0e-3
   5.000 times: tests/a.rs:7, tight: observed 2.0e-7, bound 1.0e-6";
        assert_eq!(text(&uses, 10), expected);
        assert_eq!(text(&uses, 1).lines().count(), 2);
    }

    /// Of equal uses the first is named.
    #[test]
    fn first_of_equal_uses_is_named() {
        let mut uses = BTreeMap::new();
        read("tests/a.rs;7;one;1e-7;1e-6;\ntests/a.rs;7;other;1e-7;1e-6;\n", &mut uses).unwrap();
        assert!(uses.values().all(|used| used.test == "one"), "{uses:?}");
    }

    /// What was recorded before is forgotten, all tests are run, and slack bounds are an error; `--recorded` runs and judges
    /// nothing.
    #[test]
    fn tests_are_run_and_what_they_record_is_judged() -> Result<()> {
        let target = files::scratch("bounds");
        let workspace = Workspace::of_a_test(&target);
        let folder = folder(&workspace);
        let run = |recorded: bool, lines: &'static str| {
            let folder = folder.clone();
            let machine = StandIn::new(move |_| Some(stand_in::writes(folder.join("new"), lines)));
            machine.does(|| Bounds { shown: 1, recorded }.run(&workspace))
        };
        files::write(&folder.join("old"), RECORD)?;
        let (outcome, started) = run(true, "");
        assert!(outcome.is_ok() && started.is_empty(), "{started:?}");
        let (outcome, started) = run(false, "tests/b.rs;1;tight;1e-4;1e-3;\n");
        outcome?;
        let [cargo] = &started[..] else { panic!("{started:?}") };
        assert_eq!((&*cargo.line(), cargo.folder.as_ref()), ("cargo test", Some(&workspace.root)));
        assert_eq!(Path::new(cargo.variable("CARGO_TARGET_DIR")), target);
        assert!(!folder.join("old").exists() && folder.join("new").exists());
        assert!(run(false, "tests/b.rs;1;loose;1e-6;1e-3;\n").0.is_err());
        let fails = StandIn::new(|_| Some(stand_in::Answer::Fails));
        assert!(fails.does(|| Bounds { shown: 1, recorded: false }.run(&workspace)).0.is_err());
        Ok(std::fs::remove_dir_all(&target)?)
    }

    /// A bound of ten times what is observed is not slack, one of twelve times is, and one with a reason never.
    #[test]
    fn bounds_beyond_ten_times_are_slack() {
        let used = |bound: f64, reason: &str| Use { test: "t".into(), observed: 1e-9, bound, reason: reason.into() };
        assert!(!used(1e-8, "").is_slack());
        assert!(used(1.2e-8, "").is_slack());
        let whole = |bound| Use { observed: 1.0, ..used(bound, "") };
        assert!(!whole(11.0).is_slack() && whole(11.5).is_slack());
        assert!(!used(1.0, "rounding of another machine").is_slack());
        assert!(Use { observed: 0.0, ..used(1e-300, "") }.is_slack());
    }

    #[test]
    fn line_that_is_no_record_is_refused() {
        for line in ["tests/a.rs;7;tight;1e-9", "tests/a.rs;7;tight;much;1e-6;", "tests/a.rs;x;tight;1e-9;1e-6;"] {
            let error = read(line, &mut BTreeMap::new()).unwrap_err();
            assert!(format!("{error:#}").contains(line), "{error:#}");
        }
    }

    /// What the tests of a target directory recorded there is read, and forgotten there alone.
    #[test]
    fn records_are_those_of_the_target_directory() -> Result<()> {
        let workspace = Workspace::of_the_project()?;
        let [one, other] =
            ["one", "other"].map(|name| workspace.inside(&format!("tmp/records-{}-{name}", std::process::id())));
        for (of, text) in [(&one, RECORD), (&other, "tests/b.rs;1;unused;1e-4;1e-3;\n")] {
            files::write(&of.target.join("tmp/bounds/record"), text)?;
        }
        assert_eq!((report(&one, 1)?.len(), report(&other, 1)?.len()), (3, 1));
        assert!(
            check(&one, 1).is_err() && check(&other, 1).is_ok(),
            "an unused bound is slack, one of ten times is not"
        );
        forget(&one)?;
        assert!(report(&one, 1).is_err() && report(&other, 1).is_ok());
        for of in [one, other] {
            std::fs::remove_dir_all(of.target)?;
        }
        Ok(())
    }
}
