//! Arrays: parameters whose names differ in their last index alone.
//!
//! Computed variables with such names stay single: hosts count states by their variables.

use super::Variable;

/// The name of the array that a variable is an element of: `k` of `k[3]`; nothing if it is none.
pub fn array_name(name: &str) -> Option<&str> {
    parts(name).map(|(array, _)| array)
}

/// Part of a name before its last index, and the index.
fn parts(name: &str) -> Option<(&str, usize)> {
    let (array, index) = name.strip_suffix(']')?.rsplit_once('[')?;
    Some((array, index.parse().ok()?))
}

/// Number of elements of the array that begins with each variable: 1 without an array, 0 for further elements. On failure
/// the first element that does not follow the others, or differs in more than name, value reference, text, start value and
/// conditions.
pub(super) fn lengths(variables: &[Variable]) -> (Vec<usize>, Option<&Variable>) {
    let mut lengths = vec![1; variables.len()];
    let (mut first, mut stray) = (0, None);
    for (index, variable) in variables.iter().enumerate() {
        match parts(&variable.name) {
            Some((_, number)) if number > 1 && variable.is_parameter() => {
                if !follows(variable, &variables[first], index - first) {
                    stray.get_or_insert(variable);
                }
                lengths[index] = 0;
                lengths[first] += 1;
            }
            _ => first = index,
        }
    }
    (lengths, stray)
}

/// Whether a variable is the element at an offset from the first.
fn follows(variable: &Variable, first: &Variable, offset: usize) -> bool {
    let element = Variable {
        name: match parts(&first.name) {
            Some((array, 1)) => format!("{array}[{}]", offset + 1),
            _ => String::new(),
        },
        reference: first.reference.saturating_add(offset as u32),
        description: variable.description.clone(),
        start: variable.start,
        counts_where: variable.counts_where.clone(),
        ..first.clone()
    };
    element == *variable
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

    fn pair(change: impl FnOnce(&mut [Variable; 2])) -> (Vec<usize>, Option<String>) {
        let mut pair = Variable::parameter(7, "k", units::METRE, 1.0).array([1.0, 2.0]);
        change(&mut pair);
        let (lengths, stray) = lengths(&pair);
        (lengths, stray.map(|variable| variable.name.clone()))
    }

    #[test]
    fn elements_are_counted_at_the_first() {
        assert_eq!(pair(|_| ()), (vec![2, 0], None));
        assert_eq!(pair(|[_, second]| second.name = "other".to_owned()), (vec![1, 1], None));
        assert_eq!(pair(|pair| pair.iter_mut().for_each(|it| it.role = Role::Local)), (vec![1, 1], None));
    }

    #[test]
    fn elements_have_consecutive_references() {
        assert_eq!(pair(|[_, second]| second.reference += 1).1.as_deref(), Some("k[2]"));
    }

    #[test]
    fn elements_have_one_unit() {
        let (_, stray) = pair(|[_, second]| second.kind = crate::variables::Kind::Real(units::PASCAL));
        assert_eq!(stray.as_deref(), Some("k[2]"));
    }

    #[test]
    fn elements_begin_with_the_first() {
        assert_eq!(pair(|pair| pair.swap(0, 1)).1.as_deref(), Some("k[2]"));
    }
}
