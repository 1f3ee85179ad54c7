//! Communication steps and what is told about them.

use super::Instance;
use super::clock::end_of_step;
use super::record::{Kind, LastStep};
use crate::calls::Mode;
use crate::failure::Failure;

/// End of a step that has not failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Whether it has ended at an event, which is still to happen.
    pub event: bool,
    /// Whether it has ended before its end.
    pub is_early: bool,
}

impl Instance {
    /// Integrates to exactly `point + size`, or to the first event on the way if the host wants to react to events.
    pub fn do_step(&mut self, point: f64, size: f64) -> Result<Step, Failure> {
        let start = self.time();
        let stop = self.record.experiment.and_then(|experiment| experiment.stop);
        let end = end_of_step(start, point, size, stop)?;
        let is_varied = self.record.slopes.iter().any(|slope| *slope != 0.0);
        if is_varied {
            self.check_interpolated_inputs(end - start)?;
        }
        let outcome = match self.record.kind {
            Kind::HybridCoSimulation { returns_early: true } => {
                self.run.advance_to_event(&self.layout, &self.record, end)?
            }
            _ => self.run.advance(&self.layout, &self.record, end)?.map(|()| false),
        };
        let reached = self.time();
        if is_varied {
            self.keep_reached_inputs(reached - start);
        }
        let event = match outcome {
            Ok(event) => event,
            Err(error) => return Err(self.fail_step(reached, error.to_string())),
        };
        self.check_states().map_err(|failure| self.fail_step(start, failure.message))?;
        self.record.last_step = LastStep { failed: false, successful_until: reached };
        self.tell_notices()?;
        Ok(Step { event, is_early: reached < end })
    }

    /// Refuses states that are no numbers, by the name of a variable that shows it. Other computed values are worked
    /// out, and checked, when they are asked for.
    fn check_states(&mut self) -> Result<(), Failure> {
        if self.run.is_finite() {
            return Ok(());
        }
        self.check_computed()?;
        Err(Failure::error("a state is not a finite number"))
    }

    /// End of the last step, or of the initialization.
    pub fn last_step(&self) -> LastStep {
        self.record.last_step
    }

    /// Refuses slopes that lead an input out of its range; between its ends the input is in between.
    fn check_interpolated_inputs(&self, duration: f64) -> Result<(), Failure> {
        for (place, slope) in self.record.slopes.iter().enumerate() {
            if *slope != 0.0
                && let Some(variable) = self.layout.table.inputs().nth(place)
            {
                variable.check(self.record.inputs[place] + slope * duration)?;
            }
        }
        Ok(())
    }

    /// Lets inputs keep the values they have reached; their slopes hold for one step.
    fn keep_reached_inputs(&mut self, duration: f64) {
        for (input, slope) in self.record.inputs.iter_mut().zip(&mut self.record.slopes) {
            if *slope != 0.0 {
                *input += *slope * duration;
                *slope = 0.0;
                self.run.inputs_changed();
            }
        }
    }

    fn fail_step(&mut self, successful_until: f64, cause: String) -> Failure {
        self.record.last_step = LastStep { failed: true, successful_until };
        self.record.mode = Mode::StepFailed;
        Failure::discard(cause)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::Status;
    use crate::instance::layout::Base;
    use crate::instance::testing::{self, INPUT, STATE, STEPS, SUPPLY, TRAP, Trap};
    use pneumatic_servo::variables::Choice;

    fn initialized(trap: Trap) -> Instance {
        let mut instance = testing::instance();
        instance.set(Base::Integer, [(TRAP, f64::from(trap.id()))].into_iter()).expect("an item");
        instance.setup_experiment(None, 1.0, Some(3.0)).expect("legal");
        instance.enter_initialization_mode().expect("initialization");
        instance.exit_initialization_mode().expect("initialized");
        instance
    }

    fn read(instance: &mut Instance, base: Base, reference: u32) -> Result<f64, Failure> {
        Ok(instance.get(base, [reference].into_iter())?[0])
    }

    #[test]
    fn step_follows_the_closed_form() {
        let mut instance = initialized(Trap::Nothing);
        instance.do_step(1.0, 0.25).expect("a step");
        let state = read(&mut instance, Base::Real, STATE).expect("finite");
        assert!((state - (1.0 - (-0.5f64).exp())).abs() < 1e-15, "{state}");
        assert_eq!(instance.time(), 1.25);
        assert_eq!(instance.last_step().successful_until, 1.25);
    }

    #[test]
    fn slope_holds_for_one_step_and_the_input_keeps_what_it_reached() {
        let mut instance = initialized(Trap::Nothing);
        instance.set_input_derivatives([(INPUT, 1, 4.0)].into_iter()).expect("legal");
        instance.do_step(1.0, 0.5).expect("a step");
        // u = 1 + 4 t, lag 0.5: x = u - 2 + (0 - 1 + 2) e^(-2 t)
        let expected = 3.0 - 2.0 + (-1.0f64).exp();
        let state = read(&mut instance, Base::Real, STATE).expect("finite");
        assert!((state - expected).abs() < 1e-15, "{state}, not {expected}");
        assert_eq!(read(&mut instance, Base::Real, INPUT), Ok(3.0));
        instance.do_step(1.5, 0.5).expect("a step");
        assert_eq!(read(&mut instance, Base::Real, INPUT), Ok(3.0));
        let state = read(&mut instance, Base::Real, STATE).expect("finite");
        assert!((state - (3.0 + (expected - 3.0) * (-1.0f64).exp())).abs() < 1e-15, "{state}");
    }

    #[test]
    fn slope_out_of_the_range_of_an_input_is_refused_before_the_step() {
        let mut instance = initialized(Trap::Nothing);
        instance.set_input_derivatives([(SUPPLY, 1, -1.0)].into_iter()).expect("legal");
        let failure = instance.do_step(1.0, 0.5).expect_err("negative supply");
        assert_eq!((failure.status, instance.mode(), instance.time()), (Status::Error, Mode::StepComplete, 1.0));
        assert!(failure.message.starts_with("supply = -0.5 is refused"), "{failure:?}");
    }

    #[test]
    fn step_past_the_stop_time_changes_nothing() {
        let mut instance = initialized(Trap::Nothing);
        assert!(instance.do_step(1.0, 2.5).is_err());
        assert_eq!((instance.time(), read(&mut instance, Base::Integer, STEPS)), (1.0, Ok(0.0)));
        instance.do_step(1.0, 2.0).expect("to the stop time");
    }

    #[test]
    fn step_that_stops_halfway_is_discarded_with_its_time() {
        let mut instance = initialized(Trap::StopsHalfway);
        instance.set_input_derivatives([(INPUT, 1, 4.0)].into_iter()).expect("legal");
        let failure = instance.do_step(1.0, 0.5).expect_err("halfway");
        assert!(failure.status == Status::Discard && failure.message.contains("at t = 1.25 s"), "{failure:?}");
        assert_eq!(instance.mode(), Mode::StepFailed);
        assert!(instance.last_step().failed);
        assert_eq!(instance.last_step().successful_until, 1.25);
        assert_eq!(read(&mut instance, Base::Real, INPUT), Ok(2.0));
        instance.reset().expect("a reset");
        assert_eq!(instance.mode(), Mode::Instantiated);
    }

    #[test]
    fn step_to_values_that_are_no_numbers_is_discarded() {
        let mut instance = initialized(Trap::YieldsNan);
        let failure = instance.do_step(1.0, 0.5).expect_err("not a number");
        assert!(failure.status == Status::Discard && failure.message.contains("state is not a finite number"));
        assert_eq!(instance.last_step().successful_until, 1.0);
        let failure = read(&mut instance, Base::Real, STATE).expect_err("not a number");
        assert_eq!(failure.status, Status::Error);
        assert_eq!(read(&mut instance, Base::Real, INPUT), Ok(1.0));
    }

    #[test]
    fn failed_step_can_be_undone_by_a_saved_state() {
        let mut instance = initialized(Trap::StopsHalfway);
        let saved = instance.get_state(0).expect("a state");
        instance.do_step(1.0, 0.5).expect_err("halfway");
        instance.set_state(saved).expect("restored");
        assert_eq!((instance.mode(), instance.time()), (Mode::StepComplete, 1.0));
        assert!(!instance.last_step().failed);
    }
}
