//! The DDS participant of this daemon, and the writers and readers it creates.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use crate::dds::rustdds::dds::CreateResult;
use crate::dds::rustdds::{
    DomainParticipant, DomainParticipantBuilder, Publisher, QosPolicies, Subscriber, Topic,
    TopicKind,
};

use crate::dds::wire::{Reader, Writer};
use crate::domain::Domain;

/// Creates writers and readers.
pub(crate) struct Dds {
    publisher: Publisher,
    subscriber: Subscriber,
    pub(crate) participant: DomainParticipant,
    /// Every topic that was ever written or read here, with its type and QoS.
    opened: Mutex<HashMap<(String, Direction), (String, QosPolicies)>>,
}

/// Which end of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Direction {
    Writes,
    Reads,
}

/// Bytes that arrive while RustDDS does other work, and are not lost: several images. Memory is
/// taken by what waits only.
const RECEIVE_BUFFER: usize = 32 << 20;

/// What to ask the system for. RustDDS asks for 8 MiB by itself, and complains in the log if it
/// gets less, which is as common as it is useless there: `genomctl doctor` tells it.
fn receive_buffer() -> usize {
    let most = std::fs::read_to_string("/proc/sys/net/core/rmem_max");
    let most = most.ok().and_then(|text| text.trim().parse().ok());
    most.unwrap_or(DomainParticipantBuilder::DEFAULT_SOCKET_RECEIVE_BUFFER_SIZE).min(RECEIVE_BUFFER)
}

impl Dds {
    pub(crate) fn open(domain: &Domain) -> CreateResult<Self> {
        let builder = DomainParticipantBuilder::new(domain.number);
        let mut builder = builder.socket_receive_buffer_size(receive_buffer());
        if let Some(addresses) = domain.addresses() {
            builder = builder.with_only_networks(addresses);
        }
        let participant = builder.build()?;
        let qos = QosPolicies::qos_none();
        let publisher = participant.create_publisher(&qos)?;
        let subscriber = participant.create_subscriber(&qos)?;
        Ok(Self { publisher, subscriber, participant, opened: Mutex::default() })
    }

    fn topic(&self, name: &str, ty: &str, qos: &QosPolicies) -> CreateResult<Topic> {
        self.participant.create_topic(name.to_owned(), ty.to_owned(), qos, TopicKind::NoKey)
    }

    fn note(&self, topic: &str, direction: Direction, ty: &str, qos: &QosPolicies) {
        let mut opened = self.opened.lock().unwrap_or_else(PoisonError::into_inner);
        opened.insert((topic.to_owned(), direction), (ty.to_owned(), qos.clone()));
    }

    /// Type and QoS with which a topic was last opened.
    pub(crate) fn opened(
        &self,
        topic: &str,
        direction: Direction,
    ) -> Option<(String, QosPolicies)> {
        let opened = self.opened.lock().unwrap_or_else(PoisonError::into_inner);
        opened.get(&(topic.to_owned(), direction)).cloned()
    }

    pub(crate) fn writer(&self, topic: &str, ty: &str, qos: &QosPolicies) -> CreateResult<Writer> {
        self.note(topic, Direction::Writes, ty, qos);
        let topic = self.topic(topic, ty, qos)?;
        self.publisher.create_datawriter_no_key(&topic, Some(qos.clone()))
    }

    pub(crate) fn reader(&self, topic: &str, ty: &str, qos: &QosPolicies) -> CreateResult<Reader> {
        self.note(topic, Direction::Reads, ty, qos);
        self.moment(topic, ty, qos)
    }

    /// Creates a reader that is not recorded in `opened`.
    pub(crate) fn moment(&self, topic: &str, ty: &str, qos: &QosPolicies) -> CreateResult<Reader> {
        let topic = self.topic(topic, ty, qos)?;
        self.subscriber.create_simple_datareader_no_key(&topic, Some(qos.clone()))
    }
}
