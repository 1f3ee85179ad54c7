//! When the library is unloaded.

#![allow(unsafe_code, reason = "this is an interface to C")]

/// Has a function called when the library is unloaded, or the process ends. On Linux and macOS it is registered with the handle of
/// this library (Itanium C++ ABI, section 3.3.6): `atexit` itself may be the one of the C library, which knows no other library and
/// would call a function that has gone with its own.
#[cfg(unix)]
pub fn call(function: extern "C" fn()) {
    use std::ffi::{c_int, c_void};

    unsafe extern "C" {
        static __dso_handle: u8;
        fn __cxa_atexit(function: extern "C" fn(*mut c_void), argument: *mut c_void, library: *const u8) -> c_int;
    }
    extern "C" fn call(function: *mut c_void) {
        // SAFETY: it is the function that was registered.
        let function: extern "C" fn() = unsafe { std::mem::transmute(function) };
        function();
    }
    // SAFETY: both live until the library is unloaded. Where there is no room for one more function, what it would free is left
    // behind.
    unsafe { __cxa_atexit(call, function as *mut c_void, &raw const __dso_handle) };
}

/// The runtimes of Windows are parts of the library, and call its functions when it is unloaded.
#[cfg(windows)]
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
