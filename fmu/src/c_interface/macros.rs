//! Code that the exported functions share.

/// Makes the C functions that work on an instance, each from its declaration: its documentation, its arguments after the
/// component, the call of the table that it stands for, and what it does; and from the declarations of all functions
/// a table of them.
///
/// `besides` names functions that are written out, `outside` those that the crate of a shared library has from
/// [`export_fmu!`](crate::export_fmu), since they know which models there are.
macro_rules! exports {
    (
        besides { $(fn $other:ident($($given:ty),*) $(-> $answer:ty)?;)* }
        outside { $(fn $outer:ident($($taken:ty),*) -> $made:ty;)* }
        $(
            $(#[$doc:meta])*
            fn $name:ident($($argument:ident: $type:ty),*) => $call:ident, |$instance:ident| $body:expr;
        )*
    ) => {
        $(
            $(#[$doc])*
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name(component: Component, $($argument: $type),*) -> Status {
                // SAFETY: of the module.
                unsafe { call(component, Call::$call, stringify!($name), |$instance: &mut Instance| $body) }
            }
        )*

        /// All functions of the interface, as a host has them once it has loaded the library.
        #[allow(missing_docs, reason = "the functions are documented")]
        pub struct Functions {
            $(pub $other: unsafe extern "C" fn($($given),*) $(-> $answer)?,)*
            $(pub $outer: unsafe extern "C" fn($($taken),*) -> $made,)*
            $(pub $name: unsafe extern "C" fn(Component, $($type),*) -> Status),*
        }

        impl Functions {
            /// All functions, from those that know which models there are. What is stated of functions that are written
            /// out is checked by the compiler here.
            #[allow(non_snake_case, reason = "the standard's names")]
            pub const fn with($($outer: unsafe extern "C" fn($($taken),*) -> $made),*) -> Self {
                Self { $($other,)* $($outer,)* $($name),* }
            }

            /// Their names.
            pub const NAMES: &[&str] = &[$(stringify!($other),)* $(stringify!($outer),)* $(stringify!($name)),*];

            /// The functions as symbols of a library, which `symbol` finds by name.
            ///
            /// # Safety
            /// The function of this name, which stays loaded as long as this is used.
            pub unsafe fn load<E>(mut symbol: impl FnMut(&str) -> Result<*const c_void, E>) -> Result<Self, E> {
                // SAFETY: as the caller promises; pointers to functions are pointers.
                unsafe {
                    Ok(Self {
                        $($other: transmute::<*const c_void, unsafe extern "C" fn($($given),*) $(-> $answer)?>(
                            symbol(stringify!($other))?,
                        ),)*
                        $($outer: transmute::<*const c_void, unsafe extern "C" fn($($taken),*) -> $made>(
                            symbol(stringify!($outer))?,
                        ),)*
                        $($name: transmute::<*const c_void, unsafe extern "C" fn(Component, $($type),*) -> Status>(
                            symbol(stringify!($name))?,
                        )),*
                    })
                }
            }
        }
    };
}
