//! The time that goes into the FMU: the same for the same commit, so that a build can be repeated byte by byte.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime};

use anyhow::{Context, Result, ensure};
use humantime::format_rfc3339_seconds;

use crate::process;

/// Time used outside a git checkout: 2020-01-01.
const FALLBACK: u64 = 1_577_836_800;
/// End of the calendar: the year 10000.
const BEYOND: u64 = 253_402_300_800;

/// When the FMU was generated, as far as its bytes say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timestamp(SystemTime);

impl Timestamp {
    /// `SOURCE_DATE_EPOCH` if set, else the date of the commit, else a constant.
    ///
    /// # Errors
    /// When `SOURCE_DATE_EPOCH` is not a number of seconds.
    pub fn of_source(root: &Path) -> Result<Self> {
        let seconds = match process::variable("SOURCE_DATE_EPOCH") {
            Some(text) => {
                let text = text.to_string_lossy();
                text.parse().with_context(|| format!("SOURCE_DATE_EPOCH={text} is not a number of seconds"))?
            }
            None => commit_date(root).unwrap_or(FALLBACK),
        };
        Self::from_seconds(seconds)
    }

    fn from_seconds(seconds: u64) -> Result<Self> {
        ensure!(seconds < BEYOND, "{seconds} s is out of the calendar");
        Ok(Self(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds)))
    }

    /// As XML writes it, for example `2020-01-01T00:00:00Z`.
    pub fn iso(self) -> String {
        format_rfc3339_seconds(self.0).to_string()
    }

    /// As a zip archive stores it, in UTC.
    ///
    /// # Errors
    /// When it lies outside the years 1980 to 2107.
    pub fn in_archive(self) -> Result<zip::DateTime> {
        let iso = self.iso();
        let parts = iso.trim_end_matches('Z').split(['-', 'T', ':']).map(str::parse::<u16>);
        let [year, month, day, hour, minute, second] = parts.collect::<Result<Vec<_>, _>>()?[..] else {
            unreachable!("{iso} has a date and a time");
        };
        let [month, day, hour, minute, second] = [month, day, hour, minute, second].map(|part| part as u8);
        zip::DateTime::from_date_and_time(year, month, day, hour, minute, second)
            .with_context(|| format!("a zip archive cannot hold the date {iso}"))
    }
}

/// The date of the commit in s since 1970; nothing where git or a history is missing.
fn commit_date(root: &Path) -> Option<u64> {
    let mut git = Command::new("git");
    git.args(["log", "-1", "--format=%ct"]).current_dir(root).stderr(Stdio::null());
    let log = process::caught(&mut git).ok().filter(|output| output.status.success())?;
    String::from_utf8(log.stdout).ok()?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iso_text_is_what_xml_expects() -> Result<()> {
        assert_eq!(Timestamp::from_seconds(FALLBACK)?.iso(), "2020-01-01T00:00:00Z");
        assert_eq!(Timestamp::from_seconds(1_234_567_890)?.iso(), "2009-02-13T23:31:30Z");
        Ok(())
    }

    #[test]
    fn date_is_that_of_the_last_commit() -> Result<()> {
        let folder = crate::files::scratch("timestamp");
        std::fs::create_dir_all(&folder)?;
        assert_eq!(commit_date(&folder), None, "without a history");
        let author = ["-c", "user.name=A", "-c", "user.email=a@b"];
        for command in [&["init", "--quiet"][..], &["commit", "--quiet", "--allow-empty", "--message", "Begin"]] {
            let git = Command::new("git")
                .args(author)
                .args(command)
                .current_dir(&folder)
                .env("GIT_COMMITTER_DATE", "1234567890 +0100")
                .status()?;
            assert!(git.success(), "{command:?}");
        }
        assert_eq!(commit_date(&folder), Some(1_234_567_890));
        std::fs::remove_dir_all(&folder)?;
        Ok(())
    }

    #[test]
    fn dates_before_zip_archives_and_beyond_the_calendar_are_refused() -> Result<()> {
        assert!(Timestamp::from_seconds(0)?.in_archive().is_err());
        assert!(Timestamp::from_seconds(BEYOND).is_err() && Timestamp::from_seconds(BEYOND - 1).is_ok());
        Ok(())
    }

    #[test]
    fn archives_store_the_same_date() -> Result<()> {
        let date = Timestamp::from_seconds(1_234_567_890)?.in_archive()?;
        assert_eq!((date.year(), date.month(), date.day()), (2009, 2, 13));
        assert_eq!((date.hour(), date.minute(), date.second()), (23, 31, 30));
        Ok(())
    }
}
