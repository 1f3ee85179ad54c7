//! Enumerations, each stated once: the table, the Rust type and the reading of values come from one declaration.

/// An enumeration type; the ids are part of the interface and never reused.
#[derive(Debug, PartialEq)]
pub struct Enumeration {
    /// Type name, different from every variable name.
    pub name: &'static str,
    /// Description of the choice.
    pub description: &'static str,
    /// Id, name and description of each item.
    pub items: &'static [(i32, &'static str, &'static str)],
}

impl Enumeration {
    /// The id of an item.
    pub fn id(&self, name: &str) -> Option<i32> {
        self.items.iter().find(|(_, item, _)| *item == name).map(|(id, ..)| *id)
    }

    /// Whether a number is the id of an item.
    pub fn has(&self, id: f64) -> bool {
        self.items.iter().any(|(known, ..)| f64::from(*known) == id)
    }
}

/// An item of an [`Enumeration`], as a Rust type that [`enumeration!`](crate::enumeration) declares.
pub trait Choice: Copy + Sized + 'static {
    /// The enumeration.
    const ENUMERATION: &'static Enumeration;

    /// The id of the item.
    fn id(self) -> i32;

    /// The item of an id, if there is one.
    fn from_id(id: f64) -> Option<Self>;
}

/// Declares an enumeration: `Type: "description" { id Item: "description"; ... }`.
///
/// The type gets an enum with these items, [`Choice`](crate::variables::Choice) with the table of ids, names and
/// descriptions, and [`Field`](crate::variables::Field) for structs of parameters.
#[macro_export]
macro_rules! enumeration {
    ($(#[$doc:meta])* $type:ident $name:literal: $description:literal { $($id:literal $item:ident: $text:literal;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(clippy::upper_case_acronyms, reason = "items are named as the interface names them")]
        pub enum $type {
            $(#[doc = $text] $item = $id),*
        }

        impl $crate::variables::Choice for $type {
            const ENUMERATION: &'static $crate::variables::Enumeration = &$crate::variables::Enumeration {
                name: $name,
                description: $description,
                items: &[$(($id, stringify!($item), $text)),*],
            };

            fn id(self) -> i32 {
                self as i32
            }

            fn from_id(id: f64) -> Option<Self> {
                [$(Self::$item),*].into_iter().find(|item| f64::from(*item as i32) == id)
            }
        }

        impl $crate::variables::Field for $type {
            type Value = Self;
            const LEN: usize = 1;
            fn read(values: &[$crate::variables::Tunable]) -> Option<Self> {
                <Self as $crate::variables::Choice>::from_id(values[0].value)
            }
        }
    };
}

/// Refuses lines of a user's catalogue with ids of the library; malformed lines are left to the macro that reads them.
#[doc(hidden)]
#[macro_export]
macro_rules! own_ids {
    ($($id:literal $item:ident $($group:literal)? $type:ty, $summary:literal;)*) => {
        $(
            const _: () = assert!(
                $id >= 1000,
                concat!("the id ", $id, " of ", stringify!($item), " is the library's: your own begin at 1000")
            );
        )*
    };
    ($($other:tt)*) => {};
}

#[cfg(test)]
mod tests {
    use super::*;

    enumeration! {
        /// A direction.
        Way "Way": "Where to go" {
            1 Left: "To the left";
            3 Right: "To the right";
        }
    }

    #[test]
    fn items_are_read_from_their_ids_and_from_nothing_else() {
        assert_eq!([1.0, 3.0].map(Way::from_id), [Some(Way::Left), Some(Way::Right)]);
        assert_eq!([0.0, 1.5, 2.0, -1.0, f64::NAN].map(Way::from_id), [None; 5]);
    }

    #[test]
    fn table_lists_ids_names_and_texts() {
        assert_eq!(Way::ENUMERATION.items, [(1, "Left", "To the left"), (3, "Right", "To the right")]);
        assert_eq!((Way::ENUMERATION.id("Right"), Way::ENUMERATION.id("Up")), (Some(Way::Right.id()), None));
    }
}
