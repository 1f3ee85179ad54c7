//! Values: types, arrays, indicators and dependencies.

use std::ptr;

use pneumatic_servo::models;
use pneumatic_servo::variables::Variable;
use pneumatic_servo::variables::{Kind, Role};

use super::{INDICATORS, STATES, STRIBECK};
use crate::common::fmi3::{Instance3, LIBRARY3, Way};
use crate::common::*;

/// The first event indicator of every model.
const FIRST_INDICATOR: u32 = 6_000;

#[test]
fn arrays_are_read_and_set_as_a_whole() {
    let instance = Instance3::of(cylinder(), Way::Steps);
    let (k, voltage) = (vr("friction.gms.k[1]"), vr("valveVoltage"));
    let mut values = [0.0; 11];
    assert_eq!(instance.get(&[voltage, k], &mut values), OK, "{:?}", instance.messages());
    assert_eq!(values[..5], [5.0, 4e5, 3e5, 2e5, 1e5]);
    values[3] = 2.5e5;
    assert_eq!(instance.set(&[k, voltage], &[&values[1..], &[6.0]].concat()), OK);
    let mut again = [0.0; 11];
    assert_eq!(instance.get(&[k, voltage], &mut again), OK);
    assert_eq!((again[2], again[10]), (2.5e5, 6.0));
}

#[test]
fn elements_of_arrays_and_wrong_numbers_of_values_are_refused() {
    let instance = Instance3::of(cylinder(), Way::Steps);
    let (k, second) = (vr("friction.gms.k[1]"), vr("friction.gms.k[2]"));
    let before = instance.fingerprint();
    assert_eq!(instance.get(&[second], &mut [0.0]), ERROR);
    assert!(instance.message().contains(&format!("no variable with value reference {second}")));
    for room in [1, 9, 11] {
        let mut values = vec![-7.0; room];
        assert_eq!((instance.get(&[k], &mut values), instance.set(&[k], &values)), (ERROR, ERROR));
        assert!(instance.message().contains(&format!("10 elements, but there are {room} values")));
        assert!(values.iter().all(|value| *value == -7.0));
    }
    assert_eq!(instance.set(&[k], &[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, f64::NAN]), ERROR);
    assert_eq!(instance.fingerprint(), before);
}

#[test]
fn every_variable_of_every_model_has_one_type() {
    for model in models::ALL {
        let instance = Instance3::of(model, Way::Steps);
        assert_eq!((instance.enter(), instance.exit()), (OK, OK), "{}: {:?}", model.name, instance.messages());
        let indicators = model.indicator_variables();
        let mut table: Vec<(usize, &Variable)> = (model.variables)().arrays().collect();
        table.extend(indicators.iter().map(|variable| (1, variable)));
        for (length, variable) in table {
            let reference = [variable.reference];
            let (mut reals, mut integers) = (vec![0.0; length], vec![0; length]);
            let (mut items, mut booleans) = (vec![0; length], vec![0; length]);
            let (mut singles, mut bytes) = (vec![0.0f32; length], vec![0u8; length]);
            // SAFETY: of the component; the arrays have room for all elements.
            let absent = unsafe {
                [
                    (LIBRARY3.fmi3GetFloat32)(instance.component, reference.as_ptr(), 1, singles.as_mut_ptr(), length),
                    (LIBRARY3.fmi3GetUInt8)(instance.component, reference.as_ptr(), 1, bytes.as_mut_ptr(), length),
                    (LIBRARY3.fmi3GetString)(instance.component, reference.as_ptr(), 1, ptr::null_mut(), 0),
                    (LIBRARY3.fmi3GetClock)(instance.component, reference.as_ptr(), 1, ptr::null_mut()),
                ]
            };
            assert_eq!(absent, [ERROR; 4], "{}", variable.name);
            let found = [
                instance.get(&reference, &mut reals),
                instance.get_int32(&reference, &mut integers),
                instance.get_int64(&reference, &mut items),
                instance.get_boolean(&reference, &mut booleans),
            ];
            let expected = match variable.kind {
                Kind::Real(_) => [OK, ERROR, ERROR, ERROR],
                Kind::Integer => [ERROR, OK, ERROR, ERROR],
                Kind::Enumeration(_) => [ERROR, ERROR, OK, ERROR],
                Kind::Boolean => [ERROR, ERROR, ERROR, OK],
            };
            assert_eq!(found, expected, "{}: {:?}", variable.name, instance.messages());
        }
    }
}

#[test]
fn no_value_of_an_absent_type_is_fine_and_null_is_refused_where_there_are_some() {
    let instance = Instance3::of(cylinder(), Way::Steps);
    let (component, one) = (instance.component, [vr("position")]);
    // SAFETY: of the component; NULL is allowed to be passed.
    unsafe {
        assert_eq!((LIBRARY3.fmi3GetString)(component, ptr::null(), 0, ptr::null_mut(), 0), OK);
        assert_eq!((LIBRARY3.fmi3SetClock)(component, ptr::null(), 0, ptr::null()), OK);
        assert_eq!((LIBRARY3.fmi3GetInt8)(component, ptr::null(), 0, ptr::null_mut(), 0), OK);
        instance.messages();
        assert_eq!((LIBRARY3.fmi3GetFloat64)(component, ptr::null(), 1, ptr::null_mut(), 1), ERROR);
        assert_eq!((LIBRARY3.fmi3SetFloat64)(component, one.as_ptr(), 1, ptr::null(), 1), ERROR);
        assert_eq!((LIBRARY3.fmi3GetBinary)(component, ptr::null(), 1, ptr::null_mut(), ptr::null_mut(), 1), ERROR);
    }
    let messages = instance.messages();
    assert!(messages.len() == 3 && messages.iter().all(|it| it.text.ends_with("is NULL")), "{messages:?}");
}

#[test]
fn enumerations_are_64_bit_integers_and_nothing_else() {
    let instance = Instance3::of(cylinder(), Way::Steps);
    let law = [vr("friction.law")];
    assert_eq!(instance.set_int32(&law, &[2]), ERROR);
    assert!(instance.message().ends_with("is Enumeration, not Integer"));
    for bad in [99, -1, i64::MAX] {
        assert_eq!(instance.set_int64(&law, &[bad]), ERROR);
        assert!(instance.message().contains("friction.law"));
    }
    let mut value = [0];
    assert_eq!((instance.set_int64(&law, &[14]), instance.get_int64(&law, &mut value)), (OK, OK));
    assert_eq!(value, [14]);
}

#[test]
fn indicators_are_variables_in_every_way_of_running_the_model() {
    let exchange = Instance3::cylinder(Way::Exchange, STRIBECK, 5.0);
    let steps = Instance3::cylinder(Way::Steps, STRIBECK, 5.0);
    let references: Vec<u32> = (FIRST_INDICATOR..).take(INDICATORS).collect();
    let (mut one, mut other, mut vector) = ([0.0; INDICATORS], [0.0; INDICATORS], [0.0; INDICATORS]);
    assert_eq!(exchange.update().0, OK);
    assert_eq!(exchange.get(&references, &mut one), OK, "{:?}", exchange.messages());
    assert_eq!(exchange.vector(LIBRARY3.fmi3GetEventIndicators, &mut vector), OK);
    assert_eq!(steps.get(&references, &mut other), OK, "{:?}", steps.messages());
    assert_eq!((one, one), (vector, other));
    assert!(one.iter().all(|value| *value > 0.0) && one.iter().any(|value| *value != 1.0), "{one:?}");
    assert_eq!(steps.set(&references[..1], &[1.0]), ERROR);
    assert!(steps.message().contains("friction.stop is an event indicator"));
}

#[test]
fn dependencies_are_those_of_the_table() {
    let instance = Instance3::of(cylinder(), Way::Exchange);
    let table = (cylinder().variables)();
    for (_, variable) in table.arrays() {
        let expected: Vec<_> = variable.depends_on.iter().map(|known| (0, *known, 0, 5)).collect();
        assert_eq!(instance.dependencies(variable.reference), expected, "{}", variable.name);
    }
    let all = instance.dependencies(FIRST_INDICATOR);
    let inputs = table.iter().filter(|it| it.role == Role::Input).count();
    assert_eq!(all.len(), 1 + inputs + STATES);
    let mut number = 7;
    // SAFETY: of the component.
    let status = unsafe { (LIBRARY3.fmi3GetNumberOfVariableDependencies)(instance.component, 7_777, &mut number) };
    assert_eq!((status, number), (ERROR, 7));
}
