//! The events of a contact, and their indicators.

use std::ops::{Index, IndexMut};

use crate::numbers::{Real, Scalar};
use crate::system::{Indicator, IndicatorSet, UNUSED};

/// Events that end a mode of a contact. A law uses those it [declares](super::FrictionLaw::events).
///
/// Of several at one instant the first in this order is handled first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Sliding ends or turns back. Indicator: speed in the direction of sliding, in m/s.
    Stop,
    /// The contact yields. Indicator: the force it holds beyond the present one, in N.
    BreakAway,
    /// The end of a distance is reached: of a deflection, of a loop, of a path. Indicator: the remaining distance, in m.
    Distance,
    /// The edge of a band of velocities is reached from inside. Indicator: the velocity left, in m/s.
    Edge,
    /// The applied force rises beyond what the present branch balances. Indicator: the reserve, in N.
    Rise,
    /// The applied force falls below what the present branch needs. Indicator: the excess, in N.
    Fall,
}

impl Event {
    /// All events, in the order of their indicators.
    pub const ALL: [Self; 6] = [Self::Stop, Self::BreakAway, Self::Distance, Self::Edge, Self::Rise, Self::Fall];

    /// Number of events.
    pub const COUNT: usize = Self::ALL.len();

    /// The indicators of a contact in a group of variables.
    pub fn indicators(group: &str) -> Vec<Indicator> {
        let indicators = Self::ALL.map(|event| {
            let (name, nominal, text) = event.description();
            Indicator { name: format!("{group}.{name}"), nominal, text }
        });
        indicators.to_vec()
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.description().0
    }

    fn description(self) -> (&'static str, f64, &'static str) {
        match self {
            Self::Stop => ("stop", 1e-2, "Sliding ends or turns back"),
            Self::BreakAway => ("breakAway", 10.0, "The contact yields"),
            Self::Distance => ("distance", 1e-5, "A deflection, a loop or a path is at its end"),
            Self::Edge => ("edge", 1e-4, "The velocity leaves the band that counts as rest"),
            Self::Rise => ("rise", 10.0, "The applied force rises beyond what the present branch balances"),
            Self::Fall => ("fall", 10.0, "The applied force falls below what the present branch needs"),
        }
    }
}

/// The event indicators of a contact, each in the place of its event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indicators<S = Real>([S; Event::COUNT]);

impl<S: Scalar> Default for Indicators<S> {
    /// None in use.
    fn default() -> Self {
        Self([S::of(UNUSED); Event::COUNT])
    }
}

impl<S: Scalar> Indicators<S> {
    /// The first event that is due.
    pub fn due(&self) -> Option<Event> {
        Event::ALL.into_iter().find(|event| self[*event].value() < 0.0)
    }
}

impl<S: Scalar> IndicatorSet<S> for Indicators<S> {
    fn unused() -> Self {
        Self::default()
    }
}

impl<S> Index<Event> for Indicators<S> {
    type Output = S;

    fn index(&self, event: Event) -> &S {
        &self.0[event as usize]
    }
}

impl<S> IndexMut<Event> for Indicators<S> {
    fn index_mut(&mut self, event: Event) -> &mut S {
        &mut self.0[event as usize]
    }
}

impl<S> AsMut<[S]> for Indicators<S> {
    fn as_mut(&mut self) -> &mut [S] {
        &mut self.0
    }
}

impl<S> AsRef<[S]> for Indicators<S> {
    fn as_ref(&self) -> &[S] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_event_has_its_own_place() {
        for (place, event) in Event::ALL.into_iter().enumerate() {
            let mut indicators = Indicators::<Real>::default();
            indicators[event] = Real::of(-1.0);
            assert_eq!(indicators.as_ref().iter().position(|number| number.value < 0.0), Some(place));
            assert_eq!(indicators.due(), Some(event));
        }
    }
}
