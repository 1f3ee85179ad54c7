//! The checks of laws and models find what they are for: laws that each break one promise.

use std::panic::{AssertUnwindSafe, catch_unwind};

use pneumatic_servo::conformance::law::{self, benched, passive};
use pneumatic_servo::conformance::{numbers, repeats, slopes};
use pneumatic_servo::prelude::*;

parameters! {
    /// The slope by the parameter is lost: its value alone is used.
    Lost {
        share: Tunable = Variable::parameter(0, "b", units::ONE, 0.25).range(0.0, 1.0).text("Share");
    }
}

impl VelocityLaw for Lost {
    fn force<S: Scalar>(&self, v: S, level: S) -> S {
        v * level * (1.0 - self.share.value)
    }
}

parameters! {
    /// The same with the parameter as it is, behind a plain number.
    Kept {
        share: Tunable = Variable::parameter(0, "b", units::ONE, 0.25).range(0.0, 1.0).text("Share");
    }
}

impl VelocityLaw for Kept {
    fn force<S: Scalar>(&self, v: S, level: S) -> S {
        v * level * (1.0 - self.share)
    }
}

parameters! {
    /// The derivative by the velocity is lost where it is taken from the value.
    Blind {
        damping: Tunable = Variable::parameter(0, "d", units::NEWTON_SECOND_PER_METRE, 5.0).text("Damping");
    }
}

impl VelocityLaw for Blind {
    fn force<S: Scalar>(&self, v: S, level: S) -> S {
        S::constant(v.value()) * level * self.damping
    }
}

parameters! {
    /// Not odd, and it drives a mass that moves backwards.
    Driving {
        force: Tunable = Variable::parameter(0, "F", units::NEWTON, 5.0).text("Force");
    }
}

impl VelocityLaw for Driving {
    fn force<S: Scalar>(&self, _v: S, level: S) -> S {
        level * self.force
    }
}

parameters! {
    /// Its force changes with the direction of the motion that it follows, and it does not say so.
    Silent {
        force: Tunable = Variable::parameter(0, "F", units::NEWTON, 5.0).text("Force");
    }
}

impl FrictionLaw for Silent {
    type Memory<S: Varying> = f64;

    fn follows(&self) -> &'static [Drive] {
        &[Drive::Motion]
    }

    fn start<S: Varying>(&self, contact: &Contact<S>) -> f64 {
        sign(contact.velocity.value())
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], direction: &f64, _rates: &mut [S]) -> S {
        contact.level * *direction * self.force
    }

    fn follow<S: Varying>(&self, contact: &Contact<S>, _z: &[S], direction: &mut f64) -> bool {
        *direction = sign(contact.velocity.value());
        false
    }

    fn is_sticking<S: Varying>(_direction: &f64) -> bool {
        false
    }
}

parameters! {
    /// Its force depends on whether a run is differentiated.
    Partial {
        force: Tunable = Variable::parameter(0, "F", units::NEWTON, 5.0).text("Force");
    }
}

impl FrictionLaw for Partial {
    type Memory<S: Varying> = f64;

    fn start<S: Varying>(&self, _contact: &Contact<S>) -> f64 {
        if S::VARIES { 1.001 } else { 1.0 }
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], share: &f64, _rates: &mut [S]) -> S {
        contact.level * *share * self.force * contact.velocity
    }

    fn is_sticking<S: Varying>(_share: &f64) -> bool {
        false
    }
}

laws! {
    /// Laws that break a promise each, and one that keeps all.
    mod catalogue {
        ..builtin;
        1000 Lost "lost" OfVelocity<Lost>, "Loses the slope by a parameter";
        1001 Kept "kept" OfVelocity<Kept>, "Keeps it";
        1002 Blind "blind" OfVelocity<Blind>, "Loses the slope by the velocity";
        1003 Driving "driving" OfVelocity<Driving>, "Drives one way";
        1004 Silent "silent" Silent, "Says of no change";
        1005 Partial "partial" Partial, "Differs in numbers with slopes";
    }
}

/// Message of a check, if it fails.
fn refusal(check: impl FnOnce()) -> Option<String> {
    let panic = catch_unwind(AssertUnwindSafe(check)).err()?;
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()))
}

fn moved(law: &str) -> Setup {
    benched::<catalogue::Friction>(law, "PrescribedMotion").set("driveVelocity", 0.2).expect("a velocity")
}

#[test]
fn lost_slope_by_a_parameter_is_named() {
    let said = refusal(|| slopes(&moved("Lost"))).unwrap_or_default();
    assert!(said.contains("the derivative of frictionForce by friction.lost.b is 0, and"), "{said}");
    assert_eq!(refusal(|| slopes(&moved("Kept"))), None);
}

#[test]
fn values_that_differ_in_numbers_with_slopes_are_found() {
    let said = refusal(|| numbers(&moved("Partial"), 0.1)).unwrap_or_default();
    assert!(said.contains("under Partial ") && said.contains(" in numbers with slopes, and 1 without"), "{said}");
    assert_eq!(refusal(|| numbers(&moved("Kept"), 0.1)), None);
}

#[test]
fn lost_slope_by_the_velocity_is_found_in_law_and_model() {
    let said = refusal(|| law::derivatives::<catalogue::Friction>("Blind")).unwrap_or_default();
    assert!(said.starts_with("Blind: the derivative of the friction force by velocity is 0"), "{said}");
    let said = refusal(|| slopes(&moved("Blind"))).unwrap_or_default();
    assert!(said.contains("the derivative of frictionForce by driveVelocity is 0, and"), "{said}");
}

#[test]
fn law_that_drives_is_neither_odd_nor_passive() {
    let said = refusal(|| law::mirrored::<catalogue::Friction>("Driving")).unwrap_or_default();
    assert!(said.starts_with("Driving in the drive PrescribedMotion: "), "{said}");
    let said = refusal(|| passive(&moved("Driving"), 1e-12)).unwrap_or_default();
    assert!(said.contains("friction gives back"), "{said}");
    assert_eq!(refusal(|| repeats(&moved("Driving"), 0.1)), None);
}

#[test]
fn change_of_a_force_that_is_not_told_is_found() {
    let said = refusal(|| law::unchanged::<catalogue::Friction>("Silent")).unwrap_or_default();
    assert!(said.contains("Silent says that force and rates have not changed"), "{said}");
    assert_eq!(refusal(|| law::unchanged::<catalogue::Friction>("Driving")), None);
}

#[test]
fn law_that_is_not_there_is_named() {
    let said = refusal(|| law::derivatives::<catalogue::Friction>("Missing")).unwrap_or_default();
    assert_eq!(said, "the catalogue has no law Missing");
}
