//! What tasks that share processors cost each other.

/// A task as the recurrences see it, in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub struct Load {
    /// Its period.
    pub period: u64,
    /// Its dearest cycle, with what it waits for.
    pub work: u64,
    /// How late its cycles begin.
    pub late: u64,
    /// Its longest response, for tasks of higher priority.
    pub response: u64,
}

/// Longest time from a tick to the end of its cycle on one processor: Joseph and Pandya, Finding
/// Response Times in a Real-Time System, 1986. `None` if the next tick comes before.
#[must_use]
pub fn alone(own: Load, higher: &[Load]) -> Option<u64> {
    let mut time = own.work;
    loop {
        let interference = |one: &Load| {
            let cycles = time.saturating_add(one.late).div_ceil(one.period).max(1);
            cycles.saturating_mul(one.work)
        };
        let next = higher.iter().map(interference).fold(own.work, u64::saturating_add);
        if next.saturating_add(own.late) >= own.period {
            return None;
        }
        if next == time {
            return Some(time + own.late);
        }
        time = next;
    }
}

/// The same on several processors, with a queue for all: Bertogna and Cirinei, Response-Time
/// Analysis for Globally Scheduled Symmetric Multiprocessor Platforms, 2007.
#[must_use]
pub fn together(own: Load, higher: &[Load], processors: u64) -> Option<u64> {
    let mut time = own.work;
    loop {
        let interference = |one: &Load| {
            let response = one.response.saturating_add(one.late);
            // A cycle that began before may end in this time.
            let span = time.saturating_add(response).saturating_sub(one.work);
            let whole = span / one.period;
            let part = one.work.min(span - whole * one.period);
            let load = whole.saturating_mul(one.work).saturating_add(part);
            load.min(time.saturating_sub(own.work).saturating_add(1))
        };
        let sum = higher.iter().map(interference).fold(0, u64::saturating_add);
        let next = own.work.saturating_add(sum / processors.max(1));
        if next.saturating_add(own.late) >= own.period {
            return None;
        }
        if next <= time {
            return Some(time + own.late);
        }
        time = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(period: u64, work: u64) -> Load {
        Load { period, work, late: 0, response: 0 }
    }

    /// The response of the last task on one processor if all tick at once, unit by unit.
    fn played(tasks: &[Load]) -> Option<u64> {
        let mut left: Vec<u64> = tasks.iter().map(|task| task.work).collect();
        let last = tasks.len() - 1;
        for now in 0..tasks[last].period - 1 {
            for (task, left) in tasks.iter().zip(&mut left) {
                if now > 0 && now.is_multiple_of(task.period) {
                    *left += task.work;
                }
            }
            let first = left.iter_mut().find(|left| **left > 0)?;
            *first -= 1;
            if left[last] == 0 {
                return Some(now + 1);
            }
        }
        None
    }

    #[test]
    fn on_one_processor_the_bound_is_what_happens_when_all_tick_at_once() {
        let mut seed = 7u64;
        let mut random = |below: u64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 33) % below
        };
        let (mut fit, mut late) = (0, 0);
        for _ in 0..2000 {
            let mut tasks: Vec<Load> = (0..2 + random(4))
                .map(|_| {
                    let period = 5 + random(60);
                    load(period, 1 + random(period / 3))
                })
                .collect();
            // The longest period last: it sees most of the others.
            tasks.sort_by_key(|task| task.period);
            let (own, higher) = tasks.split_last().unwrap();
            let found = alone(*own, higher);
            // A task that is preempted for ever has overruns of its own; those are told apart.
            let sound = (0..higher.len()).all(|at| alone(higher[at], &higher[..at]).is_some());
            if sound {
                assert_eq!(found, played(&tasks), "{tasks:?}");
                if found.is_some() { fit += 1 } else { late += 1 }
            }
        }
        assert!(fit > 100 && late > 100, "{fit} {late}");
    }

    #[test]
    fn a_cycle_that_ends_at_its_next_tick_is_too_late() {
        assert_eq!(alone(load(10, 9), &[]), Some(9));
        assert_eq!(alone(load(10, 10), &[]), None);
        assert_eq!(alone(Load { late: 1, ..load(10, 9) }, &[]), None);
    }

    #[test]
    fn a_task_is_preempted_only_while_all_processors_are_taken() {
        let mut higher = load(10, 4);
        higher.response = 4;
        assert_eq!(together(load(20, 9), &[higher], 2), Some(9));
        assert_eq!(together(load(20, 9), &[higher, higher], 2), Some(17));
        // On one processor it is never better than the exact bound.
        assert!(together(load(30, 9), &[higher], 1) >= alone(load(30, 9), &[higher]));
    }
}
