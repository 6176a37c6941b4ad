//! Answers to questions about the middleware.

use super::guest::Guest;
use crate::words::{Answer, Question};

impl Guest {
    /// The answer, and what follows it.
    pub(super) fn answer(&self, question: Question, payload: &[u8]) -> (Answer, Vec<u8>) {
        let on = self.middleware.as_ref();
        let answer = match question {
            Question::Discover => Answer::Endpoints(on.discover()),
            Question::EndsAt(at) => Answer::Endpoints(on.ends_at(&at)),
            Question::Spelled(at) => Answer::Text(on.spelled(&at)),
            Question::Strangers => Answer::Strangers(on.strangers()),
            Question::Obstacles(at) => Answer::Obstacles(on.obstacles(&at)),
            Question::Refused => Answer::Refused(on.refused()),
            Question::Trouble => Answer::Obstacles(on.trouble()),
            Question::Mask { ours, foreign } => Answer::Masked(on.masquerade(&ours, &foreign)),
            Question::Daemons => match on.relay() {
                Some(relay) => Answer::Daemons(relay.daemons()),
                None => Answer::None,
            },
            Question::Ask { name, at, patience } => {
                let Some(relay) = on.relay() else { return (Answer::None, Vec::new()) };
                let asked = match at {
                    Some(at) => {
                        relay.ask(&name, &at, payload, patience).map(|reply| vec![(at, reply)])
                    }
                    None => relay.ask_all(&name, payload, patience),
                };
                let mut follows = Vec::new();
                let replies = asked.map(|replies| {
                    let each = replies.into_iter().map(|(from, reply)| {
                        follows.extend(&reply);
                        (from, reply.len())
                    });
                    each.collect()
                });
                return (Answer::Replies(replies), follows);
            }
        };
        (answer, Vec::new())
    }
}
