//! What makes the runs of a cylinder faster.

use nalgebra::SMatrix;

use super::cylinder::{MemoryOf, PneumaticServoCylinder};
use super::places::{PRESSURE_A, PRESSURE_B, of_actuator};
use super::states::{Inputs, State};
use super::variables::Outputs;
use crate::friction::Laws;
use crate::hybrid::{Groups, Led, LongestSteps, Stride};
use crate::numbers::{Number, Real, Scalar};
use crate::pneumatics::actuator::{Actuators, STATES};
use crate::system::{Place, Shortcuts};

impl<L: Laws, A: Actuators, const EXTENDED: bool> Shortcuts<3> for PneumaticServoCylinder<L, A, EXTENDED> {
    const GROUPS: Groups = [STATES, State::FRICTION];

    const LED: usize = STATES;

    const RELAXING: Option<Place> = Some(Place::Front(State::FRICTION));

    const TURNING: Option<Place> = Some(Place::Back(0));

    fn at_hand<const N: usize>(&self, place: usize, x: &[f64; N], memory: &Self::Memory) -> Option<f64> {
        const POSITION: usize = Outputs::PLACES.position;
        const VELOCITY: usize = Outputs::PLACES.velocity;
        const IN_A: usize = Outputs::PLACES.pressure_a;
        const IN_B: usize = Outputs::PLACES.pressure_b;
        match place {
            POSITION => Some(State::Position.get(x)),
            VELOCITY => Some(self.rate_now(x, memory)),
            IN_A => Some(x[PRESSURE_A]),
            IN_B => Some(x[PRESSURE_B]),
            _ => None,
        }
    }

    fn driven<const N: usize>(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &MemoryOf<L, A>) -> [f64; N] {
        let (mut rates, u) = ([Real::zero(); N], Inputs::read(&Real::all(u)));
        self.driven_rates(Real::of(time), &Real::all(x), &u, memory, &mut rates);
        rates.map(Real::value)
    }

    fn jacobian<const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &MemoryOf<L, A>,
        jacobian: &mut SMatrix<f64, N, N>,
    ) -> [f64; N] {
        self.linearise(time, x, u, memory, jacobian)
    }

    fn is_chain(&self) -> bool {
        EXTENDED && self.lines.are_used()
    }

    fn indicators_hold(&self, inputs: [&[f64; 3]; 2]) -> bool {
        act_on_actuator_alone(inputs) && !self.friction.follows()
    }

    fn refresh<const N: usize>(
        &self,
        x: &[f64; N],
        inputs: [&[f64; 3]; 2],
        memory: &MemoryOf<L, A>,
        derivatives: &mut [f64; N],
    ) -> bool {
        if !act_on_actuator_alone(inputs) {
            return false;
        }
        let voltage = Real::of(Inputs::read(inputs[1]).valve_voltage);
        let rates = self.actuator.rates(Real::all(&of_actuator(x)), voltage, &memory.actuator);
        derivatives[..STATES].copy_from_slice(&rates.map(Real::value));
        true
    }

    fn is_gentle(&self) -> bool {
        self.is_gentle
    }

    fn is_hasty(&self, memory: &MemoryOf<L, A>) -> bool {
        EXTENDED && self.actuator.is_hasty(&memory.actuator)
    }

    fn relaxation<const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        rates: &[f64; N],
        u: &[f64; 3],
        memory: &MemoryOf<L, A>,
    ) -> f64 {
        let contact = || self.contact_now(time, x, u, self.rate_now(x, memory));
        self.friction.relaxation(contact, [x, rates], &memory.friction)
    }

    fn longest_gentle_steps<const N: usize>(&self, x: &[f64; N]) -> LongestSteps {
        let of_motion = self.gentle.longest(self.stops.touched(State::Position.get(x)), State::Velocity.get(x));
        if !EXTENDED {
            return of_motion;
        }
        let longest = of_motion.min(self.lines.longest_steps());
        // Chambers that pulses vent come so close to the pressure outside that the midpoint rule does not follow.
        if self.actuator.is_sampled() { LongestSteps { midpoint: 0.0, ..longest } } else { longest }
    }

    fn is_smooth<const N: usize>(
        &self,
        [x, end]: [&[f64; N]; 2],
        u: [&[f64; 3]; 2],
        memory: &MemoryOf<L, A>,
        step: f64,
    ) -> bool {
        let [u, u_end] = u.map(Inputs::read);
        let states = [of_actuator(x), of_actuator(end)];
        self.piece(x, &u) == self.piece(end, &u_end)
            && self.actuator.stays_in_piece(states, u.valve_voltage, &memory.actuator, step)
    }

    fn stride(&self, size: f64) -> Stride {
        Stride { size, half: self.actuator.half(size) }
    }

    fn led<const N: usize>(
        &self,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &MemoryOf<L, A>,
        stride: &Stride,
    ) -> Led<[f64; N]> {
        let voltage = Inputs::read(u).valve_voltage;
        let Led { middle, end, bend } = self.actuator.later(of_actuator(x), voltage, &memory.actuator, stride);
        let placed = |own: [f64; STATES]| {
            let mut all = [0.0; N];
            all[..STATES].copy_from_slice(&own);
            all
        };
        Led { middle: placed(middle), end: placed(end), bend: placed(bend) }
    }
}

/// Whether inputs differ in nothing but the voltage: it, and the play that follows it, act on the actuator alone.
fn act_on_actuator_alone(inputs: [&[f64; 3]; 2]) -> bool {
    let [from, to] =
        inputs.map(Inputs::read).map(|u: Inputs<f64>| [u.external_force, u.supply_pressure].map(f64::to_bits));
    from == to
}
