//! Derivatives by time, inputs, states and tunable parameters, compared with differences.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use super::{described, duration, moved, started};
use crate::co_simulation::{Direction, Simulation};
use crate::model::Setup;
use crate::model_exchange::Exchange;
use crate::variables::{Kind, Role, Table, Variable};

/// A difference by values that are whole steps from the present one: the steps and the weight of each.
type Stencil = [(f64, f64); 3];

/// The central difference, and one-sided ones by a parabola: where the other side is not legal, or where the values have a
/// corner with a one-sided derivative, as at rest against the hysteresis of the valve.
const STENCILS: [Stencil; 3] = [
    [(0.0, 0.0), (1.0, 0.5), (-1.0, -0.5)],
    [(0.0, -1.5), (1.0, 2.0), (2.0, -0.5)],
    [(0.0, 1.5), (-1.0, -2.0), (-2.0, 0.5)],
];

/// Step sizes, relative to the known: where a value is strongly curved the smaller ones are accurate, where large terms
/// cancel the larger ones.
const SIZES: [f64; 7] = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];
/// The smallest of them that say something of every derivative; smaller ones only where that is far above their rounding, as of a
/// law that is smooth within a nanometre per second.
const COARSE: f64 = 1e-7;

/// Compares the derivatives of all variables by time, inputs, states and tunable parameters with differences, four times in a
/// run with moving inputs, and demands the same bits with the solver inside and outside.
///
/// # Panics
/// When a derivative differs from all differences. Exactly at a corner it may be either one-sided derivative or their mean.
pub fn slopes(setup: &Setup) {
    let mut found = Slopes::default();
    found.run(setup, &|_| true);
    assert!(found.wrong.is_empty(), "{} differ: {:#?}", found.wrong.len(), &found.wrong[..found.wrong.len().min(20)]);
}

/// Results for the derivatives of a model.
#[derive(Clone, Debug, Default)]
pub struct Slopes {
    /// Derivatives that differ from differences, in words.
    pub wrong: Vec<String>,
    /// The names of the knowns with an effect.
    pub effective: BTreeSet<&'static str>,
}

impl Slopes {
    /// Looks four times at a run with moving inputs, at all but those tunable parameters that are left out.
    ///
    /// # Panics
    /// When the run fails, or a derivative has other bits with the solver outside.
    pub fn run(&mut self, setup: &Setup, is_looked_at: &dyn Fn(&Variable) -> bool) {
        let (mut run, duration) = (started(setup), duration(setup));
        for look in 0..4 {
            let inputs = moved(setup, (TAU * f64::from(look) / 3.5).sin());
            run.set_inputs(&inputs, &vec![0.0; inputs.len()]);
            let end = duration * f64::from(look + 1) / 4.0;
            run.advance(end).unwrap_or_else(|error| panic!("{}: {error}", described(setup)));
            let Some(exchange) = run.exchange(setup.model().indicators()) else { return };
            let mut states = vec![0.0; setup.table().number_of_states()];
            exchange.states(&mut states);
            let mut bench = Bench { setup, exchange, inputs, states };
            for known in bench.knowns(is_looked_at) {
                self.look(&mut bench, &known, run.as_ref());
            }
        }
    }

    fn look(&mut self, bench: &mut Bench, known: &Known, inside: &dyn Simulation) {
        let exact = bench.slopes(known, |direction, out| bench.exchange.directional_derivative(direction, out));
        let of_inside = bench.slopes(known, |direction, out| inside.directional_derivative(direction, out));
        let same = exact.iter().zip(&of_inside).all(|(one, other)| one.to_bits() == other.to_bits());
        assert!(same, "{}: other slopes by {} with the solver inside", described(bench.setup), known.variable.name);
        let at = format!("{} at {} s", described(bench.setup), inside.time());
        self.wrong.extend(bench.differing(known, &exact).into_iter().map(|wrong| format!("{at}: {wrong}")));
        self.effective.extend(exact.iter().any(|slope| *slope != 0.0).then_some(known.variable.name.as_str()));
    }
}

/// A known of the derivatives: its variable, index within its kind, value, and the magnitude of steps.
struct Known {
    kind: KnownKind,
    variable: &'static Variable,
    place: usize,
    value: f64,
    scale: f64,
}

#[derive(Clone, Copy, PartialEq)]
enum KnownKind {
    Time,
    Input,
    State,
    Parameter,
}

/// A run in model exchange, in which the knowns can be changed one by one.
struct Bench<'a> {
    setup: &'a Setup,
    exchange: Box<dyn Exchange>,
    inputs: Vec<f64>,
    states: Vec<f64>,
}

impl Bench<'_> {
    fn table(&self) -> &'static Table {
        self.setup.table()
    }

    /// All that may vary.
    fn knowns(&self, is_looked_at: &dyn Fn(&Variable) -> bool) -> Vec<Known> {
        let table = self.table();
        let time = table.entries().map(|entry| entry.variable).filter(|variable| variable.role == Role::Time);
        let time = time.map(|variable| Known {
            kind: KnownKind::Time,
            variable,
            place: 0,
            value: self.exchange.time(),
            scale: 1e-2,
        });
        let real = |variable: &Variable| matches!(variable.kind, Kind::Real(_));
        let inputs = table.inputs().zip(&self.inputs).enumerate().filter(|(_, (variable, _))| real(variable));
        let inputs = inputs.map(|(place, (variable, value))| {
            let scale = variable.nominal.unwrap_or(1.0).max(value.abs());
            Known { kind: KnownKind::Input, variable, place, value: *value, scale }
        });
        let mut nominals = self.states.clone();
        self.exchange.nominals(&mut nominals);
        let states = table.states().zip(self.states.iter().zip(&nominals)).enumerate();
        let states = states.filter_map(|(place, (reference, (value, nominal)))| {
            let variable = table.by_reference(reference)?.variable;
            Some(Known { kind: KnownKind::State, variable, place, value: *value, scale: nominal.max(value.abs()) })
        });
        let parameters = table.parameters().zip(self.setup.parameters()).enumerate();
        let parameters = parameters
            .filter(|(_, (variable, _))| variable.role == Role::Tunable && real(variable) && is_looked_at(variable));
        let parameters = parameters.map(|(place, (variable, value))| {
            // Where the value is 0, values far below the largest.
            let scale = if *value == 0.0 { 1e-3 * variable.max.unwrap_or(1.0).min(1.0) } else { value.abs() };
            Known { kind: KnownKind::Parameter, variable, place, value: *value, scale }
        });
        time.chain(inputs).chain(states).chain(parameters).collect()
    }

    /// The derivatives of all computed variables by the known.
    fn slopes(&self, known: &Known, differentiate: impl Fn(Direction, &mut [f64])) -> Vec<f64> {
        let along = |kind: KnownKind, count: usize| {
            let mut seeds = vec![0.0; count];
            if kind == known.kind {
                seeds[known.place] = 1.0;
            }
            seeds
        };
        let time = along(KnownKind::Time, 1)[0];
        let (inputs, states) = (along(KnownKind::Input, self.inputs.len()), along(KnownKind::State, self.states.len()));
        let parameters = match known.kind {
            KnownKind::Parameter => along(KnownKind::Parameter, self.setup.parameters().len()),
            _ => Vec::new(),
        };
        let mut slopes = vec![f64::NAN; self.table().computed().count()];
        let direction = Direction { time, inputs: &inputs, states: &states, parameters: &parameters };
        differentiate(direction, &mut slopes);
        slopes
    }

    /// Sets the known to a value, if that is legal.
    fn set(&mut self, known: &Known, value: f64) -> Option<()> {
        let changed = |values: &[f64]| {
            let mut values = values.to_vec();
            values[known.place] = value;
            values
        };
        match known.kind {
            KnownKind::Time => self.exchange.set_time(value),
            KnownKind::Input => self.exchange.set_inputs(&changed(&self.inputs)),
            KnownKind::State => self.exchange.set_states(&changed(&self.states)),
            KnownKind::Parameter => {
                known.variable.check(value).ok()?;
                self.exchange.retune(&changed(self.setup.parameters())).ok()?;
            }
        }
        Some(())
    }

    /// All computed values with the known at another value, if that is legal.
    fn values(&mut self, known: &Known, value: f64) -> Option<Vec<f64>> {
        self.set(known, value)?;
        let mut values = vec![0.0; self.table().computed().count()];
        self.exchange.values(&mut values);
        self.set(known, known.value).expect("the present value");
        Some(values)
    }

    /// The differences of all computed values, if the values they need are legal.
    fn difference(&mut self, known: &Known, stencil: &Stencil, step: f64) -> Option<Vec<f64>> {
        let mut sum = vec![0.0; self.table().computed().count()];
        for (steps, weight) in stencil.iter().filter(|(_, weight)| *weight != 0.0) {
            let values = self.values(known, known.value + steps * step)?;
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value / step);
        }
        Some(sum)
    }

    /// The derivatives that no difference confirms, in words.
    fn differing(&mut self, known: &Known, exact: &[f64]) -> Vec<String> {
        let now = self.values(known, known.value).expect("the present value");
        let mut wrong: Vec<(usize, &Variable)> = self.table().computed().enumerate().collect();
        wrong.retain(|(_, variable)| matches!(variable.kind, Kind::Real(_)));
        let mut differences = Vec::new();
        // Rates of elements at their limit are small differences of terms that a state moves, and have the rounding of these.
        let share = if known.kind == KnownKind::Parameter { 1e-13 } else { 1e-11 };
        for size in SIZES {
            let step = size * known.scale;
            let is_near = |(index, variable): (usize, &Variable), difference: f64| {
                let rounding = share * (now[index].abs() + variable.nominal.unwrap_or(1.0)) / step;
                if size < COARSE && rounding > 1e-5 * exact[index].abs() {
                    return false;
                }
                let error = (exact[index] - difference).abs();
                error <= 1e-5 * exact[index].abs().max(difference.abs()) + rounding
            };
            let mut sides = Vec::new();
            for stencil in &STENCILS {
                if wrong.is_empty() {
                    return Vec::new();
                }
                let Some(difference) = self.difference(known, stencil, step) else { continue };
                wrong.retain(|it| !is_near(*it, difference[it.0]));
                sides.push(difference);
            }
            if let [_, above, below] = &sides[..] {
                wrong.retain(|it| !is_near(*it, above[it.0] + below[it.0]));
            }
            differences.extend(sides);
        }
        // A value that stands for "none" has no neighbours, and nothing follows it.
        wrong.retain(|(index, _)| !differences.is_empty() || exact[*index] != 0.0);
        let tell = |(index, variable): (usize, &Variable)| {
            let far = |difference: &f64| (difference - exact[index]).abs();
            let found = differences.iter().map(|difference| difference[index]);
            let nearest = found.min_by(|one, other| far(one).total_cmp(&far(other))).unwrap_or(f64::NAN);
            format!(
                "the derivative of {} by {} is {}, and {nearest} by the nearest difference; they may differ by a share of 1e-5 \
                 beyond rounding",
                variable.name, known.variable.name, exact[index]
            )
        };
        wrong.into_iter().map(tell).collect()
    }
}
