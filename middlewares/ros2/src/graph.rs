//! Who is there: our ends, and those of others as DDS and their daemons tell.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use genom_middleware::{Address, Endpoint, EndpointKind, OpenError};
use genom_rosidl::TypeName;
use rustdds::{EndpointDescription, GUID, QosPolicies};

use crate::info::{self, End, Ends, Gid, Node, Nodes};
use crate::process::Process;

/// Daemons whose words are kept while they are away.
const MANY: usize = 256;

/// News of an end that is just being closed elsewhere may be under way for so long.
const GRACE: Duration = Duration::from_millis(100);

/// An end that is to be opened.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    pub(crate) kind: EndpointKind,
    /// The address with the namespace in front.
    pub(crate) address: String,
    /// Full types, for messages.
    pub(crate) types: String,
    pub(crate) digest: String,
    /// DDS name of the topic (of a service, of its requests) and of its type.
    pub(crate) topic: String,
    pub(crate) dds_type: String,
    /// By which ROS nodes know the message of a port.
    pub(crate) hash: Option<String>,
    /// The node it belongs to: the instance.
    pub(crate) node: String,
}

#[derive(Debug)]
struct Own {
    wanted: Wanted,
    /// Known once they are made. Locked within the state, for an instant.
    made: Mutex<Option<Made>>,
}

/// What an end of ours is in DDS.
#[derive(Clone, Debug, Default)]
pub(crate) struct Made {
    /// The one that stands for the end first, of these or those.
    pub(crate) writers: Vec<Gid>,
    pub(crate) readers: Vec<Gid>,
    /// What the writer of an out port offers.
    pub(crate) offers: Option<QosPolicies>,
}

impl Own {
    fn made(&self) -> MutexGuard<'_, Option<Made>> {
        self.made.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What DDS tells of an end of others.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) topic: String,
    pub(crate) dds_type: String,
    pub(crate) writer: bool,
    /// What it offers, or asks for.
    pub(crate) qos: QosPolicies,
    /// By which ROS nodes know the message, where it is told.
    pub(crate) hash: Option<String>,
}

impl Found {
    /// The end that DDS describes.
    pub(crate) fn new(end: EndpointDescription, writer: bool) -> Self {
        // REP-2016: `typehash=RIHS01_...;` among other words, after the length of all.
        let text = String::from_utf8_lossy(&end.user_data);
        let hash = text.split_once("typehash=").and_then(|(_, rest)| rest.split(';').next());
        let hash = hash.map(str::to_owned);
        Self { topic: end.topic_name, dds_type: end.type_name, writer, qos: end.qos, hash }
    }
}

#[derive(Debug, Default)]
struct State {
    own: HashMap<u64, Arc<Own>>,
    /// What belongs to our nodes and is no end of ours.
    others: HashMap<u64, Entities>,
    next: u64,
    found: HashMap<GUID, Found>,
    /// What daemons tell, by the writer they tell it with.
    told: HashMap<GUID, (Process, HashMap<GUID, End>)>,
}

/// All ends that are known.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    state: Mutex<State>,
    changed: Condvar,
    /// Goes up with every change, so that verdicts may be kept.
    version: AtomicU64,
}

/// Keeps an end of ours known, here and to others.
pub(crate) struct Claim {
    graph: Arc<Graph>,
    number: u64,
    own: Arc<Own>,
    /// Has others told of the change.
    announce: Box<dyn Fn() + Send + Sync>,
}

/// DDS writers and readers of a node.
#[derive(Clone, Debug)]
pub(crate) struct Entities {
    pub(crate) node: String,
    pub(crate) writers: Vec<Gid>,
    pub(crate) readers: Vec<Gid>,
}

/// Keeps writers and readers known as a node's.
pub(crate) struct Belonging {
    graph: Arc<Graph>,
    number: u64,
    announce: Box<dyn Fn() + Send + Sync>,
}

enum Conflict {
    Types(String),
    Taken,
}

impl Graph {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn touch(&self) {
        self.version.fetch_add(1, Ordering::Release);
        self.changed.notify_all();
    }

    pub(crate) fn version(&self) -> u64 {
        self.version.load(Ordering::Acquire)
    }

    /// Registers an end of ours, unless another one is in the way.
    pub(crate) fn claim(
        self: &Arc<Self>,
        at: &Address,
        wanted: Wanted,
        announce: Box<dyn Fn() + Send + Sync>,
    ) -> Result<Claim, OpenError> {
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
            let waited = self.changed.wait_timeout(state, left);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        let own = Arc::new(Own { wanted, made: Mutex::default() });
        let number = state.next;
        state.next += 1;
        state.own.insert(number, Arc::clone(&own));
        drop(state);
        self.touch();
        Ok(Claim { graph: Arc::clone(self), number, own, announce })
    }

    /// Tells of writers and readers that are no end of ours.
    pub(crate) fn belong(
        self: &Arc<Self>,
        entities: Entities,
        announce: Box<dyn Fn() + Send + Sync>,
    ) -> Belonging {
        let mut state = self.lock();
        let number = state.next;
        state.next += 1;
        state.others.insert(number, entities);
        drop(state);
        announce();
        Belonging { graph: Arc::clone(self), number, announce }
    }

    /// DDS found an end of others; whether it was not known yet.
    pub(crate) fn found(&self, guid: GUID, found: Found) -> bool {
        let known = self.lock().found.insert(guid, found);
        self.touch();
        known.is_none()
    }

    /// DDS lost an end of others.
    pub(crate) fn lost(&self, guid: &GUID) {
        if self.lock().found.remove(guid).is_some() {
            self.touch();
        }
    }

    /// A whole participant is gone: its ends. What it told stays if it may come back, since it
    /// does not tell that again.
    pub(crate) fn lost_all(&self, of: impl Fn(&GUID) -> bool, may_return: bool) -> Vec<Found> {
        let mut state = self.lock();
        let ends = state.found.extract_if(|guid, _| of(guid)).map(|(_, found)| found).collect();
        if !may_return || state.told.len() > MANY {
            state.told.retain(|guid, _| !of(guid));
        }
        drop(state);
        self.touch();
        ends
    }

    /// A daemon told its ends, all of them.
    pub(crate) fn told(&self, by: GUID, ends: Ends) {
        let known = ends.ends.into_iter().map(|end| (end.guid(), end)).collect();
        self.lock().told.insert(by, (ends.process, known));
        self.touch();
    }

    /// What is known of a writer, to one who reads this type.
    pub(crate) fn writes(&self, writer: &GUID, digest: &str, dds_type: &str) -> Verdict {
        let state = self.lock();
        let gid = writer.to_bytes();
        let own =
            |own: &&Arc<Own>| own.made().as_ref().is_some_and(|made| made.writers.contains(&gid));
        if let Some(own) = state.own.values().find(own) {
            return Verdict::of(own.wanted.digest == digest);
        }
        let told = state.told.values().find_map(|(_, ends)| ends.get(writer));
        match (told, state.found.get(writer)) {
            (Some(end), Some(_)) => Verdict::of(end.digest == digest),
            (None, Some(_)) if state.is_daemon(writer) => Verdict::Unknown,
            (None, Some(found)) => Verdict::of(found.dds_type == dds_type),
            (_, None) => Verdict::Unknown,
        }
    }

    /// Whether a writer is a port of a genomd.
    pub(crate) fn is_told(&self, writer: &GUID) -> bool {
        self.lock().told_of(writer).is_some()
    }

    /// Whether a service is there, and its types where they are known to differ. Until `end` one
    /// that is not there is waited for: others become known little by little.
    pub(crate) fn service(&self, wanted: &Wanted, end: Instant) -> Service {
        let mut state = self.lock();
        loop {
            let found = state.service(wanted);
            let left = end.saturating_duration_since(Instant::now());
            if found != Service::Nobody || left.is_zero() {
                return found;
            }
            let waited = self.changed.wait_timeout(state, left);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
    /// A reader of ours was made anew, with another id.
    pub(crate) fn renamed(&self, old: GUID, new: GUID) {
        let state = self.lock();
        let (old, new) = (old.to_bytes(), new.to_bytes());
        for own in state.own.values() {
            let mut made = own.made();
            let readers = made.iter_mut().flat_map(|made| &mut made.readers);
            readers.filter(|gid| **gid == old).for_each(|gid| *gid = new);
        }
        drop(state);
        self.touch();
    }

    /// Ends of others on a topic, with what they offer or ask for: writers or readers.
    pub(crate) fn others(&self, topic: &str, writers: bool) -> Vec<(GUID, Found)> {
        let state = self.lock();
        let all = state.found.iter().filter(|(guid, found)| {
            found.topic == topic && found.writer == writers && !state.is_dead(guid)
        });
        all.map(|(guid, found)| (*guid, found.clone())).collect()
    }

    /// Our out port on a topic, and what it offers.
    pub(crate) fn writer(&self, topic: &str) -> Option<(Wanted, QosPolicies)> {
        let state = self.lock();
        let mut own = state.own.values().filter(|own| own.wanted.topic == topic);
        own.find_map(|own| Some((own.wanted.clone(), own.made().as_ref()?.offers.clone()?)))
    }

    pub(crate) fn list(&self) -> Vec<Endpoint> {
        let state = self.lock();
        let short = |types: &str, kind| match kind {
            EndpointKind::Service => types.to_owned(),
            _ => types.split(" (").next().unwrap_or_default().to_owned(),
        };
        let own = state.own.values().map(|own| Endpoint {
            kind: own.wanted.kind,
            address: own.wanted.address.clone(),
            ty: short(&own.wanted.types, own.wanted.kind),
        });
        let others = state.found.iter().filter(|(guid, _)| !state.is_dead(guid));
        let others = others.filter_map(|(guid, found)| match state.told_of(guid) {
            Some(end) => {
                let kind = kind_of(end.kind)?;
                Some(Endpoint { kind, address: end.address.clone(), ty: short(&end.types, kind) })
            }
            // A daemon's end that was not told yet, or one of its own affairs.
            None if state.is_daemon(guid) => None,
            None => foreign(found),
        });
        own.chain(others).collect()
    }

    /// What we tell others: our ends, and our nodes with all their writers and readers.
    pub(crate) fn ours(&self, namespace: &str) -> (Vec<End>, Vec<Node>) {
        let state = self.lock();
        let mut ends = Vec::new();
        let mut nodes: Vec<Node> = Vec::new();
        let mut put = |name: &str, writers: &[Gid], readers: &[Gid]| {
            if let Some(node) = nodes.iter_mut().find(|node| node.name == name) {
                node.readers.extend(readers);
                node.writers.extend(writers);
                return;
            }
            nodes.push(Node {
                namespace: format!("/{}", namespace.trim_matches('/')),
                name: name.to_owned(),
                readers: readers.to_vec(),
                writers: writers.to_vec(),
            });
        };
        for own in state.own.values() {
            let Some(Made { writers, readers, .. }) = own.made().clone() else { continue };
            let wanted = &own.wanted;
            let first = match wanted.kind {
                EndpointKind::Publisher => writers.first(),
                _ => readers.first(),
            };
            if let Some(&gid) = first {
                ends.push(End {
                    gid,
                    kind: match wanted.kind {
                        EndpointKind::Publisher => info::PUBLISHER,
                        EndpointKind::Subscription => info::SUBSCRIPTION,
                        EndpointKind::Service => info::SERVICE,
                    },
                    address: wanted.address.clone(),
                    types: wanted.types.clone(),
                    digest: wanted.digest.clone(),
                });
            }
            put(&wanted.node, &writers, &readers);
        }
        for other in state.others.values() {
            put(&other.node, &other.writers, &other.readers);
        }
        (ends, nodes)
    }

    /// What we tell of our nodes.
    pub(crate) fn nodes(participant: Gid, nodes: Vec<Node>) -> Nodes {
        Nodes { participant, nodes }
    }
}

/// What is known of the writer of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// It writes the type that is read.
    Right,
    /// It writes another type.
    Wrong,
    /// It is not there, or not yet.
    Unknown,
}

impl Verdict {
    fn of(right: bool) -> Self {
        if right { Self::Right } else { Self::Wrong }
    }
}

/// What is known of a service that is to be called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Service {
    /// With its reader of requests; none when it is of this daemon.
    There(Option<GUID>),
    Nobody,
    /// It has these types instead.
    Differs(String),
}

impl Service {
    fn of(digest: &str, types: &str, wanted: &Wanted, reader: Option<GUID>) -> Self {
        if digest == wanted.digest { Self::There(reader) } else { Self::Differs(types.to_owned()) }
    }
}

fn kind_of(kind: u8) -> Option<EndpointKind> {
    match kind {
        info::PUBLISHER => Some(EndpointKind::Publisher),
        info::SUBSCRIPTION => Some(EndpointKind::Subscription),
        info::SERVICE => Some(EndpointKind::Service),
        _ => None,
    }
}

/// An end of a ROS node that is no daemon; nothing of what DDS and ROS use for themselves.
fn foreign(found: &Found) -> Option<Endpoint> {
    let ty = TypeName::from_dds(&found.dds_type);
    if let Some(topic) = found.topic.strip_prefix("rt/") {
        let kind = if found.writer { EndpointKind::Publisher } else { EndpointKind::Subscription };
        return Some(Endpoint { kind, address: topic.to_owned(), ty });
    }
    let service = found.topic.strip_prefix("rq/")?.strip_suffix("Request")?;
    let ty = ty.strip_suffix("_Request").unwrap_or(&ty).to_owned();
    let kind = EndpointKind::Service;
    (!found.writer).then(|| Endpoint { kind, address: service.to_owned(), ty })
}

impl State {
    fn service(&self, wanted: &Wanted) -> Service {
        let own = self
            .own
            .values()
            .map(|own| &own.wanted)
            .find(|own| own.kind == EndpointKind::Service && own.address == wanted.address);
        if let Some(own) = own {
            return Service::of(&own.digest, &own.types, wanted, None);
        }
        let mut there = None;
        for (guid, other) in self.found.iter().filter(|(_, other)| other.topic == wanted.topic) {
            if other.writer || self.is_dead(guid) {
                continue;
            }
            match self.told_of(guid) {
                Some(end) => return Service::of(&end.digest, &end.types, wanted, Some(*guid)),
                None if self.is_daemon(guid) => {}
                None if other.dds_type != wanted.dds_type => {
                    return Service::Differs(TypeName::from_dds(&other.dds_type));
                }
                None => there = Some(*guid),
            }
        }
        there.map_or(Service::Nobody, |guid| Service::There(Some(guid)))
    }

    fn told_of(&self, guid: &GUID) -> Option<&End> {
        self.told.values().find_map(|(_, ends)| ends.get(guid))
    }

    /// Whether an end is of a daemon, which tells more of it.
    fn is_daemon(&self, guid: &GUID) -> bool {
        let tells = |(other, found): (&GUID, &Found)| {
            other.prefix == guid.prefix && found.writer && found.topic == info::ENDS.0
        };
        self.told.keys().any(|by| by.prefix == guid.prefix) || self.found.iter().any(tells)
    }

    /// Whether an end is of a process that was killed; DDS learns of that much later.
    fn is_dead(&self, guid: &GUID) -> bool {
        let by = self.told.iter().find(|(by, _)| by.prefix == guid.prefix);
        by.is_some_and(|(_, (process, _))| process.has_ended())
    }

    /// What is in the way of an end, and whether that is ours.
    fn conflict(&self, wanted: &Wanted) -> Option<(Conflict, bool)> {
        let port = wanted.kind != EndpointKind::Service;
        let alone = wanted.kind != EndpointKind::Subscription;
        let mut taken = None;
        let own = self.own.values().map(|own| &own.wanted);
        for other in own.filter(|other| other.address == wanted.address) {
            if (other.kind != EndpointKind::Service) != port {
                continue;
            }
            if port && other.digest != wanted.digest {
                return Some((Conflict::Types(other.types.clone()), true));
            }
            if alone && other.kind == wanted.kind {
                taken = Some((Conflict::Taken, true));
            }
        }
        for (guid, found) in self.found.iter().filter(|(_, found)| found.topic == wanted.topic) {
            let told = self.told_of(guid);
            let same =
                told.map_or(found.dds_type == wanted.dds_type, |end| end.digest == wanted.digest);
            let clash = (port && !same)
                || (alone && told.is_some_and(|end| kind_of(end.kind) == Some(wanted.kind)));
            if !clash || self.is_dead(guid) {
                continue;
            }
            if port && !same {
                let foreign = || TypeName::from_dds(&found.dds_type);
                let theirs = told.map_or_else(foreign, |end| end.types.clone());
                return Some((Conflict::Types(theirs), false));
            }
            taken.get_or_insert((Conflict::Taken, false));
        }
        taken
    }
}

impl Claim {
    pub(crate) fn wanted(&self) -> &Wanted {
        &self.own.wanted
    }

    /// The DDS writers and readers of the end are made: others are told.
    pub(crate) fn made(&self, made: Made) {
        *self.own.made() = Some(made);
        self.graph.touch();
        (self.announce)();
    }
}

impl Drop for Belonging {
    fn drop(&mut self) {
        self.graph.lock().others.remove(&self.number);
        (self.announce)();
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        self.graph.lock().own.remove(&self.number);
        self.graph.touch();
        (self.announce)();
    }
}
