//! CVODE of SUNDIALS 6, through its C interface.
//!
//! Hindmarsh, Brown, Grant, Lee, Serban, Shumaker, Woodward (2005), ACM Trans. Mathematical Software 31(3):363-396.

#![allow(unsafe_code, reason = "a C library is called")]

use std::ffi::{c_int, c_long, c_void};
use std::ptr;

use anyhow::{Result, ensure};

use super::Tolerances;
use crate::case::DURATION;
use crate::plant::{Plant, Solver};

type Handle = *mut c_void;
type Rates = extern "C" fn(f64, Handle, Handle, *mut c_void) -> c_int;
type Jacobian = extern "C" fn(f64, Handle, Handle, Handle, *mut c_void, Handle, Handle, Handle) -> c_int;

#[link(name = "sundials_cvode")]
#[link(name = "sundials_nvecserial")]
#[link(name = "sundials_sunmatrixdense")]
#[link(name = "sundials_sunlinsoldense")]
unsafe extern "C" {
    fn SUNContext_Create(communicator: *mut c_void, context: *mut Handle) -> c_int;
    fn SUNContext_Free(context: *mut Handle) -> c_int;
    fn N_VNew_Serial(length: i64, context: Handle) -> Handle;
    fn N_VGetArrayPointer(vector: Handle) -> *mut f64;
    fn N_VDestroy(vector: Handle);
    fn SUNDenseMatrix(rows: i64, columns: i64, context: Handle) -> Handle;
    fn SUNDenseMatrix_Data(matrix: Handle) -> *mut f64;
    fn SUNMatDestroy(matrix: Handle);
    fn SUNLinSol_Dense(vector: Handle, matrix: Handle, context: Handle) -> Handle;
    fn SUNLinSolFree(solver: Handle) -> c_int;
    fn CVodeCreate(method: c_int, context: Handle) -> Handle;
    fn CVodeInit(memory: Handle, rates: Rates, time: f64, states: Handle) -> c_int;
    fn CVodeReInit(memory: Handle, time: f64, states: Handle) -> c_int;
    fn CVodeSVtolerances(memory: Handle, relative: f64, absolute: Handle) -> c_int;
    fn CVodeSetUserData(memory: Handle, data: *mut c_void) -> c_int;
    fn CVodeSetLinearSolver(memory: Handle, solver: Handle, matrix: Handle) -> c_int;
    fn CVodeSetJacFn(memory: Handle, jacobian: Jacobian) -> c_int;
    fn CVodeSetMaxNumSteps(memory: Handle, steps: c_long) -> c_int;
    fn CVodeSetStopTime(memory: Handle, time: f64) -> c_int;
    fn CVode(memory: Handle, until: f64, states: Handle, reached: *mut f64, task: c_int) -> c_int;
    fn CVodeGetDky(memory: Handle, time: f64, order: c_int, states: Handle) -> c_int;
    fn CVodeFree(memory: *mut Handle);
}

const BDF: c_int = 2;
const ONE_STEP: c_int = 2;
const NO_LIMIT: c_long = -1;

/// CVODE with dense LU and the exact Jacobian, at work.
pub struct Cvode<'p, const N: usize> {
    /// Context of the callbacks.
    plant: &'p Plant,
    context: Handle,
    memory: Handle,
    states: Handle,
    interpolated: Handle,
    tolerances: Handle,
    matrix: Handle,
    linear: Handle,
    time: f64,
}

impl<'p, const N: usize> Cvode<'p, N> {
    /// Starts at time 0.
    ///
    /// # Errors
    /// When CVODE refuses something.
    pub fn new(plant: &'p Plant, x: &[f64; N], tolerances: &Tolerances<N>) -> Result<Self> {
        let mut context = ptr::null_mut();
        // SAFETY: each handle is used as the manual of CVODE says, and freed once, when this value is dropped.
        let this = unsafe {
            check("SUNContext_Create", SUNContext_Create(ptr::null_mut(), &mut context))?;
            let [states, interpolated, absolute] = [(); 3].map(|()| N_VNew_Serial(N as i64, context));
            let matrix = SUNDenseMatrix(N as i64, N as i64, context);
            Self {
                context,
                memory: CVodeCreate(BDF, context),
                states,
                interpolated,
                tolerances: absolute,
                matrix,
                linear: SUNLinSol_Dense(states, matrix, context),
                time: 0.0,
                plant,
            }
        };
        this.write(this.states, x);
        this.write(this.tolerances, &tolerances.absolute);
        let data: *const Plant = this.plant;
        // SAFETY: the handles are valid; the callbacks' data live as long as this value.
        unsafe {
            check("CVodeInit", CVodeInit(this.memory, rates::<N>, 0.0, this.states))?;
            let set = CVodeSVtolerances(this.memory, tolerances.relative, this.tolerances);
            check("CVodeSVtolerances", set)?;
            check("CVodeSetUserData", CVodeSetUserData(this.memory, data.cast_mut().cast()))?;
            check("CVodeSetLinearSolver", CVodeSetLinearSolver(this.memory, this.linear, this.matrix))?;
            check("CVodeSetJacFn", CVodeSetJacFn(this.memory, jacobian::<N>))?;
            check("CVodeSetMaxNumSteps", CVodeSetMaxNumSteps(this.memory, NO_LIMIT))?;
        }
        Ok(this)
    }

    fn write(&self, vector: Handle, values: &[f64; N]) {
        // SAFETY: the vectors of this value have N elements.
        unsafe { N_VGetArrayPointer(vector).cast::<[f64; N]>().write(*values) };
    }
}

impl<const N: usize> Solver<N> for Cvode<'_, N> {
    fn time(&self) -> f64 {
        self.time
    }

    fn states(&self) -> [f64; N] {
        read(self.states)
    }

    fn step(&mut self) -> Result<()> {
        // From the time asked for, CVODE judges its first step.
        let until = self.time + DURATION;
        // SAFETY: the handles are valid.
        let status = unsafe { CVode(self.memory, until, self.states, &mut self.time, ONE_STEP) };
        check("CVode", status)
    }

    fn interpolate(&self, time: f64) -> Result<[f64; N]> {
        // SAFETY: the handles are valid.
        check("CVodeGetDky", unsafe { CVodeGetDky(self.memory, time, 0, self.interpolated) })?;
        Ok(read(self.interpolated))
    }

    fn restart(&mut self, time: f64, states: &[f64; N]) -> Result<()> {
        self.time = time;
        self.write(self.states, states);
        // SAFETY: the handles are valid.
        check("CVodeReInit", unsafe { CVodeReInit(self.memory, time, self.states) })
    }

    fn stop_at(&mut self, time: f64) -> Result<()> {
        // SAFETY: the handle is valid.
        check("CVodeSetStopTime", unsafe { CVodeSetStopTime(self.memory, time) })
    }
}

impl<const N: usize> Drop for Cvode<'_, N> {
    fn drop(&mut self) {
        // SAFETY: each handle is freed once, what others refer to last.
        unsafe {
            CVodeFree(&mut self.memory);
            SUNLinSolFree(self.linear);
            SUNMatDestroy(self.matrix);
            [self.states, self.interpolated, self.tolerances].into_iter().for_each(|vector| N_VDestroy(vector));
            SUNContext_Free(&mut self.context);
        }
    }
}

/// Negative numbers are errors; positive ones say why it returned.
fn check(function: &str, status: c_int) -> Result<()> {
    ensure!(status >= 0, "{function} returned {status}");
    Ok(())
}

fn read<const N: usize>(vector: Handle) -> [f64; N] {
    // SAFETY: the vectors given here have N elements.
    unsafe { N_VGetArrayPointer(vector).cast::<[f64; N]>().read() }
}

extern "C" fn rates<const N: usize>(time: f64, states: Handle, rates: Handle, plant: *mut c_void) -> c_int {
    // SAFETY: CVODE hands on the data of `Cvode::new` and vectors of N elements.
    let (plant, slots) = unsafe { (&*plant.cast::<Plant>(), &mut *N_VGetArrayPointer(rates).cast::<[f64; N]>()) };
    *slots = plant.rates(time, &read::<N>(states));
    0
}

extern "C" fn jacobian<const N: usize>(
    time: f64,
    states: Handle,
    _rates: Handle,
    matrix: Handle,
    plant: *mut c_void,
    _first: Handle,
    _second: Handle,
    _third: Handle,
) -> c_int {
    // SAFETY: CVODE hands on the data of `Cvode::new` and a dense matrix of N rows, stored by columns.
    let (plant, slots) =
        unsafe { (&*plant.cast::<Plant>(), &mut *SUNDenseMatrix_Data(matrix).cast::<[[f64; N]; N]>()) };
    *slots = plant.jacobian(time, &read::<N>(states));
    0
}
