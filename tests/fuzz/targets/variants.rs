//! Files of variants: whatever they hold, they are refused, or give values that are legal for the model and the same file again.

#![no_main]

use libfuzzer_sys::fuzz_target;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
use pneumatic_servo_variant::Variant;

fuzz_target!(|data: &[u8]| {
    let Ok(variant) = Variant::read(data) else { return };
    let again = Variant::read(variant.text().as_bytes()).map(|variant| variant.text());
    assert_eq!(again, Ok(variant.text()));
    let Ok(resolved) = variant.resolve(MODEL.table()) else { return };
    let (parameters, inputs) = (MODEL.table().parameters(), MODEL.table().inputs());
    for (variable, value) in parameters.zip(&resolved.parameters).chain(inputs.zip(&resolved.inputs)) {
        variable.check(*value).expect("a legal value");
    }
});
