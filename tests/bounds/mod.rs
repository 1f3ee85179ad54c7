//! Deviations held against bounds. NaN passes none of them, and how much of each bound is used is recorded in
//! `target/tmp/bounds`, of which `cargo xtask bounds` makes a report.

#![allow(dead_code, reason = "each test uses a part of it")]

use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::Write;
use std::panic::Location;
use std::sync::Mutex;

/// The larger of two numbers; NaN if one of them is.
pub fn larger(one: f64, other: f64) -> f64 {
    if one.is_nan() || other <= one { one } else { other }
}

/// The smaller of two numbers; NaN if one of them is.
pub fn smaller(one: f64, other: f64) -> f64 {
    -larger(-one, -other)
}

/// The largest of numbers that are not negative; NaN if one of them is, 0 if there is none.
pub fn largest(numbers: impl IntoIterator<Item = f64>) -> f64 {
    numbers.into_iter().fold(0.0, larger)
}

/// The largest distance between numbers in pairs; NaN if one of them is.
///
/// # Panics
/// When there are more of one than of the other.
pub fn farthest<'a>(
    some: impl IntoIterator<Item = &'a f64, IntoIter: ExactSizeIterator>,
    others: impl IntoIterator<Item = &'a f64, IntoIter: ExactSizeIterator>,
) -> f64 {
    let (some, others) = (some.into_iter(), others.into_iter());
    assert_eq!(some.len(), others.len(), "as many of one as of the other");
    largest(some.zip(others).map(|(one, other)| (one - other).abs()))
}

/// Demands that a deviation is at most as large as its bound.
///
/// # Panics
/// When it is larger, or NaN.
#[track_caller]
pub fn within(deviation: f64, bound: f64, at: impl Display) {
    hold(deviation, bound, 0.0, "", format_args!("{at}: {deviation:e}"));
}

/// Demands that a number is another one but for a deviation within a bound.
///
/// # Panics
/// When it is farther away, or one of them is NaN.
#[track_caller]
pub fn close(found: f64, expected: f64, bound: f64, at: impl Display) {
    /// Relative. Less than this does not count as observed: it is how far numbers are apart that are the same but for rounding.
    const ROUNDING: f64 = 8.0 * f64::EPSILON;
    let deviation = (found - expected).abs();
    hold(
        deviation,
        bound,
        ROUNDING * expected.abs(),
        "",
        format_args!("{at}: {found:?}, not {expected:?}; {deviation:e} apart"),
    );
}

/// As [`within`], where there is a reason for a bound of more than ten times what is observed.
///
/// # Panics
/// When the deviation is larger, or NaN.
#[track_caller]
pub fn loosely(deviation: f64, bound: f64, reason: &str, at: impl Display) {
    hold(deviation, bound, 0.0, reason, format_args!("{at}: {deviation:e}"));
}

/// Records how much of a bound is used, by the deviation or by rounding, and demands that it is no more than all.
#[track_caller]
fn hold(deviation: f64, bound: f64, rounding: f64, reason: &str, said: impl Display) {
    record(Location::caller(), larger(deviation, rounding), bound, reason);
    assert!(deviation <= bound, "{said}, beyond {bound:e}");
}

/// The largest share of its bound that each test has used in each place so far.
static USED: Mutex<BTreeMap<(String, &Location), f64>> = Mutex::new(BTreeMap::new());

/// Adds a line to the record wherever more of a bound is used than before. A bound of 0 demands equality and has no share.
fn record(place: &'static Location<'static>, deviation: f64, bound: f64, reason: &str) {
    let share = deviation / bound;
    if !share.is_finite() {
        return;
    }
    // A test that has failed while it held the lock leaves the shares as they were.
    let mut used = USED.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    // Each test has a thread of its own, which is named after it.
    let test = std::thread::current().name().unwrap_or_default().to_owned();
    let most = used.entry((test.clone(), place)).or_insert(-1.0);
    if share <= *most {
        return;
    }
    *most = share;
    let folder = concat!(env!("CARGO_TARGET_TMPDIR"), "/bounds");
    std::fs::create_dir_all(folder).expect("the folder of the record");
    let file = format!("{folder}/{}.csv", env!("CARGO_CRATE_NAME"));
    let mut file = std::fs::OpenOptions::new().create(true).append(true).open(&file).expect(&file);
    let line = format!("{};{};{test};{deviation:e};{bound:e};{reason}\n", place.file(), place.line());
    file.write_all(line.as_bytes()).expect("a line of the record");
}
