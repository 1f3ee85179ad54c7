//! Calls of each exported function by which it is missed: without the function, which then does nothing and says that all
//! is well, the test named here fails.

use std::collections::BTreeSet;
use std::convert::Infallible;
use std::ffi::c_void;
use std::panic::catch_unwind;
use std::ptr;

use pneumatic_servo_fmu::{fmi2, fmi3};

use crate::common::fmi3::LIBRARY3;
use crate::common::{LIBRARY, symbol};
use crate::fmi3 as three;
use crate::symbols::exported;
use crate::{derivatives, instantiation, logging, model_exchange, saved_states, state_machine, steps, values};

/// A test, and functions without which it fails.
type Needs = (fn(), &'static [&'static str]);

/// Tests, and the functions of FMI 2.0 that each needs.
const FMI2: [Needs; 22] = [
    (crate::symbols::version_and_platform_are_those_of_fmi_2, &["fmi2GetTypesPlatform", "fmi2GetVersion"]),
    (logging::errors_are_always_logged_and_everything_else_only_with_logging_on, &["fmi2SetDebugLogging"]),
    (instantiation::every_model_is_served_under_its_own_guid, &["fmi2Instantiate"]),
    (steps::stop_time_bounds_the_steps_up_to_rounding, &["fmi2SetupExperiment"]),
    (values::computed_values_follow_what_is_set_during_initialization, &["fmi2EnterInitializationMode"]),
    (state_machine::missing_experiment_means_start_at_zero, &["fmi2ExitInitializationMode"]),
    (state_machine::terminated_run_takes_no_step_and_can_still_be_read, &["fmi2Terminate"]),
    (
        values::every_parameter_and_input_keeps_what_is_set_until_a_reset,
        &[
            "fmi2Reset",
            "fmi2GetReal",
            "fmi2GetInteger",
            "fmi2GetBoolean",
            "fmi2SetReal",
            "fmi2SetInteger",
            "fmi2SetBoolean",
        ],
    ),
    (values::unknown_and_wrongly_typed_references_are_refused_and_write_nothing, &["fmi2GetString", "fmi2SetString"]),
    (
        saved_states::serialized_state_continues_in_another_instance,
        &[
            "fmi2GetFMUstate",
            "fmi2SetFMUstate",
            "fmi2SerializedFMUstateSize",
            "fmi2SerializeFMUstate",
            "fmi2DeSerializeFMUstate",
        ],
    ),
    (saved_states::null_foreign_and_freed_states_are_refused, &["fmi2FreeFMUstate"]),
    (derivatives::force_accelerates_the_mass_and_nothing_else, &["fmi2GetDirectionalDerivative"]),
    (derivatives::input_keeps_the_value_it_reached_and_then_stays, &["fmi2SetRealInputDerivatives"]),
    (derivatives::every_real_output_has_a_derivative_that_matches_its_course, &["fmi2GetRealOutputDerivatives"]),
    (model_exchange::sampled_law_announces_its_samples, &["fmi2EnterEventMode", "fmi2NewDiscreteStates"]),
    (
        model_exchange::accepted_steps_are_counted_and_lead_where_the_host_has_gone,
        &["fmi2EnterContinuousTimeMode", "fmi2CompletedIntegratorStep", "fmi2SetTime", "fmi2SetContinuousStates"],
    ),
    (
        model_exchange::states_and_derivatives_are_those_of_the_variables,
        &["fmi2GetDerivatives", "fmi2GetContinuousStates"],
    ),
    (model_exchange::indicators_are_those_that_fmi_3_shows_as_variables, &["fmi2GetEventIndicators"]),
    (model_exchange::nominals_are_those_of_the_states_or_1, &["fmi2GetNominalsOfContinuousStates"]),
    (steps::step_ends_exactly_at_point_plus_size, &["fmi2DoStep"]),
    (steps::there_is_never_a_step_to_cancel, &["fmi2CancelStep"]),
    (
        steps::each_status_function_answers_its_kind,
        &["fmi2GetStatus", "fmi2GetRealStatus", "fmi2GetIntegerStatus", "fmi2GetBooleanStatus", "fmi2GetStringStatus"],
    ),
];

/// Tests, and the functions of FMI 3.0 that each needs.
const FMI3: [Needs; 22] = [
    (three::instantiation::version_is_that_of_fmi_3, &["fmi3GetVersion"]),
    (three::experiment::logging_is_switched_by_categories, &["fmi3SetDebugLogging"]),
    (
        three::instantiation::every_model_can_be_made_in_every_way_but_one_without_states_is_not_exchanged,
        &["fmi3InstantiateModelExchange", "fmi3InstantiateCoSimulation"],
    ),
    (
        three::instantiation::scheduled_execution_and_intermediate_variables_are_refused,
        &["fmi3InstantiateScheduledExecution"],
    ),
    (
        three::experiment::run_begins_at_the_start_and_ends_at_the_stop,
        &["fmi3EnterInitializationMode", "fmi3ExitInitializationMode"],
    ),
    (three::events::jump_of_an_input_is_handled_by_the_update, &["fmi3EnterEventMode", "fmi3EnterStepMode"]),
    (three::experiment::terminated_run_takes_no_step, &["fmi3Terminate"]),
    (three::instantiation::instances_can_be_reset_in_every_way, &["fmi3Reset"]),
    (
        three::values::types_that_no_variable_has_are_refused_by_name_and_change_nothing,
        &[
            "fmi3GetFloat32",
            "fmi3GetInt8",
            "fmi3GetUInt8",
            "fmi3GetInt16",
            "fmi3GetUInt16",
            "fmi3GetUInt32",
            "fmi3GetUInt64",
            "fmi3GetString",
            "fmi3GetBinary",
            "fmi3GetClock",
            "fmi3SetFloat32",
            "fmi3SetInt8",
            "fmi3SetUInt8",
            "fmi3SetInt16",
            "fmi3SetUInt16",
            "fmi3SetUInt32",
            "fmi3SetUInt64",
            "fmi3SetString",
            "fmi3SetBinary",
            "fmi3SetClock",
            "fmi3GetIntervalDecimal",
            "fmi3GetIntervalFraction",
            "fmi3GetShiftDecimal",
            "fmi3GetShiftFraction",
            "fmi3SetIntervalDecimal",
            "fmi3SetIntervalFraction",
            "fmi3SetShiftDecimal",
            "fmi3SetShiftFraction",
        ],
    ),
    (
        three::values::every_parameter_and_input_of_every_model_keeps_what_is_set_until_a_reset,
        &[
            "fmi3GetFloat64",
            "fmi3GetInt32",
            "fmi3GetInt64",
            "fmi3GetBoolean",
            "fmi3SetFloat64",
            "fmi3SetInt32",
            "fmi3SetInt64",
            "fmi3SetBoolean",
        ],
    ),
    (
        three::values::dependencies_are_those_of_the_table,
        &["fmi3GetNumberOfVariableDependencies", "fmi3GetVariableDependencies"],
    ),
    (three::saved_states::states_go_from_one_version_to_the_other, &["fmi3SetFMUState"]),
    (three::saved_states::freed_state_is_refused, &["fmi3GetFMUState", "fmi3FreeFMUState"]),
    (
        three::saved_states::state_before_an_event_repeats_bit_for_bit_in_another_instance,
        &["fmi3SerializedFMUStateSize", "fmi3SerializeFMUState", "fmi3DeserializeFMUState"],
    ),
    (three::derivatives::force_accelerates_the_mass, &["fmi3GetDirectionalDerivative"]),
    (three::derivatives::stuck_and_sliding_carriage_differ_in_what_an_adjoint_tells, &["fmi3GetAdjointDerivative"]),
    (
        three::state_machine::what_is_not_offered_is_refused_with_a_reason,
        &[
            "fmi3EnterConfigurationMode",
            "fmi3ExitConfigurationMode",
            "fmi3EvaluateDiscreteStates",
            "fmi3ActivateModelPartition",
        ],
    ),
    (
        three::model_exchange::update_at_an_event_lets_a_stuck_carriage_go,
        &["fmi3UpdateDiscreteStates", "fmi3EnterContinuousTimeMode"],
    ),
    (
        three::model_exchange::accepted_steps_are_counted_and_lead_where_the_host_has_gone,
        &["fmi3CompletedIntegratorStep", "fmi3SetTime", "fmi3SetContinuousStates"],
    ),
    (
        three::model_exchange::solver_outside_sees_the_vectors_of_fmi_2,
        &[
            "fmi3GetContinuousStateDerivatives",
            "fmi3GetEventIndicators",
            "fmi3GetContinuousStates",
            "fmi3GetNominalsOfContinuousStates",
            "fmi3GetNumberOfEventIndicators",
            "fmi3GetNumberOfContinuousStates",
        ],
    ),
    (three::derivatives::output_derivatives_of_order_1_are_those_of_the_variables, &["fmi3GetOutputDerivatives"]),
    (three::events::step_ends_at_break_away_as_the_solver_has_located_it, &["fmi3DoStep"]),
];

/// Functions whose effect no call can see: what they give back is counted in `memory.rs`, by an allocator of its own.
const FREES: [&str; 2] = ["fmi2FreeInstance", "fmi3FreeInstance"];

/// A function in the place of another: it does nothing. OK, NULL and false are all zero.
extern "C" fn nothing() -> *mut c_void {
    ptr::null_mut()
}

/// Whether a test fails where a function does nothing.
fn is_missed(function: &str, test: fn()) -> bool {
    let found = |name: &str| {
        let there = || symbol(name).expect("a function of the standard");
        Ok::<_, Infallible>(if name == function { nothing as *const c_void } else { there() })
    };
    // SAFETY: each function has the type of its name, or is one whose arguments the caller clears away, as on all platforms of
    // the library.
    let (two, three) = unsafe { (fmi2::exports::Functions::load(found), fmi3::exports::Functions::load(found)) };
    let (Ok(two), Ok(three)) = (two, three);
    LIBRARY.replaced_by(&two, || LIBRARY3.replaced_by(&three, || catch_unwind(test))).is_err()
}

#[test]
fn every_exported_function_is_called_with_effect() {
    let table = || FMI2.iter().chain(&FMI3).flat_map(|(test, functions)| functions.iter().map(|it| (*test, *it)));
    for (test, function) in table() {
        assert!(is_missed(function, test), "the test of {function} passes without it");
    }
    let listed: BTreeSet<_> = table().map(|(_, function)| function).chain(FREES).map(str::to_owned).collect();
    let exported = exported();
    let forgotten: Vec<_> = exported.symmetric_difference(&listed).collect();
    assert!(forgotten.is_empty(), "either exported or tested, but not both: {forgotten:?}");
}
