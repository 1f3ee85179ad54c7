//! The derivative of what an evaluation leads to, along a movement of the point that it starts from.

use std::any::Any;

use super::bend::{EVEN, NEAR, ROUGH, is_bent};
use super::equations::{At, Equations};
use super::leaves::Leaves;
use super::memory::{SHARE, magnitude, moved, moves, shifted};
use super::slopes::{along, slope_between};
use super::way::Way;

/// How much farther to go where rounding counts, and by how much slopes may differ there between the whole and half the way.
const WIDE: f64 = 100.0;
const SMOOTH: f64 = 1e-4;
/// Time in s in which the equations change by themselves at the fastest.
pub(super) const TIME_SCALE: f64 = 1e-3;

/// How a point moves per unit of a direction.
#[derive(Clone, Debug)]
pub(super) struct Move {
    pub time: f64,
    pub x: Vec<f64>,
    pub inputs: Vec<f64>,
    pub memory: Vec<f64>,
}

/// Numbers that something leads to, and the form of the memory that some of them are in.
pub(super) struct Outcome {
    pub numbers: Vec<f64>,
    form: Option<Leaves>,
    /// The numbers that it came from.
    origin: Vec<f64>,
}

impl Outcome {
    pub fn of(number: f64) -> Self {
        Self::of_all(vec![number])
    }

    pub fn of_all(numbers: Vec<f64>) -> Self {
        Self { numbers, form: None, origin: Vec::new() }
    }

    /// States and memory that come from others at a time and under inputs.
    pub fn landing(at: At, memory: &Leaves, states: &[f64], form: Leaves) -> Self {
        let numbers = states.iter().copied().chain(form.values()).collect();
        let others = at.u.iter().copied().chain([at.time]);
        Self { numbers, form: Some(form), origin: at.x.iter().copied().chain(memory.values()).chain(others).collect() }
    }

    fn is_alike(&self, other: &Self) -> bool {
        match (&self.form, &other.form) {
            (Some(one), Some(other)) => one.is_alike(other),
            _ => true,
        }
    }
}

/// What leads from equations at a point to an outcome.
pub(super) type Evaluation<'a> = &'a dyn Fn(&mut dyn Equations, At) -> Outcome;

/// A point, and equations with which to go around it.
pub(super) struct Around<'a> {
    pub at: At<'a>,
    pub memory: &'a Leaves,
    /// The same as equations of the model hold it.
    pub held: &'a dyn Any,
    /// Magnitudes of the states.
    pub scales: &'a [f64],
    pub spare: &'a mut dyn Equations,
}

impl Around<'_> {
    /// The derivative of what an evaluation leads to along a movement, and of the parameter of a way if one is given. Numbers
    /// have magnitudes in which a kink counts.
    pub fn slope_of(
        &mut self,
        movement: &Move,
        mut way: Option<&mut Way>,
        base: (&Outcome, &[f64]),
        evaluate: Evaluation,
    ) -> Result<Vec<f64>, String> {
        let lacking = |slopes: &Vec<f64>| slopes.iter().filter(|slope| slope.is_nan()).count();
        match self.slope_within(movement, way.as_deref_mut(), base, evaluate, 1.0) {
            Ok(slopes) if lacking(&slopes) == 0 => Ok(slopes),
            // There may be a kink nearby: nearer to the point, though with more rounding, there is none.
            far => match (far, self.slope_within(movement, way.as_deref_mut(), base, evaluate, NEAR)) {
                (Ok(far), Ok(near)) if lacking(&far) <= lacking(&near) => Ok(far),
                (Ok(far), Err(_)) => Ok(far),
                // One indicator may bend just behind its limit: where a motion has reversed, for one.
                (_, Err(_)) if base.0.numbers.len() == 1 && base.0.form.is_none() => {
                    self.slope_within(movement, way, base, evaluate, NEAR * NEAR)
                }
                (_, near) => near,
            },
        }
    }

    /// The derivative of plain numbers, of which those at the point are known, along a movement: by the nearest points alone, and by
    /// nearer ones where they bend in between; with whether they bend at the point itself.
    pub fn plain_slope(
        &mut self,
        movement: &Move,
        way: Option<&mut Way>,
        here: &[f64],
        evaluate: &dyn Fn(&dyn Equations, At) -> Vec<f64>,
    ) -> Result<(Vec<f64>, bool), String> {
        let mut way = way.filter(|way| way.has_beside());
        let share = self.share(movement, way.as_deref());
        let one_sided = way.as_deref().and_then(|way| way.one_sided);
        let evaluate = |equations: &mut dyn Equations, at: At| Outcome::of_all(evaluate(equations, at));
        let base = Outcome::of_all(Vec::new());
        let mut side = |share: f64| self.side(movement, way.as_deref_mut(), &base, &evaluate, share);
        let Some(sign) = one_sided else {
            let mut slopes = Vec::new();
            for share in [1.0, NEAR, NEAR * NEAR].map(|part| part * share) {
                let [above, below] = both(&mut side, share)?;
                slopes = slope_between(&above.numbers, &below.numbers, 2.0 * share);
                if (0..here.len()).all(|i| !is_bent([below.numbers[i], here[i], above.numbers[i]], EVEN, 0.0)) {
                    return Ok((slopes, false));
                }
            }
            return Ok((slopes, true));
        };
        let (near, far) = (side(sign * share)?, side(2.0 * sign * share)?);
        let slope =
            |((near, far), here): ((&f64, &f64), &f64)| sign * (4.0 * (near - here) - (far - here)) / (2.0 * share);
        Ok((near.numbers.iter().zip(&far.numbers).zip(here).map(slope).collect(), false))
    }

    /// Whether what an evaluation leads to rises otherwise to one side along a movement than to the other, however near.
    pub fn bends(&mut self, movement: &Move, base: &Outcome, evaluate: Evaluation) -> bool {
        let share = self.share(movement, None);
        [1.0, NEAR].into_iter().all(|part| {
            let sides = both(|share| self.side(movement, None, base, evaluate, share), part * share);
            let Ok([above, below]) = sides else { return true };
            let three = |i: usize| [below.numbers[i], base.numbers[i], above.numbers[i]];
            (0..base.numbers.len()).any(|i| is_bent(three(i), ROUGH, 0.0))
        })
    }

    /// The slopes of a number along a movement, and of the parameter of a way if one is given: below the point, where it is
    /// known, and above it, with the distance of the points.
    pub fn sides_of(
        &mut self,
        movement: &Move,
        way: Option<&mut Way>,
        here: f64,
        evaluate: Evaluation,
    ) -> Result<([f64; 2], f64), String> {
        let mut way = way.filter(|way| way.has_beside());
        if way.as_deref().is_some_and(|way| way.one_sided.is_some()) {
            return Err("its parameter is at a limit".to_owned());
        }
        let (share, base) = (self.share(movement, way.as_deref()), Outcome::of(here));
        let [above, below] = both(|share| self.side(movement, way.as_deref_mut(), &base, evaluate, share), share)?
            .map(|it| it.numbers[0]);
        Ok(([(here - below) / share, (above - here) / share], share))
    }

    /// By how much of a movement to go to either side.
    fn share(&self, movement: &Move, way: Option<&Way>) -> f64 {
        let mut most = way.map_or(f64::INFINITY, |way| way.magnitude);
        let mut limit = |magnitude: f64, speed: f64| {
            if speed != 0.0 && magnitude.is_finite() {
                most = most.min(magnitude / speed.abs());
            }
        };
        limit(TIME_SCALE, movement.time);
        for ((x, scale), speed) in self.at.x.iter().zip(self.scales).zip(&movement.x) {
            limit(scale.max(1e-3 * x.abs()), *speed);
        }
        movement.inputs.iter().zip(self.at.u).for_each(|(speed, u)| limit(u.abs().max(1.0), *speed));
        // What the memory keeps for show alone, as the reading of a sensor, must not lead to steps that are lost in rounding.
        let least = if most.is_finite() { 1e-3 * most } else { 0.0 };
        for (leaf, speed) in movement.memory.iter().enumerate().filter(|(_, speed)| moves(**speed)) {
            let magnitude = magnitude(self.memory.value(leaf));
            most = most.min(if magnitude.is_finite() { magnitude / speed.abs() } else { f64::INFINITY });
        }
        let most = most.max(least);
        let Some(way) = way else { return SHARE * if most.is_finite() { most } else { 1.0 } };
        // By powers of two: equations beside the present ones serve many points then.
        SHARE * way.magnitude * power_of_two(most / way.magnitude)
    }

    /// What an evaluation leads to from a share of a movement.
    fn side(
        &mut self,
        movement: &Move,
        way: Option<&mut Way>,
        base: &Outcome,
        evaluate: Evaluation,
        share: f64,
    ) -> Result<Outcome, String> {
        let At { time, x, u } = self.at;
        let equations = match way {
            Some(way) => way.beside(share).ok_or("there are no equations beside the present ones")?,
            None => &mut *self.spare,
        };
        match movement.memory.iter().any(|slope| moves(*slope)) {
            true => equations.remember(&moved(self.memory, &movement.memory, share)),
            false => equations.adopt(self.held),
        }
        let (x, u) = (along(x, &movement.x, share), along(u, &movement.inputs, share));
        let outcome = evaluate(equations, At { time: time + share * movement.time, x: &x, u: &u });
        if outcome.is_alike(base) {
            Ok(outcome)
        } else {
            Err("what follows differs from one side of it to the other".to_owned())
        }
    }

    /// The same by points that are so near as a part of what [`share`](Self::share) says.
    fn slope_within(
        &mut self,
        movement: &Move,
        way: Option<&mut Way>,
        (base, magnitudes): (&Outcome, &[f64]),
        evaluate: Evaluation,
        part: f64,
    ) -> Result<Vec<f64>, String> {
        let mut way = way.filter(|way| way.has_beside());
        let share = part * self.share(movement, way.as_deref());
        let unknown = self.unknown(&movement.memory, base, evaluate)?;
        let here = &base.numbers;
        let one_sided = way.as_deref().and_then(|way| way.one_sided);
        let mut side = |share: f64| self.side(movement, way.as_deref_mut(), base, evaluate, share);
        if let Some(sign) = one_sided {
            let (near, far) = (side(sign * share)?, side(2.0 * sign * share)?);
            let copies = Copies::new(movement, [base, &near, &far]);
            let slope = |i: usize| {
                let [near, far] =
                    [&near, &far].map(|it| if it.numbers[i] == here[i] { 0.0 } else { it.numbers[i] - here[i] });
                copies.speed(i).unwrap_or(sign * (4.0 * near - far) / (2.0 * share))
            };
            return Ok((0..here.len()).map(|i| if unknown.contains(&i) { f64::NAN } else { slope(i) }).collect());
        }
        // First farther away, where rounding counts less: as a rule nothing bends there.
        let (mut slopes, rough) = match (both(&mut side, WIDE * share), both(&mut side, 0.5 * WIDE * share)) {
            (Ok(whole), Ok(half)) => wide_slopes(movement, (base, magnitudes), [&whole, &half], share),
            _ => (vec![0.0; here.len()], (0..here.len()).collect()),
        };
        unknown.iter().for_each(|i| slopes[*i] = f64::NAN);
        let rough: Vec<usize> = rough.into_iter().filter(|i| !unknown.contains(i)).collect();
        if rough.is_empty() {
            return Ok(slopes);
        }
        let [above, below] = both(&mut side, share)?;
        let copies = Copies::new(movement, [base, &above, &below]);
        for i in rough {
            if let Some(speed) = copies.speed(i) {
                slopes[i] = speed;
                continue;
            }
            let three = [below.numbers[i], here[i], above.numbers[i]];
            let magnitude = magnitudes.get(i).copied().unwrap_or_default() * (part / NEAR).min(1.0);
            slopes[i] = if !is_bent(three, ROUGH, magnitude) {
                difference([&above, &below], i, 2.0 * share)
            } else if base.form.is_some() && i >= movement.x.len() {
                // A number that is kept for show, as what a motion did last, may have none as long as nothing asks for it.
                f64::NAN
            } else {
                return Err("its slopes to both sides differ".to_owned());
            };
        }
        Ok(slopes)
    }

    /// The places of what depends on a number of the memory that has no slope, and has none either. They are in the memory.
    ///
    /// # Errors
    /// If anything else depends on one.
    fn unknown(&mut self, slopes: &[f64], base: &Outcome, evaluate: Evaluation) -> Result<Vec<usize>, String> {
        if !slopes.iter().any(|slope| slope.is_nan()) {
            return Ok(Vec::new());
        }
        self.spare.remember(&shifted(self.memory, SHARE, |leaf| slopes[leaf].is_nan()));
        let outcome = evaluate(self.spare, self.at);
        let states = if base.form.is_some() { self.at.x.len() } else { base.numbers.len() };
        if !outcome.is_alike(base) || outcome.numbers[..states] != base.numbers[..states] {
            return Err("it depends on a number of the memory that has no slope".to_owned());
        }
        let differs = |place: &usize| outcome.numbers[*place].to_bits() != base.numbers[*place].to_bits();
        Ok((states..base.numbers.len()).filter(differs).collect())
    }
}

/// The outcomes to both sides.
fn both(mut side: impl FnMut(f64) -> Result<Outcome, String>, share: f64) -> Result<[Outcome; 2], String> {
    Ok([side(share)?, side(-share)?])
}

/// The slopes between points farther away and half as far, and the places of those that bend in between.
fn wide_slopes(
    movement: &Move,
    (base, magnitudes): (&Outcome, &[f64]),
    [whole, half]: [&[Outcome; 2]; 2],
    share: f64,
) -> (Vec<f64>, Vec<usize>) {
    let copies = Copies::new(movement, [base, &whole[0], &whole[1]]);
    let mut rough = Vec::new();
    let slope = |i: usize| {
        copies.speed(i).unwrap_or_else(|| {
            let [above, below] = whole;
            let one = difference([above, below], i, 2.0 * WIDE * share);
            let [above, below] = half;
            let other = difference([above, below], i, WIDE * share);
            let three = [below.numbers[i], base.numbers[i], above.numbers[i]];
            let is_bent = is_bent(three, ROUGH, WIDE * magnitudes.get(i).copied().unwrap_or_default());
            if is_bent || (one - other).abs() > SMOOTH * other.abs() {
                rough.push(i);
            }
            (4.0 * other - one) / 3.0
        })
    };
    ((0..base.numbers.len()).map(slope).collect(), rough)
}

fn difference([above, below]: [&Outcome; 2], i: usize, distance: f64) -> f64 {
    let (above, below) = (above.numbers[i], below.numbers[i]);
    if above == below { 0.0 } else { (above - below) / distance }
}

/// The power of two at or below a positive number.
fn power_of_two(number: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff << 52;
    if number.is_normal() { f64::from_bits(number.to_bits() & EXPONENT) } else { 1.0 }
}

/// Numbers that are handed on as they are: they keep their slopes, without rounding.
struct Copies<'a> {
    /// The speeds of what they come from.
    speeds: Vec<f64>,
    /// Three points along the movement.
    points: [&'a Outcome; 3],
}

impl<'a> Copies<'a> {
    /// For what is evaluated at three points along a movement.
    fn new(movement: &Move, points: [&'a Outcome; 3]) -> Self {
        let parts = [&movement.x[..], &movement.memory, &movement.inputs, &[movement.time]];
        Self { speeds: parts.concat(), points }
    }

    /// The slope of a number that is a copy: first of what has been in its own place, then of any other.
    fn speed(&self, place: usize) -> Option<f64> {
        let is_from = |origin: usize| {
            self.points
                .iter()
                .all(|it| it.origin.get(origin).map(|it| it.to_bits()) == Some(it.numbers[place].to_bits()))
        };
        let mut others = 0..self.points[0].origin.len();
        let from = if is_from(place) { Some(place) } else { others.find(|origin| is_from(*origin)) };
        self.speeds.get(from?).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::{Around, Move, Outcome, power_of_two};
    use crate::model::Setup;
    use crate::models::position_controller;
    use crate::sensitivity::{Act, At, Equations, Way};

    /// A sample leaves the integral part of the one before in the command.
    #[test]
    fn numbers_that_follow_from_one_without_a_slope_have_none() {
        let plant = Setup::new(&position_controller::MODEL).start(0.0).expect("starts");
        let equations = plant.simulation().equations().expect("equations");
        let (memory, told) = (equations.memory(), equations.told());
        let names: Vec<String> = told.into_iter().map(|leaf| leaf.name).collect();
        let at = At { time: 0.0, x: &[], u: &[0.25, 0.0, 0.24, 0.0] };
        let sample = |equations: &mut dyn Equations, at: At| {
            let before = equations.memory();
            equations.enact(Act::Sample { due: 0.0, now: 0.0 }, at.time, &mut [], at.u);
            Outcome::landing(at, &before, &[], equations.memory())
        };
        let base = sample(equations.twin().as_mut(), at);
        let slope = |name: &String| if name == "integral" { f64::NAN } else { 0.0 };
        let movement =
            Move { time: 0.0, x: Vec::new(), inputs: vec![0.0; 4], memory: names.iter().map(slope).collect() };
        let mut spare = equations.twin();
        let mut around = Around { at, memory: &memory, held: equations.held(), scales: &[], spare: spare.as_mut() };
        let slopes = around.slope_of(&movement, None, (&base, &[]), &sample).expect("no states depend on it");
        for (name, slope) in names.iter().zip(slopes) {
            let follows = ["integral", "command", "effort"].contains(&name.as_str());
            assert!(if follows { slope.is_nan() } else { slope == 0.0 }, "{name}: {slope}");
        }
    }

    #[test]
    fn a_corner_bends_and_a_curve_does_not() {
        let plant = Setup::new(&position_controller::MODEL).start(0.0).expect("starts");
        let equations = plant.simulation().equations().expect("equations");
        let (memory, mut spare) = (equations.memory(), equations.twin());
        let mut bends = |x: f64, of: fn(f64) -> f64| {
            let at = At { time: 0.0, x: &[x], u: &[] };
            let evaluate = move |_: &mut dyn Equations, at: At| Outcome::of(of(at.x[0]));
            let still = vec![0.0; memory.count()];
            let movement = Move { time: 0.0, x: vec![1.0], inputs: Vec::new(), memory: still };
            let mut around =
                Around { at, memory: &memory, held: equations.held(), scales: &[1.0], spare: spare.as_mut() };
            around.bends(&movement, &Outcome::of(of(x)), &evaluate)
        };
        assert!(bends(0.0, f64::abs));
        // A corner 1e-6 away is met by the first look, to 1e-5 of the scale, and by the nearer one no more.
        assert!(!bends(1e-6, f64::abs) && !bends(1.0, f64::abs) && !bends(1.0, f64::exp));
    }

    /// Also where its parameter cannot be less, or more.
    #[test]
    fn slope_beside_a_bound_is_that_of_the_curve() {
        let plant = Setup::new(&position_controller::MODEL).start(0.0).expect("starts");
        let equations = plant.simulation().equations().expect("equations");
        let (memory, mut spare) = (equations.memory(), equations.twin());
        let at = At { time: 0.0, x: &[1.0], u: &[] };
        let evaluate = |_: &mut dyn Equations, at: At| Outcome::of(at.x[0].exp());
        for value in [0.0, 5.0, 10.0] {
            let beside = |_| Setup::new(&position_controller::MODEL).start(0.0).ok()?.simulation().equations();
            let mut way = Way::of_parameter(Box::new(beside), [value, 10.0], [0.0, 10.0], 0).expect("a range");
            let movement = Move { time: 0.0, x: vec![2.0], inputs: Vec::new(), memory: vec![0.0; memory.count()] };
            let mut around =
                Around { at, memory: &memory, held: equations.held(), scales: &[1.0], spare: spare.as_mut() };
            let base = Outcome::of(1f64.exp());
            let slope = around.slope_of(&movement, Some(&mut way), (&base, &[1.0]), &evaluate).expect("a slope")[0];
            assert!((slope - 2.0 * 1f64.exp()).abs() < 1e-7, "at {value}: {slope}");
        }
    }

    #[test]
    fn powers_of_two_are_at_or_below() {
        for (number, expected) in [(1.0, 1.0), (1.99, 1.0), (2.0, 2.0), (0.3, 0.25), (f64::INFINITY, 1.0), (0.0, 1.0)] {
            assert_eq!(power_of_two(number), expected, "{number}");
        }
    }
}
