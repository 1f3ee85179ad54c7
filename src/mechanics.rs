//! Gravity, contacts that only push, end stops.

use crate::numbers::{Scalar, Tangent, Tangents};
use crate::system::Limits;

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
    pub stiffness: Tangent,
    /// Dissipation coefficient `c` in s/m.
    pub damping: Tangent,
}

impl OneSided {
    /// Force in N at a penetration in m, above 0, that grows at a rate in m/s.
    pub fn force<S: Scalar>(&self, penetration: S, rate: S) -> S {
        (penetration * (rate * self.damping + 1.0) * self.stiffness).max(S::zero())
    }
}

/// End stops at both ends of the stroke: one-sided contacts, which harden where the piston would use up the space behind
/// the stop.
///
/// ```text
/// F = max(0, k*h(-x)*(1 - c*v))            x < 0
/// F = -max(0, k*h(x - stroke)*(1 + c*v))   x > stroke        [N]
/// h(p) = p                                 p <= d/2
///      = p + (d/2)*((p - d/2)/(d - p))^8   d/2 < p < d       [m]
/// ```
///
/// A stop gives way by some tenths of a millimetre. Beyond half the clearance `d`, at which no gas would be left
/// between piston and cover, metal meets metal: the force grows without bound, so no blow carries the piston through. Two
/// hundred million times the energy that the first half takes leave a fortieth of the clearance; a lower power would let
/// hard blows in so far that the rest is lost in the rounding of the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndStops {
    /// Stroke in m.
    pub stroke: Tangent,
    /// The contact at either end.
    pub contact: OneSided,
    /// Clearance `d` in m behind the stop at position 0 and behind that at the end of the stroke.
    pub clearances: Tangents,
}

impl EndStops {
    /// Which of the stops acts at a position in m: that at position 0, that at the end of the stroke.
    #[inline(always)]
    pub fn touched(&self, position: f64) -> [bool; 2] {
        [position < 0.0, position > self.stroke.value]
    }

    /// Positions between which the equations hold for an importer's solver: until a ten thousandth of a
    /// clearance is left, deeper than blows carry the piston.
    pub fn limits(&self) -> Limits {
        const LEFT: f64 = 1e-4;
        let [low, high] = self.clearances.values;
        Limits::between([-low * (1.0 - LEFT), self.stroke.value + high * (1.0 - LEFT)], [low * LEFT, high * LEFT])
    }

    /// Force in N on the carriage towards +x.
    #[inline(always)]
    pub fn force<S: Scalar>(&self, position: S, velocity: S) -> S {
        if position.value() < 0.0 {
            self.contact.force(hardened(-position, self.clearances.side(0)), -velocity)
        } else if position.value() > self.stroke.value {
            -self.contact.force(hardened(position - self.stroke, self.clearances.side(1)), velocity)
        } else {
            S::zero()
        }
    }
}

/// The penetration that a stop of constant stiffness would need for the force of one with a clearance.
fn hardened<S: Scalar>(penetration: S, clearance: Tangent) -> S {
    let half = 0.5 * clearance;
    if penetration.value() <= half.value {
        return penetration;
    }
    let ratio = (penetration - half) / (-penetration + clearance);
    let square = ratio * ratio;
    let fourth = square * square;
    penetration + fourth * fourth * half
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::{Real, STILL};

    const STOPS: EndStops = EndStops {
        stroke: Tangent::still(0.5),
        contact: OneSided { stiffness: Tangent::still(1e6), damping: Tangent::still(0.75) },
        clearances: Tangents { values: [0.02, 0.03], slopes: [STILL; 2] },
    };

    fn force(position: f64, velocity: f64) -> f64 {
        STOPS.force(Real::of(position), Real::of(velocity)).value
    }

    #[test]
    fn stops_are_linear_up_to_half_the_clearance_and_let_nothing_through() {
        assert_eq!(force(-0.01, 0.0), 0.01 * 1e6);
        assert!((force(-0.010_001, 0.0) - force(-0.01, 0.0) - 1.0).abs() < 1e-3);
        assert!((force(-0.015, 0.0) - (0.015 + 0.01) * 1e6).abs() < 1e-6);
        assert!(force(-0.019_999, 0.0) > 1e12 * 0.02 * 0.02);
        assert_eq!(force(0.515, 0.0), -(0.515 - 0.5) * 1e6);
        assert!(force(0.529_999, 0.0) < -1e8);
    }

    /// The midpoint rule is 1e-6 off.
    #[test]
    fn any_blow_leaves_some_of_the_clearance() {
        let (count, end) = (100_000, 0.02 * (1.0 - 1.0 / 40.0));
        let width = end / f64::from(count);
        let work: f64 = (0..count).map(|i| force(-width * (f64::from(i) + 0.5), 0.0) * width).sum();
        let first_half = 0.5 * 1e6 * 0.01 * 0.01;
        assert!((work / first_half - 2.27e8).abs() < 0.01e8, "{} times", work / first_half);
    }

    #[test]
    fn stops_act_only_beyond_the_stroke_and_never_pull() {
        assert_eq!(force(0.25, 3.0), 0.0);
        assert!((force(-1e-4, 0.0) - 100.0).abs() < 1e-9);
        assert!((force(0.5001, 0.0) + 100.0).abs() < 1e-9);
        assert_eq!(force(-1e-4, 2.0), 0.0);
    }

    /// The approach is damped, the rebound weakened: both stops are mirror images.
    #[test]
    fn stops_are_symmetric() {
        for velocity in [-0.5, 0.0, 0.5] {
            let (low, high) = (force(-2e-4, velocity), force(0.5002, -velocity));
            assert!((low + high).abs() < 1e-9);
        }
    }
}
