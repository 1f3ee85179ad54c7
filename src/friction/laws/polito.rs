//! The Polito law: different curves for increasing and decreasing speed.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, Drive, FrictionLaw, Stiction};
use crate::friction::parts::curve::StribeckCurve;
use crate::friction::parts::dwell::{Dwell, Resting};
use crate::friction::parts::parameters::{check_forces, damping, exponent, force, static_force, stribeck_velocity};
use crate::friction::parts::stick_slip::Mode;
use crate::numbers::{Scalar, Varying};
use crate::parameters;
use crate::variables::{Meaning, ParameterError, Tunable};

parameters! {
    /// Polito friction, set-valued at rest; for `v > 0` (odd in `v`):
    ///
    /// ```text
    /// stuck:          v = 0, F = F_applied   while |F_applied| <= lambda*F_s*(1 + restGrowth*t/(t + gamma))
    /// accelerating:   F = F1(v) = lambda*(F_c1 + (F_s - F_c1)*exp(-(v/v_s)^delta)) + c1*v   [N]
    /// decelerating:   F = F2(v) = lambda*F_c2 + c2*v                                        [N]
    /// ```
    ///
    /// Which branch holds depends on the acceleration, which depends on the branch. Where `F2 <= F1` exactly one choice
    /// is consistent: accelerating for `F_applied > F1`, decelerating for `F_applied < F2`, and in between the speed is
    /// constant and friction balances the applied force. Where `F1 < F2` both branches can be consistent; the one in
    /// force is kept until it is not. Sliding starts on the accelerating branch. The source does not say how break-away grows with the
    /// time `t` at rest; by default it does not.
    ///
    /// # Validity
    /// In the band of forces between `F2` and `F1`, 3 N wide at rest with the defaults, the mass keeps its speed: where the
    /// drive gives way after break-away, it goes on creeping while a Stribeck curve makes it slip and stop. Explicit Euler
    /// with the same equations uses the sign of the previous acceleration, jumps from branch to
    /// branch and slips: those pulses are of the method, not of the law. For stick-slip choose another law.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c1 > F_s` or `F_c2 > F_s`.
    Polito {
        accelerating: StribeckCurve = [
            static_force(10.8),
            force(1, "Fc1", 7.8).meaning(Meaning::CoulombFriction).text("Coulomb friction at increasing speed"),
            stribeck_velocity(0.01),
            exponent(),
        ];
        decelerating_coulomb: Tunable = force(5, "Fc2", 7.8).meaning(Meaning::CoulombFriction).text("Coulomb friction at decreasing speed");
        accelerating_viscous: Tunable = damping(6, "c1", 33.0).meaning(Meaning::ViscousFriction).text("Viscous friction coefficient at increasing speed");
        decelerating_viscous: Tunable = damping(7, "c2", 25.0).meaning(Meaning::ViscousFriction).text("Viscous friction coefficient at decreasing speed");
        dwell: Dwell = Dwell::variables();
    }
}

/// The branch in force while sliding.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Branch {
    /// Speed increases.
    Accelerating,
    /// Speed is constant: friction balances the applied force.
    Steady,
    /// Speed decreases.
    Decelerating,
}

/// Stuck or sliding, and the branch (kept while stuck, without meaning).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory<S> {
    rest: Resting<S>,
    branch: Branch,
}

impl FrictionLaw for Polito {
    type Memory<S: Varying> = Memory<S>;

    fn stiction(&self) -> Stiction {
        Stiction::Exact
    }

    fn asks_for_applied_force(&self) -> bool {
        true
    }

    fn may_differ_by_direction(&self) -> bool {
        true
    }

    fn sliding_direction<S: Varying>(memory: &Memory<S>) -> Option<f64> {
        memory.rest.mode.direction()
    }

    fn events(&self) -> &'static [Event] {
        &[Event::Stop, Event::BreakAway, Event::Rise, Event::Fall]
    }

    fn follows(&self) -> &'static [Drive] {
        Mode::FOLLOWS
    }

    fn check(&self) -> Result<(), ParameterError> {
        check_forces(self.accelerating.static_force, "Fc1", self.accelerating.coulomb_force)?;
        check_forces(self.accelerating.static_force, "Fc2", self.decelerating_coulomb)
    }

    fn is_non_stiff(&self) -> bool {
        self.accelerating.is_non_stiff()
    }

    fn start<S: Varying>(&self, contact: &Contact<S>) -> Memory<S> {
        let rest = Resting::start(contact, |dwell| self.break_away(contact.level, || dwell));
        Memory { rest, branch: Branch::Accelerating }
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], memory: &Memory<S::Held>, _rates: &mut [S]) -> S {
        match (memory.rest.mode, memory.branch) {
            (Mode::Stuck, _) => {
                let dwell = || contact.time - S::held(memory.rest.since);
                Mode::holding_force(contact, self.break_away(contact.level, dwell))
            }
            (Mode::Sliding(direction), Branch::Accelerating) => self.rising(contact, direction) * direction,
            (Mode::Sliding(_), Branch::Steady) => contact.applied,
            (Mode::Sliding(direction), Branch::Decelerating) => self.falling(contact, direction) * direction,
        }
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, _z: &[S], memory: &Memory<S>, out: &mut Indicators<S>) {
        let dwell = || contact.time - memory.rest.since;
        memory.rest.mode.indicators(contact, || self.break_away(contact.level, dwell), out);
        if let (Mode::Sliding(direction), Drive::Force) = (memory.rest.mode, contact.drive) {
            let push = contact.applied * direction;
            let [rising, falling] = self.branches(contact, direction);
            match memory.branch {
                Branch::Accelerating => out[Event::Fall] = push - rising,
                Branch::Decelerating => out[Event::Rise] = falling - push,
                Branch::Steady => {
                    out[Event::Rise] = rising - push;
                    out[Event::Fall] = push - falling;
                }
            }
        }
    }

    fn switch<S: Varying>(
        &self,
        event: Event,
        contact: &Contact<S>,
        velocity: &mut S,
        _z: &mut [S],
        memory: &mut Memory<S>,
    ) {
        if matches!(event, Event::Stop | Event::BreakAway) {
            memory.rest.switch(contact, velocity, |dwell| self.break_away(contact.level, || dwell));
            memory.branch = Branch::Accelerating;
        } else if let Mode::Sliding(direction) = memory.rest.mode {
            memory.branch = self.consistent(contact, direction, memory.branch, event);
        }
    }

    /// A prescribed motion says itself whether it accelerates: its applied force is far beyond both branches.
    fn follow<S: Varying>(&self, contact: &Contact<S>, _z: &[S], memory: &mut Memory<S>) -> bool {
        let before = memory.branch;
        let has_turned = memory.rest.follow(contact, |dwell| self.break_away(contact.level, || dwell));
        let accelerates = (contact.velocity * contact.applied).value() >= 0.0;
        memory.branch = if accelerates { Branch::Accelerating } else { Branch::Decelerating };
        has_turned || memory.branch != before
    }

    fn is_sticking<S: Varying>(memory: &Memory<S>) -> bool {
        memory.rest.mode == Mode::Stuck
    }
}

impl Polito {
    /// Largest force in N that holds the mass after a time at rest in s.
    fn break_away<S: Scalar>(&self, level: S, dwell: impl FnOnce() -> S) -> S {
        self.dwell.grown(level * self.accelerating.static_force, dwell)
    }

    /// `F1` and `F2` in a direction of sliding.
    fn branches<S: Scalar>(&self, contact: &Contact<S>, direction: f64) -> [S; 2] {
        [self.rising(contact, direction), self.falling(contact, direction)]
    }

    /// `F1` at the speed in the direction of sliding.
    fn rising<S: Scalar>(&self, contact: &Contact<S>, direction: f64) -> S {
        let speed = contact.velocity * direction;
        self.accelerating.at(speed.abs(), contact.level) + speed * self.accelerating_viscous
    }

    /// `F2` at the speed in the direction of sliding.
    fn falling<S: Scalar>(&self, contact: &Contact<S>, direction: f64) -> S {
        contact.level * self.decelerating_coulomb + contact.velocity * (self.decelerating_viscous * direction)
    }

    /// The branch to go to at an event of the present one.
    fn consistent<S: Scalar>(&self, contact: &Contact<S>, direction: f64, present: Branch, event: Event) -> Branch {
        let [rising, falling] = self.branches(contact, direction);
        let unique = falling.value() <= rising.value();
        match (present, event) {
            (Branch::Accelerating, _) if unique => Branch::Steady,
            (Branch::Accelerating, _) => Branch::Decelerating,
            (Branch::Decelerating, _) if unique => Branch::Steady,
            (Branch::Decelerating, _) => Branch::Accelerating,
            (Branch::Steady, Event::Rise) => Branch::Accelerating,
            (Branch::Steady, _) => Branch::Decelerating,
        }
    }
}
