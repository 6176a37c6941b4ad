//! What components ask of the daemon through their standard services (genom3.md 4.8).

use std::sync::{Arc, Weak};

use genom_middleware::Policy;
use genom_runtime::{Wiring, WiringError};

use super::connect::{ConnectError, ConnectRequest, Patience, connect};
use super::remote::{self, RemoteError, RemoteRequest};
use crate::daemon::Daemon;
use crate::flag::Flag;
use crate::hosting::UnloadError;

/// The daemon as one instance sees it.
pub struct SupervisorWiring {
    /// Weak: the daemon owns the instances, not the other way round.
    daemon: Weak<Daemon>,
    instance: String,
    /// Raised when the instance asks for its end, which it may do before it counts as loaded.
    killed: Flag,
}

impl SupervisorWiring {
    /// For an instance, which raises `killed` when it asks for its end.
    pub fn new(daemon: &Arc<Daemon>, instance: &str, killed: &Flag) -> Self {
        let (instance, killed) = (instance.to_owned(), killed.clone());
        Self { daemon: Arc::downgrade(daemon), instance, killed }
    }
}

/// Unloads an instance that asked for its end.
pub fn unload_killed(daemon: &Weak<Daemon>, instance: &str) {
    let (daemon, name) = (daemon.clone(), instance.to_owned());
    // One of the instance's own threads may be here: another one has to join it.
    let stopping = std::thread::Builder::new().name("genomd-kill".to_owned()).spawn(move || {
        match daemon.upgrade().map(|daemon| daemon.unload(&name)) {
            // It is loaded still, and unloaded then; or somebody else unloads it.
            None | Some(Ok(()) | Err(UnloadError::NotThere(_))) => {}
            Some(Err(error)) => tracing::error!("{error}"),
        }
    });
    if let Err(error) = stopping {
        tracing::error!("{instance} cannot be stopped: {error}");
    }
}

impl Wiring for SupervisorWiring {
    fn connect_port(&self, local: &str, remote: &str) -> Result<(), WiringError> {
        let Some(daemon) = self.daemon.upgrade() else {
            return Err(WiringError::PortIo("the daemon stops".to_owned()));
        };
        let request = ConnectRequest {
            inport: format!("{}/{local}", self.instance),
            outport: remote.to_owned(),
            policy: Policy::Latest,
            backend: None,
            wait: false,
            patience: Patience::Newcomer,
        };
        let made = connect(&daemon, &request);
        if made.is_ok() {
            daemon.declared.forget(&request.inport);
        }
        made.map(drop).map_err(|error| match error {
            ConnectError::NoSuchInport { .. } => WiringError::NoSuchInport(local.to_owned()),
            ConnectError::NoSuchOutport { .. } => WiringError::NoSuchOutport(remote.to_owned()),
            error => WiringError::PortIo(error.to_string()),
        })
    }

    fn connect_service(&self, local: &str, remote: &str) -> Result<(), WiringError> {
        let Some(daemon) = self.daemon.upgrade() else {
            return Err(WiringError::RemoteIo("the daemon stops".to_owned()));
        };
        let request = RemoteRequest {
            remote: format!("{}/{local}", self.instance),
            service: remote.to_owned(),
            backend: None,
            wait: false,
            patience: Patience::Newcomer,
        };
        let made = remote::connect(&daemon, &request);
        if made.is_ok() {
            // What somebody asks for now holds, whatever a deployment declared.
            daemon.declared.forget(&request.remote);
        }
        made.map(drop).map_err(|error| match error {
            RemoteError::NoSuchRemote { .. } => WiringError::NoSuchRemote(local.to_owned()),
            RemoteError::NoSuchService { .. } => WiringError::NoSuchService(remote.to_owned()),
            error => WiringError::RemoteIo(error.to_string()),
        })
    }

    fn kill(&self) {
        self.killed.raise();
        unload_killed(&self.daemon, &self.instance);
    }
}
