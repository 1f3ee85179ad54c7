//! Coefficients that depend on the size of a step alone, kept while steps have that size.

use crate::numbers::Varying;
use crate::system::Stride;

/// The strides of two step sizes: steps between points that a host multiplies out differ by rounding, and usually alternate between
/// two sizes.
#[derive(Clone, Copy, Debug)]
pub struct Strides<S> {
    known: [Stride<S>; 2],
    /// The one used last.
    last: usize,
}

impl<S: Varying> Strides<S> {
    /// No size is known yet.
    pub fn unknown() -> Self {
        Self { known: [Stride { size: f64::NAN, half: [[S::zero(); 2]; 2] }; 2], last: 0 }
    }

    /// The stride of a size in s, made if it is not known.
    pub fn of(&mut self, size: f64, make: impl FnOnce(f64) -> Stride<S>) -> Stride<S> {
        if self.known[self.last].size != size {
            self.last = 1 - self.last;
            if self.known[self.last].size != size {
                self.known[self.last] = make(size);
            }
        }
        self.known[self.last]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::{Real, Scalar};

    #[test]
    fn strides_of_two_sizes_in_turn_are_made_once() {
        let (mut strides, mut made) = (Strides::<Real>::unknown(), 0);
        let mut half = |size: f64| {
            let make = |size: f64| {
                made += 1;
                Stride { size, half: [[Real::of(size); 2]; 2] }
            };
            strides.of(size, make).half[0][0].value
        };
        let sizes = [1.0, 2.0, 1.0, 1.0, 2.0, 3.0, 2.0, 1.0];
        assert_eq!(sizes.map(&mut half), sizes);
        assert_eq!(made, 4, "1, 2, 3, and 1 once more");
    }
}
