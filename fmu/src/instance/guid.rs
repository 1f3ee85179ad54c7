//! The GUID that ties a model description to the library built from the same source.

use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Kind, Variable};
use pneumatic_servo_variant::fnv::Hash;

/// The GUID of a model of [`pneumatic_servo`]: a fingerprint of its name, the version and the source of this library, and one of
/// its variables.
///
/// It is the same on every platform and for every line end.
pub fn guid(model: &Model) -> String {
    guid_of_source(model, None)
}

/// The GUID of a model from elsewhere, whose own source has a fingerprint, too.
pub fn guid_of_source(model: &Model, source: Option<&str>) -> String {
    let start = guid_start(model, source);
    let mut hash = Hash::default();
    for variable in &*model.shared_table() {
        let Variable { reference, name, kind, role, start, min, max, nominal, derivative_of, .. } = variable;
        hash.add(name.as_bytes());
        match kind {
            Kind::Real(unit) => hash.add(unit.name.as_bytes()),
            Kind::Integer => hash.add(b"Integer"),
            Kind::Boolean => hash.add(b"Boolean"),
            Kind::Enumeration(of) => of.items.iter().for_each(|(id, name, _)| {
                hash.add(&id.to_le_bytes());
                hash.add(name.as_bytes());
            }),
        }
        let numbers = [Some(*role as u32), Some(*reference), *derivative_of];
        numbers.iter().for_each(|it| hash.add(&it.map_or(u64::MAX, u64::from).to_le_bytes()));
        [start, min, max, nominal].iter().for_each(|it| hash.add(&it.map_or(u64::MAX, f64::to_bits).to_le_bytes()));
        variable.depends_on.iter().flatten().for_each(|it| hash.add(&it.to_le_bytes()));
    }
    let digits = hash.digits();
    format!("{start}-{}-{}}}", &digits[..4], &digits[4..16])
}

/// The half of a GUID that needs no table, which takes time to make.
pub fn guid_start(model: &Model, source: Option<&str>) -> String {
    let mut hash = Hash::default();
    hash.add(model.name.as_bytes());
    hash.add(env!("CARGO_PKG_VERSION").as_bytes());
    hash.add(env!("SOURCE_FINGERPRINT").as_bytes());
    if let Some(source) = source {
        hash.add(source.as_bytes());
    }
    let digits = hash.digits();
    format!("{{{}-{}-{}", &digits[..8], &digits[8..12], &digits[12..16])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::testing;
    use pneumatic_servo::model::Functions;
    use pneumatic_servo::models;

    #[test]
    fn hash_is_the_published_one() {
        // FNV-1a 128 of "foobar", then of the separator, by the published algorithm.
        let mut state = 0x343e_1662_793c_64bf_6f0d_3597_ba44_6f18_u128;
        state = (state ^ 0x100).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
        let mut hash = Hash::default();
        hash.add(b"foobar");
        assert_eq!(hash.digits(), format!("{state:032x}"));
    }

    #[test]
    fn line_ends_do_not_matter() {
        let digits = |text: &str| {
            let mut hash = Hash::default();
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
        let other = Functions { shared_table: models::ALL[0].functions.shared_table, ..testing::MODEL.functions };
        assert_ne!(first, guid(&Model { functions: other, ..testing::MODEL }));
    }
}
