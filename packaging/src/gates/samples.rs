//! Small libraries, written byte by byte for the tests.

use sha2::{Digest, Sha256};

/// Processors, as macOS counts them.
pub const INTEL: u32 = 0x0100_0007;
pub const ARM: u32 = 0x0100_000c;
/// Platforms, as macOS counts them.
pub const MACOS: u32 = 1;
pub const IOS: u32 = 2;

/// Signed part of a library of the Mac: a page of 4096 bytes and the half of one.
const SIGNED: u32 = 6144;

/// A library of the Mac for version 11.3 of a platform: it exports the entry of the compiled part of the Python package, and
/// has a signature or none.
pub fn mac(processor: u32, platform: u32, is_signed: bool) -> Vec<u8> {
    mac_with(processor, platform, is_signed, &[])
}

/// Such a library without a signature, with symbols of some types, all without a name.
pub fn mac_with_symbols(types: &[u8]) -> Vec<u8> {
    mac_with(INTEL, MACOS, false, types)
}

fn mac_with(processor: u32, platform: u32, is_signed: bool, symbols: &[u8]) -> Vec<u8> {
    // The names as a tree: one branch with the name, and a leaf at byte 19.
    let exports = b"\0\x01_PyInit__native\0\x13\x02\0\0\0";
    let build = [0x32, 24, platform, 0x000b_0300, 0x000b_0300, 0];
    // Sixteen bytes for each symbol, from byte 1024 on, and one for their names.
    let table = [2, 24, 1024, symbols.len() as u32, 2048, 1];
    let table = if symbols.is_empty() { &[] } else { &table[..] };
    let end = 32 + 24 + 16 + if is_signed { 16 } else { 0 } + 4 * table.len() as u32;
    let names = [0x8000_0033, 16, end, exports.len() as u32];
    let signed = [0x1d, 16, SIGNED, signature(&[]).len() as u32];
    let signature_command = if is_signed { &signed[..] } else { &[] };
    let commands = 2 + u32::from(is_signed) + u32::from(!symbols.is_empty());
    let header = [0xfeed_facf, processor, 0, 6, commands, end - 32, 0, 0];
    let mut bytes = little(&[&header[..], &build, &names, signature_command, table].concat());
    bytes.extend(exports);
    bytes.resize(SIGNED as usize, 0);
    for (place, of) in symbols.iter().enumerate() {
        // Behind the place of its name the type, and the section.
        bytes[1024 + 16 * place + 4..][..2].copy_from_slice(&[*of, 1]);
    }
    if is_signed {
        bytes.extend(signature(&bytes));
    }
    bytes
}

/// A signature of signed bytes: a directory of the hashes of their pages.
fn signature(signed: &[u8]) -> Vec<u8> {
    const HASHES: u32 = 46;
    let end = HASHES + 2 * 32;
    let list = [0xfade_0cc0, 20 + end, 1, 0, 20];
    let directory = [0xfade_0c02, end, 0x0002_0000, 2, HASHES, 44, 0, 2, SIGNED];
    let mut bytes = big(&[&list[..], &directory].concat());
    // Hashes of 32 bytes by SHA-256, of pages of 2 to the power of 12 bytes; and the name.
    bytes.extend([32, 2, 0, 12, 0, 0, 0, 0]);
    bytes.extend(b"a\0");
    let (first, second) = signed.split_at(signed.len().min(4096));
    bytes.extend([first, second].into_iter().flat_map(Sha256::digest));
    bytes
}

/// One library for two processors.
pub fn universal([one, other]: [(u32, Vec<u8>); 2]) -> Vec<u8> {
    let (first, second) = (one.1.len() as u32, other.1.len() as u32);
    let header = [0xcafe_babe, 2, one.0, 0, 48, first, 0, other.0, 0, 48 + first, second, 0];
    [big(&header), one.1, other.1].concat()
}

/// A library of Windows that exports and needs nothing, with numbers of symbols, and of bytes in its directory of debugging information.
pub fn windows(symbols: u8, debugging: u32) -> Vec<u8> {
    let mut bytes = vec![0; 64 + 4 + 20 + 240];
    let mut put = |at: usize, part: &[u8]| bytes[at..at + part.len()].copy_from_slice(part);
    put(0, b"MZ");
    put(0x3c, &[64]);
    put(64, b"PE\0\0\x64\x86");
    put(64 + 4 + 12, &[symbols]);
    put(64 + 4 + 16, &[240, 0, 0x22, 0x20]);
    let optional = 64 + 4 + 20;
    put(optional, &[0x0b, 0x02]);
    // There are 16 directories; the one of debugging information is the seventh.
    put(optional + 108, &[16]);
    put(optional + 112 + 6 * 8, &little(&[0x1000, debugging]));
    bytes
}

fn little(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

fn big(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_be_bytes()).collect()
}
