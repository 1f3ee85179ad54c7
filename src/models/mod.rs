//! Complete systems: equations, events and the variable table of each.

mod bristles;
pub mod driven_slider;
pub(crate) mod equations;
pub mod festoon;
pub mod friction_bench;
pub mod pneumatic_servo_cylinder;
pub mod position_controller;
pub mod vibro_impact;

use crate::model::Model;

/// Every model this library serves; the GUID given to `fmi2Instantiate` chooses one.
pub static ALL: &[Model] = &[
    pneumatic_servo_cylinder::MODEL,
    friction_bench::MODEL,
    position_controller::MODEL,
    driven_slider::MODEL,
    vibro_impact::MODEL,
    festoon::MODEL,
];

/// The model of a name.
pub fn find(name: &str) -> Option<&'static Model> {
    ALL.iter().find(|model| model.name == name)
}
