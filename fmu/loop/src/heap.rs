//! The heap of a module on a small machine: from the end of the module's data to where the host says, not page by page.

#![allow(unsafe_code, reason = "this is an allocator")]

use std::alloc::{GlobalAlloc, Layout};
use std::cell::Cell;
use std::ptr;

/// The alignment of all blocks, and what their sizes are multiples of.
const UNIT: usize = 8;

/// A block that is free, written where it lies.
#[derive(Clone, Copy)]
struct Free {
    size: usize,
    /// Address of the next one behind it; 0 if it is the last.
    next: usize,
}

const _: () = assert!(size_of::<Free>() <= 2 * UNIT && align_of::<Free>() <= UNIT);

/// Blocks of memory between two addresses: the first free one that is large enough is taken, and neighbours are joined when they
/// are freed.
pub struct Heap {
    /// Where memory begins that has never been used, and where it ends.
    unused: Cell<(usize, usize)>,
    /// Address of the first free block; 0 without one.
    first: Cell<usize>,
}

// SAFETY: a module has one thread.
unsafe impl Sync for Heap {}

impl Heap {
    /// Without memory, until it is [given](Self::give) some.
    #[allow(clippy::new_without_default, reason = "a constant is made of it")]
    pub const fn new() -> Self {
        Self { unused: Cell::new((0, 0)), first: Cell::new(0) }
    }

    /// Takes the memory between two addresses; what it had before is given up.
    ///
    /// # Safety
    /// Nothing else uses this memory as long as the heap does, and nothing is allocated yet.
    pub unsafe fn give(&self, begin: usize, end: usize) {
        self.unused.set((begin.next_multiple_of(UNIT), end));
        self.first.set(0);
    }

    /// Sets the link to a free block: in the block before it, or the first link.
    fn link(&self, before: usize, to: usize) {
        match before {
            0 => self.first.set(to),
            // SAFETY: it is the address of a free block.
            _ => unsafe { (*(before as *mut Free)).next = to },
        }
    }
}

/// The size of the block for a layout: room for what a free block says of itself.
fn size_of_block(layout: Layout) -> usize {
    layout.size().max(size_of::<Free>()).next_multiple_of(UNIT)
}

// SAFETY: blocks lie in memory that the heap was given, and none in another.
unsafe impl GlobalAlloc for Heap {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.align() > UNIT {
            return ptr::null_mut();
        }
        let size = size_of_block(layout);
        let (mut before, mut at) = (0, self.first.get());
        while at != 0 {
            // SAFETY: it is the address of a free block.
            let free = unsafe { *(at as *const Free) };
            if free.size == size {
                self.link(before, free.next);
                return at as *mut u8;
            }
            if free.size >= size + size_of::<Free>().next_multiple_of(UNIT) {
                // The end is taken, so that links stay.
                // SAFETY: it is the address of a free block.
                unsafe { (*(at as *mut Free)).size -= size };
                return (at + free.size - size) as *mut u8;
            }
            (before, at) = (at, free.next);
        }
        let (begin, end) = self.unused.get();
        if end.saturating_sub(begin) < size {
            return ptr::null_mut();
        }
        self.unused.set((begin + size, end));
        begin as *mut u8
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        let (address, mut size) = (block as usize, size_of_block(layout));
        let (mut before, mut next) = (0, self.first.get());
        while next != 0 && next < address {
            // SAFETY: it is the address of a free block.
            (before, next) = (next, unsafe { (*(next as *const Free)).next });
        }
        if next == address + size {
            // SAFETY: it is the address of a free block.
            let joined = unsafe { *(next as *const Free) };
            (size, next) = (size + joined.size, joined.next);
        }
        // SAFETY: the block is not used any more, and is large enough; before it is a free block or none.
        unsafe {
            if before != 0 && before + (*(before as *const Free)).size == address {
                let joined = before as *mut Free;
                ((*joined).size, (*joined).next) = ((*joined).size + size, next);
            } else {
                *(address as *mut Free) = Free { size, next };
                self.link(before, address);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Random blocks keep what was written into them, do not overlap, and leave all memory for one block in the end.
    #[test]
    fn blocks_are_apart_and_join_again() {
        const WORDS: usize = 1000;
        let mut memory = vec![0_u64; WORDS];
        let begin = memory.as_mut_ptr() as usize;
        let heap = Heap::new();
        // SAFETY: the memory is used for nothing else.
        unsafe { heap.give(begin, begin + 8 * WORDS) };
        let layout = |size| Layout::from_size_align(size, 8).expect("a small size");
        let mut seed = 1_u64;
        let mut random = |below: usize| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 33) as usize % below
        };
        let mut blocks: Vec<(*mut u8, usize, u8)> = Vec::new();
        let mut refused = 0;
        for step in 0..20_000 {
            if random(100) < 52 {
                let size = 1 + random(400);
                // SAFETY: the layout has a size.
                let block = unsafe { heap.alloc(layout(size)) };
                if block.is_null() {
                    refused += 1;
                    continue;
                }
                assert!(
                    block as usize >= begin
                        && block as usize + size <= begin + 8 * WORDS
                        && (block as usize).is_multiple_of(8)
                );
                // SAFETY: the block has this size.
                unsafe { ptr::write_bytes(block, step as u8, size) };
                blocks.push((block, size, step as u8));
            } else if !blocks.is_empty() {
                let (block, size, mark) = blocks.swap_remove(random(blocks.len()));
                // SAFETY: the block was allocated with this size.
                unsafe {
                    assert!(std::slice::from_raw_parts(block, size).iter().all(|byte| *byte == mark), "step {step}");
                    heap.dealloc(block, layout(size));
                }
            }
        }
        assert!(refused > 100 && blocks.len() > 10);
        for (block, size, _) in blocks {
            // SAFETY: the block was allocated with this size.
            unsafe { heap.dealloc(block, layout(size)) };
        }
        let used = heap.unused.get().0 - begin;
        // SAFETY: the layout has a size.
        assert_eq!(unsafe { heap.alloc(layout(used)) } as usize, begin, "what is free is not one block");
        // SAFETY: as before.
        assert!(unsafe { heap.alloc(layout(8 * WORDS)) }.is_null());
        // SAFETY: as before.
        assert!(unsafe { heap.alloc(Layout::from_size_align(8, 64).expect("a layout")) }.is_null());
    }
}
