//! The valves, their lag and their flow.

use pneumatic_servo::numbers::Pair;
use pneumatic_servo::pneumatics::actuator::{Commands, Ports, STATES, SUPPLY, VOLTAGE};
use pneumatic_servo::pneumatics::gas::GasState;
use pneumatic_servo::pneumatics::orifice::{Inflow, Orifice, edge_pieces, is_above};
use pneumatic_servo::prelude::*;
use pneumatic_servo::system::{ClosedForm, Stride};

parameters! {
    /// The parameters of [`ValvePair`].
    Parameters {
        conductance: Fixed = Variable::parameter(40_001, "valvePair.C", units::CUBIC_METRE_PER_SECOND_PASCAL, 4e-9)
            .range(1e-13, 1e-5).shown_in("dm3/(s.bar)").text("Sonic conductance of a fully open valve, either way");
        critical_ratio: Fixed = Variable::parameter(40_002, "valvePair.b", units::ONE, 0.3).range(0.0, 0.99)
            .text("Critical pressure ratio of the valves");
        time_constant: Fixed = Variable::parameter(40_003, "valvePair.tau", units::SECOND, 0.005).range(1e-5, 10.0)
            .shown_in("ms").text("Time constant of the spools");
    }
}

/// Value references of the states, the spools.
const SPOOLS: [u32; STATES] = [40_011, 40_012];

outputs! {
    /// The computed variables of [`ValvePair`].
    Outputs {
        spool_a = Variable::output(SPOOLS[0], "valvePair.spoolA", units::ONE).local().nominal(1.0)
            .depends_on(&[SPOOLS[0]]).text("Spool of the valve of chamber A: above 0 it feeds, below it vents");
        spool_b = Variable::output(SPOOLS[1], "valvePair.spoolB", units::ONE).local().nominal(1.0)
            .depends_on(&[SPOOLS[1]]).text("Spool of the valve of chamber B: above 0 it feeds, below it vents");
        rate_a = Variable::output(40_013, "der(valvePair.spoolA)", units::PER_SECOND).local().nominal(100.0)
            .derivative_of(SPOOLS[0]).depends_on(&[VOLTAGE, SPOOLS[0]]).text("Rate of that spool");
        rate_b = Variable::output(40_014, "der(valvePair.spoolB)", units::PER_SECOND).local().nominal(100.0)
            .derivative_of(SPOOLS[1]).depends_on(&[VOLTAGE, SPOOLS[1]]).text("Rate of that spool");
    }
}

/// A 3/2 proportional valve for each chamber, on one voltage: above 5 V chamber A is fed and B vented, below B is fed.
///
/// ```text
/// e = clamp((u - 5 V)/5 V, -1, 1),   tau*ds_A/dt = e - s_A,   tau*ds_B/dt = -e - s_B
/// mdot = C*max(s, 0) from the supply, C*max(-s, 0) to the exhaust    (ISO 6358)
/// ```
#[derive(Clone, Debug)]
pub struct ValvePair {
    conductance: Tunable,
    orifice: Orifice,
    time_constant: Tunable,
}

impl ValvePair {
    fn openings<S: Scalar>(voltage: S) -> [S; STATES] {
        let command = ((voltage - 5.0) / 5.0).clamp(S::constant(-1.0), S::constant(1.0));
        [command, -command]
    }

    fn supplied<S: Scalar>(&self, spools: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
        let open = Pair(spools.map(|spool| spool.max(S::zero()) * self.conductance));
        Inflow::from(self.orifice.flow(open, ports.supply.at(Pair([ports.supply_pressure; 2])), gas))
    }
}

impl Actuating for ValvePair {
    type Memory<S: Varying> = ();
    type Parameters = Parameters;

    const COMPUTED: usize = Outputs::<f64>::LEN;

    fn new(p: Parameters) -> Result<Self, ParameterError> {
        let Parameters { conductance, critical_ratio, time_constant } = p;
        Ok(Self { conductance, orifice: Orifice::new(critical_ratio), time_constant })
    }

    fn computed() -> Vec<Variable> {
        Outputs::<f64>::table()
    }

    fn feeds(chamber: usize) -> Vec<u32> {
        vec![SUPPLY, SPOOLS[chamber]]
    }

    fn variables(&self) -> [Option<u32>; STATES] {
        [Some(SPOOLS[0]), Some(SPOOLS[1])]
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

    fn rates<S: Scalar>(&self, [a, b]: [S; STATES], commands: Commands<S>, _memory: &()) -> [S; STATES] {
        let [to_a, to_b] = Self::openings(commands.voltage);
        [(to_a - a) / self.time_constant, (to_b - b) / self.time_constant]
    }

    fn half<S: Varying>(&self, step: f64) -> [[S; STATES]; STATES] {
        let left = S::along(-0.5 * step / self.time_constant).exp();
        [[left, S::zero()], [S::zero(), left]]
    }

    fn later<S: Varying>(
        &self,
        spools: [S; STATES],
        commands: Commands<S>,
        _memory: &(),
        stride: &Stride<S>,
    ) -> ClosedForm<[S; STATES]> {
        let openings = Self::openings(commands.voltage);
        let left = stride.half[0][0];
        let towards = |left: S| [0, 1].map(|side| openings[side] + (spools[side] - openings[side]) * left);
        ClosedForm { middle: towards(left), end: towards(left * left), defect: [S::zero(); STATES] }
    }

    fn feed<S: Scalar>(&self, spools: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
        let open = Pair(spools.map(|spool| (-spool).max(S::zero()) * self.conductance));
        let exhaust = ports.exhaust.at(Pair([S::along(ports.exhaust_pressure); 2]));
        self.supplied(spools, ports, gas) + Inflow::from(self.orifice.flow(open, exhaust, gas))
    }

    fn drawn<S: Scalar>(&self, spools: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Pair<S> {
        self.supplied(spools, ports, gas).mass
    }

    fn smooth_region(&self, spools: [f64; STATES], ports: &Ports<Real>, pressures: Pair<Real>) -> Pair<Real> {
        edge_pieces([ports.supply_pressure, Real::along(ports.exhaust_pressure)], pressures)
            + is_above(Pair(Real::all(&spools)), Pair::zero()) * 16.0
    }

    fn write<S: Scalar>(&self, spools: [S; STATES], commands: Commands<S>, memory: &(), slots: &mut [S]) {
        let ([spool_a, spool_b], [rate_a, rate_b]) = (spools, self.rates(spools, commands, memory));
        Outputs { spool_a, spool_b, rate_a, rate_b }.write(slots);
    }
}
