//! Numbers as people read them.

/// A number of some significant digits, without zeros at its end; powers of ten are for those too large or too small to be read
/// without.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let exponent = libm::floor(libm::log10(value.abs())) as i32;
    if !(-4..(digits as i32).max(7)).contains(&exponent) {
        let text = format!("{value:.*e}", digits - 1);
        return match text.split_once('e') {
            Some((mantissa, power)) => format!("{}e{power}", without_zeros(mantissa)),
            None => text,
        };
    }
    without_zeros(&format!("{value:.*}", (digits as i32 - 1 - exponent).max(0) as usize)).to_owned()
}

/// A decimal without zeros at the end of its fraction.
fn without_zeros(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_as_many_digits_as_are_asked_for() {
        let shown = [0.0, 1.0, 12.345, 0.001_234_5, 123_456.0, 1.5e-7, -1.5e7].map(|value| significant(value, 3));
        assert_eq!(shown, ["0", "1", "12.3", "0.00123", "123456", "1.5e-7", "-1.5e7"]);
        assert_eq!(significant(0.012_345_67, 5), "0.012346");
        // As many digits as are asked for need no power.
        assert_eq!([significant(2e9, 10), significant(2e10, 10)], ["2000000000", "2e10"]);
    }
}
