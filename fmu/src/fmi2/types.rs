//! The types of the FMI 2.0 C interface: `fmi2TypesPlatform.h` (platform "default") and `fmi2FunctionTypes.h`.
//!
//! Enumerations of C are plain integers here, since a host may pass any number.

use std::ffi::{c_char, c_int, c_uint, c_void};

/// `fmi2Component`: an instance, opaque to the host.
pub type Component = *mut c_void;
/// `fmi2ComponentEnvironment`: a pointer of the host's, handed back to its callbacks.
pub type ComponentEnvironment = *mut c_void;
/// `fmi2FMUstate`: a saved state, opaque to the host.
pub type FmuState = *mut c_void;
/// `fmi2ValueReference`.
pub type ValueReference = c_uint;
/// `fmi2Real`.
pub type Real = f64;
/// `fmi2Integer`.
pub type Integer = c_int;
/// `fmi2Type`: where the solver is to be.
pub type FmuType = c_int;
/// `fmi2Boolean`: `fmi2True` is 1, `fmi2False` is 0.
pub type Boolean = c_int;
/// `fmi2String`: UTF-8, ended by a zero byte.
pub type Text = *const c_char;
/// `fmi2Byte`, whose sign does not matter.
pub type Byte = u8;
/// `fmi2Status`; `fmi2Pending` is never returned, since no step runs asynchronously.
pub type Status = c_int;

/// `fmi2OK`.
pub const OK: Status = 0;
/// `fmi2Warning`.
pub const WARNING: Status = 1;
/// `fmi2Discard`.
pub const DISCARD: Status = 2;
/// `fmi2Error`.
pub const ERROR: Status = 3;
/// `fmi2Fatal`.
pub const FATAL: Status = 4;

/// `fmi2ModelExchange` of `fmi2Type`.
pub const MODEL_EXCHANGE: FmuType = 0;
/// `fmi2CoSimulation` of `fmi2Type`.
pub const CO_SIMULATION: FmuType = 1;

/// The items of `fmi2StatusKind`.
pub mod status_kind {
    use std::ffi::c_int;

    /// `fmi2DoStepStatus`.
    pub const DO_STEP_STATUS: c_int = 0;
    /// `fmi2PendingStatus`.
    pub const PENDING_STATUS: c_int = 1;
    /// `fmi2LastSuccessfulTime`.
    pub const LAST_SUCCESSFUL_TIME: c_int = 2;
    /// `fmi2Terminated`.
    pub const TERMINATED: c_int = 3;
}

/// `fmi2CallbackLogger`: environment, instance name, status, category, format and its arguments.
pub type Logger = unsafe extern "C" fn(ComponentEnvironment, Text, Status, Text, Text, ...);

/// `fmi2CallbackFunctions`; each of them may be NULL.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct CallbackFunctions {
    /// Receives messages.
    pub logger: Option<Logger>,
    /// Not used: memory never changes its owner across the interface.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Not used.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Not used: steps are complete when `fmi2DoStep` returns.
    pub step_finished: Option<unsafe extern "C" fn(ComponentEnvironment, Status)>,
    /// Handed to the callbacks.
    pub environment: ComponentEnvironment,
}

/// `fmi2EventInfo`: what an update of the discrete part has done.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EventInfo {
    /// Whether another update is needed at this instant; never, since one settles everything.
    pub new_discrete_states_needed: Boolean,
    /// Whether the simulation is to end; never.
    pub terminate_simulation: Boolean,
    /// Whether the nominal values of the states have changed; never.
    pub nominals_of_continuous_states_changed: Boolean,
    /// Whether the update has changed continuous states.
    pub values_of_continuous_states_changed: Boolean,
    /// Whether there is a next time event.
    pub next_event_time_defined: Boolean,
    /// Its time in s.
    pub next_event_time: Real,
}
