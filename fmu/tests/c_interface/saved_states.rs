//! Saved and serialized states.

use std::env;
use std::fs;
use std::process::Command;
use std::ptr;

use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Kind, Variable, units};

use crate::common::*;

#[test]
fn restored_run_repeats_bit_for_bit_for_every_law() {
    for (law, name) in laws() {
        let instance = Instance::with_law(law);
        instance.swing(40);
        let state = instance.save();
        let first = instance.swing(30);
        assert_eq!(instance.restore(state), OK);
        assert_eq!(instance.swing(30), first, "{name}");
    }
}

/// A model under one of its friction laws, with swinging inputs that let it slide, stick and hit its ends.
struct Swinging {
    instance: Instance,
    model: &'static Model,
    size: f64,
}

impl Swinging {
    fn new(model: &'static Model, law: Option<i32>) -> Self {
        let instance = Instance::of(model);
        let table = model.table();
        if let (Some(law), Some(variable)) = (law, table.find("friction.law")) {
            assert_eq!(instance.set_integer(&[variable.variable.reference], &[law]), OK);
        }
        if let Some(balance) = table.find("balance.enabled") {
            assert_eq!(instance.set_boolean(&[balance.variable.reference], &[1]), OK);
        }
        Self { instance, model, size: 1e-3 * model.experiment.stop_time }
    }

    /// Everything that can be read after each of some steps, bit for bit.
    fn run(&self, steps: std::ops::Range<u32>) -> Vec<Vec<u64>> {
        steps.map(|step| self.step(step)).collect()
    }

    fn step(&self, step: u32) -> Vec<u64> {
        for (number, input) in self.model.table().inputs().enumerate() {
            let start = input.start.expect("inputs have start values");
            let amplitude = match input.kind {
                Kind::Real(units::NEWTON) => 20.0,
                _ => 0.4 * start.abs() + 0.05,
            };
            let phase = f64::from(step) * (0.7 + 0.3 * number as f64);
            let (reference, value) = ([input.reference], start + amplitude * phase.sin());
            let status = match input.kind {
                Kind::Boolean => self.instance.set_boolean(&reference, &[(value > 0.0).into()]),
                _ => self.instance.set_real(&reference, &[value]),
            };
            assert_eq!(status, OK, "{}", input.name);
        }
        let status = self.instance.step(f64::from(step) * self.size, self.size);
        assert_eq!(status, OK, "{}: {:?}", self.model.name, self.instance.messages());
        self.look()
    }

    fn look(&self) -> Vec<u64> {
        let value = |variable: &Variable| {
            let (mut real, mut integer, reference) = ([f64::NAN], [0], [variable.reference]);
            let status = match variable.kind {
                Kind::Real(_) => self.instance.get_real(&reference, &mut real),
                Kind::Boolean => self.instance.get_boolean(&reference, &mut integer),
                _ => self.instance.get_integer(&reference, &mut integer),
            };
            assert_eq!(status, OK, "{}", variable.name);
            if is_real(variable) { real[0].to_bits() } else { integer[0] as u64 }
        };
        self.model.table().iter().map(value).collect()
    }
}

/// In the same instance and from bytes in another one: a field of a memory that is not saved shows in what follows, since
/// the history before has given it a value of its own.
fn assert_restored_run_repeats(model: &'static Model, law: Option<i32>) {
    let one = Swinging::new(model, law);
    one.instance.initialize();
    one.run(0..40);
    let state = one.instance.save();
    let bytes = one.instance.serialize(state);
    let first = one.run(40..70);
    assert_eq!(one.instance.restore(state), OK);
    assert!(one.run(40..70) == first, "{} {law:?}", model.name);
    let other = Swinging::new(model, None);
    let (status, state) = other.instance.deserialize(&bytes);
    assert_eq!((status, other.instance.restore(state)), (OK, OK), "{} {law:?}", model.name);
    assert!(other.run(40..70) == first, "{} {law:?} from bytes", model.name);
}

#[test]
fn restored_run_repeats_bit_for_bit_in_every_model() {
    served().into_iter().for_each(|model| assert_restored_run_repeats(model, None));
}

#[test]
fn restored_run_repeats_bit_for_bit_in_every_model_for_every_law() {
    for model in served().into_iter().filter(|model| model.table().find("friction.law").is_some()) {
        laws().into_iter().for_each(|(law, _)| assert_restored_run_repeats(model, Some(law)));
    }
}

#[test]
fn restored_run_includes_inputs_slopes_and_tuned_parameters() {
    let continuation = |instance: &Instance| {
        let time = instance.real("time");
        assert_eq!(instance.step(time, 2e-3), OK);
        let reached = instance.bits();
        [vec![reached], instance.swing(5)].concat()
    };
    let instance = Instance::initialized();
    instance.swing(10);
    assert_eq!(instance.set_real(&[vr("valveVoltage"), vr("wireForce")], &[6.5, 3.0]), OK);
    assert_eq!(instance.set_slopes(&[vr("valveVoltage")], &[250.0]), OK);
    let state = instance.save();
    let first = continuation(&instance);
    assert_eq!(instance.set_real(&[vr("wireForce")], &[1.0]), OK);
    assert_eq!(instance.restore(state), OK);
    assert_eq!(instance.real("wireForce"), 3.0);
    assert_eq!(continuation(&instance), first);
    assert_eq!(instance.reset(), OK);
    assert_eq!(instance.restore(state), OK);
    assert_eq!(continuation(&instance), first);
}

/// A state goes on with the tolerance of its own experiment, though another has begun since.
#[test]
fn restored_run_includes_the_tolerance_of_the_experiment() {
    let begin = |instance: &Instance, tolerance: f64| {
        // SAFETY: of the component.
        let status = unsafe { (LIBRARY.fmi2SetupExperiment)(instance.component, 1, tolerance, 0.0, 0, 0.0) };
        assert_eq!((status, instance.enter(), instance.exit()), (OK, OK, OK));
        instance.swing(10)
    };
    let instance = Instance::new();
    begin(&instance, 1e-3);
    let state = instance.save();
    let first = instance.swing(10);
    assert_eq!(instance.reset(), OK);
    begin(&instance, 1e-9);
    assert_ne!(instance.swing(10), first);
    assert_eq!(instance.restore(state), OK);
    assert_eq!(instance.swing(10), first);
}

#[test]
fn many_states_may_be_held_and_used_in_any_order() {
    let instance = Instance::initialized();
    let mut states: Vec<_> = (0..50).map(|_| (instance.save(), instance.swing(1))).collect();
    for (state, next) in states.iter().rev() {
        assert_eq!(instance.restore(*state), OK);
        assert_eq!(instance.swing(1), *next);
    }
    for (state, _) in &mut states {
        assert_eq!(instance.forget(state), OK);
        assert!(state.is_null());
        assert_eq!(instance.forget(state), OK, "nothing to free");
    }
}

#[test]
fn state_may_be_saved_over() {
    let instance = Instance::initialized();
    let mut state = instance.save();
    instance.swing(3);
    let handle = state;
    // SAFETY: of the component.
    assert_eq!(unsafe { (LIBRARY.fmi2GetFMUstate)(instance.component, &mut state) }, OK);
    assert_eq!(state, handle);
    let next = instance.swing(1);
    assert_eq!(instance.restore(state), OK);
    assert_eq!(instance.swing(1), next);
}

#[test]
pub fn null_foreign_and_freed_states_are_refused() {
    let (instance, other) = (Instance::initialized(), Instance::initialized());
    let mut freed = instance.save();
    let stale = freed;
    assert_eq!(instance.forget(&mut freed), OK);
    let before = instance.fingerprint();
    for state in [other.save(), stale, ptr::null_mut(), ptr::without_provenance_mut(1)] {
        assert_eq!(instance.restore(state), ERROR);
        let (component, mut size, mut bytes, mut copy) = (instance.component, 0, [0; 8], state);
        // SAFETY: of the component; the handles are only compared.
        unsafe {
            assert_eq!((LIBRARY.fmi2SerializedFMUstateSize)(component, state, &mut size), ERROR);
            assert_eq!((LIBRARY.fmi2SerializeFMUstate)(component, state, bytes.as_mut_ptr(), 8), ERROR);
            if !state.is_null() {
                assert_eq!((LIBRARY.fmi2GetFMUstate)(component, &mut copy), ERROR);
                assert_eq!(instance.forget(&mut copy), ERROR);
            }
        }
        let told = if state.is_null() { "the FMU state is NULL" } else { "the FMU state is not one of this instance" };
        let messages = instance.messages();
        assert_eq!(messages.len(), if state.is_null() { 3 } else { 5 });
        assert!(messages.iter().all(|message| message.text.contains(told)), "{messages:?}");
    }
    // SAFETY: NULL is allowed to be passed.
    unsafe {
        let (component, state) = (instance.component, instance.save());
        assert_eq!((LIBRARY.fmi2FreeFMUstate)(component, ptr::null_mut()), OK);
        assert_eq!((LIBRARY.fmi2GetFMUstate)(component, ptr::null_mut()), ERROR);
        assert_eq!((LIBRARY.fmi2SerializedFMUstateSize)(component, state, ptr::null_mut()), ERROR);
        let bytes = instance.serialize(state);
        assert_eq!((LIBRARY.fmi2SerializeFMUstate)(component, state, ptr::null_mut(), bytes.len()), ERROR);
        let mut state = ptr::null_mut();
        assert_eq!((LIBRARY.fmi2DeSerializeFMUstate)(component, ptr::null(), bytes.len(), &mut state), ERROR);
        assert_eq!((LIBRARY.fmi2DeSerializeFMUstate)(component, bytes.as_ptr(), bytes.len(), ptr::null_mut()), ERROR);
    }
    assert_eq!(instance.fingerprint(), before);
}

#[test]
fn handle_of_a_freed_state_stays_refused_whatever_is_saved_later() {
    let instance = Instance::initialized();
    let mut first = instance.save();
    let stale = first;
    assert_eq!(instance.forget(&mut first), OK);
    let later: Vec<_> = (0..100).map(|_| instance.save()).collect();
    assert!(!later.contains(&stale));
    assert_eq!(instance.restore(stale), ERROR);
}

#[test]
pub fn serialized_state_continues_in_another_instance() {
    for (law, name) in laws() {
        let one = Instance::with_law(law);
        one.swing(40);
        let bytes = one.serialize(one.save());
        let other = Instance::new();
        let (status, state) = other.deserialize(&bytes);
        assert_eq!(status, OK, "{:?}", other.messages());
        assert_eq!(other.restore(state), OK);
        assert_eq!(other.swing(20), one.swing(20), "{name}");
        assert_eq!(other.fingerprint(), one.fingerprint(), "{name}");
    }
}

#[test]
fn state_of_any_phase_is_serialized() {
    let instance = Instance::new();
    let mut states = vec![instance.save()];
    assert_eq!((instance.setup(0.0, None), instance.enter()), (OK, OK));
    states.push(instance.save());
    assert_eq!((instance.exit(), instance.terminate()), (OK, OK));
    states.push(instance.save());
    for state in states {
        let bytes = instance.serialize(state);
        let (status, copy) = instance.deserialize(&bytes);
        assert_eq!(status, OK);
        assert_eq!(instance.restore(copy), OK);
        assert_eq!(instance.fingerprint(), bytes);
    }
}

/// The host's variable is only written: it may hold anything, and a state in it stays.
#[test]
fn state_is_deserialized_beside_the_one_that_the_variable_held() {
    let instance = Instance::initialized();
    let first = instance.save();
    let before = instance.fingerprint();
    assert_eq!(instance.step(0.0, 0.1), OK);
    let after = instance.fingerprint();
    let mut variable = first;
    // SAFETY: of the component, and there are as many bytes.
    let status =
        unsafe { (LIBRARY.fmi2DeSerializeFMUstate)(instance.component, after.as_ptr(), after.len(), &mut variable) };
    assert_eq!(status, OK);
    assert_ne!(variable, first);
    for (state, expected) in [(first, before), (variable, after)] {
        assert_eq!(instance.restore(state), OK);
        assert_eq!(instance.fingerprint(), expected);
    }
}

#[test]
fn size_must_be_the_one_that_was_told() {
    let instance = Instance::initialized();
    let state = instance.save();
    let length = instance.serialize(state).len();
    let mut room = vec![7; length + 8];
    for size in [0, 1, length - 1, length + 1, usize::MAX] {
        // SAFETY: of the component; no size that is too large is written to.
        let status = unsafe { (LIBRARY.fmi2SerializeFMUstate)(instance.component, state, room.as_mut_ptr(), size) };
        assert_eq!(status, ERROR, "{size}");
        assert!(instance.message().contains(&length.to_string()));
    }
    assert!(room.iter().all(|byte| *byte == 7));
}

/// There are hosts that ask for the size once.
#[test]
fn serialized_states_of_a_model_have_one_size_whatever_the_law_and_the_time() {
    for model in served() {
        let size = Instance::of(model).fingerprint().len();
        let has_laws = model.table().find("friction.law").is_some();
        for law in if has_laws { laws().into_iter().map(|(law, _)| Some(law)).collect() } else { vec![None] } {
            let run = Swinging::new(model, law);
            let assert_size = || assert_eq!(run.instance.fingerprint().len(), size, "{} {law:?}", model.name);
            run.instance.initialize();
            assert_size();
            let state = run.instance.save();
            for step in (0..60).step_by(5) {
                run.run(step..step + 5);
                assert_size();
            }
            let (status, copy) = run.instance.deserialize(&run.instance.fingerprint());
            for state in [state, copy] {
                assert_eq!((status, run.instance.restore(state)), (OK, OK));
                assert_size();
            }
        }
        if model.table().number_of_states() > 0 {
            let exchanging = Instance::for_exchange(model);
            exchanging.initialize();
            assert_eq!(exchanging.fingerprint().len(), size, "{}", model.name);
        }
    }
}

#[test]
fn corrupt_bytes_are_refused_with_a_message() {
    let instance = Instance::initialized();
    instance.swing(10);
    let bytes = instance.serialize(instance.save());
    let refused = |bytes: &[u8], what: &str| {
        let (status, state) = instance.deserialize(bytes);
        assert!(status == ERROR && state.is_null(), "{what}");
        assert!(instance.message().starts_with("fmi2DeSerializeFMUstate: "));
    };
    for bit in 0..8 * bytes.len() {
        let mut bytes = bytes.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        refused(&bytes, &format!("bit {bit}"));
    }
    for length in 0..bytes.len() {
        refused(&bytes[..length], &format!("{length} bytes"));
    }
    refused(&[&bytes[..], &[0]].concat(), "a byte too many");
    refused(&vec![0; bytes.len()], "zeros");
    refused(b"PSCstate", "only the start");
}

#[test]
fn state_of_another_model_is_refused() {
    let other = Instance::of(model("FrictionBench"));
    let bytes = other.serialize(other.save());
    let instance = Instance::new();
    assert_eq!(instance.deserialize(&bytes).0, ERROR);
    assert!(instance.message().contains("belongs to"));
}

#[test]
fn bytes_hold_no_pointers() {
    let at_different_addresses = || {
        let instance = Instance::initialized();
        instance.swing(10);
        (instance.fingerprint(), instance)
    };
    let (one, _keep) = at_different_addresses();
    let (other, _) = at_different_addresses();
    assert_eq!(one, other);
}

const STATE_FILE: &str = "SERVO_TEST_STATE";

/// Continues the run in the file that the environment names and appends what it sees to the file.
#[test]
fn child_of_the_test_with_another_process() {
    let Some(path) = env::var_os(STATE_FILE) else { return };
    let bytes = fs::read(&path).expect("the state");
    let instance = Instance::new();
    let (status, state) = instance.deserialize(&bytes);
    assert_eq!((status, instance.restore(state)), (OK, OK), "{:?}", instance.messages());
    fs::write(path, format!("{:?}", instance.swing(50))).expect("a writable file");
}

#[test]
fn serialized_state_continues_in_another_process() {
    for (law, name) in laws() {
        let instance = Instance::with_law(law);
        instance.swing(60);
        let path = env::temp_dir().join(format!("servo-state-{}-{law}", std::process::id()));
        fs::write(&path, instance.serialize(instance.save())).expect("a writable file");
        let mut child = Command::new(env::current_exe().expect("the test's own path"));
        child.args(["--exact", "saved_states::child_of_the_test_with_another_process"]).env(STATE_FILE, &path);
        // The variable names another library of the same source, so that what one has saved goes on in the other.
        if let Some(library) = env::var_os("FMU_LIBRARY_OF_CHILD") {
            child.env("FMU_LIBRARY", library);
        }
        let child = child.output().expect("a process");
        assert!(child.status.success(), "{}", String::from_utf8_lossy(&child.stdout));
        let seen = fs::read_to_string(&path).expect("what the child saw");
        fs::remove_file(&path).expect("a removable file");
        assert_eq!(seen, format!("{:?}", instance.swing(50)), "{name}");
    }
}
