//! Remotes: services of other components of this daemon, called by codels.

use std::sync::mpsc::channel;
use std::sync::{Arc, Weak};

use genom_middleware::Address;
use genom_runtime::Outcome;
use genom_runtime::body::RemoteCall;
use genom_types::Record;
use serde_json::{Value, json};

use crate::bus::Change;
use crate::daemon::Daemon;
use crate::hosting::{Heard, Hosted};
use crate::nearest::suggest;
use crate::wiring::RemoteConnection;

/// A remote could not be connected; what was there before still is.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RemoteError {
    /// No such remote.
    #[error("no_such_remote: there is no remote `{typed}`; {help}")]
    NoSuchRemote { typed: String, help: String },
    /// No such service.
    #[error("no_such_service: there is no service `{typed}` in this daemon; {help}")]
    NoSuchService { typed: String, help: String },
    /// The service takes or gives something else.
    #[error("{remote} calls {ours}, {service} is {theirs}: make the two .gen interfaces equal")]
    Differs { remote: String, ours: String, service: String, theirs: String },
}

/// Connects remote `local` (`component/remote`) to service `service` (`component/service`).
pub(crate) fn connect(
    daemon: &Arc<Daemon>,
    local: &str,
    service: &str,
) -> Result<RemoteConnection, RemoteError> {
    let (caller, remote) = find_remote(daemon, local)?;
    let (provider, index) = find_service(daemon, service)?;
    let (ours, theirs) = (&caller.model().remotes[remote], &provider.model().services[index]);
    if ours.digest != theirs.digest {
        return Err(RemoteError::Differs {
            remote: local.to_owned(),
            ours: format!("{} of interface {} ({})", ours.name, ours.interface, ours.digest),
            service: service.to_owned(),
            theirs: format!("{} ({})", theirs.name, theirs.digest),
        });
    }
    let call = DirectCall {
        daemon: Arc::downgrade(daemon),
        provider: provider.name.clone(),
        service: theirs.name.clone(),
    };
    caller.bind_remote(remote, Some(Box::new(call)));
    let connection = RemoteConnection {
        remote: caller.address(&ours.name, None),
        service: provider.address(&theirs.name, None),
    };
    caller.wiring.remote_connected(remote, connection.clone());
    daemon.bus.tell(&Change::RemoteConnected {
        remote: connection.remote.to_string(),
        service: connection.service.to_string(),
    });
    Ok(connection)
}

/// Takes the service behind a remote away; whether there was one.
pub(crate) fn disconnect(daemon: &Daemon, caller: &Hosted, remote: usize) -> bool {
    if !caller.wiring.remote_disconnected(remote) {
        return false;
    }
    caller.bind_remote(remote, None);
    let remote = caller.address(&caller.model().remotes[remote].name, None);
    daemon.bus.tell(&Change::RemoteDisconnected { remote: remote.to_string() });
    true
}

/// The remote that an address names, if it names one.
pub(crate) fn named(daemon: &Daemon, address: &str) -> Option<(Arc<Hosted>, usize)> {
    find_remote(daemon, address).ok()
}

fn find_remote(daemon: &Daemon, typed: &str) -> Result<(Arc<Hosted>, usize), RemoteError> {
    let refuse = |help| RemoteError::NoSuchRemote { typed: typed.to_owned(), help };
    let write = || refuse("write COMPONENT/REMOTE".to_owned());
    let address = Address::parse(typed).ok_or_else(write)?;
    let caller = daemon.components.get(&address.instance).ok_or_else(|| {
        let all = daemon.components.all();
        refuse(suggest(&address.instance, all.iter().map(|hosted| hosted.name.as_str())))
    })?;
    let remotes = &caller.model().remotes;
    match remotes.iter().position(|remote| remote.name == address.name) {
        Some(index) => Ok((caller, index)),
        None => {
            Err(refuse(suggest(&address.name, remotes.iter().map(|remote| remote.name.as_str()))))
        }
    }
}

fn find_service(daemon: &Daemon, typed: &str) -> Result<(Arc<Hosted>, usize), RemoteError> {
    let refuse = |help| RemoteError::NoSuchService { typed: typed.to_owned(), help };
    let write = || refuse("write COMPONENT/SERVICE".to_owned());
    let address = Address::parse(typed).ok_or_else(write)?;
    let provider = daemon.components.get(&address.instance).ok_or_else(|| {
        let all = daemon.components.all();
        refuse(suggest(&address.instance, all.iter().map(|hosted| hosted.name.as_str())))
    })?;
    let services = &provider.model().services;
    match services.iter().position(|service| service.name == address.name) {
        Some(index) => Ok((provider, index)),
        None => Err(refuse(suggest(&address.name, services.iter().map(|one| one.name.as_str())))),
    }
}

/// A call within the daemon. The provider may go and come back: it is found at each call.
struct DirectCall {
    daemon: Weak<Daemon>,
    provider: String,
    service: String,
}

impl DirectCall {
    fn provider(&self) -> Option<(Arc<Hosted>, usize)> {
        let hosted = self.daemon.upgrade()?.components.get(&self.provider)?;
        let index = hosted.plan().service(&self.service)?;
        Some((hosted, index))
    }
}

impl RemoteCall for DirectCall {
    fn call(&mut self, input: &Record, output: &mut Record) -> Result<(), (String, Value)> {
        let absent = || ("::genom::no_such_service".to_owned(), Value::Null);
        let broken = |why: String| ("::genom::remote_io".to_owned(), json!({ "what": why }));
        let (hosted, index) = self.provider().ok_or_else(absent)?;
        let mut request = Record::new(&hosted.plan().services()[index].input);
        request.copy_from(input).map_err(|error| broken(error.to_string()))?;
        let (sender, ended) = channel();
        hosted.submit(index, request, move |heard| {
            if let Heard::Ended(outcome) = heard {
                let _ = sender.send(outcome);
            }
        });
        // Dropped without an answer: the provider stopped.
        match ended.recv().map_err(|_| absent())? {
            Outcome::Success(record) => {
                output.copy_from(&record).map_err(|error| broken(error.to_string()))
            }
            Outcome::Exception(exception) => Err((exception.name, exception.detail)),
        }
    }
}
