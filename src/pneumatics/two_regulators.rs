//! Two pressure regulators, one for each chamber, each with a command of its own.

use super::actuation::{Actuating, Commands, Ports, STATES, SUPPLY, VOLTAGE_A, VOLTAGE_B};
use super::gas::GasState;
use super::orifice::{Inflow, Orifice, is_above, smooth_region};
use super::regulator::Regulator;
use crate::numbers::{Number, Pair, Real, Scalar, Varying};
use crate::system::{ClosedForm, Stride};
use crate::variables::{Fixed, ParameterError, Variable, units};
use crate::{outputs, parameters};

parameters! {
    /// The parameters of [`TwoRegulators`].
    Parameters {
        min_pressure: Fixed = Variable::parameter(1410, "twoRegulators.pMin", units::PASCAL, 1e5).range(1e3, 1e8).shown_in("bar")
            .text("Absolute pressure of both regulators at 0 V");
        max_pressure: Fixed = Variable::parameter(1411, "twoRegulators.pMax", units::PASCAL, 8.8e5).range(1e3, 1e8).shown_in("bar")
            .text("Absolute pressure of both regulators at 10 V");
        time_constant: Fixed = Variable::parameter(1412, "twoRegulators.tau", units::SECOND, 0.02).range(1e-5, 100.0).plausible(1e-4, 2.0).shown_in("ms")
            .text("Time constant of both regulators");
        conductance: Fixed = Variable::parameter(1413, "twoRegulators.C", units::CUBIC_METRE_PER_SECOND_PASCAL, 4e-9).range(1e-13, 1e-5).shown_in("dm3/(s.bar)")
            .text("Sonic conductance between each regulator and its chamber");
        critical_ratio: Fixed = Variable::parameter(1414, "twoRegulators.b", units::ONE, 0.3).range(0.0, 0.99)
            .text("Critical pressure ratio between each regulator and its chamber");
    }
}

/// Value references of the states.
const PRESSURES: [u32; STATES] = [264, 265];

outputs! {
    /// The computed variables of [`TwoRegulators`].
    Outputs {
        pressure_a = pressure(0, "A");
        pressure_b = pressure(1, "B");
        rate_a = rate(0, "A", VOLTAGE_A);
        rate_b = rate(1, "B", VOLTAGE_B);
    }
}

fn pressure(side: usize, chamber: &str) -> Variable {
    Variable::output(PRESSURES[side], &format!("twoRegulators.pressure{chamber}"), units::PASCAL)
        .local()
        .nominal(1e5)
        .shown_in("bar")
        .depends_on(&[PRESSURES[side]])
        .starts_from(&[[VOLTAGE_A, VOLTAGE_B][side]])
        .text(&format!("Absolute pressure behind the regulator of chamber {chamber}; 0 with another actuator"))
}

fn rate(side: usize, chamber: &str, voltage: u32) -> Variable {
    let name = format!("der(twoRegulators.pressure{chamber})");
    let rate = Variable::output(PRESSURES[side] + 2, &name, units::PASCAL_PER_SECOND).local().nominal(1e6);
    rate.derivative_of(PRESSURES[side])
        .depends_on(&[voltage, PRESSURES[side]])
        .text(&format!("Rate of the pressure behind the regulator of chamber {chamber}"))
}

/// A pressure regulator for each chamber. States: the pressures behind them.
///
/// ```text
/// dp/dt = (p_commanded(V) - p)/tau             of each voltage
/// mdot  = orifice(min(p, max(p_supply, p_chamber)) -> p_chamber)
/// ```
///
/// As with one regulator, a chamber gets no more than the pressure of the supply, and what it has beyond the regulated pressure
/// is vented.
#[derive(Clone, Debug)]
pub struct TwoRegulators {
    regulator: Regulator,
    orifice: Orifice,
}

impl TwoRegulators {
    fn towards<S: Scalar>(&self, commands: Commands<S>) -> [S; STATES] {
        commands.of_chambers().map(|voltage| self.regulator.command(voltage))
    }
}

impl Actuating for TwoRegulators {
    type Memory<S: Varying> = ();
    type Parameters = Parameters;

    const COMPUTED: usize = Outputs::<f64>::LEN;

    fn new(p: Parameters) -> Result<Self, ParameterError> {
        if p.max_pressure < p.min_pressure.value {
            let reason = format!("it must not be below twoRegulators.pMin = {}", p.min_pressure.value);
            return Err(ParameterError::new("twoRegulators.pMax", p.max_pressure.value, &reason));
        }
        let Parameters { min_pressure, max_pressure, time_constant, conductance, critical_ratio } = p;
        let regulator = Regulator { min_pressure, max_pressure, time_constant, conductance };
        Ok(Self { regulator, orifice: Orifice::new(critical_ratio) })
    }

    fn computed() -> Vec<Variable> {
        Outputs::<f64>::table()
    }

    fn feeds(chamber: usize) -> Vec<u32> {
        vec![SUPPLY, PRESSURES[chamber]]
    }

    fn variables(&self) -> [Option<u32>; STATES] {
        PRESSURES.map(Some)
    }

    fn takes_commands_of_chambers(&self) -> bool {
        true
    }

    fn has_closed_form(&self) -> bool {
        true
    }

    /// Above 30 Pa the pressures themselves are the magnitudes of their errors.
    fn scales(&self) -> [f64; STATES] {
        [30.0; STATES]
    }

    fn start<S: Varying>(&self, commands: Commands<S>) -> ([S; STATES], ()) {
        (self.towards(commands), ())
    }

    fn rates<S: Scalar>(&self, pressures: [S; STATES], commands: Commands<S>, _memory: &()) -> [S; STATES] {
        self.regulator.lag().rates(pressures, self.towards(commands))
    }

    fn half<S: Varying>(&self, step: f64) -> [[S; STATES]; STATES] {
        self.regulator.lag().half(step)
    }

    fn later<S: Varying>(
        &self,
        pressures: [S; STATES],
        commands: Commands<S>,
        _memory: &(),
        stride: &Stride<S>,
    ) -> ClosedForm<[S; STATES]> {
        self.regulator.lag().later(pressures, self.towards(commands), stride)
    }

    fn feed<S: Scalar>(&self, pressures: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
        let highest = Pair([ports.supply_pressure; 2]).max(gas.pressure);
        let conductance = Pair([S::along(self.regulator.conductance); 2]);
        Inflow::from(self.orifice.flow(conductance, ports.supply.at(Pair(pressures).min(highest)), gas))
    }

    /// Returning air is vented.
    fn drawn<S: Scalar>(&self, pressures: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Pair<S> {
        self.feed(pressures, ports, gas).mass.max(Pair::zero())
    }

    fn smooth_region(&self, pressures: [f64; STATES], ports: &Ports<Real>, chambers: Pair<Real>) -> Pair<Real> {
        let (pressures, supply) = (Pair(Real::all(&pressures)), Pair([ports.supply_pressure; 2]));
        let highest = supply.max(chambers);
        let is_short = is_above(pressures, highest);
        let is_spent = is_short * is_above(chambers, supply);
        smooth_region(pressures.min(highest), chambers) + (is_short + is_spent) * 4.0
    }

    fn write<S: Scalar>(&self, pressures: [S; STATES], commands: Commands<S>, memory: &(), slots: &mut [S]) {
        let ([pressure_a, pressure_b], [rate_a, rate_b]) = (pressures, self.rates(pressures, commands, memory));
        Outputs { pressure_a, pressure_b, rate_a, rate_b }.write(slots);
    }
}
