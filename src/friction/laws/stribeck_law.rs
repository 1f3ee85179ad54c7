//! The Stribeck curve with true stiction.

use crate::friction::law::{Contact, FrictionLaw};
use crate::friction::lubrication::{Film, Rated};
use crate::friction::parts::curve::StribeckCurve;
use crate::friction::parts::dwell::{Resting, risen};
use crate::friction::parts::parameters::{dwell_time, force, viscous};
use crate::friction::parts::stick_slip::{Mode, two_modes};
use crate::numbers::Scalar;
use crate::parameters;
use crate::variables::{ParameterError, Tunable, Variable, units};

parameters! {
    /// Stribeck friction, set-valued at rest.
    ///
    /// ```text
    /// stuck:    v = 0, F = F_applied         while |F_applied| <= max(lambda_s*F_s(t), lambda*F_c)
    /// sliding:  F = s(v)*sgn(v) + sigma2*v   [N], s the Stribeck curve
    /// F_s(t)   = F_s + (FsInf - F_s)*t/(t + gamma)                              [N]
    /// s(v)     = lambda*F_c + max(lambda_s*F_s - lambda*F_c, 0)*exp(-(|v|/v_s)^delta) [N]
    /// lambda_s = max(1 + kappaRatio*(lambda - 1), 0)
    /// ```
    ///
    /// `t` in s is the time at rest: break-away takes the more, the longer the contact has rested, and nothing of that is
    /// left once it slides, be it by micrometres. A run that starts at rest has rested for ever. `FsInf` = 0 stands for
    /// `F_s`: then break-away does not depend on time.
    ///
    /// Static and Coulomb friction grow with the load factor `lambda` alike, or in the ratio `kappaRatio`: with 2, a level
    /// of 1.1 gives 20 % more static friction. A contact at rest holds what friction takes while it slides: where the level
    /// leaves less static than Coulomb friction, the latter is all there is.
    ///
    /// With `delta = 1` this is Benson's velocity-dependent law; with `delta = 1` and `F_c = F_s/2` the
    /// Coulomb-Stribeck law of the vibro-impact literature.
    ///
    /// # Validity
    /// A contact that slips every now and then over less than its asperities forgets its rest here, and may not in truth.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s`, and for an `FsInf` other than 0 below `F_s`.
    ///
    /// # Source
    /// The growth is as in [`Armstrong`](super::armstrong::Armstrong)'s law after sliding that left no excess.
    Stribeck {
        curve: StribeckCurve = StribeckCurve::variables();
        viscous: Tunable = viscous(30.0);
        rested_force: Tunable = force(5, "FsInf", 0.0)
            .nominal(15.0)
            .text("Static friction after a long time at rest; 0: as Fs at all times");
        dwell_time: Tunable = dwell_time(6, 0.1)
            .text("Time at rest in which half of the growth from Fs to FsInf is done");
        kappa_ratio: Tunable = Variable::parameter(7, "kappaRatio", units::ONE, 1.0)
            .range(0.0, 100.0)
            .text("Growth of the static friction with the load factor relative to the growth of the Coulomb friction");
    }
}

impl FrictionLaw for Stribeck {
    two_modes!();

    fn is_lubricated(&self) -> bool {
        true
    }

    fn check(&self) -> Result<(), ParameterError> {
        self.curve.check()?;
        let [least, value] = [self.curve.static_force, self.rested_force].map(|force| force.value);
        if value != 0.0 && value < least {
            let reason = format!("it must be 0, for no growth, or at least the static friction Fs = {least}");
            return Err(ParameterError::new("FsInf", value, &reason));
        }
        Ok(())
    }

    fn is_non_stiff(&self) -> bool {
        self.curve.is_non_stiff()
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], memory: &Resting<S::Held>, rates: &mut [S]) -> S {
        self.lubricated_force(contact, Rated, z, memory, rates)
    }

    #[inline(always)]
    fn lubricated_force<S: Scalar>(
        &self,
        contact: &Contact<S>,
        film: impl Film<S>,
        _z: &[S],
        memory: &Resting<S::Held>,
        _rates: &mut [S],
    ) -> S {
        match memory.mode {
            Mode::Stuck => {
                let dwell = || contact.time - S::held(memory.since);
                Mode::holding_force(contact, self.break_away(contact, dwell))
            }
            Mode::Sliding(direction) => {
                let dry = self.dry(film.on_curve(contact.velocity.abs()), contact.level);
                dry * direction + film.viscous(contact.velocity * self.viscous)
            }
        }
    }
}

impl Stribeck {
    /// Largest force in N that holds the mass after a time at rest in s.
    fn break_away<S: Scalar>(&self, contact: &Contact<S>, dwell: impl FnOnce() -> S) -> S {
        let (level, fresh) = (contact.level, self.curve.static_force);
        let force = if self.rested_force.value == 0.0 {
            S::tuned(fresh)
        } else {
            risen(S::tuned(self.rested_force - fresh), self.dwell_time, dwell()) + fresh
        };
        let grown = self.static_level(level) * force;
        if self.has_one_level() { grown } else { grown.max(level * self.curve.coulomb_force) }
    }

    /// Friction in N at a speed without the viscous part.
    fn dry<S: Scalar>(&self, speed: S, level: S) -> S {
        if self.has_one_level() {
            return self.curve.at(speed, level);
        }
        let (statics, coulomb) = (self.static_level(level) * self.curve.static_force, level * self.curve.coulomb_force);
        coulomb + (statics - coulomb).max(S::zero()) * self.curve.decay(speed)
    }

    /// Whether static and Coulomb friction grow alike.
    fn has_one_level(&self) -> bool {
        self.kappa_ratio == Tunable::still(1.0)
    }

    /// The load factor `lambda_s` of the static friction.
    fn static_level<S: Scalar>(&self, level: S) -> S {
        if self.has_one_level() {
            return level;
        }
        ((level - 1.0) * self.kappa_ratio + 1.0).max(S::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::event::{Event, Indicators};
    use crate::friction::law::Drive;
    use crate::numbers::Real;
    use crate::variables::ParameterSet;

    fn law(rested_force: f64, kappa_ratio: f64) -> Stribeck {
        Stribeck::read(&[10.0, 6.0, 0.01, 2.0, 30.0, rested_force, 0.5, kappa_ratio].map(Tunable::still)).unwrap()
    }

    fn break_away(law: &Stribeck, level: f64, dwell: f64) -> f64 {
        law.break_away(&contact(0.0, 0.0, 0.0, level), || Real::of(dwell)).value
    }

    fn dry(law: &Stribeck, speed: f64, level: f64) -> f64 {
        law.dry(Real::of(speed), Real::of(level)).value
    }

    fn contact(time: f64, velocity: f64, applied: f64, level: f64) -> Contact<Real> {
        Contact { time, position: 0.0, velocity, applied, level, drive: Drive::Force }.still()
    }

    /// Half of the growth is done after `gamma`, two thirds after twice that, all of it before the first break-away.
    #[test]
    fn break_away_grows_with_the_time_at_rest() {
        let law = law(16.0, 1.0);
        for (dwell, expected) in [(0.0, 10.0), (0.5, 13.0), (1.0, 14.0), (f64::INFINITY, 16.0)] {
            assert_eq!(break_away(&law, 1.0, dwell), expected, "after {dwell} s");
        }
        let reserve = |memory: &Resting<Real>, time: f64| {
            let mut out = Indicators::default();
            law.indicators(&contact(time, 0.0, -9.0, 1.0), &[], memory, &mut out);
            out[Event::BreakAway].value
        };
        let mut memory = law.start(&contact(3.0, 0.0, 0.0, 1.0));
        assert_eq!(reserve(&memory, 3.0), 16.0 - 9.0);
        let mut velocity = Real::of(0.0);
        law.switch(Event::BreakAway, &contact(3.0, 0.0, 17.0, 1.0), &mut velocity, &mut [], &mut memory);
        assert!(!Stribeck::is_sticking(&memory));
        law.switch(Event::Stop, &contact(4.0, 0.0, -9.0, 1.0), &mut velocity, &mut [], &mut memory);
        assert!(Stribeck::is_sticking(&memory));
        assert_eq!([4.0, 4.5, 5.0].map(|time| reserve(&memory, time)), [1.0, 4.0, 5.0]);
    }

    /// At a level of 1.5 the Coulomb friction has grown by half, the static friction by none, as much, or twice that.
    #[test]
    fn static_friction_has_a_load_level_of_its_own() {
        for (ratio, static_force) in [(0.0, 10.0), (1.0, 15.0), (2.0, 20.0)] {
            let law = law(0.0, ratio);
            assert_eq!(break_away(&law, 1.5, 7.0), static_force);
            assert_eq!([dry(&law, 0.0, 1.5), dry(&law, 1e3, 1.5)], [static_force, 9.0]);
            let middle = dry(&law, 0.01, 1.5);
            assert!((middle - 9.0 - (static_force - 9.0) * (-1.0f64).exp()).abs() < 1e-14, "{middle}");
        }
    }

    /// A level of 0.5 leaves 3 N of Coulomb friction, and would leave no static friction; one of 2 would leave 10 N of the
    /// latter beside 12 N of the former. After a rest, in which the static friction has grown to 16 N, it counts again.
    #[test]
    fn rest_holds_no_less_than_sliding_takes() {
        for (ratio, level, coulomb) in [(4.0, 0.5, 3.0), (0.0, 2.0, 12.0)] {
            let law = law(0.0, ratio);
            assert_eq!(break_away(&law, level, 1.0), coulomb, "ratio {ratio}");
            assert_eq!([0.0, 1e-9, 0.01, 1.0].map(|speed| dry(&law, speed, level)), [coulomb; 4], "ratio {ratio}");
        }
        assert_eq!(break_away(&law(16.0, 0.0), 2.0, f64::INFINITY), 16.0);
    }

    #[test]
    fn rested_friction_below_the_static_one_is_refused() {
        let error = law(9.0, 1.0).check().unwrap_err();
        assert_eq!((error.variable.as_str(), error.value), ("FsInf", 9.0));
        assert!(law(0.0, 1.0).check().is_ok() && law(10.0, 1.0).check().is_ok());
    }

    /// An exponent below 1 makes the curve infinitely steep at rest.
    #[test]
    fn law_on_a_steep_curve_is_stiff() {
        let with = |exponent: f64| {
            Stribeck::read(&[10.0, 6.0, 0.01, exponent, 30.0, 10.0, 0.5, 1.0].map(Tunable::still)).unwrap()
        };
        assert_eq!([0.5, 1.0, 2.0].map(|exponent| with(exponent).is_non_stiff()), [false, true, true]);
    }
}
