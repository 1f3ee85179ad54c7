//! The tables made so far.

use std::any::TypeId;
use std::mem;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use super::Table;

/// A table, by the type of the equations that it belongs to: a generic function has no static of its own for each type.
struct Entry {
    of: TypeId,
    table: Arc<Table>,
    /// The same table, once it has been lent for good.
    lent: Option<&'static Table>,
}

static KEPT: Mutex<Vec<Entry>> = Mutex::new(Vec::new());

/// The table of a type, which is made at the first use.
pub fn shared(of: TypeId, make: impl FnOnce() -> Table) -> Arc<Table> {
    find(&mut lock(), of, make).table.clone()
}

/// The same for as long as the process lasts: this table is never freed.
pub fn lent(of: TypeId, make: impl FnOnce() -> Table) -> &'static Table {
    let mut all = lock();
    let kept = find(&mut all, of, make);
    kept.lent.get_or_insert_with(|| Box::leak(Box::new(kept.table.clone())))
}

/// Frees the tables without other owners; they are made again when they are needed. For a shared library that is about to be
/// unloaded, and would leave them behind. Returns whether it did so, as [`forget`] does.
pub fn forget_tables() -> bool {
    forget(&KEPT)
}

/// Frees what a list holds, unless a thread has it: one that has ended in the middle of adding something, as threads do when a
/// process ends, keeps it for good. Returns whether it was free.
pub fn forget<T>(list: &Mutex<Vec<T>>) -> bool {
    let kept = match list.try_lock() {
        Ok(mut all) => mem::take(&mut *all),
        Err(TryLockError::Poisoned(all)) => mem::take(&mut *all.into_inner()),
        Err(TryLockError::WouldBlock) => return false,
    };
    // A destructor may ask for the list.
    drop(kept);
    true
}

/// A name for as long as the process lasts, for errors and units, which are plain data. Such names are few and short.
pub fn lent_name(name: &str) -> &'static str {
    static NAMES: Mutex<Vec<&'static str>> = Mutex::new(Vec::new());
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    let known = names.iter().copied().find(|known| *known == name);
    known.unwrap_or_else(|| {
        names.push(Box::leak(name.into()));
        names[names.len() - 1]
    })
}

fn lock() -> MutexGuard<'static, Vec<Entry>> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner)
}

fn find(all: &mut Vec<Entry>, of: TypeId, make: impl FnOnce() -> Table) -> &mut Entry {
    let index = all.iter().position(|kept| kept.of == of).unwrap_or_else(|| {
        all.push(Entry { of, table: Arc::new(make()), lent: None });
        all.len() - 1
    });
    &mut all[index]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::Variable;

    struct Owner;

    #[test]
    fn tables_are_made_once_and_freed_when_nobody_holds_them() {
        let of = TypeId::of::<Owner>();
        let make = || Table::new(vec![Variable::time()]);
        let first = shared(of, make);
        assert!(Arc::ptr_eq(&first, &shared(of, || unreachable!("it is there"))));
        let freed = Arc::downgrade(&first);
        while !forget_tables() {}
        assert_eq!(freed.strong_count(), 1);
        drop(first);
        assert!(freed.upgrade().is_none());
        let lent = lent(of, make);
        forget_tables();
        assert_eq!(lent.len(), 1);
    }
}
