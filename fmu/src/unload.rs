//! Clean-up when the library is unloaded.

#![allow(unsafe_code, reason = "this is an interface to C")]

#[cfg(all(unix, not(target_vendor = "apple")))]
static CALLED: std::sync::OnceLock<extern "C" fn()> = std::sync::OnceLock::new();

/// Has a function called when the library is unloaded, or the process ends, by the loader (ELF, section `.fini_array`); musl
/// unloads nothing. `atexit` will not do: what calls the functions of a library when it is unloaded is a part of the compiler's
/// runtime, which not every linker puts into it; then they are called when they have gone.
#[cfg(all(unix, not(target_vendor = "apple")))]
pub fn call(function: extern "C" fn()) {
    extern "C" fn at_unload() {
        if let Some(function) = CALLED.get() {
            function();
        }
    }
    // SAFETY: the section holds functions without arguments.
    #[used]
    #[unsafe(link_section = ".fini_array")]
    static AT_UNLOAD: extern "C" fn() = at_unload;

    CALLED.get_or_init(|| function);
}

/// Has a function called when the library is unloaded, or the process ends: macOS and the runtimes of Windows, which are parts of
/// the library, know which library a function belongs to.
#[cfg(any(windows, target_vendor = "apple"))]
pub fn call(function: extern "C" fn()) {
    use std::ffi::c_int;

    unsafe extern "C" {
        safe fn atexit(function: extern "C" fn()) -> c_int;
    }
    // Without room for one more function its memory leaks.
    atexit(function);
}

/// A module of WebAssembly takes its memory along.
#[cfg(target_family = "wasm")]
pub fn call(_: extern "C" fn()) {}
