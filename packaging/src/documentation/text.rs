//! Numbers, units and text as HTML.

use pneumatic_servo::variables::{Unit, Variable};

/// Text that may hold any character.
pub fn escape(text: &str) -> String {
    quick_xml::escape::escape(text).into_owned()
}

/// A number, rounded for engineers, for example `3.93 × 10⁻⁹`.
pub fn number(value: f64) -> String {
    // Fifteen digits hide what scaling to a display unit adds in the last place.
    let rounded: f64 = format!("{value:.14e}").parse().unwrap_or(value);
    let magnitude = rounded.abs();
    if magnitude == 0.0 || (1e-3..1e6).contains(&magnitude) {
        return rounded.to_string().replace('-', "−");
    }
    let text = format!("{rounded:e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let power = format!("10<sup>{}</sup>", exponent.replace('-', "−"));
    match mantissa {
        "1" => power,
        _ => format!("{} × {power}", mantissa.replace('-', "−")),
    }
}

/// A unit's name, for example `m³/(s·Pa)`; nothing for plain numbers.
pub fn unit(name: &str) -> String {
    if name == "1" {
        return String::new();
    }
    let mut html = String::new();
    let mut previous = ' ';
    for character in name.chars() {
        match character {
            '.' => html.push('·'),
            '2'..='4' if previous.is_ascii_alphabetic() => html.push_str(&format!("<sup>{character}</sup>")),
            _ => html.push(character),
        }
        previous = character;
    }
    html.replace("degC", "°C").replace("deg", "°")
}

/// A value in the unit of its variable, and in the display unit if one is suggested.
pub fn quantity(value: f64, of: Unit, variable: &Variable) -> String {
    let si = format!("{} {}", number(value), unit(of.name));
    let display = of.display.iter().find(|display| Some(display.name) == variable.display);
    match display {
        Some(display) if value != 0.0 => {
            let shown = number(display.factor * value + display.offset);
            format!("{si} <small>({shown} {})</small>", unit(display.name))
        }
        _ => si.trim_end().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::variables::units;

    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(number(0.0), "0");
        assert_eq!(number(0.016 * 1e3), "16");
        assert_eq!(number(101_325.0 * 1e-5), "1.01325");
        assert_eq!(number(3.93e-9), "3.93 × 10<sup>−9</sup>");
        assert_eq!(number(-1e6), "−1 × 10<sup>6</sup>");
        assert_eq!(number(1e-5), "10<sup>−5</sup>");
    }

    #[test]
    fn units_read_well() {
        assert_eq!(unit("m3/(s.Pa)"), "m<sup>3</sup>/(s·Pa)");
        assert_eq!(unit("1/s2"), "1/s<sup>2</sup>");
        assert_eq!(unit("l/min(ANR)"), "l/min(ANR)");
        assert_eq!(unit("1"), "");
        assert_eq!(unit("m/(2.s2)"), "m/(2·s<sup>2</sup>)", "a number that is no power");
        assert_eq!(unit("degC"), "°C");
    }

    #[test]
    fn a_suggested_display_unit_is_shown() {
        let pressure = Variable::input(0, "p", units::PASCAL, 5e5);
        assert_eq!(quantity(5e5, units::PASCAL, &pressure), "500000 Pa");
        let shown = pressure.shown_in("bar");
        assert_eq!(quantity(5e5, units::PASCAL, &shown), "500000 Pa <small>(5 bar)</small>");
        assert_eq!(quantity(0.0, units::PASCAL, &shown), "0 Pa", "nothing is so in any unit");
        let celsius = Variable::input(0, "T", units::KELVIN, 293.15).shown_in("degC");
        assert_eq!(quantity(293.15, units::KELVIN, &celsius), "293.15 K <small>(20 °C)</small>");
    }
}
