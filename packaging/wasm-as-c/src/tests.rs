use super::*;

/// Four functions, a memory of two pages, a global variable of 7, a table and three bytes at 16: `root` calls the second, which
/// calls itself; nothing asks for the third; the fourth is in the table.
const MODULE: &[&[u8]] = &[
    b"\0asm\x01\0\0\0",
    b"\x01\x09\x02\x60\x01\x7f\x01\x7f\x60\0\0",
    b"\x03\x05\x04\0\0\x01\0",
    b"\x04\x04\x01\x70\0\x02",
    b"\x05\x03\x01\0\x02",
    b"\x06\x06\x01\x7f\x01\x41\x07\x0b",
    b"\x07\x08\x01\x04root\0\0",
    b"\x09\x07\x01\0\x41\x01\x0b\x01\x03",
    b"\x0a\x17\x04\x06\0\x20\0\x10\x01\x0b\x06\0\x20\0\x10\x01\x0b\x02\0\x0b\x04\0\x20\0\x0b",
    b"\x0b\x09\x01\0\x41\x10\x0b\x03\x01\x02\x03",
];

#[test]
fn module_becomes_what_its_roots_reach() -> Result<()> {
    let files = translate(&MODULE.concat(), "Servo", &["root"])?;
    assert_eq!(files.keys().collect::<Vec<_>>(), ["code.h", "code_1.c", "code_data.c"], "short code is in one file");
    let [header, code, data] = ["code.h", "code_1.c", "code_data.c"].map(|name| &files[name]);
    for line in [
        "#define MODULE_PAGES 2",
        "#define MODULE_GLOBALS u32 g0;",
        "#define wasm_root w0",
        "typedef u32 (*t0)(Module*,u32);",
        "typedef void (*t1)(Module*);",
    ] {
        assert!(header.lines().any(|other| other == line), "{line} is not in\n{header}");
    }
    for (number, is_reached) in [(0, true), (1, true), (2, false), (3, true)] {
        let declared = header.contains(&format!("u32 w{number}(Module*,u32);"));
        let defined = code.matches(&format!("u32 w{number}(Module*s,u32 l0)")).count();
        assert_eq!((declared, defined), (is_reached, usize::from(is_reached)), "function {number} in\n{code}");
    }
    for text in ["1,2,3,", "s->g0=7u;", "memcpy(s->memory+16u,data0,3u);", "table[2]={\n{0u,0},\n{0u,(Function)w3},"] {
        assert!(data.contains(text), "{text} is not in\n{data}");
    }
    let problem = translate(&MODULE.concat(), "Servo", &["leaf"]).err().map(|error| error.to_string());
    assert_eq!(problem.as_deref(), Some("the module exports no leaf"));
    Ok(())
}

/// A number as WebAssembly writes it: seven bits in a byte, the last of which is below 128.
fn number(mut number: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    while number >= 128 {
        bytes.push((number % 128) as u8 + 128);
        number /= 128;
    }
    bytes.push(number as u8);
    bytes
}

/// Behind its size.
fn sized(bytes: &[u8]) -> Vec<u8> {
    [&number(bytes.len()), bytes].concat()
}

/// A section of things that are counted.
fn section(id: u8, things: &[&[u8]]) -> Vec<u8> {
    [&[id][..], &sized(&[number(things.len()), things.concat()].concat())].concat()
}

const BEGIN: &[u8] = b"\0asm\x01\0\0\0";
/// The signature of functions that take and return nothing.
const NOTHING: &[u8] = b"\x60\0\0";
/// A global variable of 7.
const SEVEN: &[u8] = b"\x7f\x01\x41\x07\x0b";

/// A function of no local variables.
fn body(code: &[u8]) -> Vec<u8> {
    sized(&[&[0], code, &[0x0b]].concat())
}

/// A module of functions that take and return nothing, all exported by letters from `a` on, with a global variable.
fn module(functions: &[Vec<u8>]) -> Vec<u8> {
    let exports: Vec<Vec<u8>> = (0..functions.len() as u8).map(|place| vec![1, b'a' + place, 0, place]).collect();
    fn all(things: &[Vec<u8>]) -> Vec<&[u8]> {
        things.iter().map(Vec::as_slice).collect()
    }
    let signatures = vec![&b"\0"[..]; functions.len()];
    [
        BEGIN.to_vec(),
        section(1, &[NOTHING]),
        section(3, &signatures),
        section(5, &[b"\0\x02"]),
        section(6, &[SEVEN]),
        section(7, &all(&exports)),
        section(10, &all(functions)),
    ]
    .concat()
}

/// A function with a text of a given length: a head of 19, lines of 10 and 11, and a brace with its line end.
fn long(bytes: usize) -> Vec<u8> {
    const TEN: &[u8] = b"\x41\x01\x24\0";
    const ELEVEN: &[u8] = b"\x41\x0a\x24\0";
    let lines = bytes - 21;
    let longer = lines % 10;
    body(&[TEN.repeat((lines - 11 * longer) / 10), ELEVEN.repeat(longer)].concat())
}

/// Files end before they would have more than 400,000 bytes, but for a function that has more alone.
#[test]
fn long_code_is_in_several_files() -> Result<()> {
    let files = |lengths: &[usize]| -> Result<Vec<Vec<String>>> {
        let functions: Vec<Vec<u8>> = lengths.iter().map(|length| long(*length)).collect();
        let letters = ["a", "b", "c", "d"];
        let mut files = translate(&module(&functions), "Servo", &letters[..lengths.len()])?;
        files.retain(|name, _| name != "code.h" && name != "code_data.c");
        let names = (1..=files.len()).map(|number| format!("code_{number}.c"));
        assert_eq!(files.keys().cloned().collect::<Vec<_>>(), names.collect::<Vec<_>>());
        let heads = |text: &String| {
            let lines = text.lines().filter(|line| line.starts_with("void w"));
            lines.map(|line| line[5..].split('(').next().unwrap_or_default().to_owned()).collect()
        };
        Ok(files.values().map(heads).collect())
    };
    let alone = &translate(&module(&[long(3025)]), "Servo", &["a"])?["code_1.c"];
    assert_eq!(alone.len(), in_file("").len() + 3025);
    assert_eq!(files(&[200_000, 200_000, 1_000])?, [vec!["w0", "w1"], vec!["w2"]]);
    assert_eq!(files(&[200_000, 200_001])?, [["w0"], ["w1"]]);
    assert_eq!(files(&[450_000, 1_000, 399_500])?, [["w0"], ["w1"], ["w2"]]);
    Ok(())
}

#[test]
fn functions_may_call_each_other_in_a_circle() -> Result<()> {
    let files = translate(&module(&[body(b"\x10\x01"), body(b"\x10\0")]), "Servo", &["a"])?;
    let code = files["code_1.c"].split_once("void").map(|(_, code)| code);
    assert_eq!(code, Some(" w0(Module*s){\nw1(s);\n}\nvoid w1(Module*s){\nw0(s);\n}\n"));
    Ok(())
}

/// Two pages have 131,072 bytes: eight from 131,064 on are the last.
#[test]
fn the_memory_has_as_many_bytes_as_its_pages() -> Result<()> {
    let is_compared = |load: &[u8]| -> Result<bool> {
        let files = translate(&module(&[body(load)]), "Servo", &["a"])?;
        assert!(files["code.h"].contains("#define PAGE 65536u\n#define MODULE_PAGES 2\n"), "{}", files["code.h"]);
        Ok(files["code_1.c"].contains("within("))
    };
    assert!(!is_compared(b"\x41\xf8\xff\x07\x2b\x03\0\x1a")?);
    assert!(is_compared(b"\x41\xf9\xff\x07\x2b\x03\0\x1a")?);
    Ok(())
}

/// A function of the host is called by its name, which has the prefix of the model, from the code and from the table.
#[test]
fn imported_functions_are_called_by_their_names() -> Result<()> {
    let wasm = [
        BEGIN.to_vec(),
        section(1, &[NOTHING, b"\x60\x01\x7c\x01\x7c"]),
        section(2, &[b"\x03env\x04tell\0\x01"]),
        section(3, &[b"\0"]),
        section(4, &[b"\x70\0\x03"]),
        section(7, &[b"\x01a\0\x01"]),
        section(9, &[b"\0\x41\x01\x0b\x02\0\x01"]),
        section(10, &[&body(&[&[0x44][..], &0.5f64.to_le_bytes(), b"\x10\0\x1a"].concat())]),
    ]
    .concat();
    let files = translate(&wasm, "Servo", &["a"])?;
    for line in ["#define tell Servo_tell", "f64 tell(Module*,f64);", "#define wasm_a w1"] {
        assert!(files["code.h"].lines().any(|other| other == line), "{line} is not in\n{}", files["code.h"]);
    }
    assert!(files["code_1.c"].contains("tell(s,0.5)"), "{}", files["code_1.c"]);
    let table = "table[3]={\n{0u,0},\n{1u,(Function)tell},\n{0u,(Function)w1},\n};";
    assert!(files["code_data.c"].contains(table), "{}", files["code_data.c"]);
    assert!(files["code_data.c"].contains("if(place<3u&&"), "{}", files["code_data.c"]);
    Ok(())
}

#[test]
fn what_is_not_translated_is_refused() {
    let plain = [BEGIN.to_vec(), section(1, &[NOTHING])].concat();
    for (further, expected) in [
        (section(2, &[b"\x03env\x05speed\x03\x7f\0"]), "speed is no function"),
        (section(4, &[b"\x70\0\x01", b"\x70\0\x01"]), "there is more than one table"),
        (section(5, &[b"\0\x01", b"\0\x01"]), "there is more than one memory"),
        (section(5, &[b"\x03\x01\x02"]), "the memory is no plain one of 32 bits"),
        (section(5, &[b"\x04\x01"]), "the memory is no plain one of 32 bits"),
        (section(6, &[b"\x7e\0\x42\x01\x0b"]), "I64Const { value: 1 } is no constant of 32 bits"),
        (b"\x08\x01\0".to_vec(), "a module that starts by itself is not translated"),
        (section(9, &[b"\x01\0\x01\0"]), "a segment of the table is not written at the start"),
        (section(11, &[b"\x01\x01\x05"]), "a segment of the memory is not written at the start"),
    ] {
        let problem = translate(&[plain.clone(), further].concat(), "Servo", &[]).err().map(|error| error.to_string());
        assert_eq!(problem.as_deref(), Some(expected));
    }
    assert!(translate(&plain, "Servo", &[]).is_ok());
    let exporting = |export: &[u8], root| {
        let wasm = [plain.clone(), section(7, &[export])].concat();
        translate(&wasm, "Servo", &[root]).err().map(|error| error.to_string())
    };
    assert_eq!(exporting(b"\x01a\0\x05", "a").as_deref(), Some("there is no function 5"));
    assert_eq!(exporting(b"\x01m\x02\0", "m").as_deref(), Some("the module exports no m"), "a memory of that name");
}
