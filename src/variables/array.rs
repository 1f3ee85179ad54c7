//! Arrays: parameters whose names differ in their last index alone.
//!
//! Computed variables with such names stay single: hosts count states by their variables.

use super::Variable;

/// The name of the array that a variable is an element of: `k` of `k[3]`; nothing if it is none.
pub fn array_name(name: &str) -> Option<&str> {
    parts(name).map(|(array, _)| array)
}

/// What comes before the last index of a name, and the index.
fn parts(name: &str) -> Option<(&str, usize)> {
    let (array, index) = name.strip_suffix(']')?.rsplit_once('[')?;
    Some((array, index.parse().ok()?))
}

/// How many elements the array has that begins with each variable: 1 if it is no array, 0 for further elements.
///
/// # Panics
/// If elements of an array do not follow each other, or differ in anything but name, value reference, text and start value.
pub(super) fn lengths(variables: &[Variable]) -> Vec<usize> {
    let mut lengths = vec![1; variables.len()];
    let mut first = 0;
    for (index, variable) in variables.iter().enumerate() {
        match parts(&variable.name) {
            Some((_, number)) if number > 1 && variable.is_parameter() => {
                assert_follows(variable, &variables[first], index - first);
                lengths[index] = 0;
                lengths[first] += 1;
            }
            _ => first = index,
        }
    }
    lengths
}

fn assert_follows(variable: &Variable, first: &Variable, offset: usize) {
    let element = Variable {
        name: match parts(&first.name) {
            Some((array, 1)) => format!("{array}[{}]", offset + 1),
            _ => String::new(),
        },
        reference: first.reference + offset as u32,
        description: variable.description.clone(),
        start: variable.start,
        ..first.clone()
    };
    assert!(element == *variable, "{} does not follow the other elements of its array", variable.name);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::{Role, units};

    #[test]
    fn last_index_makes_an_element() {
        assert_eq!(array_name("friction.gms.k[10]"), Some("friction.gms.k"));
        assert_eq!(["position", "trolley[2].position", "der(z[3])"].map(array_name), [None, None, None]);
    }

    fn pair(change: impl FnOnce(&mut [Variable; 2])) -> Vec<usize> {
        let mut pair = Variable::parameter(7, "k", units::METRE, 1.0).array([1.0, 2.0]);
        change(&mut pair);
        lengths(&pair)
    }

    #[test]
    fn elements_are_counted_at_the_first() {
        assert_eq!(pair(|_| ()), [2, 0]);
        assert_eq!(pair(|[_, second]| second.name = "other".to_owned()), [1, 1]);
        assert_eq!(pair(|pair| pair.iter_mut().for_each(|it| it.role = Role::Local)), [1, 1]);
    }

    #[test]
    #[should_panic(expected = "k[2] does not follow")]
    fn elements_have_consecutive_references() {
        pair(|[_, second]| second.reference += 1);
    }

    #[test]
    #[should_panic(expected = "k[2] does not follow")]
    fn elements_have_one_unit() {
        pair(|[_, second]| second.kind = crate::variables::Kind::Real(units::PASCAL));
    }
}
