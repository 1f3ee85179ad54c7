//! Explicit schemes, as tables of Butcher.

use super::array;
use super::relaxing::Relaxing;
use super::trial::Trial;
use crate::numbers::Varying;
use crate::system::{ClosedForm, Held, System};

/// An explicit Runge-Kutta method in which each stage uses the one before only.
pub struct Tableau {
    /// Time of each stage within the step, which is also the weight of the stage before.
    times: &'static [f64],
    /// Weights of the stages in the result.
    weights: &'static [f64],
}

/// Explicit Euler method.
pub const EXPLICIT_EULER: Tableau = Tableau { times: &[0.0], weights: &[1.0] };

/// Method of order 3 of Ralston (1962), Mathematics of Computation 16:431-437.
pub const RK3: Tableau = Tableau { times: &[0.0, 0.5, 0.75], weights: &[2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0] };

/// Classical method of order 4 of Kutta (1901).
pub const RK4: Tableau =
    Tableau { times: &[0.0, 0.5, 0.5, 1.0], weights: &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0] };

impl Tableau {
    /// One step of size `h` from given derivatives at its start.
    // One function for all these methods, whose speed does not matter.
    #[inline(never)]
    #[allow(clippy::too_many_arguments, reason = "the system, where it is, and the step")]
    pub fn step<H: System<U>, S: Varying, const N: usize, const U: usize>(
        &self,
        system: &H,
        time: f64,
        x: &[S; N],
        inputs: &Held<U, S>,
        memory: &H::Memory<S>,
        derivatives: &[S; N],
        h: f64,
    ) -> Trial<N, S> {
        let mut slope = *derivatives;
        let mut end = *x;
        for (stage, (fraction, weight)) in self.times.iter().zip(self.weights).enumerate() {
            if stage > 0 {
                let argument = array(|i| x[i] + slope[i] * (fraction * h));
                let stage_time = time + fraction * h;
                slope = system.derivatives(S::of(stage_time), &argument, &inputs.at(stage_time), memory);
            }
            for i in 0..N {
                end[i] += slope[i] * (h * weight);
            }
        }
        Trial { end, error: [S::zero(); N] }
    }
}

/// A step of an explicit method: from where, and how far.
pub struct Stages<'a, H: System<U>, S: Varying, const N: usize, const U: usize> {
    /// The system.
    pub system: &'a H,
    /// Time in s at its start.
    pub time: f64,
    /// States at its start.
    pub x: &'a [S; N],
    /// The inputs.
    pub inputs: &'a Held<U, S>,
    /// The memory.
    pub memory: &'a H::Memory<S>,
    /// Derivatives at its start.
    pub first: &'a [S; N],
    /// Its size in s.
    pub h: f64,
    /// Closed form of the states that follow held inputs alone, used in every stage if given. Their derivatives are then left
    /// to [`System::update_derivatives`].
    pub closed_form: Option<&'a ClosedForm<[S; N]>>,
    /// A relaxing state, and its exponential weights in place of the method's.
    pub relaxing: Option<(usize, &'a Relaxing)>,
}

/// Result of a step, with its estimates.
pub struct Explicit<const N: usize, S> {
    /// The step.
    pub trial: Trial<N, S>,
    /// Derivatives at its end.
    pub slope: [S; N],
    /// An error of order 2, which sees kinks.
    pub defect: [S; N],
}

impl<H: System<U>, S: Varying, const N: usize, const U: usize> Stages<'_, H, S, N, U> {
    /// One step of the midpoint rule or of the classical method.
    #[inline(always)]
    pub fn taken(&self, is_midpoint: bool) -> Explicit<N, S> {
        if is_midpoint { self.midpoint() } else { self.classical() }
    }

    /// One step of the classical method, with the error of one of order 3.
    ///
    /// Up to order 2 the last stage agrees with the derivatives at the end, so that half of their difference can be moved
    /// from the one to the other: the weights 1/6, 1/3, 1/3, -1/3, 1/2 are still of order 3. For a rate `r` the error found
    /// is `(r*h)^4*(2 - r*h)/48`, which is more than the `(r*h)^5/120` that a step lacks at all sizes that are stable. With
    /// a tenth it is not, and long steps let their errors add up. Kinks show in the difference between the midpoint rule and
    /// Simpson's.
    ///
    /// Inlined, so that it is compiled once with and once without the closed form.
    #[inline(always)]
    pub fn classical(&self) -> Explicit<N, S> {
        let &Self { x, first, h, .. } = self;
        let drive_1 = self.drive(x, first);
        let x_2 = self.placed(self.along(0.5, first), |it| it.middle);
        let x_2 = self.relaxed(x_2, |state, weights| weights.second(x[state], drive_1));
        let second = self.rates(0.5, &x_2);
        let drive_2 = self.drive(&x_2, &second);
        let x_3 = self.placed(self.along(0.5, &second), |it| it.middle);
        let x_3 = self.relaxed(x_3, |state, weights| weights.third(x_2[state], [drive_1, drive_2]));
        let third = self.rates(0.5, &x_3);
        let drive_3 = self.drive(&x_3, &third);
        let x_4 = self.placed(self.along(1.0, &third), |it| it.end);
        let x_4 = self.relaxed(x_4, |state, weights| weights.fourth(x[state], [drive_1, drive_3]));
        let fourth = self.rates(1.0, &x_4);
        let drives = [drive_1, drive_2, drive_3, self.drive(&x_4, &fourth)];

        let sixth = h / 6.0;
        let outer: [S; N] = array(|i| first[i] + fourth[i]);
        let inner: [S; N] = array(|i| second[i] + third[i]);
        let end = self.placed(array(|i| x[i] + (outer[i] + inner[i] * 2.0) * sixth), |it| it.end);
        let end = self.relaxed(end, |state, weights| weights.end(x[state], drives));
        let slope = self.rates(1.0, &end);
        let last_drive = self.drive(&end, &slope);
        let error = self.placed(array(|i| (fourth[i] - slope[i]) * (0.5 * h)), |it| it.defect);
        let error = self.relaxed(error, |_, weights| weights.error(drives[3], last_drive));
        let defect = self.placed(array(|i| (outer[i] - inner[i]) * sixth), |it| it.defect);
        let defect = self.relaxed(defect, |_, weights| weights.defect(drives));
        Explicit { trial: Trial { end, error }, slope, defect }
    }

    /// One step of the midpoint rule, half as costly, with its difference from the trapezoidal rule as its error: for a
    /// rate `r` that is `(r*h)^3/4`, where a step lacks `(r*h)^3/6`.
    ///
    /// Of states with a closed form, the others meet the mean over the step.
    #[inline(always)]
    pub fn midpoint(&self) -> Explicit<N, S> {
        let &Self { x, first, h, .. } = self;
        let mean = |it: &ClosedForm<[S; N]>| array(|i| (x[i] + it.middle[i] * 4.0 + it.end[i]) / 6.0);
        let drive_1 = self.drive(x, first);
        let x_2 = self.placed(self.along(0.5, first), mean);
        let x_2 = self.relaxed(x_2, |state, weights| weights.second(x[state], drive_1));
        let second = self.rates(0.5, &x_2);
        let drive_2 = self.drive(&x_2, &second);
        let end = self.placed(array(|i| x[i] + second[i] * h), |it| it.end);
        let end = self.relaxed(end, |state, weights| weights.half_evaluated(x[state], [drive_1, drive_2]));
        let slope = self.rates(1.0, &end);
        let drives = [drive_1, drive_2, self.drive(&end, &slope)];
        let error = self.placed(array(|i| ((first[i] + slope[i]) * 0.5 - second[i]) * h), |it| it.defect);
        let error = self.relaxed(error, |_, weights| weights.half_evaluated_error(drives));
        Explicit { trial: Trial { end, error }, slope, defect: error }
    }

    /// Derivatives at a fraction of the step.
    // Compiled once for all stages of both methods.
    #[inline(never)]
    fn rates(&self, fraction: f64, states: &[S; N]) -> [S; N] {
        let &Self { system, inputs, memory, .. } = self;
        let time = self.time + fraction * self.h;
        let u = inputs.at(time);
        if self.closed_form.is_some() {
            system.derivatives_besides_closed_form(S::of(time), states, &u, memory)
        } else {
            system.derivatives(S::of(time), states, &u, memory)
        }
    }

    #[inline(always)]
    fn along(&self, fraction: f64, slope: &[S; N]) -> [S; N] {
        array(|i| self.x[i] + slope[i] * (fraction * self.h))
    }

    /// States, or errors of states, of which those with a closed form are a part of it.
    #[inline(always)]
    fn placed(&self, mut states: [S; N], part: impl Fn(&ClosedForm<[S; N]>) -> [S; N]) -> [S; N] {
        if let Some(closed_form) = self.closed_form {
            states[..H::CLOSED_FORM].copy_from_slice(&part(closed_form)[..H::CLOSED_FORM]);
        }
        states
    }

    /// Derivative of the relaxing state without its relaxation.
    #[inline(always)]
    fn drive(&self, states: &[S; N], slope: &[S; N]) -> S {
        self.relaxing.map_or(S::zero(), |(state, weights)| weights.drive(states[state], slope[state]))
    }

    /// States, or errors of states; the relaxing one's by its exponential weights.
    #[inline(always)]
    fn relaxed(&self, mut states: [S; N], value: impl Fn(usize, &Relaxing) -> S) -> [S; N] {
        if let Some((state, weights)) = self.relaxing {
            states[state] = value(state, weights);
        }
        states
    }
}
