//! The default experiment speaks of variables that there are.

use crate::model::Experiment;
use crate::variables::Table;

/// Checks that the default experiment of a model has steps, moves inputs and draws variables of the model.
///
/// # Panics
/// When it has none, or speaks of others.
pub fn experiment(model: &str, table: &Table, experiment: &Experiment) {
    let problems = experiment.problems(table);
    assert!(problems.is_empty(), "{model}: {}", problems.join("; "));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Panel, Setup};
    use crate::models::pneumatic_servo_cylinder::MODEL;

    const OTHER: Experiment =
        Experiment { panels: &[Panel { label: "slip", curves: &["position", "speed"] }], ..MODEL.experiment };

    #[test]
    #[should_panic(expected = "Cylinder: the default experiment shows speed, which is no variable")]
    fn panel_of_a_variable_that_is_not_there_is_named() {
        experiment("Cylinder", Setup::new(&MODEL).table(), &OTHER);
    }
}
