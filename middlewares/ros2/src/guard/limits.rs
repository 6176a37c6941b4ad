//! How much of others this daemon bears: bounds far above what peers do, and below what hurts.

use std::time::Duration;

/// What peers may have this daemon hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Limits {
    /// Bytes of the greatest sample that is put together of fragments. Default: 64 MiB.
    pub(crate) sample: u32,
    /// Participants that are known at a time; one address may have half of them. Default: 1024.
    pub(crate) participants: usize,
    /// A participant that is silent for so long is gone, however long it asks to be waited for.
    /// Default: 50 s, as long as others wait for this daemon, so that both give up.
    pub(crate) silence: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self { sample: 64 << 20, participants: 1024, silence: Duration::from_secs(50) }
    }
}

impl Limits {
    /// Bytes of samples that are put together at a time; one participant may have half of them.
    pub(crate) fn assembly(&self) -> u64 {
        u64::from(self.sample) * 8
    }

    /// Fragments of one sample. DDS libraries cut at 1 KiB and more.
    pub(crate) fn fragments(&self) -> u32 {
        (self.sample / 1024).max(1 << 16)
    }
}

/// Writers and readers that one participant may have announced at a time.
pub(crate) const ENDS: usize = 4096;

/// Writers and readers that all participants may have announced at a time.
pub(crate) const ALL_ENDS: usize = 32_768;

/// The greatest sequence number that counts as one: at 1 MHz it takes a writer 2000 years.
pub(crate) const LAST_NUMBER: i64 = 1 << 56;

/// Sequence numbers that a heartbeat may name as they are: DDS looks at each of them.
pub(crate) const WINDOW: i64 = 4096;

/// Sequence numbers behind the last one received that may still be looked at.
pub(crate) const REACH: i64 = 1 << 18;

/// Samples that a heartbeat says a writer holds: no writer has the memory for more.
pub(crate) const HELD: i64 = 1 << 24;

/// By so much a writer may be ahead of what was heard of it, at once and for each second.
pub(crate) const AHEAD: i64 = 1 << 20;

/// A writer whose numbers went on elsewhere for so long is believed.
pub(crate) const BELIEVED: Duration = Duration::from_secs(3);

/// Heartbeats of more than [`WINDOW`] numbers that are let through in a second.
pub(crate) const WIDE: u32 = 50;

/// Writers whose numbers are followed.
pub(crate) const FLOWS: usize = 32_768;

/// Samples that are put together at a time.
pub(crate) const ASSEMBLIES: usize = 4096;

/// DDS gives up a sample whose fragments stopped coming for so long, when others of its writer
/// come; else it counts for the longer time.
pub(crate) const GIVEN_UP: (Duration, Duration) =
    (Duration::from_secs(13), Duration::from_secs(60));

/// Locators of a participant, an end or a reply: each is sent to.
pub(crate) const LOCATORS: u32 = 32;

/// Parameters of one list.
pub(crate) const PARAMETERS: usize = 512;

/// Bytes of a name in an announcement, and of data that a user attaches.
pub(crate) const NAME: usize = 1024;
pub(crate) const USER_DATA: usize = 16 << 10;
