//! Sample times of sampled parts.

use crate::numbers::{Real, Scalar};

/// Samples are taken at communication points that miss them by this fraction of the sample time, so that they see the
/// inputs set there, however the host adds up its steps.
const PUNCTUALITY: f64 = 1e-3;

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

    #[test]
    fn no_sample_is_after_every_other() {
        assert_eq!(Sample::never().earlier(Sample::exact(Real::of(1e300))).time.value, 1e300);
        assert!(!Sample::<Real>::never().is_before(f64::MAX));
    }
}
