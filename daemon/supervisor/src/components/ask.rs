//! Requests of the control plane to a component.

use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use genom_description::model::ServiceIx;
use genom_runtime::Ticket;
use tokio::sync::mpsc;
use tokio::time::timeout;

use super::hosted::{Answer, Heard, Hosted};
use super::input::Asked;
use crate::outcome::Outcome;

/// How often to check whether a stuck codel blocks a request that has not been answered.
const LOOK: Duration = Duration::from_millis(250);

impl Hosted {
    /// Sends a request and waits for its outcome or, if it is an activity, until it is accepted.
    /// Blocks. A request that a stuck codel blocks is withdrawn.
    pub fn request_blocking(&self, service: ServiceIx, asked: Asked) -> Answer {
        let (sender, answers) = std::sync::mpsc::channel();
        let ticket = Ticket::default();
        self.submit_by(&ticket, service, asked, move |heard| {
            let _ = sender.send(first(heard));
        });
        loop {
            match answers.recv_timeout(LOOK) {
                Ok(answer) => return answer,
                Err(RecvTimeoutError::Disconnected) => return Answer::Gone,
                Err(RecvTimeoutError::Timeout) => {
                    if let Some(held_up) = self.instance.give_up(service, &ticket) {
                        return Answer::HeldUp(held_up);
                    }
                }
            }
        }
    }

    /// The same, without blocking the thread.
    pub async fn request(self: &Arc<Self>, service: ServiceIx, asked: Asked) -> Answer {
        let (sender, mut answers) = mpsc::unbounded_channel();
        let ticket = Ticket::default();
        let (hosted, shared) = (Arc::clone(self), ticket.clone());
        let send = move || {
            hosted.submit_by(&shared, service, asked, move |heard| {
                // The caller may have gone; that is not an error.
                let _ = sender.send(first(heard));
            });
        };
        if self.serves_at_once {
            // With a virtual clock, codels run in the thread that sends the request, which must not
            // be a thread of the async runtime.
            tokio::task::spawn_blocking(send);
        } else {
            send();
        }
        loop {
            match timeout(LOOK, answers.recv()).await {
                Ok(answer) => return answer.unwrap_or(Answer::Gone),
                Err(_) => {
                    if let Some(held_up) = self.instance.give_up(service, &ticket) {
                        return Answer::HeldUp(held_up);
                    }
                }
            }
        }
    }
}

fn first(heard: Heard) -> Answer {
    match heard {
        Heard::Accepted(activity) => Answer::Accepted(activity),
        Heard::Ended(outcome) => Answer::Ended(Outcome::from(&outcome)),
        Heard::Refused(error) => Answer::Refused(error),
    }
}
