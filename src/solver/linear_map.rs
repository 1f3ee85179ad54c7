//! Linear differential equations whose coefficients vary: `dz/dt = A(t)*z + b(t)`, with a column of `b` for each of several
//! inhomogeneities.
//!
//! # Source
//! Blanes, Casas, Oteo, Ros (2009), Physics Reports 470:151-238: the expansion of Magnus of order 6 by Gauss nodes.

use super::array;

/// Nodes of Gauss and Legendre as fractions of a stretch.
pub const NODES: [f64; 3] = [0.112_701_665_379_258_3, 0.5, 0.887_298_334_620_741_7];
/// Terms of the series of an exponential, and the largest sum of a column for which they are enough.
const TERMS: usize = 12;
const SMALL: f64 = 0.5;

/// Coefficients of such an equation, or the map of its solutions: of the states `z` at the start and of constant weights of the
/// inhomogeneities. Both column by column.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearMap<const N: usize> {
    /// Of the states.
    pub states: [[f64; N]; N],
    /// Of the inhomogeneities.
    pub others: Vec<[f64; N]>,
}

impl<const N: usize> LinearMap<N> {
    /// The map of no time at all.
    pub fn identity(others: usize) -> Self {
        let mut states = [[0.0; N]; N];
        (0..N).for_each(|i| states[i][i] = 1.0);
        Self { states, others: vec![[0.0; N]; others] }
    }

    /// The map over a stretch in s, from the coefficients at its [`NODES`], and the largest share by which the orders 4 and 6 of its
    /// logarithm differ: of the largest number of the column, or of 1 in a column of the states.
    pub fn of_stretch([first, middle, last]: &[Self; 3], h: f64) -> (Self, f64) {
        let root = f64::sqrt(15.0);
        let constant = Self::sum(&[(h, middle)]);
        let linear = Self::sum(&[(root * h / 3.0, last), (-root * h / 3.0, first)]);
        let quadratic = Self::sum(&[(10.0 * h / 3.0, last), (-20.0 * h / 3.0, middle), (10.0 * h / 3.0, first)]);
        let turn = constant.commutator(&linear);
        let twist = constant.commutator(&Self::sum(&[(2.0, &quadratic), (1.0, &turn)]));
        let left = Self::sum(&[(-20.0, &constant), (-1.0, &quadratic), (1.0, &turn)]);
        let right = Self::sum(&[(1.0, &linear), (-1.0 / 60.0, &twist)]);
        let six = Self::sum(&[(1.0, &constant), (1.0 / 12.0, &quadratic), (1.0 / 240.0, &left.commutator(&right))]);
        let four = Self::sum(&[(1.0, &constant), (1.0 / 12.0, &quadratic), (-1.0 / 12.0, &turn)]);
        let error = six.distance(&four);
        (six.exponential(), error)
    }

    /// This map after another one.
    pub fn after(&self, before: &Self) -> Self {
        let others = before.others.iter().zip(&self.others);
        let others = others.map(|(before, own)| array_sum(&self.times(before), own)).collect();
        Self { states: array_of(|column| self.times(&before.states[column])), others }
    }

    /// The change of the states that a change of them comes to.
    pub fn times(&self, z: &[f64; N]) -> [f64; N] {
        let mut result = [0.0; N];
        for (column, factor) in self.states.iter().zip(z).filter(|(_, factor)| **factor != 0.0) {
            for i in 0..N {
                result[i] += column[i] * factor;
            }
        }
        result
    }

    fn sum(terms: &[(f64, &Self)]) -> Self {
        let mut sum = Self { states: [[0.0; N]; N], others: vec![[0.0; N]; terms[0].1.others.len()] };
        for (factor, term) in terms {
            let columns = sum.states.iter_mut().chain(&mut sum.others).zip(term.states.iter().chain(&term.others));
            for (slots, entries) in columns {
                slots.iter_mut().zip(entries).for_each(|(slot, entry)| *slot += factor * entry);
            }
        }
        sum
    }

    /// `[X, Y] = X*Y - Y*X`, where the inhomogeneities are states that rest.
    fn commutator(&self, other: &Self) -> Self {
        let difference = |own: &[f64; N], others: &[f64; N]| {
            let (forth, back) = (self.times(others), other.times(own));
            array(|i| forth[i] - back[i])
        };
        let others = self.others.iter().zip(&other.others).map(|(own, others)| difference(own, others)).collect();
        Self { states: array_of(|column| difference(&self.states[column], &other.states[column])), others }
    }

    /// By the series of a small part, and squares.
    fn exponential(&self) -> Self {
        let sums = self.states.iter().map(|column| column.iter().map(|entry| entry.abs()).sum::<f64>());
        let largest = sums.fold(0.0, f64::max);
        let squares = if largest > SMALL { (largest / SMALL).log2().ceil() as i32 } else { 0 };
        let part = Self::sum(&[(0.5f64.powi(squares), self)]);
        let series = |first: [f64; N], begin: [f64; N]| {
            let (mut term, mut sum) = (first, array_sum(&begin, &first));
            for number in 2..=TERMS {
                if term == [0.0; N] {
                    break;
                }
                term = part.times(&term).map(|entry| entry / number as f64);
                sum = array_sum(&sum, &term);
            }
            sum
        };
        let states = array_of(|column| {
            let mut begin = [0.0; N];
            begin[column] = 1.0;
            series(part.states[column], begin)
        });
        let others = part.others.iter().map(|column| series(*column, [0.0; N])).collect();
        let mut map = Self { states, others };
        (0..squares).for_each(|_| map = map.after(&map));
        map
    }

    /// The largest distance of a column from another map's, relative to what is largest in it, in a column of the states at least 1.
    fn distance(&self, other: &Self) -> f64 {
        let largest = |column: &[f64; N]| column.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
        let apart = |own: &[f64; N], others: &[f64; N], least: f64| {
            let (distance, size) = (largest(&array(|i| own[i] - others[i])), largest(own).max(least));
            if size > 0.0 { distance / size } else { distance }
        };
        let states = self.states.iter().zip(&other.states).map(|(own, others)| apart(own, others, 1.0));
        let others = self.others.iter().zip(&other.others).map(|(own, others)| apart(own, others, 0.0));
        // A number that is none must not be passed over.
        states.chain(others).fold(0.0, |worst, it| if it.is_nan() { f64::INFINITY } else { worst.max(it) })
    }
}

fn array_of<const N: usize>(column: impl Fn(usize) -> [f64; N]) -> [[f64; N]; N] {
    let mut columns = [[0.0; N]; N];
    columns.iter_mut().enumerate().for_each(|(number, slot)| *slot = column(number));
    columns
}

fn array_sum<const N: usize>(one: &[f64; N], other: &[f64; N]) -> [f64; N] {
    array(|i| one[i] + other[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pendulum that is pushed with a constant force: an oscillation of `sqrt(k)` about `f/k`.
    #[test]
    fn exponential_of_an_oscillation_is_the_oscillation() {
        for (k, h) in [(4.0, 0.1), (4.0, 3.0), (1e4, 0.2)] {
            let at = LinearMap { states: [[0.0, -k], [1.0, 0.0]], others: vec![[0.0, 1.0]] };
            let (map, error) = LinearMap::of_stretch(&[at.clone(), at.clone(), at], h);
            let w = f64::sqrt(k);
            let [sine, cosine] = [(w * h).sin(), (w * h).cos()];
            let expected = [cosine, -w * sine, sine / w, cosine, (1.0 - cosine) / k, sine / w];
            for (entry, expected) in map.states.iter().chain(&map.others).flatten().zip(expected) {
                assert!((entry - expected).abs() < 1e-10 * w, "k = {k}, h = {h}: {entry}, not {expected}");
            }
            assert_eq!(error, 0.0);
        }
    }

    /// `dz/dt = -2*t*z + 2*t` has the solution `1 + (z0 - 1)*exp(-t^2)`, and two parts of a time give the whole.
    #[test]
    fn equation_of_one_state_is_solved() {
        let at = |t: f64| LinearMap { states: [[-2.0 * t]], others: vec![[2.0 * t]] };
        let over = |from: f64, h: f64| LinearMap::of_stretch(&NODES.map(|node| at(from + node * h)), h).0;
        let (whole, parts) = (over(0.0, 1.0), over(0.25, 0.75).after(&over(0.0, 0.25)));
        let expected = [(-1.0f64).exp(), 1.0 - (-1.0f64).exp()];
        for map in [whole, parts] {
            let found = [map.states[0][0], map.others[0][0]];
            let are_near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-13);
            assert!(are_near, "{found:?}, not {expected:?}");
        }
    }

    /// Order 6 in the step size, and an estimate of the error of order 4: Airy's equation `d2z/dt2 = t*z` from two step sizes.
    #[test]
    fn error_falls_with_the_order_and_is_not_underestimated() {
        let at = |t: f64| LinearMap { states: [[0.0, t], [1.0, 0.0]], others: vec![] };
        let over = |parts: usize| {
            let h = 2.0 / parts as f64;
            let mut worst: f64 = 0.0;
            let mut all = LinearMap::identity(0);
            for part in 0..parts {
                let (map, error) = LinearMap::of_stretch(&NODES.map(|node| at((part as f64 + node) * h)), h);
                (all, worst) = (map.after(&all), worst.max(error));
            }
            (all.states, worst)
        };
        let ((coarse, estimate), (fine, _), (exact, _)) = (over(4), over(8), over(256));
        let distance = |one: [[f64; 2]; 2]| {
            let pairs = one.iter().flatten().zip(exact.iter().flatten());
            pairs.fold(0.0, |largest: f64, (a, b)| largest.max((a - b).abs()))
        };
        let ratio = distance(coarse) / distance(fine);
        assert!((40.0..100.0).contains(&ratio), "{ratio}");
        assert!(distance(coarse) < estimate, "{} {estimate}", distance(coarse));
    }
}
