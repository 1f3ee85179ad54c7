//! The exported functions.
//!
//! Those that return a number return 0, or 1 for a refusal, which is then the text. Nothing that the page passes is used
//! as an address.

#![allow(unsafe_code, reason = "an exported name must be unique in the whole program, which no compiler can check")]

use std::cell::RefCell;

use crate::{CallError, Session, tables};

thread_local! {
    static SESSION: RefCell<Session> = RefCell::default();
    static TEXT: RefCell<String> = const { RefCell::new(String::new()) };
}

fn answer(call: impl FnOnce(&mut Session) -> Result<(), CallError>) -> u32 {
    match SESSION.with_borrow_mut(call) {
        Ok(()) => 0,
        Err(error) => {
            TEXT.set(error.to_string());
            1
        }
    }
}

/// Where the buffer is: [`BUFFER`](crate::BUFFER) numbers, always at the same place.
// SAFETY: only this library is linked, and it has one function of this name.
#[unsafe(no_mangle)]
pub extern "C" fn playground_buffer() -> *mut f64 {
    SESSION.with_borrow_mut(|session| session.buffer.as_mut_ptr())
}

/// Where the text is, until the next call.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_text() -> *const u8 {
    TEXT.with_borrow(|text| text.as_ptr())
}

/// How many bytes the text has.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_text_length() -> usize {
    TEXT.with_borrow(String::len)
}

/// Makes the [`tables`] the text.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_tables() {
    TEXT.set(tables().to_string());
}

/// [`Session::start`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_start(slot: usize, model: usize, count: usize) -> u32 {
    answer(|session| session.start(slot, model, count))
}

/// [`Session::set`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_set(slot: usize, count: usize) -> u32 {
    answer(|session| session.set(slot, count))
}

/// [`Session::advance`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_advance(slot: usize, end: f64) -> u32 {
    answer(|session| session.advance(slot, end))
}

/// [`Session::read`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_read(slot: usize, count: usize) -> u32 {
    answer(|session| session.read(slot, count))
}

/// Makes [`Session::ssv`] the text.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_ssv(count: usize, bytes: usize) -> u32 {
    answer(|session| {
        TEXT.set(session.ssv(count, bytes)?);
        Ok(())
    })
}
