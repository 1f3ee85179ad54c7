//! Pressures that change how a seal is lubricated: the Stribeck velocity and the viscous friction of a law.

use crate::numbers::Scalar;

/// Factors, above 0, on the Stribeck velocity and on the viscous friction of a law that [follows](super::FrictionLaw::is_lubricated)
/// them. Neither changes the force at rest, so that they may jump where the motion turns.
#[derive(Clone, Copy, Debug)]
pub struct Lubrication<S> {
    /// Factor on the Stribeck velocity.
    pub stribeck_velocity: S,
    /// Factor on the viscous friction coefficient.
    pub viscous: S,
}

/// How the lubricated parts of a law are taken.
pub trait Film<S: Scalar>: Copy {
    /// The speed in m/s at which the Stribeck curve with the velocity of the law has the friction of a speed.
    fn on_curve(self, speed: S) -> S;

    /// Viscous friction in N, from that with the coefficient of the law.
    fn viscous(self, force: S) -> S;
}

/// With the parameters of the law as they are.
#[derive(Clone, Copy, Debug)]
pub struct Rated;

impl<S: Scalar> Film<S> for Rated {
    #[inline(always)]
    fn on_curve(self, speed: S) -> S {
        speed
    }

    #[inline(always)]
    fn viscous(self, force: S) -> S {
        force
    }
}

impl<S: Scalar> Film<S> for Lubrication<S> {
    #[inline(always)]
    fn on_curve(self, speed: S) -> S {
        speed / self.stribeck_velocity
    }

    #[inline(always)]
    fn viscous(self, force: S) -> S {
        force * self.viscous
    }
}
