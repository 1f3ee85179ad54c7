//! Calls that set and get values and derivatives.

use std::ffi::c_int;

use pneumatic_servo::variables::{Kind, Role, Variable};

use crate::common::{ERROR, OK, is_input, is_real, is_real_input};
use crate::fuzzer::Fuzzer;
use crate::reference::{directional, find, is_computed_real, place};
use crate::{limit, variables};

impl Fuzzer {
    /// References, mostly of variables of a kind, and values for them.
    fn assignment(&mut self, usual: impl Fn(&Variable) -> bool) -> (Vec<u32>, Vec<f64>) {
        let usual: Vec<_> = variables().iter().filter(|variable| usual(variable)).collect();
        let random = &mut self.random;
        let count = 1 + random.below(3);
        let choose = |_| match random.below(16) {
            0 => (random.next() as u32, 1.0),
            1 => (variables()[random.below(variables().len())].reference, random.number()),
            _ => {
                let variable = usual[random.below(usual.len())];
                (variable.reference, random.value_for(variable))
            }
        };
        (0..count).map(choose).unzip()
    }

    pub fn set_reals(&mut self, index: usize) -> bool {
        let only_inputs = self.random.one_in(2);
        let (references, values) = self.assignment(|variable| {
            is_real(variable) && (is_input(variable) || (variable.is_parameter() && !only_inputs))
        });
        let pair = &mut self.pairs[index];
        let legal = pair.set(&references, &values, is_real);
        let actual = pair.instance.set_real(&references, &values);
        self.compare(format!("{index}: set {references:?} {values:?}"), if legal { OK } else { ERROR }, actual);
        !legal
    }

    pub fn set_integers(&mut self, index: usize) -> bool {
        let limit = limit().reference;
        let is_integer = |variable: &Variable| {
            matches!(variable.kind, Kind::Integer | Kind::Enumeration(_)) && variable.reference != limit
        };
        let (references, values) = self.assignment(|variable| is_integer(variable) && variable.is_parameter());
        let values: Vec<_> = values.into_iter().map(|value| value as c_int).collect();
        let pair = &mut self.pairs[index];
        let legal = !references.contains(&limit)
            && pair.set(&references, &values.iter().map(|value| f64::from(*value)).collect::<Vec<_>>(), is_integer);
        if references.contains(&limit) {
            return false;
        }
        let actual = pair.instance.set_integer(&references, &values);
        self.compare(format!("{index}: set {references:?} {values:?}"), if legal { OK } else { ERROR }, actual);
        !legal
    }

    pub fn set_booleans(&mut self, index: usize) -> bool {
        let is_boolean = |variable: &Variable| variable.kind == Kind::Boolean;
        let is_settable = |variable: &Variable| is_boolean(variable) && !variable.is_computed();
        if !variables().iter().any(is_settable) {
            return false;
        }
        let (references, values) = self.assignment(is_settable);
        let values: Vec<_> = values.into_iter().map(|value| value as c_int).collect();
        let pair = &mut self.pairs[index];
        let legal =
            pair.set(&references, &values.iter().map(|value| f64::from(*value)).collect::<Vec<_>>(), is_boolean);
        let actual = pair.instance.set_boolean(&references, &values);
        self.compare(format!("{index}: choose {references:?} {values:?}"), if legal { OK } else { ERROR }, actual);
        !legal
    }

    pub fn set_slopes(&mut self, index: usize) -> bool {
        let (references, values) = self.assignment(is_real_input);
        let order = if self.random.one_in(10) { self.random.below(4) as c_int - 1 } else { 1 };
        let pair = &mut self.pairs[index];
        let is_legal =
            |(reference, value): (&u32, &f64)| find(*reference).is_some_and(is_real_input) && value.is_finite();
        let legal = "IMC".contains(pair.expected.state) && order == 1 && references.iter().zip(&values).all(is_legal);
        if legal {
            for (reference, value) in references.iter().zip(&values) {
                pair.expected.slopes[place(find(*reference).expect("an input"), is_input)] = *value;
            }
        }
        let actual = pair.instance.set_input_derivatives(&references, &vec![order; references.len()], &values);
        self.compare(format!("{index}: slopes {references:?} {values:?}"), if legal { OK } else { ERROR }, actual);
        !legal
    }

    pub fn get_reals(&mut self, index: usize) -> bool {
        let (references, _) = self.assignment(is_real);
        let pair = &mut self.pairs[index];
        let found: Vec<_> = references.iter().map(|reference| find(*reference).filter(|it| is_real(it))).collect();
        let expected: Option<Vec<f64>> = found.into_iter().map(|variable| pair.value(variable?)).collect();
        let untouched = vec![-7.5; references.len()];
        let mut values = untouched.clone();
        let actual = pair.instance.get_real(&references, &mut values);
        let is_legal = expected.is_some();
        let wanted = expected.unwrap_or(untouched);
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&values), bits(&wanted), "seed {}: {references:?}", self.seed);
        self.compare(format!("{index}: get {references:?}"), if is_legal { OK } else { ERROR }, actual);
        !is_legal
    }

    pub fn directional(&mut self, index: usize) -> bool {
        let (unknowns, _) = self.assignment(is_computed_real);
        let (knowns, seeds) = self.assignment(|variable| {
            is_real_input(variable)
                || variable.role == Role::Time
                || variables().iter().any(|other| other.derivative_of == Some(variable.reference))
        });
        let pair = &mut self.pairs[index];
        let expected = directional(pair, &unknowns, &knowns, &seeds);
        let untouched = vec![-7.5; unknowns.len()];
        let mut values = untouched.clone();
        let actual = pair.instance.directional(&unknowns, &knowns, &seeds, &mut values);
        let is_legal = expected.is_some();
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&values), bits(&expected.unwrap_or(untouched)), "seed {}: {unknowns:?} {knowns:?}", self.seed);
        self.compare(format!("{index}: d {unknowns:?} / d {knowns:?}"), if is_legal { OK } else { ERROR }, actual);
        true
    }

    pub fn output_derivatives(&mut self, index: usize) -> bool {
        let is_output = |variable: &Variable| is_real(variable) && variable.role == Role::Output;
        let (references, _) = self.assignment(is_output);
        let pair = &mut self.pairs[index];
        let places: Option<Vec<_>> = references
            .iter()
            .map(|reference| Some(place(find(*reference).filter(|it| is_output(it))?, Variable::is_computed)))
            .collect();
        let expected = places.filter(|_| pair.expected.runs()).and_then(|places| {
            let mut rates = pair.computed()?;
            pair.simulation.as_ref()?.rates(&mut rates);
            places
                .into_iter()
                .map(|place| Some(rates[place]).filter(|rate| rate.is_finite()))
                .collect::<Option<Vec<_>>>()
        });
        let mut values = vec![-7.5; references.len()];
        let actual = pair.instance.output_derivatives(&references, &vec![1; references.len()], &mut values);
        let is_legal = expected.is_some();
        if let Some(expected) = expected {
            assert_eq!(values, expected, "seed {}", self.seed);
        }
        self.compare(format!("{index}: rates {references:?}"), if is_legal { OK } else { ERROR }, actual);
        true
    }
}
