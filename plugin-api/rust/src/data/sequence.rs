//! Sequences.

use std::ffi::c_void;
use std::fmt;
use std::ops::{Deref, DerefMut};

use super::{Aggregate, Data, plain};
use crate::abi::{Kind, TypeDescriptor};
use crate::memory;

/// `sequence<T>`: any number of elements in C memory. It is used as a slice.
///
/// ```
/// use genom::Sequence;
///
/// let mut ranges: Sequence<f64> = [0.5, 1.5].into_iter().collect();
/// ranges.push(4.0);
/// assert_eq!(ranges.iter().sum::<f64>(), 6.0);
/// ```
#[repr(C)]
pub struct Sequence<T> {
    maximum: u32,
    length: u32,
    buffer: *mut T,
    release: Option<unsafe extern "C" fn(*mut c_void)>,
}

// SAFETY: it owns its elements, like a `Vec<T>`.
unsafe impl<T: Send> Send for Sequence<T> {}
// SAFETY: shared, it is only read.
unsafe impl<T: Sync> Sync for Sequence<T> {}

impl<T: Data> Sequence<T> {
    /// Allocates room for exactly `maximum` elements; further elements are dropped.
    pub fn reserve_exact(&mut self, maximum: u32) {
        self.truncate(maximum);
        let length = self.len();
        let fresh = Self {
            maximum,
            length: self.length.min(maximum),
            buffer: memory::zeroed(maximum as usize),
            release: Some(memory::FREE),
        };
        if length > 0 {
            // SAFETY: both buffers hold `length` elements or more, and they are apart. The
            // elements move: the old buffer is released without them.
            unsafe { std::ptr::copy_nonoverlapping(self.buffer, fresh.buffer, length) };
        }
        let old = std::mem::replace(self, fresh);
        old.release_buffer();
        std::mem::forget(old);
    }

    /// Appends an element, and allocates room if needed.
    pub fn push(&mut self, value: T) {
        let length = self.len();
        // A buffer without a release function may be static memory: the elements are copied to a
        // new one.
        if length >= self.maximum as usize || self.release.is_none() {
            self.reserve_exact(u32::try_from(length).unwrap_or(u32::MAX).saturating_mul(2).max(4));
        }
        // SAFETY: the buffer has room for `maximum > length` elements; the one at `length` is
        // valid, zeroed or left by C code, and owns nothing that anyone counts on.
        unsafe { self.buffer.add(length).write(value) };
        self.length += 1;
    }

    /// Drops the elements beyond the first `length`.
    pub fn truncate(&mut self, length: u32) {
        let (from, to) = (length as usize, self.len());
        if from >= to {
            return;
        }
        self.length = length;
        if self.release.is_some() {
            for index in from..to {
                // SAFETY: elements `from..to` are initialised, and no longer part of `self`.
                unsafe { self.buffer.add(index).drop_in_place() };
            }
        }
    }

    /// Drops the elements, and keeps the allocated memory.
    pub fn clear(&mut self) {
        self.truncate(0);
    }
}

impl<T> Sequence<T> {
    fn len(&self) -> usize {
        if self.buffer.is_null() { 0 } else { self.length.min(self.maximum) as usize }
    }

    fn release_buffer(&self) {
        if let Some(release) = self.release
            && !self.buffer.is_null()
        {
            // SAFETY: whoever set the buffer also set the function that takes it back
            // (genom3.md 5.2); the caller no longer uses it.
            unsafe { release(self.buffer.cast()) };
        }
    }
}

impl<T> Deref for Sequence<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match self.len() {
            0 => &[],
            // SAFETY: the buffer holds `maximum >= len` elements, initialised by the C mapping.
            length => unsafe { std::slice::from_raw_parts(self.buffer, length) },
        }
    }
}

impl<T> DerefMut for Sequence<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match self.len() {
            0 => &mut [],
            // SAFETY: as above, and `self` is borrowed exclusively.
            length => unsafe { std::slice::from_raw_parts_mut(self.buffer, length) },
        }
    }
}

impl<T> Drop for Sequence<T> {
    fn drop(&mut self) {
        // Without a release function, buffer and elements belong to somebody else.
        if self.release.is_some() {
            let elements: *mut [T] = &mut **self;
            // SAFETY: the elements are initialised, and gone with the buffer.
            unsafe { elements.drop_in_place() };
            self.release_buffer();
        }
    }
}

impl<T> Default for Sequence<T> {
    fn default() -> Self {
        Self { maximum: 0, length: 0, buffer: std::ptr::null_mut(), release: None }
    }
}

impl<T: Data> FromIterator<T> for Sequence<T> {
    fn from_iter<I: IntoIterator<Item = T>>(elements: I) -> Self {
        let mut sequence = Self::default();
        elements.into_iter().for_each(|element| sequence.push(element));
        sequence
    }
}

impl<T: Data + Clone> Clone for Sequence<T> {
    fn clone(&self) -> Self {
        self.iter().cloned().collect()
    }
}

impl<T: PartialEq> PartialEq for Sequence<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: fmt::Debug> fmt::Debug for Sequence<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

// SAFETY: `struct { uint32_t _maximum, _length; T *_buffer; void (*_release)(void *); }` in C,
// empty when all bytes are zero.
unsafe impl<T: Data> Data for Sequence<T> {
    const TYPE: *const TypeDescriptor = &plain::<Self>(Kind::SEQUENCE, 0, T::TYPE);
}

impl<T: Data> Aggregate for Sequence<T> {}

/// `sequence<T, N>`: at most N elements, in place.
///
/// ```
/// use genom::BoundedSequence;
///
/// let mut latest = BoundedSequence::<i32, 2>::default();
/// assert_eq!((latest.push(7), latest.push(8)), (Ok(()), Ok(())));
/// assert_eq!(latest.push(9), Err(9), "there is no room for a third");
/// ```
#[derive(Clone, Copy)]
#[repr(C)]
pub struct BoundedSequence<T, const N: usize> {
    maximum: u32,
    length: u32,
    buffer: [T; N],
}

impl<T, const N: usize> BoundedSequence<T, N> {
    /// Appends an element.
    ///
    /// # Errors
    /// Returns the element if there is no room for it.
    pub fn push(&mut self, value: T) -> Result<(), T> {
        let length = self.len();
        match self.buffer.get_mut(length) {
            Some(slot) => {
                *slot = value;
                self.length += 1;
                Ok(())
            }
            None => Err(value),
        }
    }

    /// Makes the sequence `length` elements long; those that are added are copies of `value`.
    ///
    /// # Errors
    /// Returns `length` if it is more than N; the sequence is as before.
    ///
    /// ```
    /// use genom::BoundedSequence;
    ///
    /// let mut row = BoundedSequence::<u8, 4>::default();
    /// assert_eq!(row.resize(3, 7), Ok(()));
    /// assert_eq!(*row, [7, 7, 7]);
    /// assert_eq!(row.resize(5, 7), Err(5));
    /// ```
    pub fn resize(&mut self, length: usize, value: T) -> Result<(), usize>
    where
        T: Copy,
    {
        let before = self.len();
        let Ok(count) = u32::try_from(length) else { return Err(length) };
        let Some(elements) = self.buffer.get_mut(..length) else { return Err(length) };
        if let Some(added) = elements.get_mut(before..) {
            added.fill(value);
        }
        self.length = count;
        Ok(())
    }

    /// Removes all elements.
    pub fn clear(&mut self) {
        self.length = 0;
    }

    fn len(&self) -> usize {
        (self.length as usize).min(N)
    }
}

impl<T, const N: usize> Deref for BoundedSequence<T, N> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.buffer[..self.len()]
    }
}

impl<T, const N: usize> DerefMut for BoundedSequence<T, N> {
    fn deref_mut(&mut self) -> &mut [T] {
        let length = self.len();
        &mut self.buffer[..length]
    }
}

impl<T: Default, const N: usize> Default for BoundedSequence<T, N> {
    fn default() -> Self {
        let maximum = const {
            assert!(N <= u32::MAX as usize, "the bound of a sequence is a 32-bit number");
            N as u32
        };
        Self { maximum, length: 0, buffer: std::array::from_fn(|_| T::default()) }
    }
}

impl<T: PartialEq, const N: usize> PartialEq for BoundedSequence<T, N> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: fmt::Debug, const N: usize> fmt::Debug for BoundedSequence<T, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

// SAFETY: `struct { const uint32_t _maximum; uint32_t _length; T _buffer[N]; }` in C; lengths
// beyond N are cut when they are read.
unsafe impl<T: Data, const N: usize> Data for BoundedSequence<T, N> {
    const TYPE: *const TypeDescriptor = &plain::<Self>(Kind::SEQUENCE, N, T::TYPE);
}

impl<T: Data, const N: usize> Aggregate for BoundedSequence<T, N> {}
