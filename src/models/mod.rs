//! Complete systems: equations, events and the variable table of each.

#[cfg(test)]
mod checks;
pub mod driven_slider;
pub mod festoon;
pub mod friction_bench;
#[cfg(feature = "sensitivities")]
pub mod friction_observer;
pub mod pneumatic_servo_cylinder;
pub mod position_controller;
pub mod vibro_impact;

#[cfg(feature = "all-models")]
use crate::model::Model;

/// Every model this library serves; the GUID given to `fmi2Instantiate` chooses one. With the feature `all-models`.
#[cfg(feature = "all-models")]
pub static ALL: &[Model] = &[
    pneumatic_servo_cylinder::MODEL,
    friction_bench::MODEL,
    position_controller::MODEL,
    driven_slider::MODEL,
    vibro_impact::MODEL,
    festoon::MODEL,
];

/// The model of a name. With the feature `all-models`.
#[cfg(feature = "all-models")]
pub fn find(name: &str) -> Option<&'static Model> {
    ALL.iter().find(|model| model.name == name)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::numbers::Real;
    use crate::system::{IndicatorSet, System};

    /// Of the cylinder: both stops, both cushions, both switches.
    const KINKS: usize = 6;

    /// Number of indicators of a system.
    fn count<E: System<U>, const U: usize>() -> usize {
        E::Indicators::<Real>::unused().as_ref().len()
    }

    #[test]
    fn every_place_of_an_indicator_has_a_name_of_its_own() {
        let counts = [
            (pneumatic_servo_cylinder::MODEL, count::<pneumatic_servo_cylinder::PneumaticServoCylinder, 3>() + KINKS),
            (friction_bench::MODEL, count::<friction_bench::FrictionBench, 4>()),
            (driven_slider::MODEL, count::<driven_slider::DrivenSlider, 1>()),
            (vibro_impact::MODEL, count::<vibro_impact::VibroImpact, 1>()),
            (festoon::MODEL, count::<festoon::Festoon, 2>()),
        ];
        for (model, count) in counts {
            let indicators = model.indicators();
            let names: BTreeSet<_> = indicators.iter().map(|indicator| &indicator.name).collect();
            assert_eq!((indicators.len(), names.len()), (count, count), "{}", model.name);
        }
    }
}
