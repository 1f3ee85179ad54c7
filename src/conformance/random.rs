//! A small generator (Knuth's linear congruential one, upper bits) so that failures repeat.

/// Last random number; at first the seed.
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// Uniform between bounds.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// Uniform in \[-1, 1).
    #[allow(clippy::should_implement_trait, reason = "it never ends")]
    pub fn next(&mut self) -> f64 {
        self.between(-1.0, 1.0)
    }

    /// A magnitude between bounds, uniform in its logarithm, with a random sign.
    pub fn spread(&mut self, least: f64, most: f64) -> f64 {
        let exponent = self.between(0.0, 1.0);
        least * (most / least).powf(exponent) * if self.next() < 0.0 { -1.0 } else { 1.0 }
    }
}
