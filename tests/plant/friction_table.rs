//! Friction by a table, against closed forms of a mass that it brakes.

use crate::bounds::close;
use crate::rig::Rig;

/// Two points a direction, which are a line: (speed in m/s, force in N).
type Line = [(f64, f64); 2];

const OUTWARDS: Line = [(0.0, 9.0), (1.0, 5.0)];
const INWARDS: Line = [(0.0, 6.0), (1.0, 7.0)];

fn bench(drive: &str) -> Rig {
    let rig = Rig::bench("Table", drive).set("friction.table.sigma2", 0.0);
    [("outwards", OUTWARDS), ("inwards", INWARDS)].into_iter().fold(rig, |rig, (side, line)| {
        let rig = rig.set(&format!("friction.table.{side}.points"), 2.0);
        line.into_iter().enumerate().fold(rig, |rig, (place, (speed, force))| {
            let rig = rig.set(&format!("friction.table.{side}.speed[{}]", place + 1), speed);
            rig.set(&format!("friction.table.{side}.force[{}]", place + 1), force)
        })
    })
}

/// `m*dv/dt = -(a + b*v)` stops at `t = m/b*ln(1 + b*v0/a)`, `x = m/b*v0 - a/b*t` further, and rests there exactly.
#[test]
fn mass_is_braked_by_the_table_of_its_direction() {
    let mass = 2.0;
    for (way, [(_, a), (_, end)]) in [(1.0, OUTWARDS), (-1.0, INWARDS)] {
        let (b, speed) = (end - a, 0.8);
        let stop = mass / b * (1.0 + b * speed / a).ln();
        let place = mass / b * speed - a / b * stop;
        let mut running = bench("Free")
            .set("mass", mass)
            .set("velocity0", way * speed)
            .set("solver.relativeTolerance", 1e-10)
            .start()
            .unwrap();
        running.advance(0.999 * stop).unwrap();
        assert_eq!(running.get("sticking"), 0.0);
        running.advance(1.001 * stop).unwrap();
        assert_eq!([running.get("sticking"), running.get("velocity")], [1.0, 0.0]);
        close(running.get("position"), way * place, 1e-10, format_args!("m, {way}"));
        let rests = running.get("position");
        running.advance(10.0).unwrap();
        assert_eq!(running.get("position").to_bits(), rests.to_bits());
    }
}

/// Each side holds its first force, times the load level.
#[test]
fn each_direction_breaks_away_at_its_first_force() {
    for (way, [(_, force), _]) in [(1.0, OUTWARDS), (-1.0, INWARDS)] {
        for level in [0.5, 1.0, 2.0] {
            for (share, sticks) in [(0.999, 1.0), (1.001, 0.0)] {
                let rig = bench("Free").set("friction.level", level);
                let mut running = rig.set("appliedForce", way * share * level * force).start().unwrap();
                running.advance(0.1).unwrap();
                assert_eq!(running.get("sticking"), sticks, "{way}, {share} of {force} N at the level {level}");
            }
        }
    }
}

/// Beyond the last point a curve that falls stays, and one that rises goes on.
#[test]
fn prescribed_motion_reads_the_table() {
    for (velocity, expected) in [(0.25, 8.0), (1.0, 5.0), (3.0, 5.0), (-0.5, -6.5), (-1.0, -7.0), (-3.0, -9.0)] {
        let mut running = bench("PrescribedMotion").set("driveVelocity", velocity).start().unwrap();
        running.advance(0.1).unwrap();
        close(running.get("frictionForce"), expected, 1e-13, format_args!("N at {velocity} m/s"));
    }
}
