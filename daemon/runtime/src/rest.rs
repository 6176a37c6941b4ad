//! Moments at which a component rests: no codel runs, async ones included, and each activity is at a
//! pause. What codels are made of can be exchanged then.

use std::time::{Duration, Instant};

use genom_description::model::TaskIx;

use crate::body::Body;
use crate::control::Phase;
use crate::engine::Engine;
use crate::exclusion::Permit;
use crate::lock::Guard;
use crate::running::HeldUp;
use crate::task::driven::DrivenTask;
use crate::task::gate::Held;
use crate::task::run::{Mode, Run};

/// Pause between two attempts.
const LOOK: Duration = Duration::from_micros(500);

/// There was no moment of rest in time. Nothing was done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoRest {
    /// A codel did not return.
    #[error(transparent)]
    HeldUp(#[from] HeldUp),
    /// The codels of a task return, and yield states without pause over and over.
    #[error("{instance} does not rest: task {task} yields states without pause all the time")]
    NoPause {
        /// The instance.
        instance: String,
        /// The task.
        task: String,
    },
    /// It is being shut down.
    #[error("{instance} is being stopped")]
    Stops {
        /// The instance.
        instance: String,
    },
}

/// Proof that a component rests, for as long as it is borrowed.
#[derive(Clone, Copy)]
pub struct Rest<'a>(&'a dyn Body);

impl<'a> Rest<'a> {
    /// Its code and memory.
    #[must_use]
    pub fn body(self) -> &'a dyn Body {
        self.0
    }

    /// Whether it is this one that rests.
    #[must_use]
    pub fn is_of(self, body: &dyn Body) -> bool {
        std::ptr::addr_eq(self.0, body)
    }
}

impl std::fmt::Debug for Rest<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Rest")
    }
}

impl Engine {
    /// Runs `work` at a moment of rest; gives up after `limit`. Tasks never wait for an attempt that
    /// fails.
    pub(crate) fn at_rest<R>(
        &self,
        limit: Duration,
        work: impl FnOnce(Rest<'_>) -> R,
    ) -> Result<R, NoRest> {
        let instance = || self.name.clone();
        let end = Instant::now() + limit;
        let mut restless = None;
        loop {
            if matches!(self.lock().phase, Phase::Stopping | Phase::Stopped) {
                return Err(NoRest::Stops { instance: instance() });
            }
            match self.try_rest() {
                Ok(_still) => return Ok(work(Rest(self.shared.body.as_ref()))),
                Err(task) => restless = restless.max(task),
            }
            let late = Instant::now() >= end;
            let by = self.longest(|codel| codel.stuck || late).map(Box::new);
            match restless {
                _ if by.as_ref().is_some_and(|codel| codel.stuck) => {}
                Some(task) if late => {
                    let task = self.shared.plan.component().tasks[task].name.clone();
                    return Err(NoRest::NoPause { instance: instance(), task });
                }
                _ => {}
            }
            if late || by.is_some() {
                return Err(HeldUp { instance: instance(), by }.into());
            }
            std::thread::park_timeout(LOOK);
        }
    }

    /// Keeps all codels from running, if none does and all activities are at a pause; otherwise
    /// names a task with one that is not, if that is the reason.
    fn try_rest(&self) -> Result<Still<'_>, Option<TaskIx>> {
        let driven = match &self.driven {
            Some(driven) => Some(driven.try_lock().map_err(|_| None)?),
            None => None,
        };
        let one = self.everything.try_lock().map_err(|_| None)?;
        let mut gates = Vec::with_capacity(self.gates.len());
        for (task, gate) in self.gates.pairs() {
            let mut inside = gate.try_lock().ok_or(None)?;
            inside.admit_sent();
            let ready = |run: &Run| run.tokens.iter().any(|token| token.mode == Mode::Ready);
            if inside.core.runs().any(ready) {
                return Err(Some(task));
            }
            gates.push(inside);
        }
        let outside = self.shared.outside_context();
        let permit = self.shared.exclusion.stand_still(outside, Some(Duration::ZERO));
        Ok(Still { _permit: permit.ok_or(None)?, _gates: gates, _one: one, _driven: driven })
    }
}

/// Keeps codels from running until it is dropped.
struct Still<'a> {
    _permit: Permit<'a>,
    _gates: Vec<Held<'a>>,
    _one: Guard<'a, ()>,
    _driven: Option<Guard<'a, Vec<DrivenTask>>>,
}
