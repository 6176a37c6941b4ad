//! Requests of the control plane to a component: the first answer, or what keeps it from coming.

use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use genom_description::model::ServiceIx;
use genom_runtime::Ticket;
use tokio::sync::mpsc;
use tokio::time::timeout;

use super::hosted::ending;
use super::hosted::{Answer, Heard, Hosted};
use super::input::Asked;

/// How often one looks whether a codel is in the way of a request that is not answered.
const LOOK: Duration = Duration::from_millis(250);

impl Hosted {
    /// Sends a request and waits for its end, or for its acceptance when it is an activity.
    /// Blocks. What a stuck codel keeps from being served is given up.
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

    /// The same for whoever may not block.
    pub async fn request(self: &Arc<Self>, service: ServiceIx, asked: Asked) -> Answer {
        let (sender, mut answers) = mpsc::unbounded_channel();
        let ticket = Ticket::default();
        let (hosted, shared) = (Arc::clone(self), ticket.clone());
        let send = move || {
            hosted.submit_by(&shared, service, asked, move |heard| {
                // A caller that went away is no error of the component.
                let _ = sender.send(first(heard));
            });
        };
        if self.serves_at_once {
            // Codels run in the thread that asks: not in one of the control plane.
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
        Heard::Ended(outcome) => Answer::Ended(ending(&outcome)),
        Heard::Refused(error) => Answer::Refused(error),
    }
}
