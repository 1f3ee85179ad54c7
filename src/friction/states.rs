//! The continuous states of a contact as variables of a model.
//!
//! A law has at most one deflection, or the forces of up to ten elements, or states that it names: each kind has variables of
//! its own, so that all have a unit. Those that the chosen law does not have stay 0.

use super::law::{FrictionLaw, MAX_STATES, NamedState, StateKind};
use crate::numbers::Scalar;
use crate::variables::{Unit, Variable, units};

/// Variables of one kind: the states and, `RATES` behind them, their rates.
struct Kind {
    kind: StateKind,
    /// Value reference of the first state, counted from the contact's.
    first: u32,
    name: &'static str,
    count: u32,
    units: [Unit; 2],
    text: &'static str,
}

/// Distance of the value references of a state and its rate.
const RATES: u32 = 10;

/// Value references that a contact takes.
pub const REFERENCES: u32 = 40;

const KINDS: [Kind; 2] = [
    Kind {
        kind: StateKind::Deflection,
        first: 0,
        name: "deflection",
        count: StateKind::Deflection.most() as u32,
        units: [units::METRE, units::METRE_PER_SECOND],
        text: "Mean deflection of the bristles of the friction law (law Bristle follows each of its bonds instead)",
    },
    Kind {
        kind: StateKind::Force,
        first: 20,
        name: "elementForce",
        count: StateKind::Force.most() as u32,
        units: [units::NEWTON, units::NEWTON_PER_SECOND],
        text: "Force of an element of the friction law (GMS and BlimanSorine)",
    },
];

impl Kind {
    /// Name of a state in a group.
    fn name(&self, group: &str, number: u32) -> String {
        let index = if self.count == 1 { String::new() } else { format!("[{}]", number + 1) };
        format!("{group}.{}{index}", self.name)
    }
}

/// Number of the variables of a contact: its states and their rates.
pub const fn computed<L: FrictionLaw>() -> usize {
    assert!(L::NAMED <= MOST_NAMED, "the laws of a catalogue name more states than there are value references");
    2 * ((KINDS[0].count + KINDS[1].count) as usize + L::NAMED)
}

/// Value reference of a named state of a contact, whose other variables count from `base`, by its place among the named states
/// of all laws of the catalogue; the rate has the next reference. The contact at
/// [`references::CONTACT`](crate::system::references::CONTACT) has the references from 60 000 on, and each of [`REFERENCES`] has a
/// thousand.
const fn named(base: u32, place: u32) -> u32 {
    25 * (base + 1_940) + 2 * place
}

/// Largest number of named states of all laws of a catalogue.
const MOST_NAMED: usize = 500;

/// Value references of the states of a contact that laws do not name, whose variables count from `base`.
pub fn references(base: u32) -> Vec<u32> {
    KINDS.iter().flat_map(|kind| (0..kind.count).map(move |number| base + kind.first + number)).collect()
}

/// Value reference of the deflection of a contact, whose variables count from `base`.
pub const fn deflection(base: u32) -> u32 {
    base + KINDS[0].first
}

/// Number of the state of a law that a value reference counted from the contact's stands for.
pub fn number_of(kind: StateKind, reference: u32) -> Option<usize> {
    let own = KINDS.iter().find(|other| other.kind == kind)?;
    let number = reference.checked_sub(own.first)?;
    (number < own.count).then_some(number as usize)
}

/// The states of a contact in a group and their rates; value references from `base`. What velocity and load factor depend
/// on is listed: with the state itself, or all of its kind if the laws couple them, all that its rate does.
pub fn table<L: FrictionLaw>(group: &str, base: u32, [velocity, level]: [&[u32]; 2]) -> Vec<Variable> {
    let sliding = &[velocity, level].concat()[..];
    let not_named = KINDS.iter().flat_map(|kind| {
        let all = (0..kind.count).map(|number| base + kind.first + number).collect::<Vec<_>>();
        let own = move |state: u32| if L::couples_states() { all.clone() } else { vec![state] };
        let states = (0..kind.count).map(move |number| {
            let reference = base + kind.first + number;
            Variable::output(reference, &kind.name(group, number), kind.units[0])
                .local()
                .depends_on(&[reference])
                .text(&format!("{}; 0 if the law has none", kind.text))
        });
        let rates = (0..kind.count).map(move |number| {
            let state = base + kind.first + number;
            Variable::output(state + RATES, &format!("der({})", kind.name(group, number)), kind.units[1])
                .local()
                .derivative_of(state)
                .depends_on(&[sliding, &own(state)].concat())
                .text(&format!("Rate: {}", kind.text))
        });
        states.chain(rates)
    });
    let all = L::named_states("", 0);
    let states = all.iter().zip(0..).map(|(state, place)| {
        let reference = named(base, place);
        Variable::output(reference, &format!("{group}.{}", state.name), state.unit)
            .local()
            .depends_on(&[reference])
            .text(&format!("{}; 0 under other laws", state.text))
    });
    let rates = all.iter().zip(0..).map(|(state, place)| {
        let (reference, name) = (named(base, place), format!("der({group}.{})", state.name));
        let affects = |(other, at): &(&NamedState, u32)| *at == place || (state.is_coupled && other.law == state.law);
        let own = all.iter().zip(0..).filter(affects).map(|(_, place)| named(base, place)).collect::<Vec<_>>();
        Variable::output(reference + 1, &name, state.unit.per_second())
            .local()
            .derivative_of(reference)
            .depends_on(&[if state.is_alone { velocity } else { sliding }, &own].concat())
            .text(&format!("Rate: {}", state.text))
    });
    not_named.chain(states).chain(rates).collect()
}

/// Variables of a model of which those that depend on all other states of a contact depend on the named states of its laws, too.
pub fn completed<L: FrictionLaw>(variables: Vec<Variable>, base: u32) -> Vec<Variable> {
    let (others, named) = (references(base), (0..L::NAMED as u32).map(|place| named(base, place)).collect::<Vec<_>>());
    let complete = |variable: Variable| match &variable.depends_on {
        Some(known) if others.iter().all(|state| known.contains(state)) => {
            let all = [known, &named[..]].concat();
            variable.depends_on(&all)
        }
        _ => variable,
    };
    variables.into_iter().map(complete).collect()
}

/// Writes the values of these variables from the states of a kind and their rates, and returns the rest of the slots. The
/// named states of this law begin at a place among the named states of all laws.
pub fn write<S: Scalar>(
    of: StateKind,
    states_and_rates: [[S; MAX_STATES]; 2],
    named: Named,
    slots: &mut [S],
) -> &mut [S] {
    let mut rest = slots;
    for kind in KINDS {
        for values in states_and_rates {
            let (own, others) = rest.split_at_mut(kind.count as usize);
            own.fill(S::zero());
            if kind.kind == of {
                own.copy_from_slice(&values[..own.len()]);
            }
            rest = others;
        }
    }
    for values in states_and_rates {
        let (all, others) = rest.split_at_mut(named.all);
        all.fill(S::zero());
        all[named.first..][..named.own].copy_from_slice(&values[..named.own]);
        rest = others;
    }
    rest
}

/// The place of a law's named states among the named states of all laws of its catalogue.
#[derive(Clone, Copy, Debug, Default)]
pub struct Named {
    /// Place of the first one.
    first: usize,
    /// Number of named states of the law.
    own: usize,
    /// Number of named states of all laws.
    all: usize,
}

impl Named {
    /// The places of a law.
    pub fn of<L: FrictionLaw>(law: &L) -> Self {
        if L::NAMED == 0 {
            return Self::default();
        }
        let own = if law.state_kind() == StateKind::Named { law.states() } else { 0 };
        let first = L::named_states("", 0).iter().position(|state| state.law == law.id());
        Self { first: first.unwrap_or(0), own, all: L::NAMED }
    }

    /// Number of the named states of the law.
    pub fn own(self) -> usize {
        self.own
    }

    /// Number of the named state of the law that a value reference stands for in a contact, whose other variables count from `base`.
    pub fn number_of(self, base: u32, reference: u32) -> Option<usize> {
        let offset = reference.checked_sub(named(base, self.first as u32))? as usize;
        (offset.is_multiple_of(2) && offset / 2 < self.own).then_some(offset / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::{Friction, FrictionLaw, LAWS, Law};
    use crate::variables::{Choice, ParameterSet, Tunable};

    /// A law built from its defaults.
    fn default_law(law: Law) -> Friction {
        let table = Friction::table_within("", 0, law.id());
        let values: Vec<_> = table.iter().filter_map(|variable| variable.start).map(Tunable::still).collect();
        Friction::read(&values).expect("defaults that fit together")
    }

    #[test]
    fn every_state_of_every_law_has_a_variable() {
        let table = table::<Friction>("friction", 0, [&[], &[]]);
        for (id, name, _) in LAWS.items {
            let law = default_law(Law::from_id(f64::from(*id)).expect("an item"));
            let number = |reference: u32| match law.state_kind() {
                StateKind::Named => Named::of(&law).number_of(0, reference),
                kind => number_of(kind, reference),
            };
            let states = table.iter().filter(|variable| variable.derivative_of.is_none());
            let found = states.filter_map(|variable| number(variable.reference));
            let found: Vec<usize> = found.filter(|number| *number < law.states()).collect();
            assert_eq!(found, (0..law.states()).collect::<Vec<_>>(), "{name}");
        }
    }

    #[test]
    fn references_of_a_contact_stay_within_its_range() {
        let table = table::<Friction>("friction", 400, [&[], &[]]);
        let of_names = named(400, 0)..named(400 + REFERENCES, 0);
        let (of_laws, others): (Vec<_>, Vec<_>) =
            table.iter().partition(|variable| of_names.contains(&variable.reference));
        assert_eq!(of_laws.len(), 2 * Friction::NAMED);
        assert!(others.iter().all(|variable| (400..400 + REFERENCES).contains(&variable.reference)));
        let states: Vec<u32> = others.iter().filter_map(|variable| variable.derivative_of).collect();
        assert_eq!(states, references(400));
        assert_eq!(states[0], deflection(400));
        assert_eq!(table[0].name, "friction.deflection");
    }
}
