//! The models of this library by GUID.

use std::sync::LazyLock;

use super::layout::Layout;
use pneumatic_servo::models;

/// Made at the first use and never changed.
static LAYOUTS: LazyLock<Vec<Layout>> = LazyLock::new(|| models::ALL.iter().map(Layout::new).collect());

/// The layout of the model with a GUID.
pub fn find(guid: &str) -> Option<&'static Layout> {
    LAYOUTS.iter().find(|layout| layout.guid == guid)
}

/// Names and GUIDs of all models, for messages.
pub fn list() -> String {
    let entries: Vec<_> = LAYOUTS.iter().map(|layout| format!("{} {}", layout.model.name, layout.guid)).collect();
    entries.join(", ")
}
