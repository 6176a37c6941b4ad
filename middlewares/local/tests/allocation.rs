//! The real-time paths allocate nothing.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use genom_local::Local;
use genom_middleware::conformance::samples::{number, numbered, set_number, state};
use genom_middleware::{Address, Middleware, Policy, Reading};
use genom_types::Record;

/// Counts the allocations of each thread.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: all calls go to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn writing_and_reading_fixed_types_allocates_nothing() {
    let local = Local::new();
    let at = Address::new("demo", "position");
    let mut writer = local.publisher(&at, &state()).unwrap();
    let policies = [Policy::Latest, Policy::Queue(4), Policy::Ring(4)];
    let mut readers = policies.map(|policy| local.subscription(&at, &state(), policy).unwrap());
    let (mut sent, mut got) = (numbered(0), Record::new(&state()));
    let mut round = |n| {
        set_number(&mut sent, n);
        writer.publish(&sent).unwrap();
        for reader in &mut readers {
            assert_eq!(reader.read(&mut got), Ok(Reading::New));
            assert_eq!(number(&got), n);
            assert_eq!(reader.read(&mut got), Ok(Reading::Same));
        }
    };
    round(1);
    let before = ALLOCATIONS.get();
    (2..10_000).for_each(&mut round);
    assert_eq!(ALLOCATIONS.get() - before, 0);
}
