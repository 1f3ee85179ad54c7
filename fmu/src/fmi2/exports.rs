//! The exported C functions: all common and co-simulation functions of FMI 2.0, and nothing else.
//!
//! This is the only file with `unsafe`. It turns pointers into slices, calls the host's logger, and hands everything
//! to `Handle::call`.
//!
//! # Safety
//! What every function relies on, as the standard asks of the host:
//! - a component is NULL or was returned by [`fmi2Instantiate`] and not yet freed;
//! - a pointer that comes with a number of elements is NULL or points to that many elements, and is not written to
//!   by another thread during the call;
//! - a string is NULL or ends with a zero byte.

#![allow(unsafe_code, reason = "this is the C interface")]
#![allow(non_snake_case, reason = "the names are those of the standard")]
#![allow(clippy::missing_safety_doc, reason = "the module states it for all functions")]
#![allow(clippy::too_many_arguments, reason = "the signatures are those of the standard")]

use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr;

use super::calls::Call;
use super::failure::Failure;
use super::guard::{Handle, instantiate};
use super::instance::Instance;
use super::layout::Base;
use super::logging::Sink;
use super::types::{
    Boolean, Byte, CallbackFunctions, Component, FmuState, Integer, Real, Status, Text, ValueReference,
};

// Versions, instances, logging

/// The types are those of the standard's default platform.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> Text {
    c"default".as_ptr()
}

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> Text {
    c"2.0".as_ptr()
}

/// Makes an instance of the model with a GUID; NULL, and a message, if there is none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instance_name: Text,
    fmu_type: c_int,
    guid: Text,
    _resource_location: Text,
    functions: *const CallbackFunctions,
    _visible: Boolean,
    logging_on: Boolean,
) -> Component {
    // SAFETY: the host passes NULL or strings, and NULL or its callbacks, which `CallbackFunctions` describes.
    let (name, guid, functions) = unsafe { (text(instance_name), text(guid), functions.as_ref()) };
    let sink = sink(name, functions.copied());
    let handle = instantiate(name, fmu_type, guid, sink, logging_on != 0);
    handle.map_or(ptr::null_mut(), |handle| Box::into_raw(handle).cast())
}

/// Frees an instance and the states it has saved. Refused while another call of the instance runs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(component: Component) {
    // SAFETY: of the module.
    let freed = unsafe { call(component, Call::FreeInstance, |_| Ok(())) };
    if freed == Status::Ok {
        // SAFETY: the component came from `Box::into_raw` in `fmi2Instantiate`, the host gives it up, and no other
        // call uses it now, for it would have refused this one.
        drop(unsafe { Box::from_raw(component.cast::<Handle>()) });
    }
}

/// Switches logging on for some categories (for all, if none is named) or off. Failures are always logged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    component: Component,
    logging_on: Boolean,
    number: usize,
    categories: *const Text,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: of the module; each category is a string or NULL.
        let categories = unsafe { array(categories, number, "categories") }?.iter().map(|name| unsafe { text(*name) });
        let names: Option<Vec<_>> = categories.map(|name| name?.to_str().ok()).collect();
        let names = names.ok_or_else(|| Failure::error("a category is NULL or not UTF-8"))?;
        instance.set_debug_logging(logging_on != 0, &names)
    };
    // SAFETY: of the module.
    unsafe { call(component, Call::SetDebugLogging, body) }
}

// Life

/// Sets start time, stop time and tolerance; without it a run starts at 0 s, without end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    component: Component,
    tolerance_defined: Boolean,
    tolerance: Real,
    start_time: Real,
    stop_time_defined: Boolean,
    stop_time: Real,
) -> Status {
    let tolerance = (tolerance_defined != 0).then_some(tolerance);
    let stop = (stop_time_defined != 0).then_some(stop_time);
    let body = |instance: &mut Instance| instance.setup_experiment(tolerance, start_time, stop);
    // SAFETY: of the module.
    unsafe { call(component, Call::SetupExperiment, body) }
}

/// From now on computed values can be read; they follow parameters and inputs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(component: Component) -> Status {
    // SAFETY: of the module.
    unsafe { call(component, Call::EnterInitializationMode, Instance::enter_initialization_mode) }
}

/// Refused if parameters do not fit together.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(component: Component) -> Status {
    // SAFETY: of the module.
    unsafe { call(component, Call::ExitInitializationMode, Instance::exit_initialization_mode) }
}

/// Ends the run; everything can still be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(component: Component) -> Status {
    // SAFETY: of the module.
    unsafe { call(component, Call::Terminate, Instance::terminate) }
}

/// Goes back to the state after `fmi2Instantiate`; logging and saved states stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(component: Component) -> Status {
    // SAFETY: of the module.
    unsafe { call(component, Call::Reset, Instance::reset) }
}

// Values

/// Reads real variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    component: Component,
    references: *const ValueReference,
    number: usize,
    values: *mut Real,
) -> Status {
    // SAFETY: of the module.
    unsafe { get(component, Call::GetReal, Base::Real, references, number, values, |value| value) }
}

/// Reads integers and enumerations.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(
    component: Component,
    references: *const ValueReference,
    number: usize,
    values: *mut Integer,
) -> Status {
    // SAFETY: of the module.
    unsafe { get(component, Call::GetInteger, Base::Integer, references, number, values, |value| value as Integer) }
}

/// Reads Booleans.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(
    component: Component,
    references: *const ValueReference,
    number: usize,
    values: *mut Boolean,
) -> Status {
    let convert = |value| Boolean::from(value != 0.0);
    // SAFETY: of the module.
    unsafe { get(component, Call::GetBoolean, Base::Boolean, references, number, values, convert) }
}

/// There is no variable of type String, so that any value reference is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    component: Component,
    references: *const ValueReference,
    number: usize,
    values: *mut Text,
) -> Status {
    // SAFETY: of the module.
    unsafe { get(component, Call::GetString, Base::Text, references, number, values, |_| ptr::null()) }
}

/// Sets real inputs and parameters: all of them, or none if one is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    component: Component,
    references: *const ValueReference,
    number: usize,
    values: *const Real,
) -> Status {
    // SAFETY: of the module.
    unsafe { set(component, Call::SetReal, Base::Real, references, number, values, |value| value) }
}

/// Sets integer and enumeration parameters: all of them, or none if one is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(
    component: Component,
    references: *const ValueReference,
    number: usize,
    values: *const Integer,
) -> Status {
    // SAFETY: of the module.
    unsafe { set(component, Call::SetInteger, Base::Integer, references, number, values, f64::from) }
}

/// Sets Boolean parameters: all of them, or none if one is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(
    component: Component,
    references: *const ValueReference,
    number: usize,
    values: *const Boolean,
) -> Status {
    // SAFETY: of the module.
    unsafe { set(component, Call::SetBoolean, Base::Boolean, references, number, values, f64::from) }
}

/// There is no variable of type String, so that any value reference is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    component: Component,
    references: *const ValueReference,
    number: usize,
    values: *const Text,
) -> Status {
    // SAFETY: of the module.
    unsafe { set(component, Call::SetString, Base::Text, references, number, values, |_| f64::NAN) }
}

// Saved states

/// Saves everything that affects the further run; the handle may be NULL or one to save over.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(component: Component, state: *mut FmuState) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: of the module.
        let mut state = unsafe { Output::new(state, 1, "FMUstate") }?;
        let handle = instance.get_state(state.read().addr())?;
        state.write(0, ptr::without_provenance_mut(handle));
        Ok(())
    };
    // SAFETY: of the module.
    unsafe { call(component, Call::GetFMUstate, body) }
}

/// Goes back to a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(component: Component, state: FmuState) -> Status {
    // SAFETY: of the module; the state is only compared.
    unsafe { call(component, Call::SetFMUstate, |instance| instance.set_state(state.addr())) }
}

/// Frees a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(component: Component, state: *mut FmuState) -> Status {
    let body = |instance: &mut Instance| {
        if state.is_null() {
            return Ok(());
        }
        // SAFETY: of the module.
        let mut state = unsafe { Output::new(state, 1, "FMUstate") }?;
        instance.free_state(state.read().addr())?;
        state.write(0, ptr::null_mut());
        Ok(())
    };
    // SAFETY: of the module.
    unsafe { call(component, Call::FreeFMUstate, body) }
}

/// How many bytes a saved state takes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(component: Component, state: FmuState, size: *mut usize) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: of the module.
        let mut size = unsafe { Output::new(size, 1, "size") }?;
        size.write(0, instance.serialized(state.addr())?.len());
        Ok(())
    };
    // SAFETY: of the module.
    unsafe { call(component, Call::SerializedFMUstateSize, body) }
}

/// Writes a saved state as bytes; the size must be the one told.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    component: Component,
    state: FmuState,
    bytes: *mut Byte,
    size: usize,
) -> Status {
    let body = |instance: &mut Instance| {
        let serialized = instance.serialized(state.addr())?;
        if size != serialized.len() {
            let needed = serialized.len();
            return Err(Failure::error(format!("the state takes {needed} bytes, not {size}")));
        }
        // SAFETY: of the module.
        let mut bytes = unsafe { Output::new(bytes.cast::<u8>(), size, "serializedState") }?;
        serialized.iter().enumerate().for_each(|(index, byte)| bytes.write(index, *byte));
        Ok(())
    };
    // SAFETY: of the module.
    unsafe { call(component, Call::SerializeFMUstate, body) }
}

/// Takes a saved state from bytes, of any instance of the same model and build on any platform.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    component: Component,
    bytes: *const Byte,
    size: usize,
    state: *mut FmuState,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: of the module.
        let bytes = unsafe { array(bytes.cast::<u8>(), size, "serializedState") }?;
        // SAFETY: of the module.
        let mut state = unsafe { Output::new(state, 1, "FMUstate") }?;
        let handle = instance.deserialize(bytes, state.read().addr())?;
        state.write(0, ptr::without_provenance_mut(handle));
        Ok(())
    };
    // SAFETY: of the module.
    unsafe { call(component, Call::DeSerializeFMUstate, body) }
}

// Derivatives

/// The exact derivative of computed reals in one direction of inputs and continuous states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    component: Component,
    unknowns: *const ValueReference,
    number_of_unknowns: usize,
    knowns: *const ValueReference,
    number_of_knowns: usize,
    seeds: *const Real,
    derivatives: *mut Real,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: of the module.
        let unknowns = unsafe { array(unknowns, number_of_unknowns, "vUnknown_ref") }?;
        // SAFETY: of the module.
        let knowns = unsafe { array(knowns, number_of_knowns, "vKnown_ref") }?;
        // SAFETY: of the module.
        let seeds = unsafe { array(seeds, number_of_knowns, "dvKnown") }?;
        // SAFETY: of the module.
        let mut derivatives = unsafe { Output::new(derivatives, number_of_unknowns, "dvUnknown") }?;
        instance.directional_derivative(unknowns, knowns, seeds, |index, value| derivatives.write(index, value))
    };
    // SAFETY: of the module.
    unsafe { call(component, Call::GetDirectionalDerivative, body) }
}

/// Sets slopes of inputs, which hold for the next step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    component: Component,
    references: *const ValueReference,
    number: usize,
    orders: *const Integer,
    values: *const Real,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: of the module.
        let references = unsafe { array(references, number, "vr") }?;
        // SAFETY: of the module.
        let orders = unsafe { array(orders, number, "order") }?;
        // SAFETY: of the module.
        let values = unsafe { array(values, number, "value") }?;
        instance.set_input_derivatives(references, orders, values)
    };
    // SAFETY: of the module.
    unsafe { call(component, Call::SetRealInputDerivatives, body) }
}

/// The exact first derivatives of real outputs with respect to time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    component: Component,
    references: *const ValueReference,
    number: usize,
    orders: *const Integer,
    values: *mut Real,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: of the module.
        let references = unsafe { array(references, number, "vr") }?;
        // SAFETY: of the module.
        let orders = unsafe { array(orders, number, "order") }?;
        // SAFETY: of the module.
        let mut values = unsafe { Output::new(values, number, "value") }?;
        instance.output_derivatives(references, orders, |index, value| values.write(index, value))
    };
    // SAFETY: of the module.
    unsafe { call(component, Call::GetRealOutputDerivatives, body) }
}

// Steps

/// Integrates to exactly the communication point plus the step size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    component: Component,
    current_communication_point: Real,
    communication_step_size: Real,
    _no_set_fmu_state_prior_to_current_point: Boolean,
) -> Status {
    let body = |instance: &mut Instance| instance.do_step(current_communication_point, communication_step_size);
    // SAFETY: of the module.
    unsafe { call(component, Call::DoStep, body) }
}

/// Always refused: a step is never pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(component: Component) -> Status {
    // SAFETY: of the module.
    unsafe { call(component, Call::CancelStep, |_| Ok(())) }
}

/// Tells whether the last step was completed or discarded (`fmi2DoStepStatus`).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(component: Component, kind: c_int, value: *mut Status) -> Status {
    let told = |instance: &mut Instance| {
        let failed = instance.step_failed(kind)?;
        Ok(if failed { Status::Discard } else { Status::Ok })
    };
    // SAFETY: of the module.
    unsafe { tell(component, Call::GetStatus, value, told) }
}

/// Tells up to which time all is well (`fmi2LastSuccessfulTime`).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(component: Component, kind: c_int, value: *mut Real) -> Status {
    // SAFETY: of the module.
    unsafe { tell(component, Call::GetRealStatus, value, |instance| instance.last_successful_time(kind)) }
}

/// There is no such status.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(component: Component, kind: c_int, value: *mut Integer) -> Status {
    let told = |instance: &mut Instance| instance.unavailable_status(kind).map(|()| 0);
    // SAFETY: of the module.
    unsafe { tell(component, Call::GetIntegerStatus, value, told) }
}

/// Tells whether the instance wants to terminate, after a discarded step (`fmi2Terminated`).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(component: Component, kind: c_int, value: *mut Boolean) -> Status {
    let told = |instance: &mut Instance| instance.wants_to_terminate(kind).map(Boolean::from);
    // SAFETY: of the module.
    unsafe { tell(component, Call::GetBooleanStatus, value, told) }
}

/// There is no such status, since no step is ever pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(component: Component, kind: c_int, value: *mut Text) -> Status {
    let told = |instance: &mut Instance| instance.unavailable_status(kind).map(|()| ptr::null());
    // SAFETY: of the module.
    unsafe { tell(component, Call::GetStringStatus, value, told) }
}

// What the functions have in common

/// Carries out a call on a component.
unsafe fn call(
    component: Component,
    function: Call,
    body: impl FnOnce(&mut Instance) -> Result<(), Failure>,
) -> Status {
    let handle = component.cast::<Handle>();
    if !handle.is_aligned() {
        return Status::Error;
    }
    // SAFETY: the component is NULL or a live `Handle`, which is only ever shared.
    match unsafe { handle.as_ref() } {
        Some(handle) => handle.call(function, body),
        None => Status::Error,
    }
}

unsafe fn get<T>(
    component: Component,
    function: Call,
    base: Base,
    references: *const ValueReference,
    number: usize,
    values: *mut T,
    convert: impl Fn(f64) -> T,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: of the module.
        let references = unsafe { array(references, number, "vr") }?;
        // SAFETY: of the module.
        let mut values = unsafe { Output::new(values, number, "value") }?;
        instance.get(base, references, |index, value| values.write(index, convert(value)))
    };
    // SAFETY: of the module.
    unsafe { call(component, function, body) }
}

unsafe fn set<T: Copy>(
    component: Component,
    function: Call,
    base: Base,
    references: *const ValueReference,
    number: usize,
    values: *const T,
    convert: impl Fn(T) -> f64,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: of the module.
        let references = unsafe { array(references, number, "vr") }?;
        // SAFETY: of the module.
        let values = unsafe { array(values, number, "value") }?;
        instance.set(base, references, |index| convert(values[index]))
    };
    // SAFETY: of the module.
    unsafe { call(component, function, body) }
}

/// Hands out one value.
unsafe fn tell<T>(
    component: Component,
    function: Call,
    value: *mut T,
    told: impl FnOnce(&mut Instance) -> Result<T, Failure>,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: of the module.
        let mut value = unsafe { Output::new(value, 1, "value") }?;
        value.write(0, told(instance)?);
        Ok(())
    };
    // SAFETY: of the module.
    unsafe { call(component, function, body) }
}

unsafe fn text<'a>(text: Text) -> Option<&'a CStr> {
    // SAFETY: a string of the host's that is not NULL ends with a zero byte.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) })
}

/// An array of the host's for reading.
unsafe fn array<'a, T>(pointer: *const T, number: usize, name: &str) -> Result<&'a [T], Failure> {
    check_array(pointer, number, name)?;
    if number == 0 {
        return Ok(&[]);
    }
    // SAFETY: the pointer is not NULL, is aligned, and points to as many elements as the host says.
    Ok(unsafe { std::slice::from_raw_parts(pointer, number) })
}

/// An array of the host's for writing, which may overlap others and be uninitialised.
struct Output<T> {
    pointer: *mut T,
    number: usize,
}

impl<T> Output<T> {
    /// The pointer must stay valid for writing while this lives, and for [`Output::read`] be initialised.
    unsafe fn new(pointer: *mut T, number: usize, name: &str) -> Result<Self, Failure> {
        check_array(pointer, number, name)?;
        Ok(Self { pointer, number })
    }

    fn write(&mut self, index: usize, value: T) {
        assert!(index < self.number, "an index within the host's array");
        // SAFETY: the index is within the array, which `new` checked and the host vouches for.
        unsafe { self.pointer.add(index).write(value) }
    }
}

impl Output<FmuState> {
    /// The handle that the host passes in.
    fn read(&self) -> FmuState {
        // SAFETY: `new` checked the pointer, and any bits are a pointer that is only compared.
        unsafe { self.pointer.read() }
    }
}

fn check_array<T>(pointer: *const T, number: usize, name: &str) -> Result<(), Failure> {
    if number == 0 {
        return Ok(());
    }
    if pointer.is_null() {
        return Err(Failure::error(format!("{name} is NULL")));
    }
    if !pointer.is_aligned() {
        return Err(Failure::error(format!("{name} is not aligned")));
    }
    if number > isize::MAX as usize / size_of::<T>() {
        return Err(Failure::error(format!("{name} cannot have {number} elements")));
    }
    Ok(())
}

/// Takes messages to the host's logger, if there is one.
fn sink(name: Option<&CStr>, functions: Option<CallbackFunctions>) -> Sink {
    let name: CString = name.unwrap_or_default().to_owned();
    let Some((logger, environment)) = functions.and_then(|it| Some((it.logger?, it.environment))) else {
        return Box::new(|_, _, _| ());
    };
    let environment = Environment(environment);
    Box::new(move |status, category, message| {
        let format: *const c_char = c"%s".as_ptr();
        // SAFETY: the logger is the host's function; it takes the arguments of `fmi2CallbackLogger`, here a format
        // with one string, so that percent signs in the message mean nothing.
        unsafe { logger(environment.pointer(), name.as_ptr(), status, category.as_ptr(), format, message.as_ptr()) }
    })
}

/// The host's pointer, which is only handed back to it.
struct Environment(*mut std::ffi::c_void);

// SAFETY: nothing here looks behind the pointer; the host may call an instance from one thread after another.
unsafe impl Send for Environment {}

impl Environment {
    fn pointer(&self) -> *mut std::ffi::c_void {
        self.0
    }
}
