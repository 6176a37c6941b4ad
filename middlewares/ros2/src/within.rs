//! Calls to services of this daemon itself: DDS connects a participant to itself only over
//! multicast.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, Weak};

use genom_middleware::{ActivityId, CallError, Outcome, Replies, Running, ServiceHandler};
use genom_types::Record;

use crate::lock::lock;

/// The services of this daemon, by name.
#[derive(Default)]
pub(crate) struct Own(Mutex<HashMap<String, Weak<dyn ServiceHandler>>>);

impl Own {
    pub(crate) fn add(&self, topic: String, handler: Weak<dyn ServiceHandler>) {
        let mut all = lock(&self.0);
        all.retain(|_, handler| handler.strong_count() > 0);
        all.insert(topic, handler);
    }

    pub(crate) fn get(&self, topic: &str) -> Option<Arc<dyn ServiceHandler>> {
        lock(&self.0).get(topic).and_then(Weak::upgrade)
    }
}

/// A request to a service of this daemon, passed to its handler directly.
pub(crate) struct Within {
    handler: Weak<dyn ServiceHandler>,
    id: Arc<OnceLock<ActivityId>>,
}

struct Noting {
    replies: Option<Box<dyn Replies>>,
    id: Arc<OnceLock<ActivityId>>,
}

impl Within {
    pub(crate) fn request(
        handler: Arc<dyn ServiceHandler>,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Box<dyn Running> {
        let id = Arc::new(OnceLock::new());
        let noting = Noting { replies: Some(replies), id: Arc::clone(&id) };
        handler.request(input.clone(), Box::new(noting));
        Box::new(Self { handler: Arc::downgrade(&handler), id })
    }
}

impl Replies for Noting {
    fn accepted(&mut self, id: ActivityId) {
        let _ = self.id.set(id);
        if let Some(replies) = &mut self.replies {
            replies.accepted(id);
        }
    }

    fn feedback(&mut self, state: &str) {
        if let Some(replies) = &mut self.replies {
            replies.feedback(state);
        }
    }

    fn finish(mut self: Box<Self>, outcome: Outcome) {
        if let Some(replies) = self.replies.take() {
            replies.finish(outcome);
        }
    }
}

impl Drop for Noting {
    fn drop(&mut self) {
        if let Some(replies) = self.replies.take() {
            replies.finish(Outcome::Lost(CallError::Gone));
        }
    }
}

impl Running for Within {
    fn cancel(&self) {
        if let (Some(id), Some(handler)) = (self.id.get(), self.handler.upgrade()) {
            handler.cancel(*id);
        }
    }
}
