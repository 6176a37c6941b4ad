//! Finds tasks that occupy a processor and never pause, from the scheduler's statistics of their
//! threads.
//!
//! A codel that waits for data in each of its calls does not pause either. Drivers may be written
//! that way; such a task does not occupy a processor.

use std::collections::HashMap;
use std::time::Instant;

use genom_description::model::TaskIx;
use genom_runtime::{Unpaused, seconds};

/// Seconds between two readings of a thread's times.
const SPAN: f64 = 1.0;
/// A thread spins if it ran, or was ready to run, for at least this share of the time.
const KEEPS: f64 = 0.8;

/// A task that occupies a processor and never pauses.
#[derive(Clone, Debug, PartialEq)]
pub struct Spin {
    /// Its present cycle.
    pub unpaused: Unpaused,
    /// Share of a processor that it used recently, from 0 to 1.
    pub processor: f64,
}

impl std::fmt::Display for Spin {
    /// `codel NAME of OWNER yields without pause for 12 s (97 % of a processor)`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Unpaused { codel, owner, for_ns, .. } = &self.unpaused;
        let (time, percent) = (seconds(*for_ns), self.processor * 100.0);
        write!(
            f,
            "codel {codel} of {owner} yields without pause for {time} ({percent:.0} % of a processor)"
        )
    }
}

/// Times of a thread since its start, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Times {
    /// Time it ran.
    ran: f64,
    /// Time it was ready to run and waited for a processor.
    waited: f64,
}

/// The last reading for a cycle of a task, and the result of the comparison with the one before.
#[derive(Debug)]
struct Reading {
    at: Instant,
    times: Times,
    /// The share of a processor that it used, if it spins.
    keeps: Option<f64>,
}

/// The tasks of one component that never pause, by cycle.
#[derive(Debug, Default)]
pub(super) struct Spins {
    readings: HashMap<(TaskIx, u64), Reading>,
    /// The tasks found spinning at the last check.
    pub(super) found: Vec<Spin>,
}

impl Spins {
    pub(super) fn look(
        &mut self,
        now: Instant,
        unpaused: Vec<Unpaused>,
        times: impl Fn(u32) -> Option<Times>,
    ) {
        self.readings.retain(|cycle, _| unpaused.iter().any(|one| one.cycle == *cycle));
        self.found.clear();
        for one in unpaused {
            let Some(times) = one.thread.and_then(&times) else { continue };
            let first = || Reading { at: now, times, keeps: None };
            let last = self.readings.entry(one.cycle).or_insert_with(first);
            let span = now.saturating_duration_since(last.at).as_secs_f64();
            if span >= SPAN {
                let ran = (times.ran - last.times.ran) / span;
                let wanted = ran + (times.waited - last.times.waited) / span;
                *last =
                    Reading { at: now, times, keeps: (wanted >= KEEPS).then_some(ran.min(1.0)) };
            }
            if let Some(processor) = last.keeps {
                self.found.push(Spin { unpaused: one, processor });
            }
        }
    }
}

/// Times of a thread of this process.
pub(super) fn times_of(thread: u32) -> Option<Times> {
    parse(&std::fs::read_to_string(format!("/proc/self/task/{thread}/schedstat")).ok()?)
}

/// Parses `RAN WAITED SLICES` of `/proc/.../schedstat`, in nanoseconds.
#[allow(clippy::cast_precision_loss, reason = "shares are wanted")]
fn parse(text: &str) -> Option<Times> {
    let mut numbers = text.split_whitespace().map(|word| word.parse::<u64>().ok());
    let mut next = || Some(numbers.next()?? as f64 / 1e9);
    Some(Times { ran: next()?, waited: next()? })
}

#[cfg(test)]
mod tests {
    use genom_description::model::Ix as _;

    use super::*;
    use std::time::Duration;

    fn unpaused(began: u64) -> Unpaused {
        Unpaused {
            task: "main".into(),
            periodic: true,
            codel: "step".into(),
            owner: "go".into(),
            for_ns: 12_000_000_000,
            steps: 99,
            thread: Some(7),
            cycle: (TaskIx::new(0), began),
        }
    }

    /// What is found for a thread that accumulated these times within one second.
    fn after_a_second(ran: f64, waited: f64) -> Vec<Spin> {
        let (mut spins, begin) = (Spins::default(), Instant::now());
        spins.look(begin, vec![unpaused(1)], |_| Some(Times::default()));
        assert!(spins.found.is_empty());
        let later = begin + Duration::from_secs(1);
        spins.look(later, vec![unpaused(1)], |_| Some(Times { ran, waited }));
        spins.found
    }

    #[test]
    fn a_thread_that_keeps_a_processor_spins_and_one_that_waits_for_data_does_not() {
        let found = after_a_second(0.97, 0.0);
        assert_eq!(found.len(), 1);
        assert_eq!(
            found[0].to_string(),
            "codel step of go yields without pause for 12 s (97 % of a processor)"
        );
        assert!(after_a_second(0.4, 0.0).is_empty());
        // Other threads used the processor; it would have run all the time.
        assert_eq!(after_a_second(0.2, 0.75).len(), 1);
    }

    #[test]
    fn what_was_found_holds_until_the_cycle_ends() {
        let (mut spins, begin) = (Spins::default(), Instant::now());
        let at = |seconds: f64| begin + Duration::from_secs_f64(seconds);
        let ran = |ran: f64| move |_| Some(Times { ran, waited: 0.0 });
        spins.look(at(0.0), vec![unpaused(1)], ran(0.0));
        spins.look(at(1.0), vec![unpaused(1)], ran(1.0));
        spins.look(at(1.25), vec![unpaused(1)], ran(1.25));
        assert_eq!(spins.found.len(), 1);
        // Another cycle of the task is measured anew.
        spins.look(at(1.5), vec![unpaused(2)], ran(1.5));
        assert!(spins.found.is_empty() && spins.readings.len() == 1);
        spins.look(at(1.75), vec![], ran(1.75));
        assert!(spins.found.is_empty() && spins.readings.is_empty());
        // A thread whose times cannot be read does not count as spinning.
        spins.look(at(2.0), vec![unpaused(3)], |_| None);
        spins.look(at(3.0), vec![unpaused(3)], |_| None);
        assert!(spins.found.is_empty());
    }

    #[test]
    fn the_times_of_a_thread_are_read_as_the_system_tells_them() {
        assert_eq!(parse("2500000000 500000000 12\n"), Some(Times { ran: 2.5, waited: 0.5 }));
        assert_eq!(parse(""), None);
        assert!(times_of(std::process::id()).is_some());
    }
}
