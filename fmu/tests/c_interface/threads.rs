//! Instances in many threads, and many instances.

use std::thread;

use crate::common::*;

#[test]
fn eight_threads_give_the_bits_of_one() {
    let run = || laws().into_iter().map(|(law, _)| Instance::with_law(law).swing(25)).collect::<Vec<_>>();
    let alone = run();
    let threads: Vec<_> = (0..8).map(|_| thread::spawn(run)).collect();
    for thread in threads {
        assert_eq!(thread.join().expect("no panic"), alone);
    }
}

#[test]
fn instance_may_move_between_threads() {
    let alone = Instance::initialized().swing(8);
    let mut instance = Instance::initialized();
    let mut seen = Vec::new();
    for _ in 0..8 {
        let (back, next) = thread::spawn(move || {
            let next = instance.swing(1);
            (instance, next)
        })
        .join()
        .expect("no panic");
        instance = back;
        seen.extend(next);
    }
    assert_eq!(seen, alone);
}
