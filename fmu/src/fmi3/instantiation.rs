//! Instantiation by the C functions, each for one kind of use of the models of a library; the functions
//! themselves come from [`export_fmu!`](crate::export_fmu).
//!
//! # Safety
//! See `crate::c_interface`.

#![allow(unsafe_code, reason = "this is the C interface")]
#![allow(clippy::missing_safety_doc, reason = "the module states it for all functions")]
#![allow(clippy::too_many_arguments, reason = "the standard's signatures")]

use super::callbacks::sink;
use super::types::{
    Boolean, ClockUpdate, Instance as Component, InstanceEnvironment, IntermediateUpdate, LogMessage, Preemption, Text,
    ValueReference,
};
use crate::c_interface::hand_out;
use crate::failure::Failure;
use crate::host::text;
use crate::instance::{self, Kind, Library, Resources, Wanted, instantiate};

/// Makes an instance for model exchange of the model with a token; NULL, and a message, if there is none.
pub unsafe fn model_exchange(
    library: &'static Library,
    instance_name: Text,
    instantiation_token: Text,
    resource_path: Text,
    _visible: Boolean,
    logging_on: Boolean,
    instance_environment: InstanceEnvironment,
    log_message: Option<LogMessage>,
) -> Component {
    let made = Made { function: "fmi3InstantiateModelExchange", kind: Kind::ModelExchange, logging_on };
    // SAFETY: of the module.
    unsafe {
        made.of(
            library,
            instance_name,
            instantiation_token,
            resource_path,
            sink(log_message, instance_environment),
            || Ok(()),
        )
    }
}

/// Makes an instance for co-simulation of the model with a token; NULL, and a message, if there is none.
///
/// Steps end at events if event mode is used and steps may return early; else events are handled inside.
pub unsafe fn co_simulation(
    library: &'static Library,
    instance_name: Text,
    instantiation_token: Text,
    resource_path: Text,
    _visible: Boolean,
    logging_on: Boolean,
    event_mode_used: Boolean,
    early_return_allowed: Boolean,
    _required_intermediate_variables: *const ValueReference,
    number_of_required_intermediate_variables: usize,
    instance_environment: InstanceEnvironment,
    log_message: Option<LogMessage>,
    _intermediate_update: Option<IntermediateUpdate>,
) -> Component {
    let kind = match event_mode_used {
        0 => Kind::CoSimulation,
        _ => Kind::HybridCoSimulation { returns_early: early_return_allowed != 0 },
    };
    let made = Made { function: "fmi3InstantiateCoSimulation", kind, logging_on };
    let check = || match number_of_required_intermediate_variables {
        0 => Ok(()),
        number => Err(Failure::error(format!(
            "{number} variables are required in intermediate updates, of which there are none during a step"
        ))),
    };
    // SAFETY: of the module.
    unsafe {
        made.of(
            library,
            instance_name,
            instantiation_token,
            resource_path,
            sink(log_message, instance_environment),
            check,
        )
    }
}

/// Always refused: there is nothing to schedule.
pub unsafe fn scheduled_execution(
    library: &'static Library,
    instance_name: Text,
    instantiation_token: Text,
    resource_path: Text,
    _visible: Boolean,
    logging_on: Boolean,
    instance_environment: InstanceEnvironment,
    log_message: Option<LogMessage>,
    _clock_update: Option<ClockUpdate>,
    _lock_preemption: Option<Preemption>,
    _unlock_preemption: Option<Preemption>,
) -> Component {
    let made = Made { function: "fmi3InstantiateScheduledExecution", kind: Kind::CoSimulation, logging_on };
    let refuse = || Err(Failure::error("there is no scheduled execution: the model has no clocks"));
    // SAFETY: of the module.
    unsafe {
        made.of(
            library,
            instance_name,
            instantiation_token,
            resource_path,
            sink(log_message, instance_environment),
            refuse,
        )
    }
}

/// Arguments of an instantiation.
struct Made {
    function: &'static str,
    kind: Kind,
    logging_on: Boolean,
}

impl Made {
    /// Makes it, for a name, a token and a folder of resources.
    unsafe fn of(
        self,
        library: &'static Library,
        name: Text,
        token: Text,
        resources: Text,
        sink: instance::Sink,
        check: impl FnOnce() -> Result<(), Failure>,
    ) -> Component {
        // SAFETY: the host passes NULL or strings.
        let (name, token, resources) = unsafe { (text(name), text(token), text(resources)) };
        let name = name.unwrap_or_default();
        let token = token.map(|token| token.to_string_lossy().into_owned());
        let wanted = Wanted {
            function: self.function,
            guid_is_called: "instantiation token",
            kind: self.kind,
            name: &name.to_string_lossy(),
            guid: token.as_deref(),
            resources: resources.as_deref().map(Resources::Path),
            logging_on: self.logging_on != 0,
        };
        hand_out(instantiate(library, &wanted, sink, check))
    }
}
