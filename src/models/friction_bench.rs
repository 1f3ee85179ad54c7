//! One mass with one friction law, so that the law can be studied alone.
//!
//! ```text
//! SpringPull:        F_app = k_s*(y - x) + c_s*(dy/dt - v) + appliedForce,   dy/dt = driveVelocity
//! Free:              F_app = appliedForce
//!                    m*dv/dt = F_app - F_f,   dx/dt = v
//! PrescribedMotion:  v = driveVelocity,   dx/dt = v;   F_f is read
//! PrescribedPosition:  v = (x_e - x_b)/(t_e - t_b),   dx/dt = v;   F_f is read
//! ```
//!
//! Under a prescribed position the mass goes on a straight line from `x_b`, where it was to be at the begin `t_b` of a
//! communication step, to `x_e = prescribedPosition` at its end `t_e`: given a measured position sample by sample, it
//! passes through all samples, and its velocity is exactly 0 where they do not change. Equations that a host integrates
//! know no such steps; there the mass moves with `driveVelocity`.

use serde::{Deserialize, Serialize};

use crate::co_simulation::AnyRun;
use crate::co_simulation::start_sized;
use crate::friction::{
    self, Contact, ContactLaw, Friction, FrictionContact, FrictionLaw, Indicators, Law, MAX_STATES, Trend, states,
};
use crate::model::{Experiment, Functions, Model, Panel, Start};
use crate::numbers::{Real, Scalar, Varying};
use crate::system::{Holder, Holds, Part, PartFacts, StateLabel, System, Tables, references};
use crate::variables::{Condition, Fixed, ParameterError, ParameterSet, Values, Variable, units};
use crate::{enumeration, holds, inputs, outputs, parameters, states};

/// The model as the library offers it.
pub const MODEL: Model = model::<Friction>();

/// The model with the laws of a catalogue.
pub const fn model<L: FrictionLaw>() -> Model {
    Model {
        name: "FrictionBench",
        description: "One mass with one friction law, pulled by a spring, moved as prescribed, or pushed by a force",
        functions: Functions::of::<FrictionBench<L>, INPUTS>(State::OTHERS + MAX_STATES, start::<L, _>, start::<L, _>),
        experiment: Experiment {
            stop_time: 120.0,
            step_size: 1e-2,
            signals: &[],
            panels: &[
                Panel { label: "position", curves: &["drivePosition", "position"] },
                Panel { label: "velocity", curves: &["velocity"] },
                Panel { label: "friction force", curves: &["frictionForce"] },
            ],
        },
    }
}

/// Starts a run with as many states as the friction law needs.
fn start<L: FrictionLaw, P: AnyRun>(start: &Start) -> Result<P, ParameterError> {
    start_sized!(
        start,
        FrictionBench<L>,
        INPUTS,
        [State::OTHERS, State::OTHERS + 1, State::OTHERS + 2, State::OTHERS + 4, State::OTHERS + MAX_STATES]
    )
}

/// A deflection that yields at once where the load factor falls below its force in the direction of motion.
fn yielding(deflection: Variable) -> Variable {
    let known = [deflection.depends_on.as_deref().unwrap_or_default(), &[depends::DRIVE, depends::LEVEL]].concat();
    deflection.depends_on(&known)
}

/// The parameters of the bench and of its contact.
type Parts<L> = (Parameters, ContactLaw<L, { Law::Stribeck as i32 }>);

/// Number of inputs.
const INPUTS: usize = Inputs::LEN;

inputs! {
    #[doc(hidden)]
    /// The inputs.
    Inputs {
        drive_velocity = Variable::input(1, "driveVelocity", units::METRE_PER_SECOND, 0.1).nominal(0.1).shown_in("mm/s")
            .text("Velocity of the free end of the spring, or of the mass itself if its motion is prescribed");
        applied_force = Variable::input(2, "appliedForce", units::NEWTON, 0.0).nominal(10.0)
            .text("Force on the mass towards +x; in a prescribed motion, what a law with true stiction answers at rest");
        prescribed_position = Variable::input(3, "prescribedPosition", units::METRE, 0.0).counts_where(Condition::is("bench.drive", &[Drive::PrescribedPosition])).nominal(0.1).shown_in("mm")
            .text("Position of the mass at the end of the communication step");
        level = Variable::input(4, "friction.level", units::ONE, 1.0).range(0.0, 1e3)
            .text("Load factor of the contact, the factor on its friction forces: measured load over rated load");
    }
}

states! {
    #[doc(hidden)]
    /// The states; positions resolve presliding.
    State of Parameters, from 0; {
        ..friction;
        DrivePosition: 104, |_| 1e-3;
        Position: 101, |_| 1e-3;
        Velocity: 102, |_| 1e-2;
    }
}

/// Inputs and states that the computed variables depend on; with which drive, is a matter of parameters.
mod depends {
    use super::{State, references, states};

    pub const DRIVE: u32 = 1;
    pub const FORCE: u32 = 2;
    pub const LEVEL: u32 = 4;
    pub const X: u32 = State::Position.reference();
    pub const V: u32 = State::Velocity.reference();
    pub const Y: u32 = State::DrivePosition.reference();

    /// Dependencies of the decision whether a law without states of its own holds the mass.
    pub const LOAD: &[u32] = &[references::TIME, DRIVE, FORCE, LEVEL, X, V, Y];

    /// Dependencies of friction and acceleration.
    pub fn motion() -> Vec<u32> {
        [LOAD.to_vec(), states::references(references::CONTACT)].concat()
    }
}

outputs! {
    #[doc(hidden)]
    /// The computed variables.
    Outputs {
        position = Variable::output(depends::X, "position", units::METRE).nominal(0.1).shown_in("mm")
            .depends_on(&[depends::X])
            .text("Position of the mass");
        velocity = Variable::output(depends::V, "velocity", units::METRE_PER_SECOND).nominal(0.1).shown_in("mm/s").derivative_of(depends::X)
            .depends_on(&[depends::V, depends::DRIVE])
            .text("Velocity of the mass; exactly 0 while it sticks");
        acceleration = Variable::output(103, "acceleration", units::METRE_PER_SECOND_SQUARED).nominal(1.0).derivative_of(depends::V)
            .depends_on(&depends::motion())
            .text("Acceleration of the mass; 0 in a prescribed motion, whose velocity is given");
        drive_position = Variable::output(depends::Y, "drivePosition", units::METRE).nominal(0.1).shown_in("mm")
            .depends_on(&[depends::Y])
            .text("Position of the free end of the spring: the integral of driveVelocity");
        spring_force = Variable::output(105, "springForce", units::NEWTON).counts_where(Condition::is("bench.drive", &[Drive::SpringPull])).nominal(10.0)
            .depends_on(&[depends::Y, depends::X, depends::V, depends::DRIVE])
            .text("Force of spring and damper on the mass towards +x");
        friction_force = Variable::output(106, "frictionForce", units::NEWTON).nominal(10.0)
            .depends_on(&depends::motion())
            .text("Friction force on the mass, positive when it opposes motion towards +x");
        sticking = Variable::flag(107, "sticking")
            .depends_on(depends::LOAD)
            .text("True while a set-valued law, Karnopp's band or the stick mode of a stick-slip law holds the mass");
        drive_rate = Variable::output(204, "der(drivePosition)", units::METRE_PER_SECOND).local().nominal(0.1).shown_in("mm/s").derivative_of(depends::Y)
            .depends_on(&[depends::DRIVE])
            .text("Velocity of the free end of the spring");
    }
}

enumeration! {
    #[doc(hidden)]
    /// Drive of the mass; ids are never reused.
    Drive "BenchDrive": "What moves the mass" {
        1 SpringPull: "A spring and damper, whose free end moves with driveVelocity, and appliedForce";
        2 PrescribedMotion: "The mass moves with driveVelocity; its friction force is read";
        3 Free: "appliedForce alone";
        4 PrescribedPosition: "The mass is at prescribedPosition at the end of each communication step; its friction force is read";
    }
}

impl Drive {
    /// Whether the motion of the mass is given, so that friction is only read.
    fn prescribes(self) -> bool {
        matches!(self, Self::PrescribedMotion | Self::PrescribedPosition)
    }
}

parameters! {
    #[doc(hidden)]
    /// The parameters of the bench; the friction law's and the solver's follow in the table.
    Parameters {
        drive: Drive = Variable::choice(1001, "bench.drive", Drive::SpringPull)
            .text("What moves the mass");
        mass: Fixed = Variable::parameter(1002, "mass", units::KILOGRAM, 1.0).range(1e-3, 1e4)
            .text("Mass");
        stiffness: Fixed = Variable::parameter(1003, "spring.stiffness", units::NEWTON_PER_METRE, 2.0).counts_where(Condition::is("bench.drive", &[Drive::SpringPull])).range(0.0, 1e9)
            .text("Stiffness of the spring");
        damping: Fixed = Variable::parameter(1004, "spring.damping", units::NEWTON_SECOND_PER_METRE, 0.0).counts_where(Condition::is("bench.drive", &[Drive::SpringPull])).range(0.0, 1e6)
            .text("Damping coefficient parallel to the spring");
        position0: Fixed = Variable::parameter(1005, "position0", units::METRE, 0.0).range(-1e3, 1e3).shown_in("mm")
            .text("Initial position of the mass and of the free end of the spring");
        velocity0: Fixed = Variable::parameter(1006, "velocity0", units::METRE_PER_SECOND, 0.0).counts_where(Condition::is("bench.drive", &[Drive::SpringPull, Drive::Free])).range(-100.0, 100.0).shown_in("mm/s")
            .text("Initial velocity of the mass");
    }
}

/// The equations of the bench for given parameters.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct FrictionBench<L = Friction> {
    p: Parameters,
    friction: FrictionContact<L>,
}

/// Memory of the friction law and of a prescribed motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[doc(hidden)]
pub struct Memory<F = friction::Memory, S = Real> {
    friction: F,
    trend: Trend<S>,
    path: DrivenPath<S>,
}

/// Where a prescribed position leads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct DrivenPath<S> {
    /// Position in m at the end of the present step.
    end: S,
    /// Velocity in m/s of this step; before the first step, the input's velocity.
    velocity: Option<S>,
}

impl<L: FrictionLaw> FrictionBench<L> {
    /// Velocity of the mass: as prescribed, or the state, unless the friction law holds the position.
    fn rate<S: Scalar, const N: usize>(
        &self,
        x: &[S; N],
        u: &Inputs<S>,
        memory: &Memory<L::Memory<S::Held>, S::Held>,
    ) -> S {
        match self.p.drive {
            Drive::PrescribedMotion => u.drive_velocity,
            Drive::PrescribedPosition => memory.path.velocity.map_or(u.drive_velocity, S::held),
            Drive::SpringPull | Drive::Free => self.friction.rate(State::Velocity.get(x), &memory.friction),
        }
    }

    /// Force of spring and damper in N at a velocity of the mass.
    fn spring_force<S: Scalar, const N: usize>(&self, x: &[S; N], u: &Inputs<S>, rate: S) -> S {
        match self.p.drive {
            Drive::SpringPull => {
                (State::DrivePosition.get(x) - State::Position.get(x)) * self.p.stiffness
                    + (u.drive_velocity - rate) * self.p.damping
            }
            Drive::PrescribedMotion | Drive::PrescribedPosition | Drive::Free => S::zero(),
        }
    }

    /// Force on the mass other than friction in N, as the friction law sees it.
    fn applied_force<S: Scalar, const N: usize>(&self, x: &[S; N], u: &Inputs<S>, rate: S, trend: f64) -> S {
        let applied = self.spring_force(x, u, rate) + u.applied_force;
        let law = self.friction.law();
        if self.p.drive.prescribes() { Trend::<S>::applied(trend, law, rate, applied) } else { applied }
    }

    /// The contact as the friction law sees it, for a velocity of the mass.
    fn contact<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &Inputs<S>,
        rate: S,
        trend: f64,
    ) -> Contact<S> {
        let drive = self.friction.drive();
        let velocity = match drive {
            friction::Drive::Motion => rate,
            friction::Drive::Force => State::Velocity.get(x),
        };
        let applied = self.applied_force(x, u, rate, trend);
        Contact { time, position: State::Position.get(x), velocity, applied, level: u.level, drive }
    }

    /// The contact in the present modes.
    fn contact_at<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &Inputs<S>,
        memory: &Memory<L::Memory<S::Held>, S::Held>,
    ) -> Contact<S> {
        self.contact(time, x, u, self.rate(x, u, memory), memory.trend.sign)
    }

    /// Acceleration in m/s2 under a friction force.
    fn acceleration<S: Scalar>(&self, applied: S, friction_force: S) -> S {
        match self.p.drive {
            Drive::PrescribedMotion | Drive::PrescribedPosition => S::zero(),
            Drive::SpringPull | Drive::Free => (applied - friction_force) / self.p.mass,
        }
    }
}

holds! {
    [L: FrictionLaw] FrictionBench<L>, INPUTS; |bench, time, x, u, memory|
    friction: FrictionContact<L>, "friction", memory.friction, bench.contact_at(time, x, &Inputs::read(u), memory);
}

impl<L: FrictionLaw> System<INPUTS> for FrictionBench<L> {
    type Parameters = Parameters;
    type State = State;
    type Memory<S: Varying> = Memory<L::Memory<S>, S>;
    type Indicators<S: Varying> = Indicators<S>;

    fn tables() -> Tables {
        let states =
            states::table::<L>("friction", references::CONTACT, [&[depends::DRIVE, depends::V], &[depends::LEVEL]]);
        let states = states.into_iter().map(|state| {
            if state.reference == states::deflection(references::CONTACT) { yielding(state) } else { state }
        });
        let outputs = states::completed::<L>(Outputs::<f64>::table(), references::CONTACT);
        Tables {
            inputs: Inputs::table(),
            computed: outputs.into_iter().chain(states).collect(),
            parameters: Parts::<L>::table(),
        }
    }

    fn new(values: &mut Values) -> Result<Self, ParameterError> {
        let (p, ContactLaw(law)): Parts<L> = values.read()?;
        let drive = if p.drive.prescribes() { friction::Drive::Motion } else { friction::Drive::Force };
        let friction = FrictionContact::new(law, drive, State::FRICTION, State::Velocity.index(), references::CONTACT);
        Ok(Self { p, friction })
    }

    fn parameters(&self) -> &Parameters {
        &self.p
    }

    fn parts() -> impl Holds<Self, INPUTS> {
        Holder
    }

    fn start<S: Varying, const N: usize>(&self, u: &[S; INPUTS]) -> ([S; N], Self::Memory<S>) {
        let inputs = Inputs::read(u);
        let (mut x, start) = ([S::zero(); N], S::along(self.p.position0));
        State::DrivePosition.set(&mut x, start);
        State::Position.set(&mut x, start);
        State::Velocity.set(&mut x, S::along(self.p.velocity0));
        let trend = Trend::new(inputs.drive_velocity);
        let rate = if self.p.drive.prescribes() { inputs.drive_velocity } else { State::Velocity.get(&x) };
        let contact = self.contact(S::zero(), &x, &inputs, rate, trend.sign);
        let friction = self.friction.start(&contact, &mut x);
        (x, Memory { friction, trend, path: DrivenPath { end: start, velocity: None } })
    }

    fn derivatives<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; INPUTS],
        memory: &Memory<L::Memory<S::Held>, S::Held>,
    ) -> [S; N] {
        let u = &Inputs::read(u);
        let mut rates = [S::zero(); N];
        let contact = self.contact_at(time, x, u, memory);
        let force = self.friction.force(&contact, x, &memory.friction, &mut rates);
        State::DrivePosition.set(&mut rates, u.drive_velocity);
        State::Position.set(&mut rates, self.rate(x, u, memory));
        State::Velocity.set(&mut rates, self.acceleration(contact.applied, force));
        rates
    }

    fn begin<S: Varying, const N: usize>(
        &self,
        [_, duration]: [f64; 2],
        _x: &[S; N],
        u: &[S; INPUTS],
        _slopes: &[f64; INPUTS],
        memory: &mut Memory<L::Memory<S>, S>,
    ) -> bool {
        if self.p.drive != Drive::PrescribedPosition {
            return false;
        }
        let end = Inputs::read(u).prescribed_position;
        memory.path = DrivenPath { end, velocity: Some((end - memory.path.end) / duration) };
        true
    }

    fn follow<S: Varying, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        inputs: &[S; INPUTS],
        memory: &mut Memory<L::Memory<S>, S>,
    ) -> bool {
        let u = &Inputs::read(inputs);
        let followed = if self.p.drive.prescribes() { self.rate(x, u, memory) } else { u.drive_velocity };
        memory.trend.follow(followed);
        Holder.follow(self, (time, x, inputs), memory);
        true
    }

    /// The trend is a sign.
    fn state_label(&self, fields: &str) -> StateLabel {
        if fields == "trend.velocity" { StateLabel::Nothing } else { StateLabel::Fields }
    }

    fn fits<S: Varying>(&self, memory: &Memory<L::Memory<S>, S>) -> bool {
        let DrivenPath { end, velocity } = memory.path;
        let is_plain = [end.value(), velocity.map_or(0.0, S::value)].iter().all(|value| value.is_finite());
        is_plain && memory.trend.is_sound() && self.friction.fits::<S>(&memory.friction)
    }

    fn outputs<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; INPUTS],
        memory: &Memory<L::Memory<S::Held>, S::Held>,
        computed: &mut [S],
    ) {
        let u = &Inputs::read(u);
        let contact = self.contact_at(time, x, u, memory);
        let friction = self.friction.observe(&contact, x, &memory.friction);
        let rate = self.rate(x, u, memory);
        let outputs = Outputs {
            position: State::Position.get(x),
            velocity: rate,
            acceleration: friction.unless_held(self.acceleration(contact.applied, friction.force)),
            drive_position: State::DrivePosition.get(x),
            spring_force: self.spring_force(x, u, rate),
            friction_force: friction.force,
            sticking: friction.sticking,
            drive_rate: u.drive_velocity,
        };
        friction.write(outputs.write(computed));
    }

    fn state_at(&self, reference: u32, n: usize) -> Option<usize> {
        let own = match State::of(reference) {
            // A prescribed motion is given its velocity.
            Some(State::Velocity) if self.p.drive.prescribes() => None,
            other => other,
        };
        own.map(|state| state.at(n)).or_else(|| self.friction.state_at(reference, n))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::checks;

    /// Messages call an event of a contact as a host calls its indicator, without the group.
    #[test]
    fn events_are_named_as_their_indicators() {
        checks::events_are_named::<FrictionBench, { INPUTS }>(|_, last| last);
    }
    #[test]
    fn laws_cost_what_they_ask_for() {
        checks::laws_cost_what_they_ask_for::<FrictionBench, { INPUTS }>([false; 2]);
    }
}
