//! Gate: a library exports every function of FMI 2.0 and FMI 3.0, and nothing else.

use std::collections::BTreeSet;

use pneumatic_servo_fmu::{fmi2, fmi3};

/// Missing and superfluous exports.
pub fn problems(exports: &BTreeSet<String>) -> Vec<String> {
    let wanted = standard();
    let names = |set: &mut dyn Iterator<Item = &String>| set.map(String::as_str).collect::<Vec<_>>().join(", ");
    let missing = names(&mut wanted.difference(exports));
    let foreign = names(&mut exports.difference(&wanted));
    let mut problems = Vec::new();
    if !missing.is_empty() {
        problems.push(format!("functions of FMI are missing: {missing}"));
    }
    if !foreign.is_empty() {
        problems.push(format!("exports that are no functions of FMI: {foreign}"));
    }
    problems
}

/// The functions that FMI 2.0 and FMI 3.0 define.
pub fn standard() -> BTreeSet<String> {
    let names = [fmi2::exports::Functions::NAMES, fmi3::exports::Functions::NAMES];
    names.into_iter().flatten().map(|name| (*name).to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_functions_of_the_standard_pass() {
        assert_eq!(problems(&standard()), Vec::<String>::new());
    }

    #[test]
    fn a_missing_function_is_named() {
        let mut exports = standard();
        exports.remove("fmi2DoStep");
        assert_eq!(problems(&exports), ["functions of FMI are missing: fmi2DoStep"]);
    }

    #[test]
    fn a_foreign_symbol_is_named() {
        let mut exports = standard();
        exports.insert("rust_eh_personality".to_owned());
        assert_eq!(problems(&exports), ["exports that are no functions of FMI: rust_eh_personality"]);
    }
}
