//! What is visible on the middleware.

use genom_middleware::{Address, DiscoverError, Discovery, Endpoint, Obstacle, Stranger};
use genom_plugin_abi::Failure;
use std::borrow::Cow;

use crate::describe::address;
use crate::listing::Lent;
use crate::middleware::{Open, obstacles};

impl Open {
    pub(crate) fn error(&self, failure: Failure) -> DiscoverError {
        DiscoverError { backend: self.0.library.name().to_owned(), why: failure.why() }
    }
}

impl Discovery for Open {
    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        let list = Lent::new();
        let done = self.0.backend.discover(list.number());
        done.map_err(|failure| self.error(failure))?;
        Ok(list.into_listed(self.0.library.name()).endpoints)
    }

    fn ends_at(&self, at: &Address) -> Result<Vec<Endpoint>, DiscoverError> {
        let list = Lent::new();
        if let Some(done) = self.0.backend.ends_at(address(at), list.number()) {
            done.map_err(|failure| self.error(failure))?;
            return Ok(list.into_listed(self.0.library.name()).endpoints);
        }
        let wanted = self.spelled(at);
        Ok(self.discover()?.into_iter().filter(|end| end.address == wanted).collect())
    }

    fn spelled(&self, at: &Address) -> String {
        let listed = self.0.listed(|backend, list| backend.spelled(address(at), list));
        listed.texts.into_iter().next().map_or_else(|| at.to_string(), |(spelled, _)| spelled)
    }

    fn strangers(&self) -> Vec<Stranger> {
        let listed = self.0.listed(|backend, list| backend.strangers(list));
        let stranger = |(name, role): (String, String)| match role.is_empty() {
            true => Stranger::Reader { address: name },
            false => Stranger::Session { name, role: Cow::Owned(role) },
        };
        listed.texts.into_iter().map(stranger).collect()
    }

    fn obstacles(&self, at: &Address) -> Vec<Obstacle> {
        obstacles(self.0.listed(|backend, list| backend.obstacles(address(at), list)))
    }
}
