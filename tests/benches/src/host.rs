//! Drives the library through its C interface as a host does.

#![allow(unsafe_code, reason = "the C interface takes pointers")]

use std::ffi::{CString, c_void};
use std::hint::black_box;
use std::path::Path;
use std::ptr;
use std::sync::LazyLock;

use anyhow::{Context, Result};
use libloading::Library;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
use pneumatic_servo::variables::{Kind, Variable};
use pneumatic_servo_builtin::FMI2;
use pneumatic_servo_fmu::fmi2::exports::Functions;
use pneumatic_servo_fmu::fmi2::guid;
use pneumatic_servo_fmu::fmi2::types::{CO_SIMULATION, Component, FmuState, OK, Status};

use crate::case::{Case, variable, variables};

/// The GUID as a host reads it from `modelDescription.xml`.
static GUID: LazyLock<CString> = LazyLock::new(|| CString::new(guid(&MODEL)).expect("no zero byte"));

/// The functions of a library in a file, which stays loaded.
///
/// # Errors
/// When it cannot be loaded, or lacks a function of FMI 2.0.
pub fn load(file: &Path) -> Result<&'static Functions> {
    // SAFETY: loading an FMU starts nothing, and what it exports by these names are the functions of the standard.
    let library = unsafe { Library::new(file) };
    let library: &'static Library =
        Box::leak(Box::new(library.with_context(|| format!("cannot load {}", file.display()))?));
    // SAFETY: as above; the library is never unloaded.
    let functions = unsafe { Functions::load(|name| library.get::<*const c_void>(name.as_bytes()).map(|it| *it)) };
    Ok(Box::leak(Box::new(functions?)))
}

/// A running instance.
pub struct Host {
    functions: &'static Functions,
    component: Component,
    voltage: u32,
    time: f64,
}

/// A state saved by an instance.
pub struct Saved(FmuState);

fn check(status: Status, call: &str) {
    assert!(status == OK, "{call} returns {status}");
}

impl Host {
    /// Instantiates and initializes, in the library that this program is linked with.
    ///
    /// # Panics
    /// When a call fails.
    pub fn start(case: &Case, tolerance: f64) -> Self {
        Self::start_in(&FMI2, case, tolerance)
    }

    /// Instantiates and initializes, in a library.
    ///
    /// # Panics
    /// When a call fails.
    pub fn start_in(functions: &'static Functions, case: &Case, tolerance: f64) -> Self {
        let (name, callbacks) = (c"benchmark".as_ptr(), ptr::null());
        // SAFETY: strings end with a zero byte; callbacks may be NULL.
        let component =
            unsafe { (functions.fmi2Instantiate)(name, CO_SIMULATION, GUID.as_ptr(), ptr::null(), callbacks, 0, 0) };
        assert!(
            !component.is_null(),
            "fmi2Instantiate returns NULL; the GUID of this source is {}",
            GUID.to_string_lossy()
        );
        let host = Self { functions, component, voltage: variable("valveVoltage").reference, time: 0.0 };
        for (parameter, value) in variables(Variable::is_parameter).into_iter().zip(&case.parameters) {
            if parameter.start != Some(*value) {
                host.set_parameter(parameter, *value);
            }
        }
        // SAFETY: the component is alive.
        unsafe {
            check((functions.fmi2SetupExperiment)(component, 1, tolerance, 0.0, 0, 0.0), "fmi2SetupExperiment");
            check((functions.fmi2EnterInitializationMode)(component), "fmi2EnterInitializationMode");
            check((functions.fmi2ExitInitializationMode)(component), "fmi2ExitInitializationMode");
        }
        host
    }

    fn set_parameter(&self, parameter: &Variable, value: f64) {
        let reference = parameter.reference;
        // SAFETY: the component is alive, and the pointers are to one element each.
        let status = match parameter.kind {
            Kind::Real(_) => unsafe { (self.functions.fmi2SetReal)(self.component, &reference, 1, &value) },
            Kind::Boolean => unsafe { (self.functions.fmi2SetBoolean)(self.component, &reference, 1, &(value as i32)) },
            Kind::Integer | Kind::Enumeration(_) => unsafe {
                (self.functions.fmi2SetInteger)(self.component, &reference, 1, &(value as i32))
            },
        };
        check(status, &parameter.name);
    }

    /// Sets the valve voltage and takes a communication step: `fmi2SetReal` and `fmi2DoStep`.
    ///
    /// # Panics
    /// When a call fails.
    pub fn step(&mut self, voltage: f64, size: f64) {
        let component = black_box(self.component);
        // SAFETY: the component is alive, and the pointers are to one element each.
        unsafe {
            check((self.functions.fmi2SetReal)(component, &self.voltage, 1, &voltage), "fmi2SetReal");
            check((self.functions.fmi2DoStep)(component, self.time, size, 1), "fmi2DoStep");
        }
        self.time += size;
    }

    /// Real variables by reference.
    ///
    /// # Panics
    /// When the call fails.
    pub fn reals<const M: usize>(&self, references: &[u32; M]) -> [f64; M] {
        let mut values = [0.0; M];
        // SAFETY: the component is alive, and both pointers are to `M` elements.
        let status =
            unsafe { (self.functions.fmi2GetReal)(self.component, references.as_ptr(), M, values.as_mut_ptr()) };
        check(status, "fmi2GetReal");
        values
    }

    /// Integer variables by name.
    ///
    /// # Panics
    /// When the call fails.
    pub fn integers<const M: usize>(&self, names: [&str; M]) -> [i32; M] {
        let references = names.map(|name| variable(name).reference);
        let mut values = [0; M];
        // SAFETY: the component is alive, and both pointers are to `M` elements.
        let status =
            unsafe { (self.functions.fmi2GetInteger)(self.component, references.as_ptr(), M, values.as_mut_ptr()) };
        check(status, "fmi2GetInteger");
        values
    }

    /// Saves the state.
    ///
    /// # Panics
    /// When the call fails.
    pub fn save(&self) -> Saved {
        let mut state = ptr::null_mut();
        // SAFETY: the component is alive, and the pointer is to one element.
        check(unsafe { (self.functions.fmi2GetFMUstate)(self.component, &mut state) }, "fmi2GetFMUstate");
        Saved(state)
    }

    /// Goes back to a saved state and frees it.
    ///
    /// # Panics
    /// When a call fails.
    pub fn restore(&self, Saved(mut state): Saved) {
        // SAFETY: the component is alive, and the state was saved by it.
        unsafe {
            check((self.functions.fmi2SetFMUstate)(self.component, state), "fmi2SetFMUstate");
            check((self.functions.fmi2FreeFMUstate)(self.component, &mut state), "fmi2FreeFMUstate");
        }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: the component is alive, and nobody uses it afterwards.
        unsafe { (self.functions.fmi2FreeInstance)(self.component) };
    }
}
