//! Bare RustDDS: bytes copied in by the writer, and copied out by the reader from where a waiting
//! thread stored them.

use std::convert::Infallible;
use std::fmt::Debug;
use std::hint::black_box;
use std::net::IpAddr;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use ros2_client::dds::rustdds;
use rustdds::bytes::Bytes;
use rustdds::mio1::{Events, Interest, Poll, Token, Waker};
use rustdds::no_key::{DataWriter, DeserializerAdapter, SerializerAdapter, SimpleDataReader};
use rustdds::policy::{History, ResourceLimits};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, Duration, QosPolicies, QosPolicyBuilder,
    RepresentationIdentifier, Topic, TopicKind,
};

use super::ends::Bare;
use super::place::{Looks, Place};
use crate::error::FloorError;
use crate::pair::{Receive, Send};

/// A DDS domain that robots and tests are unlikely to use.
pub const DOMAIN: u16 = 101;

/// A participant on the loopback interface.
pub struct Participant {
    participant: DomainParticipant,
    /// Part of the names of its topics: others may be in the domain, too.
    name: String,
}

fn refused(error: impl Debug) -> FloorError {
    FloorError::of("RustDDS")(format!("{error:?}"))
}

struct Raw;

impl SerializerAdapter<Bytes> for Raw {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(value: &Bytes) -> Result<Bytes, Infallible> {
        Ok(value.clone())
    }
}

impl DeserializerAdapter<Bytes> for Raw {
    type Error = Infallible;
    type Decoded = Bytes;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &[RepresentationIdentifier::CDR_LE]
    }

    fn transform_decoded(decoded: Bytes) -> Bytes {
        decoded
    }
}

#[derive(Clone)]
struct Owned;

impl<'de> rustdds::no_key::Decode<'de, Bytes> for Owned {
    type Error = Infallible;

    fn decode_bytes(
        self,
        bytes: &'de [u8],
        _: RepresentationIdentifier,
    ) -> Result<Bytes, Infallible> {
        Ok(Bytes::copy_from_slice(bytes))
    }
}

impl rustdds::no_key::DefaultDecoder<Bytes> for Raw {
    type Decoder = Owned;
    const DECODER: Owned = Owned;
}

struct Out(DataWriter<Bytes, Raw>, Vec<u8>);

impl Send for Out {
    fn send(&mut self) -> Result<(), FloorError> {
        self.0.write(Bytes::copy_from_slice(black_box(&self.1)), None).map_err(refused)
    }
}

/// The thread that waits for samples.
struct Waits {
    stop: Arc<AtomicBool>,
    waker: Arc<Waker>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Waits {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if self.waker.wake().is_ok() {
            self.thread.take().map(JoinHandle::join);
        }
    }
}

/// The same QoS as genomd's backend: reliable, keep last 1.
fn qos() -> QosPolicies {
    QosPolicyBuilder::new()
        .reliable(Duration::from_millis(100))
        .history(History::KeepLast { depth: 1 })
        .resource_limits(ResourceLimits {
            max_samples: 32,
            max_instances: 1,
            max_samples_per_instance: 32,
        })
        .build()
}

impl Participant {
    /// Two processes meet if the folder has the same name.
    ///
    /// # Errors
    /// RustDDS refuses.
    pub fn open(place: &Path) -> Result<Self, FloorError> {
        let builder = DomainParticipantBuilder::new(DOMAIN);
        let builder = builder.with_only_networks(vec![IpAddr::from([127, 0, 0, 1])]);
        let name = place.file_name().unwrap_or_default().to_string_lossy();
        let name = name.chars().filter(char::is_ascii_alphanumeric).collect();
        Ok(Self { participant: builder.build().map_err(refused)?, name })
    }

    fn topic(&self, bytes: usize) -> Result<Topic, FloorError> {
        let (name, ty) =
            (format!("rt/bare{}/of{bytes}", self.name), "bench::msg::dds_::Octets_".to_owned());
        self.participant.create_topic(name, ty, &qos(), TopicKind::NoKey).map_err(refused)
    }
}

impl Bare for Participant {
    fn writer(&self, bytes: usize) -> Result<Box<dyn Send>, FloorError> {
        let none = QosPolicies::qos_none();
        let publisher = self.participant.create_publisher(&none).map_err(refused)?;
        let writer = publisher.create_datawriter_no_key(&self.topic(bytes)?, None);
        Ok(Box::new(Out(writer.map_err(refused)?, vec![1; bytes])))
    }

    fn reader(&self, bytes: usize) -> Result<Box<dyn Receive>, FloorError> {
        let none = QosPolicies::qos_none();
        let subscriber = self.participant.create_subscriber(&none).map_err(refused)?;
        let reader = subscriber.create_simple_datareader_no_key(&self.topic(bytes)?, None);
        let mut reader: SimpleDataReader<Bytes, Raw> = reader.map_err(refused)?;
        let place = Place::new();
        let mut poll = Poll::new()?;
        let waker = Arc::new(Waker::new(poll.registry(), Token(0))?);
        poll.registry().register(&mut reader, Token(1), Interest::READABLE)?;
        let (to, stop) = (Arc::clone(&place), Arc::new(AtomicBool::new(false)));
        let stopped = Arc::clone(&stop);
        let thread = thread::spawn(move || {
            let mut events = Events::with_capacity(8);
            while !stopped.load(Ordering::Acquire) && poll.poll(&mut events, None).is_ok() {
                reader.drain_read_notifications();
                while let Ok(Some(sample)) = reader.try_take_one() {
                    to.put(sample.into_value());
                }
            }
        });
        let keep = Waits { stop, waker, thread: Some(thread) };
        let copy = |bytes: &Bytes, to: &mut Vec<u8>| to.extend_from_slice(bytes);
        Ok(Box::new(Looks::at(place, copy, keep)))
    }
}
