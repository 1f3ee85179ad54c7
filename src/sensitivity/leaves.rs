//! The numbers in a memory: where they are in its saved form, and the memory with others in their places.
//!
//! A memory says how it is saved, and nothing else of its inside. The saved form is that of postcard: a number takes eight
//! bytes, an enumeration the index of its variant, a sequence its length and its items. [`Walk`] goes through a memory as
//! postcard does; [`Finder`] notes where the numbers are, [`Reader`] what they are. All else (modes, counts, lengths) is what
//! must not change where a derivative is taken.

use std::fmt;
use std::sync::Arc;

use serde::de::DeserializeOwned;
use serde::ser::{self, Serialize, Serializer};

use crate::system::side;

/// The saved form of a memory, and where its numbers are.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaves {
    bytes: Vec<u8>,
    places: Arc<[usize]>,
}

impl Leaves {
    /// Those of a memory.
    pub fn of<M: Serialize>(memory: &M) -> Self {
        let bytes = postcard::to_allocvec(memory).expect("a memory holds plain data");
        let mut finder = Finder::default();
        memory.serialize(Walk(&mut finder)).expect("a memory holds plain data");
        debug_assert_eq!(finder.length, bytes.len(), "the saved form is that of postcard");
        Self { bytes, places: finder.places.into() }
    }

    /// The same, faster if a memory is alike another one.
    pub fn like<M: Serialize>(memory: &M, other: &Self) -> Self {
        let mut bytes = vec![0; other.bytes.len()];
        let is_as_long = postcard::to_slice(memory, &mut bytes).is_ok_and(|used| used.len() == other.bytes.len());
        if is_as_long && other.fits(&bytes) { Self { bytes, places: other.places.clone() } } else { Self::of(memory) }
    }

    /// How many numbers there are.
    pub fn count(&self) -> usize {
        self.places.len()
    }

    /// A number.
    pub fn value(&self, leaf: usize) -> f64 {
        let place = self.places[leaf];
        let bytes = self.bytes[place..].first_chunk().expect("eight bytes of a number");
        f64::from_le_bytes(*bytes)
    }

    /// All numbers.
    pub fn values(&self) -> Vec<f64> {
        (0..self.count()).map(|leaf| self.value(leaf)).collect()
    }

    /// The same with other numbers.
    pub fn with(&self, value: impl Fn(usize) -> f64) -> Self {
        let mut moved = self.clone();
        for (leaf, place) in self.places.iter().enumerate() {
            moved.bytes[*place..place + size_of::<f64>()].copy_from_slice(&value(leaf).to_le_bytes());
        }
        moved
    }

    /// The memory; nothing if the numbers fit none.
    pub fn memory<M: DeserializeOwned>(&self) -> Option<M> {
        postcard::from_bytes(&self.bytes).ok()
    }

    /// Whether another memory differs in nothing but its numbers.
    pub fn is_alike(&self, other: &Self) -> bool {
        self.places == other.places && self.fits(&other.bytes)
    }

    /// Whether bytes differ in nothing but numbers: then they are those of a memory that has its numbers in the same places.
    fn fits(&self, bytes: &[u8]) -> bool {
        let mut start = 0;
        self.bytes.len() == bytes.len()
            && self.places.iter().chain([&bytes.len()]).all(|place| {
                let between = start..*place;
                start = place + size_of::<f64>();
                self.bytes[between.clone()] == bytes[between]
            })
    }
}

/// What a number of a memory is.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf {
    /// The names of the fields that lead to it, joined by dots.
    pub name: String,
    /// Whether it says a [side] and nothing else.
    pub is_side: bool,
}

/// What the numbers of a memory are, in their order.
pub fn told<M: Serialize>(memory: &M) -> Vec<Leaf> {
    let mut finder = Finder { told: Some(Vec::new()), ..Finder::default() };
    memory.serialize(Walk(&mut finder)).expect("a memory holds plain data");
    finder.told.unwrap_or_default()
}

/// Adds the numbers of a memory to others, and returns what all else in it is: the same for memories that are alike.
pub fn read<M: Serialize>(memory: &M, numbers: &mut Vec<f64>) -> u64 {
    let mut reader = Reader { numbers, form: 0 };
    memory.serialize(Walk(&mut reader)).expect("a memory holds plain data");
    reader.form
}

/// Who looks at what is in a memory.
trait Look {
    /// A number.
    fn number(&mut self, value: f64);
    /// A whole number without a sign, a length, or the index of a variant.
    fn whole(&mut self, value: u64);
    /// A larger one.
    fn wide(&mut self, value: u128);
    /// Bytes as they are.
    fn plain(&mut self, bytes: &[u8]);
    /// Whether what follows is a [side].
    fn mark(&mut self, _is_side: bool) {}
    /// What follows has a name.
    fn enter(&mut self, _name: &str) {}
    /// The end of that.
    fn leave(&mut self) {}
    /// Items follow.
    fn begin_items(&mut self) {}
    /// The next one, which is left by [`leave`](Self::leave).
    fn enter_item(&mut self) {}
    /// No more.
    fn end_items(&mut self) {}
}

/// Takes the numbers of a memory, and mixes all else.
struct Reader<'a> {
    numbers: &'a mut Vec<f64>,
    form: u64,
}

impl Look for Reader<'_> {
    #[inline(always)]
    fn number(&mut self, value: f64) {
        self.numbers.push(value);
        self.whole(1);
    }

    #[inline(always)]
    fn whole(&mut self, value: u64) {
        // As in the hash function of Firefox: all that differs must not look alike by chance.
        self.form = (self.form.rotate_left(5) ^ value).wrapping_mul(0x517c_c1b7_2722_0a95);
    }

    fn wide(&mut self, value: u128) {
        self.whole(value as u64);
        self.whole((value >> u64::BITS) as u64);
    }

    fn plain(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.whole((*byte).into()));
    }
}

/// Counts bytes as postcard writes them, and notes where the numbers are.
#[derive(Debug, Default)]
struct Finder {
    length: usize,
    places: Vec<usize>,
    /// The path to here.
    path: Vec<String>,
    /// What the numbers are, if that is asked for.
    told: Option<Vec<Leaf>>,
    /// Whether the next number is a side.
    is_side: bool,
    /// Number of the next item of the innermost sequences.
    items: Vec<usize>,
}

impl Look for Finder {
    fn number(&mut self, _value: f64) {
        self.places.push(self.length);
        self.length += size_of::<f64>();
        if let Some(told) = &mut self.told {
            told.push(Leaf { name: self.path.join(".").replace(".[", "["), is_side: self.is_side });
        }
        self.is_side = false;
    }

    /// In groups of seven bits.
    fn whole(&mut self, value: u64) {
        self.wide(value.into());
    }

    fn wide(&mut self, value: u128) {
        let bits = u128::BITS - value.leading_zeros();
        self.length += bits.div_ceil(7).max(1) as usize;
    }

    fn plain(&mut self, bytes: &[u8]) {
        self.length += bytes.len();
    }

    fn mark(&mut self, is_side: bool) {
        self.is_side = is_side;
    }

    fn enter(&mut self, name: &str) {
        if self.told.is_some() {
            self.path.push(name.to_owned());
        }
    }

    fn leave(&mut self) {
        self.path.pop();
    }

    fn begin_items(&mut self) {
        self.items.push(0);
    }

    fn enter_item(&mut self) {
        let number = self.items.last_mut().map_or(0, |next| {
            *next += 1;
            *next
        });
        if self.told.is_some() {
            self.path.push(format!("[{number}]"));
        }
    }

    fn end_items(&mut self) {
        self.items.pop();
    }
}

/// Goes through a memory as postcard does.
struct Walk<'a, L>(&'a mut L);

impl<L: Look> Walk<'_, L> {
    fn within<T: Serialize + ?Sized>(&mut self, name: &str, value: &T) -> Result<(), Never> {
        self.0.enter(name);
        value.serialize(Walk(self.0))?;
        self.0.leave();
        Ok(())
    }

    fn item<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Never> {
        self.0.enter_item();
        value.serialize(Walk(self.0))?;
        self.0.leave();
        Ok(())
    }
}

/// A memory that cannot be saved: there is none.
#[derive(Debug)]
struct Never(String);

impl fmt::Display for Never {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Never {}

impl ser::Error for Never {
    fn custom<T: fmt::Display>(text: T) -> Self {
        Self(text.to_string())
    }
}

macro_rules! whole_numbers {
    ($($name:ident $number:ty, |$value:ident| $how:ident($whole:expr);)*) => {$(
        fn $name(self, $value: $number) -> Result<(), Never> {
            self.0.$how($whole);
            Ok(())
        }
    )*};
}

/// A number with a sign, which postcard folds.
fn folded(value: i128) -> u128 {
    ((value << 1) ^ (value >> 127)) as u128
}

impl<'a, L: Look> Serializer for Walk<'a, L> {
    type Ok = ();
    type Error = Never;
    type SerializeSeq = Walk<'a, L>;
    type SerializeTuple = Walk<'a, L>;
    type SerializeTupleStruct = Walk<'a, L>;
    type SerializeTupleVariant = Walk<'a, L>;
    type SerializeMap = Walk<'a, L>;
    type SerializeStruct = Walk<'a, L>;
    type SerializeStructVariant = Walk<'a, L>;

    whole_numbers! {
        serialize_u16 u16, |value| whole(value.into());
        serialize_u32 u32, |value| whole(value.into());
        serialize_u64 u64, |value| whole(value);
        serialize_u128 u128, |value| wide(value);
        serialize_i16 i16, |value| wide(folded(value.into()));
        serialize_i32 i32, |value| wide(folded(value.into()));
        serialize_i64 i64, |value| wide(folded(value.into()));
        serialize_i128 i128, |value| wide(folded(value));
    }

    fn serialize_f64(self, value: f64) -> Result<(), Never> {
        self.0.number(value);
        Ok(())
    }

    fn serialize_f32(self, value: f32) -> Result<(), Never> {
        self.0.plain(&value.to_le_bytes());
        Ok(())
    }

    fn serialize_bool(self, value: bool) -> Result<(), Never> {
        self.serialize_u8(value.into())
    }

    fn serialize_u8(self, value: u8) -> Result<(), Never> {
        self.0.plain(&[value]);
        Ok(())
    }

    fn serialize_i8(self, value: i8) -> Result<(), Never> {
        self.0.plain(&value.to_le_bytes());
        Ok(())
    }

    fn serialize_char(self, value: char) -> Result<(), Never> {
        self.serialize_str(value.encode_utf8(&mut [0; 4]))
    }

    fn serialize_str(self, value: &str) -> Result<(), Never> {
        self.serialize_bytes(value.as_bytes())
    }

    fn serialize_bytes(self, value: &[u8]) -> Result<(), Never> {
        self.0.whole(value.len() as u64);
        self.0.plain(value);
        Ok(())
    }

    fn serialize_none(self) -> Result<(), Never> {
        self.0.plain(&[0]);
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Never> {
        self.0.plain(&[1]);
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), Never> {
        Ok(())
    }

    fn serialize_unit_struct(self, _name: &'static str) -> Result<(), Never> {
        Ok(())
    }

    fn serialize_unit_variant(self, _name: &'static str, index: u32, _variant: &'static str) -> Result<(), Never> {
        self.0.whole(index.into());
        Ok(())
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, name: &'static str, value: &T) -> Result<(), Never> {
        self.0.mark(name == side::NAME);
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        mut self,
        _name: &'static str,
        index: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), Never> {
        self.0.whole(index.into());
        self.within(variant, value)
    }

    fn serialize_seq(self, length: Option<usize>) -> Result<Self, Never> {
        self.0.whole(length.unwrap_or_default() as u64);
        self.serialize_tuple(0)
    }

    fn serialize_tuple(self, _length: usize) -> Result<Self, Never> {
        self.0.begin_items();
        Ok(self)
    }

    fn serialize_tuple_struct(self, _name: &'static str, length: usize) -> Result<Self, Never> {
        self.serialize_tuple(length)
    }

    fn serialize_tuple_variant(
        self,
        _name: &'static str,
        index: u32,
        _variant: &'static str,
        length: usize,
    ) -> Result<Self, Never> {
        self.0.whole(index.into());
        self.serialize_tuple(length)
    }

    fn serialize_map(self, length: Option<usize>) -> Result<Self, Never> {
        self.serialize_seq(length)
    }

    fn serialize_struct(self, _name: &'static str, length: usize) -> Result<Self, Never> {
        self.serialize_tuple(length)
    }

    fn serialize_struct_variant(
        self,
        _name: &'static str,
        index: u32,
        _variant: &'static str,
        length: usize,
    ) -> Result<Self, Never> {
        self.0.whole(index.into());
        self.serialize_tuple(length)
    }

    fn is_human_readable(&self) -> bool {
        false
    }
}

macro_rules! items {
    ($($trait:ident $name:ident;)*) => {$(
        impl<L: Look> ser::$trait for Walk<'_, L> {
            type Ok = ();
            type Error = Never;

            fn $name<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Never> {
                self.item(value)
            }

            fn end(self) -> Result<(), Never> {
                self.0.end_items();
                Ok(())
            }
        }
    )*};
}

items! {
    SerializeSeq serialize_element;
    SerializeTuple serialize_element;
    SerializeTupleStruct serialize_field;
    SerializeTupleVariant serialize_field;
}

macro_rules! fields {
    ($($trait:ident;)*) => {$(
        impl<L: Look> ser::$trait for Walk<'_, L> {
            type Ok = ();
            type Error = Never;

            fn serialize_field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Result<(), Never> {
                self.within(name, value)
            }

            fn end(self) -> Result<(), Never> {
                self.0.end_items();
                Ok(())
            }
        }
    )*};
}

fields! {
    SerializeStruct;
    SerializeStructVariant;
}

impl<L: Look> ser::SerializeMap for Walk<'_, L> {
    type Ok = ();
    type Error = Never;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Never> {
        key.serialize(Walk(self.0))
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Never> {
        self.item(value)
    }

    fn end(self) -> Result<(), Never> {
        self.0.end_items();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use serde::{Deserialize, Serialize};

    use super::*;

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    enum Mode {
        Rest,
        Slides(f64),
        Holds { place: f64, load: f64 },
    }

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Memory {
        count: u64,
        change: i32,
        modes: Vec<Mode>,
        taps: [f64; 2],
        fall: Option<(u8, f64)>,
        note: String,
    }

    fn memory(shift: f64) -> Memory {
        Memory {
            count: 300,
            change: -70,
            modes: vec![Mode::Rest, Mode::Slides(-1.0), Mode::Holds { place: 2.0 + shift, load: 3.0 }],
            taps: [4.0, 5.0 + shift],
            fall: Some((9, 6.0)),
            note: "long".repeat(50),
        }
    }

    #[test]
    fn numbers_of_a_memory_are_found_in_their_places() {
        let leaves = Leaves::of(&memory(0.0));
        assert_eq!(leaves.values(), [-1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let mut numbers = Vec::new();
        read(&memory(0.0), &mut numbers);
        assert_eq!(leaves.values(), numbers);
        let moved = leaves.with(|leaf| leaves.value(leaf) + f64::from(u8::from(leaf == 1 || leaf == 4)));
        assert_eq!(moved.memory::<Memory>().expect("a memory"), memory(1.0));
    }

    #[test]
    fn memories_that_differ_in_numbers_alone_are_alike() {
        let (one, mut other) = (Leaves::of(&memory(0.0)), memory(3.0));
        let form = |memory: &Memory| read(memory, &mut Vec::new());
        let mut are_alike = |change: fn(&mut Memory)| {
            change(&mut other);
            let is_alike = one.is_alike(&Leaves::of(&other));
            assert_eq!(Leaves::like(&other, &one), Leaves::of(&other));
            assert_eq!(is_alike, form(&memory(0.0)) == form(&other));
            other = memory(3.0);
            is_alike
        };
        assert!(are_alike(|_| {}));
        assert!(!are_alike(|other| other.count += 1));
        assert!(!are_alike(|other| other.modes[0] = Mode::Slides(1.0)));
        assert!(!are_alike(|other| other.fall = None));
        assert!(!are_alike(|other| other.note.push('!')));
        assert!(!are_alike(|other| other.note.replace_range(3..4, "G")));
        assert!(!are_alike(|other| other.fall = Some((8, 6.0))));
        assert!(!are_alike(|other| other.change += 1));
    }

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Wheel {
        since: f64,
        #[serde(with = "side")]
        turns: f64,
        rest: f64,
    }

    /// What marks a side is not saved: only who asks what a number is sees it.
    #[test]
    fn sides_are_told_and_saved_as_numbers() {
        let wheel = Wheel { since: 1.0, turns: -1.0, rest: 3.0 };
        assert_eq!(told(&wheel).into_iter().map(|leaf| leaf.is_side).collect::<Vec<_>>(), [false, true, false]);
        let saved = postcard::to_allocvec(&wheel).expect("plain data");
        assert_eq!(saved, [1.0f64, -1.0, 3.0].map(f64::to_le_bytes).concat());
        assert_eq!((Leaves::of(&wheel).memory(), Leaves::of(&wheel).values()), (Some(wheel), vec![1.0, -1.0, 3.0]));
    }

    #[test]
    fn numbers_are_named_by_their_fields() {
        let expected = ["modes[2].Slides", "modes[3].place", "modes[3].load", "taps[1]", "taps[2]", "fall[2]"];
        let told = told(&memory(0.0));
        assert_eq!(told.iter().map(|leaf| leaf.name.as_str()).collect::<Vec<_>>(), expected);
        assert!(told.iter().all(|leaf| !leaf.is_side));
    }

    #[test]
    fn items_are_counted_in_each_sequence() {
        #[derive(Serialize)]
        struct Rows {
            rows: [[f64; 2]; 2],
            last: (f64, f64),
        }
        let names = told(&Rows { rows: [[1.0, 2.0], [3.0, 4.0]], last: (5.0, 6.0) }).into_iter().map(|leaf| leaf.name);
        let expected = ["rows[1][1]", "rows[1][2]", "rows[2][1]", "rows[2][2]", "last[1]", "last[2]"];
        assert_eq!(names.collect::<Vec<_>>(), expected);
    }
}
