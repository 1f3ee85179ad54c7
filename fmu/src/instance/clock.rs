//! The end of a communication step, and the tolerance for rounding between clocks.

use crate::failure::Failure;

/// The largest difference between two times that counts as rounding, for steps of a size.
///
/// Importers multiply or add up step sizes, count nanoseconds (a step of 1/60 s is 0.33 ns off), or have a clock of 32 bits (1 us
/// off at 20 s, 0.1 ms after an hour). As in the Reference-FMUs 1e-5 is allowed, absolute or relative. More than a quarter of a step
/// is never rounding, so that a step that is asked for twice is refused however late; a few units in the last place always are.
fn rounding(time: f64, size: f64) -> f64 {
    let allowed = 1e-5 * time.abs().max(1.0);
    allowed.min(0.25 * size).max(4.0 * f64::EPSILON * time.abs())
}

/// The end of the step of a size that the host asks for at a communication point: exactly their sum. A step begins where the
/// instance is, so that no time is lost or counted twice where that differs by rounding.
pub fn end_of_step(now: f64, point: f64, size: f64, stop: Option<f64>) -> Result<f64, Failure> {
    if !(size.is_finite() && size > 0.0) {
        return Err(Failure::error(format!("the communication step size must be positive and finite, not {size} s")));
    }
    let difference = (point - now).abs();
    if difference != 0.0 && (difference.is_nan() || difference > rounding(now, size)) {
        return Err(Failure::error(format!(
            "the communication point {point} s is not where the instance is, at {now} s, but {} s away",
            point - now
        )));
    }
    let end = point + size;
    if !end.is_finite() || end <= now {
        return Err(Failure::error(format!("the clock cannot resolve a step of {size} s at {now} s")));
    }
    if let Some(stop) = stop.filter(|stop| end > stop + rounding(*stop, size)) {
        return Err(Failure::error(format!(
            "the step from {point} s by {size} s leads to {end} s, past the stop time {stop} s"
        )));
    }
    Ok(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end(now: f64, point: f64, size: f64) -> Result<f64, Failure> {
        end_of_step(now, point, size, None)
    }

    #[test]
    fn step_ends_exactly_at_point_plus_size() {
        assert_eq!(end(0.1, 0.1 + 1e-17, 0.2), Ok(0.1 + 0.2));
        assert_eq!(end(256.0, 256.0, 0.04), Ok(256.04));
    }

    #[test]
    fn size_must_be_positive_and_finite() {
        for size in [0.0, -0.0, -1e-3, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let failure = end(1.0, 1.0, size).expect_err("an impossible size");
            assert!(failure.message.contains("must be positive and finite"), "{failure:?}");
        }
    }

    #[test]
    fn point_that_is_no_rounding_away_is_refused_with_both_numbers() {
        for point in [0.999, 1.001, -1.0, f64::NAN, f64::INFINITY] {
            let failure = end(1.0, point, 0.01).expect_err("a wrong point");
            assert!(failure.message.contains(&point.to_string()) && failure.message.contains("at 1 s"), "{failure:?}");
        }
    }

    /// However a host keeps its time, it is followed for as long as its clock tells one step from the next: at 1e9 s a double
    /// has 0.12 us.
    #[test]
    fn late_hosts_are_followed_however_they_count() {
        for start in [1e9, -1e9, 999_999_999.7] {
            for size in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
                let [mut multiplied, mut added, mut sum, mut in_nanoseconds] = [start; 4];
                for step in 0..20_000 {
                    multiplied = end(multiplied, start + f64::from(step) * size, size).expect("a product");
                    added = end(added, sum, size).expect("a sum");
                    sum += size;
                    let nanoseconds = (start * 1e9).round() as i64 + i64::from(step) * (size * 1e9).round() as i64;
                    in_nanoseconds = end(in_nanoseconds, nanoseconds as f64 / 1e9, size).expect("nanoseconds");
                }
            }
            let failure = end(start, start, 1e-8).expect_err("less than the clock can tell");
            assert!(failure.message.contains("cannot resolve"), "{failure:?}");
        }
    }

    /// A clock of 32 bits, with steps of 60 Hz, for an hour: the instance goes along and loses no time.
    #[test]
    fn clock_of_32_bits_is_followed_for_an_hour() {
        let size = 1.0 / 60.0_f32;
        let (mut clock, mut now) = (0.0f32, 0.0);
        while clock < 3600.0 {
            let next = end(now, f64::from(clock), f64::from(size)).expect("a step");
            assert!(next > now && (next - f64::from(clock) - f64::from(size)).abs() == 0.0);
            (clock, now) = (clock + size, next);
        }
    }

    #[test]
    fn step_that_is_asked_for_twice_is_refused_late_in_a_run() {
        for (now, size) in [(3600.0, 1e-3), (86_400.0, 0.01), (1e6, 1e-4)] {
            let failure = end(now + size, now, size).expect_err("the step has been made");
            assert!(failure.message.contains("s away"), "{failure:?}");
        }
    }

    /// A hundred thousandth of the time is more than a step of 2 s there.
    #[test]
    fn more_than_a_quarter_of_a_step_is_no_rounding_however_late_it_is() {
        let late = 2f64.powi(31);
        for (difference, is_rounding) in [(-0.75, false), (-0.5, true), (0.5, true), (0.75, false)] {
            assert_eq!(end(late, late + difference, 2.0).is_ok(), is_rounding, "{difference}");
        }
        for (beyond, is_rounding) in [(0.5, true), (0.75, false)] {
            let point = late - 2.0 + beyond;
            assert_eq!(end_of_step(point, point, 2.0, Some(late)).is_ok(), is_rounding, "{beyond}");
        }
    }

    #[test]
    fn grids_of_multiplied_and_of_added_steps_always_move() {
        for size in [1.0 / 60.0, 0.04, 1e-3, 1e-5, 0.1, 1.0 / 3.0] {
            for start in [0.0, 256.0, -7.3, 1e4] {
                let (mut now, mut sum) = (start, start);
                for index in 0..5000 {
                    let multiplied = start + f64::from(index) * size;
                    let point = if index % 2 == 0 { multiplied } else { sum };
                    let next = end(now, point, size).expect("rounding is tolerated");
                    assert!(next > now);
                    (now, sum) = (next, sum + size);
                }
            }
        }
    }

    #[test]
    fn step_that_the_clock_cannot_resolve_is_refused() {
        assert!(end(256.0, 256.0, 1e-15).is_err());
        assert!(end(1e300, 1e300, 1.0).is_err());
        assert!(end(f64::MAX, f64::MAX, f64::MAX).is_err());
    }

    #[test]
    fn smallest_resolvable_steps_move() {
        let mut now = 256.0;
        for _ in 0..100 {
            let next = end(now, now, 6e-14).expect("about one unit in the last place");
            assert!(next > now);
            now = next;
        }
    }

    #[test]
    fn stop_time_bounds_the_step_up_to_rounding() {
        assert!(end_of_step(0.9, 0.9, 0.1, Some(1.0)).is_ok());
        assert!(end_of_step(0.9, 0.9, 0.1 + 1e-12, Some(1.0)).is_ok());
        let failure = end_of_step(0.9, 0.9, 0.2, Some(1.0)).expect_err("past the stop time");
        assert!(failure.message.contains("stop time 1 s"), "{failure:?}");
        assert!(end_of_step(0.0, 0.0, 0.1, Some(0.0)).is_err());
    }
}
