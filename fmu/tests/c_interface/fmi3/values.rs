//! Values: types, arrays, indicators and dependencies.

use std::ffi::c_int;
use std::ptr;

use pneumatic_servo::variables::{Kind, Variable};

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

/// Sets all elements of a parameter or an input.
fn set(instance: &Instance3, variable: &Variable, length: usize, value: f64) -> c_int {
    let reference = [variable.reference];
    match variable.kind {
        Kind::Real(_) => instance.set(&reference, &vec![value; length]),
        Kind::Integer => instance.set_int32(&reference, &vec![value as i32; length]),
        Kind::Enumeration(_) => instance.set_int64(&reference, &vec![value as i64; length]),
        Kind::Boolean => instance.set_boolean(&reference, &vec![value as u8; length]),
    }
}

/// All elements of a variable.
fn get(instance: &Instance3, variable: &Variable, length: usize) -> Vec<f64> {
    let reference = [variable.reference];
    let (mut reals, mut counts) = (vec![f64::NAN; length], vec![-7; length]);
    let (mut items, mut flags) = (vec![-7; length], vec![7; length]);
    let status = match variable.kind {
        Kind::Real(_) => instance.get(&reference, &mut reals),
        Kind::Integer => instance.get_int32(&reference, &mut counts),
        Kind::Enumeration(_) => instance.get_int64(&reference, &mut items),
        Kind::Boolean => instance.get_boolean(&reference, &mut flags),
    };
    assert_eq!(status, OK, "{}: {:?}", variable.name, instance.messages());
    match variable.kind {
        Kind::Real(_) => reals,
        Kind::Integer => counts.into_iter().map(f64::from).collect(),
        Kind::Enumeration(_) => items.into_iter().map(|item| item as f64).collect(),
        Kind::Boolean => flags.into_iter().map(f64::from).collect(),
    }
}

#[test]
pub fn every_parameter_and_input_of_every_model_keeps_what_is_set_until_a_reset() {
    for model in served() {
        let instance = Instance3::of(model, Way::Steps);
        let settable: Vec<(usize, &Variable)> =
            model.table().arrays().filter(|(_, it)| it.is_parameter() || is_input(it)).collect();
        for (length, variable) in &settable {
            let values = match variable.kind {
                Kind::Enumeration(of) => vec![of.items[of.items.len() - 1].0.into(), of.items[0].0.into()],
                Kind::Boolean => vec![1.0, 0.0, 1.0],
                _ => vec![variable.max.or(variable.min).unwrap_or(1.5)],
            };
            for value in values {
                let status = set(&instance, variable, *length, value);
                assert_eq!(status, OK, "{} {:?}", variable.name, instance.messages());
                assert_eq!(get(&instance, variable, *length), vec![value; *length], "{}", variable.name);
            }
        }
        assert_eq!(instance.reset(), OK);
        for (length, variable) in settable {
            let elements = (variable.reference..).take(length);
            let starts: Vec<f64> = elements
                .map(|reference| model.table().by_reference(reference).expect("an element").variable)
                .map(|element| element.start.expect("a start"))
                .collect();
            assert_eq!(get(&instance, variable, length), starts, "{}", variable.name);
        }
    }
}

/// A chamber that is open to the surroundings has their pressure, and only then.
#[test]
fn boolean_parameter_does_what_it_says() {
    for open in [0, 1] {
        let instance = Instance3::of(cylinder(), Way::Steps);
        assert_eq!(instance.set_boolean(&[vr("chamberB.open")], &[open]), OK);
        assert_eq!(instance.set(&[vr("chamberB.pressure0")], &[2e5]), OK);
        assert_eq!((instance.enter(), instance.exit()), (OK, OK), "{:?}", instance.messages());
        let is_ambient = instance.real("chamberB.pressure") == instance.real("ambientPressure");
        assert_eq!(is_ambient, open == 1);
    }
    let instance = Instance3::of(cylinder(), Way::Steps);
    for neither in [2, 255] {
        assert_eq!(instance.set_boolean(&[vr("chamberB.open")], &[neither]), ERROR);
        assert!(instance.message().contains("must be 0 (false) or 1 (true)"));
    }
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
    for model in served() {
        let instance = Instance3::of(model, Way::Steps);
        assert_eq!((instance.enter(), instance.exit()), (OK, OK), "{}: {:?}", model.name, instance.messages());
        let indicators = model.indicator_variables();
        let mut table: Vec<(usize, &Variable)> = model.table().arrays().collect();
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

/// Reads and sets two variables as numbers of a type that no variable has.
macro_rules! absent {
    ($($get:ident $set:ident $number:ty),*) => {
        [$(|instance, references| {
            let (number, mut values) = (references.len(), [7 as $number; 2]);
            // SAFETY: of the component; the arrays are no longer than what is told.
            let statuses = unsafe {
                [
                    (LIBRARY3.$get)(instance.component, references.as_ptr(), number, values.as_mut_ptr(), number),
                    (LIBRARY3.$set)(instance.component, references.as_ptr(), number, values.as_ptr(), number),
                ]
            };
            assert_eq!(values, [7 as $number; 2]);
            (statuses, [stringify!($get), stringify!($set)])
        }),*]
    };
}

type Pair = fn(&Instance3, &[u32]) -> ([c_int; 2], [&'static str; 2]);

const ABSENT_NUMBERS: [Pair; 7] = absent!(
    fmi3GetFloat32 fmi3SetFloat32 f32,
    fmi3GetInt8 fmi3SetInt8 i8,
    fmi3GetUInt8 fmi3SetUInt8 u8,
    fmi3GetInt16 fmi3SetInt16 i16,
    fmi3GetUInt16 fmi3SetUInt16 u16,
    fmi3GetUInt32 fmi3SetUInt32 u32,
    fmi3GetUInt64 fmi3SetUInt64 u64
);

/// Strings, binaries, and all that is asked of clocks.
fn others(instance: &Instance3, references: &[u32]) -> Vec<(c_int, &'static str, &'static str)> {
    let (it, vr, number) = (instance.component, references.as_ptr(), references.len());
    let (text, bytes) = (c"text".as_ptr(), [1].as_ptr());
    let (mut texts, mut sizes, mut binaries) = ([text; 2], [1; 2], [bytes; 2]);
    let (mut clocks, mut decimals, mut qualifiers) = ([7; 2], [7.0; 2], [7; 2]);
    let (mut counters, mut resolutions) = ([7; 2], [8; 2]);
    // SAFETY: of the component; the arrays have two elements.
    let statuses = unsafe {
        vec![
            ((LIBRARY3.fmi3GetString)(it, vr, number, texts.as_mut_ptr(), number), "fmi3GetString", "String"),
            ((LIBRARY3.fmi3SetString)(it, vr, number, texts.as_ptr(), number), "fmi3SetString", "String"),
            (
                (LIBRARY3.fmi3GetBinary)(it, vr, number, sizes.as_mut_ptr(), binaries.as_mut_ptr(), number),
                "fmi3GetBinary",
                "Binary",
            ),
            (
                (LIBRARY3.fmi3SetBinary)(it, vr, number, sizes.as_ptr(), binaries.as_ptr(), number),
                "fmi3SetBinary",
                "Binary",
            ),
            ((LIBRARY3.fmi3GetClock)(it, vr, number, clocks.as_mut_ptr()), "fmi3GetClock", "Clock"),
            ((LIBRARY3.fmi3SetClock)(it, vr, number, clocks.as_ptr()), "fmi3SetClock", "Clock"),
            (
                (LIBRARY3.fmi3GetIntervalDecimal)(it, vr, number, decimals.as_mut_ptr(), qualifiers.as_mut_ptr()),
                "fmi3GetIntervalDecimal",
                "Clock",
            ),
            (
                (LIBRARY3.fmi3GetIntervalFraction)(
                    it,
                    vr,
                    number,
                    counters.as_mut_ptr(),
                    resolutions.as_mut_ptr(),
                    qualifiers.as_mut_ptr(),
                ),
                "fmi3GetIntervalFraction",
                "Clock",
            ),
            ((LIBRARY3.fmi3GetShiftDecimal)(it, vr, number, decimals.as_mut_ptr()), "fmi3GetShiftDecimal", "Clock"),
            (
                (LIBRARY3.fmi3GetShiftFraction)(it, vr, number, counters.as_mut_ptr(), resolutions.as_mut_ptr()),
                "fmi3GetShiftFraction",
                "Clock",
            ),
            ((LIBRARY3.fmi3SetIntervalDecimal)(it, vr, number, decimals.as_ptr()), "fmi3SetIntervalDecimal", "Clock"),
            (
                (LIBRARY3.fmi3SetIntervalFraction)(it, vr, number, counters.as_ptr(), resolutions.as_ptr()),
                "fmi3SetIntervalFraction",
                "Clock",
            ),
            ((LIBRARY3.fmi3SetShiftDecimal)(it, vr, number, decimals.as_ptr()), "fmi3SetShiftDecimal", "Clock"),
            (
                (LIBRARY3.fmi3SetShiftFraction)(it, vr, number, counters.as_ptr(), resolutions.as_ptr()),
                "fmi3SetShiftFraction",
                "Clock",
            ),
        ]
    };
    assert_eq!((texts, sizes, binaries), ([text; 2], [1; 2], [bytes; 2]));
    assert_eq!((clocks, decimals, qualifiers), ([7; 2], [7.0; 2], [7; 2]));
    assert_eq!((counters, resolutions), ([7; 2], [8; 2]));
    statuses
}

#[test]
pub fn types_that_no_variable_has_are_refused_by_name_and_change_nothing() {
    let instance = Instance3::of(cylinder(), Way::Steps);
    let before = instance.fingerprint();
    let references = [vr("valveVoltage"), vr("friction.law")];
    for pair in ABSENT_NUMBERS {
        assert_eq!(pair(&instance, &[]).0, [OK; 2]);
        let (statuses, functions) = pair(&instance, &references);
        assert_eq!(statuses, [ERROR; 2], "{functions:?}");
        let messages = instance.messages();
        for (message, function) in messages.iter().zip(functions) {
            let kind = &function["fmi3Get".len()..];
            let expected = format!("{function}: valveVoltage (value reference {}) is Real, not {kind}", references[0]);
            assert_eq!(message.text, expected);
        }
        assert_eq!(messages.len(), 2);
    }
    assert!(others(&instance, &[]).iter().all(|(status, ..)| *status == OK), "{:?}", instance.messages());
    let refused = others(&instance, &references);
    let messages = instance.messages();
    assert_eq!(messages.len(), refused.len());
    for (message, (status, function, kind)) in messages.iter().zip(refused) {
        assert_eq!(status, ERROR, "{function}");
        let expected = format!("{function}: valveVoltage (value reference {}) is Real, not {kind}", references[0]);
        assert_eq!(message.text, expected);
    }
    assert_eq!(instance.fingerprint(), before);
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
pub fn dependencies_are_those_of_the_table() {
    let instance = Instance3::of(cylinder(), Way::Exchange);
    let table = cylinder().table();
    for (_, variable) in table.arrays() {
        let expected: Vec<_> = table.dependencies(variable).into_iter().map(|known| (0, known, 0, 5)).collect();
        assert_eq!(instance.dependencies(variable.reference), expected, "{}", variable.name);
    }
    let all = instance.dependencies(FIRST_INDICATOR);
    let inputs = table.iter().filter(|it| is_real_input(it)).count();
    assert_eq!(all.len(), 1 + inputs + STATES);
    let mut number = 7;
    // SAFETY: of the component.
    let status = unsafe { (LIBRARY3.fmi3GetNumberOfVariableDependencies)(instance.component, 7_777, &mut number) };
    assert_eq!((status, number), (ERROR, 7));
}
