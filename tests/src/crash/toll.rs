//! Daemons ended at many points of a phase, and the combined result.

use std::collections::BTreeSet;
use std::time::Duration;

use super::course::Phase;
use super::outcome::Outcome;
use super::stage::{Plan, Stage};
use super::watched::Step;

/// The calls of a phase before which a daemon is ended. After the last call is a point, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    /// Every n-th call.
    Every(usize),
    /// This many calls, evenly distributed, and one at which a file exists but is incomplete.
    Few(usize),
}

impl Points {
    fn of(self, calls: &[Step]) -> BTreeSet<usize> {
        match self {
            Self::Every(step) => (0..=calls.len()).step_by(step).collect(),
            Self::Few(number) => {
                let unfinished = calls.iter().position(|step| step.call == "fchmod");
                let spread = (1..=number).map(|point| point * calls.len() / number);
                unfinished.into_iter().chain(spread).collect()
            }
        }
    }
}

/// The results of all points of a phase.
#[derive(Debug)]
pub struct Toll {
    /// What the daemons were doing.
    pub phase: Phase,
    /// Number of calls in the phase.
    pub calls: usize,
    /// One result per point. A peer reads the daemon's port at every second point.
    pub outcomes: Vec<Outcome>,
    /// Number of periods that tasks of the peers missed meanwhile.
    pub missed: u64,
}

impl Toll {
    /// Ends a daemon at each of these points of a phase; calls `told` with each result.
    pub fn of(
        stage: &mut Stage,
        phase: Phase,
        points: Points,
        told: &mut dyn FnMut(&Outcome),
    ) -> Self {
        let calls = stage.calls(phase);
        let before = stage.missed();
        let mut outcomes = Vec::new();
        for (rank, call) in points.of(&calls).into_iter().enumerate() {
            let outcome = stage.run(Plan { phase, call, followed: rank % 2 == 1 });
            told(&outcome);
            outcomes.push(outcome);
        }
        Self { phase, calls: calls.len(), outcomes, missed: stage.missed() - before }
    }

    /// Time until successors were ready: the median and the maximum.
    #[must_use]
    pub fn ready(&self) -> [Duration; 2] {
        let mut all: Vec<Duration> = self.outcomes.iter().filter_map(|one| one.ready).collect();
        all.sort_unstable();
        let half = all.get(all.len().saturating_sub(1) / 2);
        [half, all.last()].map(|one| one.copied().unwrap_or_default())
    }
}
