//! RustDDS: bytes copied in by the writer, and copied out by the reader from where a waiting thread
//! stored them.

use std::convert::Infallible;
use std::hint::black_box;
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use genom_bench::pair::{Receive, Send};
use genom_middleware::Middleware;
use genom_ros2::{Options, Ros2};
use rustdds::bytes::Bytes;
use rustdds::mio1::{Events, Interest, Poll, Token, Waker};
use rustdds::no_key::{DataWriter, DeserializerAdapter, SerializerAdapter, SimpleDataReader};
use rustdds::policy::{History, ResourceLimits};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, Duration, QosPolicies, QosPolicyBuilder,
    RepresentationIdentifier, Topic, TopicKind,
};

use crate::Backend;
use crate::place::{Looks, Place};

/// A DDS domain that robots and tests are unlikely to use.
const DOMAIN: u16 = 101;

/// genomd's backend.
pub(crate) fn ours() -> Arc<Ros2> {
    let options = Options { domain: Some(DOMAIN), ..Options::default() };
    Ros2::open(&options).unwrap()
}

pub(crate) struct Both {
    ours: Arc<Ros2>,
    participant: DomainParticipant,
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
    fn send(&mut self) {
        self.0.write(Bytes::copy_from_slice(black_box(&self.1)), None).unwrap();
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
        self.waker.wake().unwrap();
        self.thread.take().map(JoinHandle::join);
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

impl Both {
    pub(crate) fn open() -> Self {
        let ours = ours();
        let builder = DomainParticipantBuilder::new(DOMAIN);
        let participant =
            builder.with_only_networks(vec![IpAddr::from([127, 0, 0, 1])]).build().unwrap();
        Self { ours, participant }
    }

    fn topic(&self, bytes: usize) -> Topic {
        let (name, ty) = (format!("rt/bare/of{bytes}"), "bench::msg::dds_::Octets_".to_owned());
        self.participant.create_topic(name, ty, &qos(), TopicKind::NoKey).unwrap()
    }
}

impl Backend for Both {
    fn writer(&self, bytes: usize) -> Box<dyn Send> {
        let publisher = self.participant.create_publisher(&QosPolicies::qos_none()).unwrap();
        let writer = publisher.create_datawriter_no_key(&self.topic(bytes), None).unwrap();
        Box::new(Out(writer, vec![1; bytes]))
    }

    fn reader(&self, bytes: usize) -> Box<dyn Receive> {
        let subscriber = self.participant.create_subscriber(&QosPolicies::qos_none()).unwrap();
        let mut reader: SimpleDataReader<Bytes, Raw> =
            subscriber.create_simple_datareader_no_key(&self.topic(bytes), None).unwrap();
        let place = Place::new();
        let mut poll = Poll::new().unwrap();
        let waker = Arc::new(Waker::new(poll.registry(), Token(0)).unwrap());
        poll.registry().register(&mut reader, Token(1), Interest::READABLE).unwrap();
        let (to, stop) = (Arc::clone(&place), Arc::new(AtomicBool::new(false)));
        let stopped = Arc::clone(&stop);
        let thread = thread::spawn(move || {
            let mut events = Events::with_capacity(8);
            while !stopped.load(Ordering::Acquire) {
                poll.poll(&mut events, None).unwrap();
                reader.drain_read_notifications();
                while let Ok(Some(sample)) = reader.try_take_one() {
                    to.put(sample.into_value());
                }
            }
        });
        let keep = Waits { stop, waker, thread: Some(thread) };
        let copy = |bytes: &Bytes, to: &mut Vec<u8>| to.extend_from_slice(bytes);
        Box::new(Looks::at(place, copy, keep))
    }

    fn ours(&self) -> &dyn Middleware {
        &*self.ours
    }
}
