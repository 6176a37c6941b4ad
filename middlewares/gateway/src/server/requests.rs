//! Requests in both directions, and messages for daemons.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, Weak};

use genom_middleware::{
    ActivityId, CallError, OnRequest, Outcome, Replies, ServiceHandler, ServiceType,
};
use genom_types::{DataType, Record};

use super::guest::{CALLS, Guest};
use super::held::{Asked, Called};
use crate::channel::lock;
use crate::words::{Down, Progress};

impl Guest {
    /// A client makes a request.
    pub(super) fn request(self: &Arc<Self>, end: u32, call: u64, payload: &[u8]) {
        let lost = |error| self.say(&Down::Progress { call, progress: Progress::Lost(error) }, &[]);
        // Closed before the request came.
        let Some(client) = self.client(end) else { return lost(CallError::Gone) };
        let mut client = lock(&client);
        let mut input = Record::new(&client.1.input);
        if let Err(error) = input.decode_message(payload) {
            return lost(CallError::Serialization(error.to_string()));
        }
        {
            let mut called = lock(&self.called);
            if called.len() >= CALLS {
                let (backend, why) = (self.middleware.name(), "too many requests are under way");
                let (backend, why) = (backend.to_owned(), why.to_owned());
                return lost(CallError::Failed { backend, why });
            }
            called.insert(call, Called::default());
        }
        let replies = ToCaller { guest: Arc::downgrade(self), call, ended: false };
        match client.0.request(&input, Box::new(replies)) {
            Ok(running) => {
                let mut called = lock(&self.called);
                // It may have ended already.
                if let Some(known) = called.get_mut(&call) {
                    if known.cancelled {
                        running.cancel();
                    }
                    known.running = Some(running);
                }
            }
            Err(error) => {
                if lock(&self.called).remove(&call).is_some() {
                    lost(error);
                }
            }
        }
    }

    /// A client cancels its request.
    pub(super) fn cancel(&self, call: u64) {
        if let Some(known) = lock(&self.called).get_mut(&call) {
            known.cancelled = true;
            if let Some(running) = &known.running {
                running.cancel();
            }
        }
    }

    /// What became of a request to a service of the proxy's process.
    pub(super) fn progress(&self, call: u64, progress: Progress, payload: &[u8]) {
        let mut asked = lock(&self.asked);
        let found = match asked.get(&call) {
            Some(Asked::Request(replies, output)) => Some((Arc::clone(replies), output.clone())),
            Some(Asked::Message(_)) | None => None,
        };
        let goes_on = matches!(progress, Progress::Accepted(_) | Progress::Feedback(_));
        let ended = if goes_on { None } else { asked.remove(&call) };
        drop(asked);
        // A message is dropped here: there will be no reply.
        drop(ended);
        let Some((replies, output)) = found else { return };
        match progress.outcome(&output, payload) {
            Ok(outcome) => {
                let replies = lock(&replies).take();
                if let Some(replies) = replies {
                    replies.finish(outcome);
                }
            }
            Err(Progress::Accepted(id)) => {
                if let Some(replies) = &mut *lock(&replies) {
                    replies.accepted(id);
                }
            }
            Err(Progress::Feedback(state)) => {
                if let Some(replies) = &mut *lock(&replies) {
                    replies.feedback(&state);
                }
            }
            Err(_) => {}
        }
    }

    /// The reply to a message for the daemon, if there is one.
    pub(super) fn replied(&self, call: u64, reply: Option<Vec<u8>>) {
        let asked = lock(&self.asked).remove(&call);
        if let (Some(Asked::Message(answer)), Some(reply)) = (asked, reply) {
            answer(reply);
        }
    }

    /// Passes messages for the daemon on to the proxy.
    pub(super) fn messages_for(self: &Arc<Self>, end: u32) -> Box<OnRequest> {
        let guest = Arc::downgrade(self);
        Box::new(move |message, answer| {
            let Some(guest) = guest.upgrade() else { return };
            if let Some(call) = guest.ask(Asked::Message(answer)) {
                guest.say(&Down::Relayed { end, call }, &message);
            }
        })
    }

    /// A number under which the proxy answers; none if too many wait already.
    fn ask(&self, asked: Asked) -> Option<u64> {
        let call = self.numbers.fetch_add(1, Ordering::Relaxed);
        let mut all = lock(&self.asked);
        let room = all.len() < CALLS;
        let refused = if room { all.insert(call, asked) } else { Some(asked) };
        drop(all);
        drop(refused);
        room.then_some(call)
    }
}

/// Replies to a client of the proxy.
struct ToCaller {
    guest: Weak<Guest>,
    call: u64,
    ended: bool,
}

impl ToCaller {
    fn tell(&self, progress: Progress, payload: &[u8]) {
        if let Some(guest) = self.guest.upgrade() {
            guest.say(&Down::Progress { call: self.call, progress }, payload);
        }
    }

    fn end(&mut self, outcome: Outcome) {
        self.ended = true;
        let Some(guest) = self.guest.upgrade() else { return };
        let known = lock(&guest.called).remove(&self.call);
        if known.is_some() {
            let (progress, payload) = Progress::of(outcome);
            self.tell(progress, &payload);
        }
    }
}

impl Replies for ToCaller {
    fn accepted(&mut self, id: ActivityId) {
        self.tell(Progress::Accepted(id), &[]);
    }

    fn feedback(&mut self, state: &str) {
        self.tell(Progress::Feedback(state.to_owned()), &[]);
    }

    fn finish(mut self: Box<Self>, outcome: Outcome) {
        self.end(outcome);
    }
}

impl Drop for ToCaller {
    fn drop(&mut self) {
        if !self.ended {
            self.end(Outcome::Lost(CallError::Gone));
        }
    }
}

/// Passes requests to a service on to the proxy.
pub(super) struct PassOn {
    guest: Weak<Guest>,
    end: u32,
    output: DataType,
}

impl PassOn {
    pub(super) fn new(guest: &Arc<Guest>, end: u32, service: &ServiceType) -> Self {
        Self { guest: Arc::downgrade(guest), end, output: service.output.clone() }
    }
}

impl ServiceHandler for PassOn {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        // Dropped, they tell that the service is gone.
        let Some(guest) = self.guest.upgrade() else { return };
        let mut message = Vec::new();
        if let Err(error) = input.encode_message(&mut message) {
            return replies.finish(Outcome::Lost(CallError::Serialization(error.to_string())));
        }
        let replies = Arc::new(Mutex::new(Some(replies)));
        if let Some(call) = guest.ask(Asked::Request(replies, self.output.clone())) {
            guest.say(&Down::Request { end: self.end, call }, &message);
        }
    }

    fn cancel(&self, id: ActivityId) {
        if let Some(guest) = self.guest.upgrade() {
            guest.say(&Down::Cancel { end: self.end, id }, &[]);
        }
    }
}
