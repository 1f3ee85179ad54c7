//! A small model for the tests of this room: a first-order lag with a closed form, and traps.

use std::sync::{Arc, LazyLock};

use serde::{Deserialize, Serialize};

use super::layout::{Base, Layout};
use super::log::Log;
use super::{Instance, Kind};
use crate::failure::Failure;
use pneumatic_servo::co_simulation::{Direction, Simulation, Snapshot, SnapshotError};
use pneumatic_servo::enumeration;
use pneumatic_servo::model::{Experiment, Functions, Model, Start};
use pneumatic_servo::solver::StepError;
use pneumatic_servo::variables::{Choice, ParameterError, Role, Table, Variable, units};

pub const INPUT: u32 = 1;
pub const SUPPLY: u32 = 2;
pub const LAG: u32 = 10;
pub const LOW: u32 = 11;
pub const HIGH: u32 = 12;
pub const TRAP: u32 = 13;
pub const STATE: u32 = 20;
pub const RATE: u32 = 21;
pub const OUTPUT: u32 = 22;
pub const POSITIVE: u32 = 23;
pub const STEPS: u32 = 24;

/// `dx/dt = (input - x)/lag`, `output = x + 2 input + supply + high`, `low <= high`.
pub const MODEL: Model = Model {
    name: "Lag",
    description: "A first-order lag",
    functions: Functions {
        table: || &TABLE,
        shared_table: || Arc::new(make_table()),
        snapshot_size: 64,
        indicators: Vec::new,
        start: |start| Ok(Box::new(Lag::new(start)?)),
        vary: |_| Err(ParameterError::new("slopes", 0.0, "this model has none")),
    },
    experiment: Experiment { stop_time: 1.0, step_size: 0.1, signals: &[], panels: &[] },
};

enumeration! {
    /// Kind of failure.
    Trap "Trap": "What goes wrong" {
        0 Nothing: "Nothing";
        1 StopsHalfway: "Steps fail in their middle";
        2 Panics: "Steps panic";
        3 YieldsNan: "Steps end with a state that is no number";
    }
}

static TABLE: LazyLock<Table> = LazyLock::new(make_table);

fn make_table() -> Table {
    Table::new(vec![
        Variable { role: Role::Time, ..Variable::output(0, "time", units::SECOND) },
        Variable::input(INPUT, "input", units::ONE, 1.0),
        Variable::input(SUPPLY, "supply", units::PASCAL, 0.0).at_least(0.0),
        Variable::output(STATE, "state", units::ONE),
        Variable::output(RATE, "der(state)", units::PER_SECOND).local().derivative_of(STATE),
        Variable::output(OUTPUT, "output", units::ONE),
        Variable::flag(POSITIVE, "positive"),
        Variable::counter(STEPS, "steps"),
        Variable::parameter(LAG, "lag", units::SECOND, 0.5).range(1e-3, 1e3),
        Variable::parameter(LOW, "low", units::ONE, 1.0).tunable(),
        Variable::parameter(HIGH, "high", units::ONE, 2.0).tunable(),
        Variable::choice(TRAP, "trap", Trap::Nothing),
    ])
}

/// A silent instance.
pub fn instance() -> Instance {
    Instance::new(layout(), Kind::CoSimulation, Log::new(Box::new(|_, _, _| ()), true))
}

/// The value of a real variable.
pub fn real(instance: &mut Instance, reference: u32) -> Result<f64, Failure> {
    Ok(instance.get(Base::Real, [reference].into_iter())?[0])
}

/// The layout of the model.
pub fn layout() -> Arc<Layout> {
    static LAYOUT: LazyLock<Arc<Layout>> = LazyLock::new(|| Arc::new(Layout::new(&MODEL, None)));
    LAYOUT.clone()
}

struct Lag {
    time: f64,
    state: f64,
    inputs: [f64; 2],
    slopes: [f64; 2],
    parameters: [f64; 4],
    memory: Memory,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Memory {
    steps: u64,
}

impl Lag {
    fn new(start: &Start) -> Result<Self, ParameterError> {
        let inputs: [f64; 2] = start.inputs.try_into().expect("two inputs");
        let parameters = checked(start.parameters)?;
        Ok(Self { time: start.time, state: 0.0, inputs, slopes: [0.0; 2], parameters, memory: Memory { steps: 0 } })
    }

    fn trap(&self) -> Trap {
        Trap::from_id(self.parameters[3]).expect("a legal parameter")
    }

    fn rate(&self) -> f64 {
        (self.inputs[0] - self.state) / self.parameters[0]
    }

    fn output(&self) -> f64 {
        self.state + 2.0 * self.inputs[0] + self.inputs[1] + self.parameters[2]
    }
}

fn checked(parameters: &[f64]) -> Result<[f64; 4], ParameterError> {
    let chosen = MODEL.table().chosen(parameters, &[]);
    let parameters: [f64; 4] = std::array::from_fn(|place| chosen[place].value);
    if parameters[1] > parameters[2] {
        return Err(ParameterError::new("low", parameters[1], "it must not exceed high"));
    }
    Ok(parameters)
}

impl Simulation for Lag {
    fn time(&self) -> f64 {
        self.time
    }

    fn set_inputs(&mut self, values: &[f64], slopes: &[f64]) {
        self.inputs.copy_from_slice(values);
        self.slopes.copy_from_slice(slopes);
    }

    fn retune(&mut self, parameters: &[f64]) -> Result<(), ParameterError> {
        self.parameters = checked(parameters)?;
        Ok(())
    }

    fn advance(&mut self, end: f64) -> Result<(), StepError> {
        let duration = match self.trap() {
            Trap::StopsHalfway => 0.5 * (end - self.time),
            Trap::Panics => panic!("a provoked panic with 100 % s"),
            _ => end - self.time,
        };
        // x = u - m*lag + (x0 - u0 + m*lag)*exp(-t/lag) for u = u0 + m*t
        let ([u0, _], [m, _], lag) = (self.inputs, self.slopes, self.parameters[0]);
        let decay = libm::exp(-duration / lag);
        self.state = u0 + m * (duration - lag) + (self.state - u0 + m * lag) * decay;
        for (input, slope) in self.inputs.iter_mut().zip(self.slopes) {
            *input += slope * duration;
        }
        self.memory.steps += 1;
        match self.trap() {
            Trap::StopsHalfway => {
                self.time += duration;
                return Err(StepError::TooManySteps { time: self.time, limit: 1, events: 0, event: "", variant: "" });
            }
            Trap::YieldsNan => self.state = f64::NAN,
            _ => (),
        }
        self.time = end;
        Ok(())
    }

    fn is_finite(&self) -> bool {
        self.state.is_finite()
    }

    fn values(&self, computed: &mut [f64]) {
        let positive = f64::from(self.state > 0.0);
        computed.copy_from_slice(&[self.state, self.rate(), self.output(), positive, self.memory.steps as f64]);
    }

    fn rates(&self, computed: &mut [f64]) {
        let rate = self.rate();
        let second = (self.slopes[0] - rate) / self.parameters[0];
        computed.copy_from_slice(&[rate, second, rate + 2.0 * self.slopes[0] + self.slopes[1], 0.0, 0.0]);
    }

    fn directional_derivative(&self, direction: Direction, computed: &mut [f64]) {
        let Direction { inputs, states, parameters, .. } = direction;
        let rate = (inputs[0] - states[0]) / self.parameters[0];
        let output = states[0] + 2.0 * inputs[0] + inputs[1] + parameters[2];
        computed.copy_from_slice(&[states[0], rate, output, 0.0, 0.0]);
    }

    fn save(&self) -> Snapshot {
        Snapshot {
            time: self.time,
            states: vec![self.state],
            memory: postcard::to_allocvec(&self.memory).expect("plain data"),
        }
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let [state] = snapshot.states[..] else { return Err(SnapshotError::Lengths) };
        let memory = postcard::from_bytes(&snapshot.memory).map_err(|_| SnapshotError::Unreadable)?;
        (self.time, self.state, self.memory) = (snapshot.time, state, memory);
        Ok(())
    }
}
