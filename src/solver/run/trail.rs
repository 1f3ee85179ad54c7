//! What a run has done since somebody asked, mark by mark: for who does it again with numbers of his own.

use super::Run;
use crate::solver::relaxing::Relaxing;
use crate::system::{Scheme, System};

/// What a run does to its states and its memory.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// The system takes notice of a communication step of a duration in s.
    Begins(f64),
    /// The memory follows the present inputs, and events happen that these set off.
    Follows,
    /// A step is accepted; the memory follows.
    Moves {
        /// Time in s at its end.
        time: f64,
        /// The states there.
        end: Vec<f64>,
        /// How the step is taken.
        how: How,
    },
    /// An event happens, by its place among the indicators, and those that it sets off.
    Switches(usize),
    /// The sample of a time in s is taken, and events happen that it sets off.
    Samples(f64),
    /// The system takes notice of a communication point.
    Arrives,
}

/// How a step is taken: what a solver chooses, and what does not vary with the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct How {
    /// Its size in s.
    pub h: f64,
    /// The method.
    pub method: Method,
    /// The weights of the state that relaxes.
    pub relaxing: Option<(usize, Relaxing)>,
    /// Whether states with a closed form are led.
    pub is_led: bool,
}

impl How {
    /// A step of a size in s of a method of one's own.
    pub const fn of_another(h: f64) -> Self {
        Self { h, method: Method::Other, relaxing: None, is_led: false }
    }
}

/// The method of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The classical method.
    Classical,
    /// The midpoint rule.
    Midpoint,
    /// Another.
    Other,
}

impl<H: System<U>, const N: usize, const U: usize> Run<H, N, U> {
    /// Leaves a trail from now on, or none.
    pub fn leave_trail(&mut self, leaves: bool) {
        self.trail = leaves.then(Vec::new);
    }

    /// The trail left since this was asked last.
    pub fn take_trail(&mut self) -> Vec<Mark> {
        self.trail.as_mut().map(std::mem::take).unwrap_or_default()
    }

    #[inline(always)]
    pub(super) fn mark(&mut self, mark: impl FnOnce() -> Mark) {
        // Without sensitivities nobody asks for a trail.
        if cfg!(feature = "sensitivities")
            && let Some(trail) = &mut self.trail
        {
            note(trail, mark());
        }
    }

    /// Marks a step to states.
    #[inline(always)]
    pub(super) fn mark_move(&mut self, h: f64, time: f64, end: &[f64; N]) {
        if cfg!(feature = "sensitivities") && self.trail.is_some() {
            let how = self.how(h);
            self.mark(|| moved(time, end, how));
        }
    }

    /// How a step of a size in s is taken from here.
    #[cold]
    #[inline(never)]
    fn how(&self, h: f64) -> How {
        let method = match (self.settings.scheme, self.is_explicit, self.is_midpoint) {
            (Scheme::Adaptive, true, true) => Method::Midpoint,
            (Scheme::Adaptive, true, false) => Method::Classical,
            _ => Method::Other,
        };
        let weights = |state: usize| {
            let u = self.inputs.at(self.time);
            let rate = self.system.relaxation(self.time, &self.x, &self.linearisation.derivatives, &u, &self.memory);
            Some((state, Relaxing::new(rate, h)?))
        };
        let relaxing = if method == Method::Other { None } else { Self::RELAXING.and_then(weights) };
        How { h, method, relaxing, is_led: H::LED > 0 && !self.inputs.vary() }
    }
}

// Few runs leave a trail.
#[cold]
#[inline(never)]
fn note(trail: &mut Vec<Mark>, mark: Mark) {
    trail.push(mark);
}

#[cold]
#[inline(never)]
fn moved(time: f64, end: &[f64], how: How) -> Mark {
    Mark::Moves { time, end: end.to_vec(), how }
}
