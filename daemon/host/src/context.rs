//! Contexts, through which codels throw exceptions (genom3.md 5.4). One of the few unsafe modules.
#![allow(unsafe_code)]

use std::cell::UnsafeCell;
use std::ffi::{c_char, c_void};
use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};

/// `struct genom_context_iface` (genom3.md 5.4).
#[repr(C)]
struct Interface {
    raise: unsafe extern "C" fn(
        *const c_char,
        *const c_void,
        usize,
        *const Interface,
    ) -> *const c_char,
    raised: unsafe extern "C" fn(*mut *const c_char, *const Interface) -> *const c_void,
    data: *const Context,
}

/// The contexts of one component: one for each task, then one for each control worker.
///
/// At any time, each belongs to the thread that runs a codel with it.
pub(crate) struct Contexts(Box<[Context]>);

/// The context of one task or control worker.
pub(crate) struct Context {
    interface: UnsafeCell<Interface>,
    /// Identity of the thread whose codel uses the context now; 0 between codels.
    thread: AtomicUsize,
    record: UnsafeCell<Exception>,
    /// The library's own pointer for `genom_fatal`.
    fatal: AtomicUsize,
}

/// The last exception recorded.
struct Exception {
    event: *const c_char,
    size: usize,
    /// Whether the codel that runs now, or ran last, recorded it.
    fresh: bool,
    /// As 8-byte words, so that it is aligned for any C type.
    detail: Box<[u64]>,
}

// SAFETY: the exception is accessed only by the thread in `thread`, which the runtime makes the
// only one to run codels with this context; the interface is written once, before it is shared.
unsafe impl Sync for Context {}
// SAFETY: as above; the pointers inside point into the library, which outlives the contexts.
unsafe impl Send for Context {}

impl fmt::Debug for Contexts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Contexts({})", self.0.len())
    }
}

/// Identifies the calling thread among the living ones.
fn this_thread() -> usize {
    thread_local!(static HERE: u8 = const { 0 });
    HERE.with(|here| std::ptr::from_ref(here) as usize)
}

impl Contexts {
    /// Makes `count` contexts for details of at most `room` bytes.
    pub(crate) fn new(count: usize, room: usize, fatal: *const c_char) -> Self {
        let contexts: Box<[Context]> = (0..count)
            .map(|_| Context {
                interface: UnsafeCell::new(Interface { raise, raised, data: std::ptr::null() }),
                thread: AtomicUsize::new(0),
                record: UnsafeCell::new(Exception {
                    event: std::ptr::null(),
                    size: 0,
                    fresh: false,
                    detail: vec![0; room.div_ceil(8)].into(),
                }),
                fatal: AtomicUsize::new(fatal as usize),
            })
            .collect();
        for context in &contexts {
            // SAFETY: the contexts are not shared yet; the contents of the box never move.
            unsafe { (*context.interface.get()).data = context };
        }
        Self(contexts)
    }

    /// The context with this index.
    pub(crate) fn get(&self, rank: usize) -> Option<&Context> {
        self.0.get(rank)
    }

    /// Exchanges what comes from the library with other contexts; exceptions are forgotten.
    ///
    /// # Safety
    /// No codel uses one of them.
    pub(crate) unsafe fn exchange(&self, others: &Self) {
        for (own, other) in self.0.iter().zip(&others.0) {
            let fatal = own.fatal.swap(other.fatal.load(Ordering::Relaxed), Ordering::Relaxed);
            other.fatal.store(fatal, Ordering::Relaxed);
            for context in [own, other] {
                // SAFETY: the caller's promise.
                let record = unsafe { &mut *context.record.get() };
                (record.event, record.size, record.fresh) = (std::ptr::null(), 0, false);
            }
        }
    }

    /// Finds the context that a codel passed to a method of a port or remote. It must be one of
    /// these contexts, in use by the calling thread; anything else is an error of the codel.
    pub(crate) fn passed(&self, pointer: *const u8) -> Option<&Context> {
        let context = self.0.iter().find(|context| context.pointer() == pointer.cast())?;
        context.is_here().then_some(context)
    }
}

impl Context {
    /// The pointer that codels get as `genom_context`.
    pub(crate) fn pointer(&self) -> *const c_void {
        self.interface.get().cast_const().cast()
    }

    /// A codel starts with this context on the calling thread.
    pub(crate) fn enter(&self) {
        self.thread.store(this_thread(), Ordering::Relaxed);
        // SAFETY: the context belongs to this thread now.
        unsafe { (*self.record.get()).fresh = false };
    }

    /// The codel returned.
    pub(crate) fn leave(&self) {
        self.thread.store(0, Ordering::Relaxed);
    }

    fn is_here(&self) -> bool {
        self.thread.load(Ordering::Relaxed) == this_thread()
    }

    /// Records an exception; `false` when its detail is too large. Called while a codel on this
    /// thread uses the context.
    pub(crate) fn record(&self, event: *const c_char, detail: &[u8]) -> bool {
        // SAFETY: the context belongs to this thread; the detail is as large as its slice says.
        unsafe { self.record_raw(event, detail.as_ptr().cast(), detail.len()) }
    }

    /// As [`record`](Self::record), from C.
    ///
    /// # Safety
    /// The context belongs to this thread, and `detail` points to `size` bytes.
    unsafe fn record_raw(&self, event: *const c_char, detail: *const c_void, size: usize) -> bool {
        // SAFETY: the caller's promise.
        let record = unsafe { &mut *self.record.get() };
        let size = if detail.is_null() { 0 } else { size };
        if event.is_null() || size > record.detail.len() * 8 {
            return false;
        }
        // SAFETY: the size was checked. A codel may pass the detail that it got from `raised`, so
        // both may overlap.
        unsafe { std::ptr::copy(detail.cast::<u8>(), record.detail.as_mut_ptr().cast(), size) };
        record.event = event;
        record.size = size;
        record.fresh = true;
        true
    }

    /// Copies the detail that the last codel recorded with the exception that it returned, named
    /// `name`, into `into`, which has the same size; returns the detail's size, `None` when there
    /// is none. Called on the thread that ran the codel.
    pub(crate) fn take_detail(
        &self,
        returned: *const c_char,
        name: &[u8],
        into: &mut [u64],
    ) -> Option<usize> {
        // SAFETY: the codel has returned, and this is its thread.
        let record = unsafe { &*self.record.get() };
        let same =
            || record.event == returned || crate::events::text(record.event, false) == Some(name);
        if !record.fresh || !same() {
            return None;
        }
        let words = record.size.div_ceil(8);
        into.get_mut(..words)?.copy_from_slice(&record.detail[..words]);
        Some(record.size)
    }
}

/// The context that C code passed.
///
/// # Safety
/// `this` is NULL or points to one of these contexts.
unsafe fn context<'a>(this: *const Interface) -> Option<&'a Context> {
    if this.is_null() {
        return None;
    }
    // SAFETY: the caller's promise; `data` was set when the contexts were made.
    Some(unsafe { &*(*this).data })
}

unsafe extern "C" fn raise(
    event: *const c_char,
    detail: *const c_void,
    size: usize,
    this: *const Interface,
) -> *const c_char {
    // SAFETY: a codel passes the context it got (genom3.md 5.4).
    let Some(context) = (unsafe { context(this) }) else { return event };
    // SAFETY: the thread is checked first; the codel guarantees the detail.
    if context.is_here() && unsafe { context.record_raw(event, detail, size) } {
        event
    } else {
        context.fatal.load(Ordering::Relaxed) as *const c_char
    }
}

unsafe extern "C" fn raised(event: *mut *const c_char, this: *const Interface) -> *const c_void {
    // SAFETY: a codel passes the context it got (genom3.md 5.4).
    let found = unsafe { context(this) }.filter(|context| context.is_here());
    // SAFETY: the context belongs to this thread, as was just checked.
    let record = found.map(|context| unsafe { &*context.record.get() });
    if !event.is_null() {
        // SAFETY: the codel provides the memory for the event.
        unsafe { event.write(record.map_or(std::ptr::null(), |record| record.event)) };
    }
    match record {
        Some(record) if record.size > 0 => record.detail.as_ptr().cast(),
        _ => std::ptr::null(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OK: &CStr = c"::demo::E";
    const FATAL: &CStr = c"::genom::fatal";
    use std::ffi::CStr;

    fn raise_in(context: &Context, detail: &[u8]) -> *const c_char {
        // SAFETY: the context is valid, and the detail as large as stated.
        unsafe {
            raise(OK.as_ptr(), detail.as_ptr().cast(), detail.len(), context.pointer().cast())
        }
    }

    #[test]
    fn the_interface_is_24_bytes() {
        assert_eq!(size_of::<Interface>(), 24);
    }

    #[test]
    fn a_detail_larger_than_any_of_the_component_is_fatal() {
        let contexts = Contexts::new(1, 8, FATAL.as_ptr());
        let context = contexts.get(0).unwrap();
        context.enter();
        assert_eq!(raise_in(context, &[1; 8]), OK.as_ptr());
        assert_eq!(raise_in(context, &[2; 9]), FATAL.as_ptr());
        let mut detail = [0];
        assert_eq!(context.take_detail(OK.as_ptr(), OK.to_bytes(), &mut detail), Some(8));
        assert_eq!(detail[0].to_ne_bytes(), [1; 8]);
    }

    #[test]
    fn a_context_used_by_another_thread_or_between_codels_records_nothing() {
        let contexts = Contexts::new(1, 8, FATAL.as_ptr());
        let context = contexts.get(0).unwrap();
        assert_eq!(raise_in(context, &[1]), FATAL.as_ptr());
        context.enter();
        std::thread::scope(|scope| {
            scope.spawn(|| assert_eq!(raise_in(context, &[1]), FATAL.as_ptr()));
        });
        assert!(contexts.passed(context.pointer().cast()).is_some());
        assert!(contexts.passed(std::ptr::null()).is_none());
        context.leave();
        assert!(contexts.passed(context.pointer().cast()).is_none());
        assert_eq!(context.take_detail(OK.as_ptr(), OK.to_bytes(), &mut [0]), None);
    }

    #[test]
    fn a_detail_of_an_earlier_codel_is_stale() {
        let contexts = Contexts::new(1, 8, FATAL.as_ptr());
        let context = contexts.get(0).unwrap();
        context.enter();
        raise_in(context, &[1]);
        context.leave();
        context.enter();
        context.leave();
        assert_eq!(context.take_detail(OK.as_ptr(), OK.to_bytes(), &mut [0]), None);
    }
}
