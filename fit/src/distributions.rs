//! Quantiles and tails of distributions.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

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
    let distribution =
        StudentsT::new(0.0, 1.0, freedom.max(1) as f64).expect("a positive number of degrees of freedom");
    distribution.inverse_cdf(share)
}

/// Probability that chi squared of a number of degrees of freedom is larger than a value.
pub fn chi_squared_tail(value: f64, freedom: usize) -> f64 {
    let distribution = ChiSquared::new(freedom.max(1) as f64).expect("a positive number of degrees of freedom");
    distribution.sf(value)
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
        }
        assert!((chi_squared_tail(31.410_432_844, 20) / 0.05 - 1.0).abs() < 1e-8);
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
