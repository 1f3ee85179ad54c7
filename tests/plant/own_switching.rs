//! Switching valves under pulses, against closed forms and against the proportional valve that is their mean.

use std::f64::consts::TAU;

use crate::bounds::{close, farthest, largest};
use crate::rig::{Rig, Running};
use pneumatic_servo::conformance::Host;
use pneumatic_servo::model::{Plant, Setup};
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

const CONDUCTANCE: f64 = 3.93e-9;
/// `R*T` in J/kg.
const GAS: f64 = 287.05 * 293.15;

/// Switching valves with the given values changed.
fn switched(law: &str, centre: &str, values: &[(&str, f64)]) -> Rig {
    let rig = Rig::cylinder(law).choose("actuation", "SwitchingValves").choose("switching.centre", centre);
    values.iter().fold(rig, |rig, (name, value)| rig.set(name, *value))
}

/// The piston held, gas at constant temperature, a chamber A as large as a room, so that choked flow stays choked.
fn filling(values: &[(&str, f64)]) -> Running {
    let held = [("friction.coulombStiction.Fs", 1e6), ("chamberA.deadVolume", 1.0), ("supplyPressure", 20e5)];
    switched("CoulombStiction", "Closed", &[&held, values].concat())
        .choose("thermal.model", "Isothermal")
        .start()
        .unwrap()
}

/// Choked, a pulse brings `C*p*rho0` times its length, more by what closing starts later than opening: the travels, of
/// the same length, make up for each other. Ten pulses of 4 ms.
#[test]
fn pulses_bring_what_their_length_says() {
    for (opening, closing, travel, open) in
        [(0.0, 0.0, 0.0, 4e-3), (1e-3, 1e-3, 5e-4, 4e-3), (2e-3, 1e-3, 1e-3, 3e-3), (5e-4, 2e-3, 7e-4, 5.5e-3)]
    {
        let delays = [("switching.openingDelay", opening), ("switching.closingDelay", closing)];
        let values = [&delays[..], &[("switching.travelTime", travel), ("valveVoltage", 7.0)]].concat();
        let mut running = filling(&values);
        let before = running.get("chamberA.pressure");
        running.advance(0.1).unwrap();
        let volume = 1.0 + 0.25 * std::f64::consts::PI * 0.016f64.powi(2) / 4.0;
        let expected = 10.0 * open * CONDUCTANCE * 20e5 * 1.185 * GAS / volume;
        let found = running.get("chamberA.pressure") - before;
        close(
            found / expected,
            1.0,
            5e-11,
            format_args!("{found} Pa, not {expected}, with delays {opening}, {closing}"),
        );
    }
}

/// 5 V: both chambers end at the pressure of the surroundings, or keep what they have.
#[test]
fn centre_vents_or_closes_both_chambers() {
    for (centre, expected) in [("Vented", 101_325.0), ("Closed", 4e5)] {
        let pressures =
            [("chamberA.pressure0", 4e5), ("chamberB.pressure0", 4e5), ("friction.coulombStiction.Fs", 1e6)];
        let rig = switched("CoulombStiction", centre, &pressures).choose("thermal.model", "Isothermal");
        let mut running = rig.start().unwrap();
        running.advance(3.0).unwrap();
        for name in ["chamberA.pressure", "chamberB.pressure"] {
            let found = running.get(name);
            close(found, expected, 5e-9, name);
        }
    }
}

/// The position of a carriage under a slow sine of the voltage, sampled each 10 ms.
fn course(rig: &Rig) -> Vec<f64> {
    let mut running = rig.start().unwrap();
    let mut positions = Vec::new();
    for step in 0..500 {
        let time = f64::from(step) * 1e-3;
        running.set("valveVoltage", 5.0 + 2.0 * (TAU * 2.0 * time).sin());
        running.advance(time + 1e-3).unwrap();
        positions.push(running.get("position"));
    }
    positions
}

/// Pulses without delay and travel are in the mean the valve without dead zone, play and leakage: the faster, the closer.
#[test]
fn fast_pulses_are_the_proportional_valve_of_their_mean() {
    let valve = [("valve.deadZone", 0.0), ("valve.hysteresis", 0.0), ("valve.leakage", 0.0), ("valve.bandwidth", 1e4)];
    let averaged = valve.iter().fold(Rig::cylinder("Coulomb"), |rig, (name, value)| rig.set(name, *value));
    let expected = course(&averaged);
    let moved = largest(expected.iter().map(|position| (position - 0.25).abs()));
    assert!(moved > 0.02, "the carriage moves by {moved} m");
    let apart = |frequency: f64| {
        let direct = [("switching.openingDelay", 0.0), ("switching.closingDelay", 0.0), ("switching.travelTime", 0.0)];
        let values = [&direct[..], &[("switching.frequency", frequency)]].concat();
        farthest(&course(&switched("Coulomb", "Closed", &values)), &expected)
    };
    let (slow, fast) = (apart(1000.0), apart(4000.0));
    // The pulses lie in the first part of their period; the spool of 10 kHz adds its lag of 20 us at 0.9 m/s.
    assert!(slow < 3e-4 && fast < 0.25 * slow + 2e-5, "{slow} m at 1 kHz, {fast} m at 4 kHz");
}

/// Ten seconds of 100 Hz have 4,000 beginnings and ends of motions, each of which the solver meets, and 1,000 voltages to
/// take: it costs three steps for each of them, wherever the pulses are between the communication points.
#[test]
fn pulses_cost_their_edges() {
    let mut running = switched("Stribeck", "Vented", &[("valveVoltage", 7.0)]).start().unwrap();
    running.advance(10.0).unwrap();
    let [steps, rejected] = ["solver.steps", "solver.rejectedSteps"].map(|name| running.get(name));
    assert!((5e3..2e4).contains(&(steps + rejected)), "{steps} steps, {rejected} rejected");
    let jacobians = running.get("solver.jacobians");
    assert!(20.0 * jacobians < steps, "{jacobians} implicit steps, which cost twice as much as explicit ones");
}

/// Where a valve opens with its coil, the communication step does not tell when: not even where its points are close behind the
/// beginning of a period, as those of 1 ms are at 9.2 Hz.
#[test]
fn pulses_without_a_delay_begin_on_time() {
    let direct = [("switching.openingDelay", 0.0), ("switching.frequency", 9.2), ("valveVoltage", 7.0)];
    let course = |divisions: u32| {
        let mut running = switched("Coulomb", "Closed", &direct).start().unwrap();
        let ends = (1..=2000 * divisions).map(|step| {
            running.advance(f64::from(step) * 1e-3 / f64::from(divisions)).unwrap();
            ["position", "chamberA.pressure"].map(|name| running.get(name))
        });
        ends.skip(divisions as usize - 1).step_by(divisions as usize).collect::<Vec<_>>()
    };
    let (whole, halved) = (course(1), course(2));
    let apart = |place: usize| largest(whole.iter().zip(&halved).map(|(one, two)| (one[place] - two[place]).abs()));
    let (position, pressure) = (apart(0), apart(1));
    assert!(whole.iter().any(|[position, _]| *position > 0.3), "it moves");
    assert!(position < 2e-7 && pressure < 20.0, "{position} m, {pressure} Pa");
}

/// A duty cycle counts from the period on that begins after it is set, on a communication point or not.
#[test]
fn voltage_counts_at_the_beginning_of_a_period() {
    let mut running = switched("Stribeck", "Vented", &[("valveVoltage", 7.0)]).start().unwrap();
    running.advance(0.005).unwrap();
    running.set("valveVoltage", 9.0);
    running.advance(0.01).unwrap();
    close(running.get("switching.duty"), 0.4, 1e-15, "voltage counts at the beginning of a period");
    running.set("valveVoltage", 2.0);
    running.advance(0.011).unwrap();
    close(running.get("switching.duty"), -0.6, 1e-15, "voltage counts at the beginning of a period");
}

#[test]
fn saved_state_between_edges_goes_on_bit_for_bit() {
    let mut running = switched("LuGre", "Closed", &[("valveVoltage", 7.0)]).start().unwrap();
    // On the way of an armature.
    running.advance(0.1013).unwrap();
    let opening = running.get("switching.openingA");
    assert!(0.0 < opening && opening < 1.0, "{opening}");
    let saved = running.simulation().save();
    let names = ["position", "switching.openingA", "chamberB.pressure", "frictionForce"];
    running.advance(0.2).unwrap();
    let first = names.map(|name| running.get(name).to_bits());
    running.simulation().restore(&saved).unwrap();
    running.advance(0.2).unwrap();
    assert_eq!(names.map(|name| running.get(name).to_bits()), first);
}

/// Moves a host with a solver of its own and a co-simulation on for 100 ms, in which position, pressure in chamber A and another
/// variable, beside its tolerance, stay alike; returns the latter.
fn alike_for_100_ms(setup: &Setup, host: &mut Host, another: (&str, f64)) -> Plant {
    let mut inside = setup.start(0.0).unwrap();
    let table = setup.table();
    for step in 1..=100 {
        let time = f64::from(step) * 1e-3;
        host.advance(time);
        inside.advance_to(time).unwrap();
        let mut computed = vec![0.0; table.computed().count()];
        host.model.values(&mut computed);
        for (name, allowed) in [("position", 1e-8), ("chamberA.pressure", 1e-1), another] {
            let place = table.computed().position(|variable| variable.name == name).unwrap();
            let (found, expected) = (computed[place], inside.get(name).unwrap());
            close(found, expected, allowed, format_args!("{name} at {time} s, inside {expected}"));
        }
    }
    inside
}

/// A host with a solver of its own is told every edge as a time event, and comes to the same states.
#[test]
fn solver_outside_sees_every_edge() {
    let setup = Setup::new(&MODEL).set("actuation", "SwitchingValves").unwrap().set("valveVoltage", 7.0).unwrap();
    let setup = setup.set("friction.law", "LuGre").unwrap().set("solver.relativeTolerance", 1e-9).unwrap();
    let model = setup.exchange(0.0).unwrap().unwrap();
    let table = setup.table();
    let counts = [table.number_of_states(), MODEL.indicators().len()];
    let mut host =
        Host::new(model, setup.inputs(), counts, |_, inputs| inputs[..3].copy_from_slice(&[7.0, 0.0, 5e5]), 1e-9);
    let inside = alike_for_100_ms(&setup, &mut host, ("switching.openingA", 1e-9));
    assert!(inside.get("position").unwrap() > 0.25);
}

/// Each coil by a command of its own: chamber B is fed from 20 ms on, while chamber A is, and no longer vented. Choked, each gets
/// `C*p*rho0` times the time for which its valve is open, half of the travel included.
#[test]
fn each_coil_has_a_command_of_its_own() {
    let delay = 3e-3;
    let held = [("friction.coulombStiction.Fs", 1e6), ("supplyPressure", 20e5), ("switching.frequency", 1000.0)];
    let volumes = [("chamberA.deadVolume", 1.0), ("chamberB.deadVolume", 1.0), ("switching.openingDelay", delay)];
    let rig = switched("CoulombStiction", "Vented", &[held, volumes].concat()).choose("thermal.model", "Isothermal");
    let mut running = rig
        .choose("switching.command", "EachValve")
        .set("valveVoltageA", 10.0)
        .set("valveVoltageB", 0.0)
        .start()
        .unwrap();
    running.advance(0.02).unwrap();
    assert_eq!(running.get("chamberB.pressure"), 101_325.0, "closed");
    running.set("valveVoltageB", 10.0);
    running.advance(0.1).unwrap();
    let area = std::f64::consts::PI / 4.0 * 0.016f64.powi(2);
    let areas = [area, area - std::f64::consts::PI / 4.0 * 0.006f64.powi(2)];
    for ((name, begin), area) in [("chamberA.pressure", 0.0), ("chamberB.pressure", 0.02)].into_iter().zip(areas) {
        let open = 0.1 - begin - delay - 0.25e-3;
        let mean = 0.5 * 5e-4;
        let expected = open * CONDUCTANCE * 20e5 * 1.185 * GAS / (1.0 + 0.25 * area);
        let vented = mean * CONDUCTANCE * 20e5 * 1.185 * GAS;
        let found = running.get(name) - 101_325.0;
        // While it opens it vents a little, too, at a pressure that is hardly above that around it.
        close(found, expected, 1e-3 * vented, format_args!("{name}"));
    }
    assert_eq!(["switching.openingA", "switching.openingB"].map(|name| running.get(name)), [1.0, 1.0]);
}

/// Four valves with coils of their own, the piston held, gas at constant temperature, chambers as large as a room.
fn coils(values: &[(&str, f64)]) -> Rig {
    let held = [("friction.coulombStiction.Fs", 1e6), ("chamberA.deadVolume", 1.0), ("chamberB.deadVolume", 1.0)];
    switched("CoulombStiction", "Vented", &[&held, values].concat())
        .choose("switching.command", "EachCoil")
        .choose("thermal.model", "Isothermal")
}

/// Volumes of both chambers with their rooms, in m3.
fn rooms() -> [f64; 2] {
    let area = |diameter: f64| 0.25 * std::f64::consts::PI * diameter.powi(2);
    [area(0.016), area(0.016) - area(0.006)].map(|area| 1.0 + 0.25 * area)
}

/// Each coil opens its own valve. Choked, a valve brings or takes `C*p*rho0` times the time for which it is open, half of both travels
/// included, from the end of its delay on. The frequency of pulses has no effect.
#[test]
fn each_coil_opens_its_own_valve_after_its_delay() {
    const ON: f64 = 7.3e-3;
    const OFF: f64 = 31.9e-3;
    let delays = [("switching.openingDelay", 3e-3), ("switching.closingDelay", 5e-3), ("switching.travelTime", 5e-4)];
    let high = [("supplyPressure", 20e5), ("chamberA.pressure0", 10e5), ("chamberB.pressure0", 10e5)];
    let atmosphere = [("supplyPressure", 20e5), ("chamberA.pressure0", 2e5), ("chamberB.pressure0", 2e5)];
    for (place, coil) in ["coil[1]", "coil[2]", "coil[3]", "coil[4]"].into_iter().enumerate() {
        // The pressure in front of the valve: what fills is choked below a third of the supply, what vents above the surroundings'.
        let feeds = place.is_multiple_of(2);
        let start = if feeds { atmosphere } else { high };
        let mut running = coils(&[&delays[..], &start].concat()).start().unwrap();
        running.advance(ON).unwrap();
        running.set(coil, 1.0);
        running.advance(OFF).unwrap();
        running.set(coil, 0.0);
        running.advance(0.1).unwrap();
        let open = OFF + 5e-3 - ON - 3e-3;
        for (chamber, name) in ["chamberA.pressure", "chamberB.pressure"].into_iter().enumerate() {
            let before = start[1].1;
            let rate = CONDUCTANCE * 1.185 * GAS / rooms()[chamber];
            let expected = match (chamber == place / 2, feeds) {
                (false, _) => before,
                (true, true) => before + rate * 20e5 * open,
                // The pressure in front of the valve falls by a fraction of 1e-5 meanwhile.
                (true, false) => before * (-rate * open).exp(),
            };
            close(running.get(name), expected, 1e-10 * before, format_args!("{name} by {coil}"));
        }
    }
}

/// Nothing flows until the delay is over, to the last bit, and everything from then on; a command of no longer than the delay does
/// nothing.
#[test]
fn valve_opens_when_its_delay_is_over() {
    let delays = [("switching.openingDelay", 3e-3), ("switching.closingDelay", 2e-3), ("switching.travelTime", 0.0)];
    let mut running = coils(&delays).start().unwrap();
    let before = running.get("chamberA.pressure").to_bits();
    running.advance(0.01).unwrap();
    running.set("coil[1]", 1.0);
    running.advance(0.013).unwrap();
    assert_eq!((running.get("chamberA.pressure").to_bits(), running.get("switching.openingA")), (before, 0.0));
    running.set("coil[1]", 0.0);
    running.advance(0.05).unwrap();
    assert_eq!(running.get("chamberA.pressure").to_bits(), before, "a pulse as long as the delay");
    running.set("coil[1]", 1.0);
    running.advance(0.053 + 1e-9).unwrap();
    assert_eq!(running.get("switching.openingA"), 1.0);
    let fed = running.get("chamberA.pressure") - f64::from_bits(before);
    close(fed / (1e-9 * CONDUCTANCE * 5e5 * 1.185 * GAS / rooms()[0]), 1.0, 1e-3, "the flow of a nanosecond");
}

/// With the commands that pulses would give, and without delays, four coils are the two valves bit for bit.
#[test]
fn coils_driven_as_pulses_would_are_the_two_valves() {
    let direct = [("switching.openingDelay", 0.0), ("switching.closingDelay", 0.0), ("switching.travelTime", 0.0)];
    let values = [&direct[..], &[("switching.frequency", 1000.0)]].concat();
    let names = ["position", "velocity", "chamberA.pressure", "chamberB.pressure", "chamberA.temperature"];
    let course = |command: &str, centre: &str| {
        let mut running = switched("Stribeck", centre, &values).choose("switching.command", command).start().unwrap();
        let mut course = Vec::new();
        for step in 0..400 {
            let time = f64::from(step) * 1e-3;
            let [a, b] = [(step / 40) % 3 == 0, (step / 40) % 3 == 1].map(f64::from);
            let [vent_a, vent_b] = if centre == "Vented" { [1.0 - a, 1.0 - b] } else { [b, a] };
            let commands = [("valveVoltageA", 10.0 * a), ("valveVoltageB", 10.0 * b)];
            let coils = [("coil[1]", a), ("coil[2]", vent_a), ("coil[3]", b), ("coil[4]", vent_b)];
            commands.into_iter().chain(coils).for_each(|(name, value)| running.set(name, value));
            running.advance(time + 1e-3).unwrap();
            course.push(names.map(|name| running.get(name).to_bits()));
        }
        course
    };
    for centre in ["Vented", "Closed"] {
        let expected = course("EachValve", centre);
        assert!(expected.first() != expected.last(), "it moves");
        assert_eq!(course("EachCoil", centre), expected, "{centre}");
    }
}

/// Both valves of a chamber open: its pressure settles where the same conductance lets in, below the critical ratio's flow, what it
/// lets out choked, `r = p/ps` with `r^2 = 1 - ((r - b)/(1 - b))^2`; the supply is drawn from all the time.
#[test]
fn open_feeding_and_venting_valves_leak_from_supply_to_exhaust() {
    let held = [("friction.coulombStiction.Fs", 1e6), ("supplyPressure", 6e5), ("consumption.enabled", 1.0)];
    let rig = switched("CoulombStiction", "Vented", &held).choose("switching.command", "EachCoil");
    let rig = rig.choose("thermal.model", "Isothermal").set("coil[1]", 1.0).set("coil[2]", 1.0);
    let mut running = rig.start().unwrap();
    running.advance(3.0).unwrap();
    let b: f64 = 0.3;
    let ratio = {
        let (square, half, rest) = ((1.0 - b).powi(2) + 1.0, b, b.powi(2) - (1.0 - b).powi(2));
        (half + (half * half - square * rest).sqrt()) / square
    };
    close(running.get("chamberA.pressure") / 6e5, ratio, 1e-9, "pressure between two orifices");
    let through = CONDUCTANCE * ratio * 6e5 * 1.185;
    close(running.get("supply.massFlow") / through, 1.0, 1e-9, "what flows through");
    assert_eq!(running.get("chamberB.pressure"), 101_325.0, "closed without current");
}

/// All four armatures on their way, and a coil that is switched meanwhile.
#[test]
fn saved_state_between_coils_goes_on_bit_for_bit() {
    let slow = [("switching.travelTime", 0.02), ("switching.openingDelay", 2e-3)];
    let rig = switched("LuGre", "Vented", &slow).choose("switching.command", "EachCoil");
    let mut running = rig.set("coil[1]", 1.0).set("coil[4]", 1.0).start().unwrap();
    running.advance(0.0113).unwrap();
    running.set("coil[2]", 1.0);
    running.set("coil[1]", 0.0);
    let saved = running.simulation().save();
    let names = ["position", "switching.openingA", "chamberA.pressure", "chamberB.pressure", "frictionForce"];
    let mut go_on = || {
        running.simulation().restore(&saved).unwrap();
        running.set("coil[2]", 1.0);
        running.advance(0.0155).unwrap();
        running.set("coil[2]", 0.0);
        running.advance(0.1).unwrap();
        running.set("coil[1]", 0.0);
        names.map(|name| running.get(name).to_bits())
    };
    assert_eq!(go_on(), go_on());
}

/// A host with a solver of its own is told when each valve begins and ends to move, as time events.
#[test]
fn solver_outside_sees_every_motion_of_the_coils() {
    let set = |setup: Setup, (name, value): (&str, f64)| setup.set(name, value).unwrap();
    let values = [("coil[1]", 1.0), ("coil[4]", 1.0), ("switching.travelTime", 0.03), ("chamberB.pressure0", 4e5)];
    let setup = Setup::new(&MODEL).set("actuation", "SwitchingValves").unwrap();
    let setup = values.into_iter().fold(setup.set("switching.command", "EachCoil").unwrap(), set);
    let setup = setup.set("friction.law", "LuGre").unwrap().set("solver.relativeTolerance", 1e-10).unwrap();
    let table = setup.table();
    let counts = [table.number_of_states(), MODEL.indicators().len()];
    let mut host = Host::new(setup.exchange(0.0).unwrap().unwrap(), setup.inputs(), counts, |_, _| (), 1e-10);
    let inside = alike_for_100_ms(&setup, &mut host, ("chamberB.pressure", 1e-1));
    assert!((inside.get("position").unwrap() - 0.25).abs() > 1e-3, "it moves");
}

/// A valve that begins to open later has brought, or taken, less: by its choked flow times the delay; of a slower one half of it.
#[test]
fn sensitivities_pass_the_motions_of_the_coils() {
    let names = ["switching.openingDelay", "switching.travelTime"];
    for (coil, chamber, start) in [("coil[1]", "chamberA.pressure", 2e5), ("coil[4]", "chamberB.pressure", 10e5)] {
        let setup = |values: [f64; 2]| {
            let fixed = [("supplyPressure", 20e5), ("chamberA.pressure0", start), ("chamberB.pressure0", start)];
            let held =
                [("friction.coulombStiction.Fs", 1e6), ("chamberA.deadVolume", 1e-3), ("chamberB.deadVolume", 1e-3)];
            let setup = Setup::new(&MODEL).set("actuation", "SwitchingValves").unwrap();
            let setup =
                setup.set("switching.command", "EachCoil").unwrap().set("friction.law", "CoulombStiction").unwrap();
            let values = [(names[0], values[0]), (names[1], values[1]), ("solver.relativeTolerance", 1e-11)];
            [&fixed[..], &held, &values]
                .concat()
                .into_iter()
                .fold(setup, |setup, (name, value)| setup.set(name, value).unwrap())
        };
        let end = |values: [f64; 2]| {
            let mut plant = setup(values).start(0.0).unwrap();
            plant.set(coil, true).unwrap();
            plant.advance_to(0.05).unwrap();
            plant.get(chamber).unwrap()
        };
        let usual = [3e-3, 2e-2];
        let mut plant = setup(usual).start(0.0).unwrap();
        plant.set(coil, true).unwrap();
        plant.carry_sensitivities(&names).unwrap();
        plant.advance_to(0.05).unwrap();
        let place = plant.table().computed().position(|variable| variable.name == chamber).unwrap();
        for direction in 0..names.len() {
            let change = 1e-5;
            let [above, below] = [change, -change].map(|change| {
                let mut values = usual;
                values[direction] += change;
                end(values)
            });
            let (found, expected) = (plant.sensitivities(direction).unwrap()[place], (above - below) / (2.0 * change));
            close(found / expected, 1.0, 1e-5, format_args!("{chamber} by {}: {found}", names[direction]));
        }
    }
}

#[test]
fn coil_is_true_or_false() {
    let mut plant = Setup::new(&MODEL).start(0.0).unwrap();
    plant.set("coil[2]", true).unwrap();
    assert_eq!(plant.get("coil[2]").unwrap(), 1.0);
    for refusal in [
        plant.set("coil[2]", 0.5).unwrap_err().to_string(),
        plant.set_slope("coil[2]", 1.0).unwrap_err().to_string(),
        plant.carry_sensitivities(&["coil[2]"]).unwrap_err().to_string(),
    ] {
        assert!(refusal.contains("coil[2]") && refusal.contains("true"), "{refusal}");
    }
    assert_eq!(plant.get("coil[2]").unwrap(), 1.0, "nothing is changed");
}
