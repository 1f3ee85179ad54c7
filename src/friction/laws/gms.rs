//! The generalised Maxwell-slip law.

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, FrictionLaw, StateKind};
use crate::friction::parts::curve::StribeckCurve;
use crate::friction::parts::elements::{self, Load, MAX_ELEMENTS, Modes};
use crate::friction::parts::fading::{divisor, fading_rate};
use crate::friction::parts::parameters::{stiffness, viscous};
use crate::numbers::{Scalar, Varying};
use crate::parameters;
use crate::variables::{Notice, ParameterError, Tunable, Variable, counted_by, units};

parameters! {
    /// Generalised Maxwell-slip friction: up to ten elements, one state each, the element's force `F_i` in N.
    ///
    /// ```text
    /// stick:  dF_i/dt = k_i*v                               until |F_i| = alpha_i*s(v) under growing load   [N/s]
    /// slip:   dF_i/dt = C*(alpha_i*sgn(v) - F_i/s(v))       until v = 0                                     [N/s]
    /// F = sum F_i + sigma2*v                                [N], s the Stribeck curve
    /// ```
    ///
    /// Presliding hysteresis with non-local memory, frictional lag, and rate-dependent break-away. At constant `v != 0`,
    /// `F -> sum(alpha_i)*s(v)*sgn(v) + sigma2*v`.
    ///
    /// # Validity
    /// Slipping forces lag behind `s` by about `s/C` seconds. An element whose limit falls below its force while the motion
    /// unloads it stays a spring. Where `s` falls to 0, within the last micronewton, the forces go to 0.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s`, or if the shares of all elements in use are 0.
    ///
    /// # Source
    /// Al-Bender, Lampaert, Swevers (2005), IEEE Trans. Automatic Control 50(11):1883-1887.
    Gms {
        curve: StribeckCurve = StribeckCurve::variables();
        viscous: Tunable = viscous(30.0);
        count: usize = elements::count(4);
        attraction: Tunable = Variable::parameter(6, "C", units::NEWTON_PER_SECOND, 500.0)
            .range(1e-3, 1e9)
            .text("Rate at which the force of slipping elements approaches the Stribeck curve");
        stiffness: [Tunable; MAX_ELEMENTS] = counted_by("N", stiffness(10, "k", 1e5).text("Stiffness of an element")
            .array([4e5, 3e5, 2e5, 1e5, 1e5, 1e5, 1e5, 1e5, 1e5, 1e5]));
        share: [Tunable; MAX_ELEMENTS] = counted_by("N", Variable::parameter(20, "alpha", units::ONE, 0.0)
            .range(0.0, 10.0)
            .text("Share of an element in the Stribeck curve; shares usually add up to 1")
            .array([0.25, 0.25, 0.25, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
    }
}

/// Shares written with seven digits and more add up to 1 within this.
const SHARES_ROUNDING: f64 = 1e-6;

impl FrictionLaw for Gms {
    type Memory<S: Varying> = Modes;

    fn events(&self) -> &'static [Event] {
        &[Event::Stop, Event::BreakAway]
    }

    fn is_non_stiff(&self) -> bool {
        self.curve.is_non_stiff()
    }

    fn check(&self) -> Result<(), ParameterError> {
        self.curve.check()?;
        if self.share[..self.count].iter().all(|share| share.value == 0.0) {
            return Err(ParameterError::new(
                "alpha[1]",
                self.share[0].value,
                "one element in use must have a share above 0",
            ));
        }
        Ok(())
    }

    fn states(&self) -> usize {
        self.count
    }

    fn state_kind(&self) -> StateKind {
        StateKind::Force
    }

    fn state_scale(&self) -> f64 {
        self.curve.static_force.value.max(1.0)
    }

    fn notice(&self) -> Option<Notice> {
        let sum: f64 = self.share[..self.count].iter().map(|share| share.value).sum();
        let remark = "the shares of the elements in use do not add up to 1, and sliding friction is that part of the Stribeck curve";
        let notice = Notice { variable: "sum of friction.gms.alpha", value: sum, remark };
        ((sum - 1.0).abs() > SHARES_ROUNDING).then_some(notice)
    }

    fn start<S: Varying>(&self, _contact: &Contact<S>) -> Modes {
        Modes::default()
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], modes: &Modes, rates: &mut [S]) -> S {
        let v = contact.velocity;
        let curve = self.curve.at(v.abs(), contact.level);
        let mut sum = v * self.viscous;
        for (element, (force, rate)) in z.iter().zip(rates).enumerate() {
            let limit = curve * self.share[element];
            let own = match modes.slip(element) {
                Some(direction) => (limit * direction - *force) * self.attraction / divisor(curve),
                None => v * self.stiffness[element] * (limit / divisor(limit)),
            };
            *rate = own + fading_rate(*force, limit);
            sum += *force;
        }
        sum
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, z: &[S], modes: &Modes, out: &mut Indicators<S>) {
        modes.indicators(contact.velocity, self.loads(contact, z), out);
    }

    fn switch<S: Varying>(&self, event: Event, contact: &Contact<S>, _v: &mut S, z: &mut [S], modes: &mut Modes) {
        if event == Event::Stop {
            modes.stick();
        } else {
            modes.slip_next(contact.velocity, self.loads(contact, z));
        }
    }
}

impl Gms {
    fn loads<'a, S: Scalar>(&'a self, contact: &Contact<S>, z: &'a [S]) -> impl Iterator<Item = Load<S>> + Clone + 'a {
        let curve = self.curve.at(contact.velocity.abs(), contact.level);
        let elements = z.iter().zip(&self.share).take(self.count);
        elements.map(move |(force, share)| Load { force: *force, limit: curve * *share })
    }
}
