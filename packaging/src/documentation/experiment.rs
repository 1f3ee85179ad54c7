//! The default experiment of a model, run here and drawn as a figure of its page.

use std::f64::consts::{PI, TAU};

use anyhow::{Result, anyhow};
use plotters::prelude::*;
use pneumatic_servo::model::{Model, Start};
use pneumatic_servo::variables::{DisplayUnit, Kind, Role, Variable};

use super::text::{escape, unit};

/// An input that moves.
struct Signal {
    input: &'static str,
    text: &'static str,
    at: fn(f64) -> f64,
}

/// Inputs that move; all others keep their start values.
const SIGNALS: [Signal; 5] = [
    Signal { input: "valveVoltage", text: "5 V + 2 V sin(2π t/s)", at: |t| 5.0 + 2.0 * libm::sin(TAU * t) },
    Signal { input: "referencePosition", text: "250 mm + 100 mm sin(π t/s)", at: |t| 0.25 + 0.1 * libm::sin(PI * t) },
    Signal {
        input: "position",
        text: "that of a carriage 20 ms behind the reference",
        at: |t| 0.25 + 0.1 * libm::sin(PI * (t - 0.02)),
    },
    Signal { input: "velocity", text: "that of the same carriage", at: |t| 0.1 * PI * libm::cos(PI * (t - 0.02)) },
    Signal {
        input: "craneVelocity",
        text: "0.25 m/s for 10 s, 0 for 5 s, and −0.25 m/s for 10 s",
        at: |t| 0.25 * (f64::from(t < 10.0) - f64::from((15.0..25.0).contains(&t))),
    },
];

/// What is drawn, where a model has it: each list in an axis of its own.
const PANELS: [&[&str]; 10] = [
    &["valveVoltage"],
    &["drivePosition", "referencePosition", "position"],
    &["positionError"],
    &["displacement"],
    &["tray.velocity", "walk.velocity", "velocity"],
    &["crane.position", "trolley[3].position", "trolley[2].position", "trolley[1].position"],
    &["trolley[3].velocity", "trolley[2].velocity", "trolley[1].velocity"],
    &["chamberA.pressure", "chamberB.pressure"],
    &["frictionForce"],
    &["trolley[3].frictionForce", "trolley[2].frictionForce", "trolley[1].frictionForce"],
];

const COLOURS: [RGBColor; 4] =
    [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115), RGBColor(91, 104, 118)];
const INK: RGBColor = RGBColor(29, 39, 51);
const LINE: RGBColor = RGBColor(213, 220, 228);
/// Twice what the page shows, since the drawing rounds to pixels.
const WIDTH: u32 = 1720;
const PANEL_HEIGHT: u32 = 250;
const FONT: (&str, i32) = ("sans-serif", 26);

/// A section with the figure; nothing for a model of which no variable is drawn.
///
/// # Errors
/// When the experiment fails or cannot be drawn.
pub fn section(model: &Model) -> Result<String> {
    let run = Run::new(model)?;
    let panels: Vec<Vec<&Curve>> = PANELS
        .iter()
        .map(|names| {
            names.iter().filter_map(|name| run.curves.iter().find(|curve| curve.variable.name == *name)).collect()
        })
        .filter(|panel: &Vec<_>| !panel.is_empty())
        .collect();
    if panels.is_empty() {
        return Ok(String::new());
    }
    let moved = run.signals.iter().map(|signal| format!("<code>{}</code> is {}", signal.input, escape(signal.text)));
    let moved = match moved.collect::<Vec<_>>() {
        texts if texts.is_empty() => "All inputs keep their start values.".to_owned(),
        texts => format!("{}; all other inputs keep their start values.", texts.join(", ")),
    };
    Ok(format!(
        "<section id=\"experiment\">\n<h2>Default experiment</h2>\n<figure>\n{}<figcaption>The default experiment with \
         all parameters at their defaults. {moved}</figcaption>\n</figure>\n</section>\n",
        draw(&run.times, &panels)?
    ))
}

/// A variable over time, as it is shown.
struct Curve {
    variable: &'static Variable,
    values: Vec<f64>,
}

struct Run {
    times: Vec<f64>,
    curves: Vec<Curve>,
    signals: Vec<&'static Signal>,
}

impl Run {
    /// Inputs are set at each communication point and held.
    fn new(model: &Model) -> Result<Self> {
        let variables = (model.variables)();
        let of = |wanted: fn(&Variable) -> bool| variables.iter().filter(move |variable| wanted(variable));
        let (inputs, computed) = (|v: &Variable| v.role == Role::Input, Variable::is_computed);
        let signal = |variable: &Variable| SIGNALS.iter().find(|signal| signal.input == variable.name);
        let starts = |wanted: fn(&Variable) -> bool| of(wanted).filter_map(|v| v.start).collect::<Vec<_>>();
        let parameters = starts(Variable::is_parameter);
        let inputs_at = |time: f64| -> Vec<f64> {
            of(inputs).map(|v| signal(v).map_or(v.start.unwrap_or_default(), |signal| (signal.at)(time))).collect()
        };
        let start = Start { time: 0.0, parameters: &parameters, inputs: &inputs_at(0.0), tolerance: None };
        let mut simulation = (model.start)(&start)?;
        let mut curves: Vec<Curve> =
            of(inputs).chain(of(computed)).map(|variable| Curve { variable, values: Vec::new() }).collect();
        let mut values = vec![0.0; of(computed).count()];
        let (step, slopes) = (model.experiment.step_size, vec![0.0; of(inputs).count()]);
        let count = (model.experiment.stop_time / step).round() as u32;
        let times: Vec<f64> = (0..=count).map(|index| f64::from(index) * step).collect();
        for (index, time) in times.iter().enumerate() {
            let now = inputs_at(*time);
            simulation.set_inputs(&now, &slopes);
            simulation.values(&mut values);
            for (curve, value) in curves.iter_mut().zip(now.iter().chain(&values)) {
                curve.values.push(shown(curve.variable, *value));
            }
            if let Some(next) = times.get(index + 1) {
                simulation.advance(*next)?;
            }
        }
        Ok(Self { times, curves, signals: of(inputs).filter_map(signal).collect() })
    }
}

fn display(variable: &Variable) -> Option<&'static DisplayUnit> {
    let Kind::Real(of) = variable.kind else { return None };
    of.display.iter().find(|display| Some(display.name) == variable.display)
}

/// The value in the display unit, where one is suggested.
fn shown(variable: &Variable, value: f64) -> f64 {
    display(variable).map_or(value, |display| display.factor * value + display.offset)
}

fn unit_name(variable: &Variable) -> String {
    match (display(variable), variable.kind) {
        (Some(display), _) => unit(display.name),
        (None, Kind::Real(of)) => unit(of.name),
        (None, _) => String::new(),
    }
}

/// The axes one below the other, as SVG.
fn draw(times: &[f64], panels: &[Vec<&Curve>]) -> Result<String> {
    let mut svg = String::new();
    let height = PANEL_HEIGHT * panels.len() as u32 + 50;
    {
        let area = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        for (index, (panel, area)) in panels.iter().zip(area.split_evenly((panels.len(), 1))).enumerate() {
            draw_panel(times, panel, &area, index + 1 == panels.len()).map_err(|error| anyhow!("{error}"))?;
        }
        area.present()?;
    }
    // Within a page the namespace is known.
    let svg = svg.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", "", 1);
    Ok(svg.replacen("<svg ", "<svg role=\"img\" aria-label=\"Results of the default experiment over time\" ", 1))
}

fn draw_panel(
    times: &[f64],
    panel: &[&Curve],
    area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
    is_last: bool,
) -> Result<(), Box<dyn std::error::Error>> {
    let values = || panel.iter().flat_map(|curve| &curve.values);
    let (low, high) = values().fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(*value), high.max(*value)));
    let margin = (0.06 * (high - low)).max(1e-9 * high.abs().max(1.0));
    // The names of several curves stand above them.
    let names = if panel.len() > 1 { 0.32 * panel.len() as f64 * (high - low) } else { 0.0 };
    let end = times.last().copied().unwrap_or(1.0);
    let mut chart = ChartBuilder::on(area)
        .margin_top(16)
        .margin_right(30)
        .set_label_area_size(LabelAreaPosition::Left, 150)
        .set_label_area_size(LabelAreaPosition::Bottom, if is_last { 70 } else { 36 })
        .build_cartesian_2d(0.0..end, low - margin..high + margin + names)?;
    chart
        .configure_mesh()
        .x_labels(7)
        .y_labels(5)
        .light_line_style(TRANSPARENT)
        .bold_line_style(LINE)
        .axis_style(INK)
        .label_style((FONT.0, FONT.1, &INK))
        .x_label_formatter(&|value| rounded(*value))
        .y_label_formatter(&|value| rounded(*value))
        .x_desc(if is_last { "time (s)" } else { "" })
        .y_desc(format!("{} ({})", quantity(panel), unit_name(panel[0].variable)))
        .draw()?;
    // The curve that is looked at comes last in its list, on top and in the first colour.
    for (curve, colour) in panel.iter().zip(COLOURS.iter().take(panel.len()).rev()) {
        let points = times.iter().copied().zip(curve.values.iter().copied());
        let series = chart.draw_series(LineSeries::new(points, colour.stroke_width(3)))?;
        let colour = *colour;
        series
            .label(curve.variable.name.clone())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 40, y)], colour.stroke_width(3)));
    }
    if panel.len() > 1 {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .legend_area_size(50)
            .background_style(WHITE.mix(0.8))
            .label_font((FONT.0, FONT.1, &INK))
            .draw()?;
    }
    Ok(())
}

/// A number without the rounding of its last places.
fn rounded(value: f64) -> String {
    ((value * 1e6).round() / 1e6).to_string()
}

/// What an axis shows: the name of its only variable, or what the names have in common.
fn quantity(panel: &[&Curve]) -> &'static str {
    let name = panel.last().map_or("", |curve| curve.variable.name.as_str());
    match name.rsplit_once('.') {
        Some((_, last)) => last,
        None => words(name),
    }
}

/// The names that are more than one word.
fn words(name: &'static str) -> &'static str {
    match name {
        "valveVoltage" => "voltage",
        "frictionForce" => "friction force",
        "positionError" => "error",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::models;

    use super::*;

    #[test]
    fn each_model_has_a_figure_and_the_same_each_time() -> Result<()> {
        for model in models::ALL {
            let section = section(model)?;
            assert!(section.contains("<polyline"), "{}", model.name);
            assert_eq!(section, super::section(model)?);
        }
        Ok(())
    }
}
