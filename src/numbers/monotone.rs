//! A smooth curve through points, as monotone as they are between any two of them.

use super::{Number, Scalar, Tangent};

/// A piecewise cubic through points, with a continuous slope, that rises where the points rise, falls where they fall, turns at
/// points alone and is flat where two of them are equal; constant beyond the first and the last.
///
/// ```text
/// f(x) = f_k + d_k*t + (3*D - 2*d_k - d_k+1)/h*t^2 + (d_k + d_k+1 - 2*D)/h^2*t^3     t = x - x_k, h = x_k+1 - x_k
/// d_k  = (w1 + w2)/(w1/D_k-1 + w2/D_k),  w1 = 2*h_k + h_k-1,  w2 = h_k + 2*h_k-1     D = (f_k+1 - f_k)/h
/// ```
///
/// `d_k` is 0 where one of the slopes `D` beside it is, or where they differ in sign; at both ends it is the slope of the
/// parabola through three points, limited so that the curve stays monotone.
///
/// # Source
/// Fritsch, Butland (1984), SIAM J. Scientific and Statistical Computing 5(2):300-304.
#[derive(Clone, Debug, PartialEq)]
pub struct MonotoneCurve {
    first: Tangent,
    segments: Box<[Segment]>,
    last: [Tangent; 2],
}

/// Where a cubic begins, and its coefficients by power of the distance from there.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment {
    from: Tangent,
    coefficients: [Tangent; 4],
}

impl MonotoneCurve {
    /// The curve through at least two points `(x, f)` with rising `x`.
    pub fn through(points: &[(Tangent, Tangent)]) -> Self {
        let widths: Vec<Tangent> = points.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
        let slopes: Vec<Tangent> =
            points.windows(2).zip(&widths).map(|(pair, h)| (pair[1].1 - pair[0].1) / *h).collect();
        let at_points = slopes_at_points(&widths, &slopes);
        let segment = |k: usize| {
            let (h, chord, begin, end) = (widths[k], slopes[k], at_points[k], at_points[k + 1]);
            let coefficients =
                [points[k].1, begin, (3.0 * chord - 2.0 * begin - end) / h, (begin + end - 2.0 * chord) / (h * h)];
            Segment { from: points[k].0, coefficients }
        };
        let (end, height) = points[points.len() - 1];
        Self { first: points[0].1, segments: (0..widths.len()).map(segment).collect(), last: [end, height] }
    }

    /// The value at a place.
    pub fn at<S: Scalar>(&self, x: S) -> S {
        let [end, height] = self.last;
        if x.value() >= end.value {
            return S::along(height);
        }
        let Some(Segment { from, coefficients }) = self.segments.iter().rev().find(|it| it.from.value <= x.value())
        else {
            return S::along(self.first);
        };
        let (t, [value, slope, square, cube]) = (x - *from, *coefficients);
        ((t * cube + square) * t + slope) * t + value
    }

    /// Slope just before the last point.
    pub fn end_slope(&self) -> Tangent {
        let Segment { from, coefficients: [_, slope, square, cube] } = self.segments[self.segments.len() - 1];
        let width = self.last[0] - from;
        (3.0 * cube * width + 2.0 * square) * width + slope
    }

    /// The number of the piece with a continuous slope in which a place lies: before, along or beyond the curve.
    pub fn smooth_region(&self, x: f64) -> u32 {
        u32::from(self.segments.first().is_some_and(|first| x > first.from.value)) + u32::from(x >= self.last[0].value)
    }
}

/// Slopes of the curve at its points, for widths and slopes of the chords between them.
fn slopes_at_points(widths: &[Tangent], chords: &[Tangent]) -> Vec<Tangent> {
    let inner = |k: usize| {
        let (before, after) = (chords[k - 1], chords[k]);
        if before.value * after.value <= 0.0 {
            return Tangent::zero();
        }
        let (w1, w2) = (2.0 * widths[k] + widths[k - 1], widths[k] + 2.0 * widths[k - 1]);
        (w1 + w2) / (w1 / before + w2 / after)
    };
    // Between 0 and three times the slope of the chord.
    let outer = |near: usize, next: usize| {
        let parabola = ((2.0 * widths[near] + widths[next]) * chords[near] - widths[near] * chords[next])
            / (widths[near] + widths[next]);
        let [way, beside] = [parabola, chords[next]].map(|slope| slope.value * chords[near].value);
        if way <= 0.0 {
            Tangent::zero()
        } else if beside <= 0.0 && parabola.value.abs() > 3.0 * chords[near].value.abs() {
            3.0 * chords[near]
        } else {
            parabola
        }
    };
    let count = chords.len();
    if count == 1 {
        return vec![chords[0]; 2];
    }
    let mut slopes = vec![outer(0, 1)];
    slopes.extend((1..count).map(inner));
    slopes.push(outer(count - 1, count - 2));
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::{Dual, Real};

    fn through(points: &[(f64, f64)]) -> MonotoneCurve {
        let points: Vec<_> = points.iter().map(|(x, f)| (Tangent::still(*x), Tangent::still(*f))).collect();
        MonotoneCurve::through(&points)
    }

    fn at(curve: &MonotoneCurve, x: f64) -> f64 {
        curve.at(Real::of(x)).value
    }

    /// Points of a valve with a dead zone and a progressive start.
    const POINTS: [(f64, f64); 5] = [(0.0, 0.0), (0.1, 0.0), (0.3, 0.05), (0.6, 0.4), (1.0, 1.0)];

    /// Values that `scipy.interpolate.PchipInterpolator` of SciPy 1.17 gives.
    #[test]
    fn curve_is_that_of_another_implementation() {
        let curve = through(&POINTS);
        for (x, expected) in SCIPY {
            assert!((at(&curve, x) - expected).abs() < 1e-15, "{} at {x}, not {expected}", at(&curve, x));
        }
    }

    const SCIPY: [(f64, f64); 6] = [
        (0.05, 0.0),
        (0.2, 0.015_131_578_947_368_43),
        (0.4, 0.129_290_517_549_626_92),
        (0.55, 0.331_512_047_706_379_76),
        (0.8, 0.680_712_876_866_723_2),
        (0.99, 0.983_141_689_560_439_6),
    ];

    /// Points of a friction force over the speed: it falls, then rises. Values of the same SciPy.
    #[test]
    fn curve_that_turns_is_that_of_another_implementation() {
        let curve = through(&[(0.0, 11.0), (0.01, 9.0), (0.03, 8.5), (0.1, 9.5), (0.3, 14.0), (0.5, 21.0)]);
        for (x, expected) in SCIPY_TURNING {
            assert!((at(&curve, x) / expected - 1.0).abs() < 1e-14, "{} at {x}, not {expected}", at(&curve, x));
        }
        assert!((curve.end_slope().value - 41.25).abs() < 1e-12);
    }

    const SCIPY_TURNING: [(f64, f64); 6] = [
        (0.005, 9.737_894_144_144_146),
        (0.02, 8.628_378_378_378_379),
        (0.03, 8.5),
        (0.05, 8.629_389_118_030_257),
        (0.2, 11.486_994_757_654_73),
        (0.45, 19.002_887_228_260_87),
    ];

    #[test]
    fn curve_meets_its_points_and_is_constant_beyond_them() {
        let curve = through(&POINTS);
        for (x, expected) in POINTS {
            assert!((at(&curve, x) - expected).abs() < 1e-15, "{} at {x}", at(&curve, x));
        }
        assert_eq!([-1.0, 0.05, 1.5].map(|x| at(&curve, x)), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn curve_never_falls_and_its_slope_has_no_jumps() {
        let curve = through(&POINTS);
        let slope = |x: f64| curve.at(Dual::<1>::variable(x, 0)).slope[0];
        for k in 0..=1000 {
            assert!(slope(f64::from(k) * 1e-3) >= 0.0, "at {k} thousandths");
        }
        for (x, _) in &POINTS[1..4] {
            assert!((slope(x - 1e-9) - slope(x + 1e-9)).abs() < 1e-6, "at {x}");
        }
    }

    #[test]
    fn two_points_make_a_line() {
        let line = through(&[(0.2, 0.0), (0.7, 1.0)]);
        assert!((at(&line, 0.3) - 0.2).abs() < 1e-15);
    }
}
