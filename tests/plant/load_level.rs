//! The load level of laws whose parameters are lengths and stiffnesses, not forces.

use std::f64::consts::TAU;

use crate::bounds::{close, larger, smaller, within};
use crate::rig::Rig;

/// The strength of bonds, `N*sigma0*deltaS` = 12.4 N and `(1 + a)*sigma0*z0` = 10.998 N, grows with the load level as every
/// other friction force does. Within the 0.1 ms between two samples pressure and force grow by less than 1 %.
#[test]
fn bonds_hold_as_much_more_as_the_load_level_says() {
    for (law, bond) in [("Bristle", 12.4), ("ResetIntegrator", 10.9975)] {
        let rig = Rig::cylinder(law).set("friction.kappaA", 5e-6).set("friction.kappaB", 5e-6);
        let mut run = rig.set("valveVoltage", 6.0).start().unwrap();
        let (mut strongest, mut level) = (0.0f64, 1.0);
        for step in 1..5000 {
            run.advance(f64::from(step) * 1e-4).unwrap();
            if f64::abs(run.get("position") - 0.25) > 5e-5 {
                break;
            }
            let pressures = ["chamberA.pressure", "chamberB.pressure"].map(|name| run.get(name) - 101_325.0);
            level = 1.0 + 5e-6 * (pressures[0] + pressures[1]);
            strongest = larger(strongest, run.get("frictionForce") / level);
        }
        assert!(level > 1.3, "{law}: {strongest} N at level 1, {level}");
        close(strongest / bond, 1.0, 0.01, law);
    }
}

/// While the load level falls to zero, and below the strength of bonds that are stretched, and rises again.
#[test]
fn bonds_survive_a_vanishing_load_level() {
    for law in ["Bristle", "ResetIntegrator"] {
        let mut run = Rig::cylinder(law).set("friction.kappaA", -1e-5).start().unwrap();
        let mut least = f64::INFINITY;
        for step in 0..1000 {
            let time = f64::from(step) * 1e-3;
            run.set("valveVoltage", 5.0 + 2.0 * (TAU * time).sin());
            run.advance(time + 1e-3).unwrap_or_else(|error| panic!("{law}: {error}"));
            let force = run.get("frictionForce") - 30.0 * run.get("velocity");
            let level = 1.0 - 1e-5 * (run.get("chamberA.pressure") - 101_325.0);
            if level < -0.1 {
                // Micronewtons remain of the bonds, and the contact damping where a bond yields.
                within(force.abs(), 5e-5, format_args!("{law}, N at {time} s"));
            }
            least = smaller(least, level);
        }
        assert!(least < -0.2, "{law}: the level falls to {least} only");
    }
}
