//! A sensor: how likely its readings are if a simulation is true.

use crate::arrays::{differences, extremes, line, mean, median, rms};
use crate::distributions::log_normal;
use crate::smoothing::noise;

/// Noise, in steps of a converter, that hides it: the sum of both is as good as normal.
const COARSE: f64 = 2.0;
/// Share of the step of a converter below which noise is not searched.
const FINEST: f64 = 0.02;
/// Smallest noise of a sensor in SI units.
const LEAST: f64 = 1e-12;
/// Values that deviate from a lattice by more than this share of its step were not made by a converter.
const ON_LATTICE: f64 = 0.1;
/// Levels of a converter for each one that occurs, beyond which its step has no effect.
const SPARSE: f64 = 10.0;
/// Relative difference of places up to which a point is repeated, and repetitions without which their scatter is no noise.
const REPEATED: f64 = 0.01;
const REPEATS: usize = 4;
/// Points below which third differences are too few for a noise.
const FEW: usize = 12;
/// Relative accuracy of a noise.
const EXACTNESS: f64 = 0.01;

/// Normal noise, and perhaps a converter that rounds.
///
/// The rounding errors of a carriage at rest are all the same, so that least squares would take them for motion. A reading of a
/// coarse converter tells only between which two values the noisy signal was:
///
/// ```text
/// P(d) = Phi((d + step/2)/noise) - Phi((d - step/2)/noise)      d: reading minus simulation
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Standard deviation of the noise, in SI units.
    pub noise: f64,
    /// Step of the converter; 0 without one.
    pub step: f64,
    /// Whether readings are taken as ranges.
    pub is_coarse: bool,
}

impl Sensor {
    /// Noise and rounding together, and the converter, from measured courses of a signal.
    pub fn of(courses: &[&[f64]]) -> Self {
        let ends = courses.iter().map(|course| extremes(course));
        let magnitude = ends.fold(0.0, |most: f64, (low, high)| most.max(low.abs()).max(high.abs()));
        let estimates: Vec<f64> = courses.iter().map(|course| noise(course)).collect();
        let noise = median(&estimates).max(1e-9 * magnitude).max(LEAST);
        Self { noise, step: converter(&courses.concat()), is_coarse: false }
    }

    /// The same from points: where they are, and what is read there.
    ///
    /// The noise is the scatter of repeated points. Without them it is taken from points in the order of where they are, where a
    /// smooth curve hardly changes from one to the next.
    pub fn of_points(mut points: Vec<(Vec<f64>, f64)>) -> Self {
        let mut groups = Vec::new();
        grouped(&mut points, 0, &mut groups);
        let (mut squares, mut freedom) = (0.0, 0);
        for group in &groups {
            let middle = mean(group);
            squares += group.iter().map(|reading| (reading - middle) * (reading - middle)).sum::<f64>();
            freedom += group.len() - 1;
        }
        let readings: Vec<f64> = groups.concat();
        let (low, high) = extremes(&readings);
        let step = converter(&readings);
        let noise = if freedom >= REPEATS {
            (squares / freedom as f64).sqrt()
        } else if readings.len() >= FEW {
            noise(&readings)
        } else {
            rms(&differences(&readings)) / 2f64.sqrt()
        };
        // Rounding makes repeated readings alike.
        let least = (1e-9 * low.abs().max(high.abs())).max(step / 12f64.sqrt()).max(LEAST);
        Self { noise: noise.max(least), step, is_coarse: false }
    }

    /// Standard deviation of noise and rounding together.
    pub fn whole_noise(&self) -> f64 {
        (self.noise * self.noise + self.step * self.step / 12.0).sqrt()
    }

    /// The sensor whose noise makes differences most likely.
    pub fn with_noise_of(self, differences: &[f64]) -> Self {
        let rms = rms(differences).max(LEAST);
        if rms >= COARSE * self.step {
            return Self { noise: rms, is_coarse: false, ..self };
        }
        let of = |logarithm: f64| Self { noise: libm::exp(logarithm), is_coarse: true, ..self };
        let cost = |logarithm: f64| {
            let sensor = of(logarithm);
            -differences.iter().map(|difference| sensor.log_likelihood(*difference)).sum::<f64>()
        };
        of(minimum(cost, libm::log(FINEST * self.step), libm::log(COARSE * self.step), EXACTNESS))
    }

    /// Summand of least squares: the signed root of twice what the logarithm of P lacks to its best.
    pub fn residual(&self, difference: f64) -> f64 {
        if !self.is_coarse {
            return difference / self.noise;
        }
        let lack = (self.log_likelihood(0.0) - self.log_likelihood(difference)).max(0.0);
        sign(difference) * (2.0 * lack).sqrt()
    }

    /// Logarithm of the density of readings, in 1/unit; for a coarse converter the logarithm of P over its step.
    pub fn log_density(&self, difference: f64) -> f64 {
        if self.is_coarse {
            return self.log_likelihood(difference) - libm::log(self.step);
        }
        let share = difference / self.noise;
        -0.5 * share * share - libm::log(std::f64::consts::TAU.sqrt() * self.noise)
    }

    /// Derivative of the residual.
    pub fn slope(&self, difference: f64) -> f64 {
        if !self.is_coarse {
            return 1.0 / self.noise;
        }
        // Next to its middle the residual is as good as straight; the quotient is not.
        let near = 1e-3 * self.noise;
        if difference.abs() > near {
            return -self.score(difference) / self.residual(difference);
        }
        self.residual(near) / near
    }

    /// Derivative of the logarithm of P against the simulation, in units of the weight: of variance 1.
    pub fn weighted_score(&self, difference: f64) -> f64 {
        if self.is_coarse { -self.score(difference) / self.weight(difference) } else { difference / self.noise }
    }

    /// Root of the information that a reading is expected to have about the simulation.
    pub fn weight(&self, difference: f64) -> f64 {
        if !self.is_coarse {
            return 1.0 / self.noise;
        }
        let reach = (6.0 * self.noise / self.step).ceil() as i32 + 1;
        // Deviation of the simulation from the nearest value of the converter: all readings are expected from there.
        let offset = difference - self.step * (difference / self.step).round_ties_even();
        let information = |reading: i32| {
            let shifted = offset + self.step * f64::from(reading);
            let score = self.score(shifted);
            libm::exp(self.log_likelihood(shifted)) * score * score
        };
        let whole: f64 = (-reach..=reach).map(information).sum();
        let least = 1e-6 / self.noise;
        whole.max(least * least).sqrt()
    }

    /// Ends of the range of a reading in units of the noise, as P sees them: it is even.
    fn ends(&self, difference: f64) -> (f64, f64) {
        let (half, distance) = (0.5 * self.step, difference.abs());
        ((half - distance) / self.noise, (-half - distance) / self.noise)
    }

    /// Logarithm of P, without the loss of digits in the tails.
    fn log_likelihood(&self, difference: f64) -> f64 {
        let (upper, lower) = self.ends(difference);
        let (high, low) = (log_normal(upper), log_normal(lower));
        high + libm::log1p(-libm::exp(low - high))
    }

    /// Derivative of the logarithm of P.
    fn score(&self, difference: f64) -> f64 {
        let (upper, lower) = self.ends(difference);
        let likelihood = self.log_likelihood(difference) + 0.5 * libm::log(std::f64::consts::TAU);
        let density = |end: f64| libm::exp(-0.5 * end * end - likelihood);
        -sign(difference) * (density(upper) - density(lower)) / self.noise
    }
}

/// Readings of repeated points, group by group in the order of where they are: by the coordinates from one on.
fn grouped(points: &mut [(Vec<f64>, f64)], coordinate: usize, groups: &mut Vec<Vec<f64>>) {
    if points.first().is_none_or(|(place, _)| place.len() == coordinate) {
        groups.push(points.iter().map(|(_, reading)| *reading).collect());
        return;
    }
    points.sort_by(|(one, _), (other, _)| one[coordinate].total_cmp(&other[coordinate]));
    let is_repeated = |(one, _): &(Vec<f64>, f64), (other, _): &(Vec<f64>, f64)| {
        let [one, other] = [one[coordinate], other[coordinate]];
        (one - other).abs() <= REPEATED * one.abs().max(other.abs())
    };
    points.chunk_by_mut(is_repeated).for_each(|own| grouped(own, coordinate + 1, groups));
}

/// 1, -1, or 0 for 0.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// Step of the converter on whose lattice the values lie, the common divisor of their distances; 0 if they lie on none.
///
/// Numbers that no converter made have a common divisor, too, as small as their rounding; a step that small has no effect.
pub fn converter(values: &[f64]) -> f64 {
    let mut levels = values.to_vec();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    // Of a converter whose levels hardly repeat, differences of samples show the rounding; a steady motion has even levels, too.
    if levels.len() < 2 || 4 * levels.len() > 3 * values.len() {
        return 0.0;
    }
    let jumps = || levels.windows(2).map(|pair| pair[1] - pair[0]);
    let mut step = jumps().fold(f64::INFINITY, f64::min);
    let least = (levels[levels.len() - 1] - levels[0]) / (SPARSE * levels.len() as f64);
    let smallest = loop {
        let rest = |jump: f64| (jump - step * (jump / step).round_ties_even()).abs();
        let Some(off) = jumps().map(rest).find(|rest| *rest > ON_LATTICE * step) else { break step };
        step = off;
        if step < least {
            return 0.0;
        }
    };
    let mut number = 0.0;
    let mut numbers = vec![0.0];
    for jump in jumps() {
        number += (jump / smallest).round_ties_even();
        numbers.push(number);
    }
    let (step, first) = line(&numbers, &levels);
    let is_on = |(number, level): (&f64, &f64)| (level - first - step * number).abs() < ON_LATTICE * step;
    if numbers.iter().zip(&levels).all(is_on) { step } else { 0.0 }
}

/// Place of the minimum of a function with one hollow, by golden sections (J. Kiefer, Proceedings of the AMS 4, 1953).
fn minimum(of: impl Fn(f64) -> f64, low: f64, high: f64, within: f64) -> f64 {
    let share = 0.5 * (5f64.sqrt() - 1.0);
    let (mut a, mut b) = (low, high);
    let (mut c, mut d) = (b - share * (b - a), a + share * (b - a));
    let (mut at_c, mut at_d) = (of(c), of(d));
    while b - a > within {
        if at_c < at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - share * (b - a);
            at_c = of(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + share * (b - a);
            at_d = of(d);
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::numbers::random;

    use super::*;

    fn rounded(noise: f64, step: f64) -> Vec<f64> {
        let mut state = 3;
        // A simulation anywhere between the steps of the converter, and what is read of it.
        let one = |_| {
            let truth = random::uniform(&mut state);
            step * ((truth + noise * random::normal(&mut state)) / step).round() - truth
        };
        (0..4000).map(one).collect()
    }

    #[test]
    fn noise_below_the_step_of_a_converter_is_found() {
        for (noise, is_coarse) in [(0.03, true), (0.1, true), (0.5, false)] {
            let sensor = Sensor { noise: 1.0, step: 0.1, is_coarse: false }.with_noise_of(&rounded(noise, 0.1));
            assert_eq!(sensor.is_coarse, is_coarse, "{noise}");
            assert!((sensor.noise / noise - 1.0).abs() < 0.06, "{noise}: {}", sensor.noise);
        }
    }

    /// Residuals have the slopes, and scores the variance, that they promise.
    #[test]
    fn slopes_are_derivatives_and_scores_have_variance_one() {
        let sensor = Sensor { noise: 0.03, step: 0.1, is_coarse: true };
        for difference in [-2.0, -0.07, -1e-5, 0.0, 0.02, 0.05, 0.3, 5.0] {
            let quotient = (sensor.residual(difference + 1e-6) - sensor.residual(difference - 1e-6)) / 2e-6;
            let slope = sensor.slope(difference);
            assert!((slope / quotient - 1.0).abs() < 1e-3, "{difference}: {slope}, not {quotient}");
        }
        let scores: Vec<f64> = rounded(0.03, 0.1).iter().map(|d| sensor.weighted_score(*d)).collect();
        assert!((rms(&scores) - 1.0).abs() < 0.05, "{}", rms(&scores));
    }

    /// Each of 40 points twice, in any order and at a load that varies a little, of a curve that is steeper than the noise; or once.
    #[test]
    fn repeated_points_tell_their_noise() {
        let mut state = 5;
        let mut points = |repeats: u32| -> Vec<(Vec<f64>, f64)> {
            let mut one = |row: u32| {
                let place = f64::from(row * 17 % 40) - 20.0;
                (vec![1e5 + 10.0 * f64::from(row), 1.001 * place], place * place + 0.1 * random::normal(&mut state))
            };
            (0..40 * repeats).map(&mut one).collect()
        };
        let repeated = Sensor::of_points(points(2));
        assert!((repeated.noise / 0.1 - 1.0).abs() < 0.35, "{}", repeated.noise);
        let single = Sensor::of_points(points(1));
        assert!((0.5..2.0).contains(&(single.noise / 0.1)), "{}", single.noise);
        let exact = Sensor::of_points((0..8).map(|row| (vec![f64::from(row / 2)], 7.5)).collect());
        assert!((exact.noise / 7.5e-9 - 1.0).abs() < 1e-12, "{}", exact.noise);
    }

    #[test]
    fn a_converter_is_known_by_its_lattice() {
        let lattice: Vec<f64> = [3, 7, 7, 8, 20, -4, 20, 8].iter().map(|k| 0.1 + 0.05 * f64::from(*k)).collect();
        assert!((converter(&lattice) - 0.05).abs() < 1e-12);
        assert_eq!(converter(&[0.0, 1.0, 2.45, 3.1, 4.8, 1.0, 2.45]), 0.0);
        // Levels two and three steps apart, none of them one.
        let sparse: Vec<f64> = [0, 2, 5, 7, 10, 13, 5, 2].iter().map(|k| 0.02 * f64::from(*k)).collect();
        assert!((converter(&sparse) - 0.02).abs() < 1e-12, "{}", converter(&sparse));
        assert_eq!(converter(&[2.0, 2.0]), 0.0);
    }
}
