//! The cylinder as a hybrid system: its equations, events and samples, each told by the part that has it.

use std::ops::Range;

use super::cylinder::{ExplicitSteps, Memory, MemoryOf, Parts, PneumaticServoCylinder};
use super::ends;
use super::lines::{Lines, METER};
use super::motion::{self, Guidance};
use super::parameters::Parameters;
use super::sensors::Sensors;
use super::states::{ALL, Inputs, PRESSURE_A, PRESSURE_B, State, TEMPERATURE_A, TEMPERATURE_B, of_actuator};
use super::variables::{self, Outputs};
use crate::friction::{Event, FrictionContact, FrictionLaw, Indicators, Stiction};
use crate::holds;
use crate::numbers::{Number, Pair, Real, Scalar, Varying};
use crate::pneumatics::actuator::{Actuating, STATES};
use crate::pneumatics::{gas, orifice};
use crate::system::{
    ClosedForm, Groups, Hints, Holder, Holds, Indicator, Limits, LongestSteps, Part, PartFacts, QUANTITIES, Sample,
    StateIndex, StateLabel, Stride, System, Tables, UNUSED,
};
use crate::variables::{Notice, Notices, ParameterError, Values};

holds! {
    [L: FrictionLaw, A: Actuating, const EXTENDED: bool, const U: usize] PneumaticServoCylinder<L, A, EXTENDED>, U;
    |cylinder, time, x, u, memory|
    [EXTENDED] lines: Lines, "", [], ();
    [EXTENDED] sensors: Sensors, "sensor", memory.sensors, cylinder.quantities(time, x, &Inputs::of(u), memory);
    friction: FrictionContact<L>, "friction", memory.friction, cylinder.contact_at(time, x, &Inputs::of(u), memory);
}

/// Equations that read few of the inputs, those which a cylinder without options has a use for, or all of them.
impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool, const U: usize> System<U>
    for PneumaticServoCylinder<L, A, EXTENDED>
{
    type Parameters = Parameters;
    type State = State;
    type Memory<S: Varying> = MemoryOf<L, A, S>;
    type Indicators<S: Varying> = Indicators<S>;

    const INPUTS: usize = ALL;

    const RESIDUALS: usize = variables::RESIDUALS;

    const GROUPS: Groups = [STATES, State::FRICTION];

    const CLOSED_FORM: usize = STATES;

    const RELAXING: Option<StateIndex> = Some(StateIndex::Front(State::FRICTION));

    fn tables() -> Tables {
        variables::tables::<L, A>()
    }

    fn new(values: &mut Values) -> Result<Self, ParameterError> {
        let parts = Parts::read(values)?;
        if !EXTENDED && parts.need_extension() {
            let reason = "hoses, sensors and other options of the cylinder are not compiled into this program";
            return Err(ParameterError::new("options in use", 1.0, reason));
        }
        Ok(Self::of(parts))
    }

    fn parameters(&self) -> &Parameters {
        &self.p
    }

    fn parts() -> impl Holds<Self, U> {
        Holder
    }

    fn start<S: Varying, const N: usize>(&self, inputs: &[S; U]) -> ([S; N], Self::Memory<S>) {
        let u = Inputs::of(inputs);
        let mut x = [S::zero(); N];
        // A coupling is relaxed at the start.
        let (own, imposed) = ([self.p.position0, self.p.velocity0].map(S::along), u.imposed());
        let [position0, velocity0] = if self.is_free() { own } else { [imposed.position, imposed.velocity] };
        State::Position.set(&mut x, position0);
        State::Velocity.set(&mut x, velocity0);
        (x[PRESSURE_A], x[PRESSURE_B]) = (S::along(self.p.pressure0_a), S::along(self.p.pressure0_b));
        if EXTENDED {
            for (place, opens) in [PRESSURE_A, PRESSURE_B].into_iter().zip(self.options.opens()) {
                x[place] = if opens { S::along(self.p.ambient_pressure) } else { x[place] };
            }
        }
        [x[TEMPERATURE_A], x[TEMPERATURE_B]] = [S::along(self.p.ambient_temperature); 2];
        let lines = self.lines.start([x[PRESSURE_A], x[PRESSURE_B]], self.at_least_ambient(u.supply_pressure));
        self.lines.put(&lines, &mut x);
        let (states, actuator) = self.actuator.start(u.commands());
        x[..STATES].copy_from_slice(&states);
        let rate = if self.is_rigidly_imposed() { u.imposed_velocity } else { State::Velocity.get(&x) };
        let motion = motion::Memory::new(rate);
        let contact = self.contact(S::zero(), &x, &u, rate, None, &motion);
        let friction = self.friction.start(&self.guided_at_rest(contact, &x), &mut x);
        let contact = self.guided(contact, &x, &friction);
        let force = self.friction_force(&contact, &x, &friction);
        let acceleration = self.acceleration(&contact, force, &motion);
        let quantities = self.measured(S::zero(), &x, &u, [acceleration, force], (&friction, &motion));
        self.sensors.put(&quantities, &mut x);
        let ends = self.switched(&x, ends::Memory::default());
        (x, Memory { actuator, friction, sensors: self.sensors.start(quantities), motion, ends })
    }

    fn states(&self) -> usize {
        self.states()
    }

    fn unused(&self, n: usize) -> Range<usize> {
        let behind_friction = self.friction.range().end;
        behind_friction..behind_friction + n - self.states()
    }

    fn state_at(&self, reference: u32, n: usize) -> Option<usize> {
        let own = match State::of(reference) {
            // An imposed motion is given its velocity.
            Some(State::Velocity) if self.is_rigidly_imposed() => None,
            own => own.map(|state| state.at(n)),
        };
        let of_parts = || <Self as System<U>>::parts().list(self).find_map(|part| part.state_at(reference, n));
        own.or_else(of_parts).or_else(|| self.actuator.state_at(reference))
    }

    fn kink_list() -> Vec<Indicator> {
        let kink = |name: &str, text| Indicator { name: name.to_owned(), nominal: 1e-3, text };
        vec![
            kink("cylinder.stopA", "The stop at position 0 is touched or left"),
            kink("cylinder.stopB", "The stop at the end of the stroke is touched or left"),
            kink("cushionA.entry", "The piston enters or leaves the cushion of chamber A"),
            kink("cushionB.entry", "The piston enters or leaves the cushion of chamber B"),
            kink("sensor.end1.turn", "The switch near position 0 turns on or off"),
            kink("sensor.end2.turn", "The switch near the end of the stroke turns on or off"),
        ]
    }

    fn kinks<const N: usize>(&self, x: &[f64; N], kinks: &mut [f64]) {
        let Pair(lengths) = self.lengths(Real::of(State::Position.get(x)));
        let lengths = lengths.map(Real::value);
        let (stops, rest) = kinks.split_at_mut(lengths.len());
        let (cushions, switches) = rest.split_at_mut(lengths.len());
        stops.copy_from_slice(&lengths);
        for (side, kink) in cushions.iter_mut().enumerate() {
            *kink = self.lines.cushion(side).map_or(UNUSED, |length| lengths[side] - length);
        }
        for (side, kink) in switches.iter_mut().enumerate() {
            *kink = self.options.end_switches.kink(side, lengths[side]).unwrap_or(UNUSED);
        }
    }

    fn outputs<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; U],
        memory: &Self::Memory<S::Held>,
        computed: &mut [S],
    ) {
        self.write_outputs(time, x, &Inputs::of(u), memory, computed);
    }

    fn keeps_balance(&self) -> bool {
        self.p.keeps_balance
    }

    fn notices(&self, u: &[f64; U]) -> Notices {
        let Inputs { supply_pressure: value, .. } = Inputs::of(u);
        let remark = "it acts as ambientPressure, which is higher; pressures are absolute and in Pa";
        let is_low = value < self.p.ambient_pressure.value && self.actuator.has_supply();
        let low = is_low.then_some(Notice { variable: "supplyPressure", value, remark });
        [self.friction.law().notice(), low, self.options.left_out()]
    }

    fn derivatives<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; U],
        memory: &MemoryOf<L, A, S::Held>,
    ) -> [S; N] {
        let mut rates = [S::zero(); N];
        self.write_rates(time, x, &Inputs::of(u), memory, &mut rates);
        rates
    }

    fn switch<S: Varying, const N: usize>(
        &self,
        event: usize,
        time: S,
        x: &mut [S; N],
        u: &[S; U],
        memory: &mut MemoryOf<L, A, S>,
    ) {
        let u = &Inputs::of(u);
        let mut contact = self.whole_contact_at(time, x, u, memory);
        // A stop is found just beyond velocity zero; the holding force there depends on the side that it is pushed to.
        if EXTENDED && event == Event::Stop as usize && self.friction.law().stiction() == Stiction::Exact {
            contact.level = self.directed_level(x, S::zero(), None, contact.applied);
            contact = self.guided_at_rest(contact, x);
        } else {
            contact = self.guided(contact, x, &memory.friction);
        }
        self.friction.switch(event, &contact, x, &mut memory.friction);
    }

    fn follow<S: Varying, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; U],
        memory: &mut MemoryOf<L, A, S>,
    ) -> bool {
        let commands = Inputs::of(u).commands();
        // The velocity is worked out only for a law that asks for it.
        if self.is_rigidly_imposed() && self.friction.follows() {
            let rate = self.rate(time, x, &Inputs::of(u), memory);
            memory.motion.trend.follow(rate);
        }
        self.actuator.follow(commands, &mut memory.actuator);
        if EXTENDED {
            self.actuator.command(time, commands, &mut memory.actuator);
            memory.ends = self.switched(x, memory.ends);
        }
        Holder.follow(self, (time, x, u), memory)
    }

    fn begin<S: Varying, const N: usize>(
        &self,
        span: [f64; 2],
        x: &[S; N],
        u: &[S; U],
        slopes: &[f64; U],
        memory: &mut MemoryOf<L, A, S>,
    ) -> bool {
        if self.is_free() {
            return false;
        }
        let from = self.is_rigidly_imposed().then(|| State::Position.get(x));
        memory.motion.begin(span, from, Inputs::of(u).imposed(), Inputs::of(slopes).imposed());
        true
    }

    fn next_sample<S: Varying>(&self, memory: &MemoryOf<L, A, S>) -> Sample<S> {
        let of_parts = <Self as System<U>>::parts().next_sample::<S>(self, memory);
        if EXTENDED { self.actuator.next_sample::<S>(&memory.actuator).earlier(of_parts) } else { of_parts }
    }

    fn depends_on_time(&self) -> bool {
        let is_coupled = matches!(self.guidance, Guidance::Compliant { .. });
        let of_parts = || <Self as System<U>>::parts().list(self).any(PartFacts::depends_on_time);
        is_coupled || of_parts() || self.actuator.depends_on_time()
    }

    fn rounded(&self) -> Vec<String> {
        self.sensors.rounded()
    }

    fn state_label(&self, fields: &str) -> StateLabel {
        if let Some(fields) = fields.strip_prefix("actuator") {
            return self.actuator.variable_of(fields).map_or(StateLabel::Fields, StateLabel::Variable);
        }
        // The trend of an imposed motion is a sign.
        match fields {
            "motion.trend.velocity" => StateLabel::Nothing,
            _ => self.sensors.state_label(fields).unwrap_or(StateLabel::Fields),
        }
    }

    fn sample<S: Varying, const N: usize>(&self, time: S, x: &mut [S; N], u: &[S; U], memory: &mut MemoryOf<L, A, S>) {
        let next = System::<U>::next_sample::<S>(self, memory);
        if EXTENDED && self.actuator.next_sample::<S>(&memory.actuator) == next {
            let mut states = of_actuator(x);
            self.actuator.sample(&mut states, Inputs::of(u).commands(), &mut memory.actuator);
            x[..STATES].copy_from_slice(&states);
            return;
        }
        Holder.sample(self, (time, x, u), memory);
    }

    fn admit<const N: usize>(&self, x: &[f64; N]) -> Result<(), &'static str> {
        /// Names of the quantities that must be above 0: volumes, pressures, temperatures.
        const REASONS: [&str; 6] = [
            "the volume of chamber A vanishes",
            "the volume of chamber B vanishes",
            "chamberA.pressure falls to 0",
            "chamberB.pressure falls to 0",
            "chamberA.temperature falls to 0",
            "chamberB.temperature falls to 0",
        ];
        /// The first two where a multibody tool moves the carriage.
        const IMPOSED: [&str; 2] = [
            "imposedPosition is so far below 0 that the volume of chamber A vanishes",
            "imposedPosition is so far beyond cylinder.stroke that the volume of chamber B vanishes",
        ];
        let Pair([volume_a, volume_b]) = self.chambers.volume(self.lengths(Real::of(State::Position.get(x))));
        let [volume_a, volume_b] = [volume_a.value, volume_b.value];
        let [pressure_a, pressure_b, temperature_a, temperature_b] =
            [PRESSURE_A, PRESSURE_B, TEMPERATURE_A, TEMPERATURE_B].map(|index| x[index]);
        let is_above =
            [volume_a, volume_b, pressure_a, pressure_b, temperature_a, temperature_b].map(|value| value > 0.0);
        // All at once, since as a rule all are.
        if !is_above.iter().fold(true, |all, one| all & one) {
            let place = is_above.iter().position(|one| !one).unwrap_or_default();
            let imposed = IMPOSED.get(place).filter(|_| !self.is_free());
            return Err(imposed.unwrap_or(&REASONS[place]));
        }
        if EXTENDED && !self.lines.are_filled(x) {
            return Err("the pressure in a hose or in the vessel falls to 0");
        }
        self.admit_lubrication(x)
    }

    fn limits<const N: usize>(&self) -> [Limits; N] {
        let scales: [f64; N] = System::<U>::scales(self);
        let mut limits = scales.map(Limits::of_magnitude);
        limits[State::Position.at(N)] = self.stops.limits();
        <Self as System<U>>::parts().list(self).for_each(|part| part.write_limits(&mut limits));
        for (state, least) in [
            (State::PressureA, gas::THINNEST),
            (State::PressureB, gas::THINNEST),
            (State::TemperatureA, gas::COLDEST),
            (State::TemperatureB, gas::COLDEST),
        ] {
            limits[state.at(N)] = Limits::above(least, state.scale(&self.p));
        }
        limits
    }

    fn scales<const N: usize>(&self) -> [f64; N] {
        let mut scales = [1.0; N];
        <Self as System<U>>::parts().list(self).for_each(|part| part.write_scales(&mut scales));
        scales[..STATES].copy_from_slice(&self.actuator.scales());
        State::ALL.iter().for_each(|state| scales[state.at(N)] = state.scale(&self.p));
        scales
    }

    fn content<S: Varying, const N: usize>(&self, x: &[S; N], memory: &MemoryOf<L, A, S>) -> [f64; QUANTITIES] {
        self.mass_and_energy(x, memory)
    }

    fn inflow<S: Varying, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; U],
        memory: &MemoryOf<L, A, S>,
    ) -> [f64; QUANTITIES] {
        self.mass_flow_and_power(time, x, &Inputs::of(u), memory)
    }

    fn fits<S: Varying>(&self, memory: &MemoryOf<L, A, S>) -> bool {
        let fit = <Self as System<U>>::parts().fits::<S>(self, memory);
        fit && self.actuator.fits::<S>(&memory.actuator) && memory.motion.is_sound()
    }

    // Hints for speed.

    fn turning(&self, n: usize) -> Option<usize> {
        (self.friction.states() > 0).then(|| State::Velocity.at(n))
    }

    fn counting(&self, n: usize) -> Option<usize> {
        if !EXTENDED {
            return None;
        }
        self.lines.number(METER).map(|number| self.lines.first(n) + number)
    }

    fn at_hand<S: Varying, const N: usize>(&self, place: usize, x: &[S; N], memory: &Self::Memory<S>) -> Option<S> {
        const POSITION: usize = Outputs::PLACES.position;
        const VELOCITY: usize = Outputs::PLACES.velocity;
        const IN_A: usize = Outputs::PLACES.pressure_a;
        const IN_B: usize = Outputs::PLACES.pressure_b;
        match place {
            POSITION => Some(State::Position.get(x)),
            VELOCITY => (!self.is_rigidly_imposed()).then(|| self.own_rate(x, memory)),
            IN_A => Some(x[PRESSURE_A]),
            IN_B => Some(x[PRESSURE_B]),
            _ => None,
        }
    }

    fn derivatives_besides_closed_form<S: Varying, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; U],
        memory: &MemoryOf<L, A, S>,
    ) -> [S; N] {
        let mut rates = [S::zero(); N];
        self.driven_rates(time, x, &Inputs::of(u), memory, &mut rates);
        rates
    }

    fn jacobian<S: Varying, const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; U],
        memory: &MemoryOf<L, A, S>,
        jacobian: &mut [[f64; N]; N],
    ) -> [f64; N] {
        self.linearise(time, x, u, memory, jacobian)
    }

    fn hints<S: Varying, const N: usize>(&self, x: &[S; N], memory: &MemoryOf<L, A, S>) -> Hints {
        let longest = |steps: &ExplicitSteps| {
            let [position, velocity] = [State::Position, State::Velocity].map(|state| state.get(x).value());
            let of_motion = steps.longest(self.stops.touched(position), velocity);
            if !EXTENDED {
                return of_motion;
            }
            let longest = of_motion.min(self.lines.longest_steps()).min(self.longest_coupled);
            // Chambers that pulses vent come so close to the pressure outside that the midpoint rule does not follow.
            if self.actuator.is_sampled() { LongestSteps { midpoint: 0.0, ..longest } } else { longest }
        };
        Hints {
            explicit: self.explicit.as_ref().map(longest),
            is_fast: EXTENDED && self.actuator.is_fast::<S>(&memory.actuator),
            is_chain: EXTENDED && self.lines.are_coupled(),
        }
    }

    fn indicators_hold<S: Varying>(&self, inputs: [&[S; U]; 2]) -> bool {
        self.is_free() && act_on_actuator_alone(inputs) && !self.friction.follows()
    }

    fn update_derivatives<S: Varying, const N: usize>(
        &self,
        x: &[S; N],
        inputs: [&[S; U]; 2],
        memory: &MemoryOf<L, A, S>,
        derivatives: &mut [S; N],
    ) -> bool {
        if !self.is_free() || !act_on_actuator_alone(inputs) {
            return false;
        }
        let rates = self.actuator.rates(of_actuator(x), Inputs::of(inputs[1]).commands(), &memory.actuator);
        derivatives[..STATES].copy_from_slice(&rates);
        true
    }

    fn relaxation_rate<S: Varying, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        rates: &[S; N],
        u: &[S; U],
        memory: &MemoryOf<L, A, S>,
    ) -> f64 {
        let contact = || self.contact_at(time, x, &Inputs::of(u), memory);
        self.friction.relaxation_rate(contact, [x, rates], &memory.friction)
    }

    fn is_smooth<S: Varying, const N: usize>(
        &self,
        [x, end]: [&[f64; N]; 2],
        u: [&[f64; U]; 2],
        memory: &MemoryOf<L, A, S>,
        step: f64,
    ) -> bool {
        let [u, u_end] = u.map(Inputs::of);
        let states = [of_actuator(x), of_actuator(end)];
        self.smooth_region(x, &u) == self.smooth_region(end, &u_end)
            && self.actuator.stays_in_piece::<S>(states, u.commands(), &memory.actuator, step)
    }

    fn stride<S: Varying>(&self, size: f64) -> Stride<S> {
        Stride { size, half: self.actuator.half(size) }
    }

    fn closed_form<S: Varying, const N: usize>(
        &self,
        x: &[S; N],
        u: &[S; U],
        memory: &MemoryOf<L, A, S>,
        stride: &Stride<S>,
    ) -> ClosedForm<[S; N]> {
        let commands = Inputs::of(u).commands();
        let ClosedForm { middle, end, defect } =
            self.actuator.later(of_actuator(x), commands, &memory.actuator, stride);
        let placed = |own: [S; STATES]| {
            let mut all = [S::zero(); N];
            all[..STATES].copy_from_slice(&own);
            all
        };
        ClosedForm { middle: placed(middle), end: placed(end), defect: placed(defect) }
    }
}

/// Whether inputs differ in nothing but the voltage: it, and the play that follows it, act on the actuator alone.
fn act_on_actuator_alone<S: Scalar, const U: usize>(inputs: [&[S; U]; 2]) -> bool {
    let others = |u: Inputs<S>| [u.external_force, u.supply_pressure];
    let [from, to] = inputs.map(Inputs::of).map(others);
    from == to && from.map(|it| it.value().to_bits()) == to.map(|it| it.value().to_bits())
}

/// A smooth region of the equations.
#[derive(PartialEq)]
pub(super) struct SmoothRegion {
    /// Smooth region of the flows of the actuator.
    of_actuator: Pair<Real>,
    /// Smooth region of the flow into a vessel.
    into_vessel: f64,
    /// Smooth regions of the flows from hoses through restrictions into the chambers.
    into_chambers: [f64; 2],
    /// Smooth region of the leaks, and the side of equal pressures where these are a kink.
    of_leaks: Pair<Real>,
    /// The stops that act.
    touched: [bool; 2],
    /// SmoothRegion of the load factor along the stroke.
    of_profile: u32,
    /// The direction of a motion that bends bristles.
    is_backward: bool,
}

// The smooth regions of the equations, within which explicit steps may be taken.
impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// The smooth region of the equations in which the states lie.
    #[inline(always)]
    pub(super) fn smooth_region<const N: usize>(&self, x: &[f64; N], u: &Inputs<f64>) -> SmoothRegion {
        let (supply, numbers) = (Real::of(u.supply_pressure), Real::all(x));
        let ports = self.ports_at_valve(&numbers, supply);
        let of_actuator = self.actuator.smooth_region(of_actuator(x), &ports, self.pressures_at_valve(&numbers));
        let into_vessel = |vessel: f64| orifice::smooth_region(self.at_least_ambient(supply), Real::of(vessel)).value;
        SmoothRegion {
            of_actuator,
            into_vessel: self.vessel_pressure(x).map_or(0.0, into_vessel),
            into_chambers: self.pieces_of_restrictions(&numbers),
            of_leaks: self.pieces_of_leaks(Pair([PRESSURE_A, PRESSURE_B].map(|place| numbers[place]))),
            touched: self.stops.touched(State::Position.get(x)),
            of_profile: self.profile.as_ref().map_or(0, |profile| profile.smooth_region(State::Position.get(x))),
            is_backward: self.friction.states() > 0 && State::Velocity.get(x) < 0.0,
        }
    }

    /// The numbers of the smooth regions of the leaks, and of the friction level where it has a kink at equal pressures in both
    /// chambers.
    fn pieces_of_leaks(&self, pressures: Pair<Real>) -> Pair<Real> {
        let Pair([p_a, p_b]) = pressures;
        let a_is_above = || Pair([orifice::is_above(p_a, p_b), Real::zero()]);
        match &self.leaks {
            Some(leaks) => leaks.pieces(pressures, self.p.ambient_pressure.value) + a_is_above() * 4.0,
            None if self.options.kappa_difference.is_used() => a_is_above(),
            None => Pair::zero(),
        }
    }
}
