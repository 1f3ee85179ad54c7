//! Finding where an indicator crosses zero within a step.

use super::array;

/// The states within a step: the cubic through the values and derivatives at both ends.
pub struct Hermite<'a, const N: usize> {
    /// States at the start.
    pub start: &'a [f64; N],
    /// Derivatives at the start.
    pub start_slope: &'a [f64; N],
    /// States at the end.
    pub end: &'a [f64; N],
    /// Derivatives at the end.
    pub end_slope: &'a [f64; N],
    /// Size of the step in s.
    pub h: f64,
}

impl<const N: usize> Hermite<'_, N> {
    /// The states at a fraction of the step.
    pub fn at(&self, fraction: f64) -> [f64; N] {
        let weights = self.weights(fraction);
        array(|i| self.weighted(i, weights))
    }

    /// The derivatives of the states at a fraction of the step.
    #[cfg(feature = "sensitivities")]
    pub fn rates(&self, fraction: f64) -> [f64; N] {
        let rest = 1.0 - fraction;
        let (mean, product) = (6.0 * fraction * rest / self.h, 2.0 * fraction * rest);
        let [of_start, of_end] = [rest * rest - product, fraction * fraction - product];
        array(|i| mean * (self.end[i] - self.start[i]) + of_start * self.start_slope[i] + of_end * self.end_slope[i])
    }

    /// The fraction of the step, to a given width, at which a state that has other signs at the ends is zero.
    pub fn zero(&self, state: usize, width: f64) -> Option<f64> {
        let (start, end) = (self.start[state], self.end[state]);
        let towards_start = start.signum();
        let is_between = towards_start * start > 0.0 && towards_start * end < 0.0;
        let bracket = Bracket::new((0.0, start.abs()), (1.0, -end.abs()));
        let value = |fraction| towards_start * self.weighted(state, self.weights(fraction));
        is_between.then(|| root(bracket, width, value))
    }

    fn weighted(&self, i: usize, [value, start_slope, end_slope]: [f64; 3]) -> f64 {
        self.start[i] + value * (self.end[i] - self.start[i]) + start_slope * self.start_slope[i]
            - end_slope * self.end_slope[i]
    }

    fn weights(&self, fraction: f64) -> [f64; 3] {
        let rest = 1.0 - fraction;
        [
            fraction * fraction * (3.0 - 2.0 * fraction),
            fraction * rest * rest * self.h,
            fraction * fraction * rest * self.h,
        ]
    }
}

/// Looks by chords in which a bracket must halve.
const PATIENCE: u32 = 4;

/// An interval at whose start a function is positive and at whose end it is not.
///
/// The bracket is narrowed by regula falsi. Where it moves the same end again, the value at the other is reduced by the
/// curvature of the last move, so that the next one tends to come from there. Where an indicator is steep before the root
/// and flat behind, chords are of little help: if a few do not halve the bracket, it is bisected.
///
/// # Source
/// Anderson, Björck (1973), BIT 13:253-264.
#[derive(Clone, Copy, Debug)]
pub struct Bracket {
    low: (f64, f64),
    high: (f64, f64),
    /// Whether the end moved last is the low one.
    moved_low: Option<bool>,
    /// Width to which a few looks must bring it, and the looks since it was set.
    goal: f64,
    looks: u32,
}

impl Bracket {
    /// A bracket from two points and the values there.
    pub fn new(low: (f64, f64), high: (f64, f64)) -> Self {
        Self { low, high, moved_low: None, goal: 0.5 * (high.0 - low.0), looks: 0 }
    }

    /// Where to look next: the root of the chord, or the middle if several of these have not halved the bracket.
    pub fn guess(&self) -> f64 {
        let ((a, ga), (b, gb)) = (self.low, self.high);
        if self.looks >= PATIENCE || ga <= gb {
            return 0.5 * (a + b);
        }
        a + (b - a) * (ga / (ga - gb))
    }

    /// Narrows the bracket by a value inside.
    pub fn narrow(&mut self, at: f64, value: f64) {
        let is_low = value > 0.0;
        let (moved, kept) = if is_low { (&mut self.low, &mut self.high) } else { (&mut self.high, &mut self.low) };
        if self.moved_low == Some(is_low) {
            let left = 1.0 - value / moved.1;
            kept.1 *= if left > 0.0 { left } else { 0.5 };
        }
        *moved = (at, value);
        self.moved_low = Some(is_low);
        self.looks += 1;
        if self.width() <= self.goal {
            (self.goal, self.looks) = (0.5 * self.width(), 0);
        }
    }

    /// The end, where the function is not positive.
    pub fn end(&self) -> f64 {
        self.high.0
    }

    /// Where to look next to narrow it to a resolution: slightly behind the guess, so that it closes from both sides.
    pub fn guess_behind(&self, resolution: f64) -> f64 {
        (self.guess() + 0.5 * resolution).min(self.end() - 0.5 * resolution)
    }

    /// Whether the end is just behind the root, to a resolution.
    pub fn is_within(&self, resolution: f64) -> bool {
        // The value at an end that has been kept may be a reduced one.
        self.width() <= 2.0 * resolution || (self.moved_low != Some(true) && self.overshoot() <= resolution)
    }

    /// Length of the bracket.
    pub fn width(&self) -> f64 {
        self.high.0 - self.low.0
    }

    /// Distance of the root from the end, by the chord.
    fn overshoot(&self) -> f64 {
        self.width() * (self.high.1 / (self.high.1 - self.low.1))
    }
}

/// The root of a function in a bracket, to a given width.
pub fn root(mut bracket: Bracket, width: f64, function: impl Fn(f64) -> f64) -> f64 {
    while bracket.width() > width {
        let at = bracket.guess();
        if at <= bracket.low.0 || at >= bracket.high.0 {
            break;
        }
        let value = function(at);
        if value == 0.0 {
            return at;
        }
        bracket.narrow(at, value);
    }
    bracket.guess()
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn cubic_is_reproduced_exactly() {
        let f = |t: f64| 1.0 + 2.0 * t - 3.0 * t * t + 0.5 * t * t * t;
        let slope = |t: f64| 2.0 - 6.0 * t + 1.5 * t * t;
        let (start, end) = ([f(1.0)], [f(3.0)]);
        let cubic = Hermite { start: &start, start_slope: &[slope(1.0)], end: &end, end_slope: &[slope(3.0)], h: 2.0 };
        for fraction in [0.0, 0.25, 0.6, 1.0] {
            assert!((cubic.at(fraction)[0] - f(1.0 + 2.0 * fraction)).abs() < 1e-14);
        }
        let zero = cubic.zero(0, 1e-12).expect("it falls from 0.5 to -6.5");
        assert!(f(1.0 + 2.0 * zero).abs() < 1e-10, "{zero}");
    }

    /// A motion that slows down steadily from one side or the other, and one that begins at rest.
    #[test]
    fn zero_of_a_state_between_ends_of_other_signs_is_found() {
        for sign in [1.0, -1.0] {
            let f = |t: f64| sign * (1.0 - t * t);
            let slope = |t: f64| -2.0 * sign * t;
            let path = |ends: [f64; 2], look: fn(&Hermite<2>) -> [Option<f64>; 2]| {
                let [start, end] = ends.map(|t| [7.0, f(t)]);
                let [start_slope, end_slope] = ends.map(|t| [0.0, slope(t)]);
                let h = ends[1] - ends[0];
                look(&Hermite { start: &start, start_slope: &start_slope, end: &end, end_slope: &end_slope, h })
            };
            let zeros = |path: &Hermite<2>| [0, 1].map(|state| path.zero(state, 1e-9));
            let [none, turn] = path([0.5, 2.5], zeros);
            assert!(none.is_none() && (turn.unwrap() - 0.25).abs() < 1e-9, "{turn:?}");
            assert_eq!(path([1.0, 2.0], zeros), [None; 2]);
        }
    }

    /// As where a motion turns and a bristle follows it otherwise: the chord from afar has the slope of the wrong side.
    #[test]
    fn root_just_behind_a_kink_takes_few_looks() {
        let looks = Cell::new(0);
        let function = |t: f64| {
            looks.update(|count| count + 1);
            let ahead = 0.6 - t;
            1e-6 + if ahead > 0.0 { 1.5 * ahead } else { 0.5 * ahead }
        };
        let found = root(Bracket::new((0.0, function(0.0)), (1.0, function(1.0))), 1e-12, function);
        assert!((found - (0.6 + 2e-6)).abs() < 1e-12, "{found}");
        assert!(looks.get() <= 16, "{} looks", looks.get());
    }

    /// An indicator that saturates behind its root, like an element's that yields: chords from afar nearly miss the
    /// steep part.
    #[test]
    fn root_before_a_flat_part_takes_few_looks() {
        for place in [0.03, 0.18, 0.46, 0.9] {
            let looks = Cell::new(0);
            let function = |t: f64| {
                looks.update(|count| count + 1);
                (0.09 * (place - t)).max(-5e-4 - 3e-5 * t)
            };
            let found = root(Bracket::new((0.0, function(0.0)), (1.0, function(1.0))), 1e-6, function);
            assert!((found - place).abs() < 1e-6, "{found}, not {place}");
            assert!(looks.get() <= 26, "{} looks at {place}", looks.get());
        }
    }

    #[test]
    fn root_is_found_even_of_a_curve_that_is_flat_on_one_side() {
        let function = |t: f64| 1e-6 - t.powi(9);
        let found = root(Bracket::new((0.0, function(0.0)), (1.0, function(1.0))), 1e-12, function);
        assert!((found - 1e-6f64.powf(1.0 / 9.0)).abs() < 1e-11);
    }

    #[test]
    fn search_ends_where_no_number_is_left_between() {
        let looks = std::cell::Cell::new(0);
        let function = |t: f64| {
            looks.update(|count| count + 1);
            assert!(looks.get() < 1000, "the search goes on at {t}");
            2.0 - t * t
        };
        let found = root(Bracket::new((1.0, 1.0), (2.0, -2.0)), 0.0, function);
        assert!((found - std::f64::consts::SQRT_2).abs() <= f64::EPSILON, "{found}");
    }
}
