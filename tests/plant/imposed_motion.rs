//! A carriage that a multibody tool moves: what the chambers do, which force comes out, and how position and velocity go together.

use std::f64::consts::{PI, TAU};

use crate::bounds::{close, within};
use crate::rig::{Rig, Running};

const AREA_A: f64 = PI * 0.016 * 0.016 / 4.0;
const AREA_B: f64 = AREA_A - PI * 0.006 * 0.006 / 4.0;
const AMBIENT: f64 = 101_325.0;

fn imposed(law: &str) -> Rig {
    Rig::cylinder(law).choose("motion", "Imposed")
}

/// A cylinder whose valve is closed and tight.
fn tight(law: &str) -> Rig {
    let rig = imposed(law).set("valve.leakage", 0.0).set("chamberA.pressure0", 4e5).set("chamberB.pressure0", 5e5);
    rig.set("solver.relativeTolerance", 1e-9)
}

/// A slow and a fast sine: position in m, velocity in m/s and acceleration in m/s2.
fn course(time: f64) -> [f64; 3] {
    let sine = |amplitude: f64, frequency: f64| {
        let (rate, phase) = (TAU * frequency, TAU * frequency * time);
        [phase.sin(), rate * phase.cos(), -rate * rate * phase.sin()].map(|value| amplitude * value)
    };
    let (slow, fast) = (sine(0.1, 1.0), sine(0.004, 7.0));
    [0.25 + slow[0] + fast[0], slow[1] + fast[1], slow[2] + fast[2]]
}

/// Goes a step, with position and velocity as at its beginning.
fn go(running: &mut Running, step: f64, index: u32) {
    let [position, velocity, acceleration] = course(f64::from(index) * step);
    running.set("imposedPosition", position);
    running.ramp("imposedVelocity", velocity, acceleration);
    running.advance(f64::from(index + 1) * step).unwrap();
}

/// In a tight chamber `p*V^n` is constant, with n = 1.4 without heat, or n = 1.
#[test]
fn force_of_tight_chambers_is_that_of_the_compressed_gas_and_friction() {
    for (thermal, exponent) in [("EnergyBalance", 1.4), ("Isothermal", 1.0)] {
        let rig = tight("Coulomb").choose("thermal.model", thermal).set("thermal.heatTransfer", 0.0);
        let rig = rig.set("friction.coulomb.Fc", 9.0).set("friction.coulomb.sigma2", 20.0).set("imposedVelocity", 0.2);
        let mut running =
            rig.set("load.stiffness", 300.0).set("wireForce", 3.0).set("externalForce", 50.0).start().unwrap();
        for index in 0..1500 {
            go(&mut running, 1e-3, index);
            let [x, v] = ["position", "velocity"].map(|name| running.get(name));
            let pressure = |start: f64, area: f64, length: f64| {
                start * ((5e-6 + area * 0.25) / (5e-6 + area * length)).powf(exponent)
            };
            let (a, b) = (pressure(4e5, AREA_A, x), pressure(5e5, AREA_B, 0.5 - x));
            close(running.get("chamberA.pressure"), a, 1e-7 * a, format_args!("Pa at {x} m"));
            close(running.get("chamberB.pressure"), b, 1e-7 * b, format_args!("Pa at {x} m"));
            let friction = 9.0 * v.signum() + 20.0 * v;
            close(running.get("frictionForce"), friction, 1e-12, "N");
            let gas = a * AREA_A - b * AREA_B - AMBIENT * (AREA_A - AREA_B);
            close(running.get("rodForce"), gas - 300.0 * x - 3.0 - friction, 2e-5, format_args!("N at {x} m"));
        }
    }
}

/// Held, a position and its velocity are right at the beginning of each step: at the end half the acceleration times the square of
/// the step is missing, and never more. With the derivative of the velocity a sixth of the jerk times the cube is, and positions alone
/// are met one step later.
#[test]
fn position_does_not_drift_from_the_imposed_one() {
    let step = 1e-3;
    let most =
        |derivative: f64| (0..4000).map(|i| course(f64::from(i) * step)[2].abs()).fold(0.0, f64::max) * derivative;
    let jerk = TAU.powi(3) * (0.1 + 0.004 * 343.0);
    for (way, bound) in [("held", most(0.5 * step * step)), ("ramped", jerk * step.powi(3) / 6.0), ("samples", 1e-12)] {
        let mut running = imposed("LuGre").start().unwrap();
        let mut worst = 0.0f64;
        for index in 0..4000 {
            let [position, velocity, _] = course(f64::from(index) * step);
            let expected = match way {
                "held" => {
                    running.set("imposedPosition", position);
                    running.set("imposedVelocity", velocity);
                    running.advance(f64::from(index + 1) * step).unwrap();
                    course(f64::from(index + 1) * step)[0]
                }
                "ramped" => {
                    go(&mut running, step, index);
                    course(f64::from(index + 1) * step)[0]
                }
                _ => {
                    running.set("imposedPosition", position);
                    running.advance(f64::from(index + 1) * step).unwrap();
                    position
                }
            };
            worst = worst.max((running.get("position") - expected).abs());
        }
        within(worst, 1.001 * bound, format_args!("m, {way}"));
        assert!(way == "samples" || worst > 0.9 * bound, "{worst} m, {way}: the bound is met");
    }
}

/// A position with a derivative is met at each instant, under any given velocity, and from any position of the carriage.
#[test]
fn position_with_a_derivative_leads() {
    let mut running = imposed("Stribeck").set("imposedPosition", 0.2).start().unwrap();
    assert_eq!(running.get("position"), 0.2, "position0 does not count");
    for (index, slope) in [0.5, -0.3, 0.1, 0.0].into_iter().enumerate() {
        let begin = 0.2 + 0.01 * index as f64;
        running.ramp("imposedPosition", begin, slope);
        running.advance(0.01 * (index + 1) as f64).unwrap();
        close(running.get("position"), begin + 0.01 * slope, 1e-14, "m");
    }
    running.set("imposedPosition", 0.23);
    running.advance(0.05).unwrap();
    running.advance(0.06).unwrap();
    assert_eq!([running.get("velocity"), running.get("sticking")], [0.0, 1.0], "a held position is rest");
}

/// A run under forces, given to a second cylinder as a motion: the same pressures, and the force that the mass has taken.
#[test]
fn imposed_motion_of_a_free_run_has_its_pressures_and_the_force_of_its_mass() {
    const STEP: f64 = 1e-4;
    for (law, bound) in [("None", 2e-2), ("LuGre", 0.3)] {
        let rig = Rig::cylinder(law).set("valveVoltage", 7.0).set("supplyPressure", 6e5).set("balance.enabled", 1.0);
        let mut free = rig.clone().start().unwrap();
        let mut led = rig.choose("motion", "Imposed").start().unwrap();
        for index in 0..3000 {
            let voltage = 5.0 + 2.0 * (TAU * 3.0 * f64::from(index) * STEP).cos();
            let end = f64::from(index + 1) * STEP;
            let [position, velocity] = ["position", "velocity"].map(|name| free.get(name));
            free.set("valveVoltage", voltage);
            free.advance(end).unwrap();
            led.set("valveVoltage", voltage);
            let slopes = [free.get("position") - position, free.get("velocity") - velocity].map(|change| change / STEP);
            led.ramp_all(&[("imposedPosition", position, slopes[0]), ("imposedVelocity", velocity, slopes[1])]);
            led.advance(end).unwrap();
            close(led.get("velocity"), free.get("velocity"), 3e-4, format_args!("m/s at {end} s under {law}"));
            for chamber in ["chamberA.pressure", "chamberB.pressure"] {
                close(led.get(chamber), free.get(chamber), 5.0, format_args!("Pa, {chamber} at {end} s under {law}"));
            }
            let force = 0.88 * free.get("acceleration");
            close(led.get("rodForce"), force, bound, format_args!("N at {end} s under {law}"));
            within(led.get("balance.massResidual").abs(), 1e-9, "kg");
            within(led.get("balance.energyResidual").abs(), 1e-4, "J");
        }
    }
}

/// At rest the contact holds what the cylinder and the tool push with, up to break-away, which differs by direction; sliding it has
/// one force.
#[test]
fn friction_at_rest_answers_the_force_within_its_limits() {
    for law in ["CoulombStiction", "Stribeck", "Karnopp", "Polito"] {
        let rig = imposed(law).set("friction.direction.factor", 1.5);
        let most = if law == "Polito" { 10.8 } else { 11.0 };
        let mut running = rig.start().unwrap();
        for (force, friction) in [(5.0, 5.0), (-5.0, -5.0), (30.0, 1.5 * most), (-30.0, -most)] {
            running.set("externalForce", force);
            close(running.get("frictionForce"), friction, 1e-9, format_args!("N under {law} and {force} N"));
            close(running.get("rodForce"), -friction, 1e-9, format_args!("N under {law} and {force} N"));
            let limits = ["frictionForceLimit.low", "frictionForceLimit.high"].map(|name| running.get(name));
            assert_eq!(limits, [-most, 1.5 * most], "{law}");
        }
        running.set("imposedVelocity", 0.1);
        running.advance(0.01).unwrap();
        let now = ["frictionForce", "frictionForceLimit.low", "frictionForceLimit.high"].map(|name| running.get(name));
        assert!(now[0] > 5.0 && now == [now[0]; 3], "{law}: {now:?}");
    }
}

/// A tool holds still while chamber A vents, and the load level falls with its pressure below the force that the contact holds.
/// Every law gives a force for that, and springs no larger one than the level leaves.
#[test]
fn contact_at_rest_gives_way_to_a_load_level_that_falls() {
    for (_, law, _) in pneumatic_servo::friction::LAWS.items {
        for (kappa, direction) in [(1e-6, 1.0), (5e-6, 1.0), (5e-6, -1.0)] {
            let rig = imposed(law).set("friction.kappaA", kappa).set("valveVoltage", 9.0);
            let mut running =
                rig.set("imposedPosition", 0.25).set("imposedVelocity", 0.05 * direction).start().unwrap();
            running.advance(0.2).unwrap_or_else(|error| panic!("{law}: {error}"));
            running.set("imposedPosition", 0.25 + 0.01 * direction);
            running.set("imposedVelocity", 0.0);
            running.set("valveVoltage", 1.0);
            running.advance(0.201).unwrap();
            let (level, events) = (running.get("friction.level"), running.get("solver.events"));
            for step in 1..500 {
                let end = 0.201 + 2e-3 * f64::from(step);
                running.advance(end).unwrap_or_else(|error| panic!("{law} at {end} s with {kappa}: {error}"));
                if matches!(*law, "Armstrong" | "StickSlipSpring") {
                    let limit = 11.0 * running.get("friction.level");
                    let force = direction * running.get("frictionForce");
                    assert!((-1e-9..=limit + 1e-9).contains(&force), "{law} at {end} s: {force} N, of {limit} N");
                }
            }
            assert!(running.get("friction.level") < 0.8 * level, "{law}: the level falls");
            if matches!(*law, "Armstrong" | "StickSlipSpring") {
                let since = running.get("solver.events") - events;
                assert!(since < 3.0, "{law}: {since} events at rest");
            }
        }
    }
}

/// Mass, weight, start values and the other inputs of a free carriage do not count.
#[test]
fn mass_of_an_imposed_motion_is_that_of_the_tool() {
    let force = |rig: Rig| {
        let mut running = rig.start().unwrap();
        (0..50).for_each(|index| go(&mut running, 1e-3, index));
        running.get("rodForce").to_bits()
    };
    let plain = force(imposed("LuGre"));
    let others =
        [("mass.moving", 5.0), ("incline", 1.0), ("position0", 0.1), ("velocity0", 1.0), ("mass.carriage", 0.0)];
    for (name, value) in others {
        assert_eq!(force(imposed("LuGre").set(name, value)), plain, "{name}");
    }
}

/// A mass on a spring whose far end begins to move at a constant velocity: `x = x0 + v*t - v/w*sin(w*t)`, and with a damping ratio
/// of 1 beside it `v - dx/dt = v*exp(-w*t)*(1 - w*t)`.
#[test]
fn coupling_is_a_spring_with_a_damper() {
    const STIFFNESS: f64 = 2e5;
    let natural = (STIFFNESS / 0.88f64).sqrt();
    for damping in [0.0, 2.0 * 0.88 * natural] {
        let rig = imposed("None").set("chamberA.open", 1.0).set("chamberB.open", 1.0);
        let rig = rig.set("coupling.compliance", 1.0 / STIFFNESS).set("coupling.damping", damping);
        let mut running = rig.set("solver.relativeTolerance", 1e-9).start().unwrap();
        running.set("imposedVelocity", 0.2);
        for index in 0..100 {
            // The velocity alone could not tell where the far end is.
            running.set("imposedPosition", 0.25 + 0.2 * 1e-3 * f64::from(index));
            let time = 1e-3 * f64::from(index + 1);
            running.advance(time).unwrap();
            let phase = natural * time;
            let (behind, slower) = if damping == 0.0 {
                (0.2 / natural * phase.sin(), 0.2 * phase.cos())
            } else {
                (0.2 * time * (-phase).exp(), 0.2 * (1.0 - phase) * (-phase).exp())
            };
            close(running.get("position"), 0.25 + 0.2 * time - behind, 1e-9, format_args!("m at {time} s"));
            let force = -STIFFNESS * behind - damping * slower;
            close(running.get("rodForce"), force, 2e-4, format_args!("N at {time} s"));
        }
    }
}

/// A coupling is relaxed at the start: the carriage is where the imposed motion is, and moves with it.
#[test]
fn coupled_carriage_starts_where_the_motion_is() {
    let rig = imposed("Stribeck").set("coupling.compliance", 1e-6).set("coupling.damping", 500.0);
    let mut running = rig.set("imposedPosition", 0.35).set("imposedVelocity", 0.1).start().unwrap();
    assert_eq!(["position", "velocity", "rodForce"].map(|name| running.get(name)), [0.35, 0.1, 0.0]);
    running.set("imposedPosition", 0.35);
    running.advance(1e-3).unwrap();
    assert!(running.get("rodForce").abs() < 200.0, "{} N", running.get("rodForce"));
}

/// Under a set-valued law a carriage at rest holds a coupling exactly, until it breaks away.
#[test]
fn coupled_carriage_sticks_until_the_spring_pulls_it_off() {
    let rig = imposed("CoulombStiction").set("coupling.compliance", 1e-4);
    let mut running = rig.start().unwrap();
    for index in 0..20 {
        let stretch = 1e-4 * f64::from(index);
        running.set("imposedPosition", 0.25 + stretch);
        running.advance(1e-3 * f64::from(index + 1)).unwrap();
        if stretch < 10.9e-4 {
            assert_eq!([running.get("position"), running.get("sticking")], [0.25, 1.0], "{stretch} m");
            close(running.get("rodForce"), -1e4 * stretch, 1e-9, "N");
        }
    }
    assert!(running.get("position") > 0.25, "it has broken away");
}

#[test]
fn couplings_and_motions_without_a_meaning_are_refused() {
    let refused = |rig: Rig| rig.start().err().expect("refused").to_string();
    let free = Rig::cylinder("None").set("coupling.compliance", 1e-6);
    let text = refused(free);
    assert!(text.contains("coupling.compliance") && text.contains("it needs a motion"), "{text}");
    let undamped = imposed("None").set("coupling.damping", 10.0);
    let text = refused(undamped);
    assert!(text.contains("coupling.damping") && text.contains("it needs a spring"), "{text}");
    let mut running = imposed("None").start().unwrap();
    running.set("imposedPosition", -0.1);
    let error = running.advance(1e-3).expect_err("no volume").to_string();
    assert!(error.contains("chamberA.pressure"), "{error}");
    for (position, stroke, chamber) in [(0.9, 0.5, "chamber B"), (0.25, 0.15, "chamber B"), (-0.1, 0.5, "chamber A")] {
        let rig = imposed("None").set("imposedPosition", position).set("cylinder.stroke", stroke);
        let error = rig.set("position0", 0.1).start().err().expect("no volume at the start");
        assert_eq!((error.variable.as_str(), error.value), ("imposedPosition", position));
        assert!(error.reason.contains(chamber), "{error}");
    }
}
