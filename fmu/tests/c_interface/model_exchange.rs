//! Model exchange: the solver is outside.

use std::ffi::{CString, c_int};
use std::ptr;

use pneumatic_servo_fmu::fmi2;
use pneumatic_servo_fmu::fmi2::types::EventInfo;

use crate::common::fmi3::{Instance3, Way};
use crate::common::*;

const STATES: usize = 48;
const INDICATORS: usize = 12;

/// A host that integrates by the explicit Euler method, which is enough to see what the interface does.
trait Exchange {
    fn update(&self) -> (c_int, EventInfo);
    fn integrate(&self) -> c_int;
    fn enter_event_mode(&self) -> c_int;
    fn set_time(&self, time: f64) -> c_int;
    fn set_states(&self, states: &[f64]) -> c_int;
    fn accept_step(&self) -> c_int;
    fn states(&self, values: &mut [f64]) -> c_int;
    fn derivatives(&self, values: &mut [f64]) -> c_int;
    fn nominals(&self, values: &mut [f64]) -> c_int;
    fn indicators(&self, values: &mut [f64]) -> c_int;
}

// SAFETY, for all of them: of the component; arrays have the lengths that are passed.
impl Exchange for Instance {
    fn update(&self) -> (c_int, EventInfo) {
        let mut info = EventInfo::default();
        (unsafe { (LIBRARY.fmi2NewDiscreteStates)(self.component, &mut info) }, info)
    }

    fn integrate(&self) -> c_int {
        unsafe { (LIBRARY.fmi2EnterContinuousTimeMode)(self.component) }
    }

    fn enter_event_mode(&self) -> c_int {
        unsafe { (LIBRARY.fmi2EnterEventMode)(self.component) }
    }

    fn set_time(&self, time: f64) -> c_int {
        unsafe { (LIBRARY.fmi2SetTime)(self.component, time) }
    }

    fn set_states(&self, states: &[f64]) -> c_int {
        unsafe { (LIBRARY.fmi2SetContinuousStates)(self.component, states.as_ptr(), states.len()) }
    }

    fn accept_step(&self) -> c_int {
        let (mut enter, mut terminate) = (7, 7);
        let status = unsafe { (LIBRARY.fmi2CompletedIntegratorStep)(self.component, 1, &mut enter, &mut terminate) };
        assert_eq!((enter, terminate), if status == OK { (0, 0) } else { (7, 7) });
        status
    }

    fn states(&self, values: &mut [f64]) -> c_int {
        unsafe { (LIBRARY.fmi2GetContinuousStates)(self.component, values.as_mut_ptr(), values.len()) }
    }

    fn derivatives(&self, values: &mut [f64]) -> c_int {
        unsafe { (LIBRARY.fmi2GetDerivatives)(self.component, values.as_mut_ptr(), values.len()) }
    }

    fn nominals(&self, values: &mut [f64]) -> c_int {
        unsafe { (LIBRARY.fmi2GetNominalsOfContinuousStates)(self.component, values.as_mut_ptr(), values.len()) }
    }

    fn indicators(&self, values: &mut [f64]) -> c_int {
        unsafe { (LIBRARY.fmi2GetEventIndicators)(self.component, values.as_mut_ptr(), values.len()) }
    }
}

/// A cylinder under a law and a voltage, in continuous-time mode at 0 s.
fn integrating(law: i32, voltage: f64) -> Instance {
    let instance = Instance::for_exchange(cylinder());
    assert_eq!(instance.set_integer(&[vr("friction.law")], &[law]), OK);
    assert_eq!(instance.set_real(&[vr("valveVoltage")], &[voltage]), OK);
    instance.initialize();
    assert_eq!((instance.update().0, instance.integrate()), (OK, OK));
    instance
}

/// Steps of a host with a crude method; everything that it sees, bit for bit.
fn euler(instance: &Instance, steps: u32) -> Vec<u64> {
    const SIZE: f64 = 1e-5;
    let (mut x, mut rates, mut z) = ([0.0; STATES], [0.0; STATES], [0.0; INDICATORS]);
    let mut seen = Vec::new();
    for _ in 0..steps {
        assert_eq!((instance.states(&mut x), instance.derivatives(&mut rates)), (OK, OK));
        for (state, rate) in x.iter_mut().zip(rates) {
            *state += SIZE * rate;
        }
        assert_eq!(instance.set_time(instance.real("time") + SIZE), OK);
        assert_eq!((instance.set_states(&x), instance.accept_step(), instance.indicators(&mut z)), (OK, OK, OK));
        if z.iter().any(|z| *z <= 0.0) {
            assert_eq!((instance.enter_event_mode(), instance.update().0, instance.integrate()), (OK, OK, OK));
        }
        seen.extend(x.iter().chain(&rates).chain(&z).map(|value| value.to_bits()));
    }
    seen
}

const STRIBECK: i32 = 7;

#[test]
fn every_function_is_allowed_exactly_in_its_modes() {
    /// Before initialization (I), in initialization (M), event (E) and continuous-time mode (C), terminated (T).
    fn instance_in(mode: char) -> Instance {
        let instance = Instance::for_exchange(cylinder());
        if mode != 'I' {
            assert_eq!((instance.setup(0.0, None), instance.enter()), (OK, OK));
        }
        if "ECT".contains(mode) {
            assert_eq!(instance.exit(), OK);
        }
        match mode {
            'C' => assert_eq!(instance.integrate(), OK),
            'T' => assert_eq!(instance.terminate(), OK),
            _ => (),
        }
        instance.messages();
        instance
    }
    type Function = fn(&Instance) -> c_int;
    let table: [(&str, &str, Function); 23] = [
        ("fmi2EnterEventMode", "EC", |it| it.enter_event_mode()),
        ("fmi2NewDiscreteStates", "E", |it| it.update().0),
        ("fmi2EnterContinuousTimeMode", "E", |it| it.integrate()),
        ("fmi2CompletedIntegratorStep", "C", |it| it.accept_step()),
        ("fmi2SetTime", "EC", |it| it.set_time(0.0)),
        ("fmi2SetContinuousStates", "C", |it| {
            let mut states = [0.0; STATES];
            if it.states(&mut states) == OK { it.set_states(&states) } else { it.set_states(&[1.0; STATES]) }
        }),
        ("fmi2GetContinuousStates", "MECT", |it| it.states(&mut [0.0; STATES])),
        ("fmi2GetDerivatives", "ECT", |it| it.derivatives(&mut [0.0; STATES])),
        ("fmi2GetNominalsOfContinuousStates", "IECT", |it| it.nominals(&mut [0.0; STATES])),
        ("fmi2GetEventIndicators", "MECT", |it| it.indicators(&mut [0.0; INDICATORS])),
        ("fmi2SetupExperiment", "I", |it| it.setup(0.0, None)),
        ("fmi2EnterInitializationMode", "I", Instance::enter),
        ("fmi2ExitInitializationMode", "M", Instance::exit),
        ("fmi2Terminate", "EC", Instance::terminate),
        ("fmi2Reset", "IMECT", Instance::reset),
        ("fmi2GetReal of a computed value", "MECT", |it| it.get_real(&[vr("position")], &mut [0.0])),
        ("fmi2SetReal of an input", "IMEC", |it| it.set_real(&[vr("valveVoltage")], &[6.0])),
        ("fmi2SetReal of a fixed parameter", "IM", |it| it.set_real(&[vr("mass.moving")], &[1.0])),
        ("fmi2SetReal of a tunable parameter", "IME", |it| it.set_real(&[vr("wireForce")], &[1.0])),
        ("fmi2GetDirectionalDerivative", "MECT", |it| {
            it.directional(&[vr("acceleration")], &[vr("externalForce")], &[1.0], &mut [0.0])
        }),
        ("fmi2SetRealInputDerivatives", "", |it| it.set_slopes(&[vr("valveVoltage")], &[1.0])),
        ("fmi2GetRealOutputDerivatives", "", |it| {
            if it.terminate() == OK { ERROR } else { it.output_derivatives(&[vr("position")], &[1], &mut [0.0]) }
        }),
        ("fmi2DoStep", "", |it| it.step(0.0, 1e-3)),
    ];
    for (name, allowed, function) in table {
        for mode in "IMECT".chars() {
            let instance = instance_in(mode);
            let before = instance.fingerprint();
            let status = function(&instance);
            if allowed.contains(mode) {
                assert_eq!(status, OK, "{name} in {mode}: {:?}", instance.messages());
            } else {
                assert_eq!(status, ERROR, "{name} in {mode}");
                assert!(name.ends_with("OutputDerivatives") || instance.fingerprint() == before, "{name} in {mode}");
            }
        }
    }
}

#[test]
fn functions_of_model_exchange_are_refused_in_co_simulation() {
    let instance = Instance::initialized();
    let before = instance.fingerprint();
    let refused = [
        instance.enter_event_mode(),
        instance.update().0,
        instance.integrate(),
        instance.accept_step(),
        instance.set_time(0.0),
        instance.set_states(&[0.0; STATES]),
        instance.states(&mut [0.0; STATES]),
        instance.derivatives(&mut [0.0; STATES]),
        instance.nominals(&mut [0.0; STATES]),
        instance.indicators(&mut [0.0; INDICATORS]),
    ];
    assert_eq!(refused, [ERROR; 10]);
    assert_eq!(instance.fingerprint(), before);
}

#[test]
fn vectors_have_the_lengths_of_the_description_and_nothing_else_is_taken() {
    let instance = integrating(STRIBECK, 7.0);
    let before = instance.fingerprint();
    for length in [0, STATES - 1, STATES + 1] {
        let mut room = vec![-7.0; length];
        assert_eq!(instance.states(&mut room), ERROR, "{length}");
        assert_eq!(instance.derivatives(&mut room), ERROR, "{length}");
        assert_eq!(instance.nominals(&mut room), ERROR, "{length}");
        assert_eq!(instance.set_states(&room), ERROR, "{length}");
        assert!(room.iter().all(|value| *value == -7.0));
    }
    assert_eq!(instance.indicators(&mut [0.0; INDICATORS + 1]), ERROR);
    for bad in [f64::NAN, f64::INFINITY] {
        let mut states = [0.0; STATES];
        assert_eq!(instance.states(&mut states), OK);
        states[STATES - 1] = bad;
        assert_eq!((instance.set_states(&states), instance.set_time(bad)), (ERROR, ERROR));
    }
    assert_eq!(instance.set_time(-1.0), ERROR);
    // SAFETY: NULL is allowed to be passed.
    unsafe {
        assert_eq!((LIBRARY.fmi2GetDerivatives)(instance.component, ptr::null_mut(), STATES), ERROR);
        assert_eq!((LIBRARY.fmi2SetContinuousStates)(instance.component, ptr::null(), STATES), ERROR);
        let mut flag = 7;
        let complete = LIBRARY.fmi2CompletedIntegratorStep;
        assert_eq!(complete(instance.component, 1, ptr::null_mut(), &mut flag), ERROR);
        assert_eq!(complete(instance.component, 1, &mut flag, ptr::null_mut()), ERROR);
        assert_eq!(flag, 7);
    }
    assert_eq!(instance.fingerprint(), before);
}

#[test]
pub fn nominals_are_those_of_the_states_or_1() {
    for model in served().into_iter().filter(|model| model.table().number_of_states() > 0) {
        let table = model.table();
        let nominal = |state| table.by_reference(state).expect("a state").variable.nominal.unwrap_or(1.0);
        let expected: Vec<f64> = table.states().map(nominal).collect();
        let instance = Instance::for_exchange(model);
        let mut nominals = vec![f64::NAN; expected.len()];
        assert_eq!(instance.nominals(&mut nominals), OK, "{:?}", instance.messages());
        assert_eq!(nominals, expected, "{}", model.name);
    }
}

/// A crude step of the host's own solver: time, states and the modes that follow.
#[test]
pub fn accepted_steps_are_counted_and_lead_where_the_host_has_gone() {
    let instance = integrating(STRIBECK, 7.0);
    let mut states = [0.0; STATES];
    assert_eq!(instance.states(&mut states), OK);
    states[0] += 1e-3;
    assert_eq!((instance.set_time(0.25), instance.set_states(&states), instance.accept_step()), (OK, OK, OK));
    assert_eq!((instance.real("time"), instance.real("position").to_bits()), (0.25, states[0].to_bits()));
    let mut steps = [-7];
    assert_eq!((instance.get_integer(&[vr("solver.steps")], &mut steps), steps), (OK, [1]));
}

/// Indicators are variables of FMI 3.0 only, and the same numbers.
#[test]
pub fn indicators_are_those_that_fmi_3_shows_as_variables() {
    const FIRST_INDICATOR: u32 = 6_000;
    let other = Instance3::cylinder(Way::Steps, STRIBECK.into(), 5.6);
    let references: Vec<u32> = (FIRST_INDICATOR..).take(INDICATORS).collect();
    let (mut expected, mut indicators) = ([f64::NAN; INDICATORS], [f64::NAN; INDICATORS]);
    assert_eq!(other.get(&references, &mut expected), OK);
    assert_eq!(integrating(STRIBECK, 5.6).indicators(&mut indicators), OK);
    assert_eq!(indicators, expected);
}

/// A solver tries what no run comes to. It gets rates that lead back; what it accepts there is refused.
#[test]
pub fn states_without_meaning_are_answered_where_a_host_tries_them_and_refused_where_it_accepts_them() {
    const REFUSAL: &str = "at t = 0 s the equations have no meaning at the given states: chamberA.pressure falls to 0";
    let instance = integrating(STRIBECK, 7.0);
    let mut states = [0.0; STATES];
    assert_eq!(instance.states(&mut states), OK);
    let right = states;
    states[2] = -1e5;
    let (mut rates, mut z) = ([-7.0; STATES], [-7.0; INDICATORS]);
    assert_eq!(
        (instance.set_states(&states), instance.derivatives(&mut rates), instance.indicators(&mut z)),
        (OK, OK, OK)
    );
    assert!(rates[2] > 0.0 && rates.iter().chain(&z).all(|number| number.is_finite() && *number != -7.0), "{rates:?}");
    assert_eq!(instance.real("chamberA.pressure"), -1e5);
    assert_eq!(instance.real("der(chamberA.pressure)").to_bits(), rates[2].to_bits());
    assert!(instance.messages().is_empty());
    let before = instance.fingerprint();
    for (function, call) in [
        ("fmi2CompletedIntegratorStep", Exchange::accept_step as fn(&Instance) -> c_int),
        ("fmi2EnterEventMode", Exchange::enter_event_mode),
    ] {
        assert_eq!((call(&instance), instance.message()), (ERROR, format!("{function}: {REFUSAL}")));
    }
    assert_eq!(instance.fingerprint(), before);
    assert_eq!((instance.set_states(&right), instance.accept_step(), instance.enter_event_mode()), (OK, OK, OK));
}

/// From one side to the other of the least pressure of a gas, 1 Pa, rates and their slopes change without a jump.
#[test]
pub fn rates_of_trial_states_go_on_smoothly_where_the_equations_lose_their_meaning() {
    let instance = integrating(STRIBECK, 7.0);
    let mut states = [0.0; STATES];
    assert_eq!(instance.states(&mut states), OK);
    let mut at = |pressure: f64| {
        states[2] = pressure;
        let (mut rates, mut slope) = ([0.0; STATES], [0.0]);
        assert_eq!((instance.set_states(&states), instance.derivatives(&mut rates)), (OK, OK));
        let (rate, state) = (vr("der(chamberA.pressure)"), vr("chamberA.pressure"));
        assert_eq!(instance.directional(&[rate], &[state], &[1.0], &mut slope), OK);
        [rates[2], slope[0]]
    };
    let (within, beyond) = (at(1.0 + 1e-7), at(1.0 - 1e-7));
    for (one, other) in within.iter().zip(beyond) {
        assert!((one - other).abs() <= 1e-6 * one.abs() + 1e-9, "{within:?} {beyond:?}");
    }
}

#[test]
pub fn states_and_derivatives_are_those_of_the_variables() {
    let instance = integrating(14, 8.0);
    euler(&instance, 3000);
    let (mut states, mut rates) = ([0.0; STATES], [0.0; STATES]);
    assert_eq!((instance.states(&mut states), instance.derivatives(&mut rates)), (OK, OK));
    let derivatives = variables().iter().filter(|variable| variable.derivative_of.is_some());
    for (number, derivative) in derivatives.enumerate() {
        let state =
            variables().iter().find(|state| Some(state.reference) == derivative.derivative_of).expect("a state");
        assert_eq!(instance.real(&state.name).to_bits(), states[number].to_bits(), "{}", state.name);
        assert_eq!(instance.real(&derivative.name).to_bits(), rates[number].to_bits(), "{}", derivative.name);
    }
    assert!(states[1] > 0.0, "it slides");
}

#[test]
fn saved_states_repeat_bit_for_bit_in_every_mode_and_in_another_instance() {
    for (law, name) in laws() {
        let instance = integrating(law, 7.5);
        euler(&instance, 500);
        let state = instance.save();
        let bytes = instance.serialize(state);
        let first = euler(&instance, 200);
        assert_eq!(instance.restore(state), OK);
        assert_eq!(euler(&instance, 200), first, "{name}");
        let other = Instance::for_exchange(cylinder());
        let (status, copy) = other.deserialize(&bytes);
        assert_eq!((status, other.restore(copy)), (OK, OK), "{name}: {:?}", other.messages());
        assert_eq!(euler(&other, 200), first, "{name} from bytes");
    }
    let instance = Instance::for_exchange(cylinder());
    let mut states = vec![instance.save()];
    assert_eq!((instance.setup(0.0, None), instance.enter()), (OK, OK));
    states.push(instance.save());
    assert_eq!(instance.exit(), OK);
    states.push(instance.save());
    assert_eq!((instance.update().0, instance.integrate()), (OK, OK));
    states.push(instance.save());
    assert_eq!(instance.terminate(), OK);
    states.push(instance.save());
    for state in states {
        let bytes = instance.serialize(state);
        let (status, copy) = instance.deserialize(&bytes);
        assert_eq!((status, instance.restore(copy)), (OK, OK));
        assert_eq!(instance.fingerprint(), bytes);
    }
}

#[test]
fn state_of_the_other_kind_is_refused() {
    let (one, other) = (Instance::initialized(), integrating(STRIBECK, 5.0));
    let (status, state) = other.deserialize(&one.fingerprint());
    assert!(status == OK && other.restore(state) == ERROR);
    assert!(other.message().contains("other kind"));
}

#[test]
fn model_without_continuous_states_is_there_for_co_simulation_only() {
    let controller = model("PositionController");
    let (messages, guid) = (Messages::default(), CString::new(fmi2::guid(controller)).expect("no zero byte"));
    // SAFETY: all strings end with zero bytes, and the messages outlive the call.
    let component =
        unsafe { (LIBRARY.fmi2Instantiate)(c"a".as_ptr(), 0, guid.as_ptr(), ptr::null(), &callbacks(&messages), 0, 0) };
    assert!(component.is_null());
    assert!(messages.lock().expect("no panic")[0].text.contains("no continuous states"));
    assert!(served().into_iter().filter(|it| it.name != controller.name).all(|it| {
        let instance = Instance::for_exchange(it);
        instance.initialize();
        instance.update().0 == OK
    }));
}

#[test]
pub fn sampled_law_announces_its_samples() {
    const DNLRX: i32 = 18;
    let instance = integrating(DNLRX, 7.0);
    assert_eq!(instance.enter_event_mode(), OK);
    let (status, info) = instance.update();
    assert_eq!((status, info.next_event_time_defined, info.new_discrete_states_needed), (OK, 1, 0));
    assert!((info.next_event_time - 1e-3).abs() < 1e-12, "{info:?}");
    assert_eq!(instance.set_time(info.next_event_time), OK);
    let (status, next) = instance.update();
    assert_eq!((status, next.values_of_continuous_states_changed), (OK, 0));
    assert!((next.next_event_time - 2e-3).abs() < 1e-12, "{next:?}");
}

/// The description gives states the values that they start from, as guesses: a host may send these back before the run, and
/// is told of any other that it comes from parameters.
#[test]
pub fn start_values_of_states_can_be_sent_back_and_no_others_are_taken() {
    let mut named = 0;
    for model in served().into_iter().filter(|model| model.table().number_of_states() > 0) {
        let starts = model.default_starts().expect("defaults that fit");
        assert_eq!(starts.len(), model.table().number_of_states(), "{}", model.name);
        let instance = Instance::for_exchange(model);
        let before = instance.fingerprint();
        for (reference, start) in &starts {
            assert_eq!(instance.set_real(&[*reference], &[*start]), OK, "{} {reference}", model.name);
            assert_eq!(instance.set_real(&[*reference], &[start + 1.0]), ERROR, "{} {reference}", model.name);
            let text = instance.message();
            assert!(text.contains("it starts from parameters and inputs"), "{text}");
            let state = model.table().by_reference(*reference).expect("a state").variable.name.clone();
            if let Some(initial) = model.table().find(&format!("{state}0")) {
                assert!(text.ends_with(&format!("set {} instead", initial.variable.name)), "{text}");
                named += 1;
            }
        }
        assert_eq!(instance.fingerprint(), before, "{}", model.name);
        instance.initialize();
        for (reference, start) in starts {
            let mut value = [f64::NAN];
            assert_eq!((instance.get_real(&[reference], &mut value), value), (OK, [start]), "{}", model.name);
        }
    }
    assert!(named > 0, "none of the states has a parameter of its own");
}

/// The refusal of a state's start value names the parameter that sets it.
#[test]
fn initial_values_are_set_by_the_parameters_that_the_refusals_name() {
    for (state, value) in
        [("position", 0.3), ("velocity", 0.01), ("chamberA.pressure", 2.5e5), ("chamberB.pressure", 1.5e5)]
    {
        let instance = Instance::for_exchange(cylinder());
        assert_eq!(instance.set_real(&[vr(state)], &[value]), ERROR);
        let text = instance.message();
        let (_, named) = text.split_once("; set ").unwrap_or_else(|| panic!("{text}"));
        let named = named.strip_suffix(" instead").expect("a parameter");
        assert_eq!(instance.set_real(&[vr(named)], &[value]), OK);
        instance.initialize();
        assert_eq!(instance.real(state), value, "{named}");
    }
}

/// Some hosts know of no other way.
#[test]
fn continuous_states_can_be_set_as_variables_where_the_host_integrates() {
    let (one, other) = (integrating(STRIBECK, 7.0), integrating(STRIBECK, 7.0));
    let mut states = [0.0; STATES];
    assert_eq!(one.states(&mut states), OK);
    (states[1], states[2]) = (0.3, 2.5e5);
    assert_eq!(one.set_states(&states), OK);
    let references = [vr("chamberA.pressure"), vr("valveVoltage"), vr("velocity")];
    assert_eq!(other.set_real(&references, &[2.5e5, 7.0, 0.3]), OK, "{:?}", other.messages());
    assert_eq!(one.fingerprint(), other.fingerprint());
    assert_eq!(one.bits(), other.bits());
    for bad in [f64::NAN, f64::INFINITY] {
        assert_eq!(other.set_real(&references, &[2e5, 5.0, bad]), ERROR);
    }
    assert_eq!(other.set_real(&[vr("acceleration")], &[0.0]), ERROR);
    assert_eq!(one.fingerprint(), other.fingerprint());
    assert_eq!(Instance::initialized().set_real(&[vr("velocity")], &[0.1]), ERROR);
}
