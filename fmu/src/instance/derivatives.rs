//! Slopes of inputs, rates of outputs, directional and adjoint derivatives.

use super::layout::Base;
use super::record::Kind;
use super::{Instance, Scratch};
use crate::failure::Failure;
use pneumatic_servo::co_simulation::Direction;
use pneumatic_servo::variables::{Entry, Place, Role};

impl Instance {
    /// Slopes of inputs, with the orders of the derivatives, for the next step: all of them or, if one is refused, none.
    pub fn set_input_derivatives(
        &mut self,
        slopes: impl Iterator<Item = (u32, i32, f64)> + Clone,
    ) -> Result<(), Failure> {
        if self.record.kind == Kind::ModelExchange {
            return Err(Failure::error("in model exchange the host varies the inputs itself"));
        }
        for (reference, order, slope) in slopes.clone() {
            let slot = self.layout.typed(reference, Base::Real)?;
            let name = &slot.variable.name;
            if slot.variable.role != Role::Input {
                return Err(Failure::error(format!("{name} is no input")));
            }
            self.layout.check_kept(slot.variable)?;
            check_order(name, order)?;
            if !slope.is_finite() {
                return Err(Failure::error(format!("the derivative of {name} must be a finite number, not {slope}")));
            }
        }
        for (reference, _, slope) in slopes {
            if let Place::Input(place) = self.layout.typed(reference, Base::Real)?.place {
                self.record.slopes[place] = slope;
            }
        }
        self.run.inputs_changed();
        Ok(())
    }

    /// Rates of outputs, given with the orders of the derivatives, along the solution with the present inputs, which are
    /// held unless they have been given slopes for the next step.
    pub fn output_derivatives(&mut self, outputs: impl Iterator<Item = (u32, i32)>) -> Result<&[f64], Failure> {
        self.run.rates(&self.layout, &self.record, &mut self.scratch.computed)?;
        self.scratch.answers.clear();
        for (reference, order) in outputs {
            let slot = self.layout.typed(reference, Base::Real)?;
            if slot.variable.role != Role::Output {
                return Err(Failure::error(format!("{} is no output", slot.variable.name)));
            }
            check_order(&slot.variable.name, order)?;
            let value = self.derivative(&slot)?;
            self.scratch.answers.push(value);
        }
        Ok(&self.scratch.answers)
    }

    /// Derivatives of computed reals in the direction that seeds of knowns give: of time, inputs, continuous states and
    /// tunable parameters.
    ///
    /// Each is a partial derivative: what is no known stays, so that with time the inputs and states do not move, and with
    /// a parameter neither the states nor what laws remember.
    pub fn directional_derivative(
        &mut self,
        unknowns: impl Iterator<Item = u32>,
        seeds: impl Iterator<Item = (u32, f64)>,
    ) -> Result<&[f64], Failure> {
        self.clear_direction();
        for (known, seed) in seeds {
            self.add_to_direction(known, seed)?;
        }
        self.differentiate()?;
        self.scratch.answers.clear();
        for unknown in unknowns {
            let slot = self.layout.typed(unknown, Base::Real)?;
            let value = self.derivative(&slot)?;
            self.scratch.answers.push(value);
        }
        Ok(&self.scratch.answers)
    }

    /// Derivatives of a sum of computed reals, each times its seed, with respect to knowns: time, inputs, continuous
    /// states and tunable parameters. The derivatives of all computed variables are taken in the direction of each known,
    /// so that what is found differs from directional derivatives by the rounding of the sum alone.
    pub fn adjoint_derivative(
        &mut self,
        seeds: impl Iterator<Item = (u32, f64)> + Clone,
        knowns: impl Iterator<Item = u32>,
    ) -> Result<&[f64], Failure> {
        for (unknown, seed) in seeds.clone() {
            let slot = self.layout.typed(unknown, Base::Real)?;
            check_seed(&slot, seed)?;
            computed_place(&slot)?;
        }
        self.scratch.answers.clear();
        for known in knowns {
            self.clear_direction();
            self.add_to_direction(known, 1.0)?;
            self.differentiate()?;
            let mut sum = 0.0;
            for (unknown, seed) in seeds.clone() {
                sum += seed * self.derivative(&self.layout.typed(unknown, Base::Real)?)?;
            }
            if !f64::is_finite(sum) {
                let name = &self.layout.typed(known, Base::Real)?.variable.name;
                return Err(Failure::error(format!("the derivative with respect to {name} is not finite but {sum}")));
            }
            self.scratch.answers.push(sum);
        }
        Ok(&self.scratch.answers)
    }

    fn clear_direction(&mut self) {
        self.scratch.time = 0.0;
        self.scratch.inputs.fill(0.0);
        self.scratch.states.fill(0.0);
        self.scratch.slopes.fill(0.0);
    }

    fn add_to_direction(&mut self, known: u32, seed: f64) -> Result<(), Failure> {
        let slot = self.layout.typed(known, Base::Real)?;
        check_seed(&slot, seed)?;
        match (slot.place, slot.state) {
            (Place::Time, _) => self.scratch.time += seed,
            (Place::Input(place), _) => self.scratch.inputs[place] += seed,
            (Place::Parameter(place), _) if slot.variable.role == Role::Tunable => self.scratch.slopes[place] += seed,
            (_, Some(place)) => self.scratch.states[place] += seed,
            _ => {
                let (name, knowns) = (&slot.variable.name, "time, inputs, continuous states and tunable parameters");
                return Err(Failure::error(format!("{name} is no known of derivatives: those are {knowns}")));
            }
        }
        Ok(())
    }

    /// Differentiates all computed variables in the direction.
    fn differentiate(&mut self) -> Result<(), Failure> {
        let Scratch { time, inputs, states, slopes, computed, .. } = &mut self.scratch;
        let direction = Direction { time: *time, inputs, states, parameters: slopes };
        self.run.directional_derivative(&self.layout, &self.record, direction, computed)
    }

    /// The derivative of a computed variable, if it is a number.
    fn derivative(&self, slot: &Entry) -> Result<f64, Failure> {
        let value = self.scratch.computed[computed_place(slot)?];
        if !value.is_finite() {
            let name = &slot.variable.name;
            return Err(Failure::error(format!("the derivative of {name} is not a finite number but {value}")));
        }
        Ok(value)
    }
}

fn check_seed(slot: &Entry, seed: f64) -> Result<(), Failure> {
    if seed.is_finite() {
        return Ok(());
    }
    let name = &slot.variable.name;
    Err(Failure::error(format!("the seed of {name} must be a finite number, not {seed}")))
}

fn computed_place(slot: &Entry) -> Result<usize, Failure> {
    match slot.place {
        Place::Computed(place) => Ok(place),
        _ => Err(Failure::error(format!("{} is not computed and so no unknown", slot.variable.name))),
    }
}

fn check_order(name: &str, order: i32) -> Result<(), Failure> {
    if order == 1 {
        return Ok(());
    }
    Err(Failure::error(format!("derivative of order {order} of {name}: only order 1 is supported")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::testing::{self, HIGH, INPUT, LAG, OUTPUT, RATE, STATE, SUPPLY, TRAP};

    fn initialized() -> Instance {
        let mut instance = testing::instance();
        instance.enter_initialization_mode().expect("initialization");
        instance.exit_initialization_mode().expect("initialized");
        instance
    }

    fn direction(instance: &mut Instance, knowns: &[u32], seeds: &[f64]) -> Result<Vec<f64>, Failure> {
        let unknowns = [STATE, RATE, OUTPUT];
        let seeds = knowns.iter().copied().zip(seeds.iter().copied());
        Ok(instance.directional_derivative(unknowns.into_iter(), seeds)?.to_vec())
    }

    #[test]
    fn directional_derivative_is_linear_in_inputs_states_and_tunable_parameters() {
        let mut instance = initialized();
        assert_eq!(direction(&mut instance, &[INPUT], &[1.0]), Ok(vec![0.0, 2.0, 2.0]));
        assert_eq!(direction(&mut instance, &[STATE], &[1.0]), Ok(vec![1.0, -2.0, 1.0]));
        assert_eq!(direction(&mut instance, &[STATE, SUPPLY, INPUT], &[2.0, 3.0, 0.5]), Ok(vec![2.0, -3.0, 6.0]));
        assert_eq!(direction(&mut instance, &[INPUT, INPUT], &[1.0, 1.0]), Ok(vec![0.0, 4.0, 4.0]));
        assert_eq!(direction(&mut instance, &[HIGH, STATE], &[3.0, 1.0]), Ok(vec![1.0, -2.0, 4.0]));
        assert_eq!(direction(&mut instance, &[], &[]), Ok(vec![0.0; 3]));
    }

    #[test]
    fn directional_derivative_is_available_during_initialization() {
        let mut instance = testing::instance();
        instance.enter_initialization_mode().expect("initialization");
        assert_eq!(direction(&mut instance, &[INPUT], &[1.0]), Ok(vec![0.0, 2.0, 2.0]));
    }

    #[test]
    fn directional_derivative_refuses_what_is_no_known_or_unknown() {
        let mut instance = initialized();
        for (known, seed) in [(LAG, 1.0), (OUTPUT, 1.0), (RATE, 1.0), (TRAP, 1.0), (999, 1.0), (INPUT, f64::NAN)] {
            assert!(direction(&mut instance, &[known], &[seed]).is_err(), "{known}");
        }
        for unknown in [INPUT, LAG, 0, TRAP, 999] {
            let refused = instance.directional_derivative([unknown].into_iter(), [(INPUT, 1.0)].into_iter());
            assert!(refused.is_err(), "{unknown}");
        }
    }

    #[test]
    fn output_derivatives_include_the_slopes_of_the_next_step() {
        let mut instance = initialized();
        let outputs = [(STATE, 1), (OUTPUT, 1)];
        assert_eq!(instance.output_derivatives(outputs.into_iter()), Ok(&[2.0, 2.0][..]));
        instance.set_input_derivatives([(INPUT, 1, 3.0)].into_iter()).expect("legal");
        assert_eq!(instance.output_derivatives(outputs.into_iter()), Ok(&[2.0, 8.0][..]));
    }

    #[test]
    fn output_derivatives_are_of_order_one_of_real_outputs() {
        let mut instance = initialized();
        for (reference, order) in [(STATE, 0), (STATE, 2), (STATE, -1), (RATE, 1), (INPUT, 1), (TRAP, 1), (999, 1)] {
            let refused = instance.output_derivatives([(STATE, 1), (reference, order)].into_iter());
            assert!(refused.is_err(), "{reference} {order}");
        }
    }

    #[test]
    fn input_derivatives_are_of_order_one_of_inputs_and_all_or_none() {
        let mut instance = initialized();
        let cases = [
            (INPUT, 0, 1.0),
            (INPUT, 2, 1.0),
            (INPUT, 1, f64::NAN),
            (INPUT, 1, f64::INFINITY),
            (STATE, 1, 1.0),
            (LAG, 1, 1.0),
            (999, 1, 1.0),
        ];
        for (reference, order, value) in cases {
            let set = instance.set_input_derivatives([(SUPPLY, 1, 5.0), (reference, order, value)].into_iter());
            assert!(set.is_err(), "{reference} {order} {value}");
        }
        instance.do_step(0.0, 0.1).expect("a step without slopes");
        assert_eq!(testing::real(&mut instance, SUPPLY), Ok(0.0));
    }
}
