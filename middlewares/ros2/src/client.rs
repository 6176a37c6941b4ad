//! The calling ends of services and actions.

use std::sync::Arc;
use std::time::{Duration, Instant};

use genom_middleware::describe::types_of_service;
use genom_middleware::reply::pair;
use genom_middleware::{Address, CallError, Client, Outcome, Replies, Running, ServiceType};
use genom_types::Record;

use crate::body::{self, Fields, Style};
use crate::rmw::{Answer, ClientEnd, Rmw, Service, Target, Wanted};
use crate::runs::{ActionEnd, Run};
use crate::within::{Own, Within};

/// How long after a client is opened its calls wait for an unknown service; discovery takes time.
pub(crate) const ACQUAINTANCE: Duration = Duration::from_secs(2);

/// How a service is called.
#[derive(Clone)]
pub(crate) enum Way {
    Service(Arc<dyn ClientEnd>),
    Action(Arc<ActionEnd>),
}

/// The calling end of a service.
pub(crate) struct Ros2Client {
    pub(crate) at: Address,
    pub(crate) ty: ServiceType,
    pub(crate) style: Style,
    pub(crate) wanted: Wanted,
    pub(crate) way: Way,
    /// Until then, a call waits for a service that is not known yet.
    pub(crate) acquainted: Instant,
    pub(crate) own: Arc<Own>,
    pub(crate) rmw: Arc<dyn Rmw>,
}

impl Ros2Client {
    fn mismatch(&self, theirs: String) -> CallError {
        let ours = types_of_service(&self.ty);
        CallError::TypeMismatch { address: self.at.clone(), ours, theirs }
    }
}

impl Client for Ros2Client {
    fn request(
        &mut self,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Result<Box<dyn Running>, CallError> {
        self.send(input, replies, self.acquainted)
    }

    fn call(&mut self, input: &Record, timeout: Duration) -> Result<Outcome, CallError> {
        let (replies, reply) = pair();
        let begun = Instant::now();
        let end = begun.checked_add(timeout).unwrap_or(self.acquainted).min(self.acquainted);
        let _running = self.send(input, Box::new(replies), end)?;
        reply.wait(timeout.saturating_sub(begun.elapsed())).map_err(|error| match error {
            CallError::Timeout(_) => CallError::Timeout(timeout),
            error => error,
        })
    }
}

impl Ros2Client {
    /// Sends a request. Waits until `end` for a service that is not known yet.
    fn send(
        &self,
        input: &Record,
        replies: Box<dyn Replies>,
        end: Instant,
    ) -> Result<Box<dyn Running>, CallError> {
        let server = match self.rmw.service(&self.wanted, end) {
            Service::There(server) => server,
            Service::Nobody => return Err(CallError::Nobody { address: self.at.clone() }),
            Service::Differs(theirs) => return Err(self.mismatch(theirs)),
        };
        if !input.ty().same_as(&self.ty.input) {
            return Err(self.mismatch(types_of_service(&self.ty)));
        }
        let Some(server) = server else {
            // A service of this daemon is called directly: DDS connects a participant to itself
            // only over multicast.
            let handler = self.own.get(&self.wanted.of.name);
            let handler = handler.ok_or(CallError::Nobody { address: self.at.clone() })?;
            return Ok(Within::request(handler, input, replies));
        };
        let undecodable =
            |error: genom_types::CdrError| CallError::Serialization(error.to_string());
        match &self.way {
            Way::Service(end) => {
                let mut body = Vec::new();
                body::put_input(&mut body, input).map_err(undecodable)?;
                let (output, style) = (self.ty.output.clone(), self.style);
                let then = move |reply: Result<&[u8], CallError>| {
                    replies.finish(match reply.map(Fields::of) {
                        Ok(Some(mut fields)) => fields.outcome(&output, style, None),
                        Ok(None) => Outcome::Lost(CallError::Serialization("it is empty".into())),
                        Err(error) => Outcome::Lost(error),
                    });
                };
                end.call(Target::End(server), body, Answer::new(then));
                Ok(Box::new(Nothing))
            }
            Way::Action(action) => {
                let run = Run::new((&self.at, &self.ty, self.style), action, server);
                let mut body = run.id().to_vec();
                body::put_input(&mut body, input).map_err(undecodable)?;
                Ok(run.begin(replies, Target::End(server), body))
            }
        }
    }
}

/// For attributes and functions, which cannot be cancelled.
struct Nothing;

impl Running for Nothing {
    fn cancel(&self) {}
}
