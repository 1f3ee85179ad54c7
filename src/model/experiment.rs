//! The default experiment of a model, with the inputs that move in it.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::variables::Table;

/// The experiment a host should offer by default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Experiment {
    /// Stop time in s; the start time is 0.
    pub stop_time: f64,
    /// Communication step size in s.
    pub step_size: f64,
    /// Inputs that move; all others keep their start values.
    pub signals: &'static [Signal],
    /// Variables to draw, one axis below the other.
    pub panels: &'static [Panel],
}

impl Experiment {
    /// The signal of an input, if it moves.
    pub fn signal(&self, input: &str) -> Option<&'static Signal> {
        self.signals.iter().find(|signal| signal.input == input)
    }

    /// Errors in it, given the variables of its model.
    #[doc(hidden)]
    pub fn problems(&self, table: &Table) -> Vec<String> {
        let mut problems = Vec::new();
        let is_positive = |value: f64| value.is_finite() && value > 0.0;
        if !is_positive(self.stop_time) || !is_positive(self.step_size) {
            problems.push("stop time and step size of the default experiment must be positive".to_owned());
        } else if self.stop_time < self.step_size {
            problems.push("the default experiment is shorter than one of its steps".to_owned());
        }
        for signal in self.signals {
            if !table.inputs().any(|input| input.name == signal.input) {
                problems.push(format!("the default experiment moves {}, which is no input", signal.input));
            }
        }
        for name in self.panels.iter().flat_map(|panel| panel.curves) {
            if table.find(name).is_none() {
                problems.push(format!("the default experiment shows {name}, which is no variable"));
            }
        }
        if self.panels.is_empty() || self.panels.iter().any(|panel| panel.curves.is_empty()) {
            problems.push("the default experiment shows nothing: it needs panels with curves".to_owned());
        }
        problems
    }

    /// The number of communication steps.
    pub fn steps(&self) -> u32 {
        (self.stop_time / self.step_size).round() as u32
    }
}

/// An input that moves: its value is set at each communication point and held.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Signal {
    /// Name of the input.
    pub input: &'static str,
    /// The course in words or as a formula.
    pub text: &'static str,
    /// The course over time.
    pub course: Course,
}

/// Variables that share an axis in a figure of the experiment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Panel {
    /// Label of the axis.
    pub label: &'static str,
    /// Names of the variables; the one that is looked at comes last, on top of the others.
    pub curves: &'static [&'static str],
}

/// Course of an input, in its SI unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Course {
    /// `mean + amplitude sin(2 pi frequency (t - delay))`.
    Sine {
        /// Mean value.
        mean: f64,
        /// Amplitude.
        amplitude: f64,
        /// Frequency in Hz.
        frequency: f64,
        /// Delay in s.
        delay: f64,
    },
    /// Constant from each time in s on; 0 before the first.
    Steps(&'static [(f64, f64)]),
}

impl Course {
    /// The value at a time in s.
    ///
    /// ```
    /// use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
    ///
    /// let voltage = MODEL.experiment.signal("valveVoltage").expect("the voltage moves");
    /// assert_eq!(voltage.course.at(0.25), 7.0);
    /// ```
    pub fn at(&self, time: f64) -> f64 {
        match *self {
            Self::Sine { mean, amplitude, frequency, delay } => {
                mean + amplitude * libm::sin(TAU * frequency * (time - delay))
            }
            Self::Steps(steps) => steps.iter().rev().find(|(begin, _)| *begin <= time).map_or(0.0, |(_, value)| *value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;
    use crate::models;
    use crate::variables::{Kind, Variable};

    #[test]
    fn only_inputs_move() {
        for model in models::ALL {
            for signal in model.experiment.signals {
                let inputs: Vec<_> = model.table().inputs().map(|variable| variable.name.as_str()).collect();
                assert!(inputs.contains(&signal.input), "{}: {}", model.name, signal.input);
            }
        }
    }

    #[test]
    fn what_is_drawn_together_has_a_unit_in_common() {
        for model in models::ALL {
            assert!(!model.experiment.panels.is_empty(), "{}", model.name);
            for panel in model.experiment.panels {
                let unit = |name: &&str| match model.table().find(name)?.variable {
                    Variable { kind: Kind::Real(unit), display, .. } => Some((unit.name, *display)),
                    _ => None,
                };
                let units: Vec<_> = panel.curves.iter().map(unit).collect();
                assert!(units[0].is_some() && units.iter().all(|unit| *unit == units[0]), "{}: {panel:?}", model.name);
            }
        }
    }

    #[test]
    fn steps_begin_at_their_times() {
        let steps = Course::Steps(&[(1.0, 2.0), (3.0, -1.0)]);
        assert_eq!([0.9, 1.0, 2.9, 3.0, 9.0].map(|time| steps.at(time)), [0.0, 2.0, 2.0, -1.0, -1.0]);
    }
    /// A period of 2 s from 0.25 s on.
    #[test]
    fn sine_swings_about_its_mean() {
        let sine = Course::Sine { mean: 5.0, amplitude: 3.0, frequency: 0.5, delay: 0.25 };
        for (time, expected) in [(0.25, 5.0), (0.75, 8.0), (1.25, 5.0), (1.75, 2.0), (2.75, 8.0)] {
            let value = sine.at(time);
            assert!((value - expected).abs() < 1e-14, "{value} at {time} s");
        }
    }

    #[test]
    fn steps_lead_to_the_stop_time_and_signals_belong_to_their_inputs() {
        for model in models::ALL {
            let Model { name, experiment, .. } = model;
            let end = f64::from(experiment.steps()) * experiment.step_size;
            assert!((end / experiment.stop_time - 1.0).abs() < 1e-12, "{name}: {end} s");
            for input in model.table().inputs() {
                let mut signals = experiment.signals.iter().filter(|signal| signal.input == input.name);
                assert_eq!(experiment.signal(&input.name), signals.next(), "{name}: {}", input.name);
            }
        }
    }
}
