//! Strings.

use std::borrow::Cow;
use std::ffi::{CStr, c_char};
use std::fmt;

use super::{Aggregate, Data, plain};
use crate::abi::{Kind, TypeDescriptor};
use crate::memory;

/// `string<N>`: at most N - 1 bytes of text, and a NUL. A full one that C code wrote may lack it.
///
/// ```
/// use genom::BoundedString;
///
/// let mut frame = BoundedString::<8>::new("base");
/// frame.set("left_gripper");
/// assert_eq!(frame.to_str(), "left_gr");
/// ```
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct BoundedString<const N: usize>([u8; N]);

impl<const N: usize> BoundedString<N> {
    /// A string with this text, truncated between two characters if it does not fit.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let mut string = Self([0; N]);
        string.set(text);
        string
    }

    /// Sets the text, truncated between two characters if it does not fit.
    pub fn set(&mut self, text: &str) {
        let room = N.saturating_sub(1).min(text.len());
        let end = (0..=room).rev().find(|end| text.is_char_boundary(*end)).unwrap_or(0);
        self.0 = [0; N];
        self.0[..end].copy_from_slice(&text.as_bytes()[..end]);
    }

    /// The bytes before the NUL.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.0.split(|byte| *byte == 0).next().unwrap_or(&[])
    }

    /// The text; bytes that are not UTF-8 are replaced.
    #[must_use]
    pub fn to_str(&self) -> Cow<'_, str> {
        String::from_utf8_lossy(self.as_bytes())
    }
}

impl<const N: usize> Default for BoundedString<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

impl<const N: usize> PartialEq for BoundedString<N> {
    fn eq(&self, other: &Self) -> bool {
        self.as_bytes() == other.as_bytes()
    }
}

impl<const N: usize> Eq for BoundedString<N> {}

impl<const N: usize> fmt::Debug for BoundedString<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.to_str().fmt(f)
    }
}

// SAFETY: `char[N]` in C; the bytes are looked at when they are read.
unsafe impl<const N: usize> Data for BoundedString<N> {
    const TYPE: *const TypeDescriptor = &plain::<Self>(Kind::STRING, N, std::ptr::null());
}

impl<const N: usize> Aggregate for BoundedString<N> {}

/// `string`: a text of any length in C memory; the pointer is null while it is empty.
///
/// ```
/// use genom::Text;
///
/// let mut name = Text::new("left");
/// name.set("left gripper");
/// assert_eq!(name.to_str(), "left gripper");
/// ```
#[repr(transparent)]
pub struct Text(*mut c_char);

// SAFETY: it owns its memory, like a `Box<str>`.
unsafe impl Send for Text {}
// SAFETY: shared, it is only read.
unsafe impl Sync for Text {}

impl Text {
    /// A string with this text, up to its first NUL.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let bytes = text.as_bytes().split(|byte| *byte == 0).next().unwrap_or(&[]);
        let pointer = memory::zeroed::<u8>(bytes.len() + 1);
        // SAFETY: `pointer` has room for one byte more than is copied, which stays NUL.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), pointer, bytes.len()) };
        Self(pointer.cast())
    }

    /// Sets the text, and releases the previous one.
    pub fn set(&mut self, text: &str) {
        *self = Self::new(text);
    }

    /// The text as a C string.
    #[must_use]
    pub fn as_c_str(&self) -> &CStr {
        if self.0.is_null() {
            return c"";
        }
        // SAFETY: a string of the C mapping is NUL-terminated, and lives as long as its owner.
        unsafe { CStr::from_ptr(self.0) }
    }

    /// The text; bytes that are not UTF-8 are replaced.
    #[must_use]
    pub fn to_str(&self) -> Cow<'_, str> {
        self.as_c_str().to_string_lossy()
    }
}

impl Default for Text {
    fn default() -> Self {
        Self(std::ptr::null_mut())
    }
}

impl Clone for Text {
    fn clone(&self) -> Self {
        Self::new(&self.to_str())
    }
}

impl Drop for Text {
    fn drop(&mut self) {
        // SAFETY: null, or C memory that this string owns (genom3.md 7.9).
        unsafe { memory::release(self.0) }
    }
}

impl PartialEq for Text {
    fn eq(&self, other: &Self) -> bool {
        self.as_c_str() == other.as_c_str()
    }
}

impl Eq for Text {}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.to_str().fmt(f)
    }
}

// SAFETY: `char *` in C, NUL-terminated or null, owned by what holds it.
unsafe impl Data for Text {
    const TYPE: *const TypeDescriptor = &plain::<Self>(Kind::STRING, 0, std::ptr::null());
}
