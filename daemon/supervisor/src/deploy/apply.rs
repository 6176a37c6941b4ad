//! Takes the steps of a deployment, waits for the other sides of connections, and undoes everything
//! when a step fails.

use std::sync::Arc;
use std::time::{Duration, Instant};

use genom_description::model::ServiceKind;

use super::error::StepError;
use super::step::Step;
use super::undo::{Gone, Requested, Running, Undo, move_to, take_away, take_back};
use crate::components::{Components, UnloadError, request};
use crate::connections::Wanted;
use crate::outcome::Outcome;
use crate::supervisor::Supervisor;
use genom_bus::{Bus, Change, StepStatus};
use genom_configuration::{CallEntry, ConnectionEntry, Spot};

/// How often to check for the other side of a connection: discovery does not notify.
const LOOK: Duration = Duration::from_millis(20);

/// Why a deployment could not be applied.
#[derive(Debug, thiserror::Error)]
#[error("{step}: {why}{}", remaining(.left))]
pub struct ApplyError {
    /// The step that failed.
    pub step: String,
    /// Why it failed.
    #[source]
    pub why: Box<StepError>,
    /// The entry of the file that asks for it.
    pub place: Spot,
    /// What could not be undone.
    pub left: Vec<String>,
}

fn remaining(left: &[String]) -> String {
    if left.is_empty() {
        return String::new();
    }
    format!("; all is as it was, but for: {}", left.join(", "))
}

/// Takes all steps in order. Each connection waits for its other side for at most `patience`.
/// Returns how to undo them. Blocks.
pub(super) fn apply(
    supervisor: &Arc<Supervisor>,
    steps: &[Step],
    patience: Option<Duration>,
) -> Result<Vec<Undo>, ApplyError> {
    let ran = Running::now(&supervisor.components);
    let mut undo = Vec::new();
    let mut rest = steps;
    while let Some((step, after)) = rest.split_first() {
        let taken = if let Step::Connect(_) = step {
            // Consecutive connections are made together, so that one that waits does not delay the
            // others.
            let connects = rest.iter().map_while(Step::connection).collect::<Vec<_>>();
            rest = &rest[connects.len()..];
            connect_all(supervisor, connects, patience, &mut undo)
        } else {
            rest = after;
            tell(&supervisor.bus, step, StepStatus::Begun);
            take(supervisor, step, &ran, &mut undo)
                .inspect(|()| tell(&supervisor.bus, step, StepStatus::Done))
        };
        if let Err(Refused { step, why, place }) = taken {
            let left = take_back(supervisor, undo);
            return Err(ApplyError { step, why, place, left });
        }
    }
    Ok(undo)
}

fn tell(bus: &Bus, step: &Step, status: StepStatus) {
    bus.tell(&Change::DeploymentStep { step: step.to_string(), status });
}

/// A step that failed.
struct Refused {
    step: String,
    why: Box<StepError>,
    place: Spot,
}

impl Refused {
    fn new<S: Into<String>>(
        step: &Step,
        key: impl IntoIterator<Item = S>,
        why: impl Into<StepError>,
    ) -> Self {
        let place = match step {
            Step::Load(request) | Step::Reload { request, .. } => Spot::component(request),
            Step::Unload(_) => Spot::default(),
            Step::Disconnect(entry) => Spot::connection(entry),
            Step::Move { component, .. } => Spot::named(component),
            Step::Set(entry) => Spot::named(&entry.component),
            Step::Connect(entry) => Spot::connection(entry),
            Step::Call(entry) => Spot::request("call", entry),
            Step::Start(entry) => Spot::request("activity", entry),
        };
        let place = place.key(key);
        Self { step: step.to_string(), why: Box::new(why.into()), place }
    }
}

/// Takes a step, and pushes how to undo it.
fn take(
    supervisor: &Arc<Supervisor>,
    step: &Step,
    ran: &Running,
    undo: &mut Vec<Undo>,
) -> Result<(), Refused> {
    let (components, connections) = (&supervisor.components, &supervisor.connections);
    match step {
        Step::Load(request) => {
            let loaded = supervisor.load(request);
            let hosted = loaded.map_err(|error| Refused::new(step, error.key(), error))?;
            undo.push(Undo::Unload(hosted.name.clone()));
        }
        Step::Reload { request, .. } => {
            let name = request.instance();
            let none: [&str; 0] = [];
            take_down(supervisor, &name, undo).map_err(|why| Refused::new(step, none, why))?;
            let loaded = supervisor.load(request);
            loaded.map_err(|error| Refused::new(step, error.key(), error))?;
        }
        Step::Unload(name) => {
            let none: [&str; 0] = [];
            take_down(supervisor, name, undo).map_err(|why| Refused::new(step, none, why))?;
        }
        Step::Disconnect(entry) => {
            let before = connections.present(&entry.inport);
            take_away(connections.disconnect(&entry.inport))
                .map_err(|error| Refused::new(step, ["in"], StepError::Disconnect(error)))?;
            undo.push(Undo::Reconnect { inport: entry.inport.clone(), before });
        }
        Step::Move { component, port, to } => {
            let key = port.as_ref().map_or(vec!["backend"], |port| vec!["ports", port]);
            let moved = move_to(components, connections, component, port.as_deref(), to);
            undo.push(Undo::Move(moved.map_err(|why| Refused::new(step, key, why))?));
        }
        Step::Set(entry) => {
            let before = Requested::before(components, entry, step.to_string(), ran);
            request::send(components, entry).map_err(|error| {
                // In the file the inputs stand directly under the service's name.
                let members = error.key.iter().filter(|key| *key != "inputs").cloned();
                let key = ["attributes".to_owned(), entry.service.clone()];
                let key: Vec<String> = key.into_iter().chain(members).collect();
                Refused::new(step, key, error)
            })?;
            undo.push(Undo::Request(before));
        }
        // Handled by `connect_all`.
        Step::Connect(_) => {}
        Step::Call(entry) | Step::Start(entry) => {
            if let Step::Start(_) = step {
                is_activity(components, entry)
                    .map_err(|why| Refused::new(step, ["service"], why))?;
            }
            let before = Requested::before(components, entry, step.to_string(), ran);
            let activity = request::send(components, entry)
                .map_err(|error| Refused::new(step, error.key.clone(), error))?;
            let hosted = components.get(&entry.component);
            match (step, activity, &hosted) {
                (Step::Start(_), Some(number), _) => {
                    undo.push(Undo::Request(before.started(number)));
                }
                (_, Some(number), Some(hosted)) => {
                    undo.push(Undo::Request(before));
                    // Waits for the end, because later steps may depend on it.
                    let ended = hosted.activities.get(number).map(|activity| activity.wait());
                    if let Some(Some(Outcome::Exception { name, .. })) = ended {
                        return Err(Refused::new(step, ["service"], StepError::Exception(name)));
                    }
                }
                _ => undo.push(Undo::Request(before)),
            }
            if let Some(hosted) = hosted {
                hosted.standing.deployed(&entry.service, entry.inputs.clone());
            }
        }
    }
    Ok(())
}

/// Stops a component, such that it can be loaded again.
fn take_down(
    supervisor: &Arc<Supervisor>,
    name: &str,
    undo: &mut Vec<Undo>,
) -> Result<(), UnloadError> {
    let before = supervisor.components.get(name).map(|hosted| Gone::of(&hosted));
    undo.extend(before.map(|before| Undo::PutBack(Box::new(before))));
    supervisor.unload(name)
}

/// Fails if the service is not an activity: an attribute or function would be over at once.
fn is_activity(components: &Components, entry: &CallEntry) -> Result<(), StepError> {
    let hosted = components.get(&entry.component);
    let services = hosted.as_ref().map_or(&[][..], |hosted| &hosted.model().services);
    let kind = match services.iter().find(|one| one.name == entry.service).map(|one| one.kind) {
        Some(ServiceKind::Attribute) => "an attribute",
        Some(ServiceKind::Function) => "a function",
        Some(ServiceKind::Activity) | None => return Ok(()),
    };
    let (component, service) = (entry.component.clone(), entry.service.clone());
    Err(StepError::NoActivity { component, service, kind })
}

/// Makes connections, each as soon as its other side is there.
fn connect_all(
    supervisor: &Arc<Supervisor>,
    mut waiting: Vec<&ConnectionEntry>,
    patience: Option<Duration>,
    undo: &mut Vec<Undo>,
) -> Result<(), Refused> {
    let begin = Instant::now();
    let mut told = false;
    while !waiting.is_empty() {
        let mut absent = Vec::new();
        for entry in waiting {
            let step = Step::Connect(entry.clone());
            let before = supervisor.connections.present(&entry.inport);
            match supervisor.connections.make(&Wanted::from(entry)) {
                Ok(_) => {
                    tell(&supervisor.bus, &step, StepStatus::Done);
                    undo.push(Undo::Reconnect { inport: entry.inport.clone(), before });
                }
                // The other side may appear with its daemon. A misspelt name is therefore waited
                // for until the timeout, and reported then.
                Err(error) if error.is_absent() => absent.push((entry, step, error)),
                Err(error) => return Err(Refused::new(&step, [error.key()], error)),
            }
        }
        if let Some((_, step, _)) = absent.first() {
            if supervisor.stopping() {
                return Err(Refused::new(step, ["out"], StepError::Stopping));
            }
            if patience.is_some_and(|patience| begin.elapsed() >= patience) {
                let (_, step, source) = absent.swap_remove(0);
                let why = StepError::Absent { after: begin.elapsed(), source };
                return Err(Refused::new(&step, ["out"], why));
            }
            if !told {
                told = true;
                for (_, step, _) in &absent {
                    tracing::info!("waiting to {step}");
                    supervisor.bus.tell(&Change::DeploymentWaits { step: step.to_string() });
                }
            }
            std::thread::park_timeout(LOOK);
        }
        waiting = absent.into_iter().map(|(entry, ..)| entry).collect();
    }
    Ok(())
}
