//! When the library is unloaded.

#![allow(unsafe_code, reason = "this is an interface to C")]

/// Has a function called when the library is unloaded, or the process ends.
///
/// ISO C registers functions for the end of the process. Those of a shared library are called when it is unloaded: by glibc,
/// macOS and the runtimes of Windows; musl unloads nothing.
#[cfg(not(target_family = "wasm"))]
pub fn call(function: extern "C" fn()) {
    use std::ffi::c_int;

    unsafe extern "C" {
        safe fn atexit(function: extern "C" fn()) -> c_int;
    }
    // Where there is no room for one more function, what it would free is left behind.
    atexit(function);
}

/// A module of WebAssembly takes its memory along.
#[cfg(target_family = "wasm")]
pub fn call(_: extern "C" fn()) {}
