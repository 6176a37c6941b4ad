//! Standard services of components that act on the supervisor (genom3.md 4.8).

use std::sync::{Arc, Weak};

use genom_runtime::{ConnectionError, Supervision};

use crate::components::UnloadError;
use crate::connections::{ConnectError, Kind, Patience, Wanted};
use crate::supervisor::Supervisor;
use genom_bus::flag::Flag;

/// Requests of one instance to its supervisor.
pub(super) struct StandardServices {
    /// Weak, because the supervisor owns the instances.
    supervisor: Weak<Supervisor>,
    instance: String,
    /// Raised when the instance asks to be unloaded; it may do so before it is fully loaded.
    killed: Flag,
}

impl StandardServices {
    /// For the given instance. `killed` is raised when it asks to be unloaded.
    pub(super) fn new(supervisor: &Arc<Supervisor>, instance: &str, killed: &Flag) -> Self {
        let (instance, killed) = (instance.to_owned(), killed.clone());
        Self { supervisor: Arc::downgrade(supervisor), instance, killed }
    }

    /// Connects the in port or remote `local` of this instance. The request replaces what a
    /// deployment declared.
    fn connect(&self, kind: Kind, local: &str, remote: &str) -> Result<(), ConnectionError> {
        let failed = |why: String| match kind {
            Kind::Port => ConnectionError::PortIo(why),
            Kind::Service => ConnectionError::RemoteIo(why),
        };
        let supervisor =
            self.supervisor.upgrade().ok_or_else(|| failed("the daemon stops".to_owned()))?;
        let wanted = Wanted {
            inport: format!("{}/{local}", self.instance),
            kind: Some(kind),
            outport: remote.to_owned(),
            policy: None,
            over: None,
            wait: false,
            patience: Patience::Newcomer,
        };
        let made = supervisor.connections.connect(&wanted);
        made.map(drop).map_err(|error| match (error, kind) {
            (ConnectError::NoSuchInport { .. }, Kind::Port) => {
                ConnectionError::NoSuchInport(local.to_owned())
            }
            (ConnectError::NoSuchInport { .. }, Kind::Service) => {
                ConnectionError::NoSuchRemote(local.to_owned())
            }
            (ConnectError::NoSuchOutport { .. }, Kind::Port) => {
                ConnectionError::NoSuchOutport(remote.to_owned())
            }
            (ConnectError::NoSuchOutport { .. }, Kind::Service) => {
                ConnectionError::NoSuchService(remote.to_owned())
            }
            (error, _) => failed(error.to_string()),
        })
    }
}

/// Unloads an instance that asked for it.
pub(super) fn unload_killed(supervisor: &Weak<Supervisor>, instance: &str) {
    let (supervisor, name) = (supervisor.clone(), instance.to_owned());
    // This may be a thread of the instance, which cannot join itself.
    let stopping = std::thread::Builder::new().name("genomd-kill".to_owned()).spawn(move || {
        match supervisor.upgrade().map(|supervisor| supervisor.unload(&name)) {
            // Not found: it is still being loaded, and will be unloaded after that, or another
            // thread unloads it.
            None | Some(Ok(()) | Err(UnloadError::NotThere(_))) => {}
            Some(Err(error)) => tracing::error!("{error}"),
        }
    });
    if let Err(error) = stopping {
        tracing::error!("{instance} cannot be stopped: {error}");
    }
}

impl Supervision for StandardServices {
    fn connect_port(&self, local: &str, remote: &str) -> Result<(), ConnectionError> {
        self.connect(Kind::Port, local, remote)
    }

    fn connect_service(&self, local: &str, remote: &str) -> Result<(), ConnectionError> {
        self.connect(Kind::Service, local, remote)
    }

    fn kill(&self) {
        self.killed.raise();
        unload_killed(&self.supervisor, &self.instance);
    }
}
