//! Strings, bytes and error buffers that one side lends to the other for the time of a call, and
//! tables that may be shorter than they are known here.

use std::borrow::Cow;
use std::ffi::c_char;
use std::ptr;
use std::slice;

use crate::codes::{Code, Failure};

/// A string: UTF-8, not terminated.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Str {
    /// Where it begins; may be null if it is empty.
    pub ptr: *const c_char,
    /// Its length in bytes.
    pub len: usize,
}

/// Bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Bytes {
    /// Where they begin; may be null if there are none.
    pub ptr: *const u8,
    /// How many.
    pub len: usize,
}

/// The buffer of a caller for the text of an error.
#[repr(C)]
#[derive(Debug)]
pub struct ErrorText {
    /// Size of this structure.
    pub size: usize,
    /// The buffer.
    pub text: *mut c_char,
    /// Its size.
    pub room: usize,
    /// Bytes written.
    pub len: usize,
    /// Nanoseconds of a time-out.
    pub value: u64,
}

impl Str {
    /// A string that lives as long as the caller has it.
    #[must_use]
    pub const fn of(text: &str) -> Self {
        Self { ptr: text.as_ptr().cast(), len: text.len() }
    }

    /// The string; what is not UTF-8 is replaced.
    ///
    /// # Safety
    /// The string is one, and lives and does not change while the result is used.
    #[must_use]
    pub unsafe fn read<'a>(self) -> Cow<'a, str> {
        // SAFETY: as for this function.
        String::from_utf8_lossy(unsafe { Bytes { ptr: self.ptr.cast(), len: self.len }.read() })
    }
}

impl Bytes {
    /// Bytes that live as long as the caller has them.
    #[must_use]
    pub const fn of(bytes: &[u8]) -> Self {
        Self { ptr: bytes.as_ptr(), len: bytes.len() }
    }

    /// The bytes.
    ///
    /// # Safety
    /// The bytes are readable, and live and do not change while the result is used.
    #[must_use]
    pub unsafe fn read<'a>(self) -> &'a [u8] {
        if self.ptr.is_null() || self.len == 0 {
            return &[];
        }
        // SAFETY: not null; the caller vouches for the rest.
        unsafe { slice::from_raw_parts(self.ptr, self.len) }
    }
}

impl ErrorText {
    /// An empty error with this buffer.
    pub fn new(buffer: &mut [u8]) -> Self {
        let (text, room) = (buffer.as_mut_ptr().cast(), buffer.len());
        Self { size: size_of::<Self>(), text, room, len: 0, value: 0 }
    }

    /// The failure that a function reported with this code, if it did.
    ///
    /// # Safety
    /// This was made by [`new`](Self::new) with a buffer that is still there.
    #[must_use]
    pub unsafe fn read(&self, code: Code) -> Option<Failure> {
        let len = self.len.min(self.room);
        // SAFETY: the buffer has `room` bytes.
        let text = unsafe { Str { ptr: self.text, len }.read() };
        (code != Code::OK).then(|| Failure { code, text: text.into_owned(), value: self.value })
    }

    /// Writes a failure into the error of a caller, cut where it does not fit.
    ///
    /// # Safety
    /// `to` is null, or an error whose text has `room` writable bytes.
    pub unsafe fn write(to: *mut Self, failure: &Failure) {
        // SAFETY: as for this function.
        let Some(error) = (unsafe { to.as_mut() }) else { return };
        if error.size < size_of::<Self>() {
            return;
        }
        error.value = failure.value;
        let len = (0..=failure.text.len().min(error.room))
            .rev()
            .find(|len| failure.text.is_char_boundary(*len))
            .unwrap_or(0);
        error.len = if error.text.is_null() { 0 } else { len };
        // SAFETY: the text has that many bytes, and the buffer room for them; they do not overlap,
        // because the text is a string of ours.
        unsafe { ptr::copy_nonoverlapping(failure.text.as_ptr(), error.text.cast(), error.len) };
    }
}

/// A structure of the other side, which begins with its size and may be shorter than `T`: what it
/// has not is zero, that is null, none or 0.
///
/// # Safety
/// `from` is readable for the size that its first word states. Zero is a value of all members of
/// `T`, which begins with its size.
#[must_use]
pub unsafe fn copied<T: Copy>(from: *const T) -> Option<T> {
    if from.is_null() {
        return None;
    }
    // SAFETY: all structures begin with their size.
    let size = unsafe { from.cast::<usize>().read() }.min(size_of::<T>());
    // SAFETY: zero is a value, says the caller.
    let mut copy: T = unsafe { std::mem::zeroed() };
    // SAFETY: `size` bytes are readable there, and there is room for them here.
    unsafe { ptr::copy_nonoverlapping(from.cast::<u8>(), (&raw mut copy).cast(), size) };
    Some(copy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_does_not_fit_is_cut_between_characters() {
        let mut buffer = [0; 6];
        let mut error = ErrorText::new(&mut buffer);
        let failure = Failure { code: Code::FAILED, text: "trop élevé".into(), value: 3 };
        // SAFETY: the error has a buffer.
        unsafe { ErrorText::write(&raw mut error, &failure) };
        // SAFETY: as above.
        let read = unsafe { error.read(Code::FAILED) }.unwrap();
        assert_eq!((read.text.as_str(), read.value), ("trop ", 3));
        // SAFETY: as above.
        assert!(unsafe { error.read(Code::OK) }.is_none());
        // SAFETY: null is allowed.
        unsafe { ErrorText::write(ptr::null_mut(), &failure) };
    }

    #[test]
    fn a_shorter_structure_is_read_as_far_as_it_goes() {
        #[repr(C)]
        #[derive(Clone, Copy)]
        struct Three {
            size: usize,
            two: usize,
            three: Option<extern "C" fn()>,
        }
        extern "C" fn nothing() {}
        let mut from = Three { size: 16, two: 2, three: Some(nothing) };
        // SAFETY: it states its size, or less.
        let copy = unsafe { copied(&raw const from) }.unwrap();
        assert!(copy.two == 2 && copy.three.is_none() && copy.size == 16);
        from.size = 100;
        // SAFETY: more than is known here is not read.
        assert!(unsafe { copied(&raw const from) }.unwrap().three.is_some());
        // SAFETY: null is no structure.
        assert!(unsafe { copied(ptr::null::<Three>()) }.is_none());
    }
}
