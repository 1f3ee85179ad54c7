//! The default experiment of a model: run here, or read from the results of a host.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use pneumatic_servo::model::{Model, Seeds, Start};
use pneumatic_servo::variables::Variable;

/// The default experiments of models, for programs that do not link the plant.
///
/// # Errors
/// When they cannot be written as JSON.
pub fn stated(models: &[Model]) -> Result<String> {
    let all: BTreeMap<_, _> = models.iter().map(|model| (model.name, model.experiment)).collect();
    Ok(serde_json::to_string_pretty(&all)? + "\n")
}

/// A variable over time, in its SI unit.
pub struct Curve {
    /// The variable.
    pub variable: &'static Variable,
    /// Its value at each communication point.
    pub values: Vec<f64>,
}

/// Results of an experiment.
pub struct Recording {
    /// The communication points in s.
    pub times: Vec<f64>,
    /// The variables.
    pub curves: Vec<Curve>,
}

impl Recording {
    /// Runs the experiment without any interface in between: all inputs and all that is computed.
    ///
    /// # Errors
    /// When a step fails.
    pub fn of(model: &Model) -> Result<Self> {
        let step = model.experiment.step_size;
        let times: Vec<f64> = (0..=model.experiment.steps()).map(|index| f64::from(index) * step).collect();
        let input_at = |input: &Variable, index: usize| {
            model.experiment.signal(&input.name).map(|signal| signal.course.at(times[index]))
        };
        Self::under(model, &times, input_at, |_, next| next)
    }

    /// Runs a model with its defaults from communication point to communication point, under inputs that are set at each and
    /// held; those that are not given keep their start values. A step leads from a point and the next to an end.
    fn under(
        model: &Model,
        times: &[f64],
        input_at: impl Fn(&Variable, usize) -> Option<f64>,
        end: impl Fn(f64, f64) -> f64,
    ) -> Result<Self> {
        let table = model.table();
        let starts = |variable: &Variable| variable.start.unwrap_or_default();
        let parameters: Vec<f64> = table.parameters().map(starts).collect();
        let inputs_at = |index: usize| -> Vec<f64> {
            table.inputs().map(|input| input_at(input, index).unwrap_or(starts(input))).collect()
        };
        let start =
            Start { time: 0.0, parameters: &parameters, inputs: &inputs_at(0), tolerance: None, seeds: Seeds::NONE };
        let mut simulation = (model.functions.start)(&start)?;
        let variables = table.inputs().chain(table.computed());
        let mut curves: Vec<_> = variables.map(|variable| Curve { variable, values: Vec::new() }).collect();
        let (mut values, slopes) = (vec![0.0; table.computed().count()], vec![0.0; table.inputs().count()]);
        for (index, time) in times.iter().enumerate() {
            let now = inputs_at(index);
            simulation.set_inputs(&now, &slopes);
            simulation.values(&mut values);
            for (curve, value) in curves.iter_mut().zip(now.iter().chain(&values)) {
                curve.values.push(*value);
            }
            if let Some(next) = times.get(index + 1) {
                simulation.advance(end(*time, *next))?;
            }
        }
        Ok(Self { times: times.to_vec(), curves })
    }

    /// Runs the model itself at the communication points of a host, under the inputs that the host has set, and demands the
    /// same bits of all that the host has read.
    ///
    /// # Errors
    /// When a step fails, or names the first value that is another one.
    pub fn ensure_bits(&self, model: &Model) -> Result<()> {
        let of = |variable: &Variable| self.curves.iter().find(|curve| curve.variable.reference == variable.reference);
        let input_at = |input: &Variable, index: usize| Some(of(input)?.values[index]);
        // A host gives a point and the size of a step, whose sum may be rounded.
        let expected = Self::under(model, &self.times, input_at, |time, next| time + (next - time))?;
        for (curve, found) in expected.curves.iter().filter_map(|curve| Some((curve, of(curve.variable)?))) {
            for ((time, expected), found) in self.times.iter().zip(&curve.values).zip(&found.values) {
                let name = &curve.variable.name;
                ensure!(
                    expected.to_bits() == found.to_bits(),
                    "{}: {name} is {found:?} in the host at {time} s, but {expected:?} in the plant",
                    model.name
                );
            }
        }
        Ok(())
    }

    /// The table that a host writes of a model's experiment.
    #[cfg(test)]
    pub fn table_of_a_host(model: &Model) -> Result<String> {
        let step = model.experiment.step_size;
        let times: Vec<f64> = (0..=model.experiment.steps()).map(|index| f64::from(index) * step).collect();
        let input_at = |input: &Variable, index: usize| {
            model.experiment.signal(&input.name).map(|signal| signal.course.at(times[index]))
        };
        let run = Self::under(model, &times, input_at, |time, next| time + (next - time))?;
        let names = run.curves.iter().map(|curve| &*curve.variable.name);
        let mut lines = vec![std::iter::once("time").chain(names).collect::<Vec<_>>().join(",")];
        lines.extend(run.times.iter().enumerate().map(|(index, time)| {
            let values = run.curves.iter().map(|curve| curve.values[index].to_string());
            std::iter::once(time.to_string()).chain(values).collect::<Vec<_>>().join(",")
        }));
        Ok(lines.join("\n") + "\n")
    }

    /// Reads the results of a host: a table whose columns are the time and variables of the model.
    ///
    /// # Errors
    /// Names the line with a cell that is no number, or the column that is no variable.
    pub fn read(model: &Model, table: &str) -> Result<Self> {
        let mut lines = table.lines();
        let mut names = lines.next().context("the table is empty")?.split(',');
        ensure!(names.next() == Some("time"), "the first column is not the time");
        let variable = |name: &str| {
            let found = model.table().find(name).map(|entry| entry.variable);
            found.with_context(|| format!("{} has no variable {name}", model.name))
        };
        let mut curves = names
            .map(|name| Ok(Curve { variable: variable(name)?, values: Vec::new() }))
            .collect::<Result<Vec<_>>>()?;
        let mut times = Vec::new();
        for (index, line) in lines.enumerate() {
            let cells = line.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>();
            let cells = cells.with_context(|| format!("line {}: {line}", index + 2))?;
            ensure!(cells.len() == curves.len() + 1, "line {} has {} cells", index + 2, cells.len());
            times.push(cells[0]);
            curves.iter_mut().zip(&cells[1..]).for_each(|(curve, value)| curve.values.push(*value));
        }
        Ok(Self { times, curves })
    }
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::models;

    use super::*;

    const MODEL: &Model = &models::pneumatic_servo_cylinder::MODEL;

    #[test]
    fn results_are_read_as_they_were_written() -> Result<()> {
        let run = Recording::read(MODEL, "time,position,sticking\n0.0,0.25,1.0\n1.0,0.5,0.0\n")?;
        assert_eq!(run.times, [0.0, 1.0]);
        assert_eq!(run.curves[0].values, [0.25, 0.5]);
        assert_eq!(run.curves[1].variable.name, "sticking");
        Ok(())
    }

    #[test]
    fn a_value_of_the_host_with_another_bit_is_named() -> Result<()> {
        let mut run = Recording::of(MODEL)?;
        let step = |time: f64, next: f64| time + (next - time);
        let input_at = |input: &Variable, index: usize| {
            MODEL.experiment.signal(&input.name).map(|signal| signal.course.at(run.times[index]))
        };
        run = Recording::under(MODEL, &run.times, input_at, step)?;
        run.ensure_bits(MODEL)?;
        let place = run.curves.iter().position(|curve| curve.variable.name == "position").context("a variable")?;
        let value = &mut run.curves[place].values[7];
        *value = value.next_up();
        let problem = run.ensure_bits(MODEL).map_or_else(|error| format!("{error:#}"), |()| String::new());
        assert!(problem.contains("position is 0.2500") && problem.contains("in the host at 0.007 s"), "{problem}");
        Ok(())
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        let problem = |table| Recording::read(MODEL, table).err().map(|error| format!("{error:#}")).unwrap_or_default();
        assert!(problem("time,altitude\n").contains("no variable altitude"));
        assert!(problem("time,position\n0,0\n1,far\n").contains("line 3: 1,far"));
        assert!(problem("time,position\n0\n").contains("line 2 has 1 cells"));
    }

    /// Each point of the results is the plant at that time, under the inputs that were held up to it.
    #[test]
    fn results_are_those_of_the_plant_at_the_same_times() -> Result<()> {
        let run = Recording::of(MODEL)?;
        let setup = pneumatic_servo::model::Setup::new(MODEL);
        let mut plant = setup.start(0.0)?;
        for (index, time) in run.times.iter().enumerate() {
            if index > 0 {
                plant.advance_to(*time)?;
            }
            for (place, input) in setup.table().inputs().enumerate() {
                if let Some(signal) = MODEL.experiment.signal(&input.name) {
                    plant.set_input(place, signal.course.at(*time))?;
                }
            }
            for curve in &run.curves {
                let name = &curve.variable.name;
                assert_eq!(curve.values[index], plant.get(name)?, "{name} at {time} s");
            }
        }
        let position = run.curves.iter().find(|curve| curve.variable.name == "position").context("a variable")?;
        assert!(position.values.iter().any(|x| (x - position.values[0]).abs() > 1e-3), "the carriage moves");
        Ok(())
    }
}
