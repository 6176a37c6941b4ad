//! Takes the messages to this daemon that come by a middleware.

use std::sync::Arc;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{Request, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use genom_middleware::{AnnounceError, Middleware};
use genom_proof::message::{self, Answer, FromDaemon, Question, ToDaemon};
use genom_protocol::Code;
use hyper::body::Body as _;
use hyper::service::Service as _;
use hyper_util::service::TowerToHyperService;

use super::sessions::{Admitted, Refused, Sessions};
use crate::daemon::Daemon;
use crate::rpc::error::RpcError;
use crate::rpc::seldom::Seldom;
use crate::rpc::tokens::Tokens;

/// Greatest answer that is sent.
const MOST: usize = 16 << 20;

/// What a question is longer than what it asks.
const AROUND: usize = 4 << 10;

/// What messages to this daemon are answered by.
struct Desk {
    sessions: Sessions,
    router: Router,
    /// Greatest message that is looked at.
    most: usize,
    refused: Seldom,
    /// The middleware, for the log.
    backend: &'static str,
}

/// Shows this daemon on a middleware that passes requests on, and answers those to it by `router`.
pub(crate) fn announce(
    daemon: &Arc<Daemon>,
    router: &Router,
    tokens: &Arc<Tokens>,
    runtime: &tokio::runtime::Handle,
    middleware: &dyn Middleware,
) {
    let Some(relay) = middleware.relay() else { return };
    let mut refused = None;
    for name in names(daemon) {
        let sessions = match Sessions::new(Arc::clone(tokens), &name, relay.own()) {
            Ok(sessions) => sessions,
            Err(error) => return tracing::warn!("this daemon is not reachable there: {error}"),
        };
        let desk = Arc::new(Desk {
            sessions,
            router: router.clone(),
            most: daemon.rpc.max_body + AROUND,
            refused: Seldom::default(),
            backend: middleware.name(),
        });
        let runtime = runtime.clone();
        let requests = move |bytes: Vec<u8>, answer: Box<dyn FnOnce(Vec<u8>) + Send>| {
            // Here, at once: what is not admitted costs no task.
            let asked = match desk.admit(&bytes) {
                Ok(asked) => asked,
                Err(told) => return answer(told),
            };
            let desk = Arc::clone(&desk);
            runtime.spawn(async move {
                answer(desk.reply(&asked, &bytes).await);
            });
        };
        match relay.announce(&name, Box::new(requests)) {
            Ok(announcement) => {
                if let Some(error) = refused {
                    tracing::warn!("{error}; this one is `{name}` there");
                }
                return daemon.announcements.keep(name, announcement);
            }
            // Another daemon has that name: the next one is this daemon's alone.
            Err(error @ AnnounceError::Taken { .. }) => refused = Some(error),
            Err(error) => return tracing::warn!("{error}"),
        }
    }
    if let Some(error) = refused {
        tracing::warn!("{error}; this one is not reachable there");
    }
}

/// What this daemon may be called: as it was started, else by its machine.
fn names(daemon: &Daemon) -> Vec<String> {
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let name = daemon.name.clone().unwrap_or_else(|| host.trim().to_owned());
    let name = if name.is_empty() { "genomd".to_owned() } else { name };
    vec![name.clone(), format!("{name}-{}", std::process::id())]
}

fn refusal(code: Code, message: String) -> Vec<u8> {
    message::encode(&FromDaemon::Refused { code: code.to_string(), message }, &[])
}

impl Desk {
    fn log(&self, why: &str) {
        let backend = self.backend;
        self.refused.tell(why.to_owned(), |more| {
            tracing::warn!("refused a request that came over {backend}: {why}{more}");
        });
    }

    /// Who asks; or the answer, when there is no more to it.
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

    /// The sealed answer to a question that was admitted.
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

/// The answer with its body, or with the number by which that is asked for.
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
        request = request.header("last-event-id", number);
    }
    request.body(Body::from(body.to_vec()))
}
