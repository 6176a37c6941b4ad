//! The graph: our ends, and those of others as their liveliness tokens tell of them.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use genom_middleware::{Address, Endpoint, EndpointKind, OpenError};
use genom_rosidl::TypeName;

use super::keys::{self, End, Id, Kind};
use super::refusals::Reason;
use super::told::Told;
use crate::conflict::{Conflict, is_port, unopposed};
use crate::rmw::{Gid, Service, Wanted};
use crate::settled::settled;

/// Number of ends that may be known of one session: as ROS tells of them, and as daemons do.
const ENDS: usize = 32_768;

/// The same of all sessions together.
const ALL_ENDS: usize = 131_072;

/// Another session of which ends are known.
#[derive(Debug, Default)]
struct Known {
    /// Number of its ends in `found` and in `told`.
    ends: usize,
    /// Whether it is that of a daemon. Ends of a daemon of which nothing is told are no ends of
    /// components.
    daemon: bool,
}

#[derive(Debug)]
struct State {
    own: HashMap<u64, Wanted>,
    next: u64,
    /// Ends of others, as ROS knows them; those of daemons are among them.
    found: HashMap<Id, (End, Gid)>,
    /// What daemons tell of theirs.
    told: HashMap<Id, Told>,
    /// By name. Anybody may tell of ends in the name of any session, which only zenoh's access
    /// control prevents.
    sessions: HashMap<String, Known>,
    /// Number of sessions that may be known.
    most: usize,
}

/// All known ends.
#[derive(Debug)]
pub(crate) struct Graph {
    state: Mutex<State>,
    changed: Condvar,
}

/// Keeps an end of ours registered here.
pub(crate) struct Registered {
    graph: Arc<Graph>,
    number: u64,
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
    /// Knows the ends of at most this number of other sessions.
    pub(crate) fn new(sessions: usize) -> Self {
        let state = State {
            own: HashMap::new(),
            next: 0,
            found: HashMap::new(),
            told: HashMap::new(),
            sessions: HashMap::new(),
            most: sessions,
        };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// An end of another session appeared. Returns its topic if it is a writer.
    pub(crate) fn found(&self, end: End, gid: Gid) -> Result<Option<String>, Reason> {
        let writes = (end.kind == Kind::Publisher).then(|| end.name.clone());
        let (mut state, id) = (self.lock(), end.id());
        if !state.found.contains_key(&id) {
            state.admit(&id.0)?;
        }
        state.found.insert(id, (end, gid));
        drop(state);
        self.changed.notify_all();
        Ok(writes)
    }

    /// A daemon tells of an end. Returns its topic if it is a writer that is known already: a new
    /// way to a session may bring its tokens in any order.
    pub(crate) fn told(&self, id: Id, told: Told) -> Result<Option<String>, Reason> {
        let mut state = self.lock();
        if !state.told.contains_key(&id) {
            state.admit(&id.0)?;
        }
        let found = state.found.get(&id).filter(|(end, _)| end.kind == Kind::Publisher);
        let writes = found.map(|(end, _)| end.name.clone());
        if let Some(session) = state.sessions.get_mut(&id.0) {
            session.daemon = true;
        }
        state.told.insert(id, told);
        drop(state);
        self.changed.notify_all();
        Ok(writes)
    }

    /// An end of another session is gone.
    pub(crate) fn lost(&self, id: &Id) {
        let mut state = self.lock();
        if state.found.remove(id).is_some() {
            state.forget(&id.0);
        }
        drop(state);
        self.changed.notify_all();
    }

    /// A daemon tells no more of an end.
    pub(crate) fn untold(&self, id: &Id) {
        let mut state = self.lock();
        if state.told.remove(id).is_some() {
            state.forget(&id.0);
        }
        drop(state);
        self.changed.notify_all();
    }

    /// Registers an end of ours, unless it conflicts with another one.
    pub(crate) fn register(
        self: &Arc<Self>,
        at: &Address,
        wanted: Wanted,
    ) -> Result<Registered, OpenError> {
        let look = |state: &State| state.conflict(&wanted);
        let mut state = unopposed(&self.changed, self.lock(), (at, &wanted.types), look)?;
        let number = state.next;
        state.next += 1;
        state.own.insert(number, wanted);
        Ok(Registered { graph: Arc::clone(self), number })
    }

    /// Whether a service exists, and its types if they are known to differ. Waits until `end` for
    /// one that is not known.
    pub(crate) fn service(&self, wanted: &Wanted, end: Instant) -> Service {
        let known = |found: &Service| *found != Service::Nobody;
        settled(&self.changed, self.lock(), end, |state| state.service(wanted), known).1
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

    /// Type and hash, as tokens spell them, of the server of this name in the session of that end:
    /// a caller's type of equal members may have another name.
    pub(crate) fn server(&self, name: &str, beside: Gid) -> Option<(String, String)> {
        let state = self.lock();
        let (of, _) = state.found.values().find(|(_, gid)| *gid == beside)?;
        let is_it = |end: &&End| {
            end.kind == Kind::Server && end.name == name && end.node.session == of.node.session
        };
        let server = state.found.values().map(|(end, _)| end).find(is_it)?;
        Some((server.ty.clone(), server.hash.clone()))
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

    /// All our ends.
    pub(crate) fn all_ours(&self) -> Vec<Wanted> {
        self.lock().own.values().cloned().collect()
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
            (!state.is_daemon(&found.node.session)).then(|| Endpoint {
                kind,
                address: found.name.clone(),
                ty,
            })
        });
        own.chain(told).chain(foreign).collect()
    }
}

impl State {
    /// Counts another end of a session, unless there are too many.
    fn admit(&mut self, session: &str) -> Result<(), Reason> {
        if self.found.len() + self.told.len() >= ALL_ENDS {
            return Err(Reason::Ends);
        }
        let known = self.sessions.len();
        match self.sessions.entry(session.to_owned()) {
            Entry::Occupied(of) if of.get().ends >= ENDS => return Err(Reason::Ends),
            Entry::Occupied(mut of) => of.get_mut().ends += 1,
            Entry::Vacant(_) if known >= self.most => return Err(Reason::Sessions),
            Entry::Vacant(of) => {
                of.insert(Known { ends: 1, daemon: false });
            }
        }
        Ok(())
    }

    /// Counts one end of a session less, and forgets the session with its last one.
    fn forget(&mut self, session: &str) {
        let Some(of) = self.sessions.get_mut(session) else { return };
        of.ends -= 1;
        if of.ends == 0 {
            self.sessions.remove(session);
        }
    }

    fn is_daemon(&self, session: &str) -> bool {
        self.sessions.get(session).is_some_and(|session| session.daemon)
    }

    /// The conflict with an existing end, if any, and whether that end is ours.
    fn conflict(&self, wanted: &Wanted) -> Option<(Conflict, bool)> {
        let (port, ours) = (is_port(wanted.kind), (wanted.kind, wanted.digest.as_str()));
        let mut taken = None;
        let own = self.own.values().filter(|own| own.address == wanted.address);
        let own = own.map(|own| ((own.kind, &*own.digest, &*own.types), true));
        let told = self.told.values().filter(|told| told.address == wanted.address);
        let told = told.map(|told| ((told.kind, &*told.digest, &*told.types), false));
        for (other, is_ours) in own.chain(told) {
            match Conflict::between(ours, other) {
                Some(Conflict::Taken) => _ = taken.get_or_insert((Conflict::Taken, is_ours)),
                Some(types) => return Some((types, is_ours)),
                None => {}
            }
        }
        let ty = wanted.of.ty.to_dds("");
        let foreign = self.found.values().map(|(end, _)| end).filter(|end| {
            port && end.name == wanted.of.name
                && kind_of(end.kind).is_some_and(is_port)
                && !self.is_daemon(&end.node.session)
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
                None if self.is_daemon(&end.node.session) => {}
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
mod tests;
