//! The activities of one component as supervisors see them: running, and lately ended.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use genom_protocol::{Activity as Look, Status};
use tokio::sync::watch;

use crate::ending::Ending;
use crate::waiting::wait;

/// One activity; shared by all who wait for it.
#[derive(Debug)]
pub struct Activity {
    /// Its number, unique in the component's life.
    pub number: u64,
    /// The service it runs.
    pub service: String,
    ending: watch::Sender<Option<Ended>>,
}

#[derive(Clone, Debug)]
struct Ended {
    ending: Ending,
    at: Instant,
}

impl Activity {
    /// How it ended, if it did.
    pub fn ending(&self) -> Option<Ending> {
        self.ending.borrow().as_ref().map(|ended| ended.ending.clone())
    }

    /// Waits for its end.
    pub async fn ended(&self) -> Option<Ending> {
        let mut ending = self.ending.subscribe();
        let ended = ending.wait_for(Option::is_some).await.ok()?;
        ended.as_ref().map(|ended| ended.ending.clone())
    }

    /// Waits for its end, and holds up the thread.
    pub fn wait(&self) -> Option<Ending> {
        wait(self.ended(), None).flatten()
    }

    /// The same, no longer than this.
    pub fn wait_at_most(&self, time: Duration) -> Option<Ending> {
        wait(self.ended(), Some(Instant::now() + time)).flatten()
    }

    /// As a reply; `state` of an activity that runs.
    pub fn look(&self, state: Option<String>) -> Look {
        let ending = self.ending();
        let status = match &ending {
            None => Status::Running,
            Some(Ending::Done(_)) => Status::Done,
            Some(Ending::Exception { .. }) => Status::Exception,
        };
        Look {
            activity: self.number,
            service: self.service.clone(),
            status,
            state: state.filter(|_| ending.is_none()),
            outcome: ending.map(|ending| ending.told()).unwrap_or_default(),
        }
    }
}

/// Results kept at most, however young: a supervisor that starts activities at a high rate must
/// not fill the memory.
const MOST_KEPT: usize = 4096;

/// The activities of one component.
#[derive(Debug)]
pub struct ActivityLog {
    entries: Mutex<BTreeMap<u64, Arc<Activity>>>,
    /// How long an ended activity stays.
    keep: Duration,
}

impl ActivityLog {
    /// No activity yet; ended ones stay for `keep`.
    pub fn new(keep: Duration) -> Self {
        Self { entries: Mutex::default(), keep }
    }

    /// An activity was accepted.
    pub fn started(&self, number: u64, service: &str) -> Arc<Activity> {
        let ending = watch::Sender::new(None);
        let activity = Arc::new(Activity { number, service: service.to_owned(), ending });
        self.edit(|entries| entries.insert(number, Arc::clone(&activity)));
        activity
    }

    /// An activity ended.
    pub fn ended(&self, activity: &Activity, ending: Ending) {
        activity.ending.send_replace(Some(Ended { ending, at: Instant::now() }));
    }

    /// The activity of that number.
    pub fn get(&self, number: u64) -> Option<Arc<Activity>> {
        self.edit(|entries| entries.get(&number).cloned())
    }

    /// All of them, by number.
    pub fn all(&self) -> Vec<Arc<Activity>> {
        self.edit(|entries| entries.values().cloned().collect())
    }

    /// How many run.
    pub fn running(&self) -> usize {
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
    use serde_json::{Value, json};

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
            serde_json::to_string(&activity.look(None)).unwrap(),
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
