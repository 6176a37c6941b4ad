//! Sessions of browsers.

use std::collections::HashMap;
use std::fmt;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use std::{io, net::SocketAddr};

use genom_doors::{Holder, Tokens};
use genom_proof::Bytes;
use genom_protocol::Right;

use crate::secret;
use crate::shelf::{Kept, KeptSession, Shelf};
use crate::visitor::{Ground, Visitor};

/// The sessions of all browsers.
#[derive(Debug)]
pub(crate) struct Sessions {
    /// Sessions of one visitor; with one more, the one that was not used for longest ends.
    most: usize,
    lifetime: Duration,
    tokens: Arc<Tokens>,
    shelf: Shelf,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    address: Option<SocketAddr>,
    open: HashMap<Bytes<32>, Session>,
    /// Number of the last session.
    last: u64,
    /// Advances with each use of a session.
    uses: u64,
}

#[derive(Debug)]
struct Session {
    number: u64,
    visitor: Visitor,
    /// In seconds since 1970, which a restart does not change.
    until: u64,
    used: u64,
}

/// Whose session it is, for messages.
struct Named<'a>(&'a Session);

impl fmt::Display for Named<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "web session {} of {}", self.0.number, self.0.visitor.who)
    }
}

impl Sessions {
    /// At most this many sessions of each visitor, each for this time. Those of a daemon before
    /// this one on the same socket go on.
    pub(crate) fn new(most: usize, lifetime: Duration, tokens: Arc<Tokens>, socket: &Path) -> Self {
        let shelf = Shelf::beside(socket);
        let kept = shelf.read();
        let mut state = State { address: kept.address, ..State::default() };
        for KeptSession { digest, visitor, until } in kept.sessions {
            state.last += 1;
            let session = Session { number: state.last, visitor, until, used: 0 };
            state.open.insert(digest, session);
        }
        Self { most, lifetime, tokens, shelf, state: Mutex::new(state) }
    }

    /// The address of the console of a daemon before this one.
    pub(crate) fn last_address(&self) -> Option<SocketAddr> {
        self.lock().address
    }

    /// Remembers the address for the next daemon.
    pub(crate) fn set_address(&self, address: SocketAddr) {
        let mut state = self.lock();
        state.address = Some(address);
        self.keep(&state);
    }

    /// How long a session lasts.
    pub(crate) fn lifetime(&self) -> Duration {
        self.lifetime
    }

    /// Opens a session; returns the secret for the browser, and the name of the session.
    pub(crate) fn open(&self, visitor: Visitor) -> io::Result<(String, String)> {
        let secret = secret::new()?;
        let now = seconds(SystemTime::now());
        let mut state = self.lock();
        state.open.retain(|_, one| one.until > now);
        let of_visitor = |one: &&Session| one.visitor.who == visitor.who;
        if state.open.values().filter(of_visitor).count() >= self.most {
            let all = state.open.iter().filter(|(_, one)| of_visitor(one));
            let oldest = all.min_by_key(|(_, one)| one.used).map(|(digest, _)| *digest);
            if let Some(ended) = oldest.and_then(|digest| state.open.remove(&digest)) {
                let (ended, most) = (Named(&ended), self.most);
                tracing::info!("{ended} ended: there are {most} newer ones (web.max_sessions)");
            }
        }
        state.last += 1;
        state.uses += 1;
        let (number, used) = (state.last, state.uses);
        let session = Session { number, visitor, until: now + self.lifetime.as_secs(), used };
        let name = Named(&session).to_string();
        state.open.insert(secret::digest(&secret), session);
        self.keep(&state);
        Ok((secret, name))
    }

    /// The holder of a session, with the rights that it has now.
    pub(crate) fn holder(&self, secret: &str) -> Option<Holder> {
        let mut state = self.lock();
        state.uses += 1;
        let uses = state.uses;
        let session = state.open.get_mut(&secret::digest(secret))?;
        if session.until <= seconds(SystemTime::now()) {
            return None;
        }
        session.used = uses;
        let rights = session.visitor.rights_now(&self.tokens)?;
        Some(Holder::of(Named(session).to_string(), rights))
    }

    /// Whose session it is, with these of its rights, or all.
    pub(crate) fn visitor(&self, secret: &str, rights: Option<Vec<Right>>) -> Option<Visitor> {
        let state = self.lock();
        let visitor = &state.open.get(&secret::digest(secret))?.visitor;
        let rights = rights.unwrap_or_else(|| visitor.rights.clone());
        Some(Visitor { rights, ..visitor.clone() })
    }

    /// Ends a session.
    pub(crate) fn close(&self, secret: &str) -> bool {
        let mut state = self.lock();
        let closed = state.open.remove(&secret::digest(secret));
        if let Some(closed) = &closed {
            tracing::info!("{} ended: signed out", Named(closed));
            self.keep(&state);
        }
        closed.is_some()
    }

    /// Writes down what goes on after a restart. Whether a certificate is still accepted is known
    /// only to TLS, so that these sessions end with the daemon.
    fn keep(&self, state: &State) {
        let kept = state.open.iter().filter(|(_, one)| one.visitor.ground != Ground::Certificate);
        let kept = kept.map(|(digest, one)| KeptSession {
            digest: *digest,
            visitor: one.visitor.clone(),
            until: one.until,
        });
        let kept = Kept { address: state.address, sessions: kept.collect() };
        if let Err(error) = self.shelf.write(&kept) {
            tracing::warn!("sessions of the web console will end with this daemon: {error}");
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn seconds(date: SystemTime) -> u64 {
    date.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs()
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    const HOUR: Duration = Duration::from_secs(3600);

    fn owner(who: &str) -> Visitor {
        Visitor { who: who.to_owned(), rights: vec![Right::Admin], ground: Ground::Owner }
    }

    fn sessions(at: &Path, most: usize, lifetime: Duration, tokens: &Arc<Tokens>) -> Sessions {
        Sessions::new(most, lifetime, Arc::clone(tokens), &at.join("genomd.sock"))
    }

    fn token_file(at: &Path, text: &str, rights: &str) {
        let entry =
            format!("[[token]]\nname = \"panel\"\ntoken = \"{text:-<32}\"\nrights = {rights}\n");
        std::fs::write(at, entry).unwrap();
        std::fs::set_permissions(at, std::fs::Permissions::from_mode(0o600)).unwrap();
    }

    #[test]
    fn with_one_session_too_many_the_longest_unused_of_the_same_visitor_ends() {
        let scratch = tempfile::tempdir().unwrap();
        let none = Tokens::read(None).unwrap();
        let sessions = sessions(scratch.path(), 2, HOUR, &none);
        let other = sessions.open(owner("b")).unwrap().0;
        let first = sessions.open(owner("a")).unwrap().0;
        let second = sessions.open(owner("a")).unwrap().0;
        assert!(sessions.holder(&first).is_some());
        let third = sessions.open(owner("a")).unwrap().0;
        assert!(sessions.holder(&second).is_none(), "it was used before the first");
        assert!([other, first, third].iter().all(|one| sessions.holder(one).is_some()));
    }

    #[test]
    fn a_session_ends_with_its_time_and_by_signing_out() {
        let scratch = tempfile::tempdir().unwrap();
        let none = Tokens::read(None).unwrap();
        let over = sessions(scratch.path(), 2, Duration::ZERO, &none);
        assert!(over.holder(&over.open(owner("a")).unwrap().0).is_none());
        let sessions = sessions(scratch.path(), 2, HOUR, &none);
        let secret = sessions.open(owner("a")).unwrap().0;
        assert!(sessions.close(&secret) && !sessions.close(&secret));
        assert!(sessions.holder(&secret).is_none());
    }

    #[test]
    fn a_session_outlives_the_daemon_and_no_secret_is_on_disk() {
        let scratch = tempfile::tempdir().unwrap();
        let none = Tokens::read(None).unwrap();
        let before = sessions(scratch.path(), 2, HOUR, &none);
        let (secret, _) = before.open(owner("a")).unwrap();
        let certified = Visitor { ground: Ground::Certificate, ..owner("c") };
        let (certified, _) = before.open(certified).unwrap();
        let file = scratch.path().join("genomd.sock.web");
        assert!(!std::fs::read_to_string(&file).unwrap().contains(&secret));
        assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
        drop(before);
        let after = sessions(scratch.path(), 2, HOUR, &none);
        assert_eq!(after.holder(&secret).unwrap().rights, [Right::Admin]);
        assert!(after.holder(&certified).is_none());
        // What others could have written is not believed.
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o666)).unwrap();
        assert!(sessions(scratch.path(), 2, HOUR, &none).holder(&secret).is_none());
    }

    #[test]
    fn a_session_has_the_rights_of_its_token_and_ends_with_it() {
        let scratch = tempfile::tempdir().unwrap();
        let file = scratch.path().join("tokens.toml");
        token_file(&file, "one", "[\"read\", \"call\"]");
        let tokens = Tokens::read(Some(&file)).unwrap();
        let holder = tokens.holder(format!("{:-<32}", "one").as_bytes()).unwrap();
        let sessions = sessions(scratch.path(), 2, HOUR, &tokens);
        let (secret, _) = sessions.open(Visitor::of(&holder, None, &tokens)).unwrap();
        assert_eq!(sessions.holder(&secret).unwrap().rights, [Right::Read, Right::Call]);
        token_file(&file, "one", "[\"read\"]");
        tokens.read_again().unwrap();
        assert_eq!(sessions.holder(&secret).unwrap().rights, [Right::Read]);
        token_file(&file, "another", "[\"read\"]");
        tokens.read_again().unwrap();
        assert!(sessions.holder(&secret).is_none(), "the token was replaced");
    }
}
