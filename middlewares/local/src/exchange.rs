//! The values of one address, passed from one writer to many readers without locks.
//!
//! There is a pool of buffers, and an atomic word says which one holds the latest value. The writer
//! fills a buffer that is neither the latest nor pinned, then makes it the latest; it never waits.
//! A reader pins the latest buffer, checks that it still is the latest, copies it and unpins it.
//! Queue and ring readers have a [`Lane`] of buffers that the writer pinned for them.
//!
//! Why a pinned buffer is never written: all accesses to `latest` and `pins` are sequentially
//! consistent. A reader increments `pins`, then checks that the buffer is still the latest. The
//! writer replaces `latest`, then reads `pins`. In their total order, either the writer reads
//! `pins` after the increment and does not use the buffer, or the reader's check comes after the
//! replacement and it unpins the buffer without having read it.

use std::cell::UnsafeCell;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use genom_kit::index_ring::MAX_INDEX;
use genom_middleware::{Policy, Reading};
use genom_types::{DataType, Record};

use crate::lane::{Lane, Lanes};

/// Number of buffers in the first segment; each further segment has twice as many.
const FIRST_SEGMENT: usize = 4;
const SEGMENTS: usize = 14;
const INDEX_BITS: u32 = 16;

/// Greatest number of unread samples per reader.
pub(crate) const MAX_DEPTH: usize = 4096;

struct Buffer {
    /// Number of readers and lanes that hold it.
    pins: AtomicU32,
    /// Sequence number of its value; does not change while pinned.
    sequence: AtomicU64,
    record: UnsafeCell<Record>,
}

// SAFETY: the one writer writes `record` only while the buffer is not pinned, and others only read
// it while it is; see the module's documentation.
unsafe impl Sync for Buffer {}

/// The values of one address.
pub(crate) struct Exchange {
    ty: DataType,
    segments: [OnceLock<Box<[Buffer]>>; SEGMENTS],
    /// Number of buffers in use, from index 0.
    count: AtomicUsize,
    /// Sequence number and index of the latest value; 0 when there is none.
    latest: AtomicU64,
    /// Last sequence number of the previous writer. New readers ignore values up to it.
    floor: AtomicU64,
    written_by_somebody: AtomicBool,
    lanes: Lanes,
    /// Number of readers without a lane. The lock also serialises opening and closing.
    latest_readers: Mutex<usize>,
}

/// The writing end; there is at most one.
pub(crate) struct Writer {
    exchange: Arc<Exchange>,
    /// Sequence number of the next value.
    next: u64,
    /// Where the search for a free buffer starts.
    hint: usize,
    /// Number of values for which no buffer was free. Always 0 unless the number of buffers is
    /// wrong.
    pub(crate) dropped: u64,
}

/// A reading end.
pub(crate) struct Reader {
    exchange: Arc<Exchange>,
    /// Sequence number of the last value read.
    seen: u64,
    /// Whether any value was read; `seen` alone does not tell, as it may start above 0.
    any: bool,
    lane: Option<OwnLane>,
}

struct OwnLane {
    lane: Arc<Lane>,
    /// The latest value at the time the reader was opened; pinned, and read first.
    first: Option<usize>,
    /// The lane's count of dropped samples when this reader took it over.
    dropped_before: u64,
}

impl Exchange {
    pub(crate) fn new(ty: &DataType) -> Arc<Self> {
        Arc::new(Self {
            ty: ty.clone(),
            segments: [const { OnceLock::new() }; SEGMENTS],
            count: AtomicUsize::new(0),
            latest: AtomicU64::new(0),
            floor: AtomicU64::new(0),
            written_by_somebody: AtomicBool::new(false),
            lanes: Lanes::default(),
            latest_readers: Mutex::new(0),
        })
    }

    pub(crate) fn ty(&self) -> &DataType {
        &self.ty
    }

    /// Opens the writing end, unless it is open already.
    pub(crate) fn writer(self: &Arc<Self>) -> Option<Writer> {
        if self.written_by_somebody.swap(true, Ordering::SeqCst) {
            return None;
        }
        let readers = self.latest_readers.lock().unwrap_or_else(PoisonError::into_inner);
        self.grow(*readers);
        let next = (self.latest.load(Ordering::SeqCst) >> INDEX_BITS) + 1;
        Some(Writer { exchange: Arc::clone(self), next, hint: 0, dropped: 0 })
    }

    /// Opens a reading end. `policy` holds at most [`MAX_DEPTH`] samples.
    pub(crate) fn reader(self: &Arc<Self>, policy: Policy) -> Reader {
        let mut readers = self.latest_readers.lock().unwrap_or_else(PoisonError::into_inner);
        let lane = match policy {
            Policy::Queue(depth) => Some(self.lanes.take(depth.clamp(1, MAX_DEPTH), false)),
            Policy::Ring(depth) => Some(self.lanes.take(depth.clamp(1, MAX_DEPTH), true)),
            _ => {
                *readers += 1;
                None
            }
        };
        self.grow(*readers);
        let mut reader = Reader { exchange: Arc::clone(self), seen: 0, any: false, lane: None };
        reader.seen = self.floor.load(Ordering::SeqCst);
        if let Some(lane) = lane {
            // Discard what a writer pushed while the lane was being closed.
            while let Some(left) = lane.ring.pop() {
                self.unpin(left);
            }
            let dropped_before = lane.dropped.load(Ordering::Relaxed);
            // Open the lane before reading the latest value: a value published in between is in the
            // lane, or is the latest, or both, and `seen` detects the duplicate.
            lane.open.store(true, Ordering::SeqCst);
            let mut first = self.pin_latest();
            if let Some(index) = first
                && self.sequence(index) <= reader.seen
            {
                self.unpin(index);
                first = None;
            }
            reader.lane = Some(OwnLane { lane, first, dropped_before });
        }
        reader
    }

    /// Allocates as many buffers as can be in use at once: the latest, the one being written, two
    /// per reader (one held, one for a moment while it changes), and the depth of each lane.
    fn grow(&self, latest_readers: usize) {
        let lanes: usize = self.lanes.iter().map(|lane| lane.ring.capacity() + 2).sum();
        let wanted = (2 + 2 * latest_readers + lanes).min(MAX_INDEX);
        let mut have = 0;
        for (n, segment) in self.segments.iter().enumerate() {
            if have >= wanted {
                break;
            }
            let size = FIRST_SEGMENT << n;
            segment.get_or_init(|| (0..size).map(|_| Buffer::new(&self.ty)).collect());
            have += size;
        }
        self.count.fetch_max(have, Ordering::SeqCst);
    }

    fn buffer(&self, index: usize) -> Option<&Buffer> {
        let n = (index / FIRST_SEGMENT + 1).ilog2();
        let start = FIRST_SEGMENT * ((1 << n) - 1);
        self.segments.get(n as usize)?.get()?.get(index - start)
    }

    fn sequence(&self, index: usize) -> u64 {
        self.buffer(index).map_or(0, |buffer| buffer.sequence.load(Ordering::Relaxed))
    }

    /// Pins the latest buffer. Retries only if the writer published in between.
    fn pin_latest(&self) -> Option<usize> {
        loop {
            let latest = self.latest.load(Ordering::SeqCst);
            if latest == 0 {
                return None;
            }
            let index = index_of(latest);
            let buffer = self.buffer(index)?;
            buffer.pins.fetch_add(1, Ordering::SeqCst);
            if self.latest.load(Ordering::SeqCst) == latest {
                return Some(index);
            }
            buffer.pins.fetch_sub(1, Ordering::SeqCst);
        }
    }

    fn unpin(&self, index: usize) {
        if let Some(buffer) = self.buffer(index) {
            buffer.pins.fetch_sub(1, Ordering::SeqCst);
        }
    }

    /// Copies a pinned buffer out and unpins it. Returns its sequence number; `None` if the types
    /// differ.
    fn take(&self, index: usize, into: &mut Record) -> Option<u64> {
        let buffer = self.buffer(index)?;
        // SAFETY: the buffer is pinned, by the caller in `pin_latest` or by the writer for the
        // lane, so nobody writes it until it is unpinned below.
        let copied = into.copy_from(unsafe { &*buffer.record.get() });
        let sequence = buffer.sequence.load(Ordering::Relaxed);
        buffer.pins.fetch_sub(1, Ordering::SeqCst);
        copied.is_ok().then_some(sequence)
    }
}

impl Buffer {
    fn new(ty: &DataType) -> Self {
        Self {
            pins: AtomicU32::new(0),
            sequence: AtomicU64::new(0),
            record: UnsafeCell::new(Record::new(ty)),
        }
    }
}

fn index_of(latest: u64) -> usize {
    (latest & MAX_INDEX as u64) as usize
}

impl Writer {
    /// Publishes a copy. Returns false if the value has another type.
    pub(crate) fn publish(&mut self, value: &Record) -> bool {
        let exchange = &*self.exchange;
        let latest = exchange.latest.load(Ordering::SeqCst);
        let count = exchange.count.load(Ordering::SeqCst);
        let free = (self.hint..count).chain(0..self.hint).find_map(|index| {
            let buffer = exchange.buffer(index)?;
            let is_latest = latest != 0 && index_of(latest) == index;
            let free = !is_latest && buffer.pins.load(Ordering::SeqCst) == 0;
            free.then_some((index, buffer))
        });
        let Some((index, buffer)) = free else {
            self.dropped += 1;
            return true;
        };
        // SAFETY: this is the only writer. The buffer was not the latest and then had no pins, so
        // no reader holds it, and none can until it is the latest again.
        let written = unsafe { &mut *buffer.record.get() }.copy_from(value);
        if written.is_err() {
            return false;
        }
        buffer.sequence.store(self.next, Ordering::Relaxed);
        exchange.latest.store((self.next << INDEX_BITS) | index as u64, Ordering::SeqCst);
        self.next += 1;
        self.hint = if index + 1 < count { index + 1 } else { 0 };
        for lane in exchange.lanes.iter() {
            if lane.open.load(Ordering::SeqCst) {
                buffer.pins.fetch_add(1, Ordering::SeqCst);
                if let Some(lost) = lane.push(index) {
                    exchange.unpin(lost);
                }
            }
        }
        true
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        let last = self.exchange.latest.load(Ordering::SeqCst) >> INDEX_BITS;
        self.exchange.floor.store(last, Ordering::SeqCst);
        self.exchange.written_by_somebody.store(false, Ordering::SeqCst);
    }
}

impl Reader {
    /// The next value according to the policy; `None` if `into` has another type.
    pub(crate) fn read(&mut self, into: &mut Record) -> Option<Reading> {
        let exchange = &*self.exchange;
        loop {
            let found = match &mut self.lane {
                Some(own) => own.first.take().or_else(|| own.lane.ring.pop()),
                None if exchange.latest.load(Ordering::SeqCst) >> INDEX_BITS > self.seen => {
                    exchange.pin_latest()
                }
                None => None,
            };
            let Some(index) = found else {
                return Some(if self.any { Reading::Same } else { Reading::Never });
            };
            if exchange.sequence(index) <= self.seen {
                exchange.unpin(index);
                continue;
            }
            self.seen = exchange.take(index, into)?;
            self.any = true;
            return Some(Reading::New);
        }
    }

    pub(crate) fn dropped(&self) -> u64 {
        self.lane
            .as_ref()
            .map_or(0, |own| own.lane.dropped.load(Ordering::Relaxed) - own.dropped_before)
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        let exchange = &*self.exchange;
        let mut readers = exchange.latest_readers.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(own) = &mut self.lane else {
            *readers -= 1;
            return;
        };
        own.lane.open.store(false, Ordering::SeqCst);
        let first = own.first.take();
        for index in first.into_iter().chain(std::iter::from_fn(|| own.lane.ring.pop())) {
            exchange.unpin(index);
        }
    }
}
