//! Answers of `fmi2GetStatus` and its variants about the last step.

use super::types::{Boolean, DISCARD, OK, Real, Status, status_kind};
use crate::failure::Failure;
use crate::instance::Instance;

/// `fmi2GetStatus`: how the last step ended.
pub fn of_step(instance: &Instance, kind: i32) -> Result<Status, Failure> {
    available(kind, Some(status_kind::DO_STEP_STATUS))?;
    Ok(if instance.last_step().failed { DISCARD } else { OK })
}

/// `fmi2GetRealStatus`: up to which time all is well.
pub fn last_successful_time(instance: &Instance, kind: i32) -> Result<Real, Failure> {
    available(kind, Some(status_kind::LAST_SUCCESSFUL_TIME))?;
    Ok(instance.last_step().successful_until)
}

/// `fmi2GetBooleanStatus`: a failed step ends the simulation, and masters that would retry it end too.
pub fn wants_to_terminate(instance: &Instance, kind: i32) -> Result<Boolean, Failure> {
    available(kind, Some(status_kind::TERMINATED))?;
    Ok(instance.last_step().failed.into())
}

/// `fmi2GetIntegerStatus` and `fmi2GetStringStatus`: the standard knows no integer, and the only string describes a
/// pending step, which there never is.
pub fn none<T>(kind: i32) -> Result<T, Failure> {
    available(kind, None)?;
    Err(Failure::discard(format!("this status (kind {kind}) is not available here")))
}

/// Refuses a status kind other than the one that a function can tell, if it can tell any.
fn available(kind: i32, offered: Option<i32>) -> Result<(), Failure> {
    match kind {
        _ if Some(kind) == offered => Ok(()),
        status_kind::DO_STEP_STATUS..=status_kind::TERMINATED => {
            Err(Failure::discard(format!("this status (kind {kind}) is not available here")))
        }
        _ => Err(Failure::error(format!("{kind} is no fmi2StatusKind"))),
    }
}
