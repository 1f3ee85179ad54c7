//! Units of a machine that slides, or of one that rotates: its force is a torque, its mass an inertia, its position an angle.

use std::collections::BTreeMap;

use crate::experiment::Kind;
use crate::record::{UNITS, unit_of};
use crate::refused::Refused;
use crate::units::{nearest_unit, to_si, units_of};
use crate::{calibration, signals};

/// Units of a machine that slides, and those in their place of one that rotates; equations and numbers are the same.
pub const ROTATING: [(&str, &str); 9] = [
    ("m", "rad"),
    ("m/s", "rad/s"),
    ("m/s2", "rad/s2"),
    ("N", "N.m"),
    ("kg", "kg.m2"),
    ("N/m", "N.m/rad"),
    ("N.s/m", "N.m.s/rad"),
    ("1/m", "1/rad"),
    ("N/s", "N.m/s"),
];
/// Other SI units that readings of a machine that may rotate can have.
pub const ALSO: [(&str, &[&str]); 3] = [("position", &["rad"]), ("velocity", &["rad/s"]), ("force", &["N.m", "A"])];
/// The unit of a gain that makes a force or a torque of a reading in another unit.
pub const GAINS: [(&str, &str, &str); 4] =
    [("N", "A", "N/A"), ("N.m", "A", "N.m/A"), ("N", "N.m", "1/m"), ("N.m", "N", "m")];

/// Other SI units that readings of a signal may have.
pub fn also(signal: &str) -> &'static [&'static str] {
    ALSO.iter().find(|(name, _)| *name == signal).map_or(&[], |(_, units)| *units)
}

/// The SI unit that a unit of a signal, or a calibration, is converted to.
///
/// # Errors
/// A sentence with the nearest known unit and the units that there are.
pub fn si_of(signal: &str, unit: &str) -> Result<&'static str, String> {
    let (own, others) = (unit_of(signal), also(signal));
    let is_above_ambient = signal == signals::ABOVE_AMBIENT;
    let problem = match to_si(unit, own, is_above_ambient) {
        Ok(_) => return Ok(own),
        Err(problem) => problem,
    };
    if let Some(si) = others.iter().copied().find(|si| to_si(unit, si, is_above_ambient).is_ok()) {
        return Ok(si);
    }
    let (hint, is_calibration) = (calibration::hint(unit, own), calibration::Calibration::parse(unit).is_some());
    if others.is_empty() || is_calibration {
        return Err(problem + &hint);
    }
    let names = |si: &'static str| units_of(si).map(|unit| unit.name);
    let near = std::iter::once(own).chain(others.iter().copied()).find_map(|si| nearest_unit(unit, Some(si)));
    let near = near.map_or(String::new(), |near| format!("did you mean {near}? "));
    let of_own = names(own).collect::<Vec<_>>().join(", ");
    let of_others = others.iter().copied().flat_map(names).collect::<Vec<_>>().join(", ");
    let unit = unit.trim();
    Err(format!(
        "the unit {unit} is refused; {near}it must be one of {of_own}, or for the experiment force of {of_others}{hint}"
    ))
}

/// Units of a machine and of the readings of its sensors.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MachineUnits {
    /// Whether the machine rotates.
    pub is_rotating: bool,
    /// SI unit of the readings of the force, if it is not the unit of the machine's force: A for the current of a motor.
    pub force: Option<&'static str>,
}

impl MachineUnits {
    /// Units by the signals of an experiment and the SI units of their columns.
    ///
    /// # Errors
    /// [`Refused`] if some columns have units of a sliding machine, and others of a rotating machine.
    pub fn of_columns(kind: &Kind, columns: &[(&str, &'static str)]) -> Result<Self, Refused> {
        let is_other = |(signal, si): &&(&str, &str)| unit_of(signal) != *si;
        if !kind.may_rotate() {
            let Some((signal, si)) = columns.iter().find(is_other) else { return Ok(Self::default()) };
            let own: Vec<&str> = units_of(unit_of(signal)).map(|unit| unit.name).collect();
            return Err(Refused(format!(
                "{signal} is in {si}, which only the experiment force takes; {} takes {}",
                kind.name,
                own.join(", ")
            )));
        }
        let motion = || columns.iter().filter(|(signal, _)| ["position", "velocity"].contains(signal));
        let (turning, sliding) = (motion().find(is_other), motion().find(|column| !is_other(column)));
        if let (Some((first, unit)), Some((second, another))) = (turning, sliding) {
            return Err(Refused(format!(
                "{second} is in {another}, but {first} in {unit}: a machine slides or it rotates; which is it?"
            )));
        }
        let force = columns.iter().find(|(signal, _)| *signal == "force").map(|(_, si)| *si);
        let is_rotating = turning.is_some() || (force == Some("N.m") && sliding.is_none());
        let own = if is_rotating { "N.m" } else { "N" };
        Ok(Self { is_rotating, force: force.filter(|si| *si != own) })
    }

    /// A unit of the model, or its counterpart of a rotating machine.
    pub fn of<'a>(&self, unit: &'a str) -> &'a str {
        let counterpart = ROTATING.iter().find(|(own, _)| self.is_rotating && *own == unit);
        counterpart.map_or(unit, |(_, other)| *other)
    }

    /// SI unit of the readings of a signal.
    pub fn of_signal(&self, signal: &str) -> &'static str {
        match (signal, self.force) {
            ("force", Some(unit)) => unit,
            // The force that loads a bearing is one in N.
            ("normalForce", _) => unit_of(signal),
            _ => self.of(unit_of(signal)),
        }
    }

    /// SI units of the readings of all signals.
    pub fn of_signals(&self) -> BTreeMap<String, String> {
        UNITS.iter().map(|(signal, _)| ((*signal).to_owned(), self.of_signal(signal).to_owned())).collect()
    }

    /// Unit of the gain of a reading.
    pub fn of_gain(&self, signal: &str) -> &'static str {
        let (own, read) = (self.of(unit_of(signal)), self.of_signal(signal));
        GAINS.iter().find(|(to, from, _)| (*to, *from) == (own, read)).map_or("1", |(.., unit)| *unit)
    }

    /// Unit of a parameter, by its name and its unit of a machine that slides.
    pub fn of_parameter(&self, name: &str, unit: &str) -> String {
        let of = match name.split_once('.') {
            Some(("gain", signal)) => self.of_gain(signal),
            Some(("offset", signal)) => self.of_signal(signal),
            _ => self.of(unit),
        };
        of.to_owned()
    }

    /// Note on the units of the model, for people; nothing for a machine that slides.
    pub fn told(&self) -> Option<&'static str> {
        self.is_rotating.then_some("of a rotating machine: read N.m for N, kg.m2 for kg, rad for m")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(experiment: &str, columns: &[(&str, &'static str)]) -> Result<MachineUnits, String> {
        let kind = Kind::of_name(experiment).expect("an experiment");
        MachineUnits::of_columns(kind, columns).map_err(|refused| refused.0)
    }

    #[test]
    fn columns_tell_whether_a_machine_rotates_and_what_its_gain_is_in() {
        for (position, force, is_rotating, gain) in [
            ("m", "N", false, "1"),
            ("m", "A", false, "N/A"),
            ("m", "N.m", false, "1/m"),
            ("rad", "N.m", true, "1"),
            ("rad", "A", true, "N.m/A"),
            ("rad", "N", true, "m"),
        ] {
            let units = of("force", &[("force", force), ("position", position)]).expect("units");
            assert_eq!((units.is_rotating, units.of_gain("force")), (is_rotating, gain), "{position} {force}");
            assert_eq!([units.of_signal("force"), units.of_signal("position")], [force, position]);
            assert_eq!(units.of_signal("normalForce"), "N");
        }
        let rotor = of("force", &[("force", "A"), ("velocity", "rad/s")]).expect("units");
        let named =
            ["gain.force 1", "offset.force N", "offset.velocity m/s", "mass kg", "springRest m", "lag.velocity s"];
        let units =
            named.map(|text| text.split_once(' ').expect("a unit")).map(|(name, unit)| rotor.of_parameter(name, unit));
        assert_eq!(units, ["N.m/A", "A", "rad/s", "kg.m2", "rad", "s"]);
    }

    #[test]
    fn a_mixture_of_sliding_and_rotating_is_refused() {
        let mixed = of("force", &[("position", "rad"), ("velocity", "m/s")]).expect_err("a refusal");
        assert_eq!(mixed, "velocity is in m/s, but position in rad: a machine slides or it rotates; which is it?");
        let rig = of("rig", &[("position", "rad")]).expect_err("a refusal");
        assert!(
            rig.starts_with("position is in rad, which only the experiment force takes; rig takes m, cm, mm"),
            "{rig}"
        );
        assert_eq!(of("rig", &[("position", "m")]), Ok(MachineUnits::default()));
    }

    #[test]
    fn a_unit_tells_its_si_unit_or_is_refused_with_those_that_there_are() {
        assert_eq!(si_of("position", "deg"), Ok("rad"));
        assert_eq!(si_of("position", "0..10 V = 0..90 deg"), Ok("rad"));
        assert_eq!(si_of("force", "mA"), Ok("A"));
        assert_eq!(si_of("force", "Nm"), Ok("N.m"));
        let refused = si_of("position", "degs").expect_err("a refusal");
        let expected = "the unit degs is refused; did you mean deg? it must be one of m, cm, mm, um, nm, in, ft, or for the \
                        experiment force of rad, mrad, deg";
        assert_eq!(refused, expected);
        assert!(
            si_of("force", "V").expect_err("a refusal").ends_with("need a calibration, such as 4..20 mA = 0..10 bar")
        );
    }
}
