//! Samples of several processes in one order, the same in each run: by date, by process where dates
//! are equal, and as they came.
//!
//! Of a stepped clock only: processes are stepped one after the other there, so that one can be ahead
//! of others by a whole step, and what comes of all of them comes as the machine has it. Each says how
//! far it is ([`genom_protocol::frames::Frame::Until`]); a sample waits until all are further than its
//! date.

use std::collections::BTreeMap;

/// Bytes of samples that wait at most. What is beyond goes on as it came: a process that is not
/// stepped any more keeps nobody back.
const MOST: usize = 64 << 20;

/// A sample that waits.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Held {
    pub(super) channel: u16,
    pub(super) date: u64,
    pub(super) message: Vec<u8>,
}

/// By date, process, and as they came.
type Place = (u64, usize, u64);

#[derive(Debug)]
pub(super) struct Order {
    /// Of each process, the date that it has passed.
    until: Vec<u64>,
    held: BTreeMap<Place, Held>,
    bytes: usize,
    came: u64,
}

impl Order {
    /// Of so many processes.
    pub(super) fn of(processes: usize) -> Self {
        Self { until: vec![0; processes], held: BTreeMap::new(), bytes: 0, came: 0 }
    }

    /// A sample of a process has come.
    pub(super) fn hold(&mut self, process: usize, held: Held) {
        self.bytes += held.message.len();
        self.held.insert((held.date, process, self.came), held);
        self.came += 1;
    }

    /// What comes of this process from now on is not dated before that.
    pub(super) fn has_come(&mut self, process: usize, until: u64) {
        if let Some(known) = self.until.get_mut(process) {
            *known = until;
        }
    }

    /// The next sample that no other can precede.
    pub(super) fn next(&mut self) -> Option<Held> {
        let all = self.until.iter().copied().min().unwrap_or(u64::MAX);
        let first = self.held.first_entry()?;
        if first.key().0 >= all && all != u64::MAX && self.bytes <= MOST {
            return None;
        }
        let held = first.remove();
        self.bytes -= held.message.len();
        Some(held)
    }

    /// Nothing more will come.
    pub(super) fn end(&mut self) {
        self.until.fill(u64::MAX);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(date: u64, message: &[u8]) -> Held {
        Held { channel: 0, date, message: message.to_vec() }
    }

    fn all(order: &mut Order) -> Vec<(u64, Vec<u8>)> {
        std::iter::from_fn(|| order.next()).map(|held| (held.date, held.message)).collect()
    }

    #[test]
    fn samples_of_several_processes_are_in_one_order_however_they_came() {
        let of = [(0, 1, b"a"), (0, 2, b"b"), (0, 2, b"c"), (1, 1, b"d"), (1, 2, b"e")];
        // Those of one process come in their order.
        let ways = [[0, 1, 2, 3, 4], [3, 4, 0, 1, 2], [0, 3, 1, 4, 2], [3, 0, 1, 4, 2]];
        for way in ways {
            let mut order = Order::of(2);
            let mut told = Vec::new();
            for at in way {
                let (process, date, message) = of[at];
                order.has_come(process, date);
                order.hold(process, held(date, message));
                told.extend(all(&mut order));
            }
            order.end();
            told.extend(all(&mut order));
            let texts: Vec<u8> = told.iter().flat_map(|(_, text)| text.clone()).collect();
            assert_eq!(String::from_utf8_lossy(&texts), "adbce", "{way:?}");
        }
    }

    #[test]
    fn a_sample_waits_until_each_process_is_further_than_its_date() {
        let mut order = Order::of(2);
        order.hold(0, held(5, b"a"));
        order.has_come(0, 9);
        assert!(all(&mut order).is_empty());
        order.has_come(1, 5);
        assert!(all(&mut order).is_empty(), "another of this date may come");
        order.has_come(1, 6);
        assert_eq!(all(&mut order).len(), 1);
    }

    #[test]
    fn a_process_that_is_not_stepped_keeps_no_more_back_than_there_is_room_for() {
        let mut order = Order::of(2);
        let large = vec![0; MOST / 4];
        for date in 0..6 {
            order.hold(0, held(date, &large));
        }
        assert_eq!(all(&mut order).len(), 2);
        // One that has ended keeps nothing back.
        order.has_come(1, u64::MAX);
        order.has_come(0, 6);
        assert_eq!(all(&mut order).len(), 4);
    }
}
