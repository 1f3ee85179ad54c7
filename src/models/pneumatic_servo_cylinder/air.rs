//! The air in the chambers: what flows in, and how pressures and temperatures follow.

use super::cylinder::PneumaticServoCylinder;
use super::places::{PRESSURE_A, PRESSURE_B, TEMPERATURE_A, TEMPERATURE_B, of_actuator};
use crate::friction::FrictionLaw;
use crate::numbers::{Pair, Scalar};
use crate::pneumatics::actuator::{self, Actuating, Ports};
use crate::pneumatics::chamber::ChamberRates;
use crate::pneumatics::gas::{GAS_CONSTANT, GasState};
use crate::pneumatics::orifice::{Flow, Inflow};

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Pressures and temperatures in both chambers.
    #[inline(always)]
    pub(super) fn gas<S: Scalar>(&self, x: &[S]) -> GasState<Pair<S>> {
        self.chambers.gas(Pair([x[PRESSURE_A], x[PRESSURE_B]]), Pair([x[TEMPERATURE_A], x[TEMPERATURE_B]]))
    }

    /// Rates of the gas in both chambers at a position and velocity of the carriage.
    #[inline(always)]
    pub(super) fn gas_rates<S: Scalar>(
        &self,
        gas: GasState<Pair<S>>,
        position: S,
        rate: S,
        inflow: Inflow<Pair<S>>,
    ) -> ChamberRates<Pair<S>> {
        let mut rates = self.chambers.rates(gas, self.lengths(position), Pair([rate, -rate]), inflow);
        if EXTENDED && self.options.opens_b {
            // It breathes as much as the piston displaces.
            let (Pair([_, pressure]), Pair([_, temperature])) = (gas.pressure, gas.temperature);
            let growth = -rate * self.chambers.areas[1];
            rates.mass_flow.0[1] = pressure * growth / (temperature * GAS_CONSTANT);
            (rates.pressure.0[1], rates.temperature.0[1]) = (S::zero(), S::zero());
        }
        rates
    }

    /// The sum over the chambers that are not open to the surroundings.
    #[inline(always)]
    pub(super) fn closed<S: Scalar>(&self, Pair([a, b]): Pair<S>) -> S {
        if EXTENDED && self.options.opens_b { a } else { a + b }
    }

    /// Lengths in m of the chambers.
    pub(super) fn lengths<S: Scalar>(&self, position: S) -> Pair<S> {
        Pair([position, -position + self.p.stroke])
    }

    /// What flows into the chambers; writes the rates of the lines, where there are any.
    #[inline(always)]
    pub(super) fn flows<S: Scalar>(
        &self,
        x: &[S],
        supply: S,
        gas: GasState<Pair<S>>,
        rates: &mut [S],
    ) -> Inflow<Pair<S>> {
        if !(EXTENDED && self.lines.are_used()) {
            return self.inflow(of_actuator(x), supply, gas);
        }
        let flows = self.through_lines(x, supply, gas);
        self.put_lines(&flows.rates, rates);
        flows.into
    }

    /// What flows into the chambers from the supply, from the exhaust and from each other, without lines between.
    #[inline(always)]
    pub(super) fn inflow<S: Scalar>(
        &self,
        actuator: [S; actuator::STATES],
        supply: S,
        gas: GasState<Pair<S>>,
    ) -> Inflow<Pair<S>> {
        let fed = self.actuator.feed(actuator, &self.ports(supply), gas);
        if self.p.piston_leakage == 0.0 { fed } else { fed + Inflow::from(self.piston_leak(gas)) }
    }

    /// What the actuator lies between; a supply below ambient acts as ambient.
    #[inline(always)]
    pub(super) fn ports<S: Scalar>(&self, supply: S) -> Ports<'_, S> {
        Ports {
            supply: &self.supply,
            supply_pressure: self.at_least_ambient(supply),
            exhaust: &self.exhaust,
            exhaust_pressure: self.p.ambient_pressure,
        }
    }

    /// The same behind the vessel of the supply, where there is one.
    #[inline(always)]
    pub(super) fn ports_at_valve<S: Scalar>(&self, x: &[S], supply: S) -> Ports<'_, S> {
        let ports = self.ports(supply);
        match self.vessel_pressure(x) {
            Some(supply_pressure) => Ports { supply_pressure, ..ports },
            None => ports,
        }
    }

    #[inline(always)]
    pub(super) fn at_least_ambient<S: Scalar>(&self, pressure: S) -> S {
        pressure.max(S::constant(self.p.ambient_pressure))
    }

    /// Laminar leakage past the piston seal into the chambers.
    pub(super) fn piston_leak<S: Scalar>(&self, gas: GasState<Pair<S>>) -> Flow<Pair<S>> {
        let (Pair([p_a, p_b]), Pair([t_a, t_b])) = (gas.pressure, gas.temperature);
        let to_b = (p_a * p_a - p_b * p_b) * self.p.piston_leakage;
        let temperature = if to_b.value() >= 0.0 { t_a } else { t_b };
        Flow { mass: Pair([-to_b, to_b]), temperature: Pair([temperature; 2]) }
    }
}
