//! Between which values of a state its equations are taken as they are, and how they go on beyond.

/// Largest distance of a state from 0, in magnitudes: beyond any run, and below overflow in a power.
const FAR: f64 = 1e9;

/// Continuation of the equations of a state beyond a limit next to a pole, in magnitudes.
const BEYOND: f64 = 1e-6;

/// The values of a state at which the equations have a meaning, and the room beyond them.
///
/// The solver of an importer tries values that no run reaches, and accepts them if it diverges. Beyond a limit the equations use a
/// value that exceeds it by less than the `give`, with a continuous second derivative:
///
/// ```text
/// n(x) = high + g*u/sqrt(1 + u^2),  u = (x - high)/g     x > high, and mirrored below low
///      = x                                               low <= x <= high
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    low: f64,
    high: f64,
    /// Largest excess over the limits in the equations.
    give: [f64; 2],
    /// Whether the equations lose their meaning beyond them, and do not just overflow far out.
    bounds_meaning: [bool; 2],
}

impl Limits {
    /// A state that is valid at every value: limits of a thousand million magnitudes either way.
    pub fn of_magnitude(scale: f64) -> Self {
        let far = FAR * scale;
        Self { low: -far, high: far, give: [far; 2], bounds_meaning: [false; 2] }
    }

    /// A state of a magnitude that must be above 0, such as a pressure: not below a least value, of which the equations
    /// never see less than half.
    pub fn above(least: f64, scale: f64) -> Self {
        let far = Self::of_magnitude(scale);
        Self { low: least, give: [0.5 * least, FAR * scale], bounds_meaning: [true, false], ..far }
    }

    /// A state between two values, with the room beyond each.
    pub fn between([low, high]: [f64; 2], left: [f64; 2]) -> Self {
        Self { low, high, give: left.map(|left| 0.5 * left), bounds_meaning: [true; 2] }
    }

    /// A state of a magnitude between two values, which may be infinite; the equations see hardly anything beyond a finite one, and
    /// never less than half of a positive lower one.
    pub fn within([low, high]: [f64; 2], scale: f64) -> Self {
        let (mut limits, beyond) = (Self::of_magnitude(scale), BEYOND * scale);
        if low.is_finite() {
            let give = if low > 0.0 { 0.5 * low } else { beyond };
            (limits.low, limits.give[0], limits.bounds_meaning[0]) = (low, give, true);
        }
        if high.is_finite() {
            (limits.high, limits.give[1], limits.bounds_meaning[1]) = (high, beyond, true);
        }
        limits
    }

    /// Whether a value is between them.
    pub fn hold(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// The value that the equations use in place of another, and its derivative by that.
    pub fn nearest(&self, value: f64) -> (f64, f64) {
        let (limit, give) = if value < self.low {
            (self.low, -self.give[0])
        } else if value > self.high {
            (self.high, self.give[1])
        } else {
            return (value, 1.0);
        };
        let (share, slope) = saturated((value - limit) / give);
        (limit + give * share, slope)
    }

    /// The limit of meaning that a value is beyond, for messages.
    pub fn passed(&self, value: f64) -> Option<String> {
        let [bounds_low, bounds_high] = self.bounds_meaning;
        if bounds_low && value < self.low {
            Some(format!("below {}", self.low))
        } else if bounds_high && value > self.high {
            Some(format!("above {}", self.high))
        } else {
            None
        }
    }
}

/// `u/sqrt(1 + u^2)` and its derivative for `u >= 0`, however large.
fn saturated(u: f64) -> (f64, f64) {
    if u <= 1.0 {
        let square = 1.0 + u * u;
        return (u / square.sqrt(), 1.0 / (square * square.sqrt()));
    }
    let inverse = 1.0 / u;
    let square = 1.0 + inverse * inverse;
    (1.0 / square.sqrt(), inverse * inverse * inverse / (square * square.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_between_the_limits_are_left_as_they_are() {
        let limits = Limits::above(1.0, 1e5);
        for value in [1.0, 1.5, 1e5, 1e14] {
            assert_eq!(limits.nearest(value), (value, 1.0));
            assert!(limits.hold(value) && limits.passed(value).is_none());
        }
        for value in [1.0f64.next_down(), 0.0, -1e300] {
            assert!(!limits.hold(value) && limits.passed(value).is_some(), "{value}");
        }
        assert_eq!(limits.passed(-3.0).as_deref(), Some("below 1"));
        assert_eq!(Limits::between([0.0, 2.5], [1.0; 2]).passed(3.0).as_deref(), Some("above 2.5"));
        // Far out only numbers end, not the meaning of the equations.
        assert!(!limits.hold(1e14f64.next_up()) && limits.passed(1e300).is_none());
    }

    /// Half of a least value, twice the magnitudes from 0, half of the room beyond other limits.
    #[test]
    fn however_far_a_value_is_the_equations_see_one_nearby() {
        let seen = |limits: Limits| [-1e300, 1e300].map(|value| limits.nearest(value).0);
        assert_eq!(seen(Limits::above(2.0, 1e5)), [1.0, 2e14]);
        assert_eq!(seen(Limits::of_magnitude(3.0)), [-6e9, 6e9]);
        assert_eq!(seen(Limits::between([-1.0, 3.0], [0.5, 0.25])), [-1.25, 3.125]);
    }

    /// Derivatives equal differences, and are never negative; the second derivative vanishes at the limit.
    #[test]
    fn values_beyond_follow_smoothly_and_monotonically() {
        for limits in [Limits::above(2.0, 1e-8), Limits::between([-1.0, 3.0], [0.1, 0.4]), Limits::of_magnitude(1e-9)] {
            for (limit, side, give) in [(limits.low, -1.0, limits.give[0]), (limits.high, 1.0, limits.give[1])] {
                let mut before = (limit, 1.0);
                for count in 1..2000 {
                    let u = 1e-2 * f64::from(count);
                    let at = |u: f64| limits.nearest(limit + side * give * u);
                    let (value, slope) = at(u);
                    assert!((value - before.0) * side > 0.0 && slope < before.1 && slope > 0.0, "{u}");
                    let difference = (at(u + 1e-5).0 - at(u - 1e-5).0) / (2e-5 * give * side);
                    // The third derivative is at most 3; rounding, relative to the limit.
                    let rounding = 1e-15 * (limit.abs() + give) / (1e-5 * give);
                    assert!((slope - difference).abs() <= 1e-9 + rounding, "{u}: {slope}, not {difference}");
                    before = (value, slope);
                }
                let (near, slope) = limits.nearest(limit + side * give * 1e-4);
                assert!((near - limit) * side > 0.0 && 1.0 - slope < 2e-8, "{slope}");
            }
        }
    }

    #[test]
    fn values_without_end_stay_within_the_give() {
        let limits = Limits::above(1.0, 1e5);
        assert_eq!(limits.nearest(-f64::MAX), (0.5, 0.0));
        assert_eq!(limits.nearest(f64::MAX), (2e14, 0.0));
        assert_eq!(limits.nearest(-1e300), (0.5, 0.0));
    }
}
