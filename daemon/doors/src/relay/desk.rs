//! Handles requests that arrive as messages.

use std::fmt;
use std::io;
use std::sync::Arc;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{Request, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use genom_proof::message::{self, Answer, FromDaemon, Question, ToDaemon};
use genom_protocol::Code;
use genom_protocol::sse::LAST_EVENT_ID;
use hyper::body::Body as _;
use hyper::service::Service as _;
use hyper_util::service::TowerToHyperService;
use tokio::runtime::Handle;

use super::sessions::{Admitted, Refused, Sessions};
use crate::error::RpcError;
use crate::seldom::Seldom;
use crate::tokens::Tokens;

/// Maximum size of an answer, in bytes.
const MOST: usize = 16 << 20;

/// Maximum number of bytes of a question besides the body of its request.
const AROUND: usize = 4 << 10;

/// Passes messages to a router once their senders have proved their identity, and returns the
/// answers.
///
/// Streams are kept here, to be asked for piece by piece.
pub struct Desk {
    sessions: Sessions,
    router: Router,
    /// Maximum size of a message that is processed, in bytes.
    most: usize,
    refused: Seldom,
    /// Name of the transport of the messages, for the log.
    way: &'static str,
}

impl fmt::Debug for Desk {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Desk").field("way", &self.way).finish_non_exhaustive()
    }
}

fn refusal(code: Code, message: String) -> Vec<u8> {
    message::encode(&FromDaemon::Refused { code: code.to_string(), message }, &[])
}

impl Desk {
    /// A desk with this name, at the endpoint of the transport that `at` tells. `router` is behind
    /// [`Door::proved`](crate::access::Door::proved), and takes bodies of at most `max_body` bytes.
    ///
    /// # Errors
    /// The system provides no random bytes.
    pub fn new(
        tokens: &Arc<Tokens>,
        name: &str,
        at: impl Fn() -> String + Send + Sync + 'static,
        way: &'static str,
        router: Router,
        max_body: usize,
    ) -> io::Result<Arc<Self>> {
        let sessions = Sessions::new(Arc::clone(tokens), name, Box::new(at))?;
        let (most, refused) = (max_body + AROUND, Seldom::default());
        Ok(Arc::new(Self { sessions, router, most, refused, way }))
    }

    /// Handles a message; calls back with the answer, at once or later.
    pub fn take(
        self: &Arc<Self>,
        runtime: &Handle,
        bytes: Vec<u8>,
        answer: impl FnOnce(Vec<u8>) + Send + 'static,
    ) {
        // Checked here, so that a message that is not admitted costs no task.
        let asked = match self.admit(&bytes) {
            Ok(asked) => asked,
            Err(told) => return answer(told),
        };
        let desk = Arc::clone(self);
        runtime.spawn(async move {
            answer(desk.reply(&asked, &bytes).await);
        });
    }

    fn log(&self, why: &str) {
        let way = self.way;
        self.refused.tell(why.to_owned(), |more| {
            tracing::warn!("refused a request that came over {way}: {why}{more}");
        });
    }

    /// Admits a question; otherwise returns the complete answer.
    fn admit(&self, bytes: &[u8]) -> Result<Admitted, Vec<u8>> {
        if bytes.len() > self.most {
            return Err(refusal(Code::TooLarge, "the request is too large".to_owned()));
        }
        let read = message::decode::<ToDaemon>(bytes);
        let (head, body) = read.map_err(|_| {
            self.log("a message that is none of a client of this version");
            let message = "this daemon asks for a proof that its client holds a token: use the \
                           genomctl or the Python client of its version";
            refusal(Code::Malformed, message.to_owned())
        })?;
        let told = |refused: Refused| {
            self.log(&refused.to_string());
            refusal(refused.code(), refused.to_string())
        };
        match head {
            ToDaemon::Hello(hello) => Err(match self.sessions.greet(&hello) {
                Ok(answer) => message::encode(&answer, &[]),
                Err(refused) => told(refused),
            }),
            ToDaemon::Sealed(head) => self.sessions.admit(&head, body).map_err(told),
        }
    }

    /// The sealed answer to an admitted question.
    async fn reply(&self, asked: &Admitted, bytes: &[u8]) -> Vec<u8> {
        let body = message::decode::<ToDaemon>(bytes).map(|(_, body)| body).unwrap_or_default();
        let (head, body) = self.answer(asked, body).await;
        asked.seal(&message::encode(&head, &body))
    }

    async fn answer(&self, asked: &Admitted, bytes: &[u8]) -> (Answer, Vec<u8>) {
        let refused = |why: String| RpcError::new(StatusCode::BAD_REQUEST, Code::Malformed, why);
        let streams = &asked.session.streams;
        let response = match message::decode(bytes) {
            Err(error) => refused(error.to_string()).into_response(),
            Ok((Question::More(stream), _)) => {
                let (piece, more) = streams.more(stream).await;
                let stream = more.then_some(stream);
                return (Answer { status: 200, stream, ..Answer::default() }, piece);
            }
            Ok((Question::End(stream), _)) => {
                streams.end(stream);
                return (Answer { status: 200, ..Answer::default() }, Vec::new());
            }
            Ok((Question::Request(passed), body)) => match request(passed, body) {
                Err(error) => refused(error.to_string()).into_response(),
                Ok(mut request) => {
                    request.extensions_mut().insert(asked.holder.clone());
                    match TowerToHyperService::new(self.router.clone()).call(request).await {
                        Ok(response) => response,
                        Err(never) => match never {},
                    }
                }
            },
        };
        whole(asked, response).await
    }
}

/// The answer with its body or, for a stream, with the number to ask for more.
async fn whole(asked: &Admitted, response: Response) -> (Answer, Vec<u8>) {
    let kind = response.headers().get(header::CONTENT_TYPE);
    let content_type = kind.and_then(|kind| kind.to_str().ok()).unwrap_or_default().to_owned();
    let status = response.status().as_u16();
    let body = response.into_body();
    if body.size_hint().exact().is_none() {
        asked.session.streams.add(asked.number, body);
        return (Answer { status, content_type, stream: Some(asked.number) }, Vec::new());
    }
    match to_bytes(body, MOST).await {
        Ok(body) => (Answer { status, content_type, stream: None }, body.to_vec()),
        Err(error) => {
            let content_type = "text/plain".to_owned();
            let status = StatusCode::BAD_GATEWAY.as_u16();
            (Answer { status, content_type, stream: None }, error.to_string().into_bytes())
        }
    }
}

fn request(passed: message::Request, body: &[u8]) -> Result<Request<Body>, axum::http::Error> {
    let mut request = Request::builder().method(passed.method.as_str()).uri(passed.path);
    if let Some(number) = passed.last_event_id {
        request = request.header(LAST_EVENT_ID, number);
    }
    request.body(Body::from(body.to_vec()))
}
