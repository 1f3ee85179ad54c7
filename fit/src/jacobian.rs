//! Derivatives of the differences between data and simulation.

use nalgebra::DMatrix;

use crate::problem::{Interrupted, Problem};

/// Derivatives of the differences, with a row for each sample and a column for each place of the vector, by finite differences
/// within the bounds. `base` are the differences at the vector.
///
/// The start values of one kind are moved in all segments together: no segment depends on the start of another. Where a law refuses one
/// side, as sliding friction beyond break-away, the other side is taken.
///
/// # Errors
/// [`Interrupted`].
pub fn sensitivities(
    problem: &Problem<'_>,
    x: &[f64],
    base: &[f64],
    tolerance: f64,
    is_central: bool,
) -> Result<DMatrix<f64>, Interrupted> {
    let directions = directions(problem);
    let (low, high) = problem.bounds();
    let moved = |direction: &Vec<usize>, by: f64| {
        let mut vector = x.to_vec();
        direction.iter().for_each(|place| vector[*place] = (x[*place] + by).clamp(low[*place], high[*place]));
        vector
    };
    let ups: Vec<_> = directions.iter().map(|direction| moved(direction, problem.step)).collect();
    let downs: Vec<_> = directions.iter().map(|direction| moved(direction, -problem.step)).collect();
    let count = directions.len();
    let both = if is_central { [&ups[..], &downs[..]].concat() } else { ups.clone() };
    let mut above = problem.simulated.near(x, &both, tolerance)?;
    let mut below: Vec<Option<Vec<f64>>> = above.split_off(count).into_iter().map(Some).collect();
    below.resize(count, None);
    let tells = |vector: &[f64], run: &[f64]| vector != x && !run.iter().all(|value| value.is_nan());
    let has_above: Vec<bool> = ups.iter().zip(&above).map(|(up, run)| tells(up, run)).collect();
    let lacking: Vec<usize> = (0..count).filter(|index| !is_central && !has_above[*index]).collect();
    let others: Vec<_> = lacking.iter().map(|index| downs[*index].clone()).collect();
    for (index, run) in lacking.into_iter().zip(problem.simulated.near(x, &others, tolerance)?) {
        below[index] = Some(run);
    }
    for (run, down) in below.iter_mut().zip(&downs) {
        run.take_if(|run| !tells(down, run));
    }
    let slopes: Vec<Vec<f64>> = directions
        .iter()
        .enumerate()
        .map(|(index, direction)| {
            let (first, up) = if has_above[index] { (&*ups[index], &*above[index]) } else { (x, base) };
            let (second, down) = below[index].as_ref().map_or((x, base), |run| (&*downs[index], &**run));
            let size = first[direction[0]] - second[direction[0]];
            up.iter().zip(down).map(|(up, down)| finite((up - down) / size)).collect()
        })
        .collect();
    Ok(by_column(problem, &slopes, base.len()))
}

/// Derivatives of the residuals of the data.
///
/// # Errors
/// [`Interrupted`].
pub fn jacobian(
    problem: &Problem<'_>,
    x: &[f64],
    base: &[f64],
    tolerance: f64,
    is_central: bool,
) -> Result<DMatrix<f64>, Interrupted> {
    let mut slopes = sensitivities(problem, x, base, tolerance, is_central)?;
    scale_rows(&mut slopes, &problem.by_sensor(base, |sensor, difference| finite(sensor.slope(difference))));
    Ok(slopes)
}

/// Multiplies each row by a number.
pub fn scale_rows(matrix: &mut DMatrix<f64>, factors: &[f64]) {
    for mut column in matrix.column_iter_mut() {
        column.iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor);
    }
}

fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

/// Places of the vector that are moved together: each parameter, and the start values of each place in all segments.
fn directions(problem: &Problem<'_>) -> Vec<Vec<usize>> {
    let mut directions: Vec<Vec<usize>> = (0..problem.parameters.len()).map(|place| vec![place]).collect();
    let (free, mut place) = (directions.len(), directions.len());
    for segment in &problem.segments {
        directions.resize(directions.len().max(free + segment.begins), Vec::new());
        for kind in 0..segment.begins {
            directions[free + kind].push(place);
            place += 1;
        }
    }
    directions
}

/// The derivatives along the directions as columns of the vector.
fn by_column(problem: &Problem<'_>, slopes: &[Vec<f64>], rows: usize) -> DMatrix<f64> {
    let free = problem.parameters.len();
    let mut columns = DMatrix::zeros(rows, problem.dimension());
    for (column, slope) in slopes[..free].iter().enumerate() {
        columns.column_mut(column).copy_from_slice(slope);
    }
    let (mut row, mut column) = (0, free);
    for segment in &problem.segments {
        let last = row + segment.samples * problem.sensors.len();
        for slope in &slopes[free..free + segment.begins] {
            columns.column_mut(column).as_mut_slice()[row..last].copy_from_slice(&slope[row..last]);
            column += 1;
        }
        row = last;
    }
    columns
}
