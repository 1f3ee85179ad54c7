//! The exported functions.
//!
//! Functions that return a number return 0, or 1 for a refusal with its text. Nothing that the page passes is used as an
//! address.

#![allow(unsafe_code, reason = "an exported name must be unique in the whole program, which no compiler can check")]

use std::cell::RefCell;

use crate::{
    CallError, Session, estimable, findings, fit, friction_columns, friction_table, own_fmu, proposed_columns,
    read_table, scale, table_signals, tables,
};

#[cfg(target_arch = "wasm32")]
#[link(wasm_import_module = "page")]
unsafe extern "C" {
    /// Tells the page that the text is the progress of a fit.
    safe fn progress();
}

/// Only a page hears of the progress.
#[cfg(not(target_arch = "wasm32"))]
fn progress() {}

thread_local! {
    static SESSION: RefCell<Session> = RefCell::default();
    static QUESTION: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static FILE: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static SAMPLES: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
    static TEXT: RefCell<String> = const { RefCell::new(String::new()) };
}

fn answer(call: impl FnOnce(&mut Session) -> Result<(), CallError>) -> u32 {
    match SESSION.with_borrow_mut(call) {
        Ok(()) => 0,
        Err(error) => {
            TEXT.set(error.to_string());
            1
        }
    }
}

/// Where the buffer is: [`BUFFER`](crate::BUFFER) numbers, always at the same place.
// SAFETY: only this library is linked, and it has one function of this name.
#[unsafe(no_mangle)]
pub extern "C" fn playground_buffer() -> *mut f64 {
    SESSION.with_borrow_mut(|session| session.buffer.as_mut_ptr())
}

/// Where the text is, until the next call.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_text() -> *const u8 {
    TEXT.with_borrow(|text| text.as_ptr())
}

/// Length of the text in bytes.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_text_length() -> usize {
    TEXT.with_borrow(String::len)
}

/// Makes the [`tables`] the text.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_tables() {
    TEXT.set(tables().to_string());
}

/// [`Session::start`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_start(slot: usize, model: usize, count: usize) -> u32 {
    answer(|session| session.start(slot, model, count))
}

/// [`Session::set`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_set(slot: usize, count: usize) -> u32 {
    answer(|session| session.set(slot, count))
}

/// [`Session::advance`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_advance(slot: usize, end: f64) -> u32 {
    answer(|session| session.advance(slot, end))
}

/// [`Session::read`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_read(slot: usize, count: usize) -> u32 {
    answer(|session| session.read(slot, count))
}

/// Makes [`Session::ssv`] the text.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_ssv(count: usize, bytes: usize) -> u32 {
    answer(|session| {
        TEXT.set(session.ssv(count, bytes)?);
        Ok(())
    })
}

/// Address of memory for the question of a fit, with a size in bytes, valid until the next call.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_question(bytes: usize) -> *mut u8 {
    QUESTION.replace(vec![0; bytes]);
    QUESTION.with_borrow_mut(|question| question.as_mut_ptr())
}

/// Address of memory for a number of samples of a fit, valid until the next call.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_samples(count: usize) -> *mut f64 {
    SAMPLES.replace(vec![0.0; count]);
    SAMPLES.with_borrow_mut(|samples| samples.as_mut_ptr())
}

/// Makes the answer to the question the text, and its curves the samples: [`fit`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_fit() -> u32 {
    let told = |state: &serde_json::Value| {
        TEXT.set(state.to_string());
        progress();
    };
    let (question, samples) = (QUESTION.take(), SAMPLES.take());
    let fitted = fit(&String::from_utf8_lossy(&question), &samples, &told);
    tell(fitted.map(|(answer, curves)| {
        SAMPLES.set(curves);
        answer
    }))
}

/// Makes the parameters that the fit of the question may estimate the text: [`estimable`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_estimable() -> u32 {
    tell(estimable(&String::from_utf8_lossy(&QUESTION.take())))
}

/// Makes the columns of measured friction the text, of the table and the names in the question: [`friction_columns`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_friction_columns() -> u32 {
    tell(friction_columns(&String::from_utf8_lossy(&QUESTION.take())))
}

/// Makes the parameters for measured friction the text, of the table in the question and the samples: [`friction_table`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_friction_table() -> u32 {
    tell(friction_table(&String::from_utf8_lossy(&QUESTION.take()), &SAMPLES.take()))
}

/// Address of memory for a file with a size in bytes, valid until the next call.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_file(bytes: usize) -> *mut u8 {
    FILE.replace(vec![0; bytes]);
    FILE.with_borrow_mut(|file| file.as_mut_ptr())
}

/// Makes what stands in the table of the file the text, and its numbers the samples; the question is its name: [`read_table`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_read_table() -> u32 {
    let read = read_table(&String::from_utf8_lossy(&QUESTION.take()), &FILE.take());
    tell(read.map(|(about, numbers)| {
        SAMPLES.set(numbers);
        about
    }))
}

/// Makes the columns that their names tell the text: [`proposed_columns`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_proposed_columns() -> u32 {
    tell(proposed_columns(&String::from_utf8_lossy(&QUESTION.take())))
}

/// Makes factor and offset of a unit of a signal the text; the question is both, each with a zero behind it: [`scale`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_scale() -> u32 {
    let question = QUESTION.take();
    let question = String::from_utf8_lossy(&question);
    let (signal, unit) = question.split_once('\0').unwrap_or_default();
    tell(scale(signal, unit.trim_end_matches('\0')))
}

/// Makes the signals of the table in question and samples the samples: [`table_signals`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_table_signals() -> u32 {
    let found = table_signals(&String::from_utf8_lossy(&QUESTION.take()), &SAMPLES.take());
    tell(found.map(|(about, signals)| {
        SAMPLES.set(signals);
        about
    }))
}

/// Makes the findings about the chosen columns of the table in question and samples the text: [`findings`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_findings() -> u32 {
    tell(findings(&String::from_utf8_lossy(&QUESTION.take()), &SAMPLES.take()))
}

/// Replaces the file by that of the machine in the question: [`own_fmu`].
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_own_fmu() -> u32 {
    let (question, source) = (QUESTION.take(), FILE.take());
    match own_fmu(&String::from_utf8_lossy(&question), &source) {
        Ok(made) => {
            FILE.set(made);
            0
        }
        Err(refusal) => {
            TEXT.set(refusal);
            1
        }
    }
}

/// Where the file is, until the next call.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_made() -> *const u8 {
    FILE.with_borrow(|file| file.as_ptr())
}

/// Length of the file in bytes.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_made_length() -> usize {
    FILE.with_borrow(Vec::len)
}

/// Makes an answer the text, or a refusal.
fn tell(answer: Result<serde_json::Value, String>) -> u32 {
    let is_refused = answer.is_err();
    TEXT.set(answer.map_or_else(|text| text, |answer| answer.to_string()));
    u32::from(is_refused)
}

/// Where the samples are.
// SAFETY: as for `playground_buffer`.
#[unsafe(no_mangle)]
pub extern "C" fn playground_curves() -> *const f64 {
    SAMPLES.with_borrow(|samples| samples.as_ptr())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text() -> String {
        let text = TEXT.with_borrow(String::clone);
        assert_eq!((playground_text(), playground_text_length()), (TEXT.with_borrow(|it| it.as_ptr()), text.len()));
        text
    }

    fn write(numbers: &[f64]) {
        SESSION.with_borrow_mut(|session| session.buffer[..numbers.len()].copy_from_slice(numbers));
    }

    /// A session of a page: it reads the tables, sets an input, runs to a time, reads, and writes its settings.
    #[test]
    fn page_runs_a_model_through_the_exported_functions() {
        let buffer = SESSION.with_borrow_mut(|session| session.buffer.as_mut_ptr());
        assert_eq!(playground_buffer(), buffer);
        playground_tables();
        assert_eq!(text(), tables().to_string());
        let table = pneumatic_servo::models::ALL[0].table();
        let place = |name: &str| table.iter().position(|variable| variable.name == name).expect("a variable") as f64;
        assert_eq!(playground_start(0, 0, 0), 0);
        write(&[place("valveVoltage"), 7.0]);
        assert_eq!((playground_set(0, 2), playground_advance(0, 0.3)), (0, 0));
        write(&["valveVoltage", "position"].map(place));
        assert_eq!(playground_read(0, 2), 0);
        let [voltage, position] = SESSION.with_borrow(|session| [session.buffer[0], session.buffer[1]]);
        assert!(voltage == 7.0 && position > 0.251, "at {voltage} V the carriage is at {position} m");

        let set = b"set\0text\0time\0\0";
        let mut words: Vec<u8> = set.to_vec();
        words.resize(words.len().next_multiple_of(8), 0);
        let words = words.chunks(8).map(|word| f64::from_le_bytes(word.try_into().expect("eight bytes")));
        write(&[[0.0, 2.0, place("valveVoltage"), 7.0].to_vec(), words.collect()].concat());
        assert_eq!(playground_ssv(4, set.len()), 0, "{}", text());
        assert!(text().contains("valveVoltage") && text().contains("set"), "{}", text());
    }

    /// Each refusal is a 1, and its text says why.
    #[test]
    fn refusals_are_told_by_number_and_text() {
        for (call, refused) in [
            (playground_start(0, usize::MAX, 0), "model"),
            (playground_set(40, 0), "plant"),
            (playground_advance(41, 1.0), "plant"),
            (playground_read(42, 0), "plant"),
            (playground_ssv(usize::MAX, 0), ""),
        ] {
            assert!(call == 1 && !text().is_empty(), "{refused}");
        }
        assert_eq!(playground_advance(40, 1.0), 1);
        assert!(text().contains("40"), "{}", text());
    }
}
