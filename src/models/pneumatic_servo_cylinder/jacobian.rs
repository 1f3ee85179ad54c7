//! The Jacobian of the cylinder, assembled from its parts.
//!
//! Each part depends on few of the states, so dual numbers in those directions alone cost a fraction of dual numbers
//! in all directions; the result is the same, exact to rounding.
//!
//! With lines or sensors states are coupled as in a chain: air in a hose notices its neighbours alone. So hoses share their
//! directions with each other, and with parts far away (structurally orthogonal columns; Curtis, Powell and Reid, 1974).

use std::ops::Range;

use super::cylinder::{MemoryOf, PneumaticServoCylinder};
use super::equations::Feeding;
use super::leaks::Leaks;
use super::lines::{HOSE, LINE_STATES, METER, VESSEL, VOLUMES};
use super::states::{Inputs, MOST, PRESSURE_A, PRESSURE_B, State, TEMPERATURE_A, TEMPERATURE_B, of_actuator};
use crate::friction::FrictionLaw;
use crate::numbers::{Dual, Number, Pair, Varying};
use crate::pneumatics::actuator::{Actuating, FLOW, STATES};
use crate::pneumatics::hose::COLUMNS;
use crate::system::{Couplings, PartFacts, System, jacobian_by_couplings, jacobian_by_duals};

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Writes the entries of the Jacobian that can differ from zero, and returns the derivatives.
    pub(super) fn linearise<S: Varying, const N: usize, const U: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; U],
        memory: &MemoryOf<L, A, S>,
        jacobian: &mut [[f64; N]; N],
    ) -> [f64; N] {
        if self.is_linearised_by_couplings() {
            return jacobian_by_couplings(self, &self.couplings(), time, x, u, memory, jacobian);
        }
        if !self.has_separate_parts() {
            return jacobian_by_duals(self, time, x, u, memory, jacobian);
        }
        let mut derivatives = [0.0; N];
        let inputs = &Inputs::of(u);
        self.linearise_actuator(x, inputs, memory, jacobian, &mut derivatives);
        self.linearise_chambers(time, x, inputs, memory, jacobian, &mut derivatives);
        match self.friction.states() {
            0 => self.linearise_motion::<S, 4, N>(time, x, inputs, memory, jacobian, &mut derivatives),
            1 => self.linearise_motion::<S, 5, N>(time, x, inputs, memory, jacobian, &mut derivatives),
            _ => self.linearise_motion::<S, 6, N>(time, x, inputs, memory, jacobian, &mut derivatives),
        }
        if let Some(meter) = System::<U>::counting(self, N) {
            self.linearise_meter(meter, x, inputs, jacobian, &mut derivatives);
        }
        derivatives
    }

    /// Whether the parts depend on few states each: without hoses, a vessel and lagging sensors, without leakage between the
    /// chambers, and under a law of few states.
    fn has_separate_parts(&self) -> bool {
        let leaks_past_piston = self.leaks.as_ref().is_some_and(Leaks::pass_piston);
        let is_attached = EXTENDED && (self.lines.are_coupled() || self.sensors.states() > 0);
        !is_attached && !leaks_past_piston && self.friction.states() <= 2
    }

    /// Whether structurally orthogonal columns are taken together.
    pub(super) fn is_linearised_by_couplings(&self) -> bool {
        EXTENDED && !self.has_separate_parts()
    }

    fn linearise_actuator<S: Varying, const N: usize>(
        &self,
        x: &[f64; N],
        u: &Inputs<f64>,
        memory: &MemoryOf<L, A, S>,
        jacobian: &mut [[f64; N]; N],
        derivatives: &mut [f64; N],
    ) {
        let states: [usize; STATES] = std::array::from_fn(|place| place);
        let seeded = states.map(|place| Dual::<STATES, S>::variable(x[place], place));
        let rates = self.actuator.rates(seeded, u.map(Dual::constant).commands(), &memory.actuator);
        scatter(states.into_iter().zip(rates), &states, jacobian, derivatives);
    }

    /// The rows of both chambers. The flow into each depends on the two states of the actuator and its own two, the rates on
    /// position and velocity as well.
    fn linearise_chambers<S: Varying, const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &Inputs<f64>,
        memory: &MemoryOf<L, A, S>,
        jacobian: &mut [[f64; N]; N],
        derivatives: &mut [f64; N],
    ) {
        const FED: usize = STATES + 2;
        const ALL: usize = FED + 2;
        // Each chamber in the directions of its own states.
        let seeded =
            |states: [usize; 2], direction: usize| Pair(states.map(|i| Dual::<FED, S>::variable(x[i], direction)));
        let pressures = seeded([PRESSURE_A, PRESSURE_B], STATES);
        let gas = self.chambers.gas(self.filling(), pressures, seeded([TEMPERATURE_A, TEMPERATURE_B], STATES + 1));
        let feeding: [_; STATES] = std::array::from_fn(|place| Dual::variable(x[place], place));
        let at = Feeding { time: Dual::constant(time), x: &feeding, memory: &memory.actuator };
        let inflow = self.inflow(at, Dual::constant(u.supply_pressure), gas);
        let position_ = Dual::<ALL, S>::variable(State::Position.get(x), FED);
        let rate = if self.is_rigidly_imposed() {
            memory.motion.imposed(Dual::constant(time), u.map(Dual::constant).imposed()).velocity
        } else {
            self.friction.rate(Dual::variable(State::Velocity.get(x), FED + 1), &memory.friction)
        };
        let rates = self.gas_rates(gas.map(Pair::widened), position_, rate, inflow.map(Pair::widened));
        let (Pair(pressures), Pair(temperatures)) = (rates.pressure, rates.temperature);
        let chambers = [(PRESSURE_A, TEMPERATURE_A), (PRESSURE_B, TEMPERATURE_B)];
        for (side, (pressure, temperature)) in chambers.into_iter().enumerate() {
            let states = [0, FLOW, pressure, temperature, State::Position.at(N), State::Velocity.at(N)];
            let rows = [(pressure, pressures[side]), (temperature, temperatures[side])];
            scatter(rows.into_iter(), &states, jacobian, derivatives);
        }
    }

    /// The row of the meter where it is the only line: it depends on the states of the actuator and of both chambers.
    fn linearise_meter<const N: usize>(
        &self,
        meter: usize,
        x: &[f64; N],
        u: &Inputs<f64>,
        jacobian: &mut [[f64; N]; N],
        derivatives: &mut [f64; N],
    ) {
        const D: usize = STATES + 4;
        let states = [0, FLOW, PRESSURE_A, TEMPERATURE_A, PRESSURE_B, TEMPERATURE_B];
        let mut seeded = x.map(Dual::<D>::constant);
        for (direction, state) in states.iter().enumerate() {
            seeded[*state].slope[direction] = 1.0;
        }
        let (ports, gas) = (self.ports(Dual::constant(u.supply_pressure)), self.gas(&seeded));
        let drawn = self.closed(self.actuator.drawn(of_actuator(&seeded), &ports, gas));
        scatter([(meter, drawn)].into_iter(), &states, jacobian, derivatives);
    }

    /// The rows of position, velocity and bristles, which depend on these and on the pressures: `D` states.
    fn linearise_motion<S: Varying, const D: usize, const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &Inputs<f64>,
        memory: &MemoryOf<L, A, S>,
        jacobian: &mut [[f64; N]; N],
        derivatives: &mut [f64; N],
    ) {
        let states = [
            State::Position.at(N),
            State::Velocity.at(N),
            PRESSURE_A,
            PRESSURE_B,
            State::FRICTION,
            State::FRICTION + 1,
        ];
        let mut seeded = x.map(Dual::<D, S>::constant);
        for (direction, state) in states[..D].iter().enumerate() {
            seeded[*state].slope[direction] = 1.0;
        }
        // Apart from the other states, which then stay in registers.
        let (bristles, mut bristle_rates) = ([seeded[State::FRICTION], seeded[State::FRICTION + 1]], [Dual::zero(); 2]);
        let (time, u, count) = (Dual::constant(time), u.map(Dual::constant), D - 4);
        let [rate, acceleration, _] =
            self.motion_rates(time, &seeded, &u, memory, &bristles[..count], &mut bristle_rates[..count]);
        let acceleration = if self.is_rigidly_imposed() { Dual::zero() } else { acceleration };
        let [first, second] = bristle_rates;
        let rows = [rate, acceleration, first, second].into_iter().take(2 + count);
        let places = [State::Position.at(N), State::Velocity.at(N), State::FRICTION, State::FRICTION + 1];
        scatter(places.into_iter().zip(rows), &states, jacobian, derivatives);
    }
}

/// Writes derivatives and their slopes into rows and into the columns of the states they were taken for.
fn scatter<S, const D: usize, const N: usize>(
    rows: impl Iterator<Item = (usize, Dual<D, S>)>,
    states: &[usize],
    jacobian: &mut [[f64; N]; N],
    derivatives: &mut [f64; N],
) {
    for (row, rate) in rows {
        derivatives[row] = rate.value;
        for (column, slope) in states.iter().zip(rate.slope) {
            jacobian[*column][row] = slope;
        }
    }
}

const PRESSURE: [usize; 2] = [PRESSURE_A, PRESSURE_B];
const TEMPERATURE: [usize; 2] = [TEMPERATURE_A, TEMPERATURE_B];

// Which states of a cylinder with lines change which others, for its Jacobian.
impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// The couplings of a cylinder among as many states as it has.
    pub(super) fn found_couplings(&self) -> Couplings<MOST> {
        Couplings::new(self.dependencies(self.states()))
    }

    /// The couplings among the states of a run.
    pub(super) fn couplings<const N: usize>(&self) -> Couplings<N> {
        self.couplings.among(self.states(), State::FRICTION + self.friction.states())
    }

    /// For each rate, the states on which it can depend.
    fn dependencies(&self, n: usize) -> [u64; MOST] {
        let mut rates = [0; MOST];
        // The indices of the states of the lines, where they are integrated.
        let mut lines = [None; LINE_STATES];
        self.lines.places(n).for_each(|(place, index)| lines[place] = Some(index));
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
        let carriage = motion | set(PRESSURE) | set(self.friction.range());
        for state in self.friction.range().chain([State::Position.at(n), State::Velocity.at(n)]) {
            rates[state] = carriage;
        }
        for state in self.sensor_states(n) {
            rates[state] = carriage | set([state]);
        }
        for (place, index) in lines.iter().enumerate() {
            let Some(index) = *index else { continue };
            if place == VESSEL || place == METER {
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
mod couplings {
    use super::*;
    use crate::friction::{Friction, LAWS};
    use crate::model::{Seeds, Start};
    use crate::models::pneumatic_servo_cylinder::MODEL;
    use crate::models::pneumatic_servo_cylinder::states::ALL;
    use crate::numbers::{Real, Scalar};
    use crate::pneumatics::actuator::Actuator;
    use crate::session::build;
    use crate::system::{System, jacobian_by_couplings, jacobian_by_duals};

    type Extended = PneumaticServoCylinder<Friction, Actuator, true>;

    const INPUTS: [f64; ALL] = [6.5, 3.0, 7e5, 0.25, 0.05, 6.0, 4.5, 0.0, 0.0, 0.0, 0.0];

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
        let start = Start { time: 0.0, parameters: &parameters, inputs: &INPUTS, tolerance: None, seeds: Seeds::NONE };
        build::<Extended, ALL>(&start).unwrap_or_else(|error| panic!("{changes:?}: {error}")).0
    }

    /// The couplings among all states, also of a cylinder that has no use for them.
    fn couplings(cylinder: &Extended) -> Couplings<MOST> {
        cylinder.found_couplings().among(cylinder.states(), State::FRICTION + cylinder.friction.states())
    }

    /// Every law, with every combination of options that adds a coupling.
    fn cases() -> Vec<Vec<(&'static str, f64)>> {
        let options: [&[(&str, f64)]; 16] = [
            &[("hoseA.length", 1.0), ("hoseB.length", 0.7)],
            &[("hoseA.length", 1.0), ("supply.volume", 1e-3), ("consumption.enabled", 1.0)],
            &[("consumption.enabled", 1.0)],
            &[("hoseB.length", 1.0), ("throttleB.C", 1e-9), ("supply.volume", 1e-3), ("piston.leakage", 1e-14)],
            &[("supply.volume", 1e-3), ("sensor.pressureA.lag", 1e-3), ("sensor.force.lag", 1e-3)],
            &[("hoseA.length", 1.0), ("hoseB.length", 1.0), ("cushion.length", 0.3), ("sensor.force.lag", 1e-3)],
            &[("hoseA.length", 1.0), ("chamberB.open", 1.0), ("piston.leakage", 1e-14)],
            &[("actuation", 2.0), ("hoseA.length", 1.0), ("supply.volume", 1e-3)],
            &[("actuation", 3.0), ("thermal.model", 3.0), ("hoseA.length", 1.0)],
            &[("friction.position.amplitude", 0.2), ("chamberA.leakage", 1e-10), ("chamberB.leakage", 1e-11)],
            &[("actuation", 3.0), ("switching.command", 3.0)],
            &[("actuation", 4.0), ("sensor.force.lag", 1e-3)],
            &[("actuation", 5.0), ("hoseA.length", 1.0)],
            &[("motion", 2.0), ("sensor.force.lag", 1e-3)],
            &[("hoseB.length", 1.0), ("quickExhaustB.C", 1e-8), ("friction.direction.damping", 20.0)],
            &[("motion", 2.0), ("coupling.compliance", 1e-5), ("coupling.damping", 20.0)],
        ];
        let laws = LAWS.items.iter().map(|(id, ..)| vec![("friction.law", f64::from(*id)), ("friction.kappaA", 1e-6)]);
        laws.flat_map(|law| options.map(|option| [law.as_slice(), option].concat())).collect()
    }

    #[test]
    fn jacobian_by_couplings_is_that_of_the_whole() {
        for case in cases() {
            let (cylinder, u) = (cylinder(&case), INPUTS);
            let (x, memory) = cylinder.start::<Real, MOST>(&Real::all(&u));
            let mut x = x.map(Real::value);
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
                    let [second, _] = <Extended as System<ALL>>::GROUPS;
                    assert!(column < second || row >= second || expected == 0.0, "{case:?}: {row}, {column}");
                    // The parts sum in another order.
                    assert!(
                        (part - expected).abs() <= 1e-13 * expected.abs(),
                        "{case:?}: {part}, not {expected}, in row {row} and column {column}"
                    );
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::{LAWS, MAX_STATES};
    use crate::model::{Seeds, Start};
    use crate::models::pneumatic_servo_cylinder::{MODEL, Memory};
    use crate::numbers::{Real, Scalar};
    use crate::session::build;
    use crate::system::System;
    use crate::variables::{Role, Variable};

    const N: usize = State::OTHERS + MAX_STATES;

    /// The default cylinder with some parameters changed, in motion under different pressures and temperatures.
    fn moving(changes: &[(&str, f64)], check: impl Fn(&PneumaticServoCylinder, &[f64; N], &[f64; 3], &Memory)) {
        let starts = |of: &dyn Fn(&Variable) -> bool| -> Vec<f64> {
            MODEL.table().iter().filter(|it| of(it)).filter_map(|it| it.start).collect()
        };
        let names: Vec<_> = MODEL.table().iter().filter(|it| it.is_parameter()).map(|it| &it.name).collect();
        let mut parameters = starts(&Variable::is_parameter);
        for (name, value) in changes {
            parameters[names.iter().position(|it| *it == name).expect("a parameter")] = *value;
        }
        let inputs = starts(&|it| it.role == Role::Input);
        let start = Start { time: 0.0, parameters: &parameters, inputs: &inputs, tolerance: None, seeds: Seeds::NONE };
        let (cylinder, _) = build::<PneumaticServoCylinder, 3>(&start).expect("legal parameters");
        let u: [f64; 3] = std::array::from_fn(|place| inputs[place]);
        let (x, memory) = cylinder.start::<Real, N>(&Real::all(&u));
        let mut x = x.map(Real::value);
        for spool in [-0.4, 0.3] {
            // A spool, or the pressure behind the regulator.
            x[FLOW] = if x[FLOW] > 1e3 { 4e5 } else { spool };
            (x[0], x[PRESSURE_A], x[PRESSURE_B]) = (20.0, 3.1e5, 5.2e5);
            (x[TEMPERATURE_A], x[TEMPERATURE_B], x[State::Position.at(N)], x[State::Velocity.at(N)]) =
                (281.0, 307.0, 0.2, 0.1);
            check(&cylinder, &x, &[6.0, 3.0, 7e5], &memory);
        }
    }

    fn cases() -> impl Iterator<Item = Vec<(&'static str, f64)>> {
        let laws = LAWS.items.iter().map(|(id, ..)| vec![("friction.law", f64::from(*id)), ("friction.kappaA", 1e-6)]);
        let rigs = [
            vec![("actuation", 2.0)],
            vec![("valve.characteristic", 2.0), ("valve.AR.factor", 1.3), ("valve.PB.b", 0.1)],
            vec![("thermal.model", 2.0)],
            vec![("thermal.model", 3.0)],
            vec![("piston.leakage", 1e-14)],
            vec![("chamberA.leakage", 1e-10), ("chamberB.leakage", 1e-11)],
            vec![("velocity0", 0.1)],
        ];
        laws.chain(rigs)
    }

    #[test]
    fn jacobian_by_parts_is_that_of_the_whole() {
        for case in cases() {
            moving(&case, |cylinder, x, u, memory| {
                let [mut parts, mut whole] = [[[0.0; N]; N]; 2];
                let derivatives = cylinder.linearise(0.0, x, u, memory, &mut parts);
                assert_eq!(derivatives, jacobian_by_duals(cylinder, 0.0, x, u, memory, &mut whole), "{case:?}");
                for (entry, expected) in parts.as_flattened().iter().zip(whole.as_flattened()) {
                    assert!((entry - expected).abs() <= 1e-13 * expected.abs(), "{case:?}: {entry}, not {expected}");
                }
            });
        }
    }

    #[test]
    fn jacobian_has_the_zeros_of_its_groups() {
        let [second, _] = <PneumaticServoCylinder as System<3>>::GROUPS;
        for case in cases() {
            moving(&case, |cylinder, x, u, memory| {
                let mut jacobian = [[0.0; N]; N];
                jacobian_by_duals(cylinder, 0.0, x, u, memory, &mut jacobian);
                assert!(jacobian[second..].iter().all(|it| it[..second] == [0.0; N][..second]), "{case:?}");
            });
        }
    }
}
