//! Two 3/2 proportional valves, one for each chamber, each with a command of its own.

use super::actuation::{Actuating, Commands, Ports, STATES, SUPPLY, VOLTAGE_A, VOLTAGE_B};
use super::gas::GasState;
use super::lag::Lag;
use super::orifice::{Inflow, edge_pieces, is_above};
use super::valve::{Edges, Port};
use crate::numbers::{Number, Pair, Real, Scalar, Tangent, Varying};
use crate::system::{ClosedForm, Stride};
use crate::variables::{Fixed, ParameterError, Variable, units};
use crate::{outputs, parameters};

parameters! {
    /// The parameters of [`TwoValves`].
    Parameters {
        conductance: Fixed = Variable::parameter(1400, "twoValves.C", units::CUBIC_METRE_PER_SECOND_PASCAL, 3.93e-9).range(1e-13, 1e-5).shown_in("dm3/(s.bar)")
            .text("Sonic conductance of a fully open valve, either way");
        critical_ratio: Fixed = Variable::parameter(1401, "twoValves.b", units::ONE, 0.3).range(0.0, 0.99)
            .text("Critical pressure ratio of both valves");
        dead_zone: Fixed = Variable::parameter(1402, "twoValves.deadZone", units::ONE, 0.08).range(0.0, 0.9)
            .text("Dead zone of both valves as a fraction of the spool travel");
        leakage: Fixed = Variable::parameter(1403, "twoValves.leakage", units::ONE, 0.002).range(0.0, 1.0)
            .text("Opening of a closed metering edge as a fraction of the full opening");
        time_constant: Fixed = Variable::parameter(1404, "twoValves.tau", units::SECOND, 2e-3).range(1e-5, 10.0).plausible(1e-5, 0.5).shown_in("ms")
            .text("Time constant of the spools");
    }
}

/// Value references of the states, the spools.
const SPOOLS: [u32; STATES] = [260, 261];

outputs! {
    /// The computed variables of [`TwoValves`].
    Outputs {
        spool_a = spool(0, "A");
        spool_b = spool(1, "B");
        rate_a = rate(0, "A", VOLTAGE_A);
        rate_b = rate(1, "B", VOLTAGE_B);
    }
}

fn spool(side: usize, chamber: &str) -> Variable {
    let spool = Variable::output(SPOOLS[side], &format!("twoValves.spool{chamber}"), units::ONE).local().nominal(1.0);
    spool.depends_on(&[SPOOLS[side]]).text(&format!(
        "Spool position of the valve of chamber {chamber}: positive feeds, negative vents the chamber; 0 with another actuator"
    ))
}

fn rate(side: usize, chamber: &str, voltage: u32) -> Variable {
    let rate = Variable::output(SPOOLS[side] + 2, &format!("der(twoValves.spool{chamber})"), units::PER_SECOND).local();
    rate.nominal(100.0)
        .derivative_of(SPOOLS[side])
        .depends_on(&[voltage, SPOOLS[side]])
        .text(&format!("Rate of the spool of the valve of chamber {chamber}"))
}

/// A 3/2 proportional valve between each chamber, supply and exhaust. States: the spools.
///
/// ```text
/// u    = clamp((V - 5)/5, -1, 1)              of each voltage
/// ds/dt = (u - s)/tau
/// C    = C_full*(leak + (1 - leak)*opening(s))   from the supply, opening(-s) to the exhaust
/// opening(s) = clamp((s - d)/(1 - d), 0, 1)
/// ```
#[derive(Clone, Debug)]
pub struct TwoValves {
    lag: Lag,
    edges: Edges,
    dead_zone: Tangent,
    /// Inverse of the travel beyond the dead zone.
    per_travel: Tangent,
}

impl TwoValves {
    fn towards<S: Scalar>(commands: Commands<S>) -> [S; STATES] {
        commands.of_chambers().map(|voltage| ((voltage - 5.0) / 5.0).clamp(S::constant(-1.0), S::constant(1.0)))
    }

    /// Openings of the edges to the supply, or with the spools turned round to the exhaust.
    fn opening<S: Scalar>(&self, spools: Pair<S>) -> Pair<S> {
        ((spools - self.dead_zone) * self.per_travel).max(Pair::zero()).min(Pair::constant(1.0))
    }

    fn supplied<S: Scalar>(&self, spools: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
        let supply = ports.supply.at(Pair([ports.supply_pressure; 2]));
        Inflow::from(self.edges.flow(self.opening(Pair(spools)), supply, gas))
    }
}

impl Actuating for TwoValves {
    type Memory<S: Varying> = ();
    type Parameters = Parameters;

    const COMPUTED: usize = Outputs::<f64>::LEN;

    fn new(p: Parameters) -> Result<Self, ParameterError> {
        let Parameters { conductance, critical_ratio, dead_zone, leakage, time_constant } = p;
        let port = Port { conductance, critical_ratio };
        let (lag, edges) = (Lag::new(time_constant), Edges::new([port; 2], leakage));
        Ok(Self { lag, edges, dead_zone, per_travel: 1.0 / (1.0 - dead_zone) })
    }

    fn computed() -> Vec<Variable> {
        Outputs::<f64>::table()
    }

    fn feeds(chamber: usize) -> Vec<u32> {
        vec![SUPPLY, SPOOLS[chamber]]
    }

    fn variables(&self) -> [Option<u32>; STATES] {
        SPOOLS.map(Some)
    }

    fn takes_commands_of_chambers(&self) -> bool {
        true
    }

    fn has_closed_form(&self) -> bool {
        true
    }

    fn scales(&self) -> [f64; STATES] {
        [1.0; STATES]
    }

    fn start<S: Varying>(&self, _commands: Commands<S>) -> ([S; STATES], ()) {
        ([S::zero(); STATES], ())
    }

    fn rates<S: Scalar>(&self, spools: [S; STATES], commands: Commands<S>, _memory: &()) -> [S; STATES] {
        self.lag.rates(spools, Self::towards(commands))
    }

    fn half<S: Varying>(&self, step: f64) -> [[S; STATES]; STATES] {
        self.lag.half(step)
    }

    fn later<S: Varying>(
        &self,
        spools: [S; STATES],
        commands: Commands<S>,
        _memory: &(),
        stride: &Stride<S>,
    ) -> ClosedForm<[S; STATES]> {
        self.lag.later(spools, Self::towards(commands), stride)
    }

    fn feed<S: Scalar>(&self, spools: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
        let exhaust = ports.exhaust.at(Pair([S::along(ports.exhaust_pressure); 2]));
        let vented = self.edges.flow(self.opening(-Pair(spools)), exhaust, gas);
        self.supplied(spools, ports, gas) + Inflow::from(vented)
    }

    fn drawn<S: Scalar>(&self, spools: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Pair<S> {
        self.supplied(spools, ports, gas).mass
    }

    fn smooth_region(&self, spools: [f64; STATES], ports: &Ports<Real>, pressures: Pair<Real>) -> Pair<Real> {
        let spools = Pair(Real::all(&spools));
        let corners = [-1.0, -self.dead_zone.value, self.dead_zone.value, 1.0];
        let passed = corners.map(|corner| is_above(spools, Pair::constant(corner)));
        edge_pieces([ports.supply_pressure, Real::along(ports.exhaust_pressure)], pressures)
            + passed.into_iter().fold(Pair::zero(), |sum, one| sum + one) * 16.0
    }

    fn write<S: Scalar>(&self, spools: [S; STATES], commands: Commands<S>, memory: &(), slots: &mut [S]) {
        let ([spool_a, spool_b], [rate_a, rate_b]) = (spools, self.rates(spools, commands, memory));
        Outputs { spool_a, spool_b, rate_a, rate_b }.write(slots);
    }
}
