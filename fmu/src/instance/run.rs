//! The simulation behind an instance, with its computed values at hand.

use super::failure::Failure;
use super::layout::Layout;
use super::record::Record;
use pneumatic_servo::co_simulation::{Simulation, Snapshot};

/// A simulation that is started when it is first needed and told about changed inputs when that matters.
pub struct Run {
    simulation: Option<Box<dyn Simulation>>,
    /// Whether the simulation has the inputs of the record.
    knows_inputs: bool,
    computed: Vec<f64>,
    /// Whether `computed` is what the simulation would compute.
    is_computed: bool,
}

impl Run {
    /// Nothing started yet.
    pub fn new(layout: &Layout) -> Self {
        Self { simulation: None, knows_inputs: false, computed: vec![0.0; layout.computed.len()], is_computed: false }
    }

    /// Forgets the simulation: the next one starts from the record as it is then.
    pub fn discard(&mut self) {
        self.simulation = None;
        self.is_computed = false;
    }

    /// Notes that the inputs of the record have changed.
    pub fn inputs_changed(&mut self) {
        self.knows_inputs = false;
        self.is_computed = false;
    }

    /// The simulation with the inputs of the record.
    pub fn simulation(&mut self, layout: &Layout, record: &Record) -> Result<&mut dyn Simulation, Failure> {
        let simulation = match &mut self.simulation {
            Some(simulation) => simulation,
            none => {
                self.knows_inputs = false;
                none.insert((layout.model.start)(&record.start())?)
            }
        };
        if !self.knows_inputs {
            simulation.set_inputs(&record.inputs, &record.slopes);
            self.knows_inputs = true;
        }
        Ok(simulation.as_mut())
    }

    /// The simulation for a call that changes it.
    pub fn changed_simulation(&mut self, layout: &Layout, record: &Record) -> Result<&mut dyn Simulation, Failure> {
        self.is_computed = false;
        self.simulation(layout, record)
    }

    /// The computed values for the inputs of the record.
    pub fn computed(&mut self, layout: &Layout, record: &Record) -> Result<&[f64], Failure> {
        if !self.is_computed {
            self.simulation(layout, record)?;
            if let Some(simulation) = &self.simulation {
                simulation.values(&mut self.computed);
            }
            self.is_computed = true;
        }
        Ok(&self.computed)
    }

    /// Current time in s, if the simulation is started.
    pub fn time(&self) -> Option<f64> {
        self.simulation.as_ref().map(|simulation| simulation.time())
    }

    /// The model's own states.
    pub fn save(&self) -> Option<Snapshot> {
        self.simulation.as_ref().map(|simulation| simulation.save())
    }

    /// Goes on from a snapshot; `reuse` tells that the simulation has the parameters and settings of the record.
    pub fn restore(
        &mut self,
        layout: &Layout,
        record: &Record,
        snapshot: &Snapshot,
        reuse: bool,
    ) -> Result<(), Failure> {
        let unfit = |error: pneumatic_servo::co_simulation::SnapshotError| Failure::error(error.to_string());
        match self.simulation.as_mut().filter(|_| reuse) {
            Some(simulation) => simulation.restore(snapshot).map_err(unfit)?,
            None => {
                let mut simulation = (layout.model.start)(&record.start())?;
                simulation.restore(snapshot).map_err(unfit)?;
                self.simulation = Some(simulation);
            }
        }
        self.inputs_changed();
        Ok(())
    }
}
