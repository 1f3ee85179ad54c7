//! The equations of the cylinder: air, carriage, lines, sensors, and the rates, outputs and balances made of them.
//!
//! Balances: mass and energy of the cylinder, and their inflow.
//!
//! ```text
//! mass   = m_A + m_B                      <- mass flows into both chambers
//! energy = U_A + U_B + m*v^2/2            <- enthalpy and heat into both chambers, work of all other forces
//! ```
//!
//! The pressures' work goes from the gas to the carriage and stays inside. An algebraic
//! temperature fixes the heat, so that the energy of the gas is left out, and the pressures' work enters the carriage. The gas
//! in a chamber that is open to the surroundings is not counted; its pressure is one of the outer forces.

use super::cylinder::{MemoryOf, PneumaticServoCylinder};
use super::ends;
use super::lines::{HOSE, LINE_STATES, Lines, METER, VESSEL, VOLUMES};
use super::motion::{self, Guidance};
use super::sensors::{COUNT, Memory, Sensors};
use super::states::{Inputs, MOST, PRESSURE_A, PRESSURE_B, State, TEMPERATURE_A, TEMPERATURE_B, of_actuator};
use super::variables::{ByPart, Outputs};
use crate::friction::{Contact, FrictionLaw, Lubrication, OVERWHELMING, Observation, Trend, states};
use crate::numbers::{Number, Pair, Real, Scalar, Varying};
use crate::pneumatics::actuator::{Actuating, Ports, STATES};
use crate::pneumatics::chamber::{ChamberRates, Thermal};
use crate::pneumatics::gas::{Gas, GasState};
use crate::pneumatics::orifice::Inflow;
use crate::system::{PartFacts, QUANTITIES};

/// Where an actuator is asked for its flow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Feeding<'a, S, M> {
    /// Time in s.
    pub time: S,
    /// States, of which the actuator's come first.
    pub x: &'a [S],
    /// Discrete state of the actuator.
    pub memory: &'a M,
}

// The air in the chambers: its inflow, pressures and temperatures.
impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// The gas in use; equations without options know air alone.
    #[inline(always)]
    pub(super) fn filling(&self) -> &Gas {
        if EXTENDED { &self.filling } else { &Gas::AIR }
    }

    /// Pressures and temperatures in both chambers.
    #[inline(always)]
    pub(super) fn gas<S: Scalar>(&self, x: &[S]) -> GasState<Pair<S>> {
        self.chambers.gas(
            self.filling(),
            Pair([x[PRESSURE_A], x[PRESSURE_B]]),
            Pair([x[TEMPERATURE_A], x[TEMPERATURE_B]]),
        )
    }

    /// Rates of the gas in both chambers at a position and velocity of the carriage.
    #[inline(always)]
    pub(super) fn gas_rates<S: Scalar>(
        &self,
        gas: GasState<Pair<S>>,
        position: S,
        rate: S,
        inflow: Inflow<Pair<S>>,
    ) -> ChamberRates<Pair<S>> {
        let mut rates = self.chambers.rates(self.filling(), gas, self.lengths(position), Pair([rate, -rate]), inflow);
        if EXTENDED {
            let open = |(side, _): &(usize, S)| self.options.opens()[*side];
            for (side, length_rate) in [rate, -rate].into_iter().enumerate().filter(open) {
                // It breathes as much as the piston displaces.
                let (Pair(pressure), Pair(temperature)) = (gas.pressure, gas.temperature);
                let growth = length_rate * self.chambers.areas.side(side);
                rates.mass_flow.0[side] = pressure[side] * growth / (temperature[side] * self.filling.constant);
                (rates.pressure.0[side], rates.temperature.0[side]) = (S::zero(), S::zero());
            }
        }
        rates
    }

    /// The sum over the chambers that are not open to the surroundings.
    #[inline(always)]
    pub(super) fn closed<S: Scalar>(&self, Pair([a, b]): Pair<S>) -> S {
        if !EXTENDED {
            return a + b;
        }
        match self.options.opens() {
            [false, false] => a + b,
            [false, true] => a,
            [true, false] => b,
            [true, true] => S::zero(),
        }
    }

    /// Lengths in m of the chambers.
    pub(super) fn lengths<S: Scalar>(&self, position: S) -> Pair<S> {
        Pair([position, -position + self.p.stroke])
    }

    /// Flow into the chambers; writes the rates of the lines, where there are any.
    #[inline(always)]
    pub(super) fn flows<S: Scalar>(
        &self,
        at: Feeding<'_, S, A::Memory<S::Held>>,
        supply: S,
        gas: GasState<Pair<S>>,
        rates: &mut [S],
    ) -> Inflow<Pair<S>> {
        if !(EXTENDED && self.lines.are_used()) {
            return self.inflow(at, supply, gas);
        }
        let flows = self.through_lines(at, supply, gas);
        self.lines.put(&flows.rates, rates);
        flows.into
    }

    /// Flow into the chambers from the supply, from the exhaust and from each other, without lines between.
    #[inline(always)]
    pub(super) fn inflow<S: Scalar>(
        &self,
        at: Feeding<'_, S, A::Memory<S::Held>>,
        supply: S,
        gas: GasState<Pair<S>>,
    ) -> Inflow<Pair<S>> {
        let fed = self.fed(at, &self.ports(supply), gas);
        self.leaks.as_ref().map_or(fed, |leaks| fed + leaks.inflow(gas, self.surroundings()))
    }

    /// Flow from an actuator; extended equations have those that change by themselves.
    #[inline(always)]
    fn fed<S: Scalar>(
        &self,
        Feeding { time, x, memory }: Feeding<'_, S, A::Memory<S::Held>>,
        ports: &Ports<S>,
        gas: GasState<Pair<S>>,
    ) -> Inflow<Pair<S>> {
        if EXTENDED {
            return self.actuator.feed_at(time, of_actuator(x), memory, ports, gas);
        }
        self.actuator.feed(of_actuator(x), ports, gas)
    }

    /// Surroundings of the actuator; a supply below ambient acts as ambient.
    #[inline(always)]
    pub(super) fn ports<S: Scalar>(&self, supply: S) -> Ports<'_, S> {
        Ports {
            supply: &self.supply,
            supply_pressure: self.at_least_ambient(supply),
            exhaust: &self.exhaust,
            exhaust_pressure: self.p.ambient_pressure,
        }
    }

    /// The same behind the vessel of the supply, where there is one.
    #[inline(always)]
    pub(super) fn ports_at_valve<S: Scalar>(&self, x: &[S], supply: S) -> Ports<'_, S> {
        let ports = self.ports(supply);
        match self.vessel_pressure(x) {
            Some(supply_pressure) => Ports { supply_pressure, ..ports },
            None => ports,
        }
    }

    #[inline(always)]
    pub(super) fn at_least_ambient<S: Scalar>(&self, pressure: S) -> S {
        pressure.max(S::tuned(self.p.ambient_pressure))
    }

    /// The gas around the cylinder.
    pub(super) fn surroundings<N: Number>(&self) -> GasState<N> {
        self.exhaust.at(N::tuned(self.p.ambient_pressure))
    }
}

// The carriage: its forces, its contact, its motion.
impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Force on the moving mass in N, without friction and without the force of a coupling; and the stops' part of it.
    #[inline(always)]
    pub(super) fn applied_force<S: Scalar>(&self, x: &[S], u: &Inputs<S>, rate: S) -> (S, S) {
        let position = State::Position.get(x);
        let stop = self.stops.force(position, rate);
        let force = self.pressure_force(x) + u.external_force - self.dead_load + stop;
        (if EXTENDED { force + self.options.spring_force(position) } else { force }, stop)
    }

    /// Force of the coupling on the moving mass in N, if there is one.
    #[inline(always)]
    fn coupling_force<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        rate: S,
        motion: &motion::Memory<S::Held>,
    ) -> Option<S> {
        let is_coupled = EXTENDED && matches!(self.guidance, Guidance::Compliant { .. });
        is_coupled.then(|| self.guidance.force(motion.imposed(time, u.imposed()), State::Position.get(x), rate))
    }

    /// Whether forces alone move the carriage.
    #[inline(always)]
    pub(super) fn is_free(&self) -> bool {
        !EXTENDED || self.guidance == Guidance::Free
    }

    /// Whether the carriage moves as imposed.
    #[inline(always)]
    pub(super) fn is_rigidly_imposed(&self) -> bool {
        EXTENDED && self.guidance == Guidance::Rigid
    }

    #[inline(always)]
    pub(super) fn pressure_force<S: Scalar>(&self, x: &[S]) -> S {
        let [area_a, area_b] = self.chambers.areas.each();
        x[PRESSURE_A] * area_a - x[PRESSURE_B] * area_b - self.p.ambient_pressure * self.rod_area
    }

    /// The load factor `lambda` of both directions, or of a motion or a push towards the side of a number.
    #[inline(always)]
    fn load_level<S: Scalar>(&self, x: &[S], towards: Option<f64>) -> S {
        let [excess_a, excess_b] = self.excess_pressures(x);
        let level = excess_a * self.p.kappa_a + excess_b * self.p.kappa_b + 1.0;
        if !EXTENDED {
            return level.max(S::zero());
        }
        let mut level = level + self.options.added_level(Pair([x[PRESSURE_A], x[PRESSURE_B]]));
        if let Some(towards) = towards {
            level += self.options.added_by_roles([excess_a, excess_b], towards);
        }
        let position = State::Position.get(x);
        let along = if self.has_waviness { self.options.relative_level(position) } else { S::constant(1.0) };
        let level = level.max(S::zero()) * along;
        self.profile.as_ref().map_or(level, |profile| level * profile.at(position))
    }

    /// The contact as the friction law sees it, for a velocity of the carriage and the direction in which its mode slides, if it does.
    #[inline(always)]
    pub(super) fn contact<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        rate: S,
        sliding: Option<f64>,
        motion: &motion::Memory<S::Held>,
    ) -> Contact<S> {
        let (mut applied, _) = self.applied_force(x, u, rate);
        let mut velocity = State::Velocity.get(x);
        if let Some(force) = self.coupling_force(time, x, u, rate, motion) {
            applied += force;
        }
        if self.is_rigidly_imposed() {
            (velocity, applied) = (rate, Trend::applied(motion.trend.sign, self.friction.law(), rate, applied));
        }
        self.contact_under(time, x, [velocity, rate], sliding, applied)
    }

    /// The contact in the present modes, under what a guide leaves of the applied force.
    #[inline(always)]
    pub(super) fn contact_at<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        memory: &MemoryOf<L, A, S::Held>,
    ) -> Contact<S> {
        self.guided(self.whole_contact_at(time, x, u, memory), x, &memory.friction)
    }

    /// The contact in the present modes, under the whole applied force.
    #[inline(always)]
    pub(super) fn whole_contact_at<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        memory: &MemoryOf<L, A, S::Held>,
    ) -> Contact<S> {
        let (rate, sliding) = (self.rate(time, x, u, memory), self.sliding(&memory.friction));
        self.contact(time, x, u, rate, sliding, &memory.motion)
    }

    /// A contact under what a guide leaves of the applied force, if there is one that the load presses on.
    ///
    /// The load takes `T = m*a - X`, with the force `X` on it, and the guide `c*|T|` against the motion. What the piston gives after the
    /// friction of its seals, `R`, is both: `T + c*|T|*sgn(v) = R`. For `c < 1` one `T` solves that, of the sign of `R`: the guide takes
    /// `c*|R|/(1 + c)` where `R` drives the motion, and `c*|R|/(1 - c)` where it brakes. At rest it takes what it can, up to `c*|X|`.
    #[inline(always)]
    pub(super) fn guided<S: Scalar>(&self, contact: Contact<S>, x: &[S], memory: &L::Memory<S::Held>) -> Contact<S> {
        let Some(ratio) = self.guide.filter(|_| EXTENDED) else { return contact };
        let Some(direction) = L::sliding_direction::<S::Held>(memory) else { return self.guided_at_rest(contact, x) };
        let given = self.piston_force(x, contact.velocity) - self.friction_force(&contact, x, memory);
        let along = given * direction;
        let taken =
            if along.value() >= 0.0 { along * (ratio / (ratio + 1.0)) } else { -along * (ratio / (1.0 - ratio)) };
        Contact { applied: contact.applied - taken * direction, ..contact }
    }

    /// The same of a carriage at rest.
    #[inline(always)]
    pub(super) fn guided_at_rest<S: Scalar>(&self, contact: Contact<S>, x: &[S]) -> Contact<S> {
        let Some(ratio) = self.guide.filter(|_| EXTENDED) else { return contact };
        let most = (self.piston_force(x, S::zero()) - contact.applied).abs() * ratio;
        Contact { applied: contact.applied - contact.applied.clamp(-most, most), ..contact }
    }

    /// Force in N of the pressures and the covers on the piston.
    #[inline(always)]
    fn piston_force<S: Scalar>(&self, x: &[S], rate: S) -> S {
        self.pressure_force(x) + self.stops.force(State::Position.get(x), rate)
    }

    /// The sum in N of a force and of the friction of the guide, where the cylinder has a guide.
    #[inline(always)]
    fn with_guide<S: Scalar>(
        &self,
        force: S,
        contact: impl FnOnce() -> Contact<S>,
        x: &[S],
        memory: &L::Memory<S::Held>,
    ) -> S {
        if !(EXTENDED && self.guide.is_some()) {
            return force;
        }
        let whole = contact();
        force + (whole.applied - self.guided(whole, x, memory).applied)
    }

    /// The contact at a velocity, the state, of a carriage that moves at a rate, which is 0 while it is held, under an applied force.
    #[inline(always)]
    fn contact_under<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        [velocity, rate]: [S; 2],
        sliding: Option<f64>,
        applied: S,
    ) -> Contact<S> {
        let level = self.directed_level(x, rate, sliding, applied);
        Contact { time, position: State::Position.get(x), velocity, applied, level, drive: self.friction.drive() }
    }

    /// Load factor of a carriage that slides in a direction, else moves at a rate in m/s, or at rest is pushed by an applied force in N.
    #[inline(always)]
    pub(super) fn directed_level<S: Scalar>(&self, x: &[S], rate: S, sliding: Option<f64>, applied: S) -> S {
        if !(EXTENDED && self.has_directed_level) {
            return self.load_level(x, None);
        }
        let at_rest = if rate.value() == 0.0 { applied } else { rate };
        let towards = sliding.unwrap_or(at_rest.value());
        self.load_level(x, Some(towards)) * self.options.directed_level(towards)
    }

    /// Direction in which the contact slides, where its load factor depends on it.
    #[inline(always)]
    pub(super) fn sliding<S: Varying>(&self, memory: &L::Memory<S>) -> Option<f64> {
        if EXTENDED && self.has_directed_level { L::sliding_direction::<S>(memory) } else { None }
    }

    /// Factors of the pressures on Stribeck velocity and viscous friction, if these follow them.
    #[inline(always)]
    fn lubrication<S: Scalar>(
        &self,
        contact: &Contact<S>,
        x: &[S],
        memory: &L::Memory<S::Held>,
    ) -> Option<Lubrication<S>> {
        (EXTENDED && self.is_lubricated).then(|| {
            let towards = L::sliding_direction::<S::Held>(memory).unwrap_or(contact.velocity.value());
            self.options.lubrication(self.excess_pressures(x), towards)
        })
    }

    /// Refuses pressures at which the Stribeck velocity or the viscous friction falls to 0 in either direction.
    pub(super) fn admit_lubrication(&self, x: &[f64]) -> Result<(), &'static str> {
        if !(EXTENDED && self.is_lubricated) {
            return Ok(());
        }
        let excess = [PRESSURE_A, PRESSURE_B].map(|place| Real::of(x[place]) - self.p.ambient_pressure);
        [1.0, -1.0].into_iter().try_for_each(|towards| {
            let factors = self.options.lubrication(excess, towards);
            match [factors.stribeck_velocity, factors.viscous].map(|factor| factor.value > 0.0) {
                [true, true] => Ok(()),
                [false, _] => {
                    Err("by friction.stribeckVelocity.kappaDriving and .kappaResisting the Stribeck velocity \
                                   falls to 0 at the pressures of the chambers")
                }
                [_, false] => {
                    Err("by friction.viscous.kappaDriving and .kappaResisting the viscous friction falls to 0 \
                                   at the pressures of the chambers")
                }
            }
        })
    }

    /// Pressures above ambient in Pa in both chambers.
    #[inline(always)]
    fn excess_pressures<S: Scalar>(&self, x: &[S]) -> [S; 2] {
        [PRESSURE_A, PRESSURE_B].map(|place| x[place] - self.p.ambient_pressure)
    }

    /// The least and the largest friction force in N that a carriage can ask for which moves as imposed: a range where a
    /// set-valued law has it at rest.
    pub(super) fn friction_limits<S: Scalar>(
        &self,
        contact: &Contact<S>,
        x: &[S],
        memory: &MemoryOf<L, A, S::Held>,
        friction: &Observation<S>,
    ) -> [S; 2] {
        if !self.is_rigidly_imposed() {
            return [S::zero(); 2];
        }
        if friction.sticking.value() == 0.0 {
            return [friction.force; 2];
        }
        [-OVERWHELMING, OVERWHELMING].map(|applied| {
            let pushed = self.contact_under(contact.time, x, [contact.velocity, S::zero()], None, S::constant(applied));
            self.friction.force(&pushed, x, &memory.friction, &mut [S::zero(); MOST])
        })
    }

    /// Friction force in N of the contact, with viscous friction that acts in one direction alone.
    #[inline(always)]
    pub(super) fn friction_force<S: Scalar>(&self, contact: &Contact<S>, x: &[S], memory: &L::Memory<S::Held>) -> S {
        let (lubrication, bristles) = (self.lubrication(contact, x, memory), self.friction.range());
        let rates = &mut [S::zero(); MOST][bristles.clone()];
        let force = self.friction.force_on(contact, lubrication, &x[bristles], memory, rates);
        self.with_one_way_friction(force, contact, memory)
    }

    /// Friction force in N of the law, with viscous friction that acts in one direction alone.
    #[inline(always)]
    fn with_one_way_friction<S: Scalar>(&self, force: S, contact: &Contact<S>, memory: &L::Memory<S::Held>) -> S {
        if EXTENDED && self.has_one_way_damping {
            return force + self.options.one_way_friction(self.friction.rate(contact.velocity, memory));
        }
        force
    }

    /// Velocity of the carriage: as imposed, or the state, unless the friction law holds the position.
    #[inline(always)]
    pub(super) fn rate<S: Scalar>(&self, time: S, x: &[S], u: &Inputs<S>, memory: &MemoryOf<L, A, S::Held>) -> S {
        if self.is_rigidly_imposed() {
            return memory.motion.imposed(time, u.imposed()).velocity;
        }
        self.own_rate(x, memory)
    }

    /// Velocity of a carriage that forces move.
    #[inline(always)]
    pub(super) fn own_rate<S: Scalar>(&self, x: &[S], memory: &MemoryOf<L, A, S::Held>) -> S {
        self.friction.rate(State::Velocity.get(x), &memory.friction)
    }

    /// Rates of position and velocity, and the friction force; writes the rates of the bristles.
    #[inline(always)]
    pub(super) fn motion_rates<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        memory: &MemoryOf<L, A, S::Held>,
        bristles: &[S],
        bristle_rates: &mut [S],
    ) -> [S; 3] {
        let rate = self.rate(time, x, u, memory);
        let contact = self.contact(time, x, u, rate, self.sliding(&memory.friction), &memory.motion);
        let contact = self.guided(contact, x, &memory.friction);
        let lubrication = self.lubrication(&contact, x, &memory.friction);
        let force = self.friction.force_on(&contact, lubrication, bristles, &memory.friction, bristle_rates);
        let force = self.with_one_way_friction(force, &contact, &memory.friction);
        [rate, self.acceleration(&contact, force, &memory.motion), force]
    }

    /// Acceleration of the carriage in m/s2 under a friction force in N: imposed, or by the forces, also where
    /// the friction law holds the position.
    #[inline(always)]
    pub(super) fn acceleration<S: Scalar>(
        &self,
        contact: &Contact<S>,
        friction: S,
        motion: &motion::Memory<S::Held>,
    ) -> S {
        if self.is_rigidly_imposed() {
            return S::constant(motion.acceleration());
        }
        (contact.applied - friction) * self.per_mass
    }

    /// Force of the rod on the carriage in N, at an acceleration of the carriage and a friction force in N: the reading of a load cell
    /// between them, or the force of the cylinder on the body that imposes its motion.
    #[inline(always)]
    pub(super) fn rod_force<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        [acceleration, friction]: [S; 2],
        memory: (&L::Memory<S::Held>, &motion::Memory<S::Held>),
    ) -> S {
        let (of_friction, motion) = memory;
        if self.is_rigidly_imposed() {
            let (applied, _) = self.applied_force(x, u, motion.imposed(time, u.imposed()).velocity);
            return applied - u.external_force - friction;
        }
        let rate = || self.friction.rate(State::Velocity.get(x), of_friction);
        if let Some(force) = EXTENDED.then(|| self.coupling_force(time, x, u, rate(), motion)).flatten() {
            return -force;
        }
        let weight = self.p.wire_force + self.carriage_weight;
        let force = acceleration * self.p.carriage_mass - u.external_force + weight;
        let force = if EXTENDED { force - self.options.spring_force(State::Position.get(x)) } else { force };
        let contact = || self.contact(time, x, u, rate(), self.sliding(of_friction), motion);
        self.with_guide(force, contact, x, of_friction)
    }
}

/// Flows in the lines.
#[derive(Clone, Debug)]
pub struct LineFlows<S> {
    /// Flow into the chambers through their ports.
    pub into: Inflow<Pair<S>>,
    /// Mass flow in kg/s from outside into all of it: from supply and exhaust, and past the piston from a chamber that is
    /// open.
    pub received: S,
    /// Rates of the states.
    pub rates: [S; LINE_STATES],
}

// Flows in the lines, and the indices of their states in the cylinder's vector.
impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// The pressures in Pa at the ports of the actuator: in the first volumes of hoses, or in the chambers.
    #[inline(always)]
    pub(super) fn pressures_at_valve(&self, x: &[Real]) -> Pair<Real> {
        let [a, b] = self.in_hoses(x, 0);
        Pair([a.unwrap_or(x[PRESSURE_A]), b.unwrap_or(x[PRESSURE_B])])
    }

    /// The numbers of the smooth regions of the flows through restrictions; 0 where there is none.
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
                .map_or(0.0, |(end, restriction)| restriction.smooth_region(end, chamber, distances[side]))
        })
    }

    /// A state of each hose that has it, by its place within a hose.
    #[inline(always)]
    fn in_hoses(&self, x: &[Real], place: usize) -> [Option<Real>; 2] {
        if !(EXTENDED && self.lines.hoses.iter().any(Option::is_some)) {
            return [None; 2];
        }
        let own = &x[self.lines.first(x.len())..];
        std::array::from_fn(|side| self.lines.number(side * HOSE + place).map(|number| own[number]))
    }

    /// The pressure in the vessel of the supply, if there is one.
    #[inline(always)]
    pub(super) fn vessel_pressure<S: Copy>(&self, x: &[S]) -> Option<S> {
        // It is the last of the states of the lines.
        let index = || State::Position.at(x.len()) - self.lines.behind - 1;
        (EXTENDED && self.lines.vessel.is_some()).then(|| x[index()])
    }

    /// Flows in existing lines.
    pub(super) fn through_lines<S: Scalar>(
        &self,
        at: Feeding<'_, S, A::Memory<S::Held>>,
        supply: S,
        gas: GasState<Pair<S>>,
    ) -> LineFlows<S> {
        let x = at.x;
        let (states, mut rates) = (self.lines.placed(x), [S::zero(); LINE_STATES]);
        let lines = &self.lines;
        let mut at_valve = gas;
        for (side, _) in lines.hoses.iter().enumerate().filter(|(_, line)| line.is_some()) {
            let hose = lines.air.at(states[side * HOSE]);
            at_valve.pressure.0[side] = hose.pressure;
            at_valve.temperature.0[side] = hose.temperature;
            at_valve.sonic_density.0[side] = hose.sonic_density;
        }
        let ports = self.ports_at_valve(x, supply);
        let fed = self.fed(at, &ports, at_valve);
        let (mut into, mut received) = (fed, self.closed(fed.mass));
        let Pair(distances) = self.lengths(State::Position.get(x));
        for (side, line) in lines.hoses.iter().enumerate() {
            let Some(line) = line else { continue };
            let own = &states[side * HOSE..][..HOSE];
            let chamber = gas.side(side);
            let (of_hose, out) = line.flows(own, &lines.air, fed.mass.0[side], chamber, distances[side]);
            rates[side * HOSE..][..HOSE].copy_from_slice(&of_hose);
            (into.mass.0[side], into.carried.0[side]) = (out.mass, out.mass * out.temperature);
            if let Some(flow) = line.outside_flow(own, chamber, distances[side]) {
                into.mass.0[side] += flow.mass;
                into.carried.0[side] += flow.mass * flow.temperature;
                received += flow.mass;
            }
        }
        let drawn = || self.closed(self.actuator.drawn(of_actuator(x), &ports, at_valve));
        if let Some(vessel) = &lines.vessel {
            let drawn = drawn();
            let (from, to) = (vessel.air.at(self.at_least_ambient(supply)), vessel.air.at(states[VESSEL]));
            let filled = vessel.orifice.flow(S::tuned(vessel.conductance), from, to).mass;
            rates[VESSEL] = (filled - drawn) * (vessel.gas / vessel.volume);
            received += filled - drawn;
            rates[METER] = filled;
        } else if lines.has_meter {
            rates[METER] = drawn();
        }
        if let Some(leaks) = &self.leaks {
            let leaked = leaks.inflow(gas, self.surroundings());
            received += self.closed(leaked.mass);
            into = into + leaked;
        }
        LineFlows { into, received, rates }
    }

    /// Writes the states of the lines and their rates.
    #[inline(always)]
    pub(super) fn write_lines<S: Scalar>(&self, x: &[S], rates: &[S], slots: &mut [S]) {
        if EXTENDED && self.lines.are_used() {
            let ((own, rest), states) = (slots.split_at_mut(LINE_STATES), self.lines.placed(x));
            own.copy_from_slice(&states);
            rest[..LINE_STATES].copy_from_slice(&self.lines.placed(rates));
            rest[LINE_STATES] = self.lines.consumed_volume(&states);
        } else {
            slots.fill(S::zero());
        }
    }
}

// Measured quantities and readings of the sensors, and the indices of their states in the cylinder's vector.
impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// The measured quantities in the present modes.
    pub(super) fn quantities<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        memory: &MemoryOf<L, A, S::Held>,
    ) -> [S; COUNT] {
        let contact = self.contact_at(time, x, u, memory);
        let friction = self.friction_force(&contact, x, &memory.friction);
        let acceleration = self.acceleration(&contact, friction, &memory.motion);
        self.measured(time, x, u, [acceleration, friction], (&memory.friction, &memory.motion))
    }

    /// Measured quantities, at an acceleration of the carriage, unless it is held, and a friction force in N.
    pub(super) fn measured<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        [acceleration, friction]: [S; 2],
        memory: (&L::Memory<S::Held>, &motion::Memory<S::Held>),
    ) -> [S; COUNT] {
        let acceleration = self.friction.rate(acceleration, memory.0);
        let force = self.rod_force(time, x, u, [acceleration, friction], memory);
        [State::Position.get(x), x[PRESSURE_A], x[PRESSURE_B], force]
    }

    /// Which switches at the ends of the stroke are on, given which were on.
    #[inline(always)]
    pub(super) fn switched<S: Scalar>(&self, x: &[S], before: ends::Memory) -> ends::Memory {
        if !EXTENDED {
            return before;
        }
        let Pair(lengths) = self.lengths(State::Position.get(x));
        self.options.end_switches.after(lengths.map(S::value), before)
    }

    /// Writes readings, states and their rates.
    #[inline(always)]
    pub(super) fn write_sensors<S: Scalar>(
        &self,
        x: &[S],
        quantities: [S; COUNT],
        memory: &Memory<S::Held>,
        slots: &mut [S],
    ) {
        let (readings, states) = slots.split_at_mut(COUNT);
        if !EXTENDED {
            readings.copy_from_slice(&quantities);
            states.fill(S::zero());
            return;
        }
        let lagged = self.sensors.lagged(x);
        readings.copy_from_slice(&self.sensors.readings(quantities, lagged, memory));
        states[..COUNT].copy_from_slice(&lagged);
        states[COUNT..].copy_from_slice(&self.sensors.rates(quantities, lagged));
    }
}

// The rates of all states: air, friction, motion and sensors, driven by the actuator.
impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Writes the rates of all states; constant states keep the rates that they are given.
    // Compiled once for all numbers of states, which make no difference to the equations.
    #[inline(never)]
    pub(super) fn write_rates<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        memory: &MemoryOf<L, A, S::Held>,
        rates: &mut [S],
    ) {
        self.driven_rates(time, x, u, memory, rates);
        rates[..STATES].copy_from_slice(&self.actuator.rates(of_actuator(x), u.commands(), &memory.actuator));
    }

    /// Writes the rates of all states but the actuator's.
    #[inline(always)]
    pub(super) fn driven_rates<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        memory: &MemoryOf<L, A, S::Held>,
        rates: &mut [S],
    ) {
        let bristles = self.friction.range();
        let [rate, acceleration, friction] =
            self.motion_rates(time, x, u, memory, &x[bristles.clone()], &mut rates[bristles]);
        let gas = self.gas(x);
        let at = Feeding { time, x, memory: &memory.actuator };
        let inflow = self.flows(at, u.supply_pressure, gas, rates);
        let gas = self.gas_rates(gas, State::Position.get(x), rate, inflow);
        Pair([rates[TEMPERATURE_A], rates[TEMPERATURE_B]]) = gas.temperature;
        Pair([rates[PRESSURE_A], rates[PRESSURE_B]]) = gas.pressure;
        State::Position.set(rates, rate);
        State::Velocity.set(rates, if self.is_rigidly_imposed() { S::zero() } else { acceleration });
        if EXTENDED && self.sensors.states() > 0 {
            let quantities = self.measured(time, x, u, [acceleration, friction], (&memory.friction, &memory.motion));
            self.sensors.put(&self.sensors.rates(quantities, self.sensors.lagged(x)), rates);
        }
    }
}

// Mass and energy of the cylinder, and their inflow.
impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Mass in kg and energy in J.
    pub(super) fn mass_and_energy<S: Varying, const N: usize>(
        &self,
        x: &[S; N],
        memory: &MemoryOf<L, A, S>,
    ) -> [f64; QUANTITIES] {
        // The mass of a carriage that moves as imposed is not the cylinder's.
        let rate = if self.is_rigidly_imposed() { S::zero() } else { self.own_rate(x, memory) };
        let gas = self.gas(x);
        let pressure_volume = gas.pressure * self.chambers.volume(self.lengths(State::Position.get(x)));
        let mass = self.closed(pressure_volume / (gas.temperature * self.filling().constant));
        let mass = if self.has_lines() { mass + self.lines.mass(&self.lines.placed(x).map(S::value)) } else { mass };
        let inner_energy = self.closed(pressure_volume) / (self.filling().heat_ratio - 1.0);
        let kinetic_energy = rate * (0.5 * self.p.moving_mass) * rate;
        [mass, if self.has_gas_energy() { inner_energy + kinetic_energy } else { kinetic_energy }].map(S::value)
    }

    /// Mass flow in kg/s and power in W into the cylinder.
    pub(super) fn mass_flow_and_power<S: Varying, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &Inputs<S>,
        memory: &MemoryOf<L, A, S>,
    ) -> [f64; QUANTITIES] {
        let rate = self.rate(time, x, u, memory);
        let gas = self.gas(x);
        let at = Feeding { time, x: &x[..], memory: &memory.actuator };
        // Leakage past the piston stays inside, or leaves an open chamber B.
        let (inflow, mass_flow) = if self.has_lines() {
            let flows = self.through_lines(at, u.supply_pressure, gas);
            (flows.into, flows.received)
        } else {
            let inflow = self.inflow(at, u.supply_pressure, gas);
            (inflow, self.closed(inflow.mass))
        };
        let &Gas { constant, heat_ratio, .. } = self.filling();
        let enthalpy_flow = self.closed(inflow.carried) * (constant * heat_ratio / (heat_ratio - 1.0));
        let heat = self.closed(self.chambers.heat(gas.temperature, self.lengths(State::Position.get(x))));
        let work = self.outer_force(time, x, u, memory) * rate;
        [mass_flow, if self.has_gas_energy() { enthalpy_flow + heat + work } else { work }].map(S::value)
    }

    /// Force in N on the carriage that brings energy from outside.
    fn outer_force<S: Varying>(&self, time: S, x: &[S], u: &Inputs<S>, memory: &MemoryOf<L, A, S>) -> S {
        let [area_a, area_b] = self.chambers.areas.each();
        let gas = self.closed(Pair([x[PRESSURE_A] * area_a, -x[PRESSURE_B] * area_b]));
        let of_gas = if self.has_gas_energy() { gas } else { S::zero() };
        if self.is_rigidly_imposed() {
            return -of_gas;
        }
        let contact = self.contact_at(time, x, u, memory);
        let friction = self.friction_force(&contact, x, &memory.friction);
        contact.applied - friction - of_gas
    }

    /// Whether there are hoses or a vessel, whose mass counts, but not their energy: they exchange heat at will.
    fn has_lines(&self) -> bool {
        EXTENDED && self.lines.are_used()
    }

    /// Whether the temperatures come from the energy balance.
    fn has_gas_energy(&self) -> bool {
        matches!(self.chambers.thermal, Thermal::EnergyBalance { .. })
    }
}

// The computed variables.
impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Writes the computed variables, whose number does not depend on the number of states.
    // Compiled once for all these numbers.
    #[inline(never)]
    pub(super) fn write_outputs<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        memory: &MemoryOf<L, A, S::Held>,
        computed: &mut [S],
    ) {
        let (position, rate) = (State::Position.get(x), self.rate(time, x, u, memory));
        let whole = self.contact(time, x, u, rate, self.sliding(&memory.friction), &memory.motion);
        let contact = self.guided(whole, x, &memory.friction);
        let lubrication = self.lubrication(&contact, x, &memory.friction);
        let mut friction = self.friction.observe_on(&contact, lubrication, x, &memory.friction);
        friction.force = self.with_one_way_friction(friction.force, &contact, &memory.friction);
        let acceleration = friction.unless_held(self.acceleration(&contact, friction.force, &memory.motion));
        let quantities = self.measured(time, x, u, [acceleration, friction.force], (&memory.friction, &memory.motion));
        let [.., rod_force] = quantities;
        let [friction_low, friction_high] = self.friction_limits(&contact, x, memory, &friction);
        let gas = self.gas(x);
        let Pair([temperature_a, temperature_b]) = gas.temperature;
        let rates = &mut [S::zero(); MOST][..x.len()];
        let at = Feeding { time, x, memory: &memory.actuator };
        let inflow = self.flows(at, u.supply_pressure, gas, rates);
        let gas = self.gas_rates(gas, position, rate, inflow);
        let Pair([mass_flow_a, mass_flow_b]) = gas.mass_flow;
        let Pair([pressure_rate_a, pressure_rate_b]) = gas.pressure;
        let Pair([temperature_rate_a, temperature_rate_b]) = gas.temperature;
        let [end_first, end_last] = self.switched(x, memory.ends).readings().map(S::constant);
        let outputs = Outputs {
            position,
            velocity: rate,
            acceleration,
            rod_force,
            pressure_force: self.pressure_force(x),
            friction_force: self.with_guide(friction.force, || whole, x, &memory.friction),
            friction_low,
            friction_high,
            pressure_a: x[PRESSURE_A],
            pressure_b: x[PRESSURE_B],
            temperature_a,
            temperature_b,
            mass_flow_a,
            mass_flow_b,
            sticking: friction.sticking,
            end_first,
            end_last,
            pressure_rate_a,
            temperature_rate_a,
            pressure_rate_b,
            temperature_rate_b,
            stop_force: self.applied_force(x, u, rate).1,
            load_level: contact.level,
        };
        let lengths = ByPart {
            outputs: Outputs::<S>::LEN,
            actuator: A::COMPUTED,
            friction: states::computed::<L>(),
            lines: Lines::COMPUTED,
            sensors: Sensors::COMPUTED,
        };
        let slots = ByPart::new(computed, &lengths);
        outputs.write(slots.outputs);
        self.actuator.write(of_actuator(x), u.commands(), &memory.actuator, slots.actuator);
        friction.write(slots.friction);
        self.write_lines(x, rates, slots.lines);
        self.write_sensors(x, quantities, &memory.sensors, slots.sensors);
    }
}
