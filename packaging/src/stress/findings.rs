//! What a search finds: how runs went, and why some were discarded.

use std::collections::BTreeMap;
use std::fmt;

use pneumatic_servo::solver::{Rejection, StepError};

/// What a search found.
#[derive(Default)]
pub struct Findings {
    /// How many runs there were.
    pub runs: u32,
    /// How many of them had an error.
    pub discarded: u32,
    /// Runs whose equations have no bounded solution.
    pub unstable: u32,
    /// The largest number of solver steps in one communication step of a run that was not discarded, and where.
    pub costliest: (u64, String),
    /// The largest mean number of solver steps in a communication step of such a run, and where.
    pub slowest: (f64, String),
    /// Number of discarded runs by law and cause, and the first of them.
    pub causes: BTreeMap<(String, String), (u32, String)>,
}

impl Findings {
    /// The share of runs that were discarded.
    pub fn share_discarded(&self) -> f64 {
        f64::from(self.discarded) / f64::from(self.runs.max(1))
    }

    /// Counts a run.
    pub fn note(&mut self, law: &str, place: &str, outcome: &Outcome) {
        self.runs += 1;
        if is_unstable(law, outcome) {
            self.unstable += 1;
            return;
        }
        if let Some(error) = outcome.error {
            self.discarded += 1;
            let first = || (0, format!("{place}: {error}"));
            self.causes.entry((law.to_owned(), cause(&error))).or_insert_with(first).0 += 1;
            return;
        }
        if outcome.most > self.costliest.0 {
            self.costliest = (outcome.most, place.to_owned());
        }
        if outcome.mean() > self.slowest.0 {
            self.slowest = (outcome.mean(), place.to_owned());
        }
    }
}

impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} unstable under the sampled law DNLRX", self.unstable)?;
        writeln!(f, "{} runs, {} discarded", self.runs, self.discarded)?;
        writeln!(f, "most solver steps in a communication step: {} ({})", self.costliest.0, self.costliest.1)?;
        write!(f, "most solver steps in the mean of a run: {:.1} ({})", self.slowest.0, self.slowest.1)?;
        for ((law, cause), (count, first)) in &self.causes {
            write!(f, "\n{count:5}  {law:20} {cause}\n{:28}first: {first}", "")?;
        }
        Ok(())
    }
}

/// An error without its time and without the figures of a state.
fn cause(error: &StepError) -> String {
    let text = error.to_string();
    let cause = text.split_once(" s ").map_or(&*text, |(_, rest)| rest);
    cause.split_once(", from ").map_or(cause, |(cause, _)| cause).to_owned()
}

/// Whether a run ended because a mass under a sampled law gained speed without bound. That is the solution: the law is a
/// regression, whose coefficients, drawn one by one, may push where they should brake.
fn is_unstable(law: &str, outcome: &Outcome) -> bool {
    let unbounded = |error| matches!(error, StepError::StepSizeTooSmall { reason: Rejection::Unbounded { .. }, .. });
    law == "DNLRX" && outcome.error.is_some_and(unbounded)
}

/// How a run went.
#[derive(Default)]
pub struct Outcome {
    /// Communication steps begun.
    pub steps: u64,
    /// Solver steps.
    pub work: u64,
    /// The most of them in one communication step.
    pub most: u64,
    /// Why it ended early.
    pub error: Option<StepError>,
}

impl Outcome {
    /// The mean number of solver steps in a communication step.
    pub fn mean(&self) -> f64 {
        self.work as f64 / self.steps.max(1) as f64
    }
}

#[cfg(test)]
pub mod tests {
    use pneumatic_servo::solver::Course;

    use super::*;

    /// A run of four communication steps.
    pub fn ended(work: u64, most: u64) -> Outcome {
        Outcome { steps: 4, work, most, error: None }
    }

    /// One that was discarded at a time in s.
    pub fn failed(time: f64) -> Outcome {
        Outcome { error: Some(StepError::TooManySteps { time, limit: 7 }), ..ended(9000, 9000) }
    }

    /// The same error at another time is the same cause; its place and time are those of the first.
    #[test]
    fn discarded_runs_are_counted_by_law_and_cause() {
        let mut findings = Findings::default();
        for (law, time) in [("LuGre", 0.5), ("LuGre", 0.75), ("Dahl", 0.5)] {
            findings.note(law, &format!("at {time}"), &failed(time));
        }
        let [((dahl, _), (1, _)), ((lugre, cause), (2, first))] = &findings.causes.iter().collect::<Vec<_>>()[..]
        else {
            panic!("{:?}", findings.causes)
        };
        assert_eq!((dahl.as_str(), lugre.as_str()), ("Dahl", "LuGre"));
        assert!(first.starts_with("at 0.5: ") && first.contains("0.5 s"), "{first}");
        assert!(cause.contains('7') && !cause.contains("0.5") && first.ends_with(cause.as_str()), "{cause}");
    }

    /// Gaining speed without bound is the solution of the sampled law alone, and no other error is.
    #[test]
    fn runs_that_gain_speed_without_bound_under_the_sampled_law_are_no_discarded_ones() {
        let course = Course { state: "velocity", value: 1e9, rate: 1e9 };
        let reason = Rejection::Unbounded { course, limit: 1e9 };
        let unbounded = StepError::StepSizeTooSmall { time: 0.5, reason, variant: "DNLRX" };
        let mut findings = Findings::default();
        findings.note("DNLRX", "a", &Outcome { error: Some(unbounded), ..ended(9000, 9000) });
        findings.note("DNLRX", "b", &Outcome { error: Some(unbounded), ..ended(9000, 9000) });
        assert_eq!((findings.runs, findings.unstable, findings.discarded), (2, 2, 0));
        findings.note("LuGre", "c", &Outcome { error: Some(unbounded), ..ended(9000, 9000) });
        findings.note("DNLRX", "d", &failed(0.5));
        findings.note("DNLRX", "e", &ended(8, 4));
        assert_eq!((findings.runs, findings.unstable, findings.discarded), (5, 2, 2));
        assert_eq!((findings.costliest.0, findings.slowest.0), (4, 2.0), "what is unstable costs nothing");
    }

    #[test]
    fn findings_are_told_with_the_first_run_of_each_cause() {
        let mut findings = Findings { unstable: 3, ..Findings::default() };
        findings.note("Dahl", "Bench Dahl 0", &ended(10, 7));
        for time in [0.5, 0.75] {
            findings.note("LuGre", "Bench LuGre 1", &failed(time));
        }
        let text = findings.to_string();
        let lines: Vec<&str> = text.lines().collect();
        let head = [
            "3 unstable under the sampled law DNLRX",
            "3 runs, 2 discarded",
            "most solver steps in a communication step: 7 (Bench Dahl 0)",
            "most solver steps in the mean of a run: 2.5 (Bench Dahl 0)",
        ];
        assert_eq!(lines[..4], head);
        assert!(lines[4].starts_with("    2  LuGre                "), "{text}");
        assert!(lines[5].starts_with("                            first: Bench LuGre 1: "), "{text}");
        assert_eq!(lines.len(), 6);
    }
}
