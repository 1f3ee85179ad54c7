//! A double-acting pneumatic cylinder with a friction-loaded carriage, fed by a 5/3 proportional valve or, on a second
//! rig, by a pressure regulator with the other chamber plugged.
//!
//! Chamber A (cap side, full bore) pushes the carriage to +x; chamber B is the rod side. The equations are those of
//! the rooms [`pneumatics`](crate::pneumatics), [`mechanics`](crate::mechanics) and [`friction`];
//! this file joins them:
//!
//! ```text
//! F_app = p_A*A_A - p_B*A_B - p_atm*A_r + F_ext - F_wire - m*g*sin(incline) + F_stop
//! m*dv/dt = F_app - F_f,   dx/dt = v
//! ```

mod balance;
mod jacobian;
mod variables;

use std::f64::consts::PI;

use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};

use self::variables::{Outputs, Parameters, TABLE};
use super::bristles::write_bristles;
use super::equations::{Equations, state_name};
use crate::co_simulation::Simulation;
use crate::co_simulation::Simulator;
use crate::friction::{self, Contact, Drive, Event, Friction, FrictionContact, Indicators};
use crate::hybrid::{Groups, HybridSystem, QUANTITIES, Sample};
use crate::mechanics::{EndStops, GRAVITY, OneSided};
use crate::model::{Course, Experiment, Model, Signal, Start};
use crate::numbers::Pair;
use crate::numbers::Scalar;
use crate::pneumatics::chamber::{ChamberRates, Chambers, Thermal};
use crate::pneumatics::gas::{GasState, Reservoir};
use crate::pneumatics::orifice::{Flow, Inflow, Orifice};
use crate::pneumatics::regulator::Regulator;
use crate::pneumatics::valve::{MeteringEdge, Spool, Valve};
use crate::solver::{Settings, Tuning};
use crate::variables::{ParameterError, ParameterSet};

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
    },
};

/// What feeds the chambers; both rigs use the first two states.
#[derive(Clone, Copy, Debug)]
enum Actuator {
    /// States: spool velocity and spool.
    Valve(Valve, Orifice),
    /// States: unused, and pressure behind the regulator.
    Regulator(Regulator, Orifice),
}

/// The equations of the cylinder for given parameters.
#[derive(Clone, Debug)]
pub struct PneumaticServoCylinder {
    p: Parameters,
    actuator: Actuator,
    /// Chambers A and B.
    chambers: Chambers,
    rod_area: f64,
    supply: Reservoir,
    exhaust: Reservoir,
    stops: EndStops,
    friction: FrictionContact,
    /// Inverse of the moving mass in 1/kg.
    per_mass: f64,
    /// Constant part of the applied force in N: wire and weight.
    dead_load: f64,
    /// Weight of the carriage along the axis in N.
    carriage_weight: f64,
}

/// Modes and memories of the cylinder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Set point of the spool: the state of the valve's hysteresis.
    set_point: f64,
    friction: friction::Memory,
}

// The order of the states keeps the elimination of the implicit scheme sparse: a chain from the spool over the
// chambers and the bristles to the motion.
const ACTUATOR_RATE: usize = 0;
const ACTUATOR: usize = 1;
const TEMPERATURE_A: usize = 2;
const TEMPERATURE_B: usize = 3;
/// Index of the pressure in chamber A among the states.
pub const PRESSURE_A: usize = 4;
/// Index of the pressure in chamber B among the states.
pub const PRESSURE_B: usize = 5;
const BRISTLES: usize = 6;
/// Position and velocity come last.
const fn position(n: usize) -> usize {
    n - 2
}
const fn velocity(n: usize) -> usize {
    n - 1
}
const STATES_WITHOUT_BRISTLES: usize = 8;

/// How many times larger the errors of the spool and of bristles may be than those of other states: what they do to
/// position and friction force stays far below the promised accuracy, and they would take most of the steps.
const SPOOL_ALLOWANCE: f64 = 30.0;
const BRISTLE_ALLOWANCE: f64 = 10.0;

/// Starts a run with as many states as the friction law needs.
fn start(start: &Start) -> Result<Box<dyn Simulation>, ParameterError> {
    let (equations, _) = build(start)?;
    match equations.states() {
        8 => Ok(Box::new(equations.run::<8>(start)?)),
        9 => Ok(Box::new(equations.run::<9>(start)?)),
        10 => Ok(Box::new(equations.run::<10>(start)?)),
        11..=12 => Ok(Box::new(equations.run::<12>(start)?)),
        _ => Ok(Box::new(equations.run::<18>(start)?)),
    }
}

/// The equations for the parameters of a start, and the solver settings.
///
/// # Errors
/// [`ParameterError`] when values that are legal one by one do not fit together.
pub fn build(start: &Start) -> Result<(PneumaticServoCylinder, Settings), ParameterError> {
    let (own, rest) = start.parameters.split_at(Parameters::LEN);
    let (friction, tuning) = rest.split_at(rest.len() - Tuning::LEN);
    let parameters = Parameters::read(own);
    let settings = Settings::new(&Tuning::read(tuning), start.tolerance);
    let settings = settings.keeping_balance(parameters.keeps_balance != 0.0);
    parameters.check()?;
    Ok((PneumaticServoCylinder::new(parameters, Friction::new(friction, "friction")?), settings))
}

impl PneumaticServoCylinder {
    fn new(p: Parameters, friction: Friction) -> Self {
        let area = |diameter: f64| PI * diameter * diameter / 4.0;
        let pressures0 = [p.pressure0_a, p.pressure0_b];
        let chambers = Chambers {
            areas: [area(p.bore), area(p.bore) - area(p.rod)],
            bore: p.bore,
            dead_volumes: [p.dead_volume_a, p.dead_volume_b + p.tank_volume],
            ambient_temperature: p.ambient_temperature,
            thermal: match p.thermal_model as i32 {
                2 => Thermal::Polytropic { exponent: 1.0, reference_pressures: pressures0 },
                3 => Thermal::Polytropic { exponent: p.exponent, reference_pressures: pressures0 },
                _ => Thermal::EnergyBalance { heat_transfer: p.heat_transfer },
            },
        };
        let actuator = if p.actuation == 2.0 {
            let regulator = Regulator {
                min_pressure: p.regulator_min,
                max_pressure: p.regulator_max,
                time_constant: p.regulator_lag,
                conductance: p.regulator_conductance,
            };
            Actuator::Regulator(regulator, Orifice::new(p.regulator_ratio))
        } else {
            let valve = Valve {
                edge: MeteringEdge::new(p.valve_conductance, p.dead_zone, p.leakage),
                spool: Spool::new(p.bandwidth, p.damping),
                hysteresis: p.hysteresis,
                polarity: p.polarity,
            };
            Actuator::Valve(valve, Orifice::new(p.valve_ratio))
        };
        let slope = GRAVITY * libm::sin(p.incline);
        Self {
            actuator,
            chambers,
            rod_area: area(p.rod),
            supply: Reservoir::new(p.supply_temperature),
            exhaust: Reservoir::new(p.ambient_temperature),
            stops: EndStops {
                stroke: p.stroke,
                contact: OneSided { stiffness: p.stop_stiffness, damping: p.stop_damping },
                clearances: [0, 1].map(|side| chambers.dead_volumes[side] / chambers.areas[side]),
            },
            friction: FrictionContact::new(friction, BRISTLES),
            per_mass: 1.0 / p.moving_mass,
            dead_load: p.wire_force + p.moving_mass * slope,
            carriage_weight: p.carriage_mass * slope,
            p,
        }
    }

    /// Number of states that are integrated.
    pub fn states(&self) -> usize {
        STATES_WITHOUT_BRISTLES + self.friction.count()
    }

    fn run<const N: usize>(&self, start: &Start) -> Result<Simulator<Self, N, 3>, ParameterError> {
        let (x, memory) = self.initial_state(start);
        Simulator::new(build, start, x, memory)
    }

    /// The states and the memory a run starts with; `N` is [`states`](Self::states) or more.
    pub fn initial_state<const N: usize>(&self, start: &Start) -> ([f64; N], Memory) {
        let u: [f64; 3] = std::array::from_fn(|i| start.inputs[i]);
        let mut x = [0.0; N];
        x[position(N)] = self.p.position0;
        x[velocity(N)] = self.p.velocity0;
        (x[PRESSURE_A], x[PRESSURE_B]) = (self.p.pressure0_a, self.p.pressure0_b);
        (x[TEMPERATURE_A], x[TEMPERATURE_B]) = (self.p.ambient_temperature, self.p.ambient_temperature);
        let set_point = match self.actuator {
            Actuator::Valve(valve, _) => valve.initial_play(valve.command(u[0])),
            Actuator::Regulator(regulator, _) => {
                x[ACTUATOR] = regulator.command(u[0]);
                0.0
            }
        };
        let contact = self.contact(0.0, &x, &u, x[velocity(N)]);
        let friction = self.friction.start(&contact, &mut x);
        (x, Memory { set_point, friction })
    }

    /// Force on the moving mass other than friction in N, and the stops' part of it.
    #[inline(always)]
    fn applied_force<S: Scalar, const N: usize>(&self, x: &[S; N], u: &[S; 3], rate: S) -> (S, S) {
        let stop = self.stops.force(x[position(N)], rate);
        (self.pressure_force(x) + u[1] - self.dead_load + stop, stop)
    }

    fn pressure_force<S: Scalar, const N: usize>(&self, x: &[S; N]) -> S {
        let [area_a, area_b] = self.chambers.areas;
        x[PRESSURE_A] * area_a - x[PRESSURE_B] * area_b - self.p.ambient_pressure * self.rod_area
    }

    /// The factor `lambda` of the friction levels.
    fn load_level<S: Scalar, const N: usize>(&self, x: &[S; N]) -> S {
        let excess = |pressure: S, kappa: f64| (pressure - self.p.ambient_pressure) * kappa;
        let level = excess(x[PRESSURE_A], self.p.kappa_a) + excess(x[PRESSURE_B], self.p.kappa_b) + 1.0;
        level.max(S::zero())
    }

    /// The contact as the friction law sees it, for a velocity of the carriage.
    #[inline(always)]
    fn contact<S: Scalar, const N: usize>(&self, time: S, x: &[S; N], u: &[S; 3], rate: S) -> Contact<S> {
        Contact {
            time,
            position: x[position(N)],
            velocity: x[velocity(N)],
            applied: self.applied_force(x, u, rate).0,
            level: self.load_level(x),
            drive: Drive::Force,
        }
    }

    /// Velocity of the carriage: the state, unless the friction law holds the position.
    fn rate<S: Scalar, const N: usize>(&self, x: &[S; N], memory: &Memory) -> S {
        self.friction.rate(x[velocity(N)], &memory.friction)
    }

    /// Rates of position and velocity; writes those of the bristles.
    #[inline(always)]
    fn motion_rates<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; 3],
        memory: &Memory,
        bristles: &[S],
        bristle_rates: &mut [S],
    ) -> [S; 2] {
        let rate = self.rate(x, memory);
        let contact = self.contact(time, x, u, rate);
        let force = self.friction.law().force(&contact, bristles, &memory.friction, bristle_rates);
        [rate, (contact.applied - force) * self.per_mass]
    }

    /// Set point of the spool under the present command.
    fn set_point<S: Scalar>(valve: &Valve, voltage: S, memory: &Memory) -> S {
        valve.play(memory.set_point, valve.command(voltage))
    }

    /// Pressures and temperatures in both chambers.
    #[inline(always)]
    fn gas<S: Scalar, const N: usize>(&self, x: &[S; N]) -> GasState<Pair<S>> {
        self.chambers.gas(Pair([x[PRESSURE_A], x[PRESSURE_B]]), Pair([x[TEMPERATURE_A], x[TEMPERATURE_B]]))
    }

    /// Rates of the gas in both chambers at a position and velocity of the carriage.
    #[inline(always)]
    fn gas_rates<S: Scalar>(
        &self,
        gas: GasState<Pair<S>>,
        position: S,
        rate: S,
        inflow: Inflow<Pair<S>>,
    ) -> ChamberRates<Pair<S>> {
        self.chambers.rates(gas, self.lengths(position), Pair([rate, -rate]), inflow)
    }

    /// Lengths in m of the chambers.
    fn lengths<S: Scalar>(&self, position: S) -> Pair<S> {
        Pair([position, -position + self.p.stroke])
    }

    /// What flows into the chambers from the supply, from the exhaust and from each other.
    #[inline(always)]
    fn inflow<S: Scalar>(&self, actuator: S, supply: S, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
        let fed = self.feed(actuator, supply, gas);
        if self.p.piston_leakage == 0.0 { fed } else { fed + Inflow::from(self.piston_leak(gas)) }
    }

    /// What flows into the chambers from the supply and from the exhaust.
    #[inline(always)]
    fn feed<S: Scalar>(&self, actuator: S, supply: S, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
        match &self.actuator {
            Actuator::Valve(valve, orifice) => {
                let spool = Pair([actuator, -actuator]);
                let supply = self.supply.at(Pair([supply; 2]));
                let exhaust = self.exhaust.at(Pair([S::constant(self.p.ambient_pressure); 2]));
                Inflow::from(orifice.flow(valve.edge.conductance(spool), supply, gas))
                    + Inflow::from(orifice.flow(valve.edge.conductance(-spool), exhaust, gas))
            }
            Actuator::Regulator(regulator, orifice) => {
                let conductance = Pair([regulator.conductance, 0.0].map(S::constant));
                Inflow::from(orifice.flow(conductance, self.supply.at(Pair([actuator; 2])), gas))
            }
        }
    }

    /// Laminar leakage past the piston seal into the chambers.
    fn piston_leak<S: Scalar>(&self, gas: GasState<Pair<S>>) -> Flow<Pair<S>> {
        let (Pair([p_a, p_b]), Pair([t_a, t_b])) = (gas.pressure, gas.temperature);
        let to_b = (p_a * p_a - p_b * p_b) * self.p.piston_leakage;
        let temperature = if to_b.value() >= 0.0 { t_a } else { t_b };
        Flow { mass: Pair([-to_b, to_b]), temperature: Pair([temperature; 2]) }
    }

    /// Rates of the actuator's two states `[rate, position or pressure]`.
    fn actuator_rates<S: Scalar>(&self, [rate, state]: [S; 2], voltage: S, memory: &Memory) -> [S; 2] {
        match &self.actuator {
            Actuator::Valve(valve, _) => {
                [valve.spool.acceleration(Self::set_point(valve, voltage, memory), state, rate), rate]
            }
            Actuator::Regulator(regulator, _) => {
                [S::zero(), regulator.pressure_rate(regulator.command(voltage), state)]
            }
        }
    }
}

impl<const N: usize> HybridSystem<N, 3> for PneumaticServoCylinder {
    type Memory = Memory;
    type Indicators = Indicators;

    const GROUPS: Groups = [TEMPERATURE_A, BRISTLES];

    fn derivatives<S: Scalar>(&self, time: S, x: &[S; N], u: &[S; 3], memory: &Memory) -> [S; N] {
        let mut rates = [S::zero(); N];
        let bristles = self.friction.states();
        let [rate, acceleration] = self.motion_rates(time, x, u, memory, &x[bristles.clone()], &mut rates[bristles]);
        [rates[ACTUATOR_RATE], rates[ACTUATOR]] = self.actuator_rates([x[ACTUATOR_RATE], x[ACTUATOR]], u[0], memory);
        let gas = self.gas(x);
        let gas = self.gas_rates(gas, x[position(N)], rate, self.inflow(x[ACTUATOR], u[2], gas));
        Pair([rates[TEMPERATURE_A], rates[TEMPERATURE_B]]) = gas.temperature;
        Pair([rates[PRESSURE_A], rates[PRESSURE_B]]) = gas.pressure;
        rates[position(N)] = rate;
        rates[velocity(N)] = acceleration;
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
        let contact = self.contact(time, x, u, self.rate(x, memory));
        self.friction.indicators(&contact, x, &memory.friction)
    }

    fn has_events(&self) -> bool {
        self.friction.has_events()
    }

    fn switch(&self, event: usize, time: f64, x: &mut [f64; N], u: &[f64; 3], memory: &mut Memory) {
        let contact = self.contact(time, x, u, self.rate(x, memory));
        self.friction.switch(Event::ALL[event], &contact, velocity(N), x, &mut memory.friction);
    }

    fn follow(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &mut Memory) {
        if let Actuator::Valve(valve, _) = &self.actuator {
            memory.set_point = Self::set_point(valve, u[0], memory);
        }
        let rate = self.rate(x, memory);
        let contact = || self.contact(time, x, u, rate);
        self.friction.follow(contact, x, &mut memory.friction);
    }

    fn next_sample(&self, memory: &Memory) -> Sample {
        self.friction.next_sample(&memory.friction)
    }

    fn state_name(&self, state: usize) -> &'static str {
        state_name::<Self, N, 3>(self, &TABLE, state)
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

    fn depends_on_time(&self) -> bool {
        self.friction.depends_on_time()
    }

    fn sample(&self, time: f64, x: &mut [f64; N], u: &[f64; 3], memory: &mut Memory) {
        let rate = self.rate(x, memory);
        self.friction.sample(|| self.contact(time, x, u, rate), time, x, &mut memory.friction);
    }

    fn admit(&self, x: &[f64; N]) -> Result<(), &'static str> {
        let Pair([volume_a, volume_b]) = self.chambers.volume(self.lengths(x[position(N)]));
        let [pressure_a, pressure_b, temperature_a, temperature_b] =
            [PRESSURE_A, PRESSURE_B, TEMPERATURE_A, TEMPERATURE_B].map(|index| x[index]);
        for (value, reason) in [
            (volume_a, "the volume of chamber A vanishes"),
            (volume_b, "the volume of chamber B vanishes"),
            (pressure_a, "chamberA.pressure falls to 0"),
            (pressure_b, "chamberB.pressure falls to 0"),
            (temperature_a, "chamberA.temperature falls to 0"),
            (temperature_b, "chamberB.temperature falls to 0"),
        ] {
            if value.is_nan() || value <= 0.0 {
                return Err(reason);
            }
        }
        Ok(())
    }

    fn scales(&self) -> [f64; N] {
        let mut scales = [BRISTLE_ALLOWANCE * self.friction.state_scale(); N];
        scales[ACTUATOR_RATE] = SPOOL_ALLOWANCE * self.p.bandwidth;
        scales[ACTUATOR] = SPOOL_ALLOWANCE;
        (scales[PRESSURE_A], scales[PRESSURE_B]) = (1e5, 1e5);
        (scales[TEMPERATURE_A], scales[TEMPERATURE_B]) = (300.0, 300.0);
        scales[position(N)] = 0.1;
        scales[velocity(N)] = 0.1;
        scales
    }

    fn content(&self, x: &[f64; N], memory: &Memory) -> [f64; QUANTITIES] {
        self.mass_and_energy(x, memory)
    }

    fn inflow(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &Memory) -> [f64; QUANTITIES] {
        self.mass_flow_and_power(time, x, u, memory)
    }

    fn fits(&self, memory: &Memory) -> bool {
        memory.set_point.is_finite() && self.friction.fits(&memory.friction)
    }
}

impl<const N: usize> Equations<N, 3> for PneumaticServoCylinder {
    const RESIDUALS: usize = variables::RESIDUALS;

    fn outputs<S: Scalar>(&self, time: S, x: &[S; N], u: &[S; 3], memory: &Memory, computed: &mut [S]) {
        let rate = self.rate(x, memory);
        let contact = self.contact(time, x, u, rate);
        let friction = self.friction.observe(&contact, x, &memory.friction);
        let acceleration = friction.unless_held((contact.applied - friction.force) * self.per_mass);
        let gas = self.gas(x);
        let Pair([temperature_a, temperature_b]) = gas.temperature;
        let gas = self.gas_rates(gas, x[position(N)], rate, self.inflow(x[ACTUATOR], u[2], gas));
        let Pair([mass_flow_a, mass_flow_b]) = gas.mass_flow;
        let Pair([pressure_rate_a, pressure_rate_b]) = gas.pressure;
        let Pair([temperature_rate_a, temperature_rate_b]) = gas.temperature;
        let [actuator_acceleration, actuator_rate] = self.actuator_rates([x[ACTUATOR_RATE], x[ACTUATOR]], u[0], memory);
        let is_valve = matches!(self.actuator, Actuator::Valve(..));
        let of_valve = |value: S| if is_valve { value } else { S::zero() };
        let of_regulator = |value: S| if is_valve { S::zero() } else { value };
        let outputs = Outputs {
            position: x[position(N)],
            velocity: rate,
            acceleration,
            rod_force: acceleration * self.p.carriage_mass - u[1] + (self.p.wire_force + self.carriage_weight),
            pressure_force: self.pressure_force(x),
            friction_force: friction.force,
            pressure_a: x[PRESSURE_A],
            pressure_b: x[PRESSURE_B],
            temperature_a,
            temperature_b,
            mass_flow_a,
            mass_flow_b,
            spool: of_valve(x[ACTUATOR]),
            sticking: friction.sticking,
            pressure_rate_a,
            temperature_rate_a,
            pressure_rate_b,
            temperature_rate_b,
            spool_velocity: of_valve(x[ACTUATOR_RATE]),
            spool_acceleration: of_valve(actuator_acceleration),
            regulator_pressure: of_regulator(x[ACTUATOR]),
            regulator_rate: of_regulator(actuator_rate),
            valve_command: match &self.actuator {
                Actuator::Valve(valve, _) => Self::set_point(valve, u[0], memory),
                Actuator::Regulator(..) => S::zero(),
            },
            stop_force: self.applied_force(x, u, rate).1,
            load_level: contact.level,
        };
        write_bristles(&friction, outputs.write(computed));
    }

    fn state_index(&self, place: usize) -> Option<usize> {
        let is_valve = matches!(self.actuator, Actuator::Valve(..));
        match place {
            0 => Some(position(N)),
            1 => Some(velocity(N)),
            2 => Some(PRESSURE_A),
            3 => Some(TEMPERATURE_A),
            4 => Some(PRESSURE_B),
            5 => Some(TEMPERATURE_B),
            6 => is_valve.then_some(ACTUATOR),
            7 => is_valve.then_some(ACTUATOR_RATE),
            8 => (!is_valve).then_some(ACTUATOR),
            bristle => (bristle - 9 < self.friction.count()).then_some(BRISTLES + bristle - 9),
        }
    }
}
