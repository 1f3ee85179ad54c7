//! The built library as a C host sees it: loaded at run time.

#![allow(dead_code, reason = "each test uses a part of it")]

pub mod fmi3;
pub mod under_test;

use std::cell::Cell;
use std::env;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::PathBuf;
use std::ptr;
use std::sync::{LazyLock, Mutex};

use libloading::Library;
use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Role, Variable};
use pneumatic_servo_fmu::fmi2;
pub use pneumatic_servo_fmu::fmi2::exports::Functions;
use pneumatic_servo_fmu::fmi2::types::{CO_SIMULATION, Logger, MODEL_EXCHANGE};
pub use pneumatic_servo_fmu::fmi2::types::{CallbackFunctions, DISCARD, ERROR, OK};

use under_test::UnderTest;

/// `fmi2StatusKind`, in its order.
pub const STATUS_KINDS: [c_int; 4] = [0, 1, 2, 3];

type Component = *mut c_void;
type State = *mut c_void;
type Text = *const c_char;

thread_local! {
    static REPLACED: Cell<*const Functions> = const { Cell::new(ptr::null()) };
}

/// The functions of FMI 2.0 of the library under test.
pub static LIBRARY: UnderTest<Functions> = UnderTest::new(
    // SAFETY: the library is never unloaded, and its functions have the types of their names.
    || unsafe { Functions::load(symbol) }.expect("all functions"),
    &REPLACED,
);

/// A function of the library, which is never unloaded.
pub fn symbol(name: &str) -> Result<*const c_void, libloading::Error> {
    // SAFETY: loading the library runs no code of ours.
    static FILE: LazyLock<Library> =
        LazyLock::new(|| unsafe { Library::new(library_path()) }.expect("the built library"));
    // SAFETY: nothing but the address is taken.
    unsafe { FILE.get(name.as_bytes()) }.map(|symbol| *symbol)
}

/// The file of the library: cargo builds it for the test, beside the test's own executable. The variable `FMU_LIBRARY` names
/// another one of the same source, such as one that is compiled from C.
pub fn library_path() -> PathBuf {
    if let Some(file) = env::var_os("FMU_LIBRARY") {
        return file.into();
    }
    let name = format!("{}pneumatic_servo_builtin{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
    let executable = env::current_exe().expect("the test's own path");
    let folders = executable.ancestors().skip(1).take(2);
    let candidates: Vec<_> = folders.map(|folder| folder.join(&name)).collect();
    let found = candidates.iter().find(|path| path.exists());
    found.unwrap_or_else(|| panic!("none of {candidates:?} exists")).clone()
}

/// The outcome of a call, and the floating-point exceptions that importers trap which it has raised; none where the C library does
/// not tell.
pub fn raised<T>(call: impl FnOnce() -> T) -> (T, c_int) {
    #[cfg(all(target_os = "linux", target_env = "gnu", any(target_arch = "x86_64", target_arch = "aarch64")))]
    {
        #[link(name = "m")]
        unsafe extern "C" {
            safe fn feclearexcept(exceptions: c_int) -> c_int;
            safe fn fetestexcept(exceptions: c_int) -> c_int;
        }
        /// `FE_INVALID`, `FE_DIVBYZERO` and `FE_OVERFLOW`.
        const TRAPPED: c_int = if cfg!(target_arch = "x86_64") { 1 | 4 | 8 } else { 1 | 2 | 4 };
        feclearexcept(TRAPPED);
        (call(), fetestexcept(TRAPPED))
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu", any(target_arch = "x86_64", target_arch = "aarch64"))))]
    (call(), 0)
}

/// The models that the library under test serves: all, or the one that the variable `FMU_MODEL` names.
pub fn served() -> Vec<&'static Model> {
    let only = env::var("FMU_MODEL").ok();
    let served: Vec<_> = models::ALL.iter().filter(|model| only.as_deref().is_none_or(|it| it == model.name)).collect();
    assert!(!served.is_empty(), "FMU_MODEL names no model: {only:?}");
    served
}

/// The model most tests are about.
pub fn cylinder() -> &'static Model {
    model("PneumaticServoCylinder")
}

/// The model of a name.
pub fn model(name: &str) -> &'static Model {
    models::ALL.iter().find(|model| model.name == name).expect("a model of this name")
}

/// The variables of the cylinder.
pub fn variables() -> &'static [Variable] {
    cylinder().table()
}

/// The variable of the cylinder with a name.
pub fn variable(name: &str) -> &'static Variable {
    variables().iter().find(|variable| variable.name == name).unwrap_or_else(|| panic!("no variable {name}"))
}

/// The value reference of the cylinder's variable of a name.
pub fn vr(name: &str) -> u32 {
    variable(name).reference
}

/// Value references of all variables of the cylinder for which something holds.
pub fn references(of: impl Fn(&Variable) -> bool) -> Vec<u32> {
    variables().iter().filter(|variable| of(variable)).map(|variable| variable.reference).collect()
}

/// Whether a variable has base type Real.
pub fn is_real(variable: &Variable) -> bool {
    matches!(variable.kind, Kind::Real(_))
}

/// Whether a variable is an input.
pub fn is_input(variable: &Variable) -> bool {
    variable.role == Role::Input
}

/// Whether a variable is a real input: one that may have a slope.
pub fn is_real_input(variable: &Variable) -> bool {
    is_input(variable) && is_real(variable)
}

/// The ids of the friction laws.
pub fn laws() -> Vec<(i32, &'static str)> {
    let Kind::Enumeration(laws) = variable("friction.law").kind else { panic!("friction.law is an enumeration") };
    laws.items.iter().map(|(id, name, _)| (*id, *name)).collect()
}

/// Arguments of a call of the logger.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// The instance's name.
    pub name: String,
    /// The status.
    pub status: c_int,
    /// The category.
    pub category: String,
    /// The text, as the format prints it without arguments.
    pub text: String,
}

/// Messages, with a fixed address for the logger.
pub type Messages = Mutex<Vec<Message>>;

/// The logger, which is not variadic: the texts must do without arguments.
extern "C" fn logger(environment: *mut c_void, name: Text, status: c_int, category: Text, format: Text) {
    // SAFETY: the environment is the `Messages` given with the callbacks, or NULL; the rest are strings.
    let (messages, [name, category, format]) = unsafe {
        let string = |text: Text| CStr::from_ptr(text).to_str().expect("UTF-8").to_owned();
        (environment.cast::<Messages>().as_ref(), [name, category, format].map(string))
    };
    if let Some(messages) = messages {
        let text = printed(&format);
        messages.lock().expect("no panic while logging").push(Message { name, status, category, text });
    }
}

/// Output of `printf` for a format that must not ask for an argument.
fn printed(format: &str) -> String {
    let literal = format.replace("%%", "");
    assert!(!literal.contains('%'), "{format} asks for an argument");
    format.replace("%%", "%")
}

/// A function as the logger that hosts declare with further arguments.
pub fn as_logger(function: extern "C" fn(*mut c_void, Text, c_int, Text, Text)) -> Logger {
    // SAFETY: the library passes no further arguments. No platform here has a calling convention that passes the named
    // arguments of a variadic function elsewhere.
    unsafe { std::mem::transmute(function) }
}

/// Callbacks that collect messages.
pub fn callbacks(messages: &Messages) -> CallbackFunctions {
    CallbackFunctions {
        logger: Some(as_logger(logger)),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        environment: ptr::from_ref(messages).cast_mut().cast(),
    }
}

/// An instance, freed at the end.
pub struct Instance {
    /// The component.
    pub component: Component,
    messages: Box<Messages>,
}

// SAFETY: an instance may be used by one thread after another.
unsafe impl Send for Instance {}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: the component is freed once.
        unsafe { (LIBRARY.fmi2FreeInstance)(self.component) }
    }
}

impl Instance {
    /// An instance of the cylinder.
    pub fn new() -> Self {
        Self::of(cylinder())
    }

    /// An instance of a model.
    pub fn of(model: &Model) -> Self {
        Self::with_logging(model, false)
    }

    /// An instance of a model whose states are exchanged.
    pub fn for_exchange(model: &Model) -> Self {
        Self::made(model, MODEL_EXCHANGE, false)
    }

    /// An instance with logging switched on or off.
    pub fn with_logging(model: &Model, on: bool) -> Self {
        Self::made(model, CO_SIMULATION, on)
    }

    fn made(model: &Model, fmu_type: c_int, on: bool) -> Self {
        Self::configured(&fmi2::guid(model), None, fmu_type, on).unwrap_or_else(|messages| panic!("{messages:?}"))
    }

    /// An instance for a GUID and a folder of resources, or the messages of the refusal.
    pub fn configured(guid: &str, resources: Option<&CStr>, fmu_type: c_int, on: bool) -> Result<Self, Vec<Message>> {
        let messages = Box::new(Messages::default());
        let guid = CString::new(guid).expect("no zero byte");
        // SAFETY: all strings end with zero bytes, and the messages outlive the instance.
        let component = unsafe {
            (LIBRARY.fmi2Instantiate)(
                c"test".as_ptr(),
                fmu_type,
                guid.as_ptr(),
                resources.map_or(ptr::null(), CStr::as_ptr),
                &callbacks(&messages),
                0,
                on.into(),
            )
        };
        if component.is_null() {
            return Err(messages.into_inner().expect("no panic while logging"));
        }
        Ok(Self { component, messages })
    }

    /// An initialized instance that starts at 0 s.
    pub fn initialized() -> Self {
        let instance = Self::new();
        instance.initialize();
        instance
    }

    /// An initialized instance with a friction law.
    pub fn with_law(law: i32) -> Self {
        let instance = Self::new();
        assert_eq!(instance.set_integer(&[vr("friction.law")], &[law]), OK);
        instance.initialize();
        instance
    }

    /// Goes through initialization.
    pub fn initialize(&self) {
        assert_eq!(self.setup(0.0, None), OK);
        assert_eq!(self.enter(), OK);
        assert_eq!(self.exit(), OK, "{:?}", self.messages());
    }

    /// Messages since the last call of this.
    pub fn messages(&self) -> Vec<Message> {
        std::mem::take(&mut self.messages.lock().expect("no panic while logging"))
    }

    /// The text of the only message logged since.
    pub fn message(&self) -> String {
        let messages = self.messages();
        let [message] = &messages[..] else { panic!("one message, not {messages:?}") };
        message.text.clone()
    }

    /// `fmi2SetupExperiment` without tolerance.
    pub fn setup(&self, start: f64, stop: Option<f64>) -> c_int {
        // SAFETY: of the component, as everywhere below.
        unsafe {
            (LIBRARY.fmi2SetupExperiment)(
                self.component,
                0,
                0.0,
                start,
                stop.is_some().into(),
                stop.unwrap_or(f64::NAN),
            )
        }
    }

    /// `fmi2EnterInitializationMode`.
    pub fn enter(&self) -> c_int {
        // SAFETY: as above.
        unsafe { (LIBRARY.fmi2EnterInitializationMode)(self.component) }
    }

    /// `fmi2ExitInitializationMode`.
    pub fn exit(&self) -> c_int {
        // SAFETY: as above.
        unsafe { (LIBRARY.fmi2ExitInitializationMode)(self.component) }
    }

    /// `fmi2Terminate`.
    pub fn terminate(&self) -> c_int {
        // SAFETY: as above.
        unsafe { (LIBRARY.fmi2Terminate)(self.component) }
    }

    /// `fmi2Reset`.
    pub fn reset(&self) -> c_int {
        // SAFETY: as above.
        unsafe { (LIBRARY.fmi2Reset)(self.component) }
    }

    /// `fmi2SetReal`.
    pub fn set_real(&self, references: &[u32], values: &[f64]) -> c_int {
        assert_eq!(references.len(), values.len());
        // SAFETY: as above, and the arrays have the same length.
        unsafe { (LIBRARY.fmi2SetReal)(self.component, references.as_ptr(), references.len(), values.as_ptr()) }
    }

    /// `fmi2SetInteger`.
    pub fn set_integer(&self, references: &[u32], values: &[c_int]) -> c_int {
        assert_eq!(references.len(), values.len());
        // SAFETY: as above, and the arrays have the same length.
        unsafe { (LIBRARY.fmi2SetInteger)(self.component, references.as_ptr(), references.len(), values.as_ptr()) }
    }

    /// `fmi2SetBoolean`.
    pub fn set_boolean(&self, references: &[u32], values: &[c_int]) -> c_int {
        assert_eq!(references.len(), values.len());
        // SAFETY: as above, and the arrays have the same length.
        unsafe { (LIBRARY.fmi2SetBoolean)(self.component, references.as_ptr(), references.len(), values.as_ptr()) }
    }

    /// `fmi2GetReal`.
    pub fn get_real(&self, references: &[u32], values: &mut [f64]) -> c_int {
        assert_eq!(references.len(), values.len());
        // SAFETY: as above, and the arrays have the same length.
        unsafe { (LIBRARY.fmi2GetReal)(self.component, references.as_ptr(), references.len(), values.as_mut_ptr()) }
    }

    /// `fmi2GetInteger`.
    pub fn get_integer(&self, references: &[u32], values: &mut [c_int]) -> c_int {
        assert_eq!(references.len(), values.len());
        // SAFETY: as above, and the arrays have the same length.
        unsafe { (LIBRARY.fmi2GetInteger)(self.component, references.as_ptr(), references.len(), values.as_mut_ptr()) }
    }

    /// `fmi2GetBoolean`.
    pub fn get_boolean(&self, references: &[u32], values: &mut [c_int]) -> c_int {
        assert_eq!(references.len(), values.len());
        // SAFETY: as above, and the arrays have the same length.
        unsafe { (LIBRARY.fmi2GetBoolean)(self.component, references.as_ptr(), references.len(), values.as_mut_ptr()) }
    }

    /// The value of a readable real variable.
    pub fn real(&self, name: &str) -> f64 {
        let mut value = [f64::NAN];
        assert_eq!(self.get_real(&[vr(name)], &mut value), OK, "{name}: {:?}", self.messages());
        value[0]
    }

    /// `fmi2DoStep`.
    pub fn step(&self, point: f64, size: f64) -> c_int {
        // SAFETY: as above.
        let (status, exceptions) = raised(|| unsafe { (LIBRARY.fmi2DoStep)(self.component, point, size, 0) });
        assert!(status != OK || exceptions == 0, "a step from {point} s by {size} s raises {exceptions}");
        status
    }

    /// `fmi2GetRealStatus` of `fmi2LastSuccessfulTime`.
    pub fn last_successful_time(&self) -> f64 {
        let mut time = f64::NAN;
        // SAFETY: as above.
        assert_eq!(unsafe { (LIBRARY.fmi2GetRealStatus)(self.component, 2, &mut time) }, OK);
        time
    }

    /// `fmi2GetBooleanStatus` of `fmi2Terminated`.
    pub fn wants_to_terminate(&self) -> bool {
        let mut value = -1;
        // SAFETY: as above.
        assert_eq!(unsafe { (LIBRARY.fmi2GetBooleanStatus)(self.component, 3, &mut value) }, OK);
        value == 1
    }

    /// `fmi2GetStatus` of `fmi2DoStepStatus`.
    pub fn step_status(&self) -> c_int {
        let mut value = -1;
        // SAFETY: as above.
        assert_eq!(unsafe { (LIBRARY.fmi2GetStatus)(self.component, 0, &mut value) }, OK);
        value
    }

    /// `fmi2SetRealInputDerivatives` of order 1.
    pub fn set_slopes(&self, references: &[u32], slopes: &[f64]) -> c_int {
        self.set_input_derivatives(references, &vec![1; references.len()], slopes)
    }

    /// `fmi2SetRealInputDerivatives`.
    pub fn set_input_derivatives(&self, references: &[u32], orders: &[c_int], values: &[f64]) -> c_int {
        assert!(references.len() == orders.len() && references.len() == values.len());
        let number = references.len();
        let set = LIBRARY.fmi2SetRealInputDerivatives;
        // SAFETY: as above, and the arrays have the same length.
        unsafe { set(self.component, references.as_ptr(), number, orders.as_ptr(), values.as_ptr()) }
    }

    /// `fmi2GetRealOutputDerivatives`.
    pub fn output_derivatives(&self, references: &[u32], orders: &[c_int], values: &mut [f64]) -> c_int {
        assert!(references.len() == orders.len() && references.len() == values.len());
        let number = references.len();
        let get = LIBRARY.fmi2GetRealOutputDerivatives;
        // SAFETY: as above, and the arrays have the same length.
        unsafe { get(self.component, references.as_ptr(), number, orders.as_ptr(), values.as_mut_ptr()) }
    }

    /// `fmi2GetDirectionalDerivative`.
    pub fn directional(&self, unknowns: &[u32], knowns: &[u32], seeds: &[f64], derivatives: &mut [f64]) -> c_int {
        assert!(unknowns.len() == derivatives.len() && knowns.len() == seeds.len());
        // SAFETY: as above, and the arrays have the right lengths.
        unsafe {
            (LIBRARY.fmi2GetDirectionalDerivative)(
                self.component,
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                seeds.as_ptr(),
                derivatives.as_mut_ptr(),
            )
        }
    }

    /// `fmi2GetFMUstate` into a new state.
    pub fn save(&self) -> State {
        let mut state = ptr::null_mut();
        // SAFETY: as above.
        assert_eq!(unsafe { (LIBRARY.fmi2GetFMUstate)(self.component, &mut state) }, OK);
        assert!(!state.is_null());
        state
    }

    /// `fmi2SetFMUstate`.
    pub fn restore(&self, state: State) -> c_int {
        // SAFETY: as above.
        unsafe { (LIBRARY.fmi2SetFMUstate)(self.component, state) }
    }

    /// `fmi2FreeFMUstate`.
    pub fn forget(&self, state: &mut State) -> c_int {
        // SAFETY: as above.
        unsafe { (LIBRARY.fmi2FreeFMUstate)(self.component, state) }
    }

    /// `fmi2SerializeFMUstate` into as many bytes as it says it takes.
    pub fn serialize(&self, state: State) -> Vec<u8> {
        let mut size = 0;
        // SAFETY: as above.
        assert_eq!(unsafe { (LIBRARY.fmi2SerializedFMUstateSize)(self.component, state, &mut size) }, OK);
        let mut bytes = vec![0xaa; size];
        // SAFETY: as above, and there are as many bytes.
        let status = unsafe { (LIBRARY.fmi2SerializeFMUstate)(self.component, state, bytes.as_mut_ptr(), size) };
        assert_eq!(status, OK);
        bytes
    }

    /// `fmi2DeSerializeFMUstate`.
    pub fn deserialize(&self, bytes: &[u8]) -> (c_int, State) {
        let mut state = ptr::null_mut();
        let deserialize = LIBRARY.fmi2DeSerializeFMUstate;
        // SAFETY: as above, and there are as many bytes.
        let status = unsafe { deserialize(self.component, bytes.as_ptr(), bytes.len(), &mut state) };
        (status, state)
    }

    /// Everything the instance remembers, as bytes.
    pub fn fingerprint(&self) -> Vec<u8> {
        let mut state = self.save();
        let bytes = self.serialize(state);
        assert_eq!(self.forget(&mut state), OK);
        bytes
    }

    /// All real variables, bit for bit.
    pub fn bits(&self) -> Vec<u64> {
        let references = references(is_real);
        let mut values = vec![f64::NAN; references.len()];
        assert_eq!(self.get_real(&references, &mut values), OK, "{:?}", self.messages());
        values.into_iter().map(f64::to_bits).collect()
    }

    /// A run over a number of steps of 1 ms with a swinging voltage and force; all real variables after each.
    pub fn swing(&self, steps: u32) -> Vec<Vec<u64>> {
        let run = (0..steps).map(|_| {
            let time = self.real("time");
            let voltage = 5.0 + 2.0 * (60.0 * time).sin();
            let force = 3.0 * (200.0 * time).sin();
            assert_eq!(self.set_real(&[vr("valveVoltage"), vr("externalForce")], &[voltage, force]), OK);
            assert_eq!(self.step(time, 1e-3), OK, "{:?}", self.messages());
            self.bits()
        });
        run.collect()
    }
}
