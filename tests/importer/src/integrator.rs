//! A host of model exchange: the classical method of Runge and Kutta, with events located by halving steps.

use anyhow::{Result, ensure};
use fmi::EventFlags;
use fmi::traits::FmiModelExchange;

use crate::host::{Host, Version, ok};

/// Distance in s of a step's end from an event.
const RESOLUTION: f64 = 1e-12;

/// Model exchange of either version.
pub trait Exchange: Version + FmiModelExchange {
    /// The numbers of continuous states and of event indicators.
    ///
    /// # Errors
    /// When the FMU does not tell.
    fn sizes(&mut self, import: &Self::Import) -> Result<[usize; 2]>;
}

/// An initialized instance, integrated with a fixed step.
pub struct Integrator<'a, I: Exchange> {
    /// The instance with its names.
    pub host: Host<'a, I>,
    /// Events so far, of states and of time; jumps of inputs not included.
    pub events: usize,
    step: f64,
    time: f64,
    states: Vec<f64>,
    indicators: Vec<f64>,
    next_time_event: f64,
}

impl<'a, I: Exchange> Integrator<'a, I> {
    /// Starts at time 0, with the step in s.
    ///
    /// # Errors
    /// When the FMU refuses, as in all below.
    pub fn new(mut host: Host<'a, I>, step: f64) -> Result<Self> {
        let [states, indicators] = host.instance.sizes(host.import)?;
        let mut integrator = Self {
            host,
            events: 0,
            step,
            time: 0.0,
            states: vec![0.0; states],
            indicators: vec![0.0; indicators],
            next_time_event: f64::INFINITY,
        };
        integrator.settle()?;
        Ok(integrator)
    }

    /// Lets a real input jump.
    ///
    /// # Errors
    /// See above.
    pub fn set_input(&mut self, name: &str, value: f64) -> Result<()> {
        ok::<I>(FmiModelExchange::enter_event_mode(&mut self.host.instance))?;
        self.host.set_real(name, value)?;
        self.settle()
    }

    /// Integrates to a time.
    ///
    /// # Errors
    /// See above, or when the FMU asks to terminate.
    pub fn advance(&mut self, end: f64) -> Result<()> {
        while self.time < end {
            let limit = end.min(self.next_time_event);
            let target = if self.time + 1.001 * self.step < limit { self.time + self.step } else { limit };
            let mut reached = (target, self.attempt(target - self.time)?);
            let is_event = self.has_crossed()?;
            if is_event {
                reached = self.locate(target - self.time)?;
            }
            (self.time, self.states) = reached;
            self.accept()?;
            if is_event || self.time == self.next_time_event {
                self.events += 1;
                ok::<I>(FmiModelExchange::enter_event_mode(&mut self.host.instance))?;
                self.settle()?;
            }
        }
        Ok(())
    }

    /// Updates discrete states until nothing changes, in event mode, and goes on to integrate.
    fn settle(&mut self) -> Result<()> {
        let mut flags = EventFlags { discrete_states_need_update: true, ..EventFlags::default() };
        let mut updates = 0;
        while flags.discrete_states_need_update {
            flags.reset();
            ok::<I>(FmiModelExchange::update_discrete_states(&mut self.host.instance, &mut flags))?;
            ensure!(!flags.terminate_simulation, "the FMU asks to terminate at {} s", self.time);
            updates += 1;
            ensure!(updates <= 3, "{updates} updates at {} s", self.time);
        }
        self.next_time_event = flags.next_event_time.unwrap_or(f64::INFINITY);
        ok::<I>(self.host.instance.enter_continuous_time_mode())?;
        ok::<I>(self.host.instance.get_continuous_states(&mut self.states))?;
        ensure!(!self.has_crossed()?, "an indicator is not positive after an event at {} s", self.time);
        Ok(())
    }

    /// The states after a step; the instance is left there.
    fn attempt(&mut self, h: f64) -> Result<Vec<f64>> {
        let start = self.states.clone();
        let mut rates = vec![0.0; start.len()];
        let mut sum = vec![0.0; start.len()];
        let along =
            |rates: &[f64], h: f64| -> Vec<f64> { start.iter().zip(rates).map(|(x, rate)| x + h * rate).collect() };
        for (offset, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let stage = along(&rates, offset * h);
            self.go(offset * h, &stage)?;
            ok::<I>(self.host.instance.get_continuous_state_derivatives(&mut rates))?;
            sum.iter_mut().zip(&rates).for_each(|(sum, rate)| *sum += weight / 6.0 * rate);
        }
        let end = along(&sum, h);
        self.go(h, &end)?;
        Ok(end)
    }

    /// Puts the instance at a point of a step.
    fn go(&mut self, offset: f64, states: &[f64]) -> Result<()> {
        ok::<I>(self.host.instance.set_time(self.time + offset))?;
        ok::<I>(self.host.instance.set_continuous_states(states))
    }

    /// Whether an indicator has fallen to zero where the instance is.
    fn has_crossed(&mut self) -> Result<bool> {
        let has_values = self.host.instance.get_event_indicators(&mut self.indicators);
        ensure!(has_values.map_err(Into::<fmi::Error>::into)?, "no event indicators at {} s", self.time);
        Ok(self.indicators.iter().any(|indicator| *indicator <= 0.0))
    }

    /// The point just behind the first event within a step; the instance is left there.
    fn locate(&mut self, h: f64) -> Result<(f64, Vec<f64>)> {
        let (mut low, mut high) = (0.0, h);
        while high - low > RESOLUTION {
            let middle = 0.5 * (low + high);
            self.attempt(middle)?;
            *(if self.has_crossed()? { &mut high } else { &mut low }) = middle;
        }
        Ok((self.time + high, self.attempt(high)?))
    }

    /// Tells the instance, which is there, that the step has been taken.
    fn accept(&mut self) -> Result<()> {
        let [mut event, mut terminate] = [false; 2];
        ok::<I>(self.host.instance.completed_integrator_step(true, &mut event, &mut terminate))?;
        ensure!(!event && !terminate, "an accepted step asks for an event or the end at {} s", self.time);
        Ok(())
    }
}
