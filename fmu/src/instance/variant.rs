//! The variant of a model in the `resources` of an FMU: a configured FMU has its values there.

use std::borrow::Cow;
use std::ffi::CStr;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::PathBuf;
use std::sync::Arc;

use pneumatic_servo_variant::{FILE, LIMIT, Variant, guid};

use super::layout::Layout;
use super::registry::Library;
use crate::failure::Failure;

/// Where a host says that the resources are.
#[derive(Clone, Copy)]
pub enum Resources<'a> {
    /// By a URI, as in FMI 2.0; hosts also give paths.
    Uri(&'a CStr),
    /// By the path of the folder, as in FMI 3.0.
    Path(&'a CStr),
}

impl Resources<'_> {
    /// The folder; nothing where the text names none of this machine.
    fn folder(self) -> Option<PathBuf> {
        let path = match self {
            Self::Path(path) => Cow::Borrowed(path.to_bytes()),
            Self::Uri(uri) => match uri.to_bytes().strip_prefix(b"file:") {
                Some(rest) => Cow::Owned(decoded(local(rest))),
                None => Cow::Borrowed(uri.to_bytes()),
            },
        };
        (!path.is_empty()).then(|| native(&path)).flatten()
    }

    /// The file of a variant; nothing where there is none.
    fn read(self) -> Result<Option<Vec<u8>>, Failure> {
        let Some(path) = self.folder().map(|folder| folder.join(FILE)) else { return Ok(None) };
        if !path.is_file() {
            return Ok(None);
        }
        let mut bytes = Vec::new();
        let read = File::open(&path).and_then(|file| file.take(LIMIT as u64 + 1).read_to_end(&mut bytes));
        match read {
            Ok(_) => Ok(Some(bytes)),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Failure::error(format!("{} cannot be read: {error}", path.display()))),
        }
    }
}

/// The path in a URI behind its scheme: without authority, and without the slash before a drive.
fn local(rest: &[u8]) -> &[u8] {
    let path = match rest.strip_prefix(b"//") {
        Some(rest) => &rest[rest.iter().position(|byte| *byte == b'/').unwrap_or(rest.len())..],
        None => rest,
    };
    match path {
        [b'/', drive, b':', ..] if drive.is_ascii_alphabetic() => &path[1..],
        _ => path,
    }
}

/// The bytes that percent signs stand for.
fn decoded(text: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text;
    while let [first, others @ ..] = rest {
        let digit = |at: usize| others.get(at).and_then(|digit| char::from(*digit).to_digit(16));
        match (first, digit(0), digit(1)) {
            (b'%', Some(high), Some(low)) => {
                bytes.push((16 * high + low) as u8);
                rest = &others[2..];
            }
            _ => {
                bytes.push(*first);
                rest = others;
            }
        }
    }
    bytes
}

#[cfg(unix)]
fn native(path: &[u8]) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStrExt;
    Some(std::ffi::OsStr::from_bytes(path).into())
}

#[cfg(not(unix))]
fn native(path: &[u8]) -> Option<PathBuf> {
    str::from_utf8(path).ok().map(Into::into)
}

/// The layout for a GUID: of a model, or of the variant in the resources.
///
/// A file that does not belong to the GUID is refused, whether it is damaged or of another FMU.
pub fn layout(
    library: &'static Library,
    called: &str,
    wanted: &str,
    resources: Option<Resources>,
) -> Result<Arc<Layout>, Failure> {
    let Some(bytes) = resources.map_or(Ok(None), Resources::read)? else {
        return library.find(wanted).ok_or_else(|| {
            let list = library.list();
            let hint = "modelDescription.xml and the library come from different builds, or the resources of a \
                        configured FMU are not where the importer says";
            Failure::error(format!("the {called} {wanted} belongs to no model of this library ({list}): {hint}"))
        });
    };
    let refused = |reason: String| Failure::error(format!("resources/{FILE} is refused: {reason}"));
    let variant = Variant::read(&bytes).map_err(refused)?;
    let Some(base) = library.of_name(&variant.model) else {
        return Err(refused(format!("this library has no model {}", variant.model)));
    };
    if guid(&base.guid, &bytes) != wanted {
        let Variant { name, model, .. } = &variant;
        return Err(refused(format!(
            "{name}, a variant of {model}, does not have the {called} {wanted}: the file is damaged, or the file, \
             modelDescription.xml and the library come from different FMUs"
        )));
    }
    let resolved = variant.resolve(&base.table).map_err(refused)?;
    Ok(Arc::new(base.varied(wanted.to_owned(), variant.name, resolved)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folder_is_found_in_all_forms_that_hosts_use() {
        let folder = |uri: &CStr| Resources::Uri(uri).folder();
        for (uri, path) in [
            (c"file:/tmp/resources", "/tmp/resources"),
            (c"file:///tmp/a%20b%25/%7Ec", "/tmp/a b%/~c"),
            (c"file://localhost/tmp/resources/", "/tmp/resources/"),
            (c"file:///C:/a%20b", "C:/a b"),
            (c"file:relative", "relative"),
            (c"/tmp/a%20b", "/tmp/a%20b"),
            (c"file:///a%2", "/a%2"),
            (c"file:///a%zz%", "/a%zz%"),
        ] {
            assert_eq!(folder(uri), Some(path.into()), "{uri:?}");
        }
        assert_eq!([folder(c""), folder(c"file://host"), folder(c"file:")], [None, None, None]);
        assert_eq!(Resources::Path(c"/tmp/a%20b").folder(), Some("/tmp/a%20b".into()));
    }
}
