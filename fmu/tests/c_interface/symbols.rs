//! Exported symbols of the library.

use std::collections::BTreeSet;
use std::ffi::CStr;
use std::fs;

use object::{NameOrOrdinal, Object};

use pneumatic_servo_fmu::{fmi2, fmi3};

use crate::common::{LIBRARY, library_path};

/// The names of all that the built library exports.
pub fn exported() -> BTreeSet<String> {
    let bytes = fs::read(library_path()).expect("the library's file");
    let file = object::File::parse(&*bytes).expect("a library");
    let exports = file.exports().expect("its exports");
    exports.map(|export| name(export.expect("an export").name())).collect()
}

#[test]
fn exactly_the_functions_of_the_standards_are_exported() {
    let names = [fmi2::exports::Functions::NAMES, fmi3::exports::Functions::NAMES].concat();
    let expected: BTreeSet<_> = names.into_iter().map(str::to_owned).collect();
    assert_eq!(exported(), expected);
}

#[test]
pub fn version_and_platform_are_those_of_fmi_2() {
    // SAFETY: both return static strings.
    let texts = unsafe { [LIBRARY.fmi2GetVersion, LIBRARY.fmi2GetTypesPlatform].map(|function| function()) };
    assert!(texts.iter().all(|text| !text.is_null()));
    // SAFETY: as above.
    assert_eq!(texts.map(|text| unsafe { CStr::from_ptr(text) }), [c"2.0", c"default"]);
}

/// The name of an export; Apple's start with an underscore.
fn name(name: NameOrOrdinal<&[u8]>) -> String {
    match name {
        NameOrOrdinal::Name(name) => String::from_utf8_lossy(name).trim_start_matches('_').to_owned(),
        NameOrOrdinal::Ordinal(ordinal) => format!("number {ordinal}"),
    }
}
