//! The numbers in a memory: where they are in its saved form, and the memory with others in their places.
//!
//! A memory says how it is saved, and nothing else of its inside. The saved form is that of postcard: a number takes eight
//! bytes, an enumeration the index of its variant, a sequence its length and its items. [`Finder`] walks through a memory as
//! postcard does and notes where the numbers are; all else (modes, counts, lengths) is what must not change where a
//! derivative is taken.

use std::fmt;
use std::sync::Arc;

use serde::de::DeserializeOwned;
use serde::ser::{self, Serialize, Serializer};

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
        memory.serialize(&mut finder).expect("a memory holds plain data");
        debug_assert_eq!(finder.length, bytes.len(), "the saved form is that of postcard");
        Self { bytes, places: finder.places.into() }
    }

    /// The same, faster if a memory is alike another one.
    pub fn like<M: Serialize>(memory: &M, other: &Self) -> Self {
        let bytes = postcard::to_allocvec(memory).expect("a memory holds plain data");
        if other.fits(&bytes) { Self { bytes, places: other.places.clone() } } else { Self::of(memory) }
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

/// The names of the numbers of a memory, in their order: those of its fields, joined by dots.
pub fn names<M: Serialize>(memory: &M) -> Vec<String> {
    let mut finder = Finder { names: Some(Vec::new()), ..Finder::default() };
    memory.serialize(&mut finder).expect("a memory holds plain data");
    finder.names.unwrap_or_default()
}

/// Goes through a memory, counts bytes as postcard writes them, and notes where the numbers are.
#[derive(Debug, Default)]
struct Finder {
    length: usize,
    places: Vec<usize>,
    /// The path to here.
    path: Vec<String>,
    /// The paths of the numbers, if they are asked for.
    names: Option<Vec<String>>,
    /// Number of the next item of the innermost sequences.
    items: Vec<usize>,
}

impl Finder {
    /// A whole number in groups of seven bits.
    fn varint(&mut self, value: u128) {
        let bits = u128::BITS - value.leading_zeros();
        self.length += bits.div_ceil(7).max(1) as usize;
    }

    /// One with a sign, which postcard folds.
    fn signed(&mut self, value: i128) {
        self.varint(if value < 0 { ((-(value + 1)) as u128) * 2 + 1 } else { (value as u128) * 2 });
    }

    fn within<T: Serialize + ?Sized>(&mut self, name: &str, value: &T) -> Result<(), Never> {
        if self.names.is_some() {
            self.path.push(name.to_owned());
        }
        value.serialize(&mut *self)?;
        if self.names.is_some() {
            self.path.pop();
        }
        Ok(())
    }

    fn item<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Never> {
        let number = self.items.last_mut().map_or(0, |next| {
            *next += 1;
            *next
        });
        if self.names.is_none() {
            return value.serialize(&mut *self);
        }
        self.within(&format!("[{number}]"), value)
    }

    fn begin_items(&mut self) -> &mut Self {
        self.items.push(0);
        self
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
    ($($name:ident $number:ty, $how:ident;)*) => {$(
        fn $name(self, value: $number) -> Result<(), Never> {
            self.$how(value.into());
            Ok(())
        }
    )*};
}

impl<'a> Serializer for &'a mut Finder {
    type Ok = ();
    type Error = Never;
    type SerializeSeq = Items<'a>;
    type SerializeTuple = Items<'a>;
    type SerializeTupleStruct = Items<'a>;
    type SerializeTupleVariant = Items<'a>;
    type SerializeMap = Items<'a>;
    type SerializeStruct = Items<'a>;
    type SerializeStructVariant = Items<'a>;

    whole_numbers! {
        serialize_u16 u16, varint;
        serialize_u32 u32, varint;
        serialize_u64 u64, varint;
        serialize_u128 u128, varint;
        serialize_i16 i16, signed;
        serialize_i32 i32, signed;
        serialize_i64 i64, signed;
        serialize_i128 i128, signed;
    }

    fn serialize_f64(self, _value: f64) -> Result<(), Never> {
        self.places.push(self.length);
        self.length += size_of::<f64>();
        if let Some(names) = &mut self.names {
            names.push(self.path.join(".").replace(".[", "["));
        }
        Ok(())
    }

    fn serialize_f32(self, _value: f32) -> Result<(), Never> {
        self.length += size_of::<f32>();
        Ok(())
    }

    fn serialize_bool(self, _value: bool) -> Result<(), Never> {
        self.length += 1;
        Ok(())
    }

    fn serialize_u8(self, _value: u8) -> Result<(), Never> {
        self.length += 1;
        Ok(())
    }

    fn serialize_i8(self, _value: i8) -> Result<(), Never> {
        self.length += 1;
        Ok(())
    }

    fn serialize_char(self, value: char) -> Result<(), Never> {
        self.serialize_str(value.encode_utf8(&mut [0; 4]))
    }

    fn serialize_str(self, value: &str) -> Result<(), Never> {
        self.serialize_bytes(value.as_bytes())
    }

    fn serialize_bytes(self, value: &[u8]) -> Result<(), Never> {
        self.varint(value.len() as u128);
        self.length += value.len();
        Ok(())
    }

    fn serialize_none(self) -> Result<(), Never> {
        self.length += 1;
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Never> {
        self.length += 1;
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), Never> {
        Ok(())
    }

    fn serialize_unit_struct(self, _name: &'static str) -> Result<(), Never> {
        Ok(())
    }

    fn serialize_unit_variant(self, _name: &'static str, index: u32, _variant: &'static str) -> Result<(), Never> {
        self.varint(index.into());
        Ok(())
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _name: &'static str, value: &T) -> Result<(), Never> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _name: &'static str,
        index: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), Never> {
        self.varint(index.into());
        self.within(variant, value)
    }

    fn serialize_seq(self, length: Option<usize>) -> Result<Items<'a>, Never> {
        self.varint(length.unwrap_or_default() as u128);
        Ok(Items(self.begin_items()))
    }

    fn serialize_tuple(self, _length: usize) -> Result<Items<'a>, Never> {
        Ok(Items(self.begin_items()))
    }

    fn serialize_tuple_struct(self, _name: &'static str, _length: usize) -> Result<Items<'a>, Never> {
        Ok(Items(self.begin_items()))
    }

    fn serialize_tuple_variant(
        self,
        _name: &'static str,
        index: u32,
        _variant: &'static str,
        _length: usize,
    ) -> Result<Items<'a>, Never> {
        self.varint(index.into());
        Ok(Items(self.begin_items()))
    }

    fn serialize_map(self, length: Option<usize>) -> Result<Items<'a>, Never> {
        self.serialize_seq(length)
    }

    fn serialize_struct(self, _name: &'static str, _length: usize) -> Result<Items<'a>, Never> {
        Ok(Items(self.begin_items()))
    }

    fn serialize_struct_variant(
        self,
        _name: &'static str,
        index: u32,
        _variant: &'static str,
        _length: usize,
    ) -> Result<Items<'a>, Never> {
        self.varint(index.into());
        Ok(Items(self.begin_items()))
    }

    fn is_human_readable(&self) -> bool {
        false
    }
}

/// What has several items.
struct Items<'a>(&'a mut Finder);

macro_rules! items {
    ($($trait:ident $name:ident;)*) => {$(
        impl ser::$trait for Items<'_> {
            type Ok = ();
            type Error = Never;

            fn $name<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Never> {
                self.0.item(value)
            }

            fn end(self) -> Result<(), Never> {
                self.0.items.pop();
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
        impl ser::$trait for Items<'_> {
            type Ok = ();
            type Error = Never;

            fn serialize_field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Result<(), Never> {
                self.0.within(name, value)
            }

            fn end(self) -> Result<(), Never> {
                self.0.items.pop();
                Ok(())
            }
        }
    )*};
}

fields! {
    SerializeStruct;
    SerializeStructVariant;
}

impl ser::SerializeMap for Items<'_> {
    type Ok = ();
    type Error = Never;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Never> {
        key.serialize(&mut *self.0)
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Never> {
        self.0.item(value)
    }

    fn end(self) -> Result<(), Never> {
        self.0.items.pop();
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
        let moved = leaves.with(|leaf| leaves.value(leaf) + f64::from(u8::from(leaf == 1 || leaf == 4)));
        assert_eq!(moved.memory::<Memory>().expect("a memory"), memory(1.0));
    }

    #[test]
    fn memories_that_differ_in_numbers_alone_are_alike() {
        let (one, mut other) = (Leaves::of(&memory(0.0)), memory(3.0));
        assert!(one.is_alike(&Leaves::of(&other)));
        other.count += 1;
        assert!(!one.is_alike(&Leaves::of(&other)));
        other = memory(0.0);
        other.modes[0] = Mode::Slides(1.0);
        assert!(!one.is_alike(&Leaves::of(&other)));
    }

    #[test]
    fn numbers_are_named_by_their_fields() {
        let expected = ["modes[2].Slides", "modes[3].place", "modes[3].load", "taps[1]", "taps[2]", "fall[2]"];
        assert_eq!(names(&memory(0.0)), expected);
    }
}
