//! A bottle as a tree, for short ones.

use super::reader::{Item, List, Reader};
use super::{NoBottle, tag};

/// A value in a bottle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Int(i64),
    Float(f64),
    Vocab(u32),
    Text(String),
    Blob(Vec<u8>),
    List(Vec<Value>),
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl Value {
    /// A vocab of at most four letters, as `[add]`.
    pub(crate) fn vocab(word: &str) -> Self {
        Self::Vocab(word_of(word).unwrap_or_default())
    }

    /// The text, or the letters of a vocab.
    pub(crate) fn as_word(&self) -> Option<String> {
        match self {
            Self::Text(text) => Some(text.clone()),
            Self::Vocab(word) => Some(letters(*word)),
            _ => None,
        }
    }

    /// The values of a bottle.
    pub(crate) fn read(bottle: &[u8]) -> Result<Vec<Value>, NoBottle> {
        let (mut reader, list) = Reader::open(bottle)?;
        let values = read_list(&mut reader, list)?;
        reader.end()?;
        Ok(values)
    }

    /// The bottle of these values.
    pub(crate) fn to_bottle(values: &[Value]) -> Vec<u8> {
        let mut out = Vec::new();
        write_list(values, &mut out);
        out
    }

    fn tag(&self) -> u32 {
        match self {
            Self::Int(value) if i32::try_from(*value).is_ok() => tag::INT32,
            Self::Int(_) => tag::INT64,
            Self::Float(_) => tag::FLOAT64,
            Self::Vocab(_) => tag::VOCAB,
            Self::Text(_) => tag::STRING,
            Self::Blob(_) => tag::BLOB,
            Self::List(_) => tag::LIST,
        }
    }

    fn write(&self, out: &mut Vec<u8>) {
        match self {
            Self::Int(value) => match i32::try_from(*value) {
                Ok(short) => out.extend_from_slice(&short.to_le_bytes()),
                Err(_) => out.extend_from_slice(&value.to_le_bytes()),
            },
            Self::Float(value) => out.extend_from_slice(&value.to_le_bytes()),
            Self::Vocab(word) => out.extend_from_slice(&word.to_le_bytes()),
            Self::Text(text) => write_sized(text.as_bytes(), out),
            Self::Blob(bytes) => write_sized(bytes, out),
            Self::List(_) => {}
        }
    }
}

fn write_sized(bytes: &[u8], out: &mut Vec<u8>) {
    out.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
    out.extend_from_slice(bytes);
}

fn write_list(values: &[Value], out: &mut Vec<u8>) {
    let first = values.first().map_or(tag::LIST, Value::tag);
    let same = first != tag::LIST && values.iter().all(|value| value.tag() == first);
    let code = if same { tag::LIST | first } else { tag::LIST };
    out.extend_from_slice(&code.to_le_bytes());
    out.extend_from_slice(&(values.len() as u32).to_le_bytes());
    for value in values {
        match value {
            Value::List(values) => write_list(values, out),
            value => {
                if !same {
                    out.extend_from_slice(&value.tag().to_le_bytes());
                }
                value.write(out);
            }
        }
    }
}

fn read_list(reader: &mut Reader<'_>, mut list: List) -> Result<Vec<Value>, NoBottle> {
    let mut values = Vec::new();
    while let Some(item) = reader.next(&mut list)? {
        values.push(match item {
            Item::Int(value) => Value::Int(value),
            Item::Float(value) => Value::Float(value),
            Item::Vocab(word) => Value::Vocab(word),
            Item::Text(text) => Value::Text(String::from_utf8_lossy(text).into_owned()),
            Item::Blob(bytes) => Value::Blob(bytes.to_vec()),
            Item::List(inner) => Value::List(read_list(reader, inner)?),
        });
    }
    reader.leave();
    Ok(values)
}

/// The number of a vocab.
pub(super) fn word_of(word: &str) -> Option<u32> {
    let mut bytes = [0; 4];
    bytes.get_mut(..word.len())?.copy_from_slice(word.as_bytes());
    Some(u32::from_le_bytes(bytes))
}

/// The letters of a vocab.
pub(super) fn letters(word: u32) -> String {
    let bytes = word.to_le_bytes();
    let letters = bytes.iter().filter(|byte| **byte != 0);
    letters.map(|byte| if byte.is_ascii_graphic() { char::from(*byte) } else { '?' }).collect()
}
