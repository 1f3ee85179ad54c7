//! Getting and setting values: all of a call's values or none.

use std::sync::Arc;

use super::Instance;
use super::layout::{Base, Layout};
use crate::calls::{Mode, describe};
use crate::failure::Failure;
use pneumatic_servo::variables::{Entry, Kind, Place, Role, Variable};

/// The modes in which an input may be set that is not real: in model exchange at events only.
const DISCRETE_SETTABLE: &[Mode] =
    &[Mode::Instantiated, Mode::Initialization, Mode::StepComplete, Mode::StepEvent, Mode::Event];

/// The modes in which a variable may be set: parameters only until their values are in use, unless tunable.
fn settable(variable: &Variable) -> &'static [Mode] {
    match variable.role {
        Role::Input if !matches!(variable.kind, Kind::Real(_)) => DISCRETE_SETTABLE,
        Role::Input => &[
            Mode::Instantiated,
            Mode::Initialization,
            Mode::StepComplete,
            Mode::StepEvent,
            Mode::Event,
            Mode::ContinuousTime,
        ],
        Role::Tunable => &[Mode::Instantiated, Mode::Initialization, Mode::StepComplete, Mode::StepEvent, Mode::Event],
        Role::Fixed => &[Mode::Instantiated, Mode::Initialization],
        Role::Time | Role::Output | Role::Local => &[],
    }
}

/// The modes in which a continuous state may be set: in model exchange, and the first, in which hosts may send back the start
/// values of the description.
const STATES_SETTABLE: &[Mode] = &[Mode::Instantiated, Mode::Event, Mode::ContinuousTime];

impl Instance {
    /// The values of variables of a type, after all of them have been found.
    pub fn get(&mut self, base: Base, references: impl Iterator<Item = u32>) -> Result<&[f64], Failure> {
        self.scratch.answers.clear();
        for reference in references {
            let value = self.read(reference, base)?;
            self.scratch.answers.push(value);
        }
        Ok(&self.scratch.answers)
    }

    /// Gives values to variables of a type: to all of them or, if one is refused, to none. A host that integrates may set
    /// continuous states as variables too.
    pub fn set(&mut self, base: Base, values: impl Iterator<Item = (u32, f64)> + Clone) -> Result<(), Failure> {
        let mut sets_inputs = false;
        let mut sets_parameters = false;
        let mut sets_states = false;
        for (reference, value) in values.clone() {
            let slot = self.layout.typed(reference, base)?;
            if let Err(refusal) = self.check_settable(&slot) {
                if self.keeps(&slot, value) {
                    continue;
                }
                return Err(refusal);
            }
            slot.variable.check(value)?;
            if slot.state.is_some() && self.record.mode == Mode::Instantiated {
                self.check_guess(slot.variable, value)?;
                continue;
            }
            match slot.place {
                Place::Input(place) => {
                    if !sets_inputs {
                        self.scratch.inputs.copy_from_slice(&self.record.inputs);
                        sets_inputs = true;
                    }
                    self.scratch.inputs[place] = value;
                }
                Place::Parameter(_) => sets_parameters = true,
                Place::Computed(_) => sets_states = true,
                Place::Time => {}
            }
        }
        if sets_parameters {
            self.scratch.parameters.copy_from_slice(&self.record.parameters);
            for (reference, value) in values.clone() {
                let slot = self.layout.typed(reference, base)?;
                if let Place::Parameter(place) = slot.place
                    && !self.keeps(&slot, value)
                {
                    self.scratch.parameters[place] = value;
                }
            }
            self.take_parameters()?;
        }
        if sets_states {
            let layout = Arc::clone(&self.layout);
            let state = |reference| layout.table.by_reference(reference)?.state;
            let states = values.clone().filter_map(|(reference, value)| Some((state(reference)?, value)));
            self.move_states(states)?;
        }
        if sets_inputs {
            std::mem::swap(&mut self.record.inputs, &mut self.scratch.inputs);
            self.take_inputs();
        }
        Ok(())
    }

    pub(super) fn read(&mut self, reference: u32, base: Base) -> Result<f64, Failure> {
        let slot = self.layout.typed(reference, base)?;
        let name = &slot.variable.name;
        if matches!(slot.place, Place::Computed(_)) && self.record.mode == Mode::Instantiated {
            return Err(Failure::error(format!("{name} is computed, from initialization mode on")));
        }
        let value = match slot.place {
            Place::Time => self.time(),
            Place::Input(place) => self.record.inputs[place],
            Place::Parameter(place) => self.layout.table.in_use(place, &self.record.parameters),
            Place::Computed(place) => self.run.value(place, &self.layout, &self.record)?,
        };
        if !value.is_finite() {
            return Err(Failure::error(format!("{name} is not a finite number but {value}")));
        }
        if slot.variable.kind == Kind::Integer && f64::from(value as i32) != value {
            return Err(Failure::error(format!("{name} = {value} is no 32-bit integer")));
        }
        Ok(value)
    }

    /// Refuses a start value other than in the description, since states start from parameters and inputs. The described one
    /// may be set, with no effect: the standards call it a guess.
    fn check_guess(&self, state: &Variable, value: f64) -> Result<(), Failure> {
        let Layout { model, parameters, inputs, .. } = &*self.layout;
        let start = model.starts_with(parameters, inputs)?.get(&state.reference).copied();
        if start == Some(value) {
            return Ok(());
        }
        let name = &state.name;
        let refusal = format!("{name} = {value} cannot be set before the run: it starts from parameters and inputs");
        // The name that all models give to the parameter of an initial value.
        let initial = self.layout.table.find(&format!("{name}0")).filter(|entry| entry.variable.is_parameter());
        Err(Failure::error(match initial {
            Some(initial) => format!("{refusal}; set {} instead", initial.variable.name),
            None => refusal,
        }))
    }

    /// Whether a value is the one that a fixed parameter has, or is in use for it, and can no longer change. Hosts may send it
    /// again at any time, with no effect.
    fn keeps(&self, slot: &Entry, value: f64) -> bool {
        let Place::Parameter(place) = slot.place else { return false };
        let parameters = &self.record.parameters;
        slot.variable.role == Role::Fixed
            && !settable(slot.variable).contains(&self.record.mode)
            && [parameters[place], self.layout.table.in_use(place, parameters)]
                .map(f64::to_bits)
                .contains(&value.to_bits())
    }

    fn check_settable(&self, slot: &Entry) -> Result<(), Failure> {
        let variable = slot.variable;
        if slot.state.is_none() {
            self.layout.check_kept(variable)?;
        }
        let modes = if slot.state.is_some() { STATES_SETTABLE } else { settable(variable) };
        if modes.contains(&self.record.mode) { Ok(()) } else { Err(not_settable(variable, modes)) }
    }

    /// Takes over the parameters in the scratch; a running simulation checks them as a whole, others when they start.
    fn take_parameters(&mut self) -> Result<(), Failure> {
        if self.record.is_running() {
            self.run.retune(&self.layout, &self.record, &self.scratch.parameters)?;
        } else {
            self.run.discard();
        }
        self.record.parameters.copy_from_slice(&self.scratch.parameters);
        Ok(())
    }

    fn take_inputs(&mut self) {
        if self.record.is_running() {
            self.run.inputs_changed();
        } else {
            // Initial states may follow from inputs.
            self.run.discard();
        }
    }
}

/// Why a variable may not be set now, but in some modes.
#[cold]
fn not_settable(variable: &Variable, modes: &[Mode]) -> Failure {
    let name = &variable.name;
    Failure::error(match variable.role {
        Role::Time => format!("{name} is the independent variable and cannot be set"),
        Role::Output | Role::Local => format!("{name} is computed and cannot be set"),
        _ => format!("{name} can only be set {}", describe(modes)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::testing::{self, HIGH, INPUT, LAG, LOW, OUTPUT, POSITIVE, STATE, STEPS, SUPPLY, TRAP};

    fn real(instance: &mut Instance, reference: u32) -> f64 {
        testing::real(instance, reference).expect("a readable variable")
    }

    fn set(instance: &mut Instance, reference: u32, value: f64) -> Result<(), Failure> {
        instance.set(Base::Real, [(reference, value)].into_iter())
    }

    fn initialized() -> Instance {
        let mut instance = testing::instance();
        instance.enter_initialization_mode().expect("initialization");
        instance.exit_initialization_mode().expect("initialized");
        instance
    }

    #[test]
    fn start_values_can_be_read_before_initialization_but_computed_ones_cannot() {
        let mut instance = testing::instance();
        assert_eq!([INPUT, LAG, LOW, 0].map(|it| real(&mut instance, it)), [1.0, 0.5, 1.0, 0.0]);
        let failure = testing::real(&mut instance, STATE).expect_err("not yet");
        assert!(failure.message.contains("state is computed"), "{failure:?}");
    }

    #[test]
    fn computed_values_follow_parameters_and_inputs_during_initialization() {
        let mut instance = testing::instance();
        instance.enter_initialization_mode().expect("initialization");
        assert_eq!(real(&mut instance, OUTPUT), 4.0);
        set(&mut instance, HIGH, 10.0).expect("legal");
        set(&mut instance, INPUT, 3.0).expect("legal");
        assert_eq!(real(&mut instance, OUTPUT), 16.0);
    }

    #[test]
    fn computed_values_follow_inputs_between_steps_without_a_step() {
        let mut instance = initialized();
        set(&mut instance, INPUT, 3.0).expect("legal");
        assert_eq!((real(&mut instance, OUTPUT), real(&mut instance, STATE)), (8.0, 0.0));
        set(&mut instance, INPUT, 1.0).expect("legal");
        assert_eq!((real(&mut instance, OUTPUT), real(&mut instance, STATE)), (4.0, 0.0));
    }

    #[test]
    fn one_bad_value_keeps_all_of_a_call_from_being_set() {
        let mut instance = testing::instance();
        for (references, bad) in
            [([INPUT, SUPPLY], -1.0), ([INPUT, STATE], 1.0), ([INPUT, 999], 1.0), ([INPUT, LAG], 0.0)]
        {
            let values = references.into_iter().zip([7.0, bad]);
            let failed = instance.set(Base::Real, values);
            assert!(failed.is_err() && real(&mut instance, INPUT) == 1.0, "{references:?}");
        }
    }

    #[test]
    fn nothing_is_handed_out_if_one_reference_is_bad() {
        let mut instance = initialized();
        for references in [[INPUT, 999], [INPUT, TRAP], [INPUT, POSITIVE]] {
            assert!(instance.get(Base::Real, references.into_iter()).is_err());
        }
    }

    #[test]
    fn fixed_parameters_and_inputs_have_their_times() {
        let mut instance = initialized();
        let failure = set(&mut instance, LAG, 0.6).expect_err("fixed");
        let expected = "lag can only be set before initialization or in initialization mode";
        assert_eq!(failure.message, expected);
        set(&mut instance, HIGH, 3.0).expect("tunable");
        set(&mut instance, SUPPLY, 3.0).expect("an input");
        instance.terminate().expect("terminated");
        assert!(set(&mut instance, SUPPLY, 4.0).is_err() && real(&mut instance, SUPPLY) == 3.0);
    }

    #[test]
    fn tuned_parameters_take_effect_together_or_not_at_all() {
        let mut instance = initialized();
        let failure = set(&mut instance, LOW, 5.0).expect_err("above high");
        assert_eq!(failure.message, "low = 5 is refused: it must not exceed high");
        assert_eq!((real(&mut instance, LOW), real(&mut instance, OUTPUT)), (1.0, 4.0));
        instance.set(Base::Real, [(LOW, 5.0), (HIGH, 5.0)].into_iter()).expect("legal together");
        assert_eq!((real(&mut instance, LOW), real(&mut instance, OUTPUT)), (5.0, 7.0));
    }

    #[test]
    fn combination_of_parameters_is_refused_by_name_at_the_end_of_initialization() {
        let mut instance = testing::instance();
        instance.enter_initialization_mode().expect("initialization");
        set(&mut instance, LOW, 5.0).expect("legal by itself");
        assert!(testing::real(&mut instance, OUTPUT).is_err());
        let failure = instance.exit_initialization_mode().expect_err("low > high");
        assert_eq!(failure.message, "low = 5 is refused: it must not exceed high");
        assert_eq!(instance.mode(), Mode::Initialization);
        set(&mut instance, HIGH, 6.0).expect("legal");
        instance.exit_initialization_mode().expect("corrected");
    }

    #[test]
    fn integers_and_enumerations_keep_their_items() {
        let mut instance = testing::instance();
        assert!(instance.set(Base::Integer, [(TRAP, 99.0)].into_iter()).is_err());
        assert!(instance.set(Base::Integer, [(STEPS, 1.0)].into_iter()).is_err());
        instance.set(Base::Integer, [(TRAP, 1.0)].into_iter()).expect("an item");
        assert_eq!(instance.get(Base::Integer, [TRAP].into_iter()), Ok(&[1.0][..]));
    }

    #[test]
    fn last_of_repeated_references_counts() {
        let mut instance = testing::instance();
        instance.set(Base::Real, [(INPUT, 5.0), (INPUT, 6.0)].into_iter()).expect("legal");
        assert_eq!(real(&mut instance, INPUT), 6.0);
    }
}
