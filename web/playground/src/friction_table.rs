//! Measured friction from a table of the visitor, as parameters of the law `Table`.

use pneumatic_servo_fit::friction_table::{columns, settings};
use serde_json::{Value, json};

/// The places of velocity and force among columns. The text is the names of the table and of the columns, each ended by 0.
///
/// # Errors
/// In words for the visitor, for a quantity without a column of its own.
pub fn friction_columns(texts: &str) -> Result<Value, String> {
    let mut texts = texts.split_terminator('\0');
    let table = texts.next().unwrap_or_default();
    columns(table, &texts.collect::<Vec<_>>()).map(|places| json!(places)).map_err(|refused| refused.0)
}

/// Parameters by name, for a table of a name. The samples are the velocities in m/s, the forces in N and the lines of the rows, one
/// after the other.
///
/// # Errors
/// In words for the visitor, with the line, for rows that are no friction over velocity.
pub fn friction_table(table: &str, samples: &[f64]) -> Result<Value, String> {
    let rows = samples.len() / 3;
    let [velocity, force, lines] = [0, 1, 2].map(|column| &samples[column * rows..(column + 1) * rows]);
    let settings =
        settings(velocity, force, &|row| format!("{table}:{}: ", lines[row])).map_err(|refused| refused.0)?;
    Ok(settings.into_iter().map(|(name, value)| (name, json!(value))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_and_rows_become_parameters_or_a_refusal() {
        assert_eq!(friction_columns("f.csv\0t\0F\0v\0").expect("columns"), json!([2, 1]));
        assert!(friction_columns("f.csv\0t\0").expect_err("a refusal").contains("f.csv has the columns t:"));
        let found = friction_table("f.csv", &[0.0, 0.1, 5.0, 4.0, 2.0, 3.0]).expect("parameters");
        assert_eq!(found["friction.table.inwards.speed[2]"], 0.1);
        let refusal = friction_table("f.csv", &[0.0, 0.1, 5.0, -4.0, 2.0, 7.0]).expect_err("a refusal");
        assert!(refusal.starts_with("f.csv:7: the friction outwards, -4 N at 0.1 m/s, drives"), "{refusal}");
    }
}
