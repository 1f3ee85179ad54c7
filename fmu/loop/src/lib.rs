//! A model in a control loop of C: a module of WebAssembly with one run, from which sources in C are made.
//!
//! The C in `packaging/c` knows the variables, as a constant table; here they have places alone. Inputs, parameters and computed
//! variables stand one behind the other in the memory of the module, where the C writes and reads them.

pub mod heap;

use std::fmt::Display;
use std::ptr;

use pneumatic_servo::co_simulation::{Embedded, Simulation};
use pneumatic_servo::model::{Model, Seeds, Start};
use pneumatic_servo::solver::StepError;
use pneumatic_servo::system::System;
use pneumatic_servo::variables::ParameterError;

/// Takes the message of a call that is refused.
pub type Log = fn(&str);

/// Status of a call, as the enumeration `PlantStatus` of C.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Status {
    /// All is well.
    Ok = 0,
    /// The call was refused, and has changed nothing; or a step ended before its end.
    Error = 3,
}

/// Run of a control loop; values are in the order of the table of the model.
pub trait Running {
    /// Current time in s.
    fn time(&self) -> f64;
    /// Sets the inputs at the current time.
    fn set_inputs(&mut self, inputs: &[f64]);
    /// Replaces tunable parameters.
    ///
    /// # Errors
    /// When they do not fit together; nothing is changed then.
    fn retune(&mut self, parameters: &[f64]) -> Result<(), ParameterError>;
    /// Integrates to a time in s.
    ///
    /// # Errors
    /// When it cannot be reached; the state is then the last accepted one.
    fn advance(&mut self, end: f64) -> Result<(), StepError>;
    /// Writes all computed variables.
    fn values(&mut self, computed: &mut [f64]);
}

impl<E: System<U>, const N: usize, const U: usize> Running for Embedded<E, N, U> {
    fn time(&self) -> f64 {
        Embedded::time(self)
    }

    fn set_inputs(&mut self, inputs: &[f64]) {
        Embedded::set_inputs(self, &std::array::from_fn(|place| inputs[place]));
    }

    fn retune(&mut self, parameters: &[f64]) -> Result<(), ParameterError> {
        Embedded::retune(self, parameters)
    }

    fn advance(&mut self, end: f64) -> Result<(), StepError> {
        Embedded::advance(self, end)
    }

    fn values(&mut self, computed: &mut [f64]) {
        Embedded::values(self, computed);
    }
}

/// A run of a model with its table: behind its parameters stand the integers that choose by number, which choose nothing.
struct Modelled {
    run: Box<dyn Simulation>,
    parameters: Vec<f64>,
}

impl Running for Modelled {
    fn time(&self) -> f64 {
        self.run.time()
    }

    fn set_inputs(&mut self, inputs: &[f64]) {
        self.run.set_inputs(inputs, &[0.0; MOST_INPUTS][..inputs.len()]);
    }

    fn retune(&mut self, parameters: &[f64]) -> Result<(), ParameterError> {
        self.parameters[..parameters.len()].copy_from_slice(parameters);
        self.run.retune(&self.parameters)
    }

    fn advance(&mut self, end: f64) -> Result<(), StepError> {
        self.run.advance(end)
    }

    fn values(&mut self, computed: &mut [f64]) {
        self.run.values(computed);
    }
}

/// Begins a run from parameters and inputs, with a number of computed variables.
pub type Begin = fn(&[f64], &[f64], usize) -> Result<Box<dyn Running>, ParameterError>;

/// Begins a run of equations without a table.
///
/// # Errors
/// When parameters do not fit together.
pub fn begin<E: System<U> + 'static, const N: usize, const U: usize>(
    parameters: &[f64],
    inputs: &[f64],
    computed: usize,
) -> Result<Box<dyn Running>, ParameterError> {
    let inputs = std::array::from_fn(|place| inputs[place]);
    Ok(Box::new(Embedded::<E, N, U>::new(parameters, &inputs, computed)?))
}

/// Begins a run of a model with its table.
///
/// # Errors
/// When parameters do not fit together.
pub fn begin_model(model: &Model, parameters: &[f64], inputs: &[f64]) -> Result<Box<dyn Running>, ParameterError> {
    let mut all = vec![0.0; model.table().parameters().count()];
    all[..parameters.len()].copy_from_slice(parameters);
    let run = model.begin(&Start { time: 0.0, parameters: &all, inputs, tolerance: None, seeds: Seeds::NONE })?;
    Ok(Box::new(Modelled { run, parameters: all }))
}

/// The most inputs that a model may have in a loop.
const MOST_INPUTS: usize = 32;

/// The one run of a module.
pub struct Loop {
    begin: Begin,
    log: Log,
    run: Option<Box<dyn Running>>,
    /// Inputs, parameters, computed variables.
    values: Vec<f64>,
    /// Number of inputs and of parameters.
    counts: [usize; 2],
}

impl Loop {
    /// A loop whose run has not begun.
    pub const fn new(begin: Begin, log: Log) -> Self {
        Self { begin, log, run: None, values: Vec::new(), counts: [0; 2] }
    }

    /// Where inputs, parameters and computed variables are; NULL without memory for them. A run that was there has ended.
    pub fn room(&mut self, inputs: usize, parameters: usize, computed: usize) -> *mut f64 {
        self.run = None;
        self.values.clear();
        let values = inputs + parameters + computed;
        if self.values.try_reserve_exact(values).is_err() {
            return ptr::null_mut();
        }
        self.values.resize(values, 0.0);
        self.counts = [inputs, parameters];
        self.values.as_mut_ptr()
    }

    /// Begins the run with the present parameters and inputs.
    pub fn start(&mut self) -> Status {
        let [inputs, parameters, computed] = self.parts();
        match (self.begin)(parameters, inputs, computed.len()) {
            Ok(run) => {
                self.run = Some(run);
                Status::Ok
            }
            Err(error) => self.refuse(&error),
        }
    }

    /// Takes over tunable parameters.
    pub fn retune(&mut self) -> Status {
        let [inputs, parameters] = self.counts;
        match self.run.as_mut().map(|run| run.retune(&self.values[inputs..][..parameters])) {
            Some(Err(error)) => self.refuse(&error),
            _ => Status::Ok,
        }
    }

    /// Integrates to a time in s with the present inputs.
    pub fn advance(&mut self, end: f64) -> Status {
        let Some(run) = &mut self.run else { return self.refuse(&"the run has not begun") };
        run.set_inputs(&self.values[..self.counts[0]]);
        match run.advance(end) {
            Ok(()) => Status::Ok,
            Err(error) => self.refuse(&error),
        }
    }

    /// Time in s that the run has reached.
    pub fn time(&self) -> f64 {
        self.run.as_ref().map_or(0.0, |run| run.time())
    }

    /// Computes all computed variables under the present inputs.
    pub fn read(&mut self) {
        let [inputs, parameters] = self.counts;
        let Some(run) = &mut self.run else { return };
        run.set_inputs(&self.values[..inputs]);
        run.values(&mut self.values[inputs + parameters..]);
    }

    /// Tells why a call is refused.
    fn refuse(&self, why: &dyn Display) -> Status {
        (self.log)(&why.to_string());
        Status::Error
    }

    fn parts(&self) -> [&[f64]; 3] {
        let (inputs, rest) = self.values.split_at(self.counts[0]);
        let (parameters, computed) = rest.split_at(self.counts[1]);
        [inputs, parameters, computed]
    }
}

/// Makes the crate that calls it, compiled as a `cdylib` for WebAssembly, a module with one run, which a [`Begin`] begins, and
/// a [heap](heap::Heap) of its own.
#[macro_export]
macro_rules! export_loop {
    ($begin:expr) => {
        #[cfg(target_family = "wasm")]
        const _: () = {
            #[global_allocator]
            static HEAP: $crate::heap::Heap = $crate::heap::Heap::new();

            unsafe extern "C" {
                /// Where the data of the module ends, as the linker says.
                static __heap_base: u8;
            }

            /// Gives the module the memory up to an address; the first call of all.
            #[unsafe(no_mangle)]
            extern "C" fn loop_memory(end: usize) {
                // SAFETY: nothing is allocated yet, and what is behind the data belongs to nobody.
                unsafe { HEAP.give((&raw const __heap_base) as usize, end) }
            }
        };
        $crate::export_calls! { $begin }
    };
}

/// The functions of a loop alone, for a module with a heap.
#[doc(hidden)]
#[macro_export]
macro_rules! export_calls {
    ($begin:expr) => {
        #[cfg(target_family = "wasm")]
        const _: () = {
            use std::cell::RefCell;
            use std::ffi::{CString, c_char, c_int};

            thread_local! {
                static LOOP: RefCell<$crate::Loop> = const { RefCell::new($crate::Loop::new($begin, log)) };
            }

            // Named as a module's import: linkers refuse a function that is merely declared.
            #[link(wasm_import_module = "env")]
            unsafe extern "C" {
                /// Takes a message to the host.
                fn host_log(status: c_int, category: *const c_char, text: *const c_char);
            }

            fn log(text: &str) {
                let text = CString::new(text).unwrap_or_default();
                // SAFETY: the host only reads.
                unsafe { host_log($crate::Status::Error as c_int, c"error".as_ptr(), text.as_ptr()) }
            }

            #[unsafe(no_mangle)]
            extern "C" fn loop_room(inputs: usize, parameters: usize, computed: usize) -> *mut f64 {
                LOOP.with_borrow_mut(|it| it.room(inputs, parameters, computed))
            }

            #[unsafe(no_mangle)]
            extern "C" fn loop_start() -> u32 {
                LOOP.with_borrow_mut(|it| it.start()) as u32
            }

            #[unsafe(no_mangle)]
            extern "C" fn loop_retune() -> u32 {
                LOOP.with_borrow_mut(|it| it.retune()) as u32
            }

            #[unsafe(no_mangle)]
            extern "C" fn loop_advance(end: f64) -> u32 {
                LOOP.with_borrow_mut(|it| it.advance(end)) as u32
            }

            #[unsafe(no_mangle)]
            extern "C" fn loop_time() -> f64 {
                LOOP.with_borrow(|it| it.time())
            }

            #[unsafe(no_mangle)]
            extern "C" fn loop_read() {
                LOOP.with_borrow_mut(|it| it.read());
            }
        };
    };
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use pneumatic_servo::models::pneumatic_servo_cylinder::{MODEL, PneumaticServoCylinder};

    use super::*;

    thread_local! {
        static TOLD: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
    }

    fn log(text: &str) {
        TOLD.with_borrow_mut(|told| told.push(text.to_owned()));
    }

    fn told() -> String {
        TOLD.with_borrow_mut(std::mem::take).join("\n")
    }

    /// The cylinder without options, with room for the states of any law.
    const ALONE: Begin = begin::<PneumaticServoCylinder, 18, 3>;
    /// The cylinder with its table.
    const MODELLED: Begin = |parameters, inputs, _| begin_model(&MODEL, parameters, inputs);

    /// A loop with defaults, but for some values by name.
    struct Named(Loop);

    impl Named {
        fn new(begin: Begin, others: &[(&str, f64)]) -> Self {
            let table = MODEL.table();
            let parameters = table.parameters().filter(|it| it.chooses.is_none()).count();
            let mut it = Self(Loop::new(begin, log));
            assert!(!it.0.room(table.inputs().count(), parameters, table.computed().count()).is_null());
            let all = table.inputs().chain(table.parameters().filter(|it| it.chooses.is_none()));
            let starts: Vec<f64> = all.filter_map(|it| it.start).collect();
            it.0.values[..starts.len()].copy_from_slice(&starts);
            others.iter().for_each(|(name, value)| it.set(name, *value));
            it
        }

        fn set(&mut self, name: &str, value: f64) {
            let table = MODEL.table();
            let place = table.inputs().chain(table.parameters()).position(|it| it.name == name).expect("a name");
            self.0.values[place] = value;
        }

        fn computed(&mut self) -> Vec<u64> {
            self.0.read();
            self.0.parts()[2].iter().map(|value| value.to_bits()).collect()
        }
    }

    /// Under a set-valued law, a bristle and elements, with parameters that change on the way.
    #[test]
    fn a_run_without_a_table_has_the_bits_of_the_model() {
        let fewer = begin::<PneumaticServoCylinder, 8, 3> as Begin;
        for (law, alone) in [(7.0, fewer), (7.0, ALONE), (14.0, ALONE), (16.0, ALONE)] {
            let mut runs =
                [alone, MODELLED].map(|begin| Named::new(begin, &[("friction.law", law), ("supplyPressure", 6e5)]));
            assert_eq!(runs.each_mut().map(|run| run.0.start()), [Status::Ok; 2], "{}", told());
            for step in 0..200 {
                if step == 120 {
                    for run in &mut runs {
                        ["friction.stribeck.Fc", "friction.lugre.Fc"].iter().for_each(|name| run.set(name, 8.0));
                        assert_eq!(run.0.retune(), Status::Ok, "{}", told());
                    }
                }
                for run in &mut runs {
                    run.set("valveVoltage", 5.0 + 3.0 * triangle(step));
                    assert_eq!(run.0.advance(f64::from(step + 1) * 1e-3), Status::Ok, "{}", told());
                }
                let [alone, model] = runs.each_mut().map(Named::computed);
                assert_eq!(alone, model, "law {law}, step {step}");
            }
            assert_eq!(runs.each_mut().map(|run| run.0.time()), [0.2; 2]);
        }
    }

    /// A triangle between -1 and 1 with a period of 100 steps.
    fn triangle(step: i32) -> f64 {
        let phase = f64::from(step % 100) / 25.0;
        if phase < 1.0 {
            phase
        } else if phase < 3.0 {
            2.0 - phase
        } else {
            phase - 4.0
        }
    }

    #[test]
    fn what_is_not_compiled_or_does_not_fit_is_refused() {
        for (name, value, expected) in [
            ("hoseA.length", 1.0, "options"),
            ("cylinder.rodA", 1.0, "cylinder.rodA = 1 is refused: it must be smaller than cylinder.bore"),
        ] {
            let mut run = Named::new(ALONE, &[("friction.law", 14.0), (name, value)]);
            assert_eq!(run.0.start(), Status::Error);
            let why = told();
            assert!(why.contains(expected), "{why}");
            assert_eq!(run.0.advance(1e-3), Status::Error);
            assert_eq!(told(), "the run has not begun");
            run.set(name, 0.0);
            assert_eq!(run.0.start(), Status::Ok, "{}", told());
        }
    }

    /// A step that needs more solver steps than it may take ends at the last one, where everything can be read, and the next goes on
    /// from there.
    #[test]
    fn a_bounded_step_ends_early_and_the_run_goes_on() {
        let mut run = Named::new(ALONE, &[("friction.law", 14.0), ("solver.maxStepsPerCommunicationStep", 5.0)]);
        assert_eq!(run.0.start(), Status::Ok, "{}", told());
        run.set("valveVoltage", 8.0);
        let (mut early, mut before) = (0, 0.0);
        let end = 0.2;
        while run.0.time() < end {
            let status = run.0.advance(end);
            assert!(run.0.time() > before, "{}", told());
            before = run.0.time();
            assert!(run.computed().iter().all(|bits| f64::from_bits(*bits).is_finite()));
            if status == Status::Error {
                early += 1;
                assert!(told().contains("the limit of 5 solver steps"));
            }
        }
        assert!(early > 10, "{early} steps ended early");
        // The results agree with a run without a bound, within the tolerance.
        let mut free = Named::new(ALONE, &[("friction.law", 14.0)]);
        assert_eq!(free.0.start(), Status::Ok);
        free.set("valveVoltage", 8.0);
        assert_eq!(free.0.advance(end), Status::Ok);
        let place = MODEL.table().computed().position(|it| it.name == "position").expect("a position");
        let [bounded, free] = [&mut run, &mut free].map(|run| f64::from_bits(run.computed()[place]));
        assert!((bounded - free).abs() < 1e-6 && free > 0.05, "{bounded} m instead of {free} m");
    }
}
