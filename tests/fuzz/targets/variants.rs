//! Files of variants: whatever they hold, they are refused, or give values that are legal for the model and the same file again.

#![no_main]

use std::sync::Once;

use libfuzzer_sys::fuzz_target;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
use pneumatic_servo_variant::Variant;

/// What a file begins with; values follow.
const HEAD: &str = "pneumatic-servo variant 1\nmodel = PneumaticServoCylinder\nname = Axis7\ninputs = valveVoltage\n\
                    outputs = position\nparameters = cylinder.bore\n";

static SOUND: Once = Once::new();

fuzz_target!(|data: &[u8]| {
    // Nobody guesses the first line.
    SOUND.call_once(|| assert!(Variant::read(HEAD.as_bytes()).is_ok()));
    check(data);
    check(&[HEAD.as_bytes(), data].concat());
});

fn check(data: &[u8]) {
    let Ok(variant) = Variant::read(data) else { return };
    let again = Variant::read(variant.text().as_bytes()).map(|variant| variant.text());
    assert_eq!(again, Ok(variant.text()));
    let Ok(resolved) = variant.resolve(MODEL.table()) else { return };
    let (parameters, inputs) = (MODEL.table().parameters(), MODEL.table().inputs());
    for (variable, value) in parameters.zip(&resolved.parameters).chain(inputs.zip(&resolved.inputs)) {
        variable.check(*value).expect("a legal value");
    }
}
