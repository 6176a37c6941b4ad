//! Takes the steps of a deployment, waits for what others must do first, and undoes what was
//! done when a step is refused.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::request::RequestError;
use super::{Step, request};
use crate::bus::Change;
use crate::config::{BackendNames, ConnectionEntry, Spot};
use crate::daemon::Daemon;
use crate::hosting::Ending;
use crate::wiring::connect::{self, ConnectError, ConnectRequest};
use crate::wiring::switch::switch;
use crate::wiring::{Connection, policy};

/// How often the other side of a connection is looked for: discovery tells nobody.
const LOOK: Duration = Duration::from_millis(20);

/// A deployment could not be brought about.
#[derive(Debug, thiserror::Error)]
#[error("{step}: {why}{}", remaining(.left))]
pub(crate) struct ApplyError {
    /// The step that was refused.
    pub(crate) step: String,
    pub(crate) why: String,
    /// Where it is asked for in the file.
    pub(crate) place: Spot,
    /// It was given up waiting.
    pub(crate) timeout: bool,
    /// What could not be undone.
    pub(crate) left: Vec<String>,
}

fn remaining(left: &[String]) -> String {
    if left.is_empty() {
        return String::new();
    }
    format!("; all is as it was, but for: {}", left.join(", "))
}

/// How to take a step back.
enum Undo {
    Unload(String),
    Move {
        component: String,
        port: Option<String>,
        back: BackendNames,
    },
    Reconnect {
        inport: String,
        before: Option<Connection>,
    },
    Abort {
        component: String,
        activity: u64,
    },
    /// There is no way back.
    Not(String),
}

/// Takes all steps, in order; connections wait for the other side at most this long each. Blocks.
pub(crate) fn apply(
    daemon: &Arc<Daemon>,
    steps: &[Step],
    patience: Option<Duration>,
) -> Result<(), ApplyError> {
    let mut undo = Vec::new();
    let mut rest = steps;
    while let Some((step, after)) = rest.split_first() {
        let connects = rest.iter().take_while(|step| matches!(step, Step::Connect(_))).count();
        let taken = if connects > 0 {
            // Together: one that waits holds up no other.
            let (now, after) = rest.split_at(connects);
            rest = after;
            connect_all(daemon, now, patience, &mut undo)
        } else {
            rest = after;
            daemon.bus.tell(&Change::DeploymentStep { step: step.to_string() });
            take(daemon, step).map(|way_back| undo.extend(way_back)).map_err(|error| Refused {
                step: step.to_string(),
                why: error.why,
                place: place(step).key(error.key),
                timeout: false,
            })
        };
        if let Err(Refused { step, why, place, timeout }) = taken {
            let left = take_back(daemon, undo);
            return Err(ApplyError { step, why, place, timeout, left });
        }
    }
    Ok(())
}

/// The entry of a step in the file.
fn place(step: &Step) -> Spot {
    match step {
        Step::Load(request) => Spot::component(request),
        Step::Connect(entry) => Spot::connection(entry),
        Step::Call(entry) => Spot::request("call", entry),
        Step::Start(entry) => Spot::request("activity", entry),
        Step::Move { .. } | Step::Set(_) => Spot::default(),
    }
}

/// The key of a connection that a refusal is about.
fn key(error: &ConnectError) -> &'static str {
    match error {
        ConnectError::NoSuchInport { .. } => "in",
        ConnectError::Backend(_) => "backend",
        _ => "out",
    }
}

struct Refused {
    step: String,
    why: String,
    place: Spot,
    timeout: bool,
}

/// Takes a step; the way back, when there is something to take back.
fn take(daemon: &Arc<Daemon>, step: &Step) -> Result<Option<Undo>, RequestError> {
    let plain = |why| RequestError { key: Vec::new(), why };
    Ok(match step {
        Step::Load(request) => {
            let hosted = daemon
                .load(request)
                .map_err(|error| RequestError { key: error.key(), why: error.to_string() })?;
            Some(Undo::Unload(hosted.name.clone()))
        }
        Step::Move { component, port, to } => {
            let back = move_to(daemon, component, port.as_deref(), to).map_err(plain)?;
            Some(Undo::Move { component: component.clone(), port: port.clone(), back })
        }
        Step::Set(entry) => {
            request::send(daemon, entry)?;
            Some(Undo::Not(step.to_string()))
        }
        Step::Connect(entry) => {
            let before = present(daemon, entry);
            let request = connect_request(entry);
            connect::connect(daemon, &request).map_err(|error| RequestError {
                key: vec![key(&error).to_owned()],
                why: error.to_string(),
            })?;
            Some(Undo::Reconnect { inport: entry.inport.clone(), before })
        }
        Step::Call(entry) | Step::Start(entry) => {
            let activity = request::send(daemon, entry)?;
            let hosted = daemon.components.get(&entry.component);
            if let (Step::Call(_), Some(number), Some(hosted)) = (step, activity, &hosted) {
                // Called, not started: what comes next may rely on its end.
                let ended = hosted.activities.get(number).map(|activity| activity.wait());
                if let Some(Some(Ending::Exception { name, .. })) = ended {
                    return Err(plain(format!("it ended with {name}")));
                }
            }
            if let Some(hosted) = hosted {
                hosted.done.deployed(&entry.service, entry.inputs.clone());
            }
            match (step, activity) {
                (Step::Start(_), Some(activity)) => {
                    Some(Undo::Abort { component: entry.component.clone(), activity })
                }
                _ => Some(Undo::Not(step.to_string())),
            }
        }
    })
}

/// Moves a component or port; where it was before is given back.
fn move_to(
    daemon: &Arc<Daemon>,
    component: &str,
    port: Option<&str>,
    to: &BackendNames,
) -> Result<BackendNames, String> {
    let Some(hosted) = daemon.components.get(component) else {
        return Err(format!("{component} does not run"));
    };
    let bindings = &hosted.wiring.bindings;
    let before = port.map_or_else(|| bindings.component(), |port| bindings.port(port));
    let index =
        port.and_then(|port| hosted.model().ports.iter().position(|known| known.name == port));
    switch(daemon, &hosted, index, to).map_err(|error| error.to_string())?;
    Ok(before)
}

/// The connection an in port has now.
fn present(daemon: &Daemon, entry: &ConnectionEntry) -> Option<Connection> {
    let hosted = daemon.components.get(entry.reader())?;
    let all = hosted.wiring.connections();
    all.into_iter().find(|present| present.inport.to_string() == entry.inport)
}

/// The request of an entry.
pub(super) fn connect_request(entry: &ConnectionEntry) -> ConnectRequest {
    ConnectRequest {
        inport: entry.inport.clone(),
        outport: entry.outport.clone(),
        policy: entry.policy(),
        backend: entry.backend.clone(),
        wait: false,
        patient: false,
    }
}

/// Makes connections, each as soon as its other side is there.
fn connect_all(
    daemon: &Arc<Daemon>,
    steps: &[Step],
    patience: Option<Duration>,
    undo: &mut Vec<Undo>,
) -> Result<(), Refused> {
    let begin = Instant::now();
    let mut waiting: Vec<&ConnectionEntry> = steps
        .iter()
        .filter_map(|step| if let Step::Connect(entry) = step { Some(entry) } else { None })
        .collect();
    let mut told = false;
    while !waiting.is_empty() {
        let mut absent = Vec::new();
        for entry in waiting {
            let step = Step::Connect(entry.clone()).to_string();
            let before = present(daemon, entry);
            match connect::connect(daemon, &connect_request(entry)) {
                Ok(_) => {
                    daemon.bus.tell(&Change::DeploymentStep { step });
                    undo.push(Undo::Reconnect { inport: entry.inport.clone(), before });
                }
                // A writer elsewhere comes when its daemon does; a slip of the pen waits in
                // vain, and is told.
                Err(ConnectError::NoSuchOutport { message, help, absent: true }) => {
                    absent.push((entry, step, format!("{message}; {help}")));
                }
                Err(error) => {
                    let help = error.help().map(|help| format!("; {help}")).unwrap_or_default();
                    let place = Spot::connection(entry).key([key(&error)]);
                    let why = format!("{error}{help}");
                    return Err(Refused { step, why, place, timeout: false });
                }
            }
        }
        if let Some((entry, step, why)) = absent.first() {
            let place = Spot::connection(entry).key(["out"]);
            if daemon.stopping() {
                let why = "the daemon stops".to_owned();
                return Err(Refused { step: step.clone(), why, place, timeout: false });
            }
            if patience.is_some_and(|patience| begin.elapsed() >= patience) {
                let after = begin.elapsed().as_secs_f64();
                let why = format!("nothing after {after:.1} s: {why}");
                return Err(Refused { step: step.clone(), why, place, timeout: true });
            }
            if !told {
                told = true;
                for (entry, ..) in &absent {
                    tracing::info!(
                        "waiting for {}, which {} shall read",
                        entry.outport,
                        entry.inport
                    );
                    daemon.bus.tell(&Change::DeploymentWaits { what: entry.to_string() });
                }
            }
            std::thread::park_timeout(LOOK);
        }
        waiting = absent.into_iter().map(|(entry, ..)| entry).collect();
    }
    Ok(())
}

/// Takes steps back, the last first; what could not be is named.
fn take_back(daemon: &Arc<Daemon>, undo: Vec<Undo>) -> Vec<String> {
    let mut left = Vec::new();
    for one in undo.into_iter().rev() {
        let undone = match one {
            Undo::Unload(name) => {
                // What was done to it goes with it.
                left.retain(|what: &String| !what.contains(&format!("{name}/")));
                daemon.unload(&name).map_err(|error| error.to_string())
            }
            Undo::Move { component, port, back } => {
                move_to(daemon, &component, port.as_deref(), &back).map(drop)
            }
            Undo::Reconnect { inport, before } => reconnect(daemon, &inport, before),
            Undo::Abort { component, activity } => {
                if let Some(hosted) = daemon.components.get(&component) {
                    hosted.abort(activity);
                }
                Ok(())
            }
            Undo::Not(what) => Err(what),
        };
        left.extend(undone.err());
    }
    left
}

fn reconnect(daemon: &Arc<Daemon>, inport: &str, before: Option<Connection>) -> Result<(), String> {
    match before {
        Some(before) => {
            let request = ConnectRequest {
                inport: inport.to_owned(),
                outport: before.outport.to_string(),
                policy: before.policy,
                backend: before.fixed.then(|| before.backend.clone()),
                wait: true,
                patient: false,
            };
            connect::connect(daemon, &request).map(drop).map_err(|error| {
                format!(
                    "{inport} read {} ({}): {error}",
                    before.outport,
                    policy::text(before.policy)
                )
            })
        }
        None => {
            if let Ok((hosted, port, element)) = connect::reader(daemon, inport) {
                connect::disconnect(daemon, &hosted, port, element.as_deref());
            }
            Ok(())
        }
    }
}
