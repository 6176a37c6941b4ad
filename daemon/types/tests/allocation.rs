//! Copying and encoding at each tick allocate nothing, and buffers that are large enough are
//! reused.

#![allow(clippy::unwrap_used, clippy::panic)] // also in helpers, where clippy.toml does not reach

mod support;

use std::sync::Arc;

use genom_allocations as allocations;
use genom_types::{DataType, Kind, Record, TypeTable};
use serde_json::json;
use support::{Rng, Types, value};

#[test]
fn fixed_size_values_are_moved_without_allocation() {
    for seed in 0..300 {
        let (mut table, mut rng) = (TypeTable::default(), Rng::new(seed));
        let id = Types { table: &mut table, rng: &mut rng, fixed: true, count: 0 }.structure(3);
        let json = value(&table, id, &mut rng);
        // Two tables, as two components have.
        let ty = DataType::new(&Arc::new(table.clone()), id).unwrap();
        let other = DataType::new(&Arc::new(table), id).unwrap();
        let (mut from, mut to) = (Record::new(&ty), Record::new(&other));
        from.merge_json(&json).unwrap();
        let mut payload = Vec::with_capacity(1 << 16);
        ty.prepare();
        other.prepare();
        let mut tick = |payload: &mut Vec<u8>| {
            payload.clear();
            to.copy_from(&from).unwrap();
            to.set_bytes(from.bytes().unwrap()).unwrap();
            from.encode_cdr(payload).unwrap();
            to.decode_cdr(payload).unwrap();
        };
        assert_eq!(allocations::within(|| tick(&mut payload)), 0);
    }
}

#[test]
fn buffers_that_are_large_enough_are_kept() {
    let mut table = TypeTable::default();
    let element = table.add(Kind::Long);
    let id = table.add(Kind::Sequence { element, bound: None });
    let ty = DataType::new(&Arc::new(table), id).unwrap();
    let (mut from, mut to) = (Record::new(&ty), Record::new(&ty));
    // SAFETY: `_buffer` lies at 8 in a sequence without bound.
    let buffer = |record: &Record| unsafe { record.as_ptr().add(8).cast::<usize>().read() };
    from.merge_json(&json!([1, 2, 3, 4])).unwrap();
    to.copy_from(&from).unwrap();
    let first = buffer(&to);
    from.merge_json(&json!([5])).unwrap();
    to.copy_from(&from).unwrap();
    let mut payload = Vec::new();
    from.merge_json(&json!([6, 7, 8])).unwrap();
    from.encode_cdr(&mut payload).unwrap();
    to.decode_cdr(&payload).unwrap();
    assert_eq!(to.to_json(), json!([6, 7, 8]));
    assert_eq!(buffer(&to), first);
    assert_ne!(buffer(&to), buffer(&from), "copies are deep");
}
