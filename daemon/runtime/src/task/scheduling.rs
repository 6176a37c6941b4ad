//! Scheduling of a task's thread by the system.

use std::num::NonZeroU64;
use std::sync::atomic::Ordering;

use genom_description::model::{Component, Ix as _, Task, TaskIx};

use crate::exclusion::set_fifo;
use crate::options::TaskOptions;
use crate::shared::Shared;

/// Scheduling requested by the `.gen` and the configuration.
pub(crate) struct Wanted {
    real_time: bool,
    priority: u32,
    cpus: Vec<usize>,
}

impl Wanted {
    pub(crate) fn new(task: &Task, options: TaskOptions) -> Self {
        Self {
            real_time: options.real_time.unwrap_or(task.real_time),
            // genom3.md 7.4: the lowest priority by default.
            priority: options.priority.or(task.priority).unwrap_or(255).min(255),
            cpus: options.cpus,
        }
    }

    /// Applies it to the calling thread. If the system refuses, that is logged and the thread runs
    /// without.
    pub(crate) fn apply(&self, instance: &str, task: TaskIx, shared: &Shared) {
        // Wake-ups must not be delayed to be combined with others.
        let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(1));
        let name = &shared.plan.component().tasks[task].name;
        if !self.cpus.is_empty() {
            let mut set = rustix::thread::CpuSet::new();
            let possible = self.cpus.iter().filter(|cpu| **cpu < rustix::thread::CpuSet::MAX_CPU);
            possible.for_each(|cpu| set.set(*cpu));
            if let Err(error) = rustix::thread::sched_setaffinity(None, &set) {
                tracing::warn!(instance, task = name, "cannot run on {:?}: {error}", self.cpus);
            }
        }
        let mut fifo = 0;
        if self.real_time {
            fifo = fifo_of(self.priority);
            if !set_fifo(thread_priority::thread_native_id(), fifo) {
                fifo = 0;
                tracing::warn!(
                    instance,
                    task = name,
                    "no real-time scheduling: not permitted (see RLIMIT_RTPRIO, CAP_SYS_NICE); \
                     the task runs as any thread"
                );
            }
        }
        shared.tasks[task].real_time.store(fifo > 0, Ordering::Relaxed);
        shared.exclusion.inheritance().announce(task.index(), fifo);
    }
}

/// Logs what is requested for tasks and cannot be applied because they share a thread with those of
/// other instances, which has this stack.
pub(crate) fn tell_not_applied(
    instance: &str,
    model: &Component,
    options: &[TaskOptions],
    stack: u64,
) {
    let of_task = |(task, options): (&Task, &TaskOptions)| {
        let real_time = options.real_time.unwrap_or(task.real_time);
        let priority = options.priority.or(task.priority).is_some();
        let wanted = [
            (real_time, "real-time scheduling"),
            (priority, "priority"),
            (!options.cpus.is_empty(), "cpus"),
            (task.stack.is_some_and(|wanted| wanted > stack), "stack"),
        ];
        let wanted: Vec<&str> =
            wanted.into_iter().filter(|(is, _)| *is).map(|(_, what)| what).collect();
        (!wanted.is_empty()).then(|| format!("{} of task {}", wanted.join(", "), task.name))
    };
    let all: Vec<String> = model.tasks.iter().zip(options).filter_map(of_task).collect();
    if !all.is_empty() {
        tracing::warn!(
            instance,
            "not applied: {}; with execution = \"single\" all tasks share one thread, in the order \
             of deadlines",
            all.join("; ")
        );
    }
}

/// `SCHED_FIFO` priority of a GenoM priority, from 0, the highest, to 255, the lowest. Threads of
/// the system stay above.
fn fifo_of(priority: u32) -> i32 {
    const HIGHEST: i32 = 90;
    let rank = i32::try_from(priority.min(255)).unwrap_or(255);
    HIGHEST - rank * (HIGHEST - 1) / 255
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn priority_0_is_the_highest_and_255_the_lowest() {
        assert_eq!((fifo_of(0), fifo_of(255), fifo_of(9999)), (90, 1, 1));
        assert!(fifo_of(10) > fifo_of(20));
    }
}
