//! Boolean inputs: the coils of four valves.

use pneumatic_servo_fmu::fmi2::types::EventInfo;

use crate::common::fmi3::{Instance3, Way};
use crate::common::*;

const SWITCHING_VALVES: i32 = 3;
const EACH_COIL: i32 = 3;

/// References of the four coils.
fn coils() -> [u32; 4] {
    ["coil[1]", "coil[2]", "coil[3]", "coil[4]"].map(vr)
}

/// A cylinder with four valves, initialized, for either way.
fn with_coils(instance: Instance) -> Instance {
    let choices = [vr("actuation"), vr("switching.command")];
    assert_eq!(instance.set_integer(&choices, &[SWITCHING_VALVES, EACH_COIL]), OK);
    assert_eq!(instance.set_real(&[vr("switching.openingDelay")], &[4e-3]), OK);
    instance.initialize();
    instance
}

fn with_coils3(way: Way) -> Instance3 {
    let instance = Instance3::of(cylinder(), way);
    let choices = [vr("actuation"), vr("switching.command")];
    assert_eq!(instance.set_int64(&choices, &[SWITCHING_VALVES.into(), EACH_COIL.into()]), OK);
    assert_eq!(instance.set(&[vr("switching.openingDelay")], &[4e-3]), OK);
    assert_eq!((instance.enter(), instance.exit()), (OK, OK), "{:?}", instance.messages());
    instance
}

/// A command per step of 1 ms, which both versions take; a step that is repeated from a saved state gives the same bits.
#[test]
fn coils_are_set_between_steps_alike_by_both_versions() {
    let (two, three) = (with_coils(Instance::new()), with_coils3(Way::Steps));
    let mut begins = None;
    for step in 0..100 {
        let time = f64::from(step) * 1e-3;
        let feeds_a = step % 40 < 25;
        let on = [feeds_a, !feeds_a, false, feeds_a];
        assert_eq!(two.set_boolean(&coils(), &on.map(i32::from)), OK);
        assert_eq!(three.set_boolean(&coils(), &on.map(u8::from)), OK);
        let (before, mut read) = (two.save(), [7; 4]);
        assert_eq!(two.step(time, 1e-3), OK, "{:?}", two.messages());
        let first = two.real("chamberA.pressure");
        if first != 101_325.0 {
            begins.get_or_insert(time);
        }
        assert_eq!((two.restore(before), two.step(time, 1e-3)), (OK, OK));
        assert_eq!((two.get_boolean(&coils(), &mut read), read), (OK, on.map(i32::from)));
        assert_eq!(three.step(time, 1e-3).0, OK, "{:?}", three.messages());
        for name in ["position", "chamberA.pressure", "chamberB.pressure"] {
            let found = [two.real(name), three.real(name)].map(f64::to_bits);
            assert_eq!(found[0], found[1], "{name} at {time} s");
        }
        assert_eq!(first.to_bits(), two.real("chamberA.pressure").to_bits(), "repeated at {time} s");
    }
    assert_eq!(begins, Some(4e-3), "the first step after the delay");
    assert!(two.real("position") > 0.26, "it moves");
}

#[test]
fn coils_take_true_and_false_alone() {
    let instance = with_coils(Instance::new());
    assert_eq!(instance.set_boolean(&coils(), &[1, 0, 2, 1]), ERROR);
    let message = instance.message();
    assert!(message.contains("coil[3] = 2"), "{message}");
    let mut read = [7; 4];
    assert_eq!((instance.get_boolean(&coils(), &mut read), read), (OK, [0; 4]), "all or none");
    assert_eq!(instance.set_real(&[vr("coil[1]")], &[1.0]), ERROR);
    assert_eq!(instance.set_slopes(&[vr("coil[1]")], &[1.0]), ERROR);
    let (rate, coil) = ([vr("der(chamberA.pressure)")], [vr("coil[1]")]);
    assert_eq!(instance.directional(&rate, &coil, &[1.0], &mut [0.0]), ERROR);
    let messages = instance.messages();
    assert!(messages.len() == 3 && messages.iter().all(|it| it.text.contains("coil[1]")), "{messages:?}");
}

/// Discrete inputs change at events; the importer is told when the valve begins and ends to move.
#[test]
fn coils_are_set_in_event_mode_and_announce_their_time_events() {
    let instance = with_coils(Instance::for_exchange(cylinder()));
    // SAFETY: of the component.
    let update = || {
        let mut info = EventInfo::default();
        assert_eq!(unsafe { (LIBRARY.fmi2NewDiscreteStates)(instance.component, &mut info) }, OK);
        (info.next_event_time_defined == 1).then_some(info.next_event_time)
    };
    // SAFETY: as above.
    let enter = |event: bool| unsafe {
        if event {
            (LIBRARY.fmi2EnterEventMode)(instance.component)
        } else {
            (LIBRARY.fmi2EnterContinuousTimeMode)(instance.component)
        }
    };
    assert_eq!(update(), None, "nothing happens while all coils are off");
    assert_eq!(enter(false), OK);
    assert_eq!(instance.set_boolean(&[vr("coil[1]")], &[1]), ERROR);
    assert!(instance.message().contains("coil[1]"));
    // SAFETY: as above.
    let go_to = |time: f64| assert_eq!(unsafe { (LIBRARY.fmi2SetTime)(instance.component, time) }, OK);
    go_to(0.01);
    assert_eq!((enter(true), instance.set_boolean(&[vr("coil[1]")], &[1])), (OK, OK));
    let begins = update().expect("the valve begins to open");
    assert!((begins - 0.014).abs() < 1e-12, "{begins}");
    assert_eq!(enter(false), OK);
    go_to(begins);
    assert_eq!(enter(true), OK);
    let ends = update().expect("the valve is open");
    assert!((ends - begins - 5e-4).abs() < 1e-12, "{ends}");
    assert_eq!(instance.real("der(switching.openingA)"), 2000.0);
}
