//! An owned value in C layout.

use std::collections::HashSet;
use std::mem::MaybeUninit;

use serde_json::Value;
use thiserror::Error;

use crate::cdr::{self, CdrError};
use crate::data_type::DataType;
use crate::json::{self, JsonError};
use crate::memory::{self, Edit, View};
use crate::room::{Room, Zones};

/// Two types whose values cannot be copied into each other.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("cannot copy a value of type {found} into one of type {expected}")]
pub struct TypeMismatch {
    /// Spelling of the target's type.
    pub expected: String,
    /// Spelling of the source's type.
    pub found: String,
}

/// Bytes that are not a value of a type.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum BytesError {
    /// The value has parts outside its own bytes: unbounded strings or sequences, or natives.
    #[error("{ty} has strings or sequences without bound; plain bytes cannot hold it, use CDR")]
    NotFixed {
        /// Spelling of the type.
        ty: String,
    },
    /// The number of bytes is not the size of the type.
    #[error("{ty} takes {expected} bytes, not {found}")]
    Size {
        /// Spelling of the type.
        ty: String,
        /// Size of the type.
        expected: usize,
        /// Number of bytes given.
        found: usize,
    },
    /// An enum out of range, or a sequence longer than its bound.
    #[error("the bytes of {ty} hold no value of {inner}: it is out of range")]
    Invalid {
        /// Spelling of the type.
        ty: String,
        /// Spelling of the type inside it that is wrong.
        inner: String,
    },
}

/// An owned value: C memory at an address that does not change while the record lives.
///
/// A new record is all zero, as genom3.md 7.9 asks, with `_maximum` of bounded sequences set.
/// Strings and buffers inside come from the C library's allocator, so codels may free and
/// replace them. Dropping it releases them, each buffer through its `_release`.
pub struct Record {
    ty: DataType,
    room: Room,
}

// SAFETY: the memory belongs to the record alone; it is shared for reading only, and changed
// through `&mut` only. Codels that reach it by pointer are serialised by the host (genom3.md 4.5).
unsafe impl Send for Record {}
// SAFETY: as above.
unsafe impl Sync for Record {}

impl Record {
    /// A new record, all zero but `_maximum` of bounded sequences.
    #[must_use]
    pub fn new(ty: &DataType) -> Self {
        let room = Room::new(ty.size());
        // SAFETY: the memory is zeroed and as large as the type.
        unsafe { memory::init(ty.graph(), ty.ix(), room.at()) };
        Self { ty: ty.clone(), room }
    }

    /// Type of the value.
    #[must_use]
    pub fn ty(&self) -> &DataType {
        &self.ty
    }

    /// Address of the value, the same for its whole life.
    #[must_use]
    pub fn as_ptr(&self) -> *const u8 {
        self.room.at()
    }

    /// Address of the value, to change it.
    #[must_use]
    pub fn as_mut_ptr(&mut self) -> *mut u8 {
        self.room.at()
    }

    /// The guard zones around the value, which show whether something was written past it.
    #[must_use]
    pub fn zones(&self) -> Zones {
        self.room.zones()
    }

    /// The bytes of the value in C layout; `None` when the type is not of fixed size.
    #[must_use]
    pub fn bytes(&self) -> Option<&[u8]> {
        // SAFETY: the record has that many bytes, all of them written since it was zeroed.
        self.ty
            .is_fixed_size()
            .then(|| unsafe { std::slice::from_raw_parts(self.as_ptr(), self.ty.size()) })
    }

    pub(crate) fn view(&self) -> View<'_> {
        // SAFETY: the record holds a value of its type, borrowed while the view lives.
        unsafe { View::new(self.ty.graph(), self.ty.ix(), self.as_ptr()) }
    }

    pub(crate) fn edit(&mut self) -> Edit<'_> {
        // SAFETY: the record holds a value of its type, borrowed while it is changed.
        unsafe { Edit::new(self.ty.graph(), self.ty.ix(), self.room.at()) }
    }

    /// Sets strings and sequences to null whose buffers are in `seen`, and adds the other buffers
    /// to `seen`.
    ///
    /// To be called before dropping records that codels may have assigned to each other in C, as in
    /// `ids->image = *port->data(self)`: memory that two of them point to is then released once.
    pub fn give_up_shared(&mut self, seen: &mut HashSet<usize>) {
        // SAFETY: the record holds a value of its type, borrowed while it is changed.
        unsafe { memory::give_up(self.ty.graph(), self.ty.ix(), self.room.at(), seen, 0) }
    }

    /// Makes this value equal to another, deep. Nothing is allocated for fixed-size types, nor
    /// for others whose buffers here are large enough already.
    ///
    /// # Errors
    /// The types differ by structure (genom3.md 4.3).
    pub fn copy_from(&mut self, from: &Record) -> Result<(), TypeMismatch> {
        if !self.ty.same_as(&from.ty) {
            let (expected, found) = (self.ty.name().to_owned(), from.ty.name().to_owned());
            return Err(TypeMismatch { expected, found });
        }
        // SAFETY: both hold values, of types with the same layout, at different places.
        unsafe {
            memory::copy(self.ty.graph(), self.ty.ix(), from.as_ptr(), self.room.at(), 0);
        }
        Ok(())
    }

    /// Sets the value of a fixed-size type from bytes in C layout. Booleans become 0 or 1 and
    /// `_maximum` as declared; on error nothing changes. Nothing is allocated.
    ///
    /// # Errors
    /// The type is not of fixed size, the size is wrong, an enum is out of range or a sequence
    /// longer than its bound.
    pub fn set_bytes(&mut self, bytes: &[u8]) -> Result<(), BytesError> {
        if !self.ty.is_fixed_size() {
            return Err(BytesError::NotFixed { ty: self.ty.name().to_owned() });
        }
        if bytes.len() != self.ty.size() {
            let (expected, found) = (self.ty.size(), bytes.len());
            return Err(BytesError::Size { ty: self.ty.name().to_owned(), expected, found });
        }
        let (graph, ix) = (self.ty.graph(), self.ty.ix());
        let wrong = |inner| BytesError::Invalid {
            ty: self.ty.name().to_owned(),
            inner: graph.node(inner).name.clone(),
        };
        // SAFETY: the bytes have the size of the type; they are only read.
        unsafe { memory::repair(graph, ix, bytes.as_ptr().cast_mut(), false) }.map_err(wrong)?;
        // SAFETY: both have that size; the type owns nothing that would have to be released.
        let repaired = unsafe {
            std::ptr::copy_nonoverlapping(bytes.as_ptr(), self.room.at(), bytes.len());
            memory::repair(graph, ix, self.room.at(), true)
        };
        // Reached only when another process changes the bytes while they are copied.
        repaired.map_err(|inner| {
            // SAFETY: the type owns nothing; zeros are a value.
            unsafe { memory::release(graph, ix, self.room.at(), 0) };
            wrong(inner)
        })
    }

    /// The value as JSON; see [`merge_json`](Record::merge_json) for the way back.
    #[must_use]
    pub fn to_json(&self) -> Value {
        json::write(self.view())
    }

    /// Sets what `json` gives and keeps the rest: partial objects, index-keyed objects for arrays
    /// and sequences (genom3.md appendix A). On error nothing changes.
    ///
    /// # Errors
    /// A member, type, range or bound is wrong; the error gives its path and what is accepted.
    pub fn merge_json(&mut self, json: &Value) -> Result<(), JsonError> {
        let mut copy = self.clone();
        json::merge(&mut copy.edit(), json)?;
        self.swap_values(&mut copy);
        Ok(())
    }

    /// The value as JSON that says all of it, but for `native` values: for files.
    #[must_use]
    pub fn to_exact_json(&self) -> json::Exact {
        json::exact::write(self.view())
    }

    /// Path of the first datum that none of `given` sets, as `goal.x[2]`; `None` when all are set.
    /// `given` are the JSON values that were merged into this value, the last merged first.
    /// Optionals may be left out.
    #[must_use]
    pub fn missing(&self, given: &[&Value]) -> Option<String> {
        json::missing(self.view(), given)
    }

    /// Whether two records of one type hold the same value, compared as JSON.
    #[must_use]
    pub fn holds_same(&self, other: &Record) -> bool {
        match (self.bytes(), other.bytes()) {
            (Some(own), Some(others)) if own == others => true,
            _ => self.to_json() == other.to_json(),
        }
    }

    /// Appends the value as a CDR payload, little endian (see [`cdr`]). On error `out` is as
    /// before.
    ///
    /// # Errors
    /// An enum is out of range, a string is no UTF-8, or a native is inside.
    pub fn encode_cdr(&self, out: &mut Vec<u8>) -> Result<(), CdrError> {
        self.encode_cdr_within(out.len(), out)
    }

    /// Appends the value to a CDR payload that begins at `start` in `out` and already holds other
    /// data: alignment counts from `start`. On error `out` is as before.
    ///
    /// # Errors
    /// As [`encode_cdr`](Record::encode_cdr).
    pub fn encode_cdr_within(&self, start: usize, out: &mut Vec<u8>) -> Result<(), CdrError> {
        // SAFETY: the record holds a value of its type, borrowed here.
        unsafe { cdr::encode(self.ty.graph(), self.ty.ix(), self.as_ptr(), start, out) }
    }

    /// Reads a little endian CDR payload; buffers that are large enough are reused. On error the
    /// record becomes empty.
    ///
    /// # Errors
    /// The bytes are no value of the type.
    pub fn decode_cdr(&mut self, payload: &[u8]) -> Result<(), CdrError> {
        self.decode(payload, 0, false)
    }

    /// Reads the value at byte `from` of a CDR payload, after other data. On error the record
    /// becomes empty.
    ///
    /// # Errors
    /// The bytes are no value of the type.
    pub fn decode_cdr_within(
        &mut self,
        payload: &[u8],
        from: usize,
        big_endian: bool,
    ) -> Result<(), CdrError> {
        self.decode(payload, from, big_endian)
    }

    /// Appends the 4-byte encapsulation header and the payload: a whole DDS or ROS 2 message.
    ///
    /// # Errors
    /// As [`encode_cdr`](Record::encode_cdr).
    pub fn encode_message(&self, out: &mut Vec<u8>) -> Result<(), CdrError> {
        let start = out.len();
        out.extend_from_slice(&cdr::HEADER);
        self.encode_cdr(out).inspect_err(|_| out.truncate(start))
    }

    /// Size in bytes of the message that [`encode_message`](Record::encode_message) appends.
    #[must_use]
    pub fn message_size(&self) -> usize {
        // SAFETY: the record holds a value of its type, borrowed here.
        let payload = unsafe { cdr::size(self.ty.graph(), self.ty.ix(), self.as_ptr()) };
        cdr::HEADER.len() + payload
    }

    /// Writes the message at the beginning of `room`; returns its size. `room` must be
    /// [`SLACK`](cdr::SLACK) bytes larger than [`message_size`](Record::message_size); the bytes
    /// after the message may be overwritten.
    ///
    /// # Errors
    /// As [`encode_cdr`](Record::encode_cdr), and when there is too little room.
    pub fn encode_message_to(&self, room: &mut [MaybeUninit<u8>]) -> Result<usize, CdrError> {
        let count = cdr::HEADER.len();
        let Some((header, payload)) = room.split_at_mut_checked(count) else {
            let problem = cdr::CdrProblem::Truncated { needed: count, left: room.len() };
            return Err(CdrError { ty: self.ty.name().to_owned(), at: 0, problem });
        };
        header.iter_mut().zip(cdr::HEADER).for_each(|(to, byte)| _ = to.write(byte));
        // SAFETY: the record holds a value of its type, borrowed here.
        let size =
            unsafe { cdr::encode_into(self.ty.graph(), self.ty.ix(), self.as_ptr(), payload)? };
        Ok(count + size)
    }

    /// Reads a message with its encapsulation header, in either byte order. On error the record
    /// becomes empty.
    ///
    /// # Errors
    /// The message is no plain CDR, or no value of the type.
    pub fn decode_message(&mut self, message: &[u8]) -> Result<(), CdrError> {
        let opened = cdr::open(&self.ty, message).inspect_err(|_| self.edit().clear());
        let (payload, big_endian) = opened?;
        self.decode(payload, 0, big_endian)
    }

    /// Reads a message as [`decode_message`](Record::decode_message), but on error the record keeps
    /// its value. `scratch` should be of the same type; its value afterwards is unspecified.
    ///
    /// When all bytes are valid values of the type (no boolean, enum, string and the like), they
    /// are copied once, directly from the message.
    ///
    /// # Errors
    /// The message is no plain CDR, or no value of the type.
    pub fn replace_from_message(
        &mut self,
        message: &[u8],
        scratch: &mut Record,
    ) -> Result<(), CdrError> {
        if let Some(size) = cdr::plain_size(&self.ty) {
            let (payload, big_endian) = cdr::open(&self.ty, message)?;
            if payload.len() < size {
                let problem = cdr::CdrProblem::Truncated { needed: size, left: payload.len() };
                return Err(CdrError { ty: self.ty.name().to_owned(), at: 0, problem });
            }
            return self.decode(payload, 0, big_endian);
        }
        if !scratch.ty.same_as(&self.ty) {
            *scratch = Record::new(&self.ty);
        }
        scratch.decode_message(message)?;
        if self.ty.is_fixed_size() {
            // Both are of one type: it cannot fail.
            let _ = self.copy_from(scratch);
        } else {
            self.swap_values(scratch);
        }
        Ok(())
    }

    fn decode(&mut self, payload: &[u8], from: usize, big_endian: bool) -> Result<(), CdrError> {
        let (graph, ix) = (self.ty.graph(), self.ty.ix());
        // SAFETY: the record holds a value of its type, borrowed here to be changed.
        let decoded = unsafe { cdr::decode(graph, ix, self.room.at(), payload, from, big_endian) };
        decoded.inspect_err(|_| self.clear())
    }

    /// Releases what the value owns; it is empty again.
    pub fn clear(&mut self) {
        self.edit().clear();
    }

    /// Exchanges the values of two records; both keep their addresses. Costs a copy of the C struct
    /// only: owned memory is not copied.
    ///
    /// # Errors
    /// The types differ by structure (genom3.md 4.3).
    pub fn swap(&mut self, other: &mut Record) -> Result<(), TypeMismatch> {
        if !self.ty.same_as(&other.ty) {
            let (expected, found) = (self.ty.name().to_owned(), other.ty.name().to_owned());
            return Err(TypeMismatch { expected, found });
        }
        self.swap_values(other);
        Ok(())
    }

    /// Exchanges the values of two records of one type; both keep their addresses.
    pub(crate) fn swap_values(&mut self, other: &mut Record) {
        // SAFETY: both have that size; what they own goes along with the bytes.
        unsafe {
            std::ptr::swap_nonoverlapping(self.room.at(), other.room.at(), self.ty.size());
        }
    }
}

impl Clone for Record {
    fn clone(&self) -> Self {
        let copy = Self::new(&self.ty);
        // SAFETY: both hold values of one type, at different places.
        unsafe {
            memory::copy(self.ty.graph(), self.ty.ix(), self.as_ptr(), copy.room.at(), 0);
        }
        copy
    }
}

impl Drop for Record {
    fn drop(&mut self) {
        self.clear();
    }
}

impl std::fmt::Debug for Record {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.ty)
    }
}
