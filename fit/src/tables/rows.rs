//! Numbers below the names of a table.

use std::borrow::Cow;

use crate::Refused;
use crate::tables::cells::{SEPARATORS, is_decimal, may_have_thousands, split, trim};
use crate::tables::clock::{is_clock, seconds_since_first};

/// Most characters that are shown of a cell.
const SHOWN: usize = 60;

/// A column as it is read.
#[derive(Default)]
pub struct Column {
    /// Its numbers; NaN where there is none, and everywhere in a column with a fault that is not slow.
    pub values: Vec<f64>,
    /// What is wrong with it.
    pub fault: Option<String>,
    /// Whether empty cells are all that is wrong with it.
    pub is_slow: bool,
    /// Whether it has times of the clock.
    pub is_clock: bool,
    /// Cells that are no numbers.
    wrong: usize,
    /// Cells that are empty, and cells that are true or false.
    empty: usize,
    logical: usize,
    marks: Marks,
}

/// What the numbers of a column tell of their decimal mark.
#[derive(Default)]
struct Marks {
    /// Whether a mark of one of them can be no separator of thousands.
    are_decimal: bool,
    /// The first one whose mark may be one, and its place.
    grouped: Option<(String, String)>,
    /// The first one but 0 that has no mark, and too few digits for such a separator.
    bare: Option<String>,
}

impl Marks {
    fn see(&mut self, cell: &str, place: impl Fn() -> String) {
        match cell.find(['.', ',']) {
            Some(_) if self.are_decimal => (),
            Some(at) if may_have_thousands(cell, &cell[at..=at]) => {
                self.grouped.get_or_insert_with(|| (cell.to_owned(), place()));
            }
            Some(_) => self.are_decimal = true,
            None if self.bare.is_none() && is_short(cell) => self.bare = Some(cell.to_owned()),
            None => (),
        }
    }

    /// What is wrong where some numbers have a mark before each three digits, and others none, as with separators of thousands.
    fn fault(&self) -> Option<String> {
        let Self { are_decimal: false, grouped: Some((grouped, place)), bare: Some(bare) } = self else { return None };
        Some(format!("{place}: the mark of '{grouped}' may separate thousands, since '{bare}' has none; {REMEDY}"))
    }
}

/// Whether a number but 0 has at most three digits and nothing else.
fn is_short(cell: &str) -> bool {
    let digits = cell.trim_start_matches(['+', '-']);
    (1..=3).contains(&digits.len()) && digits.bytes().all(|byte| byte.is_ascii_digit()) && !digits.starts_with('0')
}

/// What to do about numbers whose marks may separate thousands.
const REMEDY: &str = "write numbers with one decimal mark, without separators of thousands";

/// Reads the rows of a table.
pub fn read(file: &str, body: &[(usize, &str)], separator: char, names: &[String]) -> Result<Vec<Column>, Refused> {
    let has_comma = has_decimal_commas(file, body, separator, names)?;
    let place = |line: usize, at: usize| place(file, line, at, names);
    let mut columns: Vec<Column> = names.iter().map(|_| Column::default()).collect();
    let mut clocks: Vec<Option<Vec<String>>> = vec![None; names.len()];
    let mut found = Vec::with_capacity(names.len());
    for (row, &(number, line)) in body.iter().enumerate() {
        if !split(line, separator, &mut found) {
            return Err(Refused(format!("{file}:{number}: a quote is not closed")));
        }
        if separator != ' ' {
            trim(&mut found, names.len());
        }
        if found.len() != names.len() {
            let hint = other_separator(line, separator);
            return Err(Refused(format!(
                "{file}:{number}: {} values, but the header has {} columns{hint}",
                found.len(),
                names.len()
            )));
        }
        for (at, cell) in found.iter().enumerate() {
            if row == 0 && is_clock(cell) {
                clocks[at] = Some(Vec::with_capacity(body.len()));
            }
            match &mut clocks[at] {
                Some(texts) => texts.push(cell.clone().into_owned()),
                None => columns[at].take(cell, has_comma, || place(number, at)),
            }
        }
    }
    for (at, column) in columns.iter_mut().enumerate() {
        match &clocks[at] {
            Some(texts) => column.take_clock(texts, |row| place(body[row].0, at)),
            None => column.finish(),
        }
    }
    Ok(columns)
}

fn place(file: &str, line: usize, at: usize, names: &[String]) -> String {
    format!("{file}:{line}, column {} ({})", at + 1, names.get(at).map_or("", String::as_str))
}

impl Column {
    fn take(&mut self, cell: &str, has_comma: bool, place: impl Fn() -> String) {
        let value = match finite(cell, has_comma) {
            Ok(value) => value,
            Err(problem) => {
                self.fault.get_or_insert_with(|| format!("{}: {problem}", place()));
                self.wrong += 1;
                self.empty += usize::from(cell.is_empty());
                let logical =
                    [("true", 1.0), ("false", 0.0)].into_iter().find(|(word, _)| cell.eq_ignore_ascii_case(word));
                self.logical += usize::from(logical.is_some());
                logical.map_or(f64::NAN, |(_, value)| value)
            }
        };
        self.values.push(value);
        self.marks.see(cell, place);
    }

    fn finish(&mut self) {
        if let Some(fault) = self.marks.fault() {
            self.fault = Some(fault);
            self.values.fill(f64::NAN);
            return;
        }
        self.is_slow = self.wrong > 0 && self.wrong == self.empty;
        // An input may be true or false.
        if self.wrong > 0 && !self.is_slow && self.logical < self.values.len() {
            self.values.fill(f64::NAN);
        }
    }

    fn take_clock(&mut self, texts: &[String], place: impl Fn(usize) -> String) {
        self.values = vec![f64::NAN; texts.len()];
        match seconds_since_first(texts.iter().map(String::as_str)) {
            Ok(Some(seconds)) => (self.values, self.is_clock) = (seconds, true),
            Ok(None) => {
                let row = texts.iter().position(|text| !is_clock(text)).unwrap_or_default();
                self.fault = Some(format!("{}: '{}' is no time, as '{}' above is", place(row), texts[row], texts[0]));
            }
            Err(problem) => self.fault = Some(format!("{}: {problem}", place(0))),
        }
    }
}

/// The number that a cell stands for, or what is wrong with it.
pub fn finite(cell: &str, has_comma: bool) -> Result<f64, String> {
    let text = if has_comma && cell.contains(',') { Cow::Owned(cell.replace(',', ".")) } else { Cow::Borrowed(cell) };
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("{} is not finite", cell.trim())),
        Err(_) => {
            let marks = [',', '.', '\'', ' ', '\u{a0}', '\u{202f}'];
            let is_grouped = cell.contains(marks) && cell.bytes().any(|byte| byte.is_ascii_digit());
            let only = |letter: char| letter.is_ascii_digit() || "+-".contains(letter) || marks.contains(&letter);
            let remedy = if is_grouped && cell.chars().all(only) { format!("; {REMEDY}") } else { String::new() };
            let shown: String = cell.chars().take(SHOWN).collect();
            let more = if shown.len() < cell.len() { "..." } else { "" };
            Err(format!("'{}{more}' is no number{remedy}", shown.escape_debug()))
        }
    }
}

fn other_separator(line: &str, separator: char) -> String {
    let own = SEPARATORS.iter().find(|(each, _)| *each == separator).map_or("", |(_, name)| name);
    let other = SEPARATORS.iter().find(|(each, _)| *each != separator && line.trim().contains(*each));
    other.map_or(String::new(), |(_, other)| format!("; the header is separated by {own}, but this line has {other}"))
}

/// Whether commas are decimal marks; a table in which commas or points may separate thousands is refused.
///
/// A number as 101,131 is one of thousands, or of decimals: other cells tell, or nothing does.
fn has_decimal_commas(file: &str, body: &[(usize, &str)], separator: char, names: &[String]) -> Result<bool, Refused> {
    // Between commas a decimal comma stands in quotes.
    let may_be_decimal = |line: &str| line.contains(',') && (separator != ',' || line.contains('"'));
    let first_of = |lines: &[(usize, &str)], is_meant: &dyn Fn(&str) -> bool| {
        lines.iter().find_map(|&(line, text)| {
            let mut cells = Vec::new();
            split(text, separator, &mut cells);
            let at = cells.iter().position(|cell| is_meant(cell))?;
            Some((line, at, cells[at].clone().into_owned()))
        })
    };
    let with_comma: Vec<_> = body.iter().copied().filter(|(_, line)| may_be_decimal(line)).collect();
    if first_of(&with_comma, &|cell| is_decimal(cell, b',')).is_none() {
        return Ok(false);
    }
    let with_point: Vec<_> = body.iter().copied().filter(|(_, line)| line.contains('.')).collect();
    let point = first_of(&with_point, &|cell| is_decimal(cell, b'.'));
    let grouped = first_of(&with_comma, &|cell| is_decimal(cell, b',') && may_have_thousands(cell, ","));
    let here = |line: usize, at: usize| place(file, line, at, names);
    let beside = |line: usize, at: usize| {
        format!("line {line}, column {} ({})", at + 1, names.get(at).map_or("", String::as_str))
    };
    if let (Some((line, at, point)), Some((other, column, comma))) = (&point, grouped) {
        return Err(Refused(format!(
            "{}: '{point}' has a decimal point, and '{comma}' ({}) a comma, which may separate thousands; {REMEDY}",
            here(*line, *at),
            beside(other, column)
        )));
    }
    let is_plain = |cell: &str, mark: &str| is_decimal(cell, mark.as_bytes()[0]) && !may_have_thousands(cell, mark);
    let Some((other, column, comma)) = first_of(&with_comma, &|cell| is_plain(cell, ",")) else {
        let (line, at, first) = first_of(&with_comma, &|cell| is_decimal(cell, b',')).expect("a comma");
        return Err(Refused(format!(
            "{}: the comma of '{first}' may be a decimal one or separate thousands, and no other number tells; write a \
             decimal point, or no separators of thousands",
            here(line, at)
        )));
    };
    match point {
        Some((line, at, point)) if first_of(&with_point, &|cell| is_plain(cell, ".")).is_none() => {
            Err(Refused(format!(
                "{}: the point of '{point}' may separate thousands, since '{comma}' ({}) has a decimal comma; {REMEDY}",
                here(line, at),
                beside(other, column)
            )))
        }
        _ => Ok(true),
    }
}
