//! Ends of our own and of others.

use std::sync::{Mutex, MutexGuard, PoisonError};

use genom_middleware::EndpointKind;
use rustdds::{EndpointDescription, GUID, QosPolicies};

use crate::info::{self, Gid};

/// An end that is to be opened.
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

/// What is known of a service that is to be called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Service {
    /// It exists. With its reader of requests; `None` if it is in this daemon.
    There(Option<GUID>),
    Nobody,
    /// It has these types instead.
    Differs(String),
}

impl Service {
    pub(super) fn of(digest: &str, types: &str, wanted: &Wanted, reader: Option<GUID>) -> Self {
        if digest == wanted.digest { Self::There(reader) } else { Self::Differs(types.to_owned()) }
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
