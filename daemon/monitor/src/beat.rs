//! Heartbeats: time between two calls of a codel, or two values of a port.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// In place of a date.
const NONE: u64 = u64::MAX;
/// A beat came at that date.
const BEAT: u64 = 1;

/// A heartbeat. Whoever makes it beat does so with a few atomic operations.
#[derive(Debug)]
pub struct Beat {
    least: u64,
    longest: u64,
    /// All that concerns it happens in one thread.
    sole: bool,
    /// Only while activities run: how many do. `None` for always.
    running: Option<AtomicU32>,
    /// Twice the date from which on the next beat is waited for, and one more if that is the date of
    /// a beat; [`NONE`] while none is waited for.
    from: AtomicU64,
    /// Of which `from` it was told that none came.
    told: AtomicU64,
}

/// What concerns a heartbeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pulse {
    /// It beats.
    Beats,
    /// An activity begins, during which it is waited for.
    Begins,
    /// It ends.
    Ends,
}

/// A heartbeat that is not in time: nanoseconds since the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OffBeat {
    /// It came too soon.
    Soon(u64),
    /// It did not come in time.
    Late(u64),
}

impl Beat {
    /// One that comes so soon and so late; whether only while activities run, and whether all that
    /// concerns it happens in one thread.
    #[must_use]
    pub fn new((least, longest): (u64, u64), during: bool, sole: bool) -> Self {
        let date = || AtomicU64::new(NONE);
        let running = during.then(AtomicU32::default);
        Self { least, longest, sole, running, from: date(), told: date() }
    }

    /// Something that concerns it happens at this date; returns what that breaks.
    #[inline]
    pub fn hear(&self, pulse: Pulse, now: u64) -> Option<OffBeat> {
        match pulse {
            Pulse::Beats => self.beats(now),
            Pulse::Begins => {
                let before = self.running.as_ref()?.fetch_add(1, Ordering::AcqRel);
                if before == 0 {
                    self.awaits(now);
                }
                None
            }
            Pulse::Ends => {
                let less = |running: u32| running.checked_sub(1);
                let running = self.running.as_ref()?;
                let before = running.fetch_update(Ordering::SeqCst, Ordering::Acquire, less);
                if before != Ok(1) {
                    return None;
                }
                let from = self.moves_to(NONE);
                self.is_late(from, now)
            }
        }
    }

    /// From now on the next beat is waited for from another date; returns the one before.
    #[inline]
    fn moves_to(&self, from: u64) -> u64 {
        if self.sole {
            let before = self.from.load(Ordering::Acquire);
            self.from.store(from, Ordering::Release);
            return before;
        }
        self.from.swap(from, Ordering::SeqCst)
    }

    #[inline]
    fn beats(&self, now: u64) -> Option<OffBeat> {
        self.beats_while(now, |_| {})
    }

    /// The same, with what other threads do between its steps: before the date moves (1), and after
    /// that (2).
    #[inline]
    fn beats_while(&self, now: u64, others: impl Fn(u8)) -> Option<OffBeat> {
        let none = |running: &AtomicU32| running.load(Ordering::SeqCst) == 0;
        if self.running.as_ref().is_some_and(none) {
            return None;
        }
        others(1);
        let beat = now << 1 | BEAT;
        let from = self.moves_to(beat);
        others(2);
        if !self.sole && self.running.as_ref().is_some_and(none) {
            // The last activity ended meanwhile, in another thread: nothing is waited for.
            let (done, failed) = (Ordering::SeqCst, Ordering::Relaxed);
            let _ = self.from.compare_exchange(beat, NONE, done, failed);
        }
        let since = now.saturating_sub(from >> 1);
        if from != NONE && from & BEAT > 0 && since < self.least {
            return Some(OffBeat::Soon(since));
        }
        self.is_late(from, now)
    }

    /// From this date on it is waited for.
    fn awaits(&self, now: u64) {
        self.from.store(now << 1, Ordering::Release);
    }

    /// The same, unless it depends on activities.
    pub fn awaits_always(&self, now: u64) {
        if self.running.is_none() {
            self.awaits(now);
        }
    }

    /// Whether it did not come in time until this date, and nobody was told that.
    fn is_late(&self, from: u64, now: u64) -> Option<OffBeat> {
        let since = now.saturating_sub(from >> 1);
        let late = from != NONE && since > self.longest;
        let first = || self.told.swap(from, Ordering::AcqRel) != from;
        (late && first()).then_some(OffBeat::Late(since))
    }

    /// Whether it did not come in time, seen from outside.
    #[must_use]
    pub fn look(&self, now: u64) -> Option<OffBeat> {
        self.is_late(self.from.load(Ordering::Acquire), now)
    }

    /// The date at which it will be too late.
    #[must_use]
    pub fn due(&self) -> Option<u64> {
        let from = self.from.load(Ordering::Acquire);
        let waits = from != NONE && self.told.load(Ordering::Acquire) != from;
        waits.then(|| (from >> 1).saturating_add(self.longest).saturating_add(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beat_too_early_too_late_or_never_is_told_once_each() {
        for sole in [false, true] {
            let beat = Beat::new((8, 12), false, sole);
            assert_eq!((beat.due(), beat.look(100)), (None, None), "nothing is waited for yet");
            beat.awaits_always(100);
            assert_eq!(beat.due(), Some(113));
            assert_eq!(beat.hear(Pulse::Beats, 103), None, "the first may come at once");
            assert_eq!(beat.hear(Pulse::Beats, 110), Some(OffBeat::Soon(7)));
            assert_eq!(beat.hear(Pulse::Beats, 122), None, "the longest time is in time");
            assert_eq!(beat.look(134), None, "it may come at this date");
            assert_eq!(beat.look(135), Some(OffBeat::Late(13)));
            assert_eq!((beat.look(140), beat.due()), (None, None));
            assert_eq!(beat.hear(Pulse::Beats, 150), None, "it was told");
            assert_eq!(beat.hear(Pulse::Beats, 163), Some(OffBeat::Late(13)));
        }
    }

    #[test]
    fn no_beat_is_waited_for_if_the_last_activity_ends_in_another_thread_during_one() {
        for end in [1, 2] {
            let beat = Beat::new((8, 12), true, false);
            assert_eq!(beat.hear(Pulse::Begins, 10), None);
            let fact = beat.beats_while(20, |between| {
                if between == end {
                    assert_eq!(beat.hear(Pulse::Ends, 20), None);
                }
            });
            assert_eq!((fact, beat.due(), beat.look(1_000)), (None, None, None), "{end}");
            // The next activity is waited for as ever.
            assert_eq!(beat.hear(Pulse::Begins, 2_000), None);
            assert_eq!(beat.look(2_013), Some(OffBeat::Late(13)));
        }
    }

    #[test]
    fn a_beat_that_depends_on_activities_is_waited_for_while_one_runs() {
        for sole in [false, true] {
            let beat = Beat::new((8, 12), true, sole);
            beat.awaits_always(0);
            assert_eq!((beat.due(), beat.hear(Pulse::Beats, 5)), (None, None));
            assert_eq!(beat.hear(Pulse::Begins, 10), None);
            assert_eq!(beat.hear(Pulse::Begins, 15), None);
            assert_eq!(beat.due(), Some(23));
            assert_eq!(beat.hear(Pulse::Ends, 20), None);
            assert_eq!(beat.hear(Pulse::Ends, 25), Some(OffBeat::Late(15)));
            assert_eq!((beat.due(), beat.look(90)), (None, None));
        }
    }
}
