//! The 5/3-way proportional valve: command, hysteresis, spool dynamics and metering edges.

use std::f64::consts::TAU;

use super::actuator::{Actuating, Ports, STATES, SUPPLY, VOLTAGE};
use super::gas::GasState;
use super::orifice::{Inflow, Orifice};
use crate::numbers::{Number, Pair, Scalar};
use crate::variables::{ParameterError, Variable, units};
use crate::{outputs, parameters};

/// A proportional valve, closed in the centre, commanded by 0 to 10 V.
///
/// ```text
/// u   = clamp((V - 5)/5, -1, 1)*polarity                        command
/// u_p = play operator of half width w on u, none at u = +-1     hysteresis
/// s'' = wn^2*(u_p - s) - 2*zeta*wn*s'                           spool
/// opening(s) = leak + (1 - leak)*clamp((s - d)/(1 - d), 0, 1)   metering edge
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Valve {
    /// The metering edges.
    pub edge: MeteringEdge,
    /// The spool.
    pub spool: Spool,
    /// Half width of the play.
    pub hysteresis: f64,
    /// +1: more than 5 V feeds chamber A; -1: chamber B.
    pub polarity: f64,
}

/// A metering edge, as a straight line of conductance over spool between both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeteringEdge {
    dead_zone: f64,
    /// `1/(1 - d)`.
    per_travel: f64,
    /// Sonic conductances in m3/(s Pa): closed, and fully open beyond that.
    closed: f64,
    range: f64,
}

impl MeteringEdge {
    /// An edge with a sonic conductance in m3/(s Pa) when fully open, a dead zone `d` as a fraction of the spool travel,
    /// and the opening `leak` when closed.
    pub const fn new(conductance: f64, dead_zone: f64, leakage: f64) -> Self {
        let per_travel = 1.0 / (1.0 - dead_zone);
        Self { dead_zone, per_travel, closed: conductance * leakage, range: conductance * (1.0 - leakage) }
    }

    /// Sonic conductance in m3/(s Pa); the edge opens with positive `spool`.
    pub fn conductance<N: Number>(&self, spool: N) -> N {
        let travel = ((spool - self.dead_zone) * self.per_travel).max(N::zero()).min(N::constant(1.0));
        travel * self.range + self.closed
    }
}

/// The spool as an oscillator of second order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spool {
    /// `wn^2` in 1/s2.
    stiffness: f64,
    /// `2*zeta*wn` in 1/s.
    damping: f64,
}

impl Spool {
    /// A spool with a natural frequency in Hz and a damping ratio `zeta`.
    pub const fn new(bandwidth: f64, damping_ratio: f64) -> Self {
        let natural = TAU * bandwidth;
        Self { stiffness: natural * natural, damping: 2.0 * damping_ratio * natural }
    }

    /// Acceleration in 1/s2.
    pub fn acceleration<S: Scalar>(&self, set_point: S, spool: S, velocity: S) -> S {
        (set_point - spool) * self.stiffness - velocity * self.damping
    }
}

impl Valve {
    /// The command at a voltage.
    pub fn command<S: Scalar>(&self, voltage: S) -> S {
        ((voltage - 5.0) / 5.0).clamp(S::constant(-1.0), S::constant(1.0)) * self.polarity
    }

    /// The play operator: where the command drags the spool's set point from where it was.
    ///
    /// The loop closes over the last `w` of the command, so that a full command opens the valve fully.
    ///
    /// Its derivative is 1 while the command pushes (2 where the loop closes), also where it has just come to rest against
    /// the set point (the derivative of the side that was pushed), and 0 inside the play.
    pub fn play<S: Scalar>(&self, before: f64, command: S) -> S {
        let width = S::constant(self.hysteresis);
        let (low, high) = (command - width.min(-command + 1.0), command + width.min(command + 1.0));
        if low.value() >= before {
            low
        } else if high.value() <= before {
            high
        } else {
            S::constant(before)
        }
    }

    /// The set point a run starts with: the command, as far as the play around 0 reaches.
    pub fn initial_play(&self, command: f64) -> f64 {
        command.clamp(-self.hysteresis, self.hysteresis)
    }
}

parameters! {
    /// The parameters of [`ProportionalValve`].
    Parameters {
        conductance: f64 = Variable::parameter(1024, "valve.C", units::CUBIC_METRE_PER_SECOND_PASCAL, 3.93e-9).range(1e-13, 1e-5).shown_in("dm3/(s.bar)").tunable()
            .text("Sonic conductance of a fully open metering edge");
        critical_ratio: f64 = Variable::parameter(1025, "valve.b", units::ONE, 0.3).range(0.0, 0.99).tunable()
            .text("Critical pressure ratio of the metering edges");
        dead_zone: f64 = Variable::parameter(1026, "valve.deadZone", units::ONE, 0.08).range(0.0, 0.9).tunable()
            .text("Dead zone (overlap) of the metering edges as a fraction of the spool travel");
        leakage: f64 = Variable::parameter(1027, "valve.leakage", units::ONE, 0.002).range(0.0, 1.0).tunable()
            .text("Opening of a closed metering edge as a fraction of the full opening");
        bandwidth: f64 = Variable::parameter(1028, "valve.bandwidth", units::HERTZ, 115.0).range(0.1, 1e4)
            .text("Natural frequency of the spool");
        damping: f64 = Variable::parameter(1029, "valve.damping", units::ONE, std::f64::consts::FRAC_1_SQRT_2).range(0.01, 100.0)
            .text("Damping ratio of the spool");
        hysteresis: f64 = Variable::parameter(1030, "valve.hysteresis", units::ONE, 0.004).range(0.0, 1.0)
            .text("Half width of the play between command and spool set point; it closes towards full command");
        polarity: i32 = Variable::count(1031, "valve.polarity", 1).range(-1.0, 1.0)
            .text("1: more than 5 V feeds chamber A; -1: chamber B");
    }
}

/// Value references of the states.
const SPOOL: u32 = 113;
const SPOOL_VELOCITY: u32 = 202;

outputs! {
    /// The computed variables of [`ProportionalValve`].
    Outputs {
        spool = Variable::output(SPOOL, "valve.spool", units::ONE).nominal(1.0)
            .depends_on(&[SPOOL])
            .text("Spool position as a fraction of its travel, positive feeds chamber A; 0 on the rig with a regulator");
        spool_velocity = Variable::output(SPOOL_VELOCITY, "valve.spoolVelocity", units::PER_SECOND).local().nominal(100.0).derivative_of(SPOOL)
            .depends_on(&[SPOOL_VELOCITY])
            .text("Velocity of the spool");
        spool_acceleration = Variable::output(204, "der(valve.spoolVelocity)", units::PER_SECOND_SQUARED).local().nominal(1e5).derivative_of(SPOOL_VELOCITY)
            .depends_on(&[VOLTAGE, SPOOL, SPOOL_VELOCITY])
            .text("Acceleration of the spool");
        valve_command = Variable::output(206, "valve.command", units::ONE).local().nominal(1.0)
            .depends_on(&[VOLTAGE])
            .text("Set point of the spool after the hysteresis");
    }
}

/// The valve between supply, exhaust and both chambers. States: velocity of the spool, and the spool.
#[derive(Clone, Debug)]
pub struct ProportionalValve {
    valve: Valve,
    orifice: Orifice,
    bandwidth: f64,
}

/// How many times larger the errors of the spool may be than those of other states: what they do to position and force
/// stays far below the promised accuracy, and they would take most of the steps.
const ALLOWANCE: f64 = 30.0;

impl Actuating for ProportionalValve {
    /// Set point of the spool: the state of the hysteresis.
    type Memory = f64;
    type Parameters = Parameters;

    const VARIABLES: [Option<u32>; STATES] = [Some(SPOOL_VELOCITY), Some(SPOOL)];
    const FEEDS: [&'static [u32]; 2] = [&[SUPPLY, SPOOL]; 2];
    const COMPUTED: usize = Outputs::<f64>::LEN;

    fn new(p: Parameters) -> Result<Self, ParameterError> {
        if p.polarity == 0 {
            return Err(ParameterError::new("valve.polarity", 0.0, "it must be 1 or -1"));
        }
        let valve = Valve {
            edge: MeteringEdge::new(p.conductance, p.dead_zone, p.leakage),
            spool: Spool::new(p.bandwidth, p.damping),
            hysteresis: p.hysteresis,
            polarity: f64::from(p.polarity),
        };
        Ok(Self { valve, orifice: Orifice::new(p.critical_ratio), bandwidth: p.bandwidth })
    }

    fn computed() -> Vec<Variable> {
        Outputs::<f64>::table()
    }

    fn scales(&self) -> [f64; STATES] {
        [ALLOWANCE * self.bandwidth, ALLOWANCE]
    }

    fn start(&self, voltage: f64) -> ([f64; STATES], f64) {
        ([0.0; STATES], self.valve.initial_play(self.valve.command(voltage)))
    }

    fn rates<S: Scalar>(&self, [velocity, spool]: [S; STATES], voltage: S, set_point: &f64) -> [S; STATES] {
        [self.valve.spool.acceleration(self.set_point(voltage, *set_point), spool, velocity), velocity]
    }

    fn follow(&self, voltage: f64, set_point: &mut f64) {
        *set_point = self.set_point(voltage, *set_point);
    }

    #[inline(always)]
    fn feed<S: Scalar>(&self, spool: S, ports: &Ports<S>, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
        let spool = Pair([spool, -spool]);
        let supply = ports.supply.at(Pair([ports.supply_pressure; 2]));
        let exhaust = ports.exhaust.at(Pair([S::constant(ports.exhaust_pressure); 2]));
        Inflow::from(self.orifice.flow(self.valve.edge.conductance(spool), supply, gas))
            + Inflow::from(self.orifice.flow(self.valve.edge.conductance(-spool), exhaust, gas))
    }

    fn write<S: Scalar>(&self, states: [S; STATES], voltage: S, set_point: &f64, slots: &mut [S]) {
        let [spool_velocity, spool] = states;
        let [spool_acceleration, _] = self.rates(states, voltage, set_point);
        let command = self.set_point(voltage, *set_point);
        Outputs { spool, spool_velocity, spool_acceleration, valve_command: command }.write(slots);
    }

    fn fits(&self, set_point: &f64) -> bool {
        set_point.is_finite()
    }
}

impl ProportionalValve {
    /// Set point of the spool under a voltage.
    fn set_point<S: Scalar>(&self, voltage: S, before: f64) -> S {
        self.valve.play(before, self.valve.command(voltage))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Dual;

    const VALVE: Valve = Valve {
        edge: MeteringEdge::new(4e-9, 0.1, 0.002),
        spool: Spool::new(100.0, 0.7),
        hysteresis: 0.01,
        polarity: 1.0,
    };

    #[test]
    fn command_saturates_at_the_ends_of_the_voltage_range() {
        assert_eq!([-50.0, 0.0, 5.0, 7.5, 10.0, 1e9].map(|v| VALVE.command(v)), [-1.0, -1.0, 0.0, 0.5, 1.0, 1.0]);
        assert_eq!(Valve { polarity: -1.0, ..VALVE }.command(7.5), -0.5);
    }

    #[test]
    fn play_follows_only_when_pushed() {
        assert_eq!(VALVE.play(0.2, 0.205), 0.2);
        assert_eq!(VALVE.play(0.2, 0.3), 0.29);
        assert_eq!(VALVE.play(0.2, 0.1), 0.11);
    }

    /// At rest against the play the derivative is that of the side that was pushed; inside the play it is 0.
    #[test]
    fn play_has_the_derivative_of_the_side_that_is_pushed() {
        let slope = |before: f64, command: f64| VALVE.play(before, Dual::<1>::variable(command, 0)).slope[0];
        for command in [0.3, -0.4] {
            let followed = VALVE.play(0.0, command);
            assert_eq!([slope(0.0, command), slope(followed, command)], [1.0, 1.0]);
            assert_eq!(slope(followed, command * 0.99), 0.0);
        }
    }

    /// Between 1 - w and 1 the loop closes, from either side.
    #[test]
    fn full_command_has_no_play() {
        assert_eq!([1.0, -1.0].map(|command| VALVE.play(0.2, command)), [1.0, -1.0]);
        assert!((VALVE.play(0.2, 0.995) - 0.99).abs() < 1e-15 && (VALVE.play(1.0, 0.995) - 1.0).abs() < 1e-15);
        assert!((VALVE.play(0.2, 0.99) - 0.98).abs() < 1e-15);
    }

    /// Without hysteresis the set point is the command, derivatives included.
    #[test]
    fn play_of_no_width_hands_on_the_command() {
        let direct = Valve { hysteresis: 0.0, ..VALVE };
        let command = Dual::<1>::variable(0.2, 0);
        assert_eq!(direct.play(0.2, command), command);
    }

    #[test]
    fn edge_leaks_when_closed_and_is_full_at_full_travel() {
        let conductance = |spool: f64| VALVE.edge.conductance(spool);
        assert_eq!([-1.0, 0.1].map(conductance), [0.002 * 4e-9; 2]);
        assert!((conductance(1.0) - 4e-9).abs() < 1e-24);
    }
}
