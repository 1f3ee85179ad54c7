//! Packages and features of the builds in the profile `quick`: builds with the same ones share their artifacts.

/// The features of the plant that `cargo xtask` is compiled with: what has the same finds it compiled in `target/quick`.
pub const FEATURES: [&str; 2] = ["--features", "pneumatic-servo/all-models,pneumatic-servo/sensitivities"];

/// Packages whose unit tests are quick: without optimization they are compiled in a sixth of the time.
const UNITS: [&str; 11] = [
    "pneumatic-servo",
    "pneumatic-servo-export",
    "pneumatic-servo-fit",
    "pneumatic-servo-fmu",
    "pneumatic-servo-packaging",
    "pneumatic-servo-playground",
    "pneumatic-servo-ssp",
    "pneumatic-servo-variant",
    "wasm-as-c",
    "xtask",
    "xtask-developer",
];

/// Names of these packages as arguments of Cargo. Who names the same ones has the same features of all that they depend on.
pub fn packages() -> [&'static str; 22] {
    let mut arguments = ["--package"; 22];
    arguments.iter_mut().skip(1).step_by(2).zip(UNITS).for_each(|(place, name)| *place = name);
    arguments
}
