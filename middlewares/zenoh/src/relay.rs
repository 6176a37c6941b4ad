//! Requests to daemons, as queries on a key of each; who is there, by liveliness tokens.

use std::collections::BTreeSet;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use genom_middleware::DiscoverError;
use genom_middleware::relay::{AnnounceError, AskError, OnRequest, Relay};
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::query::{QueryTarget, Queryable};

use crate::backend::{BACKEND, Core, Zenoh};

/// How long a daemon that does not show yet is waited for.
const TO_SHOW: Duration = Duration::from_secs(3);

/// The daemons that show, as session and name.
#[derive(Default)]
pub(crate) struct Daemons {
    there: Mutex<BTreeSet<(String, String)>>,
    changed: Condvar,
}

impl Daemons {
    /// A daemon came, or went. `own` is this session.
    pub(crate) fn heard(&self, session: String, name: String, came: bool, own: &str) {
        let mut there = self.there.lock().unwrap_or_else(PoisonError::into_inner);
        // Both came at once, or the network was apart: neither was there to be seen.
        if came && session != own && there.contains(&(own.to_owned(), name.clone())) {
            tracing::warn!("{}; until then requests may reach either", taken(&name));
        }
        if came {
            there.insert((session, name));
        } else {
            there.remove(&(session, name));
        }
        self.changed.notify_all();
    }

    /// Whether a daemon shows in that session.
    pub(crate) fn has(&self, wanted: &str) -> bool {
        let there = self.there.lock().unwrap_or_else(PoisonError::into_inner);
        there.iter().any(|(session, _)| session == wanted)
    }

    fn names(&self) -> Vec<String> {
        let there = self.there.lock().unwrap_or_else(PoisonError::into_inner);
        let names: BTreeSet<_> = there.iter().map(|(_, name)| name.clone()).collect();
        names.into_iter().collect()
    }

    /// Waits until a daemon of that name shows; whether it does.
    fn wait_for(&self, wanted: &str) -> bool {
        let there = self.there.lock().unwrap_or_else(PoisonError::into_inner);
        let absent =
            |there: &mut BTreeSet<(String, String)>| !there.iter().any(|(_, name)| name == wanted);
        let waited = self.changed.wait_timeout_while(there, TO_SHOW, absent);
        !waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    /// Whether another session shows a daemon of that name.
    fn taken(&self, wanted: &str, own: &str) -> bool {
        let there = self.there.lock().unwrap_or_else(PoisonError::into_inner);
        there.iter().any(|(session, name)| name == wanted && session != own)
    }
}

fn taken(name: &str) -> AnnounceError {
    AnnounceError::Taken { name: name.to_owned(), backend: BACKEND.to_owned() }
}

/// A daemon that shows; gone with this.
struct Announced {
    /// Not seen any more before its requests are refused.
    token: Option<LivelinessToken>,
    queryable: Option<Queryable<()>>,
    name: String,
    core: Arc<Core>,
}

impl Drop for Announced {
    fn drop(&mut self) {
        self.token = None;
        self.queryable = None;
        let own = self.core.name();
        self.core.daemons().heard(own.to_owned(), self.name.clone(), false, own);
    }
}

impl Relay for Zenoh {
    fn announce(
        &self,
        name: &str,
        requests: Box<OnRequest>,
    ) -> Result<Box<dyn Send + Sync>, AnnounceError> {
        let core = &self.core;
        if core.daemons().taken(name, core.name()) {
            return Err(taken(name));
        }
        let failed = |error: zenoh::Error| AnnounceError::Failed {
            name: name.to_owned(),
            backend: BACKEND.to_owned(),
            why: error.to_string(),
        };
        let (key, orders) = (core.keys().to_daemon(name), core.orders().clone());
        let own = key.clone();
        let queryable = core.session().declare_queryable(key).complete(true);
        let queryable = queryable
            .callback(move |query| {
                // A question to all keys is no request to this daemon.
                if query.key_expr().as_str() != own {
                    return;
                }
                let request =
                    query.payload().map(ZBytes::to_bytes).unwrap_or_default().into_owned();
                let orders = orders.clone();
                let answer = move |answer: Vec<u8>| {
                    orders.submit(move |_| {
                        if let Err(error) = query.reply(query.key_expr().clone(), answer).wait() {
                            tracing::debug!("an answer to a supervisor was not sent: {error}");
                        }
                    });
                };
                requests(request, Box::new(answer));
            })
            .wait()
            .map_err(failed)?;
        let token = core.keys().of_daemon(core.name(), name);
        let token = core.session().liveliness().declare_token(token).wait().map_err(failed)?;
        core.daemons().heard(core.name().to_owned(), name.to_owned(), true, core.name());
        Ok(Box::new(Announced {
            token: Some(token),
            queryable: Some(queryable),
            name: name.to_owned(),
            core: Arc::clone(core),
        }))
    }

    fn daemons(&self) -> Result<Vec<String>, DiscoverError> {
        Ok(self.core.daemons().names())
    }

    fn ask(&self, name: &str, request: &[u8], patience: Duration) -> Result<Vec<u8>, AskError> {
        let silent = |why: String| AskError::Silent {
            name: name.to_owned(),
            backend: BACKEND.to_owned(),
            why,
        };
        if !self.core.daemons().wait_for(name) {
            let backend = BACKEND.to_owned();
            return Err(AskError::Unknown { name: name.to_owned(), backend });
        }
        let (sender, answers) = channel();
        // The callback, and with it the sender, goes when no more replies come.
        self.core
            .session()
            .get(self.core.keys().to_daemon(name))
            .target(QueryTarget::All)
            .payload(request)
            .timeout(patience)
            .callback(move |reply| {
                let answer = match reply.result() {
                    Ok(sample) => Ok(sample.payload().to_bytes().into_owned()),
                    Err(error) => Err(format!("{:?}", error.payload().try_to_string())),
                };
                let _ = sender.send(answer);
            })
            .wait()
            .map_err(|error| silent(error.to_string()))?;
        match answers.recv_timeout(patience) {
            Ok(answer) => answer.map_err(silent),
            Err(RecvTimeoutError::Timeout) => Err(silent(format!("nothing within {patience:?}"))),
            Err(RecvTimeoutError::Disconnected) => Err(silent("it went away".to_owned())),
        }
    }
}
