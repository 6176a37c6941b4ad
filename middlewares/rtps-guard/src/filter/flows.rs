//! Tracks the sequence numbers of foreign writers: which they may announce, and which DDS may see.
//!
//! The numbers themselves may be large: a writer that runs for weeks at 1 kHz reaches 2^31. What is
//! harmful is a wide range, because RustDDS iterates over all numbers between those received and
//! those announced, and a jump, because RustDDS gives up all numbers before it.

use std::collections::HashMap;
use std::time::Duration;

use super::limits::{AHEAD, BELIEVED, FLOWS, HELD, LAST_NUMBER, REACH, WIDE, WINDOW};
use super::message::{Entity, Prefix, is_builtin};
use super::tally::Reason;

#[derive(Clone, Copy, Debug)]
struct Flow {
    /// Greatest number that was received, or declared not to come.
    high: i64,
    /// First number that is missing, and a bit set of the 64 from there on that were received.
    next: i64,
    after: u64,
    /// Greatest number announced.
    told: i64,
    /// How much further the writer may announce.
    ahead: i64,
    at: Duration,
    /// Since when all its announcements have been too far ahead.
    elsewhere: Option<Duration>,
}

impl Flow {
    fn new(told: i64, now: Duration) -> Self {
        Self { high: 0, next: 1, after: 0, told, ahead: AHEAD, at: now, elsewhere: None }
    }

    /// Marks all numbers before `end` as received or never coming.
    fn skip_to(&mut self, end: i64) {
        while self.next < end && self.after != 0 {
            self.step();
        }
        self.next = self.next.max(end);
        while self.after & 1 == 1 {
            self.step();
        }
    }

    /// Advances by one number; the lowest bit of `after` stands for `next` itself.
    fn step(&mut self) {
        self.next += 1;
        self.after >>= 1;
    }

    /// Marks a number as received. One that is too far ahead of `next` is not recorded, and is sent
    /// again.
    fn came(&mut self, number: i64) {
        self.high = self.high.max(number);
        if let Ok(bit @ 0..64) = u32::try_from(number - self.next) {
            self.after |= 1 << bit;
            self.skip_to(self.next);
        }
    }

    fn refill(&mut self, now: Duration) {
        let millis = i64::try_from(now.saturating_sub(self.at).as_millis()).unwrap_or(i64::MAX);
        let gained = millis.saturating_mul(AHEAD / 1000);
        self.ahead = self.ahead.saturating_add(gained);
        self.at = self.at.max(now);
    }
}

/// The part of a heartbeat that DDS may see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Heard {
    pub(crate) first: i64,
    pub(crate) last: i64,
}

#[derive(Debug)]
pub(crate) struct Flows {
    flows: HashMap<(Prefix, Entity), Flow>,
    /// How many wide heartbeats may still pass in the current second, and when it began.
    wide: u32,
    second: Duration,
}

impl Flows {
    pub(crate) fn new() -> Self {
        Self { flows: HashMap::new(), wide: WIDE, second: Duration::ZERO }
    }

    /// Checks whether a writer may announce this number.
    fn tell(&mut self, writer: (Prefix, Entity), number: i64, now: Duration) -> Result<(), Reason> {
        if number > LAST_NUMBER {
            return Err(Reason::Range);
        }
        if self.flows.len() >= FLOWS && !self.flows.contains_key(&writer) {
            // Forget writers that have been silent for a minute.
            self.flows.retain(|_, flow| now.saturating_sub(flow.at) < Duration::from_secs(60));
        }
        let known = self.flows.len();
        let flow = match self.flows.entry(writer) {
            std::collections::hash_map::Entry::Occupied(entry) => entry.into_mut(),
            std::collections::hash_map::Entry::Vacant(_) if known >= FLOWS => {
                return Err(Reason::Ends);
            }
            std::collections::hash_map::Entry::Vacant(entry) => {
                entry.insert(Flow::new(number, now))
            }
        };
        flow.refill(now);
        let step = number - flow.told;
        if step > flow.ahead {
            let since = *flow.elsewhere.get_or_insert(now);
            if now.saturating_sub(since) < BELIEVED {
                return Err(Reason::Ahead);
            }
            *flow = Flow::new(number, now);
        }
        if step > 0 {
            flow.ahead -= step.min(flow.ahead);
            flow.told = number;
        }
        flow.elsewhere = None;
        Ok(())
    }

    fn flow(&mut self, writer: (Prefix, Entity)) -> Option<&mut Flow> {
        self.flows.get_mut(&writer)
    }

    /// A sample, or a fragment of one.
    pub(crate) fn sample(
        &mut self,
        writer: (Prefix, Entity),
        number: i64,
        now: Duration,
    ) -> Result<(), Reason> {
        if number < 1 {
            return Err(Reason::Malformed);
        }
        self.tell(writer, number, now)?;
        if let Some(flow) = self.flow(writer) {
            flow.came(number);
        }
        Ok(())
    }

    /// Limits a heartbeat (8.3.8.6) to what DDS may see.
    ///
    /// DDS iterates over all numbers from the last received, or `first`, to `last`, and requests at
    /// most 256 of them. So it is enough if it sees those that follow the received ones; once they
    /// have arrived, the next heartbeat announces more.
    pub(crate) fn heartbeat(
        &mut self,
        writer: (Prefix, Entity),
        Heard { first, last }: Heard,
        now: Duration,
    ) -> Result<Heard, Reason> {
        if first < 0 || last < first.saturating_sub(1) {
            return Err(Reason::Malformed);
        }
        let high = self.flows.get(&writer).map_or(0, |flow| flow.high);
        if last - first.max(high) > HELD {
            return Err(Reason::Range);
        }
        self.tell(writer, last, now)?;
        let Some(flow) = self.flow(writer) else { return Err(Reason::Ends) };
        // Numbers before `first` will never come.
        flow.high = flow.high.max(first - 1);
        flow.skip_to(first);
        // RustDDS processes each announcement once. When it rediscovers a participant, it would
        // request those it has already, and a participant that did not lose us does not send them
        // again.
        let first = if is_builtin(writer.1) { first.max(flow.next.min(last + 1)) } else { first };
        if last - first < WINDOW {
            return Ok(Heard { first, last });
        }
        let first = first.max(flow.high - REACH);
        let last = last.min(flow.high.max(first) + WINDOW);
        if last - first > WINDOW && !self.may_be_wide(now) {
            return Err(Reason::Range);
        }
        Ok(Heard { first, last })
    }

    fn may_be_wide(&mut self, now: Duration) -> bool {
        if now.saturating_sub(self.second) >= Duration::from_secs(1) {
            (self.wide, self.second) = (WIDE, now);
        }
        let may = self.wide > 0;
        self.wide = self.wide.saturating_sub(1);
        may
    }

    /// Limits a gap (8.3.8.4), the numbers from `start` up to but not including `end` that will not
    /// come. Returns the end that DDS may see.
    ///
    /// DDS keeps an entry for each of these numbers unless all before them have come. That is
    /// always so for a gap that begins at the first number, which a late reader gets.
    pub(crate) fn gap(
        &mut self,
        writer: (Prefix, Entity),
        start: i64,
        end: i64,
        now: Duration,
    ) -> Result<i64, Reason> {
        if start < 1 || end < start {
            return Err(Reason::Malformed);
        }
        self.tell(writer, end - 1, now)?;
        let end = if start == 1 { end } else { end.min(start + WINDOW) };
        if let Some(flow) = self.flow(writer) {
            flow.high = flow.high.max(end - 1);
            if start <= flow.next {
                flow.skip_to(end);
            }
        }
        Ok(end)
    }

    /// Forgets the writers of a participant that is gone.
    pub(crate) fn forget(&mut self, participant: &Prefix) {
        self.flows.retain(|(prefix, _), _| prefix != participant);
    }
}
