//! The common part of the C interfaces: how a C function gets at an instance, and how vectors and single values are handed
//! over.
//!
//! # Safety
//! What every function of a face relies on, as the standard asks of the host:
//! - a component is NULL or was returned by a function of the face that makes instances, and not yet freed;
//! - a pointer that comes with a number of elements is NULL or points to that many elements, and is not written to
//!   by another thread during the call; arrays may overlap;
//! - a string is NULL or ends with a zero byte.

#![allow(unsafe_code, reason = "this is the C interface")]

#[macro_use]
mod macros;

use std::ffi::{c_int, c_void};
use std::ptr;

use crate::calls::Call;
use crate::failure::Failure;
use crate::host::{Input, Output, text};
use crate::instance::{Handle, Instance, Vector};

/// An instance as the host holds it.
pub type Component = *mut c_void;
/// Status of a call, numbered alike in all versions of the standard.
pub type Status = c_int;

/// All is well.
pub const OK: Status = 0;
/// The call was refused.
pub const ERROR: Status = 3;

/// Hands a new instance to the host, or NULL.
pub fn hand_out(handle: Option<Box<Handle>>) -> Component {
    handle.map_or(ptr::null_mut(), |handle| Box::into_raw(handle).cast())
}

/// Frees an instance and the states it has saved, for a function of a face. Refused while another call of it runs.
///
/// # Safety
/// Of the module.
pub unsafe fn free(component: Component, function: &'static str) {
    // SAFETY: of the module.
    let freed = unsafe { call(component, Call::Free, function, |_| Ok(())) };
    if freed == OK {
        // SAFETY: the component came from `Box::into_raw` in `hand_out`, the host gives it up, and no other call uses it
        // now, for it would have refused this one.
        drop(unsafe { Box::from_raw(component.cast::<Handle>()) });
    }
}

/// Carries out a call on a component.
///
/// # Safety
/// Of the module.
pub unsafe fn call(
    component: Component,
    call: Call,
    function: &'static str,
    body: impl FnOnce(&mut Instance) -> Result<(), Failure>,
) -> Status {
    let handle = component.cast::<Handle>();
    if !handle.is_aligned() {
        return ERROR;
    }
    // SAFETY: the component is NULL or a live `Handle`, which is only ever shared.
    match unsafe { handle.as_ref() } {
        Some(handle) => handle.call(call, function, body) as Status,
        None => ERROR,
    }
}

/// Switches logging on for some categories (for all, if none is named) or off.
///
/// # Safety
/// Of the module.
pub unsafe fn choose_log(
    instance: &mut Instance,
    on: bool,
    number: usize,
    categories: *const *const std::ffi::c_char,
) -> Result<(), Failure> {
    // SAFETY: of the module.
    let names: Option<Vec<String>> = unsafe {
        Input::new(categories, number, "categories")?.iter().map(|name| text(name)?.into_string().ok()).collect()
    };
    let names = names.ok_or_else(|| Failure::error("a category is NULL or not UTF-8"))?;
    instance.choose_log(on, &names.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Saves into a new state, or over the one that the host points to.
///
/// # Safety
/// Of the module.
pub unsafe fn save(instance: &mut Instance, state: *mut *mut c_void) -> Result<(), Failure> {
    // SAFETY: of the module.
    let (state, old) = unsafe {
        let state = Output::new(state, 1, "FMU state")?;
        let old = state.read();
        (state, old)
    };
    let handle = instance.get_state(old.addr())?;
    state.write([ptr::without_provenance_mut(handle)].into_iter());
    Ok(())
}

/// Frees a saved state, and tells the host by a NULL.
///
/// # Safety
/// Of the module.
pub unsafe fn forget(instance: &mut Instance, state: *mut *mut c_void) -> Result<(), Failure> {
    if state.is_null() {
        return Ok(());
    }
    // SAFETY: of the module.
    let (state, old) = unsafe {
        let state = Output::new(state, 1, "FMU state")?;
        let old = state.read();
        (state, old)
    };
    instance.free_state(old.addr())?;
    state.write([ptr::null_mut()].into_iter());
    Ok(())
}

/// Writes a saved state as bytes; the size must be the one it takes.
///
/// # Safety
/// Of the module.
pub unsafe fn serialize(
    instance: &mut Instance,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> Result<(), Failure> {
    let serialized = instance.serialized(state.addr())?;
    let needed = serialized.len();
    if size != needed {
        return Err(Failure::error(format!("the state takes {needed} bytes, not {size}")));
    }
    // SAFETY: of the module.
    unsafe { Output::new(bytes, size, "serializedState") }?.write(serialized.into_iter());
    Ok(())
}

/// Makes a new saved state from bytes; the previous value of the host's variable does not matter.
///
/// # Safety
/// Of the module.
pub unsafe fn deserialize(
    instance: &mut Instance,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> Result<(), Failure> {
    // SAFETY: of the module.
    let (bytes, state) = unsafe {
        let bytes: Vec<u8> = Input::new(bytes, size, "serializedState")?.iter().collect();
        (bytes, Output::new(state, 1, "FMU state")?)
    };
    let handle = instance.deserialize(&bytes)?;
    state.write([ptr::without_provenance_mut(handle)].into_iter());
    Ok(())
}

/// Sets the continuous states: all of them, or none if one is refused.
///
/// # Safety
/// Of the module.
pub unsafe fn set_states(instance: &mut Instance, states: *const f64, number: usize) -> Result<(), Failure> {
    instance.check_length(Vector::States, number)?;
    // SAFETY: of the module.
    instance.set_states(unsafe { Input::new(states, number, "continuous states") }?.iter())
}

/// Hands out a vector of the solver's.
///
/// # Safety
/// Of the module.
pub unsafe fn vector(instance: &mut Instance, vector: Vector, values: *mut f64, number: usize) -> Result<(), Failure> {
    instance.check_length(vector, number)?;
    // SAFETY: of the module.
    let room = unsafe { Output::new(values, number, "values") }?;
    room.write(instance.vector(vector)?.iter().copied());
    Ok(())
}

/// Hands out one value.
///
/// # Safety
/// Of the module.
pub unsafe fn tell<T: Copy>(pointer: *mut T, value: Result<T, Failure>) -> Result<(), Failure> {
    // SAFETY: of the module.
    let room = unsafe { Output::new(pointer, 1, "value") }?;
    room.write([value?].into_iter());
    Ok(())
}
