//! Karnopp's zero-velocity band.

use serde::{Deserialize, Serialize};

use super::stick_slip::Mode as StickSlip;
use super::stribeck::{StribeckCurve, coulomb_force, exponent, static_force, stribeck_velocity, velocity, viscous};
use super::{Contact, Drive, FrictionLaw, Indicators};
use crate::parameters;
use crate::scalar::{Scalar, sign};
use crate::variables::ParameterError;

parameters! {
    /// Parameters of [`Karnopp`].
    Parameters {
        static_force: f64 = static_force(11.0);
        coulomb_force: f64 = coulomb_force(8.3);
        stribeck_velocity: f64 = stribeck_velocity(0.01);
        exponent: f64 = exponent();
        viscous: f64 = viscous(30.0);
        band: f64 = velocity(5, "DV", 1e-4).text("Half width of the band of velocities that count as rest");
    }
}

/// Karnopp friction: the velocity is a state `w` that is reported as 0 inside a band.
///
/// ```text
/// |w| < DV:  v = 0, dx/dt = 0, F = clamp(F_applied, -lambda*F_s, lambda*F_s)
/// otherwise: v = w, F = s(v)*sgn(v) + sigma2*v   [N], s the Stribeck curve
/// ```
///
/// Where the force just outside the band exceeds `lambda*F_s`, an applied force between the two would drive `w`
/// towards the edge from both sides; `w` then rests on the edge with `F = F_applied` (the solution of Filippov). It
/// does so, too, where the applied force is larger with `v = 0` than with `v = w` (a damper does that), as long as `w`
/// would come back at once.
///
/// # Errors
/// [`ParameterError`] for `F_c > F_s`.
///
/// # Source
/// Karnopp (1985), ASME J. Dynamic Systems, Measurement, and Control 107(1):100-103.
#[derive(Clone, Debug)]
pub struct Karnopp {
    curve: StribeckCurve,
    viscous: f64,
    band: f64,
}

/// Where `w` is and what it does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mode {
    /// In the band, `w` constant: friction balances the applied force.
    Held(Hold),
    /// In the band, `w` moving in a direction under the force beyond `F_s`.
    Crossing(f64),
    /// Outside the band, in a direction.
    Sliding(f64),
}

/// What is held on the edge of the band beyond the force of the law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hold {
    /// Time in s since when `w` is held.
    since: f64,
    /// Force in N by which the applied force fell short of friction when `w` came to the edge from outside.
    deficit: f64,
    /// Force in N that is held in any case.
    limit: f64,
}

impl FrictionLaw for Karnopp {
    type Memory = Mode;
    type Parameters = Parameters;

    fn new(p: Parameters) -> Result<Self, ParameterError> {
        let curve = StribeckCurve::new(p.static_force, p.coulomb_force, p.stribeck_velocity, p.exponent)?;
        Ok(Self { curve, viscous: p.viscous, band: p.band })
    }

    fn start(&self, contact: &Contact<f64>, _z: &mut [f64]) -> Mode {
        if contact.velocity.abs() >= self.band {
            Mode::Sliding(sign(contact.velocity))
        } else {
            self.in_band(contact, contact.velocity)
        }
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], mode: &Mode, _rates: &mut [S]) -> S {
        match *mode {
            Mode::Held(_) => StickSlip::holding_force(contact, contact.level.value() * self.curve.static_force),
            Mode::Crossing(direction) => contact.level * (direction * self.curve.static_force),
            Mode::Sliding(direction) => self.sliding(contact.velocity, direction, contact.level),
        }
    }

    fn indicators(&self, contact: &Contact<f64>, _z: &[f64], mode: &Mode, out: &mut Indicators) {
        let w = contact.velocity;
        match (*mode, contact.drive) {
            (Mode::Held(hold), Drive::Force) => out.push(self.reserve(contact, w, hold.limit)),
            (Mode::Held(_), Drive::Motion) => out.push(self.band - w.abs()),
            (Mode::Crossing(direction), _) => {
                out.push(self.band - direction * w);
                out.push(direction * contact.applied - contact.level * self.curve.static_force);
            }
            (Mode::Sliding(direction), _) => out.push(direction * w - self.band),
        }
    }

    fn switch(&self, event: usize, contact: &Contact<f64>, velocity: &mut f64, _z: &mut [f64], mode: &mut Mode) {
        if contact.drive == Drive::Motion {
            *mode = self.start(contact, &mut []);
            return;
        }
        *mode = match *mode {
            Mode::Sliding(direction) => {
                *velocity = direction * self.band;
                let deficit = self.sliding(self.band, 1.0, contact.level) - direction * contact.applied;
                match self.in_band(contact, *velocity) {
                    Mode::Held(hold) => Mode::Held(Hold { deficit, ..hold }),
                    other => other,
                }
            }
            Mode::Crossing(direction) if event == 0 => {
                *velocity = direction * self.band;
                self.in_band(contact, *velocity)
            }
            Mode::Crossing(_) => Self::held_since(contact.time),
            Mode::Held(hold) if hold.since == contact.time && hold.deficit > 0.0 => {
                Mode::Held(Hold { deficit: 0.0, limit: contact.applied.abs() + hold.deficit, ..hold })
            }
            Mode::Held(_) => self.in_band(contact, *velocity),
        };
    }

    fn is_sticking(&self, mode: &Mode) -> bool {
        !matches!(mode, Mode::Sliding(_))
    }
}

impl Karnopp {
    fn sliding<S: Scalar>(&self, velocity: S, direction: f64, level: S) -> S {
        self.curve.level(velocity.abs(), level) * direction + velocity * self.viscous
    }

    /// The mode at a `w` inside the band or on its edge.
    fn in_band(&self, contact: &Contact<f64>, w: f64) -> Mode {
        if contact.drive == Drive::Motion || self.reserve(contact, w, 0.0) >= 0.0 {
            return Self::held_since(contact.time);
        }
        let direction = sign(contact.applied);
        if direction * w >= self.band { Mode::Sliding(direction) } else { Mode::Crossing(direction) }
    }

    fn held_since(since: f64) -> Mode {
        Mode::Held(Hold { since, deficit: 0.0, limit: 0.0 })
    }

    /// By how much the holding force, at least `held` on the edge, exceeds the applied force.
    fn reserve(&self, contact: &Contact<f64>, w: f64, held: f64) -> f64 {
        let static_force = contact.level * self.curve.static_force;
        let direction = sign(contact.applied);
        let outside = self.sliding(self.band, 1.0, contact.level);
        let limit = if direction * w >= self.band { static_force.max(outside).max(held) } else { static_force };
        limit - contact.applied.abs()
    }
}
