//! Switches at the cylinder that tell that the carriage is near an end of its stroke.

use serde::{Deserialize, Serialize};

use crate::parameter_group;
use crate::variables::{Condition, ParameterError, Variable, units};

/// Number of switches: one near position 0, one near the end of the stroke.
pub const COUNT: usize = 2;

parameter_group! {
    /// Two switches. Each is on from a distance to its end of the stroke on, and off again beyond that distance and the hysteresis.
    EndSwitches() {
        distances: [f64; COUNT] = Variable::parameter(1240, "sensor.endDistance", units::METRE, 0.0).range(0.0, 10.0).plausible(1e-5, 2.0).nominal(5e-3).shown_in("mm")
            .text("Distance from an end of the stroke within which its switch is on: [1] at position 0, [2] at the extended end; 0: no switch")
            .array([0.0; COUNT]);
        hysteresis: f64 = Variable::parameter(1242, "sensor.endHysteresis", units::METRE, 1e-3).range(0.0, 1.0).plausible(1e-6, 0.1).shown_in("mm")
            .counts_where(Condition::any_on(&["sensor.endDistance[1]", "sensor.endDistance[2]"]))
            .text("Hysteresis of the end switches: additional distance at which a switch turns off");
    }
}

/// Which of them are on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    is_on: [bool; COUNT],
}

impl EndSwitches {
    /// The switches as outputs.
    pub fn outputs(position: u32) -> [Variable; COUNT] {
        [1, 2].map(|number: u32| {
            let end = ["position 0", "the stroke"][number as usize - 1];
            let switch = Variable::flag(116 + number, &format!("sensor.end[{number}]"))
                .depends_on(&[position])
                .counts_with(&format!("sensor.endDistance[{number}]"));
            switch.text(&format!("True while the switch near {end} is on"))
        })
    }

    /// Whether there is any.
    pub fn are_used(&self) -> bool {
        self.distances.iter().any(|distance| *distance > 0.0)
    }

    /// Refuses switches beyond the stroke in m.
    ///
    /// # Errors
    /// [`ParameterError`] of the switch.
    pub fn check(&self, stroke: f64) -> Result<(), ParameterError> {
        let beyond = self.distances.iter().position(|distance| *distance > stroke);
        beyond.map_or(Ok(()), |place| {
            let reason = format!("it must not exceed cylinder.stroke = {stroke}");
            Err(ParameterError::new(&format!("sensor.endDistance[{}]", place + 1), self.distances[place], &reason))
        })
    }

    /// Which are on at distances in m from both ends, given which were on.
    pub fn after(&self, lengths: [f64; COUNT], before: Memory) -> Memory {
        let is_on = |switch: usize| {
            let distance = self.distances[switch];
            let reach = if before.is_on[switch] { distance + self.hysteresis } else { distance };
            distance > 0.0 && lengths[switch] <= reach
        };
        Memory { is_on: std::array::from_fn(is_on) }
    }

    /// Length in m that changes its sign where a switch turns, at a distance in m from its end; none without the switch.
    pub fn kink(&self, switch: usize, length: f64) -> Option<f64> {
        let (on, width) = (length - self.distances[switch], self.hysteresis);
        let turns = if width > 0.0 { on * (1.0 - on / width) } else { -on };
        (self.distances[switch] > 0.0).then_some(turns)
    }
}

impl Memory {
    /// 1 for each that is on, else 0.
    pub fn readings(self) -> [f64; COUNT] {
        self.is_on.map(f64::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SWITCHES: EndSwitches = EndSwitches { distances: [5e-3, 0.0], hysteresis: 1e-3 };

    /// On at 5 mm, off at 6 mm; one that is not there is never on.
    #[test]
    fn switch_turns_on_and_off_at_two_places() {
        let mut memory = Memory::default();
        let course = [0.1, 5.1e-3, 4.9e-3, 5.9e-3, 6.1e-3, 5.5e-3, 5e-3].map(|length| {
            memory = SWITCHES.after([length, 0.0], memory);
            memory.readings()
        });
        assert_eq!(course, [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0].map(|first| [first, 0.0]));
    }

    #[test]
    fn kink_changes_sign_where_the_switch_may_turn() {
        let signs = [4.9e-3, 5.1e-3, 5.9e-3, 6.1e-3].map(|length| SWITCHES.kink(0, length).map(f64::signum));
        assert_eq!(signs, [Some(-1.0), Some(1.0), Some(1.0), Some(-1.0)]);
        assert_eq!(SWITCHES.kink(1, 0.0), None);
    }
}
