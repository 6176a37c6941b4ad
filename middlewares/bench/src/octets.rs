//! Types and values of any size.

use genom_types::{DataType, Kind, Record, TypeTable};

/// An array of `length` octets, all 1: a type of fixed size.
///
/// # Panics
/// Never: such a type can be laid out.
#[must_use]
pub fn array(length: usize) -> Record {
    let mut table = TypeTable::default();
    let element = table.add(Kind::Octet);
    let id = table.add(Kind::Array { element, length: u32::try_from(length).unwrap() });
    let mut record = Record::new(&DataType::new(&table.into(), id).unwrap());
    record.set_bytes(&vec![1; length]).unwrap();
    record
}

/// A sequence of `length` octets, all 1: a type of variable size.
///
/// # Panics
/// Never: such a type can be laid out.
#[must_use]
pub fn sequence(length: usize) -> Record {
    let mut table = TypeTable::default();
    let element = table.add(Kind::Octet);
    let id = table.add(Kind::Sequence { element, bound: None });
    let mut record = Record::new(&DataType::new(&table.into(), id).unwrap());
    record.merge_json(&vec![1u8; length].into()).unwrap();
    record
}
