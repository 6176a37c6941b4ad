//! Exchanges a component whose description changed: the new one starts beside it, and takes its place
//! between two ticks.

use std::sync::Arc;

use genom_configuration::ReloadSection;
use genom_protocol::FrozenComponent;
use tokio::sync::broadcast::Receiver;

use super::back::{self, Before, Beside, Way};
use super::error::ReloadError;
use super::found::Found;
use super::trial::{REST, Trial};
use crate::components::{Hosted, NotHandedOver};
use crate::connections::Wanted;
use crate::deploy::Gone;
use crate::loading::{LoadError, begin, check_names};
use crate::supervisor::Supervisor;
use crate::ties::Connection;
use genom_bus::Numbered;

/// A component that took the place of another one.
pub(super) struct Begun {
    pub(super) heir: Arc<Hosted>,
    /// What is not as it was.
    pub(super) notes: Vec<String>,
    /// Whether the library before stays.
    pub(super) stays: bool,
    /// What happens since.
    changes: Receiver<Numbered>,
}

impl Supervisor {
    /// Starts what was found in the place of a component, on trial. Returns what is not as it was, and
    /// whether the library before stays.
    pub(super) fn begin_beside(
        self: &Arc<Self>,
        hosted: Arc<Hosted>,
        found: Found,
    ) -> Result<(Vec<String>, bool), ReloadError> {
        let ReloadSection { ticks, exceptions } = self.settings.reload;
        let build = hosted.build();
        let way = exceptions.then(|| Beside::of(self, &hosted)).transpose()?;
        // Start codels of the new one may end the process.
        let trial = Trial::begin(self, &hosted, true);
        let Begun { heir, notes, stays, changes } =
            self.beside(hosted, found, None, trial.as_ref())?;
        if let Some(way) = way {
            let bus = Arc::clone(&self.bus);
            let before = Before { way: Way::Beside(way), build, changes, bus };
            back::watch(&heir, trial, before, ticks);
        } else if let Some(trial) = trial {
            trial.watch(&heir, ticks);
        }
        Ok((notes, stays))
    }

    /// Starts what was found, which runs its start codels, and hands over to it. What fails before
    /// that changes nothing. `earlier` is a state of the same description, for what the one that runs
    /// does not have.
    pub(super) fn beside(
        self: &Arc<Self>,
        hosted: Arc<Hosted>,
        found: Found,
        earlier: Option<&FrozenComponent>,
        trial: Option<&Trial>,
    ) -> Result<Begun, ReloadError> {
        let Found { mut request, source } = found;
        // Those that were set stand, as far as the new one has them.
        request.attributes.clear();
        check_names(&request, source.reading.model(), &hosted.name)?;
        self.check_ports(&hosted, &source)?;
        let mut new = Gone::of(&hosted).request;
        (new.library, new.gen_file) = (request.library, request.gen_file);
        (new.instead, new.resume) = (request.instead, None);
        new.attributes.clear();
        let heir = begin(self, &new, hosted.name.clone(), source, Some(&hosted))?;
        let timeout = self.settings.stop_timeout;
        let mut notes = self.connect_remotes(&hosted, &heir);
        if let Some(trial) = trial {
            trial.renew(&hosted);
        }
        let changes = self.bus.live();
        match self.components.hand_over(&hosted, &heir, earlier, (REST, timeout)) {
            Ok(Ok(told)) => notes.extend(told),
            refused => {
                if let Err(why) = heir.stop(timeout) {
                    tracing::error!("{why}");
                }
                let name = hosted.name.clone();
                return Err(match refused {
                    Err(why) => why.into(),
                    Ok(Err(NotHandedOver::Unfit(source))) => {
                        LoadError::Resume { name, source: Box::new(source) }.into()
                    }
                    Ok(Err(NotHandedOver::NotConverted(source))) => {
                        ReloadError::NotConverted { name, source }
                    }
                    Ok(Ok(_)) => ReloadError::NotThere(name),
                });
            }
        }
        notes.extend(self.open_what_changed(&hosted, &heir));
        let stays = !self.components.retire(hosted, timeout);
        Ok(Begun { heir, notes, stays, changes })
    }

    /// Connects the remotes of the heir as those of the one before are.
    fn connect_remotes(&self, before: &Hosted, heir: &Hosted) -> Vec<String> {
        let mut lost = Vec::new();
        for made in before.ties.services() {
            let entry = Connection::Service(made).entry();
            if let Err(error) = self.connections.connect_heir(heir, &Wanted::from(&entry)) {
                lost.push(format!("{entry}: {}", error.sentence()));
            }
        }
        lost
    }

    /// Opens ports that have another type now, and offers the services again.
    fn open_what_changed(&self, before: &Hosted, heir: &Arc<Hosted>) -> Vec<String> {
        let mut lost = Vec::new();
        for port in before.closed_for(heir) {
            if let Err(error) = self.connections.opening().open_again(heir, port) {
                lost.push(format!("{}: {error}", heir.model().ports[port].name));
            }
        }
        before.withdraw();
        let backend = heir.ties.bindings.component();
        match self.connections.serve_on(heir, backend.names()) {
            Ok(served) => heir.serve_also(served, &backend),
            Err(error) => lost.push(format!("its services are not offered: {error}")),
        }
        lost
    }
}
