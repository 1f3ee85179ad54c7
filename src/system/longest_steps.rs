//! Stability limits of explicit steps where something swings or relaxes quickly. Beyond them, errors of rounding would
//! grow to the tolerance where nothing moves.

/// Product of the rate of a swing or a relaxation and the step size up to which the classical method damps it, at any damping:
/// at a damping ratio of a half it is 2.62, at others up to 2.95.
const STABLE: f64 = 2.6;

/// The longest steps in s of explicit methods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LongestSteps {
    /// Of the classical one, of order 4.
    pub classical: f64,
    /// Of the midpoint rule.
    pub midpoint: f64,
}

impl LongestSteps {
    /// Where nothing limits them.
    pub const UNLIMITED: Self = Self { classical: f64::INFINITY, midpoint: f64::INFINITY };

    /// Longest steps that damp an oscillation `d2x/dt2 + damping*dx/dt + rate^2*x = 0`, from its rate in rad/s and its
    /// damping in 1/s.
    ///
    /// In each step the midpoint rule multiplies it by `1 + z + z^2/2`, with `z` the step size times a root of
    /// `s^2 + damping*s + rate^2`. With `r = |z|` and a damping ratio `D` that is no more than 1 in magnitude where
    /// `r^3/4 - D*r^2 + 2*D^2*r - 2*D <= 0`. At `r = 2*cbrt(D)` the left side is `-2*D*r*(cbrt(D) - D)`.
    pub fn of_swing(rate: f64, damping: f64) -> Self {
        let half = 0.5 * damping;
        // Nothing swings: no step is too long, and nothing may divide by zero where a host traps that.
        if half == 0.0 && rate == 0.0 {
            return Self::UNLIMITED;
        }
        if half < rate {
            return Self { classical: STABLE / rate, midpoint: 2.0 * libm::cbrt(half / rate) / rate };
        }
        // Overdamped: the faster of two relaxations limits the step.
        let fastest = half + (half * half - rate * rate).sqrt();
        Self { classical: STABLE / fastest, midpoint: 2.0 / fastest }
    }

    /// The shorter ones of both.
    pub fn min(self, other: Self) -> Self {
        Self { classical: self.classical.min(other.classical), midpoint: self.midpoint.min(other.midpoint) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By how much 20 000 steps of a size in s of an explicit method let a swing of rate 1 grow, whose stages each use the one before.
    fn growth(times: &[f64], damping: f64, h: f64) -> f64 {
        let (mut position, mut velocity) = (1.0, 0.0);
        for _ in 0..20_000 {
            let mut slope = [0.0, 0.0];
            let slopes = times.iter().map(|time| {
                let at = [position + time * h * slope[0], velocity + time * h * slope[1]];
                slope = [at[1], -at[0] - damping * at[1]];
                slope
            });
            let slopes: Vec<[f64; 2]> = slopes.collect();
            let mean = |i: usize| match slopes[..] {
                [_, middle] => middle[i],
                [first, second, third, fourth] => (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]) / 6.0,
                _ => panic!("neither method"),
            };
            (position, velocity) = (position + h * mean(0), velocity + h * mean(1));
            if position.abs() > 1e6 {
                break;
            }
        }
        position.hypot(velocity)
    }

    const MIDPOINT: [f64; 2] = [0.0, 0.5];
    const CLASSICAL: [f64; 4] = [0.0, 0.5, 0.5, 1.0];

    #[test]
    fn longest_steps_are_stable_and_not_much_longer_ones_are_not() {
        for ratio in [0.003, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 1.1, 1.5, 4.0] {
            let damping = 2.0 * ratio;
            let longest = LongestSteps::of_swing(1.0, damping);
            for (method, step) in [(&MIDPOINT[..], longest.midpoint), (&CLASSICAL, longest.classical)] {
                let at_once = growth(method, damping, step);
                // A swing that is neither damped nor not keeps its size, which depends on its phase.
                assert!(at_once < 3.0, "{at_once} at {ratio} with {} stages", method.len());
                let beyond = growth(method, damping, 1.3 * step);
                assert!(beyond > 1e3, "{beyond} at {ratio} with {} stages", method.len());
            }
        }
    }

    #[test]
    fn swing_without_damping_is_not_for_the_midpoint_rule() {
        let longest = LongestSteps::of_swing(100.0, 0.0);
        assert_eq!((longest.midpoint, longest.classical), (0.0, 2.6 / 100.0));
        assert!(growth(&MIDPOINT, 0.0, 0.5) > 1e3 && growth(&CLASSICAL, 0.0, 2.6) < 1.0);
        let nothing_swings = LongestSteps::of_swing(0.0, 0.0).min(LongestSteps { classical: 0.01, midpoint: 0.005 });
        assert_eq!((nothing_swings.classical, nothing_swings.midpoint), (0.01, 0.005));
    }
}
