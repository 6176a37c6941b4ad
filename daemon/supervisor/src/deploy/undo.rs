//! Undoes the steps of a deployment.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use genom_protocol::component_of;
use genom_runtime::Clock;
use serde_json::Value;

use super::dump;
use super::error::{MoveError, UndoError};
use super::steps::entries;
use crate::components::{Components, Hosted, request};
use crate::connections::{ConnectError, Connections, Wanted};
use crate::supervisor::Supervisor;
use crate::ties::Connection;
use genom_configuration::{BackendNames, CallEntry, ConnectionEntry, LoadRequest};

/// How to undo a step.
pub(super) enum Undo {
    Unload(String),
    /// Load a component that was taken down.
    PutBack(Box<Gone>),
    Move(Moved),
    /// Restore the connection of an in port or remote.
    Reconnect {
        inport: String,
        before: Option<Connection>,
    },
    Request(Requested),
}

/// A component that was taken down, as it was.
pub(crate) struct Gone {
    /// The request that loads it.
    pub(crate) request: LoadRequest,
    pub(crate) connections: Vec<ConnectionEntry>,
    /// Services whose activities were running.
    interrupted: Vec<String>,
}

impl Gone {
    pub(crate) fn of(hosted: &Hosted) -> Self {
        let running = hosted.activities.all().into_iter();
        let running = running.filter(|activity| activity.outcome().is_none());
        Self {
            request: dump::component(hosted),
            connections: entries(hosted),
            interrupted: running.map(|activity| activity.service.clone()).collect(),
        }
    }

    /// Makes its connections again. Returns those that could not be made, with the reason.
    pub(crate) fn connect(&self, supervisor: &Supervisor) -> Vec<String> {
        let failed = self.connections.iter().filter_map(|entry| {
            let failed = make_anyway(&supervisor.connections, entry).err();
            failed.map(|error| format!("{entry}: {}", error.sentence()))
        });
        failed.collect()
    }

    /// Loads it as it was, in place of a component that has its name now. Returns what could not be
    /// restored.
    fn put_back(self, supervisor: &Arc<Supervisor>) -> Vec<String> {
        let name = self.request.instance();
        if supervisor.components.get(&name).is_some()
            && let Err(error) = supervisor.unload(&name)
        {
            return vec![error.to_string()];
        }
        if let Err(error) = supervisor.load(&self.request) {
            return vec![format!("{name} does not run: {error}")];
        }
        let connected = self.connect(supervisor).into_iter();
        let stopped =
            self.interrupted.iter().map(|service| format!("{name}/{service} was interrupted"));
        connected.chain(stopped).collect()
    }
}

/// A component or port that moved.
pub(super) struct Moved {
    component: String,
    port: Option<String>,
    before: BackendNames,
    /// The middlewares of ports that differed from those of the component.
    ports: BTreeMap<String, BackendNames>,
}

/// A service that was called or started.
pub(super) struct Requested {
    entry: CallEntry,
    /// The step as reported.
    step: String,
    /// The inputs that restore an attribute; `None` for other services.
    values: Option<Value>,
    /// Activities from before the deployment that the request interrupted.
    interrupted: Vec<String>,
    /// The inputs of the attribute that were remembered for dumps.
    remembered: Option<Value>,
    /// Number of the activity that was started.
    activity: Option<u64>,
}

/// Something that could not be restored, and its component.
pub(super) struct Left {
    component: String,
    what: String,
}

/// Activities that ran before the deployment began: component and number.
pub(super) struct Running(BTreeSet<(String, u64)>);

impl Running {
    pub(super) fn now(components: &Components) -> Self {
        let of = |hosted: Arc<Hosted>| {
            let all = hosted.activities.all().into_iter();
            all.filter(|activity| activity.outcome().is_none())
                .map(move |activity| (hosted.name.clone(), activity.number))
        };
        Self(components.all().into_iter().flat_map(of).collect())
    }

    /// Services of the running activities that a request interrupts. They are reported and not
    /// started again: starting a motion is up to the supervisor.
    fn interrupted_by(&self, hosted: &Hosted, service: &str) -> Vec<String> {
        let services = &hosted.model().services;
        let Some(service) = services.iter().find(|one| one.name == service) else {
            return Vec::new();
        };
        let stops = |name: &str| service.interrupts.iter().any(|&one| services[one].name == name);
        let all = hosted.activities.all().into_iter();
        all.filter(|one| one.outcome().is_none() && stops(&one.service))
            .filter(|one| self.0.contains(&(hosted.name.clone(), one.number)))
            .map(|one| one.service.clone())
            .collect()
    }
}

/// Moves a component or port, and returns where it was.
pub(super) fn move_to(
    components: &Components,
    connections: &Connections,
    component: &str,
    port: Option<&str>,
    to: &BackendNames,
) -> Result<Moved, MoveError> {
    let Some(hosted) = components.get(component) else {
        return Err(MoveError::NotThere(component.to_owned()));
    };
    let bindings = &hosted.ties.bindings;
    let before = port.map_or_else(|| bindings.component(), |port| bindings.port(port));
    let ports = if port.is_none() { bindings.ports() } else { BTreeMap::new() };
    let index = port.and_then(|port| hosted.model().ports.find(|known| known.name == port));
    connections.move_to(&hosted, index, to)?;
    let port = port.map(str::to_owned);
    Ok(Moved { component: component.to_owned(), port, before, ports })
}

impl Requested {
    /// To be called before the request is sent.
    pub(super) fn before(
        components: &Components,
        entry: &CallEntry,
        step: String,
        ran: &Running,
    ) -> Self {
        let hosted = components.get(&entry.component);
        let remembered = hosted.as_ref().and_then(|hosted| {
            let mut all = hosted.standing.attributes();
            all.remove(&entry.service)
        });
        let interrupted = hosted.as_ref().map(|on| ran.interrupted_by(on, &entry.service));
        let interrupted = interrupted.unwrap_or_default();
        let values = hosted.and_then(|hosted| values(&hosted, &entry.service, &remembered));
        Self { entry: entry.clone(), step, values, interrupted, remembered, activity: None }
    }

    /// Stores the number of the activity that was started.
    pub(super) fn started(self, activity: u64) -> Self {
        Self { activity: Some(activity), ..self }
    }

    /// Waits at most `patience` for an activity that was started to end; with `None`, not at all.
    fn take_back(
        self,
        components: &Components,
        patience: Option<Duration>,
    ) -> Result<(), UndoError> {
        let Some(hosted) = components.get(&self.entry.component) else { return Ok(()) };
        hosted.standing.not_deployed(&self.entry.service, &self.entry.inputs);
        if let Some(number) = self.activity {
            hosted.abort(number);
            // Waits until it has ended, as before.
            if let Some(patience) = patience
                && let Some(activity) = hosted.activities.get(number)
                && activity.wait_at_most(patience).is_none()
            {
                return Err(UndoError::Endless(self.step));
            }
            return Ok(());
        }
        let Some(values) = self.values else { return Err(UndoError::Final(self.step)) };
        let entry = CallEntry { inputs: values, ..self.entry };
        let restored = request::send_to(&hosted, &entry);
        restored.map_err(|source| UndoError::Request { step: self.step, source })?;
        hosted.standing.attribute_back(&entry.service, self.remembered);
        Ok(())
    }
}

/// The inputs that restore the present state of an attribute; those it was last set to, if codels
/// exclude reading the state.
fn values(hosted: &Hosted, service: &str, remembered: &Option<Value>) -> Option<Value> {
    let index = hosted.plan().service(service)?;
    hosted.current(index).or_else(|| remembered.clone())
}

/// The result of disconnecting; a name that does not exist counts as disconnected.
pub(super) fn take_away(taken: Result<bool, ConnectError>) -> Result<(), ConnectError> {
    match taken {
        Ok(_) | Err(ConnectError::NoSuchInport { .. }) => Ok(()),
        Err(error) => Err(error),
    }
}

/// Makes the connection of an entry, even if the other side does not exist.
fn make_anyway(connections: &Connections, entry: &ConnectionEntry) -> Result<(), ConnectError> {
    let wanted = Wanted { wait: true, ..Wanted::from(entry) };
    connections.make(&wanted).map(drop)
}

/// Restores the previous connection of an in port or remote, or disconnects it.
fn put_back(
    connections: &Connections,
    inport: &str,
    before: Option<&Connection>,
) -> Result<(), UndoError> {
    let Some(before) = before else {
        return Ok(take_away(connections.take_away(inport))?);
    };
    let entry = before.entry();
    make_anyway(connections, &entry)
        .map_err(|source| UndoError::Connect { entry: entry.to_string(), source })
}

/// Undoes steps, the last first. Returns what could not be restored.
pub(super) fn take_back(supervisor: &Arc<Supervisor>, undo: Vec<Undo>) -> Vec<String> {
    let (components, connections) = (&supervisor.components, &supervisor.connections);
    // While a virtual clock stands still nothing can end.
    let patience =
        matches!(supervisor.clock, Clock::Monotonic).then_some(supervisor.settings.stop_timeout);
    let mut left: Vec<Left> = Vec::new();
    let mut back = undo.into_iter().rev().peekable();
    while let Some(one) = back.next() {
        let (component, undone) = match one {
            Undo::Unload(name) => {
                // Components that were loaded one after the other are unloaded together.
                let mut names = vec![name];
                while let Some(Undo::Unload(name)) =
                    back.next_if(|it| matches!(it, Undo::Unload(_)))
                {
                    names.insert(0, name);
                }
                // What could not be undone in these components disappears with them.
                left.retain(|left| !names.contains(&left.component));
                let failed = supervisor.unload_these(&names).into_iter();
                left.extend(
                    failed.map(|(component, error)| Left { component, what: error.to_string() }),
                );
                continue;
            }
            Undo::PutBack(gone) => {
                let component = gone.request.instance();
                left.retain(|left| left.component != component);
                let lost = gone.put_back(supervisor).into_iter();
                left.extend(lost.map(|what| Left { component: component.clone(), what }));
                continue;
            }
            Undo::Move(moved) => {
                let Moved { component, port, before, ports } = moved;
                let back = move_to(components, connections, &component, port.as_deref(), &before);
                let ports = ports.iter().try_for_each(|(port, on)| {
                    move_to(components, connections, &component, Some(port), on).map(drop)
                });
                (component, back.and(ports).map_err(UndoError::from))
            }
            Undo::Reconnect { inport, before } => {
                let undone = put_back(connections, &inport, before.as_ref());
                (component_of(&inport).to_owned(), undone)
            }
            Undo::Request(mut requested) => {
                let component = requested.entry.component.clone();
                left.extend(requested.interrupted.drain(..).map(|service| {
                    let what = format!("{component}/{service} was interrupted");
                    Left { component: component.clone(), what }
                }));
                (component, requested.take_back(components, patience))
            }
        };
        left.extend(undone.err().map(|error| Left { component, what: error.to_string() }));
    }
    left.into_iter().map(|left| left.what).collect()
}
