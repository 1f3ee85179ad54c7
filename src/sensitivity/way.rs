//! Directions in which a run is differentiated.

use super::NoDerivative;
use super::bend::{EVEN, NEAR, is_bent};
use super::equations::Equations;
use super::leaves::Leaves;
use super::memory::SHARE;
use super::slopes::{Slopes, along, any, slope_between};

/// Equations whose parameter differs from the present one by an offset, if they exist.
pub type Beside = Box<dyn Fn(f64) -> Option<Box<dyn Equations>> + Send>;

/// Most equations beside the present ones that are kept.
const MOST_KEPT: usize = 64;

/// A direction in which a run is differentiated.
pub struct Way {
    /// The equations beside the present ones.
    beside: Option<Beside>,
    /// Those that have been built, with their offsets.
    built: Vec<(f64, Box<dyn Equations>)>,
    /// The present equations, with the parameter as it varies, where rates tell exactly how.
    pub(super) varied: Option<Box<dyn Equations>>,
    /// Magnitude of the parameter.
    pub(super) magnitude: f64,
    /// The side on which there are equations, where there are none on the other.
    pub(super) one_sided: Option<f64>,
    /// Equations beside the present ones, with their memory, and their weights in the derivative; the present ones have the rest, so that all
    /// weights add up to 0.
    stencil: Vec<(Box<dyn Equations>, f64)>,
    /// What is added to the inputs.
    pub(super) inputs: Vec<f64>,
    /// The present equations, with their memory, for inputs beside the present ones.
    of_inputs: Vec<Box<dyn Equations>>,
}

impl Way {
    /// One in which neither parameters nor inputs, of a number, change: that of a state.
    pub fn still(inputs: usize) -> Self {
        let (beside, varied, one_sided) = (None, None, None);
        let (built, stencil, inputs) = (Vec::new(), Vec::new(), vec![0.0; inputs]);
        Self { beside, built, varied, magnitude: 1.0, one_sided, stencil, inputs, of_inputs: Vec::new() }
    }

    /// The direction of an input among a number of them.
    pub fn of_input(place: usize, inputs: usize) -> Self {
        let mut way = Self::still(inputs);
        way.inputs[place] = 1.0;
        way
    }

    /// The direction of a parameter with a value, a magnitude and bounds, beside a number of inputs. Where the parameter may be
    /// only more or only less, for its bounds or for the other parameters, it is differentiated to that side; `None` if it may be
    /// neither.
    pub fn of_parameter(beside: Beside, [value, magnitude]: [f64; 2], bounds: [f64; 2], inputs: usize) -> Option<Self> {
        let offset = SHARE * magnitude;
        let is_legal = |sign: f64| (bounds[0]..=bounds[1]).contains(&(value + 2.0 * sign * offset));
        let near = |sign: f64| if is_legal(sign) { beside(sign * offset) } else { None };
        let far = |sign: f64| beside(2.0 * sign * offset);
        let (stencil, one_sided) = match [near(1.0), near(-1.0)] {
            [Some(above), Some(below)] => ([(above, 0.5), (below, -0.5)], None),
            [Some(above), None] => ([(above, 2.0), (far(1.0)?, -0.5)], Some(1.0)),
            [None, Some(below)] => ([(below, -2.0), (far(-1.0)?, 0.5)], Some(-1.0)),
            [None, None] => return None,
        };
        let stencil = stencil.into_iter().map(|(equations, weight)| (equations, weight / offset)).collect();
        Some(Self { beside: Some(beside), magnitude, one_sided, stencil, ..Self::still(inputs) })
    }

    /// The same with equations whose parameter varies, so that rates and computed variables need no others beside them.
    pub fn with_varied(self, varied: Option<Box<dyn Equations>>) -> Self {
        Self { varied, ..self }
    }

    /// Whether neither parameters nor inputs change.
    pub(super) fn is_still(&self) -> bool {
        self.beside.is_none() && !any(&self.inputs)
    }

    /// Whether there are equations beside the present ones: whether the direction is that of a parameter.
    pub(super) fn has_beside(&self) -> bool {
        self.beside.is_some()
    }

    /// The equations at an offset of the parameter, if they exist.
    pub(super) fn beside(&mut self, offset: f64) -> Option<&mut dyn Equations> {
        let place = match self.built.iter().position(|(built, _)| *built == offset) {
            Some(place) => place,
            None => {
                let equations = (self.beside.as_ref()?)(offset)?;
                if self.built.len() == MOST_KEPT {
                    self.built.clear();
                }
                self.built.push((offset, equations));
                self.built.len() - 1
            }
        };
        Some(self.built[place].1.as_mut())
    }

    /// Lets a direction of inputs look at what inputs beside the present ones do.
    pub(super) fn look_beside(&mut self, present: &dyn Equations) {
        if any(&self.inputs) {
            self.of_inputs = vec![present.twin(), present.twin()];
        }
    }

    /// All equations that have the memory of the present ones, with shares of the direction by which inputs are others.
    pub(super) fn alike(&mut self) -> impl Iterator<Item = (&mut Box<dyn Equations>, f64)> {
        let of_parameter = self.varied.iter_mut().chain(self.stencil.iter_mut().map(|(equations, _)| equations));
        of_parameter.map(|equations| (equations, 0.0)).chain(self.of_inputs.iter_mut().zip([SHARE, -SHARE]))
    }

    /// Lets them have the memory of others of the model.
    pub(super) fn adopt(&mut self, others: &dyn Equations) {
        self.alike().for_each(|(equations, _)| equations.adopt(others.held()));
    }

    /// The derivative of numbers by the parameter, with states, inputs and memory held; nothing if there is none, or if the
    /// equations [vary](Self::with_varied) themselves. Numbers with a non-smooth point within the difference, such as the force of
    /// an end stop whose place is the parameter, are differenced over a shorter distance, on one side of that point.
    pub(super) fn by_parameter(
        &mut self,
        present: &dyn Equations,
        evaluate: impl Fn(&dyn Equations) -> Vec<f64>,
    ) -> Option<Vec<f64>> {
        if self.varied.is_some() || self.stencil.is_empty() {
            return None;
        }
        if self.one_sided.is_some() {
            return self.by_difference(present, evaluate);
        }
        let (here, offset) = (evaluate(present), SHARE * self.magnitude);
        let [mut above, mut below] = [0, 1].map(|side| evaluate(self.stencil[side].0.as_ref()));
        let mut slopes = slope_between(&above, &below, 2.0 * offset);
        let mut bent: Vec<usize> = (0..here.len()).collect();
        for part in [NEAR, NEAR * NEAR] {
            bent.retain(|i| is_bent([below[*i], here[*i], above[*i]], EVEN, 0.0));
            if bent.is_empty() {
                break;
            }
            let mut side = |share: f64| {
                let equations = self.beside(share * offset)?;
                equations.adopt(present.held());
                Some(evaluate(equations))
            };
            (above, below) = (side(part)?, side(-part)?);
            let nearer = slope_between(&above, &below, 2.0 * part * offset);
            bent.iter().for_each(|i| slopes[*i] = nearer[*i]);
        }
        Some(slopes)
    }

    fn by_difference(
        &self,
        present: &dyn Equations,
        evaluate: impl Fn(&dyn Equations) -> Vec<f64>,
    ) -> Option<Vec<f64>> {
        let [(one, weight), (other, other_weight)] = &self.stencil[..] else { return None };
        let (mut slopes, others) = (evaluate(one.as_ref()), evaluate(other.as_ref()));
        // To one side, what all have in common must not be lost in rounding.
        let common = if self.one_sided.is_some() { evaluate(present) } else { vec![0.0; slopes.len()] };
        for ((slope, other), common) in slopes.iter_mut().zip(others).zip(common) {
            *slope = weight * (*slope - common) + other_weight * (other - common);
        }
        Some(slopes)
    }

    /// The slopes with which a run starts under inputs, to which the direction may add.
    pub fn slopes_of_start(&self, present: &dyn Equations, inputs: &[f64]) -> Slopes {
        let (x, base) = present.start(inputs);
        let offsets = self.inputs.iter().zip(inputs).filter(|(slope, _)| **slope != 0.0);
        let offset = offsets.fold(f64::INFINITY, |least, (_, input)| least.min(SHARE * input.abs().max(1.0)));
        // Equations and inputs beside the present ones.
        let mut beside: Vec<(&dyn Equations, Vec<f64>)> =
            self.stencil.iter().map(|(equations, _)| (equations.as_ref(), inputs.to_vec())).collect();
        if offset.is_finite() {
            beside.extend([1.0, -1.0].map(|sign| (present, along(inputs, &self.inputs, sign * offset))));
        }
        let still = Slopes::new(vec![0.0; x.len()], vec![0.0; base.count()]);
        // A side or direction is no number that varies: it must be the same.
        let sides: Vec<usize> =
            present.told().iter().enumerate().filter(|(_, leaf)| leaf.is_side).map(|(place, _)| place).collect();
        let is_alike = |memory: &Leaves| {
            memory.is_alike(&base) && sides.iter().all(|place| memory.value(*place) == base.value(*place))
        };
        if !beside.iter().all(|(equations, inputs)| is_alike(&equations.start(inputs).1)) {
            let reason = "the modes differ from one side of it to the other".to_owned();
            return Slopes { lost: Some(NoDerivative { time: 0.0, event: "the start".to_owned(), reason }), ..still };
        }
        let numbers = |equations: &dyn Equations, inputs: &[f64]| -> Vec<f64> {
            let (x, memory): (_, Leaves) = equations.start(inputs);
            // What never was, as the begin of a rest that always was, has no slope.
            let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
            x.into_iter().chain(memory.values().into_iter().map(finite)).collect()
        };
        let by_inputs = || match &beside[..] {
            [(_, above), (_, below)] => {
                Some(slope_between(&numbers(present, above), &numbers(present, below), 2.0 * offset))
            }
            _ => None,
        };
        let slopes = self.by_difference(present, |equations| numbers(equations, inputs)).or_else(by_inputs);
        let Some(slopes) = slopes else { return still };
        Slopes::new(slopes[..x.len()].to_vec(), slopes[x.len()..].to_vec())
    }
}
