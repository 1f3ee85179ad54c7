//! The variable table of the cylinder.

use super::cylinder::Listed;
use super::ends::EndSwitches;
use super::lines::{Lines, feeds};
use super::motion::Motion;
use super::sensors::Sensors;
use super::states::{FORCE, IMPOSED_POSITION, IMPOSED_VELOCITY, Inputs, State};
use crate::friction::{FrictionLaw, states};
use crate::outputs;
use crate::pneumatics::actuator::Actuating;
use crate::system::{Tables, references};
use crate::variables::{Condition, ParameterSet, Variable, units};

/// Conserved quantities: mass and energy.
pub const RESIDUALS: usize = 2;

/// Makes [`ByPart`] of the parts in their order.
macro_rules! by_part {
    ($($part:ident),*) => {
        /// Values for each part with computed variables: lists of the variables, their numbers, or slots for their values.
        pub(super) struct ByPart<T> { $(pub $part: T),* }

        impl<T> ByPart<T> {
            /// In the order in which the table lists the parts.
            pub fn in_order(self) -> [T; [$(stringify!($part)),*].len()] {
                [$(self.$part),*]
            }
        }

        impl<'s, S> ByPart<&'s mut [S]> {
            /// The slots of each part.
            #[inline(always)]
            pub fn new(mut slots: &'s mut [S], lengths: &ByPart<usize>) -> Self {
                Self { $($part: slots.split_off_mut(..lengths.$part).expect("a slot for each variable")),* }
            }
        }
    };
}

by_part!(outputs, actuator, friction, lines, sensors);

/// Every variable of the cylinder.
pub fn tables<L: FrictionLaw, A: Actuating>() -> Tables {
    let feeds = [A::feeds(0), A::feeds(1)];
    let at_ports = [[depends::P_A, depends::T_A, depends::X], [depends::P_B, depends::T_B, depends::X]];
    let measured = [&[depends::X][..], &[depends::P_A], &[depends::P_B], &depends::motion()];
    let outputs = Outputs::<f64>::table().into_iter().map(|variable| depends::on_feeds(variable, &feeds));
    let completed = |variables| states::completed::<L>(variables, references::CONTACT);
    let computed = ByPart {
        outputs: completed(outputs.collect()),
        actuator: A::computed(),
        friction: states::table::<L>("friction", references::CONTACT, [&depends::MOVING, &depends::LEVEL])
            .into_iter()
            .map(yielding)
            .collect(),
        lines: Lines::computed([&feeds[0], &feeds[1]], at_ports),
        sensors: completed(Sensors::computed(
            measured,
            [&[IMPOSED_POSITION], &[], &[], &[FORCE, IMPOSED_POSITION, IMPOSED_VELOCITY]],
        )),
    };
    let parameters = Listed::<L, A>::table();
    // A cylinder of one actuator has nothing to choose.
    let has = |name: &str| parameters.iter().any(|parameter| parameter.name == name);
    let inputs = Inputs::table().into_iter().map(|input| input.without_conditions_unless(has));
    Tables {
        inputs: inputs.collect(),
        computed: [computed.in_order().concat(), residuals_table().to_vec()].concat(),
        parameters,
    }
}

/// Inputs and states that the computed variables depend on.
mod depends {
    use super::{FORCE, IMPOSED_POSITION, IMPOSED_VELOCITY, State, feeds, references, states};
    use crate::variables::Variable;

    pub const X: u32 = State::Position.reference();
    pub const V: u32 = State::Velocity.reference();
    /// The state that is the velocity, or the input that imposes it.
    pub const MOVING: [u32; 2] = [V, IMPOSED_VELOCITY];
    pub const P_A: u32 = State::PressureA.reference();
    pub const P_B: u32 = State::PressureB.reference();
    pub const T_A: u32 = State::TemperatureA.reference();
    pub const T_B: u32 = State::TemperatureB.reference();

    /// Dependencies of the mass flow into a chamber; of the laminar leakage past the piston on both pressures, of a cushion
    /// on the position.
    pub fn flow(chamber: usize) -> Vec<u32> {
        let lines = feeds(chamber).to_vec();
        [vec![FEED[chamber]], vec![P_A, P_B, [T_A, T_B][chamber], X], lines].concat()
    }

    /// Placeholders for the dependences of the inflow of a chamber, which the actuators list.
    const FEED: [u32; 2] = [u32::MAX - 1, u32::MAX];

    /// A variable with the actuators' dependences in place of an inflow.
    pub fn on_feeds(variable: Variable, feeds: &[Vec<u32>; 2]) -> Variable {
        let real = |reference: &u32| match FEED.iter().position(|feed| feed == reference) {
            Some(chamber) => feeds[chamber].clone(),
            None => vec![*reference],
        };
        let known: Option<Vec<u32>> = variable.depends_on.as_ref().map(|known| known.iter().flat_map(real).collect());
        Variable { depends_on: known, ..variable }
    }

    /// Dependencies of the rates of a chamber; leakage past the piston has the upstream temperature.
    pub fn gas(chamber: usize) -> Vec<u32> {
        [flow(chamber), vec![[T_B, T_A][chamber]], MOVING.to_vec()].concat()
    }

    /// Dependencies of the decision whether a law without states of its own holds the mass.
    pub const LOAD: &[u32] = &[references::TIME, FORCE, IMPOSED_POSITION, IMPOSED_VELOCITY, X, V, P_A, P_B];

    /// Dependencies of the load factor.
    pub const LEVEL: [u32; 3] = [X, P_A, P_B];

    /// Dependencies of the limits of friction under an imposed motion.
    pub fn limits() -> Vec<u32> {
        let own = [references::TIME, IMPOSED_VELOCITY, X, P_A, P_B];
        [own.to_vec(), states::references(references::CONTACT)].concat()
    }

    /// Dependencies of friction and acceleration.
    pub fn motion() -> Vec<u32> {
        [LOAD.to_vec(), states::references(references::CONTACT)].concat()
    }
}

outputs! {
    /// The computed variables.
    Outputs {
        position = Variable::output(depends::X, "position", units::METRE).nominal(0.1).shown_in("mm")
            .depends_on(&[depends::X])
            .starts_from(&[IMPOSED_POSITION])
            .text("Position of the carriage: 0 retracted, stroke extended");
        velocity = Variable::output(depends::V, "velocity", units::METRE_PER_SECOND).nominal(0.1).shown_in("mm/s").derivative_of(depends::X)
            .depends_on(&depends::MOVING)
            .text("Velocity of the carriage; exactly 0 while it sticks");
        acceleration = Variable::output(103, "acceleration", units::METRE_PER_SECOND_SQUARED).nominal(1.0).derivative_of(depends::V)
            .depends_on(&depends::motion())
            .text("Acceleration of the carriage");
        rod_force = Variable::output(104, "rodForce", units::NEWTON).nominal(10.0)
            .depends_on(&depends::motion())
            .text("Force of the rod on the carriage, positive when pushing, as a load cell between them reads; with motion = Imposed the whole force of the cylinder on the body that imposes it");
        pressure_force = Variable::output(105, "pressureForce", units::NEWTON).nominal(10.0)
            .depends_on(&[depends::P_A, depends::P_B])
            .text("Force of the chambers and of the atmosphere on the rod");
        friction_force = Variable::output(106, "frictionForce", units::NEWTON).nominal(10.0)
            .depends_on(&depends::motion())
            .text("Friction force on the moving mass, positive when it opposes motion towards +x");
        friction_low = friction_limit(115, "low", "Least");
        friction_high = friction_limit(116, "high", "Largest");
        pressure_a = Variable::output(depends::P_A, "chamberA.pressure", units::PASCAL).nominal(1e5).shown_in("bar")
            .depends_on(&[depends::P_A])
            .text("Absolute pressure in chamber A");
        pressure_b = Variable::output(depends::P_B, "chamberB.pressure", units::PASCAL).nominal(1e5).shown_in("bar")
            .depends_on(&[depends::P_B])
            .text("Absolute pressure in chamber B");
        temperature_a = Variable::output(depends::T_A, "chamberA.temperature", units::KELVIN).nominal(300.0).shown_in("degC")
            .depends_on(&[depends::P_A, depends::T_A])
            .text("Gas temperature in chamber A");
        temperature_b = Variable::output(depends::T_B, "chamberB.temperature", units::KELVIN).nominal(300.0).shown_in("degC")
            .depends_on(&[depends::P_B, depends::T_B])
            .text("Gas temperature in chamber B");
        mass_flow_a = Variable::output(111, "chamberA.massFlow", units::KILOGRAM_PER_SECOND).nominal(1e-3).shown_in("l/min(ANR)")
            .depends_on(&[depends::flow(0), depends::MOVING.to_vec()].concat())
            .text("Net mass flow into chamber A, leakage included; of an open chamber its exchange with the surroundings");
        mass_flow_b = Variable::output(112, "chamberB.massFlow", units::KILOGRAM_PER_SECOND).nominal(1e-3).shown_in("l/min(ANR)")
            .depends_on(&[depends::flow(1), depends::MOVING.to_vec()].concat())
            .text("Net mass flow into chamber B, leakage included; of an open chamber its exchange with the surroundings");
        sticking = Variable::flag(114, "sticking")
            .depends_on(depends::LOAD)
            .text("True while a set-valued law, Karnopp's band or the stick mode of a stick-slip law holds the carriage");
        end_first = EndSwitches::outputs(depends::X)[0].clone();
        end_last = EndSwitches::outputs(depends::X)[1].clone();
        pressure_rate_a = Variable::output(207, "der(chamberA.pressure)", units::PASCAL_PER_SECOND).local().nominal(1e6).derivative_of(depends::P_A)
            .depends_on(&depends::gas(0))
            .text("Rate of the pressure in chamber A");
        temperature_rate_a = Variable::output(209, "der(chamberA.temperature)", units::KELVIN_PER_SECOND).local().nominal(100.0).derivative_of(depends::T_A)
            .depends_on(&depends::gas(0))
            .text("Rate of the temperature in chamber A");
        pressure_rate_b = Variable::output(208, "der(chamberB.pressure)", units::PASCAL_PER_SECOND).local().nominal(1e6).derivative_of(depends::P_B)
            .depends_on(&depends::gas(1))
            .text("Rate of the pressure in chamber B");
        temperature_rate_b = Variable::output(210, "der(chamberB.temperature)", units::KELVIN_PER_SECOND).local().nominal(100.0).derivative_of(depends::T_B)
            .depends_on(&depends::gas(1))
            .text("Rate of the temperature in chamber B");
        stop_force = Variable::output(211, "cylinder.stopForce", units::NEWTON).local().nominal(100.0)
            .depends_on(&[depends::X, depends::V, IMPOSED_VELOCITY])
            .text("Force of the end stops on the carriage towards +x");
        load_level = Variable::output(212, "friction.level", units::ONE).local().nominal(1.0)
            .depends_on(&[FORCE, IMPOSED_POSITION, IMPOSED_VELOCITY, depends::X, depends::P_A, depends::P_B])
            .text("Load factor lambda of friction, which multiplies the forces of the friction law");
    }
}

/// A deflection that yields at once to an imposed motion of the other direction.
fn yielding(state: Variable) -> Variable {
    if state.reference != states::deflection(references::CONTACT) {
        return state;
    }
    let known = [state.depends_on.as_deref().unwrap_or_default(), &[IMPOSED_VELOCITY]].concat();
    state.depends_on(&known)
}

fn friction_limit(reference: u32, side: &str, which: &str) -> Variable {
    let limit = Variable::output(reference, &format!("frictionForceLimit.{side}"), units::NEWTON).nominal(10.0);
    limit.counts_where(Condition::is("motion", &[Motion::Imposed])).depends_on(&depends::limits()).text(&format!(
        "{which} friction force that the contact can exert under an imposed motion: a bound at rest under a set-valued law, otherwise equal to frictionForce"
    ))
}

/// Residuals of the balances, in the order of the conserved quantities.
fn residuals_table() -> [Variable; RESIDUALS] {
    [
        Variable::output(213, "balance.massResidual", units::KILOGRAM).local().counts_with("balance.enabled").nominal(1e-3).shown_in("g")
            .depends_on(&[]).text("Mass balance of the gas in chambers, hoses and vessel: present mass minus initial mass minus net inflow. It is the integration error; with thermal.model = PolytropicServo also the mass that this model does not conserve"),
        Variable::output(214, "balance.energyResidual", units::JOULE).local().counts_with("balance.enabled").nominal(1.0)
            .depends_on(&[]).text("Energy balance of gas and carriage: present energy minus initial energy minus net inflow of enthalpy, heat and work; of the carriage alone unless thermal.model = EnergyBalance"),
    ]
}
