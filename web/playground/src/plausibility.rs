//! Findings about the record of the visitor, before it is fitted.

use std::collections::BTreeMap;

use pneumatic_servo_fit::experiment::{Given, Kind, Options};
use pneumatic_servo_fit::machine_units::{MachineUnits, si_of};
use pneumatic_servo_fit::plausibility::{Facts, Finding, Remedy, Source, Written, check};
use pneumatic_servo_fit::record::Signals;
use serde_json::{Value, json};

use crate::fit::{known, law};
use crate::table::asked;

/// Findings about the chosen columns of a table under an experiment, each with its remedies. The question is that of
/// [`table_signals`](crate::table_signals), with experiment, law and known values; of columns that are none, which a fit refuses, there
/// are no findings.
///
/// # Errors
/// In words for the visitor, for a question that is none.
pub fn findings(question: &str, samples: &[f64]) -> Result<Value, String> {
    let question: Value =
        serde_json::from_str(question).map_err(|error| format!("the question is no JSON: {error}"))?;
    let incomplete = "the question is incomplete, or its samples are";
    let (file, table, chosen) = asked(&question, samples).ok_or(incomplete)?;
    let parts = || Some((question["experiment"].as_str()?, law(&question)?, known(&question)?));
    let (experiment, law, known) = parts().ok_or(incomplete)?;
    let kind = Kind::of_name(experiment).map_err(|refused| refused.0)?;
    let has_grid = chosen.iter().any(|column| column.signal == kind.required[0]);
    let found = table.signals(&file, &chosen);
    let (true, Ok(found)) = (has_grid, found) else { return Ok(json!([])) };
    let signals: Signals = chosen.iter().map(|column| column.signal.clone()).zip(found.samples).collect();
    let written = |place: usize, unit: &String| Written { name: table.names[place].clone(), unit: unit.clone() };
    let columns: BTreeMap<String, Written> =
        chosen.iter().map(|column| (column.signal.clone(), written(column.place, &column.unit))).collect();
    let stated: Vec<_> =
        chosen.iter().filter_map(|one| Some((&*one.signal, si_of(&one.signal, &one.unit).ok()?))).collect();
    // A mixture of units is told where the fit would start.
    let units = MachineUnits::of_columns(kind, &stated).unwrap_or_default();
    let given = Given::new(kind, law, known, signals.keys().cloned(), Options::default());
    let facts = Facts { given: &given, columns: &columns, units: &units.of_signals() };
    // Samples between the rows of other channels stand at no line.
    let is_by_row = signals.values().all(|values| values.len() == table.lines.len());
    let place = |signal: &str, row: usize| match chosen.iter().find(|column| column.signal == signal) {
        Some(column) if is_by_row => table.place(&file, column.place, row),
        _ => format!("{file}, sample {row} of {signal}"),
    };
    let found = check(&facts, &Source { name: &file, signals: &signals, place: &place });
    Ok(found.iter().map(|finding| written_finding(finding, is_by_row)).collect())
}

/// A finding; rows can be left out where each sample stands in a row of its own.
fn written_finding(finding: &Finding, is_by_row: bool) -> Value {
    let can_follow = |remedy: &&Remedy| is_by_row || !matches!(remedy, Remedy::Remove { .. });
    let remedy = |remedy: &Remedy| match remedy {
        Remedy::Unit { signal, unit } => json!({ "kind": "unit", "signal": signal, "unit": unit }),
        Remedy::Turn { signal } => json!({ "kind": "turn", "signal": signal }),
        Remedy::Swap { signals } => json!({ "kind": "swap", "signals": signals }),
        Remedy::Set { values } => json!({ "kind": "set", "values": values }),
        Remedy::Remove { signal, rows } => json!({ "kind": "remove", "signal": signal, "rows": rows }),
    };
    json!({
        "signal": finding.signal,
        "text": finding.text,
        "remedies": finding.remedies.iter().filter(can_follow).map(remedy).collect::<Vec<_>>(),
        "refused": finding.is_refused,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_name_columns_and_lines_and_have_remedies_as_data() {
        let rows = 100;
        let time = (0..rows).map(|row| 1e-3 * f64::from(row));
        let position = (0..rows).map(|row| if row == 50 { 9e9 } else { 100.0 + f64::from(row) });
        let samples: Vec<f64> = time.chain(position).chain((0..rows).map(|row| f64::from(row + 2))).collect();
        let question = json!({
            "file": "a.csv", "names": ["t", "x"], "units": [null, null], "rows": rows, "first": 1, "clocks": [], "gaps": [],
            "faults": [], "experiment": "rig", "law": 7, "known": {},
            "chosen": [
                { "signal": "time", "place": 0, "unit": "s", "turned": false },
                { "signal": "position", "place": 1, "unit": "m", "turned": false },
            ],
        });
        let found = findings(&question.to_string(), &samples).expect("findings");
        let text = found[0]["text"].as_str().expect("a text");
        assert!(text.contains("a.csv:52, column 2 (x) = 9e9 m"), "{text}");
        assert_eq!(found[0]["remedies"], json!([{ "kind": "remove", "signal": "position", "rows": [50] }]));
        assert_eq!(found[1]["remedies"], json!([{ "kind": "unit", "signal": "position", "unit": "mm" }]));
        assert_eq!((&found[1]["refused"], found[2].is_null()), (&json!(true), true));
        let text = found[1]["text"].as_str().expect("a text");
        assert!(text.starts_with("a.csv: position (column x in m) is from 100 to 199 m"), "{text}");

        let wrong = question.to_string().replace("\"law\":7", "\"law\":null");
        assert_eq!(findings(&wrong, &samples), Err("the question is incomplete, or its samples are".to_owned()));
        let falling: Vec<f64> = samples.iter().map(|value| -value).collect();
        assert_eq!(findings(&question.to_string(), &falling), Ok(json!([])));
    }
}
