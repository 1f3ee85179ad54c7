//! `std::time` in place of the crate web-time, which reads the clock of a browser through wasm-bindgen: the page has no bindings of
//! JavaScript, and no search here asks for a clock.

pub use std::time::*;
