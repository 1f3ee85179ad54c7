//! Slopes of inputs, derivatives of outputs, directional derivatives.

use std::ptr;

use pneumatic_servo::variables::{Role, Variable};

use crate::common::*;

/// A cylinder in motion, or stuck, after 50 ms.
fn moving(law: i32, voltage: f64) -> Instance {
    let instance = Instance::with_law(law);
    assert_eq!(instance.set_real(&[vr("valveVoltage")], &[voltage]), OK);
    assert_eq!(instance.step(0.0, 0.05), OK);
    instance
}

const COULOMB: i32 = 2;
const LUGRE: i32 = 14;

#[test]
pub fn input_keeps_the_value_it_reached_and_then_stays() {
    let instance = Instance::initialized();
    assert_eq!(instance.set_real(&[vr("valveVoltage")], &[5.0]), OK);
    assert_eq!(instance.set_slopes(&[vr("valveVoltage")], &[100.0]), OK);
    assert_eq!(instance.step(0.0, 0.01), OK);
    assert_eq!(instance.real("valveVoltage"), 6.0);
    assert_eq!(instance.step(0.01, 0.01), OK);
    assert_eq!(instance.real("valveVoltage"), 6.0);
}

/// With a slope for each input, too. The numbers are binary fractions, so that sums are exact.
#[test]
fn all_inputs_together_keep_the_values_they_reached() {
    let instance = Instance::initialized();
    let first = ["valveVoltage", "externalForce", "supplyPressure", "imposedPosition", "imposedVelocity"];
    let inputs = [&first[..], &["valveVoltageA", "valveVoltageB"]].concat();
    let references_of = inputs.iter().map(|name| vr(name)).collect::<Vec<_>>();
    assert_eq!(references(is_real_input), references_of);
    let before = [5.0, 8.0, 524_288.0, 0.25, 0.5, 4.0, 6.0];
    assert_eq!(instance.set_real(&references_of, &before), OK);
    assert_eq!(instance.set_slopes(&references_of, &[128.0, 1024.0, -65_536.0, 16.0, 64.0, 128.0, -128.0]), OK);
    assert_eq!(instance.step(0.0, 1.0 / 128.0), OK);
    let reached: Vec<f64> = inputs.iter().map(|name| instance.real(name)).collect();
    assert_eq!(reached, [6.0, 16.0, 523_776.0, 0.375, 1.0, 5.0, 5.0]);
}

#[test]
fn ramp_by_slopes_is_the_limit_of_small_steps() {
    let (ramp, stairs) = (Instance::with_law(LUGRE), Instance::with_law(LUGRE));
    let (voltage, force) = (vr("valveVoltage"), vr("externalForce"));
    assert_eq!(ramp.set_slopes(&[voltage, force], &[40.0, 200.0]), OK);
    assert_eq!(ramp.step(0.0, 0.05), OK);
    let count = 2000;
    let size = 0.05 / f64::from(count);
    for index in 0..count {
        // The middle of the ramp within each small step.
        let time = (f64::from(index) + 0.5) * size;
        assert_eq!(stairs.set_real(&[voltage, force], &[5.0 + 40.0 * time, 200.0 * time]), OK);
        assert_eq!(stairs.step(f64::from(index) * size, size), OK);
    }
    let (moved, expected) = (ramp.real("position") - 0.25, stairs.real("position") - 0.25);
    assert!(expected.abs() > 1e-4, "{expected}: it moves");
    assert!((moved - expected).abs() < 1e-3 * expected.abs(), "{moved}, not {expected}");
    let (pressure, expected) = (ramp.real("chamberA.pressure"), stairs.real("chamberA.pressure"));
    assert!((pressure - expected).abs() < 1e-3 * expected, "{pressure}, not {expected}");
}

#[test]
fn input_derivatives_are_checked_as_a_whole() {
    let instance = Instance::initialized();
    let before = instance.fingerprint();
    let voltage = vr("valveVoltage");
    let cases = [(voltage, 0, 1.0), (voltage, 2, 1.0), (voltage, -1, 1.0), (voltage, 1, f64::NAN)];
    for (reference, order, value) in
        cases.into_iter().chain(["position", "mass.moving", "time"].map(|name| (vr(name), 1, 1.0)))
    {
        let references = [vr("externalForce"), reference];
        assert_eq!(instance.set_input_derivatives(&references, &[1, order], &[5.0, value]), ERROR);
    }
    assert_eq!(instance.fingerprint(), before);
}

#[test]
fn slope_below_zero_supply_is_refused_before_the_step() {
    let instance = Instance::initialized();
    assert_eq!(instance.set_slopes(&[vr("supplyPressure")], &[-1e8]), OK);
    assert_eq!(instance.step(0.0, 0.01), ERROR);
    assert!(instance.message().contains("supplyPressure"));
    assert_eq!(instance.real("time"), 0.0);
    assert_eq!(instance.set_slopes(&[vr("supplyPressure")], &[-1e7]), OK);
    assert_eq!(instance.step(0.0, 0.01), OK);
}

#[test]
pub fn every_real_output_has_a_derivative_that_matches_its_course() {
    let outputs = references(|variable| variable.role == Role::Output && is_real(variable));
    let instance = moving(LUGRE, 7.0);
    let state = instance.save();
    let read = |instance: &Instance| {
        let mut values = vec![f64::NAN; outputs.len()];
        assert_eq!(instance.get_real(&outputs, &mut values), OK);
        values
    };
    let mut rates = vec![f64::NAN; outputs.len()];
    assert_eq!(instance.output_derivatives(&outputs, &vec![1; outputs.len()], &mut rates), OK);
    let (now, size) = (read(&instance), 1e-6);
    assert_eq!(instance.step(0.05, size), OK);
    let later = read(&instance);
    assert_eq!(instance.step(0.05 + size, size), OK);
    let last = read(&instance);
    for (index, reference) in outputs.iter().enumerate() {
        let name = &variables().iter().find(|variable| variable.reference == *reference).expect("an output").name;
        // Differences at the start of the course, with their own slope removed.
        let difference = (-1.5 * now[index] + 2.0 * later[index] - 0.5 * last[index]) / size;
        let noise = 1e-9 * now[index].abs() / size;
        let rate = rates[index];
        assert!((rate - difference).abs() <= 1e-3 * rate.abs() + noise, "{name}: {rate}, not about {difference}");
    }
    assert_eq!(instance.restore(state), OK);
    assert_eq!(rates[0].to_bits(), instance.real("velocity").to_bits(), "the rate of the position");
}

#[test]
fn output_derivatives_are_of_order_one_of_real_outputs() {
    let instance = moving(LUGRE, 7.0);
    let position = vr("position");
    for (reference, order) in [(position, 0), (position, 2), (vr("valveVoltage"), 1), (vr("sticking"), 1), (9999, 1)] {
        let mut values = [-1.0, -2.0];
        assert_eq!(instance.output_derivatives(&[position, reference], &[1, order], &mut values), ERROR);
        assert_eq!(values, [-1.0, -2.0]);
    }
}

fn is_state(variable: &Variable) -> bool {
    variables().iter().any(|other| other.derivative_of == Some(variable.reference))
}

fn unknowns() -> Vec<&'static Variable> {
    let unknown =
        |variable: &&Variable| is_real(variable) && (variable.role == Role::Output || variable.derivative_of.is_some());
    variables().iter().filter(unknown).collect()
}

fn column(instance: &Instance, known: u32) -> Vec<f64> {
    let unknowns: Vec<_> = unknowns().iter().map(|variable| variable.reference).collect();
    let mut derivatives = vec![f64::NAN; unknowns.len()];
    assert_eq!(instance.directional(&unknowns, &[known], &[1.0], &mut derivatives), OK, "{:?}", instance.messages());
    derivatives
}

#[test]
fn directional_derivatives_by_inputs_match_differences() {
    for (law, voltage) in [(1, 6.0), (COULOMB, 7.0), (LUGRE, 7.0), (LUGRE, 5.0)] {
        let instance = moving(law, voltage);
        let state = instance.save();
        for (input, step) in [("valveVoltage", 1e-4), ("externalForce", 1e-2), ("supplyPressure", 10.0)] {
            let derivatives = column(&instance, vr(input));
            let base = instance.real(input);
            let at = |value: f64| {
                assert_eq!(instance.set_real(&[vr(input)], &[value]), OK);
                unknowns().iter().map(|variable| instance.real(&variable.name)).collect::<Vec<_>>()
            };
            let (above, now, below) = (at(base + step), at(base), at(base - step));
            assert_eq!(instance.restore(state), OK);
            for (index, unknown) in unknowns().iter().enumerate() {
                let difference = (above[index] - below[index]) / (2.0 * step);
                let noise = 1e-12 * above[index].abs() / step;
                let exact = derivatives[index];
                let sides = [(above[index], now[index]), (now[index], below[index])];
                let is_near = |difference: f64| (exact - difference).abs() <= 1e-6 * exact.abs() + noise;
                // The valve's play has a corner where the command pushes it; there the derivative is one-sided.
                let at_corner = sides.iter().any(|(after, before)| is_near((after - before) / step));
                assert!(
                    is_near(difference) || (input == "valveVoltage" && at_corner),
                    "law {law}: d {} / d {input} = {exact}, not about {difference}",
                    unknown.name
                );
            }
        }
    }
}

/// Sliding, so that what changes with the parameters sets off no event.
#[test]
fn directional_derivatives_by_tunable_parameters_match_differences() {
    const PARAMETERS: [(&str, f64); 5] = [
        ("friction.lugre.Fs", 1e-3),
        ("friction.lugre.sigma2", 1e-2),
        ("valve.C", 1e-13),
        ("supplyTemperature", 1e-2),
        ("wireForce", 1e-2),
    ];
    let instance = moving(LUGRE, 7.0);
    let state = instance.save();
    for (parameter, step) in PARAMETERS {
        let derivatives = column(&instance, vr(parameter));
        assert!(derivatives.iter().any(|derivative| *derivative != 0.0), "{parameter}");
        let base = instance.real(parameter);
        let at = |value: f64| {
            assert_eq!(instance.set_real(&[vr(parameter)], &[value]), OK);
            let values = unknowns().iter().map(|variable| instance.real(&variable.name)).collect::<Vec<_>>();
            assert_eq!(instance.restore(state), OK);
            values
        };
        let (above, below) = (at(base + step), at(base - step));
        for (index, unknown) in unknowns().iter().enumerate() {
            let (difference, exact) = ((above[index] - below[index]) / (2.0 * step), derivatives[index]);
            let magnitude = above[index].abs().max(unknown.nominal.unwrap_or(1.0));
            let bound = 1e-6 * exact.abs() + 1e-12 * magnitude / step;
            assert!(
                (exact - difference).abs() <= bound,
                "d {} / d {parameter} = {exact}, not {difference}",
                unknown.name
            );
        }
    }
}

#[test]
fn directional_derivatives_are_linear() {
    let instance = moving(LUGRE, 7.0);
    let unknowns: Vec<_> = unknowns().iter().map(|variable| variable.reference).collect();
    let knowns = ["externalForce", "chamberA.pressure", "velocity", "valve.C", "friction.lugre.Fc"].map(vr);
    let seeds = [2.0, -3e4, 0.5, 1e-9, 3.0];
    let mut together = vec![f64::NAN; unknowns.len()];
    assert_eq!(instance.directional(&unknowns, &knowns, &seeds, &mut together), OK);
    let columns = knowns.map(|known| column(&instance, known));
    for (index, together) in together.into_iter().enumerate() {
        let terms: Vec<_> = columns.iter().zip(seeds).map(|(column, seed)| column[index] * seed).collect();
        let sum: f64 = terms.iter().sum();
        let scale = terms.iter().fold(0.0f64, |scale, term| scale.max(term.abs()));
        assert!((together - sum).abs() <= 1e-14 * scale, "{together}, not {sum}");
    }
}

/// The slider's tray depends on time alone, in closed form a sine.
#[test]
fn derivatives_by_time_hold_inputs_and_states() {
    let slider = model("DrivenSlider");
    let variables = slider.table();
    let find = |name: &str| variables.find(name).expect("a variable").variable.reference;
    let instance = Instance::of(slider);
    instance.initialize();
    assert_eq!(instance.step(0.0, 0.0137), OK);
    let (names, rate) = (["tray.position", "tray.velocity", "tray.acceleration"], find("tray.velocity"));
    let references = names.map(find);
    let (mut values, mut slopes) = ([f64::NAN; 3], [f64::NAN; 3]);
    assert_eq!(instance.get_real(&references, &mut values), OK);
    assert_eq!(
        instance.directional(&references, &[find("time")], &[1.0], &mut slopes),
        OK,
        "{:?}",
        instance.messages()
    );
    for (index, slope) in slopes.iter().take(2).enumerate() {
        let next = values[index + 1];
        assert!((slope - next).abs() <= 1e-12 * next.abs().max(1.0), "{}: {slope}, not {next}", names[index]);
    }
    let mut twice = [f64::NAN];
    assert_eq!(instance.directional(&[rate], &[find("time")], &[2.0], &mut twice), OK);
    assert_eq!(twice[0], 2.0 * slopes[1]);
    // The cylinder depends on time through inputs and states only.
    let cylinder = moving(LUGRE, 7.0);
    assert!(column(&cylinder, vr("time")).iter().all(|slope| *slope == 0.0));
}

#[test]
fn arrays_may_overlap() {
    let instance = moving(LUGRE, 7.0);
    let knowns = [vr("externalForce"), vr("chamberA.pressure"), vr("velocity")];
    let unknowns = [vr("acceleration"), vr("der(chamberA.pressure)"), vr("frictionForce")];
    let seeds = [2.0, -3e4, 0.5];
    let mut apart = [f64::NAN; 3];
    assert_eq!(instance.directional(&unknowns, &knowns, &seeds, &mut apart), OK);

    let mut shared = seeds;
    let array = shared.as_mut_ptr();
    // SAFETY: of the component; the array has as many elements as are read and written.
    let status = unsafe {
        (LIBRARY.fmi2GetDirectionalDerivative)(
            instance.component,
            unknowns.as_ptr(),
            3,
            knowns.as_ptr(),
            3,
            array.cast_const(),
            array,
        )
    };
    assert_eq!((status, shared), (OK, apart), "seeds and derivatives");

    // References in the first half of the room for the values, which are written over them.
    let mut read = [f64::NAN; 3];
    assert_eq!(instance.get_real(&unknowns, &mut read), OK);
    let mut room = [0u64; 3];
    let references = room.as_mut_ptr().cast::<u32>();
    // SAFETY: of the component; the room holds three references or three values.
    let status = unsafe {
        ptr::copy_nonoverlapping(unknowns.as_ptr(), references, 3);
        (LIBRARY.fmi2GetReal)(instance.component, references.cast_const(), 3, references.cast())
    };
    assert_eq!((status, room.map(f64::from_bits)), (OK, read), "references and values");

    let outputs = [vr("position"), vr("velocity"), vr("acceleration")];
    assert_eq!(instance.output_derivatives(&outputs, &[1, 1, 1], &mut read), OK);
    let mut room = [0u64; 3];
    let orders = room.as_mut_ptr().cast::<i32>();
    // SAFETY: of the component; the room holds three orders or three values.
    let status = unsafe {
        ptr::copy_nonoverlapping([1, 1, 1].as_ptr(), orders, 3);
        let get = LIBRARY.fmi2GetRealOutputDerivatives;
        get(instance.component, outputs.as_ptr(), 3, orders.cast_const(), orders.cast())
    };
    assert_eq!((status, room.map(f64::from_bits)), (OK, read), "orders and values");
}

#[test]
pub fn force_accelerates_the_mass_and_nothing_else() {
    let instance = moving(COULOMB, 7.0);
    assert!(instance.real("velocity") > 0.0);
    for (unknown, derivative) in unknowns().iter().zip(column(&instance, vr("externalForce"))) {
        let expected = match &*unknown.name {
            "acceleration" => 1.0 / 0.88,
            "rodForce" | "sensor.force.reading" => 0.75 / 0.88 - 1.0,
            _ => 0.0,
        };
        assert!((derivative - expected).abs() < 1e-15, "{}: {derivative}, not {expected}", unknown.name);
    }
}

#[test]
fn stuck_carriage_answers_force_with_friction() {
    let instance = moving(COULOMB, 5.0);
    assert_eq!(instance.real("velocity"), 0.0);
    for (unknown, derivative) in unknowns().iter().zip(column(&instance, vr("externalForce"))) {
        let expected = match &*unknown.name {
            "frictionForce" => 1.0,
            "rodForce" | "sensor.force.reading" => -1.0,
            _ => 0.0,
        };
        assert!((derivative - expected).abs() < 1e-15, "{}: {derivative}, not {expected}", unknown.name);
    }
}

#[test]
fn nothing_depends_on_what_the_model_structure_does_not_name() {
    for (law, _) in laws() {
        for voltage in [5.0, 8.0] {
            let instance = moving(law, voltage);
            for known in variables().iter().filter(|variable| is_real_input(variable) || is_state(variable)) {
                for (unknown, derivative) in unknowns().iter().zip(column(&instance, known.reference)) {
                    let named = unknown.depends_on.as_ref().is_none_or(|all| all.contains(&known.reference));
                    assert!(named || derivative == 0.0, "law {law}: {} by {}: {derivative}", unknown.name, known.name);
                }
            }
        }
    }
}

#[test]
fn state_derivatives_are_those_of_the_states() {
    let instance = moving(LUGRE, 7.0);
    for variable in variables() {
        let Some(state) = variable.derivative_of else { continue };
        let mut rate = [f64::NAN];
        let role = variables().iter().find(|other| other.reference == state).expect("a state").role;
        if role == Role::Output {
            assert_eq!(instance.output_derivatives(&[state], &[1], &mut rate), OK);
            assert_eq!(rate[0].to_bits(), instance.real(&variable.name).to_bits(), "{}", variable.name);
        }
    }
}

#[test]
fn directional_derivative_refuses_other_knowns_and_unknowns() {
    let instance = moving(LUGRE, 7.0);
    let (position, force) = (vr("position"), vr("externalForce"));
    let mut written = [-1.0, -2.0];
    for known in ["mass.moving", "frictionForce", "friction.law"] {
        assert_eq!(instance.directional(&[position, position], &[vr(known)], &[1.0], &mut written), ERROR, "{known}");
        assert!(instance.message().contains(known), "{:?}", instance.message());
    }
    for unknown in ["mass.moving", "externalForce", "time", "sticking"] {
        let unknowns = [position, vr(unknown)];
        assert_eq!(instance.directional(&unknowns, &[force], &[1.0], &mut written), ERROR, "{unknown}");
    }
    for seed in [f64::NAN, f64::INFINITY] {
        assert_eq!(instance.directional(&[position, position], &[force], &[seed], &mut written), ERROR);
    }
    assert_eq!(written, [-1.0, -2.0]);
}

#[test]
fn asking_for_derivatives_does_not_change_the_run() {
    let (curious, plain) = (Instance::initialized(), Instance::initialized());
    for _ in 0..30 {
        column(&curious, vr("valveVoltage"));
        let mut rate = [f64::NAN];
        assert_eq!(curious.output_derivatives(&[vr("acceleration")], &[1], &mut rate), OK);
        assert_eq!(curious.swing(1), plain.swing(1));
    }
    assert_eq!(curious.fingerprint(), plain.fingerprint());
}

#[test]
fn directional_derivatives_are_there_during_initialization() {
    let instance = Instance::new();
    assert_eq!(instance.set_integer(&[vr("friction.law")], &[1]), OK);
    assert_eq!(instance.enter(), OK);
    let mut derivative = [f64::NAN];
    assert_eq!(instance.directional(&[vr("acceleration")], &[vr("externalForce")], &[0.88], &mut derivative), OK);
    assert!((derivative[0] - 1.0).abs() < 1e-15);
}
