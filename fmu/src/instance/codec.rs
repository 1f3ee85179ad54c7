//! Saved states as bytes.
//!
//! ```text
//! magic (8 bytes) | format version (u32) | length of all bytes (u64) | GUID, record, snapshot in postcard | CRC-32
//! ```
//!
//! All numbers are little-endian, so that a state may be restored on another platform. The header is compared as a
//! whole and the checksum covers the rest: no single changed byte goes unnoticed.

use crc::{CRC_32_ISO_HDLC, Crc};
use serde::{Deserialize, Serialize};

use super::record::Record;
use crate::failure::Failure;
use pneumatic_servo::co_simulation::Snapshot;

const MAGIC: &[u8; 8] = b"PSCstate";
/// To be raised whenever [`SavedState`] or anything in it changes.
const VERSION: u32 = 3;
const VERSION_AT: usize = MAGIC.len();
const LENGTH_AT: usize = VERSION_AT + size_of::<u32>();
const BODY_AT: usize = LENGTH_AT + size_of::<u64>();
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A complete copy of an instance, apart from its log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedState {
    /// What the instance remembers.
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

/// The bytes of a state of the model with a GUID.
pub fn encode(state: &SavedState, guid: &str) -> Result<Vec<u8>, Failure> {
    let body = postcard::to_allocvec_crc32(&Outgoing { guid, state }, CRC.digest())
        .map_err(|error| Failure::error(format!("the state cannot be serialized: {error}")))?;
    Ok([&header(BODY_AT + body.len())[..], &body].concat())
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
    let content: Incoming = postcard::from_bytes_crc32(body, CRC.digest())
        .map_err(|error| Failure::error(format!("the serialized state is corrupt: {error}")))?;
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

    fn example() -> (SavedState, Vec<u8>) {
        let mut record = Record::new(&testing::layout(), crate::instance::Kind::CoSimulation);
        record.inputs[0] = f64::from_bits(0x7ff8_dead_beef_0001);
        let state = SavedState { record, snapshot: None };
        let bytes = encode(&state, GUID).expect("bytes");
        (state, bytes)
    }

    #[test]
    fn bytes_give_the_state_back_bit_for_bit() {
        let (state, bytes) = example();
        let back = decode(&bytes, GUID).expect("the state");
        assert_eq!(back.record.inputs[0].to_bits(), state.record.inputs[0].to_bits());
        assert_eq!(back.record.parameters, state.record.parameters);
        assert_eq!(encode(&back, GUID), Ok(bytes));
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
        assert!(failure.message.contains("another format than version 3"), "{failure:?}");
    }
}
