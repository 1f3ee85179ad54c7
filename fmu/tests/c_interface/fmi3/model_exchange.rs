//! Model exchange: all answers to the importer's solver equal FMI 2.0's.

use super::{INDICATORS, STATES, STRIBECK};
use crate::common::fmi3::{Instance3, LIBRARY3, Way};
use crate::common::*;

/// The same cylinder through both versions, in continuous-time mode at 0 s.
fn twins() -> (Instance, Instance3) {
    let two = Instance::for_exchange(cylinder());
    assert_eq!(two.set_integer(&[vr("friction.law")], &[STRIBECK as i32]), OK);
    assert_eq!(two.set_real(&[vr("valveVoltage")], &[7.0]), OK);
    two.initialize();
    // SAFETY: of the component.
    assert_eq!(unsafe { (LIBRARY.fmi2EnterContinuousTimeMode)(two.component) }, OK);
    let three = Instance3::cylinder(Way::Exchange, STRIBECK, 7.0);
    assert_eq!(three.integrate(), OK);
    (two, three)
}

#[test]
pub fn solver_outside_sees_the_vectors_of_fmi_2() {
    let (two, three) = twins();
    assert_eq!(three.number(LIBRARY3.fmi3GetNumberOfContinuousStates), STATES);
    assert_eq!(three.number(LIBRARY3.fmi3GetNumberOfEventIndicators), INDICATORS);
    for (of_two, of_three, length) in [
        (LIBRARY.fmi2GetContinuousStates, LIBRARY3.fmi3GetContinuousStates, STATES),
        (LIBRARY.fmi2GetDerivatives, LIBRARY3.fmi3GetContinuousStateDerivatives, STATES),
        (LIBRARY.fmi2GetNominalsOfContinuousStates, LIBRARY3.fmi3GetNominalsOfContinuousStates, STATES),
        (LIBRARY.fmi2GetEventIndicators, LIBRARY3.fmi3GetEventIndicators, INDICATORS),
    ] {
        let (mut expected, mut seen) = (vec![f64::NAN; length], vec![f64::NAN; length]);
        // SAFETY: of the component; the array has its length.
        assert_eq!(unsafe { of_two(two.component, expected.as_mut_ptr(), length) }, OK);
        assert_eq!((three.vector(of_three, &mut seen), &seen), (OK, &expected));
        assert!(seen.iter().any(|value| *value != 0.0));
        assert_eq!(three.vector(of_three, &mut vec![0.0; length + 1]), ERROR);
    }
}

#[test]
pub fn accepted_steps_are_counted_and_lead_where_the_host_has_gone() {
    let (_, three) = twins();
    let mut states = [f64::NAN; STATES];
    assert_eq!(three.vector(LIBRARY3.fmi3GetContinuousStates, &mut states), OK);
    states[0] += 1e-3;
    assert_eq!((three.set_time(0.25), three.set_states(&states), three.accept_step()), (OK, OK, OK));
    assert_eq!((three.real("time"), three.real("position").to_bits()), (0.25, states[0].to_bits()));
    let mut steps = [-7];
    assert_eq!((three.get_int32(&[vr("solver.steps")], &mut steps), steps), (OK, [1]));
}

/// Inputs may jump at an event; what follows from them waits for the update.
#[test]
pub fn update_at_an_event_lets_a_stuck_carriage_go() {
    let (_, three) = twins();
    assert!(three.sticks());
    assert_eq!(three.enter_event_mode(), OK);
    assert_eq!(three.set(&[vr("externalForce")], &[200.0]), OK);
    assert!(three.sticks());
    assert_eq!(three.update().0, OK);
    assert!(!three.sticks());
    assert_eq!((three.set_states(&[1.0; STATES]), three.integrate()), (ERROR, OK));
    let mut states = [f64::NAN; STATES];
    assert_eq!(three.vector(LIBRARY3.fmi3GetContinuousStates, &mut states), OK);
    assert_eq!(three.set_states(&states), OK);
}
