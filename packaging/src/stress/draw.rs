//! Random sets of parameters and inputs of a model.

use std::f64::consts::TAU;

use anyhow::Result;
use pneumatic_servo::model::{Model, Setup};
use pneumatic_servo::numbers::random;
use pneumatic_servo::variables::{Kind, Meaning, Variable};

/// How far parameters are from their defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// Real parameters within a factor of their defaults; all choices. What is 0 by default stays off in every second set,
    /// and is else within the factor of its nominal value.
    Factor(f64),
    /// The whole legal range of every parameter.
    Legal,
}

/// A source of random numbers that repeats.
pub struct Random(pub u64);

impl Random {
    /// Uniform in (0, 1].
    pub fn uniform(&mut self) -> f64 {
        random::uniform(&mut self.0)
    }

    /// Uniform between two numbers.
    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + self.uniform() * (most - least)
    }

    /// One of a number of choices.
    fn choice(&mut self, count: usize) -> usize {
        ((self.uniform() * count as f64).ceil() as usize).clamp(1, count) - 1
    }

    /// The same things in random order.
    fn shuffled<T>(&mut self, mut things: Vec<T>) -> Vec<T> {
        for end in (1..things.len()).rev() {
            things.swap(end, self.choice(end + 1));
        }
        things
    }
}

/// A random set of parameters with a law, if the model has any, that initialization accepts at a time in s.
///
/// The parameters take their values one after the other, in random order. One that does not fit to those before it, such
/// as a start beyond the stroke, keeps its default: sets drawn as a whole would hardly ever fit together.
///
/// # Errors
/// When a value is drawn that its variable refuses: a mistake of this program.
pub fn setup(model: &'static Model, law: Option<i32>, spread: Spread, time: f64, random: &mut Random) -> Result<Setup> {
    let mut setup = Setup::of(model);
    if let Some(law) = law {
        setup = setup.set("friction.law", law)?;
    }
    for variable in random.shuffled((model.variables)().parameters().collect()) {
        // Schemes, tolerances and limits are what is tested, not what varies; a number chooses nothing else than a name.
        let is_kept = matches!(variable.meaning, Some(Meaning::FrictionLaw | Meaning::Solving));
        if is_kept || variable.chooses.is_some() {
            continue;
        }
        if let Some(value) = value(variable, spread, random) {
            let changed = setup.clone().set(&variable.name, value)?;
            if changed.start(time).is_ok() {
                setup = changed;
            }
        }
    }
    Ok(setup)
}

/// A random value of a parameter, unless it keeps its default.
fn value(variable: &Variable, spread: Spread, random: &mut Random) -> Option<f64> {
    let start = variable.start?;
    if let Some(value) = point_of_table(variable, random) {
        return Some(value);
    }
    let (least, most) = (variable.min.unwrap_or(-1e6), variable.max.unwrap_or(1e6));
    match (variable.kind, spread) {
        (Kind::Enumeration(of), _) => Some(f64::from(of.items[random.choice(of.items.len())].0)),
        (Kind::Boolean, _) => Some(random.choice(2) as f64),
        (Kind::Integer, Spread::Factor(_)) => None,
        (Kind::Integer, Spread::Legal) => Some(random.between(least - 1.0, most).ceil().clamp(least, most)),
        (Kind::Real(_), Spread::Factor(factor)) => {
            let on = |nominal: f64, random: &mut Random| [None, Some(nominal)][random.choice(2)];
            let usual = if start == 0.0 { on(variable.nominal?, random)? } else { start };
            Some((usual * factor.powf(random.between(-1.0, 1.0))).clamp(least, most))
        }
        (Kind::Real(_), Spread::Legal) if least > 0.0 => {
            Some((least * (most / least).powf(random.uniform())).clamp(least, most))
        }
        (Kind::Real(_), Spread::Legal) => Some(random.between(least, most)),
    }
}

/// A random coordinate of a point of a valve's table, which must rise from point to point.
fn point_of_table(variable: &Variable, random: &mut Random) -> Option<f64> {
    const POINTS: f64 = 11.0;
    let (_, place) = variable.name.strip_prefix("valve.table")?.split_once('[')?;
    let place: f64 = place.trim_end_matches(']').parse().ok()?;
    Some((place - random.uniform()) / POINTS)
}

/// Inputs that swing about their start values by their nominal values, or are held somewhere there.
pub struct Swing {
    /// Place of the input, start value, amplitude, frequency in Hz and phase.
    inputs: Vec<(usize, f64, f64, f64, f64)>,
}

impl Swing {
    /// Random frequencies and phases for all inputs; those that are held have the frequency 0.
    pub fn new(setup: &Setup, held: bool, random: &mut Random) -> Self {
        let inputs = setup.table().inputs().enumerate().map(|(place, variable)| {
            let (start, nominal) = (variable.start.unwrap_or_default(), variable.nominal.unwrap_or(1.0));
            let frequency = random.between(0.2, 5.0) * if held { 0.0 } else { 1.0 };
            (place, start, nominal * random.uniform(), frequency, random.uniform() * TAU)
        });
        Self { inputs: inputs.collect() }
    }

    /// Places and values of the inputs at a time in s since the start.
    pub fn at(&self, time: f64) -> impl Iterator<Item = (usize, f64)> {
        self.inputs.iter().map(move |(place, start, amplitude, frequency, phase)| {
            (*place, start + amplitude * (TAU * frequency * time + phase).sin())
        })
    }
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::models;
    use pneumatic_servo::variables::units;

    use super::*;

    const DRAWS: usize = 4000;

    /// Values drawn for a parameter, in rising order; those that keep the default are left out.
    fn drawn(variable: &Variable, spread: Spread) -> Vec<f64> {
        let mut random = Random(5);
        let mut values: Vec<f64> = (0..DRAWS).filter_map(|_| value(variable, spread, &mut random)).collect();
        values.sort_by(f64::total_cmp);
        values
    }

    /// The values that a share of the draws does not exceed, 0, a half and all, are near those expected: of uniform draws they
    /// scatter by less than 0.01 of the range (a median by half of one over the root of 4000, 0.008).
    fn is_spread(values: &[f64], [least, middle, most]: [f64; 3], name: &str) {
        let found = [values[0], values[values.len() / 2], values[values.len() - 1]];
        for (found, expected) in found.into_iter().zip([least, middle, most]) {
            assert!((found - expected).abs() <= 0.02 * (most - least), "{name}: {found}, not {expected}");
        }
        assert!(least <= found[0] && found[2] <= most, "{name}: {found:?} beyond {least} to {most}");
    }

    #[test]
    fn every_choice_is_drawn_equally_often() {
        let mut random = Random(1);
        for count in [1, 2, 3, 7] {
            let mut often = vec![0usize; count];
            for _ in 0..DRAWS {
                often[random.choice(count)] += 1;
            }
            // Four standard deviations of a count are 4*sqrt(4000*p*(1 - p)), at most 127.
            assert!(often.iter().all(|times| times.abs_diff(DRAWS / count) <= 127), "{often:?}");
        }
    }

    #[test]
    fn order_is_random_and_loses_nothing() {
        let (mut random, mut first) = (Random(2), [0usize; 4]);
        for _ in 0..DRAWS {
            let mut order = random.shuffled(vec![0, 1, 2, 3]);
            first[order[0]] += 1;
            order.sort_unstable();
            assert_eq!(order, [0, 1, 2, 3]);
        }
        assert!(first.iter().all(|times| times.abs_diff(DRAWS / 4) <= 110), "{first:?}");
    }

    /// Within a factor of 3: from a third to the threefold, half of them below the default. A default of 0 stays off in every
    /// second set, and is else within the factor of its nominal value; limits are kept.
    #[test]
    fn real_parameters_are_within_the_factor_of_their_defaults() {
        let parameter = |start| Variable::parameter(0, "x", units::METRE, start);
        let third = Spread::Factor(3.0);
        for start in [6.0, -6.0] {
            let values = drawn(&parameter(start), third);
            let mut logarithms: Vec<f64> = values.iter().map(|x| (x / start).log(3.0)).collect();
            logarithms.sort_by(f64::total_cmp);
            assert_eq!(logarithms.len(), DRAWS);
            // Rounding takes the ends one unit in the last place beyond.
            let inside: Vec<f64> = logarithms.iter().map(|x| x.clamp(-1.0, 1.0)).collect();
            assert!(inside.iter().zip(&logarithms).all(|(a, b)| (a - b).abs() < 1e-14));
            // The greater the number drawn, the farther from 0.
            for seed in 0..20 {
                let is_beyond = value(&parameter(start), third, &mut Random(seed)).expect("a value").abs() > 6.0;
                assert_eq!(is_beyond, Random(seed).uniform() > 0.5, "{seed}");
            }
            is_spread(&inside, [-1.0, 0.0, 1.0], "logarithm");
        }
        let off = drawn(&parameter(0.0).nominal(2.0), third);
        assert!(off.len().abs_diff(DRAWS / 2) <= 127, "{}", off.len());
        assert!(off.iter().all(|x| (2.0 / 3.0 - 1e-15..=6.0 + 1e-14).contains(x)));
        assert!(drawn(&parameter(0.0), third).is_empty(), "without a nominal value");
        let limited = drawn(&parameter(6.0).range(5.0, 7.0), third);
        assert_eq!((limited[0], limited[limited.len() - 1]), (5.0, 7.0));
        assert!(drawn(&Variable::count(0, "n", 4).range(1.0, 9.0), third).is_empty(), "a number of things");
    }

    /// All that is legal: on a scale of logarithms between limits above 0, on a plain one else, and within 1e6 without limits.
    #[test]
    fn the_whole_legal_range_is_drawn() {
        let parameter = |min, max| Variable::parameter(0, "x", units::METRE, min).range(min, max);
        is_spread(&drawn(&parameter(-2.0, 4.0), Spread::Legal), [-2.0, 1.0, 4.0], "plain");
        is_spread(&drawn(&parameter(0.0, 4.0), Spread::Legal), [0.0, 2.0, 4.0], "from 0");
        let wide: Vec<f64> = drawn(&parameter(1e-3, 1e5), Spread::Legal).iter().map(|x| x.log10()).collect();
        is_spread(&wide, [-3.0, 1.0, 5.0], "decades");
        is_spread(
            &drawn(&Variable::parameter(0, "x", units::METRE, 0.0), Spread::Legal),
            [-1e6, 0.0, 1e6],
            "unlimited",
        );
        let counts = drawn(&Variable::count(0, "n", 4).range(1.0, 9.0), Spread::Legal);
        for number in 1..=9 {
            let often = counts.iter().filter(|count| **count == f64::from(number)).count();
            assert!(often.abs_diff(DRAWS / 9) <= 80, "{number} is drawn {often} times");
        }
    }

    /// The law is the one asked for, and what the solver is told stays as it is, and so do numbers that stand for names; all else
    /// is drawn.
    #[test]
    fn law_and_solver_are_kept() {
        let model = &models::friction_bench::MODEL;
        let mut moved = 0;
        for seed in 0..5 {
            let setup = setup(model, Some(14), Spread::Legal, 0.0, &mut Random(seed)).expect("a set");
            for variable in setup.table().parameters() {
                let value = setup.get(&variable.name).expect("a value");
                match variable.meaning {
                    _ if variable.chooses.is_some() => assert_eq!(value, 0.0, "{}", variable.name),
                    Some(Meaning::FrictionLaw) => assert_eq!(value, 14.0),
                    Some(Meaning::Solving) => assert_eq!(Some(value), variable.start, "{}", variable.name),
                    _ => moved += usize::from(Some(value) != variable.start),
                }
            }
        }
        assert!(moved > 5, "{moved} values are not the default");
    }

    /// Each point has its own eleventh of the line, so that the table rises.
    #[test]
    fn points_of_a_table_rise() {
        for (name, place) in [("valve.tableCommand[1]", 1.0), ("valve.tableOpening[11]", 11.0)] {
            let values = drawn(&Variable::parameter(0, name, units::ONE, 0.5).range(-1.0, 1.0), Spread::Legal);
            is_spread(&values, [(place - 1.0) / 11.0, (place - 0.5) / 11.0, place / 11.0], name);
        }
    }

    /// Inputs swing about their start values by less than their nominal values, each with a time of its own; those that are
    /// held stay.
    #[test]
    fn inputs_swing_about_their_start_values() {
        let setup = Setup::of(&models::ALL[0]);
        for held in [false, true] {
            let swing = Swing::new(&setup, held, &mut Random(4));
            // A hundred of the longest periods.
            let times = (0..50_000).map(|point| 0.01 * f64::from(point));
            let mut sums = vec![[0.0f64, f64::INFINITY, f64::NEG_INFINITY]; setup.inputs().len()];
            for time in times {
                for (place, value) in swing.at(time) {
                    let [sum, least, most] = sums[place];
                    sums[place] = [sum + value / 50_000.0, least.min(value), most.max(value)];
                }
            }
            for (input, [mean, least, most]) in setup.table().inputs().zip(sums) {
                let (start, nominal) = (input.start.unwrap_or_default(), input.nominal.unwrap_or(1.0));
                assert!(start - nominal <= least && most <= start + nominal, "{}: {least} to {most}", input.name);
                if held {
                    assert!(most == least && least != start, "{} is not held off its start value", input.name);
                } else {
                    let amplitude = 0.5 * (most - least);
                    assert!(amplitude > 0.0 && (mean - start).abs() < 0.01 * amplitude, "{}: {mean}", input.name);
                }
            }
        }
    }

    #[test]
    fn inputs_swing_about_their_start_values_or_are_held() {
        let swing = Swing { inputs: vec![(3, 2.0, 3.0, 0.25, 0.0), (5, -1.0, 4.0, 0.0, 0.25 * TAU)] };
        let at = |time: f64| swing.at(time).collect::<Vec<_>>();
        assert_eq!(at(0.0), [(3, 2.0), (5, 3.0)]);
        assert_eq!(at(1.0), [(3, 5.0), (5, 3.0)]);
        assert!((at(3.0)[0].1 + 1.0).abs() < 1e-14, "three quarters of a period later");
    }
}
