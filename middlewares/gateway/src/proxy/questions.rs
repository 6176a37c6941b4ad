//! Discovery, and messages between daemons: questions that the gateway answers.

use std::sync::Arc;
use std::time::Duration;

use genom_middleware::{
    Address, AnnounceError, AskError, DiscoverError, Discovery, Endpoint, Obstacle, OnRequest,
    Relay, Stranger,
};

use super::book::{Kind, NoAnswer};
use super::core::{Held, Proxy};
use crate::channel::lock;
use crate::words::{Answer, Question, Refusal, What};

impl Proxy {
    fn undiscovered(&self, why: &NoAnswer) -> DiscoverError {
        DiscoverError { backend: self.shared().name.to_owned(), why: why.to_string() }
    }

    fn endpoints(&self, question: &Question) -> Result<Vec<Endpoint>, DiscoverError> {
        let failed = |why: NoAnswer| self.undiscovered(&why);
        match self.shared().ask(question, &[]).map_err(failed)?.0 {
            Answer::Endpoints(endpoints) => endpoints,
            _ => Err(failed(NoAnswer::Misread)),
        }
    }
}

impl Discovery for Proxy {
    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        self.endpoints(&Question::Discover)
    }

    fn ends_at(&self, at: &Address) -> Result<Vec<Endpoint>, DiscoverError> {
        self.endpoints(&Question::EndsAt(at.clone()))
    }

    fn spelled(&self, at: &Address) -> String {
        // Most middlewares spell an address as it is.
        if self.shared().about(|about| about.spelled == "a/b") == Some(true) {
            return at.to_string();
        }
        match self.shared().ask(&Question::Spelled(at.clone()), &[]) {
            Ok((Answer::Text(text), _)) => text,
            _ => at.to_string(),
        }
    }

    fn strangers(&self) -> Vec<Stranger> {
        match self.shared().ask(&Question::Strangers, &[]) {
            Ok((Answer::Strangers(strangers), _)) => strangers,
            _ => Vec::new(),
        }
    }

    fn obstacles(&self, at: &Address) -> Vec<Obstacle> {
        match self.shared().ask(&Question::Obstacles(at.clone()), &[]) {
            Ok((Answer::Obstacles(obstacles), _)) => obstacles,
            Ok(_) => Vec::new(),
            Err(_) => {
                let (shared, book) = (self.shared(), lock(&self.shared().book));
                let name = shared.name;
                let why = book.why.clone().unwrap_or_else(|| "it does not answer".to_owned());
                vec![Obstacle {
                    what: format!("the gateway of {name} is down: {why}"),
                    fix: format!("`genomctl cells --restart gateway-{name}` starts it again"),
                }]
            }
        }
    }
}

impl Relay for Proxy {
    fn announce(
        &self,
        name: &str,
        requests: Box<OnRequest>,
    ) -> Result<Box<dyn Send + Sync>, AnnounceError> {
        let shared = self.shared();
        let end = shared.end_number();
        let what = What::Announcement { name: name.to_owned() };
        let opened = shared.open(end, what, Kind::Announcement(Arc::from(requests)));
        let failed = |why: String| AnnounceError::Failed {
            name: name.to_owned(),
            backend: shared.name.to_owned(),
            why,
        };
        opened.map_err(|refusal| match refusal {
            Refusal::Announce(error) => error,
            Refusal::Open(error) => failed(error.to_string()),
            Refusal::Own(why) => failed(why),
        })?;
        Ok(Box::new(Held { end, core: Arc::clone(&self.core) }))
    }

    fn daemons(&self) -> Result<Vec<String>, DiscoverError> {
        let failed = |why: NoAnswer| self.undiscovered(&why);
        match self.shared().ask(&Question::Daemons, &[]).map_err(failed)?.0 {
            Answer::Daemons(daemons) => daemons,
            _ => Err(failed(NoAnswer::Misread)),
        }
    }

    fn own(&self) -> String {
        self.shared().about(|about| about.own.clone()).unwrap_or_default()
    }

    fn ask_all(
        &self,
        name: &str,
        request: &[u8],
        patience: Duration,
    ) -> Result<Vec<(String, Vec<u8>)>, AskError> {
        self.ask_ends(name, None, request, patience)
    }

    fn ask(
        &self,
        name: &str,
        at: &str,
        request: &[u8],
        patience: Duration,
    ) -> Result<Vec<u8>, AskError> {
        let replies = self.ask_ends(name, Some(at.to_owned()), request, patience)?;
        let reply = replies.into_iter().next().map(|(_, reply)| reply);
        reply.ok_or_else(|| self.silent(name, "there is no reply".to_owned()))
    }
}

impl Proxy {
    fn silent(&self, name: &str, why: String) -> AskError {
        AskError::Silent { name: name.to_owned(), backend: self.shared().name.to_owned(), why }
    }

    fn ask_ends(
        &self,
        name: &str,
        at: Option<String>,
        request: &[u8],
        patience: Duration,
    ) -> Result<Vec<(String, Vec<u8>)>, AskError> {
        let question = Question::Ask { name: name.to_owned(), at, patience };
        let asked = self.shared().ask(&question, request);
        let (answer, payload) = asked.map_err(|why| self.silent(name, why.to_string()))?;
        let Answer::Replies(replies) = answer else {
            return Err(self.silent(name, NoAnswer::Misread.to_string()));
        };
        let mut rest = &payload[..];
        let mut all = Vec::new();
        for (from, size) in replies? {
            let Some((reply, others)) = rest.split_at_checked(size) else {
                return Err(self.silent(name, NoAnswer::Misread.to_string()));
            };
            all.push((from, reply.to_vec()));
            rest = others;
        }
        Ok(all)
    }
}
