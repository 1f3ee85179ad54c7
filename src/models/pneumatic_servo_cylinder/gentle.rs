//! Where explicit steps may be taken: gentle equations, and their smooth pieces.

use super::variables::Inputs;
use super::{PRESSURE_A, PRESSURE_B, PneumaticServoCylinder, State, of_actuator};
use crate::friction::{FrictionContact, Laws};
use crate::hybrid::LongestSteps;
use crate::numbers::{Pair, Real, Scalar};
use crate::pneumatics::actuator::Actuators;
use crate::pneumatics::orifice;

/// Longest explicit steps. At equal pressures the flow through an open valve settles within some ten milliseconds.
const LONGEST: LongestSteps = LongestSteps { classical: 0.01, midpoint: 0.005 };

/// Step size in s from which on explicit steps are cheaper than implicit ones where nothing but waves in hoses bounds them.
pub(super) const WORTHWHILE: f64 = 7e-5;

/// How long explicit steps may be: bristles that hold the carriage are springs, on which it swings, and so are the stops.
#[derive(Clone, Copy, Debug)]
pub(super) struct GentleSteps {
    /// While bristles hold.
    at_rest: LongestSteps,
    /// In contact with a stop.
    at_stop: LongestSteps,
    /// Speed in m/s from which on a bristle relaxes faster than the carriage swings.
    slipping: f64,
}

impl GentleSteps {
    /// Those of a friction law and stops of a stiffness in N/m under a mass in kg.
    pub(super) fn new<L: Laws>(friction: &FrictionContact<L>, stop: f64, mass: f64) -> Self {
        let [stiffness, damping] = friction.resistance();
        let swing = |stiffness: f64| (stiffness.max(0.0) / mass).sqrt();
        let longest = |swing: f64| LongestSteps::of_swing(swing, damping.max(0.0) / mass).min(LONGEST);
        Self {
            at_rest: longest(swing(stiffness)),
            at_stop: longest(swing(stiffness + stop)),
            slipping: if friction.relaxes() { 2.0 * swing(stiffness) * friction.state_scale() } else { f64::INFINITY },
        }
    }

    /// The longest steps where stops are touched or not, at a velocity in m/s.
    #[inline(always)]
    pub(super) fn longest(&self, touched: [bool; 2], velocity: f64) -> LongestSteps {
        if touched[0] | touched[1] {
            self.at_stop
        } else if velocity.abs() < self.slipping {
            self.at_rest
        } else {
            LONGEST
        }
    }
}

/// A smooth piece of the equations.
#[derive(PartialEq)]
pub(super) struct Piece {
    /// That of the flows of the actuator.
    of_actuator: Pair<Real>,
    /// That of the flow into a vessel.
    into_vessel: f64,
    /// Those of the flows from hoses through restrictions into the chambers.
    into_chambers: [f64; 2],
    /// The side of [equal pressures](PneumaticServoCylinder::has_kink_at_equal_pressures).
    a_is_above: bool,
    /// The stops that act.
    touched: [bool; 2],
    /// The direction of a motion that bends bristles.
    is_backward: bool,
}

impl<L: Laws, A: Actuators, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// The smooth piece of the equations in which the states lie.
    #[inline(always)]
    pub(super) fn piece<const N: usize>(&self, x: &[f64; N], u: &Inputs<f64>) -> Piece {
        let (supply, numbers) = (Real::of(u.supply_pressure), Real::all(x));
        let ports = self.ports_at_valve(&numbers, supply);
        let of_actuator = self.actuator.piece(of_actuator(x), &ports, self.pressures_at_valve(&numbers));
        let into_vessel = |vessel: f64| orifice::piece(self.at_least_ambient(supply), Real::of(vessel)).value;
        Piece {
            of_actuator,
            into_vessel: self.vessel_pressure(x).map_or(0.0, into_vessel),
            into_chambers: self.pieces_of_restrictions(&numbers),
            a_is_above: self.has_kink_at_equal_pressures() && x[PRESSURE_A] > x[PRESSURE_B],
            touched: self.stops.touched(State::Position.get(x)),
            is_backward: x.len() > State::OTHERS && State::Velocity.get(x) < 0.0,
        }
    }

    /// Whether the leakage past the piston, with its temperature, or the friction level has a kink where both chambers have
    /// the same pressure.
    fn has_kink_at_equal_pressures(&self) -> bool {
        self.p.piston_leakage != 0.0 || self.options.kappa_difference != 0.0
    }
}
