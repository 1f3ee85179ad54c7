//! Calls that save and restore states.

use std::ptr;

use crate::INSTANCES;
use crate::common::{ERROR, OK};
use crate::fuzzer::Fuzzer;

impl Fuzzer {
    pub fn save(&mut self, index: usize) -> bool {
        let pair = &mut self.pairs[index];
        if pair.saved.len() < 6 {
            let snapshot = pair.simulation.as_ref().filter(|_| pair.expected.runs()).map(|it| it.save());
            pair.saved.push((pair.instance.save(), pair.expected.clone(), snapshot));
            self.history.push_back(format!("{index}: save"));
        }
        false
    }

    pub fn restore(&mut self, index: usize) -> bool {
        if self.random.one_in(5) {
            let other = self.pairs[(index + 1) % INSTANCES].saved.first().map_or(ptr::null_mut(), |saved| saved.0);
            let actual = self.pairs[index].instance.restore(other);
            self.compare(format!("{index}: restore a foreign state"), ERROR, actual);
            return true;
        }
        let choice = self.random.next() as usize;
        let pair = &mut self.pairs[index];
        if pair.saved.is_empty() {
            return false;
        }
        let (handle, expected, snapshot) = &pair.saved[choice % pair.saved.len()];
        pair.expected = expected.clone();
        pair.simulation = snapshot.as_ref().map(|snapshot| {
            let mut simulation = expected.simulation().expect("parameters that were legal");
            simulation.restore(snapshot).expect("a snapshot of the same model");
            simulation
        });
        let actual = pair.instance.restore(*handle);
        self.compare(format!("{index}: restore"), OK, actual);
        false
    }

    pub fn forget(&mut self, index: usize) -> bool {
        let pair = &mut self.pairs[index];
        let Some((mut handle, ..)) = pair.saved.pop() else { return false };
        let mut stale = handle;
        let actual = pair.instance.forget(&mut handle);
        self.compare(format!("{index}: free a state"), OK, actual);
        let again = self.pairs[index].instance.forget(&mut stale);
        self.compare(format!("{index}: free it again"), ERROR, again);
        true
    }

    /// Moves a saved state into another instance as bytes.
    pub fn transport(&mut self, index: usize) -> bool {
        let target = (index + 1) % INSTANCES;
        let Some((handle, expected, snapshot)) = self.pairs[index].saved.last().cloned() else { return false };
        if self.pairs[target].saved.len() >= 6 {
            return false;
        }
        let bytes = self.pairs[index].instance.serialize(handle);
        let (actual, copy) = self.pairs[target].instance.deserialize(&bytes);
        self.compare(format!("{index}: transport"), OK, actual);
        self.pairs[target].saved.push((copy, expected, snapshot));
        true
    }

    pub fn corrupt(&mut self, index: usize) -> bool {
        let mut bytes = self.pairs[index].instance.fingerprint();
        let place = self.random.below(bytes.len());
        if self.random.one_in(2) {
            bytes[place] ^= 1 << self.random.below(8);
        } else {
            bytes.truncate(place);
        }
        let (actual, state) = self.pairs[index].instance.deserialize(&bytes);
        assert!(state.is_null());
        self.compare(format!("{index}: corrupt bytes at {place}"), ERROR, actual);
        true
    }
}
