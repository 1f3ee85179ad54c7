//! Names and units above the numbers of a table.

use std::borrow::Cow;

use crate::Refused;
use crate::tables::cells::{SEPARATORS, cells, is_number, is_row, split, trim};
use crate::tables::clock::is_clock;
use crate::tables::names::{are_units, are_words, name_and_unit, unit};

/// Lines above the numbers of a table, at most.
const MOST_ABOVE: usize = 200;

/// What stands above the numbers.
pub struct Header {
    /// Names as they are written.
    pub header: Vec<String>,
    /// Names without units.
    pub names: Vec<String>,
    /// Units.
    pub units: Vec<Option<String>>,
    /// The line with the names.
    pub line: usize,
    /// Separator of the cells.
    pub separator: char,
    /// The place of the first row.
    pub body: usize,
}

impl Header {
    /// Finds the header of a table, of its lines without those that are empty, with comments and without.
    pub fn find(file: &str, every: &[(usize, &str)], plain: &[(usize, &str)]) -> Result<Self, Refused> {
        let texts: Vec<&str> = plain.iter().take(MOST_ABOVE).map(|(_, line)| *line).collect();
        let (place, separator) = place(&texts);
        let (line, text) = plain[place];
        let mut head = Vec::new();
        if !split(text, separator, &mut head) {
            return Err(Refused(format!("{file}:{line}: a quote is not closed")));
        }
        trim(&mut head, 1);
        let count = head.len();
        let below = |at: usize| plain.get(at).map(|(_, line)| cells(line, separator)).unwrap_or_default();
        let mut body = place + 1;
        let mut header: Vec<String> = head.into_iter().map(Cow::into_owned).collect();
        let mut first = line;
        if is_row(text, separator) && !are_units(&below(body), count) {
            body = place;
            // Without names columns have numbers.
            (first, header) = named_by_comment(every, line, count, separator)
                .unwrap_or_else(|| (line, (1..=count).map(|number| number.to_string()).collect()));
        }
        let named = header.iter().map(|text| name_and_unit(text));
        let (names, mut units): (Vec<_>, Vec<_>) =
            named.map(|(name, unit)| (name.to_owned(), unit.map(str::to_owned))).unzip();
        if are_words(&header) {
            units = header.iter().map(|word| unit(word)).collect();
        }
        let mut written = below(body);
        written.resize(written.len().max(count), Cow::Borrowed(""));
        if body < plain.len() && are_units(&written, count) {
            units = units.into_iter().zip(&written).map(|(own, cell)| own.or_else(|| unit(cell))).collect();
            // Descriptions may follow.
            let is_numbers = |after: &usize| plain.get(body + after).is_some_and(|(_, line)| is_row(line, separator));
            body += (1..4).find(is_numbers).unwrap_or(1);
        }
        // A controller writes them above the names.
        let above = place.checked_sub(1).filter(|_| body > place && units.iter().all(Option::is_none)).map(below);
        if let Some(mut above) = above {
            above.resize(above.len().max(count), Cow::Borrowed(""));
            if are_units(&above, count) {
                units = above.iter().map(|cell| unit(cell)).collect();
            }
        }
        Ok(Self { header, names, units, line: first, separator, body })
    }
}

/// The place of the line with the names, and the separator of its cells.
///
/// It is the first one, unless others stand above rows of numbers: then the last of as many cells as these have, of which none is a
/// number.
fn place(texts: &[&str]) -> (usize, char) {
    for (at, line) in texts.iter().enumerate() {
        for (separator, _) in SEPARATORS {
            if separator != ',' && !line.trim().contains(separator) {
                continue;
            }
            let below = texts.get(at + 1).unwrap_or(line);
            let count = cells(line, separator).len();
            if is_row(line, separator)
                && is_row(below, separator)
                && count == cells(below, separator).len()
                && let Some(named) = names_above(texts, at, separator, count)
            {
                return (named, separator);
            }
        }
    }
    let usual = SEPARATORS.iter().find(|(separator, _)| texts[0].trim().contains(*separator));
    (0, usual.map_or(',', |(separator, _)| *separator))
}

/// The place of the names above the first row of numbers.
fn names_above(texts: &[&str], first: usize, separator: char, count: usize) -> Option<usize> {
    let of = |at: usize| cells(texts[at], separator);
    if let Some(named) = above_units_and_texts(&of, first, count) {
        return Some(named);
    }
    for above in (0..first).rev() {
        let own = of(above);
        if above + 1 < first && are_units(&of(first - 1), count) {
            // Names above units may be numbers of channels; an oscilloscope may write nothing but units.
            let numbers = own.iter().filter(|cell| is_number(cell));
            let are_channels = numbers.into_iter().all(|cell| cell.bytes().all(|byte| byte.is_ascii_digit()));
            let is_named = above + 2 == first && own.len() == count && are_channels;
            return Some(if is_named { above } else { first - 1 });
        }
        let has_number = own.iter().any(|cell| is_number(cell) || is_clock(cell));
        if own.len() == count && !has_number && !are_units(&own, count) {
            return Some(above);
        }
    }
    None
}

/// The place of names above a row of units with one or two rows of descriptions below it, above the first row of numbers.
fn above_units_and_texts<'a>(of: &impl Fn(usize) -> Vec<Cow<'a, str>>, first: usize, count: usize) -> Option<usize> {
    (1..3).filter(|texts| texts + 2 <= first).find_map(|texts| {
        let (units, named) = (first - texts - 1, first - texts - 2);
        let are_texts = (units + 1..first).all(|at| !are_units(&of(at), count));
        let names = of(named);
        (are_texts && are_units(&of(units), count) && names.len() == count && !are_units(&names, count))
            .then_some(named)
    })
}

/// The last comment above the numbers, if it has as many cells: names, as NumPy writes them, which separates them in its own way.
fn named_by_comment(
    every: &[(usize, &str)],
    first: usize,
    count: usize,
    separator: char,
) -> Option<(usize, Vec<String>)> {
    let (number, line) = every.iter().rev().find(|(number, _)| *number < first)?;
    let text = line.trim().trim_start_matches(['#', '%', '/', ' ']);
    let separators = [',', ';', '\t', ' '].into_iter().filter(|other| *other != separator);
    let separators = std::iter::once(separator).filter(|own| *own != ' ').chain(separators).chain([separator]);
    let is_named = |separator: &char| cells(text, *separator).len() == count && !is_row(text, *separator);
    let separator = separators.into_iter().find(is_named)?;
    Some((*number, cells(text, separator).into_iter().map(Cow::into_owned).collect()))
}
