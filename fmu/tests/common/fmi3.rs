//! The built library as a host of FMI 3.0 sees it.

use std::cell::Cell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;

use pneumatic_servo::model::Model;
use pneumatic_servo_fmu::fmi3::exports::Functions;
use pneumatic_servo_fmu::guid;

use super::under_test::UnderTest;
use super::{Message, Messages, OK, cylinder, raised, symbol, vr};

thread_local! {
    static REPLACED: Cell<*const Functions> = const { Cell::new(ptr::null()) };
}

/// The functions of FMI 3.0 of the library under test.
pub static LIBRARY3: UnderTest<Functions> = UnderTest::new(
    // SAFETY: the library is never unloaded, and its functions have the types of their names.
    || unsafe { Functions::load(symbol) }.expect("all functions"),
    &REPLACED,
);

/// Arguments of an instantiation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Co-simulation without event mode.
    Steps,
    /// Co-simulation with event mode, and whether steps may return early.
    Events(bool),
    /// Model exchange.
    Exchange,
}

/// Results of `fmi3DoStep`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    pub event: u8,
    pub terminate: u8,
    pub early: u8,
    pub time: f64,
}

/// Results of `fmi3UpdateDiscreteStates`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Updated {
    pub again: u8,
    pub terminate: u8,
    pub nominals: u8,
    pub values: u8,
    pub is_defined: u8,
    pub time: f64,
}

/// A logger whose environment is the `Messages`, or NULL.
pub extern "C" fn logger(environment: *mut c_void, status: c_int, category: *const c_char, text: *const c_char) {
    // SAFETY: the environment is the `Messages` given with the logger, or NULL; the rest are strings.
    let (messages, [category, text]) = unsafe {
        let string = |text: *const c_char| CStr::from_ptr(text).to_str().expect("UTF-8").to_owned();
        (environment.cast::<Messages>().as_ref(), [category, text].map(string))
    };
    if let Some(messages) = messages {
        let name = String::new();
        messages.lock().expect("no panic while logging").push(Message { name, status, category, text });
    }
}

/// A component, or NULL, and what was logged meanwhile.
pub fn instantiate(way: Way, name: &CStr, token: &CStr) -> (*mut c_void, Box<Messages>) {
    instantiate_in(way, name, token, None)
}

/// The same with a folder of resources.
pub fn instantiate_in(way: Way, name: &CStr, token: &CStr, resources: Option<&CStr>) -> (*mut c_void, Box<Messages>) {
    let messages = Box::new(Messages::default());
    let environment = ptr::from_ref(&*messages).cast_mut().cast();
    let (name, token, folder) = (name.as_ptr(), token.as_ptr(), resources.map_or(ptr::null(), CStr::as_ptr));
    // SAFETY: all strings end with zero bytes, and the messages outlive the instance.
    let component = unsafe {
        match way {
            Way::Exchange => {
                (LIBRARY3.fmi3InstantiateModelExchange)(name, token, folder, 0, 0, environment, Some(logger))
            }
            Way::Steps | Way::Events(_) => {
                let (event_mode, early) = (u8::from(way != Way::Steps), u8::from(way == Way::Events(true)));
                let make = LIBRARY3.fmi3InstantiateCoSimulation;
                make(name, token, folder, 0, 0, event_mode, early, ptr::null(), 0, environment, Some(logger), None)
            }
        }
    };
    (component, messages)
}

/// An instance, freed at the end.
pub struct Instance3 {
    pub component: *mut c_void,
    pub messages: Box<Messages>,
}

impl Drop for Instance3 {
    fn drop(&mut self) {
        // SAFETY: the component is freed once.
        unsafe { (LIBRARY3.fmi3FreeInstance)(self.component) }
    }
}

// SAFETY, for all of them: of the component; arrays have the lengths that are passed.
impl Instance3 {
    pub fn of(model: &Model, way: Way) -> Self {
        let token = CString::new(guid(model)).expect("no zero byte");
        let (component, messages) = instantiate(way, c"test", &token);
        assert!(!component.is_null(), "{:?}", messages.lock());
        Self { component, messages }
    }

    /// The cylinder under a law and a voltage, after initialization.
    pub fn cylinder(way: Way, law: i64, voltage: f64) -> Self {
        let instance = Self::of(cylinder(), way);
        assert_eq!(instance.set_int64(&[vr("friction.law")], &[law]), OK);
        assert_eq!(instance.set(&[vr("valveVoltage")], &[voltage]), OK);
        assert_eq!((instance.enter(), instance.exit()), (OK, OK), "{:?}", instance.messages());
        instance
    }

    pub fn messages(&self) -> Vec<Message> {
        std::mem::take(&mut self.messages.lock().expect("no panic while logging"))
    }

    /// The text of the last message.
    pub fn message(&self) -> String {
        self.messages().pop().expect("a message").text
    }

    pub fn enter(&self) -> c_int {
        unsafe { (LIBRARY3.fmi3EnterInitializationMode)(self.component, 0, 0.0, 0.0, 0, 0.0) }
    }

    pub fn exit(&self) -> c_int {
        unsafe { (LIBRARY3.fmi3ExitInitializationMode)(self.component) }
    }

    pub fn enter_event_mode(&self) -> c_int {
        unsafe { (LIBRARY3.fmi3EnterEventMode)(self.component) }
    }

    pub fn enter_step_mode(&self) -> c_int {
        unsafe { (LIBRARY3.fmi3EnterStepMode)(self.component) }
    }

    pub fn integrate(&self) -> c_int {
        unsafe { (LIBRARY3.fmi3EnterContinuousTimeMode)(self.component) }
    }

    pub fn terminate(&self) -> c_int {
        unsafe { (LIBRARY3.fmi3Terminate)(self.component) }
    }

    pub fn reset(&self) -> c_int {
        unsafe { (LIBRARY3.fmi3Reset)(self.component) }
    }

    pub fn update(&self) -> (c_int, Updated) {
        let mut it = Updated { again: 7, terminate: 7, nominals: 7, values: 7, is_defined: 7, time: -7.0 };
        let update = LIBRARY3.fmi3UpdateDiscreteStates;
        let status = unsafe {
            update(
                self.component,
                &mut it.again,
                &mut it.terminate,
                &mut it.nominals,
                &mut it.values,
                &mut it.is_defined,
                &mut it.time,
            )
        };
        (status, it)
    }

    pub fn step(&self, point: f64, size: f64) -> (c_int, Step) {
        let mut it = Step { event: 7, terminate: 7, early: 7, time: f64::NAN };
        let step = LIBRARY3.fmi3DoStep;
        let (status, exceptions) = raised(|| unsafe {
            step(self.component, point, size, 0, &mut it.event, &mut it.terminate, &mut it.early, &mut it.time)
        });
        assert!(status != OK || exceptions == 0, "a step from {point} s by {size} s raises {exceptions}");
        (status, it)
    }

    pub fn set(&self, references: &[u32], values: &[f64]) -> c_int {
        let (number, room) = (references.len(), values.len());
        unsafe { (LIBRARY3.fmi3SetFloat64)(self.component, references.as_ptr(), number, values.as_ptr(), room) }
    }

    pub fn set_int32(&self, references: &[u32], values: &[i32]) -> c_int {
        let (number, room) = (references.len(), values.len());
        unsafe { (LIBRARY3.fmi3SetInt32)(self.component, references.as_ptr(), number, values.as_ptr(), room) }
    }

    pub fn set_int64(&self, references: &[u32], values: &[i64]) -> c_int {
        let (number, room) = (references.len(), values.len());
        unsafe { (LIBRARY3.fmi3SetInt64)(self.component, references.as_ptr(), number, values.as_ptr(), room) }
    }

    pub fn set_boolean(&self, references: &[u32], values: &[u8]) -> c_int {
        let (number, room) = (references.len(), values.len());
        unsafe { (LIBRARY3.fmi3SetBoolean)(self.component, references.as_ptr(), number, values.as_ptr(), room) }
    }

    pub fn get(&self, references: &[u32], values: &mut [f64]) -> c_int {
        let (number, room) = (references.len(), values.len());
        unsafe { (LIBRARY3.fmi3GetFloat64)(self.component, references.as_ptr(), number, values.as_mut_ptr(), room) }
    }

    pub fn get_int32(&self, references: &[u32], values: &mut [i32]) -> c_int {
        let (number, room) = (references.len(), values.len());
        unsafe { (LIBRARY3.fmi3GetInt32)(self.component, references.as_ptr(), number, values.as_mut_ptr(), room) }
    }

    pub fn get_int64(&self, references: &[u32], values: &mut [i64]) -> c_int {
        let (number, room) = (references.len(), values.len());
        unsafe { (LIBRARY3.fmi3GetInt64)(self.component, references.as_ptr(), number, values.as_mut_ptr(), room) }
    }

    pub fn get_boolean(&self, references: &[u32], values: &mut [u8]) -> c_int {
        let (number, room) = (references.len(), values.len());
        unsafe { (LIBRARY3.fmi3GetBoolean)(self.component, references.as_ptr(), number, values.as_mut_ptr(), room) }
    }

    /// The value of a real variable of the cylinder.
    pub fn real(&self, name: &str) -> f64 {
        let mut value = [f64::NAN];
        assert_eq!(self.get(&[vr(name)], &mut value), OK, "{name}: {:?}", self.messages());
        value[0]
    }

    /// Whether the cylinder sticks.
    pub fn sticks(&self) -> bool {
        let mut value = [7];
        assert_eq!(self.get_boolean(&[vr("sticking")], &mut value), OK, "{:?}", self.messages());
        value == [1]
    }

    pub fn directional(&self, unknowns: &[u32], knowns: &[u32], seeds: &[f64], out: &mut [f64]) -> c_int {
        self.differentiate(LIBRARY3.fmi3GetDirectionalDerivative, unknowns, knowns, seeds, out)
    }

    pub fn adjoint(&self, unknowns: &[u32], knowns: &[u32], seeds: &[f64], out: &mut [f64]) -> c_int {
        self.differentiate(LIBRARY3.fmi3GetAdjointDerivative, unknowns, knowns, seeds, out)
    }

    fn differentiate(
        &self,
        function: Differentiate,
        unknowns: &[u32],
        knowns: &[u32],
        seeds: &[f64],
        out: &mut [f64],
    ) -> c_int {
        unsafe {
            function(
                self.component,
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                seeds.as_ptr(),
                seeds.len(),
                out.as_mut_ptr(),
                out.len(),
            )
        }
    }

    pub fn output_rates(&self, references: &[u32], orders: &[i32], values: &mut [f64]) -> c_int {
        let (number, room) = (references.len(), values.len());
        let get = LIBRARY3.fmi3GetOutputDerivatives;
        unsafe { get(self.component, references.as_ptr(), number, orders.as_ptr(), values.as_mut_ptr(), room) }
    }

    /// A function that reads a vector.
    pub fn vector(&self, function: Vector, values: &mut [f64]) -> c_int {
        unsafe { function(self.component, values.as_mut_ptr(), values.len()) }
    }

    pub fn set_states(&self, states: &[f64]) -> c_int {
        unsafe { (LIBRARY3.fmi3SetContinuousStates)(self.component, states.as_ptr(), states.len()) }
    }

    pub fn set_time(&self, time: f64) -> c_int {
        unsafe { (LIBRARY3.fmi3SetTime)(self.component, time) }
    }

    pub fn accept_step(&self) -> c_int {
        let (mut enter, mut terminate) = (7, 7);
        let status = unsafe { (LIBRARY3.fmi3CompletedIntegratorStep)(self.component, 1, &mut enter, &mut terminate) };
        assert_eq!((enter, terminate), if status == OK { (0, 0) } else { (7, 7) });
        status
    }

    pub fn number(&self, function: Number) -> usize {
        let mut number = usize::MAX;
        assert_eq!(unsafe { function(self.component, &mut number) }, OK);
        number
    }

    /// Dependencies of a variable: element, value reference and element of the other, kind.
    pub fn dependencies(&self, reference: u32) -> Vec<(usize, u32, usize, c_int)> {
        let mut number = usize::MAX;
        let count = LIBRARY3.fmi3GetNumberOfVariableDependencies;
        assert_eq!(unsafe { count(self.component, reference, &mut number) }, OK, "{:?}", self.messages());
        let (mut elements, mut others) = (vec![usize::MAX; number], vec![u32::MAX; number]);
        let (mut of_others, mut kinds) = (vec![usize::MAX; number], vec![-1; number]);
        let (one, two, three) = (elements.as_mut_ptr(), others.as_mut_ptr(), of_others.as_mut_ptr());
        let get = LIBRARY3.fmi3GetVariableDependencies;
        assert_eq!(unsafe { get(self.component, reference, one, two, three, kinds.as_mut_ptr(), number) }, OK);
        (0..number).map(|index| (elements[index], others[index], of_others[index], kinds[index])).collect()
    }

    pub fn save(&self) -> *mut c_void {
        let mut state = ptr::null_mut();
        assert_eq!(unsafe { (LIBRARY3.fmi3GetFMUState)(self.component, &mut state) }, OK);
        state
    }

    pub fn restore(&self, state: *mut c_void) -> c_int {
        unsafe { (LIBRARY3.fmi3SetFMUState)(self.component, state) }
    }

    pub fn serialize(&self, state: *mut c_void) -> Vec<u8> {
        let mut size = 0;
        assert_eq!(unsafe { (LIBRARY3.fmi3SerializedFMUStateSize)(self.component, state, &mut size) }, OK);
        let mut bytes = vec![0xaa; size];
        let serialize = LIBRARY3.fmi3SerializeFMUState;
        assert_eq!(unsafe { serialize(self.component, state, bytes.as_mut_ptr(), size) }, OK);
        bytes
    }

    pub fn deserialize(&self, bytes: &[u8]) -> (c_int, *mut c_void) {
        let mut state = ptr::null_mut();
        let deserialize = LIBRARY3.fmi3DeserializeFMUState;
        let status = unsafe { deserialize(self.component, bytes.as_ptr(), bytes.len(), &mut state) };
        (status, state)
    }

    /// Everything the instance remembers, as bytes.
    pub fn fingerprint(&self) -> Vec<u8> {
        let mut state = self.save();
        let bytes = self.serialize(state);
        assert_eq!(unsafe { (LIBRARY3.fmi3FreeFMUState)(self.component, &mut state) }, OK);
        assert!(state.is_null());
        bytes
    }

    /// All real variables of the cylinder, bit for bit.
    pub fn bits(&self) -> Vec<u64> {
        let table = cylinder().table();
        let arrays = table.arrays().filter(|(_, first)| super::is_real(first));
        let (lengths, references): (Vec<usize>, Vec<u32>) =
            arrays.map(|(length, first)| (length, first.reference)).unzip();
        let mut values = vec![f64::NAN; lengths.iter().sum()];
        assert_eq!(self.get(&references, &mut values), OK, "{:?}", self.messages());
        values.into_iter().map(f64::to_bits).collect()
    }
}

/// `fmi3GetDirectionalDerivative` and `fmi3GetAdjointDerivative`.
type Differentiate = unsafe extern "C" fn(
    *mut c_void,
    *const u32,
    usize,
    *const u32,
    usize,
    *const f64,
    usize,
    *mut f64,
    usize,
) -> c_int;
/// A function that reads a vector.
pub type Vector = unsafe extern "C" fn(*mut c_void, *mut f64, usize) -> c_int;
/// A function that tells a number.
pub type Number = unsafe extern "C" fn(*mut c_void, *mut usize) -> c_int;
