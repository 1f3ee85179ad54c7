//! Sensitivities of the cylinder where something bends, begins or is sampled, compared with differences of runs.

use std::f64::consts::TAU;

use pneumatic_servo::model::{Plant, Setup};
use pneumatic_servo::models::driven_slider;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

/// A voltage over time.
type Course = fn(f64) -> f64;

fn setup(law: &str, changes: &[(&str, f64)]) -> Setup {
    let setup = Setup::new(&MODEL).set("friction.law", law).expect("a law");
    let setup = setup.set("solver.relativeTolerance", 1e-11).expect("legal");
    changes.iter().fold(setup, |setup, (name, value)| setup.set(name, *value).expect("legal"))
}

/// Runs under a voltage that changes every millisecond, and looks after every step.
fn run(plant: &mut Plant, course: Course, end: f64, mut look: impl FnMut(&mut Plant)) {
    for k in 0..(end * 1e3).round() as u32 {
        plant.set("valveVoltage", course(f64::from(k) * 1e-3)).expect("legal");
        plant.advance_to(f64::from(k + 1) * 1e-3).expect("advances");
        look(plant);
    }
}

fn rows(setup: &Setup, course: Course, end: f64, name: &str) -> Vec<f64> {
    let mut rows = Vec::new();
    run(&mut setup.start(0.0).expect("starts"), course, end, |plant| rows.push(plant.get(name).expect("a variable")));
    rows
}

/// The sensitivities of variables to a parameter, row by row.
fn slopes<const N: usize>(setup: &Setup, course: Course, end: f64, by: &str, of: [&str; N]) -> Vec<[f64; N]> {
    let mut plant = setup.start(0.0).expect("starts");
    plant.carry_sensitivities(&[by]).expect("a parameter");
    let place = |name: &str| plant.table().computed().position(|it| it.name == name).expect("a computed variable");
    let (places, mut rows) = (of.map(place), Vec::new());
    run(&mut plant, course, end, |plant| {
        let all = plant.sensitivities(0).unwrap_or_else(|lost| panic!("by {by}: {lost}"));
        rows.push(places.map(|place| all[place]));
    });
    rows
}

/// Distance of sensitivities of the position from differences of runs to some sides of a parameter, relative to the
/// largest.
fn distance(setup: &Setup, course: Course, end: f64, by: &str, sides: [f64; 2]) -> f64 {
    let value = setup.get(by).expect("a parameter");
    let [one, other] = sides.map(|offset| {
        let moved = setup.clone().set(by, value + offset).expect("legal");
        rows(&moved, course, end, "position")
    });
    let found = slopes(setup, course, end, by, ["position"]);
    let differences = one.iter().zip(other).map(|(one, other)| (one - other) / (sides[0] - sides[1]));
    let (mut worst, mut largest) = (0.0f64, 0.0f64);
    for (difference, [slope]) in differences.zip(found) {
        (worst, largest) = (worst.max((difference - slope).abs()), largest.max(difference.abs()));
    }
    assert!(largest > 0.0, "the position depends on {by}");
    worst / largest
}

/// The place of a stop is a parameter, and the difference by it must not reach across its edge.
#[test]
fn stop_that_moves_takes_the_piston_along() {
    for (law, bound) in [("None", 2e-4), ("BlimanSorine", 1e-5)] {
        let setup = setup(law, &[("position0", 0.4)]);
        let distance = distance(&setup, |_| 10.0, 0.4, "cylinder.stroke", [5e-8, -5e-8]);
        assert!(distance < bound, "{law}: {distance}");
    }
}

/// A reading at the end of a step is the quantity itself, independent of other readings at the same instant.
#[test]
fn readings_of_the_same_instant_have_the_slopes_of_their_quantities() {
    let setup = setup("LuGre", &[("sensor.position.sampleTime", 1e-3), ("sensor.pressureA.sampleTime", 1e-3)]);
    let of = ["position", "sensor.position.reading", "chamberA.pressure", "sensor.pressureA.reading"];
    let found = slopes(&setup, |t| 5.0 + 2.0 * (TAU * t).sin(), 0.2, "friction.lugre.vs", of);
    assert!(found.iter().any(|row| row[0].abs() > 1e-2), "it slides");
    for (k, [position, reading, pressure, other]) in found.into_iter().enumerate() {
        for (quantity, reading) in [(position, reading), (pressure, other)] {
            assert!((reading - quantity).abs() <= 1e-12 * quantity.abs(), "row {k}: {reading}, not {quantity}");
        }
    }
}

/// Elements that come to their limits together slip together, and a motion that has just reversed is near a bend.
#[test]
fn reversals_have_derivatives_under_laws_of_hysteresis() {
    for (law, bound) in [("MaxwellSlip", 1e-5), ("Leuven", 1e-6)] {
        let setup = setup(law, &[]);
        let distance = distance(&setup, |t| 5.0 + 1.5 * (2.0 * TAU * t).sin(), 0.6, "mass.moving", [1e-5, -1e-5]);
        assert!(distance < bound, "{law}: {distance}");
    }
}

/// A carriage cannot have more than the moving mass, nor a piston less than no leakage.
#[test]
fn parameter_that_may_only_grow_has_the_slope_to_that_side() {
    for (changes, by, offset) in
        [(&[("mass.moving", 0.5), ("mass.carriage", 0.5)][..], "mass.moving", 1e-6), (&[], "piston.leakage", 1e-17)]
    {
        let distance = distance(&setup("Stribeck", changes), |_| 6.5, 0.1, by, [offset, 0.0]);
        // A forward difference has an error of first order.
        assert!(distance < 1e-3, "{by}: {distance}");
    }
}

/// Four longest steps behind a break-away the delayed velocity begins to move.
#[test]
fn delayed_velocity_has_derivatives_where_steps_divide_the_delay() {
    let setup = Setup::new(&MODEL).set("friction.law", "Armstrong").expect("a law");
    let value = setup.get("valve.C").expect("a parameter");
    let moved = |offset: f64| setup.clone().set("valve.C", value + offset).expect("legal").start(0.0).expect("starts");
    let [mut plant, mut above, mut below] = [0.0, 1e-5 * value, -1e-5 * value].map(moved);
    plant.carry_sensitivities(&["valve.C"]).expect("a parameter");
    let position = plant.table().computed().position(|it| it.name == "position").expect("a computed variable");
    for plant in [&mut plant, &mut above, &mut below] {
        plant.set("valveVoltage", 6.5).expect("legal");
    }
    for k in 1..=20 {
        for plant in [&mut plant, &mut above, &mut below] {
            plant.advance_to(f64::from(k) * 1e-2).expect("advances");
        }
    }
    let slope = plant.sensitivities(0).unwrap_or_else(|lost| panic!("{lost}"))[position];
    let [above, below] = [above, below].map(|plant| plant.get("position").expect("a variable"));
    let expected = (above - below) / (2e-5 * value);
    assert!((slope / expected - 1.0).abs() < 1e-4, "{slope}, not {expected}");
}

/// From a voltage that is held from the start the play is dragged downwards, or first up and then down.
#[test]
fn play_that_is_dragged_downwards_moves_the_spool_by_half_of_its_width() {
    let setup = setup("Coulomb", &[("valve.hysteresis", 0.01)]);
    let courses: [Course; 2] = [|_| 3.0, |t| if t < 0.05 { 7.0 } else { 3.0 }];
    for course in courses {
        let distance = distance(&setup, course, 0.1, "valve.hysteresis", [1e-5, -1e-5]);
        // Runs are known to 1e-11 m, and differ by 1e-6 m.
        assert!(distance < 1e-5, "{distance}");
    }
}

/// Quick reversals amplify what the kept course of the velocity is off by.
#[test]
fn delayed_velocity_has_exact_derivatives_through_quick_reversals() {
    let setup = setup("Armstrong", &[]);
    let value = setup.get("valve.C").expect("a parameter");
    let distance =
        distance(&setup, |t| 5.0 + 2.0 * (5.0 * TAU * t).sin(), 0.35, "valve.C", [1e-6 * value, -1e-6 * value]);
    assert!(distance < 1e-5, "{distance}");
}

/// An option that is off at 0 has an effect at a small value.
#[test]
fn options_that_are_off_at_zero_have_the_slope_of_a_little_of_them() {
    for (by, offset, sides) in [
        ("friction.kappaDifference", 1e-9, [1.0, -1.0]),
        ("load.stiffness", 1e-4, [1.0, 0.0]),
        ("friction.position.amplitude", 1e-6, [1.0, 0.0]),
        ("valve.hysteresis", 1e-6, [1.0, 0.0]),
    ] {
        let setup = setup("Stribeck", &[(by, 0.0)]);
        let distance =
            distance(&setup, |t| 6.0 + 1.5 * (2.0 * TAU * t).sin(), 0.25, by, sides.map(|side| side * offset));
        // A forward difference has an error of first order.
        assert!(distance < 1e-3, "{by}: {distance}");
    }
}

/// The air of the first little leak has the temperature of the chamber with the higher pressure.
#[test]
fn leak_past_the_piston_begins_with_the_energy_of_the_air_that_passes() {
    let voltages: [Course; 2] = [|_| 3.0, |_| 7.0];
    for voltage in voltages {
        let setup = setup("Stribeck", &[]).set("thermal.model", "EnergyBalance").expect("a thermal model");
        for name in ["chamberA.temperature", "chamberB.temperature", "chamberA.pressure"] {
            let [with, without] = [1e-18, 0.0]
                .map(|leakage| rows(&setup.clone().set("piston.leakage", leakage).expect("legal"), voltage, 0.1, name));
            let found = slopes(&setup, voltage, 0.1, "piston.leakage", [name]);
            let differences: Vec<f64> =
                with.iter().zip(without).map(|(with, without)| (with - without) / 1e-18).collect();
            let largest = differences.iter().fold(0.0f64, |most, it| most.max(it.abs()));
            for (row, ([found], difference)) in found.into_iter().zip(differences).enumerate() {
                let off = (found - difference).abs();
                assert!(off < 2e-3 * largest, "{name}, {} V, row {row}: {found} for {difference}", voltage(0.0));
            }
        }
    }
}

/// A carriage that starts at an end of its stroke can start further inside alone: the slope is that to the inside.
#[test]
fn start_at_an_end_of_the_stroke_has_the_slope_to_the_inside() {
    let voltages: [Course; 3] = [|_| 5.0, |_| 3.0, |_| 7.0];
    let mut wrong = Vec::new();
    for law in ["LuGre", "Coulomb", "None"] {
        for (place, inside) in [(0.0, 1e-10), (0.5, -1e-10)] {
            for voltage in voltages {
                let setup = setup(law, &[("position0", place)]);
                let distance = distance(&setup, voltage, 0.05, "position0", [inside, 0.0]);
                if distance > 1e-3 || distance.is_nan() {
                    wrong.push(format!("{law} at {place} m, {} V: {distance}", voltage(0.0)));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A faster tray has shorter time steps of the walk, in which the velocity changes by less.
#[test]
fn walk_beside_the_slider_varies_with_the_frequency_of_the_tray() {
    let setup = Setup::new(&driven_slider::MODEL);
    let value = setup.get("tray.frequency").expect("a parameter");
    // Communication points that no step of the walk falls on.
    let velocities = |offset: f64| {
        let mut plant = setup.clone().set("tray.frequency", value + offset).expect("legal").start(0.0).expect("starts");
        let velocity = |k: u32| {
            plant.advance_to(5.03e-4 * f64::from(k)).expect("advances");
            plant.get("walk.velocity").expect("a variable")
        };
        (1..100).map(velocity).collect::<Vec<_>>()
    };
    let mut plant = setup.start(0.0).expect("starts");
    plant.carry_sensitivities(&["tray.frequency"]).expect("a parameter");
    let place = plant.table().computed().position(|it| it.name == "walk.velocity").expect("a computed variable");
    let mut differs = 0;
    for (k, (above, below)) in (1..100).zip(velocities(1e-7).into_iter().zip(velocities(-1e-7))) {
        plant.advance_to(5.03e-4 * f64::from(k)).expect("advances");
        let (found, difference) = (plant.sensitivities(0).expect("slopes")[place], (above - below) / 2e-7);
        assert!((found - difference).abs() < 1e-6, "row {k}: {found} for {difference}");
        differs += u32::from(difference.abs() > 1e-4);
    }
    assert!(differs > 50, "{differs}");
}

/// Steps that divide the delay end beside it but for rounding, and leave two points of the past motion that nothing is between.
#[test]
fn delay_has_a_slope_where_steps_divide_it() {
    let setup = setup("Armstrong", &[]);
    let delay = setup.get("friction.armstrong.tauL").expect("a parameter");
    for parts in [1, 2, 4] {
        let step = delay / f64::from(parts);
        let positions = |offset: f64| {
            let moved = setup.clone().set("friction.armstrong.tauL", delay + offset).expect("legal");
            stepped(&mut moved.start(0.0).expect("starts"), step, |plant| plant.get("position").expect("a variable"))
        };
        let mut plant = setup.start(0.0).expect("starts");
        plant.carry_sensitivities(&["friction.armstrong.tauL"]).expect("a parameter");
        let place = plant.table().computed().position(|it| it.name == "position").expect("a computed variable");
        let found = stepped(&mut plant, step, |plant| plant.sensitivities(0).expect("slopes")[place]);
        let differences: Vec<f64> =
            positions(1e-8).into_iter().zip(positions(-1e-8)).map(|(above, below)| (above - below) / 2e-8).collect();
        let largest = differences.iter().fold(0.0f64, |most, it| most.max(it.abs()));
        for (row, (found, difference)) in found.into_iter().zip(differences).enumerate() {
            assert!((found - difference).abs() < 1e-3 * largest, "{parts}, row {row}: {found} for {difference}");
        }
    }
}

/// A sine of the voltage in steps of a size, and what is seen after each.
fn stepped(plant: &mut Plant, step: f64, mut look: impl FnMut(&mut Plant) -> f64) -> Vec<f64> {
    let mut rows = Vec::new();
    for k in 0..(0.3 / step).round() as u32 {
        plant.set("valveVoltage", 5.0 + 2.0 * (TAU * step * f64::from(k)).sin()).expect("legal");
        plant.advance_to(step * f64::from(k + 1)).expect("advances");
        rows.push(look(plant));
    }
    rows
}

/// A valve that begins to open just at a communication point feeds the chamber a moment later with less delay, and not yet with more.
#[test]
fn flow_has_no_slope_in_the_rows_at_which_a_valve_begins_to_move() {
    for by in ["switching.openingDelay", "switching.closingDelay"] {
        let setup = setup("Stribeck", &[]).set("actuation", "SwitchingValves").expect("an actuator");
        let value = setup.get(by).expect("a parameter");
        let flows = |offset: f64| {
            let moved = setup.clone().set(by, value + offset).expect("legal");
            rows(&moved, |_| 7.0, 0.05, "chamberA.massFlow")
        };
        let (here, above, below) = (flows(0.0), flows(1e-8), flows(-1e-8));
        let mut plant = setup.start(0.0).expect("starts");
        plant.carry_sensitivities(&[by]).expect("a parameter");
        let place = |name: &str| plant.table().computed().position(|it| it.name == name).expect("a computed variable");
        let (flow, position) = (place("chamberA.massFlow"), place("position"));
        let (mut row, mut bends) = (0, 0);
        run(
            &mut plant,
            |_| 7.0,
            0.05,
            |plant| {
                let found = plant.sensitivities(0).expect("slopes of the states");
                let [left, right] = [here[row] - below[row], above[row] - here[row]].map(|change| change / 1e-8);
                let bends_here = (left - right).abs() > 0.1 * left.abs().max(right.abs()).max(1e-3);
                assert_eq!(
                    found[flow].is_nan(),
                    bends_here,
                    "{by}, row {row}: {} between {left} and {right}",
                    found[flow]
                );
                assert!(found[position].is_finite(), "{by}, row {row}");
                if !bends_here {
                    assert!(
                        (found[flow] - left).abs() < 1e-3 * left.abs().max(1e-2),
                        "{by}, row {row}: {} {left}",
                        found[flow]
                    );
                }
                (row, bends) = (row + 1, bends + u32::from(bends_here));
            },
        );
        assert!(bends >= 4, "{by}: {bends}");
    }
}
