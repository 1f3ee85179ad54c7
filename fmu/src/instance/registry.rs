//! The models of a shared library by GUID.

use std::ptr;
use std::sync::{Arc, Mutex, PoisonError};

use super::guid::{guid_of_source, guid_start};
use super::layout::Layout;
use crate::unload;
use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{forget, forget_tables};

/// The models that a shared library serves; [`export_fmu!`](crate::export_fmu) makes it.
pub struct Library {
    models: fn() -> &'static [Model],
    source: Option<&'static str>,
}

/// The layout of a model, made at the first instantiation of the model, with the address of the library that serves it.
struct Kept {
    library: usize,
    layout: Arc<Layout>,
}

static KEPT: Mutex<Vec<Kept>> = Mutex::new(Vec::new());

/// Frees tables that no instance holds: otherwise each unloading of the shared library would leak them.
extern "C" fn forget_all() {
    forget(&KEPT);
    forget_tables();
}

impl Library {
    /// A library of models from a source with a fingerprint, if they are not the models of [`pneumatic_servo`].
    ///
    /// `models` are checked; `list` gives the same again when they are used. A `static` that held them itself would copy
    /// the models of another crate, whose code would be compiled once more.
    ///
    /// # Panics
    /// Without a model, and when a name is no identifier of C, or two models share it: in a `static`, when it is compiled.
    pub const fn new(models: &'static [Model], list: fn() -> &'static [Model], source: Option<&'static str>) -> Self {
        assert!(!models.is_empty(), "a library of FMUs needs a model");
        let mut index = 0;
        while index < models.len() {
            let name = models[index].name;
            if !is_identifier(name.as_bytes()) {
                panic!("the name of a model must be an identifier of C: letters, digits, `_`, no digit first");
            }
            let mut other = 0;
            while other < index {
                if is_same(name.as_bytes(), models[other].name.as_bytes()) {
                    panic!("two models of a library have the same name");
                }
                other += 1;
            }
            index += 1;
        }
        Self { models: list, source }
    }

    /// The models.
    pub fn models(&self) -> &'static [Model] {
        (self.models)()
    }

    /// The layout of the model with a GUID. Only the table of this model is made.
    pub(super) fn find(&self, guid: &str) -> Option<Arc<Layout>> {
        let library = ptr::from_ref(self).addr();
        let mut all = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kept) = all.iter().find(|kept| kept.library == library && kept.layout.guid == guid) {
            return Some(Arc::clone(&kept.layout));
        }
        let model = self.models().iter().find(|model| guid.starts_with(&guid_start(model, self.source)))?;
        let layout = Arc::new(Layout::new(model, self.source));
        if layout.guid != guid {
            return None;
        }
        if all.is_empty() {
            unload::call(forget_all);
        }
        all.push(Kept { library, layout: Arc::clone(&layout) });
        Some(layout)
    }

    /// The layout of the model of a name.
    pub(super) fn of_name(&self, name: &str) -> Option<Arc<Layout>> {
        let model = self.models().iter().find(|model| model.name == name)?;
        self.find(&guid_of_source(model, self.source))
    }

    /// Names and GUIDs of all models, for messages.
    pub(super) fn list(&self) -> String {
        let entry = |model: &Model| format!("{} {}", model.name, guid_of_source(model, self.source));
        self.models().iter().map(entry).collect::<Vec<_>>().join(", ")
    }
}

/// The model of a name among some; a name that none has does not compile.
#[cfg(any(test, all(feature = "module", target_family = "wasm")))]
pub const fn only(models: &[Model], name: &str) -> Model {
    let mut place = 0;
    while place < models.len() {
        if is_same(models[place].name.as_bytes(), name.as_bytes()) {
            return models[place];
        }
        place += 1;
    }
    panic!("the sources are to be of a model that the library does not have")
}

const fn is_identifier(name: &[u8]) -> bool {
    let mut index = 0;
    while index < name.len() {
        if !(name[index].is_ascii_alphabetic() || name[index] == b'_' || index > 0 && name[index].is_ascii_digit()) {
            return false;
        }
        index += 1;
    }
    !name.is_empty()
}

const fn is_same(one: &[u8], other: &[u8]) -> bool {
    let mut index = 0;
    while index < one.len() && index < other.len() && one[index] == other[index] {
        index += 1;
    }
    index == one.len() && index == other.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::testing;

    const fn named(name: &'static str) -> Model {
        Model { name, ..testing::MODEL }
    }

    #[test]
    fn names_must_be_identifiers_and_different() {
        // Names may begin as others, whichever comes first.
        static GOOD: [Model; 4] = [named("A_1"), named("A"), named("A_1b"), named("_b")];
        assert_eq!(Library::new(&GOOD, || &GOOD, None).models().len(), 4);
        static BAD: [[Model; 2]; 6] = [
            [named("A"), named("A")],
            [named("A"), named("")],
            [named("1A"), named("A")],
            [named("A"), named("A b")],
            [named("A-b"), named("A")],
            [named("Ä"), named("A")],
        ];
        for models in &BAD {
            let names = models.each_ref().map(|model| model.name);
            assert!(
                std::panic::catch_unwind(|| Library::new(models, || &[], None).models().len()).is_err(),
                "{names:?}"
            );
        }
        assert!(std::panic::catch_unwind(|| Library::new(&[], || &[], None).models().len()).is_err());
    }

    #[test]
    fn a_model_is_found_by_its_name() {
        const MODELS: [Model; 3] = [named("A_1"), named("A"), named("B")];
        const FOUND: [Model; 3] = [only(&MODELS, "A"), only(&MODELS, "A_1"), only(&MODELS, "B")];
        assert_eq!(FOUND.map(|model| model.name), ["A", "A_1", "B"]);
        assert!(std::panic::catch_unwind(|| only(&MODELS, "A_")).is_err());
    }

    #[test]
    fn a_model_is_found_by_the_guid_of_its_source_only() {
        static MODELS: [Model; 2] = [named("A"), named("B")];
        static LIBRARY: Library = Library::new(&MODELS, || &MODELS, Some("0123"));
        for model in &MODELS {
            let own = crate::guid_of_source(model, Some("0123"));
            assert_eq!(LIBRARY.find(&own).expect("a layout").model.name, model.name);
            for other in [crate::guid(model), crate::guid_of_source(model, Some("0124"))] {
                assert!(LIBRARY.find(&other).is_none());
            }
        }
    }
}
