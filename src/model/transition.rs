//! Steps of a plant as linear maps, and gradients of whole runs by the chain of them backwards.

use std::collections::VecDeque;

use super::plant::{Until, go};
use super::{Plant, Saved};
use crate::numbers::{DIRECTIONS, Tangent};
use crate::sensitivity::{
    Along, Column, DirectionError, Gradient, NoDerivative, Seed, States, Tangents, Transition, TransitionError, Varied,
    directions, own_slope,
};
use crate::session::Snapshot;
use crate::system::LabelledNumber;
use crate::variables::{Kind, Place, Variable, find};

/// Steps between two states that are saved on the way of a gradient, and transitions that are held at a time.
const SEGMENT: usize = 64;

/// What is asked of the transitions of a run.
struct Asked {
    /// The continuous states that are integrated.
    states: States,
    /// Of each input whether it may act on something.
    inputs: Vec<bool>,
    parameters: Vec<Along>,
    /// Places of the outputs among the computed variables.
    outputs: Vec<usize>,
    /// The name that a run without derivatives is refused by.
    refused: String,
}

/// The columns and rows of a transition.
struct Columns<'a> {
    /// The state from which they are taken.
    snapshot: Snapshot,
    /// The inputs there and their slopes.
    held: (Vec<f64>, Vec<f64>),
    along: Vec<Along>,
    asked: &'a Asked,
    names: Vec<String>,
    /// Places of the outputs among the computed variables.
    outputs: &'a [usize],
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
        let asked = self.asked(parameters, outputs)?;
        self.linearised(Some(Until::After(size)), &asked, &asked.outputs, &mut None)
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
        let (asked, mut numbers) = (self.asked(parameters, outputs)?, None);
        let of_start = self.start_slopes(&asked)?;
        let at_start = self.linearised(None, &asked, &asked.outputs, &mut numbers)?;
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
            let (mut transitions, mut numbers) = (Vec::with_capacity(SEGMENT), None);
            for index in all.clone() {
                if !go_on() {
                    return Ok(None);
                }
                self.set_inputs(&steps.inputs[index]);
                let weights: Vec<f64> = (0..outputs.len()).map(|output| weight(index + 1, output)).collect();
                let has_weights = weights.iter().any(|weight| *weight != 0.0);
                let (time, until) = (self.time(), Some(Until::Time(steps.ends[index])));
                let shown: &[usize] = if has_weights { &asked.outputs } else { &[] };
                transitions.push((time, weights, self.linearised(until, &asked, shown, &mut numbers)?));
            }
            for (index, (time, weights, transition)) in all.zip(transitions).rev() {
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
    fn start_slopes(&mut self, asked: &Asked) -> Result<Vec<Vec<(String, f64)>>, TransitionError> {
        let Columns { along, names, .. } = self.columns(asked, &[], &self.simulation.memory_numbers());
        let along = &along[names.len()..];
        if self.has_begun() {
            let still: Vec<_> = names.iter().map(|name| (name.clone(), 0.0)).collect();
            return Ok(vec![still; along.len()]);
        }
        let mut columns = vec![Vec::new(); along.len()];
        for places in self.groups(along, |_| true) {
            let group: Vec<Along> = places.iter().map(|place| along[*place]).collect();
            let begin = self.vary_start(&group).map_err(|_| unlike(&asked.refused))?;
            for (direction, place) in places.into_iter().enumerate() {
                if let Some(lost) = begin.lost(direction) {
                    return Err(TransitionError::NoDerivative(lost.clone()));
                }
                let of_states =
                    asked.states.iter().map(|(number, name)| (name.clone(), begin.state(*number)[direction]));
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
        let (asked, mut numbers) = (self.asked(parameters, outputs)?, None);
        let of_start = self.start_slopes(&asked)?;
        let at_start = self.linearised(None, &asked, &asked.outputs, &mut numbers)?;
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
            let transition = self.linearised(Some(Until::Time(*end)), &asked, &asked.outputs, &mut numbers)?;
            tangent.check(&transition, time)?;
            refuse_rounded(&transition, *end, |output| (true, outputs[output]))?;
            rows.push(tangent.outputs(&transition, added, seeds));
            tangent.go_on(&transition, added, seeds);
        }
        Ok(Some(rows))
    }

    fn asked(&self, parameters: &[&str], outputs: &[&str]) -> Result<Asked, TransitionError> {
        let table = self.table();
        let refused = |name: &str, reason| TransitionError::Direction(DirectionError::refused(name, reason));
        let along = directions(table, &self.parameters, parameters).map_err(TransitionError::Direction)?;
        if let Some(place) = along.iter().position(|along| !matches!(along, Along::Parameter(_))) {
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
        let may_act =
            |input: &Variable| matches!(input.kind, Kind::Real(_)) && table.lack(input, &self.parameters).is_none();
        Ok(Asked {
            states: numbered.collect(),
            inputs: table.inputs().map(may_act).collect(),
            parameters: along,
            outputs: places,
            refused: (*parameters.first().unwrap_or(&"states")).to_owned(),
        })
    }

    /// The columns from here on, where the memory has numbers.
    fn columns<'a>(&self, asked: &'a Asked, outputs: &'a [usize], numbers: &[LabelledNumber]) -> Columns<'a> {
        let mut along: Vec<Along> = asked.states.iter().map(|(number, _)| Along::State(*number)).collect();
        let mut seldom: Vec<usize> = Vec::new();
        for number in numbers {
            seldom.extend((!number.is_variable).then_some(along.len()));
            along.push(Along::Memory(number.place));
        }
        for (place, may_act) in asked.inputs.iter().enumerate() {
            seldom.extend((!may_act).then_some(along.len()));
            along.push(Along::Input(place));
        }
        along.extend(&asked.parameters);
        let of_states = asked.states.iter().map(|(_, name)| name.clone());
        let names = of_states.chain(numbers.iter().map(|number| number.name.clone())).collect();
        let held = (self.inputs.clone(), self.slopes.clone());
        Columns { snapshot: self.simulation.save(), held, along, asked, names, outputs, seldom }
    }

    /// The place of a run beside this one that varies with the parameters among some directions; nothing if there is none.
    fn spare(&mut self, along: &[Along]) -> Option<usize> {
        let parameter = |along: &Along| if let Along::Parameter(place) = along { Some(*place) } else { None };
        let parameters = std::array::from_fn(|direction| along.get(direction).and_then(parameter));
        let place = self.spare.iter().position(|(others, _)| *others == parameters);
        place.or_else(|| {
            let varied = self.vary(along).ok()?;
            self.spare.push((parameters, varied));
            Some(self.spare.len() - 1)
        })
    }

    /// A run beside this one for a single step, from a saved state; nothing if there is none.
    fn beside(&mut self, along: &[Along], seeds: &[Seed], of: &Columns) -> Option<&mut dyn Varied> {
        let place = self.spare(along)?;
        let (_, varied) = &mut self.spare[place];
        varied.place(&of.snapshot, seeds).ok()?;
        varied.set_inputs(&of.held.0, &of.held.1);
        Some(varied.as_mut())
    }

    /// The linear map of a step, or of none.
    ///
    /// The columns of a smooth step come from its trail, all others from runs with slopes. A parameter that is zero, where another value
    /// adds states to the model, needs a run with slopes in any case.
    ///
    /// What seldom acts on anything, such as the time at which the carriage stuck last, shares a direction, in which each has a slope
    /// of its own. Where all that comes out is 0 or one of these slopes, each of them has been handed on or forgotten, and
    /// its column is known; else halves of them are tried.
    ///
    /// The numbers of the memory here, if they are known, become those at the end.
    fn linearised(
        &mut self,
        until: Option<Until>,
        asked: &Asked,
        outputs: &[usize],
        numbers: &mut Option<Vec<LabelledNumber>>,
    ) -> Result<Transition, TransitionError> {
        let before = numbers.take().unwrap_or_else(|| self.simulation.memory_numbers());
        let of = self.columns(asked, outputs, &before);
        let (inputs, number) = (self.inputs.len(), of.along.len());
        let first_parameter = of.names.len() + inputs;
        let mut columns: Vec<Option<Column>> = vec![None; number];
        let groups = self.groups(&of.along[first_parameter..], |_| false);
        let groups: Vec<Vec<usize>> =
            groups.iter().map(|group| group.iter().map(|place| first_parameter + place).collect()).collect();
        let smooth = until.map(|until| self.followed(&of, until, first_parameter, &groups)).transpose()?.flatten();
        let is_smooth = smooth.is_some();
        for (place, column) in (0..first_parameter).chain(groups.concat()).zip(smooth.into_iter().flatten()) {
            columns[place] = column;
        }
        let next = if is_smooth { before } else { self.simulation.memory_numbers() };
        let mut is_seldom = vec![false; number];
        of.seldom.iter().for_each(|place| is_seldom[*place] = true);
        let singles = (0..first_parameter).filter(|place| !is_seldom[*place]).map(|place| vec![place]);
        let together = (!of.seldom.is_empty()).then(|| of.seldom.clone());
        let mut waiting: VecDeque<Vec<usize>> = singles.chain(together).filter(|_| !is_smooth).collect();
        while !waiting.is_empty() {
            let sets: Vec<Vec<usize>> = waiting.drain(..DIRECTIONS.min(waiting.len())).collect();
            let found = self.follow(&of, &sets, until, &next)?;
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
        for group in groups {
            if columns[group[0]].is_some() {
                continue;
            }
            let sets: Vec<Vec<usize>> = group.iter().map(|place| vec![*place]).collect();
            let found = self.follow(&of, &sets, until, &next)?;
            sets.into_iter().zip(found).for_each(|(set, column)| columns[set[0]] = Some(column));
        }
        let columns = columns.into_iter().flatten().collect();
        let of_states = asked.states.iter().map(|(_, name)| name.clone());
        let next_names = of_states.chain(next.iter().map(|number| number.name.clone())).collect();
        *numbers = Some(next);
        Ok(Transition::of(columns, [of.names, next_names], inputs, outputs.len()))
    }

    /// Goes over a step; if the step is smooth, returns the columns by states, memory and inputs, followed by the columns by groups of
    /// parameters.
    fn followed(
        &mut self,
        of: &Columns,
        until: Until,
        first_parameter: usize,
        groups: &[Vec<usize>],
    ) -> Result<Option<Vec<Option<Column>>>, TransitionError> {
        let mut places = Vec::with_capacity(groups.len());
        for group in groups {
            let along: Vec<Along> = group.iter().map(|place| of.along[*place]).collect();
            places.push((self.spare(&along).ok_or_else(|| unlike(&of.asked.refused))?, group.len()));
        }
        let acts = |place: &usize| place.checked_sub(of.names.len()).is_none_or(|input| of.asked.inputs[input]);
        let acting: Vec<usize> = (0..first_parameter).filter(acts).collect();
        let along: Vec<Along> = acting.iter().map(|place| of.along[*place]).collect();
        self.simulation.begin_trail();
        self.advance(until).map_err(TransitionError::Step)?;
        let beside: Vec<(&dyn Varied, usize)> =
            places.into_iter().map(|(place, directions)| (self.spare[place].1.as_ref(), directions)).collect();
        let Some(mut found) = self.simulation.end_trail(&along, &beside, of.outputs) else { return Ok(None) };
        let by_parameters = found.split_off(along.len());
        let memory = of.names.len() - of.asked.states.len();
        let idle = Column::zero([of.asked.states.len(), memory, of.outputs.len()]);
        let mut columns = vec![Some(idle); first_parameter];
        acting.into_iter().zip(found).for_each(|(place, column)| columns[place] = column);
        columns.extend(by_parameters);
        Ok(Some(columns))
    }

    /// Columns in as many directions as a run has, of each of which a set varies; at the end the memory has numbers that are looked up
    /// once.
    fn follow(
        &mut self,
        of: &Columns,
        sets: &[Vec<usize>],
        until: Option<Until>,
        next: &[LabelledNumber],
    ) -> Result<Vec<Column>, TransitionError> {
        let seeds = |(direction, set): (usize, &Vec<usize>)| {
            let slope: fn(usize) -> f64 = if set.len() == 1 { |_| 1.0 } else { own_slope };
            let seed = move |place: &usize| Seed { along: of.along[*place], direction, slope: slope(*place) };
            set.iter().map(seed).collect::<Vec<_>>()
        };
        let seeds: Vec<Seed> = sets.iter().enumerate().flat_map(seeds).collect();
        let along: Vec<Along> = sets.iter().map(|set| of.along[set[0]]).collect();
        let mut shown = vec![Tangent::still(0.0); self.computed_count()];
        let Some(varied) = self.beside(&along, &seeds, of) else {
            return Err(unlike(&of.asked.refused));
        };
        if let Some(until) = until {
            go(varied, until).map_err(TransitionError::Step)?;
        }
        let lost = varied.outputs(&mut shown);
        let memory = varied.memory_slopes();
        let column = |(direction, lost): (usize, Option<NoDerivative>)| Column {
            states: of.asked.states.iter().map(|(number, _)| varied.state(*number)[direction]).collect(),
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
