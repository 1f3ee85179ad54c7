//! Stick-slip with an anchored spring-damper.

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, Drive, FrictionLaw, Stiction};
use crate::friction::parts::anchored::{Limits, Mode, Spring};
use crate::friction::parts::parameters::{check_forces, coulomb_force, damping, static_force, stiffness, viscous};
use crate::numbers::{Scalar, Varying};
use crate::parameters;
use crate::variables::{ParameterError, Tunable};

parameters! {
    /// Stick-slip friction with a spring-damper that is anchored where the mass stuck.
    ///
    /// ```text
    /// sticking:  F = k*(x - x_s) + d*v               until |F| > lambda*F_s   [N]
    /// sliding:   F = lambda*F_c*sgn(v) + sigma2*v    until v crosses 0        [N]
    /// ```
    ///
    /// The anchor `x_s` keeps `F` continuous when the mass sticks again; at the start the spring carries no load.
    ///
    /// # Validity
    /// Sticking is an oscillation of frequency `sqrt(k/m)` about the anchor, not a rest. At break-away the force jumps from
    /// `F_s` to `F_c`. A load factor that falls below the force of a loaded spring lets the mass slide; while a
    /// prescribed motion rests or unloads the spring, the spring yields.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s`.
    ///
    /// # Source
    /// After the stick-slip force of Simpack, as the literature on multibody programs describes it.
    StickSlipSpring {
        static_force: Tunable = static_force(11.0);
        coulomb_force: Tunable = coulomb_force(8.3);
        viscous: Tunable = viscous(30.0);
        spring: Spring = [
            stiffness(5, "k", 1e5).text("Contact stiffness while sticking"),
            damping(6, "d", 300.0).text("Contact damping while sticking"),
        ];
    }
}

impl FrictionLaw for StickSlipSpring {
    type Memory<S: Varying> = Mode<S>;

    fn stiction(&self) -> Stiction {
        Stiction::Elastic
    }

    fn events(&self) -> &'static [Event] {
        &[Event::Stop, Event::BreakAway]
    }

    fn follows(&self) -> &'static [Drive] {
        &[Drive::Motion]
    }

    fn is_non_stiff(&self) -> bool {
        true
    }

    fn check(&self) -> Result<(), ParameterError> {
        check_forces(self.static_force, "Fc", self.coulomb_force)
    }

    fn start<S: Varying>(&self, contact: &Contact<S>) -> Mode<S> {
        Spring::start(contact, self.limits(contact))
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], mode: &Mode<S::Held>, _rates: &mut [S]) -> S {
        match *mode {
            Mode::Sticking { place, load } => {
                self.spring.holding(contact, place, load, || self.limits(contact).break_away)
            }
            Mode::Sliding { direction } => {
                contact.level * (self.coulomb_force * direction) + contact.velocity * self.viscous
            }
        }
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, _z: &[S], mode: &Mode<S>, out: &mut Indicators<S>) {
        self.spring.indicate(*mode, contact, self.limits(contact), out);
    }

    fn switch<S: Varying>(&self, _event: Event, contact: &Contact<S>, _v: &mut S, _z: &mut [S], mode: &mut Mode<S>) {
        *mode = self.spring.switched(*mode, contact, self.limits(contact));
    }

    fn follow<S: Varying>(&self, contact: &Contact<S>, _z: &[S], mode: &mut Mode<S>) -> bool {
        let Some(yielded) = self.spring.yielded(*mode, contact, self.limits(contact)) else { return false };
        *mode = yielded;
        true
    }

    fn is_sticking<S: Varying>(mode: &Mode<S>) -> bool {
        matches!(mode, Mode::Sticking { .. })
    }
}

impl StickSlipSpring {
    fn limits<S: Scalar>(&self, contact: &Contact<S>) -> Limits<S> {
        Limits { break_away: contact.level * self.static_force, sliding: contact.level * self.coulomb_force }
    }
}
