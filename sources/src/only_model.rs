//! The one model that a module serves, since more would be too large: nothing of the others is linked.

#![allow(unsafe_code, reason = "this is an interface to C")]

use pneumatic_servo::model::Model;
use pneumatic_servo::models;

/// The model that the variable `ONLY_MODEL` named when this was compiled.
pub static MODELS: &[Model] = &[models::ALL[place(env!("ONLY_MODEL"))]];

pneumatic_servo_fmu::export_fmu!(MODELS);

/// The place of the model of a name; a name that no model has does not compile.
const fn place(name: &str) -> usize {
    let mut place = 0;
    while place < models::ALL.len() {
        if is_same(models::ALL[place].name.as_bytes(), name.as_bytes()) {
            return place;
        }
        place += 1;
    }
    panic!("ONLY_MODEL names no model")
}

const fn is_same(one: &[u8], other: &[u8]) -> bool {
    let mut place = 0;
    while place < one.len() && place < other.len() && one[place] == other[place] {
        place += 1;
    }
    one.len() == other.len() && place == one.len()
}
