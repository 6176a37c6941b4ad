//! Requests between daemons.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use genom_kit::complaints::Complaints;
use genom_middleware::{AnnounceError, AskError, DiscoverError, OnRequest, Relay};
use genom_plugin_abi::{Code, Failure};

use crate::callbacks::give;
use crate::calls::Handle;
use crate::given::{Daemon, Given};
use crate::listing::{Lent, MESSAGE};
use crate::middleware::{Core, Open};

/// Most bytes of the name of a daemon, and of the identity of an end.
const NAME: usize = 1024;

impl Relay for Open {
    fn announce(
        &self,
        name: &str,
        requests: Box<OnRequest>,
    ) -> Result<Box<dyn Send + Sync>, AnnounceError> {
        let core = Arc::clone(&self.0);
        let library = core.library;
        let daemon = Arc::new(Daemon {
            name: name.to_owned(),
            library,
            requests,
            withdrawn: AtomicBool::new(false),
            waiting: Arc::default(),
            refused: Complaints::default(),
        });
        let announced = core.backend.announce(name, give(Given::Daemon(Arc::clone(&daemon))));
        match announced {
            Ok(announced) => Ok(Box::new(Announced { daemon, _announced: announced, _core: core })),
            Err(failure) => {
                // The library may go on for a while.
                daemon.withdrawn.store(true, Ordering::Release);
                Err(failure.announcing(library.name(), name))
            }
        }
    }

    fn daemons(&self) -> Result<Vec<String>, DiscoverError> {
        let list = Lent::new();
        let done = self.0.backend.daemons(list.number());
        done.map_err(|failure| self.error(failure))?;
        let listed = list.into_listed(self.0.library.name()).texts.into_iter();
        Ok(listed.map(|(name, _)| name).filter(|name| name.len() <= NAME).collect())
    }

    fn own(&self) -> String {
        let listed = self.0.listed(|backend, list| backend.own(list));
        let own = listed.texts.into_iter().next().map(|(own, _)| own);
        own.filter(|own| own.len() <= NAME).unwrap_or_default()
    }

    fn ask_all(
        &self,
        name: &str,
        request: &[u8],
        patience: Duration,
    ) -> Result<Vec<(String, Vec<u8>)>, AskError> {
        self.asked(name, request, |backend, list| {
            backend.ask_all(name, request, nanoseconds(patience), list)
        })
    }

    fn ask(
        &self,
        name: &str,
        at: &str,
        request: &[u8],
        patience: Duration,
    ) -> Result<Vec<u8>, AskError> {
        let replies = self.asked(name, request, |backend, list| {
            backend.ask(name, at, request, nanoseconds(patience), list)
        })?;
        let reply = replies.into_iter().next().map(|(_, reply)| reply);
        reply.ok_or_else(|| {
            Failure::new(Code::FAILED, "there is no reply").asking(self.0.library.name(), name)
        })
    }
}

impl Open {
    /// The replies that a function of the library lists.
    fn asked(
        &self,
        name: &str,
        request: &[u8],
        by: impl FnOnce(&Handle, genom_plugin_abi::table::Opaque) -> Result<(), Failure>,
    ) -> Result<Vec<(String, Vec<u8>)>, AskError> {
        let library = self.0.library.name();
        if request.len() > MESSAGE {
            let why = format!("the request has {} bytes, {MESSAGE} at most", request.len());
            return Err(Failure::new(Code::FAILED, why).asking(library, name));
        }
        let list = Lent::new();
        by(&self.0.backend, list.number()).map_err(|failure| failure.asking(library, name))?;
        let replies = list.into_listed(library).replies;
        Ok(replies.into_iter().filter(|(from, _)| from.len() <= NAME).collect())
    }
}

fn nanoseconds(patience: Duration) -> u64 {
    u64::try_from(patience.as_nanos()).unwrap_or(u64::MAX)
}

/// A daemon that others reach. Fields are dropped in order.
struct Announced {
    daemon: Arc<Daemon>,
    _announced: Handle,
    _core: Arc<Core>,
}

impl Drop for Announced {
    fn drop(&mut self) {
        self.daemon.withdrawn.store(true, Ordering::Release);
    }
}
