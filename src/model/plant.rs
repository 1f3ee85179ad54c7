//! A running model whose variables are set and read by name.

use std::cell::RefCell;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::Model;
use crate::co_simulation::Simulation;
use crate::numbers::{DIRECTIONS, Slopes, Tangent};
use crate::sensitivity::{Along, Crossing, DirectionError, NoDerivative, Seed, Varied, directions, seeds};
use crate::session::{Seeds, Snapshot, SnapshotError, Start};
use crate::solver::StepError;
use crate::variables::{Kind, Notice, ParameterError, Place, Role, Table, Variable};
use crate::variables::{SettingError, Value, find};

/// A running model.
///
/// Inputs are held over a step, unless they are given slopes.
pub struct Plant {
    model: &'static Model,
    pub(super) simulation: Box<dyn Simulation>,
    pub(super) parameters: Vec<f64>,
    pub(super) inputs: Vec<f64>,
    pub(super) slopes: Vec<f64>,
    /// The computed variables, where they are known for the present states and inputs.
    computed: RefCell<Computed>,
    /// Inputs at the start.
    first_inputs: Vec<f64>,
    tolerance: Option<f64>,
    /// Directions of the derivatives.
    varied: Vec<DirectionPair>,
    /// Runs that serve for single steps, by the parameters that they vary with.
    pub(super) spare: Vec<(Parameters, Box<dyn Varied>)>,
}

/// A run beside a plant in numbers with slopes.
struct DirectionPair {
    /// Places of its directions among all that are carried along.
    places: Vec<usize>,
    run: Box<dyn Varied>,
    /// The computed variables, and why a direction has no slopes, where they are known for the present states and inputs.
    computed: Vec<Tangent>,
    lost: Option<[Option<NoDerivative>; DIRECTIONS]>,
}

/// The parameter of each direction, if it is one.
pub(super) type Parameters = [Option<usize>; DIRECTIONS];

/// Values of the computed variables, in the order of the table.
struct Computed {
    values: Vec<f64>,
    /// Whether they belong to the present states and inputs.
    are_known: bool,
}

/// A saved state of a [`Plant`]: a run that goes on from it repeats bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Saved {
    snapshot: Snapshot,
    parameters: Vec<f64>,
    inputs: Vec<f64>,
    slopes: Vec<f64>,
}

/// Takes a run over a step.
pub(super) fn go(run: &mut dyn Varied, until: Until) -> Result<(), StepError> {
    match until {
        Until::Time(end) => run.advance(end),
        Until::After(size) => run.step(size),
    }
}

/// The end of a step: a time in s, or a size in s from the present time.
#[derive(Clone, Copy, Debug)]
pub(super) enum Until {
    Time(f64),
    After(f64),
}

impl Computed {
    /// The values at the present states and inputs.
    fn renew(&mut self, simulation: &dyn Simulation) -> &[f64] {
        if !self.are_known {
            simulation.values(&mut self.values);
            self.are_known = true;
        }
        &self.values
    }
}

impl fmt::Debug for Plant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("Plant");
        shown.field("model", &self.model.name).field("time", &self.time()).field("inputs", &self.inputs);
        shown.finish_non_exhaustive()
    }
}

impl Plant {
    /// A started simulation of a model, with the parameters and inputs it was started with.
    pub(crate) fn new(
        model: &'static Model,
        simulation: Box<dyn Simulation>,
        parameters: Vec<f64>,
        inputs: Vec<f64>,
        tolerance: Option<f64>,
    ) -> Self {
        let values = vec![0.0; model.table().computed().count()];
        let computed = RefCell::new(Computed { values, are_known: false });
        let slopes = vec![0.0; inputs.len()];
        let first_inputs = inputs.clone();
        Self {
            model,
            simulation,
            parameters,
            inputs,
            slopes,
            computed,
            first_inputs,
            tolerance,
            varied: Vec::new(),
            spare: Vec::new(),
        }
    }

    /// The model.
    pub fn model(&self) -> &'static Model {
        self.model
    }

    /// The variables of the model.
    pub fn table(&self) -> &'static Table {
        self.model.table()
    }

    /// Current time in s.
    pub fn time(&self) -> f64 {
        self.simulation.time()
    }

    /// Sets an input, or a parameter that is tunable.
    ///
    /// # Errors
    /// [`SettingError`]; nothing is changed then.
    pub fn set<'a>(&mut self, name: &str, value: impl Into<Value<'a>>) -> Result<(), SettingError> {
        let entry = find(self.table(), name)?;
        let refuse = |reason| Err(SettingError::NotSettable { name: name.to_owned(), reason });
        match (entry.place, entry.variable.role) {
            (Place::Input(place), _) => self.put_input(place, value.into().number(entry.variable)?),
            (Place::Parameter(place), Role::Tunable) => {
                let value = value.into().number(entry.variable)?;
                let before = std::mem::replace(&mut self.parameters[place], value);
                if let Err(error) = self.simulation.retune(&self.parameters) {
                    self.parameters[place] = before;
                    return Err(error.into());
                }
                self.forget_computed();
                self.varied.clear();
                self.spare.clear();
            }
            (Place::Parameter(_), _) => return refuse("it is fixed once the model has started"),
            (Place::Time | Place::Computed(_), _) => return refuse("it is computed"),
        }
        Ok(())
    }

    /// Sets the input in a place among the inputs of the table.
    ///
    /// # Errors
    /// [`ParameterError`] for a value that is not legal; nothing is changed then.
    ///
    /// # Panics
    /// If there is no such place.
    pub fn set_input(&mut self, place: usize, value: f64) -> Result<(), ParameterError> {
        let variable = self.table().inputs().nth(place).expect("an input in this place");
        variable.check(value)?;
        self.put_input(place, value);
        Ok(())
    }

    pub(super) fn put_input(&mut self, place: usize, value: f64) {
        self.inputs[place] = value;
        self.inputs_changed();
    }

    /// Lets an input vary with a slope in 1/s during the next step; then it keeps the value it has reached.
    ///
    /// # Errors
    /// [`SettingError`] if there is no such input, or if it is true or false.
    pub fn set_slope(&mut self, name: &str, slope: f64) -> Result<(), SettingError> {
        let entry = find(self.table(), name)?;
        let refuse = |reason| Err(SettingError::NotSettable { name: name.to_owned(), reason });
        let Place::Input(place) = entry.place else { return refuse("only inputs have slopes") };
        if slope != 0.0 && entry.variable.kind == Kind::Boolean {
            return refuse("it is true or false, and has no slope");
        }
        self.slope_input(place, slope);
        Ok(())
    }

    /// Lets the real input in a place vary with a slope in 1/s during the next step; then it keeps the value it has reached.
    ///
    /// # Panics
    /// If there is no such place.
    pub fn slope_input(&mut self, place: usize, slope: f64) {
        self.slopes[place] = slope;
        self.inputs_changed();
    }

    fn inputs_changed(&mut self) {
        self.simulation.set_inputs(&self.inputs, &self.slopes);
        self.varied.iter_mut().for_each(|beside| beside.run.set_inputs(&self.inputs, &self.slopes));
        self.forget_computed();
    }

    /// The value of a variable.
    ///
    /// # Errors
    /// [`SettingError::Unknown`] if there is none of that name.
    pub fn get(&self, name: &str) -> Result<f64, SettingError> {
        Ok(self.value(find(self.table(), name)?.place))
    }

    /// The value in a place of the table.
    pub fn value(&self, place: Place) -> f64 {
        match place {
            Place::Time => self.time(),
            Place::Input(place) => self.inputs[place],
            Place::Parameter(place) => self.table().in_use(place, &self.parameters),
            Place::Computed(place) => self.computed_value(place),
        }
    }

    fn computed_value(&self, place: usize) -> f64 {
        let mut computed = self.computed.borrow_mut();
        let mut value = [0.0];
        if !computed.are_known && self.simulation.at_hand(&[place], &mut value) {
            return value[0];
        }
        computed.renew(self.simulation.as_ref())[place]
    }

    /// All computed values, in the order of the table, consistent with the present inputs.
    pub fn computed(&mut self) -> &[f64] {
        self.computed.get_mut().renew(self.simulation.as_ref())
    }

    /// Number of the computed variables.
    pub(super) fn computed_count(&self) -> usize {
        self.computed.borrow().values.len()
    }

    fn forget_computed(&mut self) {
        self.computed.get_mut().are_known = false;
        self.varied.iter_mut().for_each(|beside| beside.lost = None);
    }

    /// Integrates over a step of a size in s. A late clock, such as one in seconds since 1970, resolves the times at the ends of steps
    /// only to fractions of a microsecond; the steps have their sizes all the same.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn step(&mut self, size: f64) -> Result<(), StepError> {
        self.advance(Until::After(size))
    }

    /// Integrates to a time in s, which is not in the past.
    ///
    /// # Errors
    /// [`StepError`] when it cannot be reached; the plant then stays at the last accepted solver step.
    pub fn advance_to(&mut self, end: f64) -> Result<(), StepError> {
        self.advance(Until::Time(end))
    }

    pub(super) fn advance(&mut self, until: Until) -> Result<(), StepError> {
        let start = self.time();
        self.forget_computed();
        let outcome = match until {
            Until::Time(end) => self.simulation.advance(end),
            Until::After(size) => self.simulation.step(size),
        };
        for beside in &mut self.varied {
            // Where the plain run comes to no end, neither does it.
            let _ = go(beside.run.as_mut(), until);
        }
        if self.slopes.iter().any(|slope| *slope != 0.0) {
            let duration = match (until, &outcome) {
                (Until::After(size), Ok(())) => size,
                _ => self.time() - start,
            };
            for (input, slope) in self.inputs.iter_mut().zip(&mut self.slopes) {
                *input += std::mem::take(slope) * duration;
            }
            self.inputs_changed();
        }
        outcome
    }

    /// Logs the events from here on; without it they cost nothing.
    ///
    /// ```
    /// use pneumatic_servo::model::Setup;
    /// use pneumatic_servo::models::friction_bench::MODEL;
    ///
    /// // Under Coulomb friction a mass stops after m*v0/Fc.
    /// let setup = Setup::new(&MODEL).set("bench.drive", "Free")?.set("friction.law", "Coulomb")?;
    /// let setup = setup.set("friction.coulomb.Fc", 2.0)?.set("friction.coulomb.sigma2", 0.0)?.set("velocity0", 3.0)?;
    /// let mut plant = setup.start(0.0)?;
    /// plant.log_events();
    /// plant.advance_to(2.0)?;
    /// let [(time, _)] = plant.logged_events()[..] else { panic!("one event") };
    /// assert!((time - 3.0 / 2.0).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn log_events(&mut self) {
        self.simulation.log_events();
    }

    /// Times in s and names of the events since they are logged, in the order in which they happened.
    pub fn logged_events(&self) -> Vec<(f64, &'static str)> {
        self.simulation.logged_events()
    }

    /// Warnings about the parameters and the present inputs, though they are accepted.
    pub fn notices(&self) -> impl Iterator<Item = Notice> {
        self.simulation.notices().into_iter().flatten()
    }

    /// Everything that affects the further run.
    pub fn save(&self) -> Saved {
        Saved {
            snapshot: self.simulation.save(),
            parameters: self.parameters.clone(),
            inputs: self.inputs.clone(),
            slopes: self.slopes.clone(),
        }
    }

    /// Goes back to a saved state of a plant of the same model that was set up alike.
    ///
    /// # Errors
    /// [`SnapshotError`] if it does not fit; nothing is changed then.
    pub fn restore(&mut self, saved: &Saved) -> Result<(), SnapshotError> {
        let lengths = |it: [&Vec<f64>; 3]| it.map(Vec::len);
        let expected = lengths([&self.parameters, &self.inputs, &self.slopes]);
        if lengths([&saved.parameters, &saved.inputs, &saved.slopes]) != expected {
            return Err(SnapshotError::Lengths);
        }
        self.check_fixed(saved)?;
        let retuned = saved.parameters != self.parameters;
        if retuned {
            self.simulation.retune(&saved.parameters).map_err(SnapshotError::Parameters)?;
        }
        if let Err(error) = self.simulation.restore(&saved.snapshot) {
            if retuned {
                self.simulation.retune(&self.parameters).map_err(SnapshotError::Parameters)?;
            }
            return Err(error);
        }
        self.parameters.clone_from(&saved.parameters);
        self.inputs.clone_from(&saved.inputs);
        self.slopes.clone_from(&saved.slopes);
        self.varied.clear();
        if retuned {
            self.spare.clear();
        }
        self.inputs_changed();
        Ok(())
    }

    /// Refuses a saved state of as many parameters in which a fixed one has another value.
    fn check_fixed(&self, saved: &Saved) -> Result<(), SnapshotError> {
        for entry in self.table().entries() {
            if let (Place::Parameter(place), Role::Fixed) = (entry.place, entry.variable.role) {
                let (saved, present) = (saved.parameters[place], self.parameters[place]);
                if saved.to_bits() != present.to_bits() {
                    return Err(SnapshotError::Fixed { name: entry.variable.name.clone(), saved, present });
                }
            }
        }
        Ok(())
    }

    /// The continuous states that are integrated under the present parameters, in the order of their derivatives.
    pub fn states(&self) -> impl Iterator<Item = &'static Variable> {
        let table = self.table();
        let states = table.iter().filter_map(|variable| table.by_reference(variable.derivative_of?));
        let is_integrated = |state| self.simulation.state_index(state).is_some();
        states.filter(move |entry| entry.state.is_some_and(is_integrated)).map(|entry| entry.variable)
    }

    /// Moves a continuous state to another value, at the present time and with the present modes.
    ///
    /// # Errors
    /// [`SettingError`] if it is no continuous state that is integrated, or the value is not finite; nothing is
    /// changed then.
    pub fn move_state(&mut self, name: &str, value: f64) -> Result<(), SettingError> {
        let entry = find(self.table(), name)?;
        let refuse = |reason| SettingError::NotSettable { name: name.to_owned(), reason };
        if !value.is_finite() {
            return Err(refuse("the value must be a finite number"));
        }
        if !entry.state.is_some_and(|state| self.put_state(state, value)) {
            return Err(refuse("it is no continuous state of this run"));
        }
        Ok(())
    }

    /// The same by the number of the state; tells whether it is integrated.
    pub(super) fn put_state(&mut self, state: usize, value: f64) -> bool {
        let is_moved = self.simulation.move_state(state, value);
        if is_moved {
            self.varied.clear();
            self.forget_computed();
        }
        is_moved
    }

    /// Carries sensitivities along from here on: derivatives of all variables by parameters, by constants added to inputs, and
    /// by the present values of continuous states, by their names. Without names it ends.
    ///
    /// In a run that has not begun yet, parameters and inputs also act on the start. Changing a parameter, moving a state
    /// or restoring a saved state ends it.
    ///
    /// ```
    /// use pneumatic_servo::model::Setup;
    /// use pneumatic_servo::models::friction_bench::MODEL;
    ///
    /// // Stopping under Coulomb friction takes m*v0^2/(2*Fc).
    /// let setup = Setup::new(&MODEL).set("bench.drive", "Free")?.set("friction.law", "Coulomb")?;
    /// let setup = setup.set("friction.coulomb.Fc", 2.0)?.set("friction.coulomb.sigma2", 0.0)?.set("velocity0", 3.0)?;
    /// let mut plant = setup.start(0.0)?;
    /// plant.carry_sensitivities(&["velocity0", "friction.coulomb.Fc"])?;
    /// plant.advance_to(2.0)?;
    /// assert!((plant.sensitivities(0)?[0] - 3.0 / 2.0).abs() < 1e-6);
    /// assert!((plant.sensitivities(1)?[0] + 9.0 / 8.0).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`DirectionError`] for a name of no such variable; none are carried along then.
    pub fn carry_sensitivities(&mut self, names: &[&str]) -> Result<(), DirectionError> {
        self.varied.clear();
        let along = directions(self.table(), &self.parameters, names)?;
        let has_begun = self.has_begun();
        let is_from_start = |along: &Along| !has_begun && matches!(along, Along::Parameter(_) | Along::Input(_));
        let mut varied = Vec::with_capacity(along.len().div_ceil(DIRECTIONS));
        for places in self.groups(&along, is_from_start) {
            let group: Vec<Along> = places.iter().map(|place| along[*place]).collect();
            let is_absent =
                |along: &Along| matches!(along, Along::State(state) if self.simulation.state_index(*state).is_none());
            if let Some(absent) = group.iter().position(is_absent) {
                return Err(DirectionError::refused(names[places[absent]], "it is no continuous state of this run"));
            }
            let run = if is_from_start(&group[0]) { self.vary_start(&group) } else { self.vary_here(&group) };
            let Ok(run) = run else {
                let reason = "this run has no equations that can be differentiated by it";
                return Err(DirectionError::refused(names[places[0]], reason));
            };
            varied.push(DirectionPair {
                places,
                run,
                computed: vec![Tangent::still(0.0); self.computed_count()],
                lost: None,
            });
        }
        self.varied = varied;
        self.inputs_changed();
        Ok(())
    }

    /// Whether the run is not where it has started, under the present parameters.
    pub(super) fn has_begun(&self) -> bool {
        let start = self.start(&self.first_inputs, Seeds::NONE);
        self.model.begin(&start).map_or(true, |fresh| fresh.save() != self.simulation.save())
    }

    fn start<'a>(&'a self, inputs: &'a [f64], seeds: Seeds<'a>) -> Start<'a> {
        Start { time: self.time(), parameters: &self.parameters, inputs, tolerance: self.tolerance, seeds }
    }

    /// The places of directions that are followed by one run, as many as it can: those that begin at the start of the run, or not.
    /// A parameter that is 0 stands for a part that its direction alone uses.
    pub(super) fn groups(&self, along: &[Along], is_from_start: impl Fn(&Along) -> bool) -> Vec<Vec<usize>> {
        let is_alone = |along: &Along| matches!(along, Along::Parameter(place) if self.parameters[*place] == 0.0);
        let (alone, others): (Vec<usize>, Vec<usize>) = (0..along.len()).partition(|place| is_alone(&along[*place]));
        let (first, later): (Vec<usize>, Vec<usize>) =
            others.into_iter().partition(|place| is_from_start(&along[*place]));
        let together = [first, later];
        let together = together.iter().flat_map(|places| places.chunks(DIRECTIONS));
        together.chain(alone.chunks(1)).map(<[usize]>::to_vec).collect()
    }

    /// A run beside this one from its start, which varies with parameters and inputs.
    pub(super) fn vary_start(&self, along: &[Along]) -> Result<Box<dyn Varied>, ParameterError> {
        self.with_start(along, |start| {
            let mut varied = (self.model.functions.vary)(start)?;
            varied.check_start(start);
            Ok(varied)
        })
    }

    /// A run beside this one that has not been placed anywhere.
    pub(super) fn vary(&self, along: &[Along]) -> Result<Box<dyn Varied>, ParameterError> {
        self.with_start(along, self.model.functions.vary)
    }

    /// Looks at the start of this run as it varies with parameters and inputs.
    fn with_start<R>(&self, along: &[Along], look: impl FnOnce(&Start) -> R) -> R {
        let parameters: Vec<Slopes> = (0..self.parameters.len()).map(|i| seeds(along, Along::Parameter(i))).collect();
        let inputs: Vec<Slopes> = (0..self.inputs.len()).map(|i| seeds(along, Along::Input(i))).collect();
        look(&self.start(&self.first_inputs, Seeds { parameters: &parameters, inputs: &inputs }))
    }

    /// A run beside this one from here on.
    fn vary_here(&self, along: &[Along]) -> Result<Box<dyn Varied>, ParameterError> {
        let mut varied = self.vary(along)?;
        let placed = varied.place(&self.simulation.save(), &Seed::each(along));
        placed.map_err(|error| ParameterError::new("the present state", self.time(), &error.to_string()))?;
        Ok(varied)
    }

    /// The derivatives of all computed variables, in the order of the table, by the name in a place among those that are
    /// carried along; in SI per SI. They belong to the present inputs, as the values do.
    ///
    /// # Errors
    /// [`NoDerivative`] if the run has come through a point at which there is none.
    ///
    /// # Panics
    /// If the direction is not carried along.
    pub fn sensitivities(&mut self, direction: usize) -> Result<Vec<f64>, NoDerivative> {
        let found = self.varied.iter_mut().find_map(|beside| {
            let place = beside.places.iter().position(|place| *place == direction)?;
            Some((beside, place))
        });
        let (DirectionPair { run, computed, lost, .. }, place) = found.expect("a direction that is carried along");
        match &lost.get_or_insert_with(|| run.outputs(computed))[place] {
            Some(lost) => Err(lost.clone()),
            None => Ok(computed.iter().map(|number| number.slopes[place]).collect()),
        }
    }

    /// The events since sensitivities are carried along, with times since the start of the run.
    pub fn crossings(&self) -> Vec<Crossing> {
        let is_same =
            |a: &Crossing, b: &Crossing| a.event == b.event && (a.time - b.time).abs() <= 1e-9 * (1.0 + b.time);
        let runs: Vec<_> = self.varied.iter().map(|beside| (&beside.places, beside.run.crossings())).collect();
        let count = runs.iter().map(|(places, _)| places.len()).sum();
        let mut all = runs.first().map(|(_, crossings)| crossings.clone()).unwrap_or_default();
        for (number, crossing) in all.iter_mut().enumerate() {
            let mut delays = vec![f64::NAN; count];
            for (places, crossings) in &runs {
                // A run that has lost its slopes has the same events, and one with a part that is 0 but for rounding.
                let same = crossings.get(number).filter(|it| is_same(it, crossing));
                for (place, delay) in places.iter().zip(same.into_iter().flat_map(|it| &it.delays)) {
                    delays[*place] = *delay;
                }
            }
            crossing.delays = delays;
        }
        all
    }

    /// The simulation behind it, without names.
    pub fn simulation(&self) -> &dyn Simulation {
        self.simulation.as_ref()
    }
}
