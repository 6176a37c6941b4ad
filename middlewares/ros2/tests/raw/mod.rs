//! A DDS participant that writes raw bytes in any representation, and functions that corrupt bytes.

#![allow(clippy::unwrap_used, reason = "test code")]

use std::convert::Infallible;
use std::marker::PhantomData;
use std::net::{IpAddr, UdpSocket};

use genom_conformance::eventually;
use ros2_client::dds::rustdds;
use rustdds::bytes::Bytes;
use rustdds::no_key::{DataWriter, SerializerAdapter};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, DomainParticipantStatusEvent,
    DomainParticipantStatusListener, QosPolicyBuilder, RTPSEntity as _, RepresentationIdentifier,
    StatusEvented as _, TopicKind, policy,
};

use crate::world::Domain;

/// The declared encoding of a payload.
pub(crate) trait Encoding {
    const IS: RepresentationIdentifier;
}

pub(crate) struct Plain;
pub(crate) struct Parameters;
pub(crate) struct Newer;
pub(crate) struct Text;

impl Encoding for Plain {
    const IS: RepresentationIdentifier = RepresentationIdentifier::CDR_LE;
}
impl Encoding for Parameters {
    const IS: RepresentationIdentifier = RepresentationIdentifier::PL_CDR_LE;
}
impl Encoding for Newer {
    const IS: RepresentationIdentifier = RepresentationIdentifier::CDR2_LE;
}
impl Encoding for Text {
    const IS: RepresentationIdentifier = RepresentationIdentifier::XML;
}

/// Arbitrary bytes after the encapsulation header.
pub(crate) struct Raw<E>(Vec<u8>, PhantomData<E>);

pub(crate) struct AsIs<E>(PhantomData<E>);

impl<E: Encoding> SerializerAdapter<Raw<E>> for AsIs<E> {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        E::IS
    }

    fn to_bytes(raw: &Raw<E>) -> Result<Bytes, Infallible> {
        Ok(Bytes::from(raw.0.clone()))
    }
}

/// A foreign participant.
pub(crate) struct Peer {
    participant: DomainParticipant,
    publisher: rustdds::Publisher,
    news: DomainParticipantStatusListener,
}

/// Writes the given bytes.
pub(crate) struct Writer<E: Encoding>(DataWriter<Raw<E>, AsIs<E>>);

impl Peer {
    pub(crate) fn new(domain: &Domain) -> Self {
        let participant = DomainParticipantBuilder::new(domain.number())
            .with_only_networks([IpAddr::from([127, 0, 0, 1])])
            .build()
            .unwrap();
        let qos = QosPolicyBuilder::new().build();
        let publisher = participant.create_publisher(&qos).unwrap();
        let news = participant.status_listener();
        Self { participant, publisher, news }
    }

    /// Waits until what this writer writes arrives.
    pub(crate) fn connected<E: Encoding>(&self, writer: &Writer<E>) {
        let ours = |event| {
            matches!(event, DomainParticipantStatusEvent::RemoteReaderMatched { local_writer, .. }
                if local_writer == writer.0.guid())
        };
        eventually("a reader is connected", || self.news.try_recv_status().is_some_and(ours));
    }

    /// Sends a sample as `writer` would, with this header and payload, to the whole domain.
    pub(crate) fn forge<E: Encoding>(
        &self,
        domain: &Domain,
        writer: &Writer<E>,
        number: u8,
        sample: &[u8],
    ) {
        let guid = writer.0.guid().to_bytes();
        let (prefix, entity) = guid.split_at(12);
        let length = u16::try_from(20 + sample.len()).unwrap().to_le_bytes();
        // RTPS 2.5, 9.4.4 and 9.4.5.4: a message header and DATA, little endian, for any reader.
        let (header, data, reader) =
            (b"RTPS\x02\x04\x01\x12", [0x15, 0x05], [0, 0, 16, 0, 0, 0, 0, 0]);
        let number = [0, 0, 0, 0, number, 0, 0, 0];
        let message = [header, prefix, &data, &length, &reader, entity, &number, sample].concat();
        let socket = UdpSocket::bind(("127.0.0.1", 0)).unwrap();
        // 9.6.2.3: UDP ports on which the domain's participants receive samples.
        let first = 7400 + 250 * domain.number() + 11;
        for participant in 0..8 {
            socket.send_to(&message, ("127.0.0.1", first + 2 * participant)).unwrap();
        }
    }

    pub(crate) fn writer<E: Encoding>(&self, topic: &str, ty: &str) -> Writer<E> {
        let qos = QosPolicyBuilder::new()
            .reliable(rustdds::Duration::from_secs(10))
            .history(policy::History::KeepLast { depth: 2000 })
            .build();
        let topic = self
            .participant
            .create_topic(topic.to_owned(), ty.to_owned(), &qos, TopicKind::NoKey)
            .unwrap();
        let writer = self.publisher.create_datawriter_no_key(&topic, Some(qos)).unwrap();
        Writer(writer)
    }
}

impl<E: Encoding> Writer<E> {
    pub(crate) fn write(&self, payload: Vec<u8>) {
        assert!(self.0.write(Raw(payload, PhantomData), None).is_ok());
    }
}

/// A deterministic pseudo-random number generator.
pub(crate) struct Noise(pub(crate) u64);

impl Noise {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub(crate) fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.next() % end as u64).unwrap()
    }

    /// Returns the payload with some bytes changed, a length or number made huge, and often
    /// truncated.
    pub(crate) fn spoil(&mut self, good: &[u8]) -> Vec<u8> {
        let mut bad = good.to_vec();
        for _ in 0..self.below(4) {
            let at = self.below(bad.len());
            bad[at] = self.next().to_le_bytes()[0];
        }
        if self.next().is_multiple_of(3) && bad.len() >= 4 {
            let at = self.below(bad.len() / 4) * 4;
            bad[at..at + 4].copy_from_slice(&[0xff, 0xff, 0xff, 0x7f]);
        }
        if self.next().is_multiple_of(2) {
            bad.truncate(self.below(bad.len()));
        }
        bad
    }
}

/// Seed of all tests.
pub(crate) const SEED: u64 = 0x9e37_79b9_7f4a_7c15;
