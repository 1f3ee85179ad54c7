//! Tables in text files, as recorders, oscilloscopes, spreadsheets and programs write them: bytes become columns of numbers.
//!
//! Understood are commas, semicolons, tabs or blanks between the values, also behind the last one; decimal commas; UTF-8, UTF-16
//! with a byte order mark, and Windows-1252; all of them compressed by gzip; lines that are empty or begin with `#`, `%` or `//`, of
//! which the last may have the names; lines of a recorder above the names; units behind the names, as `x[mm]`, `x (mm)`, `x / mm` or
//! `x in mm`, or in a row of their own below them; times of the clock; columns without names, which have numbers, `1` the first;
//! empty cells of slow channels; and the files of recorders: LabVIEW .lvm, TwinCAT Scope, Tektronix, and tables of Modelica.

mod cells;
pub mod clock;
mod decoding;
mod header;
pub mod names;
mod recorders;
mod rows;

use std::collections::{BTreeMap, BTreeSet};

use crate::Refused;
use crate::tables::header::Header;

/// Most characters of a name.
const LONGEST_NAME: usize = 1000;

/// Columns of numbers with their names.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Names as they are written.
    pub header: Vec<String>,
    /// Names without units, by which columns are chosen.
    pub names: Vec<String>,
    /// Units as they are written, where some are.
    pub units: Vec<Option<String>>,
    /// The numbers as they are written; all columns have a value for each row.
    pub columns: Vec<Vec<f64>>,
    /// The line of each row.
    pub lines: Vec<i64>,
    /// The line of the header.
    pub first: usize,
    /// By the place of a column what is wrong with it: it is to be refused where somebody asks for it.
    pub faults: BTreeMap<usize, String>,
    /// By the place of a column the place of its own clock, where that is not the first one. Such columns are NaN behind their last
    /// sample.
    pub clocks: BTreeMap<usize, usize>,
    /// Columns with empty cells, which are NaN: channels that are slower than others. They have a fault as well.
    pub gaps: BTreeSet<usize>,
}

/// Lines with their numbers.
type Lines<'a> = Vec<(usize, &'a str)>;

/// Beginnings of comments.
const COMMENTS: [&str; 3] = ["#", "%", "//"];

/// Reads the table of a file.
///
/// # Errors
/// In words for the user, with file, line, column and remedy. A column that is no numbers is no error but a [fault](Table::faults).
pub fn read(file: &str, data: &[u8]) -> Result<Table, Refused> {
    let text = decoding::text(data).map_err(|fault| Refused(format!("{file}: {fault}")))?;
    let lines: Vec<&str> =
        text.split('\n').flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r')).collect();
    if let Some(found) = recorders::read(file, &lines) {
        return found;
    }
    let every: Lines<'_> = (1..).zip(lines.iter().copied()).filter(|(_, line)| !line.trim().is_empty()).collect();
    let is_comment = |line: &str| COMMENTS.iter().any(|mark| line.trim_start().starts_with(mark));
    let plain: Lines<'_> = every.iter().copied().filter(|(_, line)| !is_comment(line)).collect();
    if plain.is_empty() {
        return Err(Refused(format!(
            "{file}: it is empty; a table has a line with the names of its columns, and rows of numbers"
        )));
    }
    let Header { header, names, mut units, line: first, separator, body } = Header::find(file, &every, &plain)?;
    if body >= plain.len() {
        return Err(Refused(format!("{file}: there are no rows below the header")));
    }
    let lengths = header.iter().map(|name| name.chars().count());
    if let Some((at, length)) = (1..).zip(lengths).find(|(_, length)| *length > LONGEST_NAME) {
        return Err(Refused(format!(
            "{file}:{first}, column {at}: its name has {length} characters; is this a table?"
        )));
    }
    let found = rows::read(file, &plain[body..], separator, &names)?;
    for (unit, column) in units.iter_mut().zip(&found) {
        if column.is_clock {
            *unit = Some("s".to_owned());
        }
    }
    let faults = found.iter().enumerate().filter_map(|(at, column)| Some((at, column.fault.clone()?))).collect();
    let gaps = found.iter().enumerate().filter(|(_, column)| column.is_slow).map(|(at, _)| at).collect();
    Ok(Table {
        header,
        names,
        units,
        columns: found.into_iter().map(|column| column.values).collect(),
        lines: plain[body..].iter().map(|(line, _)| *line as i64).collect(),
        first,
        faults,
        clocks: BTreeMap::new(),
        gaps,
    })
}
