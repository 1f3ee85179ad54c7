// Put into the crates that `switched.py` changes: which of the mistakes is made, and which are reached.

/// Whether a mistake is made: the one that the environment names. Where it names a file instead, those reached are written there.
#[doc(hidden)]
#[must_use]
pub fn mutated(number: usize) -> bool {
    use std::io::Write as _;
    use std::sync::OnceLock;
    use std::sync::atomic::{AtomicBool, Ordering};
    static MADE: OnceLock<(usize, Option<std::fs::File>)> = OnceLock::new();
    static REACHED: [AtomicBool; 1000] = [const { AtomicBool::new(false) }; 1000];
    let (made, record) = MADE.get_or_init(|| {
        let made = std::env::var("MUTATED").ok().and_then(|number| number.parse().ok());
        let record = std::env::var_os("MUTATED_RECORD")
            .and_then(|file| std::fs::OpenOptions::new().append(true).create(true).open(file).ok());
        (made.unwrap_or(usize::MAX), record)
    });
    if let Some(mut file) = record.as_ref()
        && !REACHED[number].swap(true, Ordering::Relaxed)
    {
        let digit = |ten: usize| b'0' + (number / ten % 10) as u8;
        let _ = file.write_all(&[digit(100), digit(10), digit(1), b'\n']);
    }
    *made == number
}
