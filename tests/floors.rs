//! The rooms of the library stand on floors: each uses those below it, and none above.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// From the ground up.
const FLOORS: [&str; 16] = [
    "numbers",
    "variables",
    "hybrid",
    "solver",
    "friction",
    "pneumatics",
    "mechanics",
    "sensor",
    "system",
    "session",
    "sensitivity",
    "model_exchange",
    "co_simulation",
    "model",
    "models",
    "conformance",
];

/// The room that stands over all and lets strangers in, and the library itself.
const ABOVE: [&str; 2] = ["prelude", "lib"];

fn floor(room: &str) -> Option<usize> {
    FLOORS.iter().position(|other| *other == room)
}

/// All files of a room, a folder or a file.
fn texts(path: &Path, found: &mut Vec<(String, String)>) {
    if path.is_file() {
        found.push((path.display().to_string(), fs::read_to_string(path).unwrap()));
        return;
    }
    fs::read_dir(path).unwrap().for_each(|entry| texts(&entry.unwrap().path(), found));
}

/// The rooms that a line names; what is said in comments is no use.
fn used(line: &str) -> impl Iterator<Item = usize> {
    let code = line.split("//").next().unwrap_or_default();
    let rooms = code.split("crate::").skip(1);
    rooms.filter_map(|rest| floor(rest.split(|c: char| !c.is_ascii_lowercase() && c != '_').next()?))
}

#[test]
fn no_room_uses_one_above_it() {
    let mut rooms = BTreeSet::new();
    let (mut uses, mut upwards) = (0, Vec::new());
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).unwrap() {
        let path = entry.unwrap().path();
        let room = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if ABOVE.contains(&&*room) {
            continue;
        }
        let own = floor(&room).unwrap_or_else(|| panic!("{room} has no floor"));
        rooms.insert(room);
        let mut files = Vec::new();
        texts(&path, &mut files);
        for (file, text) in files {
            // Tests at the end of a file may use everything.
            let code = text.split("#[cfg(test)]\nmod tests").next().unwrap();
            for (number, line) in code.lines().enumerate() {
                uses += used(line).count();
                upwards.extend(
                    used(line)
                        .filter(|other| *other > own)
                        .map(|other| format!("{file}:{}: uses {}, which stands above", number + 1, FLOORS[other])),
                );
            }
        }
    }
    assert_eq!(rooms.len(), FLOORS.len(), "{rooms:?}");
    assert!(uses > 400, "{uses} uses seen");
    assert!(upwards.is_empty(), "{}", upwards.join("\n"));
}
