//! The exported C functions: all functions of FMI 3.0, and nothing else. Those that make instances call
//! [`instantiation`](super::instantiation) with the models of the library, from [`export_fmu!`](crate::export_fmu).
//!
//! Each turns pointers into lists that are read and written element by element, and hands everything to
//! `Handle::call`. Functions that the FMU does not offer are refused with a reason.
//!
//! # Safety
//! See `crate::c_interface`.

#![allow(unsafe_code, reason = "this is the C interface")]
#![allow(non_snake_case, reason = "the standard's names")]
#![allow(clippy::missing_safety_doc, reason = "the module states it for all functions")]
#![allow(clippy::too_many_arguments, reason = "the standard's signatures")]

use std::ffi::c_void;
use std::mem::transmute;

use super::types::{
    Binary, Boolean, Clock, ClockUpdate, DEPENDENT, DependencyKind, FmuState, Instance as Component,
    InstanceEnvironment, IntermediateUpdate, IntervalQualifier, LogMessage, Preemption, Status, Text, ValueReference,
};
use super::values::{absent, get, set};
use crate::c_interface::{call, choose_log, deserialize, forget, free, save, serialize, set_states, tell, vector};
use crate::calls::Call;
use crate::failure::Failure;
use crate::host::{Input, Output};
use crate::instance::{Base, Instance, Vector};

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> Text {
    c"3.0".as_ptr()
}

/// Frees an instance and the states it has saved. Refused while another call of the instance runs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: Component) {
    // SAFETY: of the module.
    unsafe { free(instance, "fmi3FreeInstance") }
}

/// Declares the functions that read and set numbers from a line each, before all others.
macro_rules! exports_with_numbers {
    (
        besides { $($besides:tt)* }
        outside { $($outside:tt)* }
        numbers { $($get:ident, $set:ident: $type:ty => $base:expr;)* }
        $($others:tt)*
    ) => {
        exports! {
            besides { $($besides)* }
            outside { $($outside)* }
            $(
                /// Reads variables of this type: arrays, each by its value reference, one after the other.
                fn $get(
                    references: *const ValueReference, number: usize, values: *mut $type, room: usize
                ) => Get, |instance| get(instance, $base, references, number, values, room);

                /// Sets variables of this type: all of them, or none if one element is refused.
                fn $set(
                    references: *const ValueReference, number: usize, values: *const $type, room: usize
                ) => Set, |instance| set(instance, $base, references, number, values, room);
            )*
            $($others)*
        }
    };
}

exports_with_numbers! {
    besides {
        fn fmi3GetVersion() -> Text;
        fn fmi3FreeInstance(Component);
    }

    outside {
        fn fmi3InstantiateModelExchange(
            Text, Text, Text, Boolean, Boolean, InstanceEnvironment, Option<LogMessage>
        ) -> Component;
        fn fmi3InstantiateCoSimulation(
            Text, Text, Text, Boolean, Boolean, Boolean, Boolean, *const ValueReference, usize, InstanceEnvironment,
            Option<LogMessage>, Option<IntermediateUpdate>
        ) -> Component;
        fn fmi3InstantiateScheduledExecution(
            Text, Text, Text, Boolean, Boolean, InstanceEnvironment, Option<LogMessage>, Option<ClockUpdate>,
            Option<Preemption>, Option<Preemption>
        ) -> Component;
    }

    numbers {
        fmi3GetFloat32, fmi3SetFloat32: f32 => Base::Absent("Float32");
        fmi3GetFloat64, fmi3SetFloat64: f64 => Base::Real;
        fmi3GetInt8, fmi3SetInt8: i8 => Base::Absent("Int8");
        fmi3GetUInt8, fmi3SetUInt8: u8 => Base::Absent("UInt8");
        fmi3GetInt16, fmi3SetInt16: i16 => Base::Absent("Int16");
        fmi3GetUInt16, fmi3SetUInt16: u16 => Base::Absent("UInt16");
        fmi3GetInt32, fmi3SetInt32: i32 => Base::Count;
        fmi3GetUInt32, fmi3SetUInt32: u32 => Base::Absent("UInt32");
        fmi3GetInt64, fmi3SetInt64: i64 => Base::Enumeration;
        fmi3GetUInt64, fmi3SetUInt64: u64 => Base::Absent("UInt64");
        fmi3GetBoolean, fmi3SetBoolean: Boolean => Base::Boolean;
    }

    /// There is no variable of type String, so that any value reference is refused.
    fn fmi3GetString(
        references: *const ValueReference, number: usize, _values: *mut Text, _room: usize
    ) => Get, |instance| absent(instance, "String", references, number);

    /// There is no variable of type String, so that any value reference is refused.
    fn fmi3SetString(
        references: *const ValueReference, number: usize, _values: *const Text, _room: usize
    ) => Set, |instance| absent(instance, "String", references, number);

    /// There is no variable of type Binary, so that any value reference is refused.
    fn fmi3GetBinary(
        references: *const ValueReference, number: usize, _sizes: *mut usize, _values: *mut Binary, _room: usize
    ) => Get, |instance| absent(instance, "Binary", references, number);

    /// There is no variable of type Binary, so that any value reference is refused.
    fn fmi3SetBinary(
        references: *const ValueReference, number: usize, _sizes: *const usize, _values: *const Binary, _room: usize
    ) => Set, |instance| absent(instance, "Binary", references, number);

    /// There are no clocks, so that any value reference is refused.
    fn fmi3GetClock(references: *const ValueReference, number: usize, _values: *mut Clock) => Get, |instance| {
        absent(instance, "Clock", references, number)
    };

    /// There are no clocks, so that any value reference is refused.
    fn fmi3SetClock(references: *const ValueReference, number: usize, _values: *const Clock) => Set, |instance| {
        absent(instance, "Clock", references, number)
    };

    /// There are no clocks, so that any value reference is refused.
    fn fmi3GetIntervalDecimal(
        references: *const ValueReference, number: usize, _intervals: *mut f64, _qualifiers: *mut IntervalQualifier
    ) => Get, |instance| absent(instance, "Clock", references, number);

    /// There are no clocks, so that any value reference is refused.
    fn fmi3GetIntervalFraction(
        references: *const ValueReference, number: usize, _counters: *mut u64, _resolutions: *mut u64,
        _qualifiers: *mut IntervalQualifier
    ) => Get, |instance| absent(instance, "Clock", references, number);

    /// There are no clocks, so that any value reference is refused.
    fn fmi3GetShiftDecimal(references: *const ValueReference, number: usize, _shifts: *mut f64) => Get, |instance| {
        absent(instance, "Clock", references, number)
    };

    /// There are no clocks, so that any value reference is refused.
    fn fmi3GetShiftFraction(
        references: *const ValueReference, number: usize, _counters: *mut u64, _resolutions: *mut u64
    ) => Get, |instance| absent(instance, "Clock", references, number);

    /// There are no clocks, so that any value reference is refused.
    fn fmi3SetIntervalDecimal(
        references: *const ValueReference, number: usize, _intervals: *const f64
    ) => Set, |instance| absent(instance, "Clock", references, number);

    /// There are no clocks, so that any value reference is refused.
    fn fmi3SetIntervalFraction(
        references: *const ValueReference, number: usize, _counters: *const u64, _resolutions: *const u64
    ) => Set, |instance| absent(instance, "Clock", references, number);

    /// There are no clocks, so that any value reference is refused.
    fn fmi3SetShiftDecimal(references: *const ValueReference, number: usize, _shifts: *const f64) => Set, |instance| {
        absent(instance, "Clock", references, number)
    };

    /// There are no clocks, so that any value reference is refused.
    fn fmi3SetShiftFraction(
        references: *const ValueReference, number: usize, _counters: *const u64, _resolutions: *const u64
    ) => Set, |instance| absent(instance, "Clock", references, number);

    /// Switches logging on for some categories (for all, if none is named) or off. Failures are always logged.
    fn fmi3SetDebugLogging(logging_on: Boolean, number: usize, categories: *const Text) => ChooseLog, |instance| {
        choose_log(instance, logging_on != 0, number, categories)
    };

    /// Sets tolerance, start time and stop time. From now on computed values can be read; they follow parameters and
    /// inputs.
    fn fmi3EnterInitializationMode(
        tolerance_defined: Boolean, tolerance: f64, start_time: f64, stop_time_defined: Boolean, stop_time: f64
    ) => EnterInitialization, |instance| {
        let tolerance = (tolerance_defined != 0).then_some(tolerance);
        let stop = (stop_time_defined != 0).then_some(stop_time);
        instance.setup_experiment(tolerance, start_time, stop)?;
        instance.enter_initialization_mode()
    };

    /// Refused if parameters do not fit together.
    fn fmi3ExitInitializationMode() => ExitInitialization, |instance| instance.exit_initialization_mode();

    /// Goes on to an event, where inputs may jump.
    fn fmi3EnterEventMode() => LeaveForEvent, |instance| instance.enter_event_mode();

    /// Ends the run; everything can still be read.
    fn fmi3Terminate() => Terminate, |instance| instance.terminate();

    /// Goes back to the state after instantiation; logging and saved states stay.
    fn fmi3Reset() => Reset, |instance| instance.reset();

    /// Always refused: there are no structural parameters.
    fn fmi3EnterConfigurationMode() => UseWhatIsNotOffered, |_instance| {
        Err(Failure::error("there is nothing to configure: no parameter is structural"))
    };

    /// Always refused: there are no structural parameters.
    fn fmi3ExitConfigurationMode() => UseWhatIsNotOffered, |_instance| {
        Err(Failure::error("there is nothing to configure: no parameter is structural"))
    };

    /// Number of dependencies of a variable in `fmi3GetVariableDependencies`.
    fn fmi3GetNumberOfVariableDependencies(
        reference: ValueReference, number: *mut usize
    ) => AskAboutModel, |instance| {
        tell(number, instance.dependencies(reference).map(|dependencies| dependencies.len()))
    };

    /// Direct dependencies of a variable.
    fn fmi3GetVariableDependencies(
        dependent: ValueReference, elements: *mut usize, independents: *mut ValueReference,
        elements_of_independents: *mut usize, kinds: *mut DependencyKind, number: usize
    ) => AskAboutModel, |instance| {
        let found = instance.dependencies(dependent)?;
        if found.len() != number {
            return Err(Failure::error(format!("there are {} dependencies, not {number}", found.len())));
        }
        let elements = Output::new(elements, number, "elementIndicesOfDependent")?;
        let independents = Output::new(independents, number, "independents")?;
        let elements_of_independents = Output::new(elements_of_independents, number, "elementIndicesOfIndependents")?;
        let kinds = Output::new(kinds, number, "dependencyKinds")?;
        // Arrays are parameters only, so dependences are between whole variables.
        elements.write(found.iter().map(|_| 0));
        independents.write(found.iter().copied());
        elements_of_independents.write(found.iter().map(|_| 0));
        kinds.write(found.iter().map(|_| DEPENDENT));
        Ok(())
    };

    /// Saves everything that affects the further run; the handle may be NULL or one to save over.
    fn fmi3GetFMUState(state: *mut FmuState) => UseState, |instance| save(instance, state);

    /// Goes back to a saved state.
    fn fmi3SetFMUState(state: FmuState) => UseState, |instance| instance.set_state(state.addr());

    /// Frees a saved state.
    fn fmi3FreeFMUState(state: *mut FmuState) => UseState, |instance| forget(instance, state);

    /// Size of a saved state in bytes.
    fn fmi3SerializedFMUStateSize(state: FmuState, size: *mut usize) => UseState, |instance| {
        tell(size, instance.serialized(state.addr()).map(|bytes| bytes.len()))
    };

    /// Writes a saved state as bytes; the size must be the one told.
    fn fmi3SerializeFMUState(state: FmuState, bytes: *mut u8, size: usize) => UseState, |instance| {
        serialize(instance, state, bytes, size)
    };

    /// Takes a saved state from bytes, of any instance of the same kind, model and build on any platform.
    fn fmi3DeserializeFMUState(bytes: *const u8, size: usize, state: *mut FmuState) => UseState, |instance| {
        deserialize(instance, bytes, size, state)
    };

    /// The exact derivative of computed reals in one direction of time, inputs, continuous states and tunable parameters.
    fn fmi3GetDirectionalDerivative(
        unknowns: *const ValueReference, number_of_unknowns: usize,
        knowns: *const ValueReference, number_of_knowns: usize,
        seeds: *const f64, number_of_seeds: usize,
        sensitivities: *mut f64, number_of_sensitivities: usize
    ) => Differentiate, |instance| {
        let unknowns = Input::new(unknowns, number_of_unknowns, "unknowns")?;
        let knowns = Input::new(knowns, number_of_knowns, "knowns")?;
        let seeds = Input::new(seeds, number_of_seeds, "seed")?;
        let sensitivities = Output::new(sensitivities, number_of_sensitivities, "sensitivity")?;
        let unknowns = instance.elements(unknowns.iter(), number_of_sensitivities)?;
        let knowns = instance.elements(knowns.iter(), number_of_seeds)?;
        let values = instance.directional_derivative(unknowns, knowns.zip(seeds.iter()))?;
        sensitivities.write(values.iter().copied());
        Ok(())
    };

    /// The exact derivative of a sum of computed reals with respect to time, inputs, continuous states and tunable
    /// parameters.
    fn fmi3GetAdjointDerivative(
        unknowns: *const ValueReference, number_of_unknowns: usize,
        knowns: *const ValueReference, number_of_knowns: usize,
        seeds: *const f64, number_of_seeds: usize,
        sensitivities: *mut f64, number_of_sensitivities: usize
    ) => Differentiate, |instance| {
        let unknowns = Input::new(unknowns, number_of_unknowns, "unknowns")?;
        let knowns = Input::new(knowns, number_of_knowns, "knowns")?;
        let seeds = Input::new(seeds, number_of_seeds, "seed")?;
        let sensitivities = Output::new(sensitivities, number_of_sensitivities, "sensitivity")?;
        let unknowns = instance.elements(unknowns.iter(), number_of_seeds)?;
        let knowns = instance.elements(knowns.iter(), number_of_sensitivities)?;
        let values = instance.adjoint_derivative(unknowns.zip(seeds.iter()), knowns)?;
        sensitivities.write(values.iter().copied());
        Ok(())
    };

    /// Always refused: `fmi3UpdateDiscreteStates` settles everything at once.
    fn fmi3EvaluateDiscreteStates() => UseWhatIsNotOffered, |_instance| {
        Err(Failure::error("discrete states are not evaluated apart from their update"))
    };

    /// Updates the discrete part of the model; one update settles everything.
    fn fmi3UpdateDiscreteStates(
        discrete_states_need_update: *mut Boolean, terminate_simulation: *mut Boolean,
        nominals_of_continuous_states_changed: *mut Boolean, values_of_continuous_states_changed: *mut Boolean,
        next_event_time_defined: *mut Boolean, next_event_time: *mut f64
    ) => Update, |instance| {
        let need_update = Output::new(discrete_states_need_update, 1, "discreteStatesNeedUpdate")?;
        let terminate = Output::new(terminate_simulation, 1, "terminateSimulation")?;
        let nominals = Output::new(nominals_of_continuous_states_changed, 1, "nominalsOfContinuousStatesChanged")?;
        let values = Output::new(values_of_continuous_states_changed, 1, "valuesOfContinuousStatesChanged")?;
        let is_defined = Output::new(next_event_time_defined, 1, "nextEventTimeDefined")?;
        let time = Output::new(next_event_time, 1, "nextEventTime")?;
        let update = instance.update()?;
        for never in [need_update, terminate, nominals] {
            never.write([0].into_iter());
        }
        values.write([update.changes_states.into()].into_iter());
        is_defined.write([update.next_time_event.is_some().into()].into_iter());
        time.write([update.next_time_event.unwrap_or_default()].into_iter());
        Ok(())
    };

    /// Goes on to integrate.
    fn fmi3EnterContinuousTimeMode() => EnterContinuousTime, |instance| instance.enter_continuous_time_mode();

    /// Lets the memories of the model follow a step of the host's solver, refused at states without a meaning; never asks for
    /// an event.
    fn fmi3CompletedIntegratorStep(
        _no_set_fmu_state_prior_to_current_point: Boolean,
        enter_event_mode: *mut Boolean, terminate_simulation: *mut Boolean
    ) => AcceptStep, |instance| {
        let enter_event_mode = Output::new(enter_event_mode, 1, "enterEventMode")?;
        let terminate_simulation = Output::new(terminate_simulation, 1, "terminateSimulation")?;
        instance.accept_step()?;
        enter_event_mode.write([0].into_iter());
        terminate_simulation.write([0].into_iter());
        Ok(())
    };

    /// Sets the time.
    fn fmi3SetTime(time: f64) => SetTime, |instance| instance.set_time(time);

    /// Sets the continuous states: all of them, or none if one is refused.
    fn fmi3SetContinuousStates(states: *const f64, number: usize) => SetStates, |instance| {
        set_states(instance, states, number)
    };

    /// Reads the derivatives of the continuous states; discarded where one is no finite number.
    fn fmi3GetContinuousStateDerivatives(values: *mut f64, number: usize) => GetStates, |instance| {
        vector(instance, Vector::Derivatives, values, number)
    };

    /// Reads the event indicators.
    fn fmi3GetEventIndicators(values: *mut f64, number: usize) => GetStates, |instance| {
        vector(instance, Vector::Indicators, values, number)
    };

    /// Reads the continuous states.
    fn fmi3GetContinuousStates(values: *mut f64, number: usize) => GetStates, |instance| {
        vector(instance, Vector::States, values, number)
    };

    /// Reads the magnitudes of the continuous states.
    fn fmi3GetNominalsOfContinuousStates(values: *mut f64, number: usize) => GetStates, |instance| {
        vector(instance, Vector::Nominals, values, number)
    };

    /// Number of event indicators.
    fn fmi3GetNumberOfEventIndicators(number: *mut usize) => AskAboutModel, |instance| {
        tell(number, Ok(instance.length(Vector::Indicators)))
    };

    /// Number of continuous states.
    fn fmi3GetNumberOfContinuousStates(number: *mut usize) => AskAboutModel, |instance| {
        tell(number, Ok(instance.length(Vector::States)))
    };

    /// Goes on to take steps.
    fn fmi3EnterStepMode() => EnterSteps, |instance| instance.enter_step_mode();

    /// The exact first derivatives of real outputs with respect to time.
    fn fmi3GetOutputDerivatives(
        references: *const ValueReference, number: usize, orders: *const i32, values: *mut f64, room: usize
    ) => GetOutputRates, |instance| {
        let references = Input::new(references, number, "valueReferences")?;
        let orders = Input::new(orders, number, "orders")?;
        let values = Output::new(values, room, "values")?;
        let outputs = instance.elements(references.iter(), room)?;
        values.write(instance.output_derivatives(outputs.zip(orders.iter()))?.iter().copied());
        Ok(())
    };

    /// Integrates to exactly the communication point plus the step size, or to an event on the way. An error, after which the
    /// host may restore, reset or free the instance, where that cannot be reached; the arguments then tell how far it came.
    fn fmi3DoStep(
        current_communication_point: f64, communication_step_size: f64,
        _no_set_fmu_state_prior_to_current_point: Boolean,
        event_handling_needed: *mut Boolean, terminate_simulation: *mut Boolean,
        early_return: *mut Boolean, last_successful_time: *mut f64
    ) => Step, |instance| {
        let event = Output::new(event_handling_needed, 1, "eventHandlingNeeded")?;
        let terminate = Output::new(terminate_simulation, 1, "terminateSimulation")?;
        let early = Output::new(early_return, 1, "earlyReturn")?;
        let time = Output::new(last_successful_time, 1, "lastSuccessfulTime")?;
        let step = instance.do_step(current_communication_point, communication_step_size);
        let last = instance.last_step();
        if step.is_ok() || last.failed {
            event.write([step.as_ref().is_ok_and(|step| step.event).into()].into_iter());
            terminate.write([last.failed.into()].into_iter());
            early.write([step.as_ref().is_ok_and(|step| step.is_early).into()].into_iter());
            time.write([last.successful_until].into_iter());
        }
        // A discarded call would change nothing, and could be repeated with a shorter step.
        step.map(|_| ()).map_err(|failure| Failure::error(failure.message))
    };

    /// Always refused: there are no model partitions.
    fn fmi3ActivateModelPartition(
        _clock_reference: ValueReference, _activation_time: f64
    ) => UseWhatIsNotOffered, |_instance| {
        Err(Failure::error("there are no model partitions: the model has no clocks"))
    };
}
