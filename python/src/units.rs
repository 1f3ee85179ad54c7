//! Units in which people write values.

use pneumatic_servo_fit::calibration::Calibration;
use pneumatic_servo_fit::{machine_units, units};
use pyo3::prelude::*;

use crate::failure::refused;

/// Factor and offset from a written unit to an SI unit, of a quantity that may count above ambient pressure.
#[pyfunction]
pub fn unit_scale(text: &str, si: &str, is_above_ambient: bool) -> PyResult<(f64, f64)> {
    units::to_si(text, si, is_above_ambient).map_err(refused)
}

/// The unit of the readings of a calibration, empty for counts, and whether a table's unit is that one; `None` for a plain unit.
#[pyfunction]
#[pyo3(signature = (text, written = None))]
pub fn calibrated_reading(text: &str, written: Option<&str>) -> PyResult<Option<(String, bool)>> {
    let Some(calibration) = Calibration::parse(text) else { return Ok(None) };
    let reading = calibration.map_err(refused)?.reading;
    let is_same = written.is_none_or(|written| units::spelled(written) == reading);
    Ok(Some((reading, is_same)))
}

/// The SI unit that a unit of a signal, or a calibration, is converted to.
#[pyfunction]
pub fn si_of(signal: &str, unit: &str) -> PyResult<&'static str> {
    machine_units::si_of(signal, unit).map_err(refused)
}

/// Names of the units of an SI unit.
#[pyfunction]
pub fn units_of(si: &str) -> Vec<&'static str> {
    units::units_of(si).map(|unit| unit.name).collect()
}
