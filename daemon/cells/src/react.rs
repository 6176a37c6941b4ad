//! What is done when components fail (`on_failure`), as soon as the end of their cell is seen, and
//! before it is started again; and when they break a rule (`supervision`).

use std::collections::HashSet;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use genom_configuration::{Act, CallEntry, Deed, Reaction};
use genom_protocol::{CallReply, Change, Inputs, NoReaction, routes};
use genom_supervisor::Supervisor;
use genom_supervisor::components::request::{self, RequestError};
use genom_supervisor::reactor::{Asked, Reactor};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender};
use tokio::task::JoinError;

use crate::cell::Down;
use crate::cells::Cells;
use crate::client::AskError;
use crate::own::OwnCell;
use crate::setup::{Cause, Failure};

/// Why something could not be done of another component.
#[derive(Debug, thiserror::Error)]
enum ReactError {
    #[error(transparent)]
    Reaction(#[from] NoReaction),
    #[error(transparent)]
    Request(#[from] RequestError),
    #[error(transparent)]
    Down(#[from] Down),
    #[error(transparent)]
    Ask(#[from] AskError),
    #[error("it ended with {0}")]
    Exception(String),
    #[error(transparent)]
    Own(#[from] JoinError),
}

/// Passes on what broken rules of this process ask for.
pub struct Rules {
    /// To [`react`].
    pub failures: UnboundedSender<Failure>,
    /// In a cell: its components, the only ones that it does something of, and what ends it. For
    /// others its daemon does it, which hears of the violation.
    pub own: Option<(Weak<Supervisor>, Arc<OwnCell>)>,
}

impl Reactor for Rules {
    fn react(&self, asked: Asked) {
        let Asked { component, mut reactions, seen } = asked;
        if let Some((supervisor, _)) = &self.own {
            let Some(supervisor) = supervisor.upgrade() else { return };
            let here = |reaction: &Reaction| {
                let deed = reaction.deed();
                deed.is_ok_and(|deed| supervisor.components.get(&deed.component).is_some())
            };
            reactions.retain(here);
        }
        let cause = Cause::BrokenRule;
        let failure = Failure { component, reactions, seen, cause, under_way: None };
        // Nobody listens any more when the daemon ends.
        let _ = self.failures.send(failure);
    }

    fn restart(&self, violation: &Change, why: &str, thread: Option<u32>) {
        match &self.own {
            Some((_, own)) => own.end(violation, why, thread),
            None => tracing::error!("supervision: the daemon's own process is not restarted"),
        }
    }
}

/// Does what is to be done for each failure, until nobody tells of any. What is to be done for one
/// failure is done side by side: a service that waits delays no other.
pub async fn react(
    cells: Weak<Cells>,
    supervisor: Arc<Supervisor>,
    mut failures: UnboundedReceiver<Failure>,
) {
    let under_way = UnderWay::default();
    while let Some(failure) = failures.recv().await {
        for reaction in failure.reactions {
            let Some(cells) = cells.upgrade() else { return };
            let (supervisor, component) = (Arc::clone(&supervisor), failure.component.clone());
            // A rule that is broken again and again does not pile up calls of a slow service.
            let call = (component.clone(), reaction.to_string());
            if failure.cause == Cause::BrokenRule && !under_way.begin(&call) {
                tracing::debug!("{}: {} is still under way", call.0, call.1);
                continue;
            }
            let (under_way, doing) = (under_way.clone(), failure.under_way.clone());
            tokio::spawn(async move {
                let done = perform(&cells, &supervisor, &reaction).await;
                drop(doing);
                if failure.cause == Cause::BrokenRule {
                    under_way.end(&call);
                }
                let seconds = failure.seen.elapsed().as_secs_f64();
                let key = failure.cause.key();
                match &done {
                    Ok(()) => tracing::warn!(
                        instance = component,
                        "{key}: {reaction}, {:.1} ms after {}",
                        seconds * 1e3,
                        if failure.cause == Cause::Ended { "the end" } else { "it was seen" }
                    ),
                    Err(error) => tracing::error!(
                        instance = component,
                        "{key}: {reaction} was not done: {error}; see that the robot is safe, \
                         then change [component.{key}] of {component} or load what it names"
                    ),
                }
                let error = done.err().map(|error| error.to_string());
                let reaction = reaction.to_string();
                let told = Change::FailureReaction { component, reaction, seconds, error };
                supervisor.bus.tell(&told);
            });
        }
    }
}

/// What is being done for rules that were broken: components and reactions.
#[derive(Clone, Default)]
struct UnderWay(Arc<Mutex<HashSet<(String, String)>>>);

impl UnderWay {
    fn with<T>(&self, work: impl FnOnce(&mut HashSet<(String, String)>) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Whether it was not under way.
    fn begin(&self, call: &(String, String)) -> bool {
        self.with(|all| all.insert(call.clone()))
    }

    fn end(&self, call: &(String, String)) {
        self.with(|all| all.remove(call));
    }
}

/// Until an attribute or a function has ended, or an activity was accepted.
async fn perform(
    cells: &Cells,
    supervisor: &Arc<Supervisor>,
    reaction: &Reaction,
) -> Result<(), ReactError> {
    let Deed { act, component, name } = reaction.deed()?;
    if let Some(cell) = cells.of(&component) {
        cell.answers().await?;
        if act == Act::Fire {
            cell.ask(&routes::fire(&component, &name)).await?;
            return Ok(());
        }
        let inputs = Inputs(reaction.inputs.clone());
        let reply: CallReply = cell.tell(&routes::call(&component, &name), &inputs).await?;
        let exception = reply.outcome().and_then(|outcome| outcome.exception.clone());
        return exception.map_or(Ok(()), |name| Err(ReactError::Exception(name)));
    }
    let (worker, inputs) = (Arc::clone(supervisor), reaction.inputs.clone());
    let work = move || match act {
        Act::Fire => request::fire(&worker.components, &worker.bus, &component, &name),
        Act::Call | Act::Start => {
            let entry = CallEntry { component, service: name, inputs };
            request::send(&worker.components, &entry).map(drop)
        }
    };
    Ok(tokio::task::spawn_blocking(work).await??)
}
