//! The cylinder replayed with numbers that have slopes.

use super::cylinder::{MemoryOf, PneumaticServoCylinder};
use super::places::of_actuator;
use super::states::{Inputs, State};
use crate::friction::{Event, FrictionLaw};
use crate::hybrid::Stride;
use crate::numbers::Scalar;
use crate::pneumatics::actuator::{Actuating, STATES};
use crate::replay::Replayed;

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> Replayed<3> for PneumaticServoCylinder<L, A, EXTENDED> {
    fn held(&self, memory: &MemoryOf<L, A>) -> f64 {
        self.actuator.held(&memory.actuator)
    }

    fn followed<S: Scalar>(&self, u: &[S; 3], held: S) -> S {
        self.actuator.followed(Inputs::read(u).valve_voltage, held)
    }

    fn led_of<S: Scalar, const N: usize>(&self, x: &[S; N], held: S, stride: &Stride) -> [[S; STATES]; 2] {
        self.actuator.later_of(of_actuator(x), held, stride)
    }

    fn driven_of<S: Scalar, const N: usize>(&self, time: S, x: &[S; N], u: &[S; 3], memory: &MemoryOf<L, A>) -> [S; N] {
        let mut rates = [S::zero(); N];
        self.driven_rates(time, x, &Inputs::read(u), memory, &mut rates);
        rates
    }

    fn indicator_of<S: Scalar, const N: usize>(
        &self,
        event: usize,
        time: S,
        x: &[S; N],
        u: &[S; 3],
        memory: &MemoryOf<L, A>,
    ) -> Option<S> {
        let contact = self.contact(time, x, &Inputs::read(u), self.rate(x, memory));
        self.friction.law().indicator(Event::ALL[event], &contact, &x[self.friction.states()], &memory.friction)
    }

    fn switched_of<S: Scalar, const N: usize>(
        &self,
        event: usize,
        time: S,
        x: &mut [S; N],
        u: &[S; 3],
        memory: &MemoryOf<L, A>,
    ) {
        let contact = self.contact(time, x, &Inputs::read(u), self.rate(x, memory));
        let mut velocity = State::Velocity.get(x);
        let states = self.friction.states();
        self.friction.law().switched(Event::ALL[event], &contact, &mut velocity, &mut x[states], &memory.friction);
        State::Velocity.set(x, velocity);
    }
}
