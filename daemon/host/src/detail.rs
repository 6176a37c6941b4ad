//! Details of exceptions: their types, and conversion between C memory and JSON. One of the few
//! unsafe modules.
#![allow(unsafe_code)]

use std::collections::HashMap;

use genom_types::{DataType, Record, foreign};
use serde_json::{Value, json};

use crate::what::WHAT;

/// Bytes of the message in `exception mwerr { string<256> what; };`.
pub(crate) const MWERR_WHAT: usize = 256;

/// Full name of the exception for what is not declared.
pub(crate) const UNKEX: &str = "::genom::unkex";
/// Full name of the exception for failures of a middleware.
pub(crate) const MWERR: &str = "::genom::mwerr";
/// Full name of the exception for system calls that fail.
pub(crate) const SYSERR: &str = "::genom::syserr";

/// Types of details for the exceptions that a component may throw or get, by full name.
#[derive(Debug, Default)]
pub(crate) struct Details {
    types: HashMap<String, Option<DataType>>,
}

impl Details {
    /// Adds an exception; one without members has no detail.
    pub(crate) fn add(&mut self, name: String, ty: Option<DataType>) {
        self.types.insert(name, ty);
    }

    /// Names of the exceptions.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.types.keys().map(String::as_str)
    }

    /// The exceptions and the types of their details.
    pub(crate) fn types(&self) -> impl Iterator<Item = (&str, Option<&DataType>)> {
        self.types.iter().map(|(name, ty)| (name.as_str(), ty.as_ref()))
    }

    /// Whether `name` is an exception, declared or of the C run time.
    pub(crate) fn is_exception(&self, name: &str) -> bool {
        matches!(name, UNKEX | MWERR | SYSERR) || self.types.contains_key(name)
    }

    /// Whether the detail of exception `name` contains no pointers.
    pub(crate) fn is_plain(&self, name: &str) -> bool {
        self.types.get(name).and_then(Option::as_ref).is_none_or(DataType::is_fixed_size)
    }

    /// Size of the largest detail in bytes.
    pub(crate) fn room(&self) -> usize {
        self.types.values().flatten().map(DataType::size).max().unwrap_or(0).max(MWERR_WHAT)
    }

    /// Converts the detail of exception `name`, the first `size` bytes of `words`.
    pub(crate) fn to_json(&self, name: &str, words: &[u64], size: usize) -> Option<Value> {
        let bytes = || words.iter().flat_map(|word| word.to_ne_bytes()).take(size);
        match name {
            UNKEX | MWERR => {
                let what: Vec<u8> = bytes().take_while(|byte| *byte != 0).collect();
                Some(json!({ "what": String::from_utf8_lossy(&what) }))
            }
            SYSERR => {
                let code: Vec<u8> = bytes().take(4).collect();
                let code = i32::from_ne_bytes(code.try_into().ok()?);
                Some(json!({ "code": code }))
            }
            _ => {
                let ty = self.types.get(name)?.as_ref()?;
                // A codel may record only part of the struct: the rest is zero.
                let mut whole = vec![0_u64; ty.size().div_ceil(8).max(1)];
                let words_used = size.min(ty.size()).div_ceil(8);
                whole[..words_used].copy_from_slice(words.get(..words_used)?);
                let mut record = Record::new(ty);
                // SAFETY: the codel recorded a value of this type (genom3.md 5.4), which the words
                // align; what it points to is read before the codel runs again.
                unsafe {
                    foreign::copy_value(ty, whole.as_ptr().cast(), record.as_mut_ptr());
                }
                Some(record.to_json())
            }
        }
    }

    /// Makes the detail of exception `name` in C layout; `None` when it has none.
    pub(crate) fn make(&self, name: &str, detail: &Value) -> Option<Detail> {
        match name {
            UNKEX => {
                let mut what = [0; WHAT];
                let text = detail.get("what").and_then(Value::as_str).unwrap_or_default();
                put_text(&mut what, text);
                Some(Detail::Bytes(what.to_vec()))
            }
            SYSERR => {
                let code = detail.get("code").and_then(Value::as_i64).unwrap_or_default();
                let code = i32::try_from(code).unwrap_or_default();
                Some(Detail::Bytes(code.to_ne_bytes().to_vec()))
            }
            _ => {
                let mut record = Record::new(self.types.get(name)?.as_ref()?);
                if let Err(why) = record.merge_json(detail) {
                    tracing::warn!("detail of exception {name}: {why}");
                }
                Some(Detail::Record(record))
            }
        }
    }
}

/// Writes as much of `text` as fits, and keeps the last byte NUL.
pub(crate) fn put_text(into: &mut [u8], text: &str) {
    let room = into.len().saturating_sub(1);
    let fits = |end: &usize| *end <= room;
    let ends = text.char_indices().map(|(at, c)| at + c.len_utf8());
    let length = ends.take_while(fits).last().unwrap_or(0);
    into[..length].copy_from_slice(&text.as_bytes()[..length]);
}

/// A detail in C layout.
pub(crate) enum Detail {
    /// Of an exception of the C run time.
    Bytes(Vec<u8>),
    /// Of a declared exception.
    Record(Record),
}

impl Detail {
    /// The bytes to record; pointers in them are valid as long as the detail lives.
    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Bytes(bytes) => bytes,
            // SAFETY: a record has as many bytes as its type; padding was zeroed with the rest.
            Self::Record(record) => unsafe {
                std::slice::from_raw_parts(record.as_ptr(), record.ty().size())
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_cut_between_characters_and_keeps_its_nul() {
        let mut into = [0; 4];
        put_text(&mut into, "aé€");
        assert_eq!(&into, b"a\xc3\xa9\0");
        let mut into = [0; 3];
        put_text(&mut into, "a€");
        assert_eq!(&into, b"a\0\0");
    }
}
