//! Counts what was kept from DDS, by reason; logs at most one line per second.

use std::net::IpAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use genom_kit::complaints::Complaints;

/// Why something was kept from DDS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// It is not a valid RTPS message.
    Malformed,
    /// Its participant has not announced itself (yet). Normal while participants appear and
    /// disappear.
    Stranger,
    /// It claims to be from another participant, or combines ends that do not belong together.
    Name,
    /// It names more sequence numbers than a writer can hold.
    Range,
    /// Its sequence number is far ahead of what was heard of its writer.
    Ahead,
    /// Its sample is larger than allowed.
    Sample,
    /// Too many samples are being reassembled.
    Assembly,
    /// There are too many participants.
    Participants,
    /// There are too many writers and readers.
    Ends,
    /// Its announcement is larger than any peer needs.
    Announcement,
}

impl Reason {
    pub(crate) const ALL: [Self; 10] = [
        Self::Malformed,
        Self::Stranger,
        Self::Name,
        Self::Range,
        Self::Ahead,
        Self::Sample,
        Self::Assembly,
        Self::Participants,
        Self::Ends,
        Self::Announcement,
    ];

    /// As the log and lists word it.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Malformed => "no message of RTPS",
            Self::Stranger => "a participant that did not announce itself",
            Self::Name => "speaks for somebody else",
            Self::Range => "more sequence numbers than a writer can hold",
            Self::Ahead => "far ahead of what its writer sent",
            Self::Sample => "a sample above [backends.ros2] greatest_sample",
            Self::Assembly => "too many samples in fragments at a time",
            Self::Participants => "participants above [backends.ros2] participants",
            Self::Ends => "too many writers and readers",
            Self::Announcement => "an announcement of absurd size",
        }
    }
}

/// Counters, written by DDS's threads and read by any thread.
#[derive(Debug, Default)]
pub struct Tally {
    counts: [AtomicU64; Reason::ALL.len()],
    last: Mutex<[Option<IpAddr>; Reason::ALL.len()]>,
    lines: Complaints,
}

impl Tally {
    pub(crate) fn add(&self, reason: Reason, peer: Option<IpAddr>) {
        if let Some(count) = self.counts.get(reason as usize) {
            count.fetch_add(1, Ordering::Relaxed);
        }
        if reason == Reason::Stranger {
            return;
        }
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(last) = last.get_mut(reason as usize) {
            *last = peer;
        }
        drop(last);
        if let Some(refused) = self.lines.add() {
            let peer =
                peer.map_or_else(|| "an unknown address".to_owned(), |peer| peer.to_string());
            tracing::warn!(%peer, why = reason.text(), refused, "refused: an RTPS message");
        }
    }

    /// Each reason with its count and the sender of the last one; without reasons that are normal.
    #[must_use]
    pub fn list(&self) -> Vec<(Reason, u64, Option<IpAddr>)> {
        let last = *self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let counts = Reason::ALL.into_iter().zip(&self.counts).zip(last);
        counts
            .map(|((reason, count), peer)| (reason, count.load(Ordering::Relaxed), peer))
            .filter(|(reason, count, _)| *count > 0 && *reason != Reason::Stranger)
            .collect()
    }
}
