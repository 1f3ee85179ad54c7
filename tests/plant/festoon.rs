//! The festoon: pendulums and ropes against closed forms, break-away under pulses, towing, reversal, and rest.

use std::f64::consts::TAU;

use crate::bounds::{close, larger, loosely};
use crate::rig::{Rig, Running, watch};

const GRAVITY: f64 = 9.80665;
const TROLLEY: f64 = 5.0;
const LOAD: f64 = 10.0;

fn festoon(law: &str, trolleys: u32) -> Rig {
    Rig::new("Festoon")
        .choose("friction.law", law)
        .set("trolleys", f64::from(trolleys))
        .set("solver.relativeTolerance", 1e-10)
}

/// One trolley under Coulomb friction with stiction, without viscous friction, and with next to no load.
fn block() -> Rig {
    festoon("CoulombStiction", 1).set("friction.coulombStiction.sigma2", 0.0).set("load.mass", 1e-6)
}

fn of(trolley: u32, variable: &str) -> String {
    format!("trolley[{trolley}].{variable}")
}

/// The time of the zero crossings of a load's angle, which swings from its largest value.
fn swing_period(run: &mut Running) -> f64 {
    let (mut last, mut crossings) = ((0.0, run.get("trolley[1].load.angle")), Vec::new());
    watch(run, 8.0, 1e-3, |time, run| {
        let angle = run.get("trolley[1].load.angle");
        if angle * last.1 < 0.0 {
            crossings.push(last.0 + (time - last.0) * last.1 / (last.1 - angle));
        }
        last = (time, angle);
    });
    2.0 * (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64
}

/// A held trolley does not move by a bit while its load swings with the period of a pendulum of finite amplitude.
#[test]
fn load_of_a_held_trolley_is_a_pendulum() {
    let amplitude = 0.1f64;
    for law in ["Coulomb", "CoulombStiction", "Stribeck", "Polito"] {
        let rig = festoon(law, 1).set("load.damping", 0.0).set("load.angle0", amplitude).set("friction.level[1]", 3.0);
        let mut run = rig.start().unwrap();
        let period = swing_period(&mut run);
        // The series of the complete elliptic integral, to fourth order in the amplitude.
        let expected =
            TAU * (1.0 / GRAVITY).sqrt() * (1.0 + amplitude.powi(2) / 16.0 + 11.0 * amplitude.powi(4) / 3072.0);
        close(period, expected, 2e-9, format_args!("{law}, s"));
        assert_eq!((run.get("trolley[1].position"), run.get("trolley[1].velocity")), (-0.5, 0.0), "{law}");
        assert_eq!(run.get("solver.events"), 0.0, "{law}");
        // The trolley holds the horizontal pull of the load.
        let (angle, spin) = (run.get("trolley[1].load.angle"), run.get("trolley[1].load.angularVelocity"));
        let pull = LOAD * angle.sin() * (GRAVITY * angle.cos() + spin * spin);
        close(run.get("trolley[1].frictionForce"), pull, 1e-13, law);
    }
}

/// On a trolley without friction a load swings faster, against the trolley.
#[test]
fn load_of_a_free_trolley_swings_about_the_centre_of_mass() {
    let amplitude = 1e-3;
    let mut run = festoon("None", 1).set("load.damping", 0.0).set("load.angle0", amplitude).start().unwrap();
    let expected = TAU / (GRAVITY * (1.0 + LOAD / TROLLEY)).sqrt();
    // The amplitude lengthens the period by some 1e-7 of it.
    let period = swing_period(&mut run);
    close(period, expected, 1e-6, "s");
}

fn energy(run: &mut Running, trolleys: u32) -> f64 {
    let mut energy = 0.0;
    let mut before = run.get("crane.position");
    for trolley in 1..=trolleys {
        let [x, v, angle, spin] =
            ["position", "velocity", "load.angle", "load.angularVelocity"].map(|name| run.get(&of(trolley, name)));
        let load = v * v + 2.0 * v * spin * angle.cos() + spin * spin;
        energy += 0.5 * (TROLLEY * v * v + LOAD * load) + LOAD * GRAVITY * (1.0 - angle.cos());
        energy += 0.5 * 2e3 * (before - x - 1.0).max(0.0).powi(2) + 0.5 * 2e4 * (0.2 - (before - x)).max(0.0).powi(2);
        before = x;
    }
    energy
}

/// Without friction and dissipation energy is kept, ropes and buffers and large angles included.
#[test]
fn energy_is_kept_without_friction() {
    let rig = festoon("None", 3).set("load.damping", 0.0).set("rope.damping", 0.0).set("buffer.damping", 0.0);
    let mut run = rig.set("load.angle0", 1.2).set("spacing0", 0.98).start().unwrap();
    let before = energy(&mut run, 3);
    let (mut taut, mut pressed) = (false, false);
    watch(&mut run, 10.0, 1e-2, |time, run| {
        let now = energy(run, 3);
        close(now / before, 1.0, 5e-11, format_args!("{now} of {before} J at {time} s"));
        taut |= run.get("trolley[2].towForce") > 0.0;
        pressed |= run.get("trolley[2].bufferForce") > 0.0;
    });
    assert!(taut && pressed, "ropes and buffers act");
}

/// The momentum of trolleys and loads comes from the crane alone: by Simpson's rule, whose error comes from the instants
/// at which rope and buffer of the crane begin to act.
#[test]
fn momentum_comes_from_the_crane_alone() {
    let mut run = festoon("None", 3).set("load.angle0", 0.5).set("spacing0", 0.6).start().unwrap();
    let interval = 1e-4;
    let (mut impulse, mut index, mut largest) = (run.get("crane.force"), 0, 0.0f64);
    watch(&mut run, 2.0, interval, |time, run| {
        let mut momentum = 0.0;
        for trolley in 1..=3 {
            let [v, angle, spin] =
                ["velocity", "load.angle", "load.angularVelocity"].map(|name| run.get(&of(trolley, name)));
            momentum += TROLLEY * v + LOAD * (v + spin * angle.cos());
        }
        index += 1;
        let force = run.get("crane.force");
        if index % 2 == 0 {
            let received = (impulse + force) * interval / 3.0;
            close(momentum, received, 1e-4, format_args!("at {time} s"));
        }
        impulse += force * (2.0 + 2.0 * f64::from(index % 2));
        largest = larger(largest, momentum.abs());
    });
    assert!(largest > 1.0, "the crane acts");
}

/// A pulse below the break-away force leaves the trolley where it is, bit for bit; one above it moves the trolley as far
/// as the work of the pulse reaches.
#[test]
fn pulse_breaks_the_trolley_away_above_the_static_friction() {
    let duration = 0.1;
    for pulse in [5.0, 10.999, 11.001, 15.0, 25.0] {
        let mut run = block().set("pulseForce", pulse).start().unwrap();
        run.advance(duration).unwrap();
        run.set("pulseForce", 0.0);
        run.advance(2.0).unwrap();
        let moved = run.get("trolley[1].position") + 0.5;
        let mass = TROLLEY + 1e-6;
        let speed = (pulse - 8.3) / mass * duration;
        let expected = if pulse > 11.0 { 0.5 * speed * duration + 0.5 * mass * speed * speed / 8.3 } else { 0.0 };
        // The load, a ten-millionth of the mass, swings on its own.
        close(moved, expected, 5e-13 * expected, format_args!("{pulse} N, m"));
        assert_eq!(run.get("trolley[1].sticking"), 1.0);
    }
}

/// In steady towing each rope carries the friction of all trolleys behind it, and the loads hang straight down.
#[test]
fn ropes_carry_the_friction_of_what_they_tow() {
    let mut run = festoon("Coulomb", 3).set("craneVelocity", 0.2).start().unwrap();
    // Elastic ropes and loads calm down within minutes.
    run.advance(400.0).unwrap();
    let each = 8.3 + 30.0 * 0.2;
    for trolley in 1..=3 {
        let tow = run.get(&of(trolley, "towForce"));
        let expected = f64::from(4 - trolley) * each;
        close(tow, expected, 2e-10, "N");
        close(run.get(&of(trolley, "velocity")), 0.2, 5e-13, "ropes carry the friction of what they tow");
        assert!(run.get(&of(trolley, "load.angle")).abs() < 1e-8);
    }
    close(run.get("crane.force"), 3.0 * each, 2e-10, "ropes carry the friction of what they tow");
}

/// Slow towing through the elastic rope: the trolley waits until the rope pulls with the break-away force, slips, and
/// waits again. A slip reaches as far as the spring of the rope drives the mass: 2*(F_s - F_c)/k, at a slow pull.
#[test]
fn slow_towing_is_stick_slip() {
    let (speed, stiffness) = (1e-3, 2e3f64);
    let rig = block().set("rope.damping", 0.0).set("spacing0", 0.999).set("craneVelocity", speed);
    let mut run = rig.start().unwrap();
    let (mut was_sticking, mut changes) = (true, Vec::new());
    watch(&mut run, 20.0, 1e-3, |time, run| {
        if (run.get("trolley[1].sticking") == 1.0) != was_sticking {
            was_sticking = !was_sticking;
            changes.push((time, run.get("trolley[1].position")));
        }
    });
    // The rope tautens 1 mm, and pulls with 11 N 5.5 mm, after the start.
    let break_away = (1e-3 + 11.0 / stiffness) / speed;
    loosely((changes[0].0 - break_away).abs(), 1.01e-3, "looked at each millisecond", "s");
    assert!(changes.len() >= 8, "{changes:?}");
    // The closed form of the pulled mass: the drive moves on during the slip.
    let (mass, e0) = (TROLLEY + 1e-6, (11.0 - 8.3) / stiffness);
    let w = (stiffness / mass).sqrt();
    let slip_time = 2.0 / w * (std::f64::consts::PI - (e0 * w / speed).atan());
    for slip in changes.chunks_exact(2) {
        let [(start, from), (end, to)] = slip else { unreachable!() };
        close(end - start, slip_time, 2.01e-3, format_args!("{} s, not {slip_time} s", end - start));
        // Sampled up to a millisecond after break-away, when the trolley has hardly moved.
        let expected = 2.0 * e0 + speed * slip_time;
        close(to - from, expected, 1e-6, format_args!("{} m, not {expected} m", to - from));
    }
}

/// Pulled, left, and pushed back: the friction force changes its sign with the direction, under every law.
#[test]
fn friction_changes_sign_on_reversal_under_every_law() {
    for (_, law, _) in pneumatic_servo::friction::LAWS.items.iter().filter(|(_, law, _)| *law != "None") {
        let mut run = festoon(law, 3)
            .set("solver.relativeTolerance", 1e-6)
            .set("spacing0", 0.9)
            .set("craneVelocity", 0.3)
            .start()
            .unwrap();
        let towed = |run: &mut Running| {
            (1..=3).map(|trolley| (run.get(&of(trolley, "velocity")), run.get(&of(trolley, "frictionForce")))).collect()
        };
        run.advance(6.0).unwrap();
        let forward: Vec<(f64, f64)> = towed(&mut run);
        run.set("craneVelocity", -0.3);
        run.advance(17.0).unwrap();
        let back: Vec<(f64, f64)> = towed(&mut run);
        for ((v, f), (w, g)) in forward.into_iter().zip(back) {
            assert!(v > 0.1 && f > 5.0, "{law}: {f} N at {v} m/s");
            assert!(w < -0.1 && g < -5.0, "{law}: {g} N at {w} m/s");
        }
    }
}

/// Ropes never push, buffers never pull, and they never act at the same time.
#[test]
fn links_act_in_one_sense() {
    let mut run = festoon("Stribeck", 3).set("craneVelocity", 0.4).start().unwrap();
    watch(&mut run, 20.0, 1e-2, |time, run| {
        run.set("craneVelocity", 0.4 * (TAU * time / 10.0).cos());
        for trolley in 1..=3 {
            let (tow, buffer) = (run.get(&of(trolley, "towForce")), run.get(&of(trolley, "bufferForce")));
            assert!(tow >= 0.0 && buffer >= 0.0 && tow * buffer == 0.0, "{tow} and {buffer} N at {time} s");
        }
    });
}

/// A rope left under a tension of 8 N between crane and trolley: set-valued laws hold it for a minute without moving by
/// a bit, regularised ones give way.
#[test]
fn set_valued_laws_hold_a_taut_rope_where_regularised_ones_creep() {
    let creep = |law: &str| {
        let rig =
            festoon(law, 1).set("solver.relativeTolerance", 1e-6).set("craneVelocity", 0.002).set("spacing0", 1.0);
        let mut run = rig.start().unwrap();
        run.advance(2.0).unwrap();
        run.set("craneVelocity", 0.0);
        let before = run.get("trolley[1].position");
        run.advance(62.0).unwrap();
        (run.get("trolley[1].position") - before).abs()
    };
    for law in ["Coulomb", "CoulombStiction", "Stribeck", "Karnopp", "Polito"] {
        assert_eq!(creep(law), 0.0, "{law}");
    }
    for law in ["SmoothCoulomb", "StribeckRegularised", "VelocityBased", "StepRegularised", "SineRegularised"] {
        assert!(creep(law) > 1e-5, "{law}: {} m", creep(law));
    }
}

/// A trolley that the crane never reaches does not change what the one before it does.
#[test]
fn trolleys_at_rest_do_not_disturb_the_first() {
    let position = |trolleys: u32| {
        let mut run = festoon("Stribeck", trolleys).set("craneVelocity", 0.2).set("load.angle0", 0.05).start().unwrap();
        run.advance(4.5).unwrap();
        run.get("trolley[1].position")
    };
    let (alone, first) = (position(1), position(3));
    assert!(alone > -0.45, "{alone} m: it moves");
    // The steps differ, since the loads behind swing.
    close(alone, first, 5e-14, "m");
}

#[test]
fn absent_trolleys_show_zeros() {
    let mut run = festoon("LuGre", 1).set("craneVelocity", 0.2).start().unwrap();
    run.advance(4.0).unwrap();
    for name in ["position", "velocity", "frictionForce", "sticking", "load.angle", "friction.deflection"] {
        assert_eq!(run.get(&of(2, name)).to_bits(), 0, "{name}");
    }
    assert!(run.get("trolley[1].friction.deflection") > 0.0);
}

#[test]
fn buffer_longer_than_the_rope_is_refused() {
    let error = Rig::new("Festoon").set("buffer.length", 1.5).start().err().expect("a refusal");
    assert_eq!((error.variable.as_str(), error.value), ("buffer.length", 1.5));
}
