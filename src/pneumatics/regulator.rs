//! The electronic pressure regulator of the rig with a plugged chamber.

use crate::numbers::Scalar;

/// A pressure regulator commanded by 0 to 10 V, with a first-order lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regulator {
    /// Absolute pressure in Pa at 0 V.
    pub min_pressure: f64,
    /// Absolute pressure in Pa at 10 V.
    pub max_pressure: f64,
    /// Time constant of the lag in s.
    pub time_constant: f64,
    /// Sonic conductance in m3/(s Pa) towards the chamber.
    pub conductance: f64,
}

impl Regulator {
    /// The commanded pressure in Pa at a voltage, which counts from 0 to 10 V.
    pub fn command<S: Scalar>(&self, voltage: S) -> S {
        let fraction = voltage.clamp(S::zero(), S::constant(10.0)) / 10.0;
        fraction * (self.max_pressure - self.min_pressure) + self.min_pressure
    }

    /// Rate in Pa/s at which the pressure approaches the commanded one.
    pub fn pressure_rate<S: Scalar>(&self, command: S, pressure: S) -> S {
        (command - pressure) / self.time_constant
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pressure_is_linear_in_the_voltage_between_the_limits() {
        let regulator = Regulator { min_pressure: 1e5, max_pressure: 9e5, time_constant: 0.02, conductance: 4e-9 };
        assert_eq!([-1.0, 0.0, 5.0, 10.0, 11.0].map(|v| regulator.command(v)), [1e5, 1e5, 5e5, 9e5, 9e5]);
    }
}
