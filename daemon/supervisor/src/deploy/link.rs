//! What a connection of a deployment is: an in port that reads an out port, or a remote that
//! calls a service; made, looked at, written down and put back.

use std::sync::Arc;

use genom_middleware::Address;

use crate::daemon::Daemon;
use crate::hosting::Hosted;
use crate::wires::{Connection, RemoteConnection};
use crate::wiring::connect::{self, ConnectError, ConnectRequest, Patience};
use crate::wiring::remote::{self, RemoteError, RemoteRequest};
use genom_configuration::place::Place;
use genom_configuration::{ConnectionEntry, terms};

/// A connection that is there.
pub(super) enum Link {
    Port(Connection),
    Remote(RemoteConnection),
}

/// A connection could not be made; what was there before still is.
pub(super) struct LinkError {
    /// The key of the entry that it is about.
    pub(super) key: &'static str,
    pub(super) why: String,
    /// The other side is not there; it may come.
    pub(super) absent: bool,
}

impl Link {
    /// What feeds an in port, or serves a remote, now.
    pub(super) fn present(daemon: &Daemon, inport: &str) -> Option<Self> {
        if let Some((caller, index)) = remote::named(daemon, inport) {
            return caller.wires.remote(index).map(Link::Remote);
        }
        let (hosted, port, element) = connect::reader(daemon, inport).ok()?;
        hosted.wires.connection(port, element.as_deref()).map(Link::Port)
    }

    /// As an entry of a file, which gives the same connection when it is applied.
    pub(super) fn entry(&self) -> ConnectionEntry {
        let (inport, to, backend, fixed, policy) = match self {
            Link::Port(made) => {
                let policy = Some(terms::told_policy(made.policy).to_string());
                (&made.inport, &made.outport, Some(&made.backend), made.fixed, policy)
            }
            Link::Remote(made) => {
                (&made.remote, &made.service, made.backend.as_ref(), made.fixed, None)
            }
        };
        let backend = backend.filter(|_| fixed).cloned();
        // `/scan`, a name of somebody else's, is one on its middleware only.
        let (outport, backend) = match backend {
            Some(on) if to.instance.is_empty() => (format!("{on}:{to}"), None),
            backend => (to.to_string(), backend),
        };
        ConnectionEntry { inport: inport.to_string(), outport, policy, backend }
    }

    /// Whether it is what an entry asks for.
    pub(super) fn is(&self, wanted: &ConnectionEntry) -> bool {
        let Ok(place) = Place::parse(&wanted.outport) else { return false };
        let backend = wanted.backend.as_ref().or(place.backend.as_ref());
        let same = |to: &Address, on: Option<&String>| {
            *to == place.address && backend.is_none_or(|backend| Some(backend) == on)
        };
        match self {
            Link::Port(made) => {
                same(&made.outport, Some(&made.backend))
                    && made.policy == terms::policy(wanted.policy())
            }
            Link::Remote(made) => {
                same(&made.service, made.backend.as_ref()) && wanted.policy.is_none()
            }
        }
    }
}

/// The connections of a component's in ports and remotes, as entries of a file.
pub(super) fn of(hosted: &Hosted) -> Vec<ConnectionEntry> {
    let ports = hosted.wires.connections().into_iter().map(Link::Port);
    let remotes = hosted.wires.remotes().into_iter().map(Link::Remote);
    ports.chain(remotes).map(|link| link.entry()).collect()
}

/// Makes the connection of an entry, in place of the one that is there.
pub(super) fn make(daemon: &Arc<Daemon>, entry: &ConnectionEntry) -> Result<(), LinkError> {
    make_now(daemon, entry, false)
}

/// The same, whether the other side is there or not.
pub(super) fn make_anyway(daemon: &Arc<Daemon>, entry: &ConnectionEntry) -> Result<(), LinkError> {
    make_now(daemon, entry, true)
}

/// `wait`: also when the other side is not there.
fn make_now(daemon: &Arc<Daemon>, entry: &ConnectionEntry, wait: bool) -> Result<(), LinkError> {
    if remote::named(daemon, &entry.inport).is_some() {
        if entry.policy.is_some() {
            let why = format!("{} is a remote: it takes a service, and no policy", entry.inport);
            return Err(LinkError { key: "policy", why, absent: false });
        }
        let request = RemoteRequest {
            remote: entry.inport.clone(),
            service: entry.outport.clone(),
            backend: entry.backend.clone(),
            wait,
            patience: Patience::None,
        };
        return remote::connect(daemon, &request).map(drop).map_err(|error| {
            let (key, absent) = match &error {
                RemoteError::NoSuchRemote { .. } => ("in", false),
                RemoteError::NoSuchService { absent, .. } => ("out", *absent),
                RemoteError::Backend(_) => ("backend", false),
                RemoteError::Differs { .. } | RemoteError::Failed(_) => ("out", false),
                RemoteError::HeldUp(_) => ("in", false),
            };
            LinkError { key, why: error.to_string(), absent }
        });
    }
    let request = ConnectRequest {
        inport: entry.inport.clone(),
        outport: entry.outport.clone(),
        policy: terms::policy(entry.policy()),
        backend: entry.backend.clone(),
        wait,
        patience: Patience::None,
    };
    connect::connect(daemon, &request).map(drop).map_err(|error| {
        let (key, absent) = match &error {
            ConnectError::NoSuchInport { .. } | ConnectError::HeldUp(_) => ("in", false),
            ConnectError::NoSuchOutport { absent, .. } => ("out", *absent),
            ConnectError::Backend(_) => ("backend", false),
            ConnectError::Type { .. } | ConnectError::Failed(_) => ("out", false),
        };
        let help = error.help().map(|help| format!("; {help}")).unwrap_or_default();
        LinkError { key, why: format!("{error}{help}"), absent }
    })
}

/// Brings an in port or remote back to the connection it had, or to none.
pub(super) fn put_back(
    daemon: &Arc<Daemon>,
    inport: &str,
    before: Option<&Link>,
) -> Result<(), String> {
    let Some(before) = before else {
        if let Some((caller, index)) = remote::named(daemon, inport) {
            remote::disconnect(daemon, &caller, index).map_err(|error| error.to_string())?;
        } else if let Ok((hosted, port, element)) = connect::reader(daemon, inport) {
            let undone = connect::disconnect(daemon, &hosted, port, element.as_deref());
            undone.map_err(|error| error.to_string())?;
        }
        return Ok(());
    };
    let entry = before.entry();
    make_now(daemon, &entry, true).map_err(|error| format!("{entry}: {}", error.why))
}
