//! Events: the end of a mode of a model.

use super::System;
use crate::numbers::Real;
use crate::system::Indicator;

/// An event of a model, in words. Its index is its [indicator](System::indicators)'s; [`System::switch`] is its effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Its name, in the group of the part that it belongs to: `wheel.locks` for example.
    pub name: &'static str,
    /// Effect of the event, in words.
    pub text: &'static str,
    /// Magnitude of the indicator, in its own unit, that counts as 1 where indicators are compared.
    pub nominal: f64,
}

impl Event {
    /// Description of its indicator for a host.
    pub fn indicator(&self) -> Indicator {
        Indicator { name: self.name.to_owned(), nominal: self.nominal, text: self.text }
    }
}

/// Refuses, when a model is compiled, events that do not say what they must, or have no place among the indicators.
pub(crate) const fn assert_sound<E: System<U>, const U: usize>() {
    let events = E::EVENTS;
    let mut index = 0;
    while index < events.len() {
        let event = &events[index];
        assert!(!event.name.is_empty(), "an event has no name");
        assert!(!event.text.is_empty(), "an event does not say in words what happens");
        assert!(event.nominal > 0.0 && event.nominal < f64::INFINITY, "the nominal of an event is no positive number");
        let mut other = 0;
        while other < index {
            assert!(!is_same(events[other].name, event.name), "two events have the same name");
            other += 1;
        }
        index += 1;
    }
    let indicators = size_of::<E::Indicators<Real>>() / size_of::<f64>();
    assert!(events.len() <= indicators, "there must be as many indicators as events");
}

/// Whether two texts are the same.
const fn is_same(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut same = one.len() == other.len();
    let mut index = 0;
    while same && index < one.len() {
        same = one[index] == other[index];
        index += 1;
    }
    same
}
