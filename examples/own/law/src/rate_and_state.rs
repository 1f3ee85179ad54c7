//! A law with a state that it names: rate-and-state friction, as of rock and paper.

use pneumatic_servo::friction::parts::parameters::{coulomb_force, force, length, viscous};
use pneumatic_servo::prelude::*;

parameters! {
    /// Rate-and-state friction with the ageing law, regularised at rest.
    ///
    /// ```text
    /// F        = lambda*a*asinh(v/(2*v_0)*exp((F_c + b*ln(v_0*theta/L))/a)) + sigma2*v   [N]
    /// dtheta/dt = 1 - |v|*theta/L                                                       [1]
    /// ```
    ///
    /// `theta` is the mean age of the asperities in contact. In steady sliding it is `L/|v|`, and
    /// `F = lambda*(F_c + (a - b)*ln(v/v_0)) + sigma2*v` as long as that is far above `a`.
    ///
    /// # Source
    /// Ruina (1983), J. Geophysical Research 88(B12):10359-10370; the regularisation of Rice and Ben-Zion (1996), Proc. National
    /// Academy of Sciences 93(9):3811-3818.
    RateAndState {
        coulomb: Tunable = coulomb_force(8.3);
        direct: Tunable = force(9, "a", 1.5).text("Direct effect: growth of friction with the logarithm of velocity");
        evolution: Tunable = force(10, "b", 1.8).text("Growth of friction with the logarithm of age");
        distance: Tunable = length(11, "L", 1e-5).text("Distance over which asperities are renewed");
        reference: Tunable = Variable::parameter(12, "v0", units::METRE_PER_SECOND, 1e-3).range(1e-9, 1.0)
            .text("Velocity of steady sliding at which friction is Fc");
        viscous: Tunable = viscous(30.0);
    }
}

impl FrictionLaw for RateAndState {
    type Memory<S: Varying> = ();

    const STATES: &'static [LawState<Self>] =
        &[LawState::new("theta", units::SECOND, |law: &Self| law.distance.value / law.reference.value)
            .range(1e-12, f64::INFINITY)
            .text("Mean age of the asperities in contact")];

    /// The age in steady sliding at the reference velocity.
    fn start_states<S: Varying>(&self, _contact: &Contact<S>, z: &mut [S]) {
        z[0] = S::tuned(self.distance / self.reference);
    }

    fn start<S: Varying>(&self, _contact: &Contact<S>) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], _memory: &(), rates: &mut [S]) -> S {
        let (v, theta) = (contact.velocity, z[0]);
        // `abs` has its right derivative at rest; this has derivative 0 there, so that mirrored runs are mirrored.
        let speed = (v * v).sqrt();
        rates[0] = -speed * theta / self.distance + 1.0;
        let strength = self.coulomb + self.evolution * (self.reference * theta / self.distance).ln();
        let stressed = (v / (2.0 * self.reference)) * (strength / self.direct).exp();
        self.direct * contact.level * stressed.asinh() + self.viscous * v
    }
}
