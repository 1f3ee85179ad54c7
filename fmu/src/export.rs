//! The macro by which a shared library lists its models.

/// Makes the crate that calls it, compiled as a `cdylib`, a library of FMUs: it exports all functions of FMI 2.0 and 3.0,
/// for the models of a list (`&'static [Model]`). Called once, at the root of the crate.
///
/// Besides it makes `LIBRARY`, the models, and `FMI2` and `FMI3`, tables of the functions.
///
/// ```
/// pneumatic_servo_fmu::export_fmu!(&[pneumatic_servo::models::festoon::MODEL]);
///
/// # fn main() {
/// assert_eq!(LIBRARY.models()[0].name, "Festoon");
/// # }
/// ```
///
/// A list without a model, or with a name twice, is refused by the compiler:
///
/// ```compile_fail
/// use pneumatic_servo::models::festoon::MODEL;
///
/// pneumatic_servo_fmu::export_fmu!(&[MODEL, MODEL]);
/// ```
#[macro_export]
macro_rules! export_fmu {
    ($models:expr) => {
        $crate::library! { $models }

        /// The functions of FMI 2.0 for these models.
        pub static FMI2: $crate::fmi2::exports::Functions = {
            use $crate::fmi2::exports::{Functions, instantiate};
            use $crate::fmi2::types::{Boolean, CallbackFunctions, Component, FmuType, Text};

            #[unsafe(no_mangle)]
            unsafe extern "C" fn fmi2Instantiate(
                instance_name: Text,
                fmu_type: FmuType,
                guid: Text,
                resource_location: Text,
                functions: *const CallbackFunctions,
                visible: Boolean,
                logging_on: Boolean,
            ) -> Component {
                // SAFETY: the host vouches for its arguments.
                unsafe {
                    instantiate(
                        &LIBRARY,
                        instance_name,
                        fmu_type,
                        guid,
                        resource_location,
                        functions,
                        visible,
                        logging_on,
                    )
                }
            }

            Functions::with(fmi2Instantiate)
        };

        /// The functions of FMI 3.0 for these models.
        pub static FMI3: $crate::fmi3::exports::Functions = {
            use $crate::fmi3::exports::Functions;
            use $crate::fmi3::instantiation::{co_simulation, model_exchange, scheduled_execution};
            use $crate::fmi3::types::{
                Boolean, ClockUpdate, Instance, InstanceEnvironment, IntermediateUpdate, LogMessage, Preemption, Text,
                ValueReference,
            };

            #[unsafe(no_mangle)]
            unsafe extern "C" fn fmi3InstantiateModelExchange(
                instance_name: Text,
                instantiation_token: Text,
                resource_path: Text,
                visible: Boolean,
                logging_on: Boolean,
                instance_environment: InstanceEnvironment,
                log_message: Option<LogMessage>,
            ) -> Instance {
                // SAFETY: the host vouches for its arguments.
                unsafe {
                    model_exchange(
                        &LIBRARY,
                        instance_name,
                        instantiation_token,
                        resource_path,
                        visible,
                        logging_on,
                        instance_environment,
                        log_message,
                    )
                }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C" fn fmi3InstantiateCoSimulation(
                instance_name: Text,
                instantiation_token: Text,
                resource_path: Text,
                visible: Boolean,
                logging_on: Boolean,
                event_mode_used: Boolean,
                early_return_allowed: Boolean,
                required_intermediate_variables: *const ValueReference,
                number_of_required_intermediate_variables: usize,
                instance_environment: InstanceEnvironment,
                log_message: Option<LogMessage>,
                intermediate_update: Option<IntermediateUpdate>,
            ) -> Instance {
                // SAFETY: the host vouches for its arguments.
                unsafe {
                    co_simulation(
                        &LIBRARY,
                        instance_name,
                        instantiation_token,
                        resource_path,
                        visible,
                        logging_on,
                        event_mode_used,
                        early_return_allowed,
                        required_intermediate_variables,
                        number_of_required_intermediate_variables,
                        instance_environment,
                        log_message,
                        intermediate_update,
                    )
                }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C" fn fmi3InstantiateScheduledExecution(
                instance_name: Text,
                instantiation_token: Text,
                resource_path: Text,
                visible: Boolean,
                logging_on: Boolean,
                instance_environment: InstanceEnvironment,
                log_message: Option<LogMessage>,
                clock_update: Option<ClockUpdate>,
                lock_preemption: Option<Preemption>,
                unlock_preemption: Option<Preemption>,
            ) -> Instance {
                // SAFETY: the host vouches for its arguments.
                unsafe {
                    scheduled_execution(
                        &LIBRARY,
                        instance_name,
                        instantiation_token,
                        resource_path,
                        visible,
                        logging_on,
                        instance_environment,
                        log_message,
                        clock_update,
                        lock_preemption,
                        unlock_preemption,
                    )
                }
            }

            Functions::with(
                fmi3InstantiateModelExchange,
                fmi3InstantiateCoSimulation,
                fmi3InstantiateScheduledExecution,
            )
        };
    };
}

/// The models of a library. The program that packs it into FMUs states its source.
#[cfg(not(all(feature = "module", target_family = "wasm")))]
#[doc(hidden)]
#[macro_export]
macro_rules! library {
    ($models:expr) => {
        /// The models that this library serves.
        pub static LIBRARY: $crate::Library =
            $crate::Library::new($models, || $models, option_env!("FMU_SOURCE_FINGERPRINT"));
    };
}

/// The one model of a module from which sources in C are made, named when it is compiled: nothing of the others is linked.
#[cfg(all(feature = "module", target_family = "wasm"))]
#[doc(hidden)]
#[macro_export]
macro_rules! library {
    ($models:expr) => {
        /// The model that this module serves.
        pub static LIBRARY: $crate::Library = {
            static ONE: [$crate::Model; 1] = [$crate::only($models, env!("FMU_ONLY_MODEL"))];
            $crate::Library::new(&ONE, || &ONE, option_env!("FMU_SOURCE_FINGERPRINT"))
        };

        /// The fingerprint of the self-test; 0 if its run fails.
        #[unsafe(no_mangle)]
        pub extern "C" fn plant_self_test() -> u64 {
            $crate::self_test::fingerprint(&LIBRARY.models()[0]).unwrap_or_default()
        }

        $crate::looped::export_calls! {
            |parameters, inputs, _| $crate::looped::begin_model(&LIBRARY.models()[0], parameters, inputs)
        }
    };
}
