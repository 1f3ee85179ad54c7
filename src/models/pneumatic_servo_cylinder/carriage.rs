//! The carriage: what pushes it, what friction sees of it, how it moves.

use super::cylinder::{MemoryOf, PneumaticServoCylinder};
use super::places::{PRESSURE_A, PRESSURE_B};
use super::states::{Inputs, State};
use crate::friction::{Contact, FrictionLaw};
use crate::numbers::{Pair, Real, Scalar};
use crate::pneumatics::actuator::Actuating;
use crate::variables::Tunable;

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Force on the moving mass other than friction in N, and the stops' part of it.
    #[inline(always)]
    pub(super) fn applied_force<S: Scalar>(&self, x: &[S], u: &Inputs<S>, rate: S) -> (S, S) {
        let position = State::Position.get(x);
        let stop = self.stops.force(position, rate);
        let force = self.pressure_force(x) + u.external_force - self.dead_load + stop;
        (if EXTENDED { force + self.options.spring_force(position) } else { force }, stop)
    }

    #[inline(always)]
    pub(super) fn pressure_force<S: Scalar>(&self, x: &[S]) -> S {
        let [area_a, area_b] = self.chambers.areas;
        x[PRESSURE_A] * area_a - x[PRESSURE_B] * area_b - self.p.ambient_pressure * self.rod_area
    }

    /// The load level `lambda`.
    #[inline(always)]
    pub(super) fn load_level<S: Scalar>(&self, x: &[S]) -> S {
        let excess = |pressure: S, kappa: Tunable| (pressure - self.p.ambient_pressure) * kappa;
        let level = excess(x[PRESSURE_A], self.p.kappa_a) + excess(x[PRESSURE_B], self.p.kappa_b) + 1.0;
        if !EXTENDED {
            return level.max(S::zero());
        }
        let added = self.options.added_level(Pair([x[PRESSURE_A], x[PRESSURE_B]]));
        (level + added).max(S::zero()) * self.options.relative_level(State::Position.get(x))
    }

    /// The contact as the friction law sees it, for a velocity of the carriage.
    #[inline(always)]
    pub(super) fn contact<S: Scalar>(&self, time: S, x: &[S], u: &Inputs<S>, rate: S) -> Contact<S> {
        Contact {
            time,
            position: State::Position.get(x),
            velocity: State::Velocity.get(x),
            applied: self.applied_force(x, u, rate).0,
            level: self.load_level(x),
            drive: self.friction.drive(),
        }
    }

    /// The same in plain numbers.
    #[inline(always)]
    pub(super) fn contact_now<const N: usize>(&self, time: f64, x: &[f64; N], u: &[f64; 3], rate: f64) -> Contact<f64> {
        let u = &Inputs::read(&Real::all(u));
        self.contact(Real::of(time), &Real::all(x), u, Real::of(rate)).plain()
    }

    /// Velocity of the carriage: the state, unless the friction law holds the position.
    #[inline(always)]
    pub(super) fn rate<S: Scalar>(&self, x: &[S], memory: &MemoryOf<L, A>) -> S {
        self.friction.rate(State::Velocity.get(x), &memory.friction)
    }

    #[inline(always)]
    pub(super) fn rate_now<const N: usize>(&self, x: &[f64; N], memory: &MemoryOf<L, A>) -> f64 {
        self.rate(&Real::all(x), memory).value
    }

    /// Rates of position and velocity; writes those of the bristles.
    #[inline(always)]
    pub(super) fn motion_rates<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        memory: &MemoryOf<L, A>,
        bristles: &[S],
        bristle_rates: &mut [S],
    ) -> [S; 2] {
        let rate = self.rate(x, memory);
        let contact = self.contact(time, x, u, rate);
        let force = self.friction.law().force(&contact, bristles, &memory.friction, bristle_rates);
        [rate, (contact.applied - force) * self.per_mass]
    }

    /// Force of the rod on the carriage in N at an acceleration of it: what a load cell between them reads.
    pub(super) fn rod_force<S: Scalar>(&self, acceleration: S, position: S, external_force: S) -> S {
        let force = acceleration * self.p.carriage_mass - external_force + (self.p.wire_force + self.carriage_weight);
        if EXTENDED { force - self.options.spring_force(position) } else { force }
    }
}
