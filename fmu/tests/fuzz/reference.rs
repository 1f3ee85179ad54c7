//! A reference instance without the C interface.

use std::ffi::{c_int, c_void};

use pneumatic_servo::co_simulation::{Direction, Simulation, Snapshot};
use pneumatic_servo::model::{Seeds, Start};
use pneumatic_servo::variables::{Chosen, Kind, Role, Variable};

use crate::common::{DISCARD, ERROR, Instance, OK, is_input, is_real, is_real_input};
use crate::{MODEL, SOLVER_STEPS, limit, variables};

/// Expected state of the instance.
#[derive(Clone)]
pub struct Expected {
    pub state: char,
    pub start: f64,
    pub stop: Option<f64>,
    pub tolerance: Option<f64>,
    pub parameters: Vec<f64>,
    pub inputs: Vec<f64>,
    pub slopes: Vec<f64>,
    pub failed: bool,
    pub successful_until: f64,
}

impl Expected {
    pub fn new() -> Self {
        let starts = |of: fn(&Variable) -> bool| -> Vec<f64> {
            variables().iter().filter(|variable| of(variable)).filter_map(|variable| variable.start).collect()
        };
        let inputs = starts(is_input);
        Self {
            state: 'I',
            start: 0.0,
            stop: None,
            tolerance: None,
            parameters: starts(Variable::is_parameter),
            slopes: vec![0.0; inputs.len()],
            inputs,
            failed: false,
            successful_until: 0.0,
        }
    }

    pub fn simulation(&self) -> Option<Box<dyn Simulation>> {
        let (time, tolerance) = (self.start, self.tolerance);
        let start = Start { time, parameters: &self.parameters, inputs: &self.inputs, tolerance, seeds: Seeds::NONE };
        let mut simulation = (MODEL.get().functions.start)(&start).ok()?;
        simulation.set_inputs(&self.inputs, &self.slopes);
        Some(simulation)
    }

    pub fn runs(&self) -> bool {
        "CFT".contains(self.state)
    }
}

/// An instance, what it should be, and its saved states with what they should be.
pub struct Pair {
    pub instance: Instance,
    pub expected: Expected,
    pub simulation: Option<Box<dyn Simulation>>,
    pub saved: Vec<(*mut c_void, Expected, Option<Snapshot>)>,
}

/// The index of a variable within its kind.
pub fn place(variable: &Variable, of: impl Fn(&Variable) -> bool) -> usize {
    let mut group = variables().iter().filter(|other| of(other));
    group.position(|other| other.reference == variable.reference).expect("a variable of the kind")
}

pub fn find(reference: u32) -> Option<&'static Variable> {
    variables().iter().find(|variable| variable.reference == reference)
}

pub fn is_computed_real(variable: &Variable) -> bool {
    variable.is_computed() && is_real(variable)
}

impl Pair {
    pub fn new() -> Self {
        let instance = Instance::of(MODEL.get());
        let mut pair = Self { instance, expected: Expected::new(), simulation: None, saved: Vec::new() };
        pair.limit_steps();
        pair
    }

    pub fn limit_steps(&mut self) {
        let limit = limit();
        assert_eq!(self.instance.set_integer(&[limit.reference], &[SOLVER_STEPS]), OK);
        self.expected.parameters[place(limit, Variable::is_parameter)] = SOLVER_STEPS.into();
    }

    pub fn time(&self) -> f64 {
        match &self.simulation {
            Some(simulation) if self.expected.runs() => simulation.time(),
            _ => self.expected.start,
        }
    }

    /// The computed values, if there are any.
    pub fn computed(&mut self) -> Option<Vec<f64>> {
        let mut computed = vec![f64::NAN; variables().iter().filter(|variable| variable.is_computed()).count()];
        match self.expected.state {
            'I' => return None,
            'M' => self.expected.simulation()?.values(&mut computed),
            _ => {
                let simulation = self.simulation.as_mut().expect("a running simulation");
                simulation.set_inputs(&self.expected.inputs, &self.expected.slopes);
                simulation.values(&mut computed);
            }
        }
        Some(computed)
    }

    /// The value of a variable, if it can be read.
    pub fn value(&mut self, variable: &Variable) -> Option<f64> {
        let value = match variable.role {
            Role::Time => self.time(),
            Role::Input => self.expected.inputs[place(variable, is_input)],
            Role::Fixed | Role::Tunable => {
                MODEL.get().table().in_use(place(variable, Variable::is_parameter), &self.expected.parameters)
            }
            Role::Output | Role::Local => self.computed()?[place(variable, Variable::is_computed)],
        };
        value.is_finite().then_some(value)
    }

    /// Whether a value is what a fixed parameter has, or is in use for it, once it can no longer change.
    fn keeps(&self, variable: &Variable, value: f64) -> bool {
        if variable.role != Role::Fixed || self.expected.state != 'C' {
            return false;
        }
        let (place, parameters) = (place(variable, Variable::is_parameter), &self.expected.parameters);
        let kept = [parameters[place], MODEL.get().table().in_use(place, parameters)];
        kept.map(f64::to_bits).contains(&value.to_bits())
    }

    pub fn can_set(&self, variable: &Variable, value: f64) -> bool {
        let states = match variable.role {
            Role::Input | Role::Tunable => "IMC",
            Role::Fixed => "IM",
            // The start value of a state in the description may be set again.
            _ if MODEL.get().default_starts().expect("defaults that fit").get(&variable.reference) == Some(&value) => {
                "I"
            }
            _ => "",
        };
        let item = match (variable.kind, variable.chooses) {
            (Kind::Enumeration(of), _) => of.has(value),
            (_, Some(Chosen { of, .. })) => value == 0.0 || of.has(value),
            (Kind::Boolean, _) => value == 0.0 || value == 1.0,
            _ => true,
        };
        states.contains(self.expected.state)
            && value.is_finite()
            && variable.min.is_none_or(|min| value >= min)
            && variable.max.is_none_or(|max| value <= max)
            && item
    }

    /// Sets values in the reference; tells whether they are legal.
    pub fn set(&mut self, references: &[u32], values: &[f64], of: impl Fn(&Variable) -> bool) -> bool {
        if !"IMC".contains(self.expected.state) {
            return false;
        }
        let mut candidate = self.expected.clone();
        let mut tunes = false;
        for (reference, value) in references.iter().zip(values) {
            let Some(variable) = find(*reference).filter(|variable| of(variable)) else { return false };
            if self.keeps(variable, *value) {
                continue;
            }
            if !self.can_set(variable, *value) {
                return false;
            }
            if is_input(variable) {
                candidate.inputs[place(variable, is_input)] = *value;
            } else if variable.is_parameter() {
                candidate.parameters[place(variable, Variable::is_parameter)] = *value;
                tunes = true;
            }
        }
        if let Some(simulation) = self.simulation.as_mut().filter(|_| tunes && self.expected.runs())
            && simulation.retune(&candidate.parameters).is_err()
        {
            return false;
        }
        self.expected = candidate;
        true
    }

    pub fn step(&mut self, point: f64, size: f64) -> c_int {
        let start = self.time();
        let end = point + size;
        let is_here = point == start || point == start.next_up();
        let is_size = size > 0.0 && size.is_finite();
        let stops = self.expected.stop.is_some_and(|stop| end > stop);
        if self.expected.state != 'C' || !is_here || !is_size || !end.is_finite() || end <= start || stops {
            return ERROR;
        }
        let inputs = variables().iter().filter(|variable| is_input(variable));
        for (index, variable) in inputs.enumerate() {
            let reached = self.expected.inputs[index] + self.expected.slopes[index] * (end - start);
            if self.expected.slopes[index] != 0.0 && !self.can_set(variable, reached) {
                return ERROR;
            }
        }
        let simulation = self.simulation.as_mut().expect("a running simulation");
        simulation.set_inputs(&self.expected.inputs, &self.expected.slopes);
        let outcome = simulation.advance(end);
        let (reached, is_finite) = (simulation.time(), simulation.is_finite());
        for (input, slope) in self.expected.inputs.iter_mut().zip(&mut self.expected.slopes) {
            if *slope != 0.0 {
                *input += *slope * (reached - start);
            }
            *slope = 0.0;
        }
        self.expected.failed = outcome.is_err() || !is_finite;
        self.expected.successful_until = if outcome.is_ok() && !is_finite { start } else { reached };
        self.expected.state = if self.expected.failed { 'F' } else { 'C' };
        if self.expected.failed { DISCARD } else { OK }
    }
}

/// A directional derivative of the reference, if it is defined.
pub fn directional(pair: &mut Pair, unknowns: &[u32], knowns: &[u32], seeds: &[f64]) -> Option<Vec<f64>> {
    let places: Option<Vec<_>> = unknowns
        .iter()
        .map(|reference| Some(place(find(*reference).filter(|it| is_computed_real(it))?, Variable::is_computed)))
        .collect();
    let states: Vec<u32> = variables().iter().filter_map(|variable| variable.derivative_of).collect();
    let (mut input_seeds, mut state_seeds) = (vec![0.0; pair.expected.inputs.len()], vec![0.0; states.len()]);
    let mut parameter_seeds = vec![0.0; pair.expected.parameters.len()];
    let mut time_seed = 0.0;
    for (known, seed) in knowns.iter().zip(seeds).filter(|_| pair.expected.state != 'I') {
        if !seed.is_finite() {
            return None;
        }
        if let Some(place) = states.iter().position(|state| state == known) {
            state_seeds[place] += seed;
        } else if find(*known).is_some_and(|variable| variable.role == Role::Time) {
            time_seed += seed;
        } else if find(*known).is_some_and(|variable| variable.role == Role::Tunable && is_real(variable)) {
            parameter_seeds[place(find(*known)?, Variable::is_parameter)] += seed;
        } else {
            input_seeds[place(find(*known).filter(|it| is_real_input(it))?, is_input)] += seed;
        }
    }
    let mut derivatives = pair.computed()?;
    let during_initialization = pair.expected.simulation().filter(|_| pair.expected.state == 'M');
    let simulation = during_initialization.as_ref().or(pair.simulation.as_ref())?;
    let direction =
        Direction { time: time_seed, inputs: &input_seeds, states: &state_seeds, parameters: &parameter_seeds };
    simulation.directional_derivative(direction, &mut derivatives);
    places?.into_iter().map(|place| Some(derivatives[place]).filter(|value| value.is_finite())).collect()
}
