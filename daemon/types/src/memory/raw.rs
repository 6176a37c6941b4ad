//! Memory of the C library: malloc, strings, headers of sequences.

use std::alloc::Layout;
use std::ffi::{c_char, c_void};

use crate::graph::{Graph, Ix, Shape};

/// Deepest nesting of sequences that is followed. Deeper ones, which only codels can make, are not
/// copied, shown or released: a leak is better than a stack overflow.
pub(crate) const MAX_DEPTH: usize = 256;

unsafe extern "C" {
    fn malloc(size: usize) -> *mut c_void;
    fn calloc(count: usize, size: usize) -> *mut c_void;
    /// `free` of the C library, which codels call too; it is the `_release` of buffers made here.
    pub(crate) fn free(at: *mut c_void);
    fn strlen(at: *const c_char) -> usize;
}

/// `struct sequence_T` (genom3.md 5.2). All zero is the empty sequence.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct SequenceHeader {
    /// Elements the buffer has room for.
    pub(crate) maximum: u32,
    /// Elements that hold values.
    pub(crate) length: u32,
    pub(crate) buffer: *mut u8,
    /// Frees the buffer; null when the sequence does not own it.
    pub(crate) release: Option<unsafe extern "C" fn(*mut c_void)>,
}

const _: () = assert!(size_of::<SequenceHeader>() == 24 && align_of::<SequenceHeader>() == 8);
const _: () = assert!(cfg!(target_endian = "little"), "C layouts are copied to the wire as is");

impl SequenceHeader {
    /// Number of elements that can be read.
    ///
    /// Codels that lend a buffer often set `_buffer` and `_length` only, so a `_maximum` of 0
    /// beside a buffer counts as unset.
    pub(crate) fn readable(&self) -> usize {
        match (self.buffer.is_null(), self.maximum) {
            (true, _) => 0,
            (false, 0) => self.length as usize,
            (false, maximum) => self.length.min(maximum) as usize,
        }
    }

    /// Whether the buffer is lent: without a `_release` its content must not be changed or freed
    /// here, and it may be gone once the codel that lent it has returned.
    pub(crate) fn lent(&self) -> bool {
        self.release.is_none() && !self.buffer.is_null()
    }
}

/// `free`, as the type `_release` has.
pub(crate) const FREE: unsafe extern "C" fn(*mut c_void) = free;

/// Zeroed memory from the C library; `None` when there is none left. Never null for size 0.
pub(crate) fn allocate(count: usize, size: usize) -> Option<*mut u8> {
    // SAFETY: calloc has no precondition, it checks the product itself.
    let at = unsafe { calloc(count.max(1), size.max(1)) };
    (!at.is_null()).then_some(at.cast())
}

/// A NUL-terminated copy of `bytes` from the C library's allocator.
pub(crate) fn duplicate(bytes: &[u8]) -> Option<*mut u8> {
    // SAFETY: malloc has no precondition.
    let at: *mut u8 = unsafe { malloc(bytes.len() + 1) }.cast();
    if at.is_null() {
        return None;
    }
    // SAFETY: `at` has room for the bytes and the NUL, and is fresh.
    unsafe {
        std::ptr::copy_nonoverlapping(bytes.as_ptr(), at, bytes.len());
        at.add(bytes.len()).write(0);
    }
    Some(at)
}

/// Aborts as Rust does when memory runs out.
pub(crate) fn out_of_memory(size: usize) -> ! {
    std::alloc::handle_alloc_error(Layout::from_size_align(size, 8).unwrap_or(Layout::new::<u64>()))
}

/// The bytes of a string before its NUL; a bounded one may be full and without NUL, an unbounded
/// one may be null.
///
/// # Safety
/// `at` holds a `string` or `string<bound>` for as long as the slice is used.
pub(crate) unsafe fn text<'a>(at: *const u8, bound: Option<usize>) -> &'a [u8] {
    match bound {
        Some(bound) => {
            // SAFETY: the array has `bound` bytes.
            let all = unsafe { std::slice::from_raw_parts(at, bound) };
            let end = all.iter().position(|&byte| byte == 0).unwrap_or(bound);
            &all[..end]
        }
        None => {
            // SAFETY: `at` holds a `char *`.
            let at = unsafe { at.cast::<*const u8>().read() };
            if at.is_null() {
                return &[];
            }
            // SAFETY: a string of a codel or of ours is NUL-terminated (genom3.md 5.2).
            unsafe { std::slice::from_raw_parts(at, strlen(at.cast())) }
        }
    }
}

/// Offset of `_buffer` in a bounded sequence: after two 4-byte words, aligned for the element.
pub(crate) fn buffer_offset(graph: &Graph, element: Ix) -> usize {
    8usize.next_multiple_of(graph.node(element).layout.align)
}

/// Hands a buffer to its `_release`.
///
/// # Safety
/// The header is that of a sequence whose buffer is not used any more.
pub(crate) unsafe fn give_back(header: &SequenceHeader) {
    if let Some(release) = header.release
        && !header.buffer.is_null()
    {
        // SAFETY: that is what `_release` is for (genom3.md 5.2).
        unsafe { release(header.buffer.cast()) }
    }
}

/// The readable elements of a sequence: first address and number.
///
/// # Safety
/// `at` holds a sequence of such elements.
pub(crate) unsafe fn elements(
    graph: &Graph,
    element: Ix,
    bound: Option<usize>,
    at: *const u8,
) -> (*mut u8, usize) {
    match bound {
        // SAFETY: a bounded sequence starts with two words, its buffer lies behind.
        Some(bound) => unsafe {
            let length = at.add(4).cast::<u32>().read_unaligned() as usize;
            (at.add(buffer_offset(graph, element)).cast_mut(), length.min(bound))
        },
        None => {
            // SAFETY: an unbounded sequence is this header.
            let header = unsafe { at.cast::<SequenceHeader>().read() };
            (header.buffer, header.readable())
        }
    }
}

/// The discriminant, boolean, char, integer or enum at an address; 0 for other shapes.
///
/// # Safety
/// `at` holds a value of that shape, at any alignment.
pub(crate) unsafe fn integer(shape: &Shape, at: *const u8) -> i128 {
    use crate::graph::Scalar as S;
    // SAFETY: the caller's promise: each arm reads what the shape says.
    unsafe {
        match shape {
            Shape::Enum { .. } | Shape::Scalar(S::UnsignedLong) => {
                at.cast::<u32>().read_unaligned().into()
            }
            Shape::Scalar(S::Boolean) => (at.read() != 0).into(),
            Shape::Scalar(S::Char) => at.cast::<i8>().read_unaligned().into(),
            Shape::Scalar(S::Octet) => at.read().into(),
            Shape::Scalar(S::Short) => at.cast::<i16>().read_unaligned().into(),
            Shape::Scalar(S::UnsignedShort) => at.cast::<u16>().read_unaligned().into(),
            Shape::Scalar(S::Long) => at.cast::<i32>().read_unaligned().into(),
            Shape::Scalar(S::LongLong) => at.cast::<i64>().read_unaligned().into(),
            Shape::Scalar(S::UnsignedLongLong) => at.cast::<u64>().read_unaligned().into(),
            _ => 0,
        }
    }
}
