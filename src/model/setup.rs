//! A model with its parameters, start values of inputs and tolerance, ready to start.

use super::{Model, Plant, Seeds, Start};
use crate::co_simulation::Simulation;
use crate::model_exchange::Exchange;
use crate::sensitivity::{Along, Varied, seeds};
use crate::variables::{ParameterError, Place, Table, Variable};
use crate::variables::{SettingError, Value, find};

/// A model and its start values; all defaults at first.
///
/// ```
/// use pneumatic_servo::model::Setup;
/// use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
///
/// let mut plant = Setup::new(&MODEL).set("friction.law", "LuGre")?.set("supplyPressure", 6e5)?.start(0.0)?;
/// plant.set("valveVoltage", 6.0)?;
/// plant.step(0.1)?;
/// assert!(plant.get("position")? > 0.25);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Setup {
    model: &'static Model,
    parameters: Vec<f64>,
    inputs: Vec<f64>,
    tolerance: Option<f64>,
}

impl Setup {
    /// A model with the defaults of its table.
    pub fn new(model: &'static Model) -> Self {
        let starts = |variable: &Variable| variable.start.unwrap_or_default();
        let table = model.table();
        Self {
            model,
            parameters: table.parameters().map(starts).collect(),
            inputs: table.inputs().map(starts).collect(),
            tolerance: None,
        }
    }

    /// The former name of [`new`](Self::new).
    #[doc(hidden)]
    #[deprecated(note = "the name is `Setup::new`")]
    pub fn of(model: &'static Model) -> Self {
        Self::new(model)
    }

    /// The model.
    pub fn model(&self) -> &'static Model {
        self.model
    }

    /// The variables of the model.
    pub fn table(&self) -> &'static Table {
        self.model.table()
    }

    /// The same with a parameter or the start value of an input changed.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown name, a computed variable, or a value that is not legal. Whether parameters fit
    /// together is checked by [`start`](Self::start).
    pub fn set<'a>(mut self, name: &str, value: impl Into<Value<'a>>) -> Result<Self, SettingError> {
        self.change(name, value)?;
        Ok(self)
    }

    /// Changes a parameter or the start value of an input in place.
    ///
    /// # Errors
    /// As [`set`](Self::set); nothing is changed then.
    pub fn change<'a>(&mut self, name: &str, value: impl Into<Value<'a>>) -> Result<(), SettingError> {
        let entry = find(self.table(), name)?;
        let slot = match entry.place {
            Place::Input(place) => &mut self.inputs[place],
            Place::Parameter(place) => &mut self.parameters[place],
            Place::Time | Place::Computed(_) => {
                return Err(SettingError::NotSettable { name: name.to_owned(), reason: "it is computed" });
            }
        };
        *slot = value.into().number(entry.variable)?;
        Ok(())
    }

    /// The present value of a parameter or the start value of an input.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown name or a variable without a value before the start.
    pub fn get(&self, name: &str) -> Result<f64, SettingError> {
        match find(self.table(), name)?.place {
            Place::Input(place) => Ok(self.inputs[place]),
            Place::Parameter(place) => Ok(self.table().in_use(place, &self.parameters)),
            Place::Time | Place::Computed(_) => {
                Err(SettingError::NotSettable { name: name.to_owned(), reason: "it is computed, after the start" })
            }
        }
    }

    /// The same with a tolerance that takes the place of `solver.relativeTolerance` while that is at its default.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Self { tolerance: Some(tolerance), ..self }
    }

    /// The parameters, in the order of the table.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// The start values of the inputs, in the order of the table.
    pub fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    /// Starts a run at a time in s that knows places in the table and no names.
    ///
    /// # Errors
    /// [`ParameterError`] when parameters do not fit together.
    pub fn simulation(&self, time: f64) -> Result<Box<dyn Simulation>, ParameterError> {
        let Self { parameters, inputs, tolerance, .. } = self;
        self.model.begin(&Start { time, parameters, inputs, tolerance: *tolerance, seeds: Seeds::NONE })
    }

    /// Starts a run at a time in s in numbers with slopes, in the directions of parameters and inputs.
    ///
    /// # Errors
    /// [`ParameterError`] when parameters do not fit together, or there are no such runs.
    #[doc(hidden)]
    pub fn varied(&self, time: f64, along: &[Along]) -> Result<Box<dyn Varied>, ParameterError> {
        let Self { parameters, inputs, tolerance, .. } = self;
        let of_parameters: Vec<_> = (0..parameters.len()).map(|i| seeds(along, Along::Parameter(i))).collect();
        let of_inputs: Vec<_> = (0..inputs.len()).map(|i| seeds(along, Along::Input(i))).collect();
        let seeds = Seeds { parameters: &of_parameters, inputs: &of_inputs };
        (self.model.functions.vary)(&Start { time, parameters, inputs, tolerance: *tolerance, seeds })
    }

    /// Starts a run at a time in s whose states are to be integrated outside; nothing if the model has none.
    ///
    /// # Errors
    /// [`ParameterError`] when parameters do not fit together.
    pub fn exchange(&self, time: f64) -> Result<Option<Box<dyn Exchange>>, ParameterError> {
        Ok(self.simulation(time)?.exchange(self.model.indicators()))
    }

    /// Starts a run at a time in s.
    ///
    /// # Errors
    /// [`ParameterError`] when parameters do not fit together.
    pub fn start(&self, time: f64) -> Result<Plant, ParameterError> {
        let simulation = self.simulation(time)?;
        Ok(Plant::new(self.model, simulation, self.parameters.clone(), self.inputs.clone(), self.tolerance))
    }
}
