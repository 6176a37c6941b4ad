//! Counts the allocator calls of a thread, for tests that require none.
//!
//! A program that links this crate uses its allocator: the system's, with a counter per thread.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local!(static CALLS: Cell<u64> = const { Cell::new(0) });

struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn add() {
    // A thread that ends may still free memory after its counter is gone.
    let _ = CALLS.try_with(|calls| calls.set(calls.get() + 1));
}

// SAFETY: everything is delegated to the system's allocator; counting uses no heap.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add();
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        add();
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        add();
        // SAFETY: the caller's promise is passed on.
        unsafe { System.realloc(at, layout, size) }
    }
}

/// How often the current thread has called the allocator: to allocate, reallocate or free.
pub fn count() -> u64 {
    CALLS.with(Cell::get)
}

/// How often the current thread calls the allocator during `work`.
pub fn within(work: impl FnOnce()) -> u64 {
    let before = count();
    work();
    count() - before
}
