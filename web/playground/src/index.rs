//! Numbers by which the page names models, variables and texts.

use crate::CallError;

/// Item of a list at a place, given as a number of the page.
pub fn item<'a, T>(list: &'a [T], what: &'static str, place: f64) -> Result<&'a T, CallError> {
    // The cast saturates and makes 0 of what is no number; only a place that it leaves as it is counts.
    let index = place as usize;
    let found = list.get(index).filter(|_| index as f64 == place);
    found.ok_or(CallError::NoSuch { what, number: place })
}

/// Refusal of a number beyond the end of a list.
pub fn no_such(what: &'static str, number: usize) -> CallError {
    CallError::NoSuch { what, number: number as f64 }
}
