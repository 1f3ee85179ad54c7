//! Published and closed-form numbers of friction laws on the bench.

use std::f64::consts::{PI, TAU};

use crate::bounds::{close, larger, loosely, within};
use crate::rig::{Rig, Running, watch};

/// The closed form of stick-slip with constant kinetic friction. Times are sampled every 0.1 ms; amplitudes are exact
/// but for the tolerance of 1e-10, lengths but for a sample too (v_max is flat there).
#[test]
fn coulomb_with_stiction_sticks_and_slips_as_the_closed_form_says() {
    let (stiffness, speed, statics, kinetic) = (2.0f64, 0.1f64, 1.5, 1.0);
    let (e0, w) = ((statics - kinetic) / stiffness, stiffness.sqrt());
    let slip_time = 2.0 / w * (PI - (e0 * w / speed).atan());
    let stick_time = 2.0 * e0 / speed;
    let fastest = speed + speed.hypot(e0 * w);

    let mut run = Rig::bench("CoulombStiction", "SpringPull")
        .set("friction.coulombStiction.Fs", statics)
        .set("friction.coulombStiction.Fc", kinetic)
        .set("friction.coulombStiction.sigma2", 0.0)
        .set("solver.relativeTolerance", 1e-10)
        .start()
        .unwrap();
    let (mut was_sticking, mut top) = (true, 0.0f64);
    let mut changes = Vec::new();
    watch(&mut run, 40.0, 1e-4, |time, run| {
        top = larger(top, run.get("velocity"));
        let is_sticking = run.get("sticking") == 1.0;
        if is_sticking != was_sticking {
            changes.push((time, run.get("position")));
            was_sticking = is_sticking;
        }
    });

    close(changes[0].0, statics / stiffness / speed, 1.01e-4, format_args!("{changes:?}"));
    for cycle in changes.chunks_exact(2).skip(1) {
        let [(slip, from), (stick, to)] = cycle else { unreachable!() };
        close(stick - slip, slip_time, 2.01e-4, format_args!("slips for {} s, not {slip_time} s", stick - slip));
        close(to - from, (stick_time + slip_time) * speed, 1e-8, format_args!("steps of {} m", to - from));
    }
    for pause in changes[1..].chunks_exact(2) {
        loosely(
            (pause[1].0 - pause[0].0 - stick_time).abs(),
            2.01e-4,
            "looked at each 0.1 ms",
            format_args!("{pause:?}"),
        );
    }
    assert!(changes.len() >= 8);
    close(top, fastest, 1e-10, "v_max");
}

/// The parameters of Canudas de Wit et al. (1995).
fn lugre_1995(drive: &str) -> Rig {
    let values = [
        ("sigma0", 1e5),
        ("sigma1", 1e5f64.sqrt()),
        ("sigma2", 0.4),
        ("vd", 1e3),
        ("Fc", 1.0),
        ("Fs", 1.5),
        ("vs", 1e-3),
    ];
    let rig = Rig::bench("LuGre", drive).set("driveVelocity", 0.1).set("solver.relativeTolerance", 1e-8);
    values.into_iter().fold(rig, |rig, (name, value)| rig.set(&format!("friction.lugre.{name}"), value))
}

/// Reference values have four digits.
#[test]
fn lugre_sticks_and_slips_as_published_in_1995() {
    let mut run = lugre_1995("SpringPull").start().unwrap();
    let (mut fastest, mut peak) = (0.0f64, 0.0f64);
    let mut starts = Vec::new();
    let mut last = 0.0;
    watch(&mut run, 50.0, 1e-4, |time, run| {
        let (v, f) = (run.get("velocity"), run.get("frictionForce"));
        (fastest, peak) = (larger(fastest, v), larger(peak, f));
        if last < 0.01 && v >= 0.01 {
            starts.push((time, run.get("position")));
        }
        last = v;
    });
    close(starts[0].0, 7.5, 0.1, format_args!("first slip at {} s", starts[0].0));
    let [.., before, after] = starts.as_slice() else { panic!("too few slips") };
    close(after.0 - before.0, 6.363, 1e-3, format_args!("period {}", after.0 - before.0));
    close(after.1 - before.1, 0.6363, 1e-4, format_args!("step {}", after.1 - before.1));
    close(fastest, 0.3698, 1e-4, "v_max");
    close(peak, 1.4766, 1e-4, "peak");
}

/// Reference values have four digits.
#[test]
fn lugre_breaks_away_at_lower_forces_under_faster_loading() {
    for (rate, expected) in [(1.0, 1.432), (2.0, 1.394), (5.0, 1.313), (10.0, 1.220), (20.0, 1.099)] {
        let mut run = lugre_1995("Free").start().unwrap();
        run.ramp("appliedForce", 0.0, rate);
        let (mut peak, mut is_over) = (0.0, false);
        watch(&mut run, 2.0 / rate, 1e-4 / rate, |_, run| {
            let force = run.get("frictionForce");
            is_over |= force < peak;
            peak = if is_over { peak } else { force };
        });
        assert!(is_over, "{peak} N at {rate} N/s");
        close(peak, expected, 6e-4, format_args!("N at {rate} N/s"));
    }
}

/// Moves the applied force smoothly to a value within a time.
fn load(run: &mut Running, from: f64, to: f64, duration: f64) {
    let start = run.simulation().time();
    let steps = 1000;
    let force = |step: i32| from + (to - from) * 0.5 * (1.0 - (PI * f64::from(step) / f64::from(steps)).cos());
    let interval = duration / f64::from(steps);
    for step in 0..steps {
        run.ramp("appliedForce", force(step), (force(step + 1) - force(step)) / interval);
        run.advance(start + f64::from(step + 1) * interval).expect("a step that ends");
    }
    run.set("appliedForce", to);
}

/// Loading in 20 s is quasi-static to 0.01 um; the reference values have that resolution.
#[test]
fn lugre_presliding_is_that_of_1995() {
    let mut run = lugre_1995("Free").start().unwrap();
    let mut from = 0.0;
    for (to, micrometres) in [(1.425, 44.94), (-1.425, -10.02), (1.425, 44.94)] {
        load(&mut run, from, to, 20.0);
        from = to;
        let position = run.get("position") * 1e6;
        close(position, micrometres, 0.02, format_args!("um at {to} N"));
    }
}

/// Drift of the position per cycle of the applied force between two levels, after a few cycles.
fn drift(rig: &Rig, low: f64, high: f64) -> f64 {
    let mut run = rig.clone().set("solver.relativeTolerance", 1e-9).start().unwrap();
    load(&mut run, 0.0, high, 10.0);
    let mut positions = Vec::new();
    for _ in 0..3 {
        load(&mut run, high, low, 10.0);
        load(&mut run, low, high, 10.0);
        positions.push(run.get("position"));
    }
    positions[2] - positions[1]
}

/// Quasi-static to 1e-3 of the drift, with cycles of 20 s.
#[test]
fn dahl_and_lugre_drift_by_the_logarithm() {
    let expected = 1.5e-5 * ((1.0f64 - 0.01) / (1.0 - 0.81)).ln();
    close(expected, 24.76e-6, 1e-9, "dahl and lugre drift by the logarithm");
    let lugre = drift(&lugre_1995("Free"), 0.15, 1.35);
    close(lugre, expected, 5e-4 * expected, "LuGre drifts, m");
    let dahl = Rig::bench("Dahl", "Free")
        .set("friction.dahl.Fc", 1.5)
        .set("friction.dahl.sigma0", 1e5)
        .set("friction.dahl.sigma2", 100.0);
    let dahl = drift(&dahl, 0.15, 1.35);
    close(dahl, expected, 5e-5 * expected, "Dahl drifts, m");
}

/// The cycle swings by 8 um. The stiff elements are slightly damped; what remains is the tolerance.
#[test]
fn maxwell_slip_does_not_drift() {
    let maxwell = drift(&Rig::bench("MaxwellSlip", "Free").set("friction.maxwellSlip.sigma2", 300.0), 0.8, 7.2);
    within(maxwell.abs(), 2e-12, "m");
}

/// In the Leuven law the hysteresis force does not drift over `z`, but `x` moves by `dz/(1 -+ (F/s)^n)`. The loop is
/// integrated here by the midpoint rule; an abrupt transition (`n = 10`) drifts little below 0.7 F_s.
#[test]
fn leuven_drifts_only_by_its_transition_to_sliding() {
    let leuven = |n: f64| Rig::bench("Leuven", "Free").set("friction.leuven.n", n).set("friction.leuven.sigma2", 300.0);
    let virgin = |z: f64| 1.483e6 * z + 5.595 * (1.0 - (-5.631e5 * z).exp());
    let (low, high, statics) = (1.1, 7.7, 11.0);
    // Half the width of the loop: 2*y(width/2) = high - low.
    let (mut a, mut b) = (0.0, 1e-5);
    for _ in 0..200 {
        let middle = 0.5 * (a + b);
        if virgin(middle) < 0.5 * (high - low) { a = middle } else { b = middle }
    }
    let width = 2.0 * a;
    let steps = 100_000;
    for n in [1.0, 3.0] {
        let mut expected = 0.0;
        for step in 0..steps {
            let z = width * (f64::from(step) + 0.5) / f64::from(steps);
            let loading = (low + 2.0 * virgin(0.5 * z)) / statics;
            let unloading = (high - 2.0 * virgin(0.5 * z)) / statics;
            expected += 1.0 / (1.0 - loading.powf(n)) - 1.0 / (1.0 + unloading.powf(n));
        }
        expected *= width / f64::from(steps);
        let found = drift(&leuven(n), low, high);
        close(found, expected, 5e-6 * expected, format_args!("n = {n}, m"));
    }
    let abrupt = drift(&leuven(10.0), low, high);
    within(abrupt.abs(), 0.02 * width, format_args!("m of {width} m"));
}

/// Friction force while the mass moves along a path in micrometres, at the end of each leg.
fn along(rig: &Rig, path: &[f64]) -> Vec<f64> {
    let mut run = rig.start().unwrap();
    let mut time = 0.0;
    let mut forces = Vec::new();
    for leg in path.windows(2) {
        let duration = (leg[1] - leg[0]).abs();
        run.set("driveVelocity", 1e-6 * (leg[1] - leg[0]).signum());
        time += duration;
        run.advance(time).expect("a step that ends");
        forces.push(run.get("frictionForce"));
    }
    forces
}

/// The hysteresis of the Leuven law alone: its friction level is out of reach, so that `z` is `x`.
fn leuven_hysteresis() -> Rig {
    Rig::bench("Leuven", "PrescribedMotion")
        .set("friction.leuven.Fs", 1e6)
        .set("friction.leuven.Fc", 1e6)
        .set("friction.leuven.sigma2", 0.0)
        .set("friction.leuven.n", 10.0)
        .set("solver.relativeTolerance", 1e-10)
}

/// The published values have three or four decimals.
#[test]
fn leuven_virgin_curve_and_nested_path_are_those_of_the_thesis() {
    let virgin = along(&leuven_hysteresis(), &[0.0, 1.0, 2.0, 5.0, 10.0]);
    for (found, expected) in virgin.iter().zip([3.892, 6.747, 12.675, 20.405]) {
        close(*found, expected, 6e-4, "N");
    }
    let nested = along(&leuven_hysteresis(), &[0.0, 4.0, 1.0, 3.0, 1.0, 4.0, -4.0]);
    for (found, expected) in nested.iter().zip([10.9387, 0.1081, 7.8921, 0.1081, 10.9387, -10.9387]) {
        close(*found, expected, 6e-5, format_args!("N, {nested:?}"));
    }
}

/// The reference is Preisach's view of the same loops: each element is a play operator, followed point by point. The
/// position is exact, so forces agree to rounding.
#[test]
fn maxwell_slip_remembers_nested_loops() {
    let path = [0.0, 20.0, -3.0, 4.0, -1.0, 2.0, -1.0, 4.0, -3.0, 20.0, -20.0, 0.0];
    let rig = Rig::bench("MaxwellSlip", "PrescribedMotion").set("friction.maxwellSlip.sigma2", 0.0);
    let mut forces = [0.0f64; 4];
    for (found, leg) in along(&rig, &path).into_iter().zip(path.windows(2)) {
        let mut expected = 0.0;
        for (force, stiffness) in forces.iter_mut().zip([8e5, 4e5, 2e5, 1e5]) {
            *force = (*force + stiffness * 1e-6 * (leg[1] - leg[0])).clamp(-2.075, 2.075);
            expected += *force;
        }
        close(found, expected, 2e-11, format_args!("N after {leg:?}"));
    }
}

/// With a flat Stribeck curve and fast attraction the elements of the GMS law are Maxwell-slip elements. They
/// approach the limit within `s/C`, so the forces agree to `k*v*s/C` of about 1e-6 N per element.
#[test]
fn gms_with_a_flat_curve_is_maxwell_slip() {
    let path = [0.0, 20.0, -3.0, 4.0, -1.0, 2.0, -1.0, 4.0, -3.0, 20.0, -20.0, 0.0];
    let mut gms = Rig::bench("GMS", "PrescribedMotion")
        .set("friction.gms.Fs", 8.3)
        .set("friction.gms.C", 1e7)
        .set("friction.gms.sigma2", 0.0)
        .set("solver.relativeTolerance", 1e-10);
    for (index, stiffness) in [8e5, 4e5, 2e5, 1e5].into_iter().enumerate() {
        gms = gms.set(&format!("friction.gms.k[{}]", index + 1), stiffness);
    }
    let maxwell = Rig::bench("MaxwellSlip", "PrescribedMotion").set("friction.maxwellSlip.sigma2", 0.0);
    for (a, b) in along(&gms, &path).into_iter().zip(along(&maxwell, &path)) {
        close(a, b, 5e-11, "N");
    }
}

/// Velocity steps down in the Stribeck range: the slipping force approaches the new level like `exp(-C*t/s)`.
#[test]
fn gms_lags_behind_the_stribeck_curve_exponentially() {
    let mut run = Rig::bench("GMS", "PrescribedMotion")
        .set("friction.gms.sigma2", 0.0)
        .set("solver.relativeTolerance", 1e-10)
        .set("driveVelocity", 0.05)
        .start()
        .unwrap();
    run.advance(1.0).unwrap();
    let level = |v: f64| 8.3 + 2.7 * (-(v / 0.01f64).powi(2)).exp();
    run.set("driveVelocity", 0.005);
    for step in 1..20 {
        let time = f64::from(step) * 5e-3;
        run.advance(1.0 + time).unwrap();
        let (from, to) = (level(0.05), level(0.005));
        // The four elements have a quarter of the level each and 500 N/s each.
        let expected = to + (from - to) * (-500.0 * time / to).exp();
        let found = run.get("frictionForce");
        close(found, expected, 2e-9, format_args!("N after {time} s"));
    }
}

/// Where the friction level is 0, there is no dry friction and no bristle.
#[test]
fn bristle_laws_without_a_level_are_viscous() {
    let laws: [(&str, f64, &[&str]); 5] = [
        ("Dahl", 0.0, &["dahl.Fc"]),
        ("LuGre", 30.0, &["lugre.Fs", "lugre.Fc"]),
        ("Leuven", 30.0, &["leuven.Fs", "leuven.Fc"]),
        ("GMS", 30.0, &["gms.Fs", "gms.Fc"]),
        ("MaxwellSlip", 30.0, &["maxwellSlip.W[1]", "maxwellSlip.W[2]", "maxwellSlip.W[3]", "maxwellSlip.W[4]"]),
    ];
    let zero = |law: &str, drive: &str, names: &[&str]| {
        names.iter().fold(Rig::bench(law, drive), |rig, name| rig.set(&format!("friction.{name}"), 0.0))
    };
    for (law, viscous, names) in laws {
        let mut run = zero(law, "PrescribedMotion", names).start().unwrap();
        for (end, v) in [(0.1, 0.1), (0.2, -0.3), (0.3, 0.0), (0.4, 0.2)] {
            run.set("driveVelocity", v);
            run.advance(end).unwrap_or_else(|error| panic!("{law}: {error}"));
            let force = run.get("frictionForce");
            close(force, viscous * v, 1e-13, format_args!("{law}, N at {v} m/s"));
        }
        let mut run = zero(law, "SpringPull", names).set("spring.stiffness", 100.0).start().unwrap();
        run.advance(10.0).unwrap_or_else(|error| panic!("{law}: {error}"));
    }
}

const SET_VALUED: [&str; 4] = ["Coulomb", "CoulombStiction", "Stribeck", "Polito"];

#[test]
fn set_valued_laws_at_rest_answer_the_applied_force_up_to_break_away() {
    for law in SET_VALUED.into_iter().chain(["Karnopp"]) {
        let mut run = Rig::bench(law, "PrescribedMotion").set("driveVelocity", 0.2).start().unwrap();
        run.advance(0.1).unwrap();
        assert!(run.get("frictionForce") > 0.0 && run.get("sticking") == 0.0, "{law}");
        for (applied, expected) in [(3.0, Some(3.0)), (-3.0, Some(-3.0)), (1e3, None), (-1e3, None)] {
            run.set("driveVelocity", 0.0);
            run.set("appliedForce", applied);
            let found = run.get("frictionForce");
            assert_eq!(run.get("sticking"), 1.0, "{law}");
            assert!(expected.is_none_or(|expected| found == expected), "{law} answers {found} N to {applied} N");
            assert!(found * applied > 0.0 && found.abs() < 11.5, "{law} answers {found} N to {applied} N");
            let time = run.simulation().time();
            run.advance(time + 0.1).unwrap();
            assert_eq!(run.get("frictionForce"), found, "{law}");
        }
        run.set("driveVelocity", -0.2);
        assert!(run.get("frictionForce") < 0.0 && run.get("sticking") == 0.0, "{law}");
    }
}

/// `F1 = 7.8 + 3 exp(-(v/0.01)^2) + 33 v` accelerating, `F2 = 7.8 + 25 v` decelerating.
#[test]
fn polito_takes_the_branch_of_the_prescribed_acceleration() {
    let rising = |v: f64| 7.8 + 3.0 * (-(v / 0.01f64).powi(2)).exp() + 33.0 * v;
    let falling = |v: f64| 7.8 + 25.0 * v;
    let mut run = Rig::bench("Polito", "PrescribedMotion").set("driveVelocity", 0.0).start().unwrap();
    // Held values: the jump between them is the acceleration, and it is remembered.
    let jumps = [(0.1, 1.0), (0.3, 1.0), (0.3, 1.0), (0.2, -1.0), (0.2, -1.0), (0.25, 1.0), (-0.1, 1.0), (-0.05, -1.0)];
    for (step, (v, trend)) in (1..).zip(jumps) {
        run.set("driveVelocity", v);
        run.advance(0.1 * f64::from(step)).unwrap();
        let branch = if trend > 0.0 { rising } else { falling };
        let (found, expected) = (run.get("frictionForce"), branch(f64::abs(v)) * v.signum());
        close(found, expected, 2e-13, format_args!("N at {v} m/s"));
    }
    // A ramp through zero: decelerating before, accelerating after.
    run.set("driveVelocity", 0.1);
    run.advance(1.0).unwrap();
    for (end, expected) in [(1.05, falling(0.05)), (1.15, -rising(0.05))] {
        let (now, v) = (run.simulation().time(), 0.1 - (run.simulation().time() - 1.0));
        run.ramp("driveVelocity", v, -1.0);
        run.advance(end).unwrap();
        let found = run.get("frictionForce");
        close(found, expected, 1e-13, format_args!("N after {now} s"));
    }
}

/// Position after pushing for 10 s with 5 N, less than any break-away force, and the velocity then.
fn pushed(rig: &Rig) -> (f64, f64, f64) {
    let mut run = rig.clone().set("appliedForce", 5.0).start().unwrap();
    run.advance(5.0).unwrap();
    let halfway = run.get("position");
    run.advance(10.0).unwrap();
    (halfway, run.get("position"), run.get("velocity"))
}

#[test]
fn set_valued_laws_hold_the_mass_exactly() {
    for law in SET_VALUED.into_iter().chain(["Karnopp"]) {
        assert_eq!(pushed(&Rig::bench(law, "Free")), (0.0, 0.0, 0.0), "{law}");
    }
}

/// Pulled slower than the edge of the band through a damper, the mass would leave the band and come back without end: the
/// damper takes 0.1 N off the applied force as soon as the mass moves. On average it follows the drive.
#[test]
fn karnopp_follows_a_slow_damped_spring_in_steps_that_end() {
    let mut run = Rig::bench("Karnopp", "SpringPull")
        .set("driveVelocity", 5e-5)
        .set("spring.stiffness", 1e5)
        .set("spring.damping", 1e3)
        .set("solver.maxStepsPerCommunicationStep", 20_000.0)
        .start()
        .unwrap();
    for second in 1..=20 {
        run.advance(f64::from(second)).expect("a step that ends");
    }
    let lag = 1e5 * (run.get("drivePosition") - run.get("position"));
    close(lag, 11.0, 0.2, "N");
}

/// The creep velocity solves `F(v) = 5 N`; the solver's tolerance for velocities is 1e-8 m/s.
#[test]
fn regularised_laws_creep_at_the_velocity_of_their_curve() {
    let smooth = |v: f64| 8.3 * (v / 1e-3).tanh() + 30.0 * v;
    let linear = |v: f64| (8.3 + 2.7 * (-(v / 0.01).powi(2)).exp()) * v / 1e-3 + 30.0 * v;
    let cases: [(&str, &dyn Fn(f64) -> f64); 2] = [("SmoothCoulomb", &smooth), ("StribeckRegularised", &linear)];
    for (law, curve) in cases {
        let (mut slow, mut fast) = (0.0, 1e-3);
        for _ in 0..100 {
            let middle = 0.5 * (slow + fast);
            if curve(middle) < 5.0 { slow = middle } else { fast = middle }
        }
        let (halfway, end, velocity) = pushed(&Rig::bench(law, "Free"));
        close(velocity, slow, 5e-18, format_args!("{law} creeps, m/s"));
        close(end - halfway, 5.0 * slow, 1e-16, format_args!("{law} moves {} m in 5 s", end - halfway));
    }
}

/// Dahl's law has no damping by default and would ring.
#[test]
fn bristle_laws_yield_but_do_not_creep() {
    for law in ["Dahl", "LuGre", "Leuven", "GMS", "MaxwellSlip"] {
        let rig = Rig::bench(law, "Free");
        let rig = if law == "Dahl" { rig.set("friction.dahl.sigma2", 100.0) } else { rig };
        let (halfway, end, _) = pushed(&rig);
        assert!(end > 1e-7, "{law} yields {end} m");
        close(end, halfway, 1e-19, format_args!("{law} creeps by {} m in 5 s", end - halfway));
    }
}

#[test]
fn spring_force_balances_friction_in_slow_pulling() {
    for law in ["Stribeck", "GMS", "MaxwellSlip", "Leuven"] {
        let mut run = Rig::bench(law, "SpringPull")
            .set("spring.stiffness", 1e4)
            .set("spring.damping", 1e3)
            .set("driveVelocity", 0.1)
            .start()
            .unwrap();
        run.advance(5.0).unwrap();
        let (spring, friction) = (run.get("springForce"), run.get("frictionForce"));
        close(spring, friction, 2e-12, format_args!("{law}, N"));
        let lead = run.get("drivePosition") - run.get("position");
        close(run.get("velocity"), 0.1, 2e-15, law);
        close(lead * 1e4, spring, 2e-12, law);
    }
}

/// A free mass under a harmonic force without friction: amplitude `F/(m*w^2)`.
#[test]
fn free_mass_without_friction_follows_newton() {
    let mut run = Rig::bench("None", "Free").set("mass", 2.0).set("velocity0", -1.0 / (2.0 * TAU)).start().unwrap();
    let steps = 1000;
    let force = |step: i32| (TAU * f64::from(step) / f64::from(steps)).sin();
    for step in 0..steps {
        run.ramp("appliedForce", force(step), (force(step + 1) - force(step)) * f64::from(steps));
        run.advance(f64::from(step + 1) / f64::from(steps)).unwrap();
    }
    // Ramps through the sine have an error of (w*h)^2/12 of its amplitude.
    within(run.get("position").abs(), 1e-6, "m");
    close(run.get("velocity"), -1.0 / (2.0 * TAU), 1e-15, "m/s");
}
