//! Tables of the visitor.

use pneumatic_servo_fit::machine_units::si_of;
use pneumatic_servo_fit::record::unit_of;
use pneumatic_servo_fit::signals::{ABOVE_AMBIENT, Chosen, proposed};
use pneumatic_servo_fit::tables::{Table, read};
use pneumatic_servo_fit::units::{to_si, written_unit};
use serde_json::{Value, json};

/// Reads the table of a file; returns what stands in it beside its numbers, and these: its columns one after the other, and the line
/// of each row.
///
/// # Errors
/// In words for the visitor, with file, line, column and remedy.
pub fn read_table(file: &str, data: &[u8]) -> Result<(Value, Vec<f64>), String> {
    let table = read(file, data).map_err(|refused| refused.0)?;
    let about = json!({
        "header": table.header,
        "names": table.names,
        "units": table.units,
        "rows": table.lines.len(),
        "first": table.first,
        "faults": table.faults.iter().collect::<Vec<_>>(),
        "clocks": table.clocks.iter().collect::<Vec<_>>(),
        "gaps": table.gaps,
    });
    let lines = table.lines.iter().map(|line| *line as f64);
    Ok((about, table.columns.into_iter().flatten().chain(lines).collect()))
}

/// The signals of a question that its names of columns tell: signal, place and unit of each.
///
/// # Errors
/// In words for the visitor, for a question that is none.
pub fn proposed_columns(question: &str) -> Result<Value, String> {
    let question = serde_json::from_str(question).map_err(|error| format!("the question is no JSON: {error}"))?;
    let asked =
        |question: &Value| Some((texts(&question["names"])?, units(&question["units"])?, texts(&question["signals"])?));
    let (names, units, signals) = asked(&question).ok_or("the question is incomplete")?;
    let signals: Vec<&str> = signals.iter().map(String::as_str).collect();
    let found = proposed(&names, &units, &signals);
    Ok(found.into_iter().map(|one| json!([one.signal, one.place, one.unit])).collect())
}

/// Chosen columns of a table in SI units on one clock, one after the other, and beside them those that were read at other times. The
/// samples are the columns and the lines of the rows, as [`read_table`] gives them.
///
/// # Errors
/// In words for the visitor, for a column that is no numbers, or a unit that is none of its signal.
pub fn table_signals(question: &str, samples: &[f64]) -> Result<(Value, Vec<f64>), String> {
    let question = serde_json::from_str(question).map_err(|error| format!("the question is no JSON: {error}"))?;
    let (file, table, chosen) = asked(&question, samples).ok_or("the question is incomplete, or its samples are")?;
    let found = table.signals(&file, &chosen).map_err(|refused| refused.0)?;
    let about = json!({ "rows": found.samples.first().map_or(0, Vec::len), "others": found.others });
    Ok((about, found.samples.concat()))
}

/// SI unit, and factor and offset to it, of a unit or a calibration by two points, and its name as the table of units spells it.
///
/// # Errors
/// In words for the visitor, for a unit that is none of the signal.
pub fn scale(signal: &str, unit: &str) -> Result<Value, String> {
    let si = si_of(signal, unit)?;
    let (factor, offset) = to_si(unit, si, signal == ABOVE_AMBIENT)?;
    let name = written_unit(unit).map_or(unit, |known| known.name);
    Ok(json!({ "name": name, "si": si, "factor": factor, "offset": offset }))
}

fn text(value: &Value) -> Option<String> {
    value.as_str().map(str::to_owned)
}

fn texts(value: &Value) -> Option<Vec<String>> {
    value.as_array()?.iter().map(text).collect()
}

fn units(value: &Value) -> Option<Vec<Option<String>>> {
    value.as_array()?.iter().map(|unit| if unit.is_null() { Some(None) } else { text(unit).map(Some) }).collect()
}

fn place(value: &Value) -> Option<usize> {
    usize::try_from(value.as_u64()?).ok()
}

/// File, table and chosen columns of a question.
pub(crate) fn asked(question: &Value, samples: &[f64]) -> Option<(String, Table, Vec<Chosen>)> {
    let names = texts(&question["names"])?;
    let (rows, width) = (place(&question["rows"])?, names.len());
    if rows == 0 || rows.checked_mul(width + 1)? != samples.len() {
        return None;
    }
    let mut columns: Vec<Vec<f64>> = samples.chunks_exact(rows).map(<[f64]>::to_vec).collect();
    let lines = columns.pop()?.into_iter().map(|line| line as i64).collect();
    let is_there = |place: &usize| *place < width;
    let faults = question["faults"].as_array()?.iter().map(|pair| Some((place(&pair[0])?, text(&pair[1])?)));
    let clocks =
        question["clocks"].as_array()?.iter().map(|pair| Some((place(&pair[0])?, place(&pair[1]).filter(is_there)?)));
    let of = |one: &Value| {
        let signal = text(&one["signal"])?;
        let unit = text(&one["unit"])?;
        let si = si_of(&signal, &unit).unwrap_or_else(|_| unit_of(&signal)).to_owned();
        let place = place(&one["place"]).filter(is_there)?;
        Some(Chosen { signal, place, unit, si, is_turned: one["turned"].as_bool()? })
    };
    let chosen = question["chosen"].as_array()?.iter().map(of).collect::<Option<_>>()?;
    let table = Table {
        header: names.clone(),
        names,
        units: units(&question["units"]).filter(|units| units.len() == width)?,
        columns,
        lines,
        first: place(&question["first"])?,
        faults: faults.collect::<Option<_>>()?,
        clocks: clocks.collect::<Option<_>>()?,
        gaps: question["gaps"].as_array()?.iter().map(place).collect::<Option<_>>()?,
    };
    Some((text(&question["file"])?, table, chosen))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_of_a_signal_may_be_a_calibration() {
        let of = |signal: &str, unit: &str| {
            scale(signal, unit).map(|scale| [&scale["factor"], &scale["offset"]].map(|it| it.as_f64()))
        };
        assert_eq!(of("position", "0..10 V = 0..500 mm"), Ok([Some(0.05), Some(0.0)]));
        // That of a bench counts above ambient.
        assert_eq!(of("pressure", "barg"), Ok([Some(1e5), Some(0.0)]));
        assert_eq!(of("pressure", "bara"), Ok([Some(1e5), Some(-101_325.0)]));
        assert_eq!(of("chamberA.pressure", "barg"), Ok([Some(1e5), Some(101_325.0)]));
        assert!(of("position", "V").expect_err("a refusal").contains("calibration"));
        let angle = scale("position", "\u{b0}").expect("a unit");
        assert_eq!([&angle["name"], &angle["si"]], ["deg", "rad"]);
    }

    #[test]
    fn columns_stand_behind_one_another_and_faults_beside_them() {
        let (about, numbers) = read_table("a.csv", b"t [ms],x,on\n0,5,true\n\n1,6,low\n").expect("a table");
        assert_eq!(
            (&about["names"], &about["units"], &about["rows"]),
            (&json!(["t", "x", "on"]), &json!(["ms", null, null]), &json!(2))
        );
        assert_eq!(numbers[..4], [0.0, 1.0, 5.0, 6.0]);
        assert_eq!(numbers[6..], [2.0, 4.0]);
        assert_eq!(about["faults"][0], json!([2, "a.csv:2, column 3 (on): 'true' is no number"]));
        let question = json!({
            "file": "a.csv", "names": ["t", "x", "on"], "units": ["ms", null, null], "rows": 2, "first": 1, "clocks": [], "gaps": [],
            "faults": [[2, "a.csv:2, column 3 (on): 'true' is no number"]],
            "chosen": [
                { "signal": "time", "place": 0, "unit": "ms", "turned": false },
                { "signal": "position", "place": 1, "unit": "mm", "turned": true },
            ],
        });
        let (about, samples) = table_signals(&question.to_string(), &numbers).expect("signals");
        assert_eq!((about, samples), (json!({ "rows": 2, "others": [] }), vec![0.0, 0.001, -0.005, -0.006]));
        let wrong = question.to_string().replace("\"place\":1", "\"place\":2");
        assert!(table_signals(&wrong, &numbers).expect_err("a refusal").contains("'true' is no number"));
        let incomplete = "the question is incomplete, or its samples are";
        assert_eq!(table_signals(&question.to_string(), &numbers[1..]).expect_err("a refusal"), incomplete);
        assert_eq!(table_signals("{}", &numbers).expect_err("a refusal"), incomplete);
        assert!(read_table("a.csv", b"").expect_err("a refusal").starts_with("a.csv: it is empty"));
    }
}
