//! Ends of our own and of others.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::dds::rustdds::{EndpointDescription, GUID, QosPolicies};
use genom_middleware::EndpointKind;

use crate::dds::info::{self, Gid};
use crate::rmw::{self, Named, Service};

/// An end that is to be opened, with its names in DDS.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    pub(crate) kind: EndpointKind,
    /// The address with the namespace in front.
    pub(crate) address: String,
    /// The types as error messages spell them.
    pub(crate) types: String,
    pub(crate) digest: String,
    /// DDS names of the topic (for a service, of its requests) and of its type.
    pub(crate) topic: String,
    pub(crate) dds_type: String,
    /// Type hash by which ROS nodes identify the message of a port.
    pub(crate) hash: Option<String>,
    /// The ROS node that it belongs to: the component instance.
    pub(crate) node: String,
}

impl Wanted {
    pub(crate) fn of(wanted: &rmw::Wanted) -> Self {
        let rmw::Wanted { kind, address, types, digest, node, of } = wanted.clone();
        let Named { name, ty, hash } = of;
        let (topic, dds_type) = match kind {
            EndpointKind::Service => (format!("rq/{name}Request"), ty.to_dds("_Request")),
            _ => (format!("rt/{name}"), ty.to_dds("")),
        };
        Self { kind, address, types, digest, topic, dds_type, hash, node }
    }
}

/// An end of ours.
#[derive(Debug)]
pub(super) struct Own {
    pub(super) wanted: Wanted,
    /// `None` until they exist. Locked only briefly, while the lock of the graph is held.
    pub(super) made: Mutex<Option<Made>>,
}

/// The DDS entities of an end of ours.
#[derive(Clone, Debug, Default)]
pub(crate) struct Made {
    /// The first writer or reader identifies the end in announcements.
    pub(crate) writers: Vec<Gid>,
    pub(crate) readers: Vec<Gid>,
    /// QoS that the writer of an out port offers.
    pub(crate) offers: Option<QosPolicies>,
}

impl Own {
    pub(super) fn made(&self) -> MutexGuard<'_, Option<Made>> {
        self.made.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What DDS discovery tells about an end of others.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) topic: String,
    pub(crate) dds_type: String,
    pub(crate) writer: bool,
    /// QoS that it offers or requests.
    pub(crate) qos: QosPolicies,
    /// Type hash by which ROS nodes identify the message, if it is announced.
    pub(crate) hash: Option<String>,
}

impl Found {
    /// From DDS's description of an end.
    pub(crate) fn new(end: EndpointDescription, writer: bool) -> Self {
        // REP-2016: USER_DATA contains `typehash=RIHS01_...;` among other keys, after a length.
        let text = String::from_utf8_lossy(&end.user_data);
        let hash = text.split_once("typehash=").and_then(|(_, rest)| rest.split(';').next());
        let hash = hash.map(str::to_owned);
        Self { topic: end.topic_name, dds_type: end.type_name, writer, qos: end.qos, hash }
    }
}

/// DDS writers and readers of a node.
#[derive(Clone, Debug)]
pub(crate) struct Entities {
    pub(crate) node: String,
    pub(crate) writers: Vec<Gid>,
    pub(crate) readers: Vec<Gid>,
}

/// What is known of the writer of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// It writes the type that is read.
    Right,
    /// It writes another type.
    Wrong,
    /// It is not known, or not known yet.
    Unknown,
}

impl Verdict {
    pub(super) fn of(right: bool) -> Self {
        if right { Self::Right } else { Self::Wrong }
    }
}

/// A service with these types that has this reader of requests.
pub(super) fn service_of(
    digest: &str,
    types: &str,
    wanted: &Wanted,
    reader: Option<GUID>,
) -> Service {
    if digest == wanted.digest {
        Service::There(reader.map(|guid| guid.to_bytes()))
    } else {
        Service::Differs(types.to_owned())
    }
}

/// A kind of end, from its number in messages.
pub(super) fn kind_of(kind: u8) -> Option<EndpointKind> {
    match kind {
        info::PUBLISHER => Some(EndpointKind::Publisher),
        info::SUBSCRIPTION => Some(EndpointKind::Subscription),
        info::SERVICE => Some(EndpointKind::Service),
        _ => None,
    }
}
