//! Parts that several friction laws are made of.

/// Declares a struct around a law of a simpler kind, so that it can be a [`FrictionLaw`](super::law::FrictionLaw): its
/// parameters are the law's.
macro_rules! wrapper {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Debug)]
        pub struct $name<L>(L);

        impl<L: $crate::variables::ParameterSet> $crate::variables::ParameterSet for $name<L> {
            const LEN: usize = L::LEN;

            fn table() -> Vec<$crate::variables::Variable> {
                L::table()
            }

            fn read(values: &[$crate::variables::Tunable]) -> Result<Self, $crate::variables::ParameterError> {
                L::read(values).map(Self)
            }
        }
    };
}

pub(crate) mod anchored;
pub(crate) mod bounded;
pub(crate) mod curve;
pub(crate) mod delay;
pub mod dwell;
pub(crate) mod elements;
pub(crate) mod fading;
pub(crate) mod list;
pub mod of_velocity;
pub mod one_bristle;
pub mod parameters;
pub(crate) mod ramp;
pub(crate) mod shared;
pub mod stick_slip;
