//! Fits that the page asks for: a question as JSON beside its samples, and an answer as JSON beside its curves.

use std::cell::{Cell, RefCell};

use pneumatic_servo_fit::candidates;
use pneumatic_servo_fit::experiment::{Experiment, Given, Inputs, Kind, Options, of_kind, parameter};
use pneumatic_servo_fit::fitting::{self, Answer, Course, Estimate, Question};
use pneumatic_servo_fit::machine_units::{MachineUnits, si_of};
use pneumatic_servo_fit::parameter::Values;
use pneumatic_servo_fit::problem::Interrupted;
use pneumatic_servo_fit::search::Watch;
use pneumatic_servo_fit::verdict::verdict;
use pneumatic_servo_fit::{NoAnswer, Refused};
use serde_json::{Value, json};

/// Fits what a question asks for, with the samples of its signals one after the other, and returns the answer and the samples of
/// its curves. `told` hears how far it is.
///
/// # Errors
/// In words for the visitor, for a question that is none, or one that is refused.
pub fn fit(question: &str, samples: &[f64], told: &dyn Fn(&Value)) -> Result<(Value, Vec<f64>), String> {
    let question = serde_json::from_str(question).map_err(|error| format!("the question is no JSON: {error}"))?;
    let question = read(&question, samples).ok_or("the question is incomplete, or its samples are")??;
    let progress = Progress {
        told,
        stage: RefCell::new(String::from("Look at the data")),
        runs: Cell::new(0),
        misfit: Cell::new(None),
        best: RefCell::default(),
    };
    match fitting::fit(&question, &progress, &|share| progress.run(share)) {
        Ok(answer) => Ok((written(&answer), curves(&answer))),
        Err(NoAnswer::Refused(Refused(text))) => Err(text),
        Err(NoAnswer::Interrupted) => unreachable!("a worker of the page is ended from outside"),
    }
}

/// Parameters that a fit estimates unless others are chosen, further ones of sensors and of a bench, what may be known of the bench,
/// the units of all these where the machine rotates or a sensor has its own, and what is wrong with the signals, if anything is. The
/// question has experiment, law, known values, and units by the names of the signals.
///
/// # Errors
/// In words for the visitor, for a question that is none.
pub fn estimable(question: &str) -> Result<Value, String> {
    let question: Value =
        serde_json::from_str(question).map_err(|error| format!("the question is no JSON: {error}"))?;
    let asked = || Some((text(&question["experiment"])?, law(&question)?, known(&question)?, columns(&question)?));
    let (experiment, law, known, columns) = asked().ok_or("the question is incomplete")?;
    let kind = Kind::of_name(&experiment).map_err(|refused| refused.0)?;
    let given = Given::new(kind, law, known, columns.iter().map(|(signal, _)| signal.clone()), Options::default());
    let usual = kind.usual(given.table, law, &given.known);
    let experiment = units(kind, &columns).and_then(|units| of_kind(Given { units, ..given }));
    Ok(match experiment {
        Ok(experiment) => {
            let usual: Vec<_> = usual.into_iter().chain(experiment.unknown().into_iter().map(str::to_owned)).collect();
            let others = candidates::estimable(&*experiment);
            let known_names = experiment.given().known.keys();
            let bench = experiment.unknown().into_iter().chain(experiment.of_bench()).map(str::to_owned);
            json!({
                "bench": units_of(&*experiment, bench),
                "units": units_of(&*experiment, usual.iter().chain(&others).chain(known_names).cloned()),
                "usual": usual,
                "others": others,
                "lacking": null,
            })
        }
        Err(Refused(lacking)) => {
            json!({ "usual": usual, "others": [], "bench": {}, "units": {}, "lacking": lacking })
        }
    })
}

/// Units of parameters by their names, of those that may be estimated.
fn units_of(experiment: &dyn Experiment, names: impl Iterator<Item = String>) -> Value {
    let of = |name: String| parameter(experiment, &name).ok().map(|one| (name, json!(one.unit)));
    names.filter_map(of).collect::<serde_json::Map<_, _>>().into()
}

/// Progress of a fit.
struct Progress<'a> {
    told: &'a dyn Fn(&Value),
    stage: RefCell<String>,
    runs: Cell<u32>,
    misfit: Cell<Option<f64>>,
    best: RefCell<Values>,
}

impl Progress<'_> {
    /// Tells of a run of which a share is done.
    fn run(&self, share: f64) {
        self.runs.set(self.runs.get() + u32::from(share == 0.0));
        (self.told)(&json!({
            "stage": *self.stage.borrow(),
            "runs": self.runs.get(),
            "share": share,
            "misfit": self.misfit.get(),
            "best": *self.best.borrow(),
        }));
    }
}

impl Watch for Progress<'_> {
    fn see(&self, _: &[f64], values: &Values, mean_square: f64) -> Result<(), Interrupted> {
        let misfit = mean_square.sqrt();
        if self.misfit.get().is_none_or(|least| misfit < least) {
            self.misfit.set(Some(misfit));
            self.best.replace(values.clone());
        }
        Ok(())
    }

    fn stage(&self, text: &str) {
        self.stage.replace(text.to_owned());
        self.misfit.set(None);
    }
}

fn text(value: &Value) -> Option<String> {
    value.as_str().map(str::to_owned)
}

fn texts(value: &Value) -> Option<Vec<String>> {
    value.as_array()?.iter().map(text).collect()
}

pub(crate) fn law(question: &Value) -> Option<i32> {
    i32::try_from(question["law"].as_i64()?).ok()
}

pub(crate) fn known(question: &Value) -> Option<Values> {
    question["known"].as_object()?.iter().map(|(name, value)| Some((name.clone(), value.as_f64()?))).collect()
}

/// Signals and the units of their columns, in the order of the columns.
fn columns(question: &Value) -> Option<Vec<(String, String)>> {
    question["signals"].as_array()?.iter().map(|pair| Some((text(&pair[0])?, text(&pair[1])?))).collect()
}

/// Units of a machine by the columns of its signals.
fn units(kind: &Kind, columns: &[(String, String)]) -> Result<MachineUnits, Refused> {
    let stated = |(signal, unit): &'_ (String, String)| Some((signal.clone(), si_of(signal, unit).ok()?));
    let stated: Vec<_> = columns.iter().filter_map(stated).collect();
    let stated: Vec<_> = stated.iter().map(|(signal, si)| (signal.as_str(), *si)).collect();
    MachineUnits::of_columns(kind, &stated)
}

fn options(of: &Value) -> Result<Options, Refused> {
    let usual = Options::default();
    Ok(Options {
        rated: of["rated"].as_f64().unwrap_or(usual.rated),
        width: of["width"].as_f64().unwrap_or(usual.width),
        play: of["play"].as_f64(),
        length: of["segment"].as_f64(),
        inputs: of["inputs"].as_str().map(str::parse::<Inputs>).transpose()?,
        smoothing: of["smoothing"].as_str().map(|item| item == "on"),
    })
}

fn read(question: &Value, samples: &[f64]) -> Option<Result<Question, String>> {
    let columns = columns(question)?;
    let length = samples.len().checked_div(columns.len())?;
    if length == 0 || length * columns.len() != samples.len() {
        return None;
    }
    let experiment = text(&question["experiment"])?;
    let chosen = || -> Result<_, Refused> {
        Ok((units(Kind::of_name(&experiment)?, &columns)?, options(&question["options"])?))
    };
    let (units, options) = match chosen() {
        Ok(chosen) => chosen,
        Err(Refused(why)) => return Some(Err(why)),
    };
    let names = columns.into_iter().map(|(signal, _)| signal);
    Some(Ok(Question {
        file: text(&question["file"])?,
        experiment,
        law: law(question)?,
        signals: names.zip(samples.chunks_exact(length).map(<[f64]>::to_vec)).collect(),
        known: known(question)?,
        estimated: texts(&question["free"])?,
        validation: question["validation"].as_f64()?,
        starts: usize::try_from(question["starts"].as_u64()?).ok()?,
        options,
        units,
    }))
}

/// A number, or the name of one that JSON does not have.
fn number(value: f64) -> Value {
    match value {
        value if value.is_finite() => json!(value),
        value if value.is_nan() => json!("NaN"),
        value => json!(if value > 0.0 { "Infinity" } else { "-Infinity" }),
    }
}

fn written(answer: &Answer) -> Value {
    let Answer { converged, message, notes, .. } = answer;
    let estimate = |one: &Estimate| {
        let [low, high] = one.interval.map(number);
        let (name, unit) = &one.parameter;
        json!({
            "name": name, "unit": unit, "value": number(one.value), "low": low, "high": high, "undetermined": one.undetermined,
        })
    };
    let by_signal = |values: &std::collections::BTreeMap<&str, f64>| {
        let pairs = values.iter().map(|(signal, value)| ((*signal).to_owned(), number(*value)));
        Value::Object(pairs.collect())
    };
    let (light, findings) = verdict(answer);
    json!({
        "converged": converged,
        "message": message,
        "estimates": answer.estimates.iter().map(estimate).collect::<Vec<_>>(),
        "rms": by_signal(&answer.rms),
        "validationRms": by_signal(&answer.validation_rms),
        "notes": notes,
        "units": answer.units.of_signals(),
        "unitsTold": answer.units.told(),
        "validationFrom": answer.validation_from,
        "start": answer.start,
        "light": light.name(),
        "head": light.head(),
        "cause": answer.cause.as_ref().map(|cause| &cause.text),
        // What would be estimated or set to follow the cause.
        "remedy": answer.cause.as_ref().map(|cause| {
            json!({ "name": cause.name, "item": cause.item, "value": cause.estimate.map(|(value, _)| value) })
        }),
        "findings": findings.into_iter().map(|finding| finding.text).collect::<Vec<_>>(),
        "signals": answer.courses.first().map_or(vec![], |course| course.readings.iter().map(|(name, ..)| *name).collect()),
        "lengths": answer.courses.iter().map(|course| course.time.len()).collect::<Vec<_>>(),
    })
}

/// Of each segment the times, and of each signal the measured and the simulated readings.
fn curves(answer: &Answer) -> Vec<f64> {
    let of_segment = |course: &Course| {
        let readings = course.readings.iter().flat_map(|(_, measured, simulated)| [measured, simulated]);
        std::iter::once(&course.time).chain(readings).flatten().copied().collect::<Vec<f64>>()
    };
    answer.courses.iter().flat_map(of_segment).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_question_that_is_none_is_refused() {
        let refused = |text: &str, samples: &[f64]| fit(text, samples, &|_| {}).expect_err("a refusal");
        assert!(refused("{", &[]).starts_with("the question is no JSON"));
        for question in
            ["{}", r#"{"signals": [["time", "s"]]}"#, r#"{"signals": []}"#, r#"{"signals": [1], "file": 2}"#]
        {
            assert_eq!(refused(question, &[1.0, 2.0]), "the question is incomplete, or its samples are", "{question}");
        }
        let whole = r#"{"file": "a.csv", "experiment": "rig", "law": 7, "signals": [["time", "s"], ["position", "m"]], "known": {},
            "free": [], "validation": 0, "starts": 0, "options": {"rated": 1, "width": 0.04, "play": null}}"#;
        assert_eq!(
            refused(whole, &[0.0; 4]),
            "experiment rig needs columns for time, valveVoltage, position; valveVoltage is missing"
        );
        assert_eq!(refused(whole, &[0.0; 3]), "the question is incomplete, or its samples are");
        let cubic = whole.replace("\"play\": null", "\"inputs\": \"cubic\"");
        assert_eq!(refused(&cubic, &[0.0; 4]), "inputs = cubic is refused: it must be hold, lines or smooth");
    }

    #[test]
    fn what_may_be_estimated_depends_on_the_signals() {
        let of = |signals: &str| {
            let question = format!(r#"{{"experiment": "motion", "law": 2, "known": {{}}, "signals": {signals}}}"#);
            estimable(&question).expect("an answer")
        };
        let few = of(r#"[["time", "s"], ["position", "m"]]"#);
        assert_eq!(few["lacking"], "experiment motion needs a column for frictionForce or force");
        assert_eq!(few["usual"], json!(["friction.coulomb.Fc", "friction.coulomb.sigma2"]));
        let whole = of(r#"[["time", "s"], ["position", "m"], ["force", "N"], ["pressure", "Pa"]]"#);
        assert_eq!(whole["usual"], json!(["friction.coulomb.Fc", "friction.coulomb.sigma2", "area"]));
        let others = whole["others"].as_array().expect("names");
        for name in ["gain.force", "lag.force", "delay.position", "friction.direction.factor", "friction.kappaA"] {
            assert!(others.contains(&json!(name)), "{name}: {others:?}");
        }
        assert!(!others.contains(&json!("lag.position")), "{others:?}");
        assert_eq!(estimable("{}"), Err("the question is incomplete".to_owned()));
    }

    #[test]
    fn a_rotor_under_a_current_needs_an_inertia_and_a_gain() {
        let of = |position: &str, force: &str| {
            let signals = json!([["time", "s"], ["position", position], ["force", force]]);
            let question = json!({ "experiment": "force", "law": 2, "known": {}, "signals": signals });
            estimable(&question.to_string()).expect("an answer")
        };
        let rotor = of("deg", "mA");
        let bench = json!({ "mass": "kg.m2", "gain.force": "N.m/A", "spring": "N.m/rad", "springRest": "rad" });
        assert_eq!(rotor["bench"], bench);
        assert_eq!(
            [&rotor["units"]["friction.coulomb.Fc"], &rotor["units"]["offset.force"]],
            [&json!("N.m"), &json!("A")]
        );
        assert_eq!(of("mm", "N")["bench"]["incline"], "rad");
        let rig = json!({ "experiment": "rig", "law": 2, "known": {}, "signals": [["position", "deg"]] });
        let lacking = &estimable(&rig.to_string()).expect("an answer")["lacking"];
        assert!(
            lacking.as_str().expect("a text").starts_with("position is in rad, which only the experiment force takes")
        );
    }

    #[test]
    fn numbers_that_json_does_not_have_keep_their_names() {
        assert_eq!(
            [1.5, f64::INFINITY, -f64::INFINITY, f64::NAN].map(number),
            [json!(1.5), json!("Infinity"), json!("-Infinity"), json!("NaN")]
        );
    }
}
