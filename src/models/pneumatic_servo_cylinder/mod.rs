//! A double-acting pneumatic cylinder with a friction-loaded carriage, fed by a 5/3 proportional valve or, on a second
//! rig, by a pressure regulator with the other chamber plugged.
//!
//! Chamber A (cap side, full bore) pushes the carriage to +x; chamber B is the rod side. The equations are those of
//! the rooms [`pneumatics`](crate::pneumatics), [`mechanics`](crate::mechanics) and [`friction`];
//! this file joins them:
//!
//! ```text
//! F_app = p_A*A_A - p_B*A_B - p_atm*A_r + F_ext - F_wire - m*g*sin(incline) - k*(x - rest) + F_stop
//! m*dv/dt = F_app - F_f,   dx/dt = v
//! ```
//!
//! `A_r` is what the rods leave of the areas: that of the rod less that of a second one through chamber A.

mod air;
mod balance;
mod carriage;
mod gentle;
mod jacobian;
mod lines;
mod options;
mod outputs;
mod rates;
mod sensors;
mod variables;

use std::f64::consts::PI;

use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};

use self::gentle::GentleSteps;
use self::lines::Lines;
use self::options::Options;
use self::sensors::Sensors;
use self::variables::{Inputs, Parameters, State, TABLE};
use super::equations::state_name;
use super::references;
use crate::co_simulation::Simulation;
use crate::co_simulation::Simulator;
use crate::friction::{self, Drive, Event, Friction, FrictionContact, Indicators, MAX_STATES};
use crate::hybrid::{Groups, HybridSystem, Led, LongestSteps, QUANTITIES, Sample, Stride};
use crate::mechanics::{EndStops, GRAVITY, OneSided};
use crate::model::{Course, Experiment, Model, Panel, Signal, Start};
use crate::numbers::{Pair, Scalar};
use crate::pneumatics::actuator::{self, Actuator, STATES};
use crate::pneumatics::chamber::{Chambers, Thermal, ThermalModel, tank_wall};
use crate::pneumatics::gas::Reservoir;
use crate::sensor;
use crate::solver::{Settings, Tuning};
use crate::variables::{ParameterError, ParameterSet, Tunable};

/// The model as the library offers it.
pub const MODEL: Model = Model {
    name: "PneumaticServoCylinder",
    description: "Friction-loaded pneumatic servo cylinder with 5/3 proportional valve",
    variables: || &TABLE,
    indicators: || Event::indicators("friction"),
    start,
    experiment: Experiment {
        stop_time: 3.0,
        step_size: 1e-3,
        signals: &[Signal {
            input: "valveVoltage",
            text: "5 V + 2 V sin(2π t/s)",
            course: Course::Sine { mean: 5.0, amplitude: 2.0, frequency: 1.0, delay: 0.0 },
        }],
        panels: &[
            Panel { label: "valve voltage", curves: &["valveVoltage"] },
            Panel { label: "position", curves: &["position"] },
            Panel { label: "velocity", curves: &["velocity"] },
            Panel { label: "pressure", curves: &["chamberB.pressure", "chamberA.pressure"] },
            Panel { label: "friction force", curves: &["frictionForce"] },
        ],
    },
};

/// The equations of the cylinder for given parameters; `EXTENDED` ones for a cylinder that uses any of the options, or has
/// an actuator that changes by itself.
#[derive(Clone, Debug)]
pub struct PneumaticServoCylinder<const EXTENDED: bool = false> {
    p: Parameters,
    options: Options,
    lines: Lines,
    sensors: Sensors,
    actuator: Actuator,
    /// Chambers A and B.
    chambers: Chambers,
    /// Area in m2 of the rod less that of a second one: what the atmosphere acts on.
    rod_area: f64,
    supply: Reservoir,
    exhaust: Reservoir,
    stops: EndStops,
    friction: FrictionContact,
    /// Inverse of the moving mass in 1/kg.
    per_mass: f64,
    /// Constant part of the applied force in N: wire and weight.
    dead_load: Tunable,
    /// Weight of the carriage along the axis in N.
    carriage_weight: f64,
    /// How long explicit steps may be.
    gentle: GentleSteps,
}

/// Modes and memories of the cylinder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    actuator: actuator::Memory,
    friction: friction::Memory,
    sensors: sensors::Memory,
}

// In front of the friction law the places do not depend on its number of states.
const TEMPERATURE_A: usize = State::TemperatureA.at(State::OTHERS);
const TEMPERATURE_B: usize = State::TemperatureB.at(State::OTHERS);
/// Index of the pressure in chamber A among the states.
pub const PRESSURE_A: usize = State::PressureA.at(State::OTHERS);
/// Index of the pressure in chamber B among the states.
pub const PRESSURE_B: usize = State::PressureB.at(State::OTHERS);

/// The states of the actuator, which come first.
#[inline(always)]
fn of_actuator<S: Scalar>(x: &[S]) -> [S; STATES] {
    std::array::from_fn(|place| x[place])
}

/// How many times larger the errors of the states of a friction law may be than those of other states: what they do to
/// position and friction force stays far below the promised accuracy, and they would take most of the steps.
const FRICTION_ALLOWANCE: f64 = 10.0;

/// States of a cylinder that has them all.
const MOST: usize = State::OTHERS + MAX_STATES + lines::STATES + sensors::COUNT;

/// Starts a run with as many states as friction law, lines and sensors need, or a few more.
fn start(start: &Start) -> Result<Box<dyn Simulation>, ParameterError> {
    let (parts, _) = Parts::read(start, &[])?;
    if parts.need_extension() {
        let equations = PneumaticServoCylinder::<true>::of(parts);
        return match (equations.lines.are_used(), equations.sensors.states(), equations.friction.count()) {
            (false, 0, 0..=2) => Ok(Box::new(equations.simulator::<{ State::OTHERS + 2 }>(start)?)),
            (false, 0, _) => Ok(Box::new(equations.simulator::<{ State::OTHERS + MAX_STATES }>(start)?)),
            (false, _, 0..=2) => Ok(Box::new(equations.simulator::<{ State::OTHERS + 2 + sensors::COUNT }>(start)?)),
            (true, 0, 0..=2) => Ok(Box::new(equations.simulator::<{ State::OTHERS + 2 + lines::STATES }>(start)?)),
            (true, 0, _) => Ok(Box::new(equations.simulator::<{ State::OTHERS + MAX_STATES + lines::STATES }>(start)?)),
            _ => Ok(Box::new(equations.simulator::<MOST>(start)?)),
        };
    }
    let equations = PneumaticServoCylinder::<false>::of(parts);
    match equations.friction.count() {
        0 => Ok(Box::new(equations.simulator::<{ State::OTHERS }>(start)?)),
        1 => Ok(Box::new(equations.simulator::<{ State::OTHERS + 1 }>(start)?)),
        2 => Ok(Box::new(equations.simulator::<{ State::OTHERS + 2 }>(start)?)),
        3..=4 => Ok(Box::new(equations.simulator::<{ State::OTHERS + 4 }>(start)?)),
        _ => Ok(Box::new(equations.simulator::<{ State::OTHERS + MAX_STATES }>(start)?)),
    }
}

/// The equations for the parameters of a start, which vary with slopes or (without any) not at all, and the solver
/// settings.
///
/// # Errors
/// [`ParameterError`] when values that are legal one by one do not fit together.
pub fn build<const EXTENDED: bool>(
    start: &Start,
    slopes: &[f64],
) -> Result<(PneumaticServoCylinder<EXTENDED>, Settings), ParameterError> {
    let (parts, settings) = Parts::read(start, slopes)?;
    Ok((PneumaticServoCylinder::of(parts), settings))
}

/// What the equations are made of.
struct Parts {
    parameters: Parameters,
    options: Options,
    sensors: Sensors,
    actuator: Actuator,
    friction: Friction,
}

impl Parts {
    fn read(start: &Start, slopes: &[f64]) -> Result<(Self, Settings), ParameterError> {
        let parameters = TABLE.chosen(start.parameters, slopes);
        let (own, rest) = parameters.split_at(Parameters::LEN);
        let (options, rest) = rest.split_at(Options::LEN);
        let (sensors, rest) = rest.split_at(Sensors::LEN);
        let (actuator, rest) = rest.split_at(Actuator::LEN);
        let (friction, tuning) = rest.split_at(rest.len() - Tuning::LEN);
        let parameters = Parameters::read(own)?;
        let settings = Settings::new(&Tuning::read(tuning)?, start.tolerance);
        let settings = settings.keeping_balance(parameters.keeps_balance);
        parameters.check()?;
        let options = Options::read(options)?;
        options.check(parameters.bore)?;
        let sensors = Sensors::read(sensors)?;
        sensors.check()?;
        let friction = Friction::new(friction, "friction")?;
        Ok((Self { parameters, options, sensors, actuator: Actuator::new(actuator)?, friction }, settings))
    }

    /// Whether any of them is compiled for extended equations only.
    fn need_extension(&self) -> bool {
        self.options.are_used() || self.sensors.are_used() || self.actuator.is_sampled()
    }
}

impl<const EXTENDED: bool> PneumaticServoCylinder<EXTENDED> {
    fn of(Parts { parameters: p, options, sensors, actuator, friction }: Parts) -> Self {
        let area = |diameter: f64| PI * diameter * diameter / 4.0;
        let pressures0 = [p.pressure0_a, p.pressure0_b];
        let lines = Lines::new(&options, p.ambient_temperature, p.supply_temperature);
        let [hose_a, hose_b] = lines.added_volumes();
        let areas = [area(p.bore) - area(options.rod_a), area(p.bore) - area(p.rod)];
        let chambers = Chambers {
            areas,
            walls: [2.0 * areas[0], 2.0 * areas[1] + tank_wall(p.tank_volume)],
            bore: p.bore,
            dead_volumes: [p.dead_volume_a + hose_a, p.dead_volume_b + p.tank_volume + hose_b],
            ambient_temperature: p.ambient_temperature,
            thermal: match p.thermal_model {
                ThermalModel::Isothermal => Thermal::Polytropic { exponent: 1.0, reference_pressures: pressures0 },
                ThermalModel::Polytropic => {
                    Thermal::Polytropic { exponent: p.exponent, reference_pressures: pressures0 }
                }
                ThermalModel::PolytropicServo => Thermal::PolytropicServo { exponent: p.exponent },
                ThermalModel::EnergyBalance => Thermal::EnergyBalance { heat_transfer: p.heat_transfer },
            },
        };
        let slope = GRAVITY * libm::sin(p.incline);
        let friction = FrictionContact::new(friction, Drive::Force, State::FRICTION, references::CONTACT);
        Self {
            gentle: GentleSteps::new(&friction, p.stop_stiffness, p.moving_mass),
            actuator,
            chambers,
            rod_area: area(p.rod) - area(options.rod_a),
            supply: Reservoir::new(p.supply_temperature),
            exhaust: Reservoir::new(Tunable::still(p.ambient_temperature)),
            stops: EndStops {
                stroke: p.stroke,
                contact: OneSided { stiffness: p.stop_stiffness, damping: p.stop_damping },
                clearances: [0, 1].map(|side| chambers.dead_volumes[side] / chambers.areas[side]),
            },
            friction,
            per_mass: 1.0 / p.moving_mass,
            dead_load: p.wire_force + p.moving_mass * slope,
            carriage_weight: p.carriage_mass * slope,
            p,
            options,
            lines,
            sensors,
        }
    }

    /// Number of states that are integrated.
    pub fn states(&self) -> usize {
        let lines = if self.lines.are_used() { lines::STATES } else { 0 };
        State::OTHERS + self.friction.count() + lines + self.sensors.states()
    }

    /// The next point in time at which a part changes by itself.
    fn next_change(&self, memory: &Memory) -> Sample {
        let of_friction = self.friction.next_sample(&memory.friction);
        if !EXTENDED {
            return of_friction;
        }
        let of_sensors = self.sensors.next_sample(&memory.sensors);
        self.actuator.next_sample(&memory.actuator).earlier(of_friction).earlier(of_sensors)
    }

    fn simulator<const N: usize>(&self, start: &Start) -> Result<Simulator<Self, N, 3>, ParameterError> {
        let (x, memory) = self.initial_state(start);
        Simulator::new(build, start, x, memory)
    }

    /// The states and the memory a run starts with; `N` is [`states`](Self::states) or more.
    pub fn initial_state<const N: usize>(&self, start: &Start) -> ([f64; N], Memory) {
        let u = Inputs::read(&std::array::from_fn(|i| start.inputs[i]));
        let mut x = [0.0; N];
        x[State::Position.at(N)] = self.p.position0;
        x[State::Velocity.at(N)] = self.p.velocity0;
        (x[PRESSURE_A], x[PRESSURE_B]) = (self.p.pressure0_a, self.p.pressure0_b);
        if EXTENDED && self.options.opens_b {
            x[PRESSURE_B] = self.p.ambient_pressure;
        }
        (x[TEMPERATURE_A], x[TEMPERATURE_B]) = (self.p.ambient_temperature, self.p.ambient_temperature);
        if EXTENDED && self.lines.are_used() {
            let states = self.lines.start([x[PRESSURE_A], x[PRESSURE_B]], u.supply_pressure);
            x[self.first_of_lines(N)..][..lines::STATES].copy_from_slice(&states);
        }
        let (states, actuator) = self.actuator.start(u.valve_voltage);
        x[..STATES].copy_from_slice(&states);
        let contact = self.contact(0.0, &x, &u, x[State::Velocity.at(N)]);
        let friction = self.friction.start(&contact);
        let force = self.friction.force(&contact, &x, &friction, &mut [0.0; N]);
        let acceleration = self.friction.rate((contact.applied - force) * self.per_mass, &friction);
        let quantities = self.measured(&x, &u, acceleration);
        if EXTENDED && self.sensors.states() > 0 {
            x[Self::first_of_sensors(N)..][..sensors::COUNT].copy_from_slice(&quantities);
        }
        (x, Memory { actuator, friction, sensors: self.sensors.start(quantities) })
    }
}

impl<const N: usize, const EXTENDED: bool> HybridSystem<N, 3> for PneumaticServoCylinder<EXTENDED> {
    type Memory = Memory;
    type Indicators = Indicators;

    const GROUPS: Groups = if EXTENDED { [0, 0] } else { [STATES, State::FRICTION] };

    const LED: usize = STATES;

    const RELAXING: Option<usize> = if N > State::OTHERS { Some(State::FRICTION) } else { None };

    const TURNING: Option<usize> = if N > State::OTHERS { Some(State::Velocity.at(N)) } else { None };

    fn derivatives<S: Scalar>(&self, time: S, x: &[S; N], u: &[S; 3], memory: &Memory) -> [S; N] {
        let mut rates = [S::zero(); N];
        self.write_rates(time, x, u, memory, &mut rates);
        rates
    }

    fn driven(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &Memory) -> [f64; N] {
        let mut rates = [0.0; N];
        self.driven_rates(time, x, &Inputs::read(u), memory, &mut rates);
        rates
    }

    fn jacobian(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &Memory,
        jacobian: &mut SMatrix<f64, N, N>,
    ) -> [f64; N] {
        self.linearise(time, x, u, memory, jacobian)
    }

    fn indicators(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &Memory) -> Indicators {
        let u = &Inputs::read(u);
        let contact = self.contact(time, x, u, self.rate(x, memory));
        self.friction.indicators(&contact, x, &memory.friction)
    }

    fn indicators_hold(&self, inputs: [&[f64; 3]; 2]) -> bool {
        act_on_actuator_alone(inputs) && !self.friction.follows()
    }

    fn has_events(&self) -> bool {
        self.friction.has_events()
    }

    fn switch(&self, event: usize, time: f64, x: &mut [f64; N], u: &[f64; 3], memory: &mut Memory) {
        let u = &Inputs::read(u);
        let contact = self.contact(time, x, u, self.rate(x, memory));
        self.friction.switch(Event::ALL[event], &contact, State::Velocity.at(N), x, &mut memory.friction);
    }

    fn follow(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &mut Memory) -> bool {
        let u = &Inputs::read(u);
        self.actuator.follow(u.valve_voltage, &mut memory.actuator);
        let rate = self.rate(x, memory);
        self.friction.follow(|| self.contact(time, x, u, rate), x, &mut memory.friction)
    }

    fn next_sample(&self, memory: &Memory) -> Sample {
        self.next_change(memory)
    }

    fn state_name(&self, state: usize) -> &'static str {
        state_name::<Self, N, 3>(self, state)
    }

    fn event_name(&self, event: usize) -> &'static str {
        Event::ALL[event].name()
    }

    fn variant(&self) -> &'static str {
        self.friction.law().title()
    }

    fn max_step(&self) -> f64 {
        self.friction.max_step()
    }

    fn refresh(&self, x: &[f64; N], inputs: [&[f64; 3]; 2], memory: &Memory, derivatives: &mut [f64; N]) -> bool {
        if !act_on_actuator_alone(inputs) {
            return false;
        }
        let u = Inputs::read(inputs[1]);
        derivatives[..STATES].copy_from_slice(&self.actuator.rates(of_actuator(x), u.valve_voltage, &memory.actuator));
        true
    }

    fn is_gentle(&self) -> bool {
        self.friction.is_gentle() && !(EXTENDED && self.has_rapid_parts())
    }

    fn relaxation(&self, time: f64, x: &[f64; N], rates: &[f64; N], u: &[f64; 3], memory: &Memory) -> f64 {
        let contact = || self.contact(time, x, &Inputs::read(u), self.rate(x, memory));
        self.friction.relaxation(contact, [x, rates], &memory.friction)
    }

    fn longest_gentle_steps(&self, x: &[f64; N]) -> LongestSteps {
        self.gentle.longest(self.stops.touched(x[State::Position.at(N)]), x[State::Velocity.at(N)])
    }

    fn is_smooth(&self, [x, end]: [&[f64; N]; 2], u: [&[f64; 3]; 2], memory: &Memory, step: f64) -> bool {
        let [u, u_end] = u.map(Inputs::read);
        let states = [of_actuator(x), of_actuator(end)];
        self.piece(x, &u) == self.piece(end, &u_end)
            && self.actuator.stays_in_piece(states, u.valve_voltage, &memory.actuator, step)
    }

    fn stride(&self, size: f64) -> Stride {
        Stride { size, half: self.actuator.half(size) }
    }

    fn led(&self, x: &[f64; N], u: &[f64; 3], memory: &Memory, stride: &Stride) -> Led<[f64; N]> {
        let voltage = Inputs::read(u).valve_voltage;
        let Led { middle, end, bend } = self.actuator.later(of_actuator(x), voltage, &memory.actuator, stride);
        let placed = |own: [f64; STATES]| {
            let mut all = [0.0; N];
            all[..STATES].copy_from_slice(&own);
            all
        };
        Led { middle: placed(middle), end: placed(end), bend: placed(bend) }
    }

    fn depends_on_time(&self) -> bool {
        self.friction.depends_on_time()
    }

    fn sample(&self, time: f64, x: &mut [f64; N], u: &[f64; 3], memory: &mut Memory) {
        let u = &Inputs::read(u);
        if EXTENDED {
            // One part at a time, the earliest; the others follow when they are the earliest.
            let next = self.next_change(memory);
            if self.actuator.next_sample(&memory.actuator) == next {
                let mut states = of_actuator(x);
                self.actuator.sample(&mut states, u.valve_voltage, &mut memory.actuator);
                x[..STATES].copy_from_slice(&states);
                return;
            }
            if self.sensors.next_sample(&memory.sensors) == next {
                self.take_readings(time, x, u, memory);
                return;
            }
        }
        let rate = self.rate(x, memory);
        self.friction.sample(|| self.contact(time, x, u, rate), time, x, &mut memory.friction);
    }

    fn arrive(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &mut Memory) {
        if EXTENDED {
            self.take_readings(time, x, &Inputs::read(u), memory);
        }
    }

    fn admit(&self, x: &[f64; N]) -> Result<(), &'static str> {
        /// What has no meaning if one of these is not above 0: volumes, pressures, temperatures.
        const REASONS: [&str; 6] = [
            "the volume of chamber A vanishes",
            "the volume of chamber B vanishes",
            "chamberA.pressure falls to 0",
            "chamberB.pressure falls to 0",
            "chamberA.temperature falls to 0",
            "chamberB.temperature falls to 0",
        ];
        let Pair([volume_a, volume_b]) = self.chambers.volume(self.lengths(x[State::Position.at(N)]));
        let [pressure_a, pressure_b, temperature_a, temperature_b] =
            [PRESSURE_A, PRESSURE_B, TEMPERATURE_A, TEMPERATURE_B].map(|index| x[index]);
        let is_above =
            [volume_a, volume_b, pressure_a, pressure_b, temperature_a, temperature_b].map(|value| value > 0.0);
        // All at once, since as a rule all are.
        if !is_above.iter().fold(true, |all, one| all & one) {
            return Err(REASONS[is_above.iter().position(|one| !one).unwrap_or_default()]);
        }
        if EXTENDED && self.lines.are_used() && !self.lines.are_filled(&self.of_lines(x)) {
            return Err("the pressure in a hose or in the vessel falls to 0");
        }
        Ok(())
    }

    fn scales(&self) -> [f64; N] {
        let mut scales = [FRICTION_ALLOWANCE * self.friction.state_scale(); N];
        scales[..STATES].copy_from_slice(&self.actuator.scales());
        if EXTENDED && self.lines.are_used() {
            scales[self.first_of_lines(N)..][..lines::STATES].copy_from_slice(&Lines::scales());
        }
        if EXTENDED && self.sensors.states() > 0 {
            scales[Self::first_of_sensors(N)..][..sensors::COUNT].copy_from_slice(&Sensors::scales());
        }
        State::ALL.iter().for_each(|state| scales[state.at(N)] = state.scale(&self.p));
        scales
    }

    fn content(&self, x: &[f64; N], memory: &Memory) -> [f64; QUANTITIES] {
        self.mass_and_energy(x, memory)
    }

    fn inflow(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &Memory) -> [f64; QUANTITIES] {
        let u = &Inputs::read(u);
        self.mass_flow_and_power(time, x, u, memory)
    }

    fn fits(&self, memory: &Memory) -> bool {
        self.actuator.fits(&memory.actuator)
            && self.friction.fits(&memory.friction)
            && memory.sensors.iter().all(sensor::Memory::is_sound)
    }
}

/// Whether inputs differ in nothing but the voltage: it, and the play that follows it, act on the actuator alone.
fn act_on_actuator_alone(inputs: [&[f64; 3]; 2]) -> bool {
    let [from, to] =
        inputs.map(Inputs::read).map(|u: Inputs<f64>| [u.external_force, u.supply_pressure].map(f64::to_bits));
    from == to
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::equations::checks;
    use crate::variables::Variable;

    /// Messages call an event of a contact as a host calls its indicator, without the group.
    #[test]
    fn events_are_named_as_their_indicators() {
        let indicators = (MODEL.indicators)();
        checks::events_are_named::<_, { State::OTHERS }, 3>(build::<false>, &indicators, |_, last| last);
    }

    /// With all lines, each of their states is integrated; with a lag, a sensor's.
    #[test]
    fn states_are_as_many_as_a_run_integrates() {
        let lines = ["hoseA.length", "hoseB.length", "throttleA.C", "throttleB.C", "supply.volume"];
        let lags = ["sensor.position.lag", "sensor.pressureA.lag", "sensor.pressureB.lag", "sensor.force.lag"];
        let all = [lines.as_slice(), &lags].concat();
        for (law, options) in
            [1.0, 12.0, 16.0].into_iter().flat_map(|law| [&[][..], &lines, &lags, &all].map(|it| (law, it)))
        {
            let value = |variable: &Variable| match variable.name.as_str() {
                "friction.law" => law,
                name if options.contains(&name) => {
                    if name.ends_with(".C") {
                        1e-9
                    } else {
                        1e-3
                    }
                }
                _ => variable.start.expect("a start value"),
            };
            let parameters: Vec<f64> = TABLE.parameters().map(value).collect();
            let start = Start { time: 0.0, parameters: &parameters, inputs: &[5.0, 0.0, 6e5], tolerance: None };
            let run = (MODEL.start)(&start).expect("legal");
            let integrated = (0..TABLE.states().count()).filter(|state| run.state_index(*state).is_some());
            let (equations, _) = build::<true>(&start, &[]).expect("legal");
            assert_eq!(equations.states(), integrated.count(), "law {law}, {options:?}");
        }
    }
    #[test]
    fn laws_cost_what_they_ask_for() {
        checks::laws_cost_what_they_ask_for::<_, { State::OTHERS }, 3>(build::<false>, [false; 2]);
    }

    /// Another voltage changes the rates of the spool alone, so that no others are evaluated anew; other inputs change more.
    #[test]
    fn rates_are_refreshed_where_the_voltage_alone_has_changed() {
        let parameters: Vec<f64> = TABLE.parameters().filter_map(|it| it.start).collect();
        let before = [6.0, 1.0, 6e5];
        let start = Start { time: 0.0, parameters: &parameters, inputs: &before, tolerance: None };
        let (equations, _) = build::<false>(&start, &[]).expect("the defaults fit");
        let (x, memory) = equations.initial_state::<{ State::OTHERS }>(&start);
        for (inputs, is_refreshed) in
            [([6.5, 1.0, 6e5], true), (before, true), ([6.5, 1.5, 6e5], false), ([6.0, 1.0, 5e5], false)]
        {
            let (mut rates, mut memory) = (equations.driven(0.0, &x, &before, &memory), memory.clone());
            let unchanged = rates;
            equations.follow(0.0, &x, &inputs, &mut memory);
            assert_eq!(equations.refresh(&x, [&before, &inputs], &memory, &mut rates), is_refreshed, "{inputs:?}");
            let expected = if is_refreshed { equations.derivatives(0.0, &x, &inputs, &memory) } else { unchanged };
            assert_eq!(rates.map(f64::to_bits), expected.map(f64::to_bits), "{inputs:?}");
            let hold = <PneumaticServoCylinder as HybridSystem<{ State::OTHERS }, 3>>::indicators_hold;
            assert_eq!(hold(&equations, [&before, &inputs]), is_refreshed, "{inputs:?}");
        }
    }
}
