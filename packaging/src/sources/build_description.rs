//! `buildDescription.xml` of FMI 3.0: how an importer compiles the sources.

use anyhow::Result;
use pneumatic_servo::model::Model;
use pneumatic_servo_ssp::xml::{Element, document};

/// The description of one build, of a shared library. Without its definition all functions begin with the model's name, so that
/// several models can be linked into one program.
///
/// # Errors
/// When it cannot be written.
pub fn xml(model: &Model, compiled: &[String]) -> Result<String> {
    Ok(document(|xml| {
        Element::new("fmiBuildDescription").with("fmiVersion", "3.0").contain(xml, |xml| {
            Element::new("BuildConfiguration")
                .with("modelIdentifier", model.name)
                .with("description", "Any compiler of C99 for any processor with double precision")
                .contain(xml, |xml| {
                    Element::new("SourceFileSet").with("language", "C99").contain(xml, |xml| {
                        for file in compiled {
                            Element::new("SourceFile").with("name", file).write(xml)?;
                        }
                        Element::new("PreprocessorDefinition")
                            .with("name", "FMI3_OVERRIDE_FUNCTION_PREFIX")
                            .with("value", "1")
                            .with("description", "Functions have the names of the standard, as in a shared library")
                            .write(xml)
                    })
                })
        })
    })?)
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::models;

    use super::*;

    #[test]
    fn every_file_is_compiled_in_order() -> Result<()> {
        let text = xml(&models::friction_bench::MODEL, &["plant.c".to_owned(), "fmi3.c".to_owned()])?;
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        let expected = [
            "<fmiBuildDescription fmiVersion=\"3.0\">",
            "<BuildConfiguration modelIdentifier=\"FrictionBench\" description=\"Any compiler of C99 for any processor with \
             double precision\">",
            "<SourceFileSet language=\"C99\">",
            "<SourceFile name=\"plant.c\"/>",
            "<SourceFile name=\"fmi3.c\"/>",
            "<PreprocessorDefinition name=\"FMI3_OVERRIDE_FUNCTION_PREFIX\" value=\"1\" description=\"Functions have the names \
             of the standard, as in a shared library\"/>",
            "</SourceFileSet>",
            "</BuildConfiguration>",
            "</fmiBuildDescription>",
        ];
        assert_eq!(lines[1..], expected);
        Ok(())
    }
}
