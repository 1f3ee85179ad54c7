//! Two blocks on a beam, each under friction, coupled by a spring and pulled by another one: stick-slip that one block hands on to
//! the other.
//!
//! ```text
//! pull_1 = k*(x_2 - x_1),   pull_2 = k*(s - x_2),   ds/dt = u            [N], u the velocity of the drive
//! m*dv_i/dt = F_app,i - F_f,i,   F_app,i = pull_i - pull_(i-1)
//! ```
//!
//! The model shows the parts for contacts of your own: states in rows, a memory, indicators and events for each contact.
//!
//! # Source
//! Burridge, Knopoff (1967), Bulletin of the Seismological Society of America 57(3):341-371: blocks and springs as a model of
//! earthquakes.

#![forbid(unsafe_code)]

use pneumatic_servo::friction::Event as ContactEvent;
use pneumatic_servo::prelude::*;

laws! {
    /// The laws that a block may have. A list of few is compiled sooner than all of the library.
    pub mod catalogue {
        1007 Stribeck "stribeck" builtin::stribeck_law::Stribeck, "Stribeck curve with true stiction";
        1014 LuGre "lugre" OneBristle<builtin::lugre::LuGre>, "Bristle with presliding, Stribeck effect and frictional lag";
        1016 GMS "gms" builtin::gms::Gms, "Maxwell-slip elements with Stribeck effect and frictional lag";
    }
}

use catalogue::Friction;

/// Number of blocks.
const BLOCKS: usize = 2;

/// The largest number of states of a law in a contact: 4, as GMS has by default. Each more costs time in all runs.
const ROOM: usize = 4;

/// Value reference from which the states of the contact of a block count.
const fn contact(block: usize) -> u32 {
    460 + 40 * block as u32
}

states! {
    /// The states of the model itself. Friction states come before them.
    State of Parameters {
        Drive: 100, |_| 1e-3;
        Position[2 step 10]: 101, |_| 1e-4;
        Velocity[2 step 10]: 102, |_| 1e-2;
    }
}

inputs! {
    /// The input.
    Inputs {
        velocity = Variable::input(1, "driveVelocity", units::METRE_PER_SECOND, 0.02).nominal(1e-2).text("Velocity of the drive");
    }
}

/// A variable of a block.
fn of_block(reference: u32, block: u32, name: &str, unit: Unit) -> Variable {
    Variable::output(reference + 10 * block, &format!("block[{}].{name}", block + 1), unit)
}

outputs! {
    /// The computed variables.
    Outputs {
        drive = Variable::output(100, "drive", units::METRE).nominal(1e-3).depends_on(&[100]).text("Position of the drive");
        rate = Variable::output(99, "der(drive)", units::METRE_PER_SECOND).local().nominal(1e-3).derivative_of(100)
            .depends_on(&[1]).text("Its velocity");
        positions[2] = |i| of_block(101, i, "position", units::METRE).nominal(1e-3).depends_on(&[101 + 10 * i]).text("Position");
        // What depends on a mode and on many states says nothing, and then depends on all.
        velocities[2] = |i| of_block(102, i, "velocity", units::METRE_PER_SECOND).nominal(1e-2).derivative_of(101 + 10 * i)
            .depends_on(&[102 + 10 * i]).text("Velocity, exactly 0 while a set-valued law holds the block");
        accelerations[2] = |i| of_block(103, i, "acceleration", units::METRE_PER_SECOND_SQUARED).nominal(1.0)
            .derivative_of(102 + 10 * i).text("Acceleration");
        forces[2] = |i| of_block(104, i, "frictionForce", units::NEWTON).nominal(10.0).text("Friction force");
    }
}

parameters! {
    /// The parameters.
    Parameters {
        mass: Fixed = Variable::parameter(1001, "mass", units::KILOGRAM, 1.0).range(1e-3, 1e3).text("Mass of a block");
        stiffness: Fixed = Variable::parameter(1002, "stiffness", units::NEWTON_PER_METRE, 5e3).range(1.0, 1e7).text("Stiffness of a spring");
    }
}

/// The parameters of the model, and of the law of all contacts.
type All = (Parameters, ContactLaw<Friction, 1007>);

/// The equations for given parameters.
#[derive(Clone, Debug)]
pub struct Row {
    p: Parameters,
    contacts: [FrictionContact<Friction>; BLOCKS],
}

/// The memory of a law, for each contact.
type Memories<S> = [catalogue::Memory<S>; BLOCKS];

impl Row {
    /// A contact as its law sees it.
    fn contact<S: Scalar, const N: usize>(&self, time: S, x: &[S; N], block: usize) -> Contact<S> {
        let place = |block: usize| State::Position.get(block).map_or_else(|| State::Drive.get(x), |it| it.get(x));
        let pull = |block: usize| self.p.stiffness * (place(block + 1) - place(block));
        let before = if block == 0 { S::zero() } else { pull(block - 1) };
        let (position, velocity) = (State::Position[block].get(x), State::Velocity[block].get(x));
        Contact {
            time,
            position,
            velocity,
            applied: pull(block) - before,
            level: S::constant(1.0),
            drive: Drive::Force,
        }
    }
}

holds! {
    [] Row, 1; |row, time, x, u, memory|
    contacts: [FrictionContact<Friction>; BLOCKS], "block[].friction", *memory,
    std::array::from_fn(|block| Some(row.contact(time, x, block)));
}

impl System<1> for Row {
    type Parameters = Parameters;
    type State = State;
    type Memory<S: Varying> = Memories<S>;
    type Indicators<S: Varying> = [S; BLOCKS * ContactEvent::COUNT];

    fn tables() -> Tables {
        let mut computed = Outputs::<f64>::table();
        for block in 0..BLOCKS {
            let group = format!("block[{}].friction", block + 1);
            let sliding = State::Velocity[block].reference();
            computed.extend(FrictionContact::<Friction>::variables(&group, contact(block), &[sliding]));
        }
        Tables { inputs: Inputs::table(), computed, parameters: All::table() }
    }

    fn new(values: &mut Values) -> Result<Self, ParameterError> {
        let (p, ContactLaw(law)): All = values.read()?;
        if law.states() > ROOM {
            let reason = format!("the friction law may have {ROOM}");
            return Err(ParameterError::new("states", law.states() as f64, &reason));
        }
        let held = |block: usize| {
            FrictionContact::new(
                law.clone(),
                Drive::Force,
                block * ROOM,
                State::Velocity[block].index(),
                contact(block),
            )
        };
        Ok(Self { p, contacts: std::array::from_fn(held) })
    }

    fn parameters(&self) -> &Parameters {
        &self.p
    }

    fn parts() -> impl Holds<Self, 1> {
        Holder
    }

    fn states(&self) -> usize {
        BLOCKS * ROOM + State::OTHERS
    }

    fn start<S: Varying, const N: usize>(&self, _u: &[S; 1]) -> ([S; N], Memories<S>) {
        let mut x = [S::zero(); N];
        let memory = std::array::from_fn(|block| {
            let contact = self.contact(S::zero(), &x, block);
            self.contacts[block].start(&contact, &mut x)
        });
        (x, memory)
    }

    fn derivatives<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; 1],
        memory: &Memories<S::Held>,
    ) -> [S; N] {
        let mut rates = [S::zero(); N];
        State::Drive.set(&mut rates, Inputs::read(u).velocity);
        for (block, memory) in memory.iter().enumerate() {
            let (contact, held) = (self.contact(time, x, block), &self.contacts[block]);
            let force = held.force(&contact, x, memory, &mut rates);
            State::Position[block].set(&mut rates, held.rate(contact.velocity, memory));
            State::Velocity[block].set(&mut rates, (contact.applied - force) / self.p.mass);
        }
        rates
    }

    fn outputs<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; 1],
        memory: &Memories<S::Held>,
        computed: &mut [S],
    ) {
        let contacts: [Contact<S>; BLOCKS] = std::array::from_fn(|block| self.contact(time, x, block));
        let shown: [_; BLOCKS] =
            std::array::from_fn(|block| self.contacts[block].observe(&contacts[block], x, &memory[block]));
        let outputs = Outputs {
            drive: State::Drive.get(x),
            rate: Inputs::read(u).velocity,
            positions: State::Position.map(|position| position.get(x)),
            velocities: std::array::from_fn(|block| {
                self.contacts[block].rate(contacts[block].velocity, &memory[block])
            }),
            accelerations: std::array::from_fn(|block| {
                shown[block].unless_held((contacts[block].applied - shown[block].force) / self.p.mass)
            }),
            forces: std::array::from_fn(|block| shown[block].force),
        };
        let mut slots = outputs.write(computed);
        for contact in &shown {
            slots = contact.write(slots);
        }
    }
}

/// The model, with room for all states.
pub const MODEL: Model = Model::of::<Row, 1, { BLOCKS * ROOM + State::OTHERS }>(
    "BlocksOnABeam",
    "Two blocks on a beam, coupled by springs, each under friction",
    Experiment {
        stop_time: 5.0,
        step_size: 1e-3,
        signals: &[Signal { input: "driveVelocity", text: "20 mm/s", course: Course::Steps(&[(0.0, 0.02)]) }],
        panels: &[
            Panel { label: "position", curves: &["drive", "block[2].position", "block[1].position"] },
            Panel { label: "friction force", curves: &["block[2].frictionForce", "block[1].frictionForce"] },
        ],
    },
);
