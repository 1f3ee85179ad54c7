//! Allocations of the C functions. The functions are linked into this test, so that its allocator counts.

#![allow(unsafe_code, reason = "a C interface is called, and an allocator made")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;

use pneumatic_servo::friction::LAWS;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Role, Variable};
use pneumatic_servo_builtin::{FMI2, FMI3};
use pneumatic_servo_fmu::fmi2;
use pneumatic_servo_fmu::fmi2::exports::*;
use pneumatic_servo_fmu::fmi2::types::{ERROR, OK};
use pneumatic_servo_fmu::fmi3::exports::*;

/// Counts allocations of a thread while it is told to, and the bytes in use; grants no block above a size.
struct Counting;

thread_local! {
    static COUNTS: Cell<bool> = const { Cell::new(false) };
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    static BYTES: Cell<i64> = const { Cell::new(0) };
    static LARGEST: Cell<usize> = const { Cell::new(usize::MAX) };
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// SAFETY: all is left to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.size() > LARGEST.get() {
            return ptr::null_mut();
        }
        if COUNTS.get() {
            ALLOCATIONS.set(ALLOCATIONS.get() + 1);
            BYTES.set(BYTES.get() + layout.size() as i64);
        }
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        if COUNTS.get() {
            BYTES.set(BYTES.get() - layout.size() as i64);
        }
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// Allocations, and growth in bytes, during some work.
fn counted(work: impl FnOnce()) -> (u64, i64) {
    ALLOCATIONS.set(0);
    BYTES.set(0);
    COUNTS.set(true);
    work();
    COUNTS.set(false);
    (ALLOCATIONS.get(), BYTES.get())
}

fn reference(name: &str) -> u32 {
    models::ALL[0].table().iter().find(|variable| variable.name == name).expect("a variable").reference
}

fn instantiate(guid: &CString) -> *mut c_void {
    // SAFETY: all strings end with zero bytes.
    let component = unsafe { (FMI2.fmi2Instantiate)(c"a".as_ptr(), 1, guid.as_ptr(), ptr::null(), ptr::null(), 0, 0) };
    assert!(!component.is_null());
    component
}

fn guid() -> CString {
    CString::new(fmi2::guid(&models::ALL[0])).expect("no zero byte")
}

fn laws() -> Vec<i32> {
    LAWS.items.iter().map(|(id, ..)| *id).collect()
}

#[test]
fn stepping_setting_and_getting_allocate_nothing() {
    let (law, inputs) = (reference("friction.law"), [reference("valveVoltage"), reference("externalForce")]);
    let outputs = [reference("position"), reference("chamberA.pressure"), reference("frictionForce")];
    let (sticking, counter) = (reference("sticking"), reference("solver.steps"));
    for id in laws() {
        let component = instantiate(&guid());
        // SAFETY: of the component, and all arrays have the length that is passed.
        unsafe {
            assert_eq!(fmi2SetInteger(component, &law, 1, &id), OK);
            assert_eq!(fmi2EnterInitializationMode(component), OK);
            assert_eq!(fmi2ExitInitializationMode(component), OK);
            let mut failed = 0;
            let (allocations, _) = counted(|| {
                for index in 0..STEPS {
                    let time = f64::from(index) * 1e-3;
                    let values = [5.0 + 3.0 * (40.0 * time).sin(), 20.0 * (70.0 * time).sin()];
                    let (mut reals, mut integer): ([f64; 3], c_int) = ([0.0; 3], 0);
                    let statuses = [
                        fmi2SetReal(component, inputs.as_ptr(), 2, values.as_ptr()),
                        fmi2SetRealInputDerivatives(component, inputs.as_ptr(), 1, &1, &10.0),
                        fmi2GetReal(component, outputs.as_ptr(), 3, reals.as_mut_ptr()),
                        fmi2DoStep(component, time, 1e-3, 1),
                        fmi2GetReal(component, outputs.as_ptr(), 3, reals.as_mut_ptr()),
                        fmi2GetBoolean(component, &sticking, 1, &mut integer),
                        fmi2GetInteger(component, &counter, 1, &mut integer),
                        fmi2GetRealStatus(component, 2, &mut reals[0]),
                    ];
                    failed += statuses.iter().filter(|status| **status != OK).count();
                }
            });
            assert_eq!((failed, allocations), (0, 0), "law {id}");
            fmi2FreeInstance(component);
        }
    }
}

/// Every model under every law, with its inputs around their start values.
#[test]
fn no_model_allocates_while_stepping() {
    for model in models::ALL {
        let variables = model.table();
        let is_real = |it: &&Variable| it.role == Role::Input && matches!(it.kind, Kind::Real(_));
        let inputs: Vec<_> = variables.iter().filter(is_real).collect();
        let references: Vec<u32> = inputs.iter().map(|variable| variable.reference).collect();
        let law = variables.iter().find(|variable| variable.name == "friction.law");
        let step = model.experiment.step_size;
        for id in law.map_or(vec![0], |_| laws()) {
            let component = instantiate(&CString::new(fmi2::guid(model)).expect("no zero byte"));
            let mut values = vec![0.0; inputs.len()];
            let mut failed = 0;
            // SAFETY: of the component, and all arrays have the length that is passed.
            unsafe {
                if let Some(law) = law {
                    assert_eq!(fmi2SetInteger(component, &law.reference, 1, &id), OK);
                }
                assert_eq!(fmi2EnterInitializationMode(component), OK);
                assert_eq!(fmi2ExitInitializationMode(component), OK);
                let (allocations, _) = counted(|| {
                    for index in 0..STEPS / 3 {
                        let time = f64::from(index) * step;
                        for (value, input) in values.iter_mut().zip(&inputs) {
                            let size = 0.3 * input.nominal.unwrap_or(1.0);
                            *value = input.start.unwrap_or(0.0) + size * (20.0 * time).sin();
                        }
                        let statuses = [
                            fmi2SetReal(component, references.as_ptr(), references.len(), values.as_ptr()),
                            fmi2DoStep(component, time, step, 1),
                        ];
                        failed += statuses.iter().filter(|status| **status != OK).count();
                    }
                });
                assert_eq!((failed, allocations), (0, 0), "{} with law {id}", model.name);
                fmi2FreeInstance(component);
            }
        }
    }
}

/// The sampled controller, several samples in each step.
#[test]
fn sampling_allocates_nothing() {
    let model = models::ALL.iter().find(|model| model.name == "PositionController").expect("the model");
    let reference = |name| model.table().iter().find(|v| v.name == name).expect("a variable").reference;
    let (input, output) = (reference("referencePosition"), reference("valveVoltage"));
    let component = instantiate(&CString::new(fmi2::guid(model)).expect("no zero byte"));
    // SAFETY: of the component, and all arrays have the length that is passed.
    unsafe {
        assert_eq!(fmi2EnterInitializationMode(component), OK);
        assert_eq!(fmi2ExitInitializationMode(component), OK);
        let (mut failed, mut voltage) = (0, 0.0);
        let (allocations, _) = counted(|| {
            for index in 0..STEPS {
                let time = f64::from(index) * 5e-3;
                let statuses = [
                    fmi2SetReal(component, &input, 1, &(0.25 + 0.1 * time.sin())),
                    fmi2DoStep(component, time, 5e-3, 1),
                    fmi2GetReal(component, &output, 1, &mut voltage),
                ];
                failed += statuses.iter().filter(|status| **status != OK).count();
            }
        });
        assert_eq!((failed, allocations), (0, 0));
        assert!(voltage != 5.0, "the controller acts");
        fmi2FreeInstance(component);
    }
}

const LIVES: u64 = 10_000;
const STEPS: i32 = 300;

/// One life: initialization, steps, saved states (one of them left behind), errors, reset, end.
fn live(guid: &CString) {
    let component = instantiate(guid);
    let (voltage, position) = (reference("valveVoltage"), reference("position"));
    // SAFETY: of the component, and all arrays have the length that is passed.
    unsafe {
        for _ in 0..2 {
            assert_eq!(fmi2SetupExperiment(component, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi2EnterInitializationMode(component), OK);
            assert_eq!(fmi2ExitInitializationMode(component), OK);
            let (mut state, mut kept, mut copy, mut size, mut value) =
                (ptr::null_mut(), ptr::null_mut(), ptr::null_mut(), 0, 0.0);
            assert_eq!(fmi2SetReal(component, &voltage, 1, &7.0), OK);
            assert_eq!(fmi2DoStep(component, 0.0, 1e-4, 0), OK);
            assert_eq!(fmi2GetFMUstate(component, &mut state), OK);
            assert_eq!(fmi2GetFMUstate(component, &mut kept), OK);
            assert_eq!(fmi2SerializedFMUstateSize(component, state, &mut size), OK);
            let mut bytes = vec![0; size];
            assert_eq!(fmi2SerializeFMUstate(component, state, bytes.as_mut_ptr(), size), OK);
            assert_eq!(fmi2DeSerializeFMUstate(component, bytes.as_ptr(), size, &mut copy), OK);
            assert_eq!(fmi2SetFMUstate(component, copy), OK);
            assert_eq!(fmi2GetReal(component, &position, 1, &mut value), OK);
            assert_eq!(fmi2DoStep(component, 9.0, 1e-4, 0), ERROR);
            assert_eq!(fmi2FreeFMUstate(component, &mut state), OK);
            assert_eq!(fmi2FreeFMUstate(component, &mut copy), OK);
            assert_eq!(fmi2Terminate(component), OK);
            assert_eq!(fmi2Reset(component), OK);
        }
        fmi2FreeInstance(component);
    }
}

/// The same in FMI 3.0, in each of its ways.
fn live3(token: &CString) {
    let (voltage, position) = (reference("valveVoltage"), reference("position"));
    for way in 0..3 {
        // SAFETY: of the component, and all arrays have the length that is passed.
        unsafe {
            let component = instantiate3(token, way);
            let (mut state, mut kept, mut size, mut value) = (ptr::null_mut(), ptr::null_mut(), 0, 0.0);
            assert_eq!(fmi3EnterInitializationMode(component, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi3SetFloat64(component, &voltage, 1, &7.0, 1), OK);
            assert_eq!(fmi3ExitInitializationMode(component), OK);
            assert_eq!(fmi3GetFMUState(component, &mut state), OK);
            assert_eq!(fmi3GetFMUState(component, &mut kept), OK);
            assert_eq!(fmi3SerializedFMUStateSize(component, state, &mut size), OK);
            assert_eq!(fmi3SetFMUState(component, state), OK);
            assert_eq!(fmi3FreeFMUState(component, &mut state), OK);
            assert_eq!(fmi3GetFloat64(component, &position, 1, &mut value, 1), OK);
            assert_eq!(fmi3Terminate(component), OK);
            assert_eq!(fmi3Reset(component), OK);
            fmi3FreeInstance(component);
        }
    }
}

/// For steps without and with event mode, and for model exchange.
fn instantiate3(token: &CString, way: u8) -> *mut c_void {
    let (name, none, nobody) = (c"a".as_ptr(), ptr::null(), ptr::null_mut());
    // SAFETY: all strings end with zero bytes.
    let component = unsafe {
        if way == 2 {
            (FMI3.fmi3InstantiateModelExchange)(name, token.as_ptr(), none, 0, 0, nobody, None)
        } else {
            let more = ptr::null();
            (FMI3.fmi3InstantiateCoSimulation)(name, token.as_ptr(), none, 0, 0, way, way, more, 0, nobody, None, None)
        }
    };
    assert!(!component.is_null());
    component
}

#[test]
fn ten_thousand_lives_leave_nothing_behind() {
    let guid = guid();
    for (live, lives) in [(live as fn(&CString), LIVES), (live3, LIVES / 3)] {
        // Memory allocated once per process does not count.
        live(&guid);
        let (allocations, growth) = counted(|| (0..lives).for_each(|_| live(&guid)));
        assert_eq!(growth, 0);
        assert!(allocations > lives, "{allocations}: the allocator counts");
    }
}

#[test]
fn instances_and_states_are_there_until_they_are_freed() {
    let guid = guid();
    instantiate(&guid);
    for way in 0..4 {
        let (mut component, mut state) = (ptr::null_mut(), ptr::null_mut());
        let make = || if way == 3 { instantiate(&guid) } else { instantiate3(&guid, way) };
        let (_, instance) = counted(|| component = make());
        assert!(instance > 0, "{instance} bytes");
        // SAFETY: of the component, each function for one of its version.
        unsafe {
            let (save, forget, free): (Save, Save, unsafe extern "C" fn(*mut c_void)) = match way {
                3 => (fmi2GetFMUstate, fmi2FreeFMUstate, fmi2FreeInstance),
                _ => (fmi3GetFMUState, fmi3FreeFMUState, fmi3FreeInstance),
            };
            // Memory kept for the next state does not count.
            assert_eq!((save(component, &mut state), forget(component, &mut state)), (OK, OK));
            let (_, saved) = counted(|| assert_eq!(save(component, &mut state), OK));
            let (_, freed) = counted(|| assert_eq!(forget(component, &mut state), OK));
            assert!(saved > 0 && freed == -saved, "{saved} bytes, then {freed}");
            let (_, freed) = counted(|| free(component));
            assert!(freed <= -instance, "{instance} bytes, then {freed}");
        }
    }
}

/// A host's log: status and text of each message.
type Heard = Vec<(c_int, String)>;

extern "C" fn listen(heard: *mut c_void, status: c_int, _: *const c_char, text: *const c_char) {
    // SAFETY: the environment is the `Heard` that the host gave with this logger, and the text ends with a zero byte.
    unsafe { (*heard.cast::<Heard>()).push((status, CStr::from_ptr(text).to_string_lossy().into_owned())) }
}

/// A failed allocation would end the process, so that memory is asked for before it is needed.
#[test]
fn where_memory_is_short_no_instance_is_made_and_no_run_started() {
    const GRANTED: usize = 1 << 19;
    let (guid, none) = (guid(), ptr::null());
    let mut heard = Heard::new();
    let told = (&raw mut heard).cast();
    // SAFETY: all strings end with zero bytes, and the log outlives the instances.
    unsafe {
        let make = || {
            let make = FMI3.fmi3InstantiateCoSimulation;
            make(c"a".as_ptr(), guid.as_ptr(), none, 0, 0, 0, 0, ptr::null(), 0, told, Some(listen), None)
        };
        LARGEST.set(GRANTED);
        let refused = make();
        let silent = (FMI2.fmi2Instantiate)(c"a".as_ptr(), 1, guid.as_ptr(), ptr::null(), ptr::null(), 0, 0);
        LARGEST.set(usize::MAX);
        assert!(refused.is_null() && silent.is_null());

        let component = make();
        assert_eq!(fmi3EnterInitializationMode(component, 0, 0.0, 0.0, 0, 0.0), OK);
        LARGEST.set(GRANTED);
        let status = fmi3ExitInitializationMode(component);
        LARGEST.set(usize::MAX);
        assert_eq!((status, fmi3ExitInitializationMode(component)), (ERROR, OK));
        fmi3FreeInstance(component);
    }
    let starts = [
        "fmi3InstantiateCoSimulation: the system does not grant",
        "fmi3ExitInitializationMode: the system does not grant",
    ];
    assert_eq!(heard.len(), starts.len(), "{heard:?}");
    assert!(
        heard.iter().zip(starts).all(|((status, text), start)| *status == ERROR && text.starts_with(start)),
        "{heard:?}"
    );
}

type Save = unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> c_int;
