//! Which function may be called when: one table, checked in one place.

use serde::{Deserialize, Serialize};

use super::failure::Failure;

/// The states of an instance.
///
/// A call that returns `fmi2Error` changes nothing, so no state of its own follows it. A step is never left in
/// progress or cancelled, because steps do not run asynchronously.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// After `fmi2Instantiate` and `fmi2Reset`.
    Instantiated,
    /// After `fmi2EnterInitializationMode`.
    Initialization,
    /// After `fmi2ExitInitializationMode` and every completed step.
    StepComplete,
    /// After `fmi2DoStep` returned `fmi2Discard`.
    StepFailed,
    /// After `fmi2Terminate`.
    Terminated,
    /// After an internal error.
    Fatal,
}

impl State {
    fn text(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization",
            Self::Initialization => "in initialization mode",
            Self::StepComplete => "between communication steps",
            Self::StepFailed => "after a step that could not be completed",
            Self::Terminated => "after fmi2Terminate",
            Self::Fatal => "after an internal error",
        }
    }
}

/// Describes a set of states to a user.
pub fn describe(states: &[State]) -> String {
    let texts: Vec<_> = states.iter().map(|state| state.text()).collect();
    texts.join(" or ")
}

macro_rules! calls {
    ($($call:ident $($state:ident)*;)*) => {
        /// A function of the interface that belongs to an instance.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs, reason = "they are named after the functions of the standard")]
        pub enum Call { $($call),* }

        impl Call {
            #[cfg(test)]
            const ALL: &[Self] = &[$(Self::$call),*];

            /// The name of the function.
            pub fn name(self) -> &'static str {
                match self { $(Self::$call => concat!("fmi2", stringify!($call))),* }
            }

            /// The states in which it may be called.
            pub fn states(self) -> &'static [State] {
                match self { $(Self::$call => &[$(State::$state),*]),* }
            }
        }
    };
}

// What may be set and read in a state depends on the variable as well: see `values`.
calls! {
    SetDebugLogging           Instantiated Initialization StepComplete StepFailed Terminated;
    FreeInstance              Instantiated Initialization StepComplete StepFailed Terminated Fatal;
    SetupExperiment           Instantiated;
    EnterInitializationMode   Instantiated;
    ExitInitializationMode    Initialization;
    Terminate                 StepComplete StepFailed;
    Reset                     Instantiated Initialization StepComplete StepFailed Terminated;
    GetReal                   Instantiated Initialization StepComplete StepFailed Terminated;
    GetInteger                Instantiated Initialization StepComplete StepFailed Terminated;
    GetBoolean                Instantiated Initialization StepComplete StepFailed Terminated;
    GetString                 Instantiated Initialization StepComplete StepFailed Terminated;
    SetReal                   Instantiated Initialization StepComplete;
    SetInteger                Instantiated Initialization StepComplete;
    SetBoolean                Instantiated Initialization StepComplete;
    SetString                 Instantiated Initialization StepComplete;
    GetFMUstate               Instantiated Initialization StepComplete StepFailed Terminated;
    SetFMUstate               Instantiated Initialization StepComplete StepFailed Terminated;
    FreeFMUstate              Instantiated Initialization StepComplete StepFailed Terminated;
    SerializedFMUstateSize    Instantiated Initialization StepComplete StepFailed Terminated;
    SerializeFMUstate         Instantiated Initialization StepComplete StepFailed Terminated;
    DeSerializeFMUstate       Instantiated Initialization StepComplete StepFailed Terminated;
    GetDirectionalDerivative  Initialization StepComplete StepFailed Terminated;
    SetRealInputDerivatives   Instantiated Initialization StepComplete;
    GetRealOutputDerivatives  StepComplete StepFailed Terminated;
    DoStep                    StepComplete;
    CancelStep                ;
    GetStatus                 StepComplete StepFailed Terminated;
    GetRealStatus             StepComplete StepFailed Terminated;
    GetIntegerStatus          StepComplete StepFailed Terminated;
    GetBooleanStatus          StepComplete StepFailed Terminated;
    GetStringStatus           StepComplete StepFailed Terminated;
}

impl Call {
    /// Refuses a call that is not allowed in a state.
    pub fn check(self, state: State) -> Result<(), Failure> {
        if self.states().contains(&state) {
            return Ok(());
        }
        if state == State::Fatal {
            return Err(Failure::fatal("the instance is lost after an internal error and can only be freed"));
        }
        if self.states().is_empty() {
            return Err(Failure::error("no step is ever pending, because steps do not run asynchronously"));
        }
        let allowed = describe(self.states());
        Err(Failure::error(format!("not allowed {}; it is allowed {allowed}", state.text())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi2::types::Status;

    const STATES: [State; 6] = [
        State::Instantiated,
        State::Initialization,
        State::StepComplete,
        State::StepFailed,
        State::Terminated,
        State::Fatal,
    ];

    #[test]
    fn refusal_says_when_the_call_is_allowed() {
        let failure = Call::SetupExperiment.check(State::StepComplete).expect_err("too late");
        assert_eq!(failure.message, "not allowed between communication steps; it is allowed before initialization");
        let failure = Call::CancelStep.check(State::StepComplete).expect_err("nothing to cancel");
        assert!(failure.message.contains("no step is ever pending"), "{failure:?}");
    }

    #[test]
    fn lost_instance_can_only_be_freed() {
        for call in Call::ALL {
            match call.check(State::Fatal) {
                Ok(()) => assert_eq!(*call, Call::FreeInstance),
                Err(failure) => assert_eq!(failure.status, Status::Fatal, "{}", call.name()),
            }
        }
    }

    #[test]
    fn check_follows_the_table() {
        for call in Call::ALL {
            for state in STATES {
                assert_eq!(call.check(state).is_ok(), call.states().contains(&state), "{} {state:?}", call.name());
            }
        }
    }
}
