//! Types and values that the properties use.

use std::sync::Arc;

use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeId, TypeTable};
use serde_json::{Value, json};

/// Size in bytes of the large sample.
pub const LARGE: u32 = 4 << 20;

fn lay_out(table: TypeTable, id: TypeId) -> DataType {
    DataType::new(&Arc::new(table), id).expect("a type that can be laid out")
}

fn structure(table: &mut TypeTable, name: &str, members: &[(&str, TypeId)]) -> TypeId {
    structure_of(table, ["demo", name], members)
}

fn structure_of(table: &mut TypeTable, name: [&str; 2], members: &[(&str, TypeId)]) -> TypeId {
    let member = |&(name, ty): &(&str, TypeId)| Member { name: name.to_owned(), ty };
    table.add(Kind::Struct {
        name: ScopedName::new(name),
        members: members.iter().map(member).collect(),
    })
}

/// `::demo::state`: 64 bytes, a count and seven doubles.
#[must_use]
pub fn state() -> DataType {
    state_named(["demo", "state"])
}

/// `::other::pose`: the same members as `::demo::state`, in another component's module.
#[must_use]
pub fn twin() -> DataType {
    state_named(["other", "pose"])
}

fn state_named(name: [&str; 2]) -> DataType {
    let mut table = TypeTable::default();
    let count = table.add(Kind::UnsignedLongLong);
    let double = table.add(Kind::Double);
    let values = table.add(Kind::Array { element: double, length: 7 });
    let id = structure_of(&mut table, name, &[("count", count), ("values", values)]);
    lay_out(table, id)
}

/// A `::demo::state` of the same size with different members.
#[must_use]
pub fn other_state() -> DataType {
    let mut table = TypeTable::default();
    let double = table.add(Kind::Double);
    let values = table.add(Kind::Array { element: double, length: 8 });
    let id = structure(&mut table, "state", &[("values", values)]);
    lay_out(table, id)
}

/// `::demo::note`: a string and rows of numbers.
#[must_use]
pub fn note() -> DataType {
    let mut table = TypeTable::default();
    let text = table.add(Kind::String { bound: None });
    let long = table.add(Kind::Long);
    let row = table.add(Kind::Sequence { element: long, bound: None });
    let rows = table.add(Kind::Sequence { element: row, bound: None });
    let id = structure(&mut table, "note", &[("text", text), ("rows", rows)]);
    lay_out(table, id)
}

/// `::demo::image`: an array of 4 MiB.
#[must_use]
pub fn image() -> DataType {
    let mut table = TypeTable::default();
    let octet = table.add(Kind::Octet);
    let pixels = table.add(Kind::Array { element: octet, length: LARGE });
    let id = structure(&mut table, "image", &[("pixels", pixels)]);
    lay_out(table, id)
}

/// Structs of one to three bytes in CDR, with values of their only member `it`.
#[must_use]
pub fn small() -> [(DataType, Value); 4] {
    let of = |name: &str, kind: Kind, length: u32, values: Value| {
        let mut table = TypeTable::default();
        let mut it = table.add(kind);
        if length > 1 {
            it = table.add(Kind::Array { element: it, length });
        }
        let id = structure(&mut table, name, &[("it", it)]);
        (lay_out(table, id), values)
    };
    [
        of("octet", Kind::Octet, 1, json!([1, 0, 255])),
        of("truth", Kind::Boolean, 1, json!([true, false, true])),
        of("short", Kind::Short, 1, json!([1, -2, i16::MAX, i16::MIN])),
        of("triple", Kind::Octet, 3, json!([[1, 2, 3], [0, 0, 0], [255, 254, 253]])),
    ]
}

/// A type without a name, such as `double`.
#[must_use]
pub fn basic(kind: Kind) -> DataType {
    let mut table = TypeTable::default();
    let id = table.add(kind);
    lay_out(table, id)
}

/// A state with this number.
#[must_use]
pub fn numbered(count: u64) -> Record {
    let mut record = Record::new(&state());
    set_number(&mut record, count);
    record
}

/// Writes a number into a state, without allocating.
pub fn set_number(record: &mut Record, count: u64) {
    let mut bytes = [0; 64];
    bytes[..8].copy_from_slice(&count.to_ne_bytes());
    for (i, value) in bytes[8..].chunks_exact_mut(8).enumerate() {
        value.copy_from_slice(&(count as f64 + i as f64).to_ne_bytes());
    }
    record.set_bytes(&bytes).expect("64 bytes are a state");
}

/// The number of a state. Fails if its members disagree.
#[must_use]
pub fn number(record: &Record) -> u64 {
    let bytes = record.bytes().expect("a state is plain bytes");
    let word = |i: usize| <[u8; 8]>::try_from(&bytes[i * 8..][..8]).expect("8 bytes");
    let count = u64::from_ne_bytes(word(0));
    for i in 1..8 {
        let expected = count as f64 + (i - 1) as f64;
        assert_eq!(f64::from_ne_bytes(word(i)), expected, "the sample is torn");
    }
    count
}

/// A note with `rows` rows.
#[must_use]
pub fn note_of(rows: usize) -> Value {
    let row = |n: usize| (0..n % 7).map(|i| json!(i * n)).collect::<Vec<_>>();
    json!({
        "text": "élan ".repeat(rows),
        "rows": (0..rows).map(row).collect::<Vec<_>>(),
    })
}
