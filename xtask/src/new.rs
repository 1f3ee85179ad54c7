//! `cargo xtask new`: crates of your own, to begin with. What they hold is in the repository already, where tests compile and run
//! it: laws in `examples/own/law`, a valve and a model in `docs/own-model.md`.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, bail, ensure};
use lexopt::Arg::{Long, Short, Value};
use lexopt::{Parser, ValueExt};
use pneumatic_servo::models::{self, pneumatic_servo_cylinder};
use pneumatic_servo::variables::Kind as Of;
use pneumatic_servo_packaging::{commands, files, workspace};

const HELP: &str = "\
Begin a crate of your own, which runs, is tested and packs FMUs; docs/own.md tells the rest.

Usage: cargo xtask new law NAME FOLDER [--kind velocity|set-valued|bristle|full]
       cargo xtask new valve NAME FOLDER
       cargo xtask new model NAME FOLDER

  velocity      a law that is a function of velocity (if no kind is named)
  set-valued    a break-away force and a curve for sliding
  bristle       one state, the deflection of a bristle
  full          any other law, here one with two states

Example:
  cargo xtask new law QuadraticDrag ../quadratic-drag    then `cargo test` in that folder";

/// Kind of crate to begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A law that is a function of velocity.
    Velocity,
    /// A law with a break-away force.
    SetValued,
    /// A law of one bristle.
    Bristle,
    /// Any other law.
    Full,
    /// An actuator of the cylinder.
    Valve,
    /// A model.
    Model,
}

/// A crate that is to be begun.
#[derive(Debug, PartialEq)]
struct New {
    kind: Kind,
    name: String,
    folder: PathBuf,
}

/// Begins a crate as a command line says.
pub fn run(words: &[OsString]) -> ExitCode {
    match New::read(words) {
        Ok(None) => {
            println!("{HELP}");
            ExitCode::SUCCESS
        }
        Ok(Some(new)) => commands::ended(new.begin(&workspace::home())),
        Err(problem) => commands::misspelt(&problem, "cargo xtask new --help"),
    }
}

impl New {
    /// Reads a command line; nothing where the help is asked for.
    fn read(words: &[OsString]) -> Result<Option<Self>> {
        let mut parser = Parser::from_args(words);
        let (mut values, mut kind) = (Vec::new(), None);
        while let Some(argument) = parser.next()? {
            match argument {
                Short('h') | Long("help") => return Ok(None),
                Long("kind") => kind = Some(parser.value()?.string()?),
                Value(value) => values.push(value.string()?),
                other => return Err(other.unexpected().into()),
            }
        }
        let [what, name, folder] = <[String; 3]>::try_from(values)
            .map_err(|values| anyhow::anyhow!("what, a name and a folder are asked for, not {values:?}"))?;
        let kind = match (&*what, kind.as_deref()) {
            ("law", None | Some("velocity")) => Kind::Velocity,
            ("law", Some("set-valued")) => Kind::SetValued,
            ("law", Some("bristle")) => Kind::Bristle,
            ("law", Some("full")) => Kind::Full,
            ("law", Some(other)) => bail!("there is no kind `{other}` of laws"),
            ("valve", None) => Kind::Valve,
            ("model", None) => Kind::Model,
            ("valve" | "model", Some(_)) => bail!("--kind is for laws"),
            _ => bail!("`{what}` is neither law nor valve nor model"),
        };
        Ok(Some(Self { kind, name, folder: folder.into() }))
    }

    fn begin(&self, home: &Path) -> Result<()> {
        for file in write(self.kind, &self.name, &self.folder, home)? {
            println!("{}", file.display());
        }
        println!("\nNow: cd {} && cargo test && cargo run --example run", self.folder.display());
        Ok(())
    }
}

/// A crate of each kind below a folder, as members of one workspace.
///
/// # Errors
/// When a file cannot be read or written.
pub fn write_all(folder: &Path, home: &Path) -> Result<()> {
    let all = [
        (Kind::Velocity, "BegunVelocity"),
        (Kind::SetValued, "BegunSetValued"),
        (Kind::Bristle, "BegunBristle"),
        (Kind::Full, "BegunFull"),
        (Kind::Valve, "BegunValve"),
        (Kind::Model, "BegunModel"),
    ];
    for (kind, name) in all {
        let member = folder.join(name);
        write(kind, name, &member, home)?;
        let manifest = member.join("Cargo.toml");
        let own = files::text(&manifest)?.replace("[workspace]\n\n", "");
        files::write(&manifest, own.split("\n[profile").next().unwrap_or_default())?;
    }
    files::write(
        &folder.join("Cargo.toml"),
        "[workspace]\nmembers = [\"*\"]\nexclude = [\"target\"]\nresolver = \"3\"\n",
    )
}

/// Writes a crate whose dependencies are in a clone of the repository, and says which files it has.
///
/// # Errors
/// When the name would not compile, the folder is there already, or a file cannot be read or written.
fn write(kind: Kind, name: &str, folder: &Path, home: &Path) -> Result<Vec<PathBuf>> {
    ensure_free(kind, name, home)?;
    ensure!(!folder.exists(), "{} is there already", folder.display());
    let snake = words(name).join("_");
    let path = |part: &str| {
        let path = home.join(part);
        Ok::<_, anyhow::Error>(format!(
            "{:?}",
            path.to_str().with_context(|| format!("{} is no text", path.display()))?
        ))
    };
    let places = [
        ("@Name@", name.to_owned()),
        ("@group@", group(name)),
        ("@crate_name@", format!("own_{snake}")),
        ("@crate@", format!("own-{}", words(name).join("-"))),
        ("@plant@", path("")?),
        ("@fmu@", path("fmu")?),
        ("@packaging@", path("packaging")?),
    ];
    let fill = |text: &str| places.iter().fold(text.to_owned(), |text, (place, value)| text.replace(place, value));
    let mut written = Vec::new();
    for (file, text) in sources(kind, home)?.into_iter().chain(around(kind)) {
        let file = folder.join(file);
        files::write(&file, fill(&text))?;
        written.push(file);
    }
    Ok(written)
}

/// The source of a crate, with places for the name.
fn sources(kind: Kind, home: &Path) -> Result<Vec<(&'static str, String)>> {
    let law = |file: &str, name: &str, of: &str| {
        let text = files::text(home.join("examples/own/law/src").join(file))?;
        let text = text.replace(name, "@Name@").replace(&group(name), "@group@");
        Ok(vec![("src/lib.rs", CATALOGUE.replace("@Of@", of)), ("src/law.rs", text)])
    };
    match kind {
        Kind::Velocity => law("rooted_coulomb.rs", "RootedCoulomb", "OfVelocity<law::@Name@>"),
        Kind::SetValued => law("hyperbolic_stribeck.rs", "HyperbolicStribeck", "StickSlip<law::@Name@>"),
        Kind::Bristle => law("loaded_dahl.rs", "LoadedDahl", "OneBristle<law::@Name@>"),
        Kind::Full => law("two_bristles.rs", "TwoBristles", "law::@Name@"),
        Kind::Valve => {
            of_page(home, "LaggedSpool", "//! An actuator of your own: the cylinder has it beside the library's.")
        }
        Kind::Model => of_page(home, "Room", "//! A model of your own."),
    }
}

/// The program of `docs/own-model.md` that is about a type, without its `main`.
fn of_page(home: &Path, name: &str, comment: &str) -> Result<Vec<(&'static str, String)>> {
    let page = files::text(home.join("docs/own-model.md"))?;
    let programs =
        page.split("```rust\n").skip(1).filter_map(|rest| rest.split_once("```")).map(|(program, _)| program);
    let program = programs.filter_map(|program| program.split_once("\nfn main()")).find(|(it, _)| it.contains(name));
    let (program, _) = program.with_context(|| format!("docs/own-model.md has no program about {name}"))?;
    let program = program.replace(name, "@Name@").replace(&group(name), "@group@").replace("pub static", "pub const");
    let models = if program.contains("const CYLINDER") { "CYLINDER" } else { "MODEL" };
    Ok(vec![("src/lib.rs", format!("{comment}\n\n{program}\npneumatic_servo_fmu::export_fmu!(&[{models}]);\n"))])
}

/// All that is beside the source.
fn around(kind: Kind) -> Vec<(&'static str, String)> {
    let (what, title, test, run) = match kind {
        Kind::Valve => ("An actuator of your own in the cylinder", "actuator", VALVE_TEST, VALVE_RUN),
        Kind::Model => ("A model of your own", "model", MODEL_TEST, MODEL_RUN),
        _ => ("A friction law of your own in the cylinder and the friction bench", "law", LAW_TEST, LAW_RUN),
    };
    let manifest = MANIFEST.replace("@what@", what);
    let readme = README.replace("@what@", what).replace("@title@", title);
    vec![
        ("Cargo.toml", manifest),
        ("README.md", readme),
        (".gitignore", "/target\n".to_owned()),
        ("tests/promises.rs", test.to_owned()),
        ("examples/run.rs", run.to_owned()),
        ("examples/package.rs", PACKAGE.to_owned()),
    ]
}

const MANIFEST: &str = include_str!("../templates/Cargo.toml.in");
const README: &str = include_str!("../templates/README.md.in");
const PACKAGE: &str = include_str!("../templates/package.rs.in");
const CATALOGUE: &str = include_str!("../templates/law/lib.rs.in");
const LAW_TEST: &str = include_str!("../templates/law/promises.rs.in");
const LAW_RUN: &str = include_str!("../templates/law/run.rs.in");
const VALVE_TEST: &str = include_str!("../templates/valve/promises.rs.in");
const VALVE_RUN: &str = include_str!("../templates/valve/run.rs.in");
const MODEL_TEST: &str = include_str!("../templates/model/promises.rs.in");
const MODEL_RUN: &str = include_str!("../templates/model/run.rs.in");

/// Refuses a name that would not compile, or that something of the library has.
fn ensure_free(kind: Kind, name: &str, home: &Path) -> Result<()> {
    let letters =
        name.starts_with(|first: char| first.is_ascii_uppercase()) && name.chars().all(|it| it.is_ascii_alphanumeric());
    ensure!(letters, "`{name}` is no name of a type: it begins with a capital letter, and letters and digits follow");
    ensure!(!STANDARD.contains(&name), "`{name}` is a name of Rust; the crate would not compile");
    let texts = [vec![("", files::text(home.join("src/prelude.rs"))?)], sources(kind, home)?].concat();
    let is_used = texts.iter().any(|(_, text)| names(text).contains(name));
    ensure!(!is_used, "`{name}` means something else in the crate: its source or the prelude of the library has it");
    ensure!(models::find(name).is_none(), "`{name}` is a model of the library");
    let table = pneumatic_servo_cylinder::MODEL.table();
    for choice in table.parameters() {
        if let Of::Enumeration(of) = choice.kind {
            let is_taken = of.items.iter().any(|(_, item, _)| *item == name);
            ensure!(!is_taken, "`{name}` is in the library: {} has it", choice.name);
        }
    }
    let group = group(name);
    let [of_law, of_valve] = [format!("friction.{group}."), format!("{group}.")];
    let twin = table.iter().find(|it| it.name.starts_with(&of_law) || it.name.starts_with(&of_valve));
    match twin {
        Some(twin) => bail!("`{name}` would have its variables in the group of {}", twin.name),
        None => Ok(()),
    }
}

/// Names that Rust knows without a `use`, and its keyword among the names of types.
const STANDARD: [&str; 30] = [
    "Self", "Option", "Some", "None", "Result", "Ok", "Err", "Vec", "String", "Box", "Copy", "Send", "Sized", "Sync",
    "Unpin", "Drop", "Fn", "FnMut", "FnOnce", "AsMut", "AsRef", "From", "Into", "Default", "Iterator", "Clone",
    "ToOwned", "ToString", "Debug", "Extend",
];

/// The names with a capital letter in a source, without its comments.
fn names(text: &str) -> BTreeSet<&str> {
    let code = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    let words = code.flat_map(|line| line.split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_'));
    words.filter(|word| word.starts_with(|first: char| first.is_ascii_uppercase())).collect()
}

/// The group of the parameters: `quadraticDrag`.
fn group(name: &str) -> String {
    format!("{}{}", name[..1].to_lowercase(), &name[1..])
}

/// The words of a name in capitals: `quadratic`, `drag`.
fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = ' ';
    for letter in name.chars() {
        if words.is_empty() || letter.is_ascii_uppercase() && !before.is_ascii_uppercase() {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut() {
            word.push(letter.to_ascii_lowercase());
        }
        before = letter;
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(line: &str) -> Result<Option<New>> {
        New::read(&line.split(' ').map(OsString::from).collect::<Vec<_>>())
    }

    #[test]
    fn a_command_line_says_what_is_begun() -> Result<()> {
        let new = |kind, name: &str| Some(New { kind, name: name.to_owned(), folder: "drag".into() });
        assert_eq!(read("law Drag drag")?, new(Kind::Velocity, "Drag"));
        assert_eq!(read("law Drag drag --kind set-valued")?, new(Kind::SetValued, "Drag"));
        assert_eq!(read("--kind=full law Drag drag")?, new(Kind::Full, "Drag"));
        assert_eq!(read("valve Spool drag")?, new(Kind::Valve, "Spool"));
        assert_eq!(read("law --help")?, None);
        for (line, expected) in [
            ("law Drag", "a folder"),
            ("law Drag drag --kind sticky", "`sticky`"),
            ("model Room drag --kind full", "--kind is for laws"),
            ("pump Drag drag", "`pump` is neither"),
            ("law Drag drag --fast", "--fast"),
        ] {
            let problem = read(line).map_or_else(|problem| format!("{problem:#}"), |_| String::new());
            assert!(problem.contains(expected), "{line}: {problem}");
        }
        Ok(())
    }

    #[test]
    fn names_are_taken_apart_where_capitals_begin() {
        assert_eq!(words("QuadraticDrag").join("_"), "quadratic_drag");
        assert_eq!(words("LuGre2").join("-"), "lu-gre2");
        assert_eq!(words("GMS"), ["gms"]);
    }

    #[test]
    fn a_crate_is_written_once_with_its_name_everywhere() -> Result<()> {
        let folder = std::env::temp_dir().join(format!("new-{}", std::process::id()));
        let home = workspace::home();
        write_all(&folder, &home)?;
        let read = |name: &str| files::text(folder.join(name));
        assert!(read("BegunFull/src/lib.rs")?.contains("1000 BegunFull \"begunFull\" law::BegunFull,"));
        assert!(read("BegunBristle/src/law.rs")?.contains("impl BristleLaw for BegunBristle"));
        assert!(read("BegunValve/src/lib.rs")?.contains("impl Actuating for BegunValve"));
        assert!(read("BegunModel/tests/promises.rs")?.contains("use own_begun_model::MODEL;"));
        assert!(
            read("BegunModel/Cargo.toml")?.contains(&format!("packaging = {{ path = {:?}", home.join("packaging")))
        );
        for file in ["README.md", ".gitignore", "examples/run.rs", "examples/package.rs"] {
            assert!(!read(&format!("BegunVelocity/{file}"))?.contains('@'), "{file}");
        }
        let again = write(Kind::Model, "BegunModel", &folder.join("BegunModel"), &home);
        assert!(again.is_err_and(|error| error.to_string().contains("is there already")));
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// Refused names: no identifiers, or used by Rust, by the crate's source, or by the library.
    #[test]
    fn names_that_do_not_compile_are_refused() -> Result<()> {
        let home = workspace::home();
        for name in ["", "drag", "My Law", "Drag-2", "Größe", "Self", "Option", "Friction", "Model", "LuGre", "Gms"] {
            for kind in [Kind::Velocity, Kind::SetValued, Kind::Bristle, Kind::Full] {
                assert!(write(kind, name, Path::new("nowhere"), &home).is_err(), "{name}");
            }
        }
        for (kind, name) in [
            (Kind::Valve, "Inflow"),
            (Kind::Valve, "ProportionalValve"),
            (Kind::Valve, "Valve"),
            (Kind::Model, "State"),
            (Kind::Model, "Festoon"),
            (Kind::Model, "Model"),
        ] {
            assert!(write(kind, name, Path::new("nowhere"), &home).is_err(), "{name}");
        }
        let prelude = files::text(home.join("src/prelude.rs"))?;
        assert!(names(&prelude).len() > 30);
        for name in names(&prelude) {
            assert!(ensure_free(Kind::Velocity, name, &home).is_err(), "{name}");
        }
        assert!(ensure_free(Kind::Velocity, "QuadraticDrag", &home).is_ok());
        Ok(())
    }
}
