//! Allocations of an observer's steps. An allocator of this test counts them.

#![allow(unsafe_code, reason = "an allocator is made")]
#![cfg(feature = "sensitivities")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use pneumatic_servo::model::{Method, Observed, Observer, Setup};
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

/// Counts the allocations of a thread.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// SAFETY: all is left to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// Steps, and those until rooms have their sizes: a period of the motion.
const STEPS: usize = 2500;
const BEGIN: usize = 1000;

/// Lets an observer follow its plant, with reversals and rests, and returns the allocations of each step.
fn followed(law: &str, method: Method) -> Result<Vec<u64>, Box<dyn std::error::Error>> {
    let setup = Setup::new(&MODEL).set("friction.law", law)?.set("supplyPressure", 6e5)?;
    let mut plant = setup.start(0.0)?;
    let observed = Observed { measured: &[("position", 20e-6)], period: 1e-3, process: &[], initial: &[], method };
    let mut observer = Observer::new(&setup, observed)?;
    let mut inputs = setup.inputs().to_vec();
    let mut allocations = Vec::with_capacity(STEPS);
    for step in 0..STEPS {
        let time = step as f64 * 1e-3;
        inputs[0] = 5.0 + 1.2 * libm::sin(std::f64::consts::TAU * time);
        plant.set_input(0, inputs[0])?;
        plant.step(1e-3)?;
        let measured = [Some(plant.get("position")?)];
        let before = ALLOCATIONS.get();
        observer.update(&inputs, &measured)?;
        allocations.push(ALLOCATIONS.get() - before);
    }
    let velocity = plant.get("velocity")?;
    let place = MODEL.table().find("velocity").expect("a variable").place;
    assert!((observer.value(place) - velocity).abs() < 5e-3, "{law}: it follows the plant");
    Ok(allocations)
}

/// Also where derivatives are lost, as at events.
#[test]
fn step_of_an_observer_does_not_allocate() -> Result<(), Box<dyn std::error::Error>> {
    let extended = ["Stribeck", "LuGre", "Karnopp"].map(|law| (law, Method::Extended));
    let unscented = ["Stribeck", "LuGre", "Bristle"].map(|law| (law, Method::Unscented));
    for (law, method) in extended.into_iter().chain(unscented) {
        let some = followed(law, method)?.into_iter().skip(BEGIN).filter(|number| *number > 0).count();
        assert_eq!(some, 0, "{law}, {method:?}: of {} steps", STEPS - BEGIN);
    }
    Ok(())
}
