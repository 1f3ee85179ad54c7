//! Clocks that resolve less than the steps: seconds since 1970, and later still.

use pneumatic_servo::model::{Plant, Setup};
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

fn started(time: f64) -> Plant {
    Setup::new(&MODEL).set("friction.law", "Stribeck").expect("a law").start(time).expect("a plant")
}

/// A step has the size that is asked for, not the difference of two times of the clock, which resolves 0.24 us at 1.7e9 s and
/// 0.12 ms at 1e12 s: a run has the same bits at every clock.
#[test]
fn steps_at_a_late_clock_have_their_sizes() {
    for clock in [1.7e9, 1e12] {
        let mut runs = [started(0.0), started(clock)];
        for step in 0..500 {
            let voltage = 5.0 + 2.0 * f64::sin(0.04 * f64::from(step));
            let found = runs.each_mut().map(|run| {
                run.set("valveVoltage", voltage).expect("an input");
                run.step(1e-3).expect("a step");
                run.get("position").expect("an output")
            });
            assert_eq!(found[0].to_bits(), found[1].to_bits(), "step {step} at a clock of {clock} s");
        }
        assert!((runs[1].time() - clock - 0.5).abs() <= 1e-3, "the clock goes on");
    }
}

/// The transition of a step, too, depends on its size alone.
#[test]
fn transitions_at_a_late_clock_are_those_of_their_sizes() {
    let mut runs = [started(0.0), started(1e12)];
    let maps = runs.each_mut().map(|run| {
        run.set("valveVoltage", 7.0).expect("an input");
        run.step(0.02).expect("a step");
        let map = run.transition(1e-3, &[], &["position"]).expect("a transition").a;
        // By their bits, since columns without a derivative are no numbers.
        map.concat().into_iter().map(f64::to_bits).collect::<Vec<_>>()
    });
    assert_eq!(maps[0], maps[1]);
}
