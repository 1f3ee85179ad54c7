//! When sampled parts take their samples.

/// Samples are taken at communication points that miss them by this fraction of the sample time, so that they see the
/// inputs set there, however the host adds up its steps.
const PUNCTUALITY: f64 = 1e-3;

/// The next sample of a sampled part.
///
/// A communication point on a sample belongs to the time before: it shows the old value, and the sample is taken when
/// the run goes on from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Its time in s.
    pub time: f64,
    /// How far from it, in s, a communication point may be that is meant to be on it.
    tolerance: f64,
}

impl Sample {
    /// No sample at all.
    pub const NEVER: Self = Self { time: f64::INFINITY, tolerance: 0.0 };

    /// A sample of a part that takes one in every period, in s.
    pub fn periodic(time: f64, period: f64) -> Self {
        Self { time, tolerance: PUNCTUALITY * period }
    }

    /// A time in s at which a step has to end.
    pub fn exact(time: f64) -> Self {
        Self { time, tolerance: 0.0 }
    }

    /// The earlier of two.
    pub fn earlier(self, other: Self) -> Self {
        if other.time < self.time { other } else { self }
    }

    /// Whether it belongs to the time before a communication point in s.
    pub fn is_before(self, point: f64) -> bool {
        self.time < point - self.tolerance
    }

    /// Whether it is to be taken at a communication point in s.
    pub fn is_due_at(self, point: f64) -> bool {
        self.time <= point + self.tolerance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn communication_point_within_a_thousandth_of_the_sample_time_is_on_the_sample() {
        let sample = Sample::periodic(3.0, 1e-3);
        for point in [3.0 - 0.9e-6, 3.0, 3.0 + 0.9e-6] {
            assert!(!sample.is_before(point) && sample.is_due_at(point), "{point}");
        }
        assert!(sample.is_before(3.0 + 1.1e-6));
        assert!(!sample.is_due_at(3.0 - 1.1e-6));
    }

    #[test]
    fn no_sample_is_after_every_other() {
        assert_eq!(Sample::NEVER.earlier(Sample::exact(1e300)).time, 1e300);
        assert!(!Sample::NEVER.is_before(f64::MAX));
    }
}
