//! A session with a daemon behind the one at the socket, which relays messages without being able
//! to read or change them unnoticed.
//!
//! The daemon proves that it holds the token before anything is asked of it, and all requests and
//! answers are authenticated (`genom_proof`, `docs/security.md`). The token itself is never sent.

use std::sync::Arc;

use genom_proof::message::{self, Answer, Question, Request};
use genom_proof::{Greeting, HandshakeError, Session};
use genom_protocol::{Answers, AskParameters, Code, routes};
use hyper::Method;
use hyper::body::Bytes;
use tokio::sync::mpsc;

use crate::body::Body;
use crate::failure::Failure;
use crate::http::{self, Response};
use crate::patience::patiently;
use crate::target::Target;

/// Number of pieces of a stream that are fetched ahead of the reader.
const WAITING: usize = 4;

/// A session with a daemon that has proved itself.
pub(crate) struct Far {
    target: Arc<Target>,
    daemon: String,
    session: Session,
}

impl Far {
    /// Establishes a session with the one daemon of that name that holds the token.
    pub(crate) async fn meet(target: Arc<Target>, daemon: String) -> Result<Self, Failure> {
        let Some(token) = target.proof() else {
            return Err(Failure::refused_with(
                Code::Unauthorized.name(),
                format!("a token is needed here: daemon {daemon} asks who you are"),
                "--token-file FILE, of those that its own token file knows".to_owned(),
            ));
        };
        let greeting = Greeting::new(&token, &daemon)?;
        let hello = routes::hello(&daemon);
        let said: Bytes = greeting.message().into();
        let response = http::ask(&target, Method::POST, &hello.path, said, None).await?;
        let heard: Answers = serde_json::from_value(response.json(&target).await?)
            .map_err(|error| target.misread(error.to_string()))?;
        let answers: Vec<_> =
            heard.answers.into_iter().map(|one| (one.at, one.message.into_bytes())).collect();
        let session = greeting.meet(&answers).map_err(|error| {
            let code = match error {
                HandshakeError::Several { .. } => "several_daemons",
                HandshakeError::Impostor { .. } => "not_proved",
                _ => Code::DaemonSilent.name(),
            };
            Failure::refused(code, error.to_string())
        })?;
        Ok(Self { target, daemon, session })
    }

    async fn ask(
        &self,
        question: &Question,
        body: &[u8],
        waits: bool,
    ) -> Result<(Answer, Vec<u8>), Failure> {
        let (number, sealed) = self.session.seal(&message::encode(question, body));
        let query = AskParameters { at: self.session.at().to_owned(), wait: waits };
        let route = routes::question(&self.daemon).with(&query);
        let response =
            http::ask(&self.target, Method::POST, &route.path, sealed.into(), None).await?;
        if !response.is_success() {
            return Err(response.refusal(&self.target).await);
        }
        let bytes = response.body.whole().await?.ok_or_else(|| self.target.lost())?;
        let forged = |error: &dyn std::fmt::Display| {
            Failure::refused("not_proved", format!("{error}; ask again"))
        };
        let answer = self.session.open(number, &bytes).map_err(|error| forged(&error))?;
        let (answer, body) = message::decode::<Answer>(answer).map_err(|error| forged(&error))?;
        Ok((answer, body.to_vec()))
    }

    /// Waits for `work`, which may take long. The relaying daemon answers whatever happens to the
    /// other one, so the other one is checked, too.
    async fn while_it_answers<T>(
        &self,
        waiting: impl Future<Output = Result<T, Failure>>,
    ) -> Result<T, Failure> {
        let about = Question::Request(Request {
            method: Method::GET.to_string(),
            path: routes::about().path,
            last_event_id: None,
        });
        let about = &about;
        let ask = || async move { self.ask(about, &[], false).await.map(drop) };
        let silent = || self.target.silent(None);
        patiently(self.target.limit, waiting, ask, silent).await?
    }

    /// Makes a request as over HTTP.
    pub(crate) async fn request(
        self: &Arc<Self>,
        method: Method,
        path: &str,
        body: &[u8],
        after: Option<u64>,
    ) -> Result<Response, Failure> {
        let waits = path.contains("wait=") || path == routes::dump().path;
        let question = Question::Request(Request {
            method: method.to_string(),
            path: path.to_owned(),
            last_event_id: after.map(|number| number.to_string()),
        });
        let asked = self.ask(&question, body, waits);
        let (answer, body) =
            if waits { self.while_it_answers(asked).await? } else { asked.await? };
        let body = match answer.stream {
            None => Body::Whole(Some(body.into())),
            Some(stream) => {
                let (sender, pieces) = mpsc::channel(WAITING);
                tokio::spawn(Arc::clone(self).fetch(stream, sender));
                Body::Far(pieces)
            }
        };
        Ok(Response { status: answer.status, body })
    }

    /// Fetches a stream as long as it is read. If this program ends without closing it, the daemon
    /// does so when nobody has fetched for some time.
    async fn fetch(self: Arc<Self>, stream: u64, reader: mpsc::Sender<Result<Bytes, Failure>>) {
        loop {
            let more = Question::More(stream);
            let (answer, piece) = match self.ask(&more, &[], false).await {
                Ok(more) => more,
                // The relaying daemon does not answer. If the other daemon is gone, the stream ends
                // instead.
                Err(failure @ Failure::Silent { .. }) => {
                    let _ = reader.send(Err(failure)).await;
                    return;
                }
                Err(_) => return,
            };
            let gone = !piece.is_empty() && reader.send(Ok(piece.into())).await.is_err();
            if answer.stream.is_none() {
                return;
            }
            if gone || reader.is_closed() {
                let _ = self.ask(&Question::End(stream), &[], false).await;
                return;
            }
        }
    }
}
