//! One communication step as a linear map.

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
    /// The names of the numbers that the memory keeps, with their slopes.
    pub memory: Vec<(String, f64)>,
    /// Slopes of the outputs.
    pub outputs: Result<Vec<f64>, NoDerivative>,
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

    /// The map of its columns: by states and numbers of the memory with names, by a number of inputs, and by parameters.
    pub fn of(columns: Vec<Column>, states: &States, names: Vec<String>, inputs: usize, outputs: usize) -> Self {
        let memory: Vec<String> =
            columns.first().into_iter().flat_map(|column| &column.memory).map(|(name, _)| name.clone()).collect();
        // Columns without a derivative are left out: a request for one finds it missing.
        let with_slopes = || columns.iter().filter(|column| column.outputs.is_ok());
        let has_slopes = |place: &usize| with_slopes().all(|column| !column.memory[*place].1.is_nan());
        let kept: Vec<usize> = (0..memory.len()).filter(has_slopes).collect();
        let next_states: Vec<String> = states
            .iter()
            .map(|(_, name)| name.clone())
            .chain(kept.iter().map(|place| format!("memory.{}", memory[*place])))
            .collect();
        let next_of = |column: &Column| -> Vec<f64> {
            if column.outputs.is_err() {
                return vec![f64::NAN; next_states.len()];
            }
            let of_memory = kept.iter().map(|place| column.memory[*place].1);
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
