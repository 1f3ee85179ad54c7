//! The one way into an instance: no panic leaves it, no call interrupts another, and the table of calls is obeyed.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex};

use super::layout::Layout;
use super::log::{Log, Sink};
use super::registry::Library;
use super::variant::{self, Resources};
use super::{Instance, Kind};
use crate::calls::{Call, Mode};
use crate::failure::{Failure, Status};
use crate::memory;

/// An instance as the host holds it.
pub struct Handle(Mutex<Instance>);

impl Handle {
    /// Takes an instance.
    pub fn new(instance: Instance) -> Self {
        Self(Mutex::new(instance))
    }

    /// Carries out a call for a function of a face, and logs why it fails.
    ///
    /// A call during another one of the same instance (from the host's logger, or from another thread) is refused.
    /// That is not logged: the logger may be just what is running.
    pub fn call(
        &self,
        call: Call,
        function: &'static str,
        body: impl FnOnce(&mut Instance) -> Result<(), Failure>,
    ) -> Status {
        let Ok(mut instance) = self.0.try_lock() else {
            return Status::Error;
        };
        instance.log.enter(function);
        // The instance may be half changed after a panic; it is never used again.
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            let result = call.check(instance.mode()).and_then(|()| body(&mut instance));
            match &result {
                Err(failure) if failure.status == Status::Discard && instance.mode() != Mode::StepFailed => {
                    instance.log.discarded(failure);
                }
                Err(failure) => instance.log.failure(failure),
                Ok(()) => (),
            }
            result
        }));
        match outcome.unwrap_or_else(|panic| Err(instance.abandon(cause(panic.as_ref())))) {
            Ok(()) => Status::Ok,
            Err(failure) => failure.status,
        }
    }
}

/// Arguments of a host that asks for an instance.
pub struct Wanted<'a> {
    /// The function that is called.
    pub function: &'static str,
    /// The name of the GUID in the version of the standard.
    pub guid_is_called: &'static str,
    /// Where the solver is to be.
    pub kind: Kind,
    /// The name of the instance, if the host gives one.
    pub name: &'a str,
    /// The GUID of the model, if the host gives one.
    pub guid: Option<&'a str>,
    /// Where the resources are, if the host says it.
    pub resources: Option<Resources<'a>>,
    /// Whether everything is logged.
    pub logging_on: bool,
}

/// Makes an instance of a model of a library, or logs why not; `check` is what the face asks of it besides.
pub fn instantiate(
    library: &'static Library,
    wanted: &Wanted,
    sink: Sink,
    check: impl FnOnce() -> Result<(), Failure>,
) -> Option<Box<Handle>> {
    let mut log = Log::new(sink, wanted.logging_on);
    log.enter(wanted.function);
    let choice = catch_unwind(AssertUnwindSafe(|| {
        check()?;
        memory::check_room()?;
        choose(library, wanted)
    }));
    match choice.unwrap_or_else(|panic| Err(Failure::fatal(cause(panic.as_ref())))) {
        Ok(layout) => Some(Box::new(Handle::new(Instance::new(layout, wanted.kind, log)))),
        Err(failure) => {
            log.failure(&failure);
            None
        }
    }
}

fn choose(library: &'static Library, wanted: &Wanted) -> Result<Arc<Layout>, Failure> {
    if wanted.name.is_empty() {
        return Err(Failure::error("the instance name is missing"));
    }
    let called = wanted.guid_is_called;
    let guid = wanted.guid.ok_or_else(|| Failure::error(format!("the {called} is missing")))?;
    let found = variant::layout(library, called, guid, wanted.resources)?;
    if wanted.kind == Kind::ModelExchange && found.states == 0 {
        let name = found.model.name;
        return Err(Failure::error(format!("{name} has no continuous states and is there for co-simulation only")));
    }
    Ok(found)
}

/// The message of a panic.
fn cause(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("a panic without message")
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;
    use std::sync::mpsc::{Receiver, channel};

    use super::*;
    use crate::instance::layout::Base;
    use crate::instance::testing::{self, INPUT, STATE, TRAP, Trap};
    use pneumatic_servo::models;
    use pneumatic_servo::variables::Choice;

    fn listening_sink() -> (Sink, Receiver<(Status, String)>) {
        let (sender, receiver) = channel();
        let sink = move |status, _: &CStr, text: &CStr| {
            sender.send((status, text.to_str().expect("UTF-8").to_owned())).expect("the receiver lives");
        };
        (Box::new(sink), receiver)
    }

    fn initialized(trap: Trap) -> (Handle, Receiver<(Status, String)>) {
        let (sink, receiver) = listening_sink();
        let handle = Handle::new(Instance::new(testing::layout(), Kind::CoSimulation, Log::new(sink, false)));
        let done = handle
            .call(Call::Set, "SetInteger", |it| it.set(Base::Integer, [(TRAP, f64::from(trap.id()))].into_iter()));
        assert_eq!(done, Status::Ok);
        assert_eq!(
            handle.call(Call::EnterInitialization, "EnterInitializationMode", Instance::enter_initialization_mode),
            Status::Ok
        );
        assert_eq!(
            handle.call(Call::ExitInitialization, "ExitInitializationMode", Instance::exit_initialization_mode),
            Status::Ok
        );
        (handle, receiver)
    }

    fn step(handle: &Handle) -> Status {
        handle.call(Call::Step, "DoStep", |instance| instance.do_step(instance.time(), 0.1).map(|_| ()))
    }

    #[test]
    fn panic_becomes_fatal_with_a_message_and_other_instances_go_on() {
        let (lost, messages) = initialized(Trap::Panics);
        let (other, _) = initialized(Trap::Nothing);
        assert_eq!(step(&lost), Status::Fatal);
        let expected = "DoStep: internal error: a provoked panic with 100 % s";
        assert_eq!(messages.try_iter().collect::<Vec<_>>(), [(Status::Fatal, expected.to_owned())]);
        for call in [Call::Step, Call::Get, Call::Reset, Call::UseState] {
            assert_eq!(lost.call(call, "any", |_| unreachable!("the instance is lost")), Status::Fatal);
        }
        assert_eq!(lost.call(Call::Free, "free", |_| Ok(())), Status::Ok);
        assert_eq!(step(&other), Status::Ok);
    }

    #[test]
    fn message_of_a_formatted_panic_is_logged() {
        let (handle, messages) = initialized(Trap::Nothing);
        let number = 7;
        assert_eq!(handle.call(Call::Reset, "Reset", |_| panic!("number {number}")), Status::Fatal);
        assert!(messages.try_recv().expect("a message").1.ends_with("internal error: number 7"));
    }

    #[test]
    fn call_during_a_call_is_refused_and_changes_nothing() {
        let (handle, _) = initialized(Trap::Nothing);
        let outer = handle.call(Call::Get, "GetReal", |_| {
            assert_eq!(handle.call(Call::Reset, "Reset", Instance::reset), Status::Error);
            assert_eq!(handle.call(Call::Free, "FreeInstance", |_| Ok(())), Status::Error);
            Ok(())
        });
        assert_eq!(outer, Status::Ok);
        assert_eq!(step(&handle), Status::Ok);
    }

    #[test]
    fn call_outside_the_table_is_refused_with_a_reason_and_not_carried_out() {
        let (handle, messages) = initialized(Trap::Nothing);
        assert_eq!(handle.call(Call::SetUpExperiment, "SetupExperiment", |_| unreachable!("refused")), Status::Error);
        let (status, text) = messages.try_recv().expect("a message");
        assert_eq!(status, Status::Error);
        assert!(text.starts_with("SetupExperiment: not allowed between communication steps"), "{text}");
    }

    #[test]
    fn failed_value_calls_say_which_variable() {
        let (handle, messages) = initialized(Trap::Nothing);
        let refused = [
            handle.call(Call::Set, "SetReal", |it| it.set(Base::Real, [(STATE, 1.0)].into_iter())),
            handle.call(Call::Set, "SetReal", |it| it.set(Base::Real, [(INPUT, f64::NAN)].into_iter())),
        ];
        assert_eq!(refused, [Status::Error; 2]);
        let texts: Vec<_> = messages.try_iter().map(|(_, text)| text).collect();
        assert_eq!(texts[0], "SetReal: state is computed and cannot be set");
        assert_eq!(texts[1], "SetReal: input = NaN is refused: it must be a finite number");
    }

    #[test]
    fn instantiation_is_refused_with_a_reason() {
        static LIBRARY: Library = Library::new(models::ALL, || models::ALL, None);
        let guid = crate::guid(&models::ALL[0]);
        let kind = Kind::CoSimulation;
        let wanted = |name, guid| Wanted {
            function: "make",
            guid_is_called: "token",
            kind,
            name,
            guid,
            resources: None,
            logging_on: true,
        };
        let cases = [
            ("", Some(&*guid), "make: the instance name is missing"),
            ("a", None, "make: the token is missing"),
            ("a", Some("{guid}"), "make: the token {guid} belongs to no model"),
        ];
        for (name, guid, reason) in cases {
            let (sink, messages) = listening_sink();
            assert!(instantiate(&LIBRARY, &wanted(name, guid), sink, || Ok(())).is_none());
            let (status, text) = messages.try_recv().expect("a message");
            assert!(status == Status::Error && text.contains(reason), "{text}");
            let lists_models = models::ALL.iter().all(|it| text.contains(&format!("{} {}", it.name, crate::guid(it))));
            assert_eq!(lists_models, guid == Some("{guid}"), "{text}");
        }
        let (sink, messages) = listening_sink();
        assert!(instantiate(&LIBRARY, &wanted("a", Some(&guid)), sink, || Err(Failure::error("no"))).is_none());
        assert_eq!(messages.try_recv().expect("a message").1, "make: no");
        let (sink, messages) = listening_sink();
        assert!(instantiate(&LIBRARY, &wanted("a", Some(&guid)), sink, || Ok(())).is_some());
        assert_eq!(messages.try_iter().count(), 0);
    }
}
