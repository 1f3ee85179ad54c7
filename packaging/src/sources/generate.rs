//! Sources made of a model: its module in WebAssembly, translated, behind the functions in `packaging/c`.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use wasm_as_c::Options;

use super::{Size, Sources, build_description, model_table};
use crate::build::wasm;
use crate::description::Version;
use crate::workspace::Workspace;

/// Exports of the module that the C around it calls, besides the functions of FMI.
const ROOTS: [&str; 5] = ["plant_begin", "plant_room", "plant_callbacks", "plant_logger", "plant_self_test"];
/// Exports of a module that the loop calls.
const LOOP: [&str; 6] = ["loop_room", "loop_start", "loop_retune", "loop_advance", "loop_time", "loop_read"];

/// Builds the module of a model.
///
/// # Errors
/// When a tool is missing or fails.
pub fn module(workspace: &Workspace, model: &Model, size: Size) -> Result<Vec<u8>> {
    wasm::of_model(workspace, model.name, size == Size::Small)
}

/// The sources of an FMU for some versions, from the module of its model.
///
/// # Errors
/// When a file cannot be read, or the module holds what is not translated.
pub fn sources(workspace: &Workspace, model: &'static Model, versions: &[Version], module: &[u8]) -> Result<Sources> {
    let mut compiled = ["plant.c", "arrays.c", "operators.c"].map(str::to_owned).to_vec();
    // The loop is compiled by who wants it.
    let mut by_hand = vec!["plant.c", "plant.h", "arrays.c", "heap.h", "loop.c", "loop.h"];
    for version in versions {
        let face = match version {
            Version::Fmi2 => "fmi2.c",
            Version::Fmi3 => "fmi3.c",
        };
        compiled.push(face.to_owned());
        by_hand.push(face);
    }
    let code =
        translated(model, module, &Options { include: Some("heap.h"), ..Options::new(model.name, &roots(versions)) })?;
    compiled.extend(code_files(&code));
    let mut files = code;
    add(workspace, model, &by_hand, None, &mut files)?;
    if versions.contains(&Version::Fmi3) {
        files.insert("buildDescription.xml".to_owned(), build_description::xml(model, &compiled)?);
    }
    Ok(Sources { files, compiled })
}

/// The files of the module that are compiled.
fn code_files(files: &BTreeMap<String, String>) -> impl Iterator<Item = String> {
    files.keys().filter(|name| name.starts_with("code") && name.ends_with(".c")).cloned()
}

/// The module as C, with the files that it needs.
fn translated(model: &Model, module: &[u8], options: &Options) -> Result<BTreeMap<String, String>> {
    let code = wasm_as_c::translate_with(module, options).with_context(|| format!("the module of {}", model.name))?;
    Ok(code.into_iter().chain(wasm_as_c::RUNTIME.map(|(name, text)| (name.to_owned(), text.to_owned()))).collect())
}

/// Adds the files that are written by hand, and what C knows of the model: for a loop alone, how large its heap is.
fn add(
    workspace: &Workspace,
    model: &'static Model,
    by_hand: &[&str],
    heap: Option<usize>,
    files: &mut BTreeMap<String, String>,
) -> Result<()> {
    for name in by_hand {
        let file = workspace.home.join("packaging/c").join(name);
        let text = std::fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
        files.insert((*name).to_owned(), text);
    }
    files.insert("model.h".to_owned(), model_table::header(model, workspace.product.source.as_deref(), heap)?);
    files.insert("model.c".to_owned(), model_table::table(model)?);
    Ok(())
}

/// The sources of a control loop alone, from the module of a crate that calls `export_loop!`.
///
/// # Errors
/// As [`sources`].
pub fn loop_sources(workspace: &Workspace, model: &'static Model, module: &[u8]) -> Result<Sources> {
    let roots = [&["loop_memory"], &LOOP[..]].concat();
    // A small margin is more comparisons, and less memory.
    let options =
        Options { margin: 1024, end: Some("__heap_base"), include: Some("heap.h"), ..Options::new(model.name, &roots) };
    let mut files = translated(model, module, &options)?;
    let mut compiled = ["plant.c", "operators.c", "loop.c", "model.c"].map(str::to_owned).to_vec();
    compiled.extend(code_files(&files));
    add(workspace, model, &["plant.c", "plant.h", "heap.h", "loop.c", "loop.h"], Some(HEAP), &mut files)?;
    Ok(Sources { files, compiled })
}

/// Bytes of heap of a loop alone: a run takes half.
const HEAP: usize = 16 << 10;

/// Exports of a module that the C calls, for some versions.
fn roots(versions: &[Version]) -> Vec<&'static str> {
    let functions = versions.iter().flat_map(|version| match version {
        Version::Fmi2 => pneumatic_servo_fmu::fmi2::exports::Functions::NAMES,
        Version::Fmi3 => pneumatic_servo_fmu::fmi3::exports::Functions::NAMES,
    });
    // Functions without an instance, or that free one, are written in C.
    let asked = functions.copied().filter(|name| !CONSTANT.contains(name) && !name.ends_with("FreeInstance"));
    ROOTS.into_iter().chain(LOOP).chain(asked).collect()
}

const CONSTANT: [&str; 3] = ["fmi2GetTypesPlatform", "fmi2GetVersion", "fmi3GetVersion"];

/// A module in which all that is asked of one does nothing.
#[cfg(test)]
pub fn sample_module() -> Vec<u8> {
    /// A number of two bytes, as the format writes it.
    fn number(value: usize) -> [u8; 2] {
        [(value % 128) as u8 | 128, (value / 128) as u8]
    }
    fn section(id: u8, contents: &[u8]) -> Vec<u8> {
        [&[id], &number(contents.len())[..], contents].concat()
    }
    let roots = roots(&Version::ALL);
    let export = |name: &&str| [&number(name.len())[..], name.as_bytes(), &[0, 0]].concat();
    let exports: Vec<u8> = number(roots.len()).into_iter().chain(roots.iter().flat_map(export)).collect();
    // One function that takes and returns nothing, one page of memory, the names, and the text of the function: its end.
    let parts = [section(1, &[1, 0x60, 0, 0]), section(3, &[1, 0]), section(5, &[1, 0, 1]), section(7, &exports)];
    [&b"\0asm\x01\0\0\0"[..], &parts.concat(), &section(10, &[1, 2, 0, 0x0b])].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each version has its face; FMI 3.0 says how sources are built. The loop is in all, and compiled by none.
    #[test]
    fn sources_are_those_of_the_versions() -> Result<()> {
        let workspace = Workspace::of_a_test("/target".as_ref());
        let model = &pneumatic_servo::models::position_controller::MODEL;
        for (versions, own, others) in [
            (&[Version::Fmi2][..], ["fmi2.c", "loop.c"], ["fmi3.c", "buildDescription.xml"]),
            (&[Version::Fmi3], ["fmi3.c", "buildDescription.xml"], ["fmi2.c", "fmi2.h"]),
        ] {
            let sources = sources(&workspace, model, versions, &sample_module())?;
            let has = |name: &&str| sources.files.contains_key(*name);
            assert!(own.iter().all(has) && !others.iter().any(has), "{:?}", sources.files.keys());
            assert!(["plant.c", "wasm.h", "model.h", "model.c", "loop.c", "code.h", "code_1.c"].iter().all(has));
            assert_eq!(sources.compiled, ["plant.c", "arrays.c", "operators.c", own[0], "code_1.c", "code_data.c"]);
        }
        let broken = sources(&workspace, model, &[Version::Fmi2], b"\0asm\x01\0\0\0").map(|_| ());
        assert!(broken.is_err_and(|error| error.to_string() == "the module of PositionController"));
        Ok(())
    }

    /// All functions of the standards, except those written in C that return a constant or free an instance.
    #[test]
    fn module_is_asked_for_what_the_c_does_not_do_itself() {
        let (two, three) = (roots(&[Version::Fmi2]), roots(&[Version::Fmi3]));
        for roots in [&two, &three] {
            assert_eq!((&roots[..5], &roots[5..11]), (&ROOTS[..], &LOOP[..]));
        }
        assert!(["fmi2Instantiate", "fmi2DoStep", "fmi2GetReal"].iter().all(|name| two.contains(name)), "{two:?}");
        assert!(["fmi3InstantiateCoSimulation", "fmi3DoStep"].iter().all(|name| three.contains(name)), "{three:?}");
        let own = ["fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2FreeInstance", "fmi3GetVersion", "fmi3FreeInstance"];
        let both = roots(&[Version::Fmi2, Version::Fmi3]);
        assert!(own.iter().all(|name| !both.contains(name)), "{both:?}");
        // FMI 2.0 has 44 functions, FMI 3.0 has 75.
        assert_eq!((two.len(), three.len(), both.len()), (11 + 44 - 3, 11 + 75 - 2, 11 + 44 + 75 - 5));
    }
}
