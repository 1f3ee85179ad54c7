//! Random numbers that are the same on every platform and part of a saved state.
//!
//! The generator is SplitMix64: Steele, Lea, Flood (2014), Fast splittable pseudorandom number generators, OOPSLA '14,
//! 453-472. Its state is one number, which the caller keeps.

use std::f64::consts::TAU;

/// The next 64 random bits.
pub fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A number uniform in (0, 1].
pub fn uniform(state: &mut u64) -> f64 {
    ((next(state) >> 11) + 1) as f64 / (1u64 << 53) as f64
}

/// A number of the standard normal distribution, from two uniform ones by the transform of Box and Muller.
pub fn normal(state: &mut u64) -> f64 {
    let (radius, angle) = (uniform(state), uniform(state));
    (-2.0 * libm::log(radius)).sqrt() * libm::cos(TAU * angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first numbers that the authors' Java code and its many translations give for the seed 1234567.
    #[test]
    fn numbers_are_those_of_splitmix64() {
        let mut state = 1_234_567;
        let numbers: [u64; 3] = std::array::from_fn(|_| next(&mut state));
        assert_eq!(numbers, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
    }

    #[test]
    fn uniform_numbers_fill_the_interval_evenly() {
        let mut state = 1;
        let numbers: Vec<f64> = (0..100_000).map(|_| uniform(&mut state)).collect();
        assert!(numbers.iter().all(|number| *number > 0.0 && *number <= 1.0));
        let mean = numbers.iter().sum::<f64>() / 1e5;
        // The standard deviation of the mean is 0.0009.
        assert!((mean - 0.5).abs() < 0.004, "{mean}");
    }

    /// A share of 68.27 % is within one standard deviation, 95.45 % within two, 99.73 % within three.
    #[test]
    fn normal_numbers_have_their_distribution() {
        let mut state = 1;
        let numbers: Vec<f64> = (0..100_000).map(|_| normal(&mut state)).collect();
        for (bound, expected) in [(1.0, 0.6827), (2.0, 0.9545), (3.0, 0.9973)] {
            let share = numbers.iter().filter(|number| number.abs() < bound).count() as f64 / 1e5;
            // The standard deviation of the share is at most 0.0015.
            assert!((share - expected).abs() < 0.005, "{share} within {bound}");
        }
    }
}
