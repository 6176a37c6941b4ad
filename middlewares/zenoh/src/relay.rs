//! Requests to daemons, as queries on a key of each; who is there, by liveliness tokens.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use genom_middleware::DiscoverError;
use genom_middleware::relay::{AnnounceError, AskError, OnRequest, Relay};
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::query::{ConsolidationMode, Query, QueryTarget, Queryable, Reply};

use crate::backend::Zenoh;
use crate::core::Core;
use crate::error::BACKEND;
use crate::sending::Orders;

/// Answers to one name that are gathered; there is meant to be one.
const MOST_ANSWERS: usize = 16;

/// A daemon that shows; gone with this.
struct Announced {
    /// Not seen any more before its requests are refused.
    token: Option<LivelinessToken>,
    queryables: Vec<Queryable<()>>,
    name: String,
    core: Arc<Core>,
}

impl Drop for Announced {
    fn drop(&mut self) {
        self.token = None;
        self.queryables.clear();
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
            return Err(AnnounceError::Taken {
                name: name.to_owned(),
                backend: BACKEND.to_owned(),
            });
        }
        let failed = |error: zenoh::Error| AnnounceError::Failed {
            name: name.to_owned(),
            backend: BACKEND.to_owned(),
            why: error.to_string(),
        };
        let requests: Arc<OnRequest> = requests.into();
        // All of that name are asked by the first key, this one alone by the second.
        let keys = [core.keys().to_daemon(name), core.keys().to_daemon_at(name, core.name())];
        let declare = |key: String| {
            let (orders, requests) = (core.orders().clone(), Arc::clone(&requests));
            let own = key.clone();
            let queryable = core.session().declare_queryable(key).complete(true);
            let queryable = queryable.callback(move |query| {
                // A question to all keys is no request to this daemon.
                if query.key_expr().as_str() == own {
                    take(query, &*requests, orders.clone());
                }
            });
            queryable.wait().map_err(failed)
        };
        let queryables = keys.into_iter().map(declare).collect::<Result<_, _>>()?;
        let token = core.keys().of_daemon(core.name(), name);
        let token = core.session().liveliness().declare_token(token).wait().map_err(failed)?;
        core.daemons().heard(core.name().to_owned(), name.to_owned(), true, core.name());
        Ok(Box::new(Announced {
            token: Some(token),
            queryables,
            name: name.to_owned(),
            core: Arc::clone(core),
        }))
    }

    fn daemons(&self) -> Result<Vec<String>, DiscoverError> {
        Ok(self.core.daemons().names())
    }

    fn own(&self) -> String {
        self.core.name().to_owned()
    }

    fn ask_all(
        &self,
        name: &str,
        request: &[u8],
        patience: Duration,
    ) -> Result<Vec<(String, Vec<u8>)>, AskError> {
        if !self.core.daemons().wait_for(name) {
            let backend = BACKEND.to_owned();
            return Err(AskError::Unknown { name: name.to_owned(), backend });
        }
        let replies = self.get(name, self.core.keys().to_daemon(name), request, patience)?;
        let end = Instant::now() + patience;
        let mut answers = Vec::new();
        // Ends as well when no more replies can come.
        while let Ok(reply) = replies.recv_timeout(end.saturating_duration_since(Instant::now()))
            && answers.len() < MOST_ANSWERS
        {
            // An error is zenoh's own word that somebody who shows did not answer in time.
            let Ok(sample) = reply.result() else { continue };
            let from = reply.replier_id().map_or_else(|| "?".to_owned(), |id| id.zid().to_string());
            answers.push((from, sample.payload().to_bytes().into_owned()));
        }
        Ok(answers)
    }

    fn ask(
        &self,
        name: &str,
        at: &str,
        request: &[u8],
        patience: Duration,
    ) -> Result<Vec<u8>, AskError> {
        let replies = self.get(name, self.core.keys().to_daemon_at(name, at), request, patience)?;
        match replies.recv_timeout(patience).as_ref().map(Reply::result) {
            Ok(Ok(sample)) => Ok(sample.payload().to_bytes().into_owned()),
            Ok(Err(error)) => Err(silent(name, format!("{:?}", error.payload().try_to_string()))),
            Err(RecvTimeoutError::Timeout) => {
                Err(silent(name, format!("nothing within {patience:?}")))
            }
            Err(RecvTimeoutError::Disconnected) => Err(silent(name, "it went away".to_owned())),
        }
    }
}

/// Hands a request over; the answer goes out by the session's thread.
fn take(query: Query, requests: &OnRequest, orders: Orders) {
    let request = query.payload().map(ZBytes::to_bytes).unwrap_or_default().into_owned();
    let answer = move |answer: Vec<u8>| {
        orders.submit(move |_, _| {
            if let Err(error) = query.reply(query.key_expr().clone(), answer).wait() {
                tracing::debug!("an answer to a supervisor was not sent: {error}");
            }
        });
    };
    requests(request, Box::new(answer));
}

fn silent(name: &str, why: String) -> AskError {
    AskError::Silent { name: name.to_owned(), backend: BACKEND.to_owned(), why }
}

impl Zenoh {
    /// Asks all who answer to a key; the replies as they come, until no more do.
    fn get(
        &self,
        name: &str,
        key: String,
        request: &[u8],
        patience: Duration,
    ) -> Result<Receiver<Reply>, AskError> {
        // The callback, and with it the sender, goes when no more replies come.
        let (sender, replies) = channel();
        let get = self.core.session().get(key).target(QueryTarget::All);
        get.consolidation(ConsolidationMode::None)
            .payload(request)
            .timeout(patience)
            .callback(move |reply| {
                let _ = sender.send(reply);
            })
            .wait()
            .map_err(|error| silent(name, error.to_string()))?;
        Ok(replies)
    }
}
