//! Follows a run and carries slopes along.

use super::difference::{Around, Evaluation, Move, Outcome};
use super::equations::{Act, At, Equations};
use super::leaves::{Leaf, Leaves};
use super::memory::Dependence;
use super::of::Of;
use super::sides::Neighbours;
use super::slopes::{Driven, Slopes, add};
use super::variation::Node;
use super::way::Way;
use super::{Crossing, NoDerivative};
use crate::solver::Mark;

/// The smallest tolerance of slopes: with differences at events, they are not more exact.
const SHARPEST: f64 = 1e-8;

/// Follows a run and carries slopes along.
pub struct Companion {
    /// The equations, with the present memory.
    pub(super) equations: Box<dyn Equations>,
    /// The same, with a memory that is moved.
    pub(super) spare: Box<dyn Equations>,
    /// The same, with the memory before something is done.
    pub(super) mirror: Box<dyn Equations>,
    /// The same, with memories that differ in numbers that have slopes.
    pub(super) neighbours: Option<Neighbours>,
    pub(super) ways: Vec<Way>,
    pub(super) slopes: Vec<Slopes>,
    pub(super) inputs: Driven,
    /// Inputs from which the present ones have jumped, where nothing has followed them yet.
    pub(super) jumped_from: Option<Vec<f64>>,
    /// Whether nothing has followed the inputs yet.
    pub(super) is_new: bool,
    pub(super) time: f64,
    pub(super) x: Vec<f64>,
    pub(super) memory: Leaves,
    /// What is in the memory besides numbers.
    pub(super) form: u64,
    pub(super) scales: Vec<f64>,
    /// As many zeros as there are states.
    pub(super) stillness: Vec<f64>,
    /// Nominal values of the indicators.
    nominals: Vec<f64>,
    pub(super) input_names: Vec<&'static str>,
    /// Error of the slopes in a part of a step, relative to the largest they have had.
    pub(super) tolerance: f64,
    /// In how many parts per s pieces of steps are integrated.
    pub(super) pace: f64,
    /// The linear equations at the present point, if they are known.
    pub(super) here: Option<Node>,
    /// On which numbers of the memory the rates and the computed variables depend.
    pub(super) of_rates: Dependence,
    pub(super) of_outputs: Dependence,
    /// The slopes of the computed variables at the present point, if they are known.
    shown: Option<Vec<Result<Vec<f64>, NoDerivative>>>,
    /// Numbers of the memory that are rounded.
    pub(super) rounded: Vec<usize>,
    pub(super) crossings: Vec<Crossing>,
}

impl Companion {
    /// A companion of a run at a time and at states, for directions with their first slopes. Equations, twice, have the memory
    /// of the run; indicators have nominal values, and inputs names.
    pub fn new(
        [equations, spare]: [Box<dyn Equations>; 2],
        (time, x, inputs): (f64, Vec<f64>, Driven),
        tolerance: f64,
        (nominals, input_names): (Vec<f64>, Vec<&'static str>),
        ways: Vec<(Way, Slopes)>,
    ) -> Self {
        let (ways, slopes) = ways.into_iter().unzip();
        let (scales, memory, mirror) = (equations.scales(), equations.memory(), equations.twin());
        let tolerance = tolerance.max(SHARPEST);
        let mut companion = Self {
            equations,
            spare,
            mirror,
            neighbours: None,
            form: 0,
            ways,
            slopes,
            inputs,
            jumped_from: None,
            time,
            x,
            memory,
            stillness: vec![0.0; scales.len()],
            scales,
            nominals,
            input_names,
            tolerance,
            pace: 0.0,
            is_new: true,
            here: None,
            of_rates: Dependence::default(),
            of_outputs: Dependence::default(),
            shown: None,
            rounded: Vec::new(),
            crossings: Vec::new(),
        };
        let Self { ways, equations, .. } = &mut companion;
        ways.iter_mut().for_each(|way| way.look_beside(equations.as_ref()));
        companion.remember();
        companion.forget_rounded();
        companion
    }

    /// The slopes in each direction.
    pub fn slopes(&self) -> &[Slopes] {
        &self.slopes
    }

    /// The events so far.
    pub fn crossings(&self) -> &[Crossing] {
        &self.crossings
    }

    /// The states.
    pub fn states(&self) -> &[f64] {
        &self.x
    }

    /// The memory.
    pub fn memory(&self) -> &Leaves {
        &self.memory
    }

    /// What the numbers of the memory are.
    pub fn told(&self) -> Vec<Leaf> {
        self.equations.told()
    }

    /// Follows inputs, which may vary from now on.
    pub fn set_inputs(&mut self, values: &[f64], slopes: &[f64]) {
        let before = self.inputs.at(self.time);
        if values != before || slopes != self.inputs.slopes {
            (self.here, self.shown) = (None, None);
        }
        if values != before && self.jumped_from.is_none() {
            self.jumped_from = Some(before);
        }
        self.inputs = Driven { since: self.time, values: values.to_vec(), slopes: slopes.to_vec() };
    }

    /// Writes the slopes of the computed variables in a direction, of the values that belong to the present inputs. What has no
    /// slopes, as counters, stays 0; what depends on a number that is rounded, as the reading of a sensor with a resolution, is not a
    /// number.
    ///
    /// # Errors
    /// [`NoDerivative`] where there is none any more.
    pub fn outputs(&mut self, direction: usize, computed: &mut [f64]) -> Result<(), NoDerivative> {
        computed.fill(0.0);
        if self.shown.is_none() {
            let at = (self.x.clone(), self.memory.clone(), self.slopes.clone());
            let (here, jumped_from, is_new) = (self.here.clone(), self.jumped_from.clone(), self.is_new);
            self.pass(vec![Act::Follow], true, None);
            self.shown = Some(self.output_slopes());
            (self.here, self.jumped_from, self.is_new) = (here, jumped_from, is_new);
            if (&self.x, &self.memory) != (&at.0, &at.1) {
                (self.x, self.memory, self.neighbours) = (at.0, at.1, None);
                self.equations.remember(&self.memory);
                self.remember();
            }
            self.slopes = at.2;
        }
        let shown = self.shown.as_ref().map_or(&[][..], |shown| shown);
        match &shown[direction] {
            Ok(slopes) => computed.iter_mut().zip(slopes).for_each(|(slot, slope)| *slot = *slope),
            Err(lost) => return Err(lost.clone()),
        }
        Ok(())
    }

    /// The slopes of the computed variables in all directions.
    fn output_slopes(&mut self) -> Vec<Result<Vec<f64>, NoDerivative>> {
        let (x, u) = (self.x.clone(), self.inputs.at(self.time));
        let at = At { time: self.time, x: &x, u: &u };
        if self.moves_memory() {
            let present = self.equations.outputs(at);
            self.of_outputs.renew(self.spare.as_mut(), &self.memory, &present, |equations| equations.outputs(at));
        }
        let of_outputs = std::mem::take(&mut self.of_outputs);
        let mut shown = Vec::with_capacity(self.ways.len());
        for direction in 0..self.ways.len() {
            let Slopes { states, memory, lost, .. } = &self.slopes[direction];
            let equations = self.ways[direction].varied.as_ref().unwrap_or(&self.equations);
            shown.push(match (lost, equations.shown_slopes(memory)) {
                (Some(lost), _) => Err(lost.clone()),
                (None, Some(exact)) => Ok(exact),
                (None, None) => {
                    let mut sum = self.equations.output_slopes(at, (states, &vec![0.0; u.len()]));
                    let is_plain =
                        self.ways[direction].is_still() && !of_outputs.matters(&self.slopes[direction].memory);
                    let mut besides = vec![0.0; if is_plain { 0 } else { sum.len() }];
                    let outcome = match is_plain {
                        true => Ok(()),
                        false => self.besides(direction, at, Of::Outputs, &of_outputs, &mut besides),
                    };
                    let event = || "the computed variables".to_owned();
                    outcome.map_err(|reason| NoDerivative { time: at.time, event: event(), reason }).map(|()| {
                        add(&mut sum, Some(besides));
                        sum
                    })
                }
            });
        }
        self.of_outputs = of_outputs;
        shown
    }

    /// Does what the run has done.
    pub fn follow(&mut self, marks: &[Mark]) {
        if !marks.is_empty() {
            self.shown = None;
        }
        let mut rest = marks;
        while let [mark, others @ ..] = rest {
            rest = others;
            match mark {
                Mark::Begins(duration) => self.pass(vec![Act::Begin(*duration)], false, None),
                Mark::Follows => self.pass(vec![Act::Follow], true, None),
                Mark::Moves { time, end, .. } => {
                    self.cross(*time, end);
                    if let [Mark::Switches(event), others @ ..] = rest {
                        rest = others;
                        self.happen(*event, vec![Act::Follow, Act::Switch(*event)]);
                    } else {
                        self.pass(vec![Act::Follow], false, None);
                    }
                }
                Mark::Switches(event) => self.happen(*event, vec![Act::Switch(*event)]),
                Mark::Samples(time) => self.sample(*time),
                Mark::Arrives => self.pass(vec![Act::Arrive], false, None),
            }
        }
    }

    /// The nominal value of an indicator.
    pub(super) fn nominal(&self, event: usize) -> f64 {
        self.nominals.get(event).copied().unwrap_or(1.0)
    }

    pub(super) fn still(&self) -> Move {
        let [x, inputs, memory] = [self.x.len(), self.inputs.values.len(), self.memory.count()].map(|n| vec![0.0; n]);
        Move { time: 0.0, x, inputs, memory }
    }

    /// How the present point moves per unit of a direction.
    pub(super) fn movement(&self, direction: usize) -> Move {
        let Slopes { states, memory, .. } = &self.slopes[direction];
        Move { time: 0.0, x: states.clone(), inputs: self.ways[direction].inputs.clone(), memory: memory.clone() }
    }

    /// The derivative of what an evaluation leads to from the present point along a movement, and of the parameter of a way if
    /// one is given.
    pub(super) fn slope_along(
        &mut self,
        movement: &Move,
        way: Option<usize>,
        base: (&Outcome, &[f64]),
        evaluate: Evaluation,
    ) -> Result<Vec<f64>, String> {
        let (x, u) = (self.x.clone(), self.inputs.at(self.time));
        self.slope_at(At { time: self.time, x: &x, u: &u }, movement, way, base, evaluate)
    }

    /// The same from another point, with the present memory.
    pub(super) fn slope_at(
        &mut self,
        at: At,
        movement: &Move,
        way: Option<usize>,
        base: (&Outcome, &[f64]),
        evaluate: Evaluation,
    ) -> Result<Vec<f64>, String> {
        let (memory, held, scales) = (&self.memory, self.mirror.held(), &self.scales[..]);
        let way = way.map(|way| &mut self.ways[way]);
        Around { at, memory, held, scales, spare: self.spare.as_mut() }.slope_of(movement, way, base, evaluate)
    }

    /// Whether what an evaluation leads to from the present point bends there along a movement.
    pub(super) fn bends(&mut self, movement: &Move, base: &Outcome, evaluate: Evaluation) -> bool {
        let (x, u) = (&self.x, self.inputs.at(self.time));
        let at = At { time: self.time, x, u: &u };
        let (memory, held, scales) = (&self.memory, self.mirror.held(), &self.scales[..]);
        Around { at, memory, held, scales, spare: self.spare.as_mut() }.bends(movement, base, evaluate)
    }

    /// A number, or none and no derivative any more.
    pub(super) fn or_lose(&mut self, direction: usize, number: Result<f64, String>, event: &str) -> f64 {
        number.unwrap_or_else(|reason| {
            self.slopes[direction].lost = Some(NoDerivative { time: self.time, event: event.to_owned(), reason });
            f64::NAN
        })
    }

    /// Lets all other equations have the present memory.
    pub(super) fn remember(&mut self) {
        self.form = self.equations.numbers(&mut Vec::with_capacity(self.memory.count()));
        self.mirror.adopt(self.equations.held());
        self.ways.iter_mut().for_each(|way| way.adopt(self.equations.as_ref()));
    }

    /// What is done, in words.
    pub(super) fn describe(&self, acts: &[Act]) -> String {
        let words = acts.iter().filter_map(|act| match act {
            Act::Switch(event) => Some(self.equations.event_name(*event)),
            Act::Sample { .. } => Some("a sample"),
            _ => None,
        });
        let words: Vec<_> = words.collect();
        if words.is_empty() { "a change of the inputs or the end of a step".to_owned() } else { words.join(", then ") }
    }
}
