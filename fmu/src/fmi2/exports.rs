//! The exported C functions: all functions of FMI 2.0, and nothing else. The one that makes instances calls
//! [`instantiate`] with the models of the library, from [`export_fmu!`](crate::export_fmu).
//!
//! Each turns pointers into lists that are read and written element by element, and hands everything to
//! `Handle::call`.
//!
//! # Safety
//! See `crate::c_interface`.

#![allow(unsafe_code, reason = "this is the C interface")]
#![allow(non_snake_case, reason = "the standard's names")]
#![allow(clippy::missing_safety_doc, reason = "the module states it for all functions")]
#![allow(clippy::too_many_arguments, reason = "the standard's signatures")]

use std::ffi::{c_int, c_void};
use std::mem::transmute;
use std::ptr;

use super::callbacks::sink;
use super::status;
use super::types::{
    Boolean, Byte, CO_SIMULATION, CallbackFunctions, Component, EventInfo, FmuState, FmuType, Integer, MODEL_EXCHANGE,
    Real, Status, Text, ValueReference,
};
use crate::c_interface::{
    call, choose_log, deserialize, forget, free, hand_out, save, serialize, set_states, tell, vector,
};
use crate::calls::Call;
use crate::failure::Failure;
use crate::host::{Input, Output, text};
use crate::instance::{self, Base, Instance, Kind, Library, Resources, Vector, Wanted};

/// Types of the standard's default platform.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> Text {
    c"default".as_ptr()
}

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> Text {
    c"2.0".as_ptr()
}

/// Makes an instance of the model of a library with a GUID, as `fmi2Instantiate` does; NULL, and a message, if there is
/// none.
pub unsafe fn instantiate(
    library: &'static Library,
    instance_name: Text,
    fmu_type: FmuType,
    guid: Text,
    resource_location: Text,
    functions: *const CallbackFunctions,
    _visible: Boolean,
    logging_on: Boolean,
) -> Component {
    // SAFETY: the host passes NULL or strings, and NULL or its callbacks, which `CallbackFunctions` describes.
    let (name, guid, location, functions) = unsafe {
        (text(instance_name), text(guid), text(resource_location), (!functions.is_null()).then(|| functions.read()))
    };
    let name = name.unwrap_or_default();
    let guid = guid.map(|guid| guid.to_string_lossy().into_owned());
    let wanted = Wanted {
        function: "fmi2Instantiate",
        guid_is_called: "GUID",
        kind: if fmu_type == MODEL_EXCHANGE { Kind::ModelExchange } else { Kind::CoSimulation },
        name: &name.to_string_lossy(),
        guid: guid.as_deref(),
        resources: location.as_deref().map(Resources::Uri),
        logging_on: logging_on != 0,
    };
    let check = || match fmu_type {
        MODEL_EXCHANGE | CO_SIMULATION => Ok(()),
        _ => Err(Failure::error(format!("fmuType {fmu_type} is neither fmi2ModelExchange nor fmi2CoSimulation"))),
    };
    hand_out(instance::instantiate(library, &wanted, sink(name.clone(), functions), check))
}

/// Frees an instance and the states it has saved. Refused while another call of the instance runs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(component: Component) {
    // SAFETY: of the module.
    unsafe { free(component, "fmi2FreeInstance") }
}

exports! {
    besides {
        fn fmi2GetTypesPlatform() -> Text;
        fn fmi2GetVersion() -> Text;
        fn fmi2FreeInstance(Component);
    }

    outside {
        fn fmi2Instantiate(Text, FmuType, Text, Text, *const CallbackFunctions, Boolean, Boolean) -> Component;
    }

    /// Switches logging on for some categories (for all, if none is named) or off. Failures are always logged.
    fn fmi2SetDebugLogging(logging_on: Boolean, number: usize, categories: *const Text) => ChooseLog, |instance| {
        choose_log(instance, logging_on != 0, number, categories)
    };

    /// Sets start time, stop time and tolerance; without it a run starts at 0 s, without end.
    fn fmi2SetupExperiment(
        tolerance_defined: Boolean,
        tolerance: Real,
        start_time: Real,
        stop_time_defined: Boolean,
        stop_time: Real
    ) => SetUpExperiment, |instance| {
        let tolerance = (tolerance_defined != 0).then_some(tolerance);
        let stop = (stop_time_defined != 0).then_some(stop_time);
        instance.setup_experiment(tolerance, start_time, stop)
    };

    /// From now on computed values can be read; they follow parameters and inputs.
    fn fmi2EnterInitializationMode() => EnterInitialization, |instance| instance.enter_initialization_mode();

    /// Refused if parameters do not fit together.
    fn fmi2ExitInitializationMode() => ExitInitialization, |instance| instance.exit_initialization_mode();

    /// Ends the run; everything can still be read.
    fn fmi2Terminate() => Terminate, |instance| instance.terminate();

    /// Goes back to the state after `fmi2Instantiate`; logging and saved states stay.
    fn fmi2Reset() => Reset, |instance| instance.reset();

    /// Reads real variables.
    fn fmi2GetReal(references: *const ValueReference, number: usize, values: *mut Real) => Get, |instance| {
        get(instance, Base::Real, references, number, values, |value| value)
    };

    /// Reads integers and enumerations.
    fn fmi2GetInteger(references: *const ValueReference, number: usize, values: *mut Integer) => Get, |instance| {
        get(instance, Base::Integer, references, number, values, |value| value as Integer)
    };

    /// Reads Booleans.
    fn fmi2GetBoolean(references: *const ValueReference, number: usize, values: *mut Boolean) => Get, |instance| {
        get(instance, Base::Boolean, references, number, values, |value| Boolean::from(value != 0.0))
    };

    /// There is no variable of type String, so that any value reference is refused.
    fn fmi2GetString(references: *const ValueReference, number: usize, values: *mut Text) => Get, |instance| {
        get(instance, Base::Absent("String"), references, number, values, |_| ptr::null())
    };

    /// Sets real inputs, parameters and, in model exchange, states: all of them, or none if one is refused.
    fn fmi2SetReal(references: *const ValueReference, number: usize, values: *const Real) => Set, |instance| {
        set(instance, Base::Real, references, number, values, |value| value)
    };

    /// Sets integer and enumeration parameters: all of them, or none if one is refused.
    fn fmi2SetInteger(references: *const ValueReference, number: usize, values: *const Integer) => Set, |instance| {
        set(instance, Base::Integer, references, number, values, f64::from)
    };

    /// Sets Boolean inputs and parameters: all of them, or none if one is refused.
    fn fmi2SetBoolean(references: *const ValueReference, number: usize, values: *const Boolean) => Set, |instance| {
        set(instance, Base::Boolean, references, number, values, f64::from)
    };

    /// There is no variable of type String, so that any value reference is refused.
    fn fmi2SetString(references: *const ValueReference, number: usize, values: *const Text) => Set, |instance| {
        set(instance, Base::Absent("String"), references, number, values, |_| f64::NAN)
    };

    /// Saves everything that affects the further run; the handle may be NULL or one to save over.
    fn fmi2GetFMUstate(state: *mut FmuState) => UseState, |instance| save(instance, state);

    /// Goes back to a saved state.
    fn fmi2SetFMUstate(state: FmuState) => UseState, |instance| instance.set_state(state.addr());

    /// Frees a saved state.
    fn fmi2FreeFMUstate(state: *mut FmuState) => UseState, |instance| forget(instance, state);

    /// Size of a saved state in bytes.
    fn fmi2SerializedFMUstateSize(state: FmuState, size: *mut usize) => UseState, |instance| {
        tell(size, instance.serialized(state.addr()).map(|bytes| bytes.len()))
    };

    /// Writes a saved state as bytes; the size must be the one told.
    fn fmi2SerializeFMUstate(state: FmuState, bytes: *mut Byte, size: usize) => UseState, |instance| {
        serialize(instance, state, bytes, size)
    };

    /// Takes a saved state from bytes, of any instance of the same kind, model and build on any platform.
    fn fmi2DeSerializeFMUstate(bytes: *const Byte, size: usize, state: *mut FmuState) => UseState, |instance| {
        deserialize(instance, bytes, size, state)
    };

    /// The exact derivative of computed reals in one direction of time, inputs, continuous states and tunable parameters.
    fn fmi2GetDirectionalDerivative(
        unknowns: *const ValueReference,
        number_of_unknowns: usize,
        knowns: *const ValueReference,
        number_of_knowns: usize,
        seeds: *const Real,
        derivatives: *mut Real
    ) => Differentiate, |instance| {
        let unknowns = Input::new(unknowns, number_of_unknowns, "vUnknown_ref")?;
        let knowns = Input::new(knowns, number_of_knowns, "vKnown_ref")?;
        let seeds = Input::new(seeds, number_of_knowns, "dvKnown")?;
        let derivatives = Output::new(derivatives, number_of_unknowns, "dvUnknown")?;
        let values = instance.directional_derivative(unknowns.iter(), knowns.iter().zip(seeds.iter()))?;
        derivatives.write(values.iter().copied());
        Ok(())
    };

    /// Sets slopes of inputs, which hold for the next step.
    fn fmi2SetRealInputDerivatives(
        references: *const ValueReference,
        number: usize,
        orders: *const Integer,
        values: *const Real
    ) => SetSlopes, |instance| {
        let references = Input::new(references, number, "vr")?;
        let orders = Input::new(orders, number, "order")?;
        let values = Input::new(values, number, "value")?;
        let slopes = references.iter().zip(orders.iter()).zip(values.iter());
        instance.set_input_derivatives(slopes.map(|((reference, order), value)| (reference, order, value)))
    };

    /// The exact first derivatives of real outputs with respect to time.
    fn fmi2GetRealOutputDerivatives(
        references: *const ValueReference,
        number: usize,
        orders: *const Integer,
        values: *mut Real
    ) => GetOutputRates, |instance| {
        let references = Input::new(references, number, "vr")?;
        let orders = Input::new(orders, number, "order")?;
        let values = Output::new(values, number, "value")?;
        values.write(instance.output_derivatives(references.iter().zip(orders.iter()))?.iter().copied());
        Ok(())
    };

    /// Goes on to an event, where inputs may jump.
    fn fmi2EnterEventMode() => EnterEvent, |instance| instance.enter_event_mode();

    /// Updates the discrete part of the model; one update settles everything.
    fn fmi2NewDiscreteStates(info: *mut EventInfo) => Update, |instance| {
        let info = Output::new(info, 1, "eventInfo")?;
        let update = instance.update()?;
        let info_now = EventInfo {
            values_of_continuous_states_changed: update.changes_states.into(),
            next_event_time_defined: update.next_time_event.is_some().into(),
            next_event_time: update.next_time_event.unwrap_or_default(),
            ..EventInfo::default()
        };
        info.write([info_now].into_iter());
        Ok(())
    };

    /// Goes on to integrate.
    fn fmi2EnterContinuousTimeMode() => EnterContinuousTime, |instance| instance.enter_continuous_time_mode();

    /// Lets the memories of the model follow a step of the host's solver, refused at states without a meaning; never asks for
    /// an event.
    fn fmi2CompletedIntegratorStep(
        _no_set_fmu_state_prior_to_current_point: Boolean,
        enter_event_mode: *mut Boolean,
        terminate_simulation: *mut Boolean
    ) => AcceptStep, |instance| {
        let enter_event_mode = Output::new(enter_event_mode, 1, "enterEventMode")?;
        let terminate_simulation = Output::new(terminate_simulation, 1, "terminateSimulation")?;
        instance.accept_step()?;
        enter_event_mode.write([0].into_iter());
        terminate_simulation.write([0].into_iter());
        Ok(())
    };

    /// Sets the time.
    fn fmi2SetTime(time: Real) => SetTime, |instance| instance.set_time(time);

    /// Sets the continuous states: all of them, or none if one is refused.
    fn fmi2SetContinuousStates(states: *const Real, number: usize) => SetStates, |instance| {
        set_states(instance, states, number)
    };

    /// Reads the derivatives of the continuous states; discarded where one is no finite number.
    fn fmi2GetDerivatives(values: *mut Real, number: usize) => GetRates, |instance| {
        vector(instance, Vector::Derivatives, values, number)
    };

    /// Reads the event indicators.
    fn fmi2GetEventIndicators(values: *mut Real, number: usize) => GetStates, |instance| {
        vector(instance, Vector::Indicators, values, number)
    };

    /// Reads the continuous states.
    fn fmi2GetContinuousStates(values: *mut Real, number: usize) => GetStates, |instance| {
        vector(instance, Vector::States, values, number)
    };

    /// Reads the magnitudes of the continuous states.
    fn fmi2GetNominalsOfContinuousStates(values: *mut Real, number: usize) => GetMagnitudes, |instance| {
        vector(instance, Vector::Nominals, values, number)
    };

    /// Integrates to exactly the communication point plus the step size.
    fn fmi2DoStep(
        current_communication_point: Real,
        communication_step_size: Real,
        _no_set_fmu_state_prior_to_current_point: Boolean
    ) => Step, |instance| instance.do_step(current_communication_point, communication_step_size).map(|_| ());

    /// Always refused: a step is never pending.
    fn fmi2CancelStep() => CancelStep, |_instance| Ok(());

    /// Tells whether the last step was completed or discarded (`fmi2DoStepStatus`).
    fn fmi2GetStatus(kind: c_int, value: *mut Status) => AskAboutStep, |instance| {
        tell(value, status::of_step(instance, kind))
    };

    /// Tells up to which time all is well (`fmi2LastSuccessfulTime`).
    fn fmi2GetRealStatus(kind: c_int, value: *mut Real) => AskAboutStep, |instance| {
        tell(value, status::last_successful_time(instance, kind))
    };

    /// There is no such status.
    fn fmi2GetIntegerStatus(kind: c_int, value: *mut Integer) => AskAboutStep, |_instance| {
        tell(value, status::none(kind))
    };

    /// Tells whether the instance wants to terminate, after a discarded step (`fmi2Terminated`).
    fn fmi2GetBooleanStatus(kind: c_int, value: *mut Boolean) => AskAboutStep, |instance| {
        tell(value, status::wants_to_terminate(instance, kind))
    };

    /// There is no such status, since no step is ever pending.
    fn fmi2GetStringStatus(kind: c_int, value: *mut Text) => AskAboutStep, |_instance| tell(value, status::none(kind));
}

unsafe fn get<T: Copy>(
    instance: &mut Instance,
    base: Base,
    references: *const ValueReference,
    number: usize,
    values: *mut T,
    convert: impl Fn(f64) -> T,
) -> Result<(), Failure> {
    // SAFETY: of the module.
    let (references, values) =
        unsafe { (Input::new(references, number, "vr")?, Output::new(values, number, "value")?) };
    values.write(instance.get(base, references.iter())?.iter().map(|value| convert(*value)));
    Ok(())
}

unsafe fn set<T: Copy>(
    instance: &mut Instance,
    base: Base,
    references: *const ValueReference,
    number: usize,
    values: *const T,
    convert: impl Fn(T) -> f64 + Clone,
) -> Result<(), Failure> {
    // SAFETY: of the module.
    let (references, values) = unsafe { (Input::new(references, number, "vr")?, Input::new(values, number, "value")?) };
    instance.set(base, references.iter().zip(values.iter().map(convert)))
}
