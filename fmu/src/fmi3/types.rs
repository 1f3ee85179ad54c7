//! The types of the FMI 3.0 C interface: `fmi3PlatformTypes.h` and `fmi3FunctionTypes.h`.
//!
//! Enumerations of C are plain integers here, and Booleans bytes, since a host may pass any number.

use std::ffi::{c_char, c_int, c_void};

pub use crate::c_interface::{Component as Instance, Status};

/// `fmi3InstanceEnvironment`: a pointer of the host's, handed back to its callbacks.
pub type InstanceEnvironment = *mut c_void;
/// `fmi3FMUState`: a saved state, opaque to the host.
pub type FmuState = *mut c_void;
/// `fmi3ValueReference`.
pub type ValueReference = u32;
/// `fmi3Boolean`: `fmi3True` is 1, `fmi3False` is 0.
pub type Boolean = u8;
/// `fmi3String`: UTF-8, ended by a zero byte.
pub type Text = *const c_char;
/// `fmi3Binary`.
pub type Binary = *const u8;
/// `fmi3Clock`.
pub type Clock = u8;
/// `fmi3IntervalQualifier`.
pub type IntervalQualifier = c_int;
/// `fmi3DependencyKind`.
pub type DependencyKind = c_int;

/// `fmi3OK`.
pub const OK: Status = 0;
/// `fmi3Warning`.
pub const WARNING: Status = 1;
/// `fmi3Discard`.
pub const DISCARD: Status = 2;
/// `fmi3Error`.
pub const ERROR: Status = 3;
/// `fmi3Fatal`.
pub const FATAL: Status = 4;

/// `fmi3Dependent` of `fmi3DependencyKind`: nothing is said of how a variable depends on another.
pub const DEPENDENT: DependencyKind = 5;

/// `fmi3LogMessageCallback`: environment, status, category and message.
pub type LogMessage = unsafe extern "C" fn(InstanceEnvironment, Status, Text, Text);
/// `fmi3IntermediateUpdateCallback`, which is never called.
pub type IntermediateUpdate =
    unsafe extern "C" fn(InstanceEnvironment, f64, Boolean, Boolean, Boolean, Boolean, *mut Boolean, *mut f64);
/// `fmi3ClockUpdateCallback`, which is never called.
pub type ClockUpdate = unsafe extern "C" fn(InstanceEnvironment);
/// `fmi3LockPreemptionCallback` and `fmi3UnlockPreemptionCallback`, which are never called.
pub type Preemption = unsafe extern "C" fn();
