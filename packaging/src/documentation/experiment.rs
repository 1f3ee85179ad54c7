//! The default experiment of a model as a figure, and as a section of its page.

use anyhow::{Context, Result, anyhow};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{DisplayUnit, Kind, Variable};

use super::text::{escape, unit};
use crate::experiment::{Curve, Recording};

const COLOURS: [RGBColor; 4] =
    [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115), RGBColor(91, 104, 118)];
const INK: RGBColor = RGBColor(29, 39, 51);
const LINE: RGBColor = RGBColor(213, 220, 228);
/// Twice what the page shows, since the drawing rounds to pixels.
const WIDTH: u32 = 1720;
const PANEL_HEIGHT: u32 = 250;
const FONT: (&str, i32) = ("sans-serif", 26);
/// Margins left of the axes, for their labels, and right of them.
const LEFT: u32 = 150;
const RIGHT: u32 = 30;
/// Beside the labels of the axes, for the height of their letters.
const BORDER: u32 = 8;
/// Margin above the axes, and height of the names of several curves.
const ABOVE: u32 = 16;
const NAMES: u32 = 34;
/// The length of the line that stands before a name.
const SAMPLE: i32 = 40;

/// A section with the figure.
///
/// # Errors
/// When the experiment fails or cannot be drawn.
pub fn section(model: &Model) -> Result<String> {
    let run = Recording::of(model).with_context(|| format!("the default experiment of {}", model.name))?;
    let svg = figure(model, &run)?;
    let signals = model.experiment.signals;
    let moved = signals.iter().map(|signal| format!("<code>{}</code> is {}", signal.input, escape(signal.text)));
    let moved = match moved.collect::<Vec<_>>() {
        texts if texts.is_empty() => "All inputs keep their start values.".to_owned(),
        texts => format!("{}; all other inputs keep their start values.", texts.join(", ")),
    };
    // Within a page the namespace is known.
    let svg = svg.replacen(NAMESPACE, "", 1);
    Ok(format!(
        "<section id=\"experiment\">\n<h2>Default experiment</h2>\n<figure>\n{svg}<figcaption>The default experiment with \
         all parameters at their defaults. {moved}</figcaption>\n</figure>\n</section>\n",
    ))
}

/// The results of the experiment as SVG: the panels of the model.
///
/// # Errors
/// When one of their variables is not among the results, or they cannot be drawn.
pub fn figure(model: &Model, run: &Recording) -> Result<String> {
    let find = |name: &&str| run.curves.iter().find(|curve| curve.variable.name == **name);
    let mut drawn = Vec::new();
    for panel in model.experiment.panels {
        let curves: Option<Vec<_>> = panel.curves.iter().map(find).collect();
        drawn.push((panel.label, curves.with_context(|| format!("not among the results: one of {:?}", panel.curves))?));
    }
    draw(&run.times, &drawn)
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

const NAMESPACE: &str = " xmlns=\"http://www.w3.org/2000/svg\"";

/// The axes one below the other, as SVG.
fn draw(times: &[f64], panels: &[(&str, Vec<&Curve>)]) -> Result<String> {
    let mut svg = String::new();
    let height = PANEL_HEIGHT * panels.len() as u32 + 50;
    {
        let area = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        // The ink is dark, and so is the background of some viewers.
        area.fill(&WHITE)?;
        for (index, ((label, curves), area)) in panels.iter().zip(area.split_evenly((panels.len(), 1))).enumerate() {
            draw_panel(times, label, curves, &area, index + 1 == panels.len()).map_err(|error| anyhow!("{error}"))?;
        }
        area.present()?;
    }
    Ok(svg.replacen("<svg ", "<svg role=\"img\" aria-label=\"Results of the default experiment over time\" ", 1))
}

fn draw_panel(
    times: &[f64],
    label: &str,
    panel: &[&Curve],
    area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
    is_last: bool,
) -> Result<(), Box<dyn std::error::Error>> {
    let shown = |curve: &Curve| curve.values.iter().map(|value| shown(curve.variable, *value)).collect::<Vec<_>>();
    let curves: Vec<_> = panel.iter().map(|curve| (*curve, shown(curve))).collect();
    let values = curves.iter().flat_map(|(_, values)| values);
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(*value), high.max(*value)));
    let margin = (0.06 * (high - low)).max(1e-9 * high.abs().max(1.0));
    let has_names = panel.len() > 1;
    let end = times.last().copied().unwrap_or(1.0);
    let mut chart = ChartBuilder::on(area)
        .margin_top(if has_names { ABOVE + NAMES } else { ABOVE })
        .margin_right(RIGHT)
        .margin_left(BORDER)
        .set_label_area_size(LabelAreaPosition::Left, LEFT - BORDER)
        .set_label_area_size(LabelAreaPosition::Bottom, if is_last { 70 } else { 36 })
        .build_cartesian_2d(0.0..end, low - margin..high + margin)?;
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
        .y_desc(format!("{label} ({})", unit_name(panel[0].variable)))
        .draw()?;
    // The curve that is looked at comes last in its list, on top and in the first colour.
    for ((_, values), colour) in curves.iter().zip(COLOURS.iter().take(panel.len()).rev()) {
        let points = times.iter().copied().zip(values.iter().copied());
        chart.draw_series(LineSeries::new(points, colour.stroke_width(3)))?;
    }
    if has_names {
        draw_names(panel.iter().rev().map(|curve| &*curve.variable.name).zip(&COLOURS), area)?;
    }
    Ok(())
}

/// The names of curves, each after a line in its colour, in a row above the axes, where they hide nothing.
fn draw_names<'a>(
    names: impl Iterator<Item = (&'a str, &'a RGBColor)>,
    area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
) -> Result<(), Box<dyn std::error::Error>> {
    let style = TextStyle::from(FONT).color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
    let width = (WIDTH - LEFT - RIGHT) as i32 / COLOURS.len() as i32;
    let y = ABOVE as i32;
    for (place, (name, colour)) in (0..).zip(names) {
        let x = LEFT as i32 + place * width;
        area.draw(&PathElement::new([(x, y), (x + SAMPLE, y)], colour.stroke_width(3)))?;
        area.draw(&Text::new(name, (x + SAMPLE + 10, y), style.clone()))?;
    }
    Ok(())
}

/// A number without the rounding of its last places.
fn rounded(value: f64) -> String {
    ((value * 1e6).round() / 1e6).to_string()
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::models;
    use pneumatic_servo::variables::units;

    use super::*;

    #[test]
    fn each_model_has_a_figure_and_the_same_each_time() -> Result<()> {
        for model in models::ALL {
            let section = section(model)?;
            assert!(section.contains("<polyline"), "{}", model.name);
            let several = model.experiment.panels.iter().filter(|panel| panel.curves.len() > 1);
            for name in several.flat_map(|panel| panel.curves) {
                assert!(section.contains(&format!(">\n{name}\n</text>")), "{}: {name}", model.name);
            }
            assert_eq!(section, super::section(model)?);
        }
        Ok(())
    }

    #[test]
    fn section_says_which_inputs_move() -> Result<()> {
        for model in models::ALL {
            let (section, signals) = (section(model)?, model.experiment.signals);
            assert_eq!(section.contains("All inputs keep their start values."), signals.is_empty(), "{}", model.name);
            assert_eq!(section.contains("; all other inputs keep their start values."), !signals.is_empty());
            for signal in signals {
                assert!(section.contains(&format!("<code>{}</code> is ", signal.input)), "{}", signal.input);
            }
        }
        assert!(models::ALL.iter().any(|model| model.experiment.signals.is_empty()), "both kinds are there");
        Ok(())
    }

    #[test]
    fn values_are_shown_in_the_unit_that_is_suggested() {
        let celsius = Variable::parameter(0, "temperature", units::KELVIN, 0.0).shown_in("degC");
        assert!((shown(&celsius, 293.15) - 20.0).abs() < 1e-12, "{}", shown(&celsius, 293.15));
        let plain = Variable::parameter(0, "pressure", units::PASCAL, 0.0);
        let bar = plain.clone().shown_in("bar");
        // The factor of 1e-5 is rounded.
        assert!(shown(&plain, 6e5) == 6e5 && (shown(&bar, 6e5) - 6.0).abs() < 1e-14);
        assert_eq!((unit_name(&plain), unit_name(&bar)), (unit("Pa"), unit("bar")));
        let expected = [(0.1 + 0.2, "0.3"), (-2.0, "-2"), (2e-7, "0"), (1234.5, "1234.5")];
        assert!(expected.iter().all(|(value, text)| rounded(*value) == *text));
    }

    /// Pixels `[left, top, right, bottom]` of the curve that is drawn last.
    fn drawn(panels: &[(&str, Vec<&Curve>)]) -> Result<[f64; 4]> {
        let svg = draw(&[0.0, 1.0, 2.0], panels)?;
        // Lines of the axes and before the names have two points.
        let lines = svg.split("<polyline").filter_map(|line| line.split("points=\"").nth(1)?.split('"').next());
        let points = lines.filter(|line| line.split_whitespace().count() == 3).last();
        let mut edges = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for point in points.context("a curve")?.split_whitespace() {
            let (x, y) = point.split_once(',').context("a point")?;
            let (x, y): (f64, f64) = (x.parse()?, y.parse()?);
            edges = [edges[0].min(x), edges[1].min(y), edges[2].max(x), edges[3].max(y)];
        }
        Ok(edges)
    }

    /// A curve fills its axes from side to side, and but for 6 % of its height above and below; names take 34 pixels above. A
    /// panel has 250 pixels, and 50 are below the last; of these 300 the axes have what 16 above and 70 below leave. Drawing
    /// rounds to pixels.
    #[test]
    fn curve_fills_its_axes() -> Result<()> {
        const ROUNDING: f64 = 2.0;
        let variable = models::ALL[0].experiment.panels[0].curves[0];
        let variable = models::ALL[0].table().find(variable).context("a variable")?.variable;
        for values in [vec![0.0, 10.0, 0.0], vec![-3e5, 1e5, 0.0]] {
            let curve = Curve { variable, values };
            for (curves, above) in [(vec![&curve], 16.0), (vec![&curve; 2], 50.0)] {
                let found = drawn(&[("x", curves)])?;
                let margin = (230.0 - above) * 0.06 / 1.12;
                let expected = [150.0, above + margin, 1690.0, 230.0 - margin];
                let is_near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= ROUNDING);
                assert!(is_near, "{found:?}, not {expected:?}");
            }
            let below = drawn(&[("x", vec![&curve]), ("y", vec![&curve])])?;
            assert!(275.0 < below[1] && below[3] < 550.0, "{below:?} is not in the lower of two panels");
        }
        Ok(())
    }

    /// A constant has no height, and is drawn in the middle of its axes, which are from 16 to 230.
    #[test]
    fn curve_that_stays_the_same_is_in_the_middle() -> Result<()> {
        let variable = models::ALL[0].experiment.panels[0].curves[0];
        let variable = models::ALL[0].table().find(variable).context("a variable")?.variable;
        for value in [0.0, 0.25, -1e6] {
            let curve = Curve { variable, values: vec![value; 3] };
            let [_, top, _, bottom] = drawn(&[("x", vec![&curve])])?;
            assert!((top - 123.0).abs() <= 1.0 && top == bottom, "{value}: {top} to {bottom}");
        }
        Ok(())
    }

    /// Names of curves stand in columns of one width, each after a line in its colour.
    #[test]
    fn names_of_curves_stand_side_by_side() -> Result<()> {
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, (WIDTH, 100)).into_drawing_area();
            let names = ["one", "two", "three"].into_iter().zip(&COLOURS);
            draw_names(names, &area).map_err(|error| anyhow::anyhow!("{error}"))?;
        }
        // There are four colours, whose columns share what the margins of 150 and 30 leave of 1720. A line has 40 pixels, and its
        // name begins 10 behind it.
        let part = |text: &str, begin: &str| {
            text.split(begin).nth(1).and_then(|rest| rest.split('"').next()).unwrap_or_default().trim().to_owned()
        };
        let lines: Vec<String> = svg.split("<polyline").skip(1).map(|line| part(line, "points=\"")).collect();
        assert_eq!(lines, ["150,16 190,16", "535,16 575,16", "920,16 960,16"]);
        let texts: Vec<_> = svg.split("<text").skip(1).map(|text| (part(text, " x=\""), part(text, " y=\""))).collect();
        assert_eq!(texts, [("200", "16"), ("585", "16"), ("970", "16")].map(|(x, y)| (x.to_owned(), y.to_owned())));
        Ok(())
    }
}
