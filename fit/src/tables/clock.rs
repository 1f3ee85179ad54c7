//! Times of the clock that are written as texts, with a date or without, as seconds since the first.

use std::collections::BTreeMap;

const SECOND: i128 = 1_000_000_000;
const DAY: i128 = 86_400 * SECOND;

/// A time that is read, in ns of its day.
struct Moment<'a> {
    /// The date as it is written, and its three numbers.
    date: Option<(&'a str, [i64; 3])>,
    /// Ns since midnight, of world time where a zone is given; with the days of a duration.
    time: i128,
}

/// Whether a text is a time of the clock: `12:30:01.25`, `2026-11-27T12:30:01`, `27.11.2026 0:30:01`, `0 days 00:00:01`.
pub fn is_clock(text: &str) -> bool {
    moment(text.trim()).is_some()
}

/// Seconds of times of the clock since the first of them; nothing if some text is none.
///
/// Without dates, a clock that goes back by more than half a day has passed midnight.
///
/// # Errors
/// In words for the user, for a date that is none, or dates that may be of day and month or of month and day.
pub fn seconds_since_first<'a>(texts: impl IntoIterator<Item = &'a str>) -> Result<Option<Vec<f64>>, String> {
    let Some(found) = texts.into_iter().map(|text| moment(text.trim())).collect::<Option<Vec<_>>>() else {
        return Ok(None);
    };
    let mut moments: Vec<i128> = found.iter().map(|moment| moment.time).collect();
    if found.iter().any(|moment| moment.date.is_some()) {
        let days = days(found.iter().filter_map(|moment| moment.date))?;
        for (moment, found) in moments.iter_mut().zip(&found) {
            *moment += found.date.map_or(0, |(text, _)| days[text]) * DAY;
        }
    } else {
        let mut midnights = 0;
        for place in 1..moments.len() {
            moments[place] += midnights * DAY;
            if moments[place - 1] - moments[place] > DAY / 2 {
                midnights += 1;
                moments[place] += DAY;
            }
        }
    }
    let first = moments.first().copied();
    Ok(first.map(|first| moments.iter().map(|moment| (moment - first) as f64 / SECOND as f64).collect()))
}

/// Takes a number of some digits from the beginning of a text.
fn digits<'a>(text: &mut &'a str, least: usize, most: usize) -> Option<&'a str> {
    let number = text.bytes().take(most).take_while(u8::is_ascii_digit).count();
    let (found, rest) = text.split_at(number);
    *text = rest;
    (number >= least).then_some(found)
}

/// Takes a letter from the beginning of a text, if it is one of some.
fn one_of(text: &mut &str, letters: &[char]) -> Option<char> {
    let first = text.chars().next().filter(|first| letters.contains(first))?;
    *text = &text[first.len_utf8()..];
    Some(first)
}

fn moment(text: &str) -> Option<Moment<'_>> {
    let mut rest = text;
    let date = date(&mut rest);
    let days = if date.is_none() { days_of_duration(&mut rest) } else { 0 };
    let hour: i128 = digits(&mut rest, 1, 2)?.parse().ok()?;
    one_of(&mut rest, &[':'])?;
    let minute: i128 = digits(&mut rest, 2, 2)?.parse().ok()?;
    one_of(&mut rest, &[':'])?;
    let second: i128 = digits(&mut rest, 2, 2)?.parse().ok()?;
    let fraction = match one_of(&mut rest, &['.', ',', ':']) {
        Some(':') => digits(&mut rest, 3, 3)?,
        Some(_) => digits(&mut rest, 1, 9)?,
        None => "",
    };
    let fraction: i128 = format!("{fraction:0<9}").parse().ok()?;
    rest = rest.trim_start();
    let half = one_of(&mut rest, &['a', 'A', 'p', 'P']);
    if half.is_some() {
        one_of(&mut rest, &['.']);
        one_of(&mut rest, &['m', 'M'])?;
        one_of(&mut rest, &['.']);
        rest = rest.trim_start();
    }
    let hour = match half {
        None => hour,
        Some('p' | 'P') => hour % 12 + 12,
        Some(_) => hour % 12,
    };
    let ahead = zone(rest)?;
    Some(Moment { date, time: days * DAY + (60 * (60 * hour + minute - ahead) + second) * SECOND + fraction })
}

/// Takes a date and what stands between it and the time.
fn date<'a>(text: &mut &'a str) -> Option<(&'a str, [i64; 3])> {
    let mut rest = *text;
    let one = digits(&mut rest, 1, 4)?;
    one_of(&mut rest, &['-', '.', '/'])?;
    let two = digits(&mut rest, 1, 2)?;
    one_of(&mut rest, &['-', '.', '/'])?;
    let three = digits(&mut rest, 1, 4)?;
    let written = &text[..text.len() - rest.len()];
    if one_of(&mut rest, &['T']).is_none() {
        one_of(&mut rest, &[',']);
        let behind = rest.trim_start();
        if behind.len() == rest.len() {
            return None;
        }
        rest = behind;
    }
    let numbers = [one.parse().ok()?, two.parse().ok()?, three.parse().ok()?];
    *text = rest;
    Some((written, numbers))
}

/// Takes the days of a duration, as pandas writes it: `0 days 00:00:01`.
fn days_of_duration(text: &mut &str) -> i128 {
    let days = text.split_once(" day").and_then(|(days, rest)| {
        let rest = rest.strip_prefix('s').unwrap_or(rest).strip_prefix(' ')?;
        let is_number = !days.is_empty() && days.len() < 7 && days.bytes().all(|byte| byte.is_ascii_digit());
        Some((days.parse().ok().filter(|_| is_number)?, rest))
    });
    let Some((days, rest)) = days else { return 0 };
    *text = rest;
    days
}

/// Minutes that a zone is ahead of world time.
fn zone(text: &str) -> Option<i128> {
    let mut rest = text;
    let ahead = match one_of(&mut rest, &['Z', '+', '-']) {
        None | Some('Z') => 0,
        Some(sign) => {
            let hours: i128 = digits(&mut rest, 2, 2)?.parse().ok()?;
            one_of(&mut rest, &[':']);
            let minutes: i128 = digits(&mut rest, 2, 2)?.parse().ok()?;
            (60 * hours + minutes) * if sign == '+' { 1 } else { -1 }
        }
    };
    rest.is_empty().then_some(ahead)
}

/// The number of the day of each date.
fn days<'a>(dates: impl Iterator<Item = (&'a str, [i64; 3])>) -> Result<BTreeMap<&'a str, i128>, String> {
    let mut numbers: Vec<(&str, [i64; 3])> = Vec::new();
    for date in dates {
        if numbers.last() != Some(&date) {
            numbers.push(date);
        }
    }
    let is_month_first = is_month_first(&numbers)?;
    numbers.iter().map(|(text, numbers)| Ok((*text, day(text, *numbers, is_month_first)?))).collect()
}

/// Whether dates with slashes are of month, day and year.
fn is_month_first(dates: &[(&str, [i64; 3])]) -> Result<bool, String> {
    let slashed = || dates.iter().filter(|(text, numbers)| text.contains('/') && numbers[0] < 1000);
    if slashed().any(|(_, numbers)| numbers[0] > 12) {
        return Ok(false);
    }
    let is_told = slashed().any(|(_, numbers)| numbers[1] > 12);
    match slashed().next() {
        Some((text, _)) if !is_told && slashed().any(|(other, _)| other != text) => {
            Err(format!("the date '{text}' may be of day and month or of month and day; write year-month-day"))
        }
        _ => Ok(is_told),
    }
}

/// The number of a day since one that is always the same.
fn day(text: &str, [one, two, three]: [i64; 3], is_month_first: bool) -> Result<i128, String> {
    let is_year_first = text.bytes().take_while(u8::is_ascii_digit).count() == 4;
    let [year, month, day] = match (is_year_first, is_month_first && text.contains('/')) {
        (true, _) => [one, two, three],
        (_, true) => [three, one, two],
        _ => [three, two, one],
    };
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let longest = match month {
        1 | 3 | 5 | 7 | 8 | 10 | 12 => 31,
        4 | 6 | 9 | 11 => 30,
        2 => 28 + i64::from(is_leap),
        _ => return Err(format!("the date '{text}' is refused: there is no month {month}; write year-month-day")),
    };
    if !(1..=longest).contains(&day) {
        return Err(format!("the date '{text}' is refused: month {month} of {year} has {longest} days"));
    }
    // Years that begin in March have their leap day at the end.
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let days = 365 * year + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    Ok(i128::from(days + (153 * month + 2) / 5 + day))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(texts: &[&'static str]) -> Vec<f64> {
        seconds_since_first(texts.iter().copied()).expect("dates").expect("times")
    }

    #[test]
    fn times_of_the_clock_are_seconds_since_the_first() {
        assert_eq!(seconds(&["12:30:01.25", "12:30:02,5", "12:31:00"]), [0.0, 1.25, 58.75]);
        assert_eq!(seconds(&["23:59:59.999", "0:00:00.001", "00:00:01"]), [0.0, 0.002, 1.001]);
        assert_eq!(seconds(&["12:00:00:000", "12:00:00:001"]), [0.0, 0.001]);
        assert_eq!(seconds(&["0 days 00:00:00", "0 days 23:59:59.5", "1 day 00:00:00"]), [0.0, 86_399.5, 86_400.0]);
        assert_eq!(seconds(&["11:59:59 AM", "12:00:00 p.m.", "1:00:00 pm"]), [0.0, 1.0, 3_601.0]);
        assert_eq!(
            seconds(&["2026-11-27T12:00:00Z", "2026-11-27T13:00:01+01:00", "2026-11-27 07:00:02-0500"]),
            [0.0, 1.0, 2.0]
        );
    }

    #[test]
    fn dates_are_of_day_and_month_unless_slashes_tell() {
        assert_eq!(seconds(&["28.2.2024 0:00:00", "1.3.2024 0:00:00"]), [0.0, 2.0 * 86_400.0]);
        assert_eq!(seconds(&["28.2.2026 0:00:00", "1.3.2026 0:00:00"]), [0.0, 86_400.0]);
        assert_eq!(seconds(&["12/31/2025 23:59:59", "1/1/2026, 00:00:00"]), [0.0, 1.0]);
        assert_eq!(seconds(&["31/12/2025 23:59:59", "1/1/2026 00:00:00"]), [0.0, 1.0]);
        let refused = |texts: &[&'static str]| seconds_since_first(texts.iter().copied()).expect_err("a refusal");
        assert!(refused(&["3/4/2026 0:00:00", "3/5/2026 0:00:00"]).contains("day and month or of month and day"));
        assert!(refused(&["31.02.2026 0:00:00"]).contains("'31.02.2026' is refused"));
        assert!(refused(&["31.13.2026 0:00:00"]).contains("no month 13"));
    }

    #[test]
    fn other_texts_are_no_times() {
        for text in ["", "12:30", "12.5", "1:2:3", "12:30:01 x", "2026-11-27", "12:00:00:12", "day 12:00:00"] {
            assert!(!is_clock(text), "{text}");
        }
        assert_eq!(seconds_since_first(["12:00:00", "later"]), Ok(None));
    }
}
