//! A deflection that follows the motion up to limits, where it waits until the motion turns back.
//!
//! A limit that falls below a deflection that follows takes effect as soon as the motion adds to the deflection.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::numbers::{Scalar, sign};

/// Deflections closer to the limit than this fraction of it count as having reached it.
const AT_LIMIT: f64 = 1e-12;

/// The mode of a bounded deflection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Mode {
    /// Within the limits: the deflection follows the motion.
    #[default]
    Following,
    /// At the limit in a direction, +1 or -1, while the motion points there.
    Limited(f64),
}

impl Mode {
    /// The deflection in m, of which `z` is the state.
    pub fn deflection<S: Scalar>(self, z: S, limit: S) -> S {
        match self {
            Self::Following => z,
            Self::Limited(direction) => limit * direction,
        }
    }

    /// Its rate in m/s.
    pub fn rate<S: Scalar>(self, velocity: S) -> S {
        match self {
            Self::Following => velocity,
            Self::Limited(_) => S::zero(),
        }
    }

    /// Sets the event indicator: the reserve until the limit, which does not matter while the motion turns away from
    /// it; or the speed towards it.
    pub fn indicate<S: Scalar>(self, velocity: S, z: S, limit: S, out: &mut Indicators<S>) {
        match self {
            Self::Following => {
                out[Event::Distance] = (limit * (1.0 - AT_LIMIT) - z.abs()).max(velocity * -sign(z.value()));
            }
            Self::Limited(direction) => out[Event::Stop] = velocity * direction,
        }
    }

    /// The mode after an event of the present one.
    pub fn switched<S: Scalar>(self, z: &mut S, limit: S) -> Self {
        let direction = match self {
            Self::Following => sign(z.value()),
            Self::Limited(direction) => direction,
        };
        *z = limit * direction;
        match self {
            Self::Following => Self::Limited(direction),
            Self::Limited(_) => Self::Following,
        }
    }
}
