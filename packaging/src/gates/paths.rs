//! Gate: a library contains no path of the building machine.

/// Beginnings of paths on the machine of a person or of a build service.
const TYPICAL: &[&str] = &["/home/", "/Users/", "/root/", "/tmp/", "\\Users\\", "/.cargo/", "\\.cargo\\"];

/// Every such path that is in the bytes.
pub fn problems(bytes: &[u8], private: &[String]) -> Vec<String> {
    let needles = TYPICAL.iter().copied().chain(private.iter().map(String::as_str));
    needles.filter_map(|needle| excerpt(bytes, needle)).map(|text| format!("holds a build path: {text}")).collect()
}

/// Text around the first occurrence.
fn excerpt(bytes: &[u8], needle: &str) -> Option<String> {
    let place = bytes.windows(needle.len()).position(|window| window == needle.as_bytes())?;
    let end = (place + 80).min(bytes.len());
    let text = bytes[place..end].split(|byte| !(b' '..=b'~').contains(byte)).next()?;
    Some(String::from_utf8_lossy(text).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_found_and_shown() {
        let bytes = b"\0\x01panicked at /home/ann/plant/src/lib.rs\0...";
        assert_eq!(problems(bytes, &[]), ["holds a build path: /home/ann/plant/src/lib.rs"]);
        assert_eq!(problems(b"C:\\Users\\ann\0", &[]).len(), 1);
    }

    #[test]
    fn paths_of_this_machine_count_too() {
        let private = ["/builds/42/".to_owned()];
        assert_eq!(problems(b"/builds/42/src/lib.rs", &private), ["holds a build path: /builds/42/src/lib.rs"]);
        assert_eq!(problems(b"src/lib.rs /usr/lib/libSystem.B.dylib", &private), Vec::<String>::new());
    }
}
