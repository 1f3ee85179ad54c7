//! Our equations as a general solver meets them: inputs, right-hand side, events, and what a run is made of.
//!
//! The modes of set-valued laws are handled as ours are: after each step our indicators are looked at, the first zero is found
//! on the solver's own interpolant, and the solver goes on from there after our equations have switched. The play of the valve,
//! which has a memory, is worked out beforehand and enters as a voltage, so that the solver may look ahead.

use std::cell::{Cell, RefCell};
use std::time::Instant;

use anyhow::Result;
use nalgebra::SMatrix;
use pneumatic_servo::friction::Indicators;
use pneumatic_servo::mechanics::{EndStops, OneSided};
use pneumatic_servo::models::pneumatic_servo_cylinder::{Memory, PRESSURE_A, PRESSURE_B, PneumaticServoCylinder};
use pneumatic_servo::numbers::{Dual, Real, Scalar, Tangent};
use pneumatic_servo::system::System;

use crate::case::{Case, DURATION, STEP, inputs, voltage};
use crate::error::Trajectory;

/// Interface of a solver in the comparison.
pub trait Solver<const N: usize> {
    /// Present time in s.
    fn time(&self) -> f64;
    /// Present states.
    fn states(&self) -> [f64; N];
    /// Takes one step of the solver's own size, not beyond the stop time.
    fn step(&mut self) -> Result<()>;
    /// The states at a time in s within the last step.
    fn interpolate(&self, time: f64) -> Result<[f64; N]>;
    /// Forgets the history, and goes on from a time in s within the last step.
    fn restart(&mut self, time: f64, states: &[f64; N]) -> Result<()>;
    /// Sets the time in s that the next steps may not cross.
    fn stop_at(&mut self, time: f64) -> Result<()>;
}

/// Coupling at the end of a communication step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coupling {
    /// The solver stops and starts afresh, as it must where it knows nothing of the input to come.
    Restarted,
    /// The solver stops there, but keeps its history and step size in spite of the jump of the input.
    Stopped,
    /// The solver knows the whole input beforehand, steps across its jumps, and is interpolated.
    Free,
    /// The solver knows the input without jumps, as a modeller writes it, and is interpolated.
    Smooth,
}

impl Coupling {
    /// Whether the solver stops at the ends of communication steps.
    fn stops(self) -> bool {
        matches!(self, Self::Restarted | Self::Stopped)
    }
}

/// Results of a run, and the cost of each communication step in ns.
#[derive(Clone, Debug)]
pub struct Run {
    /// The trajectory.
    pub trajectory: Trajectory,
    /// The costs.
    pub costs: Vec<f64>,
}

/// The voltages that lead a valve without play to the set points of the valve with its play.
fn effective_voltages(case: &Case) -> Vec<f64> {
    let width = case.parameter("valve.hysteresis");
    let mut set_point = 0.0f64;
    let steps = 0..(DURATION / STEP).round() as usize;
    let voltages = steps.map(|index| {
        set_point = behind_play(set_point, voltage(index as f64 * STEP), width);
        5.0 + 5.0 * set_point
    });
    voltages.collect()
}

/// Where a set point comes to that follows a voltage with a play.
fn behind_play(set_point: f64, voltage: f64, width: f64) -> f64 {
    let command = (voltage - 5.0) / 5.0;
    set_point.clamp(command - width, command + width)
}

/// The inputs as the rival sees them.
struct Inputs {
    values: Vec<f64>,
    /// Half the width of the valve's play.
    width: f64,
    /// The communication step that is being taken.
    held: Cell<usize>,
    /// Whether the input changes with time of its own, and how.
    coupling: Coupling,
}

impl Inputs {
    fn at(&self, time: f64) -> [f64; 3] {
        let index = if self.coupling.stops() { self.held.get() } else { (time / STEP) as usize };
        let [_, force, supply] = inputs();
        let held = self.values[index.min(self.values.len() - 1)];
        if self.coupling != Coupling::Smooth {
            return [held, force, supply];
        }
        // The sine turns at communication points only, so that within a step the play is taken up from one side.
        [5.0 + 5.0 * behind_play((held - 5.0) / 5.0, voltage(time), self.width), force, supply]
    }
}

/// Outputs for the friction force: `F_app - m*dv/dt`.
struct Outputs {
    area_a: f64,
    area_b: f64,
    dead_force: f64,
    stops: EndStops,
    mass: f64,
}

impl Outputs {
    fn new(case: &Case) -> Self {
        let area = |diameter: &str| std::f64::consts::PI / 4.0 * case.parameter(diameter).powi(2);
        let (bore, rod) = (area("cylinder.bore"), area("cylinder.rod"));
        let still = |name: &str| Tangent::still(case.parameter(name));
        let dead_force = case.parameter("ambientPressure") * rod + case.parameter("wireForce");
        let stops = EndStops {
            stroke: still("cylinder.stroke"),
            contact: OneSided { stiffness: still("cylinder.stopStiffness"), damping: still("cylinder.stopDamping") },
            clearances: [
                Tangent::still(case.parameter("chamberA.deadVolume") / bore),
                Tangent::still(case.parameter("chamberB.deadVolume") / (bore - rod)),
            ]
            .into(),
        };
        Self { area_a: bore, area_b: bore - rod, dead_force, stops, mass: case.parameter("mass.moving") }
    }

    /// Position and friction force.
    fn of<const N: usize>(&self, x: &[f64; N], rates: &[f64; N]) -> [f64; 2] {
        let [position, rate] = [x[N - 2], rates[N - 2]];
        let pressures = x[PRESSURE_A] * self.area_a - x[PRESSURE_B] * self.area_b;
        let stop = self.stops.force(Real::of(position), Real::of(rate)).value();
        let applied = pressures - self.dead_force + stop;
        [position, applied - self.mass * rates[N - 1]]
    }
}

/// The equations with what they remember.
pub struct Plant {
    system: PneumaticServoCylinder,
    memory: RefCell<Memory>,
    inputs: Inputs,
    outputs: Outputs,
}

impl Plant {
    /// The equations of a case without the play of its valve, which the inputs have in its place, and the states at the start.
    pub fn new<const N: usize>(case: &Case, system: PneumaticServoCylinder, coupling: Coupling) -> (Self, [f64; N]) {
        let (x, memory) = system.start::<Real, N>(&Real::all(&inputs()));
        let inputs = Inputs {
            values: effective_voltages(case),
            width: case.parameter("valve.hysteresis"),
            held: Cell::new(0),
            coupling,
        };
        (Self { system, memory: RefCell::new(memory), inputs, outputs: Outputs::new(case) }, x.map(Real::value))
    }

    /// The right-hand side.
    pub fn rates<const N: usize>(&self, time: f64, x: &[f64; N]) -> [f64; N] {
        let inputs = Real::all(&self.inputs.at(time));
        let rates = self.system.derivatives(Real::of(time), &Real::all(x), &inputs, &self.memory.borrow());
        rates.map(Real::value)
    }

    /// Its Jacobian times a vector.
    pub fn directional_rates<const N: usize>(&self, time: f64, x: &[f64], seed: &[f64]) -> [f64; N] {
        let x = std::array::from_fn::<_, N, _>(|i| Dual::<1>::new(x[i], [seed[i]]));
        let inputs = self.inputs.at(time).map(Dual::of);
        self.system.derivatives(Dual::of(time), &x, &inputs, &self.memory.borrow()).map(|rate| rate.slope[0])
    }

    /// Its Jacobian, column by column.
    pub fn jacobian<const N: usize>(&self, time: f64, x: &[f64; N]) -> [[f64; N]; N] {
        let mut found = SMatrix::<f64, N, N>::zeros();
        self.system.jacobian(time, x, &self.inputs.at(time), &self.memory.borrow(), &mut found.data.0);
        found.into()
    }

    fn indicators<const N: usize>(&self, time: f64, x: &[f64; N]) -> Indicators {
        let inputs = Real::all(&self.inputs.at(time));
        self.system.indicators(Real::of(time), &Real::all(x), &inputs, &self.memory.borrow())
    }

    /// Integrates the experiment.
    ///
    /// # Errors
    /// When the solver gives up.
    pub fn integrate<const N: usize>(&self, mut solver: impl Solver<N>, coupling: Coupling) -> Result<Run> {
        let count = self.inputs.values.len();
        let mut trajectory = Trajectory::with_capacity(count);
        let mut costs = Vec::with_capacity(count);
        let mut before = self.indicators(0.0, &solver.states());
        for index in 0..count {
            let clock = Instant::now();
            let end = (index + 1) as f64 * STEP;
            let is_at_end = |time: f64| time >= end - RESOLUTION;
            let stops = coupling.stops();
            self.inputs.held.set(index);
            if coupling == Coupling::Restarted {
                solver.restart(solver.time(), &solver.states())?;
            }
            if stops && !is_at_end(solver.time()) {
                solver.stop_at(end)?;
            }
            while !is_at_end(solver.time()) {
                let start = solver.time();
                solver.step()?;
                let found = self.first_event(&solver, start, &before)?;
                let reached = found.map_or(solver.time(), |(time, _)| time);
                self.sample_until(&solver, reached, &mut trajectory)?;
                if let Some((time, event)) = found {
                    let states = self.switched(event, time, solver.interpolate(time)?);
                    solver.restart(time, &states)?;
                    if stops && !is_at_end(time) {
                        solver.stop_at(end)?;
                    }
                }
                before = self.indicators(solver.time(), &solver.states());
            }
            costs.push(clock.elapsed().as_nanos() as f64);
        }
        trajectory.truncate(count);
        Ok(Run { trajectory, costs })
    }

    /// Appends what the trajectory has up to a time within the last step.
    fn sample_until<const N: usize>(
        &self,
        solver: &impl Solver<N>,
        until: f64,
        trajectory: &mut Trajectory,
    ) -> Result<()> {
        loop {
            let time = (trajectory.len() + 1) as f64 * STEP;
            if time > until + RESOLUTION {
                return Ok(());
            }
            let x = solver.interpolate(time.min(until))?;
            trajectory.push(self.outputs.of(&x, &self.rates(time, &x)));
        }
    }

    /// The first event within the last step: a time just behind it, and which.
    fn first_event<const N: usize>(
        &self,
        solver: &impl Solver<N>,
        start: f64,
        before: &Indicators,
    ) -> Result<Option<(f64, usize)>> {
        let end = solver.time();
        let after = self.indicators(end, &solver.states());
        let mut first: Option<(f64, usize)> = None;
        for (event, Real { value }) in after.as_ref().iter().enumerate().filter(|(_, indicator)| indicator.value < 0.0)
        {
            let value_at = |time: f64| -> Result<f64> {
                Ok(self.indicators(time, &solver.interpolate(time)?).as_ref()[event].value)
            };
            let mut low = (start, before.as_ref()[event].value);
            // The velocity is zero right after break-away; that root does not count.
            let mut fraction = 1e-3;
            while low.1 <= 0.0 && fraction < 1.0 {
                let time = start + fraction * (end - start);
                low = (time, value_at(time)?);
                fraction *= 4.0;
            }
            let time = if low.1 > 0.0 { locate(low, (end, *value), value_at)? } else { end };
            if first.is_none_or(|(earliest, _)| time < earliest) {
                first = Some((time, event));
            }
        }
        Ok(first)
    }

    /// The states after the equations have switched until all indicators are valid.
    fn switched<const N: usize>(&self, event: usize, time: f64, x: [f64; N]) -> [f64; N] {
        let (mut event, mut x) = (Some(event), Real::all(&x));
        let inputs = Real::all(&self.inputs.at(time));
        while let Some(index) = event {
            self.system.switch(index, Real::of(time), &mut x, &inputs, &mut self.memory.borrow_mut());
            let indicators = self.system.indicators(Real::of(time), &x, &inputs, &self.memory.borrow());
            event = indicators.due().map(|event| event as usize);
        }
        x.map(Real::value)
    }
}

/// Times closer than this in s are the same.
const RESOLUTION: f64 = 1e-12;

/// A time just behind the root of a function that is positive at the first and negative at the second point: regula
/// falsi (Illinois).
fn locate(mut low: (f64, f64), mut high: (f64, f64), value_at: impl Fn(f64) -> Result<f64>) -> Result<f64> {
    let mut last = 0.0;
    for _ in 0..100 {
        if high.0 - low.0 <= RESOLUTION {
            break;
        }
        let time = (low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1)).max(low.0 + 0.4 * RESOLUTION);
        let time = time.min(high.0 - 0.4 * RESOLUTION);
        let value = value_at(time)?;
        let side = if value > 0.0 { 1.0 } else { -1.0 };
        if side > 0.0 {
            low = (time, value);
            high.1 *= if last == side { 0.5 } else { 1.0 };
        } else {
            high = (time, value);
            low.1 *= if last == side { 0.5 } else { 1.0 };
        }
        last = side;
    }
    Ok(high.0)
}
