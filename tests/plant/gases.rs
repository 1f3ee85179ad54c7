//! Gases other than air, against closed forms: chambers that empty through nozzles, waves and losses in hoses, leaks.

use std::f64::consts::PI;

use crate::bounds::{close, within};
use pneumatic_servo::model::{Plant, Setup};
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

const AMBIENT: f64 = 101_325.0;
const TEMPERATURE: f64 = 293.15;

/// Specific gas constant in J/(kg K), ratio of specific heats, viscosity in Pa s.
#[derive(Clone, Copy, Debug)]
struct Gas([f64; 3]);

const AIR: Gas = Gas([287.05, 1.4, 1.813e-5]);
const NITROGEN: Gas = Gas([296.8, 1.4, 1.76e-5]);
const HELIUM: Gas = Gas([2077.1, 1.667, 1.96e-5]);
const ARGON: Gas = Gas([208.13, 1.67, 2.23e-5]);
const CARBON_DIOXIDE: Gas = Gas([188.92, 1.29, 1.47e-5]);
const GASES: [Gas; 5] = [AIR, NITROGEN, HELIUM, ARGON, CARBON_DIOXIDE];
const NAMES: [&str; 3] = ["gas.R", "gas.gamma", "gas.viscosity"];

impl Gas {
    /// `R*T` in J/kg at the reference temperature.
    fn energy(self) -> f64 {
        self.0[0] * TEMPERATURE
    }

    /// The largest mass flow of isentropic flow over all pressures in the throat, in units of `A*p/sqrt(R*T)`: the energy equation
    /// gives the velocity, the isentrope the density.
    fn choked(self) -> f64 {
        let gamma = self.0[1];
        let flow = |ratio: f64| {
            let velocity = (2.0 * gamma / (gamma - 1.0) * (1.0 - ratio.powf((gamma - 1.0) / gamma))).sqrt();
            ratio.powf(1.0 / gamma) * velocity
        };
        let (mut low, mut high) = (0.1, 0.9);
        for _ in 0..60 {
            let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            (low, high) = if flow(left) < flow(right) { (left, high) } else { (low, right) };
        }
        flow(low)
    }

    /// Rate in 1/s at which choked flow through a conductance, that for air, takes the gas at the reference temperature from a volume.
    fn emptying(self, conductance: f64, volume: f64) -> f64 {
        let area = conductance * 1.185 * AIR.energy().sqrt() / AIR.choked();
        area * self.choked() * self.energy().sqrt() / volume
    }

    fn of(self, setup: Setup) -> Setup {
        NAMES.into_iter().zip(self.0).fold(setup, |setup, (name, value)| setup.set(name, value).unwrap())
    }
}

/// The piston held by more friction than any pressure overcomes, and a tight valve without dead zone.
fn held(gas: Gas, thermal: &str, values: &[(&str, f64)]) -> Setup {
    let setup = Setup::new(&MODEL).set("friction.law", "CoulombStiction").unwrap();
    let mut setup = gas.of(setup.set("thermal.model", thermal).unwrap().tolerance(1e-9));
    let common = [
        ("friction.coulombStiction.Fs", 1e6),
        ("thermal.heatTransfer", 0.0),
        ("valve.leakage", 0.0),
        ("valve.deadZone", 0.0),
        ("valve.hysteresis", 0.0),
    ];
    common.iter().chain(values).for_each(|(name, value)| setup.change(name, *value).unwrap());
    setup
}

fn get(plant: &Plant, name: &str) -> f64 {
    plant.get(name).unwrap()
}

fn area(diameter: f64) -> f64 {
    PI * diameter * diameter / 4.0
}

const LEAK: f64 = 2e-6;
/// Chamber A in m3.
fn volume() -> f64 {
    1.0 + area(0.016) * 0.25
}

/// Chamber A at 20 bar after 1 s through a leak whose flow is choked all the time.
fn emptied(gas: Gas, thermal: &str) -> Plant {
    let values = [("chamberA.deadVolume", 1.0), ("chamberA.pressure0", 20e5), ("chamberA.leakage", LEAK)];
    let mut plant = held(gas, thermal, &values).start(0.0).unwrap();
    plant.advance_to(1.0).unwrap();
    plant
}

/// `p = p0*exp(-k*t)` at constant temperature.
#[test]
fn chamber_at_constant_temperature_empties_as_a_nozzle_lets_it() {
    for gas in GASES {
        let found = get(&emptied(gas, "Isothermal"), "chamberA.pressure");
        let expected = 20e5 * (-gas.emptying(LEAK, volume())).exp();
        close(found / expected, 1.0, 1e-8, format_args!("{found} Pa, not {expected}, of {gas:?}"));
    }
}

/// `T = T0/(1 + (gamma - 1)/2*k*t)^2` and `p = p0*(T/T0)^(gamma/(gamma - 1))` without heat from the wall.
#[test]
fn adiabatic_chamber_empties_along_the_isentrope() {
    for gas in GASES {
        let (plant, gamma) = (emptied(gas, "EnergyBalance"), gas.0[1]);
        let cooling = (1.0 + 0.5 * (gamma - 1.0) * gas.emptying(LEAK, volume())).powi(-2);
        let (temperature, pressure) = (TEMPERATURE * cooling, 20e5 * cooling.powf(gamma / (gamma - 1.0)));
        close(get(&plant, "chamberA.temperature"), temperature, 1e-5, format_args!("K, of {gas:?}"));
        close(get(&plant, "chamberA.pressure") / pressure, 1.0, 1e-7, format_args!("of {pressure} Pa, of {gas:?}"));
    }
}

/// A valve and a quick exhaust valve pass as much of a gas as the nozzle of the same area.
#[test]
fn valves_are_nozzles() {
    for gas in GASES {
        let values =
            [("supplyPressure", 20e5), ("valveVoltage", 10.0), ("valve.C", 1e-9), ("chamberA.deadVolume", 0.1)];
        let valve = held(gas, "Isothermal", &values).start(0.0).map(|mut plant| {
            plant.advance_to(0.2).unwrap();
            get(&plant, "chamberA.massFlow") / 20e5
        });
        let values = [("quickExhaustA.C", 1e-9), ("chamberA.pressure0", 9e5), ("chamberA.deadVolume", 0.1)];
        let exhaust = held(gas, "Isothermal", &values).set("valveVoltage", 0.0).unwrap().start(0.0).map(|mut plant| {
            plant.advance_to(0.2).unwrap();
            -get(&plant, "chamberA.massFlow") / get(&plant, "chamberA.pressure")
        });
        let expected = gas.emptying(1e-9, 1.0) / gas.energy();
        for found in [valve.unwrap(), exhaust.unwrap()] {
            close(found / expected, 1.0, 1e-6, format_args!("{found} kg/(s.Pa), not {expected}, of {gas:?}"));
        }
    }
}

/// A hose that is closed by the valve and open to a chamber as large as a room swings at `c/(4*L)`, `c = sqrt(R*T)`.
#[test]
fn waves_run_at_the_speed_of_sound_of_the_gas() {
    let length = 2.0;
    for gas in GASES {
        let values = [("hoseA.length", length), ("hoseA.diameter", 0.02), ("chamberA.deadVolume", 1.0)];
        let mut plant = held(gas, "Isothermal", &values).start(0.0).unwrap();
        for (k, name) in ["hoseA.pressure[1]", "hoseA.pressure[2]", "hoseA.pressure[3]"].into_iter().enumerate() {
            plant.move_state(name, AMBIENT + 100.0 * (PI / 6.0 * k as f64).cos()).unwrap();
        }
        let expected = gas.energy().sqrt() / (4.0 * length);
        let (mut times, mut before, interval) = (Vec::new(), 100.0, 0.01 / expected);
        while times.len() < 4 {
            plant.step(interval).unwrap();
            let now = get(&plant, "hoseA.pressure[1]") - AMBIENT;
            if before < 0.0 && now >= 0.0 {
                times.push(plant.time() - interval * now / (now - before));
            }
            before = now;
        }
        // The lowest frequency of the model is 1.1 % too low.
        let found = 3.0 / (times[3] - times[0]);
        close(found / expected, 0.989, 2e-3, format_args!("{found} Hz, not {expected} Hz, of {gas:?}"));
    }
}

/// `p_1^2 - p_4^2 = R*T*phi*mu*L*mdot/(A*d^2)`, with `phi` = 64 in laminar flow, by the law of Blasius beyond.
#[test]
fn hose_loses_pressure_by_the_viscosity_of_the_gas() {
    let (length, diameter) = (2.0, 0.004);
    for (gas, conductance) in GASES.into_iter().flat_map(|gas| [(gas, 2e-12), (gas, 1e-9)]) {
        let values = [
            ("hoseA.length", length),
            ("hoseA.diameter", diameter),
            ("chamberA.deadVolume", 1.0),
            ("valve.C", conductance),
            ("supplyPressure", 20e5),
            ("valveVoltage", 10.0),
        ];
        let mut plant = held(gas, "Isothermal", &values).start(0.0).unwrap();
        plant.advance_to(1.0).unwrap();
        let (flow, viscosity) = (get(&plant, "chamberA.massFlow"), gas.0[2]);
        let reynolds = flow * diameter / (area(diameter) * viscosity);
        assert_eq!(reynolds > 1188.0, conductance > 1e-10, "{reynolds}");
        let factor = if reynolds > 1188.0 { 0.3164 * reynolds.powf(0.75) } else { 64.0 };
        let expected = gas.energy() * factor * viscosity * length * flow / (area(diameter) * diameter.powi(2));
        let [first, last] = ["hoseA.pressure[1]", "chamberA.pressure"].map(|name| get(&plant, name));
        let found = first * first - last * last;
        close(found / expected, 1.0, 1e-3, format_args!("{found} Pa2, not {expected}, of {gas:?} at Re = {reynolds}"));
    }
}

/// A gap of a width `w`, a height `h` and a length `l` passes `w*h^3/(24*mu*R*T*l)*(p_A^2 - p_B^2)`: one `w*h^3/l` for all gases.
#[test]
fn piston_leaks_by_viscosity_and_density() {
    let gaps = GASES.map(|gas| {
        let values = [("piston.leakage", 1e-15), ("chamberA.pressure0", 6e5), ("chamberB.pressure0", 2e5)];
        let plant = held(gas, "Isothermal", &values).start(0.0).unwrap();
        -get(&plant, "chamberA.massFlow") * 24.0 * gas.0[2] * gas.energy() / (6e5 * 6e5 - 2e5 * 2e5)
    });
    for (gas, gap) in GASES.iter().zip(gaps) {
        close(gap / gaps[0], 1.0, 1e-12, format_args!("{gas:?}"));
        close(gap, 1e-15 * 24.0 * 1.813e-5 * AIR.energy(), 1e-27, "of air");
    }
}

/// Mass and energy are kept, with hoses and a vessel or without, and the meter counts volume at the reference conditions.
#[test]
fn balances_hold_in_every_gas() {
    for (gas, length) in GASES.into_iter().flat_map(|gas| [(gas, 0.0), (gas, 1.0)]) {
        let mut setup = gas.of(Setup::new(&MODEL)).tolerance(1e-8);
        let values = [("balance.enabled", 1.0), ("consumption.enabled", 1.0), ("hoseA.length", length)];
        values.iter().for_each(|(name, value)| setup.change(name, *value).unwrap());
        let mut plant = setup.set("valveVoltage", 8.0).unwrap().start(0.0).unwrap();
        plant.advance_to(0.5).unwrap();
        let mass = get(&plant, "supply.consumed");
        within(get(&plant, "balance.massResidual").abs() / mass, 1e-8, format_args!("{gas:?}"));
        // The energy of the gas in hoses is not counted.
        if length == 0.0 {
            within(get(&plant, "balance.energyResidual").abs(), 1e-5, format_args!("J, {gas:?}"));
        }
        let density = mass / get(&plant, "supply.consumedVolume");
        close(density * gas.0[0], 1.185 * 287.05, 1e-9, format_args!("{gas:?}"));
    }
}

/// All but air by a part in a billion moves as air does; the equations are other ones.
#[test]
fn air_is_a_gas_among_others() {
    let [air, like_air] = [1.0, 1.0 + 1e-9].map(|factor| {
        let setup = Gas(AIR.0.map(|value| value * factor)).of(Setup::new(&MODEL)).tolerance(1e-9);
        let mut plant = setup.set("valveVoltage", 7.0).unwrap().start(0.0).unwrap();
        plant.advance_to(0.5).unwrap();
        ["position", "chamberA.pressure"].map(|name| get(&plant, name))
    });
    close(air[0], like_air[0], 1e-8, "m");
    close(air[1], like_air[1], 1e-2, "Pa");
}

/// Derivatives of runs, in air and in helium, are limits of differences of runs.
#[test]
fn runs_have_derivatives_by_the_gas() {
    let end = |gas: [f64; 3], carried: &[&str]| {
        let values = [("hoseA.length", 1.0), ("hoseA.diameter", 3e-3), ("piston.leakage", 1e-13)];
        let mut setup = Gas(gas).of(Setup::new(&MODEL)).set("friction.law", "None").unwrap().tolerance(1e-11);
        values.iter().for_each(|(name, value)| setup.change(name, *value).unwrap());
        let mut plant = setup.set("valveVoltage", 7.0).unwrap().start(0.0).unwrap();
        plant.carry_sensitivities(carried).unwrap();
        plant.advance_to(0.2).unwrap();
        let place = plant.table().computed().position(|variable| variable.name == "position").unwrap();
        let slopes: Vec<f64> = (0..carried.len()).map(|one| plant.sensitivities(one).unwrap()[place]).collect();
        (get(&plant, "position"), slopes)
    };
    for Gas(gas) in [AIR, HELIUM] {
        let (_, slopes) = end(gas, &NAMES);
        for (place, slope) in slopes.into_iter().enumerate() {
            let [low, high] = [-1e-3, 1e-3].map(|change| {
                let mut other = gas;
                other[place] *= 1.0 + change;
                end(other, &[]).0
            });
            let expected = (high - low) / (2e-3 * gas[place]);
            close(slope / expected, 1.0, 1e-3, format_args!("{slope}, not {expected}, by {} of {gas:?}", NAMES[place]));
        }
    }
}

#[test]
fn impossible_gases_are_refused_by_name_and_value() {
    for (name, value) in [("gas.R", 0.0), ("gas.R", -287.0), ("gas.gamma", 1.0), ("gas.viscosity", 0.0)] {
        let told = Setup::new(&MODEL).set(name, value).unwrap_err().to_string();
        assert!(told.contains(&format!("{name} = {value}")), "{told}");
    }
}
