//! Copies of port values for readers outside the codels, which codels never wait for. One of the
//! few unsafe modules.
#![allow(unsafe_code)]

use std::cell::UnsafeCell;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

use genom_types::{DataType, Record};

/// Larger values, in bytes, are copied only while somebody reads them.
const LARGE: usize = 1 << 16;
/// How many values are copied after a large one was read.
const WATCHED: u32 = 1000;
/// Flag of a value that the reader has not taken yet, above the two bits of a slot's index.
const FRESH: u8 = 4;

/// A triple buffer: the writer fills one slot, the reader holds another, the third is exchanged.
pub(super) struct Snapshot {
    slots: [UnsafeCell<Record>; 3],
    /// Index of the slot in the middle, and [`FRESH`].
    middle: AtomicU8,
    /// Index of the writer's slot.
    back: UnsafeCell<u8>,
    reader: Mutex<Reader>,
    large: bool,
    /// Whether the last value was not copied.
    behind: AtomicBool,
    /// Number of large values still to be copied for a reader.
    watched: AtomicU32,
}

struct Reader {
    /// Index of the reader's slot.
    front: u8,
    /// Whether it holds a value.
    filled: bool,
}

// SAFETY: the three indices (back, middle, front) always differ. The slot of `back` is accessed by
// the writer only, and `offer` requires one caller at a time; that of `front` under the mutex.
unsafe impl Sync for Snapshot {}

impl Snapshot {
    /// A buffer without value.
    pub(super) fn new(ty: &DataType) -> Self {
        Self {
            slots: std::array::from_fn(|_| UnsafeCell::new(Record::new(ty))),
            middle: AtomicU8::new(1),
            back: UnsafeCell::new(0),
            reader: Mutex::new(Reader { front: 2, filled: false }),
            large: ty.size() > LARGE,
            behind: AtomicBool::new(false),
            // The first value is always copied.
            watched: AtomicU32::new(1),
        }
    }

    /// Copies `value`, unless it is large and nobody has read the port lately.
    ///
    /// # Safety
    /// One caller at a time.
    pub(super) unsafe fn offer(&self, value: &Record) {
        if self.large {
            let watched = self.watched.load(Ordering::Relaxed);
            if watched == 0 {
                self.behind.store(true, Ordering::Relaxed);
                return;
            }
            self.watched.store(watched - 1, Ordering::Relaxed);
        }
        // SAFETY: the caller is the only writer, so `back` and its slot are not shared.
        let (back, slot) = unsafe {
            let back = &mut *self.back.get();
            let slot = &mut *self.slots[usize::from(*back)].get();
            (back, slot)
        };
        let copied = slot.copy_from(value).is_ok();
        if copied {
            *back = self.middle.swap(*back | FRESH, Ordering::AcqRel) & !FRESH;
        }
        self.behind.store(!copied, Ordering::Relaxed);
    }

    /// Result of `look` for the last value copied; `None` before the first.
    pub(super) fn look<T>(&self, look: impl FnOnce(&Record) -> T) -> Option<T> {
        if self.large {
            self.watched.store(WATCHED, Ordering::Relaxed);
        }
        let mut reader = self.reader.lock().unwrap_or_else(PoisonError::into_inner);
        if self.middle.load(Ordering::Relaxed) & FRESH != 0 {
            reader.front = self.middle.swap(reader.front, Ordering::AcqRel) & !FRESH;
            reader.filled = true;
        }
        // SAFETY: the front slot belongs to the reader, and the mutex is held.
        let slot = unsafe { &*self.slots[usize::from(reader.front)].get() };
        reader.filled.then(|| look(slot))
    }

    /// The last value offered; `None` if it was not copied, or before the first. If values are
    /// offered at the same time, it may be the previous one.
    pub(super) fn last(&self) -> Option<Record> {
        let behind = self.behind.load(Ordering::Relaxed);
        let last = self.look(Record::clone);
        last.filter(|_| !behind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    impl Snapshot {
        fn latest(&self) -> Option<Value> {
            self.look(Record::to_json)
        }
    }

    use genom_types::{Kind, TypeTable};
    use std::sync::Arc;

    fn record(kind: Kind) -> Record {
        let mut table = TypeTable::default();
        let id = table.add(kind);
        Record::new(&DataType::new(&Arc::new(table), id).unwrap())
    }

    #[test]
    fn the_last_value_offered_is_seen_and_none_before() {
        let mut value = record(Kind::LongLong);
        let snapshot = Snapshot::new(value.ty());
        assert_eq!(snapshot.latest(), None);
        for i in 0..5 {
            value.merge_json(&i.into()).unwrap();
            // SAFETY: only this thread offers values.
            unsafe { snapshot.offer(&value) };
        }
        assert_eq!(snapshot.latest(), Some(4.into()));
        assert_eq!(snapshot.latest(), Some(4.into()), "looking again shows it again");
    }

    /// An array of octets that is copied only while somebody reads it.
    fn large() -> Record {
        let mut table = TypeTable::default();
        let element = table.add(Kind::Octet);
        let length = u32::try_from(LARGE).unwrap() + 1;
        let array = table.add(Kind::Array { element, length });
        Record::new(&DataType::new(&Arc::new(table), array).unwrap())
    }

    fn offer_filled(snapshot: &Snapshot, value: &mut Record, byte: u8) {
        value.set_bytes(&vec![byte; LARGE + 1]).unwrap();
        // SAFETY: only the thread of the test offers values.
        unsafe { snapshot.offer(value) };
    }

    #[test]
    fn a_large_value_is_copied_at_first_and_while_somebody_looks() {
        let mut value = large();
        let snapshot = Snapshot::new(value.ty());
        let mut offer = |byte| offer_filled(&snapshot, &mut value, byte);
        let first = |value: Option<Value>| value.unwrap()[0].clone();
        offer(1);
        offer(2);
        assert_eq!(first(snapshot.latest()), 1, "the second was not copied: nobody had looked");
        offer(3);
        assert_eq!(first(snapshot.latest()), 3);
    }

    #[test]
    fn a_copy_of_an_older_value_is_not_told_as_the_last() {
        let mut value = large();
        let snapshot = Snapshot::new(value.ty());
        let mut offer = |byte| offer_filled(&snapshot, &mut value, byte);
        let first = |value: Option<Record>| value.map(|value| value.bytes().unwrap()[0]);
        assert_eq!(first(snapshot.last()), None);
        offer(1);
        assert_eq!(first(snapshot.last()), Some(1));
        for _ in 0..=WATCHED {
            offer(2);
        }
        offer(3);
        assert_eq!(first(snapshot.last()), None, "nobody looked any more");
        offer(4);
        assert_eq!(first(snapshot.last()), Some(4));
    }

    #[test]
    fn a_reader_beside_a_writer_sees_values_grow_and_none_torn() {
        let mut table = TypeTable::default();
        let element = table.add(Kind::Long);
        let array = table.add(Kind::Array { element, length: 64 });
        let mut value = Record::new(&DataType::new(&Arc::new(table), array).unwrap());
        let snapshot = Snapshot::new(value.ty());
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for i in 1..=20_000_i32 {
                    let whole: Vec<u8> = (0..64).flat_map(|_| i.to_ne_bytes()).collect();
                    value.set_bytes(&whole).unwrap();
                    // SAFETY: only this thread offers values.
                    unsafe { snapshot.offer(&value) };
                }
            });
            let mut last = 0;
            while last < 20_000 {
                let Some(Value::Array(seen)) = snapshot.latest() else { continue };
                let first = seen[0].as_i64().unwrap();
                assert!(seen.iter().all(|one| one.as_i64() == Some(first)), "torn");
                assert!(first >= last);
                last = first;
            }
        });
    }
}
