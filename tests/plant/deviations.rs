//! Bounds on deviations in the other tests: nothing that is no number passes.

use std::panic::catch_unwind;

use crate::bounds::{close, farthest, larger, largest, loosely, smaller, within};

#[test]
fn largest_of_numbers_with_nan_is_nan_wherever_it_stands() {
    assert_eq!(largest([1.0, 3.0, 2.0]), 3.0);
    assert_eq!(largest([]), 0.0);
    for place in 0..3 {
        let mut numbers = [1.0, 3.0, 2.0];
        numbers[place] = f64::NAN;
        assert!(largest(numbers).is_nan(), "{place}");
        assert!(farthest(&numbers, &[0.0; 3]).is_nan() && farthest(&[0.0; 3], &numbers).is_nan(), "{place}");
    }
    assert!(larger(f64::NAN, f64::INFINITY).is_nan() && larger(f64::INFINITY, f64::NAN).is_nan());
    assert!(smaller(f64::NAN, 1.0).is_nan() && smaller(1.0, f64::NAN).is_nan());
    assert_eq!((smaller(1.0, -2.0), smaller(-2.0, 1.0)), (-2.0, -2.0));
    assert_eq!(farthest(&[1.0, 2.0], &[1.5, 0.0]), 2.0);
}

#[test]
fn nan_passes_no_bound() {
    for bound in [0.0, 1.0, f64::INFINITY, f64::NAN] {
        assert!(catch_unwind(|| within(f64::NAN, bound, "")).is_err(), "{bound}");
        assert!(catch_unwind(|| loosely(f64::NAN, bound, "", "")).is_err(), "{bound}");
        assert!(catch_unwind(|| close(f64::NAN, 1.0, bound, "")).is_err(), "{bound}");
        assert!(catch_unwind(|| close(1.0, f64::NAN, bound, "")).is_err(), "{bound}");
    }
    assert!(catch_unwind(|| within(1.0, f64::NAN, "")).is_err());
}

#[test]
fn what_is_beyond_its_bound_fails_and_the_bound_itself_does_not() {
    assert!(catch_unwind(|| within(1.1, 1.0, "")).is_err());
    assert!(catch_unwind(|| loosely(1.1, 1.0, "", "")).is_err());
    assert!(catch_unwind(|| close(3.0, 1.5, 1.0, "")).is_err());
    assert!(catch_unwind(|| farthest(&[1.0], &[1.0, 2.0])).is_err());
    within(1.0, 1.0, "");
    loosely(1.0, 1.0, "", "");
    close(1.5, 2.5, 1.0, "");
}
