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
enum Way {
    /// Co-simulation, and initialization.
    Inside(Box<dyn Simulation>),
    /// Model exchange, from the end of the initialization on.
    Outside(Box<dyn Exchange>),
}

/// A model that is started when it is first needed and told about changed inputs when that matters.
pub struct Run {
    way: Option<Way>,
    /// Whether the model has the inputs of the record.
    knows_inputs: bool,
    computed: Vec<f64>,
    /// Whether `computed` is what the model would compute.
    is_computed: bool,
}

impl Run {
    /// Nothing started yet.
    pub fn new(layout: &Layout) -> Self {
        Self { way: None, knows_inputs: false, computed: vec![0.0; layout.computed], is_computed: false }
    }

    /// Forgets the run: the next one starts from the record as it is then.
    pub fn discard(&mut self) {
        self.way = None;
        self.is_computed = false;
    }

    /// Notes that the inputs of the record have changed.
    pub fn inputs_changed(&mut self) {
        self.knows_inputs = false;
        self.is_computed = false;
    }

    /// The model with the inputs of the record.
    #[inline]
    fn ready(&mut self, layout: &Layout, record: &Record) -> Result<&mut Way, Failure> {
        let way = match &mut self.way {
            Some(way) => way,
            none => {
                self.knows_inputs = false;
                none.insert(start(layout, record)?)
            }
        };
        if !self.knows_inputs {
            match way {
                Way::Inside(simulation) => simulation.set_inputs(&record.inputs, &record.slopes),
                Way::Outside(exchange) => exchange.set_inputs(&record.inputs),
            }
            self.knows_inputs = true;
        }
        Ok(way)
    }

    /// The simulation with the inputs of the record.
    #[inline]
    fn inside(&mut self, layout: &Layout, record: &Record) -> Result<&mut dyn Simulation, Failure> {
        match self.ready(layout, record)? {
            Way::Inside(simulation) => Ok(simulation.as_mut()),
            Way::Outside(_) => Err(Failure::error("the solver is outside")),
        }
    }

    /// The model for a call of the importer's solver that changes it.
    pub fn outside(&mut self, layout: &Layout, record: &Record) -> Result<&mut dyn Exchange, Failure> {
        self.is_computed = false;
        match self.ready(layout, record)? {
            Way::Outside(exchange) => Ok(exchange.as_mut()),
            Way::Inside(_) => Err(Failure::error("the solver is inside")),
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
            Way::Outside(outside) => look(outside.as_ref()),
            Way::Inside(simulation) if record.kind == Kind::ModelExchange => {
                look(exchange(simulation.as_ref(), layout)?.as_ref())
            }
            Way::Inside(_) => Err(Failure::error("the solver is inside")),
        }
    }

    /// Updates the discrete part of the model.
    pub fn update(&mut self, layout: &Layout, record: &Record) -> Result<Update, Failure> {
        self.is_computed = false;
        match self.ready(layout, record)? {
            Way::Outside(exchange) => Ok(exchange.update()?),
            Way::Inside(simulation) => {
                simulation.update().map_err(|error| Failure::error(error.to_string()))?;
                Ok(Update { changes_states: false, next_time_event: None })
            }
        }
    }

    /// Writes the event indicators for the importer's solver.
    pub fn indicators(&mut self, layout: &Layout, record: &Record, values: &mut [f64]) -> Result<(), Failure> {
        match self.ready(layout, record)? {
            Way::Outside(exchange) => exchange.indicators(values),
            Way::Inside(simulation) => {
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
        self.way = Some(Way::Outside(outside));
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
        match &self.way {
            Some(Way::Inside(simulation)) => simulation.is_finite(),
            // The state of an importer's solver is its own affair.
            Some(Way::Outside(_)) | None => true,
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
            Way::Inside(simulation) => simulation.retune(parameters)?,
            Way::Outside(exchange) => exchange.retune(parameters)?,
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
            Way::Inside(simulation) => simulation.directional_derivative(direction, computed),
            Way::Outside(exchange) => exchange.directional_derivative(direction, computed),
        }
        Ok(())
    }

    /// The computed values for the inputs of the record.
    pub fn computed(&mut self, layout: &Layout, record: &Record) -> Result<&[f64], Failure> {
        if !self.is_computed {
            self.ready(layout, record)?;
            match &self.way {
                Some(Way::Inside(simulation)) => simulation.values(&mut self.computed),
                Some(Way::Outside(exchange)) => exchange.values(&mut self.computed),
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
            if let Way::Inside(simulation) = self.ready(layout, record)?
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
            Way::Inside(simulation) => simulation.notices(),
            Way::Outside(exchange) => exchange.notices(),
        })
    }

    /// Current time in s, if the model is started.
    pub fn time(&self) -> Option<f64> {
        Some(match self.way.as_ref()? {
            Way::Inside(simulation) => simulation.time(),
            Way::Outside(exchange) => exchange.time(),
        })
    }

    /// The model's own states.
    pub fn save(&self) -> Option<Snapshot> {
        Some(match self.way.as_ref()? {
            Way::Inside(simulation) => simulation.save(),
            Way::Outside(exchange) => exchange.save(),
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
        match self.way.as_mut().filter(|_| reuse) {
            Some(Way::Inside(simulation)) => simulation.restore(snapshot)?,
            Some(Way::Outside(exchange)) => exchange.restore(snapshot)?,
            None => {
                let mut simulation = (layout.model.functions.start)(&record.start())?;
                self.way = Some(match record.kind {
                    Kind::CoSimulation | Kind::HybridCoSimulation { .. } => {
                        simulation.restore(snapshot)?;
                        Way::Inside(simulation)
                    }
                    Kind::ModelExchange => {
                        let mut exchange = exchange(simulation.as_ref(), layout)?;
                        exchange.restore(snapshot)?;
                        Way::Outside(exchange)
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
fn start(layout: &Layout, record: &Record) -> Result<Way, Failure> {
    memory::check_room()?;
    Ok(Way::Inside(layout.model.begin(&record.start())?))
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
