//! The middleware as a whole.

use std::borrow::Cow;

use genom_middleware::{
    Capabilities, Diagnosis, Discovery, LogEntry, Middleware, NoForeignName, Obstacle, Refused,
    Relay, Services,
};

use super::core::Proxy;
use crate::channel::lock;
use crate::words::{Answer, Question, Up};

impl Middleware for Proxy {
    fn name(&self) -> &'static str {
        self.shared().name
    }

    fn capabilities(&self) -> Capabilities {
        self.shared().about(|about| about.capabilities).unwrap_or(Capabilities::NETWORK)
    }

    fn services(&self) -> Option<&dyn Services> {
        self.capabilities().services.then_some(self)
    }

    fn discovery(&self) -> Option<&dyn Discovery> {
        self.shared().about(|about| about.discovers)?.then_some(self)
    }

    fn relay(&self) -> Option<&dyn Relay> {
        self.shared().about(|about| about.relays)?.then_some(self)
    }

    fn meeting_point(&self) -> Vec<(Cow<'static, str>, String)> {
        self.shared().about(|about| about.meeting.clone()).unwrap_or_default()
    }

    fn masquerade(&self, ours: &str, foreign: &str) -> Result<(), NoForeignName> {
        let question = Question::Mask { ours: ours.to_owned(), foreign: foreign.to_owned() };
        if let Ok((Answer::Masked(masked), _)) = self.shared().ask(&question, &[]) {
            masked?;
        }
        // A gateway that is not there now hears of it when it is.
        lock(&self.shared().book).masks.insert(ours.to_owned(), foreign.to_owned());
        Ok(())
    }

    fn unmask(&self, ours: &str) {
        lock(&self.shared().book).masks.remove(ours);
        let up = Up::Mask { ours: ours.to_owned(), foreign: None };
        // The next gateway never hears of it.
        let _ = self.shared().say(&up, &[]);
    }

    fn takes_reports(&self) -> bool {
        self.shared().about(|about| about.takes_reports).unwrap_or(false)
    }

    fn log(&self, entry: &LogEntry) {
        // Where there is no gateway now, its nodes are gone, too.
        let _ = self.shared().say(&Up::Log(entry.clone()), &[]);
    }

    fn diagnose(&self, parts: &[Diagnosis]) {
        let _ = self.shared().say(&Up::Diagnose(parts.to_vec()), &[]);
    }

    fn trouble(&self) -> Vec<Obstacle> {
        match self.shared().ask(&Question::Trouble, &[]) {
            Ok((Answer::Obstacles(obstacles), _)) => obstacles,
            _ => Vec::new(),
        }
    }

    fn refused(&self) -> Vec<Refused> {
        match self.shared().ask(&Question::Refused, &[]) {
            Ok((Answer::Refused(refused), _)) => refused,
            _ => Vec::new(),
        }
    }
}
