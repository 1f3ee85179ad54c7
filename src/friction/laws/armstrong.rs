//! Armstrong's seven-parameter law: dwell time and frictional memory.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, Drive, FrictionLaw, Stiction};
use crate::friction::parts::anchored::{Limits, Mode, Spring};
use crate::friction::parts::delay::{self, DelayLine};
use crate::friction::parts::parameters::{coulomb_force, damping, dwell_time, force, stiffness, velocity, viscous};
use crate::numbers::{Scalar, Varying};
use crate::parameters;
use crate::variables::{Fixed, Meaning, ParameterError, Tunable, Variable, units};

parameters! {
    /// Armstrong's seven-parameter friction.
    ///
    /// ```text
    /// sticking:  F = sigma0*(x - x_s) + sigma1*v        until |F| > lambda*(F_c + F_s(t_2))              [N]
    /// sliding:   F = lambda*(F_c + F_s(t_2)/(1 + (v(t - tauL)/v_s)^2))*sgn(v) + sigma2*v   until v crosses 0   [N]
    /// F_s(t_2) = F_sa + (FsInf - F_sa)*t_2/(t_2 + gamma)                                                 [N]
    /// ```
    ///
    /// `F_s` is the excess over `F_c`; `t_2` in s is the time spent sticking, the last one while sliding; `F_sa` is the
    /// Stribeck part `F_s/(1 + (v(t - tauL)/v_s)^2)` at the end of the last sliding, `FsInf` at first. The anchor `x_s`
    /// keeps `F` continuous when the mass sticks again. The velocity before the start equals the initial one.
    ///
    /// # Validity
    /// Sticking is an oscillation of frequency `sqrt(sigma0/m)` about the anchor, not a rest. Steps of the solver are at
    /// most `tauL/4`; see `DelayLine` for what it resolves: an oscillation of the velocity of frequency `f` comes back with
    /// an error of at most `6.2e-5*(f*tauL)^3` of its amplitude, 0.4 % at `f = 4/tauL` (800 Hz with the default, 20 Hz with
    /// `tauL` = 0.2 s). While a prescribed motion rests or unloads the spring, the spring yields
    /// to a break-away force that falls below its own.
    ///
    /// # Errors
    /// [`ParameterError`] for a `tauL` above 0 and below 10 us.
    ///
    /// # Source
    /// Armstrong-Helouvry, Dupont, Canudas de Wit (1994), Automatica 30(7):1083-1138, section 2.
    Armstrong {
        coulomb_force: Tunable = coulomb_force(8.3);
        stribeck_velocity: Tunable = velocity(2, "vs", 0.01).text("Stribeck velocity: speed at which the static excess has halved");
        viscous: Tunable = viscous(30.0);
        static_excess: Tunable = force(5, "FsInf", 2.7).meaning(Meaning::StaticExcess)
            .text("Excess of static over Coulomb friction after a long time at rest");
        dwell_time: Tunable = dwell_time(6, 0.1)
            .text("Time at rest in which half of the missing static excess comes back");
        lag: Fixed = Variable::parameter(7, "tauL", units::SECOND, 5e-3)
            .plausible(1e-6, 1.0)
            .range(0.0, 10.0)
            .shown_in("ms")
            .text("Frictional memory: delay of friction behind a change of speed; 0 or at least 10 us");
        spring: Spring = [
            stiffness(8, "sigma0", 1e6).text("Contact stiffness while sticking"),
            damping(9, "sigma1", 1000.0).text("Contact damping while sticking"),
        ];
    }
}

/// The mode, the values at its last change, and the delay line. Forces are at load factor 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "", deserialize = ""))]
pub struct Memory<S: Varying> {
    mode: Mode<S>,
    /// Time in s at which sticking began.
    since: S,
    /// While sticking `F_sa`, while sliding `F_s(t_2)`, in N.
    excess: S,
    line: DelayLine<S>,
}

impl FrictionLaw for Armstrong {
    type Memory<S: Varying> = Memory<S>;

    fn stiction(&self) -> Stiction {
        Stiction::Elastic
    }

    fn events(&self) -> &'static [Event] {
        &[Event::Stop, Event::BreakAway]
    }

    fn follows(&self) -> &'static [Drive] {
        &[Drive::Force, Drive::Motion]
    }

    fn check(&self) -> Result<(), ParameterError> {
        if self.lag > 0.0 && self.lag < 1e-5 {
            return Err(ParameterError::new("tauL", self.lag.value, "it must be 0 or at least 1e-5"));
        }
        Ok(())
    }

    fn start<S: Varying>(&self, contact: &Contact<S>) -> Memory<S> {
        let break_away = contact.level * (self.coulomb_force + self.static_excess);
        Memory {
            mode: Spring::start(contact, Limits { break_away, sliding: break_away }),
            since: contact.time,
            excess: S::tuned(self.static_excess),
            line: DelayLine::new(contact),
        }
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], memory: &Memory<S::Held>, _rates: &mut [S]) -> S {
        match memory.mode {
            Mode::Sticking { place, load } => {
                self.spring.holding(contact, place, load, || self.limits(contact, memory).break_away)
            }
            Mode::Sliding { direction } => {
                let dry = self.stribeck_part(contact, memory) + self.coulomb_force;
                contact.level * dry * direction + contact.velocity * self.viscous
            }
        }
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, _z: &[S], memory: &Memory<S>, out: &mut Indicators<S>) {
        self.spring.indicate(memory.mode, contact, self.limits(contact, memory), out);
    }

    fn switch<S: Varying>(
        &self,
        _event: Event,
        contact: &Contact<S>,
        _v: &mut S,
        _z: &mut [S],
        memory: &mut Memory<S>,
    ) {
        let before = memory.mode;
        memory.mode = self.spring.switched(before, contact, self.limits(contact, memory));
        match (before, memory.mode) {
            (Mode::Sliding { .. }, _) => {
                memory.excess = self.stribeck_part(contact, memory);
                memory.since = contact.time;
            }
            (_, Mode::Sliding { .. }) => memory.excess = self.risen_excess(contact.time, memory),
            _ => {}
        }
    }

    fn follow<S: Varying>(&self, contact: &Contact<S>, _z: &[S], memory: &mut Memory<S>) -> bool {
        memory.line.follow(contact, self.lag);
        if let Some(yielded) = self.spring.yielded(memory.mode, contact, self.limits(contact, memory)) {
            memory.mode = yielded;
        }
        true
    }

    fn max_step(&self) -> f64 {
        delay::max_step(self.lag.value)
    }

    fn depends_on_time(&self) -> bool {
        self.lag > 0.0
    }

    fn is_sticking<S: Varying>(memory: &Memory<S>) -> bool {
        matches!(memory.mode, Mode::Sticking { .. })
    }
}

impl Armstrong {
    /// Excess of sliding friction over the Coulomb friction, in N at load factor 1.
    fn stribeck_part<S: Scalar>(&self, contact: &Contact<S>, memory: &Memory<S::Held>) -> S {
        let ratio = memory.line.velocity(contact, self.lag) / self.stribeck_velocity;
        S::held(memory.excess) / (ratio * ratio + 1.0)
    }

    /// `F_s` after sticking until a time, in N at load factor 1.
    fn risen_excess<S: Scalar>(&self, time: S, memory: &Memory<S::Held>) -> S {
        let (dwell, excess) = (time - S::held(memory.since), S::held(memory.excess));
        excess + (S::tuned(self.static_excess) - excess) * dwell / (dwell + self.dwell_time)
    }

    fn limits<S: Scalar>(&self, contact: &Contact<S>, memory: &Memory<S::Held>) -> Limits<S> {
        let limit = |excess: S| contact.level * (excess + self.coulomb_force);
        match memory.mode {
            Mode::Sticking { .. } => {
                let break_away = limit(self.risen_excess(contact.time, memory));
                Limits { break_away, sliding: break_away }
            }
            // Sticking begins with the force at the end of sliding.
            Mode::Sliding { .. } => {
                let sliding = limit(self.stribeck_part(contact, memory));
                Limits { break_away: sliding, sliding }
            }
        }
    }
}
