//! What a model adds to a hybrid system: computed variables.

use crate::hybrid::HybridSystem;
use crate::numbers::{Dual, Scalar, Tangent};
use crate::variables::{Notices, Table};

/// A hybrid system with computed variables, which come first among those of the model's table.
pub trait Equations<const N: usize, const U: usize>: HybridSystem<N, U> {
    /// Conserved quantities whose residuals the table lists before the solver's counters.
    const RESIDUALS: usize = 0;

    /// The variable table of the model.
    fn table() -> &'static Table;

    /// Writes the computed variables in the order of the table.
    fn outputs<S: Scalar>(&self, time: S, x: &[S; N], u: &[S; U], memory: &Self::Memory, computed: &mut [S]);

    /// The value of a computed variable, given by its place, if it takes no evaluation of the equations: as a rule one
    /// that is a state. It is the same, bit for bit, as that of [`outputs`](Self::outputs).
    fn at_hand(&self, _place: usize, _x: &[f64; N], _memory: &Self::Memory) -> Option<f64> {
        None
    }

    /// The index among the `N` states of the one that a variable stands for, if it is integrated: with other parameters
    /// (another friction law, another rig) it may not be, and keeps its start value.
    fn state_at(&self, reference: u32) -> Option<usize>;

    /// What is unusual about the parameters and the inputs.
    fn notices(&self, u: &[f64; U]) -> Notices;
}

/// Name of the variable of a model that is a state, by its index.
pub fn state_name<E: Equations<N, U>, const N: usize, const U: usize>(equations: &E, state: usize) -> &'static str {
    let reference = E::table().states().find(|reference| equations.state_at(*reference) == Some(state));
    let entry = reference.and_then(|reference| E::table().by_reference(reference));
    entry.map_or("an internal state", |entry| entry.variable.name.as_str())
}

/// Writes the derivatives of the computed variables of a model, the solver's counters included, in a direction of time,
/// states and inputs: exactly, by dual numbers.
pub fn differentiate<E: Equations<N, U>, const N: usize, const U: usize>(
    equations: &E,
    at: (f64, &[f64; N], &[f64; U], &E::Memory),
    seeds: (f64, &[f64; N], &[f64; U]),
    computed: &mut [f64],
) {
    let dual = |value: f64, slope: f64| Dual::<1> { value, slope: [slope] };
    write_slopes(equations, at, seeds, (dual, |number| number.slope[0]), computed);
}

/// The same in a direction in which the parameters, with which the equations have been built, may vary, too.
pub fn differentiate_varied<E: Equations<N, U>, const N: usize, const U: usize>(
    equations: &E,
    at: (f64, &[f64; N], &[f64; U], &E::Memory),
    seeds: (f64, &[f64; N], &[f64; U]),
    computed: &mut [f64],
) {
    let tangent = |value: f64, slope: f64| Tangent { value, slope };
    write_slopes(equations, at, seeds, (tangent, |number| number.slope), computed);
}

/// Evaluates the equations with numbers that are made with slopes, and writes the slopes of what comes out.
fn write_slopes<E: Equations<N, U>, S: Scalar, const N: usize, const U: usize>(
    equations: &E,
    (time, x, u, memory): (f64, &[f64; N], &[f64; U], &E::Memory),
    (time_seed, x_seeds, u_seeds): (f64, &[f64; N], &[f64; U]),
    (number, slope): (impl Fn(f64, f64) -> S, impl Fn(S) -> f64),
    computed: &mut [f64],
) {
    // Residuals and counters, which the equations do not write, have no slopes.
    let mut values = vec![S::zero(); computed.len()];
    let x = std::array::from_fn(|i| number(x[i], x_seeds[i]));
    let u = std::array::from_fn(|i| number(u[i], u_seeds[i]));
    equations.outputs(number(time, time_seed), &x, &u, memory, &mut values);
    for (slot, value) in computed.iter_mut().zip(values) {
        *slot = slope(value);
    }
}

/// What tests of several models share.
#[cfg(test)]
pub mod checks {
    use super::Equations;
    use crate::co_simulation::Build;
    use crate::friction::Law;
    use crate::hybrid::Indicator;
    use crate::model::Start;
    use crate::variables::{Choice, Variable};

    /// The equations of a model with its defaults, but for the friction law.
    pub fn built<E: Equations<N, U>, const N: usize, const U: usize>(build: Build<E>, law: Option<Law>) -> E {
        let value = |variable: &Variable| match law.filter(|_| variable.name == "friction.law") {
            Some(law) => f64::from(law.id()),
            None => variable.start.unwrap_or_default(),
        };
        let parameters: Vec<f64> = E::table().parameters().map(value).collect();
        let start = Start { time: 0.0, parameters: &parameters, inputs: &[0.0; U], tolerance: None };
        build(&start, &[]).expect("the defaults fit").0
    }

    /// Checks that events are looked for, and the time counts, under friction laws that ask for it alone, since both cost
    /// time in every step; but for a model that itself has events, or whose equations depend on time.
    pub fn laws_cost_what_they_ask_for<E: Equations<N, U>, const N: usize, const U: usize>(
        build: Build<E>,
        [has_events, has_time]: [bool; 2],
    ) {
        let laws = [
            (Law::None, [false; 2]),
            (Law::LuGre, [false; 2]),
            (Law::Stribeck, [true, false]),
            (Law::Armstrong, [true; 2]),
        ];
        for (law, [switches, remembers_times]) in laws {
            let equations = built(build, Some(law));
            let found = [equations.has_events(), equations.depends_on_time()];
            assert_eq!(found, [has_events || switches, has_time || remembers_times], "{law:?}");
        }
    }

    /// Checks the name of each event of a model with its defaults against the one that belongs to its place and to the name
    /// of its indicator, without the group.
    pub fn events_are_named<E: Equations<N, U>, const N: usize, const U: usize>(
        build: Build<E>,
        indicators: &[Indicator],
        expected: impl Fn(usize, &str) -> &str,
    ) {
        let equations = built(build, None);
        for (place, indicator) in indicators.iter().enumerate() {
            let (_, last) = indicator.name.rsplit_once('.').expect("a name within a group");
            assert_eq!(equations.event_name(place), expected(place, last), "{}", indicator.name);
        }
    }
}
