//! The 5/3-way proportional valve: command, hysteresis, spool dynamics and metering edges.

use std::f64::consts::TAU;

use crate::pair::Number;
use crate::scalar::Scalar;

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
    /// Sonic conductance in m3/(s Pa) of a fully open edge.
    pub conductance: f64,
    /// Dead zone `d` as a fraction of the spool travel.
    pub dead_zone: f64,
    /// Opening `leak` of a closed edge.
    pub leakage: f64,
    /// Natural frequency of the spool in Hz.
    pub bandwidth: f64,
    /// Damping ratio `zeta` of the spool.
    pub damping: f64,
    /// Half width of the play.
    pub hysteresis: f64,
    /// +1: more than 5 V feeds chamber A; -1: chamber B.
    pub polarity: f64,
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

    /// Acceleration of the spool in 1/s2.
    pub fn spool_acceleration<S: Scalar>(&self, set_point: S, spool: S, velocity: S) -> S {
        let natural = TAU * self.bandwidth;
        (set_point - spool) * (natural * natural) - velocity * (2.0 * self.damping * natural)
    }

    /// Sonic conductance in m3/(s Pa) of an edge that opens with positive `spool`.
    pub fn edge<N: Number>(&self, spool: N) -> N {
        let travel = (spool - self.dead_zone) * (1.0 / (1.0 - self.dead_zone));
        let travel = travel.max(N::zero()).min(N::constant(1.0));
        (travel * (1.0 - self.leakage) + self.leakage) * self.conductance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALVE: Valve = Valve {
        conductance: 4e-9,
        dead_zone: 0.1,
        leakage: 0.002,
        bandwidth: 100.0,
        damping: 0.7,
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
        let command = crate::scalar::Dual::<1>::variable(0.2, 0);
        assert_eq!(direct.play(0.2, command), command);
    }

    #[test]
    fn edge_leaks_when_closed_and_is_full_at_full_travel() {
        assert_eq!(VALVE.edge(-1.0), 0.002 * 4e-9);
        assert_eq!(VALVE.edge(0.1), 0.002 * 4e-9);
        assert_eq!(VALVE.edge(1.0), 4e-9);
    }
}
