//! Slopes of inputs, rates of outputs, and directional derivatives.

use super::failure::Failure;
use super::instance::Instance;
use super::layout::Base;
use super::types::ValueReference;
use pneumatic_servo::variables::{Place, Role};

impl Instance {
    /// `fmi2SetRealInputDerivatives`: slopes for the next step.
    pub fn set_input_derivatives(
        &mut self,
        references: &[ValueReference],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), Failure> {
        for ((reference, order), value) in references.iter().zip(orders).zip(values) {
            let slot = self.layout.typed_slot(*reference, Base::Real)?;
            let name = &slot.variable.name;
            if slot.variable.role != Role::Input {
                return Err(Failure::error(format!("{name} is no input")));
            }
            check_order(name, *order)?;
            if !value.is_finite() {
                return Err(Failure::error(format!("the derivative of {name} must be a finite number, not {value}")));
            }
        }
        for (reference, value) in references.iter().zip(values) {
            if let Place::Input(place) = self.layout.typed_slot(*reference, Base::Real)?.place {
                self.record.slopes[place] = *value;
            }
        }
        self.run.inputs_changed();
        Ok(())
    }

    /// `fmi2GetRealOutputDerivatives`: rates along the solution with the present inputs, which are held unless they
    /// have been given slopes for the next step.
    pub fn output_derivatives(
        &mut self,
        references: &[ValueReference],
        orders: &[i32],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), Failure> {
        for (reference, order) in references.iter().zip(orders) {
            let variable = self.layout.typed_slot(*reference, Base::Real)?.variable;
            if variable.role != Role::Output {
                return Err(Failure::error(format!("{} is no output", variable.name)));
            }
            check_order(&variable.name, *order)?;
        }
        if references.is_empty() {
            return Ok(());
        }
        self.run.simulation(self.layout, &self.record)?.rates(&mut self.scratch.computed);
        self.hand_out(references, &mut write)
    }

    /// `fmi2GetDirectionalDerivative`: of computed reals in one direction of inputs and continuous states.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[ValueReference],
        knowns: &[ValueReference],
        seeds: &[f64],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), Failure> {
        for unknown in unknowns {
            let variable = self.layout.typed_slot(*unknown, Base::Real)?.variable;
            if !variable.is_computed() {
                return Err(Failure::error(format!("{} is not computed and so no unknown", variable.name)));
            }
        }
        self.scratch.inputs.fill(0.0);
        self.scratch.states.fill(0.0);
        for (known, seed) in knowns.iter().zip(seeds) {
            let slot = self.layout.typed_slot(*known, Base::Real)?;
            let name = &slot.variable.name;
            if !seed.is_finite() {
                return Err(Failure::error(format!("the seed of {name} must be a finite number, not {seed}")));
            }
            match (slot.place, slot.state) {
                (Place::Input(place), _) => self.scratch.inputs[place] += seed,
                (_, Some(place)) => self.scratch.states[place] += seed,
                _ => return Err(Failure::error(format!("{name} is neither an input nor a continuous state"))),
            }
        }
        let simulation = self.run.simulation(self.layout, &self.record)?;
        simulation.directional_derivative(&self.scratch.inputs, &self.scratch.states, &mut self.scratch.computed);
        self.hand_out(unknowns, &mut write)
    }

    /// Hands out derivatives of computed variables from the scratch, if all of them are numbers.
    fn hand_out(&self, references: &[ValueReference], write: &mut impl FnMut(usize, f64)) -> Result<(), Failure> {
        let derivative = |reference: ValueReference| match self.layout.typed_slot(reference, Base::Real)?.place {
            Place::Computed(place) => Ok((place, self.scratch.computed[place])),
            _ => Err(Failure::error(format!("value reference {reference} is not computed"))),
        };
        for reference in references {
            let (place, value) = derivative(*reference)?;
            if !value.is_finite() {
                let name = &self.layout.computed[place].name;
                return Err(Failure::error(format!("the derivative of {name} is not a finite number but {value}")));
            }
        }
        for (index, reference) in references.iter().enumerate() {
            write(index, derivative(*reference)?.1);
        }
        Ok(())
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
    use crate::fmi2::testing::{self, INPUT, LAG, OUTPUT, RATE, STATE, SUPPLY, TRAP};

    fn initialized() -> Instance {
        let mut instance = testing::instance();
        instance.enter_initialization_mode().expect("initialization");
        instance.exit_initialization_mode().expect("initialized");
        instance
    }

    fn direction(instance: &mut Instance, knowns: &[u32], seeds: &[f64]) -> Result<Vec<f64>, Failure> {
        let unknowns = [STATE, RATE, OUTPUT];
        let mut read = vec![f64::NAN; unknowns.len()];
        instance.directional_derivative(&unknowns, knowns, seeds, |index, value| read[index] = value)?;
        Ok(read)
    }

    #[test]
    fn directional_derivative_is_linear_in_inputs_and_states() {
        let mut instance = initialized();
        assert_eq!(direction(&mut instance, &[INPUT], &[1.0]), Ok(vec![0.0, 2.0, 2.0]));
        assert_eq!(direction(&mut instance, &[STATE], &[1.0]), Ok(vec![1.0, -2.0, 1.0]));
        assert_eq!(direction(&mut instance, &[STATE, SUPPLY, INPUT], &[2.0, 3.0, 0.5]), Ok(vec![2.0, -3.0, 6.0]));
        assert_eq!(direction(&mut instance, &[INPUT, INPUT], &[1.0, 1.0]), Ok(vec![0.0, 4.0, 4.0]));
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
        for (known, seed) in
            [(LAG, 1.0), (OUTPUT, 1.0), (RATE, 1.0), (0, 1.0), (TRAP, 1.0), (999, 1.0), (INPUT, f64::NAN)]
        {
            assert!(direction(&mut instance, &[known], &[seed]).is_err(), "{known}");
        }
        for unknown in [INPUT, LAG, 0, TRAP, 999] {
            let written = instance.directional_derivative(&[unknown], &[INPUT], &[1.0], |_, _| panic!("written"));
            assert!(written.is_err(), "{unknown}");
        }
    }

    #[test]
    fn output_derivatives_include_the_slopes_of_the_next_step() {
        let mut instance = initialized();
        let mut read = [f64::NAN; 2];
        instance.output_derivatives(&[STATE, OUTPUT], &[1, 1], |index, value| read[index] = value).expect("legal");
        assert_eq!(read, [2.0, 2.0]);
        instance.set_input_derivatives(&[INPUT], &[1], &[3.0]).expect("legal");
        instance.output_derivatives(&[STATE, OUTPUT], &[1, 1], |index, value| read[index] = value).expect("legal");
        assert_eq!(read, [2.0, 8.0]);
    }

    #[test]
    fn output_derivatives_are_of_order_one_of_real_outputs() {
        let mut instance = initialized();
        for (reference, order) in [(STATE, 0), (STATE, 2), (STATE, -1), (RATE, 1), (INPUT, 1), (TRAP, 1), (999, 1)] {
            let written = instance.output_derivatives(&[STATE, reference], &[1, order], |_, _| panic!("written"));
            assert!(written.is_err(), "{reference} {order}");
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
            let set = instance.set_input_derivatives(&[SUPPLY, reference], &[1, order], &[5.0, value]);
            assert!(set.is_err(), "{reference} {order} {value}");
        }
        instance.do_step(0.0, 0.1).expect("a step without slopes");
        let mut supply = f64::NAN;
        instance.get(Base::Real, &[SUPPLY], |_, value| supply = value).expect("readable");
        assert_eq!(supply, 0.0);
    }
}
