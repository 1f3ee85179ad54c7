//! Experiments of the crate `fit`, and what it tells of their parameters.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::str::FromStr;
use std::sync::Arc;

use numpy::ndarray::Array1;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pneumatic_servo::model;
use pneumatic_servo_fit::experiment::{
    self, Begin, Forces, Given, Inputs, KINDS, Kind, MeasuredSegment, OfRecord, Options, Whole, of_kind,
};
use pneumatic_servo_fit::machine_units::MachineUnits;
use pneumatic_servo_fit::parameter::Values;
use pneumatic_servo_fit::plausibility::{self, Facts, Finding, Remedy, Source, Written};
use pneumatic_servo_fit::record::{self, Record, Signals};
use pneumatic_servo_fit::sensor::Sensor;
use pneumatic_servo_fit::study;
use pyo3::prelude::*;

use crate::failure::refused;
use crate::fit::{Free, free, ties_of};
use crate::model::Model;
use crate::own;

type Array<'py> = Bound<'py, PyArray1<f64>>;
type Read<'py> = PyReadonlyArray1<'py, f64>;
type Flags<'py> = Bound<'py, PyArray1<bool>>;
type ReadFlags<'py> = PyReadonlyArray1<'py, bool>;
type Courses<'py> = BTreeMap<String, Read<'py>>;
type Made<'py> = BTreeMap<String, Array<'py>>;
/// Times in s, time of the table that is 0, and signals.
pub type Measured<'py> = (Read<'py>, f64, Courses<'py>);
/// The same for Python.
type Split<'py> = (Array<'py>, f64, Made<'py>);
/// Load factor 1 in N, width in s, play in m, length in s, course of inputs, and whether forces are smoothed.
type Chosen = (f64, f64, Option<f64>, Option<f64>, Option<String>, Option<bool>);
/// First sample, signals made ready, compared samples, validation data, start values, and names of the estimated ones.
type Cut<'py> = (usize, Made<'py>, Flags<'py>, Flags<'py>, Values, Vec<String>);
/// Kind, signals, unit, values and samples of a remedy.
type Remedied = (&'static str, Vec<String>, String, Vec<(String, f64)>, Vec<usize>);
/// Text of a finding, its remedies, and whether it is refused.
type Found = (String, Vec<Remedied>, bool);

/// Adds what the Python package uses.
pub fn fill(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Experiment>()?;
    module.add_class::<Segment>()?;
    module.add_function(wrap_pyfunction!(check_motion, module)?)?;
    module.add_function(wrap_pyfunction!(experiments, module)?)?;
    module.add_function(wrap_pyfunction!(outliers, module)?)?;
    module.add_function(wrap_pyfunction!(usual_parameters, module)?)
}

/// An experiment with measured signals.
#[pyclass(frozen, module = "pneumatic_servo._native")]
pub struct Experiment {
    /// The experiment.
    pub inner: Arc<dyn experiment::Experiment>,
}

/// A segment of a record.
#[pyclass(frozen, module = "pneumatic_servo._native")]
pub struct Segment {
    /// The segment; its start values are given beside it.
    pub inner: MeasuredSegment,
}

fn model_of(name: &str) -> PyResult<&'static model::Model> {
    own::all().find(|model| model.name == name).ok_or_else(|| refused(format!("there is no model {name}")))
}

#[pymethods]
impl Experiment {
    #[new]
    fn new(name: &str, law: i32, known: Values, signals: Vec<String>, options: Chosen) -> PyResult<Self> {
        let (rated, width, play, length, inputs, smoothing) = options;
        let inputs = inputs.map(|name| Inputs::from_str(&name).map_err(|why| refused(why.0))).transpose()?;
        let kind = Kind::of_name(name).map_err(|why| refused(why.0))?;
        let given = Given {
            kind,
            table: model_of(kind.table)?,
            model: model_of(kind.simulated)?,
            cylinder: model_of("PneumaticServoCylinder")?,
            law,
            known,
            signals: signals.into_iter().collect(),
            options: Options { rated, width, play, length, inputs, smoothing },
            // The package has its own table of units; numbers are the same.
            units: MachineUnits::default(),
        };
        Ok(Self { inner: of_kind(given).map_err(|why| refused(why.0))?.into() })
    }

    /// What is sent to other processes.
    #[expect(clippy::type_complexity, reason = "the arguments it is made with")]
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> (Bound<'py, PyAny>, (&'static str, i32, Values, Vec<String>, Chosen)) {
        let Given { kind, law, known, signals, options, .. } = self.inner.given().clone();
        let Options { rated, width, play, length, inputs, smoothing } = options;
        let chosen = (rated, width, play, length, inputs.map(|course| course.name().to_owned()), smoothing);
        (py.get_type::<Self>().into_any(), (kind.name, law, known, signals.into_iter().collect(), chosen))
    }

    /// A parameter that may be estimated, by its name.
    fn parameter(&self, name: &str) -> PyResult<Free> {
        experiment::parameter(&*self.inner, name).map(free).map_err(|why| refused(why.0))
    }

    /// Signals that are compared.
    #[getter]
    fn compared(&self) -> Vec<&'static str> {
        self.inner.compared().to_vec()
    }

    /// Measured signals that drive the model.
    #[getter]
    fn driving(&self) -> Vec<&'static str> {
        self.inner.driving()
    }

    /// Parameters that the model has no default of.
    #[getter]
    fn unknown(&self) -> Vec<&'static str> {
        self.inner.unknown()
    }

    /// Parameters that each machine has of its own.
    #[getter]
    fn machine(&self) -> Vec<&'static str> {
        self.inner.given().kind.machine.to_vec()
    }

    /// Whether the inputs run on straight lines between the communication points; otherwise they are held.
    #[getter]
    fn has_lines(&self) -> bool {
        self.inner.has_lines()
    }

    /// Whether each sample is a steady motion of its own, without time.
    #[getter]
    fn is_steady(&self) -> bool {
        self.inner.is_steady()
    }

    /// Signals of a table as records without gaps, or of points as one record, and notes on omitted parts.
    fn split<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        signals: Courses<'py>,
    ) -> PyResult<(Vec<Split<'py>>, Vec<String>)> {
        let (records, notes) = self.inner.given().kind.split(name, plain(&signals)).map_err(|why| refused(why.0))?;
        let one = |record: Record| (array(py, record.time), record.begin, made(py, record.signals));
        Ok((records.into_iter().map(one).collect(), notes))
    }

    /// Noise, step of the converter, and whether readings are ranges, of the sensor of each compared signal, as segments tell them.
    fn sensors_of(&self, segments: Vec<PyRef<'_, Segment>>) -> Vec<(f64, f64, bool)> {
        let segments: Vec<_> = segments.iter().map(|segment| segment.inner.clone()).collect();
        let of = |Sensor { noise, step, is_coarse }: Sensor| (noise, step, is_coarse);
        study::sensors(&*self.inner, &segments).into_iter().map(of).collect()
    }

    /// Variables of the model that are recorded.
    #[getter]
    fn outputs(&self) -> Vec<&'static str> {
        self.inner.outputs()
    }

    /// Names of properties of sensors.
    #[getter]
    fn sensors(&self) -> Vec<String> {
        experiment::sensors(&*self.inner)
    }

    /// Names of properties of a bench that its model does not have.
    #[getter]
    fn of_bench(&self) -> Vec<&'static str> {
        self.inner.of_bench()
    }

    /// Samples at which a measured position does not change by more than its noise.
    fn resting<'py>(&self, py: Python<'py>, record: Measured<'py>) -> Flags<'py> {
        self.inner.resting(&record_of(&record)).into_pyarray(py)
    }

    /// Length in s of the segments of a record with a sample interval in s; nothing if a record is not cut.
    fn length(&self, step: f64) -> Option<f64> {
        self.inner.length(step)
    }

    /// Segments of a record, signals of the whole record made ready, and notes.
    fn segments<'py>(
        &self,
        py: Python<'py>,
        record: Measured<'py>,
        share: f64,
        named: Vec<String>,
    ) -> (Made<'py>, Vec<Cut<'py>>, Vec<String>) {
        let is_named = |name: &str| named.iter().any(|own| own == name);
        let record = record_of(&record);
        let OfRecord { segments, notes } = experiment::segments(&*self.inner, &record, 0, share, &is_named);
        let whole = segments.first().map(|(_, segment)| made(py, segment.whole.driven.clone())).unwrap_or_default();
        let cut = |(first, segment): (usize, MeasuredSegment)| {
            let Begin { values, estimated } = segment.begin;
            let [used, is_validation] = [segment.used, segment.is_validation].map(|flags| flags.into_pyarray(py));
            (first, made(py, segment.driven), used, is_validation, values, estimated)
        };
        (whole, segments.into_iter().map(cut).collect(), notes)
    }

    /// Values with those of parameters that follow from others.
    fn tied(&self, ties: Vec<(String, String)>, mut values: Values) -> PyResult<Values> {
        self.inner.given().follow(&ties_of(ties)?, &mut values);
        Ok(values)
    }

    /// Known and estimated values that the model has, and the law.
    fn under_law(&self, values: Values) -> Values {
        self.inner.given().run(&values, &[])
    }

    /// Velocity, friction and load factor as far as the data alone tell them.
    fn forces<'py>(
        &self,
        py: Python<'py>,
        segment: &Segment,
        values: Values,
    ) -> Option<(Array<'py>, Array<'py>, Array<'py>)> {
        let Forces { speed, force, level } = self.inner.forces(&segment.inner, &values)?;
        Some((array(py, speed), array(py, force), array(py, level)))
    }

    /// [`plausibility::findings`] of a record by its name, its signals, and the place of a sample, which `place` gives of a signal and
    /// a number. `columns` have name and unit of each column, `units` SI units that differ from usual ones.
    fn findings(
        &self,
        name: &str,
        signals: Courses<'_>,
        columns: BTreeMap<String, (String, String)>,
        units: BTreeMap<String, String>,
        place: Bound<'_, PyAny>,
    ) -> PyResult<Vec<Found>> {
        let found = self.of_source(name, &signals, columns, &units, &place, plausibility::findings)?;
        Ok(found.into_iter().map(told).collect())
    }

    /// [`plausibility::recorder`], of the same.
    fn recorder(
        &self,
        name: &str,
        signals: Courses<'_>,
        units: BTreeMap<String, String>,
        place: Bound<'_, PyAny>,
    ) -> PyResult<(Vec<Found>, Vec<String>)> {
        let (found, notes) = self.of_source(name, &signals, BTreeMap::new(), &units, &place, plausibility::recorder)?;
        Ok((found.into_iter().map(told).collect(), notes))
    }

    /// [`plausibility::contradictions`] of records.
    fn contradictions(&self, records: Vec<Measured<'_>>, units: BTreeMap<String, String>) -> Vec<Found> {
        let records: Vec<Record> = records.iter().map(record_of).collect();
        let facts = Facts { given: self.inner.given(), columns: &BTreeMap::new(), units: &units };
        plausibility::contradictions(&facts, &records).into_iter().map(told).collect()
    }

    /// [`plausibility::supply`].
    fn doubtful_supply(&self) -> Option<Found> {
        plausibility::supply(self.inner.given()).map(told)
    }

    /// Starts of parameters of the machine that the data tell.
    fn guess(&self, segments: Vec<PyRef<'_, Segment>>, values: Values) -> Values {
        let segments: Vec<_> = segments.iter().map(|segment| segment.inner.clone()).collect();
        self.inner.guess(&segments, &values)
    }
}

impl Experiment {
    /// Does something with a record, and with what is known of it.
    fn of_source<T>(
        &self,
        name: &str,
        signals: &Courses<'_>,
        columns: BTreeMap<String, (String, String)>,
        units: &BTreeMap<String, String>,
        place: &Bound<'_, PyAny>,
        work: impl FnOnce(&Facts<'_>, &Source<'_>) -> T,
    ) -> PyResult<T> {
        let raised = RefCell::new(None);
        let place = |signal: &str, row: usize| {
            let told = place.call1((signal, row)).and_then(|told| told.extract::<String>());
            told.unwrap_or_else(|error| {
                raised.borrow_mut().get_or_insert(error);
                String::new()
            })
        };
        let columns = columns.into_iter().map(|(signal, (name, unit))| (signal, Written { name, unit })).collect();
        let facts = Facts { given: self.inner.given(), columns: &columns, units };
        let found = work(&facts, &Source { name, signals: &plain(signals), place: &place });
        raised.into_inner().map_or(Ok(found), Err)
    }
}

#[pymethods]
impl Segment {
    /// `whole` has the time of the record at which the segment begins, and communication points and signals of the record.
    #[new]
    fn new(
        record: Measured<'_>,
        driven: Courses<'_>,
        used: ReadFlags<'_>,
        is_validation: ReadFlags<'_>,
        whole: (f64, Read<'_>, Courses<'_>),
    ) -> Self {
        let (begin, grid, of_whole) = whole;
        let whole = Arc::new(Whole { begin, grid: grid.as_array().to_vec(), driven: plain(&of_whole) });
        let (record, driven) = (record_of(&record), plain(&driven));
        let [used, is_validation] = [used, is_validation].map(|flags| flags.as_array().to_vec());
        Self {
            inner: MeasuredSegment { record, driven, used, is_validation, begin: Begin::default(), number: 0, whole },
        }
    }

    /// What is sent to other processes.
    #[expect(clippy::type_complexity, reason = "the arguments it is made with")]
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> (Bound<'py, PyAny>, (Split<'py>, Made<'py>, Flags<'py>, Flags<'py>, (f64, Array<'py>, Made<'py>))) {
        let MeasuredSegment { record, driven, used, is_validation, whole, .. } = self.inner.clone();
        let record = (array(py, record.time), record.begin, made(py, record.signals));
        let whole = (whole.begin, array(py, whole.grid.clone()), made(py, whole.driven.clone()));
        let [used, is_validation] = [used, is_validation].map(|flags| flags.into_pyarray(py));
        (py.get_type::<Self>().into_any(), (record, made(py, driven), used, is_validation, whole))
    }
}

/// Refuses a motion that never changes in any of the records.
#[pyfunction]
fn check_motion(records: Vec<Measured<'_>>) -> PyResult<()> {
    let records: Vec<Record> = records.iter().map(record_of).collect();
    record::check_motion(&records).map_err(|problem| refused(problem.0))
}

/// A record of its signals.
pub fn record_of((time, begin, signals): &Measured<'_>) -> Record {
    Record::new(time.as_array().to_vec(), *begin, plain(signals))
}

fn plain(courses: &Courses<'_>) -> Signals {
    courses.iter().map(|(name, course)| (name.clone(), course.as_array().to_vec())).collect()
}

fn array(py: Python<'_>, values: Vec<f64>) -> Array<'_> {
    Array1::from(values).into_pyarray(py)
}

fn made(py: Python<'_>, signals: Signals) -> Made<'_> {
    signals.into_iter().map(|(name, course)| (name, array(py, course))).collect()
}

fn told(finding: Finding) -> Found {
    let Finding { text, remedies, is_refused, .. } = finding;
    let remedy = |remedy: Remedy| -> Remedied {
        match remedy {
            Remedy::Unit { signal, unit } => ("unit", vec![signal], unit, vec![], vec![]),
            Remedy::Turn { signal } => ("turn", vec![signal], String::new(), vec![], vec![]),
            Remedy::Swap { signals } => ("swap", signals.to_vec(), String::new(), vec![], vec![]),
            Remedy::Set { values } => ("set", vec![], String::new(), values, vec![]),
            Remedy::Remove { signal, rows } => ("remove", vec![signal], String::new(), vec![], rows),
        }
    };
    (text, remedies.into_iter().map(remedy).collect(), is_refused)
}

/// Samples that are far off those around them, and the medians of these: [`plausibility::outliers`].
#[pyfunction]
pub fn outliers<'py>(py: Python<'py>, values: Read<'py>) -> (Bound<'py, PyArray1<i64>>, Array<'py>) {
    let (rows, usual) = plausibility::outliers(&values.as_array().to_vec());
    (rows.into_iter().map(|row| row as i64).collect::<Vec<_>>().into_pyarray(py), array(py, usual))
}

/// Kinds of experiments: name, required signals, and the models with the parameters and of the simulation.
#[pyfunction]
pub fn experiments() -> Vec<(&'static str, Vec<&'static str>, &'static str, &'static str)> {
    KINDS.iter().map(|kind| (kind.name, kind.required.to_vec(), kind.table, kind.simulated)).collect()
}

/// Parameters of a law that a fit of an experiment usually estimates.
#[pyfunction]
pub fn usual_parameters(experiment: &str, model: &Model, law: i32, known: Values) -> PyResult<Vec<String>> {
    let kind = Kind::of_name(experiment).map_err(|why| refused(why.0))?;
    Ok(kind.usual(model.model, law, &known))
}
