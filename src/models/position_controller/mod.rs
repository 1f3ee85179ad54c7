//! A sampled position controller for the cylinder: position loop, velocity loop, feed-forward and an inverse of the
//! valve's dead zone.
//!
//! At each sample, with the reference `r`, its velocity `r'`, the measured position `x` and velocity `v`:
//!
//! ```text
//! w = clamp(r' + k_x*(r - x), -w_max, w_max)          wanted velocity     [m/s]
//! u = k_f*w + k_v*(w - v) + I                         effective command   [V]
//! I = clamp(I + Ts*k_i*(w - v), -I_max, I_max)        held while u is beyond the range and the error leads further
//! V = V_0 + p*clamp(u', -R, R)                        valve voltage       [V]
//! u' = u*(1 - d) + d*R*sgn(u)                         with the valve's dead zone d, both signs joined by a line
//! ```
//!
//! The voltage is held until the next sample. It follows from the inputs one sample earlier,
//! as in a digital controller, so that the loop with the plant is not algebraic.

use std::any::TypeId;
use std::f64::consts::PI;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::co_simulation::{Direction, Simulation, Snapshot, SnapshotError};
use crate::model::{Course, Experiment, Functions, Model, Panel, Signal, Start};
use crate::numbers::{DIRECTIONS, Real, STILL, Scalar, Slopes, Tangent, Varying, sign};
use crate::sensitivity::{Along, Crossing, NoDerivative, Seed, Seeded, Varied, seeds};
use crate::solver::StepError;
use crate::system::{Held, LabelledNumber, Sample, StateLabel, labelled, plain, slopes_of, still, varied};
use crate::variables::{
    Condition, Meaning, ParameterError, ParameterSet, Table, Tunable, Variable, table_cache, units,
};
use crate::{enumeration, inputs, outputs, parameters};

/// The model as the library offers it.
pub const MODEL: Model = Model {
    name: "PositionController",
    description: "Sampled position controller for a pneumatic cylinder with a proportional valve",
    functions: Functions {
        table: || table_cache::lent(TypeId::of::<PositionController<Real>>(), make_table),
        shared_table: table,
        snapshot_size: 2 * size_of::<Memory<Real>>() + 64,
        indicators: Vec::new,
        start: |start| Ok(Box::new(PositionController::<Real>::new(start)?)),
        vary: |start| Ok(Box::new(PositionController::<Tangent>::new(start)?)),
    },
    experiment: Experiment {
        stop_time: 3.0,
        step_size: 1e-3,
        // A carriage that lags behind its reference by 20 ms; a velocity leads its position by a quarter of the period.
        signals: &[
            Signal {
                input: "referencePosition",
                text: "250 mm + 100 mm sin(π t/s)",
                course: Course::Sine { mean: 0.25, amplitude: 0.1, frequency: 0.5, delay: 0.0 },
            },
            Signal {
                input: "position",
                text: "position of a carriage 20 ms behind the reference",
                course: Course::Sine { mean: 0.25, amplitude: 0.1, frequency: 0.5, delay: 0.02 },
            },
            Signal {
                input: "velocity",
                text: "velocity of the same carriage",
                course: Course::Sine { mean: 0.0, amplitude: 0.1 * PI, frequency: 0.5, delay: 0.02 - 0.5 },
            },
        ],
        panels: &[
            Panel { label: "valve voltage", curves: &["valveVoltage"] },
            Panel { label: "position", curves: &["referencePosition", "position"] },
            Panel { label: "position error", curves: &["positionError"] },
        ],
    },
};

/// The table of the model.
fn table() -> Arc<Table> {
    table_cache::shared(TypeId::of::<PositionController<Real>>(), make_table)
}

fn make_table() -> Table {
    let mut table = vec![Variable::time()];
    table.extend(Inputs::table());
    table.extend(Outputs::<f64>::table());
    table.push(
        Variable::flag(201, "saturated").depends_on(&[]).text("True while the voltage is at an end of its range"),
    );
    table.push(Variable::counter(202, "samples").depends_on(&[]).text("Samples since initialization"));
    table.extend(Parameters::table());
    Table::new(table)
}

inputs! {
    #[doc(hidden)]
    /// The inputs.
    Inputs {
        reference = Variable::input(1, "referencePosition", units::METRE, 0.25).range(-1e3, 1e3).nominal(0.1).shown_in("mm")
            .text("Position that the carriage is to have");
        reference_velocity = Variable::input(2, "referenceVelocity", units::METRE_PER_SECOND, 0.0).counts_where(Condition::is("feedForward.source", &[Source::Input])).range(-1e3, 1e3).nominal(0.1).shown_in("mm/s")
            .text("Velocity of the reference");
        position = Variable::input(3, "position", units::METRE, 0.25).range(-1e3, 1e3).nominal(0.1).shown_in("mm")
            .text("Measured position of the carriage");
        velocity = Variable::input(4, "velocity", units::METRE_PER_SECOND, 0.0).range(-1e3, 1e3).nominal(0.1).shown_in("mm/s")
            .text("Measured velocity of the carriage");
    }
}

outputs! {
    #[doc(hidden)]
    /// The computed real variables, which keep the values of the last sample.
    Outputs {
        voltage = Variable::output(101, "valveVoltage", units::VOLT).nominal(1.0)
            .depends_on(&[]).text("Voltage for the valve; valve.neutral until the first sample");
        error = Variable::output(102, "positionError", units::METRE).nominal(1e-3).shown_in("mm")
            .depends_on(&[]).text("Reference less measured position at the last sample");
        wanted = Variable::output(103, "wantedVelocity", units::METRE_PER_SECOND).local().nominal(0.1).shown_in("mm/s")
            .depends_on(&[]).text("Set point of the velocity loop at the last sample");
        command = Variable::output(104, "command", units::VOLT).local().nominal(1.0)
            .depends_on(&[]).text("Voltage that an ideal valve would need, before its range and its dead zone are taken into account");
        integral = Variable::output(105, "integral", units::VOLT).local().nominal(1.0)
            .depends_on(&[]).text("Integral part of the command");
    }
}

enumeration! {
    #[doc(hidden)]
    /// Where the velocity of the reference comes from; ids are never reused.
    Source "FeedForwardSource": "Where the velocity of the reference comes from" {
        1 Difference: "Difference of the last two samples of referencePosition";
        2 Input: "The input referenceVelocity";
    }
}

parameters! {
    #[doc(hidden)]
    /// The parameters. The gains suit the cylinder with its default parameters.
    Parameters {
        sample_time: f64 = Variable::parameter(1001, "sampleTime", units::SECOND, 1e-3).range(1e-6, 10.0).plausible(1e-5, 0.2).shown_in("ms")
            .meaning(Meaning::Sampling)
            .text("Sample time");
        position_gain: Tunable = Variable::parameter(1002, "gain.position", units::PER_SECOND, 12.0).range(0.0, 1e6)
            .text("Wanted velocity per position error");
        velocity_gain: Tunable = Variable::parameter(1003, "gain.velocity", units::VOLT_SECOND_PER_METRE, 8.0).range(0.0, 1e6)
            .text("Command per velocity error");
        integral_gain: Tunable = Variable::parameter(1004, "gain.integral", units::VOLT_PER_METRE, 10.0).range(0.0, 1e6)
            .text("Rate of the integral part per velocity error");
        feed_forward: Tunable = Variable::parameter(1005, "feedForward.gain", units::VOLT_SECOND_PER_METRE, 1.6).range(0.0, 1e6)
            .text("Command per wanted velocity");
        source: Source = Variable::choice(1006, "feedForward.source", Source::Difference)
            .text("Where the velocity of the reference comes from");
        velocity_limit: Tunable = Variable::parameter(1007, "limit.velocity", units::METRE_PER_SECOND, 1.0).range(0.0, 1e3).plausible(1e-3, 20.0).shown_in("mm/s")
            .text("Largest wanted velocity");
        integral_limit: Tunable = Variable::parameter(1008, "limit.integral", units::VOLT, 2.0).range(0.0, 1e3)
            .text("Largest integral part");
        neutral: Tunable = Variable::parameter(1009, NEUTRAL, units::VOLT, 5.0).range(-1e3, 1e3)
            .text("Voltage at which the valve is closed");
        range: Tunable = Variable::parameter(1010, "valve.range", units::VOLT, 5.0).range(1e-3, 1e3)
            .text("Distance from the neutral voltage to either end of the range");
        dead_zone: Tunable = Variable::parameter(1011, "valve.deadZone", units::ONE, 0.08).range(0.0, 0.9)
            .text("Dead zone of the valve as a fraction of its range, which the controller inverts");
        transition: Tunable = Variable::parameter(1012, "valve.transition", units::VOLT, 0.1).range(0.0, 1e3)
            .text("Commands smaller than this cross the dead zone on a line; 0: by a jump");
        polarity: i32 = Variable::count(1013, "valve.polarity", 1).range(-1.0, 1.0)
            .text("1: more than the neutral voltage moves the carriage towards +x; -1: towards -x");
        max_samples: u64 = Variable::count(1014, "maxSamplesPerCommunicationStep", 1_000_000).range(1.0, f64::from(i32::MAX))
            .text("Bound on samples within one communication step; beyond it the step is discarded");
    }
}

impl Parameters {
    /// Parameters with these values, which vary with slopes or (without any) not at all.
    fn checked(values: &[f64], slopes: &[Slopes]) -> Result<Self, ParameterError> {
        let parameters = Self::read(&table().chosen(values, slopes))?;
        if parameters.polarity == 0 {
            return Err(ParameterError::new("valve.polarity", 0.0, "it must be 1 or -1"));
        }
        Ok(parameters)
    }

    /// Distance from the neutral voltage that gives a valve with the dead zone the opening that `command` gives one
    /// without; exact for commands from `transition` on.
    fn invert_dead_zone<S: Scalar>(&self, command: S) -> S {
        let [dead_zone, range, transition] = [self.dead_zone, self.range, self.transition].map(S::along);
        let is_small = command.value().abs() < transition.value();
        let side = if is_small { command / transition } else { S::of(sign(command.value())) };
        command * (S::of(1.0) - dead_zone) + side * (dead_zone * range)
    }

    /// The control law: the next discrete state, from a sample of inputs and the last one.
    fn sample<S: Scalar>(&self, input: &Inputs<S>, last: &mut Last<S>) -> Kinks<S> {
        let [integral_gain, range, transition] = [self.integral_gain, self.range, self.transition].map(S::along);
        let slope = match self.source {
            Source::Input => input.reference_velocity,
            Source::Difference => (input.reference - last.reference) / S::of(self.sample_time),
        };
        last.reference = input.reference;
        last.error = input.reference - input.position;
        let [wanted, velocity_limit] =
            [slope + last.error * S::along(self.position_gain), S::along(self.velocity_limit)];
        last.wanted = wanted.clamp(-velocity_limit, velocity_limit);
        let lack = last.wanted - input.velocity;
        last.command = last.wanted * S::along(self.feed_forward) + lack * S::along(self.velocity_gain) + last.integral;
        let inverted = self.invert_dead_zone(last.command);
        last.effort = inverted.clamp(-range, range);
        let is_within = last.effort.value() == inverted.value();
        let mut kinks = Kinks {
            wanted: left(wanted, velocity_limit),
            command: if self.dead_zone.value == 0.0 { S::of(1.0) } else { left(last.command, transition) },
            voltage: left(inverted, range),
            lack: if is_within { S::of(1.0) } else { lack },
            integral: S::of(1.0),
        };
        if is_within || lack.value() * inverted.value() < 0.0 {
            let integral = last.integral + S::of(self.sample_time) * integral_gain * lack;
            let integral_limit = S::along(self.integral_limit);
            last.integral = integral.clamp(-integral_limit, integral_limit);
            kinks.integral = left(integral, integral_limit);
        }
        kinks
    }

    /// Outputs of the controller.
    fn shown<S: Scalar>(&self, last: &Last<S>) -> Outputs<S> {
        Outputs {
            voltage: S::of(f64::from(self.polarity)) * last.effort + S::along(self.neutral),
            error: last.error,
            wanted: last.wanted,
            command: last.command,
            integral: last.integral,
        }
    }
}

/// Distances of a sample from the kinks of its formula: 0 exactly there.
struct Kinks<S> {
    /// The wanted velocity from its limit.
    wanted: S,
    /// The command from where the line across the dead zone ends.
    command: S,
    /// The voltage from an end of its range, where the integral part begins to be held.
    voltage: S,
    /// The lack of velocity from none, where that decides whether the integral part is held.
    lack: S,
    /// The integral part from its limit.
    integral: S,
}

/// Distance to the nearer limit, on either side of it.
fn left<S: Scalar>(number: S, limit: S) -> S {
    if number.value() < 0.0 { limit + number } else { limit - number }
}

/// The voltage at which the valve is closed, which the output voltage counts from.
const NEUTRAL: &str = "valve.neutral";

impl<S: Varying> Kinks<S> {
    /// Kink of the formula at which a sample lies exactly, if a direction leads away from there.
    fn limit(&self, direction: usize) -> Option<&'static str> {
        let &Self { wanted, command, voltage, lack, integral } = self;
        let named = [
            (wanted, "the wanted velocity just at its limit"),
            (command, "the command just at an end of the line across the dead zone"),
            (voltage, "the voltage just at an end of its range"),
            (lack, "no lack of velocity, with the voltage beyond its range"),
            (integral, "the integral part just at its limit"),
        ];
        let is_left = |left: &S| left.value() == 0.0 && left.slopes()[direction] != 0.0;
        named.into_iter().find(|(left, _)| is_left(left)).map(|(_, what)| what)
    }
}

/// The controller between two samples.
struct PositionController<S: Varying> {
    p: Parameters,
    time: f64,
    inputs: Held<{ Inputs::LEN }, S>,
    /// Slopes of the inputs, of numbers with slopes.
    seeds: [Slopes; Inputs::LEN],
    memory: Memory<S>,
    /// Where numbers with slopes have none any more.
    lost: [Option<NoDerivative>; DIRECTIONS],
}

/// Samples of the inputs.
#[derive(Clone, Serialize, Deserialize)]
#[serde(bound(serialize = "", deserialize = ""))]
struct Memory<S: Varying> {
    /// Time of the first sample in s.
    start: f64,
    /// Samples taken since.
    count: u64,
    last: Last<S>,
}

/// State after the last sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Last<S> {
    /// Reference in m.
    reference: S,
    error: S,
    wanted: S,
    command: S,
    integral: S,
    /// Distance from the neutral voltage in V, before polarity.
    effort: S,
}

impl<S: Varying> Last<S> {
    /// State before the first sample, under inputs.
    fn none(input: &Inputs<S>) -> Self {
        let none = S::zero();
        Self { reference: input.reference, error: none, wanted: none, command: none, integral: none, effort: none }
    }
}

impl<S: Varying> Memory<S> {
    fn is_finite(&self) -> bool {
        let Self { start, count: _, last: Last { reference, error, wanted, command, integral, effort } } = self;
        let of_sample = [reference, error, wanted, command, integral, effort];
        start.is_finite() && of_sample.iter().all(|number| number.value().is_finite())
    }
}

impl<S: Varying> PositionController<S> {
    fn new(start: &Start) -> Result<Self, ParameterError> {
        let p = Parameters::checked(start.parameters, start.seeds.parameters)?;
        let seeds: [Slopes; Inputs::LEN] =
            std::array::from_fn(|i| start.seeds.inputs.get(i).copied().unwrap_or_default());
        let values: [S; Inputs::LEN] = std::array::from_fn(|i| S::with(start.inputs[i], seeds[i]));
        let memory = Memory { start: start.time, count: 0, last: Last::none(&Inputs::read(&values)) };
        let inputs = Held::new(start.time, values, [0.0; Inputs::LEN]);
        Ok(Self { p, time: start.time, inputs, seeds, memory, lost: [const { None }; DIRECTIONS] })
    }

    fn next_sample(&self) -> Sample<Real> {
        Sample::periodic(
            Real::of(self.memory.start + self.memory.count as f64 * self.p.sample_time),
            self.p.sample_time,
        )
    }

    /// Takes the sample that is due.
    fn sample(&mut self) {
        let due = self.next_sample().time.value;
        self.time = self.time.max(due);
        let kinks = self.p.sample(&Inputs::read(&self.inputs.at(self.time)), &mut self.memory.last);
        self.memory.count += 1;
        if !S::VARIES {
            return;
        }
        for (direction, lost) in self.lost.iter_mut().enumerate().filter(|(_, lost)| lost.is_none()) {
            *lost = kinks.limit(direction).map(|what| NoDerivative {
                time: due,
                event: "a sample".to_owned(),
                reason: format!("it finds {what}"),
            });
        }
    }

    fn put_inputs(&mut self, values: &[f64], slopes: &[f64]) {
        let values = std::array::from_fn(|i| S::with(values[i], self.seeds[i]));
        self.inputs = Held::new(self.time, values, std::array::from_fn(|i| slopes[i]));
    }

    fn go(&mut self, end: f64) -> Result<(), StepError> {
        let limit = self.p.max_samples;
        let mut samples = 0;
        while self.next_sample().is_before(end) {
            if samples == limit {
                return Err(StepError::TooManySamples { time: self.time, limit });
            }
            self.sample();
            samples += 1;
        }
        self.time = end;
        Ok(())
    }

    fn show(&self) -> [S; Outputs::<f64>::LEN] {
        let mut shown = [S::zero(); Outputs::<f64>::LEN];
        self.p.shown(&self.memory.last).write(&mut shown);
        shown
    }
}

/// Discrete state of a saved controller.
fn saved(snapshot: &Snapshot) -> Result<Memory<Real>, SnapshotError> {
    let memory: Memory<Real> = postcard::from_bytes(&snapshot.memory).map_err(|_| SnapshotError::Unreadable)?;
    if !snapshot.states.is_empty() {
        return Err(SnapshotError::States { found: snapshot.states.len(), expected: 0 });
    }
    if !snapshot.time.is_finite() || !memory.is_finite() {
        return Err(SnapshotError::NotFinite);
    }
    Ok(memory)
}

/// Between samples, which are a formula within its limits, nothing moves. When samples are taken is no question of slopes: they
/// see the inputs of their communication point, however near it is.
impl Varied for PositionController<Tangent> {
    /// The controller has one mode.
    fn check_start(&mut self, _start: &Start) {}

    fn place(&mut self, snapshot: &Snapshot, seeds: &[Seed]) -> Result<(), SnapshotError> {
        let Memory { start, count, last } = saved(snapshot)?;
        let seeded = Seeded::new(seeds);
        let last = varied(&last, |place| seeded.memory(place));
        (self.time, self.memory, self.lost) =
            (snapshot.time, Memory { start, count, last }, [const { None }; DIRECTIONS]);
        self.seeds = std::array::from_fn(|i| seeded.input(i));
        Ok(())
    }

    fn reseed(&mut self, _states: &[f64], along: &[Along], _moved: Option<&dyn Varied>) {
        self.memory.last = still(&self.memory.last);
        self.lost = [const { None }; DIRECTIONS];
        self.seeds = std::array::from_fn(|i| seeds(along, Along::Input(i)));
    }

    /// Its slopes are formulas, and are there.
    fn be_silent(&mut self) {}

    fn save(&self) -> Snapshot {
        Snapshot { time: self.time, states: Vec::new(), memory: plain(&self.memory) }
    }

    fn set_inputs(&mut self, values: &[f64], slopes: &[f64]) {
        self.put_inputs(values, slopes);
    }

    fn advance(&mut self, end: f64) -> Result<(), StepError> {
        self.go(end)
    }

    fn step(&mut self, size: f64) -> Result<(), StepError> {
        self.go(self.time + size)
    }

    fn outputs(&self, computed: &mut [Tangent]) -> [Option<NoDerivative>; DIRECTIONS] {
        computed.iter_mut().zip(self.show()).for_each(|(slot, number)| *slot = number);
        self.lost.clone()
    }

    fn state(&self, _state: usize) -> Slopes {
        STILL
    }

    fn states(&self, _states: &mut [Tangent]) {}

    fn memory(&self) -> Vec<LabelledNumber> {
        labelled(&self.memory.last, |_| StateLabel::Fields)
    }

    fn memory_slopes(&self) -> Vec<Slopes> {
        slopes_of(&self.memory.last)
    }

    fn crossings(&self) -> Vec<Crossing> {
        Vec::new()
    }

    fn lost(&self, direction: usize) -> Option<&NoDerivative> {
        self.lost[direction].as_ref()
    }
}

impl Simulation for PositionController<Real> {
    fn time(&self) -> f64 {
        self.time
    }

    #[cfg(feature = "sensitivities")]
    fn memory_numbers(&self) -> Vec<LabelledNumber> {
        labelled(&self.memory.last, |_| StateLabel::Fields)
    }

    fn set_inputs(&mut self, values: &[f64], slopes: &[f64]) {
        self.put_inputs(values, slopes);
    }

    fn retune(&mut self, parameters: &[f64]) -> Result<(), ParameterError> {
        self.p = Parameters::checked(parameters, &[])?;
        Ok(())
    }

    fn advance(&mut self, end: f64) -> Result<(), StepError> {
        self.go(end)
    }

    fn is_finite(&self) -> bool {
        self.memory.is_finite()
    }

    fn values(&self, computed: &mut [f64]) {
        let saturated = f64::from(self.memory.last.effort.value.abs() == self.p.range.value);
        // FMI integers have 32 bits; a run that exceeds them shows the largest.
        let samples = f64::from(i32::try_from(self.memory.count).unwrap_or(i32::MAX));
        let shown = self.show().map(Real::value);
        let (own, rest) = computed.split_at_mut(shown.len());
        own.copy_from_slice(&shown);
        rest.copy_from_slice(&[saturated, samples]);
    }

    /// Between samples nothing moves.
    fn rates(&self, computed: &mut [f64]) {
        computed.fill(0.0);
    }

    /// Between samples nothing reacts but the voltage, which is shown from the neutral one on.
    fn directional_derivative(&self, direction: Direction, computed: &mut [f64]) {
        computed.fill(0.0);
        let table = table();
        let places = table.parameters().zip(direction.parameters);
        let neutral = places.filter(|(variable, _)| variable.name == NEUTRAL).map(|(_, slope)| slope);
        let [voltage, ..] = computed else { return };
        *voltage = neutral.sum();
    }

    fn save(&self) -> Snapshot {
        Snapshot {
            time: self.time,
            states: Vec::new(),
            memory: postcard::to_allocvec(&self.memory).expect("a memory holds plain data"),
        }
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let memory = saved(snapshot)?;
        (self.time, self.memory) = (snapshot.time, memory);
        Ok(())
    }
}
