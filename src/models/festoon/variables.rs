//! The variable table of the festoon.

use std::f64::consts::PI;

use super::MAX_TROLLEYS;
use crate::friction::{ContactLaw, FrictionLaw, Law, states};
use crate::system::{Tables, references};
use crate::variables::{Fixed, ParameterError, ParameterSet, Tunable, Variable, counted_by, units};
use crate::{inputs, outputs, parameters, states};

const CRANE_VELOCITY: u32 = 1;
const PULSE: u32 = 2;
/// The position of the crane trolley, which is a state.
pub const CRANE_POSITION: u32 = 11;

/// Value reference that the variables of a trolley count from.
pub const fn trolley_base(trolley: usize) -> u32 {
    100 * (trolley as u32 + 1)
}

/// Value reference that the states of the contact of a trolley count from.
pub const fn contact_base(trolley: usize) -> u32 {
    references::CONTACT + states::REFERENCES * trolley as u32
}

states! {
    /// The states of a trolley, with value references relative to the trolley's; positions resolve presliding.
    State of Parameters, from 0; {
        ..friction;
        Position: 1, |_| 1e-2;
        Velocity: 2, |_| 1e-2;
        Angle: 4, |_| 1e-2;
        Spin: 5, |_| 1e-1;
    }
}

/// The parameters of the festoon and of the contacts of all its trolleys.
pub type Parts<L> = (Parameters, ContactLaw<L, { Law::Stribeck as i32 }>);

/// Every variable of the festoon.
pub fn tables<L: FrictionLaw>() -> Tables {
    let mut computed = Outputs::<f64>::table();
    for trolley in 0..MAX_TROLLEYS {
        let own = TrolleyOutputs::<f64>::table().into_iter().map(|variable| of_trolley(variable, trolley)).collect();
        computed.extend(states::completed::<L>(own, contact_base(trolley)));
        let group = format!("trolley[{}].friction", trolley + 1);
        computed.extend(states::table::<L>(
            &group,
            contact_base(trolley),
            [&[trolley_base(trolley) + own::VELOCITY], &[]],
        ));
    }
    Tables { inputs: Inputs::table(), computed, parameters: Parts::<L>::table() }
}

/// A variable of one trolley, with its dependencies on the states of this trolley and its neighbours.
fn of_trolley(variable: Variable, trolley: usize) -> Variable {
    let base = trolley_base(trolley);
    let depends_on = match variable.reference {
        own::POSITION | own::VELOCITY | own::ANGLE | own::SPIN => vec![base + variable.reference],
        own::TOW | own::BUFFER => link(trolley),
        own::STICKING => load(trolley),
        _ => motion(trolley),
    };
    let derivative_of = variable.derivative_of.map(|state| base + state);
    let place = format!("trolley[{}]", trolley + 1);
    Variable { derivative_of, ..variable }.within(&place, base).depends_on(&depends_on)
}

/// Dependencies of the forces of the link before a trolley.
fn link(trolley: usize) -> Vec<u32> {
    let behind = trolley_base(trolley);
    let before = match trolley {
        0 => [CRANE_VELOCITY, CRANE_POSITION],
        _ => [own::POSITION, own::VELOCITY].map(|state| trolley_base(trolley - 1) + state),
    };
    [before, [behind + own::POSITION, behind + own::VELOCITY]].concat()
}

/// Dependencies of friction and accelerations of a trolley.
fn motion(trolley: usize) -> Vec<u32> {
    [load(trolley), states::references(contact_base(trolley))].concat()
}

/// Dependencies of the decision whether a law without states of its own holds a trolley.
fn load(trolley: usize) -> Vec<u32> {
    let mut all = link(trolley);
    if trolley + 1 < MAX_TROLLEYS {
        all.extend(link(trolley + 1));
    }
    if trolley == 0 {
        all.push(PULSE);
    }
    all.extend([own::ANGLE, own::SPIN].map(|state| trolley_base(trolley) + state));
    all.push(references::TIME);
    all.sort_unstable();
    all.dedup();
    all
}

inputs! {
    /// The inputs.
    Inputs {
        crane_velocity = Variable::input(CRANE_VELOCITY, "craneVelocity", units::METRE_PER_SECOND, 0.0).nominal(0.1).shown_in("mm/s")
            .text("Velocity of the crane trolley, which tows the others");
        pulse_force = Variable::input(PULSE, "pulseForce", units::NEWTON, 0.0).nominal(10.0)
            .text("Force on the first trolley towards +x");
    }
}

outputs! {
    /// The computed variables of the crane trolley.
    Outputs {
        crane_position = Variable::output(CRANE_POSITION, "crane.position", units::METRE).nominal(1.0)
            .depends_on(&[CRANE_POSITION])
            .text("Position of the crane trolley");
        crane_rate = Variable::output(13, "der(crane.position)", units::METRE_PER_SECOND).local().nominal(0.1).shown_in("mm/s").derivative_of(CRANE_POSITION)
            .depends_on(&[CRANE_VELOCITY])
            .text("Velocity of the crane trolley");
        crane_force = Variable::output(12, "crane.force", units::NEWTON).nominal(10.0)
            .depends_on(&link(0))
            .text("Force of the crane trolley on the first trolley towards +x");
    }
}

/// Variables of a trolley, counted from its base.
mod own {
    use super::State;

    pub const POSITION: u32 = State::Position.reference();
    pub const VELOCITY: u32 = State::Velocity.reference();
    pub const ACCELERATION: u32 = 3;
    pub const ANGLE: u32 = State::Angle.reference();
    pub const SPIN: u32 = State::Spin.reference();
    pub const ANGULAR_ACCELERATION: u32 = 6;
    pub const TOW: u32 = 7;
    pub const BUFFER: u32 = 8;
    pub const FRICTION: u32 = 9;
    pub const STICKING: u32 = 10;
}

outputs! {
    /// The computed variables of a trolley.
    TrolleyOutputs {
        position = Variable::output(own::POSITION, "position", units::METRE).nominal(1.0)
            .text("Position of the trolley");
        velocity = Variable::output(own::VELOCITY, "velocity", units::METRE_PER_SECOND).nominal(0.1).shown_in("mm/s").derivative_of(own::POSITION)
            .text("Velocity of the trolley; exactly 0 while it sticks");
        acceleration = Variable::output(own::ACCELERATION, "acceleration", units::METRE_PER_SECOND_SQUARED).nominal(1.0).derivative_of(own::VELOCITY)
            .text("Acceleration of the trolley");
        angle = Variable::output(own::ANGLE, "load.angle", units::RADIAN).nominal(0.1).shown_in("deg")
            .text("Angle of the hanging load from the vertical, positive towards +x");
        spin = Variable::output(own::SPIN, "load.angularVelocity", units::RADIAN_PER_SECOND).nominal(0.1).shown_in("deg/s").derivative_of(own::ANGLE)
            .text("Angular velocity of the load");
        angular_acceleration = Variable::output(own::ANGULAR_ACCELERATION, "load.angularAcceleration", units::RADIAN_PER_SECOND_SQUARED).local().nominal(1.0).derivative_of(own::SPIN)
            .text("Angular acceleration of the load");
        tow_force = Variable::output(own::TOW, "towForce", units::NEWTON).nominal(10.0)
            .text("Force of the tow rope before the trolley, never negative");
        buffer_force = Variable::output(own::BUFFER, "bufferForce", units::NEWTON).nominal(10.0)
            .text("Force of the buffer before the trolley, never negative");
        friction_force = Variable::output(own::FRICTION, "frictionForce", units::NEWTON).nominal(10.0)
            .text("Friction force on the trolley, positive when it opposes motion towards +x");
        sticking = Variable::flag(own::STICKING, "sticking")
            .text("True while a set-valued law, Karnopp's band or the stick mode of a stick-slip law holds the trolley");
    }
}

parameters! {
    /// The parameters of the festoon; friction law and solver follow in the table.
    Parameters {
        trolleys: usize = Variable::count(1001, "trolleys", 3).range(1.0, MAX_TROLLEYS as f64)
            .text("Number of trolleys behind the crane trolley");
        mass: Fixed = Variable::parameter(1002, "trolley.mass", units::KILOGRAM, 5.0).range(1e-3, 1e5)
            .text("Mass of a trolley without its load");
        load_mass: Fixed = Variable::parameter(1003, "load.mass", units::KILOGRAM, 10.0).range(1e-6, 1e5)
            .text("Mass that hangs on each trolley");
        load_length: Fixed = Variable::parameter(1004, "load.length", units::METRE, 1.0).range(1e-3, 1e3)
            .text("Distance of the hanging mass below its trolley");
        load_damping: Tunable = Variable::parameter(1005, "load.damping", units::NEWTON_METRE_SECOND, 2.0).range(0.0, 1e6)
            .text("Damping coefficient of the joint between trolley and load");
        rope_length: Fixed = Variable::parameter(1006, "rope.length", units::METRE, 1.0).range(1e-3, 1e3)
            .text("Distance of neighbours at which the tow rope between them tautens");
        rope_stiffness: Fixed = Variable::parameter(1007, "rope.stiffness", units::NEWTON_PER_METRE, 2e3).range(0.0, 1e9)
            .text("Stiffness of a tow rope");
        rope_damping: Fixed = Variable::parameter(1008, "rope.damping", units::SECOND_PER_METRE, 1.0).counts_with("rope.stiffness").range(0.0, 1e3)
            .text("Dissipation coefficient of a tow rope (Hunt-Crossley)");
        buffer_length: Fixed = Variable::parameter(1009, "buffer.length", units::METRE, 0.2).range(0.0, 1e3)
            .text("Distance of neighbours at which their buffers meet; shorter than the rope");
        buffer_stiffness: Fixed = Variable::parameter(1010, "buffer.stiffness", units::NEWTON_PER_METRE, 2e4).range(0.0, 1e9)
            .text("Stiffness of a pair of buffers; 0: none");
        buffer_damping: Fixed = Variable::parameter(1011, "buffer.damping", units::SECOND_PER_METRE, 1.0).counts_with("buffer.stiffness").range(0.0, 1e3)
            .text("Dissipation coefficient of the buffers (Hunt-Crossley)");
        crane_position0: Fixed = Variable::parameter(1012, "crane.position0", units::METRE, 0.0).range(-1e4, 1e4)
            .text("Initial position of the crane trolley");
        spacing0: Fixed = Variable::parameter(1013, "spacing0", units::METRE, 0.5).range(0.0, 1e3)
            .text("Initial distance of neighbours");
        angle0: Fixed = Variable::parameter(1014, "load.angle0", units::RADIAN, 0.0).range(-PI, PI).shown_in("deg")
            .text("Initial angle of the loads");
        level: [Tunable; MAX_TROLLEYS] = counted_by("trolleys", Variable::parameter(1021, "friction.level", units::ONE, 1.0).range(0.0, 1e3)
            .text("Load factor of a trolley, which multiplies the forces of its friction law").array([1.0; MAX_TROLLEYS]));
    }
}

impl Parameters {
    /// Refuses combinations without a meaning.
    pub fn check(&self) -> Result<(), ParameterError> {
        let [buffer, rope] = [self.buffer_length, self.rope_length].map(|it| it.value);
        if buffer >= rope {
            let reason = format!("it must be shorter than rope.length = {rope}");
            return Err(ParameterError::new("buffer.length", buffer, &reason));
        }
        Ok(())
    }
}
