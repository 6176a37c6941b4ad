//! The calling end of a service: a connection for each request, on which it is followed. A server
//! that is no genomd gets the request as `yarp rpc` would send it (`stranger`).

use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use genom_middleware::describe::types_of_service;
use genom_middleware::{
    ActivityId, Address, CallError, Client, Outcome, Replies, Running, ServiceType,
};
use genom_types::Record;

use crate::bottle::reader::{Item, Reader};
use crate::bottle::skim::Skim;
use crate::bottle::{Value, decode, encode};
use crate::core::Core;
use crate::error::{BACKEND, NameError};
use crate::io::{Command, Errand, Lost, Step};
use crate::mark::Mark;
use crate::names::Contact;
use crate::stranger::{Asked, MISFIT, Request};
use crate::wire::{self, Carrier, Purpose};
use crate::words;

/// The calling end.
pub(crate) struct YarpClient {
    pub(crate) at: Address,
    /// Name of the port that serves it, and of the service there.
    pub(crate) port: String,
    pub(crate) word: String,
    pub(crate) service: ServiceType,
    pub(crate) core: Arc<Core>,
    /// Where a genomd served it last.
    pub(crate) genomd: Option<Contact>,
}

fn failed(why: impl ToString) -> CallError {
    CallError::Failed { backend: BACKEND.to_owned(), why: why.to_string() }
}

/// The message of a request with these words before it.
fn request(words: &[&str], input: &Record) -> Result<Vec<u8>, CallError> {
    let mut sample = Vec::new();
    input.encode_message(&mut sample).map_err(failed)?;
    let mut message = Vec::new();
    wire::begin(Purpose::Data { reply: true }, &mut message);
    encode::after(words, input.ty(), &sample, &mut message).map_err(failed)?;
    wire::close(&mut message);
    Ok(message)
}

/// The message of a request about an activity.
fn about(word: &str, service: &str, id: ActivityId) -> Vec<u8> {
    let mut message = Vec::new();
    wire::begin(Purpose::Data { reply: true }, &mut message);
    let values = [Value::from(word), Value::from(service), Value::Int(id.0 as i64)];
    message.extend_from_slice(&Value::to_bottle(&values));
    wire::close(&mut message);
    message
}

impl Client for YarpClient {
    fn request(
        &mut self,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Result<Box<dyn Running>, CallError> {
        if !input.ty().same_as(&self.service.input) {
            return Err(failed("the input has another type"));
        }
        let nobody = || CallError::Nobody { address: self.at.clone() };
        let told = |error: NameError| failed(error);
        let contact = self.core.names.query(&self.port).map_err(told)?.ok_or_else(nobody)?;
        let server = contact.address().ok_or_else(nobody)?;
        if self.genomd.as_ref() != Some(&contact) {
            match self.core.mark_of(&contact).map_err(told)? {
                None => return self.ask(server, input, replies),
                Some(Mark::Rpc(_)) => self.genomd = Some(contact),
                Some(Mark::In(_) | Mark::Out(_)) => return Err(nobody()),
            }
        }
        let digest = self.service.digest();
        let message = request(&[words::START, &self.word, &digest], input)?;
        let shared = Arc::new(Shared {
            server,
            service: self.word.clone(),
            state: Mutex::default(),
            core: Arc::clone(&self.core),
        });
        let call = Call {
            at: self.at.clone(),
            message,
            service: self.service.clone(),
            replies: Some(replies),
            skim: Skim::default(),
            shared: Arc::clone(&shared),
        };
        self.core.io.submit(Command::Errand { at: server, errand: Box::new(call) });
        Ok(Box::new(Run(shared)))
    }
}

impl YarpClient {
    /// Asks a server that is no genomd.
    fn ask(
        &self,
        server: SocketAddr,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Result<Box<dyn Running>, CallError> {
        let asking = Request {
            at: self.at.clone(),
            port: self.port.clone(),
            server,
            message: request(&[&self.word], input)?,
            service: self.service.clone(),
            patience: self.core.settings.answer_within,
            largest: self.core.settings.largest_message,
            replies: Some(replies),
            skim: Skim::default(),
            refusals: Arc::clone(&self.core.refusals),
        };
        self.core.io.submit(Command::Errand { at: server, errand: Box::new(asking) });
        Ok(Box::new(Asked))
    }
}

/// What a call and who may cancel it share.
struct Shared {
    server: SocketAddr,
    service: String,
    state: Mutex<State>,
    core: Arc<Core>,
}

#[derive(Default)]
struct State {
    id: Option<ActivityId>,
    cancelled: bool,
}

impl Shared {
    fn cancel(&self, id: ActivityId) {
        let cancel = Cancel(about(words::CANCEL, &self.service, id), Skim::default());
        self.core.io.submit(Command::Errand { at: self.server, errand: Box::new(cancel) });
    }
}

struct Run(Arc<Shared>);

impl Running for Run {
    fn cancel(&self) {
        let mut state = self.0.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.cancelled = true;
        if let Some(id) = state.id {
            drop(state);
            self.0.cancel(id);
        }
    }
}

/// A request under way.
struct Call {
    at: Address,
    message: Vec<u8>,
    service: ServiceType,
    /// `None` once the end was told.
    replies: Option<Box<dyn Replies>>,
    skim: Skim,
    shared: Arc<Shared>,
}

impl Call {
    fn finish(&mut self, outcome: Outcome) -> Step {
        if let Some(replies) = self.replies.take() {
            replies.finish(outcome);
        }
        Step::Done
    }

    fn fail(&mut self, why: CallError) -> Step {
        self.finish(Outcome::Lost(why))
    }

    fn misfit(&mut self, why: String) -> Step {
        let Shared { server, core, .. } = &*self.shared;
        core.refusals.add(MISFIT, Some(server.ip()), &format!("{}: {why}", self.at));
        self.fail(CallError::Serialization(why))
    }

    /// Takes an answer; `used` are its bytes.
    fn answer(&mut self, bottle: &[u8], used: usize) -> Step {
        let Ok((mut reader, mut list)) = Reader::open(bottle) else {
            return self.misfit("it is no bottle".to_owned());
        };
        let word = match reader.next(&mut list) {
            Ok(Some(Item::Text(word))) => String::from_utf8_lossy(word).into_owned(),
            _ => return self.misfit("it begins with no word".to_owned()),
        };
        if word == words::OK {
            let output = &self.service.output;
            let (mut message, mut record) = (Vec::new(), Record::new(output));
            let read = decode::values(output, &mut reader, &mut list, &mut message);
            let read = read
                .map_err(|misfit| misfit.to_string())
                .and_then(|()| record.decode_message(&message).map_err(|error| error.to_string()));
            return match read {
                Ok(()) => self.finish(Outcome::Success(record)),
                Err(why) => self.misfit(why),
            };
        }
        let item = reader.next(&mut list).ok().flatten();
        let text = match item {
            Some(Item::Text(text)) => String::from_utf8_lossy(text).into_owned(),
            _ => String::new(),
        };
        match (word.as_str(), item) {
            (words::ACCEPTED, Some(Item::Int(id))) => {
                let id = ActivityId(id as u64);
                if let Some(replies) = &mut self.replies {
                    replies.accepted(id);
                }
                let mut state = self.shared.state.lock().unwrap_or_else(PoisonError::into_inner);
                state.id = Some(id);
                if state.cancelled {
                    self.shared.cancel(id);
                }
                Step::Send(used, about(words::WAIT, &self.shared.service, id))
            }
            (words::STATE, _) => {
                if let Some(replies) = &mut self.replies {
                    replies.feedback(&text);
                }
                let state = self.shared.state.lock().unwrap_or_else(PoisonError::into_inner);
                match state.id {
                    Some(id) => Step::Send(used, about(words::WAIT, &self.shared.service, id)),
                    None => Step::Wait,
                }
            }
            (words::EXCEPTION, _) => {
                let detail = match reader.next(&mut list) {
                    Ok(Some(Item::Text(json))) => serde_json::from_slice(json).unwrap_or_default(),
                    _ => serde_json::Value::Null,
                };
                self.finish(Outcome::Exception { name: text, detail })
            }
            (words::NOBODY, _) => {
                let address = self.at.clone();
                self.fail(CallError::Nobody { address })
            }
            (words::MISMATCH, _) => {
                let (address, ours) = (self.at.clone(), types_of_service(&self.service));
                self.fail(CallError::TypeMismatch { address, ours, theirs: text })
            }
            (words::GONE, _) => self.fail(CallError::Gone),
            (words::ERROR, _) => self.fail(failed(text)),
            (other, _) => self.misfit(format!("it begins with {other:?}")),
        }
    }
}

impl Errand for Call {
    fn carrier(&self) -> Carrier {
        Carrier::FastTcp
    }

    fn begin(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.message)
    }

    fn hear(&mut self, bytes: &[u8]) -> Step {
        match self.skim.end(bytes) {
            Ok(None) => Step::Wait,
            Ok(Some(end)) => {
                self.skim = Skim::default();
                self.answer(bytes.get(..end).unwrap_or_default(), end)
            }
            Err(why) => self.misfit(why.to_string()),
        }
    }

    fn lost(mut self: Box<Self>, how: Lost) {
        let why = how.into_call_error(&self.at);
        self.fail(why);
    }

    fn patience(&self) -> Option<Duration> {
        // A service may run for any time.
        None
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        self.fail(CallError::Gone);
    }
}

/// Cancels an activity; the outcome comes to who follows it.
struct Cancel(Vec<u8>, Skim);

impl Errand for Cancel {
    fn carrier(&self) -> Carrier {
        Carrier::FastTcp
    }

    fn begin(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.0)
    }

    fn hear(&mut self, bytes: &[u8]) -> Step {
        if matches!(self.1.end(bytes), Ok(None)) { Step::Wait } else { Step::Done }
    }

    fn lost(self: Box<Self>, how: Lost) {
        tracing::debug!(?how, "a YARP activity was not cancelled");
    }
}
