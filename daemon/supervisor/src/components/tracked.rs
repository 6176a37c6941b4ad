//! Follows requests from their acceptance to their end.

use std::sync::{Arc, PoisonError};

use genom_description::model::{Owner, ServiceIx};
use genom_runtime::{Progress, Reply, Resume, Resumed};
use genom_types::Record;
use serde_json::{Value, json};
use tracing::Span;

use super::activities::{Activity, ActivityLog};
use super::input::{Completion, InputError};
use super::prepared::{Goal, Prepared};
use super::standing::Standing;
use crate::outcome::Outcome;
use crate::recording::Call;
use crate::spans;

/// Follows one request: its activity, span, recording and remembered inputs.
pub(super) struct Tracked {
    /// Lasts from the request to its end.
    pub(super) span: Span,
    /// The recorded request, if there is a recording: its end is recorded, too.
    pub(super) call: Option<Call>,
    pub(super) log: Arc<ActivityLog>,
    pub(super) service: String,
    pub(super) running: Option<Arc<Activity>>,
    pub(super) standing: Arc<Standing>,
    /// The inputs, if they are to be remembered.
    pub(super) inputs: Option<Value>,
    /// Result of completing partial inputs.
    pub(super) completion: Option<Completion>,
}

impl Tracked {
    /// Remembers the completed inputs. Returns the reason if they were refused.
    pub(super) fn completed(&mut self) -> Option<InputError> {
        let completion = self.completion.take()?;
        let mut completed = completion.lock().unwrap_or_else(PoisonError::into_inner);
        if let (Some(inputs), Some(all)) = (&mut self.inputs, completed.inputs.take()) {
            *inputs = all;
        }
        completed.refused.take()
    }

    pub(super) fn started(&mut self, number: u32) -> Arc<Activity> {
        let activity = self.log.started(u64::from(number), &self.service);
        self.running = Some(Arc::clone(&activity));
        if let Some(inputs) = self.inputs.take() {
            self.standing.activity(activity.number, inputs);
        }
        activity
    }

    pub(super) fn ended(&mut self, outcome: Outcome) {
        let activity = self.running.as_ref().map(|activity| activity.number);
        if let Some(call) = self.call.take() {
            call.ended(activity, &outcome);
        }
        // The span ends when its last handle is dropped.
        spans::ended(&std::mem::replace(&mut self.span, Span::none()), activity, &outcome);
        if let Some(inputs) = self.inputs.take().filter(|_| outcome.exception().is_none()) {
            self.standing.attribute(&self.service, inputs);
        }
        if let Some(activity) = self.running.take() {
            self.standing.ended(activity.number);
            self.log.ended(&activity, outcome);
        }
    }
}

impl Drop for Tracked {
    fn drop(&mut self) {
        // The component could not be stopped in time: callers must not wait forever.
        let (name, detail) = ("::genom::interrupted".to_owned(), json!({"by": "kill"}));
        self.ended(Outcome::Exception { name, detail });
    }
}

/// Nothing but that it is held.
pub(super) fn held() -> Resume {
    Resume {
        ids: None,
        ports: Vec::new(),
        executed: Vec::new(),
        activities: Vec::new(),
        hold: true,
    }
}

/// What the runtime takes to go on at a state.
pub(super) fn resume(
    prepared: Prepared,
    component: &str,
    log: &Arc<ActivityLog>,
    standing: &Arc<Standing>,
    goes_on: &dyn Fn(ServiceIx) -> bool,
) -> Resume {
    let permanent = prepared.permanent.into_iter();
    let mut activities: Vec<Resumed> =
        permanent.map(|activity| Resumed { activity, reply: None, goes_on: false }).collect();
    activities.extend(prepared.activities.into_iter().map(|goal| {
        let Goal { activity, service, inputs } = goal;
        // The reply that its client waits for is kept.
        if matches!(activity.owner, Owner::Service(service) if goes_on(service)) {
            return Resumed { activity, reply: None, goes_on: true };
        }
        let mut tracked = Tracked {
            span: spans::service(component, &service),
            call: None,
            log: Arc::clone(log),
            service,
            running: None,
            standing: Arc::clone(standing),
            inputs: Some(inputs),
            completion: None,
        };
        let reply: Reply = Box::new(move |step| match step {
            Progress::Accepted { activity } => drop(tracked.started(activity)),
            Progress::Ended(outcome) => tracked.ended(Outcome::from(&outcome)),
        });
        Resumed { activity, reply: Some(reply), goes_on: false }
    }));
    Resume {
        ids: prepared.ids.map(|ids| -> Box<dyn FnOnce(&mut Record) + Send> {
            Box::new(move |record| drop(record.take_over(&ids)))
        }),
        ports: prepared.ports,
        executed: prepared.executed,
        activities,
        hold: prepared.hold,
    }
}
