//! Units in which people write values: one table, for every interface.

use std::sync::LazyLock;

use crate::calibration::Calibration;

/// Pressure of the standard atmosphere in Pa, above which gauge pressures count.
pub const STANDARD_ATMOSPHERE: f64 = 101_325.0;

const POUND: f64 = 0.453_592_37;
const GRAVITY: f64 = 9.806_65;
const PSI: f64 = 6_894.757_293_168_361;
const INCH: f64 = 0.0254;
const FOOT: f64 = 0.3048;
const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// A litre of air per minute at the reference conditions of ISO 8778, in kg/s.
const LITRE_PER_MINUTE: f64 = 1.185e-3 / 60.0;
/// A cubic foot of air of 0.075 lb/ft3 (68 degF, 14.7 psi, 36 % humidity) per minute, in kg/s.
const CUBIC_FOOT_PER_MINUTE: f64 = 0.075 * POUND / 60.0;

/// Pressure from which a unit counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Datum {
    /// The unit does not say.
    Unstated,
    /// The atmosphere.
    Ambient,
    /// Vacuum.
    Vacuum,
}

/// A unit as people write it: `si = factor * written + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrittenUnit {
    /// Its name.
    pub name: &'static str,
    /// Name of its SI unit.
    pub si: &'static str,
    /// Factor to the SI unit.
    pub factor: f64,
    /// Offset in the SI unit, of an absolute value.
    pub offset: f64,
    /// Pressure from which it counts.
    pub datum: Datum,
}

impl WrittenUnit {
    /// Offset of a quantity that counts above ambient pressure, or of one that is absolute.
    ///
    /// A gauge unit of a pressure above ambient, or a unit that does not say from where it counts, has none.
    pub fn offset_of(&self, is_above_ambient: bool) -> f64 {
        match (is_above_ambient, self.datum) {
            (false, _) => self.offset,
            (true, Datum::Vacuum) => -STANDARD_ATMOSPHERE,
            (true, Datum::Ambient | Datum::Unstated) => 0.0,
        }
    }
}

/// Every unit that is known, by SI unit.
pub static WRITTEN_UNITS: LazyLock<Vec<WrittenUnit>> = LazyLock::new(|| {
    let of = |si: &'static str, units: &[(&'static str, f64)]| -> Vec<WrittenUnit> {
        let one = |(name, factor): &(&'static str, f64)| WrittenUnit {
            name,
            si,
            factor: *factor,
            offset: 0.0,
            datum: Datum::Unstated,
        };
        units.iter().map(one).collect()
    };
    let pressures = |datum, offset, units: &[(&'static str, f64)]| -> Vec<WrittenUnit> {
        of("Pa", units).into_iter().map(|unit| WrittenUnit { offset, datum, ..unit }).collect()
    };
    let celsius = WrittenUnit { name: "degC", si: "K", factor: 1.0, offset: 273.15, datum: Datum::Unstated };
    [
        of("1", &[("%", 1e-2)]),
        of(
            "s",
            &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("min", 60.0), ("h", 3_600.0), ("d", 86_400.0)],
        ),
        of("m", &[("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6), ("nm", 1e-9), ("in", INCH), ("ft", FOOT)]),
        of("m2", &[("m2", 1.0), ("cm2", 1e-4), ("mm2", 1e-6), ("in2", INCH * INCH)]),
        of("m3", &[("m3", 1.0), ("l", 1e-3), ("cm3", 1e-6), ("ml", 1e-6), ("in3", INCH * INCH * INCH)]),
        of("m/s", &[("m/s", 1.0), ("cm/s", 1e-2), ("mm/s", 1e-3), ("um/s", 1e-6), ("m/min", 1.0 / 60.0)]),
        of("m/s", &[("mm/min", 1e-3 / 60.0), ("km/h", 1.0 / 3.6), ("in/s", INCH), ("ft/s", FOOT)]),
        of("m/s2", &[("m/s2", 1.0), ("mm/s2", 1e-3)]),
        of("N", &[("N", 1.0), ("daN", 10.0), ("kN", 1e3), ("mN", 1e-3), ("lbf", POUND * GRAVITY)]),
        of("N", &[("kgf", GRAVITY), ("kp", GRAVITY)]),
        of("N/m", &[("N/m", 1.0), ("N/mm", 1e3), ("N/um", 1e6), ("lbf/in", POUND * GRAVITY / INCH)]),
        of("m/N", &[("m/N", 1.0), ("mm/N", 1e-3), ("um/N", 1e-6)]),
        of("N.s/m", &[("N.s/m", 1.0), ("N.s/mm", 1e3)]),
        of("kg", &[("kg", 1.0), ("g", 1e-3), ("t", 1e3), ("lb", POUND)]),
        of("Pa", &[("Pa", 1.0), ("hPa", 1e2), ("mbar", 1e2), ("kPa", 1e3), ("MPa", 1e6), ("bar", 1e5), ("psi", PSI)]),
        of("Pa", &[("atm", STANDARD_ATMOSPHERE)]),
        pressures(
            Datum::Ambient,
            STANDARD_ATMOSPHERE,
            &[("barg", 1e5), ("mbarg", 1e2), ("kPag", 1e3), ("MPag", 1e6), ("psig", PSI), ("Pag", 1.0)],
        ),
        pressures(Datum::Vacuum, 0.0, &[("bara", 1e5), ("mbara", 1e2), ("kPaa", 1e3), ("MPaa", 1e6), ("psia", PSI)]),
        of("Pa.s", &[("Pa.s", 1.0), ("mPa.s", 1e-3), ("uPa.s", 1e-6)]),
        of("J/(kg.K)", &[("J/(kg.K)", 1.0)]),
        of("Pa/s", &[("Pa/s", 1.0), ("bar/s", 1e5)]),
        of("1/Pa", &[("1/Pa", 1.0), ("1/bar", 1e-5)]),
        of("K", &[("K", 1.0)]),
        vec![celsius],
        of("V", &[("V", 1.0), ("mV", 1e-3)]),
        of("rad", &[("rad", 1.0), ("mrad", 1e-3), ("deg", DEGREE)]),
        of("rad/s", &[("rad/s", 1.0), ("deg/s", DEGREE), ("rpm", 6.0 * DEGREE)]),
        of("N.m", &[("N.m", 1.0), ("mN.m", 1e-3), ("kN.m", 1e3)]),
        of("kg.m2", &[("kg.m2", 1.0), ("kg.cm2", 1e-4), ("g.cm2", 1e-7)]),
        of("N.m/rad", &[("N.m/rad", 1.0)]),
        of("N.m.s/rad", &[("N.m.s/rad", 1.0)]),
        of("A", &[("A", 1.0), ("mA", 1e-3)]),
        of("Hz", &[("Hz", 1.0), ("kHz", 1e3)]),
        of(
            "m3/(s.Pa)",
            &[("m3/(s.Pa)", 1.0), ("dm3/(s.bar)", 1e-8), ("l/(s.bar)", 1e-8), ("l/(min.bar)", 1e-8 / 60.0)],
        ),
        of("kg/s", &[("kg/s", 1.0), ("g/s", 1e-3), ("l/min(ANR)", LITRE_PER_MINUTE), ("SCFM", CUBIC_FOOT_PER_MINUTE)]),
    ]
    .concat()
});

/// Other spellings of parts of units, and their own.
pub const PARTS: [(&str, &str); 15] = [
    (" ", ""),
    ("\u{a0}", ""),
    ("(g)", "g"),
    ("(a)", "a"),
    ("(abs)", "a"),
    ("(rel)", "g"),
    ("(\u{fc})", "g"),
    ("\u{b5}", "u"),
    ("\u{3bc}", "u"),
    ("^", ""),
    ("\u{b2}", "2"),
    ("\u{b3}", "3"),
    ("\u{b0}", "deg"),
    ("\u{b7}", "."),
    ("*", "."),
];
/// Other spellings of whole units, and their own.
pub const WHOLE: [(&str, &str); 20] = [
    ("Nm", "N.m"),
    ("mNm", "mN.m"),
    ("kNm", "kN.m"),
    ("Ns/m", "N.s/m"),
    ("inch", "in"),
    ("inches", "in"),
    ("sec", "s"),
    ("hr", "h"),
    ("L", "l"),
    ("Volt", "V"),
    ("baro", "barg"),
    ("bar\u{fc}", "barg"),
    ("barabs", "bara"),
    ("m/sec2", "m/s2"),
    ("m/sec", "m/s"),
    ("1/min", "rpm"),
    ("r/min", "rpm"),
    ("rev/min", "rpm"),
    ("U/min", "rpm"),
    ("msec", "ms"),
];

/// Units as words, in any case.
const WORDS: [(&str, &str); 22] = [
    ("second", "s"),
    ("seconds", "s"),
    ("sec", "s"),
    ("sekunde", "s"),
    ("sekunden", "s"),
    ("volt", "V"),
    ("volts", "V"),
    ("ampere", "A"),
    ("amperes", "A"),
    ("amp", "A"),
    ("amps", "A"),
    ("newton", "N"),
    ("newtons", "N"),
    ("pascal", "Pa"),
    ("bars", "bar"),
    ("meter", "m"),
    ("meters", "m"),
    ("metre", "m"),
    ("metres", "m"),
    ("millimeter", "mm"),
    ("millimetre", "mm"),
    ("millimeters", "mm"),
];

/// The unit that a word stands for.
pub fn of_word(text: &str) -> Option<&'static str> {
    let text = text.to_lowercase();
    WORDS.iter().find(|(word, _)| *word == text).map(|(_, unit)| *unit)
}

/// Name of a unit in the table, as far as only its spelling differs.
pub fn spelled(text: &str) -> String {
    let trimmed = text.trim();
    let closed = |open: char, close: char| trimmed.strip_prefix(open).and_then(|rest| rest.strip_suffix(close));
    let bare = closed('[', ']').or_else(|| closed('(', ')')).unwrap_or(trimmed);
    let name = PARTS.iter().fold(bare.to_owned(), |name, (other, own)| name.replace(other, own));
    let known = WHOLE.iter().find(|(other, _)| *other == name).map(|(_, own)| *own);
    known.or_else(|| of_word(&name)).map_or(name, str::to_owned)
}

/// The unit of a text, of any quantity.
pub fn written_unit(text: &str) -> Option<&'static WrittenUnit> {
    let name = spelled(text);
    WRITTEN_UNITS.iter().find(|unit| unit.name == name)
}

/// Units of a quantity by its SI unit, that first.
pub fn units_of(si: &str) -> impl Iterator<Item = &'static WrittenUnit> {
    WRITTEN_UNITS.iter().filter(move |unit| unit.si == si)
}

/// The known unit, of a quantity or of any, that an unknown one is most like; nothing if it is like none.
pub fn nearest_unit(text: &str, si: Option<&str>) -> Option<&'static str> {
    let name = spelled(text);
    let lower = name.to_lowercase();
    let letters = lower.chars().count();
    let of = || WRITTEN_UNITS.iter().filter(|unit| si.is_none_or(|si| unit.si == si)).map(|unit| unit.name);
    let is_same = |known: &&str| known.to_lowercase() == lower;
    let is_like =
        |known: &&str| letters > 2 && known.chars().count() > 1 && is_one_apart(&known.to_lowercase(), &lower);
    of().find(is_same).or_else(|| of().find(is_like))
}

/// Whether two texts differ by one letter that is missing, added or another.
fn is_one_apart(one: &str, other: &str) -> bool {
    let [one, other] = [one, other].map(|text| text.chars().collect::<Vec<_>>());
    let same = one.iter().zip(&other).take_while(|(one, other)| one == other).count();
    let (one, other) = (&one[same..], &other[same..]);
    match one.len().cmp(&other.len()) {
        std::cmp::Ordering::Less => other.get(1..) == Some(one),
        std::cmp::Ordering::Greater => one.get(1..) == Some(other),
        std::cmp::Ordering::Equal => one.get(1..) == other.get(1..),
    }
}

/// Factor and offset from a written unit, or a [calibration](Calibration), to an SI unit, of a quantity that may count above ambient
/// pressure.
///
/// # Errors
/// A sentence with the nearest known unit and the units that there are.
pub fn to_si(text: &str, si: &str, is_above_ambient: bool) -> Result<(f64, f64), String> {
    if let Some(calibration) = Calibration::parse(text) {
        return calibration?.to_si(si, is_above_ambient);
    }
    let name = spelled(text);
    if name == si || text.trim() == si {
        return Ok((1.0, 0.0));
    }
    if let Some(unit) = units_of(si).find(|unit| unit.name == name) {
        return Ok((unit.factor, unit.offset_of(is_above_ambient)));
    }
    let near = nearest_unit(text, Some(si)).map_or(String::new(), |near| format!("did you mean {near}? "));
    let mut names = vec![si];
    names.extend(units_of(si).map(|unit| unit.name).filter(|name| *name != si));
    Err(format!("the unit {} is refused; {near}it must be one of {}", text.trim(), names.join(", ")))
}

/// Values of a unit in an SI unit, by factor and offset; a thousandth is a quotient, so that 250 mm are 0.25 m.
pub fn scaled(values: &[f64], (factor, offset): (f64, f64)) -> Vec<f64> {
    if (factor, offset) == (1.0, 0.0) {
        return values.to_vec();
    }
    let inverse = (1.0 / factor).round();
    let is_exact = factor < 1.0 && (inverse * factor - 1.0).abs() < 1e-14;
    let scale = |value: &f64| if is_exact { value / inverse } else { value * factor } + offset;
    values.iter().map(scale).collect()
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::variables::units;

    use super::*;

    #[test]
    fn a_unit_stands_for_one_quantity_and_display_units_agree() {
        for (place, unit) in WRITTEN_UNITS.iter().enumerate() {
            assert!(WRITTEN_UNITS[..place].iter().all(|other| other.name != unit.name), "{}", unit.name);
            assert_eq!(written_unit(unit.name), Some(unit));
        }
        for (si, shown) in units::ALL.iter().flat_map(|unit| unit.display.iter().map(|shown| (unit.name, shown))) {
            let (factor, offset) = to_si(shown.name, si, false).unwrap_or_else(|error| panic!("{error}"));
            assert!((factor * shown.factor - 1.0).abs() < 1e-14, "{}", shown.name);
            assert!((offset + shown.offset / shown.factor).abs() < 1e-12, "{}", shown.name);
        }
    }

    #[test]
    fn a_gauge_unit_adds_the_atmosphere_to_absolute_pressures_only() {
        for (text, offset) in [
            ("barg", STANDARD_ATMOSPHERE),
            ("bar(g)", STANDARD_ATMOSPHERE),
            ("[psi (g)]", STANDARD_ATMOSPHERE),
            ("bar", 0.0),
            ("bar(a)", 0.0),
        ] {
            assert_eq!(to_si(text, "Pa", false).expect(text).1, offset, "{text}");
        }
        for (text, offset) in [("barg", 0.0), ("bar", 0.0), ("bara", -STANDARD_ATMOSPHERE)] {
            assert_eq!(to_si(text, "Pa", true).expect(text).1, offset, "{text}");
        }
    }

    #[test]
    fn thousandths_are_quotients() {
        let of = |text: &str, si: &str, value| scaled(&[value], to_si(text, si, false).expect(text))[0];
        assert_eq!(of("mm", "m", 250.061), 250.061 / 1000.0);
        assert_eq!(of("um", "m", 3.0), 3.0 / 1e6);
        assert_eq!(of("barg", "Pa", 1.0), 201_325.0);
        assert_eq!(of("degC", "K", 20.0), 293.15);
        assert_eq!(of("min", "s", 1.5), 90.0);
    }

    #[test]
    fn an_unknown_unit_is_refused_with_the_nearest_known_one() {
        for (text, si, near) in [("KN", "N", "kN"), ("Bar", "Pa", "bar"), ("lbs", "N", "lbf"), ("mms", "m", "mm")] {
            let refused = to_si(text, si, false).expect_err(text);
            assert!(refused.contains(&format!("unit {text} is refused; did you mean {near}?")), "{refused}");
        }
        assert_eq!(nearest_unit("left", None), None);
        assert!(to_si("furlong", "m", false).expect_err("a refusal").contains("it must be one of m, cm, mm"));
    }
}
