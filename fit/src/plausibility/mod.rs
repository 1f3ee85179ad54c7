//! Plausibility of a measured record: units, atmospheres, signs and chambers that are mistaken, and their remedies.

mod contradictions;
mod ranges;
mod recorder;

use std::collections::BTreeMap;

use crate::experiment::Given;
use crate::numerals::significant;
use crate::record::{Signals, unit_of};
use crate::units;

pub use contradictions::contradictions;
pub use ranges::{findings, outliers, supply};
pub use recorder::recorder;

/// A change of columns, settings or data that removes the cause of a finding.
#[derive(Clone, Debug, PartialEq)]
pub enum Remedy {
    /// The column of a signal is in another unit.
    Unit {
        /// The signal.
        signal: String,
        /// The unit.
        unit: String,
    },
    /// The sign of the column of a signal is the opposite.
    Turn {
        /// The signal.
        signal: String,
    },
    /// The columns of two signals are each other's.
    Swap {
        /// The signals.
        signals: [String; 2],
    },
    /// Parameters of the machine or of its sensors have other values.
    Set {
        /// Their names and values in SI units.
        values: Vec<(String, f64)>,
    },
    /// Samples are corrected, or removed.
    Remove {
        /// The signal.
        signal: String,
        /// The samples.
        rows: Vec<usize>,
    },
}

/// Something about a signal that cannot be meant, or is unlikely.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The signal.
    pub signal: String,
    /// Where it is, what is found, and what may be meant; the remedy is said by whoever offers it.
    pub text: String,
    /// Remedies, the likeliest first.
    pub remedies: Vec<Remedy>,
    /// Whether no fit makes sense with it.
    pub is_refused: bool,
}

impl Finding {
    fn refused(signal: &str, text: String, remedies: Vec<Remedy>) -> Self {
        Self { signal: signal.to_owned(), text, remedies, is_refused: true }
    }

    fn doubted(signal: &str, text: String, remedies: Vec<Remedy>) -> Self {
        Self { is_refused: false, ..Self::refused(signal, text, remedies) }
    }
}

/// A column as the table has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// Its name.
    pub name: String,
    /// The unit of its numbers.
    pub unit: String,
}

/// An experiment, and what is known of the units of its signals.
pub struct Facts<'a> {
    /// Kind of the experiment, and its fixed values.
    pub given: &'a Given,
    /// Columns of the signals; a signal without one is in its SI unit.
    pub columns: &'a BTreeMap<String, Written>,
    /// SI units of the signals of a rotating machine, where these differ from the units of a machine that slides.
    pub units: &'a BTreeMap<String, String>,
}

/// Signals of a record, with its name and the place of a sample, for people.
pub struct Source<'a> {
    /// Name of the record.
    pub name: &'a str,
    /// Signals in SI units, with `time`.
    pub signals: &'a Signals,
    /// Place of a sample of a signal.
    pub place: &'a dyn Fn(&str, usize) -> String,
}

/// Findings about a record by itself and about its signals beside one another.
pub fn check(facts: &Facts<'_>, source: &Source<'_>) -> Vec<Finding> {
    let mut found = findings(facts, source);
    found.extend(supply(facts.given));
    if found.iter().any(|finding| finding.is_refused) {
        return found;
    }
    match facts.given.kind.records(source.name, source.signals.clone()) {
        Ok((records, _)) => {
            if facts.given.kind.name != "points" {
                found.extend(recorder(facts, source).0);
            }
            found.extend(contradictions(facts, &records));
        }
        Err(refused) => found.push(Finding::refused("time", refused.0, vec![])),
    }
    found
}

fn is_of_cylinder(given: &Given) -> bool {
    given.table.name == given.cylinder.name
}

impl Facts<'_> {
    fn is_of_cylinder(&self) -> bool {
        is_of_cylinder(self.given)
    }

    /// SI unit of a signal.
    fn si(&self, signal: &str) -> &str {
        self.units.get(signal).map_or_else(|| unit_of(signal), String::as_str)
    }

    /// Unit of the numbers of a signal.
    fn unit(&self, signal: &str) -> &str {
        self.columns.get(signal).map_or_else(|| self.si(signal), |column| &column.unit)
    }

    fn is_set(&self, name: &str) -> bool {
        self.given.known.contains_key(name)
    }

    /// The range of a signal, as the begin of a sentence.
    fn told(&self, source: &Source<'_>, signal: &str, (low, high): (f64, f64)) -> String {
        let column = self.columns.get(signal).map(|Written { name, unit }| format!(" (column {name} in {unit})"));
        let [low, high] = [low, high].map(|value| significant(value, 5));
        let (name, column, si) = (source.name, column.unwrap_or_default(), self.si(signal));
        format!("{name}: {signal}{column} is from {low} to {high} {si}")
    }

    /// Numbers of a signal as they are written, in another unit; nothing for one of another quantity.
    fn in_unit(&self, signal: &str, unit: &str, values: [f64; 2]) -> Option<[f64; 2]> {
        let si = self.si(signal);
        let (factor, offset) = units::to_si(self.unit(signal), si, false).ok()?;
        let (times, behind) = units::to_si(unit, si, false).ok()?;
        Some(values.map(|value| (value - offset) / factor * times + behind))
    }

    fn other_unit(&self, signal: &str, unit: &str) -> Option<Remedy> {
        let is_other = units::spelled(self.unit(signal)) != unit;
        is_other.then(|| Remedy::Unit { signal: signal.to_owned(), unit: unit.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::contradictions::share_of_work;
    use super::*;
    use crate::experiment::{Kind, Options, PRESSURES};

    const SECOND: usize = 1000;

    /// A second of a rig whose carriage swings, with pressures that drive it and a voltage that leads it.
    fn rig() -> Signals {
        let course = |of: fn(f64) -> f64| (0..SECOND).map(|row| of(1e-3 * row as f64)).collect::<Vec<f64>>();
        let signals = [
            ("time", course(|t| t)),
            ("position", course(|t| 0.25 - 0.1 * libm::cos(6.0 * t))),
            ("valveVoltage", course(|t| 5.0 + 2.0 * libm::sin(6.0 * t))),
            ("chamberA.pressure", course(|t| 3.2e5 + 1e5 * libm::sin(6.0 * t))),
            ("chamberB.pressure", course(|t| 3.2e5 - 1e5 * libm::sin(6.0 * t))),
        ];
        signals.map(|(name, values)| (name.to_owned(), values)).into()
    }

    fn scaled(signal: &str, factor: f64, offset: f64) -> Signals {
        let mut signals = rig();
        signals.get_mut(signal).expect("a signal").iter_mut().for_each(|value| *value = factor * *value + offset);
        signals
    }

    fn found(signals: &Signals, columns: &[(&str, &str)], known: &[(&str, f64)]) -> Vec<Finding> {
        let kind = Kind::of_name("rig").expect("an experiment");
        let known = known.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let given = Given::new(kind, 7, known, signals.keys().cloned(), Options::default());
        let written = |(signal, unit): &(&str, &str)| {
            ((*signal).to_owned(), Written { name: "p".to_owned(), unit: (*unit).to_owned() })
        };
        let columns = columns.iter().map(written).collect();
        let facts = Facts { given: &given, columns: &columns, units: &BTreeMap::new() };
        check(&facts, &Source { name: "rig.csv", signals, place: &|signal, row| format!("rig.csv, {signal} {row}") })
    }

    fn only(mut found: Vec<Finding>) -> Finding {
        assert_eq!(found.len(), 1, "{found:?}");
        found.remove(0)
    }

    fn units_of(finding: &Finding) -> Vec<&str> {
        let mut units = Vec::new();
        for remedy in &finding.remedies {
            let Remedy::Unit { unit, .. } = remedy else { panic!("{remedy:?}") };
            units.push(unit.as_str());
        }
        units
    }

    fn set(values: &[(&str, f64)]) -> Remedy {
        Remedy::Set { values: values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect() }
    }

    const SUPPLY: (&str, f64) = ("supplyPressure", 6e5);

    #[test]
    fn a_rig_as_it_should_be_has_no_findings() {
        assert_eq!(found(&rig(), &[], &[SUPPLY]), []);
    }

    /// Pressures are written in one unit, and their column states another: the remedy is the unit of the numbers.
    #[test]
    fn a_pressure_is_in_the_unit_that_brings_it_near_its_supply() {
        let pressure = "chamberA.pressure";
        for (numbers, written, expected) in [
            (scaled(pressure, 1.0, -2.2e5), "bar", vec!["barg"]),
            (scaled(pressure, 1.0, -2.2e5), "Pa", vec!["Pag"]),
            (scaled(pressure, 1.0, -2.2e5), "psi", vec!["psig"]),
            (scaled(pressure, 1e-5, 0.0), "Pa", vec!["bar", "barg"]),
            (scaled(pressure, 1e-3, 0.0), "Pa", vec!["kPa", "kPag"]),
            (scaled(pressure, 14.503_77, 0.0), "bar", vec!["psi", "psig"]),
            (scaled(pressure, 1e2, 0.0), "bar", vec!["kPa", "kPag"]),
        ] {
            let finding = only(found(&numbers, &[(pressure, written)], &[SUPPLY]));
            assert_eq!((units_of(&finding), finding.is_refused), (expected, true), "{written}: {}", finding.text);
        }
        let none = only(found(&scaled(pressure, -1.0, 0.0), &[], &[]));
        assert!(none.remedies.is_empty() && none.text.ends_with("is the unit right?"), "{}", none.text);
    }

    #[test]
    fn a_position_is_in_the_unit_in_which_it_moves_along_the_stroke() {
        for (factor, written, expected) in
            [(1e3, "m", vec!["mm"]), (1e2, "m", vec!["cm", "mm"]), (1e6, "m", vec!["um"]), (1e4, "cm", vec!["um"])]
        {
            let finding = only(found(&scaled("position", factor, 0.0), &[("position", written)], &[]));
            assert_eq!(units_of(&finding), expected, "{written}: {}", finding.text);
        }
        let middle = only(found(&scaled("position", 1.0, -0.25), &[], &[]));
        assert_eq!((middle.remedies, middle.is_refused), (vec![set(&[("offset.position", -0.25)])], true));
        let turned = only(found(&scaled("position", -1.0, 0.0), &[], &[]));
        assert_eq!(turned.remedies, [Remedy::Turn { signal: "position".to_owned() }]);
        let beyond = only(found(&scaled("position", 1.0, 0.4), &[], &[]));
        assert!(beyond.remedies.is_empty() && beyond.text.contains("give the stroke"), "{}", beyond.text);
    }

    #[test]
    fn a_remedy_removes_its_finding() {
        assert_eq!(found(&scaled("position", 1.0, -0.25), &[], &[("offset.position", -0.25)]), []);
        assert_eq!(
            found(&scaled("position", -1.0, 0.5), &[], &[("gain.position", -1.0), ("offset.position", 0.5)]),
            []
        );
        let turned = [("gain.valveVoltage", -1.0), ("offset.valveVoltage", 10.0)];
        assert_eq!(found(&scaled("valveVoltage", -1.0, 10.0), &[], &turned), []);
    }

    #[test]
    fn one_mistake_that_explains_two_contradictions_comes_first() {
        let swap = Remedy::Swap { signals: PRESSURES.map(str::to_owned) };
        let other_end = set(&[("gain.position", -1.0), ("offset.position", 0.5)]);
        let mut swapped = rig();
        let [a, b] = PRESSURES.map(|signal| swapped[signal].clone());
        swapped.extend([(PRESSURES[0].to_owned(), b), (PRESSURES[1].to_owned(), a)]);
        let finding = only(found(&swapped, &[], &[]));
        assert_eq!((&finding.remedies, finding.is_refused), (&vec![swap.clone(), other_end.clone()], false));
        let both = found(&scaled("position", -1.0, 0.5), &[], &[]);
        assert_eq!(both.len(), 2, "{both:?}");
        assert_eq!(both[0].remedies, [other_end, swap]);
    }

    #[test]
    fn a_record_that_cannot_be_split_and_a_supply_in_bar_are_refused() {
        let short = rig().into_iter().map(|(name, values)| (name, values[..20].to_vec())).collect();
        let finding = only(found(&short, &[], &[]));
        assert!(finding.is_refused && finding.text.contains("too short, 20 samples"), "{}", finding.text);
        let finding = only(found(&rig(), &[], &[("supplyPressure", 6.0)]));
        assert_eq!((finding.remedies, finding.is_refused), (vec![set(&[("supplyPressure", 6e5)])], true));
    }

    /// 100 m one way and 60 m back end 40 of 160 m from the start: 0.3 of the path may be missing, 80 of 120 m not.
    #[test]
    fn work_says_something_of_signs_on_a_path_forth_and_back() {
        assert_eq!(share_of_work(&[1.0, 1.0], &[100.0, -60.0], 1.0), 40.0 / 160.0);
        assert_eq!(share_of_work(&[-1.0, -1.0], &[100.0, -60.0], 0.5), -40.0 / 160.0);
        assert_eq!(share_of_work(&[-1.0, -1.0], &[100.0, -20.0], 1.0), 1.0);
        assert_eq!(share_of_work(&[-1.0, -1.0], &[0.0, 0.0], 1.0), 1.0);
    }
}
