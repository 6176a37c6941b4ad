//! Where the samples of one in port arrive, in order and without duplicates.
//!
//! They arrive in two ways: as publications, and as replies to the query for the last value. The
//! mark of a sample tells whether it was received before.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use genom_kit::intake::Keeping;
use genom_kit::mailbox::Mailbox;
use zenoh::sample::{Sample, SampleKind};

use crate::arrival::Arrival;
use crate::wire::{Expected, Mark};

/// Minimum time between two log lines about bad samples.
const BETWEEN_LINES: Duration = Duration::from_secs(1);

/// Filled by zenoh's callbacks, emptied by the in port.
#[derive(Debug)]
pub(crate) struct Inbox {
    address: String,
    expected: Expected,
    pub(crate) mailbox: Mailbox<Arrival>,
    keeping: Keeping,
    /// Number of samples that could not be decoded; counted by the reader.
    pub(crate) undecodable: AtomicU64,
    gate: Mutex<Gate>,
    /// Told of each arrival.
    told: Told,
}

/// Who is told of arrivals, if anybody wants to be.
#[derive(Default)]
pub(crate) struct Told(OnceLock<Box<dyn Fn() + Send + Sync>>);

impl std::fmt::Debug for Told {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Told").field(&self.0.get().is_some()).finish()
    }
}

/// What has arrived so far.
#[derive(Debug, Default)]
struct Gate {
    last: Option<Arrived>,
    /// Number of undecodable samples when the last line was logged.
    logged: u64,
    line: Option<Instant>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Arrived {
    Marked(Mark),
    /// From a writer that attaches no marks.
    Plain,
}

/// A query for the last value in progress: the last mark that had arrived when it was sent.
#[derive(Debug)]
pub(crate) struct Asked(Option<Arrived>);

impl Inbox {
    pub(crate) fn new(address: String, expected: Expected, keeping: Keeping, size: usize) -> Self {
        let Keeping { depth, full, .. } = keeping;
        Self {
            address,
            expected,
            mailbox: Mailbox::with(depth, full, || Arrival::with_room(size)).dated(),
            keeping,
            undecodable: AtomicU64::new(0),
            gate: Mutex::default(),
            told: Told::default(),
        }
    }

    /// Number of samples lost to the reader.
    pub(crate) fn lost(&self) -> u64 {
        let given_up = if self.keeping.counts { self.mailbox.lost() } else { 0 };
        given_up + self.undecodable.load(Ordering::Relaxed)
    }

    /// Has somebody told of each arrival from now on.
    pub(crate) fn tell(&self, told: Box<dyn Fn() + Send + Sync>) -> bool {
        self.told.0.set(told).is_ok()
    }

    /// Records that the last value is being queried now.
    pub(crate) fn ask(&self) -> Asked {
        Asked(self.gate.lock().unwrap_or_else(PoisonError::into_inner).last)
    }

    /// Handles a publication, or the reply to the query `asked`.
    pub(crate) fn arrive(&self, sample: &Sample, asked: Option<&Asked>) {
        if sample.kind() != SampleKind::Put {
            return;
        }
        let mark = Mark::from_attachment(sample.attachment());
        let mut gate = self.gate.lock().unwrap_or_else(PoisonError::into_inner);
        if !gate.admits(mark, asked) {
            return;
        }
        gate.last = Some(mark.map_or(Arrived::Plain, Arrived::Marked));
        let alien = !self.expected.admits(sample.encoding());
        // The gate is still locked, so there is one producer at a time.
        let put = self.mailbox.put_by(|arrival| {
            let payload = sample.payload();
            arrival.set(payload, alien, self.keeping.holds(payload.len()));
            Ok::<_, std::convert::Infallible>(())
        });
        if put.is_err() {
            self.undecodable.fetch_add(1, Ordering::Relaxed);
        }
        gate.report(self, sample, alien);
        drop(gate);
        if let Some(told) = self.told.0.get() {
            told();
        }
    }
}

impl Gate {
    /// Whether a sample is new.
    fn admits(&self, mark: Option<Mark>, asked: Option<&Asked>) -> bool {
        if let (Some(mark), Some(Arrived::Marked(last))) = (mark, self.last)
            && mark.writer == last.writer
        {
            return mark.number > last.number;
        }
        // It comes from another writer than the last sample did. A reply must not replace what
        // arrived since the query.
        asked.is_none_or(|asked| match (mark, asked.0) {
            (_, None) => self.last.is_none(),
            (Some(_), before) => before == self.last,
            // A sample that a storage kept of a writer without marks may have been received before.
            (None, Some(_)) => false,
        })
    }

    fn report(&mut self, inbox: &Inbox, sample: &Sample, alien: bool) {
        let count = inbox.undecodable.load(Ordering::Relaxed);
        if (!alien && count == self.logged)
            || self.line.is_some_and(|line| line.elapsed() < BETWEEN_LINES)
        {
            return;
        }
        self.line = Some(Instant::now());
        self.logged = count;
        tracing::warn!(
            address = %inbox.address,
            undecodable = count,
            "samples cannot be decoded; the last one is {}",
            sample.encoding(),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marked(writer: u64, number: u64) -> Option<Mark> {
        Some(Mark { writer, number })
    }

    fn gate(last: Option<Mark>) -> Gate {
        Gate { last: last.map(Arrived::Marked), ..Gate::default() }
    }

    #[test]
    fn a_sample_that_came_both_ways_is_admitted_once() {
        let gate = gate(marked(1, 5));
        let asked = Asked(None);
        assert!(!gate.admits(marked(1, 5), Some(&asked)));
        assert!(!gate.admits(marked(1, 4), None));
        assert!(gate.admits(marked(1, 6), None));
        assert!(gate.admits(marked(1, 6), Some(&asked)));
    }

    #[test]
    fn a_late_reply_does_not_undo_what_another_writer_sent_meanwhile() {
        assert!(!gate(marked(2, 1)).admits(marked(1, 5), Some(&Asked(None))));
        assert!(gate(None).admits(marked(1, 5), Some(&Asked(None))));
        let before = Some(Arrived::Marked(Mark { writer: 1, number: 5 }));
        assert!(gate(marked(1, 5)).admits(marked(2, 1), Some(&Asked(before))));
    }

    #[test]
    fn samples_without_mark_are_all_news_but_replies_only_in_the_beginning() {
        assert!(gate(marked(1, 1)).admits(None, None));
        assert!(gate(None).admits(None, Some(&Asked(None))));
        assert!(!gate(marked(1, 1)).admits(None, Some(&Asked(None))));
    }
}
