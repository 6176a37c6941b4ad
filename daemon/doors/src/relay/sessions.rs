//! Sessions with clients of other daemons that proved that they hold a token.
//!
//! A hello needs no memory: the cookie in its answer contains its date, and only this daemon can
//! create it. A session begins with the first question whose code is valid.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use genom_proof::message::{FromDaemon, Hello, SealedQuestion};
use genom_proof::{Bytes, Handshake, Keys, NONCE, Token, Window, random};
use genom_protocol::Code;

use super::streams::Streams;
use crate::holder::Holder;
use crate::tokens::{Known, Tokens};

/// Maximum age of a cookie to begin a session. Sessions are kept for longer than that, so that no
/// cookie begins two.
const FRESH: Duration = Duration::from_secs(10);

/// Maximum number of sessions of one token; beyond that, those idle longest are dropped.
const MOST: usize = 256;

/// Idle time after which a session is dropped. Clients begin a new one before that.
const IDLE: Duration = Duration::from_secs(600);

/// Maximum number of questions of one session under way.
const AT_A_TIME: usize = 64;

/// Why a message is refused. These reasons are sent to senders that have proved nothing yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Refused {
    /// A hello whose token is unknown.
    #[error("this token is not known here")]
    Token,
    /// A hello to another daemon.
    #[error("this daemon has another name")]
    Name,
    /// A question in an unknown or expired session.
    #[error("this session is over: the daemon was restarted, or nothing was asked for long")]
    Session,
    /// A wrong code.
    #[error("the request was changed on its way")]
    Code,
    /// A question that arrived before.
    #[error("this request came before")]
    Replayed,
    /// Too many sessions or questions of this token.
    #[error("too much of this token is under way: wait for answers")]
    Busy,
    /// The system provides no random bytes.
    #[error("the daemon has no random numbers")]
    Random,
}

impl Refused {
    /// Stable name of the reason.
    pub(super) fn code(self) -> Code {
        match self {
            Self::Token => Code::Unauthorized,
            Self::Name => Code::NoSuchDaemon,
            Self::Session => Code::SessionOver,
            Self::Code => Code::Changed,
            Self::Replayed => Code::Replayed,
            Self::Busy => Code::Busy,
            Self::Random => Code::Internal,
        }
    }
}

/// A session with a client that proved that it holds a token.
pub(super) struct Session {
    /// Name of the token, to count its sessions.
    token: String,
    /// The token itself, because another one may have the same name later.
    key: Token,
    keys: Keys,
    state: Mutex<State>,
    /// Its streams, which other sessions cannot access.
    pub(super) streams: Arc<Streams>,
    born: Instant,
}

struct State {
    window: Window,
    used: Instant,
    holder: Holder,
    /// Generation of the token file when the holder was looked up.
    generation: u64,
}

/// An authenticated question; its session is not dropped meanwhile.
pub(super) struct Admitted {
    pub(super) session: Arc<Session>,
    pub(super) holder: Holder,
    pub(super) number: u64,
}

impl Admitted {
    /// Seals the answer.
    pub(super) fn seal(&self, answer: &[u8]) -> Vec<u8> {
        let mac = self.session.keys.answer(self.number, answer);
        genom_proof::message::encode(&FromDaemon::Sealed { mac }, answer)
    }
}

/// Tells the identity of an endpoint, which changes when the middleware is opened anew.
pub(super) type At = Box<dyn Fn() -> String + Send + Sync>;

/// The sessions of this daemon on one middleware, under one name.
pub(super) struct Sessions {
    tokens: Arc<Tokens>,
    name: String,
    at: At,
    /// Key of the cookies' signatures.
    secret: Token,
    begin: Instant,
    open: Mutex<HashMap<[u8; NONCE], Arc<Session>>>,
}

impl Sessions {
    /// No sessions. `at` tells the identity of this daemon's endpoint on the middleware.
    pub(super) fn new(tokens: Arc<Tokens>, name: &str, at: At) -> std::io::Result<Self> {
        Ok(Self {
            tokens,
            name: name.to_owned(),
            at,
            secret: Token::new(&Bytes(random::<32>()?).to_string()),
            begin: Instant::now(),
            open: Mutex::default(),
        })
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<[u8; NONCE], Arc<Session>>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Answers a hello, and proves that this daemon holds the token.
    pub(super) fn greet(&self, hello: &Hello) -> Result<FromDaemon, Refused> {
        // Never for another name: a client that asks for that one would be deceived.
        if hello.daemon != self.name {
            return Err(Refused::Name);
        }
        let nonce = hello.nonce.0;
        let known = self.tokens.hinted(&nonce, &hello.hint).ok_or(Refused::Token)?;
        let mut cookie = [0; NONCE];
        let (time, rest) = cookie.split_at_mut(8);
        time.copy_from_slice(&self.now().to_be_bytes());
        let (salt, _) = rest.split_at_mut(8);
        salt.copy_from_slice(&random::<8>().map_err(|_| Refused::Random)?);
        self.sign(&mut cookie, &nonce);
        let at = (self.at)();
        let keys = known.key.keys(&self.handshake(&at, &nonce, &cookie));
        Ok(FromDaemon::Hello { at, cookie: Bytes(cookie), proof: keys.proof() })
    }

    fn handshake<'a>(
        &'a self,
        at: &'a str,
        nonce: &'a [u8; NONCE],
        cookie: &'a [u8; NONCE],
    ) -> Handshake<'a> {
        Handshake { daemon: &self.name, at, nonce, cookie }
    }

    /// Milliseconds since this daemon started.
    fn now(&self) -> u64 {
        u64::try_from(self.begin.elapsed().as_millis()).unwrap_or(u64::MAX)
    }

    /// Writes the signature in the second half of a cookie.
    fn sign(&self, cookie: &mut [u8; NONCE], nonce: &[u8; NONCE]) {
        let mut first = *cookie;
        first[16..].fill(0);
        let of = Handshake { daemon: "cookie", at: "", nonce, cookie: &first };
        let code = self.secret.keys(&of).proof().0;
        cookie[16..].copy_from_slice(&code[..16]);
    }

    /// Whether this daemon recently issued that cookie for that nonce.
    fn fresh(&self, cookie: &[u8; NONCE], nonce: &[u8; NONCE]) -> bool {
        let mut signed = *cookie;
        self.sign(&mut signed, nonce);
        let genuine: bool = subtle::ConstantTimeEq::ct_eq(&signed[..], &cookie[..]).into();
        let mut time = [0; 8];
        time.copy_from_slice(&cookie[..8]);
        let age = self.now().checked_sub(u64::from_be_bytes(time));
        genuine && age.is_some_and(|age| Duration::from_millis(age) < FRESH)
    }

    /// Finds or begins the session of a question, and marks the question's number as used.
    pub(super) fn admit(&self, head: &SealedQuestion, body: &[u8]) -> Result<Admitted, Refused> {
        let found = self.lock().get(&head.cookie.0).cloned();
        let session = match found {
            Some(session) => session,
            None => self.begun(head, body)?,
        };
        if !session.keys.is_request(head.number, body, &head.mac) {
            return Err(Refused::Code);
        }
        // References: one in the map, one here, and one per question under way.
        if Arc::strong_count(&session) > AT_A_TIME + 2 {
            return Err(Refused::Busy);
        }
        let mut state = session.state.lock().unwrap_or_else(PoisonError::into_inner);
        if !state.window.take(head.number) {
            return Err(Refused::Replayed);
        }
        state.used = Instant::now();
        let generation = self.tokens.generation();
        if state.generation != generation {
            // The token file was read again: the token may have other rights, or be gone.
            let Some(Known { holder, .. }) = self.tokens.same(&session.key) else {
                // Released first: elsewhere the map is locked before the state.
                drop(state);
                self.lock().remove(&head.cookie.0);
                return Err(Refused::Token);
            };
            state.holder = holder;
            state.generation = generation;
        }
        let holder = state.holder.clone();
        drop(state);
        Ok(Admitted { session, holder, number: head.number })
    }

    /// Begins a session with this question.
    fn begun(&self, head: &SealedQuestion, body: &[u8]) -> Result<Arc<Session>, Refused> {
        let (nonce, cookie) = (&head.nonce.0, &head.cookie.0);
        if !self.fresh(cookie, nonce) {
            return Err(Refused::Session);
        }
        let generation = self.tokens.generation();
        let known = self.tokens.hinted(nonce, &head.hint).ok_or(Refused::Token)?;
        let keys = known.key.keys(&self.handshake(&(self.at)(), nonce, cookie));
        // Checked before anything is stored.
        if !keys.is_request(head.number, body, &head.mac) {
            return Err(Refused::Code);
        }
        let now = Instant::now();
        let mut open = self.lock();
        if let Some(session) = open.get(cookie) {
            return Ok(Arc::clone(session));
        }
        make_room(&mut open, &known.holder.who, now)?;
        let session = Arc::new(Session {
            token: known.holder.who.clone(),
            key: known.key,
            keys,
            state: Mutex::new(State {
                window: Window::default(),
                used: now,
                holder: known.holder,
                generation,
            }),
            streams: Arc::default(),
            born: now,
        });
        open.insert(*cookie, Arc::clone(&session));
        Ok(session)
    }
}

/// Drops idle sessions; fails if all sessions of this token are in use.
fn make_room(
    open: &mut HashMap<[u8; NONCE], Arc<Session>>,
    token: &str,
    now: Instant,
) -> Result<(), Refused> {
    let used =
        |session: &Session| session.state.lock().unwrap_or_else(PoisonError::into_inner).used;
    open.retain(|_, session| {
        Arc::strong_count(session) > 1 || now.duration_since(used(session)) < IDLE
    });
    let of_token = open.values().filter(|session| session.token == token).count();
    if of_token < MOST {
        return Ok(());
    }
    let idle = open.iter().filter(|(_, session)| {
        session.token == token
            && Arc::strong_count(session) == 1
            && now.duration_since(session.born) >= FRESH
    });
    let oldest = idle.min_by_key(|(_, session)| used(session)).map(|(cookie, _)| *cookie);
    open.remove(&oldest.ok_or(Refused::Busy)?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_proof::message::{ToDaemon, decode, encode};
    use genom_proof::{Greeting, Session as Client};

    const TEXT: &str = "0123456789abcdef0123456789abcdef";

    fn sessions(text: &str) -> Sessions {
        Sessions::new(Tokens::of("dashboard", text), "robot", Box::new(|| "1f".to_owned())).unwrap()
    }

    fn hello(message: &[u8]) -> Hello {
        match decode::<ToDaemon>(message).unwrap().0 {
            ToDaemon::Hello(hello) => hello,
            ToDaemon::Sealed(_) => panic!("no hello"),
        }
    }

    fn met(sessions: &Sessions) -> Client {
        let greeting = Greeting::new(&Token::new(TEXT), "robot").unwrap();
        let answer = sessions.greet(&hello(&greeting.message())).unwrap();
        greeting.meet(&[("1f".to_owned(), encode(&answer, &[]))]).unwrap()
    }

    fn admit(sessions: &Sessions, message: &[u8]) -> Result<Admitted, Refused> {
        let (head, body) = decode::<ToDaemon>(message).unwrap();
        match head {
            ToDaemon::Sealed(head) => sessions.admit(&head, body),
            ToDaemon::Hello(_) => panic!("no question"),
        }
    }

    fn refused(sessions: &Sessions, message: &[u8]) -> Refused {
        admit(sessions, message).err().expect("it is refused")
    }

    #[test]
    fn a_question_is_good_once_and_unchanged() {
        let sessions = sessions(TEXT);
        let client = met(&sessions);
        assert!(sessions.lock().is_empty(), "a hello costs no memory");
        let (number, first) = client.seal(b"one");
        let admitted = admit(&sessions, &first).unwrap_or_else(|_| panic!("it is admitted"));
        assert_eq!(admitted.holder.who, "token dashboard");
        assert_eq!(client.open(number, &admitted.seal(b"yes")).unwrap(), b"yes");
        assert_eq!(refused(&sessions, &first), Refused::Replayed);
        let (_, mut second) = client.seal(b"two");
        *second.last_mut().unwrap() ^= 1;
        assert_eq!(refused(&sessions, &second), Refused::Code);
        *second.last_mut().unwrap() ^= 1;
        assert!(admit(&sessions, &second).is_ok());
        // Another daemon with the same token refuses it.
        assert_eq!(refused(&super::tests::sessions(TEXT), &client.seal(b"x").1), Refused::Session);
    }

    #[test]
    fn the_first_question_does_not_begin_a_session_twice() {
        let sessions = sessions(TEXT);
        let (_, first) = met(&sessions).seal(b"start the motor");
        assert!(admit(&sessions, &first).is_ok());
        // Its cookie has expired before the session is dropped.
        let (head, _) = decode::<ToDaemon>(&first).unwrap();
        let ToDaemon::Sealed(head) = head else { panic!() };
        let full =
            || (0..MOST).filter_map(|_| admit(&sessions, &met(&sessions).seal(b"x").1).err());
        assert_eq!(full().last(), Some(Refused::Busy));
        assert!(sessions.lock().contains_key(&head.cookie.0));
        assert_eq!(refused(&sessions, &first), Refused::Replayed);
    }

    #[test]
    fn who_has_another_token_or_means_another_daemon_learns_nothing() {
        let sessions = sessions("00000000000000000000000000000000");
        let greeting = |name| Greeting::new(&Token::new(TEXT), name).unwrap().message();
        let refused = |name| sessions.greet(&hello(&greeting(name))).err().unwrap();
        assert_eq!(refused("robot"), Refused::Token);
        assert_eq!(refused("arm"), Refused::Name);
    }

    #[test]
    fn a_made_up_cookie_begins_nothing() {
        let sessions = sessions(TEXT);
        let greeting = Greeting::new(&Token::new(TEXT), "robot").unwrap();
        let nonce = hello(&greeting.message()).nonce.0;
        let cookie = [0; NONCE];
        let of = Handshake { daemon: "robot", at: "1f", nonce: &nonce, cookie: &cookie };
        let proof = Token::new(TEXT).keys(&of).proof();
        let answer = FromDaemon::Hello { at: "1f".into(), cookie: Bytes(cookie), proof };
        let client = greeting.meet(&[("1f".to_owned(), encode(&answer, &[]))]).unwrap();
        assert_eq!(self::refused(&sessions, &client.seal(b"x").1), Refused::Session);
    }
}
