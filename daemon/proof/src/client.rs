//! The client's side: finds the one daemon of a name that holds the token, then talks to that
//! daemon only.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::hex::Bytes;
use crate::key::{HINT, Handshake, Keys, NONCE, Token, random};
use crate::message::{FromDaemon, Hello, SealedQuestion, ToDaemon, decode, encode};

/// A hello that has not been answered yet.
#[derive(Debug)]
pub struct Greeting {
    token: Token,
    daemon: String,
    nonce: [u8; NONCE],
}

/// Why no session was established. Nothing but the hello was sent.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum HandshakeError {
    /// No daemon answered.
    #[error("daemon `{0}` does not answer: its process may be stopped, or have gone just now")]
    Silent(String),
    /// One daemon answered, but did not prove that it holds the token.
    #[error(
        "what answers to the name `{daemon}` ({at}) {why}: it is another daemon, or your token is \
         not in its token file; nothing was asked of it"
    )]
    Impostor {
        /// The name that was asked for.
        daemon: String,
        /// Identity of the answering endpoint on the middleware.
        at: String,
        /// What was wrong with its answer.
        why: Doubt,
    },
    /// Several daemons answered to one name.
    #[error(
        "{} answer to the name `{daemon}`: {}; nothing was asked of them: stop all but one, or \
         start each with a name of its own, `--daemon NAME`", .each.len(), .each.join("; ")
    )]
    Several {
        /// The name that was asked for.
        daemon: String,
        /// Identities of the answering endpoints, each with the result of its check.
        each: Vec<String>,
    },
}

/// Why no session was established from an answer; printed after the name of its sender.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Doubt {
    /// It is not a message of this protocol, or not the expected one.
    #[error("sends what is no answer of a genomd of this version")]
    NotUnderstood,
    /// The daemon reports that it does not hold the token.
    #[error("does not know your token")]
    NoToken,
    /// The proof is not valid.
    #[error("does not prove that it holds your token")]
    NoProof,
    /// The proof is valid, but of a daemon at another endpoint.
    #[error("passes on what daemon {0} says")]
    PassedOn(String),
}

/// An answer that was not sent by the daemon of the session.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Forged {
    /// The authentication code is wrong or missing.
    #[error("somebody changed the answer of daemon `{0}` on its way, or made one up")]
    Code(String),
    /// A refusal. It carries no authentication code, so that it may come from anybody.
    #[error("daemon `{daemon}` is said to refuse: {message}")]
    Refused {
        /// The name that was asked for.
        daemon: String,
        /// The message of the refusal.
        message: String,
    },
}

impl Greeting {
    /// A hello to the daemons called `daemon`.
    ///
    /// # Errors
    /// The operating system provides no random bytes.
    pub fn new(token: &Token, daemon: &str) -> std::io::Result<Self> {
        Ok(Self { token: token.clone(), daemon: daemon.to_owned(), nonce: random()? })
    }

    /// The hello, as bytes to send.
    #[must_use]
    pub fn message(&self) -> Vec<u8> {
        let (nonce, hint) = (Bytes(self.nonce), self.token.hint(&self.nonce));
        let daemon = self.daemon.clone();
        encode(&ToDaemon::Hello(Hello { daemon, nonce, hint }), &[])
    }

    /// Establishes the session. `answers` are all answers that arrived, each with the identity of
    /// the endpoint that sent it.
    ///
    /// # Errors
    /// No answer, several answers, or an answer without a valid proof that its sender holds the
    /// token.
    pub fn meet(self, answers: &[(String, Vec<u8>)]) -> Result<Session, HandshakeError> {
        let daemon = self.daemon.clone();
        let mut met = answers.iter().map(|(from, bytes)| (from, self.examine(from, bytes)));
        match (met.next(), met.next()) {
            (None, _) => Err(HandshakeError::Silent(daemon)),
            (Some((_, Ok(session))), None) => Ok(session),
            (Some((at, Err(why))), None) => {
                Err(HandshakeError::Impostor { daemon, at: at.clone(), why })
            }
            (Some(first), Some(second)) => {
                let all = [first, second].into_iter().chain(met);
                let each = all.map(|(at, met)| match met {
                    Ok(_) => format!("{at}, which holds your token"),
                    Err(why) => format!("{at}, which {why}"),
                });
                Err(HandshakeError::Several { daemon, each: each.collect() })
            }
        }
    }

    /// Checks one answer.
    fn examine(&self, from: &str, bytes: &[u8]) -> Result<Session, Doubt> {
        let (head, _) = decode::<FromDaemon>(bytes).map_err(|_| Doubt::NotUnderstood)?;
        let (at, cookie, proof) = match head {
            FromDaemon::Hello { at, cookie, proof } => (at, cookie.0, proof),
            FromDaemon::Refused { .. } => return Err(Doubt::NoToken),
            FromDaemon::Sealed { .. } => return Err(Doubt::NotUnderstood),
        };
        let handshake =
            Handshake { daemon: &self.daemon, at: &at, nonce: &self.nonce, cookie: &cookie };
        let keys = self.token.keys(&handshake);
        if !keys.proves(&proof) {
            return Err(Doubt::NoProof);
        }
        if at != from {
            return Err(Doubt::PassedOn(at));
        }
        Ok(Session {
            daemon: self.daemon.clone(),
            at,
            nonce: self.nonce,
            hint: self.token.hint(&self.nonce),
            cookie,
            keys,
            asked: AtomicU64::new(0),
        })
    }
}

/// A session with a daemon that has proved that it holds the token. May be used by several threads.
#[derive(Debug)]
pub struct Session {
    daemon: String,
    at: String,
    nonce: [u8; NONCE],
    hint: Bytes<HINT>,
    cookie: [u8; NONCE],
    keys: Keys,
    /// Number of the last question.
    asked: AtomicU64,
}

impl Session {
    /// Identity of the daemon's endpoint on the middleware, to which questions are sent.
    #[must_use]
    pub fn at(&self) -> &str {
        &self.at
    }

    /// Seals a question. Returns its number and the bytes to send.
    pub fn seal(&self, question: &[u8]) -> (u64, Vec<u8>) {
        let number = self.asked.fetch_add(1, Ordering::Relaxed) + 1;
        let head = ToDaemon::Sealed(SealedQuestion {
            nonce: Bytes(self.nonce),
            hint: self.hint,
            cookie: Bytes(self.cookie),
            number,
            mac: self.keys.request(number, question),
        });
        (number, encode(&head, question))
    }

    /// Checks the answer to question `number`, and returns its content.
    ///
    /// # Errors
    /// The answer was not sent by the daemon of this session, or it is a refusal.
    pub fn open<'a>(&self, number: u64, bytes: &'a [u8]) -> Result<&'a [u8], Forged> {
        let forged = || Forged::Code(self.daemon.clone());
        let (head, answer) = decode::<FromDaemon>(bytes).map_err(|_| forged())?;
        match head {
            FromDaemon::Sealed { mac } if self.keys.is_answer(number, answer, &mac) => Ok(answer),
            FromDaemon::Refused { message, .. } => {
                Err(Forged::Refused { daemon: self.daemon.clone(), message })
            }
            _ => Err(forged()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "0123456789abcdef0123456789abcdef";

    /// The answer of a daemon that holds the token `text`.
    fn answer(hello: &[u8], text: &str, name: &str, at: &str) -> Vec<u8> {
        let (head, _) = decode::<ToDaemon>(hello).unwrap();
        let ToDaemon::Hello(hello) = head else { panic!("no hello") };
        let cookie = [9; NONCE];
        let of = Handshake { daemon: name, at, nonce: &hello.nonce.0, cookie: &cookie };
        let proof = Token::new(text).keys(&of).proof();
        encode(&FromDaemon::Hello { at: at.to_owned(), cookie: Bytes(cookie), proof }, &[])
    }

    fn greeting() -> Greeting {
        Greeting::new(&Token::new(TEXT), "robot").unwrap()
    }

    fn refused(answers: impl FnOnce(&[u8]) -> Vec<(&'static str, Vec<u8>)>) -> String {
        let greeting = greeting();
        let answers = answers(&greeting.message());
        let answers: Vec<_> = answers.into_iter().map(|(at, all)| (at.to_owned(), all)).collect();
        greeting.meet(&answers).unwrap_err().to_string()
    }

    #[test]
    fn a_hello_holds_nothing_of_the_token() {
        let hello = String::from_utf8(greeting().message()).unwrap();
        assert!(!hello.contains(&TEXT[..8]), "{hello}");
        // Nor can two hellos be linked to one token.
        let other = String::from_utf8(greeting().message()).unwrap();
        let hint = |text: &str| text.split("hint").nth(1).unwrap().to_owned();
        assert_ne!(hint(&hello), hint(&other));
    }

    #[test]
    fn only_who_holds_the_token_and_has_the_name_is_believed() {
        let greeting = greeting();
        let good = answer(&greeting.message(), TEXT, "robot", "1f");
        assert_eq!(greeting.meet(&[("1f".to_owned(), good)]).unwrap().at(), "1f");
        let other = "00000000000000000000000000000000";
        let told = refused(|hello| vec![("1f", answer(hello, other, "robot", "1f"))]);
        assert!(told.contains("(1f) does not prove"), "{told}");
        let told = refused(|hello| vec![("1f", answer(hello, TEXT, "arm", "1f"))]);
        assert!(told.contains("does not prove"), "{told}");
        // The answer of the real daemon, passed on by another endpoint.
        let told = refused(|hello| vec![("66", answer(hello, TEXT, "robot", "1f"))]);
        assert!(told.contains("(66) passes on what daemon 1f says"), "{told}");
        let told = refused(|_| vec![("66", b"{}\n".to_vec())]);
        assert!(told.contains("no answer of a genomd"), "{told}");
        assert!(refused(|_| Vec::new()).contains("does not answer"));
    }

    #[test]
    fn two_of_one_name_are_both_named_whatever_they_prove() {
        for (other, what) in [(TEXT, "holds your token"), ("x", "does not prove")] {
            let told = refused(|hello| {
                vec![
                    ("1f", answer(hello, TEXT, "robot", "1f")),
                    ("66", answer(hello, other, "robot", "66")),
                ]
            });
            assert!(told.starts_with("2 answer to the name `robot`: 1f, which holds"), "{told}");
            assert!(told.contains(&format!("66, which {what}")), "{told}");
        }
    }

    #[test]
    fn answers_are_believed_once_unchanged_and_to_their_question() {
        let greeting = greeting();
        let good = answer(&greeting.message(), TEXT, "robot", "1f");
        let session = greeting.meet(&[("1f".to_owned(), good)]).unwrap();
        let ((first, one), (second, two)) = (session.seal(b"one"), session.seal(b"one"));
        assert_ne!(one, two);
        let sealed = |number: u64, text: &[u8]| {
            encode(&FromDaemon::Sealed { mac: session.keys.answer(number, text) }, text)
        };
        assert_eq!(session.open(first, &sealed(first, b"yes")).unwrap(), b"yes");
        assert!(session.open(second, &sealed(first, b"yes")).is_err());
        let mut changed = sealed(second, b"yes");
        *changed.last_mut().unwrap() ^= 1;
        assert!(session.open(second, &changed).is_err());
        assert!(session.open(second, b"").is_err());
    }
}
