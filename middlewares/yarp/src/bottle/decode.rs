//! Bottles to samples in CDR, led by the type. What does not fit is refused with its place.
//!
//! Numbers may be of another kind as long as nothing is lost: people type `1` for `1.0`.

use genom_types::{DataType, Kind, TypeId, TypeTable};

use super::NoBottle;
use super::cdr::CdrWriter;
use super::encode::{as_it_is, is_list, selected};
use super::reader::{Item, List, Reader};

/// A bottle that is no value of a type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Misfit {
    #[error("it is no bottle: {0}")]
    NoBottle(#[from] NoBottle),
    #[error("{place} wants {wanted}, not {found}")]
    Value { place: String, wanted: String, found: String },
    #[error("{place} wants {wanted}, and nothing is left")]
    Missing { place: String, wanted: String },
    #[error("{place} has {found} too many: it wants {wanted}")]
    TooMany { place: String, wanted: String, found: u32 },
}

/// Makes the message of a bottle in `out`.
pub(crate) fn message(ty: &DataType, bottle: &[u8], out: &mut Vec<u8>) -> Result<(), Misfit> {
    let (mut reader, mut list) = Reader::open(bottle)?;
    values(ty, &mut reader, &mut list, out)?;
    Ok(reader.end()?)
}

/// The same, of what is left of a list.
pub(crate) fn values(
    ty: &DataType,
    reader: &mut Reader<'_>,
    list: &mut List,
    out: &mut Vec<u8>,
) -> Result<(), Misfit> {
    let place = Place(Vec::new());
    let mut decoder = Decoder { table: ty.table(), reader, cdr: CdrWriter::new(out), place };
    if is_list(ty.table(), ty.id()) {
        decoder.list(ty.id(), *list)
    } else {
        decoder.next(ty.id(), list)?;
        decoder.finished(*list, "a single value")
    }
}

/// Where in a value something is.
struct Place(Vec<Step>);

enum Step {
    Member(String),
    Element(usize),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.is_empty() {
            return f.write_str("the value");
        }
        for (index, step) in self.0.iter().enumerate() {
            match step {
                Step::Member(name) if index == 0 => write!(f, "`{name}")?,
                Step::Member(name) => write!(f, ".{name}")?,
                Step::Element(number) if index == 0 => write!(f, "`[{number}]")?,
                Step::Element(number) => write!(f, "[{number}]")?,
            }
        }
        f.write_str("`")
    }
}

struct Decoder<'a, 'r, 'b> {
    table: &'a TypeTable,
    reader: &'r mut Reader<'b>,
    cdr: CdrWriter<'a>,
    place: Place,
}

impl Decoder<'_, '_, '_> {
    fn within<R>(
        &mut self,
        step: Step,
        work: impl FnOnce(&mut Self) -> Result<R, Misfit>,
    ) -> Result<R, Misfit> {
        self.place.0.push(step);
        let done = work(self)?;
        self.place.0.pop();
        Ok(done)
    }

    fn wrong(&self, wanted: impl Into<String>, found: &Item<'_>) -> Misfit {
        self.wrong_text(wanted, found.described())
    }

    fn wrong_text(&self, wanted: impl Into<String>, found: String) -> Misfit {
        Misfit::Value { place: self.place.to_string(), wanted: wanted.into(), found }
    }

    fn finished(&self, list: List, wanted: &str) -> Result<(), Misfit> {
        if list.left == 0 {
            return Ok(());
        }
        let (place, wanted) = (self.place.to_string(), wanted.to_owned());
        Err(Misfit::TooMany { place, wanted, found: list.left })
    }

    /// The value of a type that is the next in a list.
    fn next(&mut self, id: TypeId, list: &mut List) -> Result<(), Misfit> {
        match self.reader.next(list)? {
            Some(item) => self.value(id, item),
            None => {
                let wanted = wanted(self.table, id);
                Err(Misfit::Missing { place: self.place.to_string(), wanted })
            }
        }
    }

    fn list(&mut self, id: TypeId, mut list: List) -> Result<(), Misfit> {
        let table = self.table;
        let kind = table.resolved(id);
        match kind {
            Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                for member in members {
                    let step = Step::Member(member.name.clone());
                    self.within(step, |this| this.next(member.ty, &mut list))?;
                }
                self.finished(list, &format!("{} members", members.len()))?;
            }
            Kind::Array { element, length } => {
                if list.left != *length {
                    let found = format!("a list of {}", list.left);
                    return Err(self.wrong_text(format!("a list of {length}"), found));
                }
                self.elements(*element, list)?;
            }
            Kind::Sequence { element, bound } => {
                self.check_bound(list.left as usize, *bound, "elements")?;
                let place = self.cdr.length_later();
                let count = self.elements(*element, list)?;
                self.cdr.set_length(place, count);
            }
            Kind::Optional { element } => {
                self.check_bound(list.left as usize, Some(1), "elements")?;
                self.cdr.number(list.left.to_le_bytes());
                if list.left == 1 {
                    self.next(*element, &mut list)?;
                }
            }
            Kind::Union { discriminant, .. } => {
                let value = self.discriminant(*discriminant, &mut list)?;
                if let Some(member) = selected(kind, value) {
                    self.next(member, &mut list)?;
                }
                self.finished(list, "a discriminant and the member that it selects")?;
            }
            _ => return Err(self.wrong_text("no list", format!("a list of {}", list.left))),
        }
        self.reader.leave();
        Ok(())
    }

    fn check_bound(&self, length: usize, bound: Option<u32>, of: &str) -> Result<(), Misfit> {
        match bound {
            Some(most) if length > most as usize => {
                Err(self.wrong_text(format!("at most {most} {of}"), length.to_string()))
            }
            _ => Ok(()),
        }
    }

    fn elements(&mut self, element: TypeId, mut list: List) -> Result<u32, Misfit> {
        let count = list.left;
        if let Some((tag, size)) = as_it_is(self.table.resolved(element))
            && list.common == Some(tag)
        {
            let bytes = (count as usize).checked_mul(size).ok_or(NoBottle::Cut)?;
            let bytes = self.reader.take(bytes)?;
            self.cdr.bytes(size, bytes);
            return Ok(count);
        }
        for number in 0..count {
            self.within(Step::Element(number as usize), |this| this.next(element, &mut list))?;
        }
        Ok(count)
    }

    fn value(&mut self, id: TypeId, item: Item<'_>) -> Result<(), Misfit> {
        let table = self.table;
        let kind = table.resolved(id);
        match kind {
            Kind::Boolean => {
                let truth = match item {
                    Item::Int(value @ (0 | 1)) => value == 1,
                    // `true` and `false` as people type them.
                    Item::Vocab(0) => false,
                    Item::Vocab(word) if word == u32::from(b'1') => true,
                    other => return Err(self.wrong("0 or 1", &other)),
                };
                self.cdr.number([u8::from(truth)]);
            }
            Kind::Float => {
                let value = self.real(item)?;
                self.cdr.number((value as f32).to_le_bytes());
            }
            Kind::Double => {
                let value = self.real(item)?;
                self.cdr.number(value.to_le_bytes());
            }
            Kind::Char => self.integer::<i8, 1>(item, i8::to_le_bytes)?,
            Kind::Octet => self.integer::<u8, 1>(item, u8::to_le_bytes)?,
            Kind::Short => self.integer::<i16, 2>(item, i16::to_le_bytes)?,
            Kind::UnsignedShort => self.integer::<u16, 2>(item, u16::to_le_bytes)?,
            Kind::Long => self.integer::<i32, 4>(item, i32::to_le_bytes)?,
            Kind::UnsignedLong => self.integer::<u32, 4>(item, u32::to_le_bytes)?,
            // Bottles have no greater unsigned numbers: one of 64 bits is sent as it is.
            Kind::LongLong | Kind::UnsignedLongLong => {
                self.integer::<i64, 8>(item, i64::to_le_bytes)?;
            }
            Kind::String { bound } => {
                let Item::Text(text) = item else { return Err(self.wrong("a text", &item)) };
                if text.contains(&0) || std::str::from_utf8(text).is_err() {
                    return Err(self.wrong("a text in UTF-8 without NUL", &item));
                }
                self.check_bound(text.len(), bound.map(|bound| bound.saturating_sub(1)), "bytes")?;
                self.cdr.text(text);
            }
            Kind::Enum { enumerators, .. } => {
                let rank = match item {
                    Item::Text(name) => enumerators.iter().position(|one| one.as_bytes() == name),
                    Item::Int(rank) => {
                        usize::try_from(rank).ok().filter(|rank| *rank < enumerators.len())
                    }
                    _ => None,
                };
                let Some(rank) = rank else {
                    return Err(self.wrong(wanted(table, id), &item));
                };
                self.cdr.number((rank as u32).to_le_bytes());
            }
            Kind::Array { length, .. } if !is_list(table, id) => match item {
                Item::Blob(bytes) if bytes.len() == *length as usize => self.cdr.bytes(1, bytes),
                Item::List(list) => self.list(id, list)?,
                other => return Err(self.wrong(format!("a blob of {length} bytes"), &other)),
            },
            Kind::Sequence { bound, .. } if !is_list(table, id) => match item {
                Item::Blob(bytes) => {
                    self.check_bound(bytes.len(), *bound, "bytes")?;
                    self.cdr.number((bytes.len() as u32).to_le_bytes());
                    self.cdr.bytes(1, bytes);
                }
                Item::List(list) => self.list(id, list)?,
                other => return Err(self.wrong("a blob", &other)),
            },
            _ => match item {
                Item::List(list) => self.list(id, list)?,
                other => return Err(self.wrong(wanted(table, id), &other)),
            },
        }
        Ok(())
    }

    fn real(&self, item: Item<'_>) -> Result<f64, Misfit> {
        match item {
            Item::Float(value) => Ok(value),
            Item::Int(value) => Ok(value as f64),
            other => Err(self.wrong("a number", &other)),
        }
    }

    fn integer<T: TryFrom<i64>, const N: usize>(
        &mut self,
        item: Item<'_>,
        bytes: fn(T) -> [u8; N],
    ) -> Result<(), Misfit> {
        let wide = match item {
            Item::Int(value) => Some(value),
            _ => None,
        };
        match wide.and_then(|wide| T::try_from(wide).ok()) {
            Some(value) => self.cdr.number(bytes(value)),
            None => {
                let wanted = format!("an integer ({})", std::any::type_name::<T>());
                return Err(self.wrong(wanted, &item));
            }
        }
        Ok(())
    }

    /// Writes a discriminant; returns its value.
    fn discriminant(&mut self, id: TypeId, list: &mut List) -> Result<i128, Misfit> {
        let table = self.table;
        let Some(item) = self.reader.next(list)? else {
            let wanted = wanted(table, id);
            return Err(Misfit::Missing { place: self.place.to_string(), wanted });
        };
        self.value(id, item)?;
        Ok(match (item, table.resolved(id)) {
            (Item::Text(name), Kind::Enum { enumerators, .. }) => {
                let rank = enumerators.iter().position(|one| one.as_bytes() == name);
                rank.map_or(-1, |rank| rank as i128)
            }
            (Item::Int(value), Kind::UnsignedLongLong) => (value as u64).into(),
            (Item::Int(value), _) => value.into(),
            (Item::Vocab(word), _) => i128::from(word != 0),
            _ => -1,
        })
    }
}

/// What values of a type look like.
fn wanted(table: &TypeTable, id: TypeId) -> String {
    match table.resolved(id) {
        Kind::Boolean => "0 or 1".to_owned(),
        Kind::Float | Kind::Double => "a number".to_owned(),
        Kind::String { .. } => "a text".to_owned(),
        Kind::Enum { enumerators, .. } => {
            let shown: Vec<&str> = enumerators.iter().take(8).map(String::as_str).collect();
            let more = if enumerators.len() > shown.len() { ", ..." } else { "" };
            format!("one of {}{more}", shown.join(", "))
        }
        Kind::Struct { members, .. } => format!("a list of {} members", members.len()),
        Kind::Union { .. } => "a list of a discriminant and a member".to_owned(),
        Kind::Array { length, .. } if is_list(table, id) => format!("a list of {length}"),
        Kind::Array { length, .. } => format!("a blob of {length} bytes"),
        Kind::Sequence { .. } if is_list(table, id) => "a list".to_owned(),
        Kind::Sequence { .. } => "a blob".to_owned(),
        Kind::Optional { .. } => "a list of none or one".to_owned(),
        _ => "an integer".to_owned(),
    }
}

/// Greatest size of a bottle that holds a value of the type, if it has one.
pub(crate) fn most(ty: &DataType) -> Option<usize> {
    // A member of one byte may take a tag and four bytes, and eight bytes for each list around it.
    ty.is_fixed_size().then(|| ty.size().saturating_mul(64).saturating_add(4096))
}
