//! Samples in CDR to bottles.
//!
//! A struct is a list of its members, an array or a sequence a list of its elements, octets are a
//! blob, an enumerator is its name. What is no list is the only value of its bottle.

use genom_types::{DataType, Kind, Label, TypeId, TypeTable};

use super::cdr::CdrReader;
pub(crate) use super::cdr::Cut;
use super::{tag, width};

/// Appends the bottle of a sample.
pub(crate) fn append(ty: &DataType, message: &[u8], out: &mut Vec<u8>) -> Result<(), Cut> {
    let mut encoder = Encoder { table: ty.table(), cdr: CdrReader::new(message)?, out };
    if is_list(ty.table(), ty.id()) {
        encoder.list(ty.id())?;
    } else {
        encoder.one(ty.id())?;
    }
    Ok(())
}

/// The bottle of some words, and of the members of a struct after them.
pub(crate) fn after(
    words: &[&str],
    ty: &DataType,
    message: &[u8],
    out: &mut Vec<u8>,
) -> Result<(), Cut> {
    let start = out.len();
    let mut encoder = Encoder { table: ty.table(), cdr: CdrReader::new(message)?, out };
    encoder.word(tag::LIST);
    encoder.word(0);
    let mut tags = Tags::default();
    for word in words {
        tags.add(encoder.sized(tag::STRING, word.as_bytes())?);
    }
    match ty.table().resolved(ty.id()) {
        Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
            for member in members {
                tags.add(encoder.element(member.ty)?);
            }
        }
        _ => tags.add(encoder.element(ty.id())?),
    }
    encoder.close(start, tags);
    Ok(())
}

/// Whether values of the type are lists.
pub(super) fn is_list(table: &TypeTable, id: TypeId) -> bool {
    match table.resolved(id) {
        Kind::Array { element, .. } | Kind::Sequence { element, .. } => {
            !matches!(table.resolved(*element), Kind::Octet)
        }
        Kind::Struct { .. }
        | Kind::Exception { .. }
        | Kind::Union { .. }
        | Kind::Optional { .. } => true,
        _ => false,
    }
}

/// The member of a union that a discriminant selects.
pub(super) fn selected(union: &Kind, value: i128) -> Option<TypeId> {
    let Kind::Union { members, .. } = union else { return None };
    let labelled = |wanted: Label| {
        members.iter().find(|member| member.labels.contains(&wanted)).map(|member| member.ty)
    };
    labelled(Label::Value(value)).or_else(|| labelled(Label::Default))
}

/// Numbers that are in CDR as in a bottle: their tag and size.
pub(super) fn as_it_is(kind: &Kind) -> Option<(u32, usize)> {
    Some(match kind {
        Kind::Char => (tag::INT8, 1),
        Kind::Short => (tag::INT16, 2),
        Kind::Long => (tag::INT32, 4),
        Kind::LongLong | Kind::UnsignedLongLong => (tag::INT64, 8),
        Kind::Float => (tag::FLOAT32, 4),
        Kind::Double => (tag::FLOAT64, 8),
        _ => return None,
    })
}

struct Encoder<'a, 'm> {
    table: &'a TypeTable,
    cdr: CdrReader<'m>,
    out: &'a mut Vec<u8>,
}

impl Encoder<'_, '_> {
    fn word(&mut self, word: u32) {
        self.out.extend_from_slice(&word.to_le_bytes());
    }

    fn set(&mut self, place: usize, word: u32) {
        if let Some(room) = self.out.get_mut(place..place + 4) {
            room.copy_from_slice(&word.to_le_bytes());
        }
    }

    /// A list with the tags of its elements; tags that are all the same are taken out, as YARP
    /// does.
    fn list(&mut self, id: TypeId) -> Result<(), Cut> {
        let start = self.out.len();
        self.word(tag::LIST);
        self.word(0);
        let table = self.table;
        let kind = table.resolved(id);
        let mut tags = Tags::default();
        match kind {
            Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                for member in members {
                    tags.add(self.element(member.ty)?);
                }
            }
            Kind::Array { element, length } => {
                return self.elements(start, *element, *length as usize);
            }
            Kind::Sequence { element, .. } => {
                let length = self.cdr.length()?;
                return self.elements(start, *element, length);
            }
            Kind::Optional { element } => {
                for _ in 0..self.cdr.length()? {
                    tags.add(self.element(*element)?);
                }
            }
            Kind::Union { discriminant, .. } => {
                let value = self.discriminant(*discriminant, &mut tags)?;
                if let Some(member) = selected(kind, value) {
                    tags.add(self.element(member)?);
                }
            }
            _ => {}
        }
        self.close(start, tags);
        Ok(())
    }

    /// A bottle with a single value.
    fn one(&mut self, id: TypeId) -> Result<(), Cut> {
        let start = self.out.len();
        self.word(tag::LIST);
        self.word(0);
        let mut tags = Tags::default();
        tags.add(self.element(id)?);
        self.close(start, tags);
        Ok(())
    }

    fn close(&mut self, start: usize, tags: Tags) {
        self.set(start + 4, tags.count);
        if let Some(common) = tags.common.filter(|tag| tag & tag::LIST == 0) {
            self.set(start, tag::LIST | common);
            self.untag(start + 8, common, tags.count);
        }
    }

    /// Takes the tags out of `count` values that begin at `from`.
    fn untag(&mut self, from: usize, common: u32, count: u32) {
        let (mut read, mut write) = (from, from);
        for _ in 0..count {
            read += 4;
            let size = width(common).unwrap_or_else(|| {
                let length = self.out.get(read..read + 4).and_then(|word| word.try_into().ok());
                4 + length.map_or(0, u32::from_le_bytes) as usize
            });
            self.out.copy_within(read..read + size, write);
            (read, write) = (read + size, write + size);
        }
        self.out.truncate(write);
    }

    fn elements(&mut self, start: usize, element: TypeId, count: usize) -> Result<(), Cut> {
        let kind = self.table.resolved(element);
        let count_word = u32::try_from(count).map_err(|_| Cut)?;
        if let Some((tag, size)) = as_it_is(kind).filter(|_| self.cdr.is_little() && count > 0) {
            let bytes = self.cdr.bytes(size, size.checked_mul(count).ok_or(Cut)?)?;
            self.set(start, tag::LIST | tag);
            self.set(start + 4, count_word);
            self.out.extend_from_slice(bytes);
            return Ok(());
        }
        let mut tags = Tags::default();
        for _ in 0..count {
            tags.add(self.element(element)?);
        }
        self.close(start, tags);
        Ok(())
    }

    /// A value with its tag, which is returned.
    fn element(&mut self, id: TypeId) -> Result<u32, Cut> {
        let table = self.table;
        let kind = table.resolved(id);
        let start = self.out.len();
        let tag = match kind {
            Kind::Boolean => self.int32(|cdr| Ok(i32::from(u8::from_le_bytes(cdr.number()?))))?,
            Kind::Octet => self.int32(|cdr| Ok(i32::from(u8::from_le_bytes(cdr.number()?))))?,
            Kind::UnsignedShort => {
                self.int32(|cdr| Ok(i32::from(u16::from_le_bytes(cdr.number()?))))?
            }
            Kind::UnsignedLong => {
                let value = i64::from(u32::from_le_bytes(self.cdr.number()?));
                self.word(tag::INT64);
                self.out.extend_from_slice(&value.to_le_bytes());
                tag::INT64
            }
            Kind::Char => self.same::<1>(tag::INT8)?,
            Kind::Short => self.same::<2>(tag::INT16)?,
            Kind::Long => self.same::<4>(tag::INT32)?,
            Kind::LongLong | Kind::UnsignedLongLong => self.same::<8>(tag::INT64)?,
            Kind::Float => self.same::<4>(tag::FLOAT32)?,
            Kind::Double => self.same::<8>(tag::FLOAT64)?,
            Kind::String { .. } => {
                let text = self.cdr.text()?;
                self.sized(tag::STRING, text)?
            }
            Kind::Enum { enumerators, .. } => {
                let rank = self.cdr.length()?;
                let name = enumerators.get(rank).ok_or(Cut)?;
                self.sized(tag::STRING, name.as_bytes())?
            }
            Kind::Array { length, .. } if !is_list(table, id) => {
                let octets = self.cdr.bytes(1, *length as usize)?;
                self.sized(tag::BLOB, octets)?
            }
            Kind::Sequence { .. } if !is_list(table, id) => {
                let length = self.cdr.length()?;
                let octets = self.cdr.bytes(1, length)?;
                self.sized(tag::BLOB, octets)?
            }
            Kind::Native { .. } | Kind::Any | Kind::Typedef { .. } | Kind::Forward { .. } => {
                return Err(Cut);
            }
            _ => {
                self.list(id)?;
                let code = self.out.get(start..start + 4).and_then(|word| word.try_into().ok());
                code.map_or(tag::LIST, u32::from_le_bytes)
            }
        };
        Ok(tag)
    }

    fn int32(
        &mut self,
        read: impl FnOnce(&mut CdrReader<'_>) -> Result<i32, Cut>,
    ) -> Result<u32, Cut> {
        let value = read(&mut self.cdr)?;
        self.word(tag::INT32);
        self.out.extend_from_slice(&value.to_le_bytes());
        Ok(tag::INT32)
    }

    fn same<const N: usize>(&mut self, tag: u32) -> Result<u32, Cut> {
        let number = self.cdr.number::<N>()?;
        self.word(tag);
        self.out.extend_from_slice(&number);
        Ok(tag)
    }

    fn sized(&mut self, tag: u32, bytes: &[u8]) -> Result<u32, Cut> {
        self.word(tag);
        self.word(u32::try_from(bytes.len()).map_err(|_| Cut)?);
        self.out.extend_from_slice(bytes);
        Ok(tag)
    }

    fn discriminant(&mut self, id: TypeId, tags: &mut Tags) -> Result<i128, Cut> {
        let from = self.out.len();
        tags.add(self.element(id)?);
        let value = self.out.get(from + 4..).unwrap_or_default();
        Ok(match self.table.resolved(id) {
            Kind::Enum { enumerators, .. } => {
                let name = value.get(4..).unwrap_or_default();
                let rank = enumerators.iter().position(|one| one.as_bytes() == name);
                rank.map_or(-1, |rank| rank as i128)
            }
            Kind::UnsignedLongLong => {
                value.try_into().map(u64::from_le_bytes).map_err(|_| Cut)?.into()
            }
            _ => match *value {
                [a] => i8::from_le_bytes([a]).into(),
                [a, b] => i16::from_le_bytes([a, b]).into(),
                [a, b, c, d] => i32::from_le_bytes([a, b, c, d]).into(),
                _ => value.try_into().map(i64::from_le_bytes).map_err(|_| Cut)?.into(),
            },
        })
    }
}

/// The tags of a list's elements.
#[derive(Clone, Copy, Default)]
struct Tags {
    count: u32,
    common: Option<u32>,
}

impl Tags {
    fn add(&mut self, tag: u32) {
        self.common = if self.count == 0 { Some(tag) } else { self.common.filter(|it| *it == tag) };
        self.count += 1;
    }
}
