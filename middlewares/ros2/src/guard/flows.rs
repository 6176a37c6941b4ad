//! How far the writers of others are: what they may announce, and what DDS may look at of it.
//!
//! Sequence numbers may be of any size: a writer that runs for weeks at 1 kHz is at 2^31. What
//! harms is a range, since RustDDS looks at each number between what it has and what is announced,
//! and a jump, since it gives up all that lies before.

use std::collections::HashMap;
use std::time::Duration;

use super::limits::{AHEAD, BELIEVED, FLOWS, HELD, LAST_NUMBER, REACH, WIDE, WINDOW};
use super::message::{Entity, Prefix, is_builtin};
use super::tally::Reason;

#[derive(Clone, Copy, Debug)]
struct Flow {
    /// The greatest number received, or declared void.
    high: i64,
    /// The first number that did not come yet, and which of the 64 after it did.
    next: i64,
    after: u64,
    /// The greatest number told of.
    told: i64,
    /// By so much it may go on.
    ahead: i64,
    at: Duration,
    /// Since when it only was where it could not be.
    elsewhere: Option<Duration>,
}

impl Flow {
    fn new(told: i64, now: Duration) -> Self {
        Self { high: 0, next: 1, after: 0, told, ahead: AHEAD, at: now, elsewhere: None }
    }

    /// All before `end` came, or will not come.
    fn skip_to(&mut self, end: i64) {
        while self.next < end && self.after != 0 {
            self.step();
        }
        self.next = self.next.max(end);
        while self.after & 1 == 1 {
            self.step();
        }
    }

    /// Goes on by one number; the lowest bit of `after` is that of `next` itself.
    fn step(&mut self) {
        self.next += 1;
        self.after >>= 1;
    }

    /// A sample came; one far ahead of the first that is missing is not noted, and comes again.
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

/// A heartbeat as DDS may hear it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Heard {
    pub(crate) first: i64,
    pub(crate) last: i64,
}

#[derive(Debug)]
pub(crate) struct Flows {
    flows: HashMap<(Prefix, Entity), Flow>,
    /// Wide heartbeats that may come, and since when.
    wide: u32,
    second: Duration,
}

impl Flows {
    pub(crate) fn new() -> Self {
        Self { flows: HashMap::new(), wide: WIDE, second: Duration::ZERO }
    }

    /// The writer tells of a number: whether that can be.
    fn tell(&mut self, writer: (Prefix, Entity), number: i64, now: Duration) -> Result<(), Reason> {
        if number > LAST_NUMBER {
            return Err(Reason::Range);
        }
        if self.flows.len() >= FLOWS && !self.flows.contains_key(&writer) {
            // Those that were silent longest are of no use any more.
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

    /// A sample, or a part of one.
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

    /// A heartbeat (8.3.8.6): what DDS may hear of it.
    ///
    /// DDS looks at each number from what it has, or `first`, to `last`, and asks for 256 of them
    /// at most. So it suffices that it hears of those that follow what was received; when they
    /// have come, the next heartbeat tells of more.
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
        // What comes before the first one will never come.
        flow.high = flow.high.max(first - 1);
        flow.skip_to(first);
        // Announcements RustDDS takes once: when it meets somebody again, it would ask for those
        // it has, and who did not lose it does not send them again.
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

    /// Numbers that will not come, from `start` to before `end` (8.3.8.4): the end as DDS may hear
    /// it.
    ///
    /// DDS keeps a note for each of them, unless all before them has come: that is so of the first
    /// number of all, which is where the gap of a late reader begins.
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

    /// A participant is gone, and its writers with it.
    pub(crate) fn forget(&mut self, participant: &Prefix) {
        self.flows.retain(|(prefix, _), _| prefix != participant);
    }
}
