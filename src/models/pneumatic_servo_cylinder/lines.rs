//! Lines between supply, valve and chambers: a meter, a vessel, hoses, and restrictions where a hose meets its chamber.
//!
//! Hoses, meter and vessel have states of their own, behind the friction states; a cylinder without them has no such states.

use super::options::{Options, ThrottledFlow};
use super::states::State;
use crate::numbers::{Number, Real, Scalar, Tangent, Varying};
use crate::pneumatics::actuator::SUPPLY;
use crate::pneumatics::gas::{Gas, GasState, Reservoir, THINNEST};
use crate::pneumatics::hose::{COLUMNS, Hose};
use crate::pneumatics::orifice::{self, Flow, LAMINAR_RATIO, Orifice};
use crate::system::{Limits, LongestSteps, Part, PartFacts, references};
use crate::variables::{Tunable, Variable, units};

/// Volumes of a hose, each with a pressure.
pub const VOLUMES: usize = COLUMNS + 1;
/// States of a hose: pressures, and mass flows of the columns between them.
pub const HOSE: usize = VOLUMES + COLUMNS;
/// States of both hoses, of the meter and of the vessel.
pub const LINE_STATES: usize = 2 * HOSE + 2;
/// Place of the mass that the meter has counted among these.
pub const METER: usize = 2 * HOSE;
/// Place of the pressure in the vessel, the last one.
pub const VESSEL: usize = 2 * HOSE + 1;

/// The lines of a cylinder.
#[derive(Clone, Debug)]
pub struct Lines {
    pub hoses: [Option<Line>; 2],
    pub vessel: Option<Vessel>,
    /// Whether the mass that is drawn from the supply is counted.
    pub has_meter: bool,
    /// The gas in hoses, at the temperature that it has there.
    pub air: Reservoir,
    /// Density in kg/m3 of the gas at the reference conditions.
    reference_density: Tangent,
    /// The places of the states that are integrated, in the order in which a run has them, and how many these are.
    integrated: [u8; LINE_STATES],
    count: usize,
    /// Number of states between them and the position: the sensors'.
    pub behind: usize,
    /// The number of each state among these, by its place.
    numbers: [Option<u8>; LINE_STATES],
    /// The longest explicit steps.
    longest_steps: LongestSteps,
}

/// A hose and the restriction at its end.
#[derive(Clone, Debug)]
pub struct Line {
    hose: Hose,
    pub restriction: Option<Restriction>,
}

/// A one-way flow control and an end cushion in one: the conductance depends on the way of the flow, and in the last part
/// of the stroke the cushion takes the place of the open port.
///
/// ```text
/// C_out = C + (min(C, C_cushion) - C)*clamp(10*(1 - s/s_cushion), 0, 1)   s the distance to the end of the stroke
/// C     = C_least + (C_way - C_least)*min((1 - p2/p1)/0.005, 1)           C_way: C_into or C_out; C_least: the lesser
/// ```
///
/// The cushion closes on a tenth of its length, and lets air in freely. A check valve opens with the difference of the
/// pressures, fully at the ratio at which the flow of an orifice is no longer laminar. So the flow has a slope at equal
/// pressures, the same from both sides: there a small volume at the end of a hose, which follows the chamber within
/// nanoseconds through an open check valve and within microseconds through a closed one, would stop a solver.
#[derive(Clone, Debug)]
pub struct Restriction {
    orifice: Orifice,
    into: Tangent,
    out: Tangent,
    /// Length in m and sonic conductance in m3/(s Pa), if there is a cushion.
    cushion: Option<[Tangent; 2]>,
    quick_exhaust: Option<QuickExhaust>,
}

/// A quick exhaust valve in a port: a shuttle that lets air in from the line, and out of the chamber to the surroundings, past
/// the line.
///
/// ```text
/// o        = clamp((p - p_line)/dp_open, 0, 1)
/// mdot_out = orifice(p -> p_atm)   with o*C, b, and the conductance of the cushion as an upper bound of C
/// ```
///
/// Of the flow back into the line `1 - o` is left.
#[derive(Clone, Debug)]
struct QuickExhaust {
    orifice: Orifice,
    conductance: Tangent,
    /// `dp_open` in Pa.
    opening: Tangent,
    surroundings: Reservoir,
    /// In Pa.
    ambient: Tangent,
}

/// A vessel between the supply and the actuator, at the temperature of the supply; its own pressure bounds the outlet's
/// pressure, even where that is below ambient.
///
/// ```text
/// dp/dt = R*T/V*(mdot_supply - mdot_valve)
/// ```
#[derive(Clone, Debug)]
pub struct Vessel {
    pub volume: Tangent,
    pub conductance: Tangent,
    pub orifice: Orifice,
    pub air: Reservoir,
    /// `R*T` in J/kg.
    pub gas: Tunable,
}

/// Length in m of the passage of a port that ends in a restriction without a hose: a fitting with its thread.
pub const PASSAGE: f64 = 0.05;

/// Share of its length on which a cushion closes.
const CLOSING: f64 = 0.1;

impl Lines {
    /// The lines of a cylinder in surroundings of a pressure in Pa and a temperature in K, which the gas in its hoses has, and with
    /// gas of another temperature in its vessel.
    pub fn new(options: &Options, gas: &Gas, surroundings: [Tangent; 2], supply_temperature: Tunable) -> Self {
        let [ambient, temperature] = surroundings;
        let air = Reservoir::new(gas, temperature);
        let line = |side: usize| {
            let restriction = Restriction::new(options, side, air, ambient);
            let [length, diameter] = options.hoses()[side];
            let has_hose = length > 0.0;
            let length = if has_hose { length } else { Tangent::still(PASSAGE) };
            let is_there = (has_hose || restriction.is_some()) && !options.opens()[side];
            is_there.then(|| Line { hose: Hose::new(length, diameter, gas, temperature), restriction })
        };
        let vessel = (options.vessel_volume > 0.0).then(|| Vessel {
            volume: options.vessel_volume,
            conductance: options.vessel_conductance,
            orifice: Orifice::new(options.vessel_ratio),
            air: Reservoir::new(gas, supply_temperature),
            gas: supply_temperature * gas.constant,
        });
        Self::of([line(0), line(1)], vessel, options.counts_supply, gas, air)
    }

    fn of(hoses: [Option<Line>; 2], vessel: Option<Vessel>, has_meter: bool, gas: &Gas, air: Reservoir) -> Self {
        let lines = hoses.iter().flatten().map(|line| line.longest_steps(gas));
        let mut lines = Self {
            longest_steps: lines.fold(LongestSteps::UNLIMITED, LongestSteps::min),
            hoses,
            vessel,
            has_meter,
            air,
            reference_density: gas.reference_density(),
            integrated: [0; LINE_STATES],
            count: 0,
            behind: 0,
            numbers: [None; LINE_STATES],
        };
        for place in 0..LINE_STATES {
            if lines.has(place) {
                lines.integrated[lines.count] = place as u8;
                lines.numbers[place] = Some(lines.count as u8);
                lines.count += 1;
            }
        }
        lines
    }

    /// Whether any of their states is integrated.
    pub fn are_used(&self) -> bool {
        self.count > 0
    }

    /// Whether any of them acts on the chambers: the meter does not.
    pub fn are_coupled(&self) -> bool {
        self.count > usize::from(self.has_meter)
    }

    /// The longest explicit steps.
    pub fn longest_steps(&self) -> LongestSteps {
        self.longest_steps
    }

    /// The places of those that are integrated, in the order in which a run has them.
    pub fn integrated(&self) -> impl Iterator<Item = usize> {
        self.integrated[..self.count].iter().map(|place| usize::from(*place))
    }

    /// Number of a state, by its place, among those that are integrated, if it is.
    pub fn number(&self, place: usize) -> Option<usize> {
        self.numbers[place].map(usize::from)
    }

    /// Index of the first of them among `n` states of the cylinder.
    #[inline(always)]
    pub fn first(&self, n: usize) -> usize {
        State::Position.at(n) - self.behind - self.count
    }

    /// The places of those that are integrated, and their indices among `n` states of the cylinder.
    pub fn places(&self, n: usize) -> impl Iterator<Item = (usize, usize)> {
        self.integrated().zip(self.first(n)..)
    }

    /// The states by their places, given those of the cylinder; 0 for those that are not integrated.
    #[inline(always)]
    pub fn placed<S: Scalar>(&self, x: &[S]) -> [S; LINE_STATES] {
        let (mut states, first) = ([S::zero(); LINE_STATES], self.first(x.len()));
        self.integrated().zip(&x[first..]).for_each(|(place, state)| states[place] = *state);
        states
    }

    /// Puts values of the states, by their places, among those of the cylinder.
    #[inline(always)]
    pub fn put<T: Copy>(&self, states: &[T; LINE_STATES], x: &mut [T]) {
        let first = self.first(x.len());
        self.integrated().zip(&mut x[first..]).for_each(|(place, own)| *own = states[place]);
    }

    /// Whether a state, by its place, is integrated.
    pub fn has(&self, place: usize) -> bool {
        match place {
            METER => return self.has_meter,
            VESSEL => return self.vessel.is_some(),
            _ => {}
        }
        let owns_its_end = |line: &Line| line.restriction.is_some() || place % HOSE != VOLUMES - 1;
        self.hoses[place / HOSE].as_ref().is_some_and(owns_its_end)
    }

    /// Length in m of the cushion of a chamber, if it has one.
    pub fn cushion(&self, side: usize) -> Option<f64> {
        let [length, _] = self.hoses[side].as_ref()?.restriction.as_ref()?.cushion?;
        Some(length.value)
    }

    /// Volumes in m3 that the ends of hoses add to the chambers.
    pub fn added_volumes(&self) -> [Tangent; 2] {
        let none = Tangent::zero();
        let added = |line: &Line| if line.restriction.is_some() { none } else { line.hose.end_volume() };
        self.hoses.each_ref().map(|line| line.as_ref().map_or(none, added))
    }

    /// The states at the start: hoses at the pressures of the chambers, the vessel at supply pressure, which a supply below ambient
    /// does not lower, all at rest, the meter at 0.
    pub fn start<S: Scalar>(&self, pressures: [S; 2], supply: S) -> [S; LINE_STATES] {
        let start = |place: usize| match place {
            VESSEL => supply,
            METER => S::zero(),
            _ if place % HOSE < VOLUMES => pressures[place / HOSE],
            _ => S::zero(),
        };
        std::array::from_fn(|place| if self.has(place) { start(place) } else { S::zero() })
    }

    /// Mass in kg of the air in them.
    pub fn mass(&self, states: &[f64; LINE_STATES]) -> f64 {
        let hose = |(side, line): (usize, &Option<Line>)| {
            let pressures = std::array::from_fn(|i| states[side * HOSE + i]);
            line.as_ref().map_or(0.0, |line| line.hose.mass(pressures, line.restriction.is_some()))
        };
        let vessel = self.vessel.as_ref().map_or(0.0, |vessel| states[VESSEL] * vessel.volume.value / vessel.gas.value);
        self.hoses.iter().enumerate().map(hose).sum::<f64>() + vessel
    }

    /// Whether all pressures in use are positive, given the states of the cylinder.
    pub fn are_filled(&self, x: &[f64]) -> bool {
        self.places(x.len()).all(|(place, index)| !is_pressure(place) || x[index] > 0.0)
    }
}

/// Magnitudes of the states: 1 bar, 1 g/s, and 1 g.
fn scales() -> [f64; LINE_STATES] {
    std::array::from_fn(|place| if is_pressure(place) { 1e5 } else { 1e-3 })
}

impl PartFacts for Lines {
    #[inline(always)]
    fn states(&self) -> usize {
        self.count
    }

    fn state_at(&self, of: u32, n: usize) -> Option<usize> {
        self.places(n).find(|(place, _)| reference(*place) == of).map(|(_, index)| index)
    }

    fn write_scales(&self, all: &mut [f64]) {
        self.put(&scales(), all);
    }

    fn write_limits(&self, limits: &mut [Limits]) {
        let of = |place: usize, scale: f64| {
            if is_pressure(place) { Limits::above(THINNEST, scale) } else { Limits::of_magnitude(scale) }
        };
        let scales = scales();
        self.put(&std::array::from_fn(|place| of(place, scales[place])), limits);
    }
}

impl Part for Lines {
    type Memory<S: Varying> = [u8; 0];
    type Sees<S: Scalar> = ();
}

impl Restriction {
    /// Restriction at the port of a chamber, if any, in surroundings at a pressure in Pa.
    fn new(options: &Options, side: usize, surroundings: Reservoir, ambient: Tangent) -> Option<Self> {
        let (throttle, free) = (options.throttles()[side], options.throttle_free);
        let throttled = if throttle > 0.0 { throttle } else { free };
        let (into, out) = match options.throttled_flow {
            ThrottledFlow::MeterOut => (free, throttled),
            ThrottledFlow::MeterIn => (throttled, free),
        };
        let cushion = (options.cushion_length > 0.0).then_some([options.cushion_length, options.cushion_conductance]);
        let conductance = options.quick_exhausts()[side];
        let quick_exhaust = (conductance > 0.0).then(|| QuickExhaust {
            orifice: Orifice::new(options.quick_exhaust_ratio),
            conductance,
            opening: options.quick_exhaust_opening,
            surroundings,
            ambient,
        });
        let is_there = throttle > 0.0 || cushion.is_some() || quick_exhaust.is_some();
        is_there.then(|| Self { orifice: Orifice::new(options.throttle_ratio), into, out, cushion, quick_exhaust })
    }

    /// Flow from the end of a hose into a chamber whose piston is a distance in m from the end of its stroke, as a quick exhaust
    /// valve leaves it.
    fn line_flow<S: Scalar>(&self, from: GasState<S>, to: GasState<S>, distance: S) -> Flow<S> {
        let flow = self.flow(from, to, distance);
        let Some(exhaust) = &self.quick_exhaust else { return flow };
        Flow { mass: flow.mass * (-exhaust.opening(from.pressure, to.pressure) + 1.0), ..flow }
    }

    /// Flow from the end of a hose into a chamber whose piston is a distance in m from the end of its stroke.
    fn flow<S: Scalar>(&self, from: GasState<S>, to: GasState<S>, distance: S) -> Flow<S> {
        let (into, out) = (S::tuned(self.into), self.outward(distance));
        let (upstream, downstream) = (from.pressure.max(to.pressure), to.pressure.min(from.pressure));
        let (way, least) = (S::if_at_least(from.pressure, to.pressure, into, out), into.min(out));
        let opening = ((-downstream / upstream + 1.0) / (1.0 - LAMINAR_RATIO)).min(S::constant(1.0));
        self.orifice.flow((way - least) * opening + least, from, to)
    }

    /// The number of the smooth region of the flow between two pressures in Pa, at a distance in m from the end of the stroke.
    pub fn smooth_region(&self, from: Real, to: Real, distance: Real) -> f64 {
        let within =
            |share: f64| self.cushion.map_or(0.0, |[length, _]| f64::from(length.value * share > distance.value));
        let exhausting = self.quick_exhaust.as_ref().map_or(0.0, |exhaust| exhaust.smooth_region(from, to));
        orifice::smooth_region(from, to).value + 4.0 * (within(1.0) + within(1.0 - CLOSING)) + 12.0 * exhausting
    }

    /// Derivative in kg/(s Pa) of the flow of a gas the wider way with respect to a pressure, where it is laminar.
    fn steepest(&self, gas: &Gas) -> f64 {
        self.orifice.steepest(self.into.value.max(self.out.value), gas.choked_density.value)
    }

    fn outward<S: Scalar>(&self, distance: S) -> S {
        self.cushioned(self.out, distance)
    }

    /// A conductance out of the chamber, as the cushion leaves it.
    fn cushioned<S: Scalar>(&self, open: Tangent, distance: S) -> S {
        let Some([length, conductance]) = self.cushion else { return S::tuned(open) };
        let closed = ((-distance / length + 1.0) * (1.0 / CLOSING)).clamp(S::zero(), S::constant(1.0));
        closed * (open.min(conductance) - open) + open
    }
}

impl QuickExhaust {
    /// Opening, from 0 to 1, for the pressures in Pa in the line and in the chamber.
    fn opening<S: Scalar>(&self, line: S, chamber: S) -> S {
        ((chamber - line) / self.opening).clamp(S::zero(), S::constant(1.0))
    }

    /// The number of the smooth region of its flow: closed, opening or open, and of its orifice.
    fn smooth_region(&self, line: Real, chamber: Real) -> f64 {
        let opening = self.opening(line, chamber).value;
        let stage = if opening == 0.0 { 0.0 } else { 1.0 + f64::from(opening == 1.0) };
        stage + 3.0 * orifice::smooth_region(Real::of(self.ambient.value), chamber).value
    }
}

impl Line {
    /// The longest explicit steps, bounded by the fastest wave and by the last volume, if the line is closed.
    fn longest_steps(&self, gas: &Gas) -> LongestSteps {
        let of_waves = self.hose.longest_steps();
        self.restriction.as_ref().map_or(of_waves, |restriction| {
            let rate = self.hose.rate_at_end(restriction.steepest(gas));
            LongestSteps::of_swing(0.0, rate).min(of_waves)
        })
    }

    /// Flow from the surroundings, past the line, into a chamber whose piston is a distance in m from the end of its stroke, if a
    /// quick exhaust valve is in its port.
    pub fn outside_flow<S: Scalar>(&self, states: &[S], chamber: GasState<S>, distance: S) -> Option<Flow<S>> {
        let restriction = self.restriction.as_ref()?;
        let exhaust = restriction.quick_exhaust.as_ref()?;
        let outside = exhaust.surroundings.at(S::tuned(exhaust.ambient));
        let opening = exhaust.opening(states[VOLUMES - 1], chamber.pressure);
        Some(exhaust.orifice.flow(opening * restriction.cushioned(exhaust.conductance, distance), outside, chamber))
    }

    /// Rates of the states of the hose, and its flow into a chamber.
    pub fn flows<S: Scalar>(
        &self,
        states: &[S],
        air: &Reservoir,
        inflow: S,
        chamber: GasState<S>,
        distance: S,
    ) -> ([S; HOSE], Flow<S>) {
        let mut pressures: [S; VOLUMES] = std::array::from_fn(|i| states[i]);
        if self.restriction.is_none() {
            // The last volume is part of the chamber.
            pressures[VOLUMES - 1] = chamber.pressure;
        }
        let columns: [S; COLUMNS] = std::array::from_fn(|i| states[VOLUMES + i]);
        let flow_rates = self.hose.flow_rates(pressures, columns);
        let through = self.hose.through(pressures, columns, flow_rates);
        let end = air.at(pressures[VOLUMES - 1]);
        let out = match &self.restriction {
            Some(restriction) => restriction.line_flow(end, chamber, distance),
            None => {
                let mass = through[COLUMNS - 1];
                let temperature = if mass.value() >= 0.0 { end.temperature } else { chamber.temperature };
                Flow { mass, temperature }
            }
        };
        let mut rates = [S::zero(); HOSE];
        rates[..VOLUMES].copy_from_slice(&self.hose.pressure_rates(inflow, through, out.mass));
        if self.restriction.is_none() {
            rates[VOLUMES - 1] = S::zero();
        }
        rates[VOLUMES..].copy_from_slice(&flow_rates);
        (rates, out)
    }
}

/// Whether the state at a place is a pressure, and no mass or mass flow.
pub fn is_pressure(place: usize) -> bool {
    place == VESSEL || place < METER && place % HOSE < VOLUMES
}

/// Value references of the states of the hoses, of the vessel and of the meter; their rates are `RATES` further.
const HOSES: [u32; 2] = [300, 320];
const OF_VESSEL: u32 = 340;
const CONSUMED: u32 = 341;
const RATES: u32 = 10;
const CONSUMED_VOLUME: u32 = 342;

/// Value reference of a state by its place.
const fn reference(place: usize) -> u32 {
    match place {
        VESSEL => OF_VESSEL,
        METER => CONSUMED,
        _ => HOSES[place / HOSE] + (place % HOSE) as u32,
    }
}

/// Value references of the states that set the flow into a chamber, and of the pressure of the vessel.
pub fn feeds(chamber: usize) -> [u32; 4] {
    let first = chamber * HOSE;
    [first + VOLUMES - 2, first + VOLUMES - 1, first + HOSE - 1, VESSEL].map(reference)
}

impl Lines {
    /// Number of their variables.
    pub const COMPUTED: usize = 2 * LINE_STATES + 1;

    /// The volume in m3 at the reference conditions of a mass in kg that the meter has counted.
    pub fn consumed_volume<S: Scalar>(&self, states: &[S; LINE_STATES]) -> S {
        states[METER] / self.reference_density
    }

    /// Variables of the states, their rates and the consumed volume. The flow through the valve to a chamber depends on the
    /// variables `direct`, and on the gas at its port: in the chamber, on `gas`, which are pressure, temperature and position.
    pub fn computed(direct: [&[u32]; 2], gas: [[u32; 3]; 2]) -> Vec<Variable> {
        let mut table: Vec<Variable> = (0..LINE_STATES).map(state).collect();
        // At the port of the valve is the first volume of a hose, or the chamber, which only the vessel sees.
        let of_valve = |side: usize| [direct[side], &[reference(side * HOSE), reference(VESSEL)]].concat();
        let of_vessel = || {
            let mut all = [of_valve(0), of_valve(1), gas[0][..2].to_vec(), gas[1][..2].to_vec()].concat();
            all.sort_unstable();
            all.dedup();
            // The flow that an actuator draws follows from its states alone.
            all.retain(|known| *known != references::TIME);
            all
        };
        table.extend((0..LINE_STATES).map(|place| {
            let depends = match place {
                VESSEL | METER => of_vessel(),
                _ => depends_of_hose(place, &of_valve(place / HOSE), &gas[place / HOSE]),
            };
            let rate = state(place);
            if place == METER {
                return supply_flow().depends_on(&depends);
            }
            let unit = if is_pressure(place) { units::PASCAL_PER_SECOND } else { units::KILOGRAM_PER_SECOND_SQUARED };
            Variable::output(reference(place) + RATES, &format!("der({})", rate.name), unit)
                .local()
                .derivative_of(reference(place))
                .depends_on(&depends)
                .text(&format!("Rate: {}", rate.description))
        }));
        table.push(
            Variable::output(CONSUMED_VOLUME, "supply.consumedVolume", units::CUBIC_METRE)
                .counts_with("consumption.enabled")
                .nominal(1e-3)
                .shown_in("l")
                .depends_on(&[CONSUMED])
                .text("Gas drawn from the supply since the start, as volume at the reference conditions of ISO 8778 (ANR: air of 1.185 kg/m3, another gas by gas.R)"),
        );
        table
    }
}

/// The rate of the state of the meter.
fn supply_flow() -> Variable {
    Variable::output(CONSUMED + RATES, "supply.massFlow", units::KILOGRAM_PER_SECOND)
        .counts_with("consumption.enabled")
        .nominal(1e-3)
        .shown_in("l/min(ANR)")
        .derivative_of(CONSUMED)
        .text("Mass flow drawn from the supply by chambers, hoses, vessel and leakage; negative where gas flows back")
}

fn state(place: usize) -> Variable {
    if place == METER {
        return Variable::output(CONSUMED, "supply.consumed", units::KILOGRAM)
            .counts_with("consumption.enabled")
            .nominal(1e-3)
            .shown_in("g")
            .depends_on(&[CONSUMED])
            .text("Mass drawn from the supply since the start");
    }
    let (own, hose) = (reference(place), ["hoseA", "hoseB"].get(place / HOSE).copied().unwrap_or_default());
    let (name, text, nominal) = match place {
        VESSEL => ("supply.vesselPressure".to_owned(), "Absolute pressure in the vessel of the supply".to_owned(), 1e5),
        _ if is_pressure(place) => {
            let number = place % HOSE + 1;
            let chamber = ["chamberA", "chamberB"][place / HOSE];
            let what = if number < VOLUMES {
                "counted from the valve".to_owned()
            } else {
                format!(
                    "where a restriction is between it and the chamber; otherwise it is part of the chamber: see {chamber}.pressure"
                )
            };
            let text = format!("Absolute pressure in volume {number} of the hose, {what}");
            (format!("{hose}.pressure[{number}]"), text, 1e5)
        }
        _ => {
            let number = place % HOSE + 1 - VOLUMES;
            (
                format!("{hose}.massFlow[{number}]"),
                format!("Mass flow in air column {number} of the hose, positive towards the chamber"),
                1e-3,
            )
        }
    };
    let unit = if is_pressure(place) { units::PASCAL } else { units::KILOGRAM_PER_SECOND };
    let display = if is_pressure(place) { "bar" } else { "l/min(ANR)" };
    let variable = Variable::output(own, &name, unit).local().nominal(nominal).shown_in(display).depends_on(&[own]);
    let variable = if place == VESSEL { variable.starts_from(&[SUPPLY]) } else { variable };
    variable.text(&format!("{text}; 0 if there is none"))
}

/// Dependencies of the rate of a state of a hose.
fn depends_of_hose(place: usize, of_valve: &[u32], gas: &[u32; 3]) -> Vec<u32> {
    let (first, number) = (place / HOSE * HOSE, place % HOSE);
    let pressure = |number: usize| reference(first + number);
    // Flow of a column, from its own flow and the pressures at its ends, of which the last one may be the chamber's.
    let column = |number: usize| {
        let mut depends = vec![pressure(number), pressure(number + 1), reference(first + VOLUMES + number)];
        depends.extend((number == COLUMNS - 1).then_some(gas[0]));
        depends
    };
    let mut depends = match number {
        0 => [of_valve, &column(0)].concat(),
        _ if number == VOLUMES - 1 => [&column(COLUMNS - 1), &gas[..]].concat(),
        _ if number < VOLUMES => [column(number - 1), column(number)].concat(),
        _ => column(number - VOLUMES),
    };
    depends.sort_unstable();
    depends.dedup();
    depends
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Real;

    fn still(value: f64) -> Tangent {
        Tangent::still(value)
    }

    /// Open, half closed a twentieth of the length before the seal is tight, and tight.
    #[test]
    fn cushion_closes_on_a_tenth_of_its_length() {
        let restriction = Restriction {
            orifice: Orifice::new(still(0.3)),
            into: still(9e-9),
            out: still(8e-9),
            cushion: Some([0.02, 2e-9].map(still)),
            quick_exhaust: None,
        };
        for (distance, expected) in [(0.1, 8e-9), (0.02, 8e-9), (0.019, 5e-9), (0.018, 2e-9), (0.0, 2e-9)] {
            assert!((restriction.outward(Real::of(distance)).value - expected).abs() < 1e-21, "at {distance} m");
        }
        let gas = |pressure: f64| Gas::AIR.at(Real::of(pressure), Real::of(293.15));
        let flow = |from: f64, to: f64| restriction.flow(gas(from), gas(to), Real::of(0.0)).mass.value;
        let [into, out] = [flow(6e5, 1e5), flow(1e5, 6e5)];
        assert!((into / out + 9e-9 / 2e-9).abs() < 1e-12, "{into} {out}");
    }

    /// Mass flows have a sign, and unused places count for nothing.
    #[test]
    fn lines_are_filled_where_no_pressure_in_use_has_fallen_to_zero() {
        let hose =
            || Some(Line { hose: Hose::new(still(1.0), still(4e-3), &Gas::AIR, still(293.15)), restriction: None });
        let supply = still(293.15);
        let vessel = Vessel {
            volume: still(1e-3),
            conductance: still(1e-8),
            orifice: Orifice::new(still(0.3)),
            air: Reservoir::new(&Gas::AIR, supply),
            gas: supply * Gas::AIR.constant,
        };
        let air = Reservoir::new(&Gas::AIR, still(293.15));
        let both = Lines::of([hose(), hose()], Some(vessel), true, &Gas::AIR, air);
        let one = Lines::of([None, hose()], None, false, &Gas::AIR, air);
        for (lines, pressures) in [(both, 2 * COLUMNS + 1), (one, COLUMNS)] {
            let start = lines.start([2e5, 3e5].map(Real::of), Real::of(7e5));
            let mut x = [Real::of(0.0); State::OTHERS + LINE_STATES];
            lines.put(&start, &mut x);
            assert_eq!(lines.placed(&x), start);
            let x = x.map(Real::value);
            assert!(lines.are_filled(&x));
            let notices = |index: &usize| {
                let mut states = x;
                states[*index] = -1e-3;
                !lines.are_filled(&states)
            };
            let noticed: Vec<_> = (0..x.len()).filter(notices).collect();
            assert_eq!(noticed.len(), pressures, "{noticed:?}");
            assert!(noticed.iter().all(|index| x[*index] > 0.0), "{noticed:?}");
        }
    }
}
