//! The table of calls allowed in each mode, for all versions of the standard, checked in one place.

use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// The modes of an instance.
///
/// A call that is refused changes nothing, so no mode of its own follows it. A step is never left in progress or
/// cancelled, because steps do not run asynchronously.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// After instantiation and after a reset.
    Instantiated,
    /// While initial values are worked out.
    Initialization,
    /// After initialization and every completed step.
    StepComplete,
    /// After a step that could not be completed.
    StepFailed,
    /// At an event between communication steps, while the model is updated.
    StepEvent,
    /// At an event, while the model is updated: the solver is outside.
    Event,
    /// Between two events, while the importer's solver integrates.
    ContinuousTime,
    /// At the end of the run.
    Terminated,
    /// After an internal error.
    Fatal,
}

impl Mode {
    fn text(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization",
            Self::Initialization => "in initialization mode",
            Self::StepComplete => "between communication steps",
            Self::StepFailed => "after a step that could not be completed",
            Self::StepEvent => "in event mode between communication steps",
            Self::Event => "in event mode",
            Self::ContinuousTime => "in continuous-time mode",
            Self::Terminated => "after termination",
            Self::Fatal => "after an internal error",
        }
    }
}

/// Describes a set of modes to a user.
pub fn describe(modes: &[Mode]) -> String {
    let texts: Vec<_> = modes.iter().map(|mode| mode.text()).collect();
    texts.join(" or ")
}

macro_rules! calls {
    ($($(#[$doc:meta])* $call:ident $($mode:ident)*;)*) => {
        /// Requests to an instance, in every version of the standard.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Call { $($(#[$doc])* $call),* }

        impl Call {
            #[cfg(test)]
            const ALL: &[Self] = &[$(Self::$call),*];

            /// The modes in which it is allowed.
            pub fn modes(self) -> &'static [Mode] {
                match self { $(Self::$call => &[$(Mode::$mode),*]),* }
            }

            /// The same as bits in the places of the modes.
            fn bits(self) -> u16 {
                match self { $(Self::$call => 0 $(| 1 << Mode::$mode as u16)*),* }
            }
        }
    };
}

// Values that may be set and read in a mode depend on the variable as well: see `instance::values`. An instance sees the
// modes of co-simulation (steps) or of model exchange (continuous time), never both.
calls! {
    /// Choose what is logged.
    ChooseLog             Instantiated Initialization StepComplete StepFailed StepEvent Event ContinuousTime Terminated;
    /// Free the instance.
    Free                  Instantiated Initialization StepComplete StepFailed StepEvent Event ContinuousTime Terminated Fatal;
    /// Set start time, stop time and tolerance.
    SetUpExperiment       Instantiated;
    /// Enter initialization mode.
    EnterInitialization   Instantiated;
    /// Leave initialization mode.
    ExitInitialization    Initialization;
    /// End the run.
    Terminate             StepComplete StepFailed StepEvent Event ContinuousTime;
    /// Go back to the start values.
    Reset                 Instantiated Initialization StepComplete StepFailed StepEvent Event ContinuousTime Terminated;
    /// Read variables.
    Get                   Instantiated Initialization StepComplete StepFailed StepEvent Event ContinuousTime Terminated;
    /// Set variables.
    Set                   Instantiated Initialization StepComplete StepEvent Event ContinuousTime;
    /// Save, restore, free or serialise a state.
    UseState              Instantiated Initialization StepComplete StepFailed StepEvent Event ContinuousTime Terminated;
    /// Read directional or adjoint derivatives.
    Differentiate         Initialization StepComplete StepFailed StepEvent Event ContinuousTime Terminated;
    /// Ask how many states or indicators there are, or what a variable depends on.
    AskAboutModel         Instantiated Initialization StepComplete StepFailed StepEvent Event ContinuousTime Terminated;
    /// Set slopes of inputs.
    SetSlopes             Instantiated Initialization StepComplete;
    /// Read derivatives of outputs with respect to time.
    GetOutputRates        StepComplete StepFailed Terminated;
    /// Take a communication step.
    Step                  StepComplete;
    /// Cancel a step that is in progress.
    CancelStep            ;
    /// Ask how the last step ended.
    AskAboutStep          StepComplete StepFailed Terminated;
    /// Go on to an event, from one included.
    EnterEvent            Event ContinuousTime;
    /// Go on to an event, from steps or from continuous time.
    LeaveForEvent         StepComplete ContinuousTime;
    /// Update the discrete part of the model.
    Update                StepEvent Event;
    /// Go on to take steps.
    EnterSteps            StepEvent;
    /// Go on to integrate.
    EnterContinuousTime   Event;
    /// Accept a step of the importer's solver.
    AcceptStep            ContinuousTime;
    /// Set the time.
    SetTime               Event ContinuousTime;
    /// Set the continuous states.
    SetStates             ContinuousTime;
    /// Read derivatives of continuous states.
    GetRates              Event ContinuousTime Terminated;
    /// Read continuous states or event indicators; in FMI 3.0 derivatives and magnitudes, too.
    GetStates             Initialization Event ContinuousTime Terminated;
    /// Read magnitudes of continuous states.
    GetMagnitudes         Instantiated Event ContinuousTime Terminated;
    /// Use what is not offered, which is refused with a reason.
    UseWhatIsNotOffered   Instantiated Initialization StepComplete StepFailed StepEvent Event ContinuousTime Terminated;
}

impl Call {
    /// Refuses a call that is not allowed in a mode.
    #[inline]
    pub fn check(self, mode: Mode) -> Result<(), Failure> {
        if self.bits() & 1 << mode as u16 == 0 { Err(self.refusal(mode)) } else { Ok(()) }
    }

    /// Why it is not allowed in a mode.
    #[cold]
    fn refusal(self, mode: Mode) -> Failure {
        if mode == Mode::Fatal {
            return Failure::fatal("the instance is lost after an internal error and can only be freed");
        }
        if self.modes().is_empty() {
            return Failure::error("no step is ever pending, because steps do not run asynchronously");
        }
        let allowed = describe(self.modes());
        Failure::error(format!("not allowed {}; it is allowed {allowed}", mode.text()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODES: [Mode; 9] = [
        Mode::Instantiated,
        Mode::Initialization,
        Mode::StepComplete,
        Mode::StepFailed,
        Mode::StepEvent,
        Mode::Event,
        Mode::ContinuousTime,
        Mode::Terminated,
        Mode::Fatal,
    ];

    #[test]
    fn refusal_says_when_the_call_is_allowed() {
        let failure = Call::SetUpExperiment.check(Mode::StepComplete).expect_err("too late");
        assert_eq!(failure.message, "not allowed between communication steps; it is allowed before initialization");
        let failure = Call::CancelStep.check(Mode::StepComplete).expect_err("nothing to cancel");
        assert!(failure.message.contains("no step is ever pending"), "{failure:?}");
    }

    #[test]
    fn lost_instance_can_only_be_freed() {
        for call in Call::ALL {
            match call.check(Mode::Fatal) {
                Ok(()) => assert_eq!(*call, Call::Free),
                Err(failure) => assert_eq!(failure, Failure::fatal(&*failure.message), "{call:?}"),
            }
        }
    }

    #[test]
    fn check_follows_the_table() {
        for call in Call::ALL {
            for mode in MODES {
                assert_eq!(call.check(mode).is_ok(), call.modes().contains(&mode), "{call:?} {mode:?}");
            }
        }
    }
}
