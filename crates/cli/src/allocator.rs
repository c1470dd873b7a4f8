//! The allocator of the program and of the Python package: the allocator of the system, with huge pages for fields.
//!
//! A field of 1024 x 1024 points has 2048 pages of 4 KiB. Each costs an interruption at its first use, and their
//! addresses do not fit into the tables of the processor, on which transforms along columns wait.

#![allow(unsafe_code, reason = "an allocator has no other interface")]

use std::alloc::{GlobalAlloc, Layout, System};

#[global_allocator]
static ALLOCATOR: HugePages = HugePages;

/// The smallest block with huge pages, in bytes.
const LEAST: usize = 1 << 18;

/// The largest distance from a block to the end of the memory of the process up to which all between has huge pages, in
/// bytes.
const FAR: usize = 1 << 27;

/// The allocator of the system, which asks Linux for huge pages for large blocks.
struct HugePages;

// SAFETY: all blocks are those of the allocator of the system, used with the layouts that it was given.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the conditions are those of the caller.
        advised(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        advised(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        advised(unsafe { System.realloc(block, layout, size) }, size)
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(block, layout) }
    }
}

/// The block, after the advice to give it huge pages if it is large, and to all memory behind it that the process has
/// for the next ones: the allocator writes beside its blocks, and a huge page is possible only where nothing was
/// written before.
fn advised(block: *mut u8, size: usize) -> *mut u8 {
    #[cfg(target_os = "linux")]
    if size >= LEAST && !block.is_null() {
        use nix::libc::{MADV_HUGEPAGE, madvise, sbrk};
        /// The size of a huge page, in bytes.
        const HUGE: usize = 1 << 21;
        let before = block.addr() % HUGE;
        // SAFETY: the call tells the end of the memory of the process, and changes nothing.
        let behind = unsafe { sbrk(0) }.addr().saturating_sub(block.addr());
        // A block that is not in that memory is far from it.
        let behind = if behind <= FAR { behind.max(size) } else { size };
        let whole = (before + behind).next_multiple_of(HUGE);
        // SAFETY: the advice changes no contents, also not beside the block, where memory of others may lie, or none.
        unsafe { madvise(block.wrapping_sub(before).cast(), whole, MADV_HUGEPAGE) };
    }
    block
}
