//! Values on their way between host and instance: numbers of any type, by arrays.

#![allow(unsafe_code, reason = "the host passes pointers")]

use super::types::ValueReference;
use crate::failure::Failure;
use crate::host::{Input, Output};
use crate::instance::{Base, Instance};

/// A type of numbers of the interface; an instance has but one.
pub trait Number: Copy {
    /// A value of an instance, which fits.
    fn of(value: f64) -> Self;
    /// The value for an instance.
    fn value(self) -> f64;
}

macro_rules! numbers {
    ($($type:ty)*) => {
        $(impl Number for $type {
            fn of(value: f64) -> Self {
                value as Self
            }

            fn value(self) -> f64 {
                self as f64
            }
        })*
    };
}

numbers! { f32 f64 i8 u8 i16 u16 i32 u32 i64 u64 }

/// Reads arrays of a type.
///
/// # Safety
/// As in the module `c_interface`.
pub unsafe fn get<T: Number>(
    instance: &mut Instance,
    base: Base,
    references: *const ValueReference,
    number: usize,
    values: *mut T,
    room: usize,
) -> Result<(), Failure> {
    // SAFETY: as in the module `c_interface`.
    let (references, values) =
        unsafe { (Input::new(references, number, "valueReferences")?, Output::new(values, room, "values")?) };
    values.write(instance.get_arrays(base, references.iter(), room)?.iter().map(|value| T::of(*value)));
    Ok(())
}

/// Sets arrays of a type: all of them, or none if one element is refused.
///
/// # Safety
/// As in the module `c_interface`.
pub unsafe fn set<T: Number>(
    instance: &mut Instance,
    base: Base,
    references: *const ValueReference,
    number: usize,
    values: *const T,
    room: usize,
) -> Result<(), Failure> {
    // SAFETY: as in the module `c_interface`.
    let (references, values) =
        unsafe { (Input::new(references, number, "valueReferences")?, Input::new(values, room, "values")?) };
    let elements = instance.elements(references.iter(), room)?;
    instance.set(base, elements.zip(values.iter().map(T::value)))
}

/// Refuses variables of a type that no variable has; none at all are fine.
///
/// # Safety
/// As in the module `c_interface`.
pub unsafe fn absent(
    instance: &mut Instance,
    kind: &'static str,
    references: *const ValueReference,
    number: usize,
) -> Result<(), Failure> {
    // SAFETY: as in the module `c_interface`.
    let references = unsafe { Input::new(references, number, "valueReferences")? };
    instance.get_arrays(Base::Absent(kind), references.iter(), 0).map(|_| ())
}
