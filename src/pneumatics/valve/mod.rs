//! The 5/3-way proportional valve: command, hysteresis, spool dynamics and metering edges.

mod edges;
mod parameters;

use std::f64::consts::{PI, TAU};

use super::actuation::{Actuating, Commands, DEFECT_WEIGHT, Ports, SHORT, STATES, SUPPLY, VOLTAGE, simpson_middle};
use super::gas::GasState;
use super::orifice::{Inflow, edge_pieces};
use crate::numbers::{Pair, Real, Scalar, Tangent, Varying};
use crate::outputs;
use crate::system::{ClosedForm, Stride};
use crate::variables::{ParameterError, Tunable, Variable, units};

pub use self::edges::{Characteristic, Edges, Opening, Port};
pub use self::parameters::Parameters;

/// Dynamics of a spool under a voltage of 0 to 10 V about the centre.
///
/// ```text
/// u   = clamp((V - V_c)/5, -1, 1)*polarity                   command, V_c = 5 V less the electrical offset
/// u_p = play operator of half width w on u, none at u = +-1  hysteresis
/// s'' = wn^2*(u_p - s) - 2*zeta*wn*s'                        spool
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Valve {
    /// Voltage in V at which the command is 0.
    pub centre: Tunable,
    /// The spool.
    pub spool: Spool,
    /// Half width of the play.
    pub hysteresis: Tangent,
    /// +1: more than 5 V feeds chamber A; -1: chamber B.
    pub polarity: f64,
}

/// The spool as an oscillator of second order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spool {
    /// `wn^2` in 1/s2.
    stiffness: Tangent,
    /// `2*zeta*wn` in 1/s.
    damping: Tangent,
}

impl Spool {
    /// A spool with a natural frequency in Hz and a damping ratio `zeta`.
    pub fn new(bandwidth: Tangent, damping_ratio: Tangent) -> Self {
        let natural = TAU * bandwidth;
        Self { stiffness: natural * natural, damping: 2.0 * damping_ratio * natural }
    }

    /// Acceleration in 1/s2.
    pub fn acceleration<S: Scalar>(&self, set_point: S, spool: S, velocity: S) -> S {
        (set_point - spool) * self.stiffness - velocity * self.damping
    }

    /// The least time in s from one turning point to the next.
    fn shortest_way(&self) -> f64 {
        PI / self.stiffness.value.sqrt()
    }

    /// Reach from the set point after a distance from it and a velocity.
    fn reach(&self, distance: f64, velocity: f64) -> f64 {
        (distance * distance + velocity * velocity / self.stiffness.value).sqrt()
    }

    /// Velocity and spool in a step towards a set point.
    fn later<S: Varying>(&self, [velocity, spool]: [S; 2], set_point: S, stride: &Stride<S>) -> ClosedForm<[S; 2]> {
        let &Stride { size: step, half: [[a, b], [c, d]] } = stride;
        let moved = |[velocity, distance]: [S; 2]| [distance * c + velocity * d, distance * a + velocity * b];
        let distance = spool - set_point;
        let middle = moved([velocity, distance]);
        let [end_velocity, end] = moved(middle);
        if (self.stiffness + self.damping * self.damping).value * step * step < SHORT * SHORT {
            let placed = |[velocity, distance]: [S; 2]| [velocity, set_point + distance];
            return ClosedForm { middle: placed(middle), end: placed([end_velocity, end]), defect: [S::zero(); 2] };
        }
        let way = end - distance;
        // The equation of motion, integrated over the step.
        let mean = (velocity - end_velocity - way * self.damping) / (self.stiffness * step);
        let effective = [simpson_middle(velocity, way / step, end_velocity), simpson_middle(distance, mean, end)];
        ClosedForm {
            middle: [effective[0], set_point + effective[1]],
            end: [end_velocity, set_point + end],
            defect: [effective[0] - middle[0], effective[1] - middle[1]],
        }
    }

    /// Transition matrix of the distance from the set point and the velocity over a time in s, as two rows.
    ///
    /// ```text
    /// exp(-d*t)*| c + d*s     s     |   d = zeta*wn, w^2 = wn^2 - d^2
    ///           | -wn^2*s   c - d*s |   c = cos(w*t), s = sin(w*t)/w, or cosh and sinh where w^2 < 0
    /// ```
    fn propagator<S: Scalar>(&self, time: f64) -> [[S; 2]; 2] {
        /// Beyond this the smaller of the two exponentials in a hyperbolic function is lost in rounding.
        const FAR: f64 = 20.0;
        let decay = S::along(0.5 * self.damping);
        let square = S::along(self.stiffness) - decay * decay;
        let frequency = square.abs().sqrt();
        let angle = frequency * time;
        let left = (-decay * time).exp();
        let (c, s) = if square.value() > 0.0 {
            (left * angle.cos(), left * angle.sin() / frequency)
        } else if angle.value() == 0.0 {
            // `cos(w*t)` and `sin(w*t)/w` by the square of `w`, as it passes through 0.
            let change = square * (time * time);
            (left * (-change * 0.5 + 1.0), left * ((-change / 6.0 + 1.0) * time))
        } else if angle.value() < FAR {
            let [cosh, sinh] = [libm::cosh(angle.value()), libm::sinh(angle.value())];
            (left * angle.chain(cosh, sinh), left * angle.chain(sinh, cosh) / frequency)
        } else {
            let slow = (angle - decay * time).exp() * 0.5;
            (slow, slow / frequency)
        };
        [[c + decay * s, s], [-(s * self.stiffness), c - decay * s]]
    }
}

impl Valve {
    /// The command at a voltage.
    pub fn command<S: Scalar>(&self, voltage: S) -> S {
        self.unlimited(voltage).clamp(S::constant(-1.0), S::constant(1.0)) * self.polarity
    }

    /// The same beyond the range of the voltage, with any polarity.
    fn unlimited<S: Scalar>(&self, voltage: S) -> S {
        (voltage - self.centre) / 5.0
    }

    /// The play operator: where the command drags the spool's set point from where it was.
    ///
    /// The loop closes over the last `w` of the command, so that a full command opens the valve fully.
    ///
    /// Its derivative is 1 while the command pushes (2 where the loop closes), also where it has just come to rest against
    /// the set point (the derivative of the side that was pushed), and 0 inside the play.
    pub fn play<S: Scalar>(&self, before: S, command: S) -> S {
        let width = S::along(self.hysteresis);
        let (low, high) = (command - width.min(-command + 1.0), command + width.min(command + 1.0));
        if low.value() >= before.value() {
            low
        } else if high.value() <= before.value() {
            high
        } else {
            before
        }
    }

    /// The set point a run starts with: the command, as far as the play around 0 reaches.
    pub fn initial_play<S: Scalar>(&self, command: S) -> S {
        let width = S::along(self.hysteresis);
        command.clamp(-width, width)
    }
}

/// Value references of the states.
const SPOOL: u32 = 113;
const SPOOL_VELOCITY: u32 = 202;
/// Name of the variable that is the set point.
const COMMAND: &str = "valve.command";

outputs! {
    /// The computed variables of [`ProportionalValve`].
    Outputs {
        spool = Variable::output(SPOOL, "valve.spool", units::ONE).nominal(1.0)
            .depends_on(&[SPOOL])
            .text("Spool position as a fraction of its travel; a positive one feeds chamber A; 0 with another actuator");
        spool_velocity = Variable::output(SPOOL_VELOCITY, "valve.spoolVelocity", units::PER_SECOND).local().nominal(100.0).derivative_of(SPOOL)
            .depends_on(&[SPOOL_VELOCITY])
            .text("Velocity of the spool");
        spool_acceleration = Variable::output(204, "der(valve.spoolVelocity)", units::PER_SECOND_SQUARED).local().nominal(1e5).derivative_of(SPOOL_VELOCITY)
            .depends_on(&[VOLTAGE, SPOOL, SPOOL_VELOCITY])
            .text("Acceleration of the spool");
        valve_command = Variable::output(206, COMMAND, units::ONE).local().nominal(1.0)
            .depends_on(&[VOLTAGE])
            .text("Set point of the spool after the hysteresis");
    }
}

/// The valve between supply, exhaust and both chambers. States: velocity of the spool, and the spool.
#[derive(Clone, Debug)]
pub struct ProportionalValve {
    valve: Valve,
    opening: Opening,
    supply: Edges,
    exhaust: Edges,
    bandwidth: f64,
}

/// Factor by which the errors of the spool may exceed the errors of other states: their effect on position and force stays
/// far below the promised accuracy, and they would take most of the steps.
const ALLOWANCE: f64 = 30.0;

impl Actuating for ProportionalValve {
    /// Set point of the spool: the state of the hysteresis.
    type Memory<S: Varying> = S;
    type Parameters = Parameters;

    const COMPUTED: usize = Outputs::<f64>::LEN;

    fn new(p: Parameters) -> Result<Self, ParameterError> {
        if p.polarity == 0 {
            return Err(ParameterError::new("valve.polarity", 0.0, "it must be 1 or -1"));
        }
        let valve = Valve {
            centre: -p.offset + 5.0,
            spool: Spool::new(p.bandwidth, p.damping),
            hysteresis: p.hysteresis,
            polarity: f64::from(p.polarity),
        };
        let [supply, exhaust] = p.ports().map(|ports| Edges::new(ports, p.leakage));
        Ok(Self { valve, opening: p.opening()?, supply, exhaust, bandwidth: p.bandwidth.value })
    }

    fn computed() -> Vec<Variable> {
        Outputs::<f64>::table()
    }

    fn feeds(_chamber: usize) -> Vec<u32> {
        vec![SUPPLY, SPOOL]
    }

    fn variables(&self) -> [Option<u32>; STATES] {
        [Some(SPOOL_VELOCITY), Some(SPOOL)]
    }

    fn has_closed_form(&self) -> bool {
        true
    }

    fn scales(&self) -> [f64; STATES] {
        [ALLOWANCE * self.bandwidth, ALLOWANCE]
    }

    fn start<S: Varying>(&self, commands: Commands<S>) -> ([S; STATES], S) {
        ([S::zero(); STATES], self.valve.initial_play(self.valve.command(commands.voltage)))
    }

    fn rates<S: Scalar>(
        &self,
        [velocity, spool]: [S; STATES],
        commands: Commands<S>,
        set_point: &S::Held,
    ) -> [S; STATES] {
        let before = S::held(*set_point);
        let mut followed = self.set_point(commands.voltage, before);
        // Where the set point rests at the edge of its play it has no slope by the voltage, which its slopes say by NaN, and neither has
        // the spool: the difference is 0, or takes NaN over.
        if S::Held::VARIES && followed.value() == before.value() {
            followed -= S::held(*set_point) - before;
        }
        [self.valve.spool.acceleration(followed, spool, velocity), velocity]
    }

    fn half<S: Varying>(&self, step: f64) -> [[S; STATES]; STATES] {
        self.valve.spool.propagator(0.5 * step)
    }

    #[inline(always)]
    fn later<S: Varying>(
        &self,
        states: [S; STATES],
        _commands: Commands<S>,
        set_point: &S,
        stride: &Stride<S>,
    ) -> ClosedForm<[S; STATES]> {
        let closed_form = self.valve.spool.later(states, *set_point, stride);
        let [_, spool] = closed_form.defect;
        ClosedForm { defect: [S::zero(), spool * DEFECT_WEIGHT], ..closed_form }
    }

    fn variable_of(&self, _fields: &str) -> Option<&'static str> {
        Some(COMMAND)
    }

    fn follow<S: Varying>(&self, commands: Commands<S>, set_point: &mut S) {
        let followed = self.set_point(commands.voltage, *set_point);
        if !S::VARIES {
            *set_point = followed;
            return;
        }
        let has_play = self.valve.hysteresis.is_used();
        let rests = has_play && followed.value() == set_point.value();
        // At an end of its range more of the voltage moves nothing, and nor does less where the play rests.
        let command = self.valve.unlimited(commands.voltage);
        let is_at_end = |direction: usize| command.value().abs() == 1.0 && command.slopes()[direction] != 0.0;
        *set_point = if !rests {
            followed.or(followed.unless_tied(S::of(followed.value())), is_at_end)
        } else if self.valve.hysteresis.value == 0.0 {
            // A play that is nothing yet stays where it has been dragged to last.
            *set_point
        } else {
            // At the edge of the play more of the voltage drags the set point, and less does not.
            followed.unless_tied(*set_point).or(*set_point, is_at_end)
        };
    }

    #[inline(always)]
    fn feed<S: Scalar>(&self, [_, spool]: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
        let opening = self.opening.at(spool);
        let supply = ports.supply.at(Pair([ports.supply_pressure; 2]));
        let exhaust = ports.exhaust.at(Pair([S::along(ports.exhaust_pressure); 2]));
        Inflow::from(self.supply.flow(opening, supply, gas))
            + Inflow::from(self.exhaust.flow(opening.swapped(), exhaust, gas))
    }

    #[inline(always)]
    fn smooth_region(&self, [_, spool]: [f64; STATES], ports: &Ports<Real>, pressures: Pair<Real>) -> Pair<Real> {
        edge_pieces([ports.supply_pressure, Real::along(ports.exhaust_pressure)], pressures)
            + self.opening.smooth_region(spool).value * 16.0
    }

    /// Between two zeros of its velocity the spool moves one way. Where it turns within a step, it goes no further from its
    /// set point than its energy allows.
    #[inline(always)]
    fn stays_in_piece<S: Varying>(
        &self,
        ends: [[f64; STATES]; 2],
        commands: Commands<f64>,
        set_point: &S,
        step: f64,
    ) -> bool {
        let [[velocity, spool], [end_velocity, _]] = ends;
        if velocity * end_velocity > 0.0 && step < self.valve.spool.shortest_way() {
            return true;
        }
        let set_point = self.set_point(Real::of(commands.voltage), Real::of(set_point.value())).value;
        let reach = self.valve.spool.reach(set_point - spool, velocity);
        [-reach, reach]
            .iter()
            .all(|far| self.opening.smooth_region(set_point + far) == self.opening.smooth_region(spool))
    }

    fn drawn<S: Scalar>(&self, [_, spool]: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Pair<S> {
        let supply = ports.supply.at(Pair([ports.supply_pressure; 2]));
        self.supply.flow(self.opening.at(spool), supply, gas).mass
    }

    fn write<S: Scalar>(&self, states: [S; STATES], commands: Commands<S>, set_point: &S::Held, slots: &mut [S]) {
        let [spool_velocity, spool] = states;
        let [spool_acceleration, _] = self.rates(states, commands, set_point);
        let command = self.set_point(commands.voltage, S::held(*set_point));
        Outputs { spool, spool_velocity, spool_acceleration, valve_command: command }.write(slots);
    }

    fn fits<S: Varying>(&self, set_point: &S) -> bool {
        set_point.value().is_finite()
    }
}

impl ProportionalValve {
    /// Set point of the spool under a voltage.
    fn set_point<S: Scalar>(&self, voltage: S, before: S) -> S {
        self.valve.play(before, self.valve.command(voltage))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Dual;
    use crate::variables::ParameterSet;

    fn spool(bandwidth: f64, damping_ratio: f64) -> Spool {
        Spool::new(Tangent::still(bandwidth), Tangent::still(damping_ratio))
    }

    fn valve() -> Valve {
        let hysteresis = Tangent::still(0.01);
        Valve { centre: Tunable::still(5.0), spool: spool(100.0, 0.7), hysteresis, polarity: 1.0 }
    }

    fn command(valve: &Valve, voltage: f64) -> f64 {
        valve.command(Real::of(voltage)).value
    }

    fn play(before: f64, command: f64) -> f64 {
        valve().play(Real::of(before), Real::of(command)).value
    }

    #[test]
    fn command_saturates_at_the_ends_of_the_voltage_range() {
        assert_eq!([-50.0, 0.0, 5.0, 7.5, 10.0, 1e9].map(|v| command(&valve(), v)), [-1.0, -1.0, 0.0, 0.5, 1.0, 1.0]);
        assert_eq!(command(&Valve { polarity: -1.0, ..valve() }, 7.5), -0.5);
        let low = Valve { centre: Tunable::still(5.25), ..valve() };
        assert_eq!([5.0, 5.25, 10.0].map(|v| command(&low, v)), [-0.05, 0.0, 0.95]);
    }

    #[test]
    fn play_follows_only_when_pushed() {
        assert_eq!(play(0.2, 0.205), 0.2);
        assert_eq!(play(0.2, 0.3), 0.29);
        assert_eq!(play(0.2, 0.1), 0.11);
    }

    /// At rest at an end of the play the derivative belongs to the side that was pushed; inside the play it is 0.
    #[test]
    fn play_has_the_derivative_of_the_side_that_is_pushed() {
        let slope =
            |before: f64, command: f64| valve().play(Dual::<1>::of(before), Dual::variable(command, 0)).slope[0];
        for command in [0.3, -0.4] {
            let followed = play(0.0, command);
            assert_eq!([slope(0.0, command), slope(followed, command)], [1.0, 1.0]);
            assert_eq!(slope(followed, command * 0.99), 0.0);
        }
    }

    /// Between 1 - w and 1 the loop closes, from either side.
    #[test]
    fn full_command_has_no_play() {
        assert_eq!([1.0, -1.0].map(|command| play(0.2, command)), [1.0, -1.0]);
        assert!((play(0.2, 0.995) - 0.99).abs() < 1e-15 && (play(1.0, 0.995) - 1.0).abs() < 1e-15);
        assert!((play(0.2, 0.99) - 0.98).abs() < 1e-15);
    }

    /// Against 1000 steps of the classical Runge-Kutta method, and their means by the rule of Simpson.
    #[test]
    fn spool_towards_a_held_set_point_has_a_closed_form() {
        const STEPS: usize = 1000;
        for damping in [0.0, 0.7, 1.0, 1.0 + 1e-9, 5.0, 60.0] {
            let spool = spool(100.0, damping);
            for step in [1e-3, 1e-2] {
                let start = [40.0, -0.3];
                let ClosedForm { middle, end, .. } = later(&spool, start, 0.2, step);
                let (mut x, mut sums, h) = (start, [0.0; 2], step / STEPS as f64);
                let rates = |[v, s]: [f64; 2]| [spool.acceleration(Real::of(0.2), Real::of(s), Real::of(v)).value, v];
                for _ in 0..STEPS {
                    let on = |k: [f64; 2], by: f64| [x[0] + by * k[0], x[1] + by * k[1]];
                    let k1 = rates(x);
                    let k2 = rates(on(k1, 0.5 * h));
                    let k3 = rates(on(k2, 0.5 * h));
                    let k4 = rates(on(k3, h));
                    let between = on(k2, 0.5 * h);
                    let after = [0, 1].map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
                    sums = [0, 1].map(|i| sums[i] + (x[i] + 4.0 * between[i] + after[i]) / 6.0 / STEPS as f64);
                    x = after;
                }
                for i in 0..2 {
                    let (mean, scale) = ((start[i] + 4.0 * middle[i] + end[i]) / 6.0, [400.0, 1.0][i]);
                    assert!((end[i] - x[i]).abs() < 1e-5 * scale, "{damping}, {step}: {end:?}, not {x:?}");
                    assert!((mean - sums[i]).abs() < 1e-5 * scale, "{damping}, {step}: {mean}, not {}", sums[i]);
                }
            }
        }
        let rest = ClosedForm { middle: [0.0, 0.2], end: [0.0, 0.2], defect: [0.0; 2] };
        assert_eq!(later(&valve().spool, [0.0, 0.2], 0.2, 1e-3), rest);
    }

    /// A spool that overshoots into the opening and comes back within a step, and one that does not get there.
    #[test]
    fn turn_of_the_spool_beyond_an_edge_is_noticed() {
        let valve = ProportionalValve::new(Parameters::read(&starts()).expect("legal")).expect("legal");
        let edge = 0.08;
        for (set_point, stays) in [(0.98 * edge, false), (0.4 * edge, true)] {
            let spool = valve.valve.spool;
            let ClosedForm { end, .. } = later(&spool, [0.0; 2], set_point, 0.02);
            assert!(end[1] < edge);
            let voltage = 5.0 + 5.0 * set_point;
            let memory = valve.set_point(Real::of(voltage), Real::of(0.0));
            assert_eq!(
                valve.stays_in_piece([[0.0; 2], end], Commands::all(voltage), &memory, 0.02),
                stays,
                "{set_point}"
            );
        }
    }

    /// A spool that starts at the set point swings beyond the edge, and after a period moves the same way again. Within half
    /// a period of an undamped spool it cannot turn twice.
    #[test]
    fn swing_of_the_spool_beyond_an_edge_is_noticed() {
        let mut valve = ProportionalValve::new(Parameters::read(&starts()).expect("legal")).expect("legal");
        valve.valve.spool = spool(100.0, 0.1);
        let (edge, start, period) = (0.08, [0.2 * TAU * 100.0, 0.0], 0.01 / (1.0f64 - 0.01).sqrt());
        let after = |time: f64| later(&valve.valve.spool, start, 0.0, time).end;
        let [end_velocity, end] = after(period);
        assert!(after(0.25 * period)[1] > edge && end_velocity > 0.0 && end.abs() < edge);
        assert!(!valve.stays_in_piece([start, after(period)], Commands::all(5.0), &Real::of(0.0), period));
        let [short, long] =
            [0.0049, 0.0051].map(|step| valve.stays_in_piece([start; 2], Commands::all(5.0), &Real::of(0.0), step));
        assert!(short && !long, "half a period is 5 ms");
        assert!(
            !valve.stays_in_piece(
                [start, [0.0, after(0.25 * period)[1]]],
                Commands::all(5.0),
                &Real::of(0.0),
                0.25 * period
            ),
            "at its end"
        );
    }

    /// The departure of the spool from a parabola counts as an error, with its weight; the velocity has no effect of its
    /// own.
    #[test]
    fn bend_is_the_weighted_difference_from_the_true_middle() {
        let valve = ProportionalValve::new(Parameters::read(&starts()).expect("legal")).expect("legal");
        let (start, step) = ([0.0, -0.3], 1.0 / valve.bandwidth);
        let later = |size: f64| {
            let stride = Stride { size, half: valve.half(size) };
            let ClosedForm { middle, end, defect } =
                valve.later(Real::all(&start), Commands::all(Real::of(5.0)), &Real::of(0.2), &stride);
            ClosedForm { middle: values(middle), end: values(end), defect: values(defect) }
        };
        let (whole, [_, truth]) = (later(step), later(0.5 * step).end);
        let [_, middle] = whole.middle;
        let [of_velocity, defect] = whole.defect;
        assert!((middle - truth).abs() > 1e-3 && (defect - DEFECT_WEIGHT * (middle - truth)).abs() < 1e-12, "{defect}");
        assert_eq!(of_velocity, 0.0);
    }

    fn values(numbers: [Real; 2]) -> [f64; 2] {
        numbers.map(Real::value)
    }

    /// A step of a size in s towards a set point.
    fn later(spool: &Spool, start: [f64; 2], set_point: f64, size: f64) -> ClosedForm<[f64; 2]> {
        let stride = Stride { size, half: spool.propagator(0.5 * size) };
        let ClosedForm { middle, end, defect } = spool.later(Real::all(&start), Real::of(set_point), &stride);
        ClosedForm { middle: values(middle), end: values(end), defect: values(defect) }
    }

    fn starts() -> Vec<Tunable> {
        Parameters::table().iter().map(|variable| Tunable::still(variable.start.expect("a start value"))).collect()
    }

    /// Without hysteresis the set point is the command, derivatives included.
    #[test]
    fn play_of_no_width_hands_on_the_command() {
        let direct = Valve { hysteresis: Tangent::still(0.0), ..valve() };
        let command = Dual::<1>::variable(0.2, 0);
        assert_eq!(direct.play(Dual::of(0.2), command), command);
    }
    #[test]
    fn set_point_that_is_no_number_fits_no_valve() {
        let valve = ProportionalValve::new(Parameters::read(&starts()).expect("legal")).expect("legal");
        assert!(valve.fits(&Real::of(-0.5)));
        assert!([f64::NAN, f64::INFINITY].iter().all(|set_point| !valve.fits(&Real::of(*set_point))));
    }
}
