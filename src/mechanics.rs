//! Gravity, contacts that only push, end stops.

use crate::numbers::Scalar;

/// Standard acceleration of gravity in m/s2.
pub const GRAVITY: f64 = 9.80665;

/// An elastic contact with a dissipative part, or a rope whose stretch is the penetration: it acts in one sense only.
///
/// ```text
/// F = max(0, k*p*(1 + c*dp/dt))   p > 0   [N]
/// ```
///
/// # Source
/// Hunt, Crossley (1975), ASME J. Applied Mechanics 42(2):440-445.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneSided {
    /// Stiffness `k` in N/m.
    pub stiffness: f64,
    /// Dissipation coefficient `c` in s/m.
    pub damping: f64,
}

impl OneSided {
    /// Force in N at a penetration in m, above 0, that grows at a rate in m/s.
    pub fn force<S: Scalar>(&self, penetration: S, rate: S) -> S {
        (penetration * (rate * self.damping + 1.0) * self.stiffness).max(S::zero())
    }
}

/// End stops at both ends of the stroke: one-sided contacts.
///
/// ```text
/// F = max(0, k*(-x)*(1 - c*v))            x < 0
/// F = -max(0, k*(x - stroke)*(1 + c*v))   x > stroke   [N]
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndStops {
    /// Stroke in m.
    pub stroke: f64,
    /// The contact at either end.
    pub contact: OneSided,
}

impl EndStops {
    /// Force in N on the carriage towards +x.
    #[inline(always)]
    pub fn force<S: Scalar>(&self, position: S, velocity: S) -> S {
        if position.value() < 0.0 {
            self.contact.force(-position, -velocity)
        } else if position.value() > self.stroke {
            -self.contact.force(position - self.stroke, velocity)
        } else {
            S::zero()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STOPS: EndStops = EndStops { stroke: 0.5, contact: OneSided { stiffness: 1e6, damping: 0.75 } };

    #[test]
    fn stops_act_only_beyond_the_stroke_and_never_pull() {
        assert_eq!(STOPS.force(0.25, 3.0), 0.0);
        assert!((STOPS.force(-1e-4, 0.0) - 100.0).abs() < 1e-9);
        assert!((STOPS.force(0.5001, 0.0) + 100.0).abs() < 1e-9);
        assert_eq!(STOPS.force(-1e-4, 2.0), 0.0);
    }

    /// The approach is damped, the rebound weakened: both stops are mirror images.
    #[test]
    fn stops_are_symmetric() {
        for velocity in [-0.5, 0.0, 0.5] {
            let (low, high) = (STOPS.force(-2e-4, velocity), STOPS.force(0.5002, -velocity));
            assert!((low + high).abs() < 1e-9);
        }
    }
}
