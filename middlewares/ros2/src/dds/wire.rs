//! Passes messages to and from the DDS library as bytes: it neither encodes nor decodes them.

use std::cell::RefCell;
use std::convert::Infallible;

use crate::dds::rustdds::bytes::Bytes;
use crate::dds::rustdds::no_key::{
    DataWriter, Decode, DeserializerAdapter, SerializerAdapter, SimpleDataReader,
};
use crate::dds::rustdds::{
    Duration, QosPolicies, QosPolicyBuilder, RepresentationIdentifier, policy,
};

pub(crate) use crate::rmw::HEADER;

/// A CDR payload to send, little endian, without its header.
pub(crate) struct Payload(pub(crate) Bytes);

pub(crate) enum Outgoing {}

pub(crate) type Writer = DataWriter<Payload, Outgoing>;

impl SerializerAdapter<Payload> for Outgoing {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(payload: &Payload) -> Result<Bytes, Infallible> {
        Ok(payload.0.clone())
    }
}

/// Stands for a message whose bytes are in the buffer of the [`CopyTo`] that took it.
#[derive(Debug)]
pub(crate) struct Copied;

pub(crate) enum Incoming {}

pub(crate) type Reader = SimpleDataReader<Copied, Incoming>;

/// Copies a message, header and payload, into a buffer that is reused.
#[derive(Clone)]
pub(crate) struct CopyTo<'a>(pub(crate) &'a RefCell<Vec<u8>>);

impl DeserializerAdapter<Copied> for Incoming {
    type Error = Infallible;
    type Decoded = Copied;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &[RepresentationIdentifier::CDR_LE, RepresentationIdentifier::CDR_BE]
    }

    fn transform_decoded(decoded: Copied) -> Copied {
        decoded
    }
}

impl<'de> Decode<'de, Copied> for CopyTo<'_> {
    type Error = Infallible;

    fn decode_bytes(
        self,
        payload: &'de [u8],
        encoding: RepresentationIdentifier,
    ) -> Result<Copied, Infallible> {
        let order = u8::from(encoding == RepresentationIdentifier::CDR_LE);
        let mut buffer = self.0.borrow_mut();
        buffer.clear();
        buffer.extend_from_slice(&[0, order, 0, 0]);
        buffer.extend_from_slice(payload);
        Ok(Copied)
    }
}

/// Longest time that a write waits for slow readers; then the sample is dropped.
const BLOCKING: Duration = Duration::from_millis(100);

/// DDS QoS. `cached`: number of samples of a topic that may wait for the receiving thread.
pub(crate) fn qos(reliable: bool, transient_local: bool, cached: i32) -> QosPolicies {
    let durability = if transient_local {
        policy::Durability::TransientLocal
    } else {
        policy::Durability::Volatile
    };
    let builder = QosPolicyBuilder::new()
        .durability(durability)
        .history(policy::History::KeepLast { depth: 1 })
        .resource_limits(policy::ResourceLimits {
            max_samples: cached,
            max_instances: 1,
            max_samples_per_instance: cached,
        });
    if reliable { builder.reliable(BLOCKING).build() } else { builder.best_effort().build() }
}
