//! A request to a server of YARP that is no genomd: the name of the service and its inputs in one
//! bottle, and one bottle that answers it.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use genom_middleware::{Address, CallError, Outcome, Replies, Running, ServiceType};

use crate::bottle::decode;
use crate::bottle::skim::Skim;
use crate::error::BACKEND;
use crate::io::{Errand, Lost, Step};
use crate::refusals::Refusals;
use crate::reply::{self, Said};
use crate::wire::Carrier;

/// Least size of an answer that is read, whatever the outputs: it may be a sentence.
const SENTENCE: usize = 1 << 16;

/// What a refused answer counts as.
pub(crate) const MISFIT: &str = "an answer that does not fit its service";

/// A request under way.
pub(crate) struct Request {
    pub(crate) at: Address,
    /// Name of the server's port.
    pub(crate) port: String,
    pub(crate) server: SocketAddr,
    pub(crate) message: Vec<u8>,
    pub(crate) service: ServiceType,
    /// How long the answer may take to begin; `None` for any time.
    pub(crate) patience: Option<Duration>,
    /// Greatest size of an answer, for outputs without a greatest size.
    pub(crate) largest: usize,
    /// `None` once the end was told.
    pub(crate) replies: Option<Box<dyn Replies>>,
    pub(crate) skim: Skim,
    pub(crate) refusals: Arc<Refusals>,
}

/// One who asked: YARP has no way to cancel.
pub(crate) struct Asked;

impl Running for Asked {
    fn cancel(&self) {}
}

impl Request {
    fn finish(&mut self, outcome: Outcome) -> Step {
        if let Some(replies) = self.replies.take() {
            replies.finish(outcome);
        }
        Step::Done
    }

    fn failed(&mut self, why: String) -> Step {
        let backend = BACKEND.to_owned();
        self.finish(Outcome::Lost(CallError::Failed { backend, why }))
    }

    fn misfit(&mut self, why: &str) -> Step {
        let peer: IpAddr = self.server.ip();
        let detail = format!("{} of {}: {why}", self.at.name, self.port);
        self.refusals.add(MISFIT, Some(peer), &detail);
        let why = format!("{} answers {}, and {why}", self.port, self.at.name);
        self.finish(Outcome::Lost(CallError::Serialization(why)))
    }

    fn answer(&mut self, bottle: &[u8]) -> Step {
        match reply::read(&self.service.output, bottle) {
            Ok(Said::Outputs(record)) => self.finish(Outcome::Success(record)),
            Ok(Said::Exception { name, detail }) => {
                self.finish(Outcome::Exception { name, detail })
            }
            Ok(Said::Failed(said)) => self.failed(format!("{} answers {said}", self.port)),
            Err(odd) => self.misfit(&odd.to_string()),
        }
    }
}

impl Errand for Request {
    fn carrier(&self) -> Carrier {
        Carrier::FastTcp
    }

    fn begin(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.message)
    }

    fn hear(&mut self, bytes: &[u8]) -> Step {
        match self.skim.end(bytes) {
            Ok(None) => Step::Wait,
            Ok(Some(end)) => self.answer(bytes.get(..end).unwrap_or_default()),
            Err(why) => self.misfit(&format!("that is no bottle: {why}")),
        }
    }

    fn lost(mut self: Box<Self>, how: Lost) {
        let why = how.into_call_error(&self.at);
        self.finish(Outcome::Lost(why));
    }

    fn patience(&self) -> Option<Duration> {
        self.patience
    }

    fn most(&self) -> usize {
        decode::most(&self.service.output).unwrap_or(self.largest).max(SENTENCE)
    }
}

impl Drop for Request {
    fn drop(&mut self) {
        self.finish(Outcome::Lost(CallError::Gone));
    }
}
