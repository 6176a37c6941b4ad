//! Ends, ours and those of others, and what is known of one.

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

/// An end of ours.
#[derive(Debug)]
pub(super) struct Own {
    pub(super) wanted: Wanted,
    /// `None` until they are made. Locked for an instant, with the lock of the graph held.
    pub(super) made: Mutex<Option<Made>>,
}

/// What an end of ours is in DDS.
#[derive(Clone, Debug, Default)]
pub(crate) struct Made {
    /// The first one, of the writers or of the readers, stands for the end in announcements.
    pub(crate) writers: Vec<Gid>,
    pub(crate) readers: Vec<Gid>,
    /// What the writer of an out port offers.
    pub(crate) offers: Option<QosPolicies>,
}

impl Own {
    pub(super) fn made(&self) -> MutexGuard<'_, Option<Made>> {
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
    /// It is not there, or not yet.
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
    /// With its reader of requests; none when it is of this daemon.
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

/// A kind of end, by its number in messages.
pub(super) fn kind_of(kind: u8) -> Option<EndpointKind> {
    match kind {
        info::PUBLISHER => Some(EndpointKind::Publisher),
        info::SUBSCRIPTION => Some(EndpointKind::Subscription),
        info::SERVICE => Some(EndpointKind::Service),
        _ => None,
    }
}
