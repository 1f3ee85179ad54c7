//! The Jacobian of the cylinder, assembled from its parts.
//!
//! Each part depends on few of the states, so dual numbers in those directions alone cost a fraction of dual numbers
//! in all directions; the result is the same, exact to rounding.

use nalgebra::SMatrix;

use super::{
    ACTUATOR, ACTUATOR_RATE, BRISTLES, ChamberState, Memory, PRESSURE_A, PRESSURE_B, PneumaticServoCylinder, Side,
    TEMPERATURE_A, TEMPERATURE_B, position, velocity,
};
use crate::scalar::{Dual, Scalar};
use crate::solver::jacobian_by_duals;

impl PneumaticServoCylinder {
    /// Writes the entries of the Jacobian that can differ from zero, and returns the derivatives.
    pub(super) fn linearise<const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &Memory,
        jacobian: &mut SMatrix<f64, N, N>,
    ) -> [f64; N] {
        // The parts are independent only without leakage between the chambers.
        if self.p.piston_leakage != 0.0 || self.bristles > 2 {
            return jacobian_by_duals(self, time, x, u, memory, jacobian);
        }
        let mut derivatives = [0.0; N];
        self.linearise_actuator(x, u, memory, jacobian, &mut derivatives);
        for side in [Side::A, Side::B] {
            self.linearise_chamber(side, x, u, memory, jacobian, &mut derivatives);
        }
        match self.bristles {
            0 => self.linearise_motion::<4, N>(time, x, u, memory, jacobian, &mut derivatives),
            1 => self.linearise_motion::<5, N>(time, x, u, memory, jacobian, &mut derivatives),
            _ => self.linearise_motion::<6, N>(time, x, u, memory, jacobian, &mut derivatives),
        }
        derivatives
    }

    fn linearise_actuator<const N: usize>(
        &self,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &Memory,
        jacobian: &mut SMatrix<f64, N, N>,
        derivatives: &mut [f64; N],
    ) {
        let states = [ACTUATOR_RATE, ACTUATOR];
        let seeded = [0, 1].map(|i| Dual::<2>::variable(x[states[i]], i));
        let rates = self.actuator_rates(seeded, Dual::constant(u[0]), memory);
        scatter(states.into_iter().zip(rates), &states, jacobian, derivatives);
    }

    fn linearise_chamber<const N: usize>(
        &self,
        side: Side,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &Memory,
        jacobian: &mut SMatrix<f64, N, N>,
        derivatives: &mut [f64; N],
    ) {
        let (pressure, temperature) = match side {
            Side::A => (PRESSURE_A, TEMPERATURE_A),
            Side::B => (PRESSURE_B, TEMPERATURE_B),
        };
        let states = [ACTUATOR, pressure, temperature, position(N), velocity(N)];
        let [actuator, p, t, x_, v] = [0, 1, 2, 3, 4].map(|i| Dual::<5>::variable(x[states[i]], i));
        let rate = if self.friction.holds_position(&memory.friction) { Dual::zero() } else { v };
        let state = ChamberState { actuator, pressure: p, temperature: t, position: x_, rate };
        let rates = self.chamber_rates(side, state, Dual::constant(u[2]), self.no_flow());
        let rows = [(pressure, rates.pressure), (temperature, rates.temperature)];
        scatter(rows.into_iter(), &states, jacobian, derivatives);
    }

    /// The rows of position, velocity and bristles, which depend on these and on the pressures: `D` states.
    fn linearise_motion<const D: usize, const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &Memory,
        jacobian: &mut SMatrix<f64, N, N>,
        derivatives: &mut [f64; N],
    ) {
        let bristles = BRISTLES..BRISTLES + D - 4;
        let mut states = [position(N), velocity(N), PRESSURE_A, PRESSURE_B, 0, 0];
        for (slot, bristle) in states[4..].iter_mut().zip(bristles.clone()) {
            *slot = bristle;
        }
        let states = &states[..D];
        let mut seeded = x.map(Dual::<D>::constant);
        for (direction, state) in states.iter().enumerate() {
            seeded[*state].slope[direction] = 1.0;
        }
        let mut rates = [Dual::<D>::zero(); 2];
        let motion =
            self.motion_rates(Dual::constant(time), &seeded, &u.map(Dual::constant), memory, &mut rates[..D - 4]);
        let rows = [(position(N), motion[0]), (velocity(N), motion[1])];
        scatter(rows.into_iter().chain(bristles.zip(rates)), states, jacobian, derivatives);
    }
}

/// Writes derivatives and their slopes into rows and into the columns of the states they were taken for.
fn scatter<const D: usize, const N: usize>(
    rows: impl Iterator<Item = (usize, Dual<D>)>,
    states: &[usize],
    jacobian: &mut SMatrix<f64, N, N>,
    derivatives: &mut [f64; N],
) {
    for (row, rate) in rows {
        derivatives[row] = rate.value;
        for (column, slope) in states.iter().zip(rate.slope) {
            jacobian[(row, *column)] = slope;
        }
    }
}
