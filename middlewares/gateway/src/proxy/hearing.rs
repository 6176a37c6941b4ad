//! What a gateway says, one frame after the other.

use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use genom_middleware::{ActivityId, CallError, Outcome, Replies};
use genom_types::Record;

use super::book::{Kind, Shared};
use crate::channel::lock;
use crate::wire::{Frame, Frames};
use crate::words::{Down, Progress, Refusal, Up};

impl Shared {
    /// Hears what the gateway says until it ends.
    pub(super) fn hear(self: &Arc<Self>, frames: &mut Frames) -> io::Result<()> {
        while let Some(frame) = frames.next::<Down>()? {
            match frame {
                Frame::Sample { end, message } => {
                    let kind = self.kind(end);
                    if let Some(Kind::Subscription(inbox)) = kind {
                        inbox.arrive(message);
                    }
                }
                Frame::Message(down, payload) => self.heed(down, payload),
            }
        }
        Ok(())
    }

    fn kind(&self, end: u32) -> Option<Kind> {
        lock(&self.book).ends.get(&end).map(|end| end.kind.clone())
    }

    fn heed(self: &Arc<Self>, down: Down, payload: &[u8]) {
        match down {
            // Said once.
            Down::Welcome { .. } => {}
            Down::Opened { end } => self.opened(end),
            Down::Refused { end, why } => self.refused(end, why),
            Down::Closed { end } => {
                let closing = lock(&self.book).closing.remove(&end);
                if let Some(told) = closing {
                    let _ = told.try_send(());
                }
            }
            Down::Lost { end, count } => match self.kind(end) {
                Some(Kind::Publisher { lost, .. }) => lost.set(count),
                Some(Kind::Subscription(inbox)) => inbox.lost.set(count),
                _ => {}
            },
            Down::Request { end, call } => self.asked(end, call, payload),
            Down::Cancel { end, id } => {
                if let Some(Kind::Served(_, handler)) = self.kind(end) {
                    handler.cancel(id);
                }
            }
            Down::Progress { call, progress } => self.progress(call, progress, payload),
            Down::Relayed { end, call } => self.relayed(end, call, payload),
            Down::Answer { number, answer } => {
                let asked = lock(&self.book).questions.remove(&number);
                if let Some(told) = asked {
                    let _ = told.try_send((answer, payload.to_vec()));
                }
            }
        }
    }

    fn opened(&self, number: u32) {
        let mut book = lock(&self.book);
        let Some(end) = book.ends.get_mut(&number) else { return };
        let (opening, kind) = (end.opening.take(), end.kind.clone());
        drop(book);
        let is_new = opening.is_some();
        if let Some(told) = opening {
            let _ = told.try_send(Ok(()));
        }
        if let (Kind::Publisher { line, live, .. }, Some(orders)) = (kind, self.orders.get()) {
            if !is_new {
                // Late readers get the last value from this gateway, too.
                orders.submit(move |_, lines| {
                    let _ = lines.with(line, |line| line.repeat());
                });
            }
            live.store(true, Ordering::SeqCst);
            orders.mark(line);
        }
    }

    fn refused(&self, number: u32, why: Refusal) {
        let mut book = lock(&self.book);
        let opening = book.ends.get_mut(&number).and_then(|end| end.opening.take());
        if let Some(told) = opening {
            let gone = book.ends.remove(&number);
            // A handler of requests may have ends of its own.
            drop(book);
            drop(gone);
            let _ = told.try_send(Err(why));
            return;
        }
        let first = self.try_again(&mut book, number);
        drop(book);
        if first {
            let why = match &why {
                Refusal::Open(error) => error.to_string(),
                Refusal::Announce(error) => error.to_string(),
                Refusal::Own(why) => why.clone(),
            };
            tracing::warn!("the new gateway of {} refuses, and is asked again: {why}", self.name);
        }
        self.ring();
    }

    fn asked(self: &Arc<Self>, end: u32, call: u64, payload: &[u8]) {
        let mut replies = self.reply_to(call);
        let Some(Kind::Served(service, handler)) = self.kind(end) else { return };
        let mut input = Record::new(&service.input);
        if let Err(error) = input.decode_message(payload) {
            let error = CallError::Serialization(error.to_string());
            return replies.end(Outcome::Lost(error));
        }
        handler.request(input, Box::new(replies));
    }

    fn reply_to(self: &Arc<Self>, call: u64) -> Back {
        let generation = lock(&self.book).generation;
        Back { shared: Arc::clone(self), generation, call, ended: false }
    }

    fn progress(&self, number: u64, progress: Progress, payload: &[u8]) {
        let call = {
            let mut book = lock(&self.book);
            match progress {
                Progress::Accepted(_) | Progress::Feedback(_) => book.calls.get(&number).cloned(),
                _ => book.calls.remove(&number),
            }
        };
        let Some(call) = call else { return };
        match progress.outcome(&call.output, payload) {
            Ok(outcome) => call.finish(outcome),
            Err(Progress::Accepted(id)) => {
                if let Some(replies) = &mut *lock(&call.replies) {
                    replies.accepted(id);
                }
            }
            Err(Progress::Feedback(state)) => {
                if let Some(replies) = &mut *lock(&call.replies) {
                    replies.feedback(&state);
                }
            }
            Err(_) => {}
        }
    }

    fn relayed(self: &Arc<Self>, end: u32, call: u64, payload: &[u8]) {
        let Some(Kind::Announcement(requests)) = self.kind(end) else { return };
        let mut back = self.reply_to(call);
        // Dropped instead, it says that there will be no reply.
        let answer = move |reply: Vec<u8>| {
            back.say(&Up::Reply { call, replied: true }, &reply);
            back.ended = true;
        };
        requests(payload.to_vec(), Box::new(answer));
    }
}

/// The way back of a request that came through this gateway.
struct Back {
    shared: Arc<Shared>,
    generation: u64,
    call: u64,
    ended: bool,
}

impl Back {
    fn say(&self, up: &Up, payload: &[u8]) {
        // Its gateway may have ended: nobody waits for it there.
        let _ = self.shared.say_in(self.generation, up, payload);
    }

    fn tell(&self, progress: Progress, payload: &[u8]) {
        self.say(&Up::Progress { call: self.call, progress }, payload);
    }

    fn end(&mut self, outcome: Outcome) {
        let (progress, payload) = Progress::of(outcome);
        self.tell(progress, &payload);
        self.ended = true;
    }
}

impl Replies for Back {
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

impl Drop for Back {
    fn drop(&mut self) {
        if !self.ended {
            // The gateway knows whether this is a request or a message.
            self.tell(Progress::Lost(CallError::Gone), &[]);
        }
    }
}
