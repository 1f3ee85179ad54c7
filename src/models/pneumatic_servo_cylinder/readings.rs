//! What the sensors of a cylinder measure and read, and where their states stand among its own.

use super::cylinder::{MemoryOf, PneumaticServoCylinder};
use super::places::{MOST, PRESSURE_A, PRESSURE_B};
use super::sensors::{COUNT, Memory};
use super::states::{Inputs, State};
use crate::friction::FrictionLaw;
use crate::numbers::{Number, Real, Scalar};
use crate::pneumatics::actuator::Actuating;

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Takes the samples of the sensors that are due at a time in s.
    pub(super) fn take_readings<const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &mut MemoryOf<L, A>,
    ) {
        if !self.sensors.next_sample(&memory.sensors).is_due_at(time) {
            return;
        }
        let (x, u) = (&Real::all(x), &Inputs::read(&Real::all(u)));
        let contact = self.contact(Real::of(time), x, u, self.rate(x, memory));
        let friction = self.friction.force(&contact, x, &memory.friction, &mut [Real::zero(); MOST]);
        let acceleration = self.friction.rate((contact.applied - friction) * self.per_mass, &memory.friction);
        let [quantities, lagged] = [self.measured(x, u, acceleration), self.lagged(x)].map(|it| it.map(Real::value));
        self.sensors.sample(time, quantities, lagged, &mut memory.sensors);
    }

    /// Index of the first state of the sensors among `n` states, if they have any.
    pub(super) const fn first_of_sensors(n: usize) -> usize {
        State::Position.at(n) - COUNT
    }

    /// The states of the sensors, 0 if they have none.
    pub(super) fn lagged<S: Scalar>(&self, x: &[S]) -> [S; COUNT] {
        if self.sensors.states() == 0 {
            return [S::zero(); COUNT];
        }
        std::array::from_fn(|place| x[Self::first_of_sensors(x.len()) + place])
    }

    /// What the sensors measure, at an acceleration of the carriage.
    pub(super) fn measured<S: Scalar>(&self, x: &[S], u: &Inputs<S>, acceleration: S) -> [S; COUNT] {
        let position = State::Position.get(x);
        [position, x[PRESSURE_A], x[PRESSURE_B], self.rod_force(acceleration, position, u.external_force)]
    }

    /// Writes readings, states and their rates.
    #[inline(always)]
    pub(super) fn write_sensors<S: Scalar>(&self, x: &[S], quantities: [S; COUNT], memory: &Memory, slots: &mut [S]) {
        let (readings, states) = slots.split_at_mut(COUNT);
        if !EXTENDED {
            readings.copy_from_slice(&quantities);
            states.fill(S::zero());
            return;
        }
        let lagged = self.lagged(x);
        readings.copy_from_slice(&self.sensors.readings(quantities, lagged, memory));
        states[..COUNT].copy_from_slice(&lagged);
        states[COUNT..].copy_from_slice(&self.sensors.rates(quantities, lagged));
    }
}
