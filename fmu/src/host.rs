//! The host's memory: arrays and strings behind pointers.
//!
//! No reference to memory of the host is ever made: elements are copied one by one, so that a host may pass the same
//! array twice, and nothing is assumed about the host's memory between two calls.

#![allow(unsafe_code, reason = "the host passes pointers")]

use std::ffi::{CStr, CString, c_char};

use crate::failure::Failure;

/// An array of the host's for reading.
#[derive(Clone, Copy)]
pub struct Input<T> {
    pointer: *const T,
    number: usize,
}

impl<T: Copy> Input<T> {
    /// Checks what can be checked of an array with a name.
    ///
    /// # Safety
    /// The pointer is NULL, or points to as many initialised elements as long as this is used.
    pub unsafe fn new(pointer: *const T, number: usize, name: &str) -> Result<Self, Failure> {
        check_array(pointer, number, name)?;
        Ok(Self { pointer, number })
    }

    /// The elements, each read when it is asked for.
    pub fn iter(self) -> impl Iterator<Item = T> + Clone {
        // SAFETY: the index is within the array, which `new` checked and the host vouches for.
        (0..self.number).map(move |index| unsafe { self.pointer.add(index).read() })
    }
}

/// An array of the host's for writing, which may be uninitialised.
pub struct Output<T> {
    pointer: *mut T,
    number: usize,
}

impl<T: Copy> Output<T> {
    /// Checks what can be checked of an array with a name.
    ///
    /// # Safety
    /// The pointer is NULL, or points to room for as many elements as long as this is used.
    pub unsafe fn new(pointer: *mut T, number: usize, name: &str) -> Result<Self, Failure> {
        check_array(pointer, number, name)?;
        Ok(Self { pointer, number })
    }

    /// Fills the array with as many values.
    pub fn write(&self, values: impl ExactSizeIterator<Item = T>) {
        assert_eq!(values.len(), self.number, "values for the host's array");
        for (index, value) in values.enumerate() {
            // SAFETY: the index is within the array, which `new` checked and the host vouches for.
            unsafe { self.pointer.add(index).write(value) }
        }
    }

    /// The first element.
    ///
    /// # Safety
    /// There is one, and the host has initialised it.
    pub unsafe fn read(&self) -> T {
        // SAFETY: as the caller promises, of a pointer that `new` has checked.
        unsafe { self.pointer.read() }
    }
}

/// A copy of a string of the host's; nothing of NULL.
///
/// # Safety
/// The pointer is NULL, or points to a string that ends with a zero byte.
pub unsafe fn text(text: *const c_char) -> Option<CString> {
    // SAFETY: as the caller promises; the reference ends with this function.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) }.to_owned())
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
