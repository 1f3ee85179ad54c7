//! The GUID that ties a model description to the library built from the same source.

use crate::fnv::Hash;
use pneumatic_servo::model::Model;

/// The GUID of a model of [`pneumatic_servo`]: a fingerprint of its name, the version, its variable table and the source of
/// this library.
///
/// It is the same on every platform and for every line end.
pub fn guid(model: &Model) -> String {
    guid_of_source(model, None)
}

/// The GUID of a model from elsewhere, whose own source has a fingerprint, too.
pub fn guid_of_source(model: &Model, source: Option<&str>) -> String {
    let mut hash = Hash::new();
    hash.add(model.name.as_bytes());
    hash.add(env!("CARGO_PKG_VERSION").as_bytes());
    hash.add(env!("SOURCE_FINGERPRINT").as_bytes());
    if let Some(source) = source {
        hash.add(source.as_bytes());
    }
    for variable in (model.variables)() {
        hash.add(format!("{variable:?}").as_bytes());
    }
    let digits = hash.digits();
    let (a, b, c, d, e) = (&digits[..8], &digits[8..12], &digits[12..16], &digits[16..20], &digits[20..]);
    format!("{{{a}-{b}-{c}-{d}-{e}}}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::testing;
    use pneumatic_servo::models;

    #[test]
    fn hash_is_the_published_one() {
        // FNV-1a 128 of "foobar", then of the separator, by the published algorithm.
        let mut state = 0x343e_1662_793c_64bf_6f0d_3597_ba44_6f18_u128;
        state = (state ^ 0x100).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
        let mut hash = Hash::new();
        hash.add(b"foobar");
        assert_eq!(hash.digits(), format!("{state:032x}"));
    }

    #[test]
    fn line_ends_do_not_matter() {
        let digits = |text: &str| {
            let mut hash = Hash::new();
            hash.add(text.as_bytes());
            hash.digits()
        };
        assert_eq!(digits("a\r\nb\r\n"), digits("a\nb\n"));
        assert_ne!(digits("a\rb"), digits("ab"));
    }

    #[test]
    fn guid_has_the_usual_form_and_follows_the_model() {
        let first = guid(&testing::MODEL);
        let dashes: Vec<_> = first.match_indices('-').map(|(index, _)| index).collect();
        assert_eq!(dashes, [9, 14, 19, 24]);
        assert!(first.starts_with('{') && first.ends_with('}') && first.len() == 38);
        assert_eq!(first, guid(&testing::MODEL));
        assert_ne!(first, guid(&Model { name: "Other", ..testing::MODEL }));
        assert_ne!(first, guid(&Model { variables: models::ALL[0].variables, ..testing::MODEL }));
    }
}
