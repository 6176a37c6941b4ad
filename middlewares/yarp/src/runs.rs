//! Activities that callers follow: what was reported and not yet asked for.

use std::collections::{HashMap, VecDeque};

/// Greatest number of reports of one activity that are kept, and of activities.
const MOST_REPORTS: usize = 256;
const MOST_RUNS: usize = 1024;

/// An activity: the service, and its number.
pub(crate) type Key = (String, u64);

/// The activities of a component.
#[derive(Debug, Default)]
pub(crate) struct Runs {
    all: HashMap<Key, Run>,
    /// Keys in order of their beginning.
    order: VecDeque<Key>,
}

#[derive(Debug, Default)]
struct Run {
    /// Bottles, and whether it is the last one.
    reports: VecDeque<(Vec<u8>, bool)>,
    /// The connection that waits for the next report.
    waiting: Option<u64>,
    ended: bool,
}

/// What `wait` leads to.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Waiting {
    /// This is the report.
    Report(Vec<u8>),
    /// It will come. The connection that waited before waits no more.
    Later(Option<u64>),
    /// There is no such activity.
    Unknown,
}

impl Runs {
    /// Begins an activity. Returns false if too many are running.
    pub(crate) fn begin(&mut self, key: Key) -> bool {
        if self.all.len() >= MOST_RUNS {
            // One that has ended and that nobody asks for any more.
            let ended = |key: &Key| self.all.get(key).is_none_or(|run| run.ended);
            let Some(index) = self.order.iter().position(ended) else { return false };
            if let Some(key) = self.order.remove(index) {
                self.all.remove(&key);
            }
        }
        self.order.retain(|other| *other != key);
        self.order.push_back(key.clone());
        self.all.insert(key, Run::default());
        true
    }

    /// Adds a report. Returns the connection that waits for it, which gets it.
    pub(crate) fn report(
        &mut self,
        key: &Key,
        report: Vec<u8>,
        last: bool,
    ) -> Option<(u64, Vec<u8>)> {
        let run = self.all.get_mut(key)?;
        if let Some(token) = run.waiting.take() {
            if last {
                self.forget(key);
            }
            return Some((token, report));
        }
        run.ended |= last;
        if run.reports.len() >= MOST_REPORTS {
            run.reports.pop_front();
        }
        run.reports.push_back((report, last));
        None
    }

    /// A connection asks for the next report.
    pub(crate) fn wait(&mut self, key: &Key, token: u64) -> Waiting {
        let Some(run) = self.all.get_mut(key) else { return Waiting::Unknown };
        match run.reports.pop_front() {
            Some((report, last)) => {
                if last {
                    self.forget(key);
                }
                Waiting::Report(report)
            }
            None => Waiting::Later(run.waiting.replace(token)),
        }
    }

    fn forget(&mut self, key: &Key) {
        self.all.remove(key);
        self.order.retain(|other| other != key);
    }

    /// Ends all activities of a service. Returns the connections that wait.
    pub(crate) fn withdraw(&mut self, service: &str) -> Vec<u64> {
        let of_service = |key: &&Key| key.0 == service;
        let keys: Vec<Key> = self.all.keys().filter(of_service).cloned().collect();
        let mut waiting = Vec::new();
        for key in keys {
            waiting.extend(self.all.get(&key).and_then(|run| run.waiting));
            self.forget(&key);
        }
        waiting
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(number: u64) -> Key {
        ("goto".to_owned(), number)
    }

    #[test]
    fn reports_wait_for_those_who_ask_and_those_who_ask_for_reports() {
        let mut runs = Runs::default();
        assert_eq!(runs.wait(&key(1), 7), Waiting::Unknown);
        assert!(runs.begin(key(1)));
        assert_eq!(runs.report(&key(1), vec![1], false), None);
        assert_eq!(runs.wait(&key(1), 7), Waiting::Report(vec![1]));
        assert_eq!(runs.wait(&key(1), 7), Waiting::Later(None));
        assert_eq!(runs.wait(&key(1), 8), Waiting::Later(Some(7)));
        assert_eq!(runs.report(&key(1), vec![2], true), Some((8, vec![2])));
        assert_eq!(runs.wait(&key(1), 7), Waiting::Unknown, "its end was told");
        assert!(runs.begin(key(2)));
        assert_eq!(runs.wait(&key(2), 9), Waiting::Later(None));
        assert_eq!(runs.withdraw("goto"), [9]);
        assert!(runs.all.is_empty() && runs.order.is_empty());
    }

    #[test]
    fn what_nobody_asks_for_is_bounded() {
        let mut runs = Runs::default();
        for number in 0..3 * MOST_RUNS as u64 {
            assert!(runs.begin(key(number)));
            for _ in 0..3 {
                runs.report(&key(number), vec![0], false);
            }
            runs.report(&key(number), vec![0], true);
        }
        assert_eq!((runs.all.len(), runs.order.len()), (MOST_RUNS, MOST_RUNS));
        let last = key(3 * MOST_RUNS as u64 - 1);
        (0..2 * MOST_REPORTS).for_each(|_| drop(runs.report(&last, vec![0], false)));
        assert_eq!(runs.all[&last].reports.len(), MOST_REPORTS);
        let mut running = Runs::default();
        assert!((0..MOST_RUNS as u64).all(|number| running.begin(key(number))));
        assert!(!running.begin(key(u64::MAX)), "none of them has ended");
    }
}
