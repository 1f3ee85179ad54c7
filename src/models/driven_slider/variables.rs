//! The variable table of the slider.

use crate::friction::parts::shared::{SharedForce, SharedForces};
use crate::friction::{FrictionLaw, Law, states};
use crate::mechanics::GRAVITY;
use crate::system::{Tables, references};
use crate::variables::{Choice, Fixed, ParameterError, ParameterSet, Tunable, Variable, units};
use crate::{inputs, outputs, parameters, states};

/// The slider of the source.
const MASS: f64 = 21.19e-3;
const DYNAMIC_COEFFICIENT: f64 = 0.32;

/// Every variable of the slider.
pub fn tables<L: FrictionLaw>() -> Tables {
    let states = states::table::<L>("friction", references::CONTACT, [&[depends::U], &[]]);
    let weight = DYNAMIC_COEFFICIENT * MASS * GRAVITY;
    let laws = SharedForces::table::<L>("friction", references::FRICTION, Law::CoulombStiction.id(), weight);
    Tables {
        inputs: Inputs::table(),
        computed: [states::completed::<L>(Outputs::<f64>::table(), references::CONTACT), states].concat(),
        parameters: [Parameters::table(), laws].concat(),
    }
}

inputs! {
    /// The input.
    Inputs {
        external_force = Variable::input(1, "externalForce", units::NEWTON, 0.0).nominal(0.1)
            .text("Force on the slider towards +x");
    }
}

states! {
    /// The states: position and velocity on the tray.
    State of Parameters, from 0; {
        ..friction;
        Position: 104, |_| 1e-3;
        Velocity: 105, |_| 1e-2;
    }
}

/// Inputs and states that the computed variables depend on.
mod depends {
    use super::State;
    use crate::friction::states;
    use crate::system::references;

    pub const TIME: u32 = references::TIME;
    pub const FORCE: u32 = 1;
    pub const R: u32 = State::Position.reference();
    pub const U: u32 = State::Velocity.reference();

    /// Dependencies of the decision whether a law without states of its own holds the mass.
    pub const LOAD: &[u32] = &[TIME, FORCE, R, U];

    /// Dependencies of friction and acceleration.
    pub fn motion() -> Vec<u32> {
        [LOAD.to_vec(), states::references(references::CONTACT)].concat()
    }
}

outputs! {
    /// The computed variables.
    Outputs {
        position = Variable::output(101, "position", units::METRE).nominal(1e-3).shown_in("mm")
            .depends_on(&[depends::TIME, depends::R])
            .text("Position of the slider");
        velocity = Variable::output(102, "velocity", units::METRE_PER_SECOND).nominal(0.01).shown_in("mm/s")
            .depends_on(&[depends::TIME, depends::U])
            .text("Velocity of the slider");
        acceleration = Variable::output(103, "acceleration", units::METRE_PER_SECOND_SQUARED).nominal(1.0)
            .depends_on(&depends::motion())
            .text("Acceleration of the slider");
        relative_position = Variable::output(depends::R, "relativePosition", units::METRE).nominal(1e-3).shown_in("mm")
            .depends_on(&[depends::R])
            .text("Position of the slider on the tray");
        relative_velocity = Variable::output(depends::U, "relativeVelocity", units::METRE_PER_SECOND).nominal(0.01).shown_in("mm/s").derivative_of(depends::R)
            .depends_on(&[depends::U])
            .text("Velocity of the slider on the tray; exactly 0 while it sticks");
        relative_acceleration = Variable::output(106, "relativeAcceleration", units::METRE_PER_SECOND_SQUARED).nominal(1.0).derivative_of(depends::U)
            .depends_on(&depends::motion())
            .text("Acceleration of the slider relative to the tray");
        tray_position = Variable::output(107, "tray.position", units::METRE).nominal(1e-3).shown_in("mm")
            .depends_on(&[depends::TIME])
            .text("Position of the tray");
        tray_velocity = Variable::output(108, "tray.velocity", units::METRE_PER_SECOND).nominal(0.01).shown_in("mm/s")
            .depends_on(&[depends::TIME])
            .text("Velocity of the tray: the attractor of a slider that sticks");
        tray_acceleration = Variable::output(109, "tray.acceleration", units::METRE_PER_SECOND_SQUARED).nominal(1.0)
            .depends_on(&[depends::TIME])
            .text("Acceleration of the tray");
        friction_force = Variable::output(110, "frictionForce", units::NEWTON).nominal(0.1)
            .depends_on(&depends::motion())
            .text("Friction force on the slider, positive when it opposes motion on the tray towards +x");
        sticking = Variable::flag(111, "sticking")
            .depends_on(depends::LOAD)
            .text("True while a set-valued law, Karnopp's band or the stick mode of a stick-slip law holds the slider on the tray");
        stick_free_velocity = Variable::output(112, "walk.stickFreeVelocity", units::METRE_PER_SECOND).nominal(0.01).shown_in("mm/s")
            .depends_on(&[depends::TIME])
            .text("Velocity of the tray convolved with the deceleration of the slider: the attractor of a slider that never sticks");
        walk_velocity = Variable::output(113, "walk.velocity", units::METRE_PER_SECOND).nominal(0.01).shown_in("mm/s")
            .depends_on(&[]).text("Velocity of the random walk between both attractors, held between its time steps; 0 without a walk");
        walk_probability = Variable::output(201, "walk.chi", units::ONE).local().nominal(0.1)
            .depends_on(&[]).text("Probability of the walk to move towards the stick-free attractor (towards the tray otherwise)");
    }
}

parameters! {
    /// The parameters of slider, tray and walk; the friction law's and the solver's follow in the table.
    Parameters {
        mass: Fixed = Variable::parameter(1001, "mass", units::KILOGRAM, MASS).range(1e-6, 1e4).shown_in("g")
            .text("Mass of the slider");
        dynamic_coefficient: Tunable = Variable::parameter(1002, "muDynamic", units::ONE, DYNAMIC_COEFFICIENT).range(1e-3, 100.0)
            .text("Dynamic friction coefficient: Coulomb friction of the law divided by the weight");
        static_coefficient: Tunable = Variable::parameter(1003, "muStatic", units::ONE, 0.4).range(1e-3, 100.0)
            .text("Static friction coefficient: break-away force of the law divided by the weight; not below muDynamic");
        tray_velocity: Fixed = Variable::parameter(1004, "tray.velocityAmplitude", units::METRE_PER_SECOND, 0.04).range(0.0, 100.0).shown_in("mm/s")
            .text("Amplitude v_d of the velocity of the tray, which is v_d*cos(2*pi*frequency*time)");
        tray_frequency: Fixed = Variable::parameter(1005, "tray.frequency", units::HERTZ, 20.0).range(1e-3, 1e4)
            .text("Frequency of the tray");
        position0: Fixed = Variable::parameter(1006, "relativePosition0", units::METRE, 0.0).range(-1e3, 1e3).shown_in("mm")
            .text("Initial position on the tray");
        velocity0: Fixed = Variable::parameter(1007, "relativeVelocity0", units::METRE_PER_SECOND, 0.0).range(-100.0, 100.0).shown_in("mm/s")
            .text("Initial velocity on the tray, for example of a kick");
        walk_steps: i32 = Variable::count(1008, "walk.stepsPerPeriod", 500).range(0.0, 1e6)
            .text("Time steps of the random walk per period of the tray; 0: no walk");
        seed: u64 = Variable::count(1009, "walk.seed", 1).counts_with("walk.stepsPerPeriod").range(0.0, f64::from(i32::MAX))
            .text("Seed of the random walk");
        flight_factor: Fixed = Variable::parameter(1010, "walk.flightFactor", units::ONE, 1.0).range(0.0, 100.0)
            .text("Flight time of the stick-free attractor in units of v_d/(muDynamic*g), in which the slider comes to rest from v_d");
    }
}

impl Parameters {
    /// The forces of the friction law: coefficients times the weight.
    pub fn friction_forces(&self) -> Result<SharedForces, ParameterError> {
        let [statics, dynamic] = [self.static_coefficient, self.dynamic_coefficient].map(|it| it.value);
        if statics < dynamic {
            return Err(ParameterError::new(
                "muStatic",
                statics,
                &format!("it must not be below muDynamic = {dynamic}"),
            ));
        }
        let force = |variable, value: Tunable| SharedForce { variable, value, force: value * self.mass * GRAVITY };
        Ok(SharedForces {
            statics: force("muStatic", self.static_coefficient),
            coulomb: force("muDynamic", self.dynamic_coefficient),
        })
    }
}
