//! Texts that a plain table is none of: LabVIEW .lvm, TwinCAT Scope, Tektronix, tables of Modelica.
//!
//! Their channels may have clocks of their own.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use crate::Refused;
use crate::tables::Table;
use crate::tables::cells::split;
use crate::tables::rows::finite;
use crate::units::of_word;

const END: &str = "***End_of_Header***";
const EXPORT: &str = "Starttime of export";

/// Cells of lines with their numbers.
type Rows<'a> = Vec<(usize, Vec<Cow<'a, str>>)>;

/// Reads the channels of a text, if it is one of these.
pub fn read(file: &str, lines: &[&str]) -> Option<Result<Table, Refused>> {
    let first = lines.first().map_or("", |line| line.trim());
    let beginning = cells(first, ',');
    let is_number = |at: usize| beginning.get(at).is_some_and(|cell| cell.parse::<f64>().is_ok());
    if first.starts_with("LabVIEW Measurement") {
        Some(labview(file, lines))
    } else if lines.iter().take(8).any(|line| line.starts_with(EXPORT)) {
        Some(twincat(file, lines))
    } else if first == "#1" {
        Some(combi_table(file, lines))
    } else if first.starts_with("Record Length") && is_number(3) && is_number(4) {
        Some(tektronix(file, lines))
    } else {
        None
    }
}

fn cells(line: &str, separator: char) -> Vec<Cow<'_, str>> {
    let mut found = Vec::new();
    split(line, separator, &mut found);
    found
}

/// The lines from one on as cells, without the empty ones.
fn rows<'a>(lines: &[&'a str], from: usize, separator: char) -> Rows<'a> {
    let every = lines.iter().enumerate().skip(from).map(|(at, line)| (at + 1, cells(line, separator)));
    every.filter(|(_, cells)| cells.iter().any(|cell| !cell.is_empty())).collect()
}

/// Columns of a recorder, each with its clock.
#[derive(Default)]
struct Channels {
    header: Vec<String>,
    names: Vec<String>,
    units: Vec<Option<String>>,
    columns: Vec<Vec<f64>>,
    clocks: BTreeMap<usize, usize>,
    clocks_there: Vec<usize>,
}

impl Channels {
    /// The place of a clock: of one that is there with the same times, or of a new one, `time` the first.
    fn clock(&mut self, times: Vec<f64>, unit: &str, header: &str) -> usize {
        let is_same = |place: &&usize| self.units[**place].as_deref() == Some(unit) && self.columns[**place] == times;
        if let Some(place) = self.clocks_there.iter().find(is_same) {
            return *place;
        }
        let behind = match self.clocks_there.len() {
            0 => String::new(),
            number => format!(" {}", number + 1),
        };
        let place = self.add(format!("{header}{behind}"), format!("time{behind}"), Some(unit.to_owned()), times);
        self.clocks_there.push(place);
        place
    }

    fn channel(&mut self, header: &str, name: &str, unit: Option<String>, values: Vec<f64>, clock: usize) {
        let place = self.add(header.to_owned(), name.to_owned(), unit, values);
        if clock != 0 {
            self.clocks.insert(place, clock);
        }
    }

    fn add(&mut self, header: String, name: String, unit: Option<String>, values: Vec<f64>) -> usize {
        self.header.push(header);
        self.names.push(name);
        self.units.push(unit);
        self.columns.push(values);
        self.columns.len() - 1
    }

    fn table(mut self, file: &str) -> Result<Table, Refused> {
        let rows = self.columns.iter().map(Vec::len).max().unwrap_or_default();
        if rows == 0 {
            return Err(Refused(format!("{file}: there are no channels of numbers in it")));
        }
        for column in &mut self.columns {
            column.resize(rows, f64::NAN);
        }
        Ok(Table {
            header: self.header,
            names: self.names,
            units: self.units,
            columns: self.columns,
            lines: (0..rows as i64).collect(),
            first: 0,
            faults: BTreeMap::new(),
            clocks: self.clocks,
            gaps: BTreeSet::new(),
        })
    }
}

/// A number at a place.
fn number(cell: &str, has_comma: bool, place: impl Fn() -> String) -> Result<f64, Refused> {
    finite(cell, has_comma).map_err(|problem| Refused(format!("{}: {problem}", place())))
}

/// Values of columns, of a channel and of its clock, from the rows in which the first column has a value.
fn columns<const N: usize>(
    file: &str,
    rows: &Rows<'_>,
    places: [usize; N],
    name: &str,
    has_comma: bool,
) -> Result<[Vec<f64>; N], Refused> {
    let mut found = [const { Vec::new() }; N];
    for (line, cells) in rows {
        if cells.get(places[0]).is_none_or(|cell| cell.is_empty()) {
            continue;
        }
        for (values, at) in found.iter_mut().zip(places) {
            let cell = cells.get(at).map_or("", |cell| cell);
            values.push(number(cell, has_comma, || format!("{file}:{line}, column {} ({name})", at + 1))?);
        }
    }
    Ok(found)
}

/// Numbers of a column without its empty cells.
fn numbers(file: &str, rows: &Rows<'_>, at: usize, name: &str, has_comma: bool) -> Result<Vec<f64>, Refused> {
    columns(file, rows, [at], name, has_comma).map(|[values]| values)
}

/// A unit that a recorder writes.
fn unit(text: &str) -> Option<String> {
    let text = text.trim();
    (!text.is_empty()).then(|| of_word(text).unwrap_or(text).to_owned())
}

/// What a segment of LabVIEW says about its channels, and its rows.
type Segment<'a> = (BTreeMap<String, Vec<Cow<'a, str>>>, Rows<'a>);

/// LabVIEW's text: a header, and segments with a header each; times are columns, or a start and a step.
fn labview(file: &str, lines: &[&str]) -> Result<Table, Refused> {
    let is_comma = |line: &&str| line.starts_with("Separator") && line.contains("Comma");
    let separator = if lines.iter().take(20).any(is_comma) { ',' } else { '\t' };
    let Some(end) = lines.iter().position(|line| line.starts_with(END)) else {
        return Err(Refused(format!("{file}: there is no {END}, with which the header of LabVIEW ends")));
    };
    let told: Rows<'_> = rows(&lines[..end], 0, separator);
    let told = |key: &str| {
        let row = told.iter().find(|(_, cells)| cells[0] == key);
        row.and_then(|(_, cells)| cells.get(1)).map_or("", |cell| cell)
    };
    let has_comma = told("Decimal_Separator") == "," && separator != ',';
    let kind = told("X_Columns");
    let mut header: Vec<Cow<'_, str>> = Vec::new();
    let mut segments: Vec<Segment<'_>> = Vec::new();
    let mut about = BTreeMap::new();
    let mut is_head = true;
    for (number, cells) in rows(lines, end + 1, separator) {
        if cells[0] == "Channels" {
            (about, is_head) = (BTreeMap::new(), true);
        }
        if cells[0].starts_with(END) {
            is_head = false;
        } else if cells[0] == "X_Value" {
            is_head = false;
            segments.push((std::mem::take(&mut about), Vec::new()));
            if header.is_empty() {
                header = cells;
            }
        } else if is_head {
            about.insert(cells[0].to_string(), cells[1..].to_vec());
        } else if let Some((_, rows)) = segments.last_mut() {
            rows.push((number, cells));
        }
    }
    if header.is_empty() {
        return Err(Refused(format!("{file}: there is no line with X_Value, below which LabVIEW writes the numbers")));
    }
    let last = header.len() - usize::from(header.last().is_some_and(|name| name == "Comment"));
    let step = if kind == "Multi" { 2 } else { 1 };
    let mut found = Channels::default();
    for (channel, at) in (1..last).step_by(step).enumerate() {
        let name = &header[at];
        let (mut times, mut values) = (Vec::new(), Vec::new());
        for (about, rows) in &segments {
            let clock = if kind == "Multi" { at - 1 } else { 0 };
            if kind != "No" {
                let [own, at] = columns(file, rows, [at, clock], name, has_comma)?;
                values.extend(own);
                times.extend(at);
                continue;
            }
            let said = |key: &str, usual: f64| match about.get(key).and_then(|cells| cells.get(channel)) {
                Some(cell) => number(cell, true, || format!("{file}, {key}")),
                None => Ok(usual),
            };
            let (start, by) = (said("X0", 0.0)?, said("Delta_X", f64::NAN)?);
            if by.is_nan() || by <= 0.0 {
                let told = if by.is_nan() { "not there".to_owned() } else { by.to_string() };
                return Err(Refused(format!(
                    "{file}: X_Columns is No, and Delta_X of {name} is {told}: there is no time; save the file with X columns"
                )));
            }
            let own = numbers(file, rows, at, name, has_comma)?;
            times.extend((0..own.len()).map(|row| start + by * row as f64));
            values.extend(own);
        }
        let label = segments.first().and_then(|(about, _)| about.get("Y_Unit_Label")?.get(channel));
        let clock = found.clock(times, "s", "X_Value");
        found.channel(name, name, label.and_then(|label| unit(label)), values, clock);
    }
    found.table(file)
}

/// An export of TwinCAT Scope: above the numbers rows of properties, whose names stand above clocks in ms.
fn twincat(file: &str, lines: &[&str]) -> Result<Table, Refused> {
    let behind = lines.iter().find_map(|line| line.strip_prefix(EXPORT)).unwrap_or_default();
    let separator = behind.chars().next().unwrap_or('\t');
    let told = |key: &str| {
        lines.iter().rev().find(|line| line.strip_prefix(key).is_some_and(|rest| rest.starts_with(separator)))
    };
    let end = lines.iter().skip(8).position(|line| line.starts_with("Unit Offset")).map(|at| at + 8);
    let names = lines.iter().filter(|line| line.starts_with("Name")).count();
    let (Some(end), Some(header), true) = (end, told("Name"), names > 1) else {
        return Err(Refused(format!("{file}: it is an export of TwinCAT Scope without its rows Name and Unit Offset")));
    };
    let units = told("Unit").map(|line| cells(line, separator)).unwrap_or_default();
    let mut body = rows(lines, end + 1, separator);
    body.retain(|(_, cells)| cells[0] != "EOF");
    let has_comma =
        separator != ',' && body.iter().take(1000).any(|(_, cells)| cells.iter().any(|cell| cell.contains(',')));
    let mut found = Channels::default();
    let (mut clock, mut times) = (0, Vec::new());
    for (at, name) in cells(header, separator).iter().enumerate() {
        if name == "Name" {
            times = numbers(file, &body, at, "time", has_comma)?;
            clock = found.clock(times.clone(), "ms", "time");
            continue;
        }
        let values = numbers(file, &body, at, name, has_comma)?;
        if values.len() != times.len() {
            return Err(Refused(format!(
                "{file}, column {} ({name}): {} values at {} times",
                at + 1,
                values.len(),
                times.len()
            )));
        }
        let unit =
            units.get(at).and_then(|unit| unit.split(' ').next()).filter(|unit| !["", "(None)", "None"].contains(unit));
        found.channel(name, name, unit.map(str::to_owned), values, clock);
    }
    found.table(file)
}

/// Tektronix' text, whose preamble stands in the first columns beside times and voltages.
fn tektronix(file: &str, lines: &[&str]) -> Result<Table, Refused> {
    let body = rows(lines, 0, ',');
    let told = |key: &str| {
        let row = body.iter().rev().find(|(_, cells)| cells[0] == key);
        row.and_then(|(_, cells)| cells.get(1)).map_or("", |cell| cell)
    };
    let mut found = Channels::default();
    let times = numbers(file, &body, 3, "time", false)?;
    let name = if told("Source").is_empty() { "CH1" } else { told("Source") };
    let values = numbers(file, &body, 4, name, false)?;
    let over = unit(told("Horizontal Units")).unwrap_or_else(|| "s".to_owned());
    let clock = found.clock(times, &over, "time");
    found.channel(name, name, unit(told("Vertical Units")), values, clock);
    found.table(file)
}

/// A table of Modelica: columns have numbers, the first is the time; names may stand behind the head.
fn combi_table(file: &str, lines: &[&str]) -> Result<Table, Refused> {
    let heads: Vec<_> = lines.iter().enumerate().filter_map(|(at, line)| Some((at, matrix(line)?))).collect();
    let [(at, (name, [count, width], about))] = heads[..] else {
        let named: Vec<&str> = heads.iter().map(|(_, (name, ..))| *name).collect();
        return Err(Refused(if named.is_empty() {
            format!("{file}: below #1 there is no head of a table, such as `double table(100,3)`")
        } else {
            format!("{file}: there are {} tables in it, {}; leave the one that is meant", named.len(), named.join(", "))
        }));
    };
    // A row may go on in the next line.
    let is_between = |letter: char| letter.is_whitespace() || letter == ',' || letter == ';';
    let cells: Vec<(usize, &str)> = (lines.iter().enumerate().skip(at + 1))
        .flat_map(|(at, line)| {
            let line = line.split('#').next().unwrap_or_default();
            line.split(is_between).filter(|cell| !cell.is_empty()).map(move |cell| (at + 1, cell))
        })
        .collect();
    if Some(cells.len()) != count.checked_mul(width) {
        return Err(Refused(format!(
            "{file}:{}: {name} is to have {count} x {width} numbers, but has {}",
            at + 1,
            cells.len()
        )));
    }
    let names: Vec<&str> = about.split(',').map(str::trim).collect();
    let is_named = names.len() == width && names.iter().all(|name| !name.is_empty());
    let mut found = Channels::default();
    for place in 0..width {
        let header = (place + 1).to_string();
        let name = match place {
            0 => "time",
            place if is_named => names[place],
            _ => header.as_str(),
        };
        let column = cells[place..]
            .iter()
            .step_by(width)
            .map(|(line, cell)| number(cell, false, || format!("{file}:{line}, column {} ({name})", place + 1)));
        let column = column.collect::<Result<Vec<f64>, Refused>>()?;
        if place == 0 {
            found.clock(column, "s", &header);
        } else {
            found.channel(&header, name, None, column, 0);
        }
    }
    found.table(file)
}

/// Name, rows and columns of the head of a table of Modelica, and what is said about it.
fn matrix(line: &str) -> Option<(&str, [usize; 2], &str)> {
    let (head, about) = line.split_once('#').unwrap_or((line, ""));
    let head = head.trim();
    let rest = head.strip_prefix("double").or_else(|| head.strip_prefix("float"))?;
    let (name, size) = rest.strip_prefix(char::is_whitespace)?.strip_suffix(')')?.split_once('(')?;
    let (rows, columns) = size.split_once(',')?;
    let is_word = |letter: char| letter.is_alphanumeric() || letter == '_';
    let name = name.trim();
    let size = [rows.trim().parse().ok()?, columns.trim().parse().ok()?];
    (!name.is_empty() && name.chars().all(is_word)).then_some((name, size, about.trim()))
}
