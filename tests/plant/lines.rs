//! Hoses, flow controls, cushions and the vessel of the supply, against closed forms.

use std::f64::consts::{PI, TAU};

use crate::bounds::{close, farthest, largest, within};
use crate::rig::Rig;
use pneumatic_servo::model::Plant;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

/// `R*T` in J/kg.
const GAS: f64 = 287.05 * 293.15;
pub const AMBIENT: f64 = 101_325.0;
/// Of air in Pa s.
const VISCOSITY: f64 = 1.813e-5;

fn area(diameter: f64) -> f64 {
    PI * diameter * diameter / 4.0
}

/// The piston held by more friction than any pressure overcomes, gas at constant temperature, a tight valve without dead
/// zone.
pub fn held(values: &[(&str, f64)]) -> Plant {
    let setup = Setup::new(&MODEL).set("friction.law", "CoulombStiction").unwrap();
    let mut setup = setup.set("thermal.model", "Isothermal").unwrap().tolerance(1e-9);
    let common = [
        ("friction.coulombStiction.Fs", 1e6),
        ("valve.leakage", 0.0),
        ("valve.deadZone", 0.0),
        ("valve.hysteresis", 0.0),
    ];
    for (name, value) in common.iter().chain(values) {
        setup.change(name, *value).unwrap();
    }
    setup.start(0.0).unwrap()
}

pub fn get(plant: &mut Plant, name: &str) -> f64 {
    plant.get(name).unwrap()
}

/// A hose that is closed by the valve and open to a chamber as large as a room swings at `c/(4*L)`, `c = sqrt(R*T)`, if
/// it starts from the shape of that wave.
#[test]
fn closed_hose_swings_at_its_quarter_wave_frequency() {
    for (length, diameter) in [(0.3, 0.006), (2.0, 0.01), (10.0, 0.02)] {
        let mut plant = held(&[("hoseA.length", length), ("hoseA.diameter", diameter), ("chamberA.deadVolume", 1.0)]);
        for (k, name) in ["hoseA.pressure[1]", "hoseA.pressure[2]", "hoseA.pressure[3]"].into_iter().enumerate() {
            plant.move_state(name, AMBIENT + 100.0 * (PI / 6.0 * k as f64).cos()).unwrap();
        }
        let expected = GAS.sqrt() / (4.0 * length);
        let (mut times, mut before, interval) = (Vec::new(), 100.0, 0.01 / expected);
        while times.len() < 6 {
            plant.step(interval).unwrap();
            let now = get(&mut plant, "hoseA.pressure[1]") - AMBIENT;
            if before < 0.0 && now >= 0.0 {
                times.push(plant.time() - interval * now / (now - before));
            }
            before = now;
        }
        let found = 5.0 / (times[5] - times[0]);
        close(found / expected, 1.0, 0.02, format_args!("{found} Hz, not {expected} Hz, of {length} m"));
    }
}

/// Choked flow of the valve through a hose into a chamber as large as a room: `p_1^2 - p_4^2 = R*T*phi*mu*L*mdot/(A*d^2)`
/// with `phi` = 64 in laminar flow, by the law of Blasius beyond.
#[test]
fn steady_flow_loses_the_pressure_of_hagen_and_poiseuille_or_of_blasius() {
    let (length, diameter) = (2.0, 0.004);
    for (conductance, is_turbulent) in [(1e-12, false), (5e-12, false), (1e-10, true), (1e-9, true)] {
        let mut plant = held(&[
            ("hoseA.length", length),
            ("hoseA.diameter", diameter),
            ("chamberA.deadVolume", 1.0),
            ("valve.C", conductance),
            ("supplyPressure", 20e5),
            ("valveVoltage", 10.0),
        ]);
        plant.advance_to(1.0).unwrap();
        let flow = conductance * 20e5 * 1.185;
        let found_flow = get(&mut plant, "chamberA.massFlow");
        close(found_flow / flow, 1.0, 1e-4, format_args!("{found_flow} kg/s, not {flow}"));
        let reynolds = flow * diameter / (area(diameter) * VISCOSITY);
        assert_eq!(reynolds > 1188.0, is_turbulent, "{reynolds}");
        let factor = if is_turbulent { 0.3164 * reynolds.powf(0.75) } else { 64.0 };
        let expected = GAS * factor * VISCOSITY * length * flow / (area(diameter) * diameter.powi(2));
        let [first, last] = ["hoseA.pressure[1]", "chamberA.pressure"].map(|name| get(&mut plant, name));
        let found = first * first - last * last;
        // The room fills, and the hose with it.
        close(found / expected, 1.0, 1e-4, format_args!("{found} Pa2, not {expected}, at Re = {reynolds}"));
    }
}

/// The inflow is found in chamber and hose at one pressure.
#[test]
fn hose_has_its_volume() {
    let mut plant = held(&[("hoseA.length", 3.0), ("hoseA.diameter", 0.008), ("supplyPressure", 8e5)]);
    let volume = 5e-6 + area(0.016) * 0.25 + area(0.008) * 3.0;
    let mass = |plant: &mut Plant| get(plant, "balance.massResidual");
    assert_eq!(mass(&mut plant), 0.0);
    plant.set("valveVoltage", 10.0).unwrap();
    // Choked until the hose has 2.4 bar at the valve: the spool's opening alone decides the flow.
    let mut received = 0.0;
    for _ in 0..400 {
        let before = get(&mut plant, "valve.spool");
        plant.step(5e-5).unwrap();
        received += 0.5 * (before + get(&mut plant, "valve.spool")) * 5e-5 * 3.93e-9 * 8e5 * 1.185;
    }
    assert!(get(&mut plant, "hoseA.pressure[1]") < 2.4e5);
    plant.set("valveVoltage", 5.0).unwrap();
    for _ in 0..400 {
        let before = get(&mut plant, "valve.spool").max(0.0);
        plant.step(5e-5).unwrap();
        received += 0.5 * (before + get(&mut plant, "valve.spool").max(0.0)) * 5e-5 * 3.93e-9 * 8e5 * 1.185;
    }
    plant.step(3.0).unwrap();
    let expected = AMBIENT + received * GAS / volume;
    for name in ["hoseA.pressure[1]", "hoseA.pressure[2]", "hoseA.pressure[3]", "chamberA.pressure"] {
        let found = get(&mut plant, name);
        // The spool swings back through the centre and vents a little.
        assert!((found - AMBIENT) / (expected - AMBIENT) > 0.99 && found < expected, "{name}: {found}, not {expected}");
    }
}

/// No hose, however short and wide, has waves that a solver must follow for long: five milliseconds take fewer steps than
/// one millisecond may.
#[test]
fn hose_of_any_size_runs_in_bounded_time() {
    for diameter in [5e-4, 4e-3, 0.1] {
        for length in [1e-4, 1e-3, 5e-3, 2e-2, 0.1, 1.0] {
            for tolerance in [1e-6, 1e-8] {
                let values = [
                    ("hoseA.length", length),
                    ("hoseB.length", length),
                    ("hoseA.diameter", diameter),
                    ("hoseB.diameter", diameter),
                    ("valveVoltage", 7.0),
                ];
                let mut setup = Setup::new(&MODEL).tolerance(tolerance);
                for (name, value) in values {
                    setup.change(name, value).unwrap();
                }
                let mut plant = setup.start(0.0).unwrap();
                let place = format!("{length} m of {diameter} m at {tolerance}");
                for _ in 0..5 {
                    plant.step(1e-3).unwrap_or_else(|error| panic!("{place}: {error}"));
                }
                let [steps, rejected] = ["solver.steps", "solver.rejectedSteps"].map(|name| get(&mut plant, name));
                assert!(steps + rejected < 5e3, "{place}: {steps} steps, {rejected} rejected");
            }
        }
    }
}

#[test]
fn hose_shorter_than_the_shortest_is_refused() {
    let error = Rig::cylinder("Stribeck").set("hoseB.length", 9e-5).start().err().unwrap();
    assert_eq!(error.to_string(), "hoseB.length = 0.00009 is refused: it must be 0, for no hose, or at least 0.0001");
}

/// A tenth of a millimetre of hose is no more than its volume of a few cubic millimetres, as dead volume. The gas is isothermal, since a
/// hose of any length brings the air to the temperature of its surroundings.
#[test]
fn shortest_hose_is_none() {
    for diameter in [0.003, 0.006] {
        let [apart, _] = short_hose_against_none(diameter, "Isothermal", 0.5);
        within(apart, 1e-6, format_args!("{diameter} m"));
    }
}

/// With an energy balance the air that leaves a chamber is not at ambient temperature, at which it comes out of a hose of any
/// length: the figures on the page, for half a second and for the whole of the default experiment.
#[test]
fn shortest_hose_brings_the_air_to_ambient_temperature() {
    for (seconds, position, pressure) in [(0.5, 5e-4, 340.0), (3.0, 2.9e-3, 2.5e3)] {
        let found = short_hose_against_none(0.004, "EnergyBalance", seconds);
        close(found[0], position, 0.02 * position, format_args!("m in {seconds} s"));
        close(found[1], pressure, 0.02 * pressure, format_args!("Pa in {seconds} s"));
    }
}

/// The largest differences in m and in Pa from a cylinder with the volume of the hoses as dead volume.
fn short_hose_against_none(diameter: f64, thermal: &str, seconds: f64) -> [f64; 2] {
    let run = |length: f64, dead_volume: f64| {
        let rig = Rig::cylinder("Stribeck").set("hoseA.length", length).set("hoseB.length", length);
        let rig = rig.set("hoseA.diameter", diameter).set("hoseB.diameter", diameter);
        let rig = rig.set("chamberA.deadVolume", dead_volume).set("chamberB.deadVolume", dead_volume);
        let mut running = rig.choose("thermal.model", thermal).start().unwrap();
        let mut course = Vec::new();
        for step in 0..(seconds * 1e3) as u32 {
            let time = f64::from(step) * 1e-3;
            running.set("valveVoltage", 5.0 + 2.0 * (TAU * time).sin());
            running.advance(time + 1e-3).unwrap();
            course.push(["position", "chamberA.pressure"].map(|name| running.get(name)));
        }
        course
    };
    let (with, without) = (run(1e-4, 5e-6), run(0.0, 5e-6 + area(diameter) * 1e-4));
    assert!(largest(without.iter().map(|[position, _]| (position - 0.25).abs())) > 0.01, "the carriage has moved");
    [0, 1].map(|place| {
        let [with, without] = [&with, &without].map(|course| course.iter().map(|row| row[place]).collect::<Vec<_>>());
        farthest(&with, &without)
    })
}

/// A gas leaves chamber A through its flow control at `C*p*rho0`, and enters it by the free conductance; metered in, the
/// other way round.
#[test]
fn flow_control_throttles_one_way() {
    for (direction, out, into) in [(1.0, 1e-10, 3e-10), (2.0, 3e-10, 1e-10)] {
        let flow = |voltage: f64, pressure: f64| {
            let mut plant = held(&[
                ("hoseA.length", 0.2),
                ("hoseA.diameter", 0.01),
                ("throttleA.C", 1e-10),
                ("throttle.free", 3e-10),
                ("throttle.direction", direction),
                ("chamberA.deadVolume", 1.0),
                ("chamberA.pressure0", pressure),
                ("supplyPressure", 20e5),
                ("valveVoltage", voltage),
            ]);
            plant.advance_to(1.0).unwrap();
            let [chamber, hose] = ["chamberA.pressure", "hoseA.pressure[4]"].map(|name| get(&mut plant, name));
            get(&mut plant, "chamberA.massFlow") / (chamber.max(hose) * 1.185)
        };
        let (found_out, found_in) = (-flow(0.0, 10e5), flow(10.0, 1e5));
        close(found_out / out, 1.0, 1e-14, format_args!("{found_out}, not {out}"));
        close(found_in / into, 1.0, 1e-14, format_args!("{found_in}, not {into}"));
    }
}

/// Speed of the piston as it meets the stop.
#[test]
fn cushion_takes_the_speed_before_the_stop() {
    let impact = |cushion: f64| {
        // Little dead volume, so that there is something to compress.
        let rig = Rig::cylinder("Stribeck").set("chamberB.deadVolume", 5e-7).set("hoseA.length", 0.2);
        let mut running =
            rig.set("hoseB.length", 0.2).set("cushion.length", cushion).set("valveVoltage", 10.0).start().unwrap();
        let mut speed = 0.0;
        for step in 1..2000 {
            running.advance(f64::from(step) * 1e-3).unwrap();
            if running.get("position") >= 0.5 {
                return speed;
            }
            speed = running.get("velocity");
        }
        panic!("the piston does not arrive")
    };
    let (hard, soft) = (impact(0.0), impact(0.02));
    assert!(soft < hard * 2.0 / 3.0, "{soft} m/s with, {hard} m/s without");
}

/// Mass flow in kg/s through an orifice (ISO 6358) with the critical ratio 0.3, between air of the reference temperature.
fn orifice(conductance: f64, from: f64, to: f64) -> f64 {
    let excess = ((to / from - 0.3) / 0.7).max(0.0);
    conductance * from * 1.185 * (1.0 - excess * excess).sqrt()
}

/// Screwed into the port, a flow control is in series with the edge of the valve: as much flows through both, and the pressure
/// between them is found by bisection.
#[test]
fn flow_control_in_the_port_is_in_series_with_the_valve() {
    for (throttle, chamber) in [(5e-10, 6e5), (2e-9, 6e5), (2e-9, 2e5)] {
        let mut plant = held(&[
            ("throttleA.C", throttle),
            ("hoseA.diameter", 0.02),
            ("chamberA.deadVolume", 1.0),
            ("chamberA.pressure0", chamber),
            ("valveVoltage", 0.0),
        ]);
        plant.advance_to(0.2).unwrap();
        let chamber = get(&mut plant, "chamberA.pressure");
        let [mut low, mut high] = [AMBIENT, chamber];
        for _ in 0..100 {
            let between = 0.5 * (low + high);
            let is_low = orifice(3.93e-9, between, AMBIENT) < orifice(throttle, chamber, between);
            if is_low { low = between } else { high = between }
        }
        let (found, expected) = (-get(&mut plant, "chamberA.massFlow"), orifice(throttle, chamber, low));
        // The passage between them has some friction of its own.
        close(found / expected, 1.0, 2e-3, format_args!("{found} kg/s, not {expected}, of {throttle}"));
        let between = get(&mut plant, "hoseA.pressure[4]");
        close(between / low, 1.0, 2e-3, format_args!("{between} Pa, not {low}"));
    }
}

/// A cushion without a hose takes the speed, too; what it needs is air in front of it.
#[test]
fn port_without_a_hose_has_a_passage_of_50_mm() {
    let course = |length: f64| {
        let rig =
            Rig::cylinder("Stribeck").set("throttleA.C", 1e-9).set("throttleB.C", 1e-9).set("cushion.length", 0.02);
        let mut running =
            rig.set("hoseA.length", length).set("hoseB.length", length).set("valveVoltage", 10.0).start().unwrap();
        running.advance(0.5).unwrap();
        running.get("position")
    };
    assert_eq!(course(0.0).to_bits(), course(0.05).to_bits());
}

/// Choked filling through `supply.C` is linear in time, and the valve sees the vessel.
#[test]
fn vessel_fills_and_droops() {
    let mut plant = held(&[("supply.volume", 2e-3), ("supply.C", 1e-9), ("supplyPressure", AMBIENT)]);
    plant.set("supplyPressure", 20e5).unwrap();
    plant.advance_to(0.1).unwrap();
    let found = get(&mut plant, "supply.vesselPressure");
    let expected = AMBIENT + GAS / 2e-3 * 1e-9 * 20e5 * 1.185 * 0.1;
    close(found / expected, 1.0, 1e-14, format_args!("{found} Pa, not {expected}"));

    // Cut off, the vessel gives the chamber what it has: one pressure in both at the end.
    let mut plant =
        held(&[("supply.volume", 1e-4), ("supply.C", 1e-13), ("supplyPressure", 6e5), ("valveVoltage", 10.0)]);
    plant.advance_to(1.0).unwrap();
    let chamber = 5e-6 + area(0.016) * 0.25;
    let expected = (6e5 * 1e-4 + AMBIENT * chamber) / (1e-4 + chamber);
    for name in ["supply.vesselPressure", "chamberA.pressure"] {
        let found = get(&mut plant, name);
        // The supply adds some 40 Pa through the smallest conductance there is.
        close(found / expected, 1.0, 1e-4, format_args!("{name}: {found}, not {expected}"));
    }
}

/// A valve empties a vessel into a chamber until both are the same, below ambient pressure. A supply below ambient acts as ambient: the
/// vessel starts there.
#[test]
fn vessel_below_ambient_gives_what_it_has() {
    let mut plant = held(&[
        ("supply.volume", 1e-5),
        ("supply.C", 1e-13),
        ("supplyPressure", 5e4),
        ("valveVoltage", 10.0),
        ("chamberA.pressure0", 2e4),
    ]);
    plant.advance_to(1.0).unwrap();
    let chamber = 5e-6 + area(0.016) * 0.25;
    let expected = (AMBIENT * 1e-5 + 2e4 * chamber) / (1e-5 + chamber);
    for name in ["supply.vesselPressure", "chamberA.pressure"] {
        let found = get(&mut plant, name);
        // The supply adds some 10 Pa through the smallest conductance there is.
        close(found / expected, 1.0, 1e-3, format_args!("{name}: {found}, not {expected}"));
    }
}

/// A solver inside and one outside start alike where nothing is connected to the supply.
#[test]
fn vessel_without_a_supply_starts_at_ambient_pressure() {
    let setup = Setup::new(&MODEL).set("supply.volume", 1e-3).unwrap().set("supplyPressure", 0.0).unwrap();
    let mut plant = setup.start(0.0).unwrap();
    close(get(&mut plant, "supply.vesselPressure"), AMBIENT, 0.0, "in co-simulation");
    plant.advance_to(0.1).unwrap();
    close(get(&mut plant, "supply.vesselPressure"), AMBIENT, 1e-6, "in co-simulation");
    assert!(setup.exchange(0.0).unwrap().is_some(), "in model exchange");
}

/// Whoever asks for a hose where the port is plugged is told.
#[test]
fn line_to_an_open_chamber_is_told() {
    for (name, value) in [("hoseB.length", 1.0), ("throttleB.C", 1e-9), ("quickExhaustB.C", 1e-8)] {
        let noticed = |open: f64| {
            let setup = Setup::new(&MODEL).set(name, value).unwrap().set("chamberB.open", open).unwrap();
            setup.start(0.0).unwrap().notices().any(|notice| notice.variable == name && notice.value == value)
        };
        assert_eq!([0.0, 1.0].map(noticed), [false, true], "{name}");
    }
}

/// Commanded to 20 bar it fills the chamber from a vessel at 5 bar that nothing refills: to one pressure in both. Commanded
/// to less, it vents the chamber, and the vessel keeps what it has.
#[test]
fn regulator_gives_no_more_than_its_vessel_has_and_takes_nothing_back() {
    let mut plant = held(&[
        ("actuation", 2.0),
        ("regulator.pMax", 20e5),
        ("supply.volume", 1e-4),
        ("supply.C", 1e-13),
        ("valveVoltage", 10.0),
    ]);
    plant.advance_to(2.0).unwrap();
    let chamber = 5e-6 + area(0.016) * 0.25;
    let expected = (5e5 * 1e-4 + AMBIENT * chamber) / (1e-4 + chamber);
    let [vessel, filled] = ["supply.vesselPressure", "chamberA.pressure"].map(|name| get(&mut plant, name));
    for found in [vessel, filled] {
        // The supply adds some 100 Pa through the smallest conductance there is.
        close(found / expected, 1.0, 1e-3, format_args!("{found}, not {expected}"));
    }
    plant.set("valveVoltage", 0.0).unwrap();
    plant.advance_to(4.0).unwrap();
    let [kept, left] = ["supply.vesselPressure", "chamberA.pressure"].map(|name| get(&mut plant, name));
    assert!(kept >= vessel, "{kept}, not {vessel}");
    close(kept / vessel, 1.0, 1e-3, "of what the vessel has");
    close(left / 1e5, 1.0, 1e-14, format_args!("{left} Pa at 0 V"));
}

/// Everything at once, under the regulator, too; bounds as in the balances of the plain cylinder.
#[test]
fn mass_and_energy_balance_with_all_lines() {
    for actuation in ["ProportionalValve", "PressureRegulator", "SwitchingValves"] {
        let mut rig = Rig::cylinder("Stribeck").choose("actuation", actuation).set("balance.enabled", 1.0);
        for (name, value) in ALL_LINES {
            rig = rig.set(name, value);
        }
        let mut running = rig.set("position0", 0.45).start().unwrap();
        for step in 0..1000 {
            let time = f64::from(step) * 1e-3;
            running.set("valveVoltage", 5.0 + 2.0 * (TAU * time).sin());
            running.advance(time + 1e-3).unwrap();
            let [mass, energy] = ["mass", "energy"].map(|name| running.get(&format!("balance.{name}Residual")).abs());
            within(mass, 4e-11, format_args!("{actuation}, kg at {time} s"));
            within(energy, 5e-4, format_args!("{actuation}, J at {time} s"));
        }
    }
}

/// Leakage past the piston leaves the cylinder where chamber B is open, also with a hose: 12 mg in a second.
#[test]
fn leakage_into_an_open_chamber_is_accounted_for() {
    let rig = Rig::cylinder("Stribeck").set("chamberB.open", 1.0).set("piston.leakage", 1e-16);
    for length in [0.0, 1.0] {
        let rig = rig.clone().set("balance.enabled", 1.0).set("hoseA.length", length).set("valveVoltage", 7.0);
        let mut running = rig.start().unwrap();
        running.advance(1.0).unwrap();
        let residual = running.get("balance.massResidual");
        within(residual.abs(), 1e-10, format_args!("kg, {length} m"));
    }
}

/// In a cushion whose check valve opens 200 times as wide as the cushion is, at the end of a hose of half a cubic millimetre:
/// as the piston turns, the check valve closes.
#[test]
fn check_valve_that_closes_stops_no_solver() {
    let values = [
        ("hoseA.length", 0.5),
        ("hoseB.length", 1e-3),
        ("hoseB.diameter", 8e-4),
        ("cushion.length", 0.02),
        ("cushion.C", 5e-11),
        ("valveVoltage", 2.0),
    ];
    for (law, position) in [("Stribeck", 0.499), ("Stribeck", 0.4992), ("Stribeck", 0.49), ("LuGre", 0.499)] {
        let rig = Rig::cylinder(law).choose("actuation", "PressureRegulator").set("position0", position);
        let mut running = values.iter().fold(rig, |rig, (name, value)| rig.set(name, *value)).start().unwrap();
        for step in 1..=200 {
            let place = format!("{law} from {position} m at {step} ms");
            running.advance(f64::from(step) * 1e-3).unwrap_or_else(|error| panic!("{place}: {error}"));
        }
        let [steps, rejected] = ["solver.steps", "solver.rejectedSteps"].map(|name| running.get(name));
        assert!(steps + rejected < 5e3, "{law} from {position} m: {steps} steps, {rejected} rejected");
    }
}

#[test]
fn cushion_longer_than_the_stroke_is_refused() {
    let rig = Rig::cylinder("Stribeck").set("hoseA.length", 0.2).set("hoseB.length", 0.2);
    let error = rig.set("cushion.length", 0.6).start().err().unwrap();
    let expected = "cushion.length = 0.6 is refused: it must not exceed cylinder.stroke = 0.5";
    assert_eq!(error.to_string(), expected);
}

const ALL_LINES: [(&str, f64); 9] = [
    ("hoseA.length", 1.5),
    ("hoseB.length", 0.8),
    ("hoseB.diameter", 0.003),
    ("throttleA.C", 2e-9),
    ("throttleB.C", 1e-9),
    ("cushion.length", 0.02),
    ("supply.volume", 4e-4),
    ("supply.C", 3e-9),
    ("piston.leakage", 1e-16),
];

#[test]
fn saved_state_of_a_cylinder_with_lines_goes_on_bit_for_bit() {
    let mut rig = Rig::cylinder("LuGre");
    for (name, value) in ALL_LINES {
        rig = rig.set(name, value);
    }
    let mut running = rig.set("valveVoltage", 7.0).start().unwrap();
    running.advance(0.1).unwrap();
    let saved = running.simulation().save();
    let names = ["position", "hoseA.massFlow[3]", "hoseB.pressure[4]", "supply.vesselPressure", "frictionForce"];
    running.advance(0.2).unwrap();
    let first = names.map(|name| running.get(name).to_bits());
    running.simulation().restore(&saved).unwrap();
    running.advance(0.2).unwrap();
    assert_eq!(names.map(|name| running.get(name).to_bits()), first);
}

/// Errors of the position in m and of the pressure in chamber A in Pa at a tolerance, beside a run at 1e-10, over the first
/// milliseconds of the default experiment with hoses of a length in m; and solver steps, those among them with a Jacobian,
/// and the most tries in a millisecond.
fn deviation(law: &str, length: f64, values: &[(&str, f64)], milliseconds: u32) -> ([f64; 2], [f64; 3]) {
    let run = |tolerance: f64| {
        let mut setup = Setup::new(&MODEL).set("friction.law", law).unwrap().tolerance(tolerance);
        for (name, value) in [("hoseA.length", length), ("hoseB.length", length)].iter().chain(values) {
            setup.change(name, *value).unwrap();
        }
        let mut plant = setup.start(0.0).unwrap();
        let (mut rows, mut tries, mut most) = (Vec::new(), 0.0, 0.0);
        for row in 0..milliseconds {
            plant.set("valveVoltage", 5.0 + 2.0 * (TAU * f64::from(row) * 1e-3).sin()).unwrap();
            plant.advance_to(f64::from(row + 1) * 1e-3).unwrap();
            rows.push(["position", "chamberA.pressure"].map(|name| get(&mut plant, name)));
            let before = tries;
            tries = get(&mut plant, "solver.steps") + get(&mut plant, "solver.rejectedSteps");
            most = f64::max(most, tries - before);
        }
        (rows, [get(&mut plant, "solver.steps"), get(&mut plant, "solver.jacobians"), most])
    };
    let ((rows, counts), (exact, _)) = (run(1e-6), run(1e-10));
    let error = |i: usize| largest(rows.iter().zip(&exact).map(|(row, exact)| (row[i] - exact[i]).abs()));
    ([error(0), error(1)], counts)
}

/// Where accuracy bounds the steps, explicit ones are a fifth as costly as implicit ones. Short hoses swing too quickly for
/// them, and so does the last volume of a hose behind a wide port.
#[test]
fn long_hoses_take_explicit_steps_and_short_or_stiff_ones_implicit_steps() {
    let wide = |free: f64| vec![("throttleA.C", 1e-9), ("throttleB.C", 1e-9), ("throttle.free", free)];
    let cases = [
        ("Stribeck", 1.0, vec![], true, 4.0),
        ("LuGre", 1.0, vec![], true, 4.0),
        ("Stribeck", 1.0, wide(1e-8), true, 6.0),
        ("Stribeck", 0.1, vec![], true, 12.0),
        ("Stribeck", 0.015, vec![], false, 4.0),
        ("Stribeck", 0.1, wide(1e-7), false, 6.0),
        ("Stribeck", 0.1, wide(1e-6), false, 6.0),
        ("Stribeck", 0.1, wide(1e-5), false, 6.0),
    ];
    for (law, length, values, is_explicit, most) in cases {
        let place = format!("{law}, {length} m, {values:?}");
        let ([position, pressure], [steps, jacobians, worst]) = deviation(law, length, &values, 300);
        // A twentieth of what is promised of the cylinder without hoses.
        assert!(position < 0.05e-6 && pressure < 0.05, "{place}: {position} m, {pressure} Pa");
        let share = jacobians / steps;
        assert!(if is_explicit { share < 0.05 } else { share == 1.0 }, "{place}: {share} of the steps have a Jacobian");
        assert!(steps < most * 300.0 && worst < 200.0, "{place}: {steps} steps, {worst} in a millisecond");
    }
}
