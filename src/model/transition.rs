//! Steps of a plant as linear maps, and gradients of whole runs by the chain of them backwards.

use std::collections::VecDeque;

use super::plant::{Until, go};
use super::{Plant, Saved};
use crate::numbers::{DIRECTIONS, Tangent, random};
use crate::sensitivity::{
    Along, Column, DirectionError, Gradient, NoDerivative, Seed, States, Tangents, Transition, TransitionError, Varied,
    directions,
};
use crate::session::Snapshot;
use crate::system::LabelledNumber;
use crate::variables::{Kind, Place, find};

/// Steps between two states that are saved on the way of a gradient, and transitions that are held at a time.
const SEGMENT: usize = 64;

/// The columns and rows of a transition.
struct Columns {
    /// The state from which they are taken.
    snapshot: Snapshot,
    along: Vec<Along>,
    states: States,
    names: Vec<String>,
    /// Places of the outputs among the computed variables.
    outputs: Vec<usize>,
    /// Places of directions that seldom act on anything.
    seldom: Vec<usize>,
}

/// The steps of a run: the times in s at their ends and the inputs that are held over each.
#[derive(Clone, Copy, Debug)]
pub struct Steps<'a> {
    /// The times in s.
    pub ends: &'a [f64],
    /// The inputs, in the order of the table.
    pub inputs: &'a [Vec<f64>],
}

impl Plant {
    /// Integrates over a step of a size in s, with the derivatives of states, memory and outputs at its end by states, memory and
    /// inputs at its start and by parameters, which are given by their names.
    ///
    /// # Errors
    /// [`TransitionError`] for a name, and nothing has been done then, or for a step that cannot be made. A direction without a
    /// derivative has a column of NaN, and [`Transition::lost`] tells why.
    pub fn transition(
        &mut self,
        size: f64,
        parameters: &[&str],
        outputs: &[&str],
    ) -> Result<Transition, TransitionError> {
        self.linearised(Some(Until::After(size)), parameters, outputs)
    }

    /// Gradient of a scalar of a run from here on by additions to the inputs over each step, by the present states and
    /// numbers of the memory, and by parameters. In a run that has not begun yet, the first inputs and parameters act on its start,
    /// too. The scalar is a weighted sum of outputs: `weight` has the weight of an output,
    /// by its place, at the begin (0) and behind each step. Before every step of the way `go_on` is asked whether to go on; if not,
    /// there is no gradient.
    ///
    /// It is the chain of [transitions](Self::transition) backwards. On the way there a state is saved every 64 steps; on the way
    /// back the steps between two of these are repeated, bit for bit, and their transitions held. So it takes two runs and the
    /// transitions, however many inputs there are, and the memory of 64 transitions besides the inputs.
    ///
    /// # Errors
    /// [`TransitionError`]; the plant is somewhere in the run then, and at its begin otherwise. Where there is no derivative with
    /// respect to an input over a step, the gradient has NaN.
    pub fn gradient(
        &mut self,
        steps: Steps,
        parameters: &[&str],
        outputs: &[&str],
        weight: impl Fn(usize, usize) -> f64,
        mut go_on: impl FnMut() -> bool,
    ) -> Result<Option<Gradient>, TransitionError> {
        let of_start = self.start_slopes(parameters)?;
        let at_start = self.linearised(None, parameters, outputs)?;
        let mut saved: Vec<Saved> = Vec::new();
        for (index, (end, inputs)) in steps.ends.iter().zip(steps.inputs).enumerate() {
            if !go_on() {
                return Ok(None);
            }
            if index % SEGMENT == 0 {
                saved.push(self.save());
            }
            self.set_inputs(inputs);
            self.advance_to(*end).map_err(TransitionError::Step)?;
        }
        let mut gradient = Gradient::new(steps.ends.len(), self.inputs.len(), parameters.len());
        for (segment, saved) in saved.iter().enumerate().rev() {
            self.restore(saved).expect("a state of this plant");
            let first = segment * SEGMENT;
            let all = first..(first + SEGMENT).min(steps.ends.len());
            let mut transitions = Vec::with_capacity(SEGMENT);
            for index in all.clone() {
                if !go_on() {
                    return Ok(None);
                }
                self.set_inputs(&steps.inputs[index]);
                transitions
                    .push((self.time(), self.linearised(Some(Until::Time(steps.ends[index])), parameters, outputs)?));
            }
            for (index, (time, transition)) in all.zip(transitions).rev() {
                let weights: Vec<f64> = (0..outputs.len()).map(|output| weight(index + 1, output)).collect();
                refuse_rounded(&transition, steps.ends[index], |output| (weights[output] != 0.0, outputs[output]))?;
                gradient.go_back(index, time, &transition, &weights)?;
            }
        }
        let weights: Vec<f64> = (0..outputs.len()).map(|output| weight(0, output)).collect();
        refuse_rounded(&at_start, self.time(), |output| (weights[output] != 0.0, outputs[output]))?;
        gradient.begin(self.time(), &at_start, &of_start, &weights)?;
        if let Some(saved) = saved.first() {
            self.restore(saved).expect("a state of this plant");
        }
        Ok(Some(gradient))
    }

    fn set_inputs(&mut self, inputs: &[f64]) {
        inputs.iter().enumerate().for_each(|(place, value)| self.put_input(place, *value));
    }

    /// Derivatives of the start of states and numbers of the memory by inputs and parameters, if the run has not begun yet:
    /// a column for each.
    fn start_slopes(&mut self, parameters: &[&str]) -> Result<Vec<Vec<(String, f64)>>, TransitionError> {
        let Columns { along, states, names, .. } = self.columns(parameters, &[])?;
        let along = &along[names.len()..];
        if self.has_begun() {
            let still: Vec<_> = names.iter().map(|name| (name.clone(), 0.0)).collect();
            return Ok(vec![still; along.len()]);
        }
        let mut columns = vec![Vec::new(); along.len()];
        for places in self.groups(along, |_| true) {
            let group: Vec<Along> = places.iter().map(|place| along[*place]).collect();
            let begin = self.vary_start(&group).map_err(|_| unlike(parameters.first().unwrap_or(&"states")))?;
            for (direction, place) in places.into_iter().enumerate() {
                if let Some(lost) = begin.lost(direction) {
                    return Err(TransitionError::NoDerivative(lost.clone()));
                }
                let of_states = states.iter().map(|(number, name)| (name.clone(), begin.state(*number)[direction]));
                let slopes = begin.memory_slopes();
                let of_memory = begin.memory().into_iter();
                let of_memory = of_memory.map(|number| (number.name, slopes[number.place][direction]));
                columns[place] = of_states.chain(of_memory).collect();
            }
        }
        Ok(columns)
    }

    /// Derivatives of outputs of a run from here on along a direction, at the begin and behind each step: of additions to the
    /// inputs over each step, and of parameters. By the chain of [transitions](Self::transition) forwards, of which one is held
    /// at a time.
    ///
    /// # Errors
    /// As [`gradient`](Self::gradient).
    pub fn tangent(
        &mut self,
        steps: Steps,
        (parameters, seeds): (&[&str], &[f64]),
        outputs: &[&str],
        seed: impl Fn(usize, usize) -> f64,
        mut go_on: impl FnMut() -> bool,
    ) -> Result<Option<Vec<Vec<f64>>>, TransitionError> {
        let of_start = self.start_slopes(parameters)?;
        let at_start = self.linearised(None, parameters, outputs)?;
        let added = |step: usize| (0..self.inputs.len()).map(|input| seed(step, input)).collect::<Vec<_>>();
        let courses: Vec<Vec<f64>> = (0..steps.ends.len()).map(added).collect();
        let first = courses.first().cloned().unwrap_or_else(|| vec![0.0; self.inputs.len()]);
        let mut tangent = Tangents::begin(&of_start, &[&first[..], seeds].concat());
        let mut rows = vec![tangent.outputs(&at_start, &first, seeds)];
        for ((end, inputs), added) in steps.ends.iter().zip(steps.inputs).zip(&courses) {
            if !go_on() {
                return Ok(None);
            }
            self.set_inputs(inputs);
            let time = self.time();
            let transition = self.linearised(Some(Until::Time(*end)), parameters, outputs)?;
            tangent.check(&transition, time)?;
            refuse_rounded(&transition, *end, |output| (true, outputs[output]))?;
            rows.push(tangent.outputs(&transition, added, seeds));
            tangent.go_on(&transition, added, seeds);
        }
        Ok(Some(rows))
    }

    fn columns(&mut self, parameters: &[&str], outputs: &[&str]) -> Result<Columns, TransitionError> {
        let table = self.table();
        let refused = |name: &str, reason| TransitionError::Direction(DirectionError::refused(name, reason));
        let parameters_along = directions(table, &self.parameters, parameters).map_err(TransitionError::Direction)?;
        if let Some(place) = parameters_along.iter().position(|along| !matches!(along, Along::Parameter(_))) {
            return Err(refused(
                parameters[place],
                "it is no parameter: states and inputs are among the columns anyway",
            ));
        }
        let mut places = Vec::with_capacity(outputs.len());
        for name in outputs {
            let entry =
                find(table, name).map_err(|error| TransitionError::Direction(DirectionError::Unknown(error)))?;
            match (entry.place, &entry.variable.kind) {
                (Place::Computed(place), Kind::Real(_)) => places.push(place),
                (Place::Computed(_), _) => return Err(refused(name, "as an output: it is no real number")),
                _ => return Err(refused(name, "as an output: it is not computed")),
            }
        }
        let numbered = table.states().enumerate().filter_map(|(number, reference)| {
            self.simulation.state_index(number)?;
            Some((number, table.by_reference(reference)?.variable.name.clone()))
        });
        let states: States = numbered.collect();
        let snapshot = self.simulation.save();
        let here = self.beside(&[Along::Input(0)], &[], &snapshot).map(|varied| varied.memory());
        let memory = here.ok_or_else(|| unlike(parameters.first().unwrap_or(&"states")))?;
        let mut along: Vec<Along> = states.iter().map(|(number, _)| Along::State(*number)).collect();
        let mut seldom: Vec<usize> = Vec::new();
        for number in &memory {
            seldom.extend((!number.is_variable).then_some(along.len()));
            along.push(Along::Memory(number.place));
        }
        let of_states = states.iter().map(|(_, name)| name.clone());
        let names = of_states.chain(memory.into_iter().map(|number| number.name)).collect();
        for (place, input) in table.inputs().enumerate() {
            let may_act = matches!(input.kind, Kind::Real(_)) && table.lack(input, &self.parameters).is_none();
            seldom.extend((!may_act).then_some(along.len()));
            along.push(Along::Input(place));
        }
        along.extend(parameters_along);
        Ok(Columns { snapshot, along, states, names, outputs: places, seldom })
    }

    /// A run beside this one for a single step, from a saved state; nothing if there is none.
    fn beside(&mut self, along: &[Along], seeds: &[Seed], snapshot: &Snapshot) -> Option<&mut dyn Varied> {
        let parameter = |along: &Along| if let Along::Parameter(place) = along { Some(*place) } else { None };
        let parameters = std::array::from_fn(|direction| along.get(direction).and_then(parameter));
        let place = match self.spare.iter().position(|(others, _)| *others == parameters) {
            Some(place) => place,
            None => {
                let varied = self.vary(along).ok()?;
                self.spare.push((parameters, varied));
                self.spare.len() - 1
            }
        };
        let (_, varied) = &mut self.spare[place];
        varied.place(snapshot, seeds).ok()?;
        varied.set_inputs(&self.inputs, &self.slopes);
        Some(varied.as_mut())
    }

    /// The linear map of a step, or of none.
    ///
    /// What seldom acts on anything, such as the time at which the carriage stuck last, shares a direction, in which each has a slope
    /// of its own. Where all that comes out is 0 or one of these slopes, each of them has been handed on or forgotten, and
    /// its column is known; else halves of them are tried.
    fn linearised(
        &mut self,
        until: Option<Until>,
        parameters: &[&str],
        outputs: &[&str],
    ) -> Result<Transition, TransitionError> {
        let of = self.columns(parameters, outputs)?;
        let (inputs, number) = (self.inputs.len(), of.along.len());
        let first_parameter = of.names.len() + inputs;
        let mut columns: Vec<Option<Column>> = vec![None; number];
        let mut next: Option<Vec<LabelledNumber>> = None;
        let mut is_seldom = vec![false; number];
        of.seldom.iter().for_each(|place| is_seldom[*place] = true);
        let singles = (0..first_parameter).filter(|place| !is_seldom[*place]).map(|place| vec![place]);
        let together = (!of.seldom.is_empty()).then(|| of.seldom.clone());
        let mut waiting: VecDeque<Vec<usize>> = singles.chain(together).collect();
        while !waiting.is_empty() {
            let sets: Vec<Vec<usize>> = waiting.drain(..DIRECTIONS.min(waiting.len())).collect();
            let found = self.follow(&of, &sets, until, &mut next)?;
            for (set, column) in sets.into_iter().zip(found) {
                match &set[..] {
                    [place] => columns[*place] = Some(column),
                    _ => match column.each(set.iter().map(|place| own_slope(*place))) {
                        Some(each) => set.into_iter().zip(each).for_each(|(place, own)| columns[place] = Some(own)),
                        None if set.len() <= FEW => waiting.extend(set.into_iter().map(|place| vec![place])),
                        None => {
                            let (one, other) = set.split_at(set.len() / 2);
                            waiting.extend([one.to_vec(), other.to_vec()]);
                        }
                    },
                }
            }
        }
        for group in self.groups(&of.along[first_parameter..], |_| false) {
            let sets: Vec<Vec<usize>> = group.iter().map(|place| vec![first_parameter + place]).collect();
            let found = self.follow(&of, &sets, until, &mut next)?;
            sets.into_iter().zip(found).for_each(|(set, column)| columns[set[0]] = Some(column));
        }
        let columns = columns.into_iter().flatten().collect();
        if let Some(until) = until {
            self.advance(until).map_err(TransitionError::Step)?;
        }
        let of_states = of.states.iter().map(|(_, name)| name.clone());
        let of_memory = next.into_iter().flatten().map(|number| number.name);
        Ok(Transition::of(columns, [of.names, of_states.chain(of_memory).collect()], inputs, of.outputs.len()))
    }

    /// Columns in as many directions as a run has, of each of which a set varies; at the end the memory has numbers that are looked up
    /// once.
    fn follow(
        &mut self,
        of: &Columns,
        sets: &[Vec<usize>],
        until: Option<Until>,
        next: &mut Option<Vec<LabelledNumber>>,
    ) -> Result<Vec<Column>, TransitionError> {
        let seeds = |(direction, set): (usize, &Vec<usize>)| {
            let slope: fn(usize) -> f64 = if set.len() == 1 { |_| 1.0 } else { own_slope };
            let seed = move |place: &usize| Seed { along: of.along[*place], direction, slope: slope(*place) };
            set.iter().map(seed).collect::<Vec<_>>()
        };
        let seeds: Vec<Seed> = sets.iter().enumerate().flat_map(seeds).collect();
        let along: Vec<Along> = sets.iter().map(|set| of.along[set[0]]).collect();
        let mut shown = vec![Tangent::still(0.0); self.computed_count()];
        let Some(varied) = self.beside(&along, &seeds, &of.snapshot) else {
            return Err(unlike(of.names.first().map_or("states", String::as_str)));
        };
        if let Some(until) = until {
            go(varied, until).map_err(TransitionError::Step)?;
        }
        let lost = varied.outputs(&mut shown);
        let next = next.get_or_insert_with(|| varied.memory());
        let memory = varied.memory_slopes();
        let column = |(direction, lost): (usize, Option<NoDerivative>)| Column {
            states: of.states.iter().map(|(number, _)| varied.state(*number)[direction]).collect(),
            memory: next.iter().map(|number| memory[number.place][direction]).collect(),
            outputs: match lost {
                Some(lost) => Err(lost),
                None => Ok(of.outputs.iter().map(|place| shown[*place].slopes[direction]).collect()),
            },
        };
        Ok(lost.into_iter().enumerate().take(sets.len()).map(column).collect())
    }
}

fn unlike(name: &str) -> TransitionError {
    let reason = "this run has no equations that can be differentiated by it";
    TransitionError::Direction(DirectionError::refused(name, reason))
}

/// The most directions that are tried one by one where they act on something together.
const FEW: usize = 3;

/// A slope that no other direction has.
fn own_slope(place: usize) -> f64 {
    random::uniform(&mut (place as u64)) + 1.0
}

/// Why an output has no slope where the states have one.
const NO_SLOPE: &str =
    "it is rounded, or bends just there, as a flow where a valve begins to open at a communication point";

/// Refuses outputs that are rounded, of which is told whether they matter and their names.
fn refuse_rounded<'a>(
    transition: &Transition,
    time: f64,
    told: impl Fn(usize) -> (bool, &'a str),
) -> Result<(), TransitionError> {
    let Some(output) = transition.rounded(|output| told(output).0) else { return Ok(()) };
    let reason = NO_SLOPE.to_owned();
    Err(TransitionError::NoDerivative(NoDerivative { time, event: told(output).1.to_owned(), reason }))
}
