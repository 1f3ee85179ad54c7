//! Slopes in a direction, and how they are added up.

use super::NoDerivative;

/// Slopes in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Slopes {
    /// Of the states.
    pub states: Vec<f64>,
    /// Of the numbers of the memory; not a number where there is no derivative.
    pub memory: Vec<f64>,
    /// The largest the states have had so far.
    pub peaks: Vec<f64>,
    /// Where they end.
    pub lost: Option<NoDerivative>,
}

impl Slopes {
    /// Slopes of states and of the numbers of a memory, from here on.
    pub fn new(states: Vec<f64>, memory: Vec<f64>) -> Self {
        Self { peaks: states.iter().map(|slope| slope.abs()).collect(), states, memory, lost: None }
    }
}

/// Inputs that vary linearly from a time on.
#[derive(Clone, Debug)]
pub struct Driven {
    /// That time in s.
    pub since: f64,
    /// Their values then.
    pub values: Vec<f64>,
    /// Their slopes.
    pub slopes: Vec<f64>,
}

impl Driven {
    pub(super) fn at(&self, time: f64) -> Vec<f64> {
        let at =
            |(value, slope): (&f64, &f64)| if *slope == 0.0 { *value } else { value + slope * (time - self.since) };
        self.values.iter().zip(&self.slopes).map(at).collect()
    }

    pub(super) fn vary(&self) -> bool {
        self.slopes.iter().any(|slope| *slope != 0.0)
    }
}

/// Numbers with others added.
pub(super) fn add(sum: &mut [f64], others: Option<Vec<f64>>) {
    for (slot, other) in sum.iter_mut().zip(others.into_iter().flatten()) {
        *slot += other;
    }
}

/// Numbers moved by a share of slopes; all of them where there are no slopes.
pub(super) fn along(numbers: &[f64], slopes: &[f64], share: f64) -> Vec<f64> {
    let mut moved = numbers.to_vec();
    moved.iter_mut().zip(slopes).for_each(|(number, slope)| *number += share * slope);
    moved
}

/// The derivative of numbers between two evaluations.
pub(super) fn slope_between(above: &[f64], below: &[f64], distance: f64) -> Vec<f64> {
    above.iter().zip(below).map(|(above, below)| (above - below) / distance).collect()
}

/// Whether any number is one.
pub(super) fn any(numbers: &[f64]) -> bool {
    numbers.iter().any(|number| *number != 0.0)
}

#[cfg(test)]
mod tests {
    use super::Driven;

    /// `2 + 0.5*t` and a constant 3, from 1 s on.
    #[test]
    fn driven_inputs_follow_their_lines() {
        let driven = Driven { since: 1.0, values: vec![2.0, 3.0], slopes: vec![0.5, 0.0] };
        assert_eq!((driven.at(1.0), driven.at(5.0)), (vec![2.0, 3.0], vec![4.0, 3.0]));
        assert!(driven.vary() && !Driven { slopes: vec![0.0; 2], ..driven }.vary());
    }
}
