//! The time that goes into the FMU: the same for the same commit, so that a build can be repeated byte by byte.

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result};
use jiff::Timestamp;
use jiff::tz::Offset;

/// What is used outside a git checkout: 2020-01-01.
const FALLBACK: i64 = 1_577_836_800;

/// When the FMU was generated, as far as its bytes say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment(Timestamp);

impl Moment {
    /// `SOURCE_DATE_EPOCH` if set, else the date of the commit, else a constant.
    ///
    /// # Errors
    /// When `SOURCE_DATE_EPOCH` is not a number of seconds.
    pub fn of_source(root: &Path) -> Result<Self> {
        let seconds = match std::env::var("SOURCE_DATE_EPOCH") {
            Ok(text) => text.parse().with_context(|| format!("SOURCE_DATE_EPOCH={text} is not a number of seconds"))?,
            Err(_) => commit_date(root).unwrap_or(FALLBACK),
        };
        Self::from_seconds(seconds)
    }

    fn from_seconds(seconds: i64) -> Result<Self> {
        Ok(Self(Timestamp::from_second(seconds).with_context(|| format!("{seconds} s is out of the calendar"))?))
    }

    /// As XML writes it, for example `2020-01-01T00:00:00Z`.
    pub fn iso(self) -> String {
        self.0.to_string()
    }

    /// As a zip archive stores it, in UTC.
    ///
    /// # Errors
    /// When it lies outside the years 1980 to 2107.
    pub fn in_archive(self) -> Result<zip::DateTime> {
        let civil = Offset::UTC.to_datetime(self.0);
        zip::DateTime::try_from(civil).with_context(|| format!("a zip archive cannot hold the date {}", self.iso()))
    }
}

/// The date of the commit in s since 1970; nothing where git or a history is missing.
fn commit_date(root: &Path) -> Option<i64> {
    let log = Command::new("git")
        .args(["log", "-1", "--format=%ct"])
        .current_dir(root)
        .stderr(Stdio::null())
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    String::from_utf8(log.stdout).ok()?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iso_text_is_what_xml_expects() -> Result<()> {
        assert_eq!(Moment::from_seconds(FALLBACK)?.iso(), "2020-01-01T00:00:00Z");
        assert_eq!(Moment::from_seconds(1_234_567_890)?.iso(), "2009-02-13T23:31:30Z");
        Ok(())
    }

    #[test]
    fn dates_before_zip_archives_are_refused() -> Result<()> {
        assert!(Moment::from_seconds(0)?.in_archive().is_err());
        assert_eq!(Moment::from_seconds(FALLBACK)?.in_archive()?.year(), 2020);
        Ok(())
    }
}
