//! Takes a new library back whose activities end with exceptions during its trial.

use std::sync::{Arc, Weak};
use std::thread;

use genom_host::{Component, Contents};
use genom_protocol::FrozenComponent;
use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::TryRecvError;

use super::error::ReloadError;
use super::found::Found;
use super::trial::{LOOK, REST, Trial, Watched};
use crate::components::{Build, Hosted, is_vacated};
use crate::loading::Source;
use crate::supervisor::Supervisor;
use genom_bus::{Bus, Change, Numbered};

/// The exception of an activity that somebody stopped.
const INTERRUPTED: &str = "::genom::interrupted";

/// What a component ran before, ready to run again.
pub(super) struct Before {
    pub(super) way: Way,
    pub(super) build: Build,
    /// What happens since.
    pub(super) changes: Receiver<Numbered>,
    pub(super) bus: Arc<Bus>,
}

/// How it runs again.
pub(super) enum Way {
    /// The code that ran takes the place of the new one.
    Exchange { component: Component, date: String },
    /// One like it starts beside the new one, which has another description, and takes its place.
    Beside(Box<Beside>),
}

/// What ran with another description.
pub(super) struct Beside {
    supervisor: Weak<Supervisor>,
    library: Option<Contents>,
    /// Its state before the reload, for what the new description does not have.
    state: FrozenComponent,
}

impl Beside {
    /// What runs now.
    ///
    /// # Errors
    /// There is no moment between two codels.
    pub(super) fn of(
        supervisor: &Arc<Supervisor>,
        hosted: &Hosted,
    ) -> Result<Box<Self>, ReloadError> {
        let (supervisor, library) = (Arc::downgrade(supervisor), hosted.contents());
        Ok(Box::new(Self { supervisor, library, state: hosted.freeze(REST)? }))
    }

    /// Starts it beside the component, whose place it takes.
    fn again(&self, hosted: Arc<Hosted>, build: &Build) -> Result<(), ReloadError> {
        let Some(supervisor) = self.supervisor.upgrade() else { return Ok(()) };
        let request = build.request.clone();
        let source = Source::as_it_was(build.clone(), self.library.clone());
        let begun =
            supervisor.beside(hosted, Found { request, source }, Some(&self.state), None)?;
        begun.notes.iter().for_each(|note| tracing::warn!(instance = begun.heir.name, "{note}"));
        Ok(())
    }
}

/// Watches a trial until it is over; then the library before is closed.
pub(super) fn watch(hosted: &Arc<Hosted>, trial: Option<Trial>, before: Before, ticks: u64) {
    let (watched, name) = (Watched::new(hosted, ticks), hosted.name.clone());
    let (weak, digest) = (Arc::downgrade(hosted), hosted.build().digest);
    let mut before = before;
    let watch = move || {
        let (mut threw, mut taken_back) = (None, false);
        while !watched.is_over() {
            threw = threw.or_else(|| before.threw(&name));
            match threw.as_ref().map(|why| before.runs_again(&weak, digest, why)) {
                Some(Again::Runs) => {
                    taken_back = true;
                    break;
                }
                Some(Again::Never) => break,
                Some(Again::Later) | None => thread::park_timeout(LOOK),
            }
        }
        if let Way::Exchange { component, .. } = &before.way {
            is_vacated(component);
        }
        drop(before);
        if let Some(trial) = trial.filter(|_| !taken_back) {
            trial.passed();
        }
    };
    if let Err(error) = thread::Builder::new().name("genomd-trial".to_owned()).spawn(watch) {
        tracing::error!("a reload is not on trial: {error}");
    }
}

impl Before {
    /// The first exception with which an activity of the component ended.
    fn threw(&mut self, component: &str) -> Option<String> {
        loop {
            let change = match self.changes.try_recv() {
                Ok(change) => change.data,
                Err(TryRecvError::Lagged(_)) => continue,
                Err(TryRecvError::Empty | TryRecvError::Closed) => return None,
            };
            let exception = change["exception"].as_str();
            if change["event"] == "activity_ended"
                && change["component"] == component
                && let Some(exception) = exception.filter(|name| *name != INTERRUPTED)
            {
                let service = change["service"].as_str().unwrap_or_default();
                return Some(format!("activity {service} ended with {exception}"));
            }
        }
    }

    /// Has it run again.
    fn runs_again(&self, hosted: &Weak<Hosted>, digest: genom_host::Digest, why: &str) -> Again {
        let Some(hosted) = hosted.upgrade() else { return Again::Never };
        let busy = hosted.is_reloading();
        let Some(_turn) = busy.begin() else { return Again::Later };
        // A later reload took its place.
        if hosted.gone.is_up() || hosted.build().digest != digest {
            return Again::Never;
        }
        let name = hosted.name.clone();
        let done = match &self.way {
            Way::Exchange { component, date } => {
                match hosted.exchange(component, self.build.clone(), date.clone(), REST) {
                    Ok(exchanged) => exchanged.map_err(ReloadError::from),
                    Err(no_rest) => Err(no_rest.into()),
                }
            }
            Way::Beside(beside) => beside.again(hosted, &self.build),
        };
        match done {
            Ok(()) => {
                tracing::warn!(
                    instance = name,
                    "{why} soon after a reload: it runs what it ran before"
                );
                self.bus.tell(&Change::ComponentRolledBack { component: name });
                Again::Runs
            }
            Err(ReloadError::NoRest(error)) => {
                tracing::warn!(instance = name, "{why}, and the new library stays so far: {error}");
                Again::Later
            }
            Err(error) => {
                tracing::error!(instance = name, "{why}, and the new library stays: {error}");
                Again::Never
            }
        }
    }
}

/// Whether what ran before runs again.
enum Again {
    Runs,
    Later,
    Never,
}
