//! Statistics and interpolation of samples.

/// Mean value.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Root mean square.
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

/// Value below which a share of the values lies, on straight lines between them.
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = share * (sorted.len() - 1) as f64;
    let low = place.floor() as usize;
    let high = (low + 1).min(sorted.len() - 1);
    sorted[low] + (place - low as f64) * (sorted[high] - sorted[low])
}

/// Median.
pub fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// Smallest and largest value.
pub fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// Largest less smallest value.
pub fn span(values: &[f64]) -> f64 {
    let (low, high) = extremes(values);
    high - low
}

/// Differences of successive values.
pub fn differences(values: &[f64]) -> Vec<f64> {
    values.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

/// Derivative of equidistant values by central differences, one-sided at the ends.
pub fn gradient(values: &[f64], step: f64) -> Vec<f64> {
    let last = values.len() - 1;
    let slope = |index: usize| {
        let (from, to) = (index.saturating_sub(1), (index + 1).min(last));
        (values[to] - values[from]) / ((to - from) as f64 * step)
    };
    (0..=last).map(slope).collect()
}

/// Slope, and value at 0, of the straight line through points by least squares.
pub fn line(across: &[f64], up: &[f64]) -> (f64, f64) {
    let (x, y) = (mean(across), mean(up));
    let (mut both, mut own) = (0.0, 0.0);
    for (a, b) in across.iter().zip(up) {
        both += (a - x) * (b - y);
        own += (a - x) * (a - x);
    }
    (both / own, y - both / own * x)
}

/// Values on straight lines through points whose abscissas rise, constant beyond the ends; `places` rise as well.
pub fn interpolate(places: impl IntoIterator<Item = f64>, across: &[f64], up: &[f64]) -> Vec<f64> {
    let last = across.len() - 1;
    let mut at = 0;
    let value = |place: f64| {
        while at < last && across[at + 1] <= place {
            at += 1;
        }
        if at == last || place <= across[at] {
            return up[at];
        }
        (up[at + 1] - up[at]) / (across[at + 1] - across[at]) * (place - across[at]) + up[at]
    };
    places.into_iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_passes_through_its_points_and_is_constant_beyond_them() {
        let found = interpolate([-1.0, 0.0, 0.25, 1.0, 2.5, 9.0], &[0.0, 1.0, 3.0], &[2.0, 4.0, 0.0]);
        assert_eq!(found, [2.0, 2.0, 2.5, 4.0, 1.0, 0.0]);
    }

    #[test]
    fn statistics_are_those_of_their_definitions() {
        assert_eq!(quantile(&[4.0, 1.0, 3.0, 2.0], 0.25), 1.75);
        assert_eq!(gradient(&[0.0, 1.0, 4.0, 9.0], 0.5), [2.0, 4.0, 8.0, 10.0]);
        let (slope, zero) = line(&[1.0, 2.0, 4.0], &[3.0, 5.0, 9.0]);
        assert!((slope - 2.0).abs() < 1e-15 && (zero - 1.0).abs() < 1e-15);
    }
}
