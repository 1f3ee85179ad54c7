//! Follows a run and carries slopes along.

use std::collections::HashMap;

use super::equations::{Act, At, Equations};
use super::leaves::Leaves;
use super::variation::{Node, Piece};
use super::way::Way;
use super::{Crossing, NoDerivative};
use crate::solver::Mark;

/// Share of its magnitude by which what is differenced moves. The error of a central difference is the square of that, and
/// that of rounding 1e-16 over it.
pub(super) const SHARE: f64 = 1e-5;
/// How much of a difference may be a kink.
const ROUGH: f64 = 0.05;
/// How much nearer to stay where there is a kink.
const NEAR: f64 = 0.01;
/// How much farther to go where rounding counts, and by how much slopes may differ there between the whole and half the way.
const WIDE: f64 = 100.0;
const SMOOTH: f64 = 1e-4;
/// Steps are divided at kinks until less than this fraction is left.
const SMALLEST_PIECE: f64 = 1e-9;
/// The smallest tolerance of slopes: with differences of rates, they are not more exact.
const SHARPEST: f64 = 1e-8;
/// Slopes that change a state by less than this multiple of its scale, where the parameter changes by its magnitude, do not
/// count.
const NEGLIGIBLE: f64 = 1e-3;
/// Longest part of a step, as a multiple of the time in which states that follow the inputs alone change: the solver has these
/// in closed form, and its steps do not know them.
const LED_PART: f64 = 0.2;
/// Events that one change sets off, before a run gives up.
const MAX_SWITCHES: usize = 100;
/// Rate in 1/s of an indicator relative to its nominal value below which the motion grazes the limit.
const GRAZING: f64 = 1e-7;
/// Distance from its limit, relative to its nominal value, at which an indicator is at it.
const AT_LIMIT: f64 = 1e-10;
/// How far behind its limit, relative to its nominal value, an indicator is where both sides of it are.
const BEHIND: f64 = 1e-7;
/// Time in s in which the equations change by themselves at the fastest.
const TIME_SCALE: f64 = 1e-3;

/// Slopes in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Slopes {
    /// Of the states.
    pub states: Vec<f64>,
    /// Of the numbers of the memory.
    pub memory: Vec<f64>,
    /// The largest the states have had so far.
    pub peaks: Vec<f64>,
    /// Where they end.
    pub lost: Option<NoDerivative>,
}

impl Slopes {
    /// Slopes of states and of the numbers of a memory, from here on.
    pub fn new(states: Vec<f64>, memory: Vec<f64>) -> Self {
        Self { peaks: states.iter().map(|slope| slope.abs()).collect(), states, memory, lost: None }
    }
}

/// Inputs that vary linearly from a time on.
#[derive(Clone, Debug)]
pub struct Driven {
    /// That time in s.
    pub since: f64,
    /// Their values then.
    pub values: Vec<f64>,
    /// Their slopes.
    pub slopes: Vec<f64>,
}

impl Driven {
    fn at(&self, time: f64) -> Vec<f64> {
        let at =
            |(value, slope): (&f64, &f64)| if *slope == 0.0 { *value } else { value + slope * (time - self.since) };
        self.values.iter().zip(&self.slopes).map(at).collect()
    }

    fn vary(&self) -> bool {
        self.slopes.iter().any(|slope| *slope != 0.0)
    }
}

/// How a point moves per unit of a direction.
#[derive(Clone, Debug)]
struct Move {
    time: f64,
    x: Vec<f64>,
    inputs: Vec<f64>,
    memory: Vec<f64>,
}

/// Numbers that something leads to, and the form of the memory that some of them are in.
struct Outcome {
    numbers: Vec<f64>,
    form: Option<Leaves>,
    /// The numbers that it came from.
    origin: Vec<f64>,
}

impl Outcome {
    fn of(numbers: Vec<f64>) -> Self {
        Self { numbers, form: None, origin: Vec::new() }
    }

    /// States and memory that come from others at a time and under inputs.
    fn landing(at: At, memory: &Leaves, states: &[f64], form: Leaves) -> Self {
        let numbers = states.iter().copied().chain(form.values()).collect();
        let others = at.u.iter().copied().chain([at.time]);
        Self { numbers, form: Some(form), origin: at.x.iter().copied().chain(memory.values()).chain(others).collect() }
    }
}

/// A step: the cubic through the states and the rates at both ends.
struct Path {
    start: f64,
    h: f64,
    ends: [Vec<f64>; 2],
    rates: [Vec<f64>; 2],
}

impl Path {
    fn at(&self, fraction: f64) -> Vec<f64> {
        let rest = 1.0 - fraction;
        let [value, first, last] = [
            fraction * fraction * (3.0 - 2.0 * fraction),
            fraction * rest * rest * self.h,
            fraction * fraction * rest * self.h,
        ];
        let state = |i: usize| {
            let [start, end] = [self.ends[0][i], self.ends[1][i]];
            start + value * (end - start) + first * self.rates[0][i] - last * self.rates[1][i]
        };
        (0..self.ends[0].len()).map(state).collect()
    }
}

/// Follows a run and carries slopes along.
pub struct Companion {
    /// The equations, with the present memory.
    equations: Box<dyn Equations>,
    /// The same, with a memory that is moved.
    spare: Box<dyn Equations>,
    ways: Vec<Way>,
    slopes: Vec<Slopes>,
    inputs: Driven,
    time: f64,
    x: Vec<f64>,
    memory: Leaves,
    scales: Vec<f64>,
    /// Nominal values of the indicators.
    nominals: Vec<f64>,
    /// Error of the slopes in a part of a step, relative to the largest they have had.
    tolerance: f64,
    /// The linear equations at the present point, if they are known.
    here: Option<Node>,
    crossings: Vec<Crossing>,
}

impl Companion {
    /// A companion of a run at a time and at states, for directions with their first slopes. Equations, twice, have the memory
    /// of the run; indicators have nominal values.
    pub fn new(
        [equations, spare]: [Box<dyn Equations>; 2],
        (time, x, inputs): (f64, Vec<f64>, Driven),
        tolerance: f64,
        nominals: Vec<f64>,
        ways: Vec<(Way, Slopes)>,
    ) -> Self {
        let (ways, slopes) = ways.into_iter().unzip();
        let (scales, memory) = (equations.scales(), equations.memory());
        let tolerance = tolerance.max(SHARPEST);
        let mut companion = Self {
            equations,
            spare,
            ways,
            slopes,
            inputs,
            time,
            x,
            memory,
            scales,
            nominals,
            tolerance,
            here: None,
            crossings: Vec::new(),
        };
        companion.remember();
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

    /// The names of the numbers of the memory.
    pub fn memory_names(&self) -> Vec<String> {
        self.equations.memory_names()
    }

    /// Follows inputs, which may vary from now on.
    pub fn set_inputs(&mut self, values: &[f64], slopes: &[f64]) {
        if values != self.inputs.at(self.time) || slopes != self.inputs.slopes {
            self.here = None;
        }
        self.inputs = Driven { since: self.time, values: values.to_vec(), slopes: slopes.to_vec() };
    }

    /// Writes the slopes of the computed variables in a direction, of the values that belong to the present inputs; what has no
    /// slopes, as counters, stays 0.
    ///
    /// # Errors
    /// [`NoDerivative`] where there is none any more.
    pub fn outputs(&mut self, direction: usize, computed: &mut [f64]) -> Result<(), NoDerivative> {
        computed.fill(0.0);
        let at = (self.x.clone(), self.memory.clone(), self.slopes.clone(), self.here.clone());
        self.pass(vec![Act::Follow], true, None);
        let outcome = self.output_slopes(direction);
        (self.x, self.memory, self.slopes, self.here) = at;
        self.remember();
        for (slot, slope) in computed.iter_mut().zip(outcome?) {
            *slot = slope;
        }
        Ok(())
    }

    fn output_slopes(&mut self, direction: usize) -> Result<Vec<f64>, NoDerivative> {
        let slopes = &self.slopes[direction];
        if let Some(lost) = &slopes.lost {
            return Err(lost.clone());
        }
        let u = self.inputs.at(self.time);
        let at = At { time: self.time, x: &self.x, u: &u };
        let way = &self.ways[direction];
        let mut sum = self.equations.output_slopes(at, (&slopes.states, &way.inputs));
        let by_parameter = way.by_parameter(self.equations.as_ref(), |equations| equations.outputs(at));
        add(&mut sum, by_parameter);
        add(&mut sum, by_memory(self.spare.as_mut(), &self.memory, &slopes.memory, |equations| equations.outputs(at)));
        if sum.iter().any(|slope| slope.is_nan()) {
            let reason = "they depend on a number of the memory that has no slope".to_owned();
            return Err(NoDerivative { time: self.time, event: "the computed variables".to_owned(), reason });
        }
        Ok(sum)
    }

    /// Does what the run has done.
    pub fn follow(&mut self, marks: &[Mark]) {
        let mut rest = marks;
        while let [mark, others @ ..] = rest {
            rest = others;
            match mark {
                Mark::Begins(duration) => self.pass(vec![Act::Begin(*duration)], false, None),
                Mark::Follows => self.pass(vec![Act::Follow], true, None),
                Mark::Moves { time, end } => {
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

    /// Goes along a step.
    fn cross(&mut self, time: f64, end: &[f64]) {
        let start = self.time;
        let u = [start, time].map(|time| self.inputs.at(time));
        let rates = [
            self.equations.rates(At { time: start, x: &self.x, u: &u[0] }),
            self.equations.rates(At { time, x: end, u: &u[1] }),
        ];
        let path = Path { start, h: time - start, ends: [self.x.clone(), end.to_vec()], rates };
        let first = self.here.take().unwrap_or_else(|| self.node(&path, 0.0));
        let (middle, last) = (self.node(&path, 0.5), self.node(&path, 1.0));
        let mut columns: Vec<Vec<f64>> = self.slopes.iter().map(|slopes| slopes.states.clone()).collect();
        // Pieces that are left, the next one last, with the nodes in their middle and at their end.
        let mut pieces = vec![([0.0, 1.0], [middle, last.clone()])];
        let (mut here, mut is_solvable) = (first, true);
        while let Some(([from, to], [between, there])) = pieces.pop() {
            let (middle, length) = (0.5 * (from + to), (to - from) * path.h);
            let quarters = [0.25, 0.75].map(|share| self.node(&path, from + share * (to - from)));
            let weights = self.weights(&columns);
            let is_divisible = to - from > SMALLEST_PIECE;
            let is_smooth = !is_divisible
                || self.roughness([&here, &between, &there], &quarters, &columns, &weights) * length <= 1.0;
            let crossed = if is_smooth {
                let [one, other] = [[&here, &quarters[0], &between], [&between, &quarters[1], &there]]
                    .map(|nodes| Piece { parts: self.parts(nodes[0], 0.5 * length), nodes, length: 0.5 * length });
                one.cross(&columns, &weights).and_then(|columns| other.cross(&columns, &weights))
            } else {
                None
            };
            if let Some(crossed) = crossed {
                (columns, here) = (crossed, there);
            } else if is_divisible {
                let [before, behind] = quarters;
                pieces.push(([middle, to], [behind, there]));
                pieces.push(([from, middle], [before, between]));
            } else {
                is_solvable = false;
                break;
            }
        }
        let weights = self.weights(&columns);
        for ((slopes, column), weights) in self.slopes.iter_mut().zip(columns).zip(weights) {
            if !is_solvable && slopes.lost.is_none() {
                let reason = "its linear equations have no solution".to_owned();
                slopes.lost = Some(NoDerivative { time, event: "a step".to_owned(), reason });
            }
            slopes.states = column;
            slopes.peaks = weights.into_iter().map(|weight| weight / self.tolerance).collect();
        }
        (self.time, self.x) = (time, end.to_vec());
        self.here = Some(last);
    }

    /// Errors that states of slopes may have in a part of a step.
    fn weights(&self, columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let of = |(direction, column): (usize, &Vec<f64>)| {
            let (way, slopes) = (&self.ways[direction], &self.slopes[direction]);
            let weight = |i: usize| {
                let floor = NEGLIGIBLE * self.scales[i] / way.magnitude;
                self.tolerance * slopes.peaks.get(i).copied().unwrap_or_default().max(column[i].abs()).max(floor)
            };
            (0..column.len()).map(weight).collect()
        };
        columns.iter().enumerate().map(of).collect()
    }

    /// How much faster slopes change than parabolas through the linear equations tell, relative to weights: the rule of Boole,
    /// which looks at quarters, less that of Simpson.
    fn roughness(&self, nodes: [&Node; 3], quarters: &[Node; 2], columns: &[Vec<f64>], weights: &[Vec<f64>]) -> f64 {
        let n = self.x.len();
        let off = |[start, middle, end]: [f64; 3], [before, behind]: [f64; 2]| {
            (before + behind - 0.25 * (start + end) - 1.5 * middle) * (32.0 / 90.0)
        };
        let mut largest = 0.0f64;
        let jacobian: Vec<f64> = (0..n * n)
            .map(|place| off(nodes.map(|node| node.jacobian[place]), [0, 1].map(|side| quarters[side].jacobian[place])))
            .collect();
        for (direction, column) in columns.iter().enumerate() {
            for i in 0..n {
                let forcing = nodes.map(|node| node.forcing[direction][i]);
                let mut error = off(forcing, [0, 1].map(|side| quarters[side].forcing[direction][i]));
                error += (0..n).map(|j| jacobian[j * n + i] * column[j]).sum::<f64>();
                largest = largest.max(error.abs() / weights[direction][i]);
            }
        }
        largest
    }

    /// In how many parts a piece of a length in s is integrated.
    fn parts(&self, node: &Node, length: f64) -> u32 {
        if self.equations.led() != 2 {
            return 1;
        }
        let n = self.x.len();
        let entry = |i: usize, j: usize| node.jacobian[j * n + i];
        let (trace, product) = (entry(0, 0) + entry(1, 1), entry(0, 0) * entry(1, 1) - entry(0, 1) * entry(1, 0));
        let rate = product.abs().sqrt().max(0.5 * trace.abs());
        (length * rate / LED_PART).ceil().clamp(1.0, 1e4) as u32
    }

    /// The states at a fraction of a step.
    fn between(&self, path: &Path, fraction: f64) -> Vec<f64> {
        if fraction == 0.0 || fraction == 1.0 {
            return path.ends[usize::from(fraction == 1.0)].clone();
        }
        let mut x = path.at(fraction);
        if !self.inputs.vary() {
            // Such states change faster within a step than a cubic can tell.
            let at = At { time: path.start, x: &path.ends[0], u: &self.inputs.values };
            let led = self.equations.later(at, fraction * path.h).unwrap_or_default();
            x[..led.len()].copy_from_slice(&led);
        }
        x
    }

    /// The linear equations at a fraction of a step, with the present memory.
    fn node(&mut self, path: &Path, fraction: f64) -> Node {
        let time = if fraction == 0.0 { path.start } else { path.start + fraction * path.h };
        let (x, u) = (self.between(path, fraction), self.inputs.at(time));
        let jacobian = self.equations.jacobian(At { time, x: &x, u: &u });
        let forcing = (0..self.ways.len()).map(|direction| self.forcing(direction, At { time, x: &x, u: &u }));
        Node { jacobian, forcing: forcing.collect() }
    }

    /// What a direction does to the rates besides changing the states.
    fn forcing(&mut self, direction: usize, at: At) -> Vec<f64> {
        let (way, slopes) = (&self.ways[direction], &self.slopes[direction]);
        let mut forcing = vec![0.0; at.x.len()];
        if slopes.lost.is_some() {
            return forcing;
        }
        add(&mut forcing, way.by_parameter(self.equations.as_ref(), |equations| equations.rates(at)));
        let from_memory = by_memory(self.spare.as_mut(), &self.memory, &slopes.memory, |equations| equations.rates(at));
        if from_memory.as_ref().is_some_and(|slopes| slopes.iter().any(|slope| slope.is_nan())) {
            let reason = "they depend on a number of the memory that has no slope".to_owned();
            let lost = NoDerivative { time: at.time, event: "the equations".to_owned(), reason };
            self.slopes[direction].lost = Some(lost);
            return forcing;
        }
        add(&mut forcing, from_memory);
        if way.inputs.iter().any(|slope| *slope != 0.0) {
            let movement = Move { inputs: way.inputs.clone(), ..self.still() };
            let share = self.share(&movement, at.u, None);
            let [above, below] = [share, -share].map(|share| {
                let u = along(at.u, &way.inputs, share);
                self.equations.rates(At { u: &u, ..at })
            });
            add(&mut forcing, Some(slope_between(&above, &below, 2.0 * share)));
        }
        forcing
    }

    fn still(&self) -> Move {
        let [x, inputs, memory] = [self.x.len(), self.inputs.values.len(), self.memory.count()].map(|n| vec![0.0; n]);
        Move { time: 0.0, x, inputs, memory }
    }

    /// By how much of a movement to go to either side.
    fn share(&self, movement: &Move, u: &[f64], way: Option<&Way>) -> f64 {
        let mut most = way.filter(|way| way.beside.is_some()).map_or(f64::INFINITY, |way| way.magnitude);
        let mut limit = |magnitude: f64, speed: f64| {
            if speed != 0.0 && magnitude.is_finite() {
                most = most.min(magnitude / speed.abs());
            }
        };
        limit(TIME_SCALE, movement.time);
        movement.x.iter().enumerate().for_each(|(i, speed)| limit(self.scales[i].max(1e-3 * self.x[i].abs()), *speed));
        movement.inputs.iter().zip(u).for_each(|(speed, u)| limit(u.abs().max(1.0), *speed));
        // What the memory keeps for show alone, as the reading of a sensor, must not lead to steps that are lost in rounding.
        let least = if most.is_finite() { 1e-3 * most } else { 0.0 };
        for (leaf, speed) in movement.memory.iter().enumerate().filter(|(_, speed)| moves(**speed)) {
            let magnitude = magnitude(self.memory.value(leaf));
            most = most.min(if magnitude.is_finite() { magnitude / speed.abs() } else { f64::INFINITY });
        }
        let most = most.max(least);
        SHARE * if most.is_finite() { most } else { 1.0 }
    }

    /// The derivative of what an evaluation leads to from the present point along a movement, and of the parameter of a way if
    /// one is given. Numbers have magnitudes in which a kink counts.
    fn slope_of(
        &mut self,
        movement: &Move,
        way: Option<usize>,
        base: (&Outcome, &[f64]),
        evaluate: &dyn Fn(&mut dyn Equations, At) -> Outcome,
    ) -> Result<Vec<f64>, String> {
        let lacking = |slopes: &Vec<f64>| slopes.iter().filter(|slope| slope.is_nan()).count();
        match self.slope_within(movement, way, base, evaluate, 1.0) {
            Ok(slopes) if lacking(&slopes) == 0 => Ok(slopes),
            // There may be a kink nearby: nearer to the point, though with more rounding, there is none.
            far => match (far, self.slope_within(movement, way, base, evaluate, NEAR)) {
                (Ok(far), Ok(near)) if lacking(&far) <= lacking(&near) => Ok(far),
                (Ok(far), Err(_)) => Ok(far),
                (_, near) => near,
            },
        }
    }

    /// The same by points that are so near as a part of what [`share`](Self::share) says.
    fn slope_within(
        &mut self,
        movement: &Move,
        way: Option<usize>,
        (base, magnitudes): (&Outcome, &[f64]),
        evaluate: &dyn Fn(&mut dyn Equations, At) -> Outcome,
        part: f64,
    ) -> Result<Vec<f64>, String> {
        let u = self.inputs.at(self.time);
        let way = way.map(|way| &self.ways[way]).filter(|way| way.beside.is_some());
        let share = part * self.share(movement, &u, way);
        let (time, here_x, memory) = (self.time, &self.x, &self.memory);
        let spare = &mut self.spare;
        if movement.memory.iter().any(|slope| slope.is_nan()) {
            let mut unknown = Move { time: 0.0, x: Vec::new(), inputs: Vec::new(), memory: movement.memory.clone() };
            for (leaf, slope) in unknown.memory.iter_mut().enumerate() {
                *slope = if slope.is_nan() { SHARE * magnitude(memory.value(leaf)) } else { 0.0 };
            }
            spare.remember(&moved(memory, &unknown.memory, 1.0));
            let outcome = evaluate(spare.as_mut(), At { time, x: here_x, u: &u });
            let states = if base.form.is_some() { here_x.len() } else { base.numbers.len() };
            if outcome.numbers[..states] != base.numbers[..states] {
                return Err("it depends on a number of the memory that has no slope".to_owned());
            }
        }
        let mut side = |share: f64| -> Result<Outcome, String> {
            let mut built = match way.and_then(|way| way.beside.as_ref()) {
                Some(beside) => Some(beside(share).ok_or("there are no equations beside the present ones")?),
                None => None,
            };
            let equations = built.as_deref_mut().unwrap_or(spare.as_mut());
            equations.remember(&moved(memory, &movement.memory, share));
            let (x, u) = (along(here_x, &movement.x, share), along(&u, &movement.inputs, share));
            let outcome = evaluate(equations, At { time: time + share * movement.time, x: &x, u: &u });
            let is_alike = match (&outcome.form, &base.form) {
                (Some(one), Some(other)) => one.is_alike(other),
                _ => true,
            };
            if is_alike { Ok(outcome) } else { Err("what follows differs from one side of it to the other".to_owned()) }
        };
        let here = &base.numbers;
        if let Some(sign) = way.and_then(|way| way.one_sided) {
            let (near, far) = (side(sign * share)?, side(2.0 * sign * share)?);
            let copies = Copies::new(movement, [base, &near, &far]);
            let slope = |i: usize| {
                let [near, far] =
                    [&near, &far].map(|it| if it.numbers[i] == here[i] { 0.0 } else { it.numbers[i] - here[i] });
                copies.speed(i).unwrap_or(sign * (4.0 * near - far) / (2.0 * share))
            };
            return Ok((0..here.len()).map(slope).collect());
        }
        let (above, below) = (side(share)?, side(-share)?);
        let copies = Copies::new(movement, [base, &above, &below]);
        // Farther away, where rounding counts less, if nothing bends there.
        let wide =
            [1.0, -1.0, 0.5, -0.5].map(|multiple| side(multiple * WIDE * share).map(|outcome| outcome.numbers).ok());
        let difference = |[above, below]: [&[f64]; 2], i: usize, distance: f64| {
            if above[i] == below[i] { 0.0 } else { (above[i] - below[i]) / distance }
        };
        let slope = |i: usize| {
            if let Some(speed) = copies.speed(i) {
                return Ok(speed);
            }
            if let [Some(a), Some(b), Some(c), Some(d)] = &wide {
                let one = difference([a, b], i, 2.0 * WIDE * share);
                let half = difference([c, d], i, WIDE * share);
                if (one - half).abs() <= SMOOTH * half.abs() {
                    return Ok((4.0 * half - one) / 3.0);
                }
            }
            let [above, below] = [&above.numbers[..], &below.numbers];
            let (rise, fall) = (above[i] - here[i], here[i] - below[i]);
            let rounding = 64.0 * f64::EPSILON * (above[i].abs() + here[i].abs() + below[i].abs());
            let negligible = 1e-3 * SHARE * magnitudes.get(i).copied().unwrap_or_default();
            if (rise - fall).abs() > ROUGH * (rise + fall).abs() + rounding + negligible {
                // A number that is kept for show, as what a motion did last, may have none as long as nothing asks for it.
                let is_kept = base.form.is_some() && i >= here_x.len();
                return if is_kept { Ok(f64::NAN) } else { Err("its slopes to both sides differ".to_owned()) };
            }
            Ok(difference([above, below], i, 2.0 * share))
        };
        (0..here.len()).map(slope).collect()
    }

    /// An event happens: the later, the later its indicator comes to zero.
    fn happen(&mut self, event: usize, acts: Vec<Act>) {
        let (name, time, u) = (self.equations.event_name(event), self.time, self.inputs.at(self.time));
        let at = At { time, x: &self.x, u: &u };
        let indicators = self.equations.indicators(at);
        let base = Outcome::of(vec![indicators[event]]);
        let indicator = |equations: &mut dyn Equations, at: At| Outcome::of(vec![equations.indicators(at)[event]]);
        let nominal = self.nominals.get(event).copied().unwrap_or(1.0);
        let flow = Move { time: 1.0, x: self.equations.rates(at), inputs: self.inputs.slopes.clone(), ..self.still() };
        let rate = self.slope_of(&flow, None, (&base, &[nominal]), &indicator).map(|slopes| slopes[0]);
        let mut coincident = indicators.iter().enumerate().filter(|(other, value)| {
            *other != event && **value <= AT_LIMIT * self.nominals.get(*other).copied().unwrap_or(1.0)
        });
        let rate = match (rate, coincident.next()) {
            (Ok(rate), _) if rate.abs() < GRAZING * nominal => {
                Err(format!("the motion only grazes its limit, at {rate:e} of its unit per second"))
            }
            (Ok(_), Some((other, _))) => {
                Err(format!("{} happens at the same instant", self.equations.event_name(other)))
            }
            (rate, _) => rate,
        };
        let mut delays = Vec::with_capacity(self.ways.len());
        for direction in 0..self.ways.len() {
            let slopes = &self.slopes[direction];
            if slopes.lost.is_some() {
                delays.push(f64::NAN);
                continue;
            }
            let (x, inputs) = (slopes.states.clone(), self.ways[direction].inputs.clone());
            let movement = Move { time: 0.0, x, inputs, memory: slopes.memory.clone() };
            let delay = rate.clone().and_then(|rate| {
                let fall = self.slope_of(&movement, Some(direction), (&base, &[nominal]), &indicator)?[0];
                Ok(-fall / rate)
            });
            delays.push(self.or_lose(direction, delay, name));
        }
        let rate = rate.unwrap_or(f64::NAN);
        self.crossings.push(Crossing { time, event: name, rate, delays: delays.clone() });
        let ahead = if rate.is_finite() { BEHIND * nominal / rate.abs() } else { 0.0 };
        self.pass_ahead(acts, true, Some(&delays), ahead);
    }

    /// A number, or none and no derivative any more.
    fn or_lose(&mut self, direction: usize, number: Result<f64, String>, event: &str) -> f64 {
        number.unwrap_or_else(|reason| {
            self.slopes[direction].lost = Some(NoDerivative { time: self.time, event: event.to_owned(), reason });
            f64::NAN
        })
    }

    /// Takes a sample of a time in s: the later, the later it is due.
    fn sample(&mut self, due: f64) {
        let now = self.time;
        let base = Outcome::of(vec![self.equations.next_sample()]);
        let time = |equations: &mut dyn Equations, _: At| Outcome::of(vec![equations.next_sample()]);
        let mut delays = Vec::with_capacity(self.ways.len());
        for direction in 0..self.ways.len() {
            let (way, slopes) = (&self.ways[direction], &self.slopes[direction]);
            let movement = self.still().with_memory(&slopes.memory);
            let is_still = way.beside.is_none() && movement.memory.iter().all(|slope| *slope == 0.0);
            let delay = if is_still {
                Ok(0.0)
            } else {
                self.slope_of(&movement, Some(direction), (&base, &[TIME_SCALE]), &time).map(|slopes| slopes[0])
            };
            delays.push(self.or_lose(direction, delay, "a sample"));
        }
        let moves = delays.iter().any(|delay| *delay != 0.0);
        self.pass(vec![Act::Sample { due, now }], true, moves.then_some(&delays[..]));
    }

    /// Does something to states and memory, with what it sets off, at a time that moves with delays or stays.
    fn pass(&mut self, acts: Vec<Act>, settles: bool, delays: Option<&[f64]>) {
        self.pass_ahead(acts, settles, delays, 0.0);
    }

    /// The same; where it depends on being behind the limit of an event, a time in s later.
    fn pass_ahead(&mut self, mut acts: Vec<Act>, settles: bool, delays: Option<&[f64]>, ahead: f64) {
        let (time, u) = (self.time, self.inputs.at(self.time));
        let before = if delays.is_some() { self.equations.rates(At { time, x: &self.x, u: &u }) } else { Vec::new() };
        let mut x = self.x.clone();
        for act in &acts {
            self.equations.enact(*act, time, &mut x, &u);
        }
        for _ in 0..if settles { MAX_SWITCHES } else { 0 } {
            let indicators = self.equations.indicators(At { time, x: &x, u: &u });
            let Some(event) = indicators.iter().position(|value| *value < 0.0) else { break };
            self.equations.enact(Act::Switch(event), time, &mut x, &u);
            acts.push(Act::Switch(event));
        }
        let after = self.equations.memory();
        if delays.is_none() && x == self.x && after == self.memory {
            return;
        }
        let behind = if delays.is_some() { self.equations.rates(At { time, x: &x, u: &u }) } else { Vec::new() };
        let base = Outcome::landing(At { time, x: &self.x, u: &u }, &self.memory, &x, after.clone());
        let landing = |equations: &mut dyn Equations, at: At| {
            let (mut states, before) = (at.x.to_vec(), equations.memory());
            acts.iter().for_each(|act| equations.enact(*act, at.time, &mut states, at.u));
            Outcome::landing(at, &before, &states, equations.memory())
        };
        let (n, scales) = (x.len(), self.scales.clone());
        for direction in 0..self.ways.len() {
            if self.slopes[direction].lost.is_some() {
                continue;
            }
            let (way, slopes) = (&self.ways[direction], &self.slopes[direction]);
            let delay = delays.map_or(0.0, |delays| delays[direction]);
            let movement = Move {
                time: delay,
                x: along(&slopes.states, &before, delay),
                inputs: along(&way.inputs, &self.inputs.slopes, delay),
                memory: slopes.memory.clone(),
            };
            let mut landed = self.slope_of(&movement, Some(direction), (&base, &scales), &landing);
            if landed.is_err() && ahead > 0.0 {
                let later = along(&self.x, &before, ahead);
                let here = (std::mem::replace(&mut self.x, later), self.time);
                self.time += ahead;
                self.spare.remember(&self.memory);
                let at = At { time: self.time, x: &self.x, u: &u };
                let base = landing(self.spare.as_mut(), at);
                landed = self.slope_of(&movement, Some(direction), (&base, &scales), &landing);
                (self.x, self.time) = here;
            }
            let landed = landed.and_then(|slopes| {
                let is_finite =
                    slopes.iter().all(|slope| !slope.is_infinite()) && slopes[..n].iter().all(|slope| !slope.is_nan());
                if is_finite { Ok(slopes) } else { Err("a slope is infinite".to_owned()) }
            });
            match landed {
                Ok(landed) => {
                    let (states, memory) = (along(&landed[..n], &behind, -delay), landed[n..].to_vec());
                    let slopes = &mut self.slopes[direction];
                    (slopes.states, slopes.memory) = (states, memory);
                }
                Err(reason) => {
                    let event = self.describe(&acts);
                    self.slopes[direction].lost = Some(NoDerivative { time, event, reason });
                }
            }
        }
        for slopes in &mut self.slopes {
            slopes.memory.resize(after.count(), 0.0);
        }
        (self.x, self.memory, self.here) = (x, after, None);
        self.remember();
    }

    /// Lets all equations have the present memory.
    fn remember(&mut self) {
        self.equations.remember(&self.memory);
        for way in &mut self.ways {
            way.stencil.iter_mut().for_each(|(equations, _)| equations.remember(&self.memory));
        }
    }

    /// What is done, in words.
    fn describe(&self, acts: &[Act]) -> String {
        let words = acts.iter().filter_map(|act| match act {
            Act::Switch(event) => Some(self.equations.event_name(*event)),
            Act::Sample { .. } => Some("a sample"),
            _ => None,
        });
        let words: Vec<_> = words.collect();
        if words.is_empty() { "a change of the inputs or the end of a step".to_owned() } else { words.join(", then ") }
    }
}

impl Move {
    fn with_memory(self, memory: &[f64]) -> Self {
        Self { memory: memory.to_vec(), ..self }
    }
}

/// Numbers with others added.
fn add(sum: &mut [f64], others: Option<Vec<f64>>) {
    for (slot, other) in sum.iter_mut().zip(others.into_iter().flatten()) {
        *slot += other;
    }
}

/// Numbers moved by a share of slopes; all of them where there are no slopes.
fn along(numbers: &[f64], slopes: &[f64], share: f64) -> Vec<f64> {
    let mut moved = numbers.to_vec();
    moved.iter_mut().zip(slopes).for_each(|(number, slope)| *number += share * slope);
    moved
}

/// What becomes of numbers that are handed on as they are: they keep their slopes, without rounding.
struct Copies<'a> {
    /// The speeds of what they come from, by the bits it has at three points.
    speeds: HashMap<[u64; 3], f64>,
    own: Vec<f64>,
    points: [&'a Outcome; 3],
}

impl<'a> Copies<'a> {
    /// For what is evaluated at three points along a movement.
    fn new(movement: &Move, points: [&'a Outcome; 3]) -> Self {
        let own: Vec<f64> = [&movement.x, &movement.memory, &movement.inputs, &vec![movement.time]]
            .into_iter()
            .flatten()
            .copied()
            .collect();
        let mut speeds = HashMap::new();
        for (place, speed) in own.iter().enumerate().take(points[0].origin.len()) {
            speeds.entry(points.map(|it| it.origin[place].to_bits())).or_insert(*speed);
        }
        Self { speeds, own, points }
    }

    /// The slope of a number that is a copy.
    fn speed(&self, place: usize) -> Option<f64> {
        let bits = self.points.map(|it| it.numbers[place].to_bits());
        let is_own = |it: &Outcome| it.origin.get(place).map(|origin| origin.to_bits());
        if self.points.map(is_own) == bits.map(Some) {
            return self.own.get(place).copied();
        }
        self.speeds.get(&bits).copied()
    }
}

/// The derivative of numbers between two evaluations.
fn slope_between(above: &[f64], below: &[f64], distance: f64) -> Vec<f64> {
    above.iter().zip(below).map(|(above, below)| (above - below) / distance).collect()
}

/// Magnitude of a number of a memory: between a typical deflection and the scale of positions in m.
fn magnitude(value: f64) -> f64 {
    value.abs().clamp(1e-6, 1e-3)
}

/// Whether the slope of a number of a memory moves it; one that there is none of does not.
fn moves(slope: f64) -> bool {
    slope != 0.0 && !slope.is_nan()
}

/// The derivative of numbers along slopes of a memory, one number of it after the other; nothing if none varies.
fn by_memory(
    spare: &mut dyn Equations,
    memory: &Leaves,
    slopes: &[f64],
    evaluate: impl Fn(&dyn Equations) -> Vec<f64>,
) -> Option<Vec<f64>> {
    if slopes.iter().all(|slope| *slope == 0.0) {
        return None;
    }
    // As a rule nothing depends on what moves: one look with all of it moved at once.
    let here = |leaf: usize| memory.value(leaf);
    let step_of = |leaf: usize| SHARE * magnitude(here(leaf)) * (1.0 + 0.1 * (leaf % 7) as f64);
    spare.remember(memory);
    let present = evaluate(spare);
    spare.remember(&memory.with(|leaf| here(leaf) + if slopes[leaf] == 0.0 { 0.0 } else { step_of(leaf) }));
    if evaluate(spare) == present {
        return None;
    }
    let is_moving = |leaf: &usize| slopes[*leaf] != 0.0 && here(*leaf).is_finite();
    let moving: Vec<usize> = (0..slopes.len()).filter(is_moving).collect();
    // Halves on which something depends, until they are single numbers.
    let (mut halves, mut relevant) = (vec![&moving[..]], Vec::new());
    while let Some(half) = halves.pop() {
        let moved = |leaf: usize| here(leaf) + if half.contains(&leaf) { step_of(leaf) } else { 0.0 };
        spare.remember(&memory.with(moved));
        match half {
            [] => {}
            _ if evaluate(spare) == present => {}
            [leaf] => relevant.push(*leaf),
            _ => halves.extend([half.split_at(half.len() / 2).0, half.split_at(half.len() / 2).1]),
        }
    }
    if relevant.iter().any(|leaf| slopes[*leaf].is_nan()) {
        return Some(vec![f64::NAN; present.len()]);
    }
    let shares = relevant.iter().map(|leaf| SHARE * magnitude(here(*leaf)) / slopes[*leaf].abs());
    let share = shares.fold(f64::INFINITY, f64::min);
    let [above, below] = [share, -share].map(|share| {
        let moved = |leaf: usize| here(leaf) + if relevant.contains(&leaf) { share * slopes[leaf] } else { 0.0 };
        spare.remember(&memory.with(moved));
        evaluate(spare)
    });
    (!relevant.is_empty()).then(|| slope_between(&above, &below, 2.0 * share))
}

/// A memory whose numbers are moved by a share of slopes.
fn moved(memory: &Leaves, slopes: &[f64], share: f64) -> Leaves {
    let moved = |leaf: usize| memory.value(leaf) + if moves(slopes[leaf]) { share * slopes[leaf] } else { 0.0 };
    if slopes.iter().any(|slope| moves(*slope)) { memory.with(moved) } else { memory.clone() }
}
