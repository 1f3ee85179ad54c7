//! Estimated parameters: bounds, and how a search sees them.

use std::collections::BTreeMap;

use pneumatic_servo::variables::{Kind, Role, Variable};

use crate::numerals::significant;
use crate::refused::Refused;

/// Values of parameters by name, in SI units.
pub type Values = BTreeMap<String, f64>;

/// Factor by which a positive parameter without bounds may be smaller or larger than its start.
pub const SPAN: f64 = 1e3;

/// A parameter that is estimated. A search sees its logarithm, or its value in units of its scale: the inner value.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// A parameter of the model, `gain.SIGNAL`, `offset.SIGNAL`, `delay.SIGNAL`, `lag.SIGNAL`, or a property of a bench.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Start value; NaN where only the data tell it.
    pub start: f64,
    /// Bounds.
    pub bounds: [f64; 2],
    /// Magnitude of its changes; 0 for a parameter whose logarithm is estimated.
    pub scale: f64,
    /// Whether the user gave the start.
    pub is_given: bool,
    /// Whether the user gave the bounds.
    pub is_bounded: bool,
    /// Smallest and largest value that the model accepts.
    pub legal: [f64; 2],
}

impl Parameter {
    /// Whether a search sees the logarithm.
    pub fn is_logarithmic(&self) -> bool {
        self.scale == 0.0
    }

    /// The inner value.
    pub fn inner(&self, value: f64) -> f64 {
        if self.is_logarithmic() { libm::log(value) } else { value / self.scale }
    }

    /// The value of an inner one.
    pub fn outer(&self, inner: f64) -> f64 {
        if self.is_logarithmic() { libm::exp(inner) } else { inner * self.scale }
    }

    /// The inner bounds.
    pub fn inner_bounds(&self) -> [f64; 2] {
        let inner =
            |bound: f64| if self.is_logarithmic() && bound <= 0.0 { f64::NEG_INFINITY } else { self.inner(bound) };
        self.bounds.map(inner)
    }

    /// The bound that an inner value is at, within a relative distance, if it is none of the model: beyond the latter is nothing.
    pub fn bound_of_user_at(&self, inner: f64, within: f64) -> Option<f64> {
        let is_at = |bound: f64| (inner - bound).abs() < within * inner.abs().max(1.0);
        let places = self.inner_bounds().into_iter().enumerate();
        let mut own = places.filter(|(place, bound)| is_at(*bound) && self.bounds[*place] != self.legal[*place]);
        own.next().map(|(place, _)| self.bounds[place])
    }

    /// The same with a start from the data, within the bounds; default bounds of a logarithm move along with it.
    pub fn at(&self, start: f64) -> Self {
        let mut moved = self.clone();
        if self.is_given || !start.is_finite() || (self.is_logarithmic() && start <= 0.0) {
            return moved;
        }
        if self.is_logarithmic() && !self.is_bounded {
            let [low, high] = self.bounds;
            moved.bounds = [low.min(start / SPAN).max(self.legal[0]), high.max(start * SPAN).min(self.legal[1])];
        }
        moved.start = start.max(moved.bounds[0]).min(moved.bounds[1]);
        moved
    }

    /// The same with another start, whoever gave the one before.
    pub fn moved(&self, start: f64) -> Self {
        let free = Self { is_given: false, ..self.clone() };
        Self { is_given: self.is_given, ..free.at(start) }
    }
}

/// Values of parameters by name, of a vector that begins with their inner values.
pub fn values(parameters: &[Parameter], x: &[f64]) -> Values {
    parameters.iter().zip(x).map(|(one, x)| (one.name.clone(), one.outer(*x))).collect()
}

/// Magnitudes of the offsets of sensors, by SI unit.
const OFFSETS: [(&str, f64); 9] = [
    ("m", 1e-4),
    ("N", 1.0),
    ("Pa", 1e3),
    ("m/s", 1e-2),
    ("V", 0.1),
    ("rad", 1e-3),
    ("rad/s", 1e-2),
    ("N.m", 1.0),
    ("A", 0.1),
];
const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
/// Longest delay and lag of a sensor in s, and the magnitude of their changes.
const LATE: f64 = 0.5;
const DELAY: f64 = 0.02;

impl Parameter {
    fn new(name: &str, unit: &str, start: f64, bounds: [f64; 2], scale: f64) -> Self {
        let (name, unit) = (name.to_owned(), unit.to_owned());
        Self { name, unit, start, bounds, scale, is_given: false, is_bounded: false, legal: ANY }
    }

    /// The gain, offset, delay or lag of the sensor of a signal in an SI unit; nothing for another kind.
    pub fn of_sensor(kind: &str, signal: &str, unit: &str) -> Option<Self> {
        let name = format!("{kind}.{signal}");
        match kind {
            "gain" => Some(Self::new(&name, "1", 1.0, ANY, 1.0)),
            "offset" => {
                let scale = OFFSETS.iter().find(|(known, _)| *known == unit).map_or(1.0, |(_, scale)| *scale);
                Some(Self::new(&name, unit, 0.0, ANY, scale))
            }
            "delay" => Some(Self::new(&name, "s", 0.0, [-LATE, LATE], DELAY)),
            "lag" => Some(Self { legal: [0.0, f64::INFINITY], ..Self::new(&name, "s", 0.0, [0.0, LATE], DELAY) }),
            _ => None,
        }
    }

    /// An input of a model that has one value for all records.
    pub fn of_input(name: &str, unit: &str, start: f64, bounds: [f64; 2]) -> Self {
        Self::new(name, unit, start, bounds, 0.0)
    }

    /// A property of a test bench; nothing for another name. The effective area of a seal has a start from the data alone.
    pub fn of_bench(name: &str) -> Option<Self> {
        const STEEPEST: [f64; 2] = [-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2];
        const NOT_NEGATIVE: [f64; 2] = [0.0, f64::INFINITY];
        let of = |unit, start, legal: [f64; 2], scale| Self { legal, ..Self::new(name, unit, start, legal, scale) };
        match name {
            "area" => Some(of("m2", f64::NAN, ANY, 1e-4)),
            "incline" => Some(of("rad", 0.0, STEEPEST, 0.1)),
            "spring" => Some(of("N/m", 100.0, NOT_NEGATIVE, 100.0)),
            "springRest" => Some(of("m", 0.0, ANY, 0.01)),
            _ => None,
        }
    }

    /// A real parameter of a model; nothing for another variable.
    pub fn of_variable(variable: &Variable) -> Option<Self> {
        let (Kind::Real(unit), Role::Fixed | Role::Tunable, Some(start)) =
            (variable.kind, variable.role, variable.start)
        else {
            return None;
        };
        let legal = [variable.min.unwrap_or(f64::NEG_INFINITY), variable.max.unwrap_or(f64::INFINITY)];
        let [least, most] = legal;
        // Viscous friction, heat transfer and the like may well be 0, which has no logarithm.
        let may_be_zero = ["N.s/m", "W/(m2.K)"].contains(&unit.name);
        if least >= 0.0 && start > 0.0 && !may_be_zero && most > 1.0 {
            let bounds = [least.max(start / SPAN), most.min(start * SPAN)];
            return Some(Self { legal, ..Self::new(&variable.name, unit.name, start, bounds, 0.0) });
        }
        let usual = if unit.name == "1/Pa" { 1e-6 } else { 1.0 };
        let nominal = variable.nominal.filter(|nominal| *nominal != 0.0).unwrap_or(usual);
        let scale = if start == 0.0 { nominal } else { start.abs() };
        Some(Self { legal, ..Self::new(&variable.name, unit.name, start, legal, scale) })
    }

    /// The same with a start and bounds that the user gives.
    ///
    /// # Errors
    /// [`Refused`] for what the model does not accept, and for a start that is not within the bounds.
    pub fn given(self, start: Option<f64>, bounds: Option<[f64; 2]>) -> Result<Self, Refused> {
        let legal = self.legal;
        let mut given = Self { start: start.unwrap_or(self.start), is_given: start.is_some(), ..self };
        if let Some([low, high]) = bounds {
            if low.is_nan() || high.is_nan() || low >= high {
                let [low, high] = [low, high].map(shown);
                return Err(Refused(format!("the lower bound {low} is not below the upper bound {high}")));
            }
            if low < legal[0] || high > legal[1] {
                return Err(Refused(format!("the bounds leave what is legal, {}", given.range(legal))));
            }
            (given.bounds, given.is_bounded) = ([low, high], true);
            // A start that only the data tell stays open.
            if start.is_none() && !given.start.is_nan() {
                given.start = given.start.max(low).min(high);
            }
            if low <= 0.0 && given.is_logarithmic() {
                given.scale = low.abs().max(high.abs());
            }
        } else if given.is_logarithmic() && given.start > 0.0 && start.is_some() {
            let is_usual = (given.bounds[0]..=given.bounds[1]).contains(&given.start);
            let [least, most] = if is_usual { given.bounds } else { legal };
            given.bounds = [least.max(given.start / SPAN), most.min(given.start * SPAN)];
        }
        if given.is_logarithmic() && given.start <= 0.0 {
            let [low, high] = given.bounds;
            (given.scale, given.bounds) = (high.abs().max(1e-300), [low.min(0.0), high]);
        }
        for ends in [legal, given.bounds] {
            if given.start < ends[0] || given.start > ends[1] {
                let text = format!("the start {} is not within {}", shown(given.start), given.range(ends));
                return Err(Refused(text));
            }
        }
        Ok(given)
    }

    /// A number of its own that only expressions of parameters use, such as a ratio.
    pub fn of_number(name: &str, start: f64) -> Self {
        Self::new(name, "1", start, ANY, if start == 0.0 { 1.0 } else { start.abs() })
    }

    /// A range as people write it, with its unit.
    fn range(&self, [low, high]: [f64; 2]) -> String {
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        format!("{} to {}{unit}", shown(low), shown(high))
    }
}

fn shown(value: f64) -> String {
    significant(value, 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mass() -> Parameter {
        let legal = [0.0, f64::INFINITY];
        Parameter { legal, ..Parameter::new("mass", "kg", 2.0, [2e-3, 2e3], 0.0) }
    }

    #[test]
    fn a_start_moves_the_bounds_that_nobody_gave() {
        let given = mass().given(Some(50.0), None).expect("a mass");
        assert_eq!((given.start, given.bounds, given.is_given, given.is_bounded), (50.0, [0.05, 2e3], true, false));
        // A start beyond the usual bounds is held to the legal bounds of the model alone.
        let far = mass().given(Some(5e6), None).expect("a mass");
        assert_eq!(far.bounds, [5e3, 5e9]);
        let zero = mass().given(Some(0.0), None).expect("0 has no logarithm, but a scale");
        assert_eq!((zero.scale, zero.bounds), (2e3, [0.0, 2e3]));
    }

    #[test]
    fn a_start_of_the_model_is_within_bounds_that_the_user_gives() {
        let given = mass().given(None, Some([3.0, 4.0])).expect("a mass");
        assert_eq!((given.start, given.bounds, given.is_given, given.is_bounded), (3.0, [3.0, 4.0], false, true));
        let linear = mass().given(None, Some([0.0, 4.0])).expect("a mass");
        assert_eq!(linear.scale, 4.0);
        let open = Parameter::of_bench("area").expect("a bench has it");
        assert!(open.given(None, Some([1e-5, 1e-3])).expect("an area").start.is_nan());
    }

    #[test]
    fn what_the_model_does_not_accept_is_refused_with_its_range() {
        let of = |start, bounds| mass().given(start, bounds).expect_err("refused").0;
        assert_eq!(of(Some(-1.0), None), "the start -1 is not within 0 to inf kg");
        assert_eq!(of(Some(5.0), Some([1.0, 3.0])), "the start 5 is not within 1 to 3 kg");
        assert_eq!(of(None, Some([3.0, 3.0])), "the lower bound 3 is not below the upper bound 3");
        assert_eq!(of(None, Some([-1.0, 3.0])), "the bounds leave what is legal, 0 to inf kg");
        let ratio = Parameter::of_number("ratio", 4.0).given(Some(4.0), Some([1.0, 3.0])).expect_err("refused").0;
        assert_eq!(ratio, "the start 4 is not within 1 to 3");
    }
}
