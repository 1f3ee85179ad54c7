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
mod couplings;
mod gentle;
mod jacobian;
mod lines;
mod options;
mod outputs;
mod rates;
mod sensors;
mod variables;

use std::f64::consts::PI;
use std::ops::Range;

use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};

use self::gentle::{GentleSteps, WORTHWHILE};
use self::lines::Lines;
use self::options::Options;
use self::sensors::Sensors;
use self::variables::{Inputs, Outputs, Parameters, State};
use crate::co_simulation::Simulation;
use crate::friction::{self, Drive, Event, Friction, FrictionContact, Indicators, Laws, MAX_STATES};
use crate::hybrid::{Couplings, Groups, Indicator, Led, Limits, LongestSteps, QUANTITIES, Sample, Stride, UNUSED};
use crate::mechanics::{EndStops, GRAVITY, OneSided};
use crate::model::{Course, Experiment, Model, Panel, Signal, Start};
use crate::numbers::{Number, Pair, Real, Scalar};
use crate::pneumatics::actuator::{self, Actuator, Actuators, STATES};
use crate::pneumatics::chamber::{Chambers, Thermal, ThermalModel, tank_wall};
use crate::pneumatics::gas::{self, Reservoir};
use crate::run_sized;
use crate::sensor;
use crate::session::read;
use crate::system::{Place, Shortcuts, System, Tables, indicators, references, table};
use crate::variables::{Notice, Notices, ParameterError, Tunable, Values};

/// The model as the library offers it.
pub const MODEL: Model = model::<Friction, Actuator>();

/// The model with the laws and the actuators of catalogues.
pub const fn model<L: Laws, A: Actuators>() -> Model {
    Model {
        name: "PneumaticServoCylinder",
        description: "Friction-loaded pneumatic servo cylinder with 5/3 proportional valve",
        variables: table::<PneumaticServoCylinder<L, A>, 3>,
        indicators: indicators::<PneumaticServoCylinder<L, A>, 3>,
        start: start::<L, A>,
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
    }
}

/// The equations of the cylinder for given parameters; `EXTENDED` ones for a cylinder that uses any of the options, or has
/// an actuator that changes by itself.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct PneumaticServoCylinder<L = Friction, A = Actuator, const EXTENDED: bool = false> {
    p: Parameters,
    options: Options,
    lines: Lines,
    sensors: Sensors,
    actuator: A,
    /// Chambers A and B.
    chambers: Chambers,
    /// Area in m2 of the rod less that of a second one: what the atmosphere acts on.
    rod_area: f64,
    supply: Reservoir,
    exhaust: Reservoir,
    stops: EndStops,
    friction: FrictionContact<L>,
    /// Inverse of the moving mass in 1/kg.
    per_mass: f64,
    /// Constant part of the applied force in N: wire and weight.
    dead_load: Tunable,
    /// Weight of the carriage along the axis in N.
    carriage_weight: f64,
    /// Whether explicit steps may be taken.
    is_gentle: bool,
    /// How long they may be.
    gentle: GentleSteps,
    /// Which states change which others; of a cylinder with [attachments](Self::has_attachments) only.
    couplings: Couplings<MOST>,
}

/// Modes and memories of the cylinder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[doc(hidden)]
pub struct Memory<F = friction::Memory, A = actuator::Memory> {
    actuator: A,
    friction: F,
    sensors: sensors::Memory,
}

/// The memory of a cylinder with laws and actuators of catalogues.
type MemoryOf<L, A> = Memory<<L as Laws>::Memory, <A as Actuators>::Memory>;

// In front of the friction law the places do not depend on its number of states.
const TEMPERATURE_A: usize = State::TemperatureA.at(State::OTHERS);
const TEMPERATURE_B: usize = State::TemperatureB.at(State::OTHERS);
/// Index of the pressure in chamber A among the states.
#[doc(hidden)]
pub const PRESSURE_A: usize = State::PressureA.at(State::OTHERS);
/// Index of the pressure in chamber B among the states.
#[doc(hidden)]
pub const PRESSURE_B: usize = State::PressureB.at(State::OTHERS);

/// The states of the actuator, which come first.
#[inline(always)]
fn of_actuator<S: Copy>(x: &[S]) -> [S; STATES] {
    std::array::from_fn(|place| x[place])
}

/// How many times larger the errors of the states of a friction law may be than those of other states: what they do to
/// position and friction force stays far below the promised accuracy, and they would take most of the steps.
const FRICTION_ALLOWANCE: f64 = 10.0;

/// States of a cylinder that has them all.
const MOST: usize = State::OTHERS + MAX_STATES + lines::STATES + sensors::COUNT;

/// Whether few sizes are compiled, with more states than needed in most of them.
const SMALL: bool = cfg!(feature = "small");

/// Starts a run with as many states as friction law, lines and sensors need, or a few more.
fn start<L: Laws, A: Actuators>(start: &Start) -> Result<Box<dyn Simulation>, ParameterError> {
    let (parts, settings) = read::<PneumaticServoCylinder<L, A>, 3, _>(start, &[], Parts::<L, A>::read)?;
    let settings = settings.keeping_balance(parts.parameters.keeps_balance);
    if !parts.need_extension() {
        let equations = PneumaticServoCylinder::<L, A>::of(parts);
        return run_sized!(start, equations, settings, 3, [
            // Always there: kinks are searched for otherwise where a friction law may have states.
            State::OTHERS,
            State::OTHERS + 1 => !SMALL,
            State::OTHERS + 2,
            State::OTHERS + 4 => !SMALL,
            State::OTHERS + MAX_STATES
        ]);
    }
    let equations = PneumaticServoCylinder::<L, A, true>::of(parts);
    run_sized!(start, equations, settings, 3, [
        State::OTHERS + 2 => !SMALL,
        State::OTHERS + 2 + sensors::COUNT => !SMALL,
        State::OTHERS + MAX_STATES => !SMALL,
        State::OTHERS + 2 + lines::STATES => !SMALL,
        State::OTHERS + MAX_STATES + lines::STATES => !SMALL,
        MOST
    ])
}

/// What the equations are made of.
struct Parts<L, A> {
    parameters: Parameters,
    options: Options,
    sensors: Sensors,
    actuator: A,
    friction: L,
}

impl<L: Laws, A: Actuators> Parts<L, A> {
    fn read(values: &mut Values) -> Result<Self, ParameterError> {
        let parameters: Parameters = values.read()?;
        parameters.check()?;
        let options: Options = values.read()?;
        options.check(parameters.bore, parameters.stroke)?;
        let sensors: Sensors = values.read()?;
        sensors.check()?;
        Ok(Self { parameters, options, sensors, actuator: A::read(values)?, friction: L::read(values, "friction")? })
    }

    /// Whether any of them is compiled for extended equations only.
    fn need_extension(&self) -> bool {
        self.options.are_used() || self.sensors.are_used() || self.actuator.is_sampled()
    }
}

impl<L: Laws, A: Actuators, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    fn of(Parts { parameters: p, options, sensors, actuator, friction }: Parts<L, A>) -> Self {
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
        // Friction along the stroke, and waves in short hoses: explicit steps would be too many.
        let has_rapid_parts = lines.longest_steps().classical < WORTHWHILE || options.waviness != 0.0;
        let mut cylinder = Self {
            is_gentle: friction.is_gentle() && actuator.has_closed_form() && !(EXTENDED && has_rapid_parts),
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
            couplings: Couplings::NONE,
        };
        if cylinder.has_attachments() {
            cylinder.couplings = cylinder.found_couplings();
        }
        cylinder
    }

    /// The next point in time at which a part changes by itself.
    fn next_change(&self, memory: &MemoryOf<L, A>) -> Sample {
        let of_friction = self.friction.next_sample(&memory.friction);
        if !EXTENDED {
            return of_friction;
        }
        let of_sensors = self.sensors.next_sample(&memory.sensors);
        self.actuator.next_sample(&memory.actuator).earlier(of_friction).earlier(of_sensors)
    }
}

impl<L: Laws, A: Actuators, const EXTENDED: bool> System<3> for PneumaticServoCylinder<L, A, EXTENDED> {
    type Parameters = Parameters;
    type State = State;
    type Memory = MemoryOf<L, A>;
    type Indicators = Indicators;

    const RESIDUALS: usize = variables::RESIDUALS;

    fn tables() -> Tables {
        variables::tables::<L, A>()
    }

    fn new(values: &mut Values) -> Result<Self, ParameterError> {
        Ok(Self::of(Parts::read(values)?))
    }

    fn parameters(&self) -> &Parameters {
        &self.p
    }

    fn start<const N: usize>(&self, inputs: &[f64; 3]) -> ([f64; N], Self::Memory) {
        let u = Inputs::read(inputs);
        let mut x = [0.0; N];
        State::Position.set(&mut x, self.p.position0);
        State::Velocity.set(&mut x, self.p.velocity0);
        (x[PRESSURE_A], x[PRESSURE_B]) = (self.p.pressure0_a, self.p.pressure0_b);
        if EXTENDED && self.options.opens_b {
            x[PRESSURE_B] = self.p.ambient_pressure;
        }
        (x[TEMPERATURE_A], x[TEMPERATURE_B]) = (self.p.ambient_temperature, self.p.ambient_temperature);
        if EXTENDED && self.lines.are_used() {
            let states = self.lines.start([x[PRESSURE_A], x[PRESSURE_B]], u.supply_pressure);
            self.put_lines(&states, &mut x);
        }
        let (states, actuator) = self.actuator.start(u.valve_voltage);
        x[..STATES].copy_from_slice(&states);
        let (there, u) = (Real::all(&x), Inputs::read(&Real::all(inputs)));
        let contact = self.contact(Real::zero(), &there, &u, State::Velocity.get(&there));
        let friction = self.friction.start(&contact.plain());
        let force = self.friction.force(&contact, &there, &friction, &mut [Real::zero(); N]);
        let acceleration = self.friction.rate((contact.applied - force) * self.per_mass, &friction);
        let quantities = self.measured(&there, &u, acceleration).map(Real::value);
        if EXTENDED && self.sensors.states() > 0 {
            x[Self::first_of_sensors(N)..][..sensors::COUNT].copy_from_slice(&quantities);
        }
        (x, Memory { actuator, friction, sensors: self.sensors.start(quantities) })
    }

    fn states(&self) -> usize {
        State::OTHERS + self.friction.count() + self.lines.states() + self.sensors.states()
    }

    fn unused(&self, n: usize) -> Range<usize> {
        let behind_friction = self.friction.states().end;
        behind_friction..behind_friction + n - self.states()
    }

    fn state_at(&self, reference: u32, n: usize) -> Option<usize> {
        let own = State::of(reference).map(|state| state.at(n));
        let of_lines = || self.lines.state_at(reference).and_then(|place| self.places_of_lines(n).nth(place));
        let of_sensors = || self.sensors.state_at(reference).map(|place| Self::first_of_sensors(n) + place);
        own.or_else(|| self.friction.state_at(reference))
            .or_else(|| self.actuator.state_at(reference))
            .or_else(|| of_lines().map(|(_, index)| index))
            .or_else(of_sensors)
    }

    fn indicator_list() -> Vec<Indicator> {
        Event::indicators("friction")
    }

    fn kink_list() -> Vec<Indicator> {
        let kink = |name: &str, text| Indicator { name: name.to_owned(), nominal: 1e-3, text };
        vec![
            kink("cylinder.stopA", "The stop at position 0 is touched or left"),
            kink("cylinder.stopB", "The stop at the end of the stroke is touched or left"),
            kink("cushionA.entry", "The piston enters or leaves the cushion of chamber A"),
            kink("cushionB.entry", "The piston enters or leaves the cushion of chamber B"),
        ]
    }

    fn kinks<const N: usize>(&self, x: &[f64; N], kinks: &mut [f64]) {
        let Pair(lengths) = self.lengths(Real::of(State::Position.get(x)));
        let lengths = lengths.map(Real::value);
        let (stops, cushions) = kinks.split_at_mut(lengths.len());
        stops.copy_from_slice(&lengths);
        for (side, kink) in cushions.iter_mut().enumerate() {
            *kink = self.lines.cushion(side).map_or(UNUSED, |length| lengths[side] - length);
        }
    }

    fn outputs<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; 3],
        memory: &Self::Memory,
        computed: &mut [S],
    ) {
        self.write_outputs(time, x, &Inputs::read(u), memory, computed);
    }

    fn keeps_balance(&self) -> bool {
        self.p.keeps_balance
    }

    fn notices(&self, u: &[f64; 3]) -> Notices {
        let Inputs { supply_pressure: value, .. } = Inputs::read(u);
        let remark = "it acts as ambientPressure, which is higher; pressures are absolute and in Pa";
        let is_low = value < self.p.ambient_pressure && self.actuator.has_supply();
        let low = is_low.then_some(Notice { variable: "supplyPressure", value, remark });
        [self.friction.law().notice(), low]
    }

    fn derivatives<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; 3],
        memory: &MemoryOf<L, A>,
    ) -> [S; N] {
        let mut rates = [S::zero(); N];
        self.write_rates(time, x, u, memory, &mut rates);
        rates
    }

    fn indicators<const N: usize>(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &MemoryOf<L, A>) -> Indicators {
        let contact = self.contact_now(time, x, u, self.rate_now(x, memory));
        self.friction.indicators(&contact, x, &memory.friction)
    }

    fn has_events(&self) -> bool {
        self.friction.has_events()
    }

    fn switch<const N: usize>(
        &self,
        event: usize,
        time: f64,
        x: &mut [f64; N],
        u: &[f64; 3],
        memory: &mut MemoryOf<L, A>,
    ) {
        let contact = self.contact_now(time, x, u, self.rate_now(x, memory));
        self.friction.switch(Event::ALL[event], &contact, State::Velocity.at(N), x, &mut memory.friction);
    }

    fn follow<const N: usize>(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &mut MemoryOf<L, A>) -> bool {
        self.actuator.follow(Inputs::read(u).valve_voltage, &mut memory.actuator);
        let rate = self.rate_now(x, memory);
        self.friction.follow(|| self.contact_now(time, x, u, rate), x, &mut memory.friction)
    }

    fn next_sample(&self, memory: &MemoryOf<L, A>) -> Sample {
        self.next_change(memory)
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

    fn rounded(&self) -> Vec<String> {
        self.sensors.rounded()
    }

    fn sample<const N: usize>(&self, time: f64, x: &mut [f64; N], u: &[f64; 3], memory: &mut MemoryOf<L, A>) {
        if EXTENDED {
            // One part at a time, the earliest; the others follow when they are the earliest.
            let next = self.next_change(memory);
            if self.actuator.next_sample(&memory.actuator) == next {
                let mut states = of_actuator(x);
                self.actuator.sample(&mut states, Inputs::read(u).valve_voltage, &mut memory.actuator);
                x[..STATES].copy_from_slice(&states);
                return;
            }
            if self.sensors.next_sample(&memory.sensors) == next {
                self.take_readings(time, x, u, memory);
                return;
            }
        }
        let rate = self.rate_now(x, memory);
        self.friction.sample(|| self.contact_now(time, x, u, rate), time, x, &mut memory.friction);
    }

    fn arrive<const N: usize>(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &mut MemoryOf<L, A>) {
        if EXTENDED {
            self.take_readings(time, x, u, memory);
        }
    }

    fn admit<const N: usize>(&self, x: &[f64; N]) -> Result<(), &'static str> {
        /// What has no meaning if one of these is not above 0: volumes, pressures, temperatures.
        const REASONS: [&str; 6] = [
            "the volume of chamber A vanishes",
            "the volume of chamber B vanishes",
            "chamberA.pressure falls to 0",
            "chamberB.pressure falls to 0",
            "chamberA.temperature falls to 0",
            "chamberB.temperature falls to 0",
        ];
        let Pair([volume_a, volume_b]) = self.chambers.volume(self.lengths(Real::of(State::Position.get(x))));
        let [volume_a, volume_b] = [volume_a.value, volume_b.value];
        let [pressure_a, pressure_b, temperature_a, temperature_b] =
            [PRESSURE_A, PRESSURE_B, TEMPERATURE_A, TEMPERATURE_B].map(|index| x[index]);
        let is_above =
            [volume_a, volume_b, pressure_a, pressure_b, temperature_a, temperature_b].map(|value| value > 0.0);
        // All at once, since as a rule all are.
        if !is_above.iter().fold(true, |all, one| all & one) {
            return Err(REASONS[is_above.iter().position(|one| !one).unwrap_or_default()]);
        }
        if EXTENDED && self.lines.are_used() && !self.lines.are_filled(&self.of_lines(&Real::all(x)).map(Real::value)) {
            return Err("the pressure in a hose or in the vessel falls to 0");
        }
        Ok(())
    }

    fn limits<const N: usize>(&self) -> [Limits; N] {
        let mut limits = self.scales().map(Limits::of_magnitude);
        limits[State::Position.at(N)] = self.stops.limits();
        for (state, least) in [
            (State::PressureA, gas::THINNEST),
            (State::PressureB, gas::THINNEST),
            (State::TemperatureA, gas::COLDEST),
            (State::TemperatureB, gas::COLDEST),
        ] {
            limits[state.at(N)] = Limits::above(least, state.scale(&self.p));
        }
        if EXTENDED && self.lines.are_used() {
            self.put_lines(&self.lines.limits(), &mut limits);
        }
        limits
    }

    fn scales<const N: usize>(&self) -> [f64; N] {
        let mut scales = [FRICTION_ALLOWANCE * self.friction.state_scale(); N];
        scales[..STATES].copy_from_slice(&self.actuator.scales());
        if EXTENDED && self.lines.are_used() {
            self.put_lines(&Lines::scales(), &mut scales);
        }
        if EXTENDED && self.sensors.states() > 0 {
            scales[Self::first_of_sensors(N)..][..sensors::COUNT].copy_from_slice(&Sensors::scales());
        }
        State::ALL.iter().for_each(|state| scales[state.at(N)] = state.scale(&self.p));
        scales
    }

    fn content<const N: usize>(&self, x: &[f64; N], memory: &MemoryOf<L, A>) -> [f64; QUANTITIES] {
        self.mass_and_energy(x, memory)
    }

    fn inflow<const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &MemoryOf<L, A>,
    ) -> [f64; QUANTITIES] {
        self.mass_flow_and_power(time, x, u, memory)
    }

    fn fits(&self, memory: &MemoryOf<L, A>) -> bool {
        self.actuator.fits(&memory.actuator)
            && self.friction.fits(&memory.friction)
            && memory.sensors.iter().all(sensor::Memory::is_sound)
    }
}

impl<L: Laws, A: Actuators, const EXTENDED: bool> Shortcuts<3> for PneumaticServoCylinder<L, A, EXTENDED> {
    const GROUPS: Groups = [STATES, State::FRICTION];

    const LED: usize = STATES;

    const RELAXING: Option<Place> = Some(Place::Front(State::FRICTION));

    const TURNING: Option<Place> = Some(Place::Back(0));

    fn at_hand<const N: usize>(&self, place: usize, x: &[f64; N], memory: &Self::Memory) -> Option<f64> {
        const POSITION: usize = Outputs::PLACES.position;
        const VELOCITY: usize = Outputs::PLACES.velocity;
        const IN_A: usize = Outputs::PLACES.pressure_a;
        const IN_B: usize = Outputs::PLACES.pressure_b;
        match place {
            POSITION => Some(State::Position.get(x)),
            VELOCITY => Some(self.rate_now(x, memory)),
            IN_A => Some(x[PRESSURE_A]),
            IN_B => Some(x[PRESSURE_B]),
            _ => None,
        }
    }

    fn driven<const N: usize>(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &MemoryOf<L, A>) -> [f64; N] {
        let (mut rates, u) = ([Real::zero(); N], Inputs::read(&Real::all(u)));
        self.driven_rates(Real::of(time), &Real::all(x), &u, memory, &mut rates);
        rates.map(Real::value)
    }

    fn jacobian<const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &MemoryOf<L, A>,
        jacobian: &mut SMatrix<f64, N, N>,
    ) -> [f64; N] {
        self.linearise(time, x, u, memory, jacobian)
    }

    fn is_chain(&self) -> bool {
        EXTENDED && self.lines.are_used()
    }

    fn indicators_hold(&self, inputs: [&[f64; 3]; 2]) -> bool {
        act_on_actuator_alone(inputs) && !self.friction.follows()
    }

    fn refresh<const N: usize>(
        &self,
        x: &[f64; N],
        inputs: [&[f64; 3]; 2],
        memory: &MemoryOf<L, A>,
        derivatives: &mut [f64; N],
    ) -> bool {
        if !act_on_actuator_alone(inputs) {
            return false;
        }
        let voltage = Real::of(Inputs::read(inputs[1]).valve_voltage);
        let rates = self.actuator.rates(Real::all(&of_actuator(x)), voltage, &memory.actuator);
        derivatives[..STATES].copy_from_slice(&rates.map(Real::value));
        true
    }

    fn is_gentle(&self) -> bool {
        self.is_gentle
    }

    fn is_hasty(&self, memory: &MemoryOf<L, A>) -> bool {
        EXTENDED && self.actuator.is_hasty(&memory.actuator)
    }

    fn relaxation<const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        rates: &[f64; N],
        u: &[f64; 3],
        memory: &MemoryOf<L, A>,
    ) -> f64 {
        let contact = || self.contact_now(time, x, u, self.rate_now(x, memory));
        self.friction.relaxation(contact, [x, rates], &memory.friction)
    }

    fn longest_gentle_steps<const N: usize>(&self, x: &[f64; N]) -> LongestSteps {
        let of_motion = self.gentle.longest(self.stops.touched(State::Position.get(x)), State::Velocity.get(x));
        if !EXTENDED {
            return of_motion;
        }
        let longest = of_motion.min(self.lines.longest_steps());
        // Chambers that pulses vent come so close to the pressure outside that the midpoint rule does not follow.
        if self.actuator.is_sampled() { LongestSteps { midpoint: 0.0, ..longest } } else { longest }
    }

    fn is_smooth<const N: usize>(
        &self,
        [x, end]: [&[f64; N]; 2],
        u: [&[f64; 3]; 2],
        memory: &MemoryOf<L, A>,
        step: f64,
    ) -> bool {
        let [u, u_end] = u.map(Inputs::read);
        let states = [of_actuator(x), of_actuator(end)];
        self.piece(x, &u) == self.piece(end, &u_end)
            && self.actuator.stays_in_piece(states, u.valve_voltage, &memory.actuator, step)
    }

    fn stride(&self, size: f64) -> Stride {
        Stride { size, half: self.actuator.half(size) }
    }

    fn led<const N: usize>(
        &self,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &MemoryOf<L, A>,
        stride: &Stride,
    ) -> Led<[f64; N]> {
        let voltage = Inputs::read(u).valve_voltage;
        let Led { middle, end, bend } = self.actuator.later(of_actuator(x), voltage, &memory.actuator, stride);
        let placed = |own: [f64; STATES]| {
            let mut all = [0.0; N];
            all[..STATES].copy_from_slice(&own);
            all
        };
        Led { middle: placed(middle), end: placed(end), bend: placed(bend) }
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
    use crate::models::checks;
    use crate::session::build;
    use crate::variables::Variable;

    /// Messages call an event of a contact as a host calls its indicator, without the group.
    #[test]
    fn events_are_named_as_their_indicators() {
        checks::events_are_named::<PneumaticServoCylinder, 3>(|_, last| last);
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
            let parameters: Vec<f64> = (MODEL.variables)().parameters().map(value).collect();
            let start = Start { time: 0.0, parameters: &parameters, inputs: &[5.0, 0.0, 6e5], tolerance: None };
            let run = (MODEL.start)(&start).expect("legal");
            let integrated =
                (0..(MODEL.variables)().states().count()).filter(|state| run.state_index(*state).is_some());
            let (equations, _) =
                build::<PneumaticServoCylinder<Friction, Actuator, true>, 3>(&start, &[]).expect("legal");
            assert_eq!(equations.states(), integrated.count(), "law {law}, {options:?}");
        }
    }
    #[test]
    fn laws_cost_what_they_ask_for() {
        checks::laws_cost_what_they_ask_for::<PneumaticServoCylinder, 3>([false; 2]);
    }

    /// Another voltage changes the rates of the spool alone, so that no others are evaluated anew; other inputs change more.
    #[test]
    fn rates_are_refreshed_where_the_voltage_alone_has_changed() {
        let parameters: Vec<f64> = (MODEL.variables)().parameters().filter_map(|it| it.start).collect();
        let before = [6.0, 1.0, 6e5];
        let start = Start { time: 0.0, parameters: &parameters, inputs: &before, tolerance: None };
        let (equations, _) = build::<PneumaticServoCylinder, 3>(&start, &[]).expect("the defaults fit");
        let (x, memory) = equations.start::<{ State::OTHERS }>(&before);
        for (inputs, is_refreshed) in
            [([6.5, 1.0, 6e5], true), (before, true), ([6.5, 1.5, 6e5], false), ([6.0, 1.0, 5e5], false)]
        {
            let (mut rates, mut memory) = (equations.driven(0.0, &x, &before, &memory), memory.clone());
            let unchanged = rates;
            equations.follow(0.0, &x, &inputs, &mut memory);
            assert_eq!(equations.refresh(&x, [&before, &inputs], &memory, &mut rates), is_refreshed, "{inputs:?}");
            let expected = if is_refreshed {
                crate::hybrid::HybridSystem::rates(&equations, 0.0, &x, &inputs, &memory)
            } else {
                unchanged
            };
            assert_eq!(rates.map(f64::to_bits), expected.map(f64::to_bits), "{inputs:?}");
            assert_eq!(equations.indicators_hold([&before, &inputs]), is_refreshed, "{inputs:?}");
        }
    }
}
