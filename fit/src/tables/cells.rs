//! Cells of a line, and what they look like.

use std::borrow::Cow;

use crate::tables::clock::is_clock;

/// Separators of cells in the order in which they are tried, and their names.
pub const SEPARATORS: [(char, &str); 4] = [('\t', "tabs"), (';', "semicolons"), (',', "commas"), (' ', "blanks")];

/// Fills `found` with the cells of a line; returns whether all quotes are closed.
pub fn split<'a>(line: &'a str, separator: char, found: &mut Vec<Cow<'a, str>>) -> bool {
    found.clear();
    let is_end = |letter: char| if separator == ' ' { letter.is_whitespace() } else { letter == separator };
    if !line.contains('"') {
        let cells = line.split(is_end).map(str::trim).filter(|cell| separator != ' ' || !cell.is_empty());
        found.extend(cells.map(Cow::Borrowed));
        return true;
    }
    let mut rest = line;
    loop {
        rest = rest.trim_start_matches(|letter: char| letter == ' ' || (separator == ' ' && letter.is_whitespace()));
        if separator == ' ' && rest.is_empty() {
            return true;
        }
        let mut cell = Cow::Borrowed("");
        if let Some(quoted) = rest.strip_prefix('"') {
            let Some((text, behind)) = unquoted(quoted) else {
                found.push(Cow::Borrowed(quoted.trim()));
                return false;
            };
            (cell, rest) = (text, behind);
        }
        let (own, behind) = match rest.find(is_end) {
            Some(end) => (&rest[..end], rest[end..].chars().next().map(|letter| &rest[end + letter.len_utf8()..])),
            None => (rest, None),
        };
        cell += own.trim();
        found.push(cell);
        match behind {
            Some(behind) => rest = behind,
            None => return true,
        }
    }
}

/// The text up to the closing quote, and what is behind it; two quotes are one.
fn unquoted(text: &str) -> Option<(Cow<'_, str>, &str)> {
    let mut found = Cow::Borrowed("");
    let mut rest = text;
    loop {
        let (own, behind) = rest.split_once('"')?;
        found += own;
        match behind.strip_prefix('"') {
            Some(more) => (found, rest) = (found + "\"", more),
            None => return Some((Cow::Owned(found.trim().to_owned()), behind)),
        }
    }
}

/// The cells of a line, without the empty ones at its end.
pub fn cells(line: &str, separator: char) -> Vec<Cow<'_, str>> {
    let mut found = Vec::new();
    split(line, separator, &mut found);
    trim(&mut found, 1);
    found
}

/// Takes away empty cells at the end, but for a number of cells.
pub fn trim(cells: &mut Vec<Cow<'_, str>>, least: usize) {
    while cells.len() > least && cells.last().is_some_and(|cell| cell.is_empty()) {
        cells.pop();
    }
}

/// Whether more than half of the cells of a line are numbers or times.
pub fn is_row(line: &str, separator: char) -> bool {
    let cells = cells(line, separator);
    let is_known =
        |cell: &&Cow<'_, str>| (is_number(cell) && !(separator == ',' && cell.contains(','))) || is_clock(cell);
    2 * cells.iter().filter(is_known).count() > cells.len()
}

/// What is left of a text to be looked at.
struct Rest<'a>(&'a [u8]);

impl Rest<'_> {
    fn skip(&mut self, is: impl Fn(u8) -> bool) -> usize {
        let number = self.0.iter().take_while(|byte| is(**byte)).count();
        self.0 = &self.0[number..];
        number
    }

    fn digits(&mut self) -> usize {
        self.skip(|byte| byte.is_ascii_digit())
    }

    fn one_of(&mut self, letters: &[u8]) -> bool {
        let is_there = self.0.first().is_some_and(|first| letters.contains(first));
        self.0 = &self.0[usize::from(is_there)..];
        is_there
    }

    /// Whether nothing is left but an exponent.
    fn ends(&mut self) -> bool {
        if self.one_of(b"eE") {
            self.one_of(b"+-");
            return self.digits() > 0 && self.0.is_empty();
        }
        self.0.is_empty()
    }
}

/// Whether a text is a number, with a decimal point or a decimal comma, or what programs write for one that is none.
pub fn is_number(text: &str) -> bool {
    let mut rest = Rest(text.as_bytes());
    rest.one_of(b"+-");
    if rest.0.eq_ignore_ascii_case(b"nan") || rest.0.eq_ignore_ascii_case(b"inf") {
        return true;
    }
    let whole = rest.digits();
    let behind = if rest.one_of(b".,") { rest.digits() } else { 0 };
    whole + behind > 0 && rest.ends()
}

/// Whether a text is a number with digits before and behind a decimal mark.
pub fn is_decimal(text: &str, mark: u8) -> bool {
    let mut rest = Rest(text.as_bytes());
    rest.one_of(b"+-");
    rest.digits() > 0 && rest.one_of(&[mark]) && rest.digits() > 0 && rest.ends()
}

/// Whether the marks of a number, commas or points, may separate thousands.
pub fn may_have_thousands(text: &str, mark: &str) -> bool {
    let mut groups = text.trim_start_matches(['+', '-']).split(mark);
    let first = groups.next().unwrap_or_default();
    let are_digits = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
    let is_first = (1..=3).contains(&first.len()) && are_digits(first) && !first.starts_with('0');
    is_first && text.contains(mark) && groups.all(|group| group.len() == 3 && are_digits(group))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_what_stands_between_separators_and_in_quotes() {
        let of = |line: &'static str, separator| {
            let mut found = Vec::new();
            let is_closed = split(line, separator, &mut found);
            (found.into_iter().map(Cow::into_owned).collect::<Vec<_>>(), is_closed)
        };
        let are = |cells: &[&str], is_closed| (cells.iter().map(|cell| (*cell).to_owned()).collect(), is_closed);
        assert_eq!(of("a; b;;c ", ';'), are(&["a", "b", "", "c"], true));
        assert_eq!(of("  a \t b ", ' '), are(&["a", "b"], true));
        assert_eq!(of(r#""a,b", "say ""c""",d"#, ','), are(&["a,b", r#"say "c""#, "d"], true));
        assert_eq!(of(r#""a b" "c""#, ' '), are(&["a b", "c"], true));
        assert_eq!(of(r#"5" pipe,2"#, ','), are(&["5\" pipe", "2"], true));
        assert_eq!(of(r#"1,"2"#, ','), are(&["1", "2"], false));
        assert_eq!(of("\"a\"\t\t", '\t'), are(&["a", "", ""], true));
    }

    #[test]
    fn numbers_are_recognised() {
        for text in ["1", "-1.5e-3", "1,5", ".5", "5.", "+,5", "NaN", "-inf"] {
            assert!(is_number(text), "{text}");
        }
        for text in ["", "-", ".", "1.2.3", "0x10", "1e", "a", "1 2", "infinite"] {
            assert!(!is_number(text), "{text}");
        }
        assert!(is_decimal("-1,5e3", b',') && !is_decimal("1,5", b'.') && !is_decimal(",5", b','));
        assert!(may_have_thousands("101,131", ",") && may_have_thousands("-1.234.567", "."));
        assert!(!["0,131", "1234,567", "1,23", "101"].into_iter().any(|text| may_have_thousands(text, ",")));
    }
}
