//! Discovery: the liveliness tokens of this session and of all others.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

use genom_middleware::{Address, Endpoint, EndpointKind, OpenError};
use zenoh::liveliness::LivelinessToken;

use crate::inbox::Inbox;
use crate::keys::Token;

/// How long the news that an end was closed elsewhere may take to arrive.
const GRACE: Duration = Duration::from_millis(100);

/// All known ends.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    tokens: HashMap<String, Vec<Token>>,
    /// Our readers by address. They query the last value when a writer appears.
    readers: HashMap<String, Vec<Weak<Inbox>>>,
}

/// Keeps an end of ours registered, here and for others.
#[derive(Debug)]
pub(crate) struct Claim {
    graph: Arc<Graph>,
    token: Token,
    /// Set when the token has been declared.
    declared: Option<LivelinessToken>,
}

enum Conflict {
    Types(String),
    Taken,
}

impl Graph {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Registers an end of ours, unless it conflicts with another one.
    pub(crate) fn claim(
        self: &Arc<Self>,
        at: &Address,
        mut token: Token,
    ) -> Result<Claim, OpenError> {
        let end = Instant::now() + GRACE;
        let mut state = self.lock();
        loop {
            token.number = state.free(&token);
            let Some((conflict, session)) = state.conflict(&token) else { break };
            let left = end.saturating_duration_since(Instant::now());
            if session == token.session || left.is_zero() {
                return Err(match conflict {
                    Conflict::Types(theirs) => {
                        OpenError::TypeMismatch { address: at.clone(), ours: token.types, theirs }
                    }
                    Conflict::Taken => OpenError::Taken { address: at.clone() },
                });
            }
            let waited = self.changed.wait_timeout(state, left);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        state.add(token.clone());
        Ok(Claim { graph: Arc::clone(self), token, declared: None })
    }

    /// An end of another session appeared. Returns those of our readers that want its last value.
    pub(crate) fn appeared(&self, token: Token) -> Vec<Arc<Inbox>> {
        let mut state = self.lock();
        if let Some((conflict, _)) = state.conflict(&token)
            && state.has_ours(&token)
        {
            let Token { address, types, .. } = &token;
            match conflict {
                Conflict::Types(ours) => {
                    tracing::warn!(%address, "another session has {types} there, this one {ours}");
                }
                Conflict::Taken => tracing::warn!(%address, "another session opened it as well"),
            }
        }
        let readers = match token.kind {
            EndpointKind::Publisher => state.readers.get(&token.address),
            _ => None,
        };
        let readers = readers.into_iter().flatten().filter_map(Weak::upgrade).collect();
        state.add(token);
        self.changed.notify_all();
        readers
    }

    /// An end of another session is gone.
    pub(crate) fn vanished(&self, token: &Token) {
        self.lock().remove(token);
        self.changed.notify_all();
    }

    /// Types of the service at an address, if they are known to differ from `digest`.
    pub(crate) fn other_service(&self, at: &str, digest: &str) -> Option<String> {
        let state = self.lock();
        let mut services = state.at(at).filter(|other| other.kind == EndpointKind::Service);
        services.find(|other| other.digest != digest).map(|other| other.types.clone())
    }

    /// Whether somebody announces a service at an address.
    pub(crate) fn serves(&self, at: &str) -> bool {
        self.lock().at(at).any(|other| other.kind == EndpointKind::Service)
    }

    /// Registers a reader of ours for as long as it exists.
    pub(crate) fn add_reader(&self, at: &Address, inbox: &Arc<Inbox>) {
        let mut state = self.lock();
        let readers = state.readers.entry(at.to_string()).or_default();
        readers.retain(|other| other.strong_count() > 0);
        readers.push(Arc::downgrade(inbox));
    }

    /// The sessions that have ends.
    pub(crate) fn sessions(&self) -> HashSet<String> {
        let state = self.lock();
        state.tokens.values().flatten().map(|token| token.session.clone()).collect()
    }

    /// The ends of a session.
    pub(crate) fn ours(&self, own: &str) -> Vec<Token> {
        let state = self.lock();
        state.tokens.values().flatten().filter(|token| token.session == own).cloned().collect()
    }

    /// Addresses of a session's out ports that no known end of another session reads.
    pub(crate) fn unread(&self, own: &str) -> Vec<String> {
        let state = self.lock();
        let unread = |(_, tokens): &(&String, &Vec<Token>)| {
            let ours =
                |token: &Token| token.kind == EndpointKind::Publisher && token.session == own;
            let theirs =
                |token: &Token| token.kind == EndpointKind::Subscription && token.session != own;
            tokens.iter().any(ours) && !tokens.iter().any(theirs)
        };
        state.tokens.iter().filter(unread).map(|(address, _)| address.clone()).collect()
    }

    pub(crate) fn list(&self) -> Vec<Endpoint> {
        let state = self.lock();
        let endpoint = |token: &Token| Endpoint {
            kind: token.kind,
            address: token.address.clone(),
            ty: match token.kind {
                EndpointKind::Service => token.types.clone(),
                _ => token.types.split(" (").next().unwrap_or_default().to_owned(),
            },
        };
        state.tokens.values().flatten().map(endpoint).collect()
    }
}

impl State {
    fn at(&self, address: &str) -> impl Iterator<Item = &Token> + Clone {
        self.tokens.get(address).into_iter().flatten()
    }

    fn add(&mut self, token: Token) {
        let tokens = self.tokens.entry(token.address.clone()).or_default();
        if !tokens.contains(&token) {
            tokens.push(token);
        }
    }

    fn remove(&mut self, token: &Token) {
        let Some(tokens) = self.tokens.get_mut(&token.address) else { return };
        tokens.retain(|other| other != token);
        if tokens.is_empty() {
            self.tokens.remove(&token.address);
        }
    }

    /// The smallest number that no end of this session uses at the address. Numbers are reused,
    /// because zenoh never frees a key expression that it has seen.
    fn free(&self, token: &Token) -> u64 {
        let own = self.at(&token.address).filter(|other| other.session == token.session);
        (0..).find(|number| own.clone().all(|other| other.number != *number)).unwrap_or_default()
    }

    /// The end that conflicts with this one, and the session that has it.
    fn conflict(&self, token: &Token) -> Option<(Conflict, String)> {
        let port = token.kind != EndpointKind::Service;
        let mut same = self
            .at(&token.address)
            .filter(|other| *other != token && (other.kind != EndpointKind::Service) == port);
        if port && let Some(other) = same.clone().find(|other| other.digest != token.digest) {
            return Some((Conflict::Types(other.types.clone()), other.session.clone()));
        }
        let alone = token.kind != EndpointKind::Subscription;
        let other = same.find(|other| alone && other.kind == token.kind)?;
        Some((Conflict::Taken, other.session.clone()))
    }

    /// Whether this session has an end at the address of another session's token.
    fn has_ours(&self, token: &Token) -> bool {
        self.at(&token.address).any(|other| other.session != token.session)
    }
}

impl Claim {
    pub(crate) fn token(&self) -> &Token {
        &self.token
    }

    /// Keeps the declared token for as long as the claim.
    pub(crate) fn declared(mut self, token: LivelinessToken) -> Self {
        self.declared = Some(token);
        self
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        self.declared = None;
        self.graph.lock().remove(&self.token);
        self.graph.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_that_comes_again_has_the_same_key_and_no_other_end_has_it() {
        let graph = Arc::new(Graph::default());
        let at = Address::parse("demo/position").unwrap();
        let claim = |kind| {
            let (session, digest, types) = ("1".to_owned(), "d".to_owned(), "t".to_owned());
            let token = Token { kind, session, number: 0, digest, types, address: at.to_string() };
            graph.claim(&at, token)
        };
        let first = claim(EndpointKind::Publisher).unwrap();
        assert!(matches!(claim(EndpointKind::Publisher), Err(OpenError::Taken { .. })));
        let reader = claim(EndpointKind::Subscription).unwrap();
        let (token, other) = (first.token().clone(), reader.token().clone());
        assert_ne!(token.number, other.number);
        drop(first);
        assert_eq!(*claim(EndpointKind::Publisher).unwrap().token(), token);
    }
}
