//! Exchanges a component whose description changed: it stops, and another one starts where it was.

use std::sync::Arc;

use genom_description::model::{Port, PortDirection, PortIx};
use genom_middleware::{Address, Endpoint, EndpointKind};
use genom_protocol::Resumption;

use super::error::ReloadError;
use super::found::Found;
use super::trial::REST;
use crate::components::Hosted;
use crate::deploy::Gone;
use crate::loading::{Source, check_names};
use crate::supervisor::Supervisor;

impl Supervisor {
    /// Stops a component, and starts what was found in its place, with its IDS and activities by
    /// name. What does not fit is refused before anything changed; if the new one does not start,
    /// the one before is started again. Returns what is not as it was.
    pub(super) fn restart(
        self: &Arc<Self>,
        hosted: Arc<Hosted>,
        found: Found,
    ) -> Result<Vec<String>, ReloadError> {
        let Found { request, source } = found;
        check_names(&request, source.reading.model(), &hosted.name)?;
        self.check_ports(&hosted, &source)?;
        let name = hosted.name.clone();
        let state = hosted.freeze(REST)?;
        let resume = || {
            Some(Box::new(Resumption {
                state: state.clone(),
                activities: true,
                hold: false,
                copy: None,
            }))
        };
        let mut gone = Gone::of(&hosted);
        let before = Source::as_it_was(hosted.build(), hosted.contents());
        let mut new = gone.request.clone();
        (new.library, new.gen_file, new.resume) = (request.library, request.gen_file, resume());
        drop(hosted);
        self.unload(&name)?;
        let why = match self.load_from(&new, source) {
            Ok(hosted) => return Ok([hosted.notes.clone(), gone.connect(self)].concat()),
            Err(why) => why,
        };
        tracing::warn!(instance = name, "{why}: started again as it was");
        gone.request.resume = resume();
        match self.load_from(&gone.request, before) {
            Ok(_) => {
                gone.connect(self).iter().for_each(|lost| tracing::warn!("{lost}"));
                Err(ReloadError::RolledBack { why })
            }
            Err(again) => {
                Err(ReloadError::Lost { name, why: Box::new(why), again: Box::new(again) })
            }
        }
    }

    /// Refuses a description that takes away a port that is connected, or gives it another type; its
    /// readers in other processes count as far as middlewares show them.
    pub(super) fn check_ports(&self, hosted: &Hosted, source: &Source) -> Result<(), ReloadError> {
        let (old, plan) = (hosted.model(), &source.reading.plan);
        let all = self.connections.all();
        for (index, port) in old.ports.pairs() {
            let is_end = |address: &Address| {
                let rest = address.name.as_str().strip_prefix(port.name.as_str());
                address.instance == hosted.name
                    && rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
            };
            let peer = all.iter().find_map(|made| match port.direction {
                PortDirection::In if is_end(made.inport()) => Some(made.outport().to_string()),
                PortDirection::Out if is_end(made.outport()) => Some(made.inport().to_string()),
                _ => None,
            });
            let new: Option<PortIx> = plan.component().ports.find(|new| new.name == port.name);
            let found = match new.map(|new| (&plan.component().ports[new], plan.port_type(new))) {
                None => "no such port",
                Some((new, _)) if new.direction != port.direction => "another direction of it",
                Some((new, _)) if new.multiple != port.multiple => "another kind of it",
                Some((_, ty)) => match (ty, hosted.port_type(index)) {
                    (Some(new), Some(old)) if new.same_as(old) => continue,
                    _ => "another type of it",
                },
            };
            let Some(peer) = peer.or_else(|| self.reader_elsewhere(hosted, port)) else { continue };
            let (name, port) = (hosted.name.clone(), port.name.clone());
            return Err(ReloadError::Port { name, port, peer, found });
        }
        Ok(())
    }

    /// Who reads an out port in another process, as far as its middlewares show it.
    fn reader_elsewhere(&self, hosted: &Hosted, port: &Port) -> Option<String> {
        if port.direction != PortDirection::Out {
            return None;
        }
        let address = Address::new(hosted.name.as_str(), port.name.as_str());
        hosted.ties.bindings.port(&port.name).names().iter().find_map(|name| {
            let middleware = self.backends.get(name).ok()?;
            let spelled = middleware.spelled(&address);
            let reads = |found: &Endpoint| {
                let rest = found.address.strip_prefix(spelled.as_str());
                found.kind == EndpointKind::Subscription
                    && rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
            };
            let found = middleware.discover().ok()?.into_iter().any(|found| reads(&found));
            found.then(|| format!("a reader in another process, on {name}"))
        })
    }
}
