//! The one way into an instance: no panic leaves it, no call interrupts another, and the table of calls is obeyed.

use std::any::Any;
use std::ffi::CStr;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;

use super::calls::Call;
use super::failure::Failure;
use super::instance::Instance;
use super::layout::Layout;
use super::logging::{Log, Sink};
use super::registry;
use super::types::{CO_SIMULATION, Status};

/// An instance as the host holds it.
pub struct Handle(Mutex<Instance>);

impl Handle {
    /// Takes an instance.
    pub fn new(instance: Instance) -> Self {
        Self(Mutex::new(instance))
    }

    /// Carries out a call and logs why it fails.
    ///
    /// A call during another one of the same instance (from the host's logger, or from another thread) is refused
    /// with `fmi2Error`. It is not logged: the logger may be just what is running.
    pub fn call(&self, call: Call, body: impl FnOnce(&mut Instance) -> Result<(), Failure>) -> Status {
        let Ok(mut instance) = self.0.try_lock() else {
            return Status::Error;
        };
        // The instance may be half changed after a panic; it is never used again.
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            let result = call.check(instance.state()).and_then(|()| body(&mut instance));
            if let Err(failure) = &result {
                instance.log().failure(call.name(), failure);
            }
            result
        }));
        match outcome.unwrap_or_else(|panic| Err(instance.abandon(call.name(), cause(panic.as_ref())))) {
            Ok(()) => Status::Ok,
            Err(failure) => failure.status,
        }
    }
}

/// Makes an instance for `fmi2Instantiate`, or logs why not.
pub fn instantiate(
    name: Option<&CStr>,
    fmu_type: i32,
    guid: Option<&CStr>,
    sink: Sink,
    logging_on: bool,
) -> Option<Box<Handle>> {
    let log = Log::new(sink, logging_on);
    let choice = catch_unwind(|| choose(name, fmu_type, guid));
    match choice.unwrap_or_else(|panic| Err(Failure::fatal(cause(panic.as_ref())))) {
        Ok(layout) => Some(Box::new(Handle::new(Instance::new(layout, log)))),
        Err(failure) => {
            log.failure("fmi2Instantiate", &failure);
            None
        }
    }
}

fn choose(name: Option<&CStr>, fmu_type: i32, guid: Option<&CStr>) -> Result<&'static Layout, Failure> {
    if name.is_none_or(CStr::is_empty) {
        return Err(Failure::error("the instance name is missing"));
    }
    if fmu_type != CO_SIMULATION {
        return Err(Failure::error(format!("fmuType {fmu_type} is not fmi2CoSimulation, the only type offered")));
    }
    let guid = guid.ok_or_else(|| Failure::error("the GUID is missing"))?.to_string_lossy();
    registry::find(&guid).ok_or_else(|| {
        let list = registry::list();
        let hint = "modelDescription.xml and the library come from different builds";
        Failure::error(format!("the GUID {guid} is not that of a model in this library ({list}): {hint}"))
    })
}

/// The message of a panic.
fn cause(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("a panic without message")
}

#[cfg(test)]
mod tests {
    use std::ffi::CString;
    use std::sync::mpsc::{Receiver, channel};

    use super::*;
    use crate::fmi2::layout::Base;
    use crate::fmi2::testing::{self, INPUT, PANICS, STATE, TRAP};
    use pneumatic_servo::models;

    fn listening_sink() -> (Sink, Receiver<(Status, String)>) {
        let (sender, receiver) = channel();
        let sink = move |status, _: &CStr, text: &CStr| {
            sender.send((status, text.to_str().expect("UTF-8").to_owned())).expect("the receiver lives");
        };
        (Box::new(sink), receiver)
    }

    fn initialized(trap: i32) -> (Handle, Receiver<(Status, String)>) {
        let (sink, receiver) = listening_sink();
        let handle = Handle::new(Instance::new(testing::layout(), Log::new(sink, false)));
        let done = handle.call(Call::SetInteger, |it| it.set(Base::Integer, &[TRAP], |_| f64::from(trap)));
        assert_eq!(done, Status::Ok);
        assert_eq!(handle.call(Call::EnterInitializationMode, Instance::enter_initialization_mode), Status::Ok);
        assert_eq!(handle.call(Call::ExitInitializationMode, Instance::exit_initialization_mode), Status::Ok);
        (handle, receiver)
    }

    fn step(handle: &Handle) -> Status {
        handle.call(Call::DoStep, |instance| instance.do_step(instance.time(), 0.1))
    }

    #[test]
    fn panic_becomes_fatal_with_a_message_and_other_instances_go_on() {
        let (lost, messages) = initialized(PANICS);
        let (other, _) = initialized(testing::NOTHING);
        assert_eq!(step(&lost), Status::Fatal);
        let expected = "fmi2DoStep: internal error: a provoked panic with 100 % s";
        assert_eq!(messages.try_iter().collect::<Vec<_>>(), [(Status::Fatal, expected.to_owned())]);
        for call in [Call::DoStep, Call::GetReal, Call::Reset, Call::SetFMUstate] {
            assert_eq!(lost.call(call, |_| unreachable!("the instance is lost")), Status::Fatal);
        }
        assert_eq!(lost.call(Call::FreeInstance, |_| Ok(())), Status::Ok);
        assert_eq!(step(&other), Status::Ok);
    }

    #[test]
    fn message_of_a_formatted_panic_is_logged() {
        let (handle, messages) = initialized(testing::NOTHING);
        let number = 7;
        assert_eq!(handle.call(Call::Reset, |_| panic!("number {number}")), Status::Fatal);
        assert!(messages.try_recv().expect("a message").1.ends_with("internal error: number 7"));
    }

    #[test]
    fn call_during_a_call_is_refused_and_changes_nothing() {
        let (handle, _) = initialized(testing::NOTHING);
        let outer = handle.call(Call::GetReal, |_| {
            assert_eq!(handle.call(Call::Reset, Instance::reset), Status::Error);
            assert_eq!(handle.call(Call::FreeInstance, |_| Ok(())), Status::Error);
            Ok(())
        });
        assert_eq!(outer, Status::Ok);
        assert_eq!(step(&handle), Status::Ok);
    }

    #[test]
    fn call_outside_the_table_is_refused_with_a_reason_and_not_carried_out() {
        let (handle, messages) = initialized(testing::NOTHING);
        assert_eq!(handle.call(Call::SetupExperiment, |_| unreachable!("refused")), Status::Error);
        let (status, text) = messages.try_recv().expect("a message");
        assert_eq!(status, Status::Error);
        assert!(text.starts_with("fmi2SetupExperiment: not allowed between communication steps"), "{text}");
    }

    #[test]
    fn failed_value_calls_say_which_variable() {
        let (handle, messages) = initialized(testing::NOTHING);
        let refused = [
            handle.call(Call::SetReal, |it| it.set(Base::Real, &[STATE], |_| 1.0)),
            handle.call(Call::SetReal, |it| it.set(Base::Real, &[INPUT], |_| f64::NAN)),
        ];
        assert_eq!(refused, [Status::Error; 2]);
        let texts: Vec<_> = messages.try_iter().map(|(_, text)| text).collect();
        assert_eq!(texts[0], "fmi2SetReal: state is computed and cannot be set");
        assert_eq!(texts[1], "fmi2SetReal: input = NaN is refused: it must be a finite number");
    }

    #[test]
    fn instantiation_is_refused_with_a_reason() {
        let guid = CString::new(crate::fmi2::guid(&models::ALL[0])).expect("no zero byte");
        let cases = [
            (None, 1, Some(guid.as_c_str()), "the instance name is missing"),
            (Some(c""), 1, Some(&guid), "the instance name is missing"),
            (Some(c"a"), 0, Some(&guid), "fmuType 0 is not fmi2CoSimulation"),
            (Some(c"a"), 1, None, "the GUID is missing"),
            (Some(c"a"), 1, Some(c"{guid}"), "the GUID {guid} is not that of a model"),
        ];
        for (name, fmu_type, guid, reason) in cases {
            let (sink, messages) = listening_sink();
            assert!(instantiate(name, fmu_type, guid, sink, false).is_none());
            let (status, text) = messages.try_recv().expect("a message");
            assert!(status == Status::Error && text.contains(reason), "{text}");
        }
        let (sink, messages) = listening_sink();
        assert!(instantiate(Some(c"a"), 1, Some(&guid), sink, true).is_some());
        assert_eq!(messages.try_iter().count(), 0);
    }
}
