//! The adaptive scheme: Rodas4, a stiffly accurate, L-stable Rosenbrock method of order 4 with 6 stages and an
//! embedded solution of order 3.
//!
//! Hairer, Wanner (1996), Solving Ordinary Differential Equations II, 2nd edition, section IV.10 and the code RODAS.
//! The coefficients are transformed (section IV.7) so that no stage needs a product with the Jacobian.

use super::linear::Inverse;
use super::trial::{Linearisation, Trial};
use super::{array, numbers, values};
use crate::numbers::{DIRECTIONS, Slopes, Varying};
use crate::system::{Held, System};

const GAMMA: f64 = 0.25;

/// Weights of the earlier stages in the argument of stages 2 to 5; stage 6 adds the fifth stage to the fifth argument.
const A2: [f64; 1] = [1.544];
const A3: [f64; 2] = [0.946_678_528_081_582_6, 0.255_701_169_898_328_4];
const A4: [f64; 3] = [3.314_825_187_068_521, 2.896_124_015_972_201, 0.998_641_913_997_781_7];
const A5: [f64; 4] = [1.221_224_509_226_641, 6.019_134_481_288_629, 12.537_083_329_320_87, -0.687_886_036_105_895];

/// Weights of the earlier stages on the right-hand side of stages 2 to 6, divided by the step size.
const C2: [f64; 1] = [-5.6688];
const C3: [f64; 2] = [-2.430_093_356_833_875, -0.206_359_915_709_191_5];
const C4: [f64; 3] = [-0.107_352_905_815_137_5, -9.594_562_251_023_355, -20.470_286_148_096_16];
const C5: [f64; 4] = [7.496_443_313_967_647, -10.246_804_314_643_52, -33.999_903_528_199_05, 11.708_908_932_061_6];
const C6: [f64; 5] = [
    8.083_246_795_921_522,
    -7.981_132_988_064_893,
    -31.521_594_328_743_71,
    16.319_305_431_231_36,
    -6.058_818_238_834_054,
];

/// Time of stages 1 to 4 within the step; stages 5 and 6 are at its end.
const ALPHA: [f64; 4] = [0.0, 0.386, 0.21, 0.63];

/// Weights of the partial derivative with respect to time in stages 1 to 4, multiplied by the step size.
const D: [f64; 4] = [0.25, -0.1043, 0.1035, -0.036_200_000_000_000_23];

/// One step of size `h`; `None` if it leads nowhere.
pub fn step<H: System<U>, S: Varying, const N: usize, const U: usize>(
    system: &H,
    time: f64,
    x: &[S; N],
    inputs: &Held<U, S>,
    memory: &H::Memory<S>,
    linearisation: &Linearisation<N, S>,
    h: f64,
) -> Option<Trial<N, S>> {
    let inverse =
        Inverse::new(&linearisation.jacobian, 1.0 / (GAMMA * h), H::GROUPS, system.hints(x, memory).is_chain)?;
    let rates = |fraction: f64, argument: &[S; N]| {
        let stage_time = time + fraction * h;
        system.derivatives(S::of(stage_time), argument, &inputs.at(stage_time), memory)
    };
    // With `W = I/(gamma*h) - J` a stage `W*k = r` varies by `W*k' = r' + J'*k`.
    let solve = |right: [S; N]| {
        let solved = inverse.times(&values(&right), H::GROUPS);
        if !S::VARIES {
            return numbers(&solved);
        }
        let bent = change_along(|share| {
            let moved: [S; N] = array(|i| S::with(x[i].value() + share * solved[i], x[i].slopes()));
            system.derivatives(S::of(time), &moved, &inputs.at(time), memory)
        });
        let slopes: [[f64; N]; DIRECTIONS] = std::array::from_fn(|way| {
            let right: [f64; N] = array(|i| right[i].slopes()[way] + bent[i][way]);
            inverse.times(&right, H::GROUPS)
        });
        array(|i| S::with(solved[i], slopes.map(|slopes| slopes[i])))
    };
    let drift = linearisation.time_slopes.map(|drift| {
        if !S::VARIES {
            return numbers(&drift);
        }
        let changes = change_along(|share| rates(share, x));
        array(|i| S::with(drift[i], changes[i].map(|change| change / h)))
    });
    let in_time = |right: [S; N], weight: f64| match &drift {
        Some(slopes) => combine(&right, [slopes], [weight], h),
        None => right,
    };
    let per_h = 1.0 / h;
    let k1 = solve(in_time(linearisation.derivatives, D[0]));
    let right = combine(&rates(ALPHA[1], &combine(x, [&k1], A2, 1.0)), [&k1], C2, per_h);
    let k2 = solve(in_time(right, D[1]));
    let right = combine(&rates(ALPHA[2], &combine(x, [&k1, &k2], A3, 1.0)), [&k1, &k2], C3, per_h);
    let k3 = solve(in_time(right, D[2]));
    let right = combine(&rates(ALPHA[3], &combine(x, [&k1, &k2, &k3], A4, 1.0)), [&k1, &k2, &k3], C4, per_h);
    let k4 = solve(in_time(right, D[3]));
    let argument = combine(x, [&k1, &k2, &k3, &k4], A5, 1.0);
    let k5 = solve(combine(&rates(1.0, &argument), [&k1, &k2, &k3, &k4], C5, per_h));
    let argument = combine(&argument, [&k5], [1.0], 1.0);
    let k6 = solve(combine(&rates(1.0, &argument), [&k1, &k2, &k3, &k4, &k5], C6, per_h));
    // The last stage is the difference between the solutions of order 4 and 3.
    Some(Trial { end: combine(&argument, [&k6], [1.0], 1.0), error: k6 })
}

/// Change of the derivatives of numbers along a path, at its start: the second derivative of a smooth function, by central differences of
/// the first, which is exact. They are good to some 1e-10.
fn change_along<S: Varying, const N: usize>(numbers: impl Fn(f64) -> [S; N]) -> [Slopes; N] {
    const SHARE: f64 = 1e-5;
    let (ahead, behind) = (numbers(SHARE), numbers(-SHARE));
    let change = |ahead: S, behind: S| {
        let (ahead, behind) = (ahead.slopes(), behind.slopes());
        std::array::from_fn(|way| (ahead[way] - behind[way]) / (2.0 * SHARE))
    };
    array(|i| change(ahead[i], behind[i]))
}

/// A vector plus a weighted sum of vectors, whose weights are multiplied by a factor.
#[inline(always)]
fn combine<S: Varying, const N: usize, const M: usize>(
    base: &[S; N],
    vectors: [&[S; N]; M],
    weights: [f64; M],
    factor: f64,
) -> [S; N] {
    let mut sum = *base;
    for (vector, weight) in vectors.iter().zip(weights) {
        let weight = weight * factor;
        for i in 0..N {
            sum[i] += vector[i] * weight;
        }
    }
    sum
}
