//! What would have to change so that tasks of a machine are in time.

use super::known::Cause;
use super::machine::{Job, Machine};
use genom_timing::below;

/// Codels that are looked at; with more of them, none is.
const MOST: usize = 200;

/// A change that is enough for all tasks of the machine to be in time, or for the one that it names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// Priorities in the order of periods, the shortest first: tasks, the highest priority first.
    Order(Vec<String>),
    /// A task on another processor.
    Processor {
        /// The task.
        task: String,
        /// The processor.
        cpu: usize,
    },
    /// A codel that takes less.
    Time {
        /// The component and the codel.
        codel: String,
        /// Time below which it has to stay, in nanoseconds.
        below: u64,
        /// The task that is in time then; others may still be late.
        task: String,
    },
}

impl Machine<'_> {
    /// The changes of which each by itself is enough; none if all tasks are in time.
    #[must_use]
    pub fn changes(&self) -> Vec<Change> {
        let jobs = self.jobs();
        let late: Vec<String> = self
            .bounded(&jobs)
            .into_iter()
            .filter(|one| matches!(one.task.response, Err(Cause::Late(_))))
            .map(|one| format!("{}/{}", one.component, one.task.name))
            .collect();
        if late.is_empty() {
            return Vec::new();
        }
        let mut changes: Vec<Change> = self.order(&jobs).into_iter().collect();
        for job in (0..jobs.len()).filter(|job| jobs[*job].period.is_some()) {
            changes.extend(self.elsewhere(&jobs, job));
        }
        for task in &late {
            self.shorter(&jobs, task, &mut changes);
        }
        changes
    }

    fn fits(&self, jobs: &[Job]) -> bool {
        let real_time = |at: usize| jobs.iter().filter(|job| job.period.is_some()).nth(at);
        let all = self.bounded(jobs);
        all.iter().enumerate().all(|(at, one)| {
            // What is no real-time thread has no bound wherever it runs.
            one.task.response.is_ok() || real_time(at).is_some_and(|job| !job.real_time)
        })
    }

    /// The order of periods, which is the best one if tasks wait for nothing (Liu, Layland 1973).
    fn order(&self, jobs: &[Job]) -> Option<Change> {
        let mut order: Vec<usize> = (0..jobs.len()).collect();
        order.retain(|job| jobs[*job].real_time && jobs[*job].period.is_some());
        order.sort_by_key(|job| jobs[*job].period);
        let mut changed = jobs.to_vec();
        for (job, priority) in order.iter().zip(0..) {
            changed[*job].priority = priority;
        }
        let named = || order.iter().map(|job| self.name(&jobs[*job])).collect();
        self.fits(&changed).then(|| Change::Order(named()))
    }

    /// Another processor for a task.
    fn elsewhere(&self, jobs: &[Job], job: usize) -> Option<Change> {
        let other = (0..self.processors).filter(|cpu| jobs[job].cpus != [*cpu]);
        let mut fitting = other.filter(|cpu| {
            let mut changed = jobs.to_vec();
            changed[job].cpus = vec![*cpu];
            self.fits(&changed)
        });
        fitting.next().map(|cpu| Change::Processor { task: self.name(&jobs[job]), cpu })
    }

    /// Codels of which a shorter time would do for a task.
    fn shorter(&self, jobs: &[Job], task: &str, changes: &mut Vec<Change>) {
        let count = |at: usize| self.components[at].times.codels.len();
        if (0..self.components.len()).map(count).sum::<usize>() > MOST {
            return;
        }
        let mut other = self.clone();
        for at in 0..self.components.len() {
            for codel in 0..count(at) {
                let duration = self.components[at].times.codels[codel];
                let Some(most) = duration.most else { continue };
                let holds = |time: u64| {
                    other.components[at].times.codels[codel].most = Some(time);
                    let all = other.bounded(jobs);
                    let is = |one: &&super::OnMachine| {
                        format!("{}/{}", one.component, one.task.name) == task
                    };
                    all.iter().find(is).is_some_and(|one| one.task.response.is_ok())
                };
                if let Some(below) = below(duration.least, most, holds) {
                    let placed = &self.components[at];
                    let node = u16::try_from(codel).unwrap_or(u16::MAX);
                    changes.push(Change::Time {
                        codel: format!("{}/{}", placed.name, placed.system.node_name(node)),
                        below,
                        task: task.to_owned(),
                    });
                }
                other.components[at].times.codels[codel].most = Some(most);
            }
        }
    }
}
