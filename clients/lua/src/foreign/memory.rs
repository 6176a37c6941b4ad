//! Values in memory: of genomd, or of this program.

use std::ffi::{CStr, c_char, c_void};
use std::ptr;

/// Where a value begins.
///
/// Whoever makes one promises that the memory is valid as long as it is used; views of arguments see to
/// that by the life of their call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct At(usize);

impl At {
    /// An address that genomd passed.
    pub(super) fn new(address: *const c_void) -> Self {
        Self(address as usize)
    }

    pub(crate) fn address(self) -> usize {
        self.0
    }

    pub(super) fn pointer(self) -> *mut c_void {
        self.0 as *mut c_void
    }

    /// A part of the value.
    pub(crate) fn plus(self, offset: usize) -> Self {
        Self(self.0.wrapping_add(offset))
    }

    /// The bytes of a number.
    pub(crate) fn read<const N: usize>(self) -> [u8; N] {
        // SAFETY: the promise of whoever made it; alignment is not asked.
        unsafe { ptr::read_unaligned(self.pointer().cast()) }
    }

    pub(crate) fn write<const N: usize>(self, bytes: [u8; N]) {
        // SAFETY: as above.
        unsafe { ptr::write_unaligned(self.pointer().cast(), bytes) }
    }

    /// The address that stands here; `None` for null.
    pub(crate) fn follow(self) -> Option<Self> {
        let address = usize::from_ne_bytes(self.read());
        (address != 0).then_some(Self(address))
    }

    /// Stores an address.
    pub(crate) fn point(self, to: Option<Self>) {
        self.write(to.map_or(0, |to| to.0).to_ne_bytes());
    }

    pub(crate) fn bytes(self, count: usize) -> Vec<u8> {
        let mut bytes = vec![0; count];
        // SAFETY: as above, for so many bytes.
        unsafe { ptr::copy_nonoverlapping(self.pointer().cast(), bytes.as_mut_ptr(), count) };
        bytes
    }

    /// Copies a value to here, which may overlap.
    pub(crate) fn copy(self, from: Self, size: usize) {
        // SAFETY: as above, of both.
        unsafe { ptr::copy(from.pointer().cast::<u8>(), self.pointer().cast(), size) };
    }

    pub(crate) fn put_bytes(self, bytes: &[u8]) {
        // SAFETY: as above; a slice of this program does not overlap.
        unsafe { ptr::copy_nonoverlapping(bytes.as_ptr(), self.pointer().cast(), bytes.len()) };
    }

    pub(crate) fn clear(self, size: usize) {
        // SAFETY: as above.
        unsafe { ptr::write_bytes(self.pointer().cast::<u8>(), 0, size) };
    }

    /// The text up to its NUL.
    pub(crate) fn text(self) -> Vec<u8> {
        // SAFETY: as above: genomd passes C strings.
        unsafe { CStr::from_ptr(self.pointer().cast::<c_char>()) }.to_bytes().to_vec()
    }

    /// Memory for a text, as `strdup` makes it; the text has no NUL.
    pub(crate) fn of_text(text: &[u8]) -> Option<Self> {
        let made = Self::calloc(text.len() + 1, 1)?;
        made.put_bytes(text);
        Some(made)
    }

    /// Empty memory of `malloc`.
    pub(crate) fn calloc(count: usize, size: usize) -> Option<Self> {
        // SAFETY: it takes any numbers.
        let made = unsafe { libc::calloc(count.max(1), size.max(1)) };
        (!made.is_null()).then(|| Self::new(made))
    }

    /// Frees memory of `malloc`.
    pub(crate) fn free(self) {
        // SAFETY: as above; the caller forgets the address.
        unsafe { libc::free(self.pointer()) };
    }

    /// Stores the address of `free`, as sequences keep it.
    pub(crate) fn point_to_free(self) {
        self.write((libc::free as unsafe extern "C" fn(*mut c_void) as usize).to_ne_bytes());
    }

    /// Has the function whose address stands at `by`, if there is one, free this memory.
    pub(crate) fn free_by(self, by: Self) {
        let Some(function) = by.follow() else { return };
        // SAFETY: a sequence keeps the function that frees its elements.
        let free: unsafe extern "C" fn(*mut c_void) = unsafe { std::mem::transmute(function.0) };
        // SAFETY: as above.
        unsafe { free(self.pointer()) };
    }
}

/// Memory of this program, for a value; empty at first.
#[derive(Debug)]
pub(crate) struct Memory(Vec<u64>);

impl Memory {
    pub(crate) fn new(size: usize) -> Self {
        Self(vec![0; size / 8 + 1])
    }

    /// Valid until it is dropped.
    pub(crate) fn at(&mut self) -> At {
        At::new(self.0.as_mut_ptr().cast())
    }
}
