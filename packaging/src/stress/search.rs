//! A search: random runs of every model under every law, and what must come out.

use std::time::{Duration, Instant};

use anyhow::Result;
use pneumatic_servo::model::{Model, Plant, Setup};
use pneumatic_servo::models;
use pneumatic_servo::variables::Variable;

use super::Stress;
use super::draw::{self, Random, Spread, Swing};
use super::findings::{Findings, Outcome};

/// Communication step in s.
const STEP: f64 = 1e-3;
/// Time between two signs of life.
const SIGN_OF_LIFE: Duration = Duration::from_secs(4);

/// What is searched, and what must come out.
pub struct Search {
    /// What it is called.
    pub name: &'static str,
    /// How far parameters are from their defaults.
    pub spread: Spread,
    /// Clock at the start in s.
    pub start: f64,
    /// Whether inputs keep the values of the start.
    pub held: bool,
    /// Largest share of discarded runs.
    pub discarded: f64,
    /// Most solver steps within a communication step, rejected ones included.
    pub most: u64,
    /// Most solver steps within a communication step in the mean over a run.
    pub mean: f64,
}

/// Searches found up to 280 and 47 solver steps; three to five times that is left for other sets.
const NEAR: Search = Search {
    name: "within a factor of 3",
    spread: Spread::Factor(3.0),
    start: 0.0,
    held: false,
    discarded: 0.0,
    most: 1_500,
    mean: 150.0,
};
/// 503 and 191.
const FAR: Search = Search {
    name: "within a factor of 30",
    spread: Spread::Factor(30.0),
    discarded: 0.01,
    most: 2_500,
    mean: 700.0,
    ..NEAR
};
/// FrictionBench runs with anything, DrivenSlider with five sets of six, Festoon with half, and VibroImpact with hardly any: its
/// masses and springs may be twelve decades apart. A step that takes more than 5,000 solver steps is discarded.
const LEGAL: Search =
    Search { name: "whole legal range", spread: Spread::Legal, discarded: 0.5, most: 4_500, mean: 3_000.0, ..NEAR };

/// The searches.
pub const SEARCHES: [Search; 7] = [
    NEAR,
    Search { name: "within a factor of 3, constant inputs", held: true, ..NEAR },
    Search { name: "within a factor of 3, at 1.7e9 s", start: 1.7e9, ..NEAR },
    FAR,
    Search { name: "within a factor of 30, constant inputs", held: true, ..FAR },
    LEGAL,
    Search { name: "whole legal range, at 1.7e9 s", start: 1.7e9, ..LEGAL },
];

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

/// Solver steps of a run so far, rejected ones included; 0 for the controller, which has none.
fn work(plant: &mut Plant) -> u64 {
    let counts = ["solver.steps", "solver.rejectedSteps"].map(|name| plant.get(name).unwrap_or_default());
    counts.iter().sum::<f64>() as u64
}

/// The laws of a model, by number and name; one without a number stands for those of a model that has none.
fn laws(model: &Model) -> Vec<(Option<i32>, &'static str)> {
    match (model.variables)().friction_law() {
        Some((_, laws)) => laws.items.iter().map(|(law, name, _)| (Some(*law), *name)).collect(),
        None => vec![(None, "without a law")],
    }
}

/// Signs of life.
struct Signs {
    /// When there was one.
    last: Instant,
}

impl Signs {
    /// Whether there is to be one now, so long after the last.
    fn are_due(&mut self, now: Instant) -> bool {
        let are_due = now.duration_since(self.last) > SIGN_OF_LIFE;
        if are_due {
            self.last = now;
        }
        are_due
    }
}

/// The seed of a set under a law.
fn seed_of(seed: u64, set: u32, law: Option<i32>) -> u64 {
    seed ^ (u64::from(set) << 32) ^ (u64::from(law.unwrap_or_default().unsigned_abs()) << 16)
}

impl Search {
    /// The goals that findings miss.
    pub fn missed(&self, findings: &Findings) -> Vec<String> {
        let ((most, at), (mean, of)) = (&findings.costliest, &findings.slowest);
        let goals = [
            (findings.share_discarded() <= self.discarded, {
                format!("{} of {} runs discarded", findings.discarded, findings.runs)
            }),
            (*most <= self.most, format!("{most} solver steps in one communication step of {at}")),
            (*mean <= self.mean, format!("{mean:.1} solver steps in each communication step of {of}")),
        ];
        let missed = goals.into_iter().filter(|(is_met, _)| !is_met);
        missed.map(|(_, text)| format!("{}: {text}", self.name)).collect()
    }

    /// Runs it.
    ///
    /// # Errors
    /// When a set cannot be drawn or started.
    pub fn run(&self, effort: &Stress) -> Result<Findings> {
        let mut findings = Findings::default();
        let mut signs = Signs { last: Instant::now() };
        for model in models::ALL {
            for (law, name) in laws(model) {
                for set in 0..effort.sets {
                    let place = format!("{} {name} {set}", model.name);
                    if effort.only.as_ref().is_some_and(|only| !place.contains(only)) {
                        continue;
                    }
                    let mut random = Random(seed_of(effort.seed, set, law));
                    let setup = draw::setup(model, law, self.spread, self.start, &mut random)?;
                    if effort.only.is_some() {
                        println!("{place}: {}", changes(&setup)?);
                    }
                    let swing = Swing::new(&setup, self.held, &mut random);
                    let outcome = self.simulate(&swing, &mut setup.start(self.start)?, effort.seconds)?;
                    findings.note(name, &place, &outcome);
                    if signs.are_due(Instant::now()) {
                        eprintln!("  {place}: {} runs, {} discarded", findings.runs, findings.discarded);
                    }
                }
            }
        }
        Ok(findings)
    }

    fn simulate(&self, swing: &Swing, plant: &mut Plant, seconds: f64) -> Result<Outcome> {
        let mut outcome = Outcome::default();
        while outcome.steps < (seconds / STEP).round() as u64 {
            if outcome.steps == 0 || !self.held {
                for (place, value) in swing.at(outcome.steps as f64 * STEP) {
                    plant.set_input(place, value);
                }
            }
            outcome.steps += 1;
            outcome.error = plant.advance_to(self.start + outcome.steps as f64 * STEP).err();
            let work = work(plant);
            outcome.most = outcome.most.max(work - outcome.work);
            outcome.work = work;
            if outcome.error.is_some() {
                break;
            }
        }
        Ok(outcome)
    }
}

#[cfg(test)]
mod tests {
    use super::super::findings::tests::{ended, failed};
    use super::*;

    const SEARCH: Search = Search { discarded: 0.25, most: 10, mean: 2.5, ..NEAR };

    /// Of four runs one may be discarded; a run may take 10 solver steps at most, and 2.5 in the mean. What is discarded costs
    /// nothing, and of equals the first is named.
    #[test]
    fn goals_are_met_at_their_limits_and_missed_beyond_them() {
        let mut findings = Findings::default();
        for (place, outcome) in [("a", ended(10, 10)), ("b", ended(10, 10)), ("c", failed(0.5)), ("d", ended(1, 1))] {
            findings.note("LuGre", place, &outcome);
        }
        assert_eq!((findings.runs, findings.discarded, findings.share_discarded()), (4, 1, 0.25));
        assert_eq!((findings.costliest.clone(), findings.slowest.clone()), ((10, "a".into()), (2.5, "a".into())));
        assert!(SEARCH.missed(&findings).is_empty());
        findings.note("LuGre", "e", &failed(0.75));
        findings.note("LuGre", "f", &ended(11, 11));
        let beyond = [
            "2 of 6 runs discarded",
            "11 solver steps in one communication step of f",
            "2.8 solver steps in each communication step of f",
        ];
        assert_eq!(SEARCH.missed(&findings), beyond.map(|text| format!("{}: {text}", NEAR.name)));
        assert_eq!(Findings::default().share_discarded(), 0.0, "of nothing");
    }

    #[test]
    fn changes_name_what_is_not_at_its_default() {
        let setup = Setup::of(&models::ALL[0]);
        assert_eq!(changes(&setup).unwrap(), "");
        let changed = setup.set("cylinder.stroke", 0.75).unwrap().set("position0", 0.125).unwrap();
        let mut found: Vec<String> = changes(&changed).unwrap().split(' ').map(str::to_owned).collect();
        found.sort();
        assert_eq!(found, ["cylinder.stroke=0.75", "position0=0.125"]);
    }

    /// Of the seven searches the two at 1.7e9 s begin there, the two of constant inputs hold them. What may happen depends on how
    /// far parameters are from their defaults.
    #[test]
    fn searches_differ_as_their_names_say() {
        let names: std::collections::BTreeSet<_> = SEARCHES.iter().map(|search| search.name).collect();
        assert_eq!(names.len(), 7);
        for search in SEARCHES {
            assert_eq!(search.start, if search.name.ends_with("at 1.7e9 s") { 1.7e9 } else { 0.0 }, "{}", search.name);
            assert_eq!(search.held, search.name.ends_with("constant inputs"), "{}", search.name);
            let (begin, discarded, most, mean) = match search.spread {
                Spread::Factor(3.0) => ("within a factor of 3", 0.0, 1_500, 150.0),
                Spread::Factor(_) => ("within a factor of 30", 0.01, 2_500, 700.0),
                Spread::Legal => ("whole legal range", 0.5, 4_500, 3_000.0),
            };
            assert_eq!(search.name.split(',').next(), Some(begin));
            assert_eq!((search.discarded, search.most, search.mean), (discarded, most, mean), "{}", search.name);
        }
    }

    /// One run for each law that the name allows, ten communication steps long, at the times and with the inputs of the search.
    #[test]
    fn run_is_as_long_as_asked_and_meets_the_inputs_of_its_search() {
        let effort = Stress { sets: 2, seconds: 0.01, only: Some("FrictionBench LuGre".into()), ..Stress::SHORT };
        let findings = NEAR.run(&effort).unwrap();
        assert_eq!((findings.runs, findings.discarded), (2, 0));
        assert!(findings.costliest.0 > 0 && findings.costliest.1.starts_with("FrictionBench LuGre "));

        let model = &models::ALL[0];
        assert_eq!(laws(model).iter().filter(|(law, name)| *law == Some(14) && *name == "LuGre").count(), 1);
        for (start, held) in [(0.0, false), (100.0, false), (0.0, true)] {
            let search = Search { start, held, ..NEAR };
            let setup = Setup::of(model);
            let swing = Swing::new(&setup, held, &mut Random(3));
            let mut plant = setup.start(start).unwrap();
            let outcome = search.simulate(&swing, &mut plant, 0.01).unwrap();
            assert_eq!((outcome.steps, outcome.error), (10, None));
            assert!((plant.time() - start - 0.01).abs() < 1e-12, "{} s", plant.time());
            let counters = ["solver.steps", "solver.rejectedSteps"].map(|name| plant.get(name).unwrap());
            assert_eq!(outcome.work as f64, counters[0] + counters[1]);
            assert!(outcome.most <= outcome.work && 10 * outcome.most >= outcome.work, "{}", outcome.most);
            assert_eq!(outcome.mean(), outcome.work as f64 / 10.0);
            let names: Vec<&str> = setup.table().inputs().map(|input| input.name.as_str()).collect();
            for (place, value) in swing.at(0.009) {
                let found = plant.get(names[place]).unwrap();
                assert!((found - value).abs() <= 1e-9 * value.abs(), "{} is {found}, not {value}", names[place]);
            }
        }
    }

    /// The seed in the lowest bits, the law from bit 16 on, the set from bit 32 on: each set of each law has its own.
    #[test]
    fn every_set_of_every_law_has_a_seed_of_its_own() {
        assert_eq!(seed_of(1, 0, None), 1);
        assert_eq!(seed_of(5, 2, Some(14)), 0x0000_0002_000e_0005);
        assert_eq!(seed_of(0x1_0000, 0, Some(1)), 0, "bits that both have are none");
        assert_eq!(seed_of(1 << 32, 1, None), 0);
    }

    #[test]
    fn signs_of_life_come_every_four_seconds() {
        let begin = Instant::now();
        let mut signs = Signs { last: begin };
        let times = [1000, 4000, 4001, 8001, 8002, 9000];
        let are_due = times.map(|time| signs.are_due(begin + Duration::from_millis(time)));
        assert_eq!(are_due, [false, false, true, false, true, false]);
    }

    /// Inputs that are held are set before the first step.
    #[test]
    fn inputs_act_from_the_first_step_on() {
        for held in [false, true] {
            let setup = Setup::of(&models::ALL[0]);
            let swing = Swing::new(&setup, held, &mut Random(3));
            let mut plant = setup.start(0.0).unwrap();
            Search { held, ..NEAR }.simulate(&swing, &mut plant, 0.001).unwrap();
            let names: Vec<&str> = setup.table().inputs().map(|input| input.name.as_str()).collect();
            for (place, value) in swing.at(0.0) {
                let found = plant.get(names[place]).unwrap();
                assert!((found - value).abs() <= 1e-9 * value.abs(), "{} is {found}, not {value}", names[place]);
            }
        }
    }
}
