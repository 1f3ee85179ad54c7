//! Noise of a signal, and its smoothed course.

use crate::arrays::{differences, mean, median};
use crate::sensor::converter;

/// Standard deviation of a normal distribution over the median of its magnitude.
const OF_MEDIAN: f64 = 0.6745;
/// Sum of the squares of 1, 3, 3, 1: variance of a third difference of white noise.
const THIRD: f64 = 20.0;

/// Standard deviation of white noise and of quantisation, from third differences, in which motion vanishes.
///
/// The median does not see the few samples at which a signal jumps. A signal that mostly rests between the steps of its
/// converter has differences of 0; then its step over the root of 12 counts, if its values lie on the lattice of one.
pub fn noise(values: &[f64]) -> f64 {
    if values.len() < 8 {
        return 0.0;
    }
    let first = differences(values);
    let third: Vec<f64> = differences(&differences(&first)).iter().map(|value| value.abs()).collect();
    let white = median(&third) / OF_MEDIAN / THIRD.sqrt();
    white.max(converter(values) / 12f64.sqrt())
}

/// Samples in a width in s: an odd number, at least five.
fn samples(length: usize, step: f64, width: f64) -> usize {
    let number = (2 * (0.5 * width / step).round_ties_even() as usize + 1).max(5);
    number.min(length - 1 + length % 2)
}

/// Values and slopes of the parabolas fitted about each of equidistant samples over a width in s
/// (A. Savitzky, M. J. E. Golay, Analytical Chemistry 36, 1964); at the ends the first and the last parabola hold.
pub fn parabolas(values: &[f64], step: f64, width: f64) -> (Vec<f64>, Vec<f64>) {
    let number = samples(values.len(), step, width);
    let half = (number - 1) / 2;
    let reach = half as f64;
    let squares = reach * (reach + 1.0) * number as f64 / 3.0;
    let middle = squares / number as f64;
    let offsets = || (0..number).map(|k| k as f64 - reach);
    let spread: f64 = offsets().map(|k| (k * k - middle) * (k * k - middle)).sum();
    let at = |index: usize| {
        let centre = index.clamp(half, values.len() - 1 - half);
        let window = &values[centre - half..=centre + half];
        let level = mean(window);
        let (mut rise, mut bend) = (0.0, 0.0);
        for (k, value) in offsets().zip(window) {
            rise += k * (value - level);
            bend += (k * k - middle) * (value - level);
        }
        (rise, bend) = (rise / squares, bend / spread);
        let off = index as f64 - centre as f64;
        (level + rise * off + bend * (off * off - middle), (rise + 2.0 * bend * off) / step)
    };
    (0..values.len()).map(at).unzip()
}

/// Output of a filter of first order, whose time constant in s is the lag, for equidistant samples.
///
/// The signal lies on straight lines between them, for which this is exact, and has been its first value before.
pub fn low_pass(values: &[f64], step: f64, lag: f64) -> Vec<f64> {
    let kept = libm::exp(-step / lag);
    let share = lag / step * (1.0 - kept);
    let mut last = values[0];
    let mut passed = values[0];
    let each = |value: &f64| {
        passed = kept * passed + (1.0 - share) * value + (share - kept) * last;
        last = *value;
        passed
    };
    std::iter::once(values[0]).chain(values[1..].iter().map(each)).collect()
}

/// Output of a backlash that follows a signal: it rests while the signal stays within the play about it.
pub fn follow(values: &[f64], play: f64) -> Vec<f64> {
    if play <= 0.0 {
        return values.to_vec();
    }
    let mut last = values[0];
    let each = |value: &f64| {
        last = last.max(value - play).min(value + play);
        last
    };
    values.iter().map(each).collect()
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::numbers::random;

    use super::*;

    #[test]
    fn noise_does_not_see_motion_and_sees_the_steps_of_a_converter() {
        let mut state = 1;
        let noisy: Vec<f64> =
            (0..4000).map(|k| libm::sin(1e-2 * f64::from(k)) + 1e-4 * random::normal(&mut state)).collect();
        assert!((noise(&noisy) / 1e-4 - 1.0).abs() < 0.1, "{}", noise(&noisy));
        let rounded: Vec<f64> = (0..4000).map(|k| (1e-3 * f64::from(k)).round()).collect();
        assert!((noise(&rounded) - 1.0 / 12f64.sqrt()).abs() < 1e-12);
    }

    /// A motion that never rests has no smallest step but its slowest.
    #[test]
    fn the_noise_of_a_signal_that_always_moves_is_not_its_slowest_motion() {
        let mut state = 1;
        let mut moving = |noise: f64, step: f64| -> Vec<f64> {
            let mut one =
                |k| 0.1 * f64::from(k) + 1e-3 * libm::sin(0.3 * f64::from(k)) + noise * random::normal(&mut state);
            (0..300).map(|k| if step == 0.0 { one(k) } else { step * (one(k) / step).round() }).collect()
        };
        for (given, step, expected) in [(1e-3, 0.0, 1e-3), (0.0, 7e-3, 7e-3 / 12f64.sqrt())] {
            let found = noise(&moving(given, step));
            assert!((0.7..1.5).contains(&(found / expected)), "{given}, {step}: {found}");
        }
    }

    #[test]
    fn parabolas_are_exact_for_a_parabola_up_to_its_ends() {
        let values: Vec<f64> = (0..30).map(|k| 0.01 * f64::from(k)).map(|t| 1.0 + 2.0 * t - 3.0 * t * t).collect();
        let (smooth, slope) = parabolas(&values, 0.01, 0.1);
        for (k, value) in values.iter().enumerate() {
            assert!((smooth[k] - value).abs() < 1e-13 && (slope[k] - (2.0 - 0.06 * k as f64)).abs() < 1e-11, "{k}");
        }
    }

    /// A ramp through a filter of first order: t - T (1 - exp(-t/T)).
    #[test]
    fn a_filter_is_exact_for_a_ramp() {
        let (step, lag) = (0.01, 0.05);
        let ramp: Vec<f64> = (0..50).map(|k| step * f64::from(k)).collect();
        for (t, passed) in ramp.iter().zip(low_pass(&ramp, step, lag)) {
            assert!((passed - (t - lag * (1.0 - libm::exp(-t / lag)))).abs() < 1e-14, "{t}: {passed}");
        }
    }

    #[test]
    fn a_jitter_within_the_play_becomes_rest() {
        assert_eq!(follow(&[0.0, 0.5, -0.5, 2.0, 1.5, 0.0], 1.0), [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    }
}
