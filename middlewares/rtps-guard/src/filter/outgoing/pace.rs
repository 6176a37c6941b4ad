//! How fast large samples go once a reader has lost parts of one.
//!
//! RustDDS sends a sample as one burst. The socket of a reader may have room for three datagrams of
//! 64 KiB, or for 92 from a network: other libraries leave it at `net.core.rmem_default`. What has
//! no room is lost, and nothing tells a writer how much there is. So after a loss datagrams with
//! fragments go with pauses between them.

use std::time::Duration;

/// Bytes that go at once, and how many of them have to be taken before the next: two datagrams of
/// 64 KiB, and one.
const AT_ONCE: u64 = 128 << 10;
const TAKEN: u64 = 64 << 10;

/// Bytes a second: 6 MB in 20 ms, so that 30 of them go in a second on one machine.
const RATE: u64 = 300_000_000;

/// Bytes that a datagram counts at least: it takes a reader as long as these, and more room than it
/// has bytes. Of the datagrams of 1.3 KiB of a network 50,000 go in a second, 64 MB.
const LEAST: u64 = 6000;

/// How long a reader has to prepare for the rest of a sample after the first part of it: Fast DDS
/// then touches all pages of a new buffer.
const FIRST: Duration = Duration::from_millis(1);

/// How long this lasts after a loss.
const LASTS: Duration = Duration::from_secs(600);

#[derive(Debug, Default)]
pub(crate) struct Pace {
    until: Option<Duration>,
    /// Bytes sent that readers need not have taken yet, and when that was so.
    ahead: u64,
    at: Duration,
}

impl Pace {
    /// A reader has lost parts of a sample.
    pub(crate) fn lost(&mut self, now: Duration) {
        self.until = Some(now + LASTS);
    }

    /// Whether a reader has lost something of late.
    pub(crate) fn is_slow(&self, now: impl FnOnce() -> Duration) -> bool {
        self.until.is_some_and(|until| now() < until)
    }

    /// How long to wait before so many bytes go, if at all.
    pub(crate) fn pause(&mut self, bytes: usize, now: Duration) -> Option<Duration> {
        self.ahead = self.ahead.saturating_sub(taken(now.saturating_sub(self.at)));
        // A pause that was decided on may lie ahead.
        self.at = self.at.max(now);
        if self.ahead >= AT_ONCE {
            self.at += Duration::from_nanos((self.ahead - TAKEN) * 1_000_000_000 / RATE);
            self.ahead = TAKEN;
        }
        self.ahead += (bytes as u64).max(LEAST);
        self.at.checked_sub(now).filter(|pause| !pause.is_zero())
    }

    /// The first part of a sample goes now.
    pub(crate) fn begin(&mut self) {
        self.at += FIRST;
    }
}

/// What is taken in this time; no more is ahead than a few datagrams.
fn taken(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX).saturating_mul(RATE / 1_000_000) / 1000
}

#[cfg(test)]
mod tests {
    use super::*;

    const DATAGRAM: usize = 65_400;

    #[test]
    fn after_a_loss_fragments_go_no_faster_than_readers_take_them() {
        let mut pace = Pace::default();
        let begun = Duration::from_secs(9);
        assert!(!pace.is_slow(|| begun));
        pace.lost(begun);
        assert!(pace.is_slow(|| begun) && !pace.is_slow(|| begun + LASTS));
        let mut now = begun;
        let sent = 1000;
        for _ in 0..sent {
            now += pace.pause(DATAGRAM, now).unwrap_or_default();
        }
        let most = u64::try_from((now - begun).as_nanos()).unwrap() * RATE / 1_000_000_000;
        let sent = sent * DATAGRAM as u64;
        assert!(sent <= most + AT_ONCE + DATAGRAM as u64 && sent > most, "{sent} {most}");
    }

    #[test]
    fn the_rest_of_a_sample_waits_for_the_reader_to_prepare() {
        let mut pace = Pace::default();
        let now = Duration::from_secs(9);
        assert_eq!(pace.pause(DATAGRAM, now), None);
        pace.begin();
        assert_eq!(pace.pause(DATAGRAM, now), Some(FIRST));
        assert_eq!(pace.pause(DATAGRAM, now + FIRST), None);
    }
}
