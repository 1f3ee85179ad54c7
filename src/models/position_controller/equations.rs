//! The controller as slopes are carried along it: its samples are all that happens.
//!
//! A sample is a formula within its limits, and has no derivative just at one: where the voltage, the wanted velocity or the
//! integral part comes to its limit, where the integral part begins to be held, and, without a `valve.transition`, where the
//! command is zero. When samples are taken is no question of slopes: they see the inputs of their communication point,
//! however near it is. So there are no equations with another sample time.

use std::any::Any;

use super::{Inputs, Kinks, Last, Outputs, Parameters};
use crate::numbers::Tangent;
use crate::sensitivity::{Act, At, Equations, Leaf, Leaves, Piece, read, told};

/// The control law, and what its last sample has left.
pub(super) struct Sampled {
    pub law: Parameters,
    pub last: Last,
}

impl Equations for Sampled {
    fn under(&self, parameters: &[f64], slopes: &[f64]) -> Option<Box<dyn Equations>> {
        let law = Parameters::checked(parameters, slopes).ok()?;
        (law.sample_time == self.law.sample_time).then(|| Box::new(Self { law, last: self.last.clone() }) as _)
    }

    fn states(&self) -> usize {
        0
    }

    fn scales(&self) -> Vec<f64> {
        Vec::new()
    }

    fn start(&self, u: &[f64]) -> (Vec<f64>, Leaves) {
        (Vec::new(), Leaves::of(&Last::none(&inputs(u))))
    }

    fn memory(&self) -> Leaves {
        Leaves::of(&self.last)
    }

    fn memory_like(&self, other: &Leaves) -> Leaves {
        Leaves::like(&self.last, other)
    }

    fn numbers(&self, numbers: &mut Vec<f64>) -> u64 {
        read(&self.last, numbers)
    }

    fn twin(&self) -> Box<dyn Equations> {
        Box::new(Self { law: self.law.clone(), last: self.last.clone() })
    }

    fn held(&self) -> &dyn Any {
        &self.last
    }

    fn adopt(&mut self, held: &dyn Any) {
        self.last.clone_from(held.downcast_ref().expect("a memory of this model"));
    }

    fn holds(&self, held: &dyn Any) -> bool {
        held.downcast_ref() == Some(&self.last)
    }

    fn rounded(&self) -> Vec<usize> {
        Vec::new()
    }

    fn remember(&mut self, memory: &Leaves) {
        self.last = memory.memory().expect("a memory of this model");
    }

    fn told(&self) -> Vec<Leaf> {
        told(&self.last)
    }

    fn rates(&self, _at: At) -> Vec<f64> {
        Vec::new()
    }

    fn jacobian(&self, _at: At) -> Vec<f64> {
        Vec::new()
    }

    fn rate_slopes(&self, _at: At, _direction: (&[f64], &[f64]), _slopes: &mut [f64]) {}

    fn cross(&self, _piece: &Piece, _columns: &[f64], _weights: &[f64]) -> Option<(Vec<f64>, u32)> {
        Some((Vec::new(), 1))
    }

    fn later(&self, _at: At, _step: f64) -> Option<Vec<f64>> {
        None
    }

    fn indicators(&self, _at: At) -> Vec<f64> {
        Vec::new()
    }

    fn enact(&mut self, act: Act, _time: f64, _x: &mut [f64], u: &[f64]) {
        if let Act::Sample { .. } = act {
            self.law.take(&std::array::from_fn(|i| u[i]), &mut self.last);
        }
    }

    fn sample_slopes(&self, [u, du]: [&[f64]; 2], memory: &[f64]) -> Option<Result<Vec<f64>, String>> {
        let mut last = self.last.along(memory);
        let input = Inputs::read(&std::array::from_fn(|i| Tangent::along_first(u[i], du[i])));
        let kinks = self.law.sample(&input, &mut last);
        Some(kinks.refuse().map(|()| last.numbers().map(|number| number.slope()).to_vec()))
    }

    fn shown_slopes(&self, memory: &[f64]) -> Option<Vec<f64>> {
        let mut shown = vec![Tangent::still(0.0); Outputs::<f64>::LEN];
        self.law.shown(&self.last.along(memory)).write(&mut shown);
        Some(shown.into_iter().map(|value| value.slope()).collect())
    }

    /// Always the same, so that nothing makes samples later.
    fn next_sample(&self) -> f64 {
        0.0
    }

    fn event_name(&self, _event: usize) -> &'static str {
        "a sample"
    }

    fn outputs(&self, _at: At) -> Vec<f64> {
        self.law.show(&self.last).to_vec()
    }

    /// Of neutral voltage, if that varies; the memory is still.
    fn output_slopes(&self, _at: At, _direction: (&[f64], &[f64])) -> Vec<f64> {
        self.shown_slopes(&[0.0; Last::LEN]).unwrap_or_default()
    }
}

impl Last {
    const LEN: usize = 6;

    /// The same with slopes, in the order of the fields.
    fn along(&self, slopes: &[f64]) -> Last<Tangent> {
        let numbers = self.numbers();
        let [reference, error, wanted, command, integral, effort] =
            std::array::from_fn(|i| Tangent::along_first(numbers[i], slopes[i]));
        Last { reference, error, wanted, command, integral, effort }
    }
}

impl<S: Copy> Last<S> {
    /// The numbers in the order of the fields.
    pub(super) fn numbers(&self) -> [S; Last::LEN] {
        let &Self { reference, error, wanted, command, integral, effort } = self;
        [reference, error, wanted, command, integral, effort]
    }
}

impl Kinks<Tangent> {
    /// Refuses a sample that is just where its formula changes, in a direction that leads away from there.
    fn refuse(self) -> Result<(), String> {
        let Self { wanted, command, voltage, lack, integral } = self;
        let named = [
            (wanted, "the wanted velocity just at its limit"),
            (command, "the command just at an end of the line across the dead zone"),
            (voltage, "the voltage just at an end of its range"),
            (lack, "no lack of velocity, with the voltage beyond its range"),
            (integral, "the integral part just at its limit"),
        ];
        match named.into_iter().find(|(left, _)| left.value == 0.0 && left.slope() != 0.0) {
            Some((_, what)) => Err(format!("it finds {what}")),
            None => Ok(()),
        }
    }
}

fn inputs(values: &[f64]) -> Inputs<f64> {
    Inputs::read(&std::array::from_fn(|i| values[i]))
}
