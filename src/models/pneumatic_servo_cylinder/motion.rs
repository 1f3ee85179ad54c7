//! A motion that a multibody tool imposes: on the carriage itself, or on the far end of a spring at the carriage.
//!
//! Inputs are the position `x_i` and the velocity `v_i` of the tool's body. In a communication step from `t_b` to `t_e` the
//! imposed point moves with
//!
//! ```text
//! v(t) = v_i(t) + c,   c = (x_e - x_b - integral of v_i from t_b to t_e)/(t_e - t_b)
//! x_e  = x_i(t_e)                               where x_i has a derivative
//!      = x_i(t_b) + integral of v_i             where it is held
//! ```
//!
//! `x_b` is where the point is when the step begins, so that a drift between position and velocity is made up within one
//! step. Before the first step, and in equations that a host integrates, the point is at `x_i` and moves with `v_i`.
//!
//! ```text
//! rigid:      dx/dt = v                 F_rod = F_p + F_stop + F_spring - F_wire - F_f
//! compliant:  m*dv_c/dt = F_app - F_f - F_rod,   F_rod = (x_c - x)/compliance + d*(v_c - v)
//! ```
//!
//! Of a rigid motion the mass, its weight and the external force are the tool's own.

use serde::{Deserialize, Serialize};

use crate::enumeration;
use crate::friction::Trend;
use crate::numbers::{Scalar, Tangent, Varying};
use crate::system::LongestSteps;

enumeration! {
    /// The choice of the carriage's drive; ids are never reused.
    Motion "CylinderMotion": "What moves the carriage" {
        1 Free: "Forces: pressures, friction and externalForce";
        2 Imposed: "imposedPosition and imposedVelocity, rigidly or through coupling.compliance; rodForce is the reaction force";
    }
}

/// Drive of the carriage, with its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Guidance {
    /// By forces alone.
    Free,
    /// As imposed.
    Rigid,
    /// By forces, including a spring whose far end moves as imposed.
    Compliant {
        /// Stiffness in N/m.
        stiffness: Tangent,
        /// Damping in N.s/m.
        damping: Tangent,
    },
}

/// Position and velocity of the imposed point at an instant, or the inputs for them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Imposed<S> {
    /// Position in m.
    pub position: S,
    /// Velocity in m/s.
    pub velocity: S,
}

/// Discrete state of an imposed motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Memory<S> {
    /// The path of the present communication step, or of the last one; none before the first.
    path: Option<ImposedPath<S>>,
    /// Change of the carriage's speed.
    pub trend: Trend<S>,
}

/// The motion of the imposed point in a communication step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct ImposedPath<S> {
    /// Time in s at which the step begins.
    begin: f64,
    /// Position in m there.
    position: S,
    /// Velocity in m/s there.
    velocity: S,
    /// The part of it beyond the input.
    correction: S,
    /// Acceleration in m/s2.
    acceleration: f64,
}

impl<S: Varying> ImposedPath<S> {
    fn position<T: Scalar<Held = S>>(&self, time: T) -> T {
        let elapsed = time - self.begin;
        T::held(self.position) + (T::held(self.velocity) + elapsed * (0.5 * self.acceleration)) * elapsed
    }
}

impl<S: Varying> Memory<S> {
    /// The memory of a run that starts with a velocity of the carriage in m/s.
    pub fn new(velocity: S) -> Self {
        Self { path: None, trend: Trend::new(velocity) }
    }

    /// The imposed point, given the inputs.
    pub fn imposed<T: Scalar<Held = S>>(&self, time: T, given: Imposed<T>) -> Imposed<T> {
        let Some(path) = &self.path else { return given };
        Imposed { position: path.position(time), velocity: given.velocity + T::held(path.correction) }
    }

    /// Acceleration in m/s2 of the imposed point.
    pub fn acceleration(&self) -> f64 {
        self.path.map_or(0.0, |path| path.acceleration)
    }

    /// Takes notice of a communication step from a time on and of a duration, both in s; `from` is where the carriage is, if it
    /// moves as imposed.
    pub fn begin(&mut self, [begin, duration]: [f64; 2], from: Option<S>, given: Imposed<S>, slopes: Imposed<f64>) {
        let here = || self.path.map_or(given.position, |path| path.position(S::of(begin)));
        let position = from.unwrap_or_else(here);
        let acceleration = slopes.velocity;
        let travel = (given.velocity + S::of(0.5 * acceleration * duration)) * duration;
        let slope = slopes.position;
        let end = given.position + if slope != 0.0 { S::of(slope * duration) } else { travel };
        let correction = (end - position - travel) / duration;
        let velocity = given.velocity + correction;
        self.path = Some(ImposedPath { begin, position, velocity, correction, acceleration });
    }

    /// Whether a run can have it.
    pub fn is_sound(&self) -> bool {
        let numbers = self.path.map(|ImposedPath { begin, position, velocity, correction, acceleration }| {
            [begin, position.value(), velocity.value(), correction.value(), acceleration]
        });
        self.trend.is_sound() && numbers.is_none_or(|numbers| numbers.iter().all(|number| number.is_finite()))
    }
}

impl Guidance {
    /// The longest explicit steps for a mass in kg at the spring.
    pub fn longest(self, mass: f64) -> LongestSteps {
        match self {
            Self::Free | Self::Rigid => LongestSteps::UNLIMITED,
            Self::Compliant { stiffness, damping } => {
                LongestSteps::of_swing((stiffness.value / mass).sqrt(), damping.value / mass)
            }
        }
    }

    /// Force in N of the spring on the carriage towards +x, which is at a position in m and moves with a velocity in m/s.
    pub fn force<S: Scalar>(self, imposed: Imposed<S>, position: S, velocity: S) -> S {
        match self {
            Self::Free | Self::Rigid => S::zero(),
            Self::Compliant { stiffness, damping } => {
                (imposed.position - position) * stiffness + (imposed.velocity - velocity) * damping
            }
        }
    }
}
