//! `model.h`: what the C around a module knows of its model.

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use pneumatic_servo_fmu::guid_of_source;
use pneumatic_servo_fmu::self_test::fingerprint;

/// The header: names, GUID, the fingerprint of the self-test, and the value references of all variables. A library that is not
/// the project's has the fingerprint of a source of its own.
///
/// # Errors
/// When the run of the self-test fails.
pub fn text(model: &'static Model, source: Option<&str>) -> Result<String> {
    let name = model.name;
    let fingerprint = fingerprint(model).with_context(|| format!("the self-test of {name} fails here"))?;
    let mut text = format!(
        "/* {name}: {}. The licences are in the folder documentation/licenses of the FMU. */\n\
         #ifndef MODEL_H\n\
         #define MODEL_H\n\n\
         /* What all symbols begin with, so that models do not get into each other's way. */\n\
         #define MODEL_PREFIX {name}_\n\
         #define PLANT_NAME(symbol) {name}_##symbol\n\
         /* CMake defines this where it makes a shared library, in which functions have the names of the standard. */\n\
         #ifdef {name}_EXPORTS\n\
         #define MODEL_IS_SHARED\n\
         #endif\n\
         #define MODEL_GUID \"{}\"\n\
         /* What the self-test gives where numbers are computed exactly. */\n\
         #define MODEL_FINGERPRINT 0x{fingerprint:016x}ull\n\n\
         /* Value references. */\n\
         enum {{\n",
        model.description,
        guid_of_source(model, source)
    );
    let references =
        model.table().iter().map(|variable| format!("    REF_{} = {}", identifier(&variable.name), variable.reference));
    text += &references.collect::<Vec<_>>().join(",\n");
    text += "\n};\n\n#endif\n";
    Ok(text)
}

/// A name as an identifier of C: `friction.law` is `friction_law`, `der(position)` is `der_position`.
fn identifier(name: &str) -> String {
    let words = name.split(|letter: char| !letter.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("_")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use pneumatic_servo::models;

    #[test]
    fn every_variable_has_an_identifier_of_its_own() -> Result<()> {
        assert_eq!(identifier("friction.gms.k[10]"), "friction_gms_k_10");
        assert_eq!(identifier("der(position)"), "der_position");
        for model in models::ALL {
            let names: Vec<_> = model.table().iter().map(|variable| identifier(&variable.name)).collect();
            assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "{}", model.name);
            let text = text(model, None)?;
            let (_, listed) = text.split_once("enum {\n").context("no references")?;
            let listed = listed.strip_suffix("\n};\n\n#endif\n").context("no end")?;
            let lines = names.iter().zip(model.table()).map(|(name, it)| format!("    REF_{name} = {}", it.reference));
            assert_eq!(listed.split(",\n").collect::<Vec<_>>(), lines.collect::<Vec<_>>());
        }
        Ok(())
    }
}
