//! A crane festoon: trolleys with hanging loads on a rail, each under friction, towed by ropes and pushed by buffers.
//!
//! ```text
//! gap_i = x_(i-1) - x_i,   x_0 the crane trolley, whose velocity is an input
//! L_i   = rope(gap_i - rope.length) - buffer(buffer.length - gap_i)      [N], each only where its argument is positive
//! (M + m*sin(phi)^2)*dv/dt = F_app - F_f
//! F_app = L_i - L_(i+1) + m*sin(phi)*(g*cos(phi) + l*w^2) + d*w*cos(phi)/l,   and pulseForce on the first trolley
//! dw/dt = -(cos(phi)*dv/dt + g*sin(phi))/l - d*w/(m*l^2),   w = dphi/dt
//! ```
//!
//! `F_app` is the force of load and links on a trolley that is held; it does not depend on the friction force, and
//! a trolley that is held stays so while friction can balance it. Ropes tauten and buffers meet at events.
//!
//! # Source
//! Friction modeling from a practical point of view (extended abstract), which proposes the festoon as a friction test
//! bench but gives no equations or parameters: those are this project's.

mod variables;

use serde::{Deserialize, Serialize};

use self::variables::{CRANE_POSITION, Inputs, Outputs, Parameters, State, TrolleyOutputs, contact_base, trolley_base};
use crate::co_simulation::AnyRun;
use crate::co_simulation::start_sized;
use crate::friction::{self, Contact, ContactLaw, Drive, Event, Friction, FrictionContact, FrictionLaw, MAX_STATES};
use crate::holds;
use crate::mechanics::{GRAVITY, OneSided};
use crate::model::{Course, Experiment, Functions, Model, Panel, Signal, Start};
use crate::numbers::{Scalar, Varying};
#[cfg(feature = "sensitivities")]
use crate::system::are_alike;
use crate::system::{Hints, Holder, Holds, Indicator, Part, PartFacts, Sample, StateIndex, System, Tables, UNUSED};
use crate::variables::{ParameterError, Values};

/// The model as the library offers it.
pub const MODEL: Model = model::<Friction>();

/// The model with the laws of a catalogue.
pub const fn model<L: FrictionLaw>() -> Model {
    Model {
        name: "Festoon",
        description: "Crane festoon: trolleys with hanging loads and friction, towed by ropes and pushed by buffers",
        functions: Functions::of::<Festoon<L>, 2>(states(MAX_STATES), start::<L, _>, start::<L, _>),
        experiment: Experiment {
            stop_time: 30.0,
            step_size: 1e-2,
            signals: &[Signal {
                input: "craneVelocity",
                text: "0.25 m/s for 10 s, 0 for 5 s, and −0.25 m/s for 10 s",
                course: Course::Steps(&[(0.0, 0.25), (10.0, 0.0), (15.0, -0.25), (25.0, 0.0)]),
            }],
            panels: &[
                Panel {
                    label: "position",
                    curves: &["crane.position", "trolley[3].position", "trolley[2].position", "trolley[1].position"],
                },
                Panel {
                    label: "velocity",
                    curves: &["trolley[3].velocity", "trolley[2].velocity", "trolley[1].velocity"],
                },
                Panel {
                    label: "load angle",
                    curves: &["trolley[3].load.angle", "trolley[2].load.angle", "trolley[1].load.angle"],
                },
                Panel {
                    label: "friction force",
                    curves: &["trolley[3].frictionForce", "trolley[2].frictionForce", "trolley[1].frictionForce"],
                },
            ],
        },
    }
}

/// The largest number of trolleys.
///
/// The work of a step grows with the cube of the number of states, of which a trolley has up to 14; three show all that
/// a longer festoon does (a first, a middle and a last trolley).
const MAX_TROLLEYS: usize = 3;

/// The equations for given parameters.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct Festoon<L = Friction> {
    p: Parameters,
    rope: OneSided,
    buffer: OneSided,
    friction: [FrictionContact<L>; MAX_TROLLEYS],
}

/// Link between a trolley and the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Link {
    /// The rope hangs through, the buffers do not meet.
    Loose,
    /// The rope is taut.
    Taut,
    /// The buffers press each other.
    Pressed,
}

/// Memory of the friction laws and of the links.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[doc(hidden)]
pub struct Memory<F = friction::Memory> {
    friction: [F; MAX_TROLLEYS],
    links: [Link; MAX_TROLLEYS],
}

/// Forces of a link in N.
#[derive(Clone, Copy, Debug)]
struct LinkForces<S> {
    tow: S,
    buffer: S,
}

impl<S: Scalar> LinkForces<S> {
    /// Force on the trolley behind towards +x; the one before feels its reaction.
    fn pull(&self) -> S {
        self.tow - self.buffer
    }
}

/// Forces on a trolley and its load.
#[derive(Clone, Copy, Debug)]
struct Motion<S> {
    acceleration: S,
    angular_acceleration: S,
}

// The crane trolley's position comes first, then a block for each trolley. Blocks of trolleys that are not there stay as
// they are.
const CRANE: usize = 0;
const BLOCKS: usize = 1;

/// Index of a state of a trolley among `n`.
#[inline(always)]
const fn at(state: State, trolley: usize, n: usize) -> usize {
    let block = (n - BLOCKS) / MAX_TROLLEYS;
    BLOCKS + trolley * block + state.at(block)
}

/// One indicator for each link comes first, then the indicators of each trolley's contact.
const fn contact_indicators(trolley: usize) -> usize {
    MAX_TROLLEYS + trolley * Event::COUNT
}

/// Starts a run with as many states as the friction law needs.
fn start<L: FrictionLaw, P: AnyRun>(start: &Start) -> Result<P, ParameterError> {
    start_sized!(start, Festoon<L>, 2, [states(0), states(1), states(MAX_STATES)])
}

/// Room in a block for the states of a friction law.
const fn room(count: usize) -> usize {
    if count <= 1 { count } else { MAX_STATES }
}

/// Number of all states, with room for some states of the friction law of each trolley.
const fn states(room: usize) -> usize {
    BLOCKS + MAX_TROLLEYS * (State::OTHERS + room)
}

impl<L: FrictionLaw> Festoon<L> {
    fn trolleys(&self) -> usize {
        self.p.trolleys
    }

    /// Position of a trolley; index 0 is the crane trolley.
    fn place<S: Scalar, const N: usize>(x: &[S; N], link: usize) -> S {
        if link == 0 { x[CRANE] } else { x[at(State::Position, link - 1, N)] }
    }

    /// Distance that a link spans.
    fn gap<S: Scalar, const N: usize>(x: &[S; N], link: usize) -> S {
        Self::place(x, link) - x[at(State::Position, link, N)]
    }

    /// The link across a gap in m.
    fn link_at(&self, gap: f64) -> Link {
        if gap > self.p.rope_length.value {
            Link::Taut
        } else if gap < self.p.buffer_length.value {
            Link::Pressed
        } else {
            Link::Loose
        }
    }

    /// The link after the event of the present one; the gap is at a limit but for rounding.
    fn link_after(&self, link: Link, gap: f64) -> Link {
        match link {
            Link::Taut | Link::Pressed => Link::Loose,
            Link::Loose if gap > 0.5 * (self.p.rope_length + self.p.buffer_length).value => Link::Taut,
            Link::Loose => Link::Pressed,
        }
    }

    /// Velocities of the trolleys: the states, unless the friction law holds a position.
    fn rates<S: Scalar, const N: usize>(&self, x: &[S; N], memory: &Memory<L::Memory<S::Held>>) -> [S; MAX_TROLLEYS] {
        std::array::from_fn(|trolley| {
            self.friction[trolley].rate(x[at(State::Velocity, trolley, N)], &memory.friction[trolley])
        })
    }

    /// Forces of the link before a trolley, at velocities of the trolleys.
    fn link_forces<S: Scalar, const N: usize>(
        &self,
        x: &[S; N],
        u: &Inputs<S>,
        rates: &[S; MAX_TROLLEYS],
        links: &[Link; MAX_TROLLEYS],
        link: usize,
    ) -> LinkForces<S> {
        let none = LinkForces { tow: S::zero(), buffer: S::zero() };
        if link >= self.trolleys() {
            return none;
        }
        let gap = Self::gap(x, link);
        let opening = if link == 0 { u.crane_velocity } else { rates[link - 1] } - rates[link];
        match links[link] {
            Link::Loose => none,
            Link::Taut => LinkForces { tow: self.rope.force(gap - self.p.rope_length, opening), ..none },
            Link::Pressed => LinkForces { buffer: self.buffer.force(-gap + self.p.buffer_length, -opening), ..none },
        }
    }

    /// The contact of a trolley as the friction law sees it, at velocities of the trolleys.
    fn contact<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &Inputs<S>,
        rates: &[S; MAX_TROLLEYS],
        links: &[Link; MAX_TROLLEYS],
        trolley: usize,
    ) -> Contact<S> {
        let pull = |link| self.link_forces(x, u, rates, links, link).pull();
        let (sine, cosine, w) = (
            x[at(State::Angle, trolley, N)].sin(),
            x[at(State::Angle, trolley, N)].cos(),
            x[at(State::Spin, trolley, N)],
        );
        let swing = sine * self.p.load_mass * (cosine * GRAVITY + w * w * self.p.load_length);
        let joint = w * cosine * (self.p.load_damping / self.p.load_length);
        let pulse = if trolley == 0 { u.pulse_force } else { S::zero() };
        Contact {
            time,
            position: x[at(State::Position, trolley, N)],
            velocity: x[at(State::Velocity, trolley, N)],
            applied: pull(trolley) - pull(trolley + 1) + swing + joint + pulse,
            level: S::tuned(self.p.level[trolley]),
            drive: self.friction[trolley].drive(),
        }
    }

    /// Accelerations of a trolley and its load under a friction force.
    fn motion<S: Scalar, const N: usize>(
        &self,
        contact: &Contact<S>,
        friction_force: S,
        x: &[S; N],
        memory: &L::Memory<S::Held>,
        trolley: usize,
    ) -> Motion<S> {
        let p = &self.p;
        let (sine, cosine) = (x[at(State::Angle, trolley, N)].sin(), x[at(State::Angle, trolley, N)].cos());
        let acceleration = (contact.applied - friction_force) / (sine * sine * p.load_mass + p.mass);
        // The load swings about the trolley as it is: at rest while the law holds its position.
        let carried = self.friction[trolley].rate(acceleration, memory);
        let damping = x[at(State::Spin, trolley, N)] * (p.load_damping / (p.load_mass * p.load_length * p.load_length));
        let angular_acceleration = -(cosine * carried + sine * GRAVITY) / p.load_length - damping;
        Motion { acceleration, angular_acceleration }
    }

    fn link_indicator<S: Varying, const N: usize>(&self, x: &[S; N], memory: &Memory<L::Memory<S>>, link: usize) -> S {
        let gap = Self::gap(x, link);
        let (until_taut, until_pressed) = (-gap + self.p.rope_length, gap - self.p.buffer_length);
        match memory.links[link] {
            Link::Loose => until_taut.min(until_pressed),
            Link::Taut => -until_taut,
            Link::Pressed => -until_pressed,
        }
    }
}

holds! {
    [L: FrictionLaw] Festoon<L>, 2; |festoon, time, x, u, memory|
    friction: [FrictionContact<L>; MAX_TROLLEYS], "trolley[].friction", memory.friction, {
        let (rates, u) = (festoon.rates(x, memory), &Inputs::read(u));
        std::array::from_fn(|trolley| {
            (trolley < festoon.trolleys()).then(|| festoon.contact(time, x, u, &rates, &memory.links, trolley))
        })
    };
}

impl<L: FrictionLaw> System<2> for Festoon<L> {
    type Parameters = Parameters;
    type State = State;
    type Memory<S: Varying> = Memory<L::Memory<S>>;
    type Indicators<S: Varying> = [S; contact_indicators(MAX_TROLLEYS)];

    fn tables() -> Tables {
        variables::tables::<L>()
    }

    fn new(values: &mut Values) -> Result<Self, ParameterError> {
        let (p, ContactLaw(law)): variables::Parts<L> = values.read()?;
        p.check()?;
        let rope = OneSided { stiffness: p.rope_stiffness, damping: p.rope_damping };
        let buffer = OneSided { stiffness: p.buffer_stiffness, damping: p.buffer_damping };
        let block = State::OTHERS + room(law.states());
        let friction = std::array::from_fn(|trolley| {
            let first = BLOCKS + trolley * block;
            let velocity = StateIndex::Front(first + State::Velocity.at(block));
            FrictionContact::new(law.clone(), Drive::Force, first + State::FRICTION, velocity, contact_base(trolley))
        });
        Ok(Self { p, rope, buffer, friction })
    }

    fn parameters(&self) -> &Parameters {
        &self.p
    }

    fn parts() -> impl Holds<Self, 2> {
        Holder
    }

    fn start<S: Varying, const N: usize>(&self, u: &[S; 2]) -> ([S; N], Self::Memory<S>) {
        let mut x = [S::zero(); N];
        x[CRANE] = S::along(self.p.crane_position0);
        for trolley in 0..self.trolleys() {
            let position = self.p.crane_position0 - (trolley + 1) as f64 * self.p.spacing0;
            x[at(State::Position, trolley, N)] = S::along(position);
            x[at(State::Angle, trolley, N)] = S::along(self.p.angle0);
        }
        let links = std::array::from_fn(|link| self.link_at(Self::gap(&x, link).value()));
        let (still, u) = ([S::zero(); MAX_TROLLEYS], Inputs::read(u));
        let friction = std::array::from_fn(|trolley| {
            let contact = self.contact(S::zero(), &x, &u, &still, &links, trolley);
            self.friction[trolley].start(&contact, &mut x)
        });
        (x, Memory { friction, links })
    }

    fn states(&self) -> usize {
        states(room(self.friction[0].states()))
    }

    fn indicator_list() -> Vec<Indicator> {
        let link = |number| Indicator {
            name: format!("trolley[{number}].link"),
            nominal: 0.1,
            text: "The rope becomes taut or slack, or the buffer is touched or left",
        };
        (1..=MAX_TROLLEYS).map(link).chain(Self::parts().indicator_list()).collect()
    }

    fn derivatives<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; 2],
        memory: &Memory<L::Memory<S::Held>>,
    ) -> [S; N] {
        let u = &Inputs::read(u);
        let mut derivatives = [S::zero(); N];
        derivatives[CRANE] = u.crane_velocity;
        let rates = self.rates(x, memory);
        for trolley in 0..self.trolleys() {
            let contact = self.contact(time, x, u, &rates, &memory.links, trolley);
            let law = &memory.friction[trolley];
            let friction_force = self.friction[trolley].force(&contact, x, law, &mut derivatives);
            let motion = self.motion(&contact, friction_force, x, law, trolley);
            derivatives[at(State::Position, trolley, N)] = rates[trolley];
            derivatives[at(State::Velocity, trolley, N)] = motion.acceleration;
            derivatives[at(State::Angle, trolley, N)] = x[at(State::Spin, trolley, N)];
            derivatives[at(State::Spin, trolley, N)] = motion.angular_acceleration;
        }
        derivatives
    }

    fn indicators<S: Varying, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; 2],
        memory: &Memory<L::Memory<S>>,
    ) -> Self::Indicators<S> {
        let mut indicators = [S::of(UNUSED); contact_indicators(MAX_TROLLEYS)];
        for (link, indicator) in indicators.iter_mut().enumerate().take(self.trolleys()) {
            *indicator = self.link_indicator(x, memory, link);
        }
        Holder.write_indicators(self, (time, x, u), memory, &mut indicators);
        indicators
    }

    /// Ropes and buffers have no preload.
    fn is_kink(&self, event: usize) -> bool {
        event < MAX_TROLLEYS
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
        u: &[S; 2],
        memory: &mut Memory<L::Memory<S>>,
    ) {
        if event < MAX_TROLLEYS {
            memory.links[event] = self.link_after(memory.links[event], Self::gap(x, event).value());
            return;
        }
        Holder.switch(self, event - MAX_TROLLEYS, (time, x, u), memory);
    }

    fn next_sample<S: Varying>(&self, memory: &Memory<L::Memory<S>>) -> Sample<S> {
        let trolleys = self.friction[..self.trolleys()].iter().zip(&memory.friction);
        trolleys.map(|(friction, law)| friction.next_sample(law)).fold(Sample::never(), Sample::earlier)
    }

    fn event_name(&self, event: usize) -> &'static str {
        match event.checked_sub(MAX_TROLLEYS) {
            None => "a rope or buffer",
            Some(event) => self.friction.event_name(event),
        }
    }

    fn scales<const N: usize>(&self) -> [f64; N] {
        let mut scales = [1.0; N];
        self.friction.write_scales(&mut scales);
        scales[CRANE] = 1e-2;
        for trolley in 0..MAX_TROLLEYS {
            State::ALL.iter().for_each(|state| scales[at(*state, trolley, N)] = state.scale(&self.p));
        }
        scales
    }

    fn outputs<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; 2],
        memory: &Memory<L::Memory<S::Held>>,
        computed: &mut [S],
    ) {
        let u = &Inputs::read(u);
        let rates = self.rates(x, memory);
        let forces = |link| self.link_forces(x, u, &rates, &memory.links, link);
        let crane = Outputs { crane_position: x[CRANE], crane_rate: u.crane_velocity, crane_force: forces(0).pull() };
        let mut slots = crane.write(computed);
        for trolley in 0..MAX_TROLLEYS {
            if trolley >= self.trolleys() {
                // A trolley that is not there shows zeros.
                slots.fill(S::zero());
                return;
            }
            let law = &memory.friction[trolley];
            let contact = self.contact(time, x, u, &rates, &memory.links, trolley);
            let friction = self.friction[trolley].observe(&contact, x, law);
            let motion = self.motion(&contact, friction.force, x, law, trolley);
            let outputs = TrolleyOutputs {
                position: x[at(State::Position, trolley, N)],
                velocity: rates[trolley],
                acceleration: friction.unless_held(motion.acceleration),
                angle: x[at(State::Angle, trolley, N)],
                spin: x[at(State::Spin, trolley, N)],
                angular_acceleration: motion.angular_acceleration,
                tow_force: forces(trolley).tow,
                buffer_force: forces(trolley).buffer,
                friction_force: friction.force,
                sticking: friction.sticking,
            };
            slots = friction.write(outputs.write(slots));
        }
    }

    fn state_at(&self, reference: u32, n: usize) -> Option<usize> {
        let of_trolley = |trolley: usize| {
            let own = reference.checked_sub(trolley_base(trolley)).and_then(State::of);
            own.map(|state| at(state, trolley, n)).or_else(|| self.friction[trolley].state_at(reference, n))
        };
        if reference == CRANE_POSITION { Some(CRANE) } else { (0..self.trolleys()).find_map(of_trolley) }
    }

    fn hints<S: Varying, const N: usize>(&self, _x: &[S; N], _memory: &Self::Memory<S>) -> Hints {
        Hints { is_chain: true, ..Hints::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::checks;

    /// Messages call an event of a contact as a host calls its indicator, without the group.
    #[test]
    fn events_are_named_as_their_indicators() {
        checks::events_are_named::<Festoon, 2>(|_, last| if last == "link" { "a rope or buffer" } else { last });
    }
    #[test]
    fn laws_cost_what_they_ask_for() {
        checks::laws_cost_what_they_ask_for::<Festoon, 2>([true, false]);
    }
}
