//! Which states of a cylinder with lines change which others, for its Jacobian.
//!
//! Air in a hose notices its neighbours alone. So hoses share their directions with each other, and with parts far away.

use std::ops::Range;

use super::cylinder::PneumaticServoCylinder;
use super::lines::{HOSE, STATES as LINES, VESSEL, VOLUMES};
use super::places::{MOST, PRESSURE_A, PRESSURE_B, TEMPERATURE_A, TEMPERATURE_B};
use super::states::State;
use crate::friction::FrictionLaw;
use crate::pneumatics::actuator::{Actuating, STATES};
use crate::pneumatics::hose::COLUMNS;
use crate::system::{Couplings, System};

const PRESSURE: [usize; 2] = [PRESSURE_A, PRESSURE_B];
const TEMPERATURE: [usize; 2] = [TEMPERATURE_A, TEMPERATURE_B];

/// Directions of the states of the actuator, of both pressures and both temperatures, of position and velocity.
const ACTUATOR: [u8; STATES] = [0, 1];
const PRESSURES: [u8; 2] = [2, 3];
const TEMPERATURES: [u8; 2] = [4, 5];
const MOTION: [u8; 2] = [6, 7];
/// Directions of the volumes of a hose, apart from the first, and of its columns.
const LATER_VOLUMES: [u8; VOLUMES - 1] = [9, 11, 0];
const LINE_COLUMNS: [u8; COLUMNS] = [8, 10, 8];
/// What flows through the valve changes the first volumes of both hoses and the vessel.
const FIRST_VOLUMES: [u8; 2] = MOTION;
const OF_VESSEL: u8 = 10;
/// Directions of the states of the friction law, which change nothing but themselves and the motion; the next one is that
/// of the sensors.
const REST: [u8; 11] = [0, 1, 4, 5, 8, 9, 10, 11, 12, 13, 14];

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Whether lines or sensors have states.
    pub(super) fn has_attachments(&self) -> bool {
        EXTENDED && (self.lines.are_used() || self.sensors.states() > 0)
    }

    /// The couplings of a cylinder among as many states as it has.
    pub(super) fn found_couplings(&self) -> Couplings<MOST> {
        let n = self.states();
        let lines = self.indices_of_lines(n);
        Couplings { direction: self.directions(n, &lines), rates: self.dependencies(n, &lines) }
    }

    /// The same among those of a run.
    pub(super) fn couplings<const N: usize>(&self) -> Couplings<N> {
        self.couplings.among(self.states(), State::FRICTION + self.friction.count())
    }

    /// The indices of the states of the lines, where they are integrated.
    fn indices_of_lines(&self, n: usize) -> [Option<usize>; LINES] {
        let mut indices = [None; LINES];
        self.places_of_lines(n).for_each(|(place, index)| indices[place] = Some(index));
        indices
    }

    fn directions(&self, n: usize, lines: &[Option<usize>; LINES]) -> [u8; MOST] {
        let mut direction = [0; MOST];
        direction[..STATES].copy_from_slice(&ACTUATOR);
        for side in 0..2 {
            direction[PRESSURE[side]] = PRESSURES[side];
            direction[TEMPERATURE[side]] = TEMPERATURES[side];
        }
        for (state, free) in self.friction.states().zip(REST) {
            direction[state] = free;
        }
        direction[self.sensor_states(n)].fill(REST[self.friction.count()]);
        [direction[State::Position.at(n)], direction[State::Velocity.at(n)]] = MOTION;
        for (place, index) in lines.iter().enumerate() {
            let Some(index) = *index else { continue };
            direction[index] = match place {
                VESSEL => OF_VESSEL,
                _ => match place % HOSE {
                    0 => FIRST_VOLUMES[place / HOSE],
                    volume if volume < VOLUMES => LATER_VOLUMES[volume - 1],
                    column => LINE_COLUMNS[column - VOLUMES],
                },
            };
        }
        direction
    }

    fn dependencies(&self, n: usize, lines: &[Option<usize>; LINES]) -> [u64; MOST] {
        let mut rates = [0; MOST];
        let of_lines = |places: &[usize]| set(places.iter().filter_map(|place| lines[*place]));
        let valve = set(0..STATES) | of_lines(&[VESSEL]);
        let motion = set([State::Position.at(n), State::Velocity.at(n)]);
        let gas = set([PRESSURE_A, PRESSURE_B, TEMPERATURE_A, TEMPERATURE_B]);
        rates[..STATES].fill(set(0..STATES));
        for side in 0..2 {
            let [volume, column] = [VOLUMES - 1, HOSE - 1].map(|last| side * HOSE + last);
            let hose = of_lines(&[volume - 1, volume, column]);
            let port = if hose == 0 { valve } else { hose };
            (rates[PRESSURE[side]], rates[TEMPERATURE[side]]) = (gas | motion | port, gas | motion | port);
        }
        let carriage = motion | set(PRESSURE) | set(self.friction.states());
        for state in self.friction.states().chain([State::Position.at(n), State::Velocity.at(n)]) {
            rates[state] = carriage;
        }
        for state in self.sensor_states(n) {
            rates[state] = carriage | set([state]);
        }
        for (place, index) in lines.iter().enumerate() {
            let Some(index) = *index else { continue };
            if place == VESSEL {
                rates[index] = valve | gas | of_lines(&[0, HOSE]);
                continue;
            }
            let (side, own) = (place / HOSE, place % HOSE);
            let [volumes, columns] = neighbours(own);
            let (volumes, columns) = (volumes.start..volumes.end.min(VOLUMES), columns.start..columns.end.min(COLUMNS));
            let shifted = volumes.chain(columns.start + VOLUMES..columns.end + VOLUMES).map(|own| side * HOSE + own);
            rates[index] = set(shifted.filter_map(|place| lines[place]));
            if own == 0 {
                rates[index] |= valve;
            }
            if [VOLUMES - 2, VOLUMES - 1, HOSE - 1].contains(&own) {
                rates[index] |= set([PRESSURE[side], TEMPERATURE[side], State::Position.at(n)]);
            }
        }
        rates
    }

    /// The states of the sensors, where there are any.
    fn sensor_states(&self, n: usize) -> Range<usize> {
        State::Position.at(n) - self.sensors.states()..State::Position.at(n)
    }
}

/// The volumes and the columns of a hose that change one of its states: a volume changes with those beside it, and with what
/// flows in the columns between; a column with itself and the volumes at its ends. They may reach beyond the hose.
fn neighbours(own: usize) -> [Range<usize>; 2] {
    match own.checked_sub(VOLUMES) {
        None => [own.saturating_sub(1)..own + 2, own.saturating_sub(1)..own + 1],
        Some(column) => [column..column + 2, column..column + 1],
    }
}

/// States as bits.
fn set(states: impl IntoIterator<Item = usize>) -> u64 {
    states.into_iter().fold(0, |set, state| set | 1 << state)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::{Friction, LAWS};
    use crate::model::Start;
    use crate::models::pneumatic_servo_cylinder::MODEL;
    use crate::pneumatics::actuator::Actuator;
    use crate::session::build;
    use crate::system::{System, jacobian_by_couplings, jacobian_by_duals};

    type Extended = PneumaticServoCylinder<Friction, Actuator, true>;

    fn cylinder(changes: &[(&str, f64)]) -> Extended {
        for (name, _) in changes {
            assert!(MODEL.table().parameters().any(|variable| variable.name == *name), "there is no {name}");
        }
        let parameters: Vec<f64> = MODEL
            .table()
            .parameters()
            .map(|variable| {
                let change = changes.iter().find(|(name, _)| *name == variable.name);
                change.map_or_else(|| variable.start.expect("a start value"), |(_, value)| *value)
            })
            .collect();
        let start = Start { time: 0.0, parameters: &parameters, inputs: &[6.5, 3.0, 7e5], tolerance: None };
        build::<Extended, 3>(&start, &[]).unwrap_or_else(|error| panic!("{changes:?}: {error}")).0
    }

    /// The couplings among all states, also of a cylinder that has no use for them.
    fn couplings(cylinder: &Extended) -> Couplings<MOST> {
        cylinder.found_couplings().among(cylinder.states(), State::FRICTION + cylinder.friction.count())
    }

    /// Every law, with every combination of options that adds a coupling.
    fn cases() -> Vec<Vec<(&'static str, f64)>> {
        let options: [&[(&str, f64)]; 10] = [
            &[("hoseA.length", 1.0), ("hoseB.length", 0.7)],
            &[("hoseA.length", 1.0), ("supply.volume", 1e-3)],
            &[("hoseB.length", 1.0), ("throttleB.C", 1e-9), ("supply.volume", 1e-3), ("piston.leakage", 1e-14)],
            &[("supply.volume", 1e-3), ("sensor.pressureA.lag", 1e-3), ("sensor.force.lag", 1e-3)],
            &[("hoseA.length", 1.0), ("hoseB.length", 1.0), ("cushion.length", 0.3), ("sensor.force.lag", 1e-3)],
            &[("hoseA.length", 1.0), ("chamberB.open", 1.0), ("piston.leakage", 1e-14)],
            &[("actuation", 2.0), ("hoseA.length", 1.0), ("supply.volume", 1e-3)],
            &[("actuation", 3.0), ("thermal.model", 3.0), ("hoseA.length", 1.0)],
            &[("friction.position.amplitude", 0.2)],
            &[("actuation", 3.0), ("valve.hysteresis", 0.0)],
        ];
        let laws = LAWS.items.iter().map(|(id, ..)| vec![("friction.law", f64::from(*id)), ("friction.kappaA", 1e-6)]);
        laws.flat_map(|law| options.map(|option| [law.as_slice(), option].concat())).collect()
    }

    #[test]
    fn jacobian_by_couplings_is_that_of_the_whole() {
        for case in cases() {
            let (cylinder, u) = (cylinder(&case), [6.5, 3.0, 7e5]);
            let (mut x, memory) = cylinder.start::<MOST>(&u);
            for (place, state) in x.iter_mut().enumerate() {
                // Away from where anything is equal, or at rest.
                *state = if *state > 1e4 {
                    *state * (1.0 + 0.03 * place as f64)
                } else {
                    *state + 1e-4 * (1.0 + place as f64)
                };
            }
            x[State::Velocity.at(MOST)] = 0.1;
            let [mut few, mut whole, mut parts] = [[[0.0; MOST]; MOST]; 3];
            let rates = jacobian_by_couplings(&cylinder, &couplings(&cylinder), 0.1, &x, &u, &memory, &mut few);
            assert_eq!(rates, jacobian_by_duals(&cylinder, 0.1, &x, &u, &memory, &mut whole), "{case:?}");
            assert_eq!(rates, cylinder.linearise(0.1, &x, &u, &memory, &mut parts), "{case:?}");
            for row in 0..MOST {
                for column in 0..MOST {
                    let [found, part, expected] = [&few, &parts, &whole].map(|jacobian| jacobian[column][row]);
                    assert!(found == expected, "{case:?}: {found}, not {expected}, in row {row} and column {column}");
                    let [second, third] = Extended::GROUPS;
                    let is_between = column >= second && row < second || column < second && row >= third;
                    assert!(
                        cylinder.hints(&x, &memory).is_chain || !is_between || expected == 0.0,
                        "{case:?}: {row}, {column}"
                    );
                    // The parts sum in another order.
                    assert!(
                        (part - expected).abs() <= 1e-13 * expected.abs(),
                        "{case:?}: {part}, not {expected}, in row {row} and column {column}"
                    );
                }
            }
        }
    }

    #[test]
    fn no_rate_depends_on_two_states_of_one_direction() {
        for case in cases() {
            let Couplings { direction, rates } = couplings(&cylinder(&case));
            for (row, depends) in rates.into_iter().enumerate() {
                let mut taken = [None; 16];
                for state in (0..MOST).filter(|state| depends >> state & 1 == 1) {
                    let other = taken[usize::from(direction[state])].replace(state);
                    assert_eq!(other, None, "{case:?}: the rate of {row} depends on {state}, too");
                }
            }
        }
    }
}
