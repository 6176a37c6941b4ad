//! Records what codels did to the process, where it happens, also in signal handlers; taken out
//! when it is logged. Nothing here allocates, locks or waits.

use std::sync::atomic::{AtomicI32, AtomicU8, AtomicU32, Ordering};

/// What a codel did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Act {
    /// A signal without handler was received; its number.
    Signal = 1,
    /// A signal was sent to the own process; its number.
    Sent,
    /// An attempt to lower a limit of the process; its resource.
    Limit,
    /// An attempt to close a standard descriptor.
    Close,
    /// A standard descriptor was closed, and was opened again.
    Reopened,
}

/// An act, with the number of times since it was last taken.
#[derive(Debug)]
pub(crate) struct Note {
    pub(crate) act: Act,
    /// Signal, resource or descriptor.
    pub(crate) number: i32,
    /// Sender of a signal: a process id, or 0 for the kernel and its timers.
    pub(crate) sender: i32,
    pub(crate) times: u32,
    /// The code that did it, as in crash reports; empty if unknown.
    pub(crate) words: String,
}

/// Bytes for the description of the code.
const ROOM: usize = 200;

/// A record of one act and number.
struct Slot {
    /// 0 while it is free, else the act and the number.
    key: AtomicU32,
    times: AtomicU32,
    sender: AtomicI32,
    /// Whether a thread is writing or reading the words.
    busy: AtomicU8,
    words: [AtomicU8; ROOM],
}

/// Further kinds of acts at the same time are not recorded.
static SLOTS: [Slot; 32] = [const {
    Slot {
        key: AtomicU32::new(0),
        times: AtomicU32::new(0),
        sender: AtomicI32::new(0),
        busy: AtomicU8::new(0),
        words: [const { AtomicU8::new(0) }; ROOM],
    }
}; 32];

fn key(act: Act, number: i32) -> u32 {
    u32::from(act as u8) << 24 | (number.unsigned_abs() & 0xff_ffff)
}

/// Records an act of the code that `words` describe. Signal handlers may call it.
pub(crate) fn add(act: Act, number: i32, sender: i32, words: &str) {
    let key = key(act, number);
    let own = |slot: &&Slot| {
        let taken = slot.key.compare_exchange(0, key, Ordering::AcqRel, Ordering::Acquire);
        taken.is_ok() || taken == Err(key)
    };
    let Some(slot) = SLOTS.iter().find(own) else { return };
    if slot.busy.swap(1, Ordering::Acquire) == 0 {
        // Keeps the name: the same signal may come again while no codel runs.
        if !words.is_empty() || slot.times.load(Ordering::Relaxed) == 0 {
            let mut ends = (0..=words.len().min(ROOM - 1)).rev();
            let end = ends.find(|at| words.is_char_boundary(*at)).unwrap_or(0);
            for (to, byte) in slot.words.iter().zip(words.bytes().take(end).chain([0])) {
                to.store(byte, Ordering::Relaxed);
            }
            slot.sender.store(sender, Ordering::Relaxed);
        }
        slot.busy.store(0, Ordering::Release);
    }
    slot.times.fetch_add(1, Ordering::Release);
}

fn read(slot: &Slot, act: Act, number: i32, times: u32) -> Note {
    let bytes = slot.words.iter().map(|byte| byte.load(Ordering::Relaxed));
    let bytes: Vec<u8> = bytes.take_while(|byte| *byte != 0).collect();
    let words = String::from_utf8_lossy(&bytes).into_owned();
    let sender = slot.sender.load(Ordering::Relaxed);
    Note { act, number, sender, times, words }
}

/// Takes the records of these acts.
pub(crate) fn take(acts: &[Act]) -> Vec<Note> {
    let mut notes = Vec::new();
    for slot in &SLOTS {
        let key = slot.key.load(Ordering::Acquire);
        let Some(act) = acts.iter().find(|act| **act as u32 == key >> 24) else { continue };
        let times = slot.times.swap(0, Ordering::AcqRel);
        if times > 0 && slot.busy.swap(1, Ordering::Acquire) == 0 {
            notes.push(read(slot, *act, (key & 0xff_ffff).cast_signed(), times));
            slot.busy.store(0, Ordering::Release);
        }
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_act_is_told_once_with_how_often_and_by_whom() {
        let taken = || take(&[Act::Close]);
        assert!(taken().is_empty());
        add(Act::Close, 2, 0, "codel `a`");
        add(Act::Close, 2, 0, "");
        add(Act::Close, 1, 7, &"x".repeat(500));
        let notes = taken();
        assert_eq!(notes.len(), 2);
        assert_eq!((notes[0].number, notes[0].times, notes[0].words.as_str()), (2, 2, "codel `a`"));
        assert_eq!((notes[1].sender, notes[1].words.len()), (7, ROOM - 1));
        assert!(taken().is_empty());
    }
}
