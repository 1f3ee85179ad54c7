//! The 5/3-way proportional valve: command, hysteresis, spool dynamics and metering edges.

use std::f64::consts::TAU;

use crate::numbers::Number;
use crate::numbers::Scalar;

/// A proportional valve, closed in the centre, commanded by 0 to 10 V.
///
/// ```text
/// u   = clamp((V - 5)/5, -1, 1)*polarity                        command
/// u_p = play operator of half width w on u                      hysteresis
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
    pub fn play<S: Scalar>(&self, before: f64, command: S) -> S {
        if self.hysteresis == 0.0 {
            return command;
        }
        S::constant(before).clamp(command - self.hysteresis, command + self.hysteresis)
    }

    /// The set point a run starts with: the command, as far as the play around 0 reaches.
    pub fn initial_play(&self, command: f64) -> f64 {
        command.clamp(-self.hysteresis, self.hysteresis)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    /// Without hysteresis the set point is the command, derivatives included.
    #[test]
    fn play_of_no_width_hands_on_the_command() {
        let direct = Valve { hysteresis: 0.0, ..VALVE };
        let command = crate::numbers::Dual::<1>::variable(0.2, 0);
        assert_eq!(direct.play(0.2, command), command);
    }

    #[test]
    fn edge_leaks_when_closed_and_is_full_at_full_travel() {
        let conductance = |spool: f64| VALVE.edge.conductance(spool);
        assert_eq!([-1.0, 0.1].map(conductance), [0.002 * 4e-9; 2]);
        assert!((conductance(1.0) - 4e-9).abs() < 1e-24);
    }
}
