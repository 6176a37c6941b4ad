//! What a sample in the black box costs the codel that writes it.

use std::sync::Arc;

use genom_allocations as allocations;
use genom_blackbox::{Memory, Writer, read};
use genom_ports::dates::Dates;
use genom_ports::tape::{Tape, Tapes, Way};
use genom_types::{DataType, Kind, Record, TypeTable};

#[test]
fn a_sample_in_the_black_box_allocates_nothing_however_many_there_are() {
    let mut table = TypeTable::default();
    let id = table.add(Kind::Double);
    let ty = DataType::new(&Arc::new(table), id).unwrap();
    ty.prepare();
    let memory = Memory::new(0).unwrap();
    let writer = Writer::new(&memory).unwrap();
    let tapes = Tapes::default();
    let track = writer.track(b"one", 64 << 10).unwrap();
    tapes.add(1, || Tape::boxed(1, &ty, Dates::default(), track));
    let mut value = Record::new(&ty);
    // Through all blocks of the track, many times.
    let calls =
        allocations::within(|| (0..100_000).for_each(|_| tapes.take(&value, Way::default())));
    assert_eq!(calls, 0);
    value.merge_json(&0.5.into()).unwrap();
    tapes.take(&value, Way::default());
    let kept = read(&memory).unwrap();
    let last = kept[0].records().last().unwrap();
    let mut decoded = Record::new(&ty);
    decoded.decode_message(last.content).unwrap();
    assert_eq!((last.number, decoded.to_json()), (100_000, 0.5.into()));
    assert!(memory.taken().unwrap() < 256 << 10, "{:?}", memory.taken());
}
