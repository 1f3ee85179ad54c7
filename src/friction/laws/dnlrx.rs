//! Dynamic nonlinear regression: sampled Maxwell-slip springs through finite impulse responses.

use serde::{Deserialize, Serialize};

use crate::friction::law::{Contact, FrictionLaw};
use crate::friction::parts::elements::{self, MAX_ELEMENTS};
use crate::numbers::{Scalar, Varying};
use crate::parameters;
use crate::system::Sample;
use crate::variables::{Condition, Meaning, Tunable, Variable, counted_by, units};

/// Taps of the displacement: the present sample and four past ones.
const POSITION_TAPS: usize = 5;
/// Taps of the spring deformations: the present sample and two past ones.
const SPRING_TAPS: usize = 3;

parameters! {
    /// Dynamic nonlinear regression (DNLRX): a discrete-time law, sampled every `Ts` and held in between.
    ///
    /// ```text
    /// F_k     = sum_{r=0..nx} c_r*x(k - r) + sum_{r=0..nchi} sum_i chi_r,i*delta_i(k - r)        [N]
    /// delta_i(k) = delta_i(k-1) + x(k) - x(k-1), kept within +-lambda*limit_i                     [m]
    /// ```
    ///
    /// The springs `delta_i` are as in the Maxwell-slip law. Their past brings rate dependence within presliding, the
    /// past displacements viscous friction and lag. With the default coefficients `c_0 = -c_1 = sigma2/Ts`, `chi_0,i = k_i`
    /// and limits `W_i/k_i` it samples [`MaxwellSlip`](super::maxwell_slip::MaxwellSlip) with its defaults. In names of
    /// parameters indices start from 1: `c[1]` is `c_0`, `chi0[1]` is `chi_0,1`. The coefficients depend on `Ts`.
    ///
    /// # Validity
    /// Before the start the mass was at rest and the springs without load. A law for given motions: on a free mass the held
    /// force acts like a delay, and with `Ts` above about `0.1*sqrt(m/sum chi_0)` it shakes the mass by some samples of
    /// travel instead of letting it rest. It is not passive: where the motion turns within a sample, the held force drives
    /// the mass until the next one, with up to `|F_k|*|v|*Ts`. In the default experiment of the cylinder it so gives back
    /// 9.9e-5 J, where its springs hold 4.0e-5 J.
    ///
    /// # Source
    /// Rizos, Fassois (2004), Presliding friction identification based upon the Maxwell slip model structure, Chaos 14(2):
    /// 431-445, has the linear regression that this extends.
    Dnlrx {
        sample_time: f64 = Variable::parameter(4, "Ts", units::SECOND, 1e-3).range(1e-6, 10.0).plausible(1e-5, 0.2).shown_in("ms")
            .meaning(Meaning::Sampling)
            .text("Sample time");
        count: usize = elements::count(4);
        position_taps: usize = Variable::count(6, "nx", 1).range(0.0, (POSITION_TAPS - 1) as f64)
            .text("Number of past displacements that count; coefficients beyond are unused");
        spring_taps: usize = Variable::count(7, "nchi", 0).range(0.0, (SPRING_TAPS - 1) as f64)
            .text("Number of past spring deformations that count; coefficients beyond are unused");
        limit: [Tunable; MAX_ELEMENTS] = counted_by("N", Variable::parameter(10, "limit", units::METRE, 0.0).range(0.0, 1.0).plausible(1e-10, 2e-3)
            .text("Largest deformation of a spring at load factor 1")
            .array([2.59375e-6, 5.1875e-6, 1.0375e-5, 2.075e-5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
        position_coefficient: [Tunable; POSITION_TAPS] = coefficient(20, "c")
            .meaning(Meaning::ViscousFriction)
            .text("Coefficient of the displacement 0, 1, 2, ... samples ago")
            .array([3e4, -3e4, 0.0, 0.0, 0.0]);
        spring_coefficient_0: [Tunable; MAX_ELEMENTS] = counted_by("N", coefficient(30, "chi0")
            .text("Coefficient of the present deformation of a spring")
            .array([8e5, 4e5, 2e5, 1e5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
        spring_coefficient_1: [Tunable; MAX_ELEMENTS] = counted_by("N", coefficient(40, "chi1").counts_where(Condition::at_least("nchi", 1))
            .text("Coefficient of the deformation of a spring one sample ago").array([0.0; MAX_ELEMENTS]));
        spring_coefficient_2: [Tunable; MAX_ELEMENTS] = counted_by("N", coefficient(50, "chi2").counts_where(Condition::at_least("nchi", 2))
            .text("Coefficient of the deformation of a spring two samples ago").array([0.0; MAX_ELEMENTS]));
    }
}

/// A coefficient of the regression.
fn coefficient(reference: u32, name: &str) -> Variable {
    Variable::parameter(reference, name, units::NEWTON_PER_METRE, 0.0).range(-1e12, 1e12)
}

/// Samples, the latest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory<S> {
    /// Time of the first sample in s.
    start: f64,
    /// Samples taken since.
    count: u64,
    positions: [S; POSITION_TAPS],
    deformations: [[S; MAX_ELEMENTS]; SPRING_TAPS],
    /// Force held until the next sample, in N.
    force: S,
}

impl FrictionLaw for Dnlrx {
    type Memory<S: Varying> = Memory<S>;

    fn start<S: Varying>(&self, contact: &Contact<S>) -> Memory<S> {
        let mut memory = Memory {
            start: contact.time.value(),
            count: 0,
            positions: [contact.position; POSITION_TAPS],
            deformations: [[S::zero(); MAX_ELEMENTS]; SPRING_TAPS],
            force: S::zero(),
        };
        memory.force = self.regression(&memory);
        memory
    }

    fn force<S: Scalar>(&self, _contact: &Contact<S>, _z: &[S], memory: &Memory<S::Held>, _rates: &mut [S]) -> S {
        S::held(memory.force)
    }

    fn next_sample<S: Varying>(&self, memory: &Memory<S>) -> Sample<S> {
        Sample::periodic(S::of(memory.start + (memory.count + 1) as f64 * self.sample_time), self.sample_time)
    }

    fn sample<S: Varying>(&self, contact: &Contact<S>, _z: &[S], memory: &mut Memory<S>) {
        let step = contact.position - memory.positions[0];
        memory.positions.rotate_right(1);
        memory.positions[0] = contact.position;
        memory.deformations.rotate_right(1);
        memory.deformations[0] = memory.deformations[1];
        for (deformation, limit) in memory.deformations[0].iter_mut().zip(self.limit).take(self.count) {
            let limit = contact.level * limit;
            let pushed = *deformation + step;
            *deformation = pushed.unless_tied(limit).unless_tied(-limit).clamp(-limit, limit);
        }
        memory.count += 1;
        memory.force = self.regression(memory);
    }
}

impl Dnlrx {
    /// The force in N by the present and past samples.
    fn regression<S: Varying>(&self, memory: &Memory<S>) -> S {
        let sum = |terms: &mut dyn Iterator<Item = S>| terms.fold(S::zero(), |sum, term| sum + term);
        let dot = |a: &[Tunable], b: &[S]| sum(&mut a.iter().zip(b).map(|(a, b)| *b * *a));
        let coefficients = [&self.spring_coefficient_0, &self.spring_coefficient_1, &self.spring_coefficient_2];
        let taps = coefficients.into_iter().zip(&memory.deformations).take(self.spring_taps + 1);
        dot(&self.position_coefficient[..=self.position_taps], &memory.positions)
            + sum(&mut taps.map(|(chi, delta)| dot(&chi[..self.count], delta)))
    }
}
