//! The FMU as WebAssembly, from which the C sources for any target are made.
//!
//! The module exports the functions of both faces as they are, so that calls, statuses, messages and saved states are those
//! of the shared library. Its memory is no memory of the host's: the C in `sources/c` copies what pointers lead to. What it
//! needs besides the faces is here:
//!
//! | place | what it does |
//! |---|---|
//! | [`self_test`](mod@self_test) | a short run and its fingerprint, by which a target shows that it computes exactly |
//! | `only_model` | the one model that the module serves |
//! | `host` | room for the host's arrays, its logger, and the message of a panic |

pub mod self_test;

// What is exported for C only.
#[cfg(target_family = "wasm")]
mod host;
#[cfg(target_family = "wasm")]
mod only_model;
