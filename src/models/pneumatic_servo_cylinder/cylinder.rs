//! The cylinder: its parts, its discrete memory, and a run of as many states as it needs.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::ends;
use super::leaks::Leaks;
use super::lines;
use super::lines::Lines;
use super::motion::{self, Guidance};
use super::options::Options;
use super::parameters::Parameters;
use super::sensors::{self, Sensors};
use super::states::{ALL, FEW, Inputs, MOST, State};
use crate::co_simulation::{AnyRun, run_sized};
use crate::friction::{self, ContactLaw, Drive, Friction, FrictionContact, FrictionLaw, Law, MAX_STATES};
use crate::mechanics::{EndStops, GRAVITY, OneSided};
use crate::model::Start;
use crate::numbers::{MonotoneCurve, Pair, Real, Scalar, Tangent};
use crate::pneumatics::actuator::{self, Actuating, Actuator};
use crate::pneumatics::chamber::{Chambers, Thermal, ThermalModel, tank_wall};
use crate::pneumatics::gas::{Gas, Reservoir};
use crate::session::read;
use crate::system::{Couplings, LongestSteps, PartFacts, references};
use crate::variables::{ParameterError, Tunable, Values};

/// The equations of the cylinder for given parameters; `EXTENDED` ones for a cylinder that uses any of the options, or has
/// an actuator that changes by itself.
#[derive(Clone, Debug)]
pub struct PneumaticServoCylinder<L = Friction, A = Actuator, const EXTENDED: bool = false> {
    pub(super) p: Parameters,
    pub(super) options: Options,
    pub(super) lines: Lines,
    pub(super) sensors: Sensors,
    pub(super) actuator: A,
    /// The gas in it and around it.
    pub(super) filling: Gas,
    /// Chambers A and B.
    pub(super) chambers: Chambers,
    /// Area in m2 of the rod less the area of a second one: the atmosphere acts on it.
    pub(super) rod_area: Tangent,
    pub(super) supply: Reservoir,
    pub(super) exhaust: Reservoir,
    pub(super) leaks: Option<Leaks>,
    pub(super) stops: EndStops,
    /// Drive of the carriage.
    pub(super) guidance: Guidance,
    pub(super) friction: FrictionContact<L>,
    /// Whether friction has another level outwards than inwards.
    pub(super) has_directed_level: bool,
    /// Whether Stribeck velocity or viscous friction follow the pressures.
    pub(super) is_lubricated: bool,
    /// Friction of a guide that the load presses on, over the force that moves the load.
    pub(super) guide: Option<Tangent>,
    /// Whether some viscous friction acts in one direction alone.
    pub(super) has_one_way_damping: bool,
    /// Whether friction varies along the stroke.
    pub(super) has_waviness: bool,
    /// Factor of the load factor over the position in m.
    pub(super) profile: Option<MonotoneCurve>,
    /// Inverse of the moving mass in 1/kg.
    pub(super) per_mass: Tangent,
    /// Constant part of the applied force in N: wire and weight, which is the tool's own where it imposes the motion.
    pub(super) dead_load: Tunable,
    /// Weight of the carriage along the axis in N.
    pub(super) carriage_weight: Tangent,
    /// The longest explicit steps beside the spring of a coupling.
    pub(super) longest_coupled: LongestSteps,
    /// The longest explicit steps, if any may be taken.
    pub(super) explicit: Option<ExplicitSteps>,
    /// Which states change which others; of a cylinder whose [Jacobian](Self::linearise) is made by them only.
    pub(super) couplings: Couplings<MOST>,
}

/// Modes and memories of the cylinder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory<F = friction::Memory, A = actuator::Memory, S = Real> {
    pub(super) actuator: A,
    pub(super) friction: F,
    pub(super) sensors: sensors::Memory<S>,
    pub(super) motion: motion::Memory<S>,
    pub(super) ends: ends::Memory,
}

/// The memory of a cylinder with laws and actuators of catalogues.
pub(super) type MemoryOf<L, A, S> = Memory<<L as FrictionLaw>::Memory<S>, <A as Actuating>::Memory<S>, S>;

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    pub(super) fn of(Parts { parameters: p, options, sensors, actuator, friction }: Parts<L, A>) -> Self {
        let area = |diameter: Tangent| PI * diameter * diameter / 4.0;
        let pressures0 = [p.pressure0_a, p.pressure0_b].into();
        let filling = options.gas();
        let mut lines =
            Lines::new(&options, &filling, [p.ambient_pressure, p.ambient_temperature], p.supply_temperature);
        lines.behind = sensors.states();
        let [hose_a, hose_b] = lines.added_volumes();
        let areas = [area(p.bore) - area(options.rod_a), area(p.bore) - area(p.rod)];
        let chambers = Chambers {
            areas: areas.into(),
            walls: [2.0 * areas[0], 2.0 * areas[1] + tank_wall(p.tank_volume)].into(),
            bore: p.bore,
            dead_volumes: [p.dead_volume_a + hose_a, p.dead_volume_b + p.tank_volume + hose_b].into(),
            ambient_temperature: p.ambient_temperature,
            thermal: match p.thermal_model {
                ThermalModel::Isothermal => {
                    Thermal::Polytropic { exponent: Tangent::still(1.0), reference_pressures: pressures0 }
                }
                ThermalModel::Polytropic => {
                    Thermal::Polytropic { exponent: p.exponent, reference_pressures: pressures0 }
                }
                ThermalModel::PolytropicServo => Thermal::PolytropicServo { exponent: p.exponent },
                ThermalModel::EnergyBalance => Thermal::EnergyBalance { heat_transfer: p.heat_transfer },
            },
        };
        let slope = GRAVITY * p.incline.sin();
        let guidance = options.guidance();
        let drive = if guidance == Guidance::Rigid { Drive::Motion } else { Drive::Force };
        let friction =
            FrictionContact::new(friction, drive, State::FRICTION, State::Velocity.index(), references::CONTACT)
                .allowing(FRICTION_ALLOWANCE);
        let longest_coupled = guidance.longest(p.moving_mass.value);
        // Friction along the stroke, and waves in short hoses: explicit steps would be too many.
        let longest = lines.longest_steps().min(longest_coupled);
        let has_rapid_parts = longest.classical < WORTHWHILE || options.waviness.is_used();
        // The friction of a guide turns where the force that moves the load does.
        let has_rapid_parts = has_rapid_parts || options.guide().is_some();
        // Where a state is the velocity, the reversal of bristles is found by it.
        let has_rapid_parts = has_rapid_parts || (guidance == Guidance::Rigid && friction.states() > 0);
        let is_explicit = friction.is_non_stiff() && actuator.has_closed_form() && !(EXTENDED && has_rapid_parts);
        let mut cylinder = Self {
            explicit: is_explicit.then(|| ExplicitSteps::new(&friction, p.stop_stiffness.value, p.moving_mass.value)),
            actuator,
            chambers,
            rod_area: area(p.rod) - area(options.rod_a),
            supply: Reservoir::new(&filling, p.supply_temperature),
            exhaust: Reservoir::new(&filling, p.ambient_temperature),
            leaks: Leaks::new(p.piston_leakage * filling.laminar_flow(), &options),
            filling,
            stops: EndStops {
                stroke: p.stroke,
                contact: OneSided { stiffness: p.stop_stiffness, damping: p.stop_damping },
                clearances: [0, 1].map(|side| chambers.dead_volumes.side(side) / chambers.areas.side(side)).into(),
            },
            guidance,
            longest_coupled,
            friction,
            has_directed_level: options.differs_by_direction(),
            is_lubricated: options.lubricating().is_some(),
            guide: options.guide(),
            has_one_way_damping: options.one_way_damping.is_used(),
            has_waviness: options.waviness.is_used(),
            profile: options.profile(),
            per_mass: 1.0 / p.moving_mass,
            dead_load: p.wire_force
                + if guidance == Guidance::Rigid { Tangent::still(0.0) } else { p.moving_mass * slope },
            carriage_weight: p.carriage_mass * slope,
            p,
            options,
            lines,
            sensors,
            couplings: Couplings::NONE,
        };
        if cylinder.is_linearised_by_couplings() {
            cylinder.couplings = cylinder.found_couplings();
        }
        cylinder
    }

    /// Number of states, for every number of inputs.
    pub fn states(&self) -> usize {
        State::OTHERS + self.friction.states() + self.lines.states() + self.sensors.states()
    }
}

/// The parameters, in the order of the table.
pub(super) type Listed<L, A> =
    (Parameters, Options, Sensors, <A as Actuating>::Parameters, ContactLaw<L, { Law::Stribeck as i32 }>);

/// Parts of the equations.
pub(super) struct Parts<L, A> {
    pub parameters: Parameters,
    pub options: Options,
    pub sensors: Sensors,
    pub actuator: A,
    pub friction: L,
}

impl<L: FrictionLaw, A: Actuating> Parts<L, A> {
    pub fn read(values: &mut Values) -> Result<Self, ParameterError> {
        let (parameters, options, sensors, actuator, ContactLaw(friction)): Listed<L, A> = values.read()?;
        parameters.check()?;
        options.check(parameters.bore.value, parameters.stroke.value)?;
        sensors.check()?;
        if let Some((name, value)) = options.direction().filter(|_| !friction.may_differ_by_direction()) {
            let reason = "under this friction law springs would give back more than they took; it needs a law without springs, such as \
                          Stribeck or Table, or one whose bristles bend at a stiffness of their own: Dahl, LuGre, RevisedLuGre, \
                          ElastoPlastic";
            return Err(ParameterError::new(name, value, reason));
        }
        if let Some((name, value)) = options.lubricating().filter(|_| !friction.is_lubricated()) {
            let reason = "this friction law has no Stribeck velocity beside a viscous friction that may follow the pressures; \
                          Stribeck, LuGre, RevisedLuGre and ElastoPlastic have";
            return Err(ParameterError::new(name, value, reason));
        }
        if options.guide().is_some() && !friction.is_set_valued() {
            let reason = "a guide sticks, too, which needs a friction law that is stuck or slides: Coulomb, CoulombStiction, \
                          Stribeck or Table";
            let value = options.guide_coefficient.value;
            return Err(ParameterError::new("friction.guide.coefficient", value, reason));
        }
        Ok(Self { parameters, options, sensors, actuator: A::new(actuator)?, friction })
    }

    /// Whether any of them is compiled for extended equations only.
    pub fn need_extension(&self) -> bool {
        let has_options = self.options.are_used() || self.sensors.are_used();
        has_options || self.actuator.is_sampled() || self.actuator.takes_commands_of_chambers()
    }
}

/// Factor by which the errors of the states of a friction law may exceed the errors of other states: their effect on
/// position and friction force stays far below the promised accuracy, and they would take most of the steps.
const FRICTION_ALLOWANCE: f64 = 10.0;

/// Longest explicit steps. At equal pressures the flow through an open valve settles within some ten milliseconds.
const LONGEST: LongestSteps = LongestSteps { classical: 0.01, midpoint: 0.005 };

/// Step size in s from which on explicit steps are cheaper than implicit ones where nothing but waves in hoses bounds them.
pub(super) const WORTHWHILE: f64 = 7e-5;

/// The longest explicit steps: bristles that hold the carriage are springs, on which it swings, and so are the stops.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExplicitSteps {
    /// While bristles hold.
    at_rest: LongestSteps,
    /// In contact with a stop.
    at_stop: LongestSteps,
    /// Speed in m/s from which on a bristle relaxes faster than the carriage swings.
    slipping: f64,
}

impl ExplicitSteps {
    /// Limits on explicit steps under a friction law, with stops of a stiffness in N/m, for a mass in kg.
    pub(super) fn new<L: FrictionLaw>(friction: &FrictionContact<L>, stop: f64, mass: f64) -> Self {
        let [stiffness, damping] = friction.resistance();
        let swing = |stiffness: f64| (stiffness.max(0.0) / mass).sqrt();
        let longest = |swing: f64| LongestSteps::of_swing(swing, damping.max(0.0) / mass).min(LONGEST);
        Self {
            at_rest: longest(swing(stiffness)),
            at_stop: longest(swing(stiffness + stop)),
            slipping: if friction.relaxes() { 2.0 * swing(stiffness) * friction.state_scale() } else { f64::INFINITY },
        }
    }

    /// The longest steps where stops are touched or not, at a velocity in m/s.
    #[inline(always)]
    pub(super) fn longest(&self, touched: [bool; 2], velocity: f64) -> LongestSteps {
        if touched[0] | touched[1] {
            self.at_stop
        } else if velocity.abs() < self.slipping {
            self.at_rest
        } else {
            LONGEST
        }
    }
}

impl<L: FrictionLaw, A: Actuating> PneumaticServoCylinder<L, A, true> {
    /// Refuses an imposed motion that begins where a chamber has no volume.
    fn check_start(&self, inputs: &[f64]) -> Result<(), ParameterError> {
        if self.is_free() {
            return Ok(());
        }
        let imposed = Inputs::of(&std::array::from_fn::<f64, ALL, _>(|place| inputs[place])).imposed().position;
        let Pair(volumes) = self.chambers.volume(self.lengths(Real::of(imposed)));
        let Some(chamber) = volumes.iter().position(|volume| volume.value <= 0.0) else { return Ok(()) };
        let reason = format!(
            "a motion cannot start there: chamber {} has no volume with cylinder.stroke = {}",
            ["A", "B"][chamber],
            self.p.stroke.value
        );
        Err(ParameterError::new("imposedPosition", imposed, &reason))
    }
}

/// Whether few sizes are compiled, with more states than needed in most of them.
const SMALL: bool = cfg!(feature = "small");

/// Starts a run with as many states as friction law, lines and sensors need, or a few more: each size is the whole solver
/// compiled once more. Spare states cost LuGre 4 % of a step, nothing with hoses.
pub(super) fn start<L: FrictionLaw, A: Actuating, P: AnyRun>(start: &Start) -> Result<P, ParameterError> {
    let (parts, settings) = read::<PneumaticServoCylinder<L, A>, FEW, _>(start, Parts::<L, A>::read)?;
    let settings = settings.keeping_balance(parts.parameters.keeps_balance);
    if !parts.need_extension() {
        let equations = PneumaticServoCylinder::<L, A>::of(parts);
        return run_sized!(
            start,
            equations,
            settings,
            FEW,
            [State::OTHERS, State::OTHERS + 4, State::OTHERS + MAX_STATES]
        );
    }
    let equations = PneumaticServoCylinder::<L, A, true>::of(parts);
    equations.check_start(start.inputs)?;
    run_sized!(start, equations, settings, ALL, [
        State::OTHERS + 2 + sensors::COUNT => !SMALL,
        State::OTHERS + 1 + lines::LINE_STATES => !SMALL,
        MOST
    ])
}
