//! What was kept from DDS: counted by reason, and told in one line a second at most.

use std::net::IpAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::complaints::Complaints;

/// Why something was kept from DDS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reason {
    /// It is no message of the protocol.
    Malformed,
    /// Its participant did not announce itself (yet): usual when others come and go.
    Stranger,
    /// It speaks in the name of another participant, or mixes up ends.
    Name,
    /// It names more sequence numbers than a writer can hold.
    Range,
    /// It runs far ahead of what was heard of its writer.
    Ahead,
    /// Its sample is greater than samples may be.
    Sample,
    /// More samples are being put together than fit.
    Assembly,
    /// There are too many participants.
    Participants,
    /// There are too many writers and readers.
    Ends,
    /// It announces more than anybody needs.
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

    pub(crate) fn text(self) -> &'static str {
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

/// Counts what was kept from DDS. Written by DDS's threads, read by anybody.
#[derive(Debug, Default)]
pub(crate) struct Tally {
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

    /// How many, why, and who sent the last one; those that are usual are left out.
    pub(crate) fn list(&self) -> Vec<(Reason, u64, Option<IpAddr>)> {
        let last = *self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let counts = Reason::ALL.into_iter().zip(&self.counts).zip(last);
        counts
            .map(|((reason, count), peer)| (reason, count.load(Ordering::Relaxed), peer))
            .filter(|(reason, count, _)| *count > 0 && *reason != Reason::Stranger)
            .collect()
    }
}
