//! Text of a file.

use std::io::Read;

use flate2::bufread::MultiGzDecoder;

/// Characters of Windows-1252 from 0x80 to 0x9f. A few of these bytes have no character.
const WINDOWS: [char; 32] = [
    '€', '\0', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\0', 'Ž', '\0', '\0', '‘', '’', '“', '”', '•',
    '–', '—', '˜', '™', 'š', '›', 'œ', '\0', 'ž', 'Ÿ',
];

/// The text of a file: UTF-8, UTF-16 with a byte order mark, else Windows-1252; it may be compressed by gzip.
pub fn text(data: &[u8]) -> Result<String, String> {
    if data.starts_with(&[0x1f, 0x8b]) {
        let mut unpacked = Vec::new();
        let read = MultiGzDecoder::new(data).read_to_end(&mut unpacked);
        read.map_err(|error| format!("it cannot be unpacked: {error}"))?;
        return plain(&unpacked);
    }
    plain(data)
}

fn plain(data: &[u8]) -> Result<String, String> {
    if data.starts_with(b"PK\x03\x04") || data.starts_with(b"\xd0\xcf\x11\xe0") {
        return Err(
            "it is a workbook, not a table of text; save it as CSV, or give pandas.read_excel(...) of it".to_owned()
        );
    }
    let (found, name) = match data {
        [0xff, 0xfe, rest @ ..] => (utf_16(rest, u16::from_le_bytes), "UTF-16"),
        [0xfe, 0xff, rest @ ..] => (utf_16(rest, u16::from_be_bytes), "UTF-16"),
        _ => match str::from_utf8(data.strip_prefix(b"\xef\xbb\xbf").unwrap_or(data)) {
            Ok(text) => (Ok(text.to_owned()), "UTF-8"),
            Err(_) => (windows_1252(data), "Windows-1252"),
        },
    };
    let hint = "; encoding= says in which it is";
    match found {
        Ok(text) if text.contains('\0') => Err(format!("it is no text in {name}, since it has bytes of 0{hint}")),
        Ok(text) => Ok(text),
        Err(what) => Err(format!("{what} is no text in {name}{hint}")),
    }
}

fn utf_16(data: &[u8], word: fn([u8; 2]) -> u16) -> Result<String, String> {
    let (words, rest) = data.as_chunks::<2>();
    let text: Result<String, _> = char::decode_utf16(words.iter().copied().map(word)).collect();
    match text {
        Ok(text) if rest.is_empty() => Ok(text),
        Ok(_) => Err("half a character at its end".to_owned()),
        Err(error) => Err(format!("0x{:04x}", error.unpaired_surrogate())),
    }
}

fn windows_1252(data: &[u8]) -> Result<String, String> {
    let character = |byte: u8| match byte {
        0x80..=0x9f => Some(WINDOWS[usize::from(byte - 0x80)]).filter(|known| *known != '\0'),
        other => Some(char::from(other)),
    };
    data.iter().map(|&byte| character(byte).ok_or_else(|| format!("byte 0x{byte:02x}"))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_the_same_in_each_encoding() {
        let text_of = |data: &[u8]| text(data).expect("a text");
        let words = |each: fn(u16) -> [u8; 2]| "\u{feff}Höhe 5 €".encode_utf16().flat_map(each).collect::<Vec<_>>();
        assert_eq!(text_of("Höhe 5 €".as_bytes()), "Höhe 5 €");
        assert_eq!(text_of("\u{feff}Höhe 5 €".as_bytes()), "Höhe 5 €");
        assert_eq!(text_of(b"H\xf6he 5 \x80"), "Höhe 5 €");
        assert_eq!(text_of(&words(u16::to_le_bytes)), "Höhe 5 €");
        assert_eq!(text_of(&words(u16::to_be_bytes)), "Höhe 5 €");
    }

    #[test]
    fn what_is_no_text_is_refused() {
        for (data, words) in [
            (b"t;x\n0;\x81\n".as_slice(), "byte 0x81 is no text in Windows-1252"),
            (b"\xff\xfea\0b", "half a character"),
            (b"\xff\xfe\0\xd8a\0", "0xd800 is no text in UTF-16"),
            (b"a\0b", "bytes of 0"),
            (b"PK\x03\x04", "a workbook"),
            (b"\x1f\x8b\x08", "cannot be unpacked"),
        ] {
            let refused = text(data).expect_err(words);
            assert!(refused.contains(words), "{refused}");
        }
    }
}
