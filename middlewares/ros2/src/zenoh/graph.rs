//! The graph: our ends, and those of others as their liveliness tokens tell of them.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use genom_middleware::{Address, Endpoint, EndpointKind, OpenError};
use genom_rosidl::TypeName;

use super::keys::{self, End, Id, Kind};
use super::told::Told;
use crate::rmw::{Gid, Service, Wanted};

/// How long the news that an end was closed elsewhere may take to arrive.
const GRACE: Duration = Duration::from_millis(100);

#[derive(Debug, Default)]
struct State {
    own: HashMap<u64, Wanted>,
    next: u64,
    /// Ends of others, as ROS knows them; those of daemons are among them.
    found: HashMap<Id, (End, Gid)>,
    /// What daemons tell of theirs.
    told: HashMap<Id, Told>,
    /// Sessions of daemons. Their ends of which nothing is told are no ends of components.
    daemons: HashSet<String>,
}

/// All known ends.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    state: Mutex<State>,
    changed: Condvar,
}

/// Keeps an end of ours registered here.
pub(crate) struct Registered {
    graph: Arc<Graph>,
    number: u64,
}

enum Conflict {
    Types(String),
    Taken,
}

fn kind_of(kind: Kind) -> Option<EndpointKind> {
    match kind {
        Kind::Publisher => Some(EndpointKind::Publisher),
        Kind::Subscription => Some(EndpointKind::Subscription),
        Kind::Server => Some(EndpointKind::Service),
        Kind::Client => None,
    }
}

impl Graph {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, state: MutexGuard<'a, State>, left: Duration) -> MutexGuard<'a, State> {
        self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0
    }

    /// An end of another session appeared. Returns its topic if it is a writer.
    pub(crate) fn found(&self, end: End, gid: Gid) -> Option<String> {
        let writes = (end.kind == Kind::Publisher).then(|| end.name.clone());
        self.lock().found.insert(end.id(), (end, gid));
        self.changed.notify_all();
        writes
    }

    /// A daemon tells of an end. Returns its topic if it is a writer that is known already: a new
    /// way to a session may bring its tokens in any order.
    pub(crate) fn told(&self, id: Id, told: Told) -> Option<String> {
        let mut state = self.lock();
        let found = state.found.get(&id).filter(|(end, _)| end.kind == Kind::Publisher);
        let writes = found.map(|(end, _)| end.name.clone());
        state.daemons.insert(id.0.clone());
        state.told.insert(id, told);
        drop(state);
        self.changed.notify_all();
        writes
    }

    /// An end of another session is gone.
    pub(crate) fn lost(&self, id: &Id) {
        let mut state = self.lock();
        state.found.remove(id);
        state.forget(&id.0);
        drop(state);
        self.changed.notify_all();
    }

    /// A daemon tells no more of an end.
    pub(crate) fn untold(&self, id: &Id) {
        let mut state = self.lock();
        state.told.remove(id);
        state.forget(&id.0);
        drop(state);
        self.changed.notify_all();
    }

    /// Registers an end of ours, unless it conflicts with another one.
    pub(crate) fn register(
        self: &Arc<Self>,
        at: &Address,
        wanted: Wanted,
    ) -> Result<Registered, OpenError> {
        let end = Instant::now() + GRACE;
        let mut state = self.lock();
        while let Some((conflict, ours)) = state.conflict(&wanted) {
            let left = end.saturating_duration_since(Instant::now());
            if ours || left.is_zero() {
                let address = at.clone();
                return Err(match conflict {
                    Conflict::Types(theirs) => {
                        OpenError::TypeMismatch { address, ours: wanted.types, theirs }
                    }
                    Conflict::Taken => OpenError::Taken { address },
                });
            }
            state = self.wait(state, left);
        }
        let number = state.next;
        state.next += 1;
        state.own.insert(number, wanted);
        Ok(Registered { graph: Arc::clone(self), number })
    }

    /// Whether a service exists, and its types if they are known to differ. Waits until `end` for
    /// one that is not known.
    pub(crate) fn service(&self, wanted: &Wanted, end: Instant) -> Service {
        let mut state = self.lock();
        loop {
            let found = state.service(wanted);
            let left = end.saturating_duration_since(Instant::now());
            if found != Service::Nobody || left.is_zero() {
                return found;
            }
            state = self.wait(state, left);
        }
    }

    /// Type and hash, as tokens spell them, of all writers that a reader of this digest can read:
    /// daemons' types of equal members may have other names. Also of this daemon.
    pub(crate) fn equals(&self, name: &str, digest: &str) -> HashSet<(String, String)> {
        let state = self.lock();
        let own = state.own.values().filter(|own| {
            own.kind == EndpointKind::Publisher && own.of.name == name && own.digest == digest
        });
        let own = own.filter_map(|own| Some((own.of.ty.to_dds(""), own.of.hash.clone()?)));
        let theirs = state.found.values().filter(|(end, _)| {
            let told = state.told.get(&end.id());
            end.kind == Kind::Publisher
                && end.name == name
                && told.is_some_and(|told| told.digest == digest)
        });
        own.chain(theirs.map(|(end, _)| (end.ty.clone(), end.hash.clone()))).collect()
    }

    /// The ends of ROS nodes and daemons on a topic, without those of this daemon.
    pub(crate) fn others(&self, name: &str) -> Vec<End> {
        let state = self.lock();
        let all = state.found.values().map(|(end, _)| end).filter(|end| end.name == name);
        all.cloned().collect()
    }

    /// Our ends on a topic.
    pub(crate) fn ours(&self, name: &str) -> Vec<Wanted> {
        self.lock().own.values().filter(|own| own.of.name == name).cloned().collect()
    }

    pub(crate) fn list(&self) -> Vec<Endpoint> {
        let state = self.lock();
        let short = |types: &str, kind| match kind {
            EndpointKind::Service => types.to_owned(),
            _ => types.split(" (").next().unwrap_or_default().to_owned(),
        };
        let end = |kind, address: &str, types: &str| Endpoint {
            kind,
            address: address.to_owned(),
            ty: short(types, kind),
        };
        let own = state.own.values().map(|own| end(own.kind, &own.address, &own.types));
        let told = state.told.values().map(|told| end(told.kind, &told.address, &told.types));
        let foreign = state.found.values().filter_map(|(found, _)| {
            let kind = kind_of(found.kind)?;
            let ty = TypeName::from_dds(&found.ty);
            let ours = state.daemons.contains(&found.node.session);
            (!ours).then(|| Endpoint { kind, address: found.name.clone(), ty })
        });
        own.chain(told).chain(foreign).collect()
    }
}

impl State {
    /// Forgets a session of which nothing is left.
    fn forget(&mut self, session: &str) {
        let of = |id: &Id| id.0 == session;
        if !self.told.keys().any(of) && !self.found.keys().any(of) {
            self.daemons.remove(session);
        }
    }

    /// The conflict with an existing end, if any, and whether that end is ours.
    fn conflict(&self, wanted: &Wanted) -> Option<(Conflict, bool)> {
        let is_port = |kind| kind != EndpointKind::Service;
        let port = is_port(wanted.kind);
        let alone = wanted.kind != EndpointKind::Subscription;
        let mut taken = None;
        for other in self.own.values().filter(|other| other.address == wanted.address) {
            if is_port(other.kind) != port {
                continue;
            }
            if port && other.digest != wanted.digest {
                return Some((Conflict::Types(other.types.clone()), true));
            }
            if alone && other.kind == wanted.kind {
                taken = Some((Conflict::Taken, true));
            }
        }
        for other in self.told.values().filter(|other| other.address == wanted.address) {
            if is_port(other.kind) != port {
                continue;
            }
            if port && other.digest != wanted.digest {
                return Some((Conflict::Types(other.types.clone()), false));
            }
            if alone && other.kind == wanted.kind {
                taken.get_or_insert((Conflict::Taken, false));
            }
        }
        let ty = wanted.of.ty.to_dds("");
        let foreign = self.found.values().map(|(end, _)| end).filter(|end| {
            port && end.name == wanted.of.name
                && kind_of(end.kind).is_some_and(is_port)
                && !self.daemons.contains(&end.node.session)
        });
        for end in foreign {
            if end.ty != ty {
                return Some((Conflict::Types(TypeName::from_dds(&end.ty)), false));
            }
        }
        taken
    }

    fn service(&self, wanted: &Wanted) -> Service {
        let own = self.own.values();
        let mut own = own.filter(|own| own.kind == EndpointKind::Service);
        if let Some(own) = own.find(|own| own.address == wanted.address) {
            return service_of(&own.digest, &own.types, wanted, None);
        }
        let ty = wanted.of.ty.to_dds("");
        let mut there = Service::Nobody;
        let servers = self
            .found
            .values()
            .filter(|(end, _)| end.kind == Kind::Server && end.name == wanted.of.name);
        for (end, gid) in servers {
            match self.told.get(&end.id()) {
                Some(told) => return service_of(&told.digest, &told.types, wanted, Some(*gid)),
                None if self.daemons.contains(&end.node.session) => {}
                None if end.ty != ty => {
                    return Service::Differs(TypeName::from_dds(&end.ty));
                }
                // zenoh does not connect the two.
                None if end.hash != keys::NO_HASH && wanted.of.hash.as_ref() != Some(&end.hash) => {
                    let ty = TypeName::from_dds(&end.ty);
                    return Service::Differs(format!("{ty} ({})", end.hash));
                }
                None => there = Service::There(Some(*gid)),
            }
        }
        there
    }
}

/// A service with these types.
fn service_of(digest: &str, types: &str, wanted: &Wanted, server: Option<Gid>) -> Service {
    if digest == wanted.digest {
        Service::There(server)
    } else {
        Service::Differs(types.to_owned())
    }
}

impl Drop for Registered {
    fn drop(&mut self) {
        self.graph.lock().own.remove(&self.number);
        self.graph.changed.notify_all();
    }
}

#[cfg(test)]
#[path = "../../tests/unit/zenoh_graph.rs"]
mod tests;
