//! The shared library of an FMU 2.0 for co-simulation, behind safe functions.

#![allow(unsafe_code, reason = "the interface of FMI is C")]

use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::path::Path;
use std::ptr::{self, NonNull};
use std::sync::{Mutex, MutexGuard};

const OK: c_int = 0;
const WARNING: c_int = 1;
const CO_SIMULATION: c_int = 1;

/// `fmi2Component`, an instance; also what its callbacks are handed, and a saved state.
type Pointer = *mut c_void;
type Text = *const c_char;

/// `fmi2CallbackLogger`, without the arguments of a format, which are not looked at.
type Logger = unsafe extern "C" fn(Pointer, Text, c_int, Text, Text);

/// `fmi2CallbackFunctions`; FMUs of this library allocate by themselves.
#[repr(C)]
struct Callbacks {
    logger: Logger,
    allocate: Pointer,
    free: Pointer,
    finished: Pointer,
    environment: Pointer,
}

/// The functions of the standard that are used, by their names there.
macro_rules! functions {
    ($($field:ident = $name:literal: fn($($argument:ty),*) $(-> $answer:ty)?;)*) => {
        /// The functions of a shared library, which stays loaded: threads may have to leave it when they end.
        pub struct Library {
            $($field: unsafe extern "C" fn($($argument),*) $(-> $answer)?,)*
        }

        impl Library {
            /// Loads a library.
            ///
            /// # Errors
            /// Why it cannot be loaded, or which function it lacks.
            pub fn load(file: &Path) -> Result<&'static Self, libloading::Error> {
                // SAFETY: loading an FMU of this library starts nothing.
                let code = Box::leak(Box::new(unsafe { libloading::Library::new(file) }?));
                Ok(Box::leak(Box::new(Self {
                    // SAFETY: by these names the standard has functions of these types.
                    $($field: *unsafe { code.get(concat!($name, "\0").as_bytes()) }?,)*
                })))
            }
        }
    };
}

functions! {
    instantiate = "fmi2Instantiate": fn(Text, c_int, Text, Text, *const Callbacks, c_int, c_int) -> Pointer;
    free_instance = "fmi2FreeInstance": fn(Pointer);
    set_debug_logging = "fmi2SetDebugLogging": fn(Pointer, c_int, usize, *const Text) -> c_int;
    setup_experiment = "fmi2SetupExperiment": fn(Pointer, c_int, f64, f64, c_int, f64) -> c_int;
    enter_initialization_mode = "fmi2EnterInitializationMode": fn(Pointer) -> c_int;
    exit_initialization_mode = "fmi2ExitInitializationMode": fn(Pointer) -> c_int;
    get_real = "fmi2GetReal": fn(Pointer, *const c_uint, usize, *mut f64) -> c_int;
    get_integer = "fmi2GetInteger": fn(Pointer, *const c_uint, usize, *mut c_int) -> c_int;
    get_boolean = "fmi2GetBoolean": fn(Pointer, *const c_uint, usize, *mut c_int) -> c_int;
    set_real = "fmi2SetReal": fn(Pointer, *const c_uint, usize, *const f64) -> c_int;
    set_integer = "fmi2SetInteger": fn(Pointer, *const c_uint, usize, *const c_int) -> c_int;
    set_boolean = "fmi2SetBoolean": fn(Pointer, *const c_uint, usize, *const c_int) -> c_int;
    do_step = "fmi2DoStep": fn(Pointer, f64, f64, c_int) -> c_int;
    get_directional_derivative = "fmi2GetDirectionalDerivative":
        fn(Pointer, *const c_uint, usize, *const c_uint, usize, *const f64, *mut f64) -> c_int;
    get_state = "fmi2GetFMUstate": fn(Pointer, *mut Pointer) -> c_int;
    set_state = "fmi2SetFMUstate": fn(Pointer, Pointer) -> c_int;
    free_state = "fmi2FreeFMUstate": fn(Pointer, *mut Pointer) -> c_int;
    serialized_size = "fmi2SerializedFMUstateSize": fn(Pointer, Pointer, *mut usize) -> c_int;
    serialize = "fmi2SerializeFMUstate": fn(Pointer, Pointer, *mut u8, usize) -> c_int;
    deserialize = "fmi2DeSerializeFMUstate": fn(Pointer, *const u8, usize, *mut Pointer) -> c_int;
}

/// What an instance has told by its logger.
#[derive(Default)]
struct Heard {
    warnings: Vec<String>,
    failures: Vec<String>,
}

/// The logger of all instances; the environment is what one of them has told.
unsafe extern "C" fn hear(environment: Pointer, _instance: Text, status: c_int, _category: Text, message: Text) {
    // SAFETY: the environment is the pointer to `Heard` that `Instance::new` has given; its box outlives the C instance.
    let heard = unsafe { &*environment.cast::<Mutex<Heard>>() };
    // SAFETY: messages end with a zero byte.
    let text = unsafe { CStr::from_ptr(message) }.to_string_lossy().replace("%%", "%");
    let mut heard = locked(heard);
    (if status == WARNING { &mut heard.warnings } else { &mut heard.failures }).push(text);
}

fn locked(heard: &Mutex<Heard>) -> MutexGuard<'_, Heard> {
    heard.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Integers and Booleans of FMI have the same type in C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// `fmi2Real`.
    Real,
    /// `fmi2Integer`, as which enumerations are read, too.
    Integer,
    /// `fmi2Boolean`.
    Boolean,
}

/// A running instance, by one thread at a time.
pub struct Instance {
    library: &'static Library,
    component: NonNull<c_void>,
    /// The instance may call back as long as it lives.
    _callbacks: Box<Callbacks>,
    heard: Box<Mutex<Heard>>,
}

// SAFETY: the standard lets any thread call an instance, one at a time; `&Instance` calls nothing that runs.
unsafe impl Send for Instance {}

/// What an instance answers: why a call has failed.
pub type Answer<T> = Result<T, String>;

impl Instance {
    /// Makes an instance that tells its warnings.
    ///
    /// # Errors
    /// What the FMU says against it.
    pub fn new(library: &'static Library, identifier: &str, guid: &str, resources: &str) -> Answer<Self> {
        let text = |text: &str| CString::new(text).map_err(|_| format!("{text:?} has a zero byte"));
        let (identifier, guid, resources) = (text(identifier)?, text(guid)?, text(resources)?);
        let heard = Box::new(Mutex::new(Heard::default()));
        let callbacks = Box::new(Callbacks {
            logger: hear,
            allocate: ptr::null_mut(),
            free: ptr::null_mut(),
            finished: ptr::null_mut(),
            environment: ptr::from_ref(&*heard).cast_mut().cast(),
        });
        // SAFETY: texts end with a zero byte; the callbacks live in boxes that move with the instance.
        let component = unsafe {
            (library.instantiate)(
                identifier.as_ptr(),
                CO_SIMULATION,
                guid.as_ptr(),
                resources.as_ptr(),
                &raw const *callbacks,
                0,
                0,
            )
        };
        let Some(component) = NonNull::new(component) else {
            let told = std::mem::take(&mut locked(&heard).failures).join("; ");
            return Err(if told.is_empty() { "the FMU cannot be instantiated".into() } else { told });
        };
        let mut instance = Self { library, component, _callbacks: callbacks, heard };
        let category = c"logStatusWarning".as_ptr();
        // SAFETY: one category.
        instance
            .call("fmi2SetDebugLogging", |of, it| unsafe { (of.set_debug_logging)(it, 1, 1, &raw const category) })?;
        Ok(instance)
    }

    /// Calls a function of the standard, and tells why it has failed.
    fn call(&mut self, name: &str, function: impl FnOnce(&Library, Pointer) -> c_int) -> Answer<()> {
        locked(&self.heard).failures.clear();
        let status = function(self.library, self.component.as_ptr());
        if status == OK || status == WARNING {
            return Ok(());
        }
        let told = std::mem::take(&mut locked(&self.heard).failures).join("; ");
        Err(if told.is_empty() { format!("{name} ends with the status {status}") } else { told })
    }

    /// The warnings told since they were last taken.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut locked(&self.heard).warnings)
    }

    /// Initializes a run that starts at a time in s.
    pub fn initialize(&mut self, time: f64) -> Answer<()> {
        // SAFETY: numbers alone.
        self.call("fmi2SetupExperiment", |of, it| unsafe { (of.setup_experiment)(it, 0, 0.0, time, 0, 0.0) })?;
        // SAFETY: no arguments.
        self.call("fmi2EnterInitializationMode", |of, it| unsafe { (of.enter_initialization_mode)(it) })?;
        // SAFETY: no arguments.
        self.call("fmi2ExitInitializationMode", |of, it| unsafe { (of.exit_initialization_mode)(it) })
    }

    /// Sets a variable; one that is no Real to a whole number.
    pub fn set(&mut self, kind: Kind, reference: u32, value: f64) -> Answer<()> {
        let whole = value as c_int;
        // SAFETY: one reference and one value each.
        match kind {
            Kind::Real => self.call("fmi2SetReal", |of, it| unsafe { (of.set_real)(it, &reference, 1, &value) }),
            Kind::Integer => {
                self.call("fmi2SetInteger", |of, it| unsafe { (of.set_integer)(it, &reference, 1, &whole) })
            }
            Kind::Boolean => {
                self.call("fmi2SetBoolean", |of, it| unsafe { (of.set_boolean)(it, &reference, 1, &whole) })
            }
        }
    }

    /// The value of a variable.
    pub fn get(&mut self, kind: Kind, reference: u32) -> Answer<f64> {
        let (mut value, mut whole) = (0.0, 0);
        // SAFETY: one reference and room for one value each.
        match kind {
            Kind::Real => {
                self.call("fmi2GetReal", |of, it| unsafe { (of.get_real)(it, &reference, 1, &raw mut value) })?;
                return Ok(value);
            }
            Kind::Integer => {
                self.call("fmi2GetInteger", |of, it| unsafe { (of.get_integer)(it, &reference, 1, &raw mut whole) })?;
            }
            Kind::Boolean => {
                self.call("fmi2GetBoolean", |of, it| unsafe { (of.get_boolean)(it, &reference, 1, &raw mut whole) })?;
            }
        }
        Ok(f64::from(whole))
    }

    /// Integrates from a time over a step in s.
    pub fn step(&mut self, time: f64, size: f64) -> Answer<()> {
        // SAFETY: numbers alone.
        self.call("fmi2DoStep", |of, it| unsafe { (of.do_step)(it, time, size, 0) })
    }

    /// Partial derivatives of computed variables with respect to one state or input.
    pub fn derivatives(&mut self, of_all: &[u32], to: u32) -> Answer<Vec<f64>> {
        let (mut found, one) = (vec![0.0; of_all.len()], 1.0);
        self.call("fmi2GetDirectionalDerivative", |of, it| {
            let (rows, room) = (of_all.as_ptr(), found.as_mut_ptr());
            // SAFETY: as many rows as there is room for, and one column.
            unsafe { (of.get_directional_derivative)(it, rows, of_all.len(), &to, 1, &one, room) }
        })?;
        Ok(found)
    }

    /// Everything that affects the further run, as the FMU serializes it.
    pub fn save(&mut self) -> Answer<Vec<u8>> {
        let (mut state, mut size) = (ptr::null_mut(), 0);
        // SAFETY: room for one state.
        self.call("fmi2GetFMUstate", |of, it| unsafe { (of.get_state)(it, &raw mut state) })?;
        let outcome = self
            // SAFETY: the state is the instance's own, and there is room for its size.
            .call("fmi2SerializedFMUstateSize", |of, it| unsafe { (of.serialized_size)(it, state, &raw mut size) })
            .and_then(|()| {
                let mut bytes = vec![0; size];
                let room = bytes.as_mut_ptr();
                // SAFETY: there is room for as many bytes as the FMU has asked for.
                self.call("fmi2SerializeFMUstate", |of, it| unsafe { (of.serialize)(it, state, room, size) })?;
                Ok(bytes)
            });
        self.forget(state)?;
        outcome
    }

    /// Goes back to a saved state.
    pub fn restore(&mut self, bytes: &[u8]) -> Answer<()> {
        let mut state = ptr::null_mut();
        self.call("fmi2DeSerializeFMUstate", |of, it| {
            // SAFETY: the bytes are there, and room for one state.
            unsafe { (of.deserialize)(it, bytes.as_ptr(), bytes.len(), &raw mut state) }
        })?;
        // SAFETY: the state is the instance's own.
        let outcome = self.call("fmi2SetFMUstate", |of, it| unsafe { (of.set_state)(it, state) });
        self.forget(state)?;
        outcome
    }

    fn forget(&mut self, mut state: Pointer) -> Answer<()> {
        // SAFETY: the state is the instance's own, and is not used again.
        self.call("fmi2FreeFMUstate", |of, it| unsafe { (of.free_state)(it, &raw mut state) })
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: the instance is not used again.
        unsafe { (self.library.free_instance)(self.component.as_ptr()) };
    }
}
