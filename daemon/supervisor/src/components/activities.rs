//! The activities of one component as supervisors see them: the running ones, and those that ended
//! recently.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use genom_protocol::{Activity as Look, Status};
use tokio::sync::watch;

use crate::outcome::Outcome;
use crate::waiting::wait;

/// An activity, shared by all who wait for it.
#[derive(Debug)]
pub struct Activity {
    /// Its number, unique during the life of the component.
    pub number: u64,
    /// Name of its service.
    pub service: String,
    outcome: watch::Sender<Option<Ended>>,
}

#[derive(Clone, Debug)]
struct Ended {
    outcome: Outcome,
    at: Instant,
}

impl Activity {
    /// Its outcome, if it has ended.
    pub fn outcome(&self) -> Option<Outcome> {
        self.outcome.borrow().as_ref().map(|ended| ended.outcome.clone())
    }

    /// Waits for its outcome.
    pub async fn ended(&self) -> Option<Outcome> {
        let mut outcome = self.outcome.subscribe();
        let ended = outcome.wait_for(Option::is_some).await.ok()?;
        ended.as_ref().map(|ended| ended.outcome.clone())
    }

    /// Waits for its outcome. Blocks the thread.
    pub fn wait(&self) -> Option<Outcome> {
        wait(self.ended(), None).flatten()
    }

    /// Waits for its outcome, at most this long. Blocks the thread.
    pub fn wait_at_most(&self, time: Duration) -> Option<Outcome> {
        wait(self.ended(), Some(Instant::now() + time)).flatten()
    }

    /// The activity as the control plane reports it; `state` is used only if it still runs.
    pub fn look(&self, state: Option<String>) -> Look {
        let outcome = self.outcome();
        let status = match &outcome {
            None => Status::Running,
            Some(Outcome::Success(_)) => Status::Done,
            Some(Outcome::Exception { .. }) => Status::Exception,
        };
        Look {
            activity: self.number,
            service: self.service.clone(),
            status,
            state: state.filter(|_| outcome.is_none()),
            outcome: outcome.map(Into::into).unwrap_or_default(),
        }
    }
}

/// Maximum number of results kept, however recent: a supervisor that starts activities at a high
/// rate must not fill the memory.
const MOST_KEPT: usize = 4096;

/// The activities of one component.
#[derive(Debug)]
pub struct ActivityLog {
    entries: Mutex<BTreeMap<u64, Arc<Activity>>>,
    /// How long an ended activity is kept.
    keep: Duration,
}

impl ActivityLog {
    /// No activities; those that end are kept for `keep`.
    pub fn new(keep: Duration) -> Self {
        Self { entries: Mutex::default(), keep }
    }

    /// Adds an activity that was accepted.
    pub fn started(&self, number: u64, service: &str) -> Arc<Activity> {
        let outcome = watch::Sender::new(None);
        let activity = Arc::new(Activity { number, service: service.to_owned(), outcome });
        self.edit(|entries| entries.insert(number, Arc::clone(&activity)));
        activity
    }

    /// Stores the outcome of an activity.
    pub fn ended(&self, activity: &Activity, outcome: Outcome) {
        activity.outcome.send_replace(Some(Ended { outcome, at: Instant::now() }));
    }

    /// The activity of that number.
    pub fn get(&self, number: u64) -> Option<Arc<Activity>> {
        self.edit(|entries| entries.get(&number).cloned())
    }

    /// All activities, in order of their numbers.
    pub fn all(&self) -> Vec<Arc<Activity>> {
        self.edit(|entries| entries.values().cloned().collect())
    }

    /// Number of running activities.
    pub fn running(&self) -> usize {
        self.all().iter().filter(|activity| activity.outcome.borrow().is_none()).count()
    }

    /// Calls `work` with the entries, after removing those that were kept long enough.
    fn edit<T>(&self, work: impl FnOnce(&mut BTreeMap<u64, Arc<Activity>>) -> T) -> T {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let mut excess = entries.len().saturating_sub(MOST_KEPT);
        entries.retain(|_, activity| match &*activity.outcome.borrow() {
            None => true,
            Some(ended) => {
                let excessive = excess > 0;
                excess = excess.saturating_sub(1);
                !excessive && ended.at.elapsed() <= self.keep
            }
        });
        work(&mut entries)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    #[test]
    fn a_result_stays_readable_for_the_time_asked() {
        let log = ActivityLog::new(Duration::from_secs(3600));
        let first = log.started(1, "goto");
        log.ended(&first, Outcome::Success(json!({})));
        assert_eq!(log.get(1).unwrap().outcome(), Some(Outcome::Success(json!({}))));
        let log = ActivityLog::new(Duration::ZERO);
        let first = log.started(1, "goto");
        assert_eq!(log.running(), 1);
        log.ended(&first, Outcome::Success(json!({})));
        assert_eq!(log.running(), 0);
    }

    #[tokio::test]
    async fn several_may_wait_for_one_activity() {
        let log = ActivityLog::new(Duration::from_secs(3600));
        let activity = log.started(7, "goto");
        let outcome = Outcome::Exception { name: "::x::E".into(), detail: json!({"a": 1}) };
        let (one, two, ()) = tokio::join!(activity.ended(), activity.ended(), async {
            log.ended(&activity, outcome.clone());
        });
        assert_eq!((one, two), (Some(outcome.clone()), Some(outcome)));
        assert_eq!(
            serde_json::to_string(&activity.look(None)).unwrap(),
            r#"{"activity":7,"service":"goto","status":"exception","exception":"::x::E","detail":{"a":1}}"#
        );
    }

    #[test]
    fn many_results_do_not_pile_up() {
        let log = ActivityLog::new(Duration::from_secs(3600));
        for number in 0..MOST_KEPT as u64 + 10 {
            let activity = log.started(number, "tick");
            log.ended(&activity, Outcome::Success(Value::Null));
        }
        assert!(log.all().len() <= MOST_KEPT);
        assert!(log.get(0).is_none());
    }
}
