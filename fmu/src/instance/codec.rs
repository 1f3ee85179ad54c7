//! Saved states as bytes.
//!
//! ```text
//! magic (8 bytes) | format version (u32) | length of all bytes (u64) | GUID, record, snapshot in postcard | zeros | CRC-32
//! ```
//!
//! All numbers are little-endian, so that a state may be restored on another platform. The header is compared as a
//! whole and the checksum covers the rest: no single changed byte goes unnoticed. With the zeros all states of a model have
//! the same length, since there are hosts that ask for it once.

use std::fmt::Display;

use crc::{CRC_32_ISO_HDLC, Crc};
use serde::{Deserialize, Serialize};

use super::layout::Layout;
use super::record::Record;
use crate::failure::Failure;
use pneumatic_servo::co_simulation::Snapshot;

const MAGIC: &[u8; 8] = b"PSCstate";
/// To be raised whenever [`SavedState`] or anything in it changes.
const VERSION: u32 = 4;
const VERSION_AT: usize = MAGIC.len();
const LENGTH_AT: usize = VERSION_AT + size_of::<u32>();
const BODY_AT: usize = LENGTH_AT + size_of::<u64>();
const CHECKSUM: usize = size_of::<u32>();
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A complete copy of an instance, apart from its log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedState {
    /// Record of the instance.
    pub record: Record,
    /// The model's own states, once it runs.
    pub snapshot: Option<Snapshot>,
}

#[derive(Serialize)]
struct Outgoing<'a> {
    guid: &'a str,
    state: &'a SavedState,
}

#[derive(Deserialize)]
struct Incoming {
    guid: String,
    state: SavedState,
}

/// The bytes of a state of the model with a GUID: as many as a length, unless the state takes more.
pub fn encode(state: &SavedState, guid: &str, length: usize) -> Result<Vec<u8>, Failure> {
    let mut body = postcard::to_allocvec(&Outgoing { guid, state })
        .map_err(|error| Failure::error(format!("the state cannot be serialized: {error}")))?;
    let length = length.max(BODY_AT + body.len() + CHECKSUM);
    body.resize(length - BODY_AT - CHECKSUM, 0);
    Ok([&header(length)[..], &body, &CRC.checksum(&body).to_le_bytes()].concat())
}

/// The length of the states of a model.
pub fn length(layout: &Layout) -> usize {
    // GUID, kind, mode, experiment, the last step, the lengths of lists, and the checksum.
    const OTHERS: usize = 160;
    BODY_AT
        + size_of::<f64>() * (layout.parameters.len() + 2 * layout.inputs.len())
        + layout.model.snapshot_size()
        + OTHERS
}

/// The state from which the bytes were made.
pub fn decode(bytes: &[u8], guid: &str) -> Result<SavedState, Failure> {
    if !bytes.starts_with(MAGIC) {
        return Err(Failure::error("the bytes are no serialized state"));
    }
    let Some((start, body)) = bytes.split_at_checked(BODY_AT) else {
        return Err(Failure::error(format!("the serialized state is cut off: {} bytes are left", bytes.len())));
    };
    let expected = header(bytes.len());
    if start[VERSION_AT..LENGTH_AT] != expected[VERSION_AT..LENGTH_AT] {
        return Err(Failure::error(format!("the serialized state has another format than version {VERSION}")));
    }
    if start[LENGTH_AT..] != expected[LENGTH_AT..] {
        return Err(Failure::error(format!("{} bytes are not the length of the serialized state", bytes.len())));
    }
    let corrupt = |cause: &dyn Display| Failure::error(format!("the serialized state is corrupt: {cause}"));
    let checked = body.split_last_chunk().filter(|(body, sum)| CRC.checksum(body) == u32::from_le_bytes(**sum));
    let (body, _) = checked.ok_or_else(|| corrupt(&"its checksum is another one"))?;
    let (content, rest): (Incoming, _) = postcard::take_from_bytes(body).map_err(|error| corrupt(&error))?;
    if rest.iter().any(|byte| *byte != 0) {
        return Err(corrupt(&"something follows it"));
    }
    if content.guid != guid {
        return Err(Failure::error(format!("the serialized state belongs to {}, not to {guid}", content.guid)));
    }
    Ok(content.state)
}

fn header(length: usize) -> [u8; BODY_AT] {
    let mut header = [0; BODY_AT];
    header[..VERSION_AT].copy_from_slice(MAGIC);
    header[VERSION_AT..LENGTH_AT].copy_from_slice(&VERSION.to_le_bytes());
    header[LENGTH_AT..].copy_from_slice(&(length as u64).to_le_bytes());
    header
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::testing;

    const GUID: &str = "{a model}";
    const LENGTH: usize = 400;

    fn example() -> (SavedState, Vec<u8>) {
        let mut record = Record::new(&testing::layout(), crate::instance::Kind::CoSimulation);
        record.inputs[0] = f64::from_bits(0x7ff8_dead_beef_0001);
        let state = SavedState { record, snapshot: None };
        let bytes = encode(&state, GUID, LENGTH).expect("bytes");
        (state, bytes)
    }

    #[test]
    fn bytes_give_the_state_back_bit_for_bit() {
        let (state, bytes) = example();
        let back = decode(&bytes, GUID).expect("the state");
        assert_eq!(back.record.inputs[0].to_bits(), state.record.inputs[0].to_bits());
        assert_eq!(back.record.parameters, state.record.parameters);
        assert_eq!(bytes.len(), LENGTH);
        assert_eq!(encode(&back, GUID, LENGTH), Ok(bytes));
    }

    #[test]
    fn every_flipped_bit_is_noticed() {
        let (_, bytes) = example();
        for bit in 0..8 * bytes.len() {
            let mut bytes = bytes.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(decode(&bytes, GUID).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn every_cut_and_every_extension_is_noticed() {
        let (_, bytes) = example();
        for length in 0..bytes.len() {
            assert!(decode(&bytes[..length], GUID).is_err(), "{length} bytes");
        }
        assert!(decode(&[&bytes[..], &[0]].concat(), GUID).is_err());
    }

    #[test]
    fn other_models_and_versions_are_refused_by_name() {
        let (_, mut bytes) = example();
        let failure = decode(&bytes, "{another}").expect_err("another model");
        assert!(failure.message.contains(GUID) && failure.message.contains("{another}"), "{failure:?}");
        bytes[VERSION_AT] += 1;
        let failure = decode(&bytes, GUID).expect_err("another version");
        assert!(failure.message.contains("another format than version 4"), "{failure:?}");
    }
}
