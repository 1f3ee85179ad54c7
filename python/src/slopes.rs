//! Sensitivities of the recorded outputs of a run.

use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyArray3};
use pneumatic_servo::model::Plant;
use pneumatic_servo::sensitivity::{Crossing, NoDerivative};
use pneumatic_servo::variables::Place;
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;

use crate::failure::refused;

/// Most bytes that the sensitivities of a run may take.
const MOST_BYTES: usize = 1 << 31;

/// Sensitivities of the outputs of a run, row by row.
#[derive(Default)]
pub struct Slopes {
    names: Vec<String>,
    rows: usize,
    /// The slot of direction `d`, output `o` and row `r` is `values[(d * outputs + o) * rows + r]`.
    values: Vec<f64>,
    /// Where each direction has no derivative any more.
    lost: Vec<Option<NoDerivative>>,
    crossings: Vec<Crossing>,
}

/// Time in s, event and reason.
type Lost = (f64, String, String);
/// Time in s, name, rate of the indicator, and delays in s per unit of each direction.
type Event = (f64, &'static str, f64, Vec<f64>);
/// Sensitivities `[direction, output, row]`, where each direction ends, and the events.
pub type SlopeParts<'py> = (Bound<'py, PyArray3<f64>>, Vec<Option<Lost>>, Vec<Event>);

impl Slopes {
    /// Room for those by names, of a number of outputs in a number of rows.
    ///
    /// # Errors
    /// `MemoryError` if there is not so much.
    pub fn new(names: Vec<String>, outputs: usize, rows: usize) -> PyResult<Self> {
        let number = names.len().checked_mul(outputs).and_then(|number| number.checked_mul(rows));
        let mut values = Vec::new();
        let fits = number.filter(|number| *number <= MOST_BYTES / size_of::<f64>());
        let Some(number) = fits.filter(|number| values.try_reserve_exact(*number).is_ok()) else {
            return Err(PyMemoryError::new_err(format!(
                "sensitivities of {outputs} outputs by {} variables in {rows} rows do not fit into {} GiB: record fewer \
                 outputs, or with a larger `every` fewer rows",
                names.len(),
                MOST_BYTES >> 30
            )));
        };
        values.resize(number, f64::NAN);
        let lost = vec![None; names.len()];
        Ok(Self { names, rows, values, lost, crossings: Vec::new() })
    }

    /// Lets a plant carry them along from here on.
    ///
    /// # Errors
    /// `ValueError` for a name by which nothing can be differentiated.
    pub fn begin(&self, plant: &mut Plant) -> PyResult<()> {
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        plant.carry_sensitivities(&names).map_err(refused)
    }

    /// Reads the derivatives of a row.
    pub fn read(&mut self, plant: &mut Plant, outputs: &[Place], row: usize) {
        for direction in 0..self.names.len() {
            if self.lost[direction].is_some() {
                continue;
            }
            match plant.sensitivities(direction) {
                Ok(slopes) => {
                    let own = plant.table().find(&self.names[direction]).map(|entry| entry.place);
                    for (output, place) in outputs.iter().enumerate() {
                        let slope = match place {
                            Place::Computed(place) => slopes[*place],
                            // What is given changes with itself alone.
                            other => f64::from(u8::from(own == Some(*other))),
                        };
                        self.values[(direction * outputs.len() + output) * self.rows + row] = slope;
                    }
                }
                Err(lost) => self.lost[direction] = Some(lost),
            }
        }
    }

    /// The events of a run that has started at a time in s.
    pub fn end(&mut self, plant: &Plant, start: f64) {
        self.crossings = plant.crossings().to_vec();
        self.crossings.iter_mut().for_each(|crossing| crossing.time += start);
    }

    /// All derivatives for Python, with a number of outputs.
    pub fn tell(self, py: Python<'_>, outputs: usize) -> SlopeParts<'_> {
        let shape = (self.names.len(), outputs, self.rows);
        let values = Array3::from_shape_vec(shape, self.values).expect("one slot per direction, output and row");
        let lost = self.lost.into_iter().map(|lost| lost.map(|it| (it.time, it.event, it.reason))).collect();
        let event = |it: Crossing| (it.time, it.event, it.rate, it.delays);
        (values.into_pyarray(py), lost, self.crossings.into_iter().map(event).collect())
    }
}
