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
            let on = |nominal: f64, random: &mut Random| (random.choice(2) == 1).then_some(nominal);
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
