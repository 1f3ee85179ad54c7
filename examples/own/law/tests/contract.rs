//! The contract of laws: a contact that has broken away slides; derivatives and dependencies agree with the equations. Laws
//! that break it are found.

use pneumatic_servo::conformance::{found_dependencies, law};
use pneumatic_servo::friction::parts::parameters::force;
use pneumatic_servo::friction::parts::stick_slip::Mode;
use pneumatic_servo::friction::{Event, Indicators};
use pneumatic_servo::models::friction_bench;
use pneumatic_servo::prelude::*;

parameters! {
    /// Coulomb friction whose force while sliding may exceed that at rest.
    #[derive(Copy)]
    Grip {
        holding: Tunable = force(9, "holding", 10.0).text("Largest force at rest");
        sliding: Tunable = force(10, "sliding", 12.0).text("Force while sliding");
    }
}

impl SetValued for Grip {
    fn break_away<S: Scalar>(&self, _direction: f64, level: S) -> S {
        level * self.holding
    }

    fn kinetic<S: Scalar>(&self, _velocity: S, direction: f64, level: S) -> S {
        level * self.sliding * direction
    }
}

/// The same as a law of the general kind, whose forces are not checked.
#[derive(Clone, Debug)]
struct Unchecked(Grip);

impl ParameterSet for Unchecked {
    const LEN: usize = Grip::LEN;

    fn table() -> Vec<Variable> {
        Grip::table()
    }

    fn read(values: &[Tunable]) -> Result<Self, ParameterError> {
        Grip::read(values).map(Self)
    }
}

impl FrictionLaw for Unchecked {
    type Memory<S: Varying> = Mode;

    fn stiction(&self) -> Stiction {
        Stiction::Exact
    }

    fn events(&self) -> &'static [Event] {
        Mode::EVENTS
    }

    fn start<S: Varying>(&self, contact: &Contact<S>) -> Mode {
        Mode::at(contact, contact.velocity, self.0.break_away(1.0, contact.level))
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], mode: &Mode, _rates: &mut [S]) -> S {
        match *mode {
            Mode::Stuck => Mode::holding_force(contact, self.0.break_away(1.0, contact.level)),
            Mode::Sliding(direction) => self.0.kinetic(contact.velocity, direction, contact.level),
        }
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, _z: &[S], mode: &Mode, out: &mut Indicators<S>) {
        mode.indicators(contact, || self.0.break_away(1.0, contact.level), out);
    }

    fn switch<S: Varying>(&self, _event: Event, contact: &Contact<S>, velocity: &mut S, _z: &mut [S], mode: &mut Mode) {
        *mode = mode.switched(contact, velocity, self.0.break_away(1.0, contact.level));
    }

    fn is_sticking<S: Varying>(mode: &Mode) -> bool {
        *mode == Mode::Stuck
    }
}

parameters! {
    /// A bristle that wears, by equations that say less of themselves than they do.
    Careless {
        stiffness: Tunable = Variable::parameter(0, "k", units::NEWTON_PER_METRE, 1e3).text("Stiffness");
    }
}

impl FrictionLaw for Careless {
    type Memory<S: Varying> = ();

    const STATES: &'static [LawState<Self>] = &[
        LawState::new("bristle", units::METRE, |_| 1e-3),
        LawState::new("wear", units::ONE, |_| 1.0).range(1e-3, f64::INFINITY),
    ];

    // The wear depends on the bristle.
    fn couples_states() -> bool {
        false
    }

    fn start_states<S: Varying>(&self, _contact: &Contact<S>, z: &mut [S]) {
        z[1] = S::constant(0.01);
    }

    fn start<S: Varying>(&self, _contact: &Contact<S>) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], _memory: &(), rates: &mut [S]) -> S {
        rates[0] = contact.velocity - z[0];
        rates[1] = z[0] * z[0];
        // The logarithm ends where wear does; the value has no derivative.
        contact.level * self.stiffness * z[0] + S::constant(z[1].ln().value())
    }
}

laws! {
    /// Laws that keep the contract, and laws that do not.
    pub mod catalogue {
        1000 Grip "grip" StickSlip<Grip>, "Coulomb friction, more or less of it while sliding";
        1001 Unchecked "unchecked" Unchecked, "The same, unchecked";
        1002 Careless "careless" Careless, "A bristle that wears";
    }
}

static BENCH: Model = friction_bench::model::<catalogue::Friction>();

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn free(law: &str) -> Result<Setup, Box<dyn std::error::Error>> {
    Ok(Setup::new(&BENCH).set("friction.law", law)?.set("bench.drive", "Free")?)
}

/// At rest 10 N, sliding 12 N: refused before a run begins, with both numbers. No more than 10 N is accepted.
#[test]
fn sliding_that_takes_more_than_rest_is_refused() -> Outcome {
    let error = free("Grip")?.start(0.0).err().ok_or("a law that cannot slide has started")?;
    assert_eq!(error.value, 6.0, "at half the load: {error}");
    for part in ["friction.grip.kinetic force", "break-away force of 5 N"] {
        assert!(error.to_string().contains(part), "{error}");
    }
    let mut bench = free("Grip")?.set("friction.grip.sliding", 10.0)?.start(0.0)?;
    bench.set("appliedForce", 11.0)?;
    bench.step(0.1)?;
    assert!(bench.get("velocity")? > 0.0);
    Ok(())
}

/// A run that it stops names the event and the law.
#[test]
fn event_that_repeats_without_end_is_named() -> Outcome {
    let mut bench = free("Unchecked")?.set("solver.maxStepsPerCommunicationStep", 2000.0)?.start(0.0)?;
    bench.set("appliedForce", 11.0)?;
    let error = bench.step(0.1).err().ok_or("a contact that cannot slide has moved")?.to_string();
    for part in ["events, the last of them stop (friction law Unchecked)", "repeat without end"] {
        assert!(error.contains(part), "{error}");
    }
    Ok(())
}

#[test]
#[should_panic(expected = "breaks away under 1.0000000")]
fn conformance_finds_friction_that_pushes_back() {
    law::yields::<catalogue::Friction>("Unchecked");
}

/// States are drawn where they have a meaning, and messages have their names.
#[test]
#[should_panic(expected = "Careless: the derivative of the friction force by careless.wear is 0 by dual numbers")]
fn conformance_names_the_state_of_a_lost_derivative() {
    law::derivatives::<catalogue::Friction>("Careless");
}

#[test]
#[should_panic(expected = "der(friction.careless.wear) on friction.careless.bristle")]
fn conformance_names_coupled_states_that_are_not_declared() {
    let moved = Setup::new(&BENCH).set("friction.law", "Careless").and_then(|setup| setup.set("driveVelocity", 1e-3));
    found_dependencies(&moved.expect("a velocity"));
}
