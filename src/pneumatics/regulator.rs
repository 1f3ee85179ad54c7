//! The electronic pressure regulator of the rig with a plugged chamber.

use super::actuation::{Actuating, Commands, Ports, STATES, SUPPLY, VOLTAGE};
use super::gas::GasState;
use super::lag::Lag;
use super::orifice::{Inflow, Orifice, is_above, smooth_region};
use crate::numbers::{Number, Pair, Real, Scalar, Tangent, Varying};
use crate::system::{ClosedForm, Stride};
use crate::variables::{Fixed, ParameterError, Variable, units};
use crate::{outputs, parameters};

/// A pressure regulator commanded by 0 to 10 V, with a first-order lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regulator {
    /// Absolute pressure in Pa at 0 V.
    pub min_pressure: Tangent,
    /// Absolute pressure in Pa at 10 V.
    pub max_pressure: Tangent,
    /// Time constant of the lag in s.
    pub time_constant: Tangent,
    /// Sonic conductance in m3/(s Pa) towards the chamber.
    pub conductance: Tangent,
}

impl Regulator {
    /// The commanded pressure in Pa at a voltage, which counts from 0 to 10 V.
    pub fn command<S: Scalar>(&self, voltage: S) -> S {
        let fraction = voltage.clamp(S::zero(), S::constant(10.0)) / 10.0;
        fraction * (self.max_pressure - self.min_pressure) + self.min_pressure
    }

    /// Rate in Pa/s at which the pressure approaches the commanded one.
    pub fn pressure_rate<S: Scalar>(&self, command: S, pressure: S) -> S {
        self.lag().rate(pressure, command)
    }

    pub(super) fn lag(&self) -> Lag {
        Lag::new(self.time_constant)
    }
}

parameters! {
    /// The parameters of [`PressureRegulator`].
    Parameters {
        min_pressure: Fixed = Variable::parameter(1033, "regulator.pMin", units::PASCAL, 1e5).range(1e3, 1e8).shown_in("bar")
            .text("Absolute pressure of the regulator at 0 V");
        max_pressure: Fixed = Variable::parameter(1034, "regulator.pMax", units::PASCAL, 8.8e5).range(1e3, 1e8).shown_in("bar")
            .text("Absolute pressure of the regulator at 10 V");
        time_constant: Fixed = Variable::parameter(1035, "regulator.tau", units::SECOND, 0.02).range(1e-5, 100.0).plausible(1e-4, 2.0).shown_in("ms")
            .text("Time constant of the regulator");
        conductance: Fixed = Variable::parameter(1036, "regulator.C", units::CUBIC_METRE_PER_SECOND_PASCAL, 4e-9).range(1e-13, 1e-5).shown_in("dm3/(s.bar)")
            .text("Sonic conductance between regulator and chamber A");
        critical_ratio: Fixed = Variable::parameter(1037, "regulator.b", units::ONE, 0.3).range(0.0, 0.99)
            .text("Critical pressure ratio between regulator and chamber A");
    }
}

/// Value reference of the state.
const PRESSURE: u32 = 203;

outputs! {
    /// The computed variables of [`PressureRegulator`].
    Outputs {
        pressure = Variable::output(PRESSURE, "regulator.pressure", units::PASCAL).local().nominal(1e5).shown_in("bar")
            .depends_on(&[PRESSURE])
            .starts_from(&[VOLTAGE])
            .text("Absolute pressure behind the regulator; 0 with another actuator");
        pressure_rate = Variable::output(205, "der(regulator.pressure)", units::PASCAL_PER_SECOND).local().nominal(1e6).derivative_of(PRESSURE)
            .depends_on(&[VOLTAGE, PRESSURE])
            .text("Rate of the pressure behind the regulator");
    }
}

/// The regulator that feeds chamber A, chamber B plugged. State: the pressure behind it.
///
/// ```text
/// mdot = orifice(p -> p_A),   p = min(p_regulated, max(p_supply, p_A))
/// ```
///
/// The chamber gets no more than the pressure of the supply, be it a vessel or not, and the supply takes nothing back. What
/// the chamber has beyond the regulated pressure is vented.
#[derive(Clone, Debug)]
pub struct PressureRegulator {
    regulator: Regulator,
    orifice: Orifice,
}

impl Actuating for PressureRegulator {
    type Memory<S: Varying> = ();
    type Parameters = Parameters;

    const COMPUTED: usize = Outputs::<f64>::LEN;

    fn new(p: Parameters) -> Result<Self, ParameterError> {
        if p.max_pressure < p.min_pressure.value {
            let reason = format!("it must not be below regulator.pMin = {}", p.min_pressure.value);
            return Err(ParameterError::new("regulator.pMax", p.max_pressure.value, &reason));
        }
        let Parameters { min_pressure, max_pressure, time_constant, conductance, critical_ratio } = p;
        let regulator = Regulator { min_pressure, max_pressure, time_constant, conductance };
        Ok(Self { regulator, orifice: Orifice::new(critical_ratio) })
    }

    fn computed() -> Vec<Variable> {
        Outputs::<f64>::table()
    }

    fn feeds(chamber: usize) -> Vec<u32> {
        if chamber == 0 { vec![SUPPLY, PRESSURE] } else { Vec::new() }
    }

    fn variables(&self) -> [Option<u32>; STATES] {
        [None, Some(PRESSURE)]
    }

    fn has_closed_form(&self) -> bool {
        true
    }

    /// Above 30 Pa the pressure itself is the magnitude of its errors.
    fn scales(&self) -> [f64; STATES] {
        [1.0, 30.0]
    }

    fn start<S: Varying>(&self, commands: Commands<S>) -> ([S; STATES], ()) {
        ([S::zero(), self.regulator.command(commands.voltage)], ())
    }

    fn rates<S: Scalar>(&self, [_, pressure]: [S; STATES], commands: Commands<S>, _memory: &()) -> [S; STATES] {
        [S::zero(), self.regulator.pressure_rate(self.regulator.command(commands.voltage), pressure)]
    }

    fn half<S: Varying>(&self, step: f64) -> [[S; STATES]; STATES] {
        [[S::zero(); STATES], [S::zero(), self.regulator.lag().left(step)]]
    }

    #[inline(always)]
    fn later<S: Varying>(
        &self,
        [_, pressure]: [S; STATES],
        commands: Commands<S>,
        _memory: &(),
        stride: &Stride<S>,
    ) -> ClosedForm<[S; STATES]> {
        let &Stride { size: step, half: [_, [_, left]] } = stride;
        let command = self.regulator.command(commands.voltage);
        let [middle, end, defect] =
            self.regulator.lag().course(pressure, command, step, left).map(|it| [S::zero(), it]);
        ClosedForm { middle, end, defect }
    }

    #[inline(always)]
    fn feed<S: Scalar>(&self, [_, pressure]: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
        let conductance = Pair([S::along(self.regulator.conductance), S::zero()]);
        let Pair([behind, _]) = gas.pressure;
        let source = pressure.min(ports.supply_pressure.max(behind));
        Inflow::from(self.orifice.flow(conductance, ports.supply.at(Pair([source; 2])), gas))
    }

    /// It vents the returning air.
    fn drawn<S: Scalar>(&self, states: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Pair<S> {
        self.feed(states, ports, gas).mass.max(Pair::zero())
    }

    #[inline(always)]
    fn smooth_region(
        &self,
        [_, pressure]: [f64; STATES],
        ports: &Ports<Real>,
        Pair([pressure_a, _]): Pair<Real>,
    ) -> Pair<Real> {
        let pressure = Real::of(pressure);
        let highest = ports.supply_pressure.max(pressure_a);
        let is_short = is_above(pressure, highest);
        let is_spent = is_short * is_above(pressure_a, ports.supply_pressure);
        Pair([smooth_region(pressure.min(highest), pressure_a) + 4.0 * (is_short + is_spent), Real::zero()])
    }

    fn write<S: Scalar>(&self, states: [S; STATES], commands: Commands<S>, memory: &(), slots: &mut [S]) {
        let [[_, pressure], [_, pressure_rate]] = [states, self.rates(states, commands, memory)];
        Outputs { pressure, pressure_rate }.write(slots);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pneumatics::actuation::DEFECT_WEIGHT;
    use crate::variables::{ParameterSet, Tunable};

    /// The lag has the solution `p = p_c + (p_0 - p_c)*exp(-t/tau)`, whose mean over a step of `tau` is
    /// `p_c + (p_0 - p_c)*(1 - 1/e)`.
    #[test]
    fn held_voltage_has_a_closed_form() {
        let p = Parameters::read(&[1e5, 9e5, 0.02, 4e-9, 0.3].map(Tunable::still)).expect("legal");
        let regulator = PressureRegulator::new(p).expect("legal");
        let stride = Stride { size: 0.02, half: regulator.half(0.02) };
        let ClosedForm { middle: [_, middle], end: [_, end], defect } =
            regulator.later([0.0, 2e5].map(Real::of), Commands::all(Real::of(5.0)), &(), &stride);
        let ([middle, end], defect) = ([middle, end].map(Real::value), defect.map(Real::value));
        let left = (-1.0f64).exp();
        assert!((end - (5e5 - 3e5 * left)).abs() < 1e-9, "{end}");
        assert!(((2e5 + 4.0 * middle + end) / 6.0 - (5e5 - 3e5 * (1.0 - left))).abs() < 1e-9, "{middle}");
        let [still, defect] = defect;
        assert!((defect - DEFECT_WEIGHT * (middle - (5e5 - 3e5 * left.sqrt()))).abs() < 1e-8, "{defect}");
        assert_eq!(still, 0.0, "there is no state in this place");
    }

    #[test]
    fn pressure_is_linear_in_the_voltage_between_the_limits() {
        let [min_pressure, max_pressure, time_constant, conductance] = [1e5, 9e5, 0.02, 4e-9].map(Tunable::still);
        let regulator = Regulator { min_pressure, max_pressure, time_constant, conductance };
        assert_eq!(
            [-1.0, 0.0, 5.0, 10.0, 11.0].map(|v| regulator.command(Real::of(v)).value),
            [1e5, 1e5, 5e5, 9e5, 9e5]
        );
    }
}
