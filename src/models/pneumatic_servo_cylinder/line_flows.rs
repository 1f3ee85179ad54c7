//! What flows in the lines of a cylinder, and where their states stand among its own.

use super::cylinder::PneumaticServoCylinder;
use super::lines::{HOSE, STATES, VESSEL, VOLUMES};
use super::places::{PRESSURE_A, PRESSURE_B, of_actuator};
use super::states::State;
use crate::friction::FrictionLaw;
use crate::numbers::{Pair, Real, Scalar};
use crate::pneumatics::actuator::Actuating;
use crate::pneumatics::gas::GasState;
use crate::pneumatics::orifice::Inflow;

/// What flows in the lines.
#[derive(Clone, Debug)]
pub struct LineFlows<S> {
    /// What flows into the chambers through their ports.
    pub into: Inflow<Pair<S>>,
    /// Mass flow in kg/s from outside into all of it: from supply and exhaust, and past the piston from a chamber that is
    /// open.
    pub received: S,
    /// Rates of the states.
    pub rates: [S; STATES],
}

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Places of the states of the lines, and their indices among `n` states.
    pub(super) fn places_of_lines(&self, n: usize) -> impl Iterator<Item = (usize, usize)> {
        let first = State::Position.at(n) - self.sensors.states() - self.lines.states();
        self.lines.integrated().zip(first..)
    }

    /// The states of the lines; 0 for those that are not integrated.
    pub(super) fn of_lines<S: Scalar>(&self, x: &[S]) -> [S; STATES] {
        let mut states = [S::zero(); STATES];
        self.places_of_lines(x.len()).for_each(|(place, index)| states[place] = x[index]);
        states
    }

    /// Puts what belongs to the states of the lines in its places.
    pub(super) fn put_lines<T: Copy>(&self, states: &[T; STATES], x: &mut [T]) {
        self.places_of_lines(x.len()).for_each(|(place, index)| x[index] = states[place]);
    }

    /// The pressures in Pa at the ports of the actuator: in the first volumes of hoses, or in the chambers.
    #[inline(always)]
    pub(super) fn pressures_at_valve(&self, x: &[Real]) -> Pair<Real> {
        let [a, b] = self.in_hoses(x, 0);
        Pair([a.unwrap_or(x[PRESSURE_A]), b.unwrap_or(x[PRESSURE_B])])
    }

    /// The numbers of the smooth pieces of the flows through restrictions; 0 where there is none.
    #[inline(always)]
    pub(super) fn pieces_of_restrictions(&self, x: &[Real]) -> [f64; 2] {
        let ends = self.in_hoses(x, VOLUMES - 1);
        let Pair(distances) = self.lengths(State::Position.get(x));
        std::array::from_fn(|side| {
            let line = if EXTENDED { self.lines.hoses[side].as_ref() } else { None };
            let restriction = line.and_then(|line| line.restriction.as_ref());
            let chamber = x[[PRESSURE_A, PRESSURE_B][side]];
            ends[side]
                .zip(restriction)
                .map_or(0.0, |(end, restriction)| restriction.piece(end, chamber, distances[side]))
        })
    }

    /// A state of each hose that has it, by its place within a hose.
    #[inline(always)]
    fn in_hoses(&self, x: &[Real], place: usize) -> [Option<Real>; 2] {
        if !(EXTENDED && self.lines.hoses.iter().any(Option::is_some)) {
            return [None; 2];
        }
        let states = self.of_lines(x);
        std::array::from_fn(|side| self.lines.hoses[side].as_ref().map(|_| states[side * HOSE + place]))
    }

    /// The pressure in the vessel of the supply, if there is one.
    #[inline(always)]
    pub(super) fn vessel_pressure<S: Copy>(&self, x: &[S]) -> Option<S> {
        // It is the last of the states of the lines.
        let index = || State::Position.at(x.len()) - self.sensors.states() - 1;
        (EXTENDED && self.lines.vessel.is_some()).then(|| x[index()])
    }

    /// What flows in lines that are there.
    pub(super) fn through_lines<S: Scalar>(&self, x: &[S], supply: S, gas: GasState<Pair<S>>) -> LineFlows<S> {
        let (states, mut rates) = (self.of_lines(x), [S::zero(); STATES]);
        let lines = &self.lines;
        let mut at_valve = gas;
        for (side, _) in lines.hoses.iter().enumerate().filter(|(_, line)| line.is_some()) {
            at_valve.pressure.0[side] = states[side * HOSE];
            at_valve.temperature.0[side] = S::constant(lines.temperature);
        }
        let at_valve = GasState::new(at_valve.pressure, at_valve.temperature);
        let ports = self.ports_at_valve(x, supply);
        let fed = self.actuator.feed(of_actuator(x), &ports, at_valve);
        let (mut into, mut received) = (fed, self.closed(fed.mass));
        let Pair(distances) = self.lengths(State::Position.get(x));
        for (side, line) in lines.hoses.iter().enumerate() {
            let Some(line) = line else { continue };
            let own = &states[side * HOSE..][..HOSE];
            let chamber = gas.side(side);
            let (of_hose, out) = line.flows(own, lines.temperature, fed.mass.0[side], chamber, distances[side]);
            rates[side * HOSE..][..HOSE].copy_from_slice(&of_hose);
            (into.mass.0[side], into.carried.0[side]) = (out.mass, out.mass * out.temperature);
        }
        if let Some(vessel) = &lines.vessel {
            let drawn = self.closed(self.actuator.drawn(of_actuator(x), &ports, at_valve));
            let (from, to) = (vessel.air.at(self.at_least_ambient(supply)), vessel.air.at(states[VESSEL]));
            let filled = vessel.orifice.flow(S::constant(vessel.conductance), from, to).mass;
            rates[VESSEL] = (filled - drawn) * (vessel.gas / vessel.volume);
            received += filled - drawn;
        }
        if self.p.piston_leakage != 0.0 {
            let leak = self.piston_leak(gas);
            received += self.closed(leak.mass);
            into = into + Inflow::from(leak);
        }
        LineFlows { into, received, rates }
    }

    /// Writes the states of the lines and their rates.
    #[inline(always)]
    pub(super) fn write_lines<S: Scalar>(&self, x: &[S], rates: &[S], slots: &mut [S]) {
        if EXTENDED && self.lines.are_used() {
            slots[..STATES].copy_from_slice(&self.of_lines(x));
            slots[STATES..].copy_from_slice(&self.of_lines(rates));
        } else {
            slots.fill(S::zero());
        }
    }
}
