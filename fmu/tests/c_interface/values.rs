//! Getting and setting.

use std::ffi::c_int;
use std::ptr;

use pneumatic_servo::variables::{Kind, Role, Variable};

use crate::common::*;

fn set(instance: &Instance, variable: &Variable, value: f64) -> c_int {
    match variable.kind {
        Kind::Real(_) => instance.set_real(&[variable.reference], &[value]),
        Kind::Boolean => instance.set_boolean(&[variable.reference], &[value as c_int]),
        _ => instance.set_integer(&[variable.reference], &[value as c_int]),
    }
}

fn get(instance: &Instance, variable: &Variable) -> Option<f64> {
    let (mut real, mut integer) = ([f64::NAN], [0]);
    let references = [variable.reference];
    match variable.kind {
        Kind::Real(_) => (instance.get_real(&references, &mut real) == OK).then_some(real[0]),
        Kind::Boolean => (instance.get_boolean(&references, &mut integer) == OK).then_some(integer[0].into()),
        _ => (instance.get_integer(&references, &mut integer) == OK).then_some(integer[0].into()),
    }
}

fn settable(variable: &&Variable) -> bool {
    variable.is_parameter() || variable.role == Role::Input
}

#[test]
fn start_values_are_those_of_the_table() {
    let instance = Instance::new();
    for variable in variables().iter().filter(settable) {
        assert_eq!(get(&instance, variable), variable.start, "{}", variable.name);
    }
}

#[test]
pub fn every_parameter_and_input_keeps_what_is_set_until_a_reset() {
    let instance = Instance::new();
    for variable in variables().iter().filter(settable) {
        let limit = variable.max.or(variable.min).unwrap_or(1.5);
        let value = match variable.kind {
            Kind::Enumeration(of) => of.items[of.items.len() - 1].0.into(),
            Kind::Boolean => 1.0,
            _ => limit,
        };
        assert_eq!(set(&instance, variable, value), OK, "{} {:?}", variable.name, instance.messages());
        assert_eq!(get(&instance, variable), Some(value), "{}", variable.name);
    }
    assert_eq!(instance.reset(), OK);
    for variable in variables().iter().filter(settable) {
        assert_eq!(get(&instance, variable), variable.start, "{}", variable.name);
    }
}

#[test]
fn values_out_of_range_are_refused_by_name_and_value() {
    let instance = Instance::new();
    let mut refused = 0;
    for variable in variables().iter().filter(settable) {
        let beyond = |limit: f64, direction: f64| match variable.kind {
            Kind::Real(_) if direction > 0.0 => limit.next_up(),
            Kind::Real(_) => limit.next_down(),
            _ => limit + direction,
        };
        let is_int = |value: &f64| matches!(variable.kind, Kind::Real(_)) || c_int::try_from(*value as i64).is_ok();
        let bad = [variable.min.map(|min| beyond(min, -1.0)), variable.max.map(|max| beyond(max, 1.0))];
        for value in bad.into_iter().flatten().filter(is_int) {
            assert_eq!(set(&instance, variable, value), ERROR, "{} = {value}", variable.name);
            let message = instance.message();
            let expected = format!("{} = {value} is refused", variable.name);
            assert!(message.contains(&expected), "{message}, not {expected}");
            assert_eq!(get(&instance, variable), variable.start);
            refused += 1;
        }
    }
    assert!(refused > 100, "{refused}");
}

#[test]
fn limits_themselves_are_legal() {
    let instance = Instance::new();
    for variable in variables().iter().filter(settable) {
        for value in [variable.min, variable.max].into_iter().flatten() {
            assert_eq!(set(&instance, variable, value), OK, "{} = {value}", variable.name);
        }
    }
}

#[test]
fn not_a_number_and_infinity_are_refused() {
    let instance = Instance::new();
    for variable in variables().iter().filter(settable).filter(|variable| is_real(variable)) {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(set(&instance, variable, value), ERROR, "{} = {value}", variable.name);
        }
        assert_eq!(get(&instance, variable), variable.start);
    }
}

#[test]
fn tiny_and_huge_finite_inputs_are_legal() {
    let instance = Instance::initialized();
    for value in [f64::from_bits(1), -f64::MIN_POSITIVE / 4.0, -0.0, f64::MAX, f64::MIN] {
        assert_eq!(instance.set_real(&[vr("valveVoltage")], &[value]), OK);
        assert_eq!(instance.real("valveVoltage").to_bits(), value.to_bits());
        assert_eq!(instance.real("position"), 0.25);
    }
}

#[test]
fn unconnected_supply_is_legal_and_negative_supply_is_not() {
    let instance = Instance::initialized();
    assert_eq!(instance.set_real(&[vr("supplyPressure")], &[0.0]), OK);
    assert_eq!(instance.step(0.0, 0.01), OK);
    assert_eq!(instance.set_real(&[vr("supplyPressure")], &[-1.0]), ERROR);
    assert!(instance.message().contains("supplyPressure = -1 is refused"));
}

#[test]
fn items_that_an_enumeration_lacks_are_refused() {
    let instance = Instance::new();
    for value in [c_int::MIN, -1, 999, c_int::MAX] {
        assert_eq!(instance.set_integer(&[vr("friction.law")], &[value]), ERROR);
        assert!(instance.message().contains(&format!("friction.law = {value} is refused")));
    }
}

#[test]
fn no_values_need_no_arrays() {
    let instance = Instance::initialized();
    let component = instance.component;
    let (vr, none) = (ptr::null(), 0);
    // SAFETY: NULL is allowed to be passed.
    let statuses = unsafe {
        [
            (LIBRARY.fmi2GetReal)(component, vr, none, ptr::null_mut()),
            (LIBRARY.fmi2GetInteger)(component, vr, none, ptr::null_mut()),
            (LIBRARY.fmi2GetBoolean)(component, vr, none, ptr::null_mut()),
            (LIBRARY.fmi2GetString)(component, vr, none, ptr::null_mut()),
            (LIBRARY.fmi2SetReal)(component, vr, none, ptr::null()),
            (LIBRARY.fmi2SetInteger)(component, vr, none, ptr::null()),
            (LIBRARY.fmi2SetBoolean)(component, vr, none, ptr::null()),
            (LIBRARY.fmi2SetString)(component, vr, none, ptr::null()),
            (LIBRARY.fmi2SetRealInputDerivatives)(component, vr, none, ptr::null(), ptr::null()),
            (LIBRARY.fmi2GetRealOutputDerivatives)(component, vr, none, ptr::null(), ptr::null_mut()),
            (LIBRARY.fmi2GetDirectionalDerivative)(component, vr, none, vr, none, ptr::null(), ptr::null_mut()),
        ]
    };
    assert_eq!(statuses, [OK; 11], "{:?}", instance.messages());
}

#[test]
fn missing_arrays_are_errors() {
    let instance = Instance::initialized();
    let component = instance.component;
    let references = [vr("valveVoltage")];
    let (vr, no_vr) = (references.as_ptr(), ptr::null());
    let (mut real, mut integer, one) = ([5.0], [1], 1);
    // SAFETY: NULL is allowed to be passed, and all arrays have one element.
    let statuses = unsafe {
        [
            (LIBRARY.fmi2GetReal)(component, no_vr, one, real.as_mut_ptr()),
            (LIBRARY.fmi2GetReal)(component, vr, one, ptr::null_mut()),
            (LIBRARY.fmi2GetInteger)(component, no_vr, one, integer.as_mut_ptr()),
            (LIBRARY.fmi2GetInteger)(component, vr, one, ptr::null_mut()),
            (LIBRARY.fmi2GetBoolean)(component, vr, one, ptr::null_mut()),
            (LIBRARY.fmi2GetString)(component, vr, one, ptr::null_mut()),
            (LIBRARY.fmi2SetReal)(component, no_vr, one, real.as_ptr()),
            (LIBRARY.fmi2SetReal)(component, vr, one, ptr::null()),
            (LIBRARY.fmi2SetInteger)(component, vr, one, ptr::null()),
            (LIBRARY.fmi2SetBoolean)(component, vr, one, ptr::null()),
            (LIBRARY.fmi2SetString)(component, vr, one, ptr::null()),
            (LIBRARY.fmi2SetRealInputDerivatives)(component, no_vr, one, integer.as_ptr(), real.as_ptr()),
            (LIBRARY.fmi2SetRealInputDerivatives)(component, vr, one, ptr::null(), real.as_ptr()),
            (LIBRARY.fmi2SetRealInputDerivatives)(component, vr, one, integer.as_ptr(), ptr::null()),
            (LIBRARY.fmi2GetRealOutputDerivatives)(component, no_vr, one, integer.as_ptr(), real.as_mut_ptr()),
            (LIBRARY.fmi2GetRealOutputDerivatives)(component, vr, one, ptr::null(), real.as_mut_ptr()),
            (LIBRARY.fmi2GetRealOutputDerivatives)(component, vr, one, integer.as_ptr(), ptr::null_mut()),
            (LIBRARY.fmi2GetDirectionalDerivative)(component, no_vr, one, vr, one, real.as_ptr(), real.as_mut_ptr()),
            (LIBRARY.fmi2GetDirectionalDerivative)(component, vr, one, no_vr, one, real.as_ptr(), real.as_mut_ptr()),
            (LIBRARY.fmi2GetDirectionalDerivative)(component, vr, one, vr, one, ptr::null(), real.as_mut_ptr()),
            (LIBRARY.fmi2GetDirectionalDerivative)(component, vr, one, vr, one, real.as_ptr(), ptr::null_mut()),
            (LIBRARY.fmi2GetStatus)(component, 0, ptr::null_mut()),
            (LIBRARY.fmi2GetRealStatus)(component, 2, ptr::null_mut()),
            (LIBRARY.fmi2GetIntegerStatus)(component, 0, ptr::null_mut()),
            (LIBRARY.fmi2GetBooleanStatus)(component, 3, ptr::null_mut()),
            (LIBRARY.fmi2GetStringStatus)(component, 1, ptr::null_mut()),
        ]
    };
    assert_eq!(statuses, [ERROR; 26]);
    let messages = instance.messages();
    assert!(messages.iter().all(|message| message.text.ends_with("is NULL")), "{messages:?}");
}

#[test]
fn misaligned_and_impossible_arrays_are_errors() {
    let instance = Instance::initialized();
    let references = [vr("valveVoltage"); 2];
    let mut values = [0.0; 2];
    // SAFETY: the arrays are only looked at if they are aligned and possible.
    unsafe {
        let shifted = values.as_mut_ptr().byte_add(1);
        assert_eq!((LIBRARY.fmi2GetReal)(instance.component, references.as_ptr(), 1, shifted), ERROR);
        assert_eq!(
            (LIBRARY.fmi2GetReal)(instance.component, references.as_ptr(), usize::MAX, values.as_mut_ptr()),
            ERROR
        );
    }
}

#[test]
pub fn unknown_and_wrongly_typed_references_are_refused_and_write_nothing() {
    let instance = Instance::initialized();
    let before = instance.fingerprint();
    let known: Vec<u32> = references(|_| true);
    let unknown = (0..20_000).filter(|reference| !known.contains(reference)).step_by(97).chain([u32::MAX]);
    for bad in unknown.chain(references(|variable| !is_real(variable))) {
        let mut values = [-1.0, -2.0];
        assert_eq!(instance.get_real(&[vr("position"), bad], &mut values), ERROR, "{bad}");
        assert_eq!(values, [-1.0, -2.0]);
        assert_eq!(instance.set_real(&[vr("valveVoltage"), bad], &[7.0, 7.0]), ERROR, "{bad}");
    }
    for bad in references(is_real).into_iter().chain([u32::MAX]) {
        let mut values = [-1, -2];
        assert_eq!(instance.get_integer(&[vr("friction.law"), bad], &mut values), ERROR, "{bad}");
        assert_eq!(instance.get_boolean(&[vr("sticking"), bad], &mut values), ERROR, "{bad}");
        assert_eq!(values, [-1, -2]);
        assert_eq!(instance.set_boolean(&[bad], &[1]), ERROR, "{bad}");
        assert_eq!(instance.set_integer(&[bad], &[1]), ERROR, "{bad}");
    }
    for reference in references(|_| true) {
        let mut text = ptr::null();
        // SAFETY: the arrays have one element.
        unsafe {
            assert_eq!((LIBRARY.fmi2GetString)(instance.component, &reference, 1, &mut text), ERROR);
            assert_eq!((LIBRARY.fmi2SetString)(instance.component, &reference, 1, &c"".as_ptr()), ERROR);
        }
        assert!(text.is_null());
    }
    assert_eq!(instance.fingerprint(), before);
}

#[test]
fn one_refused_value_keeps_the_others_from_being_set() {
    let instance = Instance::new();
    let before = instance.fingerprint();
    let references = [vr("valveVoltage"), vr("mass.moving"), vr("cylinder.bore")];
    assert_eq!(instance.set_real(&references, &[6.0, 1.0, -1.0]), ERROR);
    assert_eq!(instance.set_real(&[vr("valveVoltage"), vr("position")], &[6.0, 0.1]), ERROR);
    assert_eq!(instance.fingerprint(), before);
}

#[test]
fn computed_values_and_time_cannot_be_set() {
    let starts = cylinder().default_starts().expect("defaults that fit");
    for instance in [Instance::new(), Instance::initialized()] {
        let before = instance.fingerprint();
        for variable in variables().iter().filter(|variable| !settable(variable)) {
            // States may be set to what they start from anyway.
            let is_start = starts.get(&variable.reference) == Some(&0.0);
            assert_eq!(set(&instance, variable, f64::from(u8::from(is_start))), ERROR, "{}", variable.name);
            assert!(instance.message().contains(&variable.name));
        }
        assert_eq!(instance.fingerprint(), before);
    }
}

#[test]
fn computed_values_are_not_there_before_initialization() {
    let instance = Instance::new();
    for variable in variables() {
        let readable = !variable.is_computed();
        assert_eq!(get(&instance, variable).is_some(), readable, "{}", variable.name);
    }
    assert_eq!(instance.enter(), OK);
    for variable in variables() {
        assert!(get(&instance, variable).is_some(), "{}", variable.name);
    }
}

#[test]
pub fn computed_values_follow_what_is_set_during_initialization() {
    let instance = Instance::new();
    assert_eq!(instance.enter(), OK);
    assert_eq!(instance.real("position"), 0.25);
    assert_eq!(instance.set_real(&[vr("position0")], &[0.125]), OK);
    assert_eq!(instance.real("position"), 0.125);
    assert_eq!(instance.set_integer(&[vr("friction.law")], &[1]), OK);
    let still = instance.real("acceleration");
    assert_eq!(instance.set_real(&[vr("externalForce")], &[8.8]), OK);
    let difference = instance.real("acceleration") - still;
    assert!((difference - 10.0).abs() < 1e-12, "{difference}: 8.8 N on 0.88 kg");
    assert_eq!(instance.exit(), OK);
    assert_eq!(instance.real("position"), 0.125);
}

/// OpenModelica sends fixed parameters again after the initialization.
#[test]
fn fixed_parameters_are_kept_after_initialization_and_tunable_ones_are_not() {
    let instance = Instance::initialized();
    let before = instance.fingerprint();
    for variable in variables().iter().filter(|variable| variable.role == Role::Fixed) {
        let start = variable.start.expect("a start");
        let other = if variable.kind == Kind::Boolean { 1.0 - start } else { start + 1.0 };
        assert_eq!(set(&instance, variable, start), OK, "{}: {:?}", variable.name, instance.messages());
        assert_eq!(set(&instance, variable, other), ERROR, "{}", variable.name);
        let message = instance.message();
        assert!(message.contains(&variable.name) && message.contains("initialization"), "{message}");
    }
    assert_eq!(instance.fingerprint(), before);
    let mut tunable = 0;
    for variable in variables().iter().filter(|variable| variable.role == Role::Tunable) {
        let start = variable.start.expect("a start");
        assert_eq!(set(&instance, variable, start), OK, "{}: {:?}", variable.name, instance.messages());
        tunable += 1;
    }
    assert!(tunable > 10, "{tunable}");
}

/// The number of a law takes the place of the law; neither may change it afterwards, and both may be sent again.
#[test]
fn fixed_parameter_keeps_what_is_in_use_and_what_was_set() {
    let (law, number) = (vr("friction.law"), vr("friction.lawNumber"));
    let instance = Instance::new();
    assert_eq!(instance.setup(0.0, None), OK);
    assert_eq!(instance.set_integer(&[number], &[14]), OK);
    assert_eq!((instance.enter(), instance.exit()), (OK, OK));
    let before = instance.fingerprint();
    assert_eq!(instance.set_integer(&[law, law, number], &[14, 7, 14]), OK, "{:?}", instance.messages());
    assert_eq!(instance.set_integer(&[law, number], &[14, 7]), ERROR);
    let mut chosen = [0];
    assert_eq!((instance.get_integer(&[law], &mut chosen), chosen), (OK, [14]));
    assert_eq!(instance.fingerprint(), before);
}

#[test]
fn tuned_parameter_takes_effect_at_the_next_step() {
    let (tuned, plain) = (Instance::with_law(1), Instance::with_law(1));
    assert_eq!(tuned.set_real(&[vr("wireForce")], &[0.88]), OK);
    let difference = tuned.real("acceleration") - plain.real("acceleration");
    assert!((difference + 1.0).abs() < 1e-12, "{difference}: -0.88 N on 0.88 kg");
    assert_eq!((tuned.step(0.0, 0.01), plain.step(0.0, 0.01)), (OK, OK));
    let difference = tuned.real("velocity") - plain.real("velocity");
    assert!((difference + 0.01).abs() < 1e-4, "{difference}: about -1 m/s2 for 10 ms");
}

#[test]
fn parameters_that_do_not_fit_together_are_refused_by_name() {
    let bad = [vr("friction.stribeck.Fs"), vr("friction.stribeck.Fc")];
    let instance = Instance::new();
    assert_eq!(instance.setup(0.0, None), OK);
    assert_eq!(instance.enter(), OK);
    assert_eq!(instance.set_real(&bad, &[5.0, 6.0]), OK);
    assert_eq!(instance.exit(), ERROR);
    let message = instance.message();
    assert!(message.contains("friction.stribeck.F") && message.contains("is refused"), "{message}");
    assert_eq!(instance.set_real(&bad, &[6.0, 5.0]), OK);
    assert_eq!(instance.exit(), OK);

    let before = instance.fingerprint();
    assert_eq!(instance.set_real(&[vr("valveVoltage"), bad[0], bad[1]], &[7.0, 5.0, 6.0]), ERROR);
    let message = instance.message();
    assert!(message.contains("friction.stribeck.F") && message.contains("is refused"), "{message}");
    assert_eq!(instance.fingerprint(), before);
    assert_eq!(instance.set_real(&bad, &[7.0, 7.0]), OK);
}

#[test]
fn reading_after_setting_inputs_does_not_change_the_run() {
    let (curious, plain) = (Instance::initialized(), Instance::initialized());
    for index in 0..200 {
        let time = f64::from(index) * 1e-3;
        let inputs = [vr("valveVoltage"), vr("externalForce")];
        let values = [5.0 + 3.0 * (40.0 * time).sin(), 10.0 * (90.0 * time).cos()];
        for wild in [[0.0, 1e6], [10.0, -1e6], [5.4, 12.0]] {
            assert_eq!(curious.set_real(&inputs, &wild), OK);
            let seen = curious.bits();
            assert_eq!(curious.bits(), seen);
        }
        for instance in [&curious, &plain] {
            assert_eq!(instance.set_real(&inputs, &values), OK);
        }
        assert_eq!(curious.bits(), plain.bits(), "step {index}");
        assert_eq!((curious.step(time, 1e-3), plain.step(time, 1e-3)), (OK, OK));
    }
    assert_eq!(curious.bits(), plain.bits());
    assert_eq!(curious.fingerprint(), plain.fingerprint());
}

#[test]
fn values_stay_readable_after_terminate_and_after_errors() {
    let instance = Instance::initialized();
    instance.swing(5);
    let values = instance.bits();
    assert_eq!(instance.step(99.0, 1e-3), ERROR);
    assert_eq!(instance.bits(), values);
    assert_eq!(instance.terminate(), OK);
    assert_eq!(instance.bits(), values);
}
