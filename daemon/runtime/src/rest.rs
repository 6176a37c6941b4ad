//! Moments at which a component rests: no codel runs, async ones included, and each activity is at a
//! pause. What codels are made of can be exchanged then.

use std::time::{Duration, Instant};

use genom_description::model::TaskIx;

use crate::body::Body;
use crate::control::Phase;
use crate::engine::Engine;
use crate::running::HeldUp;
use crate::still::{LOOK, Still};
use crate::task::run::{Mode, Run};

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
        let mut work = Some(work);
        let rest = || Rest(self.shared.body.as_ref());
        self.still_at_rest(limit, |_, _| work.take().map(|work| work(rest())))
    }

    /// The same, with what is kept still. `work` is called again, at another moment, if it returns
    /// `None`; it hears whether more than half of the time is left for that.
    pub(crate) fn still_at_rest<R>(
        &self,
        limit: Duration,
        mut work: impl FnMut(&mut Still<'_>, bool) -> Option<R>,
    ) -> Result<R, NoRest> {
        let instance = || self.name.clone();
        let begin = Instant::now();
        let end = begin + limit;
        let mut restless = None;
        loop {
            if matches!(self.lock().phase, Phase::Stopping | Phase::Stopped) {
                return Err(NoRest::Stops { instance: instance() });
            }
            match self.try_rest() {
                Ok(mut still) => {
                    if let Some(done) = work(&mut still, begin.elapsed() < limit / 2) {
                        return Ok(done);
                    }
                }
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
        let still = self.try_still().ok_or(None)?;
        let ready = |run: &Run| run.tokens.iter().any(|token| token.mode == Mode::Ready);
        let mut tasks = self.shared.tasks.places().zip(&still.tasks);
        match tasks.find(|(_, inside)| inside.core.runs().any(ready)) {
            Some((task, _)) => Err(Some(task)),
            None => Ok(still),
        }
    }
}
