//! Names of columns, and the units behind or below them.

use std::borrow::Cow;

use crate::units::{nearest_unit, of_word, written_unit};

/// Cells that say that a column has no unit.
const NONE: [&str; 3] = ["", "-", "1"];

/// A text without brackets around it.
fn bare(text: &str) -> &str {
    text.trim().trim_matches(['[', ']', '(', ')']).trim()
}

/// A unit that is known, written as a word, or in square brackets: what stands there is one, known or not.
pub fn unit(text: &str) -> Option<String> {
    let text = text.trim();
    let bracketed = text.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).map(str::trim);
    let inner = bracketed.unwrap_or(text);
    let enclosed = inner.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).map_or(inner, str::trim);
    // Brackets belong to l/min(ANR).
    let is_known = |text: &&str| written_unit(text).is_some();
    let known = of_word(inner).or_else(|| [enclosed, bare(inner)].into_iter().find(is_known));
    known.or(bracketed.filter(|text| !NONE.contains(text))).map(str::to_owned)
}

/// Whether cells are units: at least one is known, and the others are units or empty.
///
/// What stands in square brackets is a unit; one that is not known is refused where somebody asks for its column.
pub fn are_units(cells: &[Cow<'_, str>], columns: usize) -> bool {
    let is_unit = |cell: &Cow<'_, str>| unit(cell).is_some() || unit(bare(cell)).is_some();
    let is_known = |cell: &Cow<'_, str>| unit(bare(cell)).is_some();
    cells.len() == columns
        && cells.iter().any(is_known)
        && cells.iter().all(|cell| is_unit(cell) || NONE.contains(&bare(cell)))
}

/// Whether cells are words for units and nothing else, as an oscilloscope writes them in place of names.
pub fn are_words(cells: &[String]) -> bool {
    cells.iter().all(|cell| of_word(cell).is_some())
}

/// The name in a header without the unit behind it, and the unit.
///
/// What stands in square brackets is a unit, and so is what is written otherwise and is like a known one: an unknown unit is refused
/// where somebody asks for its column.
pub fn name_and_unit(text: &str) -> (&str, Option<&str>) {
    // `friction.gms.alpha[1]` is an element, `reading [1]` has the unit 1.
    if is_element(text) {
        return (text, None);
    }
    let found = in_brackets(text).or_else(|| in_parentheses(text)).or_else(|| behind_a_word(text));
    match found {
        Some((name, unit, is_bracketed)) if !name.is_empty() && is_unit(unit, is_bracketed) => (name, Some(unit)),
        _ => (text, None),
    }
}

fn is_element(text: &str) -> bool {
    let parts = text.strip_suffix(']').and_then(|rest| rest.rsplit_once('['));
    parts.is_some_and(|(name, number)| {
        let is_number = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
        is_number && !name.is_empty() && !name.ends_with(char::is_whitespace)
    })
}

fn is_unit(text: &str, is_bracketed: bool) -> bool {
    // A letter behind a name is a chamber, a number one of several; a ratio is no unit.
    let is_letter = text.chars().count() < 2 && (!is_bracketed || ["", "-", "A", "B", "a", "b"].contains(&text));
    let is_name = is_letter || text.bytes().all(|byte| byte.is_ascii_digit());
    text == "1" || written_unit(text).is_some() || (!is_name && (is_bracketed || nearest_unit(text, None).is_some()))
}

/// A name without what leads to a unit in brackets: `x / [mm]`, `x in (mm)`.
fn led(name: &str) -> &str {
    let name = name.trim_end();
    name.strip_suffix('/').or_else(|| name.strip_suffix(" in")).unwrap_or(name).trim_end()
}

fn in_brackets(text: &str) -> Option<(&str, &str, bool)> {
    let (name, unit) = text.strip_suffix(']')?.rsplit_once('[')?;
    (!unit.contains(']')).then(|| (led(name), unit.trim(), true))
}

fn in_parentheses(text: &str) -> Option<(&str, &str, bool)> {
    let inner = text.strip_suffix(')')?;
    // `bar(g)` has parentheses of its own.
    let before = match inner.trim_end().strip_suffix(')') {
        Some(own) => own.rsplit_once('(').filter(|(_, own)| !own.contains(')'))?.0,
        None => inner,
    };
    let open = before.rfind('(')?;
    (!before[open..].contains(')')).then(|| (led(&text[..open]), inner[open + 1..].trim(), false))
}

/// A unit behind a slash or behind `in`.
fn behind_a_word(text: &str) -> Option<(&str, &str, bool)> {
    // The unit of `v_mm/s` stands behind the low line.
    if text.rsplit_once('_').is_some_and(|(_, unit)| unit.contains('/') && written_unit(unit).is_some()) {
        return None;
    }
    let slash = text.match_indices('/').map(|(at, _)| (at, at + 1));
    let word = text.match_indices(" in ").map(|(at, word)| (at, at + word.len()));
    let mut found: Vec<_> = slash.chain(word).filter(|(at, _)| *at > 0).collect();
    found.sort_unstable();
    let split = |(end, begin): (usize, usize)| (text[..end].trim_end(), text[begin..].trim_start());
    found
        .into_iter()
        .map(split)
        .find(|(_, unit)| !unit.is_empty() && !unit.contains(char::is_whitespace))
        .map(|(name, unit)| (name, unit, false))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_stand_behind_names_in_many_ways() {
        for (text, name, unit) in [
            ("x[mm]", "x", "mm"),
            ("Weg [mm]", "Weg", "mm"),
            ("x (mm)", "x", "mm"),
            ("p (bar(g))", "p", "bar(g)"),
            ("p [bar(g)]", "p", "bar(g)"),
            ("t / s", "t", "s"),
            ("v / m/min", "v", "m/min"),
            ("x/mm", "x", "mm"),
            ("Weg in mm", "Weg", "mm"),
            ("Weg / [mm]", "Weg", "mm"),
            ("x/y [mm]", "x/y", "mm"),
            ("reading [1]", "reading", "1"),
            ("F [foo]", "F", "foo"),
            ("p (Bar)", "p", "Bar"),
        ] {
            assert_eq!(name_and_unit(text), (name, Some(unit)), "{text}");
        }
        for text in [
            "x",
            "",
            "Position (left)",
            "friction.gms.alpha[1]",
            "F/x",
            "reading (2)",
            "x_KN",
            "v_mm/s",
            "[mm]",
            "x [-]",
        ] {
            assert_eq!(name_and_unit(text), (text, None), "{text}");
        }
    }

    #[test]
    fn rows_of_units_are_recognised() {
        let are = |cells: &[&str]| are_units(&cells.iter().map(|cell| Cow::from(*cell)).collect::<Vec<_>>(), 3);
        assert!(are(&["s", "(mm)", "-"]) && are(&["Second", "Volt", ""]) && are(&["[ms]", "[pulse]", "[r/min]"]));
        assert!(!are(&["", "-", "1"]) && !are(&["s", "mm"]) && !are(&["s", "mm", "left"]));
        assert_eq!(unit("[pulse]").as_deref(), Some("pulse"));
        assert_eq!(unit("(mm)").as_deref(), Some("mm"));
        assert_eq!(unit("pulse"), None);
        assert!(are_words(&["Second".to_owned(), "Volt".to_owned()]) && !are_words(&["s".to_owned()]));
    }
}
