//! The run of the model of an instance, with a cache of its computed values.

use super::layout::Layout;
use super::record::{Kind, Record};
use crate::failure::Failure;
use crate::memory;
use pneumatic_servo::co_simulation::{Direction, Simulation, Snapshot, SnapshotError};
use pneumatic_servo::model_exchange::{Exchange, Update, seen};
use pneumatic_servo::solver::StepError;
use pneumatic_servo::variables::Notices;

/// A running model.
enum Running {
    /// Co-simulation, and initialization.
    CoSimulation(Box<dyn Simulation>),
    /// Model exchange, from the end of the initialization on.
    ModelExchange(Box<dyn Exchange>),
}

/// A model that is started when it is first needed and told about changed inputs when that matters.
pub struct RunningModel {
    running: Option<Running>,
    /// Whether the model has the inputs of the record.
    knows_inputs: bool,
    computed: Vec<f64>,
    /// Whether `computed` is up to date.
    is_computed: bool,
}

impl RunningModel {
    /// Nothing started yet.
    pub fn new(layout: &Layout) -> Self {
        Self { running: None, knows_inputs: false, computed: vec![0.0; layout.computed], is_computed: false }
    }

    /// Forgets the run: the next one starts from the record as it is then.
    pub fn discard(&mut self) {
        self.running = None;
        self.is_computed = false;
    }

    /// Notes that the inputs of the record have changed.
    pub fn inputs_changed(&mut self) {
        self.knows_inputs = false;
        self.is_computed = false;
    }

    /// The model with the inputs of the record.
    #[inline]
    fn ready(&mut self, layout: &Layout, record: &Record) -> Result<&mut Running, Failure> {
        let running = match &mut self.running {
            Some(running) => running,
            none => {
                self.knows_inputs = false;
                none.insert(start(layout, record)?)
            }
        };
        if !self.knows_inputs {
            match running {
                Running::CoSimulation(simulation) => simulation.set_inputs(&record.inputs, &record.slopes),
                Running::ModelExchange(exchange) => exchange.set_inputs(&record.inputs),
            }
            self.knows_inputs = true;
        }
        Ok(running)
    }

    /// The simulation with the inputs of the record.
    #[inline]
    fn inside(&mut self, layout: &Layout, record: &Record) -> Result<&mut dyn Simulation, Failure> {
        match self.ready(layout, record)? {
            Running::CoSimulation(simulation) => Ok(simulation.as_mut()),
            Running::ModelExchange(_) => Err(Failure::error("the solver is outside")),
        }
    }

    /// The model for a call of the importer's solver that changes it.
    pub fn outside(&mut self, layout: &Layout, record: &Record) -> Result<&mut dyn Exchange, Failure> {
        self.is_computed = false;
        match self.ready(layout, record)? {
            Running::ModelExchange(exchange) => Ok(exchange.as_mut()),
            Running::CoSimulation(_) => Err(Failure::error("the solver is inside")),
        }
    }

    /// Looks at the model as the importer's solver sees it, or will see it after the initialization.
    pub fn look_from_outside(
        &mut self,
        layout: &Layout,
        record: &Record,
        look: impl FnOnce(&dyn Exchange) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        match self.ready(layout, record)? {
            Running::ModelExchange(outside) => look(outside.as_ref()),
            Running::CoSimulation(simulation) if record.kind == Kind::ModelExchange => {
                look(exchange(simulation.as_ref(), layout)?.as_ref())
            }
            Running::CoSimulation(_) => Err(Failure::error("the solver is inside")),
        }
    }

    /// Updates the discrete part of the model.
    pub fn update(&mut self, layout: &Layout, record: &Record) -> Result<Update, Failure> {
        self.is_computed = false;
        match self.ready(layout, record)? {
            Running::ModelExchange(exchange) => Ok(exchange.update()?),
            Running::CoSimulation(simulation) => {
                simulation.update().map_err(|error| Failure::error(error.to_string()))?;
                Ok(Update { changes_states: false, next_time_event: None })
            }
        }
    }

    /// Writes the event indicators for the importer's solver.
    pub fn indicators(&mut self, layout: &Layout, record: &Record, values: &mut [f64]) -> Result<(), Failure> {
        match self.ready(layout, record)? {
            Running::ModelExchange(exchange) => exchange.indicators(values),
            Running::CoSimulation(simulation) => {
                simulation.indicators(values);
                for (value, indicator) in values.iter_mut().zip(&layout.indicators) {
                    *value = seen(indicator, *value);
                }
            }
        }
        Ok(())
    }

    /// Hands the started model to the importer's solver.
    pub fn go_outside(&mut self, layout: &Layout, record: &Record) -> Result<(), Failure> {
        let outside = exchange(self.inside(layout, record)?, layout)?;
        self.running = Some(Running::ModelExchange(outside));
        self.inputs_changed();
        Ok(())
    }

    /// Integrates to `end`; tells why not, if it stops before.
    pub fn advance(&mut self, layout: &Layout, record: &Record, end: f64) -> Result<Result<(), StepError>, Failure> {
        self.is_computed = false;
        Ok(self.inside(layout, record)?.advance(end))
    }

    /// Whether everything the model carries on from step to step is a finite number.
    pub fn is_finite(&self) -> bool {
        match &self.running {
            Some(Running::CoSimulation(simulation)) => simulation.is_finite(),
            // The state of an importer's solver is its own affair.
            Some(Running::ModelExchange(_)) | None => true,
        }
    }

    /// Integrates to `end` or to the first event on the way, and tells whether there is one; or tells why not, if it stops
    /// before.
    pub fn advance_to_event(
        &mut self,
        layout: &Layout,
        record: &Record,
        end: f64,
    ) -> Result<Result<bool, StepError>, Failure> {
        self.is_computed = false;
        Ok(self.inside(layout, record)?.advance_to_event(end))
    }

    /// Replaces tunable parameters.
    pub fn retune(&mut self, layout: &Layout, record: &Record, parameters: &[f64]) -> Result<(), Failure> {
        self.is_computed = false;
        match self.ready(layout, record)? {
            Running::CoSimulation(simulation) => simulation.retune(parameters)?,
            Running::ModelExchange(exchange) => exchange.retune(parameters)?,
        }
        Ok(())
    }

    /// Writes the derivatives of the computed values with respect to time.
    pub fn rates(&mut self, layout: &Layout, record: &Record, computed: &mut [f64]) -> Result<(), Failure> {
        self.inside(layout, record)?.rates(computed);
        Ok(())
    }

    /// Writes the derivatives of the computed values in a direction.
    pub fn directional_derivative(
        &mut self,
        layout: &Layout,
        record: &Record,
        direction: Direction,
        computed: &mut [f64],
    ) -> Result<(), Failure> {
        match self.ready(layout, record)? {
            Running::CoSimulation(simulation) => simulation.directional_derivative(direction, computed),
            Running::ModelExchange(exchange) => exchange.directional_derivative(direction, computed),
        }
        Ok(())
    }

    /// The computed values for the inputs of the record.
    pub fn computed(&mut self, layout: &Layout, record: &Record) -> Result<&[f64], Failure> {
        if !self.is_computed {
            self.ready(layout, record)?;
            match &self.running {
                Some(Running::CoSimulation(simulation)) => simulation.values(&mut self.computed),
                Some(Running::ModelExchange(exchange)) => exchange.values(&mut self.computed),
                None => unreachable!("it is ready"),
            }
            self.is_computed = true;
        }
        Ok(&self.computed)
    }

    /// The computed variable in a place of the table; one that is a state, as a controller reads it after each step, takes no
    /// evaluation of the equations.
    pub fn value(&mut self, place: usize, layout: &Layout, record: &Record) -> Result<f64, Failure> {
        if !self.is_computed {
            let mut value = [0.0];
            if let Running::CoSimulation(simulation) = self.ready(layout, record)?
                && simulation.at_hand(&[place], &mut value)
            {
                return Ok(value[0]);
            }
        }
        Ok(self.computed(layout, record)?[place])
    }

    /// Warnings about the parameters and inputs of the record.
    pub fn notices(&mut self, layout: &Layout, record: &Record) -> Result<Notices, Failure> {
        Ok(match self.ready(layout, record)? {
            Running::CoSimulation(simulation) => simulation.notices(),
            Running::ModelExchange(exchange) => exchange.notices(),
        })
    }

    /// Current time in s, if the model is started.
    pub fn time(&self) -> Option<f64> {
        Some(match self.running.as_ref()? {
            Running::CoSimulation(simulation) => simulation.time(),
            Running::ModelExchange(exchange) => exchange.time(),
        })
    }

    /// The model's own states.
    pub fn save(&self) -> Option<Snapshot> {
        Some(match self.running.as_ref()? {
            Running::CoSimulation(simulation) => simulation.save(),
            Running::ModelExchange(exchange) => exchange.save(),
        })
    }

    /// Goes on from a snapshot; `reuse` tells that the model has the parameters and settings of the record.
    pub fn restore(
        &mut self,
        layout: &Layout,
        record: &Record,
        snapshot: &Snapshot,
        reuse: bool,
    ) -> Result<(), Failure> {
        match self.running.as_mut().filter(|_| reuse) {
            Some(Running::CoSimulation(simulation)) => simulation.restore(snapshot)?,
            Some(Running::ModelExchange(exchange)) => exchange.restore(snapshot)?,
            None => {
                let mut simulation = (layout.model.functions.start)(&record.start())?;
                self.running = Some(match record.kind {
                    Kind::CoSimulation | Kind::HybridCoSimulation { .. } => {
                        simulation.restore(snapshot)?;
                        Running::CoSimulation(simulation)
                    }
                    Kind::ModelExchange => {
                        let mut exchange = exchange(simulation.as_ref(), layout)?;
                        exchange.restore(snapshot)?;
                        Running::ModelExchange(exchange)
                    }
                });
            }
        }
        self.inputs_changed();
        Ok(())
    }
}

/// Starts the model for co-simulation. Its stack is released before the run is used.
#[cold]
#[inline(never)]
fn start(layout: &Layout, record: &Record) -> Result<Running, Failure> {
    memory::check_room()?;
    Ok(Running::CoSimulation(layout.model.begin(&record.start())?))
}

/// The model of a simulation in model exchange.
fn exchange(simulation: &dyn Simulation, layout: &Layout) -> Result<Box<dyn Exchange>, Failure> {
    let none = || Failure::error(format!("{} has no continuous states", layout.model.name));
    simulation.exchange(layout.model.indicators()).ok_or_else(none)
}

impl From<SnapshotError> for Failure {
    fn from(error: SnapshotError) -> Self {
        Self::error(error.to_string())
    }
}
