//! WebAssembly as C: the module that Rust's compiler makes of the plant, in files of bearable size.
//!
//! What is translated is what that compiler uses: one memory, one table that never changes, functions with at most one
//! result. Anything else is refused by name. Functions that nothing asks for are left out.
//!
//! | file | what it does |
//! |---|---|
//! | `operators` | the operators that compute, as a table |
//! | `function` | one function |
//! | `bounds` | which addresses in it are known to be within the memory |
//! | `value` | its variables, and what is on its stack |
//! | `signature` | what functions take and return |

mod bounds;
mod function;
mod operators;
mod signature;
#[cfg(test)]
mod tests;
mod value;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use anyhow::{Context, Result, bail, ensure};
use wasmparser::{
    ConstExpr, DataKind, ElementItems, ElementKind, ExternalKind, FunctionBody, Operator, Parser, Payload, TypeRef,
};

use self::bounds::MARGIN;
use self::function::{Function, Surroundings};
use self::operators::Type;
use self::signature::{Signature, value_type};

/// How many bytes of C are in a file, about.
const FILE: usize = 400_000;
/// How many bytes of memory a page has.
const PAGE: u64 = 65_536;

/// A module as it is read.
#[derive(Default)]
struct Module<'a> {
    signatures: Vec<Signature>,
    /// The signatures of functions, imported ones first.
    functions: Vec<usize>,
    imports: Vec<String>,
    globals: Vec<(Type, String)>,
    pages: u64,
    exports: BTreeMap<String, u32>,
    /// The functions of the table by their places; 0 is none.
    table: BTreeMap<u64, u32>,
    data: Vec<(u64, &'a [u8])>,
    bodies: Vec<FunctionBody<'a>>,
}

/// The C files of a module by name. Symbols begin with a prefix, for which a model stands; `roots` are the exported
/// functions that are needed, each by the name `wasm_<export>`.
///
/// # Errors
/// When the module holds what is not translated, or lacks a root.
pub fn translate(wasm: &[u8], prefix: &str, roots: &[&str]) -> Result<BTreeMap<String, String>> {
    let module = read(wasm)?;
    let mut exported = BTreeMap::new();
    for root in roots {
        let function = module.exports.get(*root).with_context(|| format!("the module exports no {root}"))?;
        exported.insert(*root, *function);
    }
    // What is imported has no text.
    let in_table = module.table.values().copied().filter(|number| *number as usize >= module.imports.len());
    let functions = translated(&module, exported.values().copied().chain(in_table))?;
    let mut files = BTreeMap::new();
    files.insert("code.h".to_owned(), header(&module, prefix, &exported, &functions)?);
    files.insert("code_data.c".to_owned(), data(&module)?);
    let mut number = 0;
    let mut text = String::new();
    for function in functions.values() {
        if text.len() + function.text.len() > FILE && !text.is_empty() {
            number += 1;
            files.insert(format!("code_{number}.c"), in_file(&std::mem::take(&mut text)));
        }
        text += &function.text;
    }
    files.insert(format!("code_{}.c", number + 1), in_file(&text));
    Ok(files)
}

fn in_file(text: &str) -> String {
    format!("/* Made from the plant in Rust; not meant to be read or changed. */\n#include \"code.h\"\n{text}")
}

fn read(wasm: &[u8]) -> Result<Module<'_>> {
    let mut module = Module::default();
    for payload in Parser::new(0).parse_all(wasm) {
        match payload? {
            Payload::TypeSection(types) => {
                for function in types.into_iter_err_on_gc_types() {
                    module.signatures.push(Signature::of(&function?)?);
                }
            }
            Payload::ImportSection(imports) => {
                for import in imports.into_imports() {
                    let import = import?;
                    let TypeRef::Func(signature) = import.ty else { bail!("{} is no function", import.name) };
                    module.functions.push(signature as usize);
                    module.imports.push(import.name.to_owned());
                }
            }
            Payload::FunctionSection(functions) => {
                for signature in functions {
                    module.functions.push(signature? as usize);
                }
            }
            Payload::TableSection(tables) => ensure!(tables.count() == 1, "there is more than one table"),
            Payload::MemorySection(memories) => {
                let memories = memories.into_iter().collect::<Result<Vec<_>, _>>()?;
                let [memory] = &memories[..] else { bail!("there is more than one memory") };
                ensure!(!memory.memory64 && !memory.shared, "the memory is no plain one of 32 bits");
                module.pages = memory.initial;
            }
            Payload::GlobalSection(globals) => {
                for global in globals {
                    let global = global?;
                    let start = format!("{}u", constant(&global.init_expr)?);
                    module.globals.push((value_type(global.ty.content_type)?, start));
                }
            }
            Payload::ExportSection(exports) => {
                for export in exports {
                    let export = export?;
                    if export.kind == ExternalKind::Func {
                        module.exports.insert(export.name.to_owned(), export.index);
                    }
                }
            }
            Payload::ElementSection(segments) => {
                for segment in segments {
                    let segment = segment?;
                    let (ElementKind::Active { offset_expr, .. }, ElementItems::Functions(functions)) =
                        (segment.kind, segment.items)
                    else {
                        bail!("a segment of the table is not written at the start")
                    };
                    let first = constant(&offset_expr)?;
                    for (function, place) in functions.into_iter().zip(first..) {
                        module.table.insert(place, function?);
                    }
                }
            }
            Payload::DataSection(segments) => {
                for segment in segments {
                    let segment = segment?;
                    let DataKind::Active { offset_expr, .. } = segment.kind else {
                        bail!("a segment of the memory is not written at the start")
                    };
                    module.data.push((constant(&offset_expr)?, segment.data));
                }
            }
            Payload::CodeSectionEntry(body) => module.bodies.push(body),
            Payload::StartSection { .. } => bail!("a module that starts by itself is not translated"),
            _ => (),
        }
    }
    Ok(module)
}

/// The number of a constant expression.
fn constant(expression: &ConstExpr) -> Result<u64> {
    match expression.get_operators_reader().read()? {
        Operator::I32Const { value } => Ok(u64::from(value.cast_unsigned())),
        other => bail!("{other:?} is no constant of 32 bits"),
    }
}

/// The functions that are reached from some.
fn translated(module: &Module, from: impl Iterator<Item = u32>) -> Result<BTreeMap<u32, Function>> {
    let globals: Vec<_> = module.globals.iter().map(|(of, _)| *of).collect();
    let surroundings = Surroundings {
        functions: &module.functions,
        imports: &module.imports,
        signatures: &module.signatures,
        globals: &globals,
        memory: module.pages * PAGE,
    };
    let mut functions = BTreeMap::new();
    let mut open: BTreeSet<u32> = from.collect();
    while let Some(number) = open.pop_first() {
        if functions.contains_key(&number) {
            continue;
        }
        let body = (number as usize).checked_sub(module.imports.len()).and_then(|place| module.bodies.get(place));
        let body = body.with_context(|| format!("there is no function {number}"))?;
        let function = function::translate(body, number, &surroundings)
            .with_context(|| format!("function {number} cannot be translated"))?;
        open.extend(&function.calls);
        functions.insert(number, function);
    }
    Ok(functions)
}

/// What the files share: names, types and declarations.
fn header(
    module: &Module,
    prefix: &str,
    exported: &BTreeMap<&str, u32>,
    functions: &BTreeMap<u32, Function>,
) -> Result<String> {
    let mut text = String::from("/* Made from the plant in Rust; not meant to be read or changed. */\n");
    writeln!(text, "#ifndef CODE_H\n#define CODE_H")?;
    writeln!(text, "#define PAGE {PAGE}u")?;
    writeln!(text, "#define MODULE_PAGES {}", module.pages)?;
    writeln!(text, "#define MARGIN {MARGIN}u")?;
    let globals = module.globals.iter().enumerate().map(|(place, (of, _))| format!("{} g{place};", of.in_c()));
    writeln!(text, "#define MODULE_GLOBALS {}", globals.collect::<String>())?;
    writeln!(text, "#include \"wasm.h\"")?;
    for name in ["module_start", "module_entry", "module_trap", "module_grow", "module_sum64"] {
        writeln!(text, "#define {name} {prefix}_{name}")?;
    }
    for import in &module.imports {
        writeln!(text, "#define {import} {prefix}_{import}")?;
    }
    for number in functions.keys() {
        writeln!(text, "#define w{number} {prefix}_w{number}")?;
    }
    for (name, number) in exported {
        writeln!(text, "#define wasm_{name} w{number}")?;
    }
    writeln!(text, "#include \"operators.h\"")?;
    for (number, signature) in module.signatures.iter().enumerate() {
        writeln!(text, "typedef {};", signature.declaration(&format!("(*t{number})"), false))?;
    }
    let signature = |number: u32| &module.signatures[module.functions[number as usize]];
    for (import, number) in module.imports.iter().zip(0..) {
        writeln!(text, "{};", signature(number).declaration(import, false))?;
    }
    for number in functions.keys() {
        writeln!(text, "{};", signature(*number).declaration(&format!("w{number}"), false))?;
    }
    writeln!(text, "#endif")?;
    Ok(text)
}

/// Memory, global variables and table at the start.
fn data(module: &Module) -> Result<String> {
    let mut text = String::new();
    for (number, (_, bytes)) in module.data.iter().enumerate() {
        writeln!(text, "static const u8 data{number}[{}]={{", bytes.len().max(1))?;
        for line in bytes.chunks(40) {
            for byte in line {
                write!(text, "{byte},")?;
            }
            text.push('\n');
        }
        writeln!(text, "}};")?;
    }
    writeln!(text, "void module_start(Module*s){{")?;
    for (place, (_, start)) in module.globals.iter().enumerate() {
        writeln!(text, "s->g{place}={start};")?;
    }
    for (number, (at, bytes)) in module.data.iter().enumerate() {
        writeln!(text, "memcpy(s->memory+{at}u,data{number},{}u);", bytes.len())?;
    }
    writeln!(text, "}}")?;
    let last = module.table.keys().last().copied().unwrap_or_default();
    writeln!(text, "static const struct{{u32 of;Function function;}}table[{}]={{", last + 1)?;
    for place in 0..=last {
        match module.table.get(&place) {
            Some(function) => {
                let signature = module.functions[*function as usize];
                let name = match module.imports.get(*function as usize) {
                    Some(import) => import.clone(),
                    None => format!("w{function}"),
                };
                writeln!(text, "{{{signature}u,(Function){name}}},")?;
            }
            None => writeln!(text, "{{0u,0}},")?,
        }
    }
    writeln!(text, "}};")?;
    writeln!(
        text,
        "Function module_entry(Module*s,u32 of,u32 place){{\n\
         if(place<{}u&&table[place].function&&table[place].of==of)return table[place].function;\n\
         trap(s,CALL_INDIRECT);\n}}",
        last + 1
    )?;
    Ok(in_file(&text))
}
