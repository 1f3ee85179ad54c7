//! Lights of a verdict on a fit.

use pneumatic_servo_fit::verdict::Light;
use pyo3::prelude::*;

/// Names and meanings of the lights, the worst last.
#[pyfunction]
pub fn lights() -> Vec<(&'static str, &'static str)> {
    Light::ALL.iter().map(|light| (light.name(), light.head())).collect()
}

/// The light of the RMS residual of a signal, by the standard deviation of its samples and by the noise of its sensor.
#[pyfunction]
pub fn residual_light(rms: f64, spread: f64, noise: f64) -> &'static str {
    Light::of_residual(rms, spread, noise).name()
}

/// The light of a prediction, by the ratio of the RMS residuals of validation data and of fitted data.
#[pyfunction]
pub fn prediction_light(ratio: f64) -> &'static str {
    Light::of_prediction(ratio).name()
}
