//! A free slider on a tray that is shaken harmonically: friction alone moves it.
//!
//! ```text
//! v_tray = v_d*cos(w*t),   x_tray = v_d/w*sin(w*t)
//! r = x - x_tray,   dr/dt = u,   m*du/dt = F_app - F_f(u),   F_app = externalForce - m*dv_tray/dt
//! ```
//!
//! Position and velocity relative to the tray are the states, so that a slider that sticks stays in place exactly.
//! The friction forces are friction coefficients times the weight. Beside the slider runs the walk of [`walk`].

mod variables;
#[doc(hidden)]
pub mod walk;

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use self::variables::{Inputs, Outputs, Parameters, State};
use self::walk::{Harmonic, Walk};
use crate::co_simulation::AnyRun;
use crate::co_simulation::start_sized;
use crate::friction::{self, Contact, Drive, Friction, FrictionContact, FrictionLaw, Indicators, MAX_STATES};
use crate::holds;
use crate::mechanics::GRAVITY;
use crate::model::{Experiment, Functions, Model, Panel, Start};
use crate::numbers::{Scalar, Varying};
use crate::system::{Holder, Holds, Part, Sample, System, Tables, references};
use crate::variables::{ParameterError, Tunable, Values};

/// The model as the library offers it.
pub const MODEL: Model = model::<Friction>();

/// The model with the laws of a catalogue.
pub const fn model<L: FrictionLaw>() -> Model {
    Model {
        name: "DrivenSlider",
        description: "Free slider on a harmonically shaken tray, moved by friction alone",
        functions: Functions::of::<DrivenSlider<L>, 1>(State::OTHERS + MAX_STATES, start::<L, _>, start::<L, _>),
        experiment: Experiment {
            stop_time: 0.5,
            step_size: 5e-4,
            signals: &[],
            panels: &[
                Panel { label: "position", curves: &["position"] },
                Panel { label: "velocity", curves: &["tray.velocity", "walk.velocity", "velocity"] },
                Panel { label: "friction force", curves: &["frictionForce"] },
            ],
        },
    }
}

/// The equations for given parameters.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct DrivenSlider<L = Friction> {
    p: Parameters,
    tray: Harmonic,
    stick_free: Harmonic,
    walk: Option<Walk>,
    friction: FrictionContact<L>,
}

/// Memory of the friction law, and of the events at given times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[doc(hidden)]
pub struct Memory<F = friction::Memory> {
    friction: F,
    walk: walk::State,
    /// Number of the next half period in whose middle the acceleration of the tray is largest.
    peak: f64,
}

/// Starts a run with as many states as the friction law needs.
fn start<L: FrictionLaw, P: AnyRun>(start: &Start) -> Result<P, ParameterError> {
    start_sized!(start, DrivenSlider<L>, 1, [State::OTHERS, State::OTHERS + 1, State::OTHERS + MAX_STATES])
}

impl<L: FrictionLaw> DrivenSlider<L> {
    fn of(p: Parameters, friction: L) -> Self {
        let tray =
            Harmonic { amplitude: p.tray_velocity, frequency: TAU * p.tray_frequency, phase: Tunable::still(0.0) };
        // From the velocity of the tray the slider comes to rest in v_d/(mu_dyn*g).
        let flight_time = p.flight_factor * p.tray_velocity / (p.dynamic_coefficient * GRAVITY);
        let stick_free = tray.stick_free(flight_time);
        let walk = (p.walk_steps > 0).then(|| {
            let coefficients = [p.static_coefficient, p.dynamic_coefficient];
            let time_step = 1.0 / (p.tray_frequency * f64::from(p.walk_steps));
            Walk::new([tray, stick_free], coefficients, time_step, p.seed)
        });
        Self {
            tray,
            stick_free,
            walk,
            friction: FrictionContact::new(
                friction,
                Drive::Force,
                State::FRICTION,
                State::Velocity.index(),
                references::CONTACT,
            ),
            p,
        }
    }

    fn tray_position<S: Scalar>(&self, time: S) -> S {
        (time * self.tray.frequency).sin() * (self.p.tray_velocity / self.tray.frequency)
    }

    fn tray_acceleration<S: Scalar>(&self, time: S) -> S {
        (time * self.tray.frequency).sin() * (-self.p.tray_velocity * self.tray.frequency)
    }

    /// The contact with the tray as the friction law sees it.
    fn contact<S: Scalar, const N: usize>(&self, time: S, x: &[S; N], u: &Inputs<S>) -> Contact<S> {
        Contact {
            time,
            position: State::Position.get(x),
            velocity: State::Velocity.get(x),
            applied: u.external_force - self.tray_acceleration(time) * self.p.mass,
            level: S::constant(1.0),
            drive: self.friction.drive(),
        }
    }

    /// Velocity on the tray: the state, unless the friction law holds the position.
    fn rate<S: Scalar, const N: usize>(&self, x: &[S; N], memory: &Memory<L::Memory<S::Held>>) -> S {
        self.friction.rate(State::Velocity.get(x), &memory.friction)
    }

    /// Number of the half period after a time, in whose middle the tray turns back.
    fn peak_after(&self, time: f64) -> f64 {
        libm::floor(2.0 * self.p.tray_frequency.value * time + 0.5)
    }

    /// Time in s at which the tray turns back in a half period.
    fn peak_time(&self, number: f64) -> Tunable {
        (number + 0.5) / (2.0 * self.p.tray_frequency)
    }
}

holds! {
    [L: FrictionLaw] DrivenSlider<L>, 1; |slider, time, x, u, memory|
    friction: FrictionContact<L>, "friction", memory.friction, slider.contact(time, x, &Inputs::read(u));
}

impl<L: FrictionLaw> System<1> for DrivenSlider<L> {
    type Parameters = Parameters;
    type State = State;
    type Memory<S: Varying> = Memory<L::Memory<S>>;
    type Indicators<S: Varying> = Indicators<S>;

    fn tables() -> Tables {
        variables::tables::<L>()
    }

    fn new(values: &mut Values) -> Result<Self, ParameterError> {
        let p: Parameters = values.read()?;
        let friction = p.friction_forces()?.read(values, "friction")?;
        Ok(Self::of(p, friction))
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
        let contact = self.contact(S::zero(), &x, &Inputs::read(u));
        let friction = self.friction.start(&contact, &mut x);
        let walk = self.walk.map_or(walk::State::AT_REST, |walk| walk.start(0.0));
        (x, Memory { friction, walk, peak: self.peak_after(0.0) })
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
        let contact = self.contact(time, x, u);
        let force = self.friction.force(&contact, x, &memory.friction, &mut rates);
        State::Position.set(&mut rates, self.rate(x, memory));
        State::Velocity.set(&mut rates, (contact.applied - force) / self.p.mass);
        rates
    }

    /// Where the tray turns back the force on a stuck slider is largest: a step ends there, lest it miss a break-away.
    fn next_sample<S: Varying>(&self, memory: &Memory<L::Memory<S>>) -> Sample<S> {
        let of_walk = |walk: Walk| Sample::periodic(S::of(walk.next_step(&memory.walk)), walk.time_step.value);
        let turn = Sample::exact(S::along(self.peak_time(memory.peak)));
        let of_friction = self.friction.next_sample(&memory.friction);
        self.walk.map_or(Sample::never(), of_walk).earlier(turn).earlier(of_friction)
    }

    fn depends_on_time(&self) -> bool {
        true
    }

    fn sample<S: Varying, const N: usize>(
        &self,
        time: S,
        x: &mut [S; N],
        u: &[S; 1],
        memory: &mut Memory<L::Memory<S>>,
    ) {
        Holder.sample(self, (time, x, u), memory);
        let now = time.value();
        if let Some(walk) = self.walk.filter(|walk| walk.next_step(&memory.walk) <= now) {
            walk.step(&mut memory.walk);
        }
        if self.peak_time(memory.peak).value <= now {
            memory.peak += 1.0;
        }
    }

    fn fits<S: Varying>(&self, memory: &Memory<L::Memory<S>>) -> bool {
        memory.peak.is_finite() && memory.walk.is_finite() && self.friction.fits::<S>(&memory.friction)
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
        let contact = self.contact(time, x, u);
        let friction = self.friction.observe(&contact, x, &memory.friction);
        let rate = self.rate(x, memory);
        let (tray_position, tray_velocity) = (self.tray_position(time), self.tray.at(time));
        let tray_acceleration = self.tray_acceleration(time);
        let of_walk = |value: fn(&Walk, &walk::State) -> Tunable| {
            self.walk.as_ref().map_or(S::zero(), |walk| S::tuned(value(walk, &memory.walk)))
        };
        let relative_acceleration = friction.unless_held((contact.applied - friction.force) / self.p.mass);
        let outputs = Outputs {
            position: tray_position + State::Position.get(x),
            velocity: tray_velocity + rate,
            acceleration: tray_acceleration + relative_acceleration,
            relative_position: State::Position.get(x),
            relative_velocity: rate,
            relative_acceleration,
            tray_position,
            tray_velocity,
            tray_acceleration,
            friction_force: friction.force,
            sticking: friction.sticking,
            stick_free_velocity: self.stick_free.at(time),
            walk_velocity: of_walk(Walk::velocity),
            walk_probability: of_walk(|walk, _| walk.chi),
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
        checks::events_are_named::<DrivenSlider, 1>(|_, last| last);
    }

    /// Under `sin(2*pi*f*t)` after a quarter and three quarters of each period.
    #[test]
    fn tray_turns_back_twice_in_a_period() {
        let slider = checks::built::<DrivenSlider, 1>(None);
        let period = 1.0 / slider.p.tray_frequency.value;
        for (time, next) in [(0.0, 0.25), (0.24, 0.25), (0.26, 0.75), (0.74, 0.75), (0.76, 1.25), (7.9, 8.25)] {
            let turn = slider.peak_time(slider.peak_after(time * period)).value;
            assert!((turn - next * period).abs() < 1e-12 * period, "{turn} s after {time} periods");
        }
    }

    #[test]
    fn laws_cost_what_they_ask_for() {
        checks::laws_cost_what_they_ask_for::<DrivenSlider, 1>([false, true]);
    }
}
