//! The activities of one component as supervisors see them: running, and lately ended.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Map, Value};
use tokio::sync::watch;

/// How a service ended.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Ending {
    /// With these outputs.
    Done(Value),
    /// With an exception and its members.
    Exception { name: String, detail: Value },
}

impl Ending {
    /// `{"result": ...}` or `{"exception": ..., "detail": ...}`.
    pub(crate) fn to_json(&self) -> Map<String, Value> {
        let mut reply = Map::new();
        match self {
            Ending::Done(outputs) => {
                reply.insert("result".into(), outputs.clone());
            }
            Ending::Exception { name, detail } => {
                reply.insert("exception".into(), name.as_str().into());
                reply.insert("detail".into(), detail.clone());
            }
        }
        reply
    }

    /// Name of the exception, if it ended with one.
    pub(crate) fn exception(&self) -> Option<&str> {
        match self {
            Ending::Done(_) => None,
            Ending::Exception { name, .. } => Some(name),
        }
    }
}

/// One activity; shared by all who wait for it.
#[derive(Debug)]
pub(crate) struct Activity {
    /// Its number, unique in the component's life.
    pub(crate) number: u64,
    /// The service it runs.
    pub(crate) service: String,
    ending: watch::Sender<Option<Ended>>,
}

#[derive(Clone, Debug)]
struct Ended {
    ending: Ending,
    at: Instant,
}

impl Activity {
    /// How it ended, if it did.
    pub(crate) fn ending(&self) -> Option<Ending> {
        self.ending.borrow().as_ref().map(|ended| ended.ending.clone())
    }

    /// Waits for its end.
    pub(crate) async fn ended(&self) -> Option<Ending> {
        let mut ending = self.ending.subscribe();
        let ended = ending.wait_for(Option::is_some).await.ok()?;
        ended.as_ref().map(|ended| ended.ending.clone())
    }

    /// Waits for its end, and holds up the thread.
    pub(crate) fn wait(&self) -> Option<Ending> {
        tokio::runtime::Handle::try_current().ok()?.block_on(self.ended())
    }

    /// As a reply; `state` of an activity that runs.
    pub(crate) fn to_json(&self, state: Option<&str>) -> Value {
        let mut reply = Map::new();
        reply.insert("activity".into(), self.number.into());
        reply.insert("service".into(), self.service.as_str().into());
        let ending = self.ending();
        let status = match &ending {
            None => "running",
            Some(Ending::Done(_)) => "done",
            Some(Ending::Exception { .. }) => "exception",
        };
        reply.insert("status".into(), status.into());
        match ending {
            Some(ending) => reply.extend(ending.to_json()),
            None => reply.extend(state.map(|state| ("state".to_owned(), Value::from(state)))),
        }
        Value::Object(reply)
    }
}

/// Results kept at most, however young: a supervisor that starts activities at a high rate must
/// not fill the memory.
const MOST_KEPT: usize = 4096;

/// The activities of one component.
#[derive(Debug)]
pub(crate) struct ActivityLog {
    entries: Mutex<BTreeMap<u64, Arc<Activity>>>,
    /// How long an ended activity stays.
    keep: Duration,
}

impl ActivityLog {
    pub(crate) fn new(keep: Duration) -> Self {
        Self { entries: Mutex::default(), keep }
    }

    /// An activity was accepted.
    pub(crate) fn started(&self, number: u64, service: &str) -> Arc<Activity> {
        let ending = watch::Sender::new(None);
        let activity = Arc::new(Activity { number, service: service.to_owned(), ending });
        self.edit(|entries| entries.insert(number, Arc::clone(&activity)));
        activity
    }

    /// An activity ended.
    pub(crate) fn ended(&self, activity: &Activity, ending: Ending) {
        activity.ending.send_replace(Some(Ended { ending, at: Instant::now() }));
    }

    /// The activity of that number.
    pub(crate) fn get(&self, number: u64) -> Option<Arc<Activity>> {
        self.edit(|entries| entries.get(&number).cloned())
    }

    /// All of them, by number.
    pub(crate) fn all(&self) -> Vec<Arc<Activity>> {
        self.edit(|entries| entries.values().cloned().collect())
    }

    /// How many run.
    pub(crate) fn running(&self) -> usize {
        self.all().iter().filter(|activity| activity.ending.borrow().is_none()).count()
    }

    /// Works on the entries, the outdated ones gone.
    fn edit<T>(&self, work: impl FnOnce(&mut BTreeMap<u64, Arc<Activity>>) -> T) -> T {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let mut excess = entries.len().saturating_sub(MOST_KEPT);
        entries.retain(|_, activity| match &*activity.ending.borrow() {
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
    use serde_json::json;

    #[test]
    fn a_result_stays_readable_for_the_time_asked() {
        let log = ActivityLog::new(Duration::from_secs(3600));
        let first = log.started(1, "goto");
        log.ended(&first, Ending::Done(json!({})));
        assert_eq!(log.get(1).unwrap().ending(), Some(Ending::Done(json!({}))));
        let log = ActivityLog::new(Duration::ZERO);
        let first = log.started(1, "goto");
        assert_eq!(log.running(), 1);
        log.ended(&first, Ending::Done(json!({})));
        assert_eq!(log.running(), 0);
    }

    #[tokio::test]
    async fn several_may_wait_for_one_activity() {
        let log = ActivityLog::new(Duration::from_secs(3600));
        let activity = log.started(7, "goto");
        let ending = Ending::Exception { name: "::x::E".into(), detail: json!({"a": 1}) };
        let (one, two, ()) = tokio::join!(activity.ended(), activity.ended(), async {
            log.ended(&activity, ending.clone());
        });
        assert_eq!((one, two), (Some(ending.clone()), Some(ending)));
        assert_eq!(
            activity.to_json(None).to_string(),
            r#"{"activity":7,"service":"goto","status":"exception","exception":"::x::E","detail":{"a":1}}"#
        );
    }

    #[test]
    fn many_results_do_not_pile_up() {
        let log = ActivityLog::new(Duration::from_secs(3600));
        for number in 0..MOST_KEPT as u64 + 10 {
            let activity = log.started(number, "tick");
            log.ended(&activity, Ending::Done(Value::Null));
        }
        assert!(log.all().len() <= MOST_KEPT);
        assert!(log.get(0).is_none());
    }
}
