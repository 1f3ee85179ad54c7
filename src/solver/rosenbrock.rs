//! The adaptive scheme: Rodas4, a stiffly accurate, L-stable Rosenbrock method of order 4 with 6 stages and an
//! embedded solution of order 3.
//!
//! Hairer, Wanner (1996), Solving Ordinary Differential Equations II, 2nd edition, section IV.10 and the code RODAS.

use super::linear::Factors;
use super::system::{Held, HybridSystem};
use super::run::{Linearisation, Trial};

const STAGES: usize = 6;
const GAMMA: f64 = 0.25;

/// Order of the error estimate: the error of a step falls with this power of its size.
pub const ERROR_ORDER: i32 = 4;

/// Weights of earlier stages in the argument of a stage.
const A: [[f64; STAGES]; STAGES] = [
    [0.0; 6],
    [1.544, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.946_678_528_081_582_6, 0.255_701_169_898_328_4, 0.0, 0.0, 0.0, 0.0],
    [3.314_825_187_068_521, 2.896_124_015_972_201, 0.998_641_913_997_781_7, 0.0, 0.0, 0.0],
    [1.221_224_509_226_641, 6.019_134_481_288_629, 12.537_083_329_320_87, -0.687_886_036_105_895, 0.0, 0.0],
    [1.221_224_509_226_641, 6.019_134_481_288_629, 12.537_083_329_320_87, -0.687_886_036_105_895, 1.0, 0.0],
];

/// Weights of earlier stages on the right-hand side of a stage, divided by the step size.
const C: [[f64; STAGES]; STAGES] = [
    [0.0; 6],
    [-5.6688, 0.0, 0.0, 0.0, 0.0, 0.0],
    [-2.430_093_356_833_875, -0.206_359_915_709_191_5, 0.0, 0.0, 0.0, 0.0],
    [-0.107_352_905_815_137_5, -9.594_562_251_023_355, -20.470_286_148_096_16, 0.0, 0.0, 0.0],
    [7.496_443_313_967_647, -10.246_804_314_643_52, -33.999_903_528_199_05, 11.708_908_932_061_6, 0.0, 0.0],
    [
        8.083_246_795_921_522,
        -7.981_132_988_064_893,
        -31.521_594_328_743_71,
        16.319_305_431_231_36,
        -6.058_818_238_834_054,
        0.0,
    ],
];

/// Time of a stage within the step.
const ALPHA: [f64; STAGES] = [0.0, 0.386, 0.21, 0.63, 1.0, 1.0];

/// Weight of the partial derivative with respect to time.
const D: [f64; STAGES] = [0.25, -0.1043, 0.1035, -0.036_200_000_000_000_23, 0.0, 0.0];

/// One step of size `h`; `None` if it leads nowhere.
pub fn step<H: HybridSystem<N, U>, const N: usize, const U: usize>(
    system: &H,
    time: f64,
    x: &[f64; N],
    inputs: &Held<U>,
    memory: &H::Memory,
    linearisation: &Linearisation<N>,
    h: f64,
) -> Option<Trial<N>> {
    let factors = Factors::new(&linearisation.jacobian, 1.0 / (GAMMA * h))?;
    let inverse_h = 1.0 / h;
    let mut stages = [[0.0; N]; STAGES];
    let mut argument = *x;
    for stage in 0..STAGES {
        let mut right = if stage == 0 {
            linearisation.derivatives
        } else {
            argument = *x;
            for earlier in 0..stage {
                let weight = A[stage][earlier];
                for i in 0..N {
                    argument[i] += weight * stages[earlier][i];
                }
            }
            let stage_time = time + ALPHA[stage] * h;
            system.derivatives(stage_time, &argument, &inputs.at(stage_time), memory)
        };
        for earlier in 0..stage {
            let weight = C[stage][earlier] * inverse_h;
            for i in 0..N {
                right[i] += weight * stages[earlier][i];
            }
        }
        if let Some(time_slopes) = &linearisation.time_slopes {
            for i in 0..N {
                right[i] += h * D[stage] * time_slopes[i];
            }
        }
        factors.solve(&mut right);
        stages[stage] = right;
    }
    // The last stage is the difference between the solutions of order 4 and 3.
    let error = stages[STAGES - 1];
    let end = std::array::from_fn(|i| argument[i] + error[i]);
    Some(Trial { end, error })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The last two stages sit at the end of the step and differ by one increment, so the method is stiffly accurate;
    /// row sums are consistent with the stage times.
    #[test]
    fn last_stages_are_at_the_end_of_the_step() {
        assert_eq!(A[4][..4], A[5][..4]);
        assert_eq!((ALPHA[4], ALPHA[5], A[5][4]), (1.0, 1.0, 1.0));
        assert!((A[1][0] * GAMMA - ALPHA[1]).abs() < 1e-15);
    }
}
