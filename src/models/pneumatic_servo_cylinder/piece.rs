//! The smooth pieces of the equations, within which explicit steps may be taken.

use super::cylinder::PneumaticServoCylinder;
use super::places::{PRESSURE_A, PRESSURE_B, of_actuator};
use super::states::{Inputs, State};
use crate::friction::FrictionLaw;
use crate::numbers::{Pair, Real, Scalar};
use crate::pneumatics::actuator::Actuating;
use crate::pneumatics::orifice;

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

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
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
