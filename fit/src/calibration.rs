//! Calibrations of transducers, written as units of columns: `4..20 mA = 0..10 bar`.

use crate::units::{spelled, to_si, units_of};

/// SI units of the readings of transducers; readings without a unit are counts of a converter.
const READINGS: [&str; 2] = ["V", "A"];
const EXAMPLE: &str = "4..20 mA = 0..10 bar";

/// A calibration: a straight line through two points.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The unit of the readings; empty for counts of a converter.
    pub reading: String,
    readings: [f64; 2],
    quantities: [f64; 2],
    unit: String,
}

impl Calibration {
    /// Parses a text; `None` where it has not the form of a calibration.
    ///
    /// # Errors
    /// A sentence that names what is wrong with a calibration.
    pub fn parse(text: &str) -> Option<Result<Self, String>> {
        let bare = text.trim();
        let bare = bare.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or(bare);
        (bare.contains("..") || bare.contains('=')).then(|| Self::of(bare))
    }

    fn of(text: &str) -> Result<Self, String> {
        let refused = |problem: &str| format!("the calibration {text} is refused: {problem}");
        let (readings, quantities) = text.split_once('=').ok_or_else(|| refused(&form()))?;
        let (readings, reading) = range(readings).ok_or_else(|| refused(&form()))?;
        let (quantities, unit) = range(quantities).ok_or_else(|| refused(&form()))?;
        let is_reading = |si: &str| units_of(si).any(|unit| unit.name == reading);
        if !(reading.is_empty() || reading == "%" || READINGS.iter().any(|si| is_reading(si))) {
            let problem = format!("readings are in V, mV, A, mA, % or, without a unit, in counts, not in {reading}");
            return Err(refused(&problem));
        }
        if unit.is_empty() {
            return Err(refused("the quantity has no unit"));
        }
        let is_point = |[low, high]: [f64; 2]| low == high || !low.is_finite() || !high.is_finite();
        if is_point(readings) || is_point(quantities) {
            return Err(refused("its two points must differ and be finite"));
        }
        Ok(Self { reading, readings, quantities, unit })
    }

    /// Factor and offset from readings to an SI unit.
    ///
    /// # Errors
    /// As of [`to_si`], for the unit of the quantity.
    pub fn to_si(&self, si: &str, is_above_ambient: bool) -> Result<(f64, f64), String> {
        let (factor, offset) = to_si(&self.unit, si, is_above_ambient)?;
        let [[low, high], [least, most]] = [self.readings, self.quantities];
        let slope = (most - least) / (high - low);
        Ok((slope * factor, (least - slope * low) * factor + offset))
    }
}

fn form() -> String {
    format!("a calibration is written as {EXAMPLE}: readings at two points, and the quantity there")
}

/// The end of a refusal of a column whose unit is one of readings where a quantity is meant; empty for another unit.
pub fn hint(text: &str, si: &str) -> String {
    let name = spelled(text);
    if READINGS.contains(&si) || !READINGS.iter().any(|of| units_of(of).any(|unit| unit.name == name)) {
        return String::new();
    }
    format!("; readings in {name} need a calibration, such as {EXAMPLE}")
}

/// Two numbers and the unit behind them, of `4..20 mA`; `4...20` is no range, since it may be one from 4 to 0.2.
fn range(text: &str) -> Option<([f64; 2], String)> {
    let (low, rest) = text.trim().split_once("..")?;
    let is_of_number = |letter: char| letter.is_ascii_digit() || "+-.eE".contains(letter);
    let rest = rest.trim_start();
    if rest.starts_with('.') {
        return None;
    }
    let end = rest.find(|letter| !is_of_number(letter)).unwrap_or(rest.len());
    let (high, unit) = rest.split_at(end);
    Some(([low.trim().parse().ok()?, high.parse().ok()?], spelled(unit)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_calibration_is_a_straight_line_through_its_points() {
        for (text, si, reading, expected) in [
            ("4..20 mA = 0..10 bar", "Pa", 4.0, 0.0),
            ("4..20 mA = 0..10 bar", "Pa", 20.0, 1e6),
            ("4..20mA=0..10bar", "Pa", 12.0, 5e5),
            ("4..20 mA = 0..10 barg", "Pa", 4.0, 101_325.0),
            ("0..10 V = -250..250 mm", "m", 7.5, 0.125),
            ("[10..0 V = 0..0.5 m]", "m", 2.5, 0.375),
            ("0..4095 = 0..500 mm", "m", 4095.0, 0.5),
            ("-10..10 V = -2e3..2e3 N", "N", 1.0, 200.0),
            ("4..20 mA = 0..10 V", "V", 12.0, 5.0),
        ] {
            let (factor, offset) = to_si(text, si, false).expect(text);
            let found = reading * factor + offset;
            assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{text} at {reading}: {found}");
        }
        let (_, offset) = to_si("0..10 V = 0..10 barg", "Pa", true).expect("a pressure above ambient");
        assert_eq!(offset, 0.0);
    }

    #[test]
    fn a_reading_without_a_calibration_is_refused_with_the_way_to_write_one() {
        assert_eq!(hint("mA", "Pa"), "; readings in mA need a calibration, such as 4..20 mA = 0..10 bar");
        assert_eq!(hint("mV", "V") + &hint("mm", "Pa"), "");
    }

    #[test]
    fn a_wrong_calibration_is_refused_by_what_is_wrong() {
        for (text, problem) in [
            ("4..20 mA", "is written as 4..20 mA = 0..10 bar"),
            ("4-20 mA = 0-10 bar", "is written as"),
            ("4...20 mA = 0..10 bar", "is written as"),
            ("4..20 mA = 0..10", "the quantity has no unit"),
            ("4..4 mA = 0..10 bar", "its two points must differ"),
            ("4..20 mA = 0..inf bar", "is written as"),
            ("0..10 mm = 0..10 bar", "not in mm"),
            ("0..10 V = 0..10 Bar", "did you mean bar?"),
            ("0..10 V = 0..10 mm", "the unit mm is refused"),
        ] {
            let refused = to_si(text, "Pa", false).expect_err(text);
            assert!(refused.contains(problem), "{text}: {refused}");
        }
        assert_eq!(Calibration::parse("mm"), None);
    }
}
