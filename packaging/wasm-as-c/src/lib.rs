//! WebAssembly as C: the module that Rust's compiler makes of the plant, in files of bearable size.
//!
//! The translated subset is the output of that compiler: one memory, one table that never changes, functions with at most
//! one result. Anything else is refused by name. Functions that nothing asks for are left out.
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

use self::function::{Function, Surroundings};
use self::operators::Type;
use self::signature::{Signature, first_equal, value_type};

/// Approximate number of bytes of C in a file.
const FILE: usize = 400_000;
/// Bytes of a page of memory.
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
    /// The values of exported global variables at the start, as far as they are numbers of 32 bits.
    exported_globals: BTreeMap<String, u64>,
    /// The functions of the table by their places; 0 is none.
    table: BTreeMap<u64, u32>,
    data: Vec<(u64, &'a [u8])>,
    bodies: Vec<FunctionBody<'a>>,
}

/// Options of the translation of a module.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// Prefix of all symbols, before an underscore, so that several modules can be linked into one program.
    pub prefix: &'a str,
    /// The exported functions that are needed, each by the name `wasm_<export>` in C.
    pub roots: &'a [&'a str],
    /// Bytes behind the memory that nothing uses: accesses at smaller offsets from an address are checked together.
    pub margin: u64,
    /// The exported global variable whose value is the end of the memory that the module needs at least, if that is not whole
    /// pages: `__heap_base` of LLVM's linker, for a module that takes no pages into use.
    pub end: Option<&'a str>,
    /// A header that `code.h` includes before the runtime: it may define `MEMORY`, how many bytes an instance has.
    pub include: Option<&'a str>,
}

/// The files of C, by their names, that a translated module needs besides its own.
pub const RUNTIME: [(&str, &str); 3] = [
    ("operators.c", include_str!("../c/operators.c")),
    ("operators.h", include_str!("../c/operators.h")),
    ("wasm.h", include_str!("../c/wasm.h")),
];

impl<'a> Options<'a> {
    /// The usual options: whole pages and a margin of 16 KiB.
    pub fn new(prefix: &'a str, roots: &'a [&'a str]) -> Self {
        Self { prefix, roots, margin: 16_384, end: None, include: None }
    }
}

/// The C files of a module by name, with the usual options.
///
/// # Errors
/// As [`translate_with`].
pub fn translate(wasm: &[u8], prefix: &str, roots: &[&str]) -> Result<BTreeMap<String, String>> {
    translate_with(wasm, &Options::new(prefix, roots))
}

/// The C files of a module by name.
///
/// # Errors
/// When the module holds what is not translated, or lacks a root or the end of its memory.
pub fn translate_with(wasm: &[u8], options: &Options) -> Result<BTreeMap<String, String>> {
    let Options { prefix, roots, margin, end, include } = *options;
    let module = read(wasm)?;
    let bytes = match end {
        None => module.pages * PAGE,
        Some(name) => {
            let end =
                module.exported_globals.get(name).with_context(|| format!("the module exports no number {name}"))?;
            ensure!(*end <= module.pages * PAGE, "{name} = {end} is behind the memory of the module");
            end.next_multiple_of(16)
        }
    };
    let mut exported = BTreeMap::new();
    for root in roots {
        let function = module.exports.get(*root).with_context(|| format!("the module exports no {root}"))?;
        exported.insert(*root, *function);
    }
    // Imports have no text.
    let in_table = module.table.values().copied().filter(|number| *number as usize >= module.imports.len());
    let functions = translated(&module, [bytes, margin], exported.values().copied().chain(in_table))?;
    let mut files = BTreeMap::new();
    files.insert(
        "code.h".to_owned(),
        header(&module, [prefix, include.unwrap_or_default()], [bytes, margin], &exported, &functions)?,
    );
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

/// The names of the functions that a module exports.
///
/// # Errors
/// When the module holds what is not translated.
pub fn exports(wasm: &[u8]) -> Result<Vec<String>> {
    Ok(read(wasm)?.exports.into_keys().collect())
}

fn in_file(text: &str) -> String {
    format!("/* Translated from WebAssembly; not meant to be read or changed. */\n#include \"code.h\"\n{text}")
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
                    match export.kind {
                        ExternalKind::Func => {
                            module.exports.insert(export.name.to_owned(), export.index);
                        }
                        ExternalKind::Global => {
                            let start = module
                                .globals
                                .get(export.index as usize)
                                .and_then(|(_, start)| start.strip_suffix('u'));
                            if let Some(value) = start.and_then(|start| start.parse().ok()) {
                                module.exported_globals.insert(export.name.to_owned(), value);
                            }
                        }
                        _ => (),
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
fn translated(
    module: &Module,
    [memory, margin]: [u64; 2],
    from: impl Iterator<Item = u32>,
) -> Result<BTreeMap<u32, Function>> {
    let globals: Vec<_> = module.globals.iter().map(|(of, _)| *of).collect();
    let surroundings = Surroundings {
        functions: &module.functions,
        imports: &module.imports,
        signatures: &module.signatures,
        globals: &globals,
        memory,
        margin,
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

/// Common header of the files: names, types and declarations.
fn header(
    module: &Module,
    [prefix, include]: [&str; 2],
    [bytes, margin]: [u64; 2],
    exported: &BTreeMap<&str, u32>,
    functions: &BTreeMap<u32, Function>,
) -> Result<String> {
    let mut text = String::from("/* Translated from WebAssembly; not meant to be read or changed. */\n");
    writeln!(text, "#ifndef CODE_H\n#define CODE_H")?;
    writeln!(text, "#define PAGE {PAGE}u")?;
    writeln!(text, "#define MODULE_PAGES {}", module.pages)?;
    writeln!(text, "#define MODULE_BYTES {bytes}u")?;
    writeln!(text, "#define MARGIN {margin}u")?;
    let globals = module.globals.iter().enumerate().map(|(place, (of, _))| format!("{} g{place};", of.in_c()));
    writeln!(text, "#define MODULE_GLOBALS {}", globals.collect::<String>())?;
    if !include.is_empty() {
        writeln!(text, "#include \"{include}\"")?;
    }
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
                let signature = first_equal(&module.signatures, module.functions[*function as usize]);
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
