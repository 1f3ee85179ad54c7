//! Drives a model by the names of its variables, without FMI.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::fmt::Debug;

use pneumatic_servo::co_simulation::Simulation;
use pneumatic_servo::model::{Model, Seeds, Start};
use pneumatic_servo::models;
use pneumatic_servo::solver::StepError;
use pneumatic_servo::variables::{Kind, ParameterError, Role, Variable};
use serde::Deserialize;

/// Value of a variable in a file: a number, a switch, or an item of its enumeration.
#[derive(Deserialize)]
#[serde(untagged)]
pub enum Value {
    Number(f64),
    Switch(bool),
    Item(String),
}

/// A model with its parameters and inputs, ready to start.
#[derive(Clone)]
pub struct Rig {
    model: &'static Model,
    parameters: Vec<f64>,
    inputs: Vec<f64>,
}

/// A started model.
pub struct Running {
    simulation: Box<dyn Simulation>,
    model: &'static Model,
    inputs: Vec<f64>,
    computed: Vec<f64>,
    places: HashMap<&'static str, usize>,
}

fn variables(model: &Model, of: impl Fn(&Variable) -> bool) -> Vec<&'static Variable> {
    model.table().iter().filter(|variable| of(variable)).collect()
}

fn is_input(variable: &Variable) -> bool {
    variable.role == Role::Input
}

impl Rig {
    /// The model of that name with all defaults.
    pub fn new(model: &str) -> Self {
        let model = models::ALL.iter().find(|candidate| candidate.name == model).expect("a known model");
        let starts = |of: fn(&Variable) -> bool| {
            variables(model, of).iter().map(|variable| variable.start.expect("a start value")).collect()
        };
        Self { model, parameters: starts(Variable::is_parameter), inputs: starts(is_input) }
    }

    /// The cylinder with a friction law.
    pub fn cylinder(law: &str) -> Self {
        Self::new("PneumaticServoCylinder").choose("friction.law", law)
    }

    /// The friction bench with a friction law and a drive.
    pub fn bench(law: &str, drive: &str) -> Self {
        Self::new("FrictionBench").choose("friction.law", law).choose("bench.drive", drive)
    }

    /// With a parameter or the start value of an input changed.
    pub fn set(mut self, name: &str, value: f64) -> Self {
        let place = |of: fn(&Variable) -> bool| variables(self.model, of).iter().position(|v| v.name == name);
        if let Some(place) = place(Variable::is_parameter) {
            self.parameters[place] = value;
        } else {
            let place = place(is_input).unwrap_or_else(|| panic!("{name} is no parameter or input"));
            self.inputs[place] = value;
        }
        self
    }

    /// With an item of an enumeration chosen by its name.
    pub fn choose(self, name: &str, item: &str) -> Self {
        let variable = variables(self.model, |v| v.name == name)[0];
        let Kind::Enumeration(of) = variable.kind else { panic!("{name} is no enumeration") };
        let (id, ..) = of.items.iter().find(|(_, candidate, _)| *candidate == item).expect("an item");
        self.set(name, f64::from(*id))
    }

    /// With what a file says of variables.
    pub fn with<'a>(self, values: impl IntoIterator<Item = (&'a String, &'a Value)>) -> Self {
        values.into_iter().fold(self, |rig, (name, value)| match value {
            Value::Number(value) => rig.set(name, *value),
            Value::Switch(is_on) => rig.set(name, f64::from(*is_on)),
            Value::Item(item) => rig.choose(name, item),
        })
    }

    /// Runs a cylinder under sines about the closed valve: no run ends early.
    pub fn run_through_reversals(&self, at: &impl Debug) {
        for (amplitude, frequency) in [(1.0, 1.0), (2.0, 5.0), (3.0, 1.0)] {
            let mut running = self.start().unwrap();
            for step in 0..500 {
                let time = f64::from(step) * 1e-3;
                running.set("valveVoltage", 5.0 + amplitude * (TAU * frequency * time).sin());
                let end = running.advance(time + 1e-3);
                end.unwrap_or_else(|error| panic!("{at:?}, {amplitude} V, {frequency} Hz: {error}"));
            }
        }
    }

    /// Starts at time 0.
    pub fn start(&self) -> Result<Running, ParameterError> {
        let start = Start {
            time: 0.0,
            parameters: &self.parameters,
            inputs: &self.inputs,
            tolerance: None,
            seeds: Seeds::NONE,
        };
        let computed = variables(self.model, Variable::is_computed);
        Ok(Running {
            simulation: (self.model.functions.start)(&start)?,
            model: self.model,
            inputs: self.inputs.clone(),
            places: computed.iter().enumerate().map(|(place, variable)| (variable.name.as_str(), place)).collect(),
            computed: vec![0.0; computed.len()],
        })
    }
}

/// Advances in equal intervals up to an end, and calls `look` with the time after each.
pub fn watch(run: &mut Running, end: f64, interval: f64, mut look: impl FnMut(f64, &mut Running)) {
    let start = run.simulation().time();
    for step in 1..=((end - start) / interval).round() as usize {
        let time = start + step as f64 * interval;
        run.advance(time).expect("a step that ends");
        look(time, run);
    }
}

impl Running {
    /// Sets an input from now on.
    pub fn set(&mut self, name: &str, value: f64) {
        let place = variables(self.model, is_input).iter().position(|v| v.name == name).expect("an input");
        self.inputs[place] = value;
        let slopes = vec![0.0; self.inputs.len()];
        self.simulation.set_inputs(&self.inputs, &slopes);
    }

    /// Sets an input that rises by a slope per second from now on.
    pub fn ramp(&mut self, name: &str, value: f64, slope: f64) {
        let place = variables(self.model, is_input).iter().position(|v| v.name == name).expect("an input");
        self.inputs[place] = value;
        let mut slopes = vec![0.0; self.inputs.len()];
        slopes[place] = slope;
        self.simulation.set_inputs(&self.inputs, &slopes);
    }

    /// Sets inputs that rise by slopes per second from now on, and nothing else does.
    pub fn ramp_all(&mut self, ramps: &[(&str, f64, f64)]) {
        let mut slopes = vec![0.0; self.inputs.len()];
        for (name, value, slope) in ramps {
            let place = variables(self.model, is_input).iter().position(|v| v.name == *name).expect("an input");
            (self.inputs[place], slopes[place]) = (*value, *slope);
        }
        self.simulation.set_inputs(&self.inputs, &slopes);
    }

    /// Integrates to a time in s.
    pub fn advance(&mut self, end: f64) -> Result<(), StepError> {
        self.simulation.advance(end)
    }

    /// A computed variable now.
    pub fn get(&mut self, name: &str) -> f64 {
        self.simulation.values(&mut self.computed);
        self.computed[*self.places.get(name).unwrap_or_else(|| panic!("{name} is not computed"))]
    }

    /// Work in J that friction takes on each of four paths of a cylinder under an imposed motion: sines of an amplitude in m about the
    /// middle of the stroke, at 5 Hz.
    pub fn work_of_closed_paths(&mut self, amplitude: f64) -> [f64; 4] {
        let (frequency, steps) = (5.0, 400);
        let (mut work, mut before) = ([0.0; 4], [self.get("position"), self.get("frictionForce")]);
        for step in 1..=4 * steps {
            let time = f64::from(step - 1) / (frequency * f64::from(steps));
            let [phase, rate] = [TAU * frequency * time, TAU * frequency];
            self.set("imposedPosition", 0.25 + amplitude * phase.sin());
            let [velocity, slope] = [amplitude * rate * phase.cos(), -amplitude * rate * rate * phase.sin()];
            self.ramp("imposedVelocity", velocity, slope);
            self.advance(f64::from(step) / (frequency * f64::from(steps))).unwrap();
            let now = [self.get("position"), self.get("frictionForce")];
            work[(step - 1) as usize / steps as usize] += 0.5 * (now[1] + before[1]) * (now[0] - before[0]);
            before = now;
        }
        work
    }

    /// The simulation itself.
    pub fn simulation(&mut self) -> &mut dyn Simulation {
        self.simulation.as_mut()
    }
}
