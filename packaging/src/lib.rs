//! Packs models into FMUs: those of a crate by a program of one line in it, [`package_fmus!`], and those of the project by
//! `cargo xtask package`.
//!
//! | module | what it does |
//! |---|---|
//! | [`commands`] | the command lines of both |
//! | [`mod@package`] | builds, describes, zips, validates and runs |
//! | [`product`], [`workspace`], [`fingerprint`] | whose FMUs are packed, where, from which source |
//! | [`build`], [`library`], [`gates`] | shared libraries: how they are compiled for a platform, and what they must be |
//! | [`description`], [`documentation`], [`parameter_sets`], [`licences`] | what is beside the library in an FMU |
//! | [`ssp`] | cylinder and controller as one system |
//! | [`sources`] | sources in C (feature `sources`) |
//! | [`archive`], [`moment`] | archives that are the same for the same commit |
//! | [`experiment`] | the default experiment of a model, and that of a host, bit for bit |
//! | [`venv`], [`process`], [`tools`], [`files`], [`lock`], [`platform`] | Python environments, programs, what is missing, files, platforms |
//!
//! The macro is for everybody; the modules are for the commands of the project (`xtask`, `xtask/developer`).

pub mod archive;
pub mod build;
pub mod commands;
pub mod description;
pub mod documentation;
pub mod experiment;
pub mod files;
pub mod fingerprint;
pub mod gates;
pub mod library;
pub mod licences;
pub mod lock;
pub mod moment;
mod own;
pub mod package;
pub mod parameter_sets;
pub mod platform;
pub mod process;
pub mod product;
pub mod sources;
pub mod ssp;
pub mod tools;
pub mod venv;
pub mod workspace;

pub use own::{Crate, package, package_loop};
