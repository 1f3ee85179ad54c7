//! Properties that every friction law of the registry has.

use std::f64::consts::TAU;

use crate::bounds::close;
use crate::rig::Rig;
use pneumatic_servo::conformance;
use pneumatic_servo::friction::{Friction, FrictionLaw, LAWS, Law};
use pneumatic_servo::variables::Choice;

fn laws() -> impl Iterator<Item = &'static str> {
    LAWS.items.iter().map(|(_, name, _)| *name)
}

/// The default table of friction over speed, as `scipy.interpolate.PchipInterpolator` of SciPy 1.17 has it between the points.
fn table(v: f64) -> f64 {
    let known =
        [(5e-4, 10.988_977_149_906_015), (2e-3, 10.894), (5e-3, 10.404_159_250_887_307), (0.02, 8.349), (0.3, 8.305)];
    known.into_iter().find(|(speed, _)| *speed == v).expect("a speed at which it was computed").1
}

/// The law's steady curve for `v > 0` with its default parameters, as the catalogue of laws defines it.
fn steady_curve(law: &str, v: f64) -> Result<f64, &'static str> {
    let bell = |w: f64| (-(v / w).powi(2)).exp();
    let stribeck = 8.3 + 2.7 * bell(0.01);
    let viscous = 30.0 * v;
    // Rises to F_s until 1 mm/s, falls to F_c until 10 mm/s.
    let stepped = |rise: fn(f64) -> f64| {
        if v < 1e-3 { 11.0 * rise(v / 1e-3) } else { 11.0 - 2.7 * rise(((v - 1e-3) / 9e-3).min(1.0)) }
    };
    let cubic: fn(f64) -> f64 = |q| q * q * (3.0 - 2.0 * q);
    let sine: fn(f64) -> f64 = |q| 0.5 * (1.0 - (std::f64::consts::PI * q).cos());
    Ok(match law {
        "None" => 0.0,
        "Coulomb" | "CoulombStiction" | "ResetIntegrator" | "MaxwellSlip" | "DNLRX" | "BlimanSorine"
        | "StickSlipSpring" => 8.3 + viscous,
        "SmoothCoulomb" => 8.3 * (v / 1e-3).tanh() + viscous,
        "VelocityBased" => {
            let shape = 2.0 - 2.0 / std::f64::consts::PI * (8.3f64 / 11.0).asin();
            let slope = (std::f64::consts::FRAC_PI_2 / shape).tan() / 0.01;
            11.0 * (shape * (slope * v).atan()).sin() + viscous
        }
        "StribeckRegularised" => stribeck * (v / 1e-3).min(1.0) + viscous,
        "Stribeck" | "Karnopp" | "LuGre" | "Leuven" | "GMS" | "ElastoPlastic" => stribeck + viscous,
        "RevisedLuGre" => {
            let film = (1.0 - 8.3 / 11.0) * (v / 0.05).min(1.0).powf(2.0 / 3.0);
            8.3 + ((1.0 - film) * 11.0 - 8.3) * bell(0.01) + viscous
        }
        "Polito" => 7.8 + 3.0 * bell(0.01) + 33.0 * v,
        "Dahl" => 10.6,
        "Table" => table(v) + viscous,
        "Bristle" => return Err("bonds break and form at random: only the mean force is steady"),
        "Armstrong" => 8.3 + 2.7 / (1.0 + (v / 0.01).powi(2)) + viscous,
        "StepRegularised" => stepped(cubic) + viscous,
        "SineRegularised" => stepped(sine) + viscous,
        "StickSlipCreep" => {
            let creep = cubic(((1e-2 - v) / 9e-3).clamp(0.0, 1.0));
            creep * 11.0 + (1.0 - creep) * 8.3 + viscous
        }
        _ => panic!("what is the steady curve of {law}?"),
    })
}

/// Sliding for 3 cm and 0.5 s, or 40 time constants of a film, leaves nothing of the transient; the solver's tolerance remains.
#[test]
fn steady_sliding_gives_the_steady_curve() {
    for law in laws() {
        for v in [5e-4, 2e-3, 5e-3, 0.02, 0.3] {
            let Ok(expected) = steady_curve(law, v) else { continue };
            for direction in [1.0, -1.0] {
                let mut run = Rig::bench(law, "PrescribedMotion").set("driveVelocity", direction * v).start().unwrap();
                let settled = if law == "RevisedLuGre" { 10.0 } else { 0.5 };
                run.advance(settled + 0.03 / v).unwrap_or_else(|error| panic!("{law}: {error}"));
                let found = direction * run.get("frictionForce");
                close(found, expected, 5e-13 * 11.0, format_args!("{law} at {v} m/s, N"));
            }
        }
    }
}

/// Whether a law is odd; the others are left out with their reason.
fn is_odd(law: &str) -> bool {
    // Bristle: one generator serves both directions.
    law != "Bristle"
}

/// Every operation on mirrored numbers gives mirrored numbers.
#[test]
fn mirrored_motion_gives_mirrored_friction() {
    laws().filter(|law| is_odd(law)).for_each(conformance::law::mirrored::<Friction>);
}

#[test]
fn derivatives_by_dual_numbers_are_those_of_differences() {
    laws().for_each(conformance::law::derivatives::<Friction>);
}

#[test]
fn broken_contacts_slide() {
    laws().for_each(conformance::law::yields::<Friction>);
}

/// So that what is evaluated need not be evaluated again.
#[test]
fn force_is_the_same_where_a_law_says_so() {
    laws().for_each(conformance::law::unchanged::<Friction>);
}

/// A run that is saved, continued, restored and continued again repeats every bit.
#[test]
fn restored_runs_repeat_every_bit() {
    for law in laws() {
        let mut bench = conformance::law::benched::<Friction>(law, "SpringPull");
        bench.change("spring.stiffness", 1e4).expect("a stiffness");
        conformance::repeats(&bench, 0.35);
    }
}

/// Stick-slip at the edges of the parameters: a Stribeck exponent of 0.5, whose slope at rest is infinite, and static
/// friction no larger than Coulomb friction.
#[test]
fn steep_and_flat_stribeck_curves_are_integrated() {
    let table = Friction::table_within("friction", 0, Law::None.id());
    for law in laws() {
        let group = format!("friction.{}", law_group(law));
        let has = |name: &str| table.iter().any(|variable| variable.name == format!("{group}.{name}"));
        for (name, value) in [("delta", 0.5), ("Fs", 8.3)] {
            // Law 5 needs F_c < F_s.
            if !has(name) || !has("Fc") && name == "Fs" || law == "VelocityBased" {
                continue;
            }
            let mut run = Rig::bench(law, "SpringPull")
                .set("spring.stiffness", 1e4)
                .set("driveVelocity", 0.005)
                .set(&format!("{group}.{name}"), value)
                .set("solver.maxStepsPerCommunicationStep", 200_000.0)
                .start()
                .unwrap();
            run.advance(2.0).unwrap_or_else(|error| panic!("{law} with {name} = {value}: {error}"));
            let force = run.get("frictionForce");
            assert!(force.is_finite() && force.abs() < 20.0, "{law} with {name} = {value}: {force} N");
        }
    }
}

/// Under every law: where sliding takes more than holding, nothing could rest, and the name and the value are refused.
#[test]
fn coulomb_above_static_friction_is_refused_by_every_law_that_has_both() {
    let table = Friction::table_within("friction", 0, Law::None.id());
    let mut refused = 0;
    for law in laws() {
        let group = format!("friction.{}", law_group(law));
        let has = |name: &str| table.iter().any(|variable| variable.name == format!("{group}.{name}"));
        for coulomb in ["Fc", "Fc1", "Fc2"].into_iter().filter(|name| has(name) && has("Fs")) {
            let name = format!("{group}.{coulomb}");
            let error =
                Rig::bench(law, "SpringPull").set(&name, 11.5).start().err().unwrap_or_else(|| panic!("{name}"));
            assert_eq!((error.variable.as_str(), error.value), (name.as_str(), 11.5), "{error}");
            assert!(error.reason.contains("static friction Fs = "), "{error}");
            refused += 1;
        }
    }
    assert!(refused >= 15, "{refused} limits");
}

/// The group of a law's parameters: its name in camel case.
fn law_group(law: &str) -> String {
    match law {
        "GMS" | "LuGre" | "DNLRX" => law.to_lowercase(),
        _ => law[..1].to_lowercase() + &law[1..],
    }
}

/// Laws that are non-stiff with their defaults, by `docs/solver.md`: away from the stops the steps of the cylinder are explicit.
const NON_STIFF: [&str; 17] = [
    "None",
    "Coulomb",
    "CoulombStiction",
    "Stribeck",
    "Karnopp",
    "Polito",
    "Bristle",
    "StickSlipSpring",
    "MaxwellSlip",
    "GMS",
    "LuGre",
    "ElastoPlastic",
    "Leuven",
    "Dahl",
    "ResetIntegrator",
    "StickSlipCreep",
    "Table",
];

/// The implicit method takes over where an explicit one would have to take short steps: seldom, after events.
#[test]
fn non_stiff_laws_need_hardly_a_jacobian_and_others_one_in_every_step() {
    for law in laws() {
        let mut run = Rig::cylinder(law).start().unwrap();
        for step in 0..1000 {
            let time = f64::from(step) * 1e-3;
            run.set("valveVoltage", 5.0 + libm::sin(TAU * time));
            run.advance(time + 1e-3).unwrap();
        }
        let [steps, jacobians] = ["solver.steps", "solver.jacobians"].map(|name| run.get(name));
        let (is_rare, is_always) = (jacobians < 0.02 * steps, jacobians >= steps);
        assert!(is_rare || is_always && !NON_STIFF.contains(&law), "{law}: {jacobians} Jacobians in {steps} steps");
    }
}
