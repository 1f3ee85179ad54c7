//! One communication step as a linear map.

use std::collections::BTreeMap;

use super::NoDerivative;

/// Transition matrices of a communication step, exact through the events in it: rows are the results, columns the variables.
///
/// ```text
/// x+ = A*x + B*u + P*p        y = C*x + D*u + Q*p
/// ```
///
/// `x` are the continuous states and, behind them, the numbers that the memory keeps (`memory.friction.since`); `x+` are those at
/// the end of the step, whose memory may keep others. `u` is added to the inputs over the whole step, and `y` are the outputs
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

/// The continuous states that are integrated: their numbers and their names.
pub type States = Vec<(usize, String)>;

/// Derivatives after a step in one direction.
#[derive(Clone, Debug)]
pub struct Column {
    /// Slopes of the continuous states that are integrated.
    pub states: Vec<f64>,
    /// Slopes of the numbers of the memory that are told.
    pub memory: Vec<f64>,
    /// Slopes of the outputs.
    pub outputs: Result<Vec<f64>, NoDerivative>,
}

impl Column {
    /// The column of what acts on nothing, by the numbers of states, of numbers of the memory and of outputs.
    pub(crate) fn zero([states, memory, outputs]: [usize; 3]) -> Self {
        Self { states: vec![0.0; states], memory: vec![0.0; memory], outputs: Ok(vec![0.0; outputs]) }
    }

    /// The columns of several things that vary together, each with a slope of its own, if all that comes out is 0 or one of these slopes.
    pub(crate) fn each(&self, own: impl ExactSizeIterator<Item = f64>) -> Option<Vec<Self>> {
        let Self { states, memory, outputs: Ok(outputs) } = self else { return None };
        let nothing = Self::zero([states.len(), memory.len(), outputs.len()]);
        let mut each = vec![nothing; own.len()];
        let places: BTreeMap<u64, usize> = own.map(f64::to_bits).zip(0..).collect();
        let rows = |column: &mut Self, row: usize| {
            let behind_states = row.checked_sub(column.states.len());
            let behind_memory = behind_states.and_then(|row| row.checked_sub(column.memory.len()));
            match (behind_states, behind_memory) {
                (None, _) => column.states[row] = 1.0,
                (Some(row), None) => column.memory[row] = 1.0,
                (_, Some(row)) => column.outputs.iter_mut().for_each(|outputs| outputs[row] = 1.0),
            }
        };
        for (row, slope) in states.iter().chain(memory).chain(outputs).enumerate().filter(|(_, slope)| **slope != 0.0) {
            rows(&mut each[*places.get(&slope.to_bits())?], row);
        }
        Some(each)
    }
}

impl Transition {
    /// The place of an output without a derivative in a direction that has one, as the reading of a sensor with a resolution.
    pub(crate) fn rounded(&self, mut matters: impl FnMut(usize) -> bool) -> Option<usize> {
        let is_lost = |column: &usize| self.lost.iter().any(|(lost, _)| lost == column);
        (0..self.c.len()).find(|output| {
            let row = self.c[*output].iter().chain(&self.d[*output]).chain(&self.q[*output]);
            matters(*output) && row.enumerate().any(|(column, slope)| slope.is_nan() && !is_lost(&column))
        })
    }

    /// The map of its columns: by states and numbers of the memory with names, by a number of inputs, and by parameters. At the end
    /// the states and numbers of the memory have other names.
    pub fn of(columns: Vec<Column>, [names, next]: [Vec<String>; 2], inputs: usize, outputs: usize) -> Self {
        let states = columns.first().map_or(0, |column| column.states.len());
        // Columns without a derivative are left out: a request for one finds it missing.
        let with_slopes = || columns.iter().filter(|column| column.outputs.is_ok());
        let has_slopes = |place: &usize| with_slopes().all(|column| !column.memory[*place].is_nan());
        let kept: Vec<usize> = (0..next.len() - states).filter(has_slopes).collect();
        let (of_states, of_memory) = next.split_at(states);
        let kept_names = kept.iter().map(|place| of_memory[*place].clone());
        let next_states: Vec<String> = of_states.iter().cloned().chain(kept_names).collect();
        let next_of = |column: &Column| -> Vec<f64> {
            if column.outputs.is_err() {
                return vec![f64::NAN; next_states.len()];
            }
            let of_memory = kept.iter().map(|place| column.memory[*place]);
            column.states.iter().copied().chain(of_memory).collect()
        };
        let next: Vec<Vec<f64>> = columns.iter().map(next_of).collect();
        let (mut shown, mut lost) = (Vec::with_capacity(columns.len()), Vec::new());
        for (place, column) in columns.into_iter().enumerate() {
            shown.push(column.outputs.unwrap_or_else(|why| {
                lost.push((place, why));
                vec![f64::NAN; outputs]
            }));
        }
        let (n, m, rows) = (names.len(), names.len() + inputs, next_states.len());
        let by_rows = |columns: &[Vec<f64>], count: usize| -> Vec<Vec<f64>> {
            (0..count).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
        };
        Self {
            states: names,
            next_states,
            a: by_rows(&next[..n], rows),
            b: by_rows(&next[n..m], rows),
            c: by_rows(&shown[..n], outputs),
            d: by_rows(&shown[n..m], outputs),
            p: by_rows(&next[m..], rows),
            q: by_rows(&shown[m..], outputs),
            lost,
        }
    }
}
