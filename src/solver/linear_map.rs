//! Linear differential equations whose coefficients vary: `dz/dt = A(t)*z + b(t)`, with a column of `b` for each of several
//! inhomogeneities.
//!
//! # Source
//! Blanes, Casas, Oteo, Ros (2009), Physics Reports 470:151-238: the expansion of Magnus of order 6 by Gauss nodes.

use super::array;

/// Nodes of Gauss and Legendre as fractions of a stretch.
pub const NODES: [f64; 3] = [0.112_701_665_379_258_3, 0.5, 0.887_298_334_620_741_7];
/// The largest measure of a matrix for which the polynomial is enough for the exponential.
const SMALL: f64 = 0.5;
/// Coefficients of the polynomial of degree 12, three by three from the last one behind them downwards.
const POLYNOMIAL: [[f64; 3]; 4] = [
    [1.0 / 362_880.0, 1.0 / 3_628_800.0, 1.0 / 39_916_800.0],
    [1.0 / 720.0, 1.0 / 5_040.0, 1.0 / 40_320.0],
    [1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0],
    [1.0, 1.0, 1.0 / 2.0],
];
const LAST: f64 = 1.0 / 479_001_600.0;
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
    fn zero(others: usize) -> Self {
        Self { states: [[0.0; N]; N], others: vec![[0.0; N]; others] }
    }

    /// The map of no time at all.
    pub fn identity(others: usize) -> Self {
        let mut map = Self::zero(others);
        (0..N).for_each(|i| map.states[i][i] = 1.0);
        map
    }

    /// The map of order 6 over a stretch in s, from the coefficients at its [`NODES`], and about the error of the map of
    /// order 4.
    pub fn of_stretch(nodes: &[Self; 3], h: f64) -> [Self; 2] {
        let active = Active::of(nodes);
        // Of a few sizes, of which each is compiled.
        match active.states.len() {
            0..=8 => active.of_stretch::<8, N>(nodes, h),
            9..=12 => active.of_stretch::<12, N>(nodes, h),
            13..=16 => active.of_stretch::<16, N>(nodes, h),
            _ => active.of_stretch::<N, N>(nodes, h),
        }
    }

    /// The largest magnitude in each column; the columns of states come first.
    pub fn sizes(&self) -> impl Iterator<Item = f64> {
        self.states.iter().chain(&self.others).map(|column| largest(*column))
    }

    /// This map after another one; also a change of such a map.
    pub fn after(&self, before: &Self) -> Self {
        let others = before.others.iter().zip(&self.others);
        let sum = |(before, own): (&[f64; N], &[f64; N])| {
            let carried = self.times(before);
            array(|i| carried[i] + own[i])
        };
        let mut states = [[0.0; N]; N];
        states.iter_mut().zip(&before.states).for_each(|(slot, column)| *slot = self.times(column));
        Self { states, others: others.map(sum).collect() }
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
}

/// What is not zero in the coefficients of a stretch: the others are states that rest and move nothing, and inhomogeneities that act on
/// nothing.
struct Active {
    states: Vec<usize>,
    others: Vec<usize>,
}

impl Active {
    fn of<const N: usize>(nodes: &[LinearMap<N>; 3]) -> Self {
        let mut is_state = [false; N];
        let mut is_other = vec![false; nodes[0].others.len()];
        let is_there = |entry: &f64| *entry != 0.0;
        for node in nodes {
            for (place, column) in node.states.iter().enumerate() {
                for row in (0..N).filter(|row| is_there(&column[*row])) {
                    (is_state[place], is_state[row]) = (true, true);
                }
            }
            for (is_other, column) in is_other.iter_mut().zip(&node.others) {
                for row in (0..N).filter(|row| is_there(&column[*row])) {
                    (*is_other, is_state[row]) = (true, true);
                }
            }
        }
        let places = |is_there: &[bool]| (0..is_there.len()).filter(|place| is_there[*place]).collect();
        Self { states: places(&is_state), others: places(&is_other) }
    }

    /// [`LinearMap::of_stretch`] in at most as many active states.
    fn of_stretch<const R: usize, const N: usize>(&self, nodes: &[LinearMap<N>; 3], h: f64) -> [LinearMap<N>; 2] {
        let [first, middle, last] = nodes.each_ref().map(|node| self.part::<R, N>(node));
        let (six, lacking) = Matrix::logarithm([&first, &middle, &last], h);
        let map = six.exponential();
        // The derivative of an exponential is an integral over a way, of which these are the ends: at one of them what decays is there.
        let lacking = Matrix::sum(&[(0.5, &lacking.times(&map, 1.0)), (0.5, &map.times(&lacking, 0.0))]);
        let others = nodes[0].others.len();
        [(map, LinearMap::identity(others)), (lacking, LinearMap::zero(others))]
            .map(|(part, whole)| self.put_into(whole, &part))
    }

    fn part<const R: usize, const N: usize>(&self, whole: &LinearMap<N>) -> Matrix<R> {
        let columns = self.states.iter().map(|place| &whole.states[*place]);
        let columns = columns.chain(self.others.iter().map(|place| &whole.others[*place]));
        let part = |column: &[f64; N]| array(|row| self.states.get(row).map_or(0.0, |place| column[*place]));
        Matrix { states: self.states.len(), columns: columns.map(part).collect() }
    }

    fn put_into<const R: usize, const N: usize>(&self, mut whole: LinearMap<N>, part: &Matrix<R>) -> LinearMap<N> {
        let fill = |slots: &mut [f64; N], column: &[f64; R]| {
            self.states.iter().zip(column).for_each(|(row, entry)| slots[*row] = *entry);
        };
        let (of_states, of_others) = part.columns.split_at(self.states.len());
        self.states.iter().zip(of_states).for_each(|(place, column)| fill(&mut whole.states[*place], column));
        self.others.iter().zip(of_others).for_each(|(place, column)| fill(&mut whole.others[*place], column));
        whole
    }
}

/// A matrix of at most `R` states, and behind its columns those of inhomogeneities, which are states that rest.
#[derive(Clone)]
struct Matrix<const R: usize> {
    states: usize,
    columns: Vec<[f64; R]>,
}

impl<const R: usize> Matrix<R> {
    /// The logarithm of order 6 of the map over a stretch in s, from the coefficients at its nodes, and its difference from the one of
    /// order 4.
    fn logarithm([first, middle, last]: [&Self; 3], h: f64) -> (Self, Self) {
        let root = f64::sqrt(15.0);
        let constant = Self::sum(&[(h, middle)]);
        let linear = Self::sum(&[(root * h / 3.0, last), (-root * h / 3.0, first)]);
        let quadratic = Self::sum(&[(10.0 * h / 3.0, last), (-20.0 * h / 3.0, middle), (10.0 * h / 3.0, first)]);
        let turn = constant.commutator(&linear);
        let twist = constant.commutator(&Self::sum(&[(2.0, &quadratic), (1.0, &turn)]));
        let left = Self::sum(&[(-20.0, &constant), (-1.0, &quadratic), (1.0, &turn)]);
        let right = Self::sum(&[(1.0, &linear), (-1.0 / 60.0, &twist)]);
        let bend = left.commutator(&right);
        let six = Self::sum(&[(1.0, &constant), (1.0 / 12.0, &quadratic), (1.0 / 240.0, &bend)]);
        (six, Self::sum(&[(1.0 / 240.0, &bend), (1.0 / 12.0, &turn)]))
    }

    fn sum(terms: &[(f64, &Self)]) -> Self {
        let mut sum = Self { states: terms[0].1.states, columns: vec![[0.0; R]; terms[0].1.columns.len()] };
        terms.iter().for_each(|(factor, term)| sum.add(*factor, term));
        sum
    }

    fn add(&mut self, factor: f64, term: &Self) {
        for (slots, column) in self.columns.iter_mut().zip(&term.columns) {
            (0..R).for_each(|row| slots[row] += factor * column[row]);
        }
    }

    /// The product with another one, in whose rows of the inhomogeneities are those of the unit matrix times a weight.
    fn times(&self, other: &Self, weight: f64) -> Self {
        let product = |(factors, own): (&[f64; R], Option<&[f64; R]>)| {
            let mut sum = own.map_or([0.0; R], |own| own.map(|entry| weight * entry));
            for (column, factor) in self.columns[..self.states].iter().zip(factors) {
                (0..R).for_each(|row| sum[row] += column[row] * factor);
            }
            sum
        };
        let (of_states, of_others) = other.columns.split_at(self.states);
        let of_others = of_others.iter().zip(self.columns[self.states..].iter().map(Some));
        let columns = of_states.iter().map(|column| (column, None)).chain(of_others).map(product).collect();
        Self { states: self.states, columns }
    }

    /// `[X, Y] = X*Y - Y*X`.
    fn commutator(&self, other: &Self) -> Self {
        let mut difference = self.times(other, 0.0);
        difference.add(-1.0, &other.times(self, 0.0));
        difference
    }

    /// By a polynomial of a small part, whose rows of the inhomogeneities are those of the unit matrix, and squares. What counts is how
    /// the powers of the matrix grow, which may be less than the sum of a column says (Al-Mohy, Higham (2009), SIAM Journal on Matrix
    /// Analysis and Applications 31:970-989).
    fn exponential(&self) -> Self {
        let square = self.times(self, 0.0);
        let cube = self.times(&square, 0.0);
        let growth = square.norm().sqrt().max(libm::cbrt(cube.norm()));
        if !growth.is_finite() {
            return Self::sum(&[(f64::NAN, self)]);
        }
        let squares = if growth > SMALL { libm::log2(growth / SMALL).ceil() as i32 } else { 0 };
        let factor = libm::ldexp(1.0, -squares);
        let cube = Self::sum(&[(factor * factor * factor, &cube)]);
        let mut whole = Self::sum(&[(LAST, &cube)]);
        for (place, [constant, linear, quadratic]) in POLYNOMIAL.into_iter().enumerate() {
            if let Some([before, ..]) = place.checked_sub(1).map(|before| POLYNOMIAL[before]) {
                whole = cube.times(&whole, before);
            }
            whole.add(linear * factor, self);
            whole.add(quadratic * factor * factor, &square);
            (0..whole.states).for_each(|i| whole.columns[i][i] += constant);
        }
        (0..squares).for_each(|_| whole = whole.times(&whole, 1.0));
        whole
    }

    /// The largest sum of a column of the states.
    fn norm(&self) -> f64 {
        largest(self.columns[..self.states].iter().map(|column| column.iter().map(|entry| entry.abs()).sum()))
    }
}

/// The largest magnitude of some numbers, infinite if one of them is NaN.
fn largest(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |largest: f64, number: f64| if number.is_nan() { f64::INFINITY } else { largest.max(number.abs()) };
    numbers.into_iter().fold(0.0, larger)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pendulum that is pushed with a constant force: an oscillation of `sqrt(k)` about `f/k`.
    #[test]
    fn exponential_of_an_oscillation_is_the_oscillation() {
        for (k, h) in [(4.0, 0.1), (4.0, 3.0), (1e4, 0.2)] {
            let at = LinearMap { states: [[0.0, -k], [1.0, 0.0]], others: vec![[0.0, 1.0]] };
            let [map, lacking] = LinearMap::of_stretch(&[at.clone(), at.clone(), at], h);
            let w = f64::sqrt(k);
            let [sine, cosine] = [(w * h).sin(), (w * h).cos()];
            let expected = [cosine, -w * sine, sine / w, cosine, (1.0 - cosine) / k, sine / w];
            for (entry, expected) in map.states.iter().chain(&map.others).flatten().zip(expected) {
                assert!((entry - expected).abs() < 1e-10 * w, "k = {k}, h = {h}: {entry}, not {expected}");
            }
            assert_eq!(lacking, LinearMap::zero(1));
        }
    }

    /// `dz/dt = -2*t*z + 2*t` has the solution `1 + (z0 - 1)*exp(-t^2)`, and two parts of a time give the whole.
    #[test]
    fn equation_of_one_state_is_solved() {
        let at = |t: f64| LinearMap { states: [[-2.0 * t]], others: vec![[2.0 * t]] };
        let over = |from: f64, h: f64| LinearMap::of_stretch(&NODES.map(|node| at(from + node * h)), h)[0].clone();
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
            let (mut all, mut error) = (LinearMap::identity(0), 0.0);
            for part in 0..parts {
                let [map, lacking] = LinearMap::of_stretch(&NODES.map(|node| at((part as f64 + node) * h)), h);
                error += lacking.after(&all).sizes().fold(0.0, f64::max);
                all = map.after(&all);
            }
            (all.states, error)
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
