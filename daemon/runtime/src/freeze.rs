//! Copies what an instance is, between two passes of all of its tasks.

use std::time::{Duration, Instant};

use genom_description::model::Owner;

use crate::api::ActivityPhase;
use crate::control::{Control, Entry, Phase, Stage};
use crate::engine::Engine;
use crate::frozen::{Frozen, FrozenActivity, FrozenToken, Waiting};
use crate::running::HeldUp;
use crate::still::{LOOK, Still};
use crate::task::run::{Mode, Run, Status};

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
            if let Some(still) = self.try_still() {
                return self.frozen_now(&still, also);
            }
            if Instant::now() >= end {
                let by = by.map(Box::new);
                return Err(FreezeError::Busy(HeldUp { instance: self.name.clone(), by }));
            }
            std::thread::park_timeout(LOOK);
        }
    }

    pub(crate) fn frozen_now(
        &self,
        still: &Still<'_>,
        also: &mut dyn FnMut(),
    ) -> Result<Frozen, FreezeError> {
        let control = self.lock();
        if control.phase != Phase::Running {
            return Err(FreezeError::Stopping { instance: self.name.clone() });
        }
        let mut activities = Vec::new();
        for inside in &still.tasks {
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
        Ok(Frozen {
            ids: self.shared.body.ids(),
            executed: executed.map(|(service, _)| service).collect(),
            activities,
        })
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
