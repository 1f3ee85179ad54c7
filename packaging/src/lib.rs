//! Packing of models into FMUs: a crate's models by a program of one line in it, [`package_fmus!`], the project's by
//! `cargo xtask package`.
//!
//! | module | what it does |
//! |---|---|
//! | [`commands`] | the command lines of both |
//! | [`mod@package`] | builds, describes, zips, validates and runs |
//! | [`product`], [`workspace`], [`fingerprint`] | owner of the FMUs, paths, fingerprint of the source |
//! | [`build`], [`library`], [`gates`] | shared libraries: compiling for a platform, and requirements |
//! | [`description`], [`documentation`], [`parameter_sets`], [`licences`] | the other files of an FMU |
//! | [`machine`] | FMUs of a configured machine: `--set` |
//! | [`ssp`] | cylinder and controller as one system |
//! | [`sources`] | sources in C (feature `sources`) |
//! | [`archive`], [`timestamp`] | archives that are the same for the same commit |
//! | [`experiment`] | the default experiment of a model, here and in an importer, bit for bit |
//! | [`venv`], [`process`], [`tools`], [`files`], [`lock`], [`platform`] | Python environments, programs, tools, files, platforms |
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
pub mod machine;
pub mod package;
pub mod parameter_sets;
pub mod platform;
pub mod process;
pub mod product;
pub mod sources;
pub mod ssp;
pub mod timestamp;
pub mod tools;
mod user_crate;
pub mod venv;
pub mod workspace;

pub use user_crate::{Crate, package, package_loop};
