//! The Jacobian of the cylinder, assembled from its parts.
//!
//! Each part depends on few of the states, so dual numbers in those directions alone cost a fraction of dual numbers
//! in all directions; the result is the same, exact to rounding.

use super::cylinder::{MemoryOf, PneumaticServoCylinder};
use super::places::{PRESSURE_A, PRESSURE_B, TEMPERATURE_A, TEMPERATURE_B};
use super::states::{Inputs, State};
use crate::friction::FrictionLaw;
use crate::numbers::Pair;
use crate::numbers::{Dual, Number};
use crate::pneumatics::actuator::{Actuating, FLOW, STATES};
use crate::system::{jacobian_by_couplings, jacobian_by_duals};

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Writes the entries of the Jacobian that can differ from zero, and returns the derivatives.
    pub(super) fn linearise<const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &MemoryOf<L, A>,
        jacobian: &mut [[f64; N]; N],
    ) -> [f64; N] {
        // The parts are independent only without lines and sensors, and without leakage between the chambers.
        if self.has_attachments() {
            return jacobian_by_couplings(self, &self.couplings(), time, x, u, memory, jacobian);
        }
        if self.p.piston_leakage != 0.0 || self.friction.count() > 2 {
            return jacobian_by_duals(self, time, x, u, memory, jacobian);
        }
        let mut derivatives = [0.0; N];
        let inputs = &Inputs::read(u);
        self.linearise_actuator(x, inputs, memory, jacobian, &mut derivatives);
        self.linearise_chambers(x, inputs, memory, jacobian, &mut derivatives);
        match self.friction.count() {
            0 => self.linearise_motion::<4, N>(time, x, u, memory, jacobian, &mut derivatives),
            1 => self.linearise_motion::<5, N>(time, x, u, memory, jacobian, &mut derivatives),
            _ => self.linearise_motion::<6, N>(time, x, u, memory, jacobian, &mut derivatives),
        }
        derivatives
    }

    fn linearise_actuator<const N: usize>(
        &self,
        x: &[f64; N],
        u: &Inputs<f64>,
        memory: &MemoryOf<L, A>,
        jacobian: &mut [[f64; N]; N],
        derivatives: &mut [f64; N],
    ) {
        let states: [usize; STATES] = std::array::from_fn(|place| place);
        let seeded = states.map(|place| Dual::<STATES>::variable(x[place], place));
        let rates = self.actuator.rates(seeded, Dual::constant(u.valve_voltage), &memory.actuator);
        scatter(states.into_iter().zip(rates), &states, jacobian, derivatives);
    }

    /// The rows of both chambers. The flow into each depends on the two states of the actuator and its own two, the rates on
    /// position and velocity as well.
    fn linearise_chambers<const N: usize>(
        &self,
        x: &[f64; N],
        u: &Inputs<f64>,
        memory: &MemoryOf<L, A>,
        jacobian: &mut [[f64; N]; N],
        derivatives: &mut [f64; N],
    ) {
        const FED: usize = STATES + 2;
        const ALL: usize = FED + 2;
        // Each chamber in the directions of its own states.
        let seeded =
            |states: [usize; 2], direction: usize| Pair(states.map(|i| Dual::<FED>::variable(x[i], direction)));
        let gas = self
            .chambers
            .gas(seeded([PRESSURE_A, PRESSURE_B], STATES), seeded([TEMPERATURE_A, TEMPERATURE_B], STATES + 1));
        let feeding = std::array::from_fn(|place| Dual::variable(x[place], place));
        let inflow = self.inflow(feeding, Dual::constant(u.supply_pressure), gas);
        let position_ = Dual::<ALL>::variable(State::Position.get(x), FED);
        let rate = self.friction.rate(Dual::variable(State::Velocity.get(x), FED + 1), &memory.friction);
        let rates = self.gas_rates(gas.map(Pair::widened), position_, rate, inflow.map(Pair::widened));
        let (Pair(pressures), Pair(temperatures)) = (rates.pressure, rates.temperature);
        let chambers = [(PRESSURE_A, TEMPERATURE_A), (PRESSURE_B, TEMPERATURE_B)];
        for (side, (pressure, temperature)) in chambers.into_iter().enumerate() {
            let states = [0, FLOW, pressure, temperature, State::Position.at(N), State::Velocity.at(N)];
            let rows = [(pressure, pressures[side]), (temperature, temperatures[side])];
            scatter(rows.into_iter(), &states, jacobian, derivatives);
        }
    }

    /// The rows of position, velocity and bristles, which depend on these and on the pressures: `D` states.
    fn linearise_motion<const D: usize, const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &MemoryOf<L, A>,
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
        let mut seeded = x.map(Dual::<D>::constant);
        for (direction, state) in states[..D].iter().enumerate() {
            seeded[*state].slope[direction] = 1.0;
        }
        // Apart from the other states, which then stay in registers.
        let (bristles, mut bristle_rates) = ([seeded[State::FRICTION], seeded[State::FRICTION + 1]], [Dual::zero(); 2]);
        let (time, u, count) = (Dual::constant(time), Inputs::read(&u.map(Dual::constant)), D - 4);
        let [rate, acceleration] =
            self.motion_rates(time, &seeded, &u, memory, &bristles[..count], &mut bristle_rates[..count]);
        let [first, second] = bristle_rates;
        let rows = [rate, acceleration, first, second].into_iter().take(2 + count);
        let places = [State::Position.at(N), State::Velocity.at(N), State::FRICTION, State::FRICTION + 1];
        scatter(places.into_iter().zip(rows), &states, jacobian, derivatives);
    }
}

/// Writes derivatives and their slopes into rows and into the columns of the states they were taken for.
fn scatter<const D: usize, const N: usize>(
    rows: impl Iterator<Item = (usize, Dual<D>)>,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::{LAWS, MAX_STATES};
    use crate::model::Start;
    use crate::models::pneumatic_servo_cylinder::{MODEL, Memory};
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
        let start = Start { time: 0.0, parameters: &parameters, inputs: &inputs, tolerance: None };
        let (cylinder, _) = build::<PneumaticServoCylinder, 3>(&start, &[]).expect("legal parameters");
        let u: [f64; 3] = std::array::from_fn(|place| inputs[place]);
        let (mut x, memory) = cylinder.start::<N>(&u);
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
        let [second, third] = <PneumaticServoCylinder as System<3>>::GROUPS;
        for case in cases() {
            moving(&case, |cylinder, x, u, memory| {
                let mut jacobian = [[0.0; N]; N];
                jacobian_by_duals(cylinder, 0.0, x, u, memory, &mut jacobian);
                assert!(jacobian[second..].iter().all(|it| it[..second] == [0.0; N][..second]), "{case:?}");
                assert!(jacobian[..second].iter().all(|it| it[third..] == [0.0; N][third..]), "{case:?}");
            });
        }
    }
}
