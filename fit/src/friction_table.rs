//! Measured friction over velocity as parameters of the friction law `Table`.

use crate::Refused;
use crate::arrays::interpolate;
use crate::matrix::{from_rows, pseudo_inverse, triangle};
use crate::numerals::significant;

/// Points that a direction may have.
pub const POINTS: usize = 11;
/// Singular values below this share of the largest count as 0.
const NO_RANK: f64 = 1e-12;

const SIDES: [(&str, f64); 2] = [("outwards", 1.0), ("inwards", -1.0)];

/// Names of a column in lower case without blanks, low lines and hyphens, in English and German.
const VELOCITY: &[&str] = &["velocity", "speed", "v", "vel", "geschwindigkeit"];
const FORCE: &[&str] = &["force", "friction", "frictionforce", "f", "ff", "reibung", "reibkraft", "kraft"];

/// A row of measured friction: its place, the speed in m/s and the force in N against the motion.
type Row = (usize, f64, f64);

/// The columns of velocity and force among the names of a table.
///
/// # Errors
/// [`Refused`] for a quantity without a column, or with several.
pub fn columns(table: &str, names: &[&str]) -> Result<[usize; 2], Refused> {
    let column = |quantity: &str, known: &[&str]| {
        let plain = |name: &str| name.to_lowercase().replace([' ', '_', '-'], "");
        let found: Vec<usize> =
            (0..names.len()).filter(|place| known.contains(&plain(names[*place]).as_str())).collect();
        match &found[..] {
            [place] => Ok(*place),
            [] => {
                let listed = names.join(", ");
                Err(Refused(format!(
                    "{table} has the columns {listed}: one of them must be {quantity}, called {}",
                    known.join(", ")
                )))
            }
            _ => {
                let found: Vec<&str> = found.iter().map(|place| names[*place]).collect();
                Err(Refused(format!(
                    "{table} has {} columns of {quantity}, {}: it must have one",
                    found.len(),
                    found.join(", ")
                )))
            }
        }
    };
    Ok([column("velocity", VELOCITY)?, column("force", FORCE)?])
}

/// The parameters of the law for velocities in m/s, positive outwards, and friction forces in N.
///
/// Forces have the sign of the velocity, or are all positive. At velocity 0 the sign is the direction; of forces that are all
/// positive the one there counts for both. A direction of at most [`POINTS`] velocities has them as its points; more are fitted by
/// a line with as many corners, which are closer where the carriage is slow. A direction without data takes the points of the
/// other one. Viscous friction is 0, since the points have it. `place` begins the message about a row, for example with file and
/// line.
///
/// # Errors
/// [`Refused`] for columns of different lengths, a direction of one velocity, no rows, and friction that drives.
pub fn settings(
    velocity: &[f64],
    force: &[f64],
    place: &dyn Fn(usize) -> String,
) -> Result<Vec<(String, f64)>, Refused> {
    if velocity.len() != force.len() {
        let (rows, forces) = (velocity.len(), force.len());
        return Err(Refused(format!("velocity has {rows} rows and force {forces}: they must have as many")));
    }
    let is_unsigned = force.iter().all(|force| *force >= 0.0) && velocity.iter().any(|velocity| *velocity < 0.0);
    let of_side = |sign: f64| -> Vec<Row> {
        let is_of = |velocity: f64, force: f64| {
            if velocity != 0.0 { velocity * sign > 0.0 } else { is_unsigned || (force < 0.0) == (sign < 0.0) }
        };
        let rows = velocity.iter().zip(force).enumerate().filter(|(_, (velocity, force))| is_of(**velocity, **force));
        rows.map(|(row, (velocity, force))| (row, velocity.abs(), if is_unsigned { *force } else { sign * force }))
            .collect()
    };
    let mut sides = Vec::new();
    for (name, sign) in SIDES {
        sides.push(points(name, of_side(sign), place)?);
    }
    let Some(known) = sides.iter().find(|points| !points.is_empty()) else {
        return Err(Refused("velocity has no rows: a curve of friction needs two velocities".to_owned()));
    };
    let mut settings = vec![("friction.table.sigma2".to_owned(), 0.0)];
    for ((name, _), own) in SIDES.iter().zip(&sides) {
        let own = if own.is_empty() { known } else { own };
        settings.push((format!("friction.table.{name}.points"), own.len() as f64));
        for (place, (speed, force)) in own.iter().enumerate() {
            settings.push((format!("friction.table.{name}.speed[{}]", place + 1), *speed));
            settings.push((format!("friction.table.{name}.force[{}]", place + 1), *force));
        }
    }
    Ok(settings)
}

/// Points of rising speed of a direction; none for no rows.
fn points(name: &str, mut rows: Vec<Row>, place: &dyn Fn(usize) -> String) -> Result<Vec<(f64, f64)>, Refused> {
    rows.sort_by(|one, other| one.1.total_cmp(&other.1));
    let groups: Vec<&[Row]> = rows.chunk_by(|one, other| one.1 == other.1).collect();
    match &groups[..] {
        [] => return Ok(Vec::new()),
        [only] => {
            let (begin, speed) = (place(only[0].0), significant(only[0].1, 6));
            return Err(Refused(format!(
                "{begin}the friction {name} has one velocity, {speed} m/s: a curve needs two"
            )));
        }
        _ if groups.len() > POINTS => return corners(name, &rows),
        _ => {}
    }
    let mean = |group: &&[Row]| (group[0].1, group.iter().map(|row| row.2).sum::<f64>() / group.len() as f64);
    let found: Vec<(f64, f64)> = groups.iter().map(mean).collect();
    if let Some(at) = found.iter().position(|(_, force)| *force < 0.0) {
        let [speed, force] = [found[at].0, found[at].1].map(|value| significant(value, 6));
        let begin = place(groups[at][0].0);
        return Err(Refused(format!(
            "{begin}the friction {name}, {force} N at {speed} m/s, drives: it must have the sign of the velocity"
        )));
    }
    Ok(found)
}

/// Corners of the line that is nearest to many rows of rising speed.
fn corners(name: &str, rows: &[Row]) -> Result<Vec<(f64, f64)>, Refused> {
    let [first, last] = [rows[0].1, rows[rows.len() - 1].1];
    let [low, high] = [first, last].map(libm::sqrt);
    let mut speeds: Vec<f64> = (0..POINTS)
        .map(|corner| {
            let root = low + (high - low) * corner as f64 / (POINTS - 1) as f64;
            root * root
        })
        .collect();
    (speeds[0], speeds[POINTS - 1]) = (first, last);
    let measured: Vec<f64> = rows.iter().map(|row| row.1).collect();
    // A corner without data beside it is none.
    let is_told = |hat: &Vec<f64>| hat.iter().any(|share| *share > 0.0);
    let told: Vec<f64> =
        speeds.iter().zip(hats(&speeds, &measured)).filter(|(_, hat)| is_told(hat)).map(|it| *it.0).collect();
    let hats = hats(&told, &measured);
    let count = told.len();
    let row = |at: usize| hats.iter().map(move |hat| hat[at]).chain([rows[at].2]);
    let reduced = triangle(&from_rows(rows.len(), count + 1, (0..rows.len()).flat_map(row)));
    let inverse = pseudo_inverse(&reduced.view((0, 0), (count, count)).into_owned(), NO_RANK);
    let forces = inverse * reduced.view((0, count), (count, 1));
    if forces.iter().any(|force| *force < 0.0) {
        return Err(Refused(format!(
            "the friction {name} scatters so much that its curve falls below 0: average it before"
        )));
    }
    Ok(told.into_iter().zip(forces.iter().copied()).collect())
}

/// For each corner the share that it has in a line with corners, at speeds that rise.
fn hats(corners: &[f64], speeds: &[f64]) -> Vec<Vec<f64>> {
    let hat = |own: usize| {
        let unit: Vec<f64> = (0..corners.len()).map(|corner| f64::from(u8::from(corner == own))).collect();
        interpolate(speeds.iter().copied(), corners, &unit)
    };
    (0..corners.len()).map(hat).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(velocity: &[f64], force: &[f64]) -> Result<Vec<(String, f64)>, Refused> {
        settings(velocity, force, &|row| format!("f.csv:{}: ", row + 2))
    }

    fn value(settings: &[(String, f64)], name: &str) -> f64 {
        settings.iter().find(|(known, _)| *known == format!("friction.table.{name}")).expect("a setting").1
    }

    /// In any order, with either sign, and the mean of several rows at one velocity.
    #[test]
    fn few_velocities_are_the_points() {
        let found = of(&[0.2, -0.1, 0.0, -0.3, 0.05, 0.2], &[11.0, -8.0, 10.0, -9.0, 7.0, 13.0]).expect("settings");
        assert_eq!((value(&found, "outwards.points"), value(&found, "inwards.points")), (3.0, 2.0));
        for (name, expected) in [("outwards.speed[1]", 0.0), ("outwards.force[3]", 12.0), ("inwards.force[2]", 9.0)] {
            assert_eq!(value(&found, name), expected, "{name}");
        }
        let unsigned = of(&[-0.1, 0.0, 0.1], &[5.0, 6.0, 4.0]).expect("settings");
        assert_eq!((value(&unsigned, "outwards.force[1]"), value(&unsigned, "inwards.force[1]")), (6.0, 6.0));
        let one = of(&[0.0, 0.1], &[6.0, 4.0]).expect("settings");
        assert_eq!(value(&one, "inwards.force[2]"), 4.0, "of the direction that is known");
    }

    /// A line with the corners themselves comes back.
    #[test]
    fn many_velocities_are_fitted() {
        let speeds: Vec<f64> = (0..=1000).map(|row| row as f64 * 1e-4).collect();
        let corner = |place: usize| 0.1 * (place * place) as f64 / 100.0;
        let (at, level): (Vec<f64>, Vec<f64>) = (0..POINTS).map(|it| (corner(it), 5.0 + libm::sin(it as f64))).unzip();
        let forces = interpolate(speeds.iter().copied(), &at, &level);
        let found = of(&speeds, &forces).expect("settings");
        for (place, expected) in level.iter().enumerate() {
            let force = value(&found, &format!("outwards.force[{}]", place + 1));
            assert!((force - expected).abs() < 1e-9, "{force} N at corner {place}, not {expected}");
        }
    }

    #[test]
    fn refusals_name_the_row() {
        let told = |velocity: &[f64], force: &[f64]| of(velocity, force).expect_err("a refusal").0;
        assert_eq!(told(&[], &[]), "velocity has no rows: a curve of friction needs two velocities");
        assert!(told(&[0.1, 0.1], &[1.0, 2.0]).starts_with("f.csv:2: the friction outwards has one velocity, 0.1 m/s"));
        let driving = told(&[-0.1, -0.2, 0.1, 0.2], &[-3.0, 2.5, 3.0, 3.0]);
        assert!(driving.starts_with("f.csv:3: the friction inwards, -2.5 N at 0.2 m/s, drives"), "{driving}");
    }

    #[test]
    fn columns_are_found_by_their_names() {
        assert_eq!(columns("f.csv", &["t", "Friction_force", "v"]).expect("columns"), [2, 1]);
        let missing = columns("f.csv", &["t", "F"]).expect_err("a refusal").0;
        assert!(missing.starts_with("f.csv has the columns t, F: one of them must be velocity"), "{missing}");
        let several = columns("f.csv", &["v", "F", "friction"]).expect_err("a refusal").0;
        assert!(several.starts_with("f.csv has 2 columns of force, F, friction"), "{several}");
    }
}
