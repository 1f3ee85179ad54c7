//! Directions in which a run is differentiated.

use super::NoDerivative;
use super::companion::{SHARE, Slopes};
use super::equations::Equations;
use super::leaves::Leaves;

/// Equations whose parameter differs from the present one by an offset, if they exist.
pub type Beside = Box<dyn Fn(f64) -> Option<Box<dyn Equations>> + Send>;

/// A direction in which a run is differentiated.
pub struct Way {
    /// The equations beside the present ones.
    pub(super) beside: Option<Beside>,
    /// Magnitude of the parameter.
    pub(super) magnitude: f64,
    /// The side on which there are equations, where there are none on the other.
    pub(super) one_sided: Option<f64>,
    /// Equations beside the present ones and their weights in the derivative; the present ones have the rest, so that all
    /// weights add up to 0.
    pub(super) stencil: Vec<(Box<dyn Equations>, f64)>,
    /// What is added to the inputs.
    pub(super) inputs: Vec<f64>,
}

impl Way {
    /// One in which neither parameters nor inputs, of a number, change: that of a state.
    pub fn still(inputs: usize) -> Self {
        Self { beside: None, magnitude: 1.0, one_sided: None, stencil: Vec::new(), inputs: vec![0.0; inputs] }
    }

    /// The direction of an input among a number of them.
    pub fn of_input(place: usize, inputs: usize) -> Self {
        let mut way = Self::still(inputs);
        way.inputs[place] = 1.0;
        way
    }

    /// The direction of a parameter with a value, a magnitude and bounds, beside a number of inputs; `None` if there are no
    /// equations beside the present ones.
    pub fn of_parameter(beside: Beside, [value, magnitude]: [f64; 2], bounds: [f64; 2], inputs: usize) -> Option<Self> {
        let offset = SHARE * magnitude;
        let is_legal = |sign: f64| (bounds[0]..=bounds[1]).contains(&(value + 2.0 * sign * offset));
        let (weights, one_sided) = match [is_legal(-1.0), is_legal(1.0)] {
            [true, true] => ([(1.0, 0.5), (-1.0, -0.5)], None),
            [false, true] => ([(1.0, 2.0), (2.0, -0.5)], Some(1.0)),
            [true, false] => ([(-1.0, -2.0), (-2.0, 0.5)], Some(-1.0)),
            [false, false] => return None,
        };
        let built = weights.into_iter().map(|(at, weight)| Some((beside(at * offset)?, weight / offset)));
        let stencil = built.collect::<Option<_>>()?;
        Some(Self { beside: Some(beside), magnitude, one_sided, stencil, inputs: vec![0.0; inputs] })
    }

    /// The derivative of numbers by the parameter, with states, inputs and memory held; nothing if none varies.
    pub(super) fn by_parameter(
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

    /// The slopes with which a run starts under inputs.
    pub fn slopes_of_start(&self, present: &dyn Equations, inputs: &[f64]) -> Slopes {
        let (x, base) = present.start(inputs);
        let is_alike = |equations: &dyn Equations| equations.start(inputs).1.is_alike(&base);
        let still = Slopes::new(vec![0.0; x.len()], vec![0.0; base.count()]);
        if !self.stencil.iter().all(|(beside, _)| is_alike(beside.as_ref())) {
            let reason = "the modes differ from one side of it to the other".to_owned();
            return Slopes { lost: Some(NoDerivative { time: 0.0, event: "the start".to_owned(), reason }), ..still };
        }
        let numbers = |equations: &dyn Equations| {
            let (x, memory): (_, Leaves) = equations.start(inputs);
            // What never was, as the begin of a rest that always was, has no slope.
            let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
            x.into_iter().chain(memory.values().into_iter().map(finite)).collect()
        };
        let Some(slopes) = self.by_parameter(present, numbers) else { return still };
        Slopes::new(slopes[..x.len()].to_vec(), slopes[x.len()..].to_vec())
    }
}
