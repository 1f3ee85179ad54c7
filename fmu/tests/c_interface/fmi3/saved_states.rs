//! Saved states.

use super::STRIBECK;
use crate::common::fmi3::{Instance3, LIBRARY3, Way};
use crate::common::*;

/// Steps to a time, and to all events on the way; everything that is seen, bit for bit.
fn run(instance: &Instance3, end: f64) -> Vec<Vec<u64>> {
    let mut seen = Vec::new();
    while instance.real("time") < end {
        let time = instance.real("time");
        let (status, step) = instance.step(time, end - time);
        assert_eq!(status, OK, "{:?}", instance.messages());
        seen.push(instance.bits());
        if step.event == 1 {
            assert_eq!((instance.enter_event_mode(), instance.update().0, instance.enter_step_mode()), (OK, OK, OK));
            seen.push(instance.bits());
        }
    }
    seen
}

#[test]
pub fn state_before_an_event_repeats_bit_for_bit_in_another_instance() {
    for (law, name) in laws() {
        let instance = Instance3::cylinder(Way::Events(true), law.into(), 6.0);
        assert_eq!(instance.enter_step_mode(), OK);
        let (status, step) = instance.step(0.0, 0.2);
        assert_eq!(status, OK);
        assert!(step.event == 1 || step.time == 0.2, "{name}");
        let (state, at_event) = (instance.save(), instance.bits());
        let bytes = instance.serialize(state);
        let first = run(&instance, 0.3);
        assert_eq!(instance.restore(state), OK);
        assert_eq!((instance.bits(), run(&instance, 0.3)), (at_event.clone(), first.clone()), "{name}");
        let other = Instance3::of(cylinder(), Way::Events(true));
        let (status, copy) = other.deserialize(&bytes);
        assert_eq!((status, other.restore(copy)), (OK, OK), "{name}: {:?}", other.messages());
        assert_eq!((other.bits(), run(&other, 0.3)), (at_event, first), "{name}");
    }
}

#[test]
fn states_of_other_kinds_are_refused() {
    let ways = [Way::Steps, Way::Events(false), Way::Events(true), Way::Exchange];
    for from in ways {
        let bytes = Instance3::cylinder(from, STRIBECK, 6.0).fingerprint();
        for to in ways {
            let instance = Instance3::of(cylinder(), to);
            let (status, state) = instance.deserialize(&bytes);
            assert_eq!(status, OK, "{:?}", instance.messages());
            assert_eq!(instance.restore(state), if from == to { OK } else { ERROR }, "{from:?} to {to:?}");
        }
    }
}

/// The state of a co-simulation is the same in both versions of the standard.
#[test]
pub fn states_go_from_one_version_to_the_other() {
    let (two, three) = (Instance::with_law(STRIBECK as i32), Instance3::cylinder(Way::Steps, STRIBECK, 5.0));
    assert_eq!((two.step(0.0, 0.1), three.step(0.0, 0.2).0), (OK, OK));
    let (status, state) = three.deserialize(&two.fingerprint());
    assert_eq!((status, three.restore(state)), (OK, OK), "{:?}", three.messages());
    assert_eq!((three.step(0.1, 0.1).0, two.step(0.1, 0.1)), (OK, OK));
    assert_eq!(three.bits(), two.bits());
}

#[test]
pub fn freed_state_is_refused() {
    let instance = Instance3::cylinder(Way::Steps, STRIBECK, 5.0);
    let state = instance.save();
    let (mut freed, mut size) = (state, 7);
    assert_eq!(instance.restore(state), OK);
    // SAFETY: of the component; the handle is only compared.
    unsafe {
        assert_eq!((LIBRARY3.fmi3FreeFMUState)(instance.component, &mut freed), OK);
        assert!(freed.is_null());
        assert_eq!(instance.restore(state), ERROR);
        assert_eq!((LIBRARY3.fmi3SerializedFMUStateSize)(instance.component, state, &mut size), ERROR);
    }
    assert_eq!(size, 7);
}
