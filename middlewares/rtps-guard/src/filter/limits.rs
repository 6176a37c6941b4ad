//! Limits for what others may cause here: far above what peers need, and below what does harm.

use std::time::Duration;

/// Limits that options set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Size in bytes of the largest sample that is reassembled from fragments. Default: 64 MiB.
    pub sample: u32,
    /// Number of participants at a time; one address may have half of them. Default: 1024.
    pub participants: usize,
    /// Longest lease: a participant that is silent for this long counts as gone, whatever lease it
    /// announces. Default: 50 s, the lease of this daemon, so that both sides give up at the same
    /// time.
    pub silence: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self { sample: 64 << 20, participants: 1024, silence: Duration::from_secs(50) }
    }
}

impl Limits {
    /// Bytes of samples being reassembled at a time; one participant may use half of them.
    pub(crate) fn assembly(&self) -> u64 {
        u64::from(self.sample) * 8
    }

    /// Number of fragments of one sample. DDS libraries use fragments of at least 1 KiB.
    pub(crate) fn fragments(&self) -> u32 {
        (self.sample / 1024).max(1 << 16)
    }
}

/// Writers and readers that one participant may have at a time.
pub(crate) const ENDS: usize = 4096;

/// Writers and readers that all participants together may have at a time.
pub(crate) const ALL_ENDS: usize = 32_768;

/// Greatest valid sequence number; a writer at 1 MHz needs 2000 years to reach it.
pub(crate) const LAST_NUMBER: i64 = 1 << 56;

/// Width up to which the range of a heartbeat is not limited; DDS iterates over it.
pub(crate) const WINDOW: i64 = 4096;

/// How far before the last received number a range may begin.
pub(crate) const REACH: i64 = 1 << 18;

/// Greatest number of samples that a writer may claim to hold; no writer has memory for more.
pub(crate) const HELD: i64 = 1 << 24;

/// How far a writer may get ahead of what was heard of it: at once, and additionally per second.
pub(crate) const AHEAD: i64 = 1 << 20;

/// A jump is accepted if the writer's numbers have all been ahead for this long.
pub(crate) const BELIEVED: Duration = Duration::from_secs(3);

/// Heartbeats wider than [`WINDOW`] that may pass per second.
pub(crate) const WIDE: u32 = 50;

/// Number of writers whose sequence numbers are tracked.
pub(crate) const FLOWS: usize = 32_768;

/// Number of samples being reassembled at a time.
pub(crate) const ASSEMBLIES: usize = 4096;

/// Time without fragments after which DDS gives up a sample: the first if its writer sends others,
/// else the second.
pub(crate) const GIVEN_UP: (Duration, Duration) =
    (Duration::from_secs(13), Duration::from_secs(60));

/// Number of locators of a participant, an end or a reply; DDS sends to each of them.
pub(crate) const LOCATORS: u32 = 32;

/// Number of parameters in one list.
pub(crate) const PARAMETERS: usize = 512;

/// Size in bytes of a name in an announcement, and of user data.
pub(crate) const NAME: usize = 1024;
pub(crate) const USER_DATA: usize = 16 << 10;
