//! One communication step as a linear map.

use super::{Along, Companion, Leaf, NoDerivative, Slopes};

/// What a communication step does to small changes, exact through the events in it: rows are what changes, columns by what.
///
/// ```text
/// x+ = A*x + B*u + P*p        y = C*x + D*u + Q*p
/// ```
///
/// `x` are the continuous states and, behind them, the numbers that the memory keeps (`memory.friction.since`) but for
/// its [sides](crate::system::side); `x+` are those
/// at the end of the step, whose memory may keep others. `u` is added to the inputs over the whole step, and `y` are the outputs
/// at its end, as a run records them. All matrices are row by row, in SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transition {
    /// Names of `x`.
    pub states: Vec<String>,
    /// Names of `x+`.
    pub next_states: Vec<String>,
    /// `A`, by its rows.
    pub a: Vec<Vec<f64>>,
    /// `B`.
    pub b: Vec<Vec<f64>>,
    /// `C`.
    pub c: Vec<Vec<f64>>,
    /// `D`.
    pub d: Vec<Vec<f64>>,
    /// `P`.
    pub p: Vec<Vec<f64>>,
    /// `Q`.
    pub q: Vec<Vec<f64>>,
    /// The columns without a derivative, counted over states, inputs and parameters, and why: their entries are not numbers.
    pub lost: Vec<(usize, NoDerivative)>,
}

/// The continuous states that are integrated: their numbers, their places and their names.
pub type States = Vec<(usize, usize, String)>;

/// The columns of a transition, and the names of those that are states.
pub fn columns(states: &States, memory: &[Leaf], inputs: usize, parameters: &[Along]) -> (Vec<Along>, Vec<String>) {
    let kept = memory.iter().enumerate().filter(|(_, leaf)| !leaf.is_side);
    let of_states = states.iter().map(|(number, _, name)| (Along::State(*number), name.clone()));
    let of_memory = kept.map(|(number, leaf)| (Along::Memory(number), format!("memory.{}", leaf.name)));
    let (mut along, names): (Vec<_>, Vec<_>) = of_states.chain(of_memory).unzip();
    along.extend((0..inputs).map(Along::Input));
    along.extend(parameters);
    (along, names)
}

impl Transition {
    /// The place of an output without a derivative in any direction that has one, as the reading of a sensor with a resolution.
    pub(crate) fn rounded(&self, mut matters: impl FnMut(usize) -> bool) -> Option<usize> {
        let is_lost = |column: &usize| self.lost.iter().any(|(lost, _)| lost == column);
        (0..self.c.len()).find(|output| {
            let row = self.c[*output].iter().chain(&self.d[*output]).chain(&self.q[*output]);
            let mut others = row.enumerate().filter(|(column, _)| !is_lost(column)).peekable();
            matters(*output) && others.peek().is_some() && others.all(|(_, slope)| slope.is_nan())
        })
    }

    /// That of a companion that has come across a step, with so many inputs, at whose end variables in places are the outputs;
    /// all computed variables are so many.
    pub fn of(
        companion: &mut Companion,
        (states, names, inputs): (&States, Vec<String>, usize),
        outputs: &[usize],
        computed: usize,
    ) -> Self {
        let after = companion.told();
        let (count, mut values) = (companion.slopes().len(), vec![0.0; computed]);
        let (mut by_direction, mut lost) = (Vec::with_capacity(count), Vec::new());
        for direction in 0..count {
            if let Err(error) = companion.outputs(direction, &mut values) {
                lost.push((direction, error));
                values.fill(f64::NAN);
            }
            by_direction.push(outputs.iter().map(|place| values[*place]).collect::<Vec<_>>());
        }
        let slopes = companion.slopes();
        // What has no slope is left out: whoever asks for it finds it missing.
        let is_lost = |direction: usize| lost.iter().any(|(column, _)| *column == direction);
        let has_slopes =
            |leaf: &usize| slopes.iter().enumerate().all(|(column, it)| is_lost(column) || !it.memory[*leaf].is_nan());
        let kept: Vec<usize> = (0..after.len()).filter(|leaf| !after[*leaf].is_side && has_slopes(leaf)).collect();
        let column = |(column, slopes): (usize, &Slopes)| -> Vec<f64> {
            let of_states = states.iter().map(|(_, place, _)| slopes.states[*place]);
            let own = of_states.chain(kept.iter().map(|leaf| slopes.memory[*leaf]));
            own.map(|slope| if is_lost(column) { f64::NAN } else { slope }).collect()
        };
        let columns: Vec<Vec<f64>> = slopes.iter().enumerate().map(column).collect();
        let (n, m) = (names.len(), names.len() + inputs);
        let rows = |columns: &[Vec<f64>], count: usize| -> Vec<Vec<f64>> {
            (0..count).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
        };
        let of_states = states.iter().map(|(.., name)| name.clone());
        let next_states: Vec<String> =
            of_states.chain(kept.iter().map(|leaf| format!("memory.{}", after[*leaf].name))).collect();
        let (next, out) = (next_states.len(), outputs.len());
        Self {
            states: names,
            next_states,
            a: rows(&columns[..n], next),
            b: rows(&columns[n..m], next),
            c: rows(&by_direction[..n], out),
            d: rows(&by_direction[n..m], out),
            p: rows(&columns[m..], next),
            q: rows(&by_direction[m..], out),
            lost,
        }
    }
}
