//! Sample times of sampled parts.

use crate::numbers::{Real, Scalar};

/// Samples are taken at communication points that miss them by rounding, so that they see the inputs set there, however the host
/// adds up its steps: by no more than this fraction of the sample time.
const PUNCTUALITY: f64 = 1e-3;
/// Rounding of a sum of steps, as a fraction of it: a million steps of 1 ms add up to a second or a thousand with less.
const SUMMED: f64 = 1e-10;
/// Roundings of a time on the clock of a host.
const ROUNDINGS: f64 = 4.0;

/// The next sample of a sampled part.
///
/// A communication point on a sample belongs to the time before: it shows the old value, and the sample is taken when
/// the run goes on from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<S = Real> {
    /// Its time in s.
    pub time: S,
    /// Tolerance in s of a communication point on a sample.
    tolerance: f64,
}

impl<S: Scalar> Sample<S> {
    /// No sample at all.
    pub fn never() -> Self {
        Self { time: S::of(f64::INFINITY), tolerance: 0.0 }
    }

    /// A sample of a part that takes one in every period, in s.
    pub fn periodic(time: S, period: f64) -> Self {
        Self { time, tolerance: PUNCTUALITY * period }
    }

    /// A time in s at which a step has to end.
    pub fn exact(time: S) -> Self {
        Self { time, tolerance: 0.0 }
    }

    /// A time in s at which a step has to end, unless a communication point is as near as a tolerance in s.
    pub fn near(time: S, tolerance: f64) -> Self {
        Self { time, tolerance }
    }

    /// The earlier of two.
    pub fn earlier(self, other: Self) -> Self {
        if other.time.value() < self.time.value() { other } else { self }
    }

    /// The same where communication points miss it by rounding alone, at a time since the start of a run, whose start is at a time on
    /// the clock of the host, both in s.
    pub fn rounded(self, time: f64, start: f64) -> Self {
        let rounding = SUMMED * time.abs() + ROUNDINGS * f64::EPSILON * (start.abs() + time.abs());
        Self { tolerance: self.tolerance.min(rounding), ..self }
    }

    /// Whether it belongs to the time before a communication point in s.
    pub fn is_before(self, point: f64) -> bool {
        self.time.value() < point - self.tolerance
    }

    /// Whether it is to be taken at a communication point in s.
    pub fn is_due_at(self, point: f64) -> bool {
        self.time.value() <= point + self.tolerance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn communication_point_within_a_thousandth_of_the_sample_time_is_on_the_sample() {
        let sample = Sample::periodic(Real::of(3.0), 1e-3);
        for point in [3.0 - 0.9e-6, 3.0, 3.0 + 0.9e-6] {
            assert!(!sample.is_before(point) && sample.is_due_at(point), "{point}");
        }
        assert!(sample.is_before(3.0 + 1.1e-6));
        assert!(!sample.is_due_at(3.0 - 1.1e-6));
    }

    /// Hosts that add up steps miss a sample by rounding; other points near it are not on it.
    #[test]
    fn communication_point_of_a_run_is_on_a_sample_but_for_rounding() {
        let sum = |steps: u32, size: f64| (0..steps).fold(0.0, |time, _| time + size);
        for (steps, size) in [(3000, 1e-3), (1_000_000, 1e-3), (100_000, 1e-4)] {
            let (point, exact) = (sum(steps, size), f64::from(steps) * size);
            let sample = Sample::periodic(Real::of(exact), size).rounded(point, 0.0);
            assert!(!sample.is_before(point) && sample.is_due_at(point), "{steps} steps of {size} s");
        }
        let late = Sample::periodic(Real::of(3.0), 1e-3).rounded(3.0, 1.7e9);
        assert!(!late.is_before(3.0 + 2e-7), "a clock that resolves 0.24 us");
        let exact = Sample::periodic(Real::of(3.0), 1e-3).rounded(3.0, 0.0);
        assert!(exact.is_before(3.0 + 1e-9) && !exact.is_due_at(3.0 - 1e-9));
    }

    #[test]
    fn no_sample_is_after_every_other() {
        assert_eq!(Sample::never().earlier(Sample::exact(Real::of(1e300))).time.value, 1e300);
        assert!(!Sample::<Real>::never().is_before(f64::MAX));
    }
}
