//! Lists all ends, and those that this daemon announces.

use std::collections::HashSet;

use genom_middleware::{Endpoint, EndpointKind};
use genom_rosidl::TypeName;

use super::ends::{Found, Made, kind_of};
use super::known::Graph;
use crate::dds::info::{self, End, Gid, Node, Nodes};
use crate::names;

impl Graph {
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
            // A daemon's end that it has not announced yet, or that it uses internally.
            None if state.is_daemon(guid) => None,
            None => foreign(found),
        });
        own.chain(others).collect()
    }

    /// Our nodes that have ends.
    pub(crate) fn node_names(&self) -> HashSet<String> {
        let state = self.lock();
        let own = state.own.values().map(|own| own.wanted.node.as_str());
        let all = own.chain(state.others.values().map(|other| other.node.as_str()));
        let all: HashSet<_> = all.collect();
        all.into_iter().map(str::to_owned).collect()
    }

    /// What we announce: our ends, and our nodes with all their writers and readers.
    pub(crate) fn ours(&self) -> (Vec<End>, Vec<Node>) {
        let state = self.lock();
        let mut ends = Vec::new();
        let mut nodes: Vec<Node> = Vec::new();
        let mut put = |node: &str, writers: &[Gid], readers: &[Gid]| {
            let (before, name) = names::split(node);
            let namespace = format!("/{before}");
            let is = |node: &&mut Node| node.name == name && node.namespace == namespace;
            if let Some(node) = nodes.iter_mut().find(is) {
                node.readers.extend(readers);
                node.writers.extend(writers);
                return;
            }
            nodes.push(Node {
                namespace,
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

    /// The announcement of our nodes.
    pub(crate) fn nodes(participant: Gid, nodes: Vec<Node>) -> Nodes {
        Nodes { participant, nodes }
    }
}

/// An end of a ROS node that is not a daemon; `None` for what DDS and ROS use internally.
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
