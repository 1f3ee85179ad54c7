//! Values that are legal and hardly meant: a unit was forgotten, as a rule.

use super::{Kind, Table, Variable};

/// Units that people write values in, by the SI unit that they stand for: name, and factor and offset from the SI unit.
const WRITTEN: &[(&str, &str, f64, f64)] = &[
    ("1", "%", 1e2, 0.0),
    ("m", "mm", 1e3, 0.0),
    ("m3", "cm3", 1e6, 0.0),
    ("m3", "l", 1e3, 0.0),
    ("s", "ms", 1e3, 0.0),
    ("Hz", "kHz", 1e-3, 0.0),
    ("m/s", "mm/s", 1e3, 0.0),
    ("kg", "g", 1e3, 0.0),
    ("N/m", "N/mm", 1e-3, 0.0),
    ("N/m", "N/um", 1e-6, 0.0),
    ("m/N", "um/N", 1e6, 0.0),
    ("Pa", "bar", 1e-5, 0.0),
    ("Pa", "kPa", 1e-3, 0.0),
    ("1/Pa", "1/bar", 1e5, 0.0),
    ("K", "degC", 1.0, -273.15),
    ("m3/(s.Pa)", "dm3/(s.bar)", 1e8, 0.0),
    ("Pa.s", "uPa.s", 1e6, 0.0),
    ("rad", "deg", 57.295_779_513_082_32, 0.0),
];

/// The unit in which a value may be meant that is not between bounds in its SI unit, as the end of a sentence; nothing if none
/// leads between them. Of several units it is the one in which such values are `shown`, then the one that comes nearest to a
/// `usual` value.
pub fn meant(unit: &str, value: f64, [low, high]: [f64; 2], shown: &str, usual: Option<f64>) -> Option<String> {
    // Percent are written for a share of a whole.
    let in_si = WRITTEN.iter().filter(|(si, name, ..)| *si == unit && (*name != "%" || high <= 1.0));
    let in_si = in_si.map(|(_, name, factor, offset)| (*name, (value - offset) / factor));
    let fitting = in_si.filter(|(_, other)| low <= *other && *other <= high && *other != 0.0);
    let distance = |name: &str, other: f64| {
        if name == shown { -1.0 } else { usual.map_or(0.0, |usual| libm::log((other / usual).abs()).abs()) }
    };
    let (name, other) = fitting.min_by(|(a, x), (b, y)| distance(a, *x).total_cmp(&distance(b, *y)))?;
    let si = if unit == "1" { String::new() } else { format!(" {unit}") };
    Some(format!("; did you mean {} {name}, which is {}{si}?", short(value), short(other)))
}

/// A number with at most six digits.
fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-4..1e6).contains(&rounded.abs()) { format!("{rounded}") } else { format!("{rounded:e}") }
}

impl Variable {
    /// The same with the range of values that rigs have; a legal value beyond, other than 0, gets a warning.
    pub fn plausible(self, low: f64, high: f64) -> Self {
        Self { plausible: Some([low, high]), ..self }
    }

    /// The name of the unit of a real variable.
    fn unit(&self) -> &'static str {
        if let Kind::Real(unit) = self.kind { unit.name } else { "1" }
    }

    /// The unit in which a value of this variable may be meant that is out of range, as the end of a sentence.
    pub fn meant(&self, value: f64) -> Option<String> {
        let Kind::Real(unit) = self.kind else { return None };
        let legal = [self.min.unwrap_or(f64::NEG_INFINITY), self.max.unwrap_or(f64::INFINITY)];
        let usual = self.start.filter(|start| *start != 0.0).or(self.nominal);
        let shown = self.display.or(unit.display.first().map(|shown| shown.name)).unwrap_or_default();
        meant(unit.name, value, self.plausible.unwrap_or(legal), shown, usual)
    }

    /// The same for a value that is beyond what is plausible.
    pub fn meant_beyond(&self, value: f64) -> Option<String> {
        self.is_doubtful(value).then(|| self.meant(value)).flatten()
    }

    fn is_doubtful(&self, value: f64) -> bool {
        self.plausible.is_some_and(|[low, high]| value != 0.0 && !(low <= value && value <= high))
    }

    /// The warning about a legal value that is hardly meant.
    pub fn doubt(&self, value: f64) -> Option<String> {
        let [low, high] = self.plausible.filter(|_| self.is_doubtful(value))?;
        let unit = if self.unit() == "1" { String::new() } else { format!(" {}", self.unit()) };
        let (shown, low, high) = (short(value), short(low), short(high));
        let hint = self.meant(value).unwrap_or_default();
        Some(format!("{} = {shown}{unit}: usual values are from {low} to {high}{unit}{hint}", self.name))
    }
}

impl Table {
    /// Warnings of parameters that differ from their defaults and are hardly meant, for the values of all; not of those
    /// without effect.
    pub fn doubts(&self, parameters: &[f64]) -> Vec<String> {
        let given = self.parameters().zip(parameters).filter(|(variable, value)| variable.start != Some(**value));
        let counts = |variable: &Variable| self.lack(variable, parameters).is_none();
        given.filter(|(it, _)| counts(it)).filter_map(|(variable, value)| variable.doubt(*value)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::units;

    fn stiffness() -> Variable {
        Variable::parameter(1, "k", units::NEWTON_PER_METRE, 1e5).range(1.0, 1e10).plausible(1e3, 1e9)
    }

    #[test]
    fn value_in_another_unit_is_recognised() {
        let told = stiffness().doubt(8.0).expect("a warning");
        assert_eq!(told, "k = 8 N/m: usual values are from 1000 to 1e9 N/m; did you mean 8 N/mm, which is 8000 N/m?");
        let told = Variable { start: Some(8e6), ..stiffness() }.doubt(9.0).expect("a warning");
        assert!(told.ends_with("did you mean 9 N/um, which is 9e6 N/m?"), "{told}");
        assert_eq!([1e3, 1e9, 0.0].map(|value| stiffness().doubt(value)), [None, None, None]);
        // No unit leads back between the bounds.
        assert!(stiffness().doubt(1e-9).expect("a warning").ends_with("1e9 N/m"));
    }

    #[test]
    fn refusal_says_what_may_be_meant() {
        let bore = Variable::parameter(1, "bore", units::METRE, 0.016).range(1e-4, 1.0);
        let refused = bore.check(16.0).expect_err("too large");
        assert_eq!(refused.reason, "it must be at most 1; did you mean 16 mm, which is 0.016 m?");
        let warm = Variable::parameter(1, "warm", units::KELVIN, 293.15).range(100.0, 1000.0);
        let share = Variable::parameter(1, "share", units::ONE, 0.5).range(0.0, 0.9);
        assert!(share.check(8.0).expect_err("too large").reason.ends_with("did you mean 8 %, which is 0.08?"));
        let factor = Variable::parameter(1, "factor", units::ONE, 1.0).range(0.0, 2.0);
        assert_eq!(factor.check(3.0).expect_err("too large").reason, "it must be at most 2");
        assert!(warm.check(20.0).expect_err("too cold").reason.ends_with("did you mean 20 degC, which is 293.15 K?"));
    }
    /// A default, or an order of magnitude, in another usual unit is refused or doubted, and the unit is named.
    #[test]
    fn forgotten_units_are_noticed() {
        // Both readings are plausible of a mass, a fraction, an angle, an offset and a coefficient of a regression; a decay velocity is
        // large for no decay.
        const QUANTITIES: [&str; 3] = ["kg", "1", "rad"];
        const NAMES: [&str; 5] = [".offset", "lugre.vd", "dLuGre.vd", "dnlrx.c", "dnlrx.chi0"];
        let is_exempt = |it: &Variable| {
            let name = it.name.split('[').next().unwrap_or_default();
            QUANTITIES.contains(&it.unit()) || NAMES.iter().any(|end| name.ends_with(end))
        };
        let mut passed = Vec::new();
        for model in [crate::models::pneumatic_servo_cylinder::MODEL, crate::models::position_controller::MODEL] {
            for variable in model.table().parameters().filter(|it| !is_exempt(it)) {
                let start = variable.start.filter(|start| *start != 0.0).or(variable.nominal);
                let units = WRITTEN.iter().filter(|(si, ..)| *si == variable.unit());
                for (value, (_, unit, factor, offset)) in
                    start.into_iter().flat_map(|it| units.clone().map(move |unit| (it, unit)))
                {
                    let written = value * factor + offset;
                    let told = variable
                        .check(written)
                        .map_or_else(|refused| Some(refused.reason), |()| variable.doubt(written));
                    if !told.is_some_and(|told| told.contains("did you mean")) {
                        passed.push(format!(
                            "{} = {value} {}, written as {written} {unit}",
                            variable.name,
                            variable.unit()
                        ));
                    }
                }
            }
        }
        assert!(passed.is_empty(), "nothing is said about\n{}", passed.join("\n"));
    }

    /// Defaults are plausible, and plausible values legal.
    #[test]
    fn plausible_values_are_legal_and_hold_the_defaults() {
        for variable in crate::models::ALL.iter().flat_map(|model| model.table().iter()) {
            let Some(range) = variable.plausible else { continue };
            assert!(range[0] < range[1], "{}", variable.name);
            assert!(variable.start.is_none_or(|start| variable.doubt(start).is_none()), "{}", variable.name);
            assert!(
                variable.role == crate::variables::Role::Input
                    || range.iter().all(|bound| variable.check(*bound).is_ok()),
                "{}: {range:?}",
                variable.name
            );
        }
    }
}
