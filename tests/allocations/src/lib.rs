//! Counts the allocator calls of a thread, for tests that require none, and the memory that it holds,
//! for tests of limits.
//!
//! A program that links this crate uses its allocator: the system's, with counters per thread.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static CALLS: Cell<u64> = const { Cell::new(0) };
    /// Bytes that are held, and the most so far. What another thread frees stays counted here.
    static HELD: Cell<(isize, isize)> = const { Cell::new((0, 0)) };
}

struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn add(taken: usize, freed: usize) {
    // A thread that ends may still free memory after its counters are gone.
    let _ = CALLS.try_with(|calls| calls.set(calls.get() + 1));
    let _ = HELD.try_with(|held| {
        let (now, most) = held.get();
        let now = now + taken.cast_signed() - freed.cast_signed();
        held.set((now, most.max(now)));
    });
}

// SAFETY: everything is delegated to the system's allocator; counting uses no heap.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add(layout.size(), 0);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        add(0, layout.size());
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        add(size, layout.size());
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

/// The most bytes that the current thread holds at once during `work`, beside what it holds before.
pub fn most_held(work: impl FnOnce()) -> usize {
    let (before, _) = HELD.get();
    HELD.set((before, before));
    work();
    (HELD.get().1 - before).unsigned_abs()
}
