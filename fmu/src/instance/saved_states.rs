//! Saved states of an instance.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::Instance;
use super::codec::{self, SavedState};
use super::layout::Layout;
use super::record::{Experiment, Record};
use super::running_model::RunningModel;
use crate::calls::Mode;
use crate::failure::Failure;
use pneumatic_servo::co_simulation::Snapshot;
use pneumatic_servo::variables::Variable;

/// The saved states the host holds, by handle.
///
/// A handle is a number that no other state in the process has or has had, so that handles of other instances and
/// freed ones are recognised.
#[derive(Default)]
pub struct SavedStates(BTreeMap<usize, SavedState>);

/// The next handle. It starts where small numbers, which a host may pass by mistake, end.
static NEXT_HANDLE: AtomicUsize = AtomicUsize::new(0x1000);

impl SavedStates {
    /// Keeps a state under a handle that exists, or else under a new one.
    fn keep(&mut self, state: SavedState, handle: usize) -> Result<usize, Failure> {
        if let Some(kept) = self.0.get_mut(&handle) {
            *kept = state;
            return Ok(handle);
        }
        let next = NEXT_HANDLE.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |handle| handle.checked_add(1));
        let handle = next.map_err(|_| Failure::error("all numbers of states have been used"))?;
        self.0.insert(handle, state);
        Ok(handle)
    }

    fn get(&self, handle: usize) -> Result<&SavedState, Failure> {
        self.0.get(&handle).ok_or_else(|| unknown(handle))
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
    /// Saves into a new state, or over one that the handle stands for.
    pub fn get_state(&mut self, handle: usize) -> Result<usize, Failure> {
        if handle != NULL {
            self.saved.get(handle)?;
        }
        let state = SavedState { record: self.record.clone(), snapshot: self.snapshot() };
        self.saved.keep(state, handle)
    }

    /// Goes back to a saved state.
    pub fn set_state(&mut self, handle: usize) -> Result<(), Failure> {
        let SavedState { record, snapshot } = self.saved.get(handle)?;
        if record.kind != self.record.kind {
            return Err(Failure::error(
                "the FMU state is of another kind of instance: its solver is elsewhere, or it handles events otherwise",
            ));
        }
        match snapshot {
            Some(snapshot) => {
                let reuse = self.record.is_running() && has_same_settings(&self.record, record);
                self.run.restore(&self.layout, record, snapshot, reuse)?;
            }
            None => self.run.discard(),
        }
        self.record.clone_from(record);
        self.log.event("state restored");
        Ok(())
    }

    /// Frees a saved state.
    pub fn free_state(&mut self, handle: usize) -> Result<(), Failure> {
        if handle == NULL {
            return Ok(());
        }
        self.saved.0.remove(&handle).map(|_| ()).ok_or_else(|| unknown(handle))
    }

    /// The bytes of a saved state.
    pub fn serialized(&self, handle: usize) -> Result<Vec<u8>, Failure> {
        codec::encode(self.saved.get(handle)?, &self.layout.guid, codec::length(&self.layout))
    }

    /// Keeps the state that bytes stand for, under a new handle.
    pub fn deserialize(&mut self, bytes: &[u8]) -> Result<usize, Failure> {
        let state = codec::decode(bytes, &self.layout.guid)?;
        state.check(&self.layout)?;
        self.saved.keep(state, NULL)
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
            && record.mode != Mode::Fatal
            && record.is_running() == self.snapshot.is_some();
        if !fits {
            return Err(Failure::error("the serialized state is no state of this model"));
        }
        if let Some(Experiment { start, stop, tolerance }) = record.experiment {
            Experiment::new(start, stop, tolerance)?;
        }
        check_values(layout.table.parameters(), &record.parameters)?;
        check_values(layout.table.inputs(), &record.inputs)?;
        match &self.snapshot {
            Some(snapshot) => RunningModel::new(layout).restore(layout, record, snapshot, false),
            None => Ok(()),
        }
    }
}

fn check_values<'a>(variables: impl Iterator<Item = &'a Variable>, values: &[f64]) -> Result<(), Failure> {
    for (variable, value) in variables.zip(values) {
        variable.check(*value)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::layout::Base;
    use crate::instance::testing::{self, HIGH, INPUT, OUTPUT, STATE};

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
            let values = instance.get(Base::Real, [0, INPUT, STATE, OUTPUT, HIGH].into_iter()).expect("readable");
            seen.extend(values.iter().map(|value| value.to_bits()));
        }
        seen
    }

    /// An instance in the middle of a run, with everything different from the start.
    fn midway() -> Instance {
        let mut instance = initialized();
        instance.do_step(0.0, 0.1).expect("a step");
        instance.set(Base::Real, [(INPUT, 0.3), (HIGH, 7.0)].into_iter()).expect("legal");
        instance.set_input_derivatives([(INPUT, 1, 2.0)].into_iter()).expect("legal");
        instance
    }

    #[test]
    fn restored_state_repeats_bit_for_bit() {
        let mut instance = midway();
        let saved = instance.get_state(0).expect("a state");
        let first = continuation(&mut instance);
        instance.set_state(saved).expect("restored");
        assert_eq!(continuation(&mut instance), first);
        instance.set(Base::Real, [(HIGH, 9.0)].into_iter()).expect("tunable");
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
        let restored = other.deserialize(&bytes).expect("a state");
        other.set_state(restored).expect("restored");
        assert_eq!(continuation(&mut other), continuation(&mut one));
    }

    #[test]
    fn states_before_and_during_initialization_and_after_the_end_are_restored() {
        let mut instance = testing::instance();
        let before = instance.get_state(0).expect("a state");
        instance.enter_initialization_mode().expect("initialization");
        instance.set(Base::Real, [(INPUT, 4.0)].into_iter()).expect("legal");
        let during = instance.get_state(0).expect("a state");
        instance.exit_initialization_mode().expect("initialized");
        instance.terminate().expect("terminated");
        let after = instance.get_state(0).expect("a state");
        for (saved, mode) in [(before, Mode::Instantiated), (during, Mode::Initialization), (after, Mode::Terminated)] {
            instance.set_state(saved).expect("restored");
            assert_eq!(instance.mode(), mode);
            let bytes = instance.serialized(saved).expect("bytes");
            assert!(instance.deserialize(&bytes).is_ok());
        }
        instance.set_state(during).expect("restored");
        instance.exit_initialization_mode().expect("initialized");
        assert_eq!(testing::real(&mut instance, INPUT), Ok(4.0));
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
    fn handle_of_a_freed_state_is_never_given_to_another() {
        let mut instance = initialized();
        let first = instance.get_state(0).expect("a state");
        instance.free_state(first).expect("freed");
        // An allocator gives the room of the first state to the second one.
        let second = instance.get_state(0).expect("a state");
        assert_ne!(first, second);
        assert!(instance.set_state(first).is_err() && instance.set_state(second).is_ok());
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
            let bytes = codec::encode(&state, &testing::layout().guid, 0).expect("bytes");
            let failure = instance.deserialize(&bytes).expect_err("an impossible state");
            assert!(!failure.message.contains("corrupt"), "{failure:?}");
        };
        refuse(|it| it.record.mode = Mode::Fatal);
        refuse(|it| it.record.mode = Mode::Instantiated);
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
