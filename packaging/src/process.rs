//! Running of other programs, with output at least every half a minute.

use std::cell::{OnceCell, RefCell};
use std::ffi::{OsStr, OsString};
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Output, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use cargo_metadata::{Metadata, MetadataCommand};

/// Time until the first line about the progress of a program; the time until each further one is twice as long as the last.
const FIRST_PAUSE: Duration = Duration::from_secs(4);
/// Longest time without output.
const LONGEST_PAUSE: Duration = Duration::from_secs(32);

/// The Cargo that runs this program.
pub fn cargo() -> Command {
    Command::new(variable("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// Whether the variable `CI` is set: then a check that cannot run is an error.
pub fn under_ci() -> bool {
    variable("CI").is_some_and(|value| !value.is_empty() && value != "false")
}

/// Says that a check is left out, which is an error under CI.
///
/// # Errors
/// Under CI.
pub fn leave_out(what: &str, reason: &str) -> Result<()> {
    ensure!(!under_ci(), "{what}: {reason}; with CI set nothing is left out");
    heading(&format!("{what}: left out"));
    println!("{reason}");
    Ok(())
}

/// Prints the heading of a section, and how long the program has been running. The section lasts until the next heading
/// of the thread.
pub fn heading(text: &str) {
    end_section();
    let begin = since_begin();
    SECTION.with(|section| section.replace(Some((text.to_owned(), begin))));
    println!("\n== {text} == ({})", minutes(begin));
    // Programs started next write to the same terminal or file, so the heading must be there first.
    std::io::stdout().flush().ok();
}

/// A section that has come to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Its heading.
    pub text: String,
    /// When it began, since the program did.
    pub begin: Duration,
    /// Duration.
    pub length: Duration,
}

/// The sections so far, in order of their start. Sections of two threads may overlap.
pub fn sections() -> Vec<Section> {
    end_section();
    let mut sections = SECTIONS.lock().unwrap_or_else(PoisonError::into_inner).clone();
    sections.sort_by_key(|section| section.begin);
    sections
}

/// Minutes and seconds.
pub fn minutes(duration: Duration) -> String {
    format!("{}:{:02}", duration.as_secs() / 60, duration.as_secs() % 60)
}

static SECTIONS: Mutex<Vec<Section>> = Mutex::new(Vec::new());

thread_local! {
    /// The section that the thread is in, and when it began.
    static SECTION: RefCell<Option<(String, Duration)>> = const { RefCell::new(None) };
}

fn end_section() {
    if let Some((text, begin)) = SECTION.take() {
        let section = Section { text, begin, length: since_begin() - begin };
        SECTIONS.lock().unwrap_or_else(PoisonError::into_inner).push(section);
    }
}

/// Time since this was first asked for.
fn since_begin() -> Duration {
    static BEGIN: OnceLock<Instant> = OnceLock::new();
    BEGIN.get_or_init(Instant::now).elapsed()
}

/// Does something, and says in growing intervals that it is still under way.
pub fn with_progress<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let begin = Instant::now();
    std::thread::scope(|scope| {
        let (done, wait) = channel::<()>();
        scope.spawn(move || {
            let mut pause = FIRST_PAUSE;
            while wait.recv_timeout(pause) == Err(RecvTimeoutError::Timeout) {
                pause = (2 * pause).min(LONGEST_PAUSE);
                println!("  {what}: {:.0} s", begin.elapsed().as_secs_f64());
                std::io::stdout().flush().ok();
            }
        });
        let result = work();
        drop(done);
        result
    })
}

thread_local! {
    /// Set once something has failed that this thread works together with.
    static FAILED: OnceCell<Arc<OnceLock<()>>> = const { OnceCell::new() };
}

fn failed() -> Arc<OnceLock<()>> {
    FAILED.with(|failed| Arc::clone(failed.get_or_init(Arc::default)))
}

/// The error of a check that was abandoned.
const GIVEN_UP: &str = "given up, because another check has failed";

/// Does two things at once, and waits for both; once one has failed, the other starts no program any more.
///
/// # Errors
/// The first failure.
pub fn both<A: Send, B>(
    first: impl FnOnce() -> Result<A> + Send,
    second: impl FnOnce() -> Result<B>,
) -> Result<(A, B)> {
    let together = failed();
    std::thread::scope(|scope| {
        let first = scope.spawn(move || {
            FAILED.with(|failed| failed.set(together).ok());
            let outcome = noted(first());
            end_section();
            outcome
        });
        let second = noted(second());
        // Waiting for the other is no part of it.
        end_section();
        let first = first.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        match (first, second) {
            (Ok(first), Ok(second)) => Ok((first, second)),
            (Err(first), Err(second)) if first.to_string() == GIVEN_UP => Err(second),
            (Err(problem), _) | (_, Err(problem)) => Err(problem),
        }
    })
}

/// Notes a failure, whose error ends the program when all is quiet, and shows the first.
fn noted<T>(result: Result<T>) -> Result<T> {
    result.inspect_err(|problem| {
        failed().get_or_init(|| eprintln!("error: {problem:#}; the rest is given up"));
    })
}

fn go_on() -> Result<()> {
    ensure!(failed().get().is_none(), GIVEN_UP);
    Ok(())
}

/// Runs a command whose output the user sees.
///
/// # Errors
/// When it cannot be started or fails; the message holds the command line.
pub fn run(command: &mut Command) -> Result<()> {
    let status = status(command)?;
    ensure!(status.success(), "`{}` failed ({status})", line(command));
    Ok(())
}

/// Runs a command whose output the user sees, and returns how it has ended.
///
/// # Errors
/// When it cannot be started; the message holds the command line.
pub fn status(command: &mut Command) -> Result<ExitStatus> {
    go_on()?;
    let status = with_progress(&brief(command), || command.status());
    status.with_context(|| format!("cannot start `{}`", line(command)))
}

/// Runs a command and returns what it prints; its messages go to the user.
///
/// # Errors
/// When it cannot be started, fails, or prints something that is not UTF-8.
pub fn output(command: &mut Command) -> Result<String> {
    let output = caught(command.stderr(Stdio::inherit()))?;
    ensure!(output.status.success(), "`{}` failed ({})", line(command), output.status);
    String::from_utf8(output.stdout).with_context(|| format!("the output of `{}` is not UTF-8", line(command)))
}

/// Runs a command and returns how it has ended, with what it has printed.
///
/// # Errors
/// When it cannot be started; the message holds the command line.
pub fn caught(command: &mut Command) -> Result<Output> {
    go_on()?;
    let output = with_progress(&brief(command), || command.output());
    output.with_context(|| format!("cannot start `{}`", line(command)))
}

/// Whether a command can be started and ends well; nothing of it is shown.
pub fn works(command: &mut Command) -> bool {
    command.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
}

/// Metadata of packages, from Cargo.
///
/// # Errors
/// When it fails, or tells something else.
pub fn metadata(command: &MetadataCommand) -> Result<Metadata> {
    Ok(MetadataCommand::parse(output(&mut command.cargo_command())?)?)
}

/// Where a program is that would be started, if it is on the search path, or at the path that is its name.
pub fn find(program: &str) -> Option<PathBuf> {
    let is_program = |file: &PathBuf| file.is_file();
    if program.contains(['/', '\\']) {
        return Some(PathBuf::from(program)).filter(is_program);
    }
    let names =
        if cfg!(windows) { vec![format!("{program}.exe"), program.to_owned()] } else { vec![program.to_owned()] };
    let folders = variable("PATH").unwrap_or_default();
    let of = |folder: PathBuf| names.iter().map(move |name| folder.join(name)).collect::<Vec<_>>();
    std::env::split_paths(&folders).flat_map(of).find(is_program)
}

/// The value of a variable of the environment.
pub fn variable(name: &str) -> Option<OsString> {
    std::env::var_os(name)
}

/// The command line as a user would type it, near enough.
fn line(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(OsStr::to_string_lossy).collect::<Vec<_>>().join(" ")
}

/// The program without its folder, and the first of its arguments that are words.
fn brief(command: &Command) -> String {
    let program = std::path::Path::new(command.get_program()).file_stem().unwrap_or_default().to_string_lossy();
    let arguments = command.get_args().map(OsStr::to_string_lossy).filter(|argument| !argument.starts_with('-'));
    let names = arguments.map(|argument| argument.rsplit(['/', '\\']).next().unwrap_or_default().to_owned());
    std::iter::once(program.into_owned()).chain(names.take(2)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use anyhow::bail;

    use super::*;

    #[test]
    fn a_long_command_is_named_briefly() {
        let mut command = Command::new("/usr/bin/python3");
        assert_eq!(
            brief(command.args(["-m", "/a/b/check.py", "Model.fmu", "Other.fmu"])),
            "python3 check.py Model.fmu"
        );
    }

    #[test]
    fn a_command_that_fails_is_quoted() {
        let problem = run(cargo().args(["no-such-command"])).map_err(|error| error.to_string());
        assert!(problem.is_err_and(|text| text.contains("no-such-command` failed")));
    }

    #[test]
    fn sections_of_two_threads_are_told_in_their_order_and_end_with_their_thread() -> Result<()> {
        let nap = || std::thread::sleep(Duration::from_millis(30));
        heading("a test of sections: before");
        both(
            || {
                heading("a test of sections: one");
                nap();
                Ok(())
            },
            || {
                nap();
                heading("a test of sections: other");
                Ok(())
            },
        )?;
        nap();
        let ours: Vec<_> =
            sections().into_iter().filter(|section| section.text.starts_with("a test of sections")).collect();
        let texts: Vec<_> = ours.iter().map(|section| section.text.rsplit(' ').next().unwrap_or_default()).collect();
        assert_eq!(texts, ["before", "one", "other"]);
        let [before, one, other] = &ours[..] else { bail!("{ours:?}") };
        assert!(before.length >= Duration::from_millis(30) && one.length >= Duration::from_millis(30), "{ours:?}");
        assert!(other.begin >= before.begin + before.length && other.length < Duration::from_millis(30), "{ours:?}");
        assert_eq!(minutes(Duration::from_secs(605)), "10:05");
        Ok(())
    }

    #[test]
    fn once_one_of_two_has_failed_the_other_starts_no_program_and_the_failure_is_told() {
        let mut started = None;
        let outcome: Result<((), ())> = both(
            || bail!("the cause"),
            || {
                while go_on().is_ok() {
                    std::thread::yield_now();
                }
                let second = run(cargo().arg("--version"));
                started = Some(second.is_ok());
                second
            },
        );
        assert_eq!((outcome.unwrap_err().to_string().as_str(), started), ("the cause", Some(false)));
    }
}
