//! Explicit steps of a state that relaxes within a step, as the bristle of a sliding contact does: exponential time
//! differencing, in which a linear relaxation is exact, however fast it is.
//!
//! Krogstad (2005), Journal of Computational Physics. Without relaxation it is the classical method; for any
//! rate its order is 4, so that the rate need not be exact. With half the evaluations its order is 2: Hochbruck, Ostermann
//! (2010), Acta Numerica.

use crate::numbers::Scalar;

/// Share of a relaxation within a step below which the classical method is as good. Much further down, the weights below
/// would be differences of nearly equal numbers: here they lose four digits of sixteen.
const SLOW: f64 = 0.05;

/// The weights of a step for a state that relaxes at a rate `r`, driven by the rest of its derivative.
#[derive(Clone, Copy, Debug)]
pub struct Relaxing {
    /// In 1/s.
    rate: f64,
    /// Decay of the state over half a step and the whole step.
    half: f64,
    whole: f64,
    /// Weight in s of the first drive in the second argument.
    second: f64,
    /// Weight in s of the change of the drive from the first stage to the second in the third argument.
    third: f64,
    /// Weights in s of the first drive, and of the change from the first stage to the third, in the fourth argument.
    fourth: [f64; 2],
    /// Weights in s of the first drive, of those in the middle, and of the fourth in the result.
    result: [f64; 3],
}

impl Relaxing {
    /// The weights for a rate in 1/s and a step of a size in s; `None` where the state is so slow that it needs none.
    pub fn new(rate: f64, h: f64) -> Option<Self> {
        let exponent = -rate * h;
        if exponent.is_nan() || exponent > -SLOW {
            return None;
        }
        let half_exponent = 0.5 * exponent;
        let half = libm::exp(half_exponent);
        let whole = half * half;
        // The functions phi of exponential integrators: of half a step, and of the whole.
        let per_half = 1.0 / half_exponent;
        let per_whole = 0.5 * per_half;
        let half_1 = (half - 1.0) * per_half;
        let half_2 = (half_1 - 1.0) * per_half;
        let phi_1 = (whole - 1.0) * per_whole;
        let phi_2 = (phi_1 - 1.0) * per_whole;
        let phi_3 = (phi_2 - 0.5) * per_whole;
        Some(Self {
            rate,
            half,
            whole,
            second: 0.5 * h * half_1,
            third: h * half_2,
            fourth: [h * phi_1, 2.0 * h * phi_2],
            result: [
                h * (phi_1 - 3.0 * phi_2 + 4.0 * phi_3),
                h * (2.0 * phi_2 - 4.0 * phi_3),
                h * (4.0 * phi_3 - phi_2),
            ],
        })
    }

    /// Derivative of the state without its relaxation.
    pub fn drive<S: Scalar>(&self, state: S, slope: S) -> S {
        slope + state * self.rate
    }

    /// The argument of the second stage.
    pub fn second<S: Scalar>(&self, state: S, first: S) -> S {
        state * self.half + first * self.second
    }

    /// The argument of the third stage, from the second's.
    pub fn third<S: Scalar>(&self, argument: S, [first, second]: [S; 2]) -> S {
        argument + (second - first) * self.third
    }

    /// The argument of the fourth stage.
    pub fn fourth<S: Scalar>(&self, state: S, [first, third]: [S; 2]) -> S {
        state * self.whole + (first * self.fourth[0] + (third - first) * self.fourth[1])
    }

    /// The state at the end.
    pub fn end<S: Scalar>(&self, state: S, [first, second, third, fourth]: [S; 4]) -> S {
        let [outer, inner, last] = self.result;
        state * self.whole + (first * outer + (second + third) * inner + fourth * last)
    }

    /// Its error: as in the classical method, three times the weight of the fourth stage is moved to the end.
    pub fn error<S: Scalar>(&self, fourth: S, end: S) -> S {
        (fourth - end) * (3.0 * self.result[2])
    }

    /// By how much the drives in the middle differ from those at the ends.
    pub fn defect<S: Scalar>(&self, [first, second, third, fourth]: [S; 4]) -> S {
        (first + fourth - second - third) * self.result[2]
    }

    /// The state at the end of a step with half the evaluations, in which the drive grows from the first stage on as it does
    /// up to the middle.
    pub fn half_evaluated<S: Scalar>(&self, state: S, drives: [S; 2]) -> S {
        self.fourth(state, drives)
    }

    /// Its error: by how much a drive that grows as it does up to the end brings more.
    pub fn half_evaluated_error<S: Scalar>(&self, [first, middle, end]: [S; 3]) -> S {
        (first + end - middle * 2.0) * (0.5 * self.fourth[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Real;

    /// A step of `dx/dt = -rate*x + drive(t)` from 1.
    fn step(rate: f64, h: f64, drive: impl Fn(f64) -> f64) -> f64 {
        let relaxing = Relaxing::new(rate, h).expect("a fast state");
        let drives = [0.0, 0.5, 0.5, 1.0].map(|fraction| drive(fraction * h));
        relaxing.end(Real::of(1.0), drives.map(Real::of)).value
    }

    #[test]
    fn linear_relaxation_is_exact_at_any_rate() {
        for rate in [51.0, 501.0, 5e3, 1e5, 1e9] {
            let exact = |t: f64| 0.25 + 0.75 * (-rate * t).exp();
            let found = step(rate, 1e-3, |_| 0.25 * rate);
            assert!((found - exact(1e-3)).abs() < 1e-14, "{rate}: {found}");
            let relaxing = Relaxing::new(rate, 1e-3).expect("a fast state");
            let second = relaxing.second(Real::of(1.0), Real::of(0.25 * rate)).value;
            assert!((second - exact(0.5e-3)).abs() < 1e-14, "{rate}: {second}");
        }
    }

    /// `x = (t - 1/r)*b + (1 + b/r)*exp(-r*t)` for a drive `b*r*t`; and a parabola likewise.
    #[test]
    fn drive_that_is_a_parabola_in_time_is_exact() {
        let (rate, h) = (7e3, 1e-3);
        let particular = |t: f64| t * t - 2.0 * t / rate + 2.0 / (rate * rate);
        let exact = particular(h) + (1.0 - particular(0.0)) * (-rate * h).exp();
        let found = step(rate, h, |t| rate * t * t);
        assert!((found - exact).abs() < 1e-15, "{found}, not {exact}");
    }

    /// With half the evaluations a drive that grows steadily is exact, and what is lacking for a parabola is the error, but for
    /// what its curvature does within the step.
    #[test]
    fn half_the_evaluations_are_exact_for_a_drive_that_grows_steadily() {
        let h = 1e-3;
        for rate in [51.0, 7e3, 1e6] {
            let particular = |t: f64| 0.25 + 30.0 * (t - 1.0 / rate);
            let exact = particular(h) + (1.0 - particular(0.0)) * (-rate * h).exp();
            let drives = [0.0, 0.5, 1.0].map(|fraction| rate * (0.25 + 30.0 * fraction * h));
            let relaxing = Relaxing::new(rate, h).expect("a fast state");
            let found = relaxing.half_evaluated(Real::of(1.0), [drives[0], drives[1]].map(Real::of)).value;
            assert!((found - exact).abs() < 1e-13, "{rate}: {found}, not {exact}");
            assert!(relaxing.half_evaluated_error(drives.map(Real::of)).value.abs() < 1e-15);
        }
        // A state that follows at once, and a drive that bends by 2 up to the end: as much at the end.
        let relaxing = Relaxing::new(1e9, h).expect("a fast state");
        let error = relaxing.half_evaluated_error([1e9, 2e9, 5e9].map(Real::of)).value;
        assert!((error - 2.0).abs() < 1e-5, "{error}");
    }

    #[test]
    fn slow_states_and_those_that_run_away_need_no_weights() {
        for rate in [0.0, 49.0, -1e6, f64::NAN] {
            assert!(Relaxing::new(rate, 1e-3).is_none(), "{rate}");
        }
    }
}
