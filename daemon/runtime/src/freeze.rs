//! Copies what an instance is, between two passes of all of its tasks.

use std::time::{Duration, Instant};

use genom_description::model::Owner;

use crate::api::ActivityPhase;
use crate::control::{Control, Entry, Phase, Stage};
use crate::engine::Engine;
use crate::frozen::{Frozen, FrozenActivity, FrozenToken, Waiting};
use crate::running::HeldUp;
use crate::task::run::{Mode, Run, Status};

/// Pause between two attempts: nobody is kept waiting by one that fails.
const LOOK: Duration = Duration::from_micros(500);

/// An instance could not be frozen.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FreezeError {
    /// There was no moment without a codel.
    #[error("{0}")]
    Busy(HeldUp),
    /// Its activities are being stopped.
    #[error("{instance} is stopping")]
    Stopping {
        /// The instance.
        instance: String,
    },
}

impl Engine {
    pub(crate) fn freeze(
        &self,
        patience: Duration,
        also: &mut dyn FnMut(),
    ) -> Result<Frozen, FreezeError> {
        let end = Instant::now() + patience;
        loop {
            let by = self.running_codels().into_iter().max_by_key(|codel| codel.for_ns);
            if let Some(frozen) = self.try_freeze(end, also) {
                return frozen.ok_or_else(|| FreezeError::Stopping { instance: self.name.clone() });
            }
            if Instant::now() >= end {
                let by = by.map(Box::new);
                return Err(FreezeError::Busy(HeldUp { instance: self.name.clone(), by }));
            }
            std::thread::park_timeout(LOOK);
        }
    }

    /// `None` while a codel runs; `Some(None)` when the instance stops.
    fn try_freeze(&self, end: Instant, also: &mut dyn FnMut()) -> Option<Option<Frozen>> {
        let shared = &self.shared;
        // On a virtual clock: no step is under way in this instance.
        let _still = match &self.driven {
            Some(driven) => Some(driven.try_lock().ok()?),
            None => None,
        };
        let _one = self.everything.try_lock().ok()?;
        // Of tasks that make a pass, one is waited for while no other is kept from its own: it may
        // hardly ever be between two passes by chance.
        let all: Vec<_> = self.gates.iter().map(|gate| gate.try_lock()).collect();
        let mut gates = match all.iter().position(Option::is_none) {
            None => all,
            Some(busy) => {
                drop(all);
                let task = self.shared.tasks.places().nth(busy)?;
                let mut waited = self.gates[task].lock_until(end);
                let others = self.gates.pairs();
                others
                    .map(
                        |(other, gate)| if other == task { waited.take() } else { gate.try_lock() },
                    )
                    .collect()
            }
        };
        let mut gates: Vec<_> = gates.drain(..).collect::<Option<_>>()?;
        let outside = shared.outside_context();
        let _permit = shared.exclusion.enter_all(outside, Some(Duration::ZERO))?;
        // Async codels of requests, which the exclusion does not wait for.
        if (self.gates.len()..outside).any(|context| shared.current(context).is_some()) {
            return None;
        }
        let control = self.lock();
        if control.phase != Phase::Running {
            return Some(None);
        }
        let mut activities = Vec::new();
        for inside in &mut gates {
            inside.admit_sent();
            activities.extend(inside.core.runs().filter_map(|run| self.frozen(&control, run)));
        }
        for entry in &control.entries {
            if let Stage::Pending(run) = &entry.stage {
                activities.extend(self.frozen(&control, run));
            }
        }
        for task in self.shared.tasks.places() {
            let owner = Owner::Task(task);
            if !activities.iter().any(|one| one.owner == owner) {
                activities.push(FrozenActivity::over(owner));
            }
        }
        also();
        let executed = control.services.pairs().filter(|(_, queue)| queue.ran);
        Some(Some(Frozen {
            ids: shared.body.ids(),
            executed: executed.map(|(service, _)| service).collect(),
            activities,
        }))
    }

    fn frozen(&self, control: &Control, run: &Run) -> Option<FrozenActivity> {
        let entry: &Entry = control.entries.iter().find(|entry| entry.id == run.id)?;
        let phase = match run.marker.status() {
            Status::Init => ActivityPhase::Init,
            Status::Run => ActivityPhase::Run,
            Status::Stop => ActivityPhase::Stop,
            Status::Ether | Status::Cancelled => return None,
        };
        if run.outcome.is_some() {
            return None;
        }
        let token = |token: &crate::task::run::Token| {
            let waits = match token.mode {
                Mode::Done => return None,
                Mode::Ready => Waiting::Ready,
                Mode::Paused => Waiting::Paused,
                Mode::Asleep => Waiting::Asleep,
            };
            Some(FrozenToken { state: token.state, waits })
        };
        let owner = self.shared.plan.machines().get(run.machine)?.owner;
        Some(FrozenActivity {
            id: run.id,
            owner,
            phase,
            pending: matches!(entry.stage, Stage::Pending(_)),
            stopped_by: entry.by.clone(),
            tokens: run.tokens.iter().filter_map(token).collect(),
            memory: match owner {
                Owner::Service(_) => run.frame.save(),
                Owner::Task(_) => None,
            },
        })
    }
}
