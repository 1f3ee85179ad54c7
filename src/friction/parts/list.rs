//! A list of bounded length.

use std::ops::{Deref, DerefMut, Range};

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

/// A list that never allocates, in a memory that is copied and saved; saved as a sequence.
#[derive(Clone)]
pub struct List<T, const CAPACITY: usize> {
    items: [T; CAPACITY],
    len: usize,
}

impl<T: Copy + Default, const CAPACITY: usize> List<T, CAPACITY> {
    /// A list of at most `CAPACITY` items; further ones are left out.
    pub fn new(items: impl IntoIterator<Item = T>) -> Self {
        let mut list = Self { items: [T::default(); CAPACITY], len: 0 };
        items.into_iter().take(CAPACITY).for_each(|item| list.push(item));
        list
    }

    /// Appends an item, for which there must be room.
    pub fn push(&mut self, item: T) {
        self.items[self.len] = item;
        self.len += 1;
    }

    /// Removes the items in a range of places.
    pub fn remove(&mut self, range: Range<usize>) {
        self.items.copy_within(range.end..self.len, range.start);
        self.len -= range.len();
    }
}

impl<T: Copy + Default, const CAPACITY: usize> Default for List<T, CAPACITY> {
    fn default() -> Self {
        Self::new([])
    }
}

impl<T, const CAPACITY: usize> Deref for List<T, CAPACITY> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.items[..self.len]
    }
}

impl<T, const CAPACITY: usize> DerefMut for List<T, CAPACITY> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.items[..self.len]
    }
}

impl<T: std::fmt::Debug, const CAPACITY: usize> std::fmt::Debug for List<T, CAPACITY> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (**self).fmt(f)
    }
}

impl<T: PartialEq, const CAPACITY: usize> PartialEq for List<T, CAPACITY> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Serialize, const CAPACITY: usize> Serialize for List<T, CAPACITY> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (**self).serialize(serializer)
    }
}

impl<'de, T: Copy + Default + Deserialize<'de>, const CAPACITY: usize> Deserialize<'de> for List<T, CAPACITY> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let items = Vec::<T>::deserialize(deserializer)?;
        if items.len() > CAPACITY {
            return Err(D::Error::custom("too many items"));
        }
        Ok(Self::new(items))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saved_list_is_read_back_unless_it_is_too_long() {
        let list = List::<f64, 4>::new([1.0, 2.0, 3.0]);
        let bytes = postcard::to_allocvec(&list).unwrap();
        assert_eq!(postcard::from_bytes::<List<f64, 4>>(&bytes).unwrap(), list);
        assert_eq!(*postcard::from_bytes::<List<f64, 3>>(&bytes).unwrap(), *list);
        assert!(postcard::from_bytes::<List<f64, 2>>(&bytes).is_err());
    }

    #[test]
    fn items_are_removed_from_the_front_and_from_between() {
        let mut list = List::<f64, 4>::new([1.0, 2.0, 3.0, 4.0]);
        list.remove(0..3);
        list.push(5.0);
        assert_eq!(*list, [4.0, 5.0]);
        list.push(6.0);
        list.remove(1..2);
        assert_eq!(*list, [4.0, 6.0]);
    }
}
