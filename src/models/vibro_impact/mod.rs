//! A vibro-impact locomotion system: an internal mass shaken inside a body that rests on dry friction and is hit from
//! within once per cycle or so.
//!
//! ```text
//! d = x_1 - x_2,   F_i = A*sin(w*t) - k_1*d - k_2*d^3 - c*dd/dt - h*k_0*(d - G)   [N], h = 1 where d > G, else 0
//! m_1*dv_1/dt = F_i
//! m_2*dv_2/dt = F_app - F_f(v_2),   F_app = externalForce - F_i
//! ```
//!
//! The impact spring meets the mass at an event, which is located like break-away and stop.
//!
//! # Source
//! The effect of friction on the vibro-impact locomotion system: modeling and dynamic response, eqs. 4, 5 and 9. In its
//! dimensionless form, eq. 13, the force on the body is printed with a cosine; both masses feel the same sine.

mod variables;

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use self::variables::{Inputs, Outputs, Parameters, State};
use crate::co_simulation::AnyRun;
use crate::co_simulation::start_sized;
use crate::friction::{self, Contact, Drive, Event, Friction, FrictionContact, FrictionLaw, MAX_STATES};
use crate::holds;
use crate::model::{Experiment, Functions, Model, Panel, Start};
use crate::numbers::{Scalar, Tangent, Varying};
#[cfg(feature = "sensitivities")]
use crate::system::are_alike;
use crate::system::{Holder, Holds, Indicator, PartFacts, System, Tables, UNUSED, references};
use crate::variables::{ParameterError, Values};

/// The model as the library offers it.
pub const MODEL: Model = model::<Friction>();

/// The model with the laws of a catalogue.
pub const fn model<L: FrictionLaw>() -> Model {
    Model {
        name: "VibroImpact",
        description: "Vibro-impact locomotion: a body on dry friction, driven by an internal mass that hits it",
        functions: Functions::of::<VibroImpact<L>, 1>(State::OTHERS + MAX_STATES, start::<L, _>, start::<L, _>),
        experiment: Experiment {
            stop_time: 3.0,
            step_size: 1e-3,
            signals: &[],
            panels: &[
                Panel { label: "position", curves: &["position"] },
                Panel { label: "displacement", curves: &["displacement"] },
                Panel { label: "velocity", curves: &["velocity"] },
                Panel { label: "friction force", curves: &["frictionForce"] },
            ],
        },
    }
}

/// Everything between the two masses, in SI units or, in the dimensionless form, without units.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Coupling {
    internal_mass: Tangent,
    body_mass: Tangent,
    /// Stiffness of the spring for displacement and for its cube.
    stiffness: Tangent,
    cubic: Tangent,
    damping: Tangent,
    impact_stiffness: Tangent,
    gap: Tangent,
    amplitude: Tangent,
    /// Angular frequency.
    frequency: Tangent,
}

/// The equations for given parameters.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct VibroImpact<L = Friction> {
    p: Parameters,
    coupling: Coupling,
    friction: FrictionContact<L>,
}

/// Memory of the friction law and of the impacts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[doc(hidden)]
pub struct Memory<F = friction::Memory> {
    friction: F,
    /// Whether the mass touches the impact spring.
    touches: bool,
    /// Impacts so far.
    impacts: u32,
}

/// The indicator of the impact spring comes first, then the contact's.
const IMPACT: usize = 0;
const CONTACT: usize = 1;

/// Starts a run with as many states as the friction law needs.
fn start<L: FrictionLaw, P: AnyRun>(start: &Start) -> Result<P, ParameterError> {
    start_sized!(start, VibroImpact<L>, 1, [State::OTHERS, State::OTHERS + 1, State::OTHERS + MAX_STATES])
}

impl Coupling {
    fn new(p: &Parameters) -> Self {
        if p.is_dimensionless() {
            return Self {
                internal_mass: Tangent::still(1.0),
                body_mass: p.mass_ratio,
                stiffness: Tangent::still(1.0),
                cubic: p.beta,
                damping: 2.0 * p.zeta,
                impact_stiffness: p.sigma,
                gap: p.gamma,
                amplitude: p.chi,
                frequency: p.omega,
            };
        }
        Self {
            internal_mass: p.internal_mass,
            body_mass: p.body_mass,
            stiffness: p.stiffness,
            cubic: p.cubic_stiffness,
            damping: p.damping,
            impact_stiffness: p.impact_stiffness,
            gap: p.gap,
            amplitude: p.amplitude,
            frequency: TAU * p.frequency,
        }
    }

    fn excitation<S: Scalar>(&self, time: S) -> S {
        (time * self.frequency).sin() * self.amplitude
    }

    /// Force of spring and damper on the body at a displacement of the internal mass on it and its rate.
    fn spring_force<S: Scalar>(&self, d: S, rate: S) -> S {
        d * (d * d * self.cubic + self.stiffness) + rate * self.damping
    }

    /// Force of the impact spring on the body; it cannot pull.
    fn impact_force<S: Scalar>(&self, d: S, touches: bool) -> S {
        if touches { (d - self.gap) * self.impact_stiffness } else { S::zero() }
    }
}

impl<L: FrictionLaw> VibroImpact<L> {
    /// Displacement of the internal mass on the body and its rate, for a velocity of the body.
    fn displacement<S: Scalar, const N: usize>(&self, x: &[S; N], rate: S) -> (S, S) {
        (State::InternalPosition.get(x) - State::Position.get(x), State::InternalVelocity.get(x) - rate)
    }

    /// Force on the internal mass, and its reaction on the body.
    fn internal_force<S: Scalar, const N: usize>(&self, time: S, x: &[S; N], rate: S, touches: bool) -> S {
        let (d, d_rate) = self.displacement(x, rate);
        let coupling = &self.coupling;
        coupling.excitation(time) - coupling.spring_force(d, d_rate) - coupling.impact_force(d, touches)
    }

    /// The contact of the body as the friction law sees it, for a velocity of the body.
    fn contact<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &Inputs<S>,
        rate: S,
        touches: bool,
    ) -> Contact<S> {
        Contact {
            time,
            position: State::Position.get(x),
            velocity: State::Velocity.get(x),
            applied: u.external_force - self.internal_force(time, x, rate, touches),
            level: S::constant(1.0),
            drive: self.friction.drive(),
        }
    }

    /// Velocity of the body: the state, unless the friction law holds the position.
    fn rate<S: Scalar, const N: usize>(&self, x: &[S; N], memory: &Memory<L::Memory<S::Held>>) -> S {
        self.friction.rate(State::Velocity.get(x), &memory.friction)
    }
}

holds! {
    [L: FrictionLaw] VibroImpact<L>, 1; |system, time, x, u, memory|
    friction: FrictionContact<L>, "friction", memory.friction,
    system.contact(time, x, &Inputs::read(u), system.rate(x, memory), memory.touches);
}

impl<L: FrictionLaw> System<1> for VibroImpact<L> {
    type Parameters = Parameters;
    type State = State;
    type Memory<S: Varying> = Memory<L::Memory<S>>;
    type Indicators<S: Varying> = [S; CONTACT + Event::COUNT];

    fn tables() -> Tables {
        variables::tables::<L>()
    }

    fn new(values: &mut Values) -> Result<Self, ParameterError> {
        let p: Parameters = values.read()?;
        let law = p.friction_forces().read(values, "friction")?;
        let friction =
            FrictionContact::new(law, Drive::Force, State::FRICTION, State::Velocity.index(), references::CONTACT);
        Ok(Self { coupling: Coupling::new(&p), friction, p })
    }

    fn parameters(&self) -> &Parameters {
        &self.p
    }

    fn parts() -> impl Holds<Self, 1> {
        Holder
    }

    fn start<S: Varying, const N: usize>(&self, u: &[S; 1]) -> ([S; N], Self::Memory<S>) {
        let mut x = [S::zero(); N];
        State::Position.set(&mut x, S::along(self.p.position0));
        State::Velocity.set(&mut x, S::along(self.p.velocity0));
        State::InternalPosition.set(&mut x, S::along(self.p.position0 + self.p.displacement0));
        State::InternalVelocity.set(&mut x, S::along(self.p.velocity0 + self.p.displacement_rate0));
        let touches = self.p.displacement0 > self.coupling.gap.value;
        let contact = self.contact(S::zero(), &x, &Inputs::read(u), State::Velocity.get(&x), touches);
        let friction = self.friction.start(&contact, &mut x);
        (x, Memory { friction, touches, impacts: 0 })
    }

    fn indicator_list() -> Vec<Indicator> {
        let text = "The impact spring is touched or left";
        let impact = Indicator { name: "impact.contact".to_owned(), nominal: 1e-3, text };
        [vec![impact], Self::parts().indicator_list()].concat()
    }

    fn derivatives<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; 1],
        memory: &Memory<L::Memory<S::Held>>,
    ) -> [S; N] {
        let u = &Inputs::read(u);
        let mut rates = [S::zero(); N];
        let rate = self.rate(x, memory);
        let contact = self.contact(time, x, u, rate, memory.touches);
        let force = self.friction.force(&contact, x, &memory.friction, &mut rates);
        State::InternalPosition.set(&mut rates, State::InternalVelocity.get(x));
        State::InternalVelocity.set(&mut rates, (u.external_force - contact.applied) / self.coupling.internal_mass);
        State::Position.set(&mut rates, rate);
        State::Velocity.set(&mut rates, (contact.applied - force) / self.coupling.body_mass);
        rates
    }

    fn indicators<S: Varying, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; 1],
        memory: &Memory<L::Memory<S>>,
    ) -> Self::Indicators<S> {
        let mut indicators = [S::of(UNUSED); CONTACT + Event::COUNT];
        let (d, _) = self.displacement(x, S::zero());
        let gap = self.coupling.gap;
        indicators[IMPACT] = if memory.touches { d - gap } else { -d + gap };
        Holder.write_indicators(self, (time, x, u), memory, &mut indicators);
        indicators
    }

    /// The impact spring has no preload.
    fn is_kink(&self, event: usize) -> bool {
        event == IMPACT
    }

    #[cfg(feature = "sensitivities")]
    fn are_alike<S: Varying>(&self, one: &Memory<L::Memory<S>>, other: &Memory<L::Memory<S>>) -> bool {
        are_alike(&one.friction, &other.friction)
    }

    fn switch<S: Varying, const N: usize>(
        &self,
        event: usize,
        time: S,
        x: &mut [S; N],
        u: &[S; 1],
        memory: &mut Memory<L::Memory<S>>,
    ) {
        if event == IMPACT {
            memory.touches = !memory.touches;
            memory.impacts = memory.impacts.saturating_add(u32::from(memory.touches));
            return;
        }
        Holder.switch(self, event - CONTACT, (time, x, u), memory);
    }

    fn event_name(&self, event: usize) -> &'static str {
        if event == IMPACT { "impact" } else { Event::ALL[event - CONTACT].name() }
    }

    /// At rest in the middle only the excitation moves anything: a step must not pass over a period of it.
    fn max_step(&self) -> f64 {
        self.friction.max_step().min(0.125 * TAU / self.coupling.frequency.value)
    }

    fn depends_on_time(&self) -> bool {
        true
    }

    fn outputs<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; 1],
        memory: &Memory<L::Memory<S::Held>>,
        computed: &mut [S],
    ) {
        let u = &Inputs::read(u);
        let rate = self.rate(x, memory);
        let contact = self.contact(time, x, u, rate, memory.touches);
        let friction = self.friction.observe(&contact, x, &memory.friction);
        let (d, d_rate) = self.displacement(x, rate);
        let outputs = Outputs {
            position: State::Position.get(x),
            velocity: rate,
            acceleration: friction.unless_held((contact.applied - friction.force) / self.coupling.body_mass),
            internal_position: State::InternalPosition.get(x),
            internal_velocity: State::InternalVelocity.get(x),
            internal_acceleration: (u.external_force - contact.applied) / self.coupling.internal_mass,
            displacement: d,
            displacement_rate: d_rate,
            excitation: self.coupling.excitation(time),
            spring_force: self.coupling.spring_force(d, d_rate),
            impact_force: self.coupling.impact_force(d, memory.touches),
            friction_force: friction.force,
            sticking: friction.sticking,
            touching: S::constant(f64::from(memory.touches)),
            impacts: S::constant(f64::from(i32::try_from(memory.impacts).unwrap_or(i32::MAX))),
        };
        friction.write(outputs.write(computed));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::checks;

    /// Messages call an event of a contact as a host calls its indicator, without the group.
    #[test]
    fn events_are_named_as_their_indicators() {
        checks::events_are_named::<VibroImpact, 1>(|place, last| if place == IMPACT { "impact" } else { last });
    }
    #[test]
    fn laws_cost_what_they_ask_for() {
        checks::laws_cost_what_they_ask_for::<VibroImpact, 1>([true; 2]);
    }
}
