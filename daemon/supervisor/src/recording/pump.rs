//! The thread of one recording: collects samples and notes, and sends them in order of date.

use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use genom_ports::dates::Calendar;
use genom_ports::tape::Reel;
use genom_protocol::frames::{End, Frame, Lost, Sample, Start};
use serde_json::json;
use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::TryRecvError;
use tokio::sync::mpsc::Sender;

use super::Session;
use super::notes::{SUBJECTS, Subject};
use crate::waiting::wait;
use genom_bus::Numbered;
use genom_bus::flag::Flag;

/// How often tapes are emptied: far more often than they can fill up.
const LOOK: Duration = Duration::from_millis(2);
/// Approximate size of a batch that is sent, in bytes.
const BATCH: usize = 64 << 10;
/// A reader that takes nothing for this long is given up.
const SLOWEST_READER: Duration = Duration::from_secs(60);

/// The machine's clock counts as set if it changed by more than this between two checks, in
/// nanoseconds. Gradual adjustment (NTP) changes it less.
const SET: u64 = 100_000_000;

/// A port that is recorded.
struct Channel {
    number: u16,
    reel: Reel,
    /// Number of lost samples reported so far.
    told: u64,
}

struct Pump<'a> {
    session: &'a Session,
    changes: Receiver<Numbered>,
    channels: Vec<Channel>,
    /// Number of the next channel, as long as there are any.
    next: Option<u16>,
    notes_lost: [u64; SUBJECTS.len()],
    /// How far the clock was when that was told last.
    until: u64,
    /// The machine's clock at the last note about it.
    noted: Calendar,
    sender: Sender<Vec<u8>>,
}

/// The reader is gone.
struct Gone;

/// Records until the end is requested, `closed` is raised or the reader is gone. Blocks.
pub fn run(
    closed: &Flag,
    session: &Session,
    changes: Receiver<Numbered>,
    sender: Sender<Vec<u8>>,
    start: Start,
) {
    let mut pump = Pump {
        session,
        changes,
        channels: Vec::new(),
        next: Some(SUBJECTS.len() as u16),
        notes_lost: [0; SUBJECTS.len()],
        until: 0,
        noted: session.calendar,
        sender,
    };
    if pump.follow(closed, start).is_err() {
        tracing::info!("recording {}: nobody reads it any more", session.number);
    }
}

impl Pump<'_> {
    fn follow(&mut self, closed: &Flag, start: Start) -> Result<(), Gone> {
        let mut out = Vec::new();
        Frame::Start(start).append(&mut out);
        for subject in SUBJECTS {
            Frame::Channel(subject.head()).append(&mut out);
        }
        loop {
            // Read before the last collection, which then includes everything taken until now.
            let asked = self.session.end.load(Ordering::Acquire);
            let stopped = closed.is_up();
            self.look(&mut out)?;
            if asked || stopped {
                let why = if asked { "asked" } else { "the daemon stops" };
                Frame::End(End { why: why.to_owned() }).append(&mut out);
                return self.send(&mut out);
            }
            self.send(&mut out)?;
            std::thread::park_timeout(LOOK);
        }
    }

    /// Collects all available samples and notes.
    fn look(&mut self, out: &mut Vec<u8>) -> Result<(), Gone> {
        // Read before the collection, which then includes everything of earlier dates.
        let until = self.session.dates.moment();
        let new =
            std::mem::take(&mut *self.session.new.lock().unwrap_or_else(PoisonError::into_inner));
        for (mut head, reel) in new {
            let Some(number) = self.next else {
                let topic = head.topic;
                tracing::warn!("{topic} is not recorded: a recording has 65,536 channels at most");
                continue;
            };
            head.channel = number;
            Frame::Channel(head).append(out);
            self.channels.push(Channel { number, reel, told: 0 });
            self.next = number.checked_add(1);
        }
        self.take_changes();
        self.look_at_the_clock();
        // The frames collected in this round, to be sorted by date.
        let calendar = self.session.calendar;
        let mut bytes = Vec::new();
        let mut frames: Vec<(u64, std::ops::Range<usize>)> = Vec::new();
        let mut lost = Vec::new();
        self.channels.retain_mut(|Channel { number, reel, told }| {
            let over = reel.is_over();
            reel.wind(|sample| {
                let begin = bytes.len();
                let date = calendar.date(sample.moment);
                let (channel, number, message) = (*number, sample.number, sample.message);
                Frame::Sample(Sample { channel, number, date, message }).append(&mut bytes);
                frames.push((date, begin..bytes.len()));
            });
            let count = reel.lost();
            if count > *told {
                *told = count;
                lost.push(Lost { channel: *number, lost: count });
            }
            !over
        });
        let (notes, notes_lost) = self.session.notes.take();
        for note in notes {
            let (begin, channel) = (bytes.len(), note.subject.channel());
            let date = calendar.date(note.moment);
            let (number, message) = (note.number, note.text.as_bytes());
            Frame::Sample(Sample { channel, number, date, message }).append(&mut bytes);
            frames.push((date, begin..bytes.len()));
        }
        for (channel, (&count, told)) in (0..).zip(notes_lost.iter().zip(&mut self.notes_lost)) {
            if count > *told {
                *told = count;
                lost.push(Lost { channel, lost: count });
            }
        }
        frames.sort_by_key(|(date, _)| *date);
        for (_, range) in frames {
            out.extend_from_slice(&bytes[range]);
            if out.len() >= BATCH {
                self.send(out)?;
            }
        }
        for told in lost {
            Frame::Lost(told).append(out);
        }
        if self.session.ordered && until > self.until {
            self.until = until;
            Frame::Until(until).append(out);
        }
        Ok(())
    }

    fn take_changes(&mut self) {
        loop {
            match self.changes.try_recv() {
                Ok(change) => {
                    if let Some(on) = self.session.takes(&change) {
                        self.session.notes.add(on, change.moment, &change.data);
                    }
                }
                Err(TryRecvError::Lagged(count)) => {
                    self.session.notes.lose(Subject::Changes, count);
                }
                Err(TryRecvError::Empty | TryRecvError::Closed) => return,
            }
        }
    }

    /// Adds a note if the machine's clock was set, because dates of the recording do not follow it.
    fn look_at_the_clock(&mut self) {
        let now = self.session.dates.calendar();
        if self.noted.until(now).unsigned_abs() > SET {
            self.noted = now;
            let ahead = self.session.calendar.until(now);
            let moment = self.session.dates.moment();
            let note = json!({"event": "clock_set", "ahead_ns": ahead});
            self.session.notes.add(Subject::Changes, moment, &note);
        }
    }

    fn send(&self, out: &mut Vec<u8>) -> Result<(), Gone> {
        if out.is_empty() {
            return if self.sender.is_closed() { Err(Gone) } else { Ok(()) };
        }
        let batch = std::mem::take(out);
        let sent = wait(self.sender.send(batch), Some(Instant::now() + SLOWEST_READER));
        sent.and_then(Result::ok).ok_or(Gone)
    }
}
