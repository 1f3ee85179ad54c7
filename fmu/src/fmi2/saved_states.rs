//! Saved states of an instance.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::calls::{Call, State};
use super::codec;
use super::failure::Failure;
use super::instance::Instance;
use super::layout::Layout;
use super::record::{Experiment, Record};
use super::run::Run;
use super::values::check_value;
use pneumatic_servo::co_simulation::Snapshot;
use pneumatic_servo::variables::Variable;

/// A complete copy of an instance, apart from its log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedState {
    /// What the instance remembers.
    pub record: Record,
    /// The model's own states, once it runs.
    pub snapshot: Option<Snapshot>,
}

/// The saved states the host holds, by handle.
///
/// A handle is the address of a state but is only ever compared, so that those of other instances, freed ones and
/// arbitrary numbers are recognised.
#[derive(Default)]
#[allow(clippy::vec_box, reason = "the boxes give each state an address that no other state in the process has")]
pub struct SavedStates(BTreeMap<usize, Box<SavedState>>);

impl SavedStates {
    /// Keeps a state under a handle that exists, or else under a new one.
    fn keep(&mut self, state: SavedState, handle: usize) -> usize {
        if let Some(kept) = self.0.get_mut(&handle) {
            **kept = state;
            return handle;
        }
        let state = Box::new(state);
        let handle = std::ptr::from_ref(&*state).addr();
        self.0.insert(handle, state);
        handle
    }

    fn get(&self, handle: usize) -> Result<&SavedState, Failure> {
        self.0.get(&handle).map(Box::as_ref).ok_or_else(|| unknown(handle))
    }
}

/// The handle that stands for no state.
const NULL: usize = 0;

fn unknown(handle: usize) -> Failure {
    match handle {
        NULL => Failure::error("the FMU state is NULL"),
        _ => Failure::error("the FMU state is not one of this instance, or has been freed"),
    }
}

impl Instance {
    /// `fmi2GetFMUstate`: saves into a new state, or over one that the handle stands for.
    pub fn get_state(&mut self, handle: usize) -> Result<usize, Failure> {
        if handle != NULL {
            self.saved.get(handle)?;
        }
        let state = SavedState { record: self.record.clone(), snapshot: self.snapshot() };
        Ok(self.saved.keep(state, handle))
    }

    /// `fmi2SetFMUstate`.
    pub fn set_state(&mut self, handle: usize) -> Result<(), Failure> {
        let SavedState { record, snapshot } = self.saved.get(handle)?;
        match snapshot {
            Some(snapshot) => {
                let reuse = self.record.is_running() && has_same_settings(&self.record, record);
                self.run.restore(self.layout, record, snapshot, reuse)?;
            }
            None => self.run.discard(),
        }
        self.record.clone_from(record);
        self.log.event(Call::SetFMUstate, "state restored");
        Ok(())
    }

    /// `fmi2FreeFMUstate`.
    pub fn free_state(&mut self, handle: usize) -> Result<(), Failure> {
        if handle == NULL {
            return Ok(());
        }
        self.saved.0.remove(&handle).map(|_| ()).ok_or_else(|| unknown(handle))
    }

    /// `fmi2SerializeFMUstate`: the bytes of a saved state.
    pub fn serialized(&self, handle: usize) -> Result<Vec<u8>, Failure> {
        codec::encode(self.saved.get(handle)?, &self.layout.guid)
    }

    /// `fmi2DeSerializeFMUstate`: like `get_state`, except that a handle that is not known counts as none, since the
    /// standard lets hosts pass anything.
    pub fn deserialize(&mut self, bytes: &[u8], handle: usize) -> Result<usize, Failure> {
        let state = codec::decode(bytes, &self.layout.guid)?;
        state.check(self.layout)?;
        Ok(self.saved.keep(state, handle))
    }

    /// The model's own states. During initialization they follow from the record.
    fn snapshot(&self) -> Option<Snapshot> {
        self.run.save().filter(|_| self.record.is_running())
    }
}

/// Whether a simulation made for one record serves the other.
fn has_same_settings(one: &Record, other: &Record) -> bool {
    let bits = |record: &Record| record.parameters.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    one.experiment == other.experiment && bits(one) == bits(other)
}

impl SavedState {
    /// Refuses a state that no instance of the model can have had.
    fn check(&self, layout: &Layout) -> Result<(), Failure> {
        let record = &self.record;
        let fits = record.parameters.len() == layout.parameters.len()
            && record.inputs.len() == layout.inputs.len()
            && record.slopes.len() == layout.inputs.len()
            && record.slopes.iter().all(|slope| slope.is_finite())
            && record.last_step.successful_until.is_finite()
            && record.state != State::Fatal
            && record.is_running() == self.snapshot.is_some();
        if !fits {
            return Err(Failure::error("the serialized state is no state of this model"));
        }
        if let Some(Experiment { start, stop, tolerance }) = record.experiment {
            Experiment::new(start, stop, tolerance)?;
        }
        check_values(&layout.parameters, &record.parameters)?;
        check_values(&layout.inputs, &record.inputs)?;
        match &self.snapshot {
            Some(snapshot) => Run::new(layout).restore(layout, record, snapshot, false),
            None => Ok(()),
        }
    }
}

fn check_values(variables: &[&Variable], values: &[f64]) -> Result<(), Failure> {
    for (variable, value) in variables.iter().zip(values) {
        check_value(variable, *value)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi2::layout::Base;
    use crate::fmi2::testing::{self, HIGH, INPUT, OUTPUT, STATE};

    fn initialized() -> Instance {
        let mut instance = testing::instance();
        instance.setup_experiment(Some(1e-5), 0.0, None).expect("legal");
        instance.enter_initialization_mode().expect("initialization");
        instance.exit_initialization_mode().expect("initialized");
        instance
    }

    /// Two steps with a slope in the first, and everything that can be seen after each.
    fn continuation(instance: &mut Instance) -> Vec<u64> {
        let mut seen = Vec::new();
        for size in [0.1, 0.03] {
            instance.do_step(instance.time(), size).expect("a step");
            instance
                .get(Base::Real, &[0, INPUT, STATE, OUTPUT, HIGH], |_, value| seen.push(value.to_bits()))
                .expect("readable");
        }
        seen
    }

    /// An instance in the middle of a run, with everything different from the start.
    fn midway() -> Instance {
        let mut instance = initialized();
        instance.do_step(0.0, 0.1).expect("a step");
        instance.set(Base::Real, &[INPUT, HIGH], |index| [0.3, 7.0][index]).expect("legal");
        instance.set_input_derivatives(&[INPUT], &[1], &[2.0]).expect("legal");
        instance
    }

    #[test]
    fn restored_state_repeats_bit_for_bit() {
        let mut instance = midway();
        let saved = instance.get_state(0).expect("a state");
        let first = continuation(&mut instance);
        instance.set_state(saved).expect("restored");
        assert_eq!(continuation(&mut instance), first);
        instance.set(Base::Real, &[HIGH], |_| 9.0).expect("tunable");
        instance.set_state(saved).expect("restored with other parameters");
        assert_eq!(continuation(&mut instance), first);
        instance.reset().expect("reset");
        instance.set_state(saved).expect("restored after a reset");
        assert_eq!(continuation(&mut instance), first);
    }

    #[test]
    fn serialized_state_repeats_bit_for_bit_in_another_instance() {
        let mut one = midway();
        let saved = one.get_state(0).expect("a state");
        let bytes = one.serialized(saved).expect("bytes");
        let mut other = testing::instance();
        let restored = other.deserialize(&bytes, 0).expect("a state");
        other.set_state(restored).expect("restored");
        assert_eq!(continuation(&mut other), continuation(&mut one));
    }

    #[test]
    fn states_before_and_during_initialization_and_after_the_end_are_restored() {
        let mut instance = testing::instance();
        let before = instance.get_state(0).expect("a state");
        instance.enter_initialization_mode().expect("initialization");
        instance.set(Base::Real, &[INPUT], |_| 4.0).expect("legal");
        let during = instance.get_state(0).expect("a state");
        instance.exit_initialization_mode().expect("initialized");
        instance.terminate().expect("terminated");
        let after = instance.get_state(0).expect("a state");
        for (saved, state) in
            [(before, State::Instantiated), (during, State::Initialization), (after, State::Terminated)]
        {
            instance.set_state(saved).expect("restored");
            assert_eq!(instance.state(), state);
            let bytes = instance.serialized(saved).expect("bytes");
            assert!(instance.deserialize(&bytes, 0).is_ok());
        }
        instance.set_state(during).expect("restored");
        instance.exit_initialization_mode().expect("initialized");
        let mut input = 0.0;
        instance.get(Base::Real, &[INPUT], |_, value| input = value).expect("readable");
        assert_eq!(input, 4.0);
    }

    #[test]
    fn handles_of_others_and_freed_ones_are_refused() {
        let (mut one, mut other) = (initialized(), initialized());
        let foreign = other.get_state(0).expect("a state");
        let own = one.get_state(0).expect("a state");
        one.free_state(own).expect("freed");
        for handle in [foreign, own, 1, usize::MAX] {
            assert!(one.set_state(handle).is_err());
            assert!(one.get_state(handle).is_err());
            assert!(one.serialized(handle).is_err());
            assert!(one.free_state(handle).is_err());
        }
        assert!(one.set_state(0).is_err() && one.serialized(0).is_err());
        one.free_state(0).expect("nothing to free");
        other.set_state(foreign).expect("its own");
    }

    #[test]
    fn saving_into_a_handle_overwrites_it() {
        let mut instance = initialized();
        let saved = instance.get_state(0).expect("a state");
        instance.do_step(0.0, 0.5).expect("a step");
        assert_eq!(instance.get_state(saved), Ok(saved));
        instance.reset().expect("reset");
        instance.set_state(saved).expect("restored");
        assert_eq!(instance.time(), 0.5);
    }

    #[test]
    fn states_that_no_instance_can_have_had_are_refused() {
        let mut instance = midway();
        let saved = instance.get_state(0).expect("a state");
        let state = instance.saved.get(saved).expect("kept").clone();
        let mut refuse = |change: fn(&mut SavedState)| {
            let mut state = state.clone();
            change(&mut state);
            let bytes = codec::encode(&state, &testing::layout().guid).expect("bytes");
            let failure = instance.deserialize(&bytes, 0).expect_err("an impossible state");
            assert!(!failure.message.contains("corrupt"), "{failure:?}");
        };
        refuse(|it| it.record.state = State::Fatal);
        refuse(|it| it.record.state = State::Instantiated);
        refuse(|it| it.snapshot = None);
        refuse(|it| it.record.parameters.truncate(1));
        refuse(|it| it.record.inputs.push(0.0));
        refuse(|it| it.record.inputs[1] = -1.0);
        refuse(|it| it.record.inputs[0] = f64::NAN);
        refuse(|it| it.record.slopes[0] = f64::INFINITY);
        refuse(|it| it.record.parameters[0] = 0.0);
        refuse(|it| it.record.parameters[1] = 99.0);
        refuse(|it| it.record.last_step.successful_until = f64::NAN);
        refuse(|it| it.record.experiment = Some(Experiment { start: f64::NAN, stop: None, tolerance: None }));
        refuse(|it| it.record.experiment = Some(Experiment { start: 0.0, stop: Some(-1.0), tolerance: None }));
        refuse(|it| it.record.experiment = Some(Experiment { start: 0.0, stop: None, tolerance: Some(0.0) }));
        refuse(|it| it.snapshot.iter_mut().for_each(|snapshot| snapshot.states.push(0.0)));
        refuse(|it| it.snapshot.iter_mut().for_each(|snapshot| snapshot.memory.clear()));
    }
}
