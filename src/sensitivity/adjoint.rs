//! The chain of transitions, backwards and forwards.

use super::{NoDerivative, Transition, TransitionError};

/// Gradient of a scalar of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gradient {
    /// By an addition to each input over each step: by step and input, in the unit of the scalar per unit.
    pub inputs: Vec<Vec<f64>>,
    /// By the states at the start, by their names, and by the numbers of the memory (`memory.friction.since`). On the way
    /// back these are the states at a point of the run.
    pub states: Vec<(String, f64)>,
    /// By each parameter.
    pub parameters: Vec<f64>,
}

impl Gradient {
    /// A zero gradient, at the end of a run.
    pub fn new(steps: usize, inputs: usize, parameters: usize) -> Self {
        Self { inputs: vec![vec![0.0; inputs]; steps], states: Vec::new(), parameters: vec![0.0; parameters] }
    }

    /// Goes back over a step that begins at a time in s, of outputs with weights at its end.
    ///
    /// # Errors
    /// [`TransitionError::NoDerivative`] where the scalar depends on a number of the memory that has no slope.
    pub fn go_back(
        &mut self,
        step: usize,
        time: f64,
        transition: &Transition,
        weights: &[f64],
    ) -> Result<(), TransitionError> {
        let behind = self.weights_of(&transition.next_states, time)?;
        let Transition { a, b, c, d, p, q, states, .. } = transition;
        let states_before = states
            .iter()
            .enumerate()
            .map(|(column, name)| (name.clone(), weighted(a, &behind, column) + weighted(c, weights, column)));
        let before: Vec<(String, f64)> = states_before.collect();
        for (column, slot) in self.inputs[step].iter_mut().enumerate() {
            *slot += weighted(b, &behind, column) + weighted(d, weights, column);
        }
        for (column, slot) in self.parameters.iter_mut().enumerate() {
            *slot += weighted(p, &behind, column) + weighted(q, weights, column);
        }
        self.states = before;
        Ok(())
    }

    /// Arrives at the begin, where outputs have weights, and states depend on the first inputs and on parameters: a column for each.
    ///
    /// # Errors
    /// As [`go_back`](Self::go_back).
    pub fn begin(
        &mut self,
        time: f64,
        here: &Transition,
        of_start: &[Vec<(String, f64)>],
        weights: &[f64],
    ) -> Result<(), TransitionError> {
        let behind = self.weights_of(&here.states, time)?;
        let own = behind.iter().enumerate().map(|(column, weight)| weight + weighted(&here.c, weights, column));
        self.states = here.states.iter().cloned().zip(own).collect();
        for (column, slot) in self.parameters.iter_mut().enumerate() {
            *slot += weighted(&here.q, weights, column);
        }
        let first = self.inputs.first_mut().into_iter().flatten();
        for (slot, start) in first.chain(&mut self.parameters).zip(of_start) {
            for (name, weight) in self.states.iter().filter(|(_, weight)| *weight != 0.0) {
                let slope = value_of(start, name);
                *slot += if slope == 0.0 { 0.0 } else { weight * slope };
            }
        }
        Ok(())
    }

    /// The weights of states by their names; of others there are none but 0.
    fn weights_of(&self, names: &[String], time: f64) -> Result<Vec<f64>, TransitionError> {
        if are_same(&self.states, names) {
            return Ok(self.states.iter().map(|(_, weight)| *weight).collect());
        }
        let is_lost = |(name, weight): &&(String, f64)| *weight != 0.0 && !weight.is_nan() && !names.contains(name);
        if let Some((name, _)) = self.states.iter().find(is_lost) {
            let reason = "what follows depends on it, and it has no slope".to_owned();
            return Err(TransitionError::NoDerivative(NoDerivative { time, event: name.clone(), reason }));
        }
        Ok(values_of(&self.states, names))
    }
}

/// The chain of transitions forwards: slopes of states along a direction, by their names.
#[derive(Clone, Debug)]
pub struct Tangents {
    states: Vec<(String, f64)>,
}

impl Tangents {
    /// Begins with those that come from columns times seeds.
    pub fn begin(of_start: &[Vec<(String, f64)>], seeds: &[f64]) -> Self {
        let names = of_start.first().into_iter().flatten().map(|(name, _)| name);
        let slope = |name: &String| of_start.iter().zip(seeds).map(|(start, seed)| seed * value_of(start, name)).sum();
        Self { states: names.map(|name| (name.clone(), slope(name))).collect() }
    }

    /// Checks that all states of a step that begins at a time in s have slopes.
    ///
    /// # Errors
    /// [`TransitionError::NoDerivative`] where the scalar depends on a number of the memory that has none.
    pub fn check(&self, transition: &Transition, time: f64) -> Result<(), TransitionError> {
        let Transition { states, a, c, .. } = transition;
        let matters = |column: usize| a.iter().chain(c).any(|row| row[column] != 0.0);
        if are_same(&self.states, states) {
            return Ok(());
        }
        let is_lost =
            |(column, name): &(usize, &String)| self.states.iter().all(|(other, _)| other != *name) && matters(*column);
        let Some((_, name)) = states.iter().enumerate().find(is_lost) else { return Ok(()) };
        let reason = "what follows depends on it, and it has no slope".to_owned();
        Err(TransitionError::NoDerivative(NoDerivative { time, event: name.clone(), reason }))
    }

    /// The outputs at the end of a step.
    pub fn outputs(&self, transition: &Transition, inputs: &[f64], parameters: &[f64]) -> Vec<f64> {
        self.rows([&transition.c, &transition.d, &transition.q], transition, inputs, parameters)
    }

    /// Goes on over a step.
    pub fn go_on(&mut self, transition: &Transition, inputs: &[f64], parameters: &[f64]) {
        let next = self.rows([&transition.a, &transition.b, &transition.p], transition, inputs, parameters);
        self.states = transition.next_states.iter().cloned().zip(next).collect();
    }

    fn rows(
        &self,
        [by_states, by_inputs, by_parameters]: [&[Vec<f64>]; 3],
        transition: &Transition,
        inputs: &[f64],
        parameters: &[f64],
    ) -> Vec<f64> {
        let states = values_of(&self.states, &transition.states);
        let product = |row: &[f64], factors: &[f64]| {
            let terms = row.iter().zip(factors).map(|(a, b)| if *a == 0.0 || *b == 0.0 { 0.0 } else { a * b });
            terms.sum::<f64>()
        };
        let rows = by_states.iter().zip(by_inputs).zip(by_parameters);
        rows.map(|((x, u), p)| product(x, &states) + product(u, inputs) + product(p, parameters)).collect()
    }
}

/// Whether numbers have these names, as they do but where the mode changes.
fn are_same(numbers: &[(String, f64)], names: &[String]) -> bool {
    numbers.len() == names.len() && numbers.iter().zip(names).all(|((own, _), name)| own == name)
}

/// The numbers of names; 0 where there is none.
fn values_of(numbers: &[(String, f64)], names: &[String]) -> Vec<f64> {
    if are_same(numbers, names) {
        return numbers.iter().map(|(_, value)| *value).collect();
    }
    names.iter().map(|name| value_of(numbers, name)).collect()
}

/// The number of a name; 0 if there is none.
fn value_of(numbers: &[(String, f64)], name: &str) -> f64 {
    numbers.iter().find(|(other, _)| other == name).map_or(0.0, |(_, value)| *value)
}

/// The sum of the entries of a column, each with the weight of its row.
fn weighted(rows: &[Vec<f64>], weights: &[f64], column: usize) -> f64 {
    // Terms without a lost derivative stay exact.
    let term = |(row, weight): (&Vec<f64>, &f64)| {
        if *weight == 0.0 || row[column] == 0.0 { 0.0 } else { weight * row[column] }
    };
    rows.iter().zip(weights).map(term).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(all: &[&str]) -> Vec<String> {
        all.iter().map(|name| (*name).to_owned()).collect()
    }

    /// x+ = 2 x + 3 u + 5 p and y = 7 x + 11 u + 13 p, and a state that has no slope and that nothing depends on.
    fn transition() -> Transition {
        Transition {
            states: names(&["x", "lost"]),
            next_states: names(&["x"]),
            a: vec![vec![2.0, 0.0]],
            b: vec![vec![3.0]],
            c: vec![vec![7.0, 0.0]],
            d: vec![vec![11.0]],
            p: vec![vec![5.0]],
            q: vec![vec![13.0]],
            lost: Vec::new(),
        }
    }

    /// By hand: y1 + 10 y2 = 147 x0 + 221 u0 + 110 u1 + 493 p; and 100 (x0 + 2 p), where x0 = 4 u0 + 6 p.
    #[test]
    fn slopes_of_two_steps_are_those_by_hand_backwards() -> Result<(), TransitionError> {
        let mut gradient = Gradient::new(2, 1, 1);
        gradient.go_back(1, 0.1, &transition(), &[10.0])?;
        gradient.go_back(0, 0.0, &transition(), &[1.0])?;
        assert_eq!(gradient.states, [("x".to_owned(), 147.0), ("lost".to_owned(), 0.0)]);
        assert_eq!((&gradient.inputs, &gradient.parameters), (&vec![vec![221.0], vec![110.0]], &vec![493.0]));
        let here = Transition { c: vec![vec![1.0, 0.0]], q: vec![vec![2.0]], ..transition() };
        let of_start = [4.0, 6.0].map(|slope| vec![("x".to_owned(), slope)]);
        gradient.begin(0.0, &here, &of_start, &[100.0])?;
        assert_eq!(gradient.states[0], ("x".to_owned(), 247.0));
        let (first, parameter) = (221.0 + 4.0 * 247.0, 493.0 + 200.0 + 6.0 * 247.0);
        assert_eq!((gradient.inputs, gradient.parameters), (vec![vec![first], vec![110.0]], vec![parameter]));
        Ok(())
    }

    #[test]
    fn slopes_of_two_steps_are_those_by_hand_forwards() {
        let of_start = [4.0, 6.0].map(|slope| vec![("x".to_owned(), slope)]);
        // x0 = 4 + 6 / 2, y1 = 7 x0 + 11 + 13 / 2, x1 = 2 x0 + 3 + 5 / 2.
        let mut tangents = Tangents::begin(&of_start, &[1.0, 0.5]);
        assert_eq!(tangents.outputs(&transition(), &[1.0], &[0.5]), [66.5]);
        tangents.go_on(&transition(), &[1.0], &[0.5]);
        assert_eq!(tangents.outputs(&transition(), &[0.0], &[0.0]), [7.0 * 19.5]);
    }

    #[test]
    fn state_without_a_slope_is_missed_only_by_what_depends_on_it() -> Result<(), TransitionError> {
        let depending = Transition { a: vec![vec![2.0, 1.0]], ..transition() };
        let tangents = Tangents::begin(&[vec![("x".to_owned(), 1.0)]], &[1.0]);
        tangents.check(&transition(), 0.0)?;
        let problem = tangents.check(&depending, 0.25).expect_err("a state without a slope");
        assert!(problem.to_string().contains("lost") && problem.to_string().contains("0.25"), "{problem}");
        let mut gradient = Gradient::new(3, 1, 1);
        gradient.go_back(2, 0.75, &transition(), &[10.0])?;
        gradient.go_back(1, 0.5, &depending, &[0.0])?;
        let problem = gradient.go_back(0, 0.25, &transition(), &[1.0]).expect_err("a state without a slope");
        assert!(problem.to_string().contains("lost") && problem.to_string().contains("0.25"), "{problem}");
        Ok(())
    }

    #[test]
    fn entry_that_is_no_number_spoils_only_what_has_a_weight() -> Result<(), TransitionError> {
        let nowhere = Transition { c: vec![vec![f64::NAN, 0.0]], ..transition() };
        let mut gradient = Gradient::new(1, 1, 1);
        gradient.go_back(0, 0.0, &nowhere, &[0.0])?;
        assert_eq!(gradient.states[0].1, 0.0);
        gradient.go_back(0, 0.0, &nowhere, &[1.0])?;
        assert!(gradient.states[0].1.is_nan());
        Ok(())
    }
}
