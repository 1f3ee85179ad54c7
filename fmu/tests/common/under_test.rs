//! The functions of the library, one of which a test may take away.

use std::cell::Cell;
use std::ops::Deref;
use std::sync::LazyLock;
use std::thread::LocalKey;

/// The functions of a version of the standard, as the library has them or as [`UnderTest::replaced_by`] puts it.
pub struct UnderTest<F: 'static> {
    loaded: LazyLock<F>,
    replaced: &'static LocalKey<Cell<*const F>>,
}

impl<F> UnderTest<F> {
    pub const fn new(load: fn() -> F, replaced: &'static LocalKey<Cell<*const F>>) -> Self {
        Self { loaded: LazyLock::new(load), replaced }
    }

    /// Does something with other functions in the place of the library's, as far as it happens in this thread.
    pub fn replaced_by<T>(&self, functions: &F, work: impl FnOnce() -> T) -> T {
        self.replaced.set(functions);
        let _restored = Restored(self.replaced);
        work()
    }
}

/// Gives the library's own functions back, also after a panic.
struct Restored<F: 'static>(&'static LocalKey<Cell<*const F>>);

impl<F> Drop for Restored<F> {
    fn drop(&mut self) {
        self.0.set(std::ptr::null());
    }
}

impl<F> Deref for UnderTest<F> {
    type Target = F;

    fn deref(&self) -> &F {
        // SAFETY: the pointer is NULL, or points to the functions that `replaced_by` borrows all the while.
        unsafe { self.replaced.get().as_ref() }.unwrap_or_else(|| &self.loaded)
    }
}
