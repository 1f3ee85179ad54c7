//! Random numbers, and values for variables.

use pneumatic_servo::variables::{Chosen, Kind, Variable};

/// Where random numbers come from.
pub enum Random {
    /// SplitMix64.
    Seeded(u64),
    /// Bytes that a fuzzer makes up, from the last to the first; zeros behind them.
    Given(Vec<u8>),
}

impl Random {
    pub fn given(bytes: &[u8]) -> Self {
        Self::Given(bytes.iter().rev().copied().collect())
    }

    /// Whether all bytes are used up.
    pub fn is_exhausted(&self) -> bool {
        matches!(self, Self::Given(bytes) if bytes.is_empty())
    }

    pub fn next(&mut self) -> u64 {
        match self {
            Self::Seeded(state) => {
                *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
                let mut mixed = *state;
                mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
                mixed ^ (mixed >> 31)
            }
            Self::Given(_) => self.bytes::<8>(),
        }
    }

    pub fn below(&mut self, bound: usize) -> usize {
        // Few bytes for small numbers: each byte that the fuzzer changes should matter.
        let number = match (&self, bound) {
            (Self::Seeded(_), _) => self.next(),
            (Self::Given(_), ..=0x100) => self.bytes::<1>(),
            (Self::Given(_), ..=0x1_0000) => self.bytes::<2>(),
            (Self::Given(_), _) => self.next(),
        };
        (number % bound as u64) as usize
    }

    fn bytes<const N: usize>(&mut self) -> u64 {
        let Self::Given(bytes) = self else { unreachable!("of bytes only") };
        (0..N).fold(0, |number, _| number << 8 | u64::from(bytes.pop().unwrap_or(0)))
    }

    pub fn one_in(&mut self, bound: usize) -> bool {
        self.below(bound) == 0
    }

    pub fn fraction(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    /// Any number: small, large, special, or any bits.
    pub fn number(&mut self) -> f64 {
        match self.below(8) {
            0 => self.pick(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, f64::MAX, f64::MIN_POSITIVE]),
            1 => f64::from_bits(self.next()),
            2 => 10f64.powi(self.below(40) as i32 - 20),
            _ => 20.0 * self.fraction() - 10.0,
        }
    }

    /// A value for a variable, mostly legal.
    pub fn value_for(&mut self, variable: &Variable) -> f64 {
        let start = variable.start.unwrap_or(1.0);
        if let Kind::Enumeration(of) = variable.kind
            && !self.one_in(8)
        {
            return of.items[self.below(of.items.len())].0.into();
        }
        if let Some(Chosen { of, .. }) = variable.chooses {
            return self.below(of.items.len() + 2) as f64;
        }
        // Any other number is refused.
        if variable.kind == Kind::Boolean {
            return if self.one_in(12) { 2.0 } else { self.below(2) as f64 };
        }
        match self.below(12) {
            0 => self.number(),
            1 => variable.min.unwrap_or(start),
            2 => variable.max.unwrap_or(start),
            3 => start,
            4 => start * 10f64.powf(2.0 * self.fraction() - 1.0),
            _ => start * (0.9 + 0.2 * self.fraction()),
        }
    }
}
