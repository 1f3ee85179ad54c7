//! Derivatives along anything that has a name are numbers, or are refused by name: of every model, at its defaults.

use pneumatic_servo::model::{Setup, Steps};
use pneumatic_servo::models;

#[test]
fn directions_of_all_names_are_carried_or_refused() {
    for model in models::ALL {
        let outputs: Vec<&str> = model.table().computed().take(2).map(|variable| variable.name.as_str()).collect();
        for variable in model.table().iter() {
            let name = variable.name.as_str();
            let mut plant = Setup::new(model).start(0.0).expect("the defaults fit");
            let carried = match plant.carry_sensitivities(&[name]) {
                Ok(()) => {
                    plant.advance_to(2e-3).expect("a step");
                    match plant.sensitivities(0) {
                        Ok(slopes) => assert!(slopes.iter().all(|slope| slope.is_finite()), "{}: {name}", model.name),
                        Err(lost) => assert!(!lost.to_string().is_empty()),
                    }
                    true
                }
                Err(refused) => {
                    assert!(refused.to_string().contains(name), "{}: {refused}", model.name);
                    false
                }
            };
            if !variable.is_parameter() {
                continue;
            }
            let mut plant = Setup::new(model).start(0.0).expect("the defaults fit");
            match plant.transition(1e-3, &[name], &outputs) {
                Ok(_) => assert!(carried, "{}: {name} has a transition", model.name),
                Err(refused) => {
                    assert!(!carried && refused.to_string().contains(name), "{}: {refused}", model.name);
                }
            }
            let mut plant = Setup::new(model).start(0.0).expect("the defaults fit");
            let inputs: Vec<f64> = model.table().inputs().filter_map(|input| input.start).collect();
            let steps = Steps { ends: &[1e-3, 2e-3], inputs: &[inputs.clone(), inputs] };
            match plant.gradient(steps, &[name], &outputs, |_, _| 1.0, || true) {
                Ok(gradient) => assert!(carried && gradient.is_some(), "{}: {name} has a gradient", model.name),
                Err(refused) => assert!(!refused.to_string().is_empty()),
            }
        }
    }
}
