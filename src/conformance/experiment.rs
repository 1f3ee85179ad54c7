//! The default experiment speaks of variables that there are.

use crate::model::Experiment;
use crate::variables::{Place, Table, find};

/// Checks that the default experiment of a model has steps, moves inputs and draws variables of the model.
///
/// # Panics
/// When it has none, or speaks of others.
pub fn experiment(model: &str, table: &Table, experiment: &Experiment) {
    let Experiment { stop_time, step_size, signals, panels } = *experiment;
    assert!(step_size > 0.0 && stop_time >= step_size, "{model}: the default experiment has no step of {step_size} s");
    for signal in signals {
        let entry = find(table, signal.input).unwrap_or_else(|error| panic!("{model}: a signal: {error}"));
        assert!(matches!(entry.place, Place::Input(_)), "{model}: {} moves, and is no input", signal.input);
    }
    for (panel, curve) in panels.iter().flat_map(|panel| panel.curves.iter().map(move |curve| (panel, curve))) {
        find(table, curve).unwrap_or_else(|error| panic!("{model}: the panel \"{}\": {error}", panel.label));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Panel, Setup};
    use crate::models::pneumatic_servo_cylinder::MODEL;

    const OTHER: Experiment =
        Experiment { panels: &[Panel { label: "slip", curves: &["position", "speed"] }], ..MODEL.experiment };

    #[test]
    #[should_panic(expected = "Cylinder: the panel \"slip\": ")]
    fn panel_of_a_variable_that_is_not_there_is_named() {
        experiment("Cylinder", Setup::of(&MODEL).table(), &OTHER);
    }
}
