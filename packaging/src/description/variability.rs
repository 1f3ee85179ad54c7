//! Causality and variability, named alike by both versions of FMI.

use pneumatic_servo::variables::{Kind, Role, Variable};
use pneumatic_servo_ssp::xml::Element;

/// Adds name, value reference, description, causality, variability and initial.
pub fn describe(element: Element, name: &str, description: &str, variable: &Variable) -> Element {
    let (causality, variability, initial) = attributes(variable);
    element
        .with("name", name)
        .with("valueReference", &variable.reference.to_string())
        .with_some("description", Some(description).filter(|text| !text.is_empty()))
        .with("causality", causality)
        .with("variability", variability)
        .with_some("initial", initial)
}

/// Causality, variability and initial. The time and inputs must not have the last; FMI fixes it for them.
fn attributes(variable: &Variable) -> (&'static str, &'static str, Option<&'static str>) {
    let varies = if matches!(variable.kind, Kind::Real(_)) { "continuous" } else { "discrete" };
    match variable.role {
        Role::Time => ("independent", "continuous", None),
        Role::Input => ("input", varies, None),
        Role::Fixed => ("parameter", "fixed", Some("exact")),
        Role::Tunable => ("parameter", "tunable", Some("exact")),
        Role::Output => ("output", varies, Some(calculated(variable))),
        Role::Local => ("local", varies, Some(calculated(variable))),
    }
}

/// `approx` with a start value (a state under the defaults), else `calculated`.
fn calculated(variable: &Variable) -> &'static str {
    if variable.start.is_some() { "approx" } else { "calculated" }
}

/// Whether the variable is a continuous state. Events may set any of them.
pub fn is_state(variables: &[Variable], variable: &Variable) -> bool {
    variables.iter().any(|other| other.derivative_of == Some(variable.reference))
}

/// An integer as text.
pub fn whole(value: f64) -> String {
    format!("{value:.0}")
}
