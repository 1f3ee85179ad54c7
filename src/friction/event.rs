//! The events of a contact, and their indicators.

use std::ops::{Index, IndexMut};

use crate::system::{Indicator, UNUSED};

/// What can end a mode of a contact. A law uses those it [declares](super::FrictionLaw::events).
///
/// Of several at one instant the first in this order is handled first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Sliding ends or turns back. Indicator: speed in the direction of sliding, in m/s.
    Stop,
    /// The contact yields. Indicator: the force it holds beyond the present one, in N.
    BreakAway,
    /// The end of a distance is reached: of a deflection, of a loop, of a path. Indicator: what is left, in m.
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

    /// How many there are.
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
pub struct Indicators([f64; Event::COUNT]);

impl Default for Indicators {
    /// None in use.
    fn default() -> Self {
        Self([UNUSED; Event::COUNT])
    }
}

impl Indicators {
    /// The first event that is due.
    pub fn due(&self) -> Option<Event> {
        Event::ALL.into_iter().find(|event| self[*event] < 0.0)
    }
}

impl Index<Event> for Indicators {
    type Output = f64;

    fn index(&self, event: Event) -> &f64 {
        &self.0[event as usize]
    }
}

impl IndexMut<Event> for Indicators {
    fn index_mut(&mut self, event: Event) -> &mut f64 {
        &mut self.0[event as usize]
    }
}

impl AsMut<[f64]> for Indicators {
    fn as_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

impl AsRef<[f64]> for Indicators {
    fn as_ref(&self) -> &[f64] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_event_has_its_own_place() {
        for (place, event) in Event::ALL.into_iter().enumerate() {
            let mut indicators = Indicators::default();
            indicators[event] = -1.0;
            assert_eq!(indicators.as_ref().iter().position(|value| *value < 0.0), Some(place));
            assert_eq!(indicators.due(), Some(event));
        }
    }
}
