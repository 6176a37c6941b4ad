//! Reads a bottle value by value. The bytes are not trusted.

use super::{MOST_DEPTH, NoBottle, tag};

/// Bytes of a bottle, and how far they were read.
#[derive(Clone, Debug)]
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    depth: usize,
}

/// What is left of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct List {
    pub(crate) left: u32,
    /// The tag that all elements share, if they do.
    pub(crate) common: Option<u32>,
}

/// A value. The elements of a list follow: who takes a list reads them, or gives the bottle up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Item<'a> {
    Int(i64),
    Float(f64),
    Vocab(u32),
    Text(&'a [u8]),
    Blob(&'a [u8]),
    List(List),
}

impl Item<'_> {
    /// What it is, for an error.
    pub(crate) fn described(&self) -> String {
        match self {
            Self::Int(value) => format!("the integer {value}"),
            Self::Float(value) => format!("the number {value:?}"),
            Self::Vocab(_) => "a vocab".to_owned(),
            Self::Text(text) => {
                let shown: String = String::from_utf8_lossy(text).chars().take(32).collect();
                format!("the text {shown:?}")
            }
            Self::Blob(bytes) => format!("a blob of {} bytes", bytes.len()),
            Self::List(list) => format!("a list of {}", list.left),
        }
    }
}

impl<'a> Reader<'a> {
    /// Begins to read a bottle.
    pub(crate) fn open(bytes: &'a [u8]) -> Result<(Self, List), NoBottle> {
        let mut reader = Self { bytes, at: 0, depth: 0 };
        let code = reader.word()?;
        if code & tag::LIST == 0 {
            return Err(NoBottle::Tag(code));
        }
        let list = reader.list(code)?;
        Ok((reader, list))
    }

    /// Takes the next value out of a list; `None` at its end.
    pub(crate) fn next(&mut self, list: &mut List) -> Result<Option<Item<'a>>, NoBottle> {
        let Some(left) = list.left.checked_sub(1) else { return Ok(None) };
        list.left = left;
        let tag = match list.common {
            Some(tag) => tag,
            None => self.word()?,
        };
        self.value(tag).map(Some)
    }

    /// Marks the end of a list whose elements were all read.
    pub(crate) fn leave(&mut self) {
        self.depth = self.depth.saturating_sub(1);
    }

    /// The end of the outermost list is the end of the bytes.
    pub(crate) fn end(&self) -> Result<(), NoBottle> {
        if self.at == self.bytes.len() { Ok(()) } else { Err(NoBottle::Long) }
    }

    pub(crate) fn take(&mut self, bytes: usize) -> Result<&'a [u8], NoBottle> {
        let end = self.at.checked_add(bytes).ok_or(NoBottle::Cut)?;
        let taken = self.bytes.get(self.at..end).ok_or(NoBottle::Cut)?;
        self.at = end;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], NoBottle> {
        self.take(N)?.try_into().map_err(|_| NoBottle::Cut)
    }

    fn word(&mut self) -> Result<u32, NoBottle> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn length(&mut self) -> Result<u32, NoBottle> {
        let length = self.word()?;
        if i32::try_from(length).is_ok() { Ok(length) } else { Err(NoBottle::Negative) }
    }

    fn list(&mut self, code: u32) -> Result<List, NoBottle> {
        self.depth += 1;
        if self.depth > MOST_DEPTH {
            return Err(NoBottle::Deep);
        }
        let left = self.length()?;
        let common = Some(code & !tag::LIST).filter(|tag| *tag != 0);
        Ok(List { left, common })
    }

    fn value(&mut self, code: u32) -> Result<Item<'a>, NoBottle> {
        Ok(match code {
            tag::INT8 => Item::Int(i8::from_le_bytes(self.array()?).into()),
            tag::INT16 => Item::Int(i16::from_le_bytes(self.array()?).into()),
            tag::INT32 => Item::Int(i32::from_le_bytes(self.array()?).into()),
            tag::INT64 => Item::Int(i64::from_le_bytes(self.array()?)),
            tag::FLOAT32 => Item::Float(f32::from_le_bytes(self.array()?).into()),
            tag::FLOAT64 => Item::Float(f64::from_le_bytes(self.array()?)),
            tag::VOCAB => Item::Vocab(self.word()?),
            tag::STRING => {
                let length = self.length()? as usize;
                Item::Text(self.take(length)?)
            }
            tag::BLOB => {
                let length = self.length()? as usize;
                Item::Blob(self.take(length)?)
            }
            code if code & tag::LIST != 0 => Item::List(self.list(code)?),
            other => return Err(NoBottle::Tag(other)),
        })
    }
}
