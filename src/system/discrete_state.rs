//! The numbers that a discrete state keeps and that vary with parameters and start values: their names, their slopes, and the
//! state with slopes given to them.
//!
//! A discrete state says how it is saved, and nothing else of its inside. The saved form is postcard: a number takes eight
//! bytes, an enumeration the index of its variant, a sequence its length and its items. [`Walk`] goes through a state as postcard
//! does, and notes where the numbers are that are called [`KEPT`]. All else (modes, sides, counts, lengths) does not vary.

use std::fmt;

use serde::de::DeserializeOwned;
use serde::ser::{self, Serialize, Serializer};

use crate::numbers::{KEPT, Slopes};

/// A number that a discrete state keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedNumber {
    /// The names of the fields that lead to it, joined by dots.
    pub name: String,
    /// Its slopes; 0 in a state of numbers without slopes.
    pub slopes: Slopes,
}

/// Label of a number of the discrete state among the states of a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateLabel {
    /// By the fields that lead to it.
    Fields,
    /// By the computed variable that shows it.
    Variable(&'static str),
    /// Not at all, since nothing depends on it under the present parameters.
    Nothing,
}

/// A number that a discrete state keeps, as a state of a transition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LabelledNumber {
    /// Its place among all numbers that the state keeps.
    pub place: usize,
    /// Its name.
    pub name: String,
    /// Whether it stands for a computed variable, which as a rule acts on others.
    pub is_variable: bool,
}

/// The numbers that a discrete state keeps, in the order in which they are saved.
pub fn kept<M: Serialize>(state: &M) -> Vec<NamedNumber> {
    Finder::of(state).numbers.into_iter().map(|(_, kept)| kept).collect()
}

/// The numbers that a discrete state keeps, with their labels as states of a transition; those labelled by nothing are left out.
pub fn labelled<M: Serialize>(state: &M, state_label: impl Fn(&str) -> StateLabel) -> Vec<LabelledNumber> {
    let named = |(place, NamedNumber { name, .. }): (usize, NamedNumber)| match state_label(&name) {
        StateLabel::Fields => Some(LabelledNumber { place, name: format!("memory.{name}"), is_variable: false }),
        StateLabel::Variable(name) => Some(LabelledNumber { place, name: name.to_owned(), is_variable: true }),
        StateLabel::Nothing => None,
    };
    kept(state).into_iter().enumerate().filter_map(named).collect()
}

/// The slopes of the numbers that a discrete state keeps, in the order in which they are saved.
pub fn slopes_of<M: Serialize>(state: &M) -> Vec<Slopes> {
    let mut finder = Finder::default();
    finder.find(state);
    finder.numbers.into_iter().map(|(_, kept)| kept.slopes).collect()
}

/// A discrete state of numbers without slopes as one of numbers that have them, by the places of the numbers.
pub fn varied<A: Serialize, B: DeserializeOwned>(state: &A, slopes: impl Fn(usize) -> Slopes) -> B {
    let mut finder = Finder::default();
    finder.find(state);
    let saved = postcard::to_allocvec(state).expect("a discrete state holds plain data");
    let (mut start, mut renewed) = (0, Vec::new());
    for (number, (place, _)) in finder.numbers.iter().enumerate() {
        let end = place + size_of::<f64>();
        renewed.extend(&saved[start..end]);
        slopes(number).iter().for_each(|slope| renewed.extend(slope.to_le_bytes()));
        start = end;
    }
    renewed.extend(&saved[start..]);
    postcard::from_bytes(&renewed).expect("a discrete state of the same model")
}

/// A discrete state of numbers with slopes, of which none varies.
pub fn still<M: Serialize + DeserializeOwned>(state: &M) -> M {
    Stilling::default().still(state)
}

/// Room to still discrete states: the next of a model takes no more memory.
#[derive(Debug, Default)]
pub struct Stilling {
    finder: Finder,
    saved: Vec<u8>,
    /// The one before, in which the finder has found the numbers.
    before: Vec<u8>,
}

impl Stilling {
    /// As [`still`].
    pub fn still<M: Serialize + DeserializeOwned>(&mut self, state: &M) -> M {
        let mut saved = std::mem::take(&mut self.saved);
        saved.clear();
        let mut saved = postcard::to_extend(state, saved).expect("a discrete state holds plain data");
        if !self.finder.are_same_between_numbers(&saved, &self.before, size_of::<f64>() + size_of::<Slopes>()) {
            self.finder.find(state);
        }
        for (place, _) in &self.finder.numbers {
            saved[place + size_of::<f64>()..][..size_of::<Slopes>()].fill(0);
        }
        self.saved = std::mem::replace(&mut self.before, saved);
        postcard::from_bytes(&self.before).expect("a discrete state of the same model")
    }
}

/// A discrete state of numbers with slopes as one of numbers without them is saved.
pub fn plain<M: Serialize>(state: &M) -> Vec<u8> {
    let saved = postcard::to_allocvec(state).expect("a discrete state holds plain data");
    let (mut start, mut plain) = (0, Vec::new());
    for (place, _) in Finder::of(state).numbers {
        let end = place + size_of::<f64>();
        plain.extend(&saved[start..end]);
        start = end + size_of::<Slopes>();
    }
    plain.extend(&saved[start..]);
    plain
}

/// Whether two discrete states of numbers without slopes differ in nothing but these numbers.
#[cfg(feature = "sensitivities")]
pub fn are_alike<M: Serialize>(one: &M, other: &M) -> bool {
    let [saved, of_other] =
        [one, other].map(|it| postcard::to_allocvec(it).expect("a discrete state holds plain data"));
    let mut finder = Finder::default();
    finder.find(one);
    finder.are_same_between_numbers(&saved, &of_other, size_of::<f64>())
}

/// Counts bytes as postcard writes them, and notes where the numbers are.
#[derive(Debug, Default)]
struct Finder {
    length: usize,
    numbers: Vec<(usize, NamedNumber)>,
    /// The numbers since the last one that is kept began.
    values: Vec<f64>,
    /// The path to here, if names are asked for.
    path: Option<Vec<String>>,
    /// Number of the next item of the innermost sequences.
    items: Vec<usize>,
}

impl Finder {
    fn of<M: Serialize>(state: &M) -> Self {
        let mut finder = Self { path: Some(Vec::new()), ..Self::default() };
        finder.find(state);
        finder
    }

    fn find<M: Serialize>(&mut self, state: &M) {
        self.length = 0;
        self.numbers.clear();
        state.serialize(Walk(self)).expect("a discrete state holds plain data");
    }

    /// Whether two saved states differ in nothing but the numbers, of which each takes some bytes. Then both have them in the same
    /// places: what is saved before a number tells where the number is.
    fn are_same_between_numbers(&self, one: &[u8], other: &[u8], width: usize) -> bool {
        let mut start = 0;
        let is_same = |from: usize, to: usize| one[from..to] == other[from..to];
        one.len() == other.len()
            && self.numbers.iter().all(|(place, _)| {
                let from = std::mem::replace(&mut start, place + width);
                is_same(from, *place)
            })
            && is_same(start, one.len())
    }

    fn enter(&mut self, name: impl FnOnce() -> String) {
        if let Some(path) = &mut self.path {
            path.push(name());
        }
    }

    fn leave(&mut self) {
        if let Some(path) = &mut self.path {
            path.pop();
        }
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

    fn begin_items(&mut self) {
        self.items.push(0);
    }

    fn enter_item(&mut self) {
        let number = self.items.last_mut().map_or(0, |next| {
            *next += 1;
            *next
        });
        self.enter(|| format!("[{number}]"));
    }

    fn end_items(&mut self) {
        self.items.pop();
    }
}

/// Goes through a discrete state as postcard does.
struct Walk<'a>(&'a mut Finder);

impl Walk<'_> {
    fn within<T: Serialize + ?Sized>(&mut self, name: &str, value: &T) -> Result<(), Never> {
        self.0.enter(|| name.to_owned());
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

/// A discrete state that cannot be saved: there is none.
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

impl<'a> Serializer for Walk<'a> {
    type Ok = ();
    type Error = Never;
    type SerializeSeq = Walk<'a>;
    type SerializeTuple = Walk<'a>;
    type SerializeTupleStruct = Walk<'a>;
    type SerializeTupleVariant = Walk<'a>;
    type SerializeMap = Walk<'a>;
    type SerializeStruct = Walk<'a>;
    type SerializeStructVariant = Walk<'a>;

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
        self.0.values.push(value);
        self.0.plain(&value.to_le_bytes());
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
        if name != KEPT {
            return value.serialize(self);
        }
        let Self(finder) = self;
        let place = finder.length;
        finder.values.clear();
        value.serialize(Walk(finder))?;
        let slopes = std::array::from_fn(|i| finder.values.get(1 + i).copied().unwrap_or_default());
        let name = finder.path.as_ref().map_or_else(String::new, |path| path.join(".").replace(".[", "["));
        finder.numbers.push((place, NamedNumber { name, slopes }));
        Ok(())
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _name: &'static str,
        index: u32,
        _variant: &'static str,
        value: &T,
    ) -> Result<(), Never> {
        self.0.whole(index.into());
        value.serialize(self)
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
        name: &'static str,
        index: u32,
        variant: &'static str,
        length: usize,
    ) -> Result<Self, Never> {
        self.serialize_tuple_variant(name, index, variant, length)
    }

    fn is_human_readable(&self) -> bool {
        false
    }
}

macro_rules! items {
    ($($trait:ident $name:ident;)*) => {$(
        impl ser::$trait for Walk<'_> {
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
        impl ser::$trait for Walk<'_> {
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

impl ser::SerializeMap for Walk<'_> {
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
    use crate::numbers::{Real, Scalar, Tangent, Varying, first};

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    enum Mode<S> {
        Rest,
        Slides(f64),
        Holds { place: S, load: S },
    }

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct State<S> {
        count: u64,
        change: i32,
        modes: Vec<Mode<S>>,
        taps: [S; 2],
        fall: Option<(u8, S)>,
        note: String,
    }

    fn state<S: Varying>(slope: impl Fn(f64) -> f64) -> State<S> {
        let number = |value: f64| S::with(value, first(slope(value)));
        State {
            count: 300,
            change: -70,
            modes: vec![Mode::Rest, Mode::Slides(-1.0), Mode::Holds { place: number(2.0), load: number(3.0) }],
            taps: [4.0, 5.0].map(number),
            fall: Some((9, number(6.0))),
            note: "long".repeat(50),
        }
    }

    #[test]
    fn numbers_are_found_in_their_places_and_named_by_their_fields() {
        let plain = state::<Real>(|_| 0.0);
        let of: State<Tangent> = varied(&plain, |place| first(10.0 * place as f64));
        assert_eq!(of, state(|value| 10.0 * (value - 2.0)));
        let found: Vec<_> = kept(&of).into_iter().map(|it| (it.name, it.slopes)).collect();
        let expected = ["modes[3].place", "modes[3].load", "taps[1]", "taps[2]", "fall[2]"];
        for ((name, slopes), (place, expected)) in found.iter().zip(expected.iter().enumerate()) {
            assert!(*expected == *name && *slopes == first(10.0 * place as f64), "{name} {slopes:?}");
        }
        assert_eq!((found.len(), kept(&plain).len()), (5, 5));
    }

    #[test]
    fn states_that_differ_in_numbers_alone_are_alike() {
        let one = state::<Real>(|_| 0.0);
        let is_alike = |change: fn(&mut State<Real>)| {
            let mut other = one.clone();
            change(&mut other);
            are_alike(&one, &other)
        };
        assert!(is_alike(|_| {}) && is_alike(|other| other.taps[0] = Real::of(7.0)));
        assert!(!is_alike(|other| other.count += 1));
        assert!(!is_alike(|other| other.modes[0] = Mode::Slides(1.0)));
        assert!(!is_alike(|other| other.modes[1] = Mode::Slides(1.0)));
        assert!(!is_alike(|other| other.fall = None));
    }
}
