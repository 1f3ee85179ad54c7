//! Quantiles and tails of distributions.

use std::f64::consts::{FRAC_1_PI, PI};

/// Probability that an interval holds.
pub const LEVEL: f64 = 0.95;
/// Half of the 95 % interval of a normal distribution, in standard deviations.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;
/// Below this the asymptotic series of [`log_normal`] has all digits.
const TAIL: f64 = -20.0;

/// Half the width of the interval, in standard deviations, in which a value of Student's distribution lies with the
/// probability [`LEVEL`]. At least one degree of freedom is assumed.
pub fn student(freedom: usize) -> f64 {
    student_quantile(0.5 + 0.5 * LEVEL, freedom)
}

/// Quantile of Student's distribution with a number of degrees of freedom, at least one.
pub fn student_quantile(share: f64, freedom: usize) -> f64 {
    let freedom = freedom.max(1);
    let mut angle = 0.0;
    // Within these angles the probability is concave: no step of Newton's method leads beyond the root.
    loop {
        let (inside, slope) = within(angle, freedom);
        let next = angle + ((2.0 * share - 1.0).abs() - inside) / slope;
        if next <= angle || next.is_nan() {
            return (freedom as f64).sqrt() * libm::tan(angle).copysign(share - 0.5);
        }
        angle = next;
    }
}

/// Probability that the magnitude of a variable with Student's distribution is at most the tangent of an angle times the square root of
/// the degrees of freedom, and the derivative of the probability by the angle (Abramowitz, Stegun, 26.7.3 and 26.7.4).
fn within(angle: f64, freedom: usize) -> (f64, f64) {
    let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
    let is_odd = freedom % 2 == 1;
    let (mut term, mut over, mut series) = if is_odd { (cosine, 3.0, 0.0) } else { (1.0, 2.0, 0.0) };
    for _ in 0..freedom / 2 {
        series += term;
        term *= cosine * cosine * (over - 1.0) / over;
        over += 2.0;
    }
    let slope = freedom as f64 * term / cosine;
    if is_odd { (2.0 * FRAC_1_PI * (angle + sine * series), 2.0 * FRAC_1_PI * slope) } else { (sine * series, slope) }
}

/// Probability that chi squared of a number of degrees of freedom, at least one, is larger than a value (Abramowitz, Stegun, 26.4.4
/// and 26.4.5).
pub fn chi_squared_tail(value: f64, freedom: usize) -> f64 {
    if value <= 0.0 {
        return 1.0;
    }
    let (freedom, half) = (freedom.max(1), 0.5 * value);
    let is_odd = freedom % 2 == 1;
    let root = half.sqrt();
    let (mut term, mut over, mut tail) = if is_odd {
        (2.0 * root / PI.sqrt() * libm::exp(-half), 1.5, libm::erfc(root))
    } else {
        (libm::exp(-half), 1.0, 0.0)
    };
    for _ in 0..freedom / 2 {
        tail += term;
        term *= half / over;
        over += 1.0;
    }
    tail
}

/// Standard normal distribution function.
pub fn normal(x: f64) -> f64 {
    0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}

/// Logarithm of the standard normal distribution function, with all digits in both tails
/// (M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, 1964, 26.2.12).
pub fn log_normal(x: f64) -> f64 {
    if x >= 0.0 {
        return libm::log1p(-0.5 * libm::erfc(x * std::f64::consts::FRAC_1_SQRT_2));
    }
    if x > TAIL {
        return libm::log(0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2));
    }
    let (mut term, mut series) = (1.0, 1.0);
    for k in 0..8 {
        term *= -f64::from(2 * k + 1) / (x * x);
        series += term;
    }
    -0.5 * x * x - libm::log(-x) - 0.5 * libm::log(std::f64::consts::TAU) + libm::log(series)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables of quantiles, and tails by Mathematica's `N[Log[Erfc[x/Sqrt[2]]/2], 17]` (SciPy's `log_ndtr` agrees).
    #[test]
    fn quantiles_and_tails_are_those_of_the_tables() {
        for (freedom, expected) in
            [(1, 12.706_204_736), (2, 4.302_652_730), (19, 2.093_024_054), (10_000, 1.960_201_239)]
        {
            let found = student(freedom);
            assert!((found / expected - 1.0).abs() < 1e-8, "{freedom}: {found}");
            assert!((student_quantile(0.5 - 0.5 * LEVEL, freedom) / -found - 1.0).abs() < 1e-12);
        }
        assert_eq!(student_quantile(0.5, 7), 0.0);
        for (value, freedom) in [(31.410_432_844, 20), (30.143_527_206, 19), (5.991_464_547, 2), (3.841_458_821, 1)] {
            let found = chi_squared_tail(value, freedom);
            assert!((found / 0.05 - 1.0).abs() < 1e-8, "{freedom}: {found}");
        }
        assert_eq!([0.0, 1e4].map(|value| chi_squared_tail(value, 3)), [1.0, 0.0]);
        for (x, expected) in [
            (-40.0, -804.608_442_013_754),
            (-20.0, -203.917_155_37),
            (-1.0, -1.841_021_645_009_264),
            (3.0, -0.001_350_809_964_748_193),
        ] {
            let found = log_normal(x);
            assert!((found / expected - 1.0).abs() < 1e-10, "{x}: {found}");
        }
        let (above, below) = (log_normal(TAIL + 1e-9), log_normal(TAIL - 1e-9));
        assert!((above - below).abs() < 1e-7, "{above} and {below} do not meet");
    }
}
