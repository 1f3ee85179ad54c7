//! Units.

use super::table_cache;

/// Exponents of the SI base units kg, m, s, A, K, mol, cd and rad.
pub type BaseUnit = [i8; 8];

/// A display unit: `shown = factor * value + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayUnit {
    /// Name, for example `bar`.
    pub name: &'static str,
    /// Factor from the SI unit.
    pub factor: f64,
    /// Offset after scaling.
    pub offset: f64,
}

/// A coherent SI unit, so that its factor to the base units is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Name, for example `Pa`.
    pub name: &'static str,
    /// Exponents of the SI base units.
    pub base: BaseUnit,
    /// Units an engineer may prefer to look at.
    pub display: &'static [DisplayUnit],
}

impl Unit {
    /// The unit of the rate of a quantity.
    pub(crate) fn per_second(self) -> Self {
        let mut base = self.base;
        base[2] -= 1;
        let known = units::ALL.iter().find(|unit| unit.base == base);
        let other = || Self { name: table_cache::lent_name(&format!("{}/s", self.name)), base, display: &[] };
        known.copied().unwrap_or_else(other)
    }
}

/// The units of this library.
pub mod units {
    use super::{DisplayUnit, Unit};

    macro_rules! units {
        ($($(#[$doc:meta])* $id:ident = $name:literal $base:expr $(, $shown:literal $factor:expr, $offset:expr)*;)*) => {
            $($(#[$doc])* pub const $id: Unit = Unit {
                name: $name,
                base: $base,
                display: &[$(DisplayUnit { name: $shown, factor: $factor, offset: $offset }),*],
            };)*
            /// Every unit.
            pub const ALL: &[Unit] = &[$($id),*];
        };
    }

    // Exponents in the order kg, m, s, A, K, mol, cd, rad.
    units! {
        /// A number without dimension.
        ONE = "1" [0; 8];
        /// Length; shown in millimetres.
        METRE = "m" [0, 1, 0, 0, 0, 0, 0, 0], "mm" 1e3, 0.0;
        /// Volume; shown in cubic centimetres or litres.
        CUBIC_METRE = "m3" [0, 3, 0, 0, 0, 0, 0, 0], "cm3" 1e6, 0.0, "l" 1e3, 0.0;
        /// Time; shown in milliseconds.
        SECOND = "s" [0, 0, 1, 0, 0, 0, 0, 0], "ms" 1e3, 0.0;
        /// Rate.
        PER_SECOND = "1/s" [0, 0, -1, 0, 0, 0, 0, 0];
        /// Rate of a rate.
        PER_SECOND_SQUARED = "1/s2" [0, 0, -2, 0, 0, 0, 0, 0];
        /// Frequency.
        HERTZ = "Hz" [0, 0, -1, 0, 0, 0, 0, 0];
        /// Velocity; shown in millimetres per second.
        METRE_PER_SECOND = "m/s" [0, 1, -1, 0, 0, 0, 0, 0], "mm/s" 1e3, 0.0;
        /// Inverse velocity.
        SECOND_PER_METRE = "s/m" [0, -1, 1, 0, 0, 0, 0, 0];
        /// Acceleration.
        METRE_PER_SECOND_SQUARED = "m/s2" [0, 1, -2, 0, 0, 0, 0, 0];
        /// Mass; shown in grams.
        KILOGRAM = "kg" [1, 0, 0, 0, 0, 0, 0, 0], "g" 1e3, 0.0;
        /// Force.
        NEWTON = "N" [1, 1, -2, 0, 0, 0, 0, 0];
        /// Rate of a force.
        NEWTON_PER_SECOND = "N/s" [1, 1, -3, 0, 0, 0, 0, 0];
        /// Stiffness.
        NEWTON_PER_METRE = "N/m" [1, 0, -2, 0, 0, 0, 0, 0];
        /// Compliance; shown in micrometres per newton.
        METRE_PER_NEWTON = "m/N" [-1, 0, 2, 0, 0, 0, 0, 0], "um/N" 1e6, 0.0;
        /// Cubic stiffness.
        NEWTON_PER_CUBIC_METRE = "N/m3" [1, -2, -2, 0, 0, 0, 0, 0];
        /// Viscous damping.
        NEWTON_SECOND_PER_METRE = "N.s/m" [1, 0, -1, 0, 0, 0, 0, 0];
        /// Inverse length.
        PER_METRE = "1/m" [0, -1, 0, 0, 0, 0, 0, 0];
        /// Pressure; shown in bar.
        PASCAL = "Pa" [1, -1, -2, 0, 0, 0, 0, 0], "bar" 1e-5, 0.0;
        /// Rate of a pressure.
        PASCAL_PER_SECOND = "Pa/s" [1, -1, -3, 0, 0, 0, 0, 0], "bar/s" 1e-5, 0.0;
        /// Inverse pressure.
        PER_PASCAL = "1/Pa" [-1, 1, 2, 0, 0, 0, 0, 0], "1/bar" 1e5, 0.0;
        /// Absolute temperature; shown in degrees Celsius.
        KELVIN = "K" [0, 0, 0, 0, 1, 0, 0, 0], "degC" 1.0, -273.15;
        /// Rate of a temperature.
        KELVIN_PER_SECOND = "K/s" [0, 0, -1, 0, 1, 0, 0, 0];
        /// Mass flow; shown as the volume flow at the reference conditions of ISO 8778 (density 1.185 kg/m3).
        KILOGRAM_PER_SECOND = "kg/s" [1, 0, -1, 0, 0, 0, 0, 0], "g/s" 1e3, 0.0, "l/min(ANR)" 60_000.0 / 1.185, 0.0;
        /// Rate of a mass flow.
        KILOGRAM_PER_SECOND_SQUARED = "kg/s2" [1, 0, -2, 0, 0, 0, 0, 0];
        /// Sonic conductance of ISO 6358; shown in dm3/(s.bar).
        CUBIC_METRE_PER_SECOND_PASCAL = "m3/(s.Pa)" [-1, 4, 1, 0, 0, 0, 0, 0], "dm3/(s.bar)" 1e8, 0.0;
        /// Specific gas constant.
        JOULE_PER_KILOGRAM_KELVIN = "J/(kg.K)" [0, 2, -2, 0, -1, 0, 0, 0];
        /// Dynamic viscosity.
        PASCAL_SECOND = "Pa.s" [1, -1, -1, 0, 0, 0, 0, 0], "uPa.s" 1e6, 0.0;
        /// Laminar leakage coefficient: mass flow per difference of squared pressures.
        KILOGRAM_PER_SECOND_SQUARE_PASCAL = "kg/(s.Pa2)" [-1, 2, 3, 0, 0, 0, 0, 0];
        /// Heat transfer coefficient.
        WATT_PER_SQUARE_METRE_KELVIN = "W/(m2.K)" [1, 0, -3, 0, -1, 0, 0, 0];
        /// Voltage.
        VOLT = "V" [1, 2, -3, -1, 0, 0, 0, 0];
        /// Voltage per velocity.
        VOLT_SECOND_PER_METRE = "V.s/m" [1, 1, -2, -1, 0, 0, 0, 0];
        /// Voltage per length.
        VOLT_PER_METRE = "V/m" [1, 1, -3, -1, 0, 0, 0, 0];
        /// Angle; shown in degrees.
        RADIAN = "rad" [0, 0, 0, 0, 0, 0, 0, 1], "deg" 57.295_779_513_082_32, 0.0;
        /// Damping of a joint.
        NEWTON_METRE_SECOND = "N.m.s/rad" [1, 2, -1, 0, 0, 0, 0, -1];
        /// Torque.
        NEWTON_METRE = "N.m" [1, 2, -2, 0, 0, 0, 0, 0];
        /// Moment of inertia.
        KILOGRAM_SQUARE_METRE = "kg.m2" [1, 2, 0, 0, 0, 0, 0, 0];
        /// Angular velocity; shown in degrees per second.
        RADIAN_PER_SECOND = "rad/s" [0, 0, -1, 0, 0, 0, 0, 1], "deg/s" 57.295_779_513_082_32, 0.0;
        /// Angular acceleration.
        RADIAN_PER_SECOND_SQUARED = "rad/s2" [0, 0, -2, 0, 0, 0, 0, 1];
        /// Energy.
        JOULE = "J" [1, 2, -2, 0, 0, 0, 0, 0];
    }
}
