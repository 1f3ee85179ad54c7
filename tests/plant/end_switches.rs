//! Switches near the ends of the stroke.

use crate::rig::Rig;

/// Back and forth between the ends: each switch turns on within its distance, and off beyond it and the hysteresis.
#[test]
fn switches_turn_at_their_places() {
    let rig = Rig::cylinder("Stribeck").set("sensor.endDistance[1]", 0.02).set("sensor.endDistance[2]", 0.03);
    let mut running = rig.set("sensor.endHysteresis", 0.004).set("position0", 0.25).start().unwrap();
    let (mut before, mut turns) = ([0.0; 2], Vec::new());
    for step in 1..6000 {
        running.set("valveVoltage", if (step / 1500) % 2 == 0 { 7.0 } else { 3.0 });
        running.advance(f64::from(step) * 1e-3).unwrap();
        let now = ["sensor.end[1]", "sensor.end[2]"].map(|name| running.get(name));
        let way = running.get("velocity") * 1e-3;
        for side in 0..2 {
            if now[side] != before[side] {
                let distance = [running.get("position"), 0.5 - running.get("position")][side];
                let place = [[0.024, 0.02], [0.034, 0.03]][side][now[side] as usize];
                // Within the travel of a step.
                assert!((distance - place).abs() < 1.5 * way.abs() + 1e-5, "switch {side} turns at {distance} m");
                turns.push((side, now[side]));
            }
        }
        before = now;
    }
    assert!(turns.starts_with(&[(1, 1.0), (1, 0.0), (0, 1.0), (0, 0.0), (1, 1.0)]), "{turns:?}");
}

/// A carriage that starts within a distance has its switch on; one without a distance has none.
#[test]
fn switch_is_on_from_the_start() {
    let mut running =
        Rig::cylinder("Stribeck").set("sensor.endDistance[1]", 0.02).set("position0", 0.01).start().unwrap();
    assert_eq!(["sensor.end[1]", "sensor.end[2]"].map(|name| running.get(name)), [1.0, 0.0]);
}

#[test]
fn switch_beyond_the_stroke_is_refused_by_name() {
    let error = Rig::cylinder("Stribeck").set("sensor.endDistance[2]", 0.6).start().err().unwrap();
    assert_eq!(error.to_string(), "sensor.endDistance[2] = 0.6 is refused: it must not exceed cylinder.stroke = 0.5");
}
