//! The calling end of a service: one query per request.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use genom_middleware::describe::types_of_service;
use genom_middleware::{
    ActivityId, Address, CallError, Client, Outcome, Replies, Running, ServiceKind, ServiceType,
};
use genom_types::Record;
use zenoh::Wait;
use zenoh::key_expr::OwnedKeyExpr;
use zenoh::query::{ConsolidationMode, Reply, ReplyError};
use zenoh::sample::Sample;

use crate::core::Core;
use crate::error::BACKEND;
use crate::sending::Orders;
use crate::wire::{self, ErrorReply, Expected, Refusal};

/// Time after which a reply is lost. zenoh keeps a timer for each query for this long, even after
/// the reply, so it is short for frequent calls.
const ANSWER: Duration = Duration::from_secs(60);

/// The same for activities: the longest run whose end is reported.
const RUN: Duration = Duration::from_secs(7 * 24 * 3600);

/// The calling end.
pub(crate) struct ZenohClient {
    pub(crate) at: Address,
    pub(crate) ty: ServiceType,
    pub(crate) key: OwnedKeyExpr,
    pub(crate) cancel: OwnedKeyExpr,
    pub(crate) core: Arc<Core>,
}

/// A request in progress.
struct Call {
    at: Address,
    ty: ServiceType,
    timeout: Duration,
    cancel: OwnedKeyExpr,
    orders: Orders,
    /// Taken when the request ends.
    replies: Mutex<Option<Box<dyn Replies>>>,
    id: OnceLock<ActivityId>,
    /// Whether a genomd served it at the time of the call. If so, the end of the query without a
    /// reply means that the server is gone.
    served: bool,
    /// Cancelled before it was accepted.
    cancelled: AtomicBool,
}

/// Owned by zenoh's callback, which is dropped when no more replies can come.
struct Listening(Arc<Call>);

impl ZenohClient {
    fn mismatch(&self, theirs: String) -> CallError {
        let ours = types_of_service(&self.ty);
        CallError::TypeMismatch { address: self.at.clone(), ours, theirs }
    }
}

impl Client for ZenohClient {
    fn request(
        &mut self,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Result<Box<dyn Running>, CallError> {
        let digest = self.ty.digest();
        if let Some(theirs) = self.core.graph().other_service(&self.at.to_string(), &digest) {
            return Err(self.mismatch(theirs));
        }
        if !input.ty().same_as(&self.ty.input) {
            return Err(self.mismatch(types_of_service(&self.ty)));
        }
        let mut message = Vec::new();
        let encoded = input.encode_message(&mut message);
        encoded.map_err(|error| CallError::Serialization(error.to_string()))?;
        let timeout = if self.ty.kind == ServiceKind::Activity { RUN } else { ANSWER };
        let call = Arc::new(Call {
            at: self.at.clone(),
            ty: self.ty.clone(),
            timeout,
            cancel: self.cancel.clone(),
            orders: self.core.orders().clone(),
            replies: Mutex::new(Some(replies)),
            id: OnceLock::new(),
            served: self.core.graph().serves(&self.at.to_string()),
            cancelled: AtomicBool::new(false),
        });
        let listening = Listening(Arc::clone(&call));
        self.core
            .session()
            .get(&self.key)
            .payload(message)
            .encoding(wire::encoding_of(&self.ty.input))
            .attachment(digest)
            .consolidation(ConsolidationMode::None)
            .timeout(timeout)
            .callback(move |reply| listening.hear(reply))
            .wait()
            .map_err(|error| CallError::Failed {
                backend: BACKEND.to_owned(),
                why: error.to_string(),
            })?;
        Ok(Box::new(ZenohRunning(call)))
    }
}

impl Listening {
    fn hear(&self, reply: Reply) {
        match reply.into_result() {
            Ok(sample) => self.0.sample(&sample),
            Err(error) => self.0.error(&error),
        }
    }
}

impl Drop for Listening {
    fn drop(&mut self) {
        // No reply can come any more. If the service existed, it went away; otherwise there was
        // none.
        let error = if self.0.served || self.0.id.get().is_some() {
            CallError::Gone
        } else {
            CallError::Nobody { address: self.0.at.clone() }
        };
        self.0.finish(Outcome::Lost(error));
    }
}

impl Call {
    fn lock(&self) -> MutexGuard<'_, Option<Box<dyn Replies>>> {
        self.replies.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn finish(&self, outcome: Outcome) {
        let replies = self.lock().take();
        if let Some(replies) = replies {
            replies.finish(outcome);
        }
    }

    fn sample(&self, sample: &Sample) {
        let payload = sample.payload().to_bytes();
        let kind = sample.attachment().map(|kind| kind.to_bytes());
        let text = || String::from_utf8_lossy(&payload);
        match kind.as_deref() {
            Some(wire::ACCEPTED) => match text().parse() {
                Ok(id) => self.accepted(ActivityId(id)),
                Err(_) => self.unreadable(&format!("`{}` is no number of a run", text())),
            },
            Some(wire::FEEDBACK) => {
                if let Some(replies) = &mut *self.lock() {
                    replies.feedback(&text());
                }
            }
            // A foreign server attaches nothing.
            _ => {
                let mut output = Record::new(&self.ty.output);
                if !Expected::of(&self.ty.output).admits(sample.encoding()) {
                    return self.unreadable(&format!("it is {}", sample.encoding()));
                }
                match output.decode_message(&payload) {
                    Ok(()) => self.finish(Outcome::Success(output)),
                    Err(error) => self.unreadable(&error.to_string()),
                }
            }
        }
    }

    fn accepted(&self, id: ActivityId) {
        let _ = self.id.set(id);
        if let Some(replies) = &mut *self.lock() {
            replies.accepted(id);
        }
        if self.cancelled.load(Ordering::SeqCst) {
            self.ask_to_cancel(id);
        }
    }

    fn unreadable(&self, why: &str) {
        self.finish(Outcome::Lost(CallError::Serialization(why.to_owned())));
    }

    fn error(&self, error: &ReplyError) {
        let payload = error.payload().to_bytes();
        if &*payload == b"Timeout" {
            return self.finish(Outcome::Lost(CallError::Timeout(self.timeout)));
        }
        self.finish(match wire::read_error(&payload) {
            ErrorReply::Exception(name, detail) => Outcome::Exception { name, detail },
            ErrorReply::Refusal(refusal) => Outcome::Lost(match refusal {
                Refusal::Gone => CallError::Gone,
                Refusal::Serialization(why) => CallError::Serialization(why),
                Refusal::Types(theirs) => CallError::TypeMismatch {
                    address: self.at.clone(),
                    ours: types_of_service(&self.ty),
                    theirs,
                },
                Refusal::Failed(why) => CallError::Failed { backend: BACKEND.to_owned(), why },
            }),
        });
    }

    fn ask_to_cancel(&self, id: ActivityId) {
        let key = self.cancel.clone();
        self.orders.submit(move |outgoing, _| {
            let asked = outgoing.session.get(&key).payload(id.to_string()).callback(|_| {}).wait();
            if let Err(error) = asked {
                tracing::warn!(%key, %error, "an activity could not be cancelled");
            }
        });
    }
}

struct ZenohRunning(Arc<Call>);

impl Running for ZenohRunning {
    fn cancel(&self) {
        // `accepted` stores the id and then reads this flag; whichever of the two comes second sees
        // the other and sends the cancellation.
        self.0.cancelled.store(true, Ordering::SeqCst);
        if let Some(id) = self.0.id.get()
            && self.0.lock().is_some()
        {
            self.0.ask_to_cancel(*id);
        }
    }
}
