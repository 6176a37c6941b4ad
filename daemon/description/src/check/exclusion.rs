//! Computes which codels may not run at the same time (genom3.md 4.5), and checks rule K24.
//!
//! Accesses are grouped by what they touch (a port, or the first member of an IDS path) and by the
//! task that makes them: only accesses that may conflict are compared.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::Checker;
use crate::diagnostic::Diagnostic;
use crate::model::{
    Codel, CodelIx, CodelKind, Component, Direction, Indexed, Node, Owner, PathStep, PortIx,
    ServiceIx, ServiceKind, Source, StateIx, TaskIx,
};

/// The task that runs a codel; `None` for the control task.
type Context = Option<TaskIx>;

/// What an access touches.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Key {
    Port(PortIx),
    Ids(usize),
}

/// One parameter of a codel, or one member that an attribute transfers.
struct Access<'m> {
    node: usize,
    path: &'m [PathStep],
    writes: bool,
}

/// Accesses of one context to one key.
#[derive(Default)]
struct Sharers<'m> {
    readers: Vec<Access<'m>>,
    writers: Vec<Access<'m>>,
}

/// Limit on pairs of codels that exclude each other, and on comparisons to find them: both grow
/// with the square of the number of codels that touch one item.
const MOST_PAIRS: usize = 1 << 22;
const MOST_COMPARISONS: usize = 1 << 26;

/// The services that a service interrupts.
enum Interrupted {
    All,
    Some(HashSet<ServiceIx>),
}

/// Number of comparisons made and pairs found so far.
#[derive(Default)]
struct Effort {
    pairs: usize,
    comparisons: usize,
}

/// All accesses of one component to shared data.
pub(super) struct Sharing<'m> {
    component: &'m Component,
    contexts: Vec<Context>,
    keys: HashMap<Key, BTreeMap<Context, Sharers<'m>>>,
    /// Accesses to the whole IDS, which conflict with every member.
    whole: BTreeMap<Context, Sharers<'m>>,
    /// All accesses to the IDS, to be compared with those to the whole of it.
    any: BTreeMap<Context, Sharers<'m>>,
}

impl<'m> Sharing<'m> {
    pub(super) fn new(component: &'m Component) -> Self {
        let mut contexts: Vec<Context> =
            component.codels.iter().map(|codel| context(component, codel)).collect();
        contexts.resize(component.codels.len() + component.services.len(), None);
        let mut sharing = Sharing {
            component,
            contexts,
            keys: HashMap::new(),
            whole: BTreeMap::new(),
            any: BTreeMap::new(),
        };
        for (ix, codel) in component.codels.pairs() {
            let node = component.node_number(Node::Codel(ix));
            for parameter in &codel.parameters {
                match &parameter.source {
                    // Rule 3: ports always conflict, remotes never.
                    Source::Port(port) => {
                        sharing
                            .add(Some(Key::Port(*port)), Access { node, path: &[], writes: true });
                    }
                    Source::Ids { path } => {
                        let writes = parameter.direction != Direction::In;
                        sharing.add(ids_key(path), Access { node, path, writes });
                    }
                    _ => {}
                }
            }
        }
        for (ix, service) in component.services.pairs() {
            let node = component.node_number(Node::Transfer(ix));
            for parameter in &service.parameters {
                if let Some(target) = &parameter.target {
                    // The other way round than for codels: an attribute's `in` writes the member.
                    let writes = parameter.direction != Direction::Out;
                    sharing.add(ids_key(&target.path), Access { node, path: &target.path, writes });
                }
            }
        }
        sharing
    }

    fn add(&mut self, key: Option<Key>, access: Access<'m>) {
        let context = self.contexts.get(access.node).copied().flatten();
        let push = |to: &mut BTreeMap<Context, Sharers<'m>>, access: Access<'m>| {
            let sharers = to.entry(context).or_default();
            if access.writes { sharers.writers.push(access) } else { sharers.readers.push(access) }
        };
        let again = || Access { node: access.node, path: access.path, writes: access.writes };
        match key {
            Some(key @ Key::Ids(_)) => {
                push(&mut self.any, again());
                push(self.keys.entry(key).or_default(), access);
            }
            Some(key @ Key::Port(_)) => push(self.keys.entry(key).or_default(), access),
            None => {
                push(&mut self.any, again());
                push(&mut self.whole, access);
            }
        }
    }

    /// The nodes of other contexts whose accesses conflict with those of `node`; `None` when the
    /// limit is exceeded.
    fn conflicts(&self, node: usize, same: bool, effort: &mut Effort) -> Option<Vec<usize>> {
        let context = self.contexts.get(node).copied().flatten();
        let mut found = HashSet::new();
        for (key, path, writes) in self.accesses(node) {
            let (one, whole) = match key {
                None => (Some(&self.any), None),
                Some(key @ Key::Ids(_)) => (self.keys.get(&key), Some(&self.whole)),
                Some(key) => (self.keys.get(&key), None),
            };
            for (other, sharers) in [one, whole].into_iter().flatten().flatten() {
                if !same && *other == context {
                    continue;
                }
                let readers = if writes { &*sharers.readers } else { &[] };
                effort.comparisons += sharers.writers.len() + readers.len();
                if effort.comparisons > MOST_COMPARISONS {
                    return None;
                }
                let all = sharers.writers.iter().chain(readers);
                found.extend(all.filter(|a| overlap(a.path, path)).map(|a| a.node));
            }
        }
        effort.pairs += found.len();
        let mut found: Vec<usize> = found.into_iter().collect();
        found.sort_unstable();
        (effort.pairs <= MOST_PAIRS).then_some(found)
    }

    /// The accesses of a node, without repetitions.
    fn accesses(&self, node: usize) -> HashSet<(Option<Key>, &'m [PathStep], bool)> {
        let component = self.component;
        let service = match component.node(node) {
            Node::Codel(ix) => {
                let touch = |p: &'m crate::model::CodelParameter| match &p.source {
                    Source::Port(port) => Some((Some(Key::Port(*port)), &[][..], true)),
                    Source::Ids { path } => {
                        Some((ids_key(path), &path[..], p.direction != Direction::In))
                    }
                    _ => None,
                };
                let parameters =
                    component.codels.get(ix).map_or(&[][..], |codel| &codel.parameters);
                return parameters.iter().filter_map(touch).collect();
            }
            Node::Transfer(ix) => component.services.get(ix),
        };
        let parameters = service.map_or(&[][..], |service| &service.parameters);
        let moved = parameters.iter().filter_map(|p| Some((p, p.target.as_ref()?)));
        moved.map(|(p, t)| (ids_key(&t.path), &t.path[..], p.direction != Direction::Out)).collect()
    }

    /// The whole relation; `None` when the limit is exceeded.
    pub(super) fn table(&self) -> Option<Vec<Vec<usize>>> {
        let services = &self.component.services;
        let interrupted = services.map(|_, service| match service.interrupts.len() {
            all if all == services.len() => Interrupted::All,
            _ => Interrupted::Some(service.interrupts.iter().copied().collect()),
        });
        let mut effort = Effort::default();
        (0..self.contexts.len())
            .map(|node| {
                let mut list = self.conflicts(node, false, &mut effort)?;
                match self.component.node(node) {
                    Node::Codel(_) => {
                        list.retain(|other| !self.is_interrupted_by(node, *other, &interrupted));
                    }
                    // An attribute excludes what tasks run; the control task is sequential.
                    Node::Transfer(_) => {
                        list.retain(|other| self.contexts.get(*other).copied().flatten().is_some());
                    }
                }
                Some(list)
            })
            .collect()
    }

    /// Whether `other` is a codel of a service that interrupts the service of `node`: these two
    /// never run at the same time.
    fn is_interrupted_by(
        &self,
        node: usize,
        other: usize,
        by: &Indexed<ServiceIx, Interrupted>,
    ) -> bool {
        let codel = |node: usize| self.component.codel_of_node(node);
        let (Some(node), Some(other)) = (codel(node), codel(other)) else { return false };
        let (Owner::Service(own), Owner::Service(theirs)) = (node.owner, other.owner) else {
            return false;
        };
        matches!(other.kind, CodelKind::Fsm { .. })
            && by.get(theirs).is_some_and(|interrupted| match interrupted {
                Interrupted::All => true,
                Interrupted::Some(list) => list.contains(&own),
            })
    }

    /// For each activity, the activities whose codels conflict with its own, itself included.
    // dialects.md A: a service of the papers interrupts these, unless it lists others.
    pub(super) fn incompatible(&self) -> Option<Indexed<ServiceIx, Vec<ServiceIx>>> {
        let services = &self.component.services;
        let activity = |node: usize| match self.component.codel_of_node(node)?.owner {
            Owner::Service(rank)
                if services.get(rank).is_some_and(|s| s.kind == ServiceKind::Activity) =>
            {
                Some(rank)
            }
            _ => None,
        };
        let mut effort = Effort::default();
        services
            .iter()
            .map(|service| {
                if service.kind != ServiceKind::Activity {
                    return Some(Vec::new());
                }
                let mut list = BTreeSet::new();
                for codel in &service.codels {
                    let node = self.component.node_number(Node::Codel(*codel));
                    let conflicts = self.conflicts(node, true, &mut effort)?;
                    list.extend(conflicts.into_iter().filter_map(activity));
                }
                Some(list.into_iter().collect())
            })
            .collect()
    }
}

fn ids_key(path: &[PathStep]) -> Option<Key> {
    match path.first() {
        Some(PathStep::Member(rank)) => Some(Key::Ids(*rank)),
        _ => None,
    }
}

/// Rule 4: two paths overlap when one is a prefix of the other.
fn overlap(a: &[PathStep], b: &[PathStep]) -> bool {
    a.iter().zip(b).all(|(a, b)| a == b)
}

fn context(component: &Component, codel: &Codel) -> Context {
    match (&codel.kind, codel.owner) {
        (_, Owner::Task(task)) => Some(task),
        (CodelKind::Fsm { .. }, Owner::Service(rank)) => {
            component.services.get(rank).and_then(|service| service.task)
        }
        _ => None,
    }
}

impl Checker {
    /// Checks that async codels share no data with other contexts.
    // genom3.md 3.7 K24, 4.5.
    pub(super) fn check_async(&mut self, component: &Component) {
        if !component.codels.iter().any(|codel| codel.asynchronous) {
            return;
        }
        let exempt = start_and_stop(component);
        for (ix, codel) in component.codels.pairs().filter(|(_, codel)| codel.asynchronous) {
            let others = component.exclusion(component.node_number(Node::Codel(ix))).iter();
            let mut others = others.map(|other| component.node(*other));
            let sharing =
                |other: &Node| !matches!(other, Node::Codel(other) if exempt.contains(other));
            let (what, span) = match others.find(sharing) {
                None => continue,
                Some(Node::Codel(other)) => {
                    let other = &component.codels[other];
                    (format!("codel `{}`", other.name), other.span)
                }
                Some(Node::Transfer(other)) => {
                    let service = &component.services[other];
                    (format!("service `{}`", service.name), service.span)
                }
            };
            let message = format!("async codel `{}` shares data with {what}", codel.name);
            self.push(
                Diagnostic::error("E0724", codel.span, message)
                    .note(span, "declared here")
                    .help("remove `async`, or pass the data through a codel that is not async"),
            );
        }
    }
}

/// Permanent codels that run at start-up, and those that cannot be reached from `start`.
fn start_and_stop(component: &Component) -> HashSet<CodelIx> {
    let mut exempt = HashSet::new();
    for task in &component.tasks {
        let mut by_state: HashMap<StateIx, CodelIx> = HashMap::new();
        for ix in &task.codels {
            if let Some(CodelKind::Fsm { triggers, .. }) =
                component.codels.get(*ix).map(|codel| &codel.kind)
            {
                triggers.iter().for_each(|state| _ = by_state.entry(*state).or_insert(*ix));
            }
        }
        let start = component.state("start").and_then(|state| by_state.get(&state).copied());
        let mut seen: HashSet<CodelIx> = start.into_iter().collect();
        let mut todo: Vec<CodelIx> = start.into_iter().collect();
        while let Some(ix) = todo.pop() {
            let Some(CodelKind::Fsm { yields, .. }) = component.codels.get(ix).map(|c| &c.kind)
            else {
                continue;
            };
            for next in yields.iter().filter_map(|y| by_state.get(&y.state)) {
                if seen.insert(*next) {
                    todo.push(*next);
                }
            }
        }
        exempt.extend(start);
        exempt.extend(task.codels.iter().filter(|ix| !seen.contains(ix)));
    }
    exempt
}
