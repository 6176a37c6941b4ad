//! All that uses iceoryx2's interface for types known only at run time. Pinned to one version.
//!
//! Beside that, samples of ours carry a [`Stamp`], so that readers can count what they lost:
//! iceoryx2 does not tell. In fixed-size samples it lies in the gap between iceoryx2's header and
//! a payload aligned to 64 bytes, which nobody else uses; in slices it is the last 16 bytes.
//! A peer that only knows iceoryx2 neither sees it nor has to write it.

use std::mem::size_of;

use genom_types::Record;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::service::builder::publish_subscribe::{Builder, PublishSubscribeOpenError};
use iceoryx2::service::header::publish_subscribe::Header;
use iceoryx2::service::marker::{CustomHeaderMarker, CustomPayloadMarker};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory as PubSubFactory;
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};

use crate::room::Written;
use crate::typing::Wire;

/// Everything of ours may move between threads.
pub(crate) type Ipc = ipc_threadsafe::Service;
pub(crate) type RawService = PubSubFactory<Ipc, [CustomPayloadMarker], CustomHeaderMarker>;
pub(crate) type RawPublisher = Publisher<Ipc, [CustomPayloadMarker], CustomHeaderMarker>;
pub(crate) type RawSubscriber = Subscriber<Ipc, [CustomPayloadMarker], CustomHeaderMarker>;
pub(crate) type RawSample = Sample<Ipc, [CustomPayloadMarker], CustomHeaderMarker>;
pub(crate) type RawBuilder = Builder<[CustomPayloadMarker], CustomHeaderMarker, Ipc>;

/// Alignment of payloads in services of ours: leaves a gap after the 48 bytes of the header.
const ALIGN: usize = 64;

/// Bytes of a stamp.
const STAMP: usize = 16;
const _: () = assert!(STAMP >= genom_types::cdr::SLACK);

/// Tells stamps from whatever else may lie there.
const MAGIC: u32 = u32::from_ne_bytes(*b"gn3\x01");

/// Which sample it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stamp {
    /// Tells the publisher from those before it under the same address; the same on all services
    /// it writes to.
    pub(crate) writer: u32,
    /// Number among the samples of that publisher, from 1.
    pub(crate) number: u64,
}

/// What stamps call the publisher of this id.
pub(crate) fn short(id: u128) -> u32 {
    (id ^ (id >> 32) ^ (id >> 64) ^ (id >> 96)) as u32
}

impl Stamp {
    fn to_bytes(self) -> [u8; STAMP] {
        let mut bytes = [0; STAMP];
        bytes[..4].copy_from_slice(&MAGIC.to_ne_bytes());
        bytes[4..8].copy_from_slice(&self.writer.to_ne_bytes());
        bytes[8..].copy_from_slice(&self.number.to_ne_bytes());
        bytes
    }

    fn from_bytes(bytes: &[u8; STAMP]) -> Option<Self> {
        let (start, number) = bytes.split_last_chunk::<8>()?;
        let (magic, writer) = start.split_first_chunk::<4>()?;
        let writer = u32::from_ne_bytes(writer.try_into().ok()?);
        (u32::from_ne_bytes(*magic) == MAGIC)
            .then(|| Self { writer, number: u64::from_ne_bytes(*number) })
    }
}

/// Why a sample was not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SendError {
    /// No memory for it: readers hold all samples.
    Full,
    /// It cannot be encoded.
    Serialization,
    /// Shared memory is full.
    NoRoom,
    /// iceoryx2 refused.
    Refused,
}

/// A builder for a service of this type: to open one when `own` is false, to create one else.
pub(crate) fn builder(
    node: &Node<Ipc>,
    name: &ServiceName,
    wire: &Wire,
    own: bool,
) -> Option<RawBuilder> {
    let variant = if wire.slice { TypeVariant::Dynamic } else { TypeVariant::FixedSize };
    // The alignment of an element pads each of a slice: those keep their own.
    let align = if own && !wire.slice { wire.align.max(ALIGN) } else { wire.align };
    let size = wire.size.max(1);
    let payload = TypeDetail::__internal_new_from_parts(variant, &wire.name, size, align).ok()?;
    let header = TypeDetail::__internal_new_from_parts(TypeVariant::FixedSize, "()", 0, 1).ok()?;
    let builder = node
        .service_builder(name)
        .publish_subscribe::<[CustomPayloadMarker]>()
        .user_header::<CustomHeaderMarker>();
    // SAFETY: the details are the type's own; every access to a payload below goes by them.
    Some(unsafe {
        builder
            .__internal_set_payload_type_details(&payload)
            .__internal_set_user_header_type_details(&header)
    })
}

/// Opens a service whatever its type is, only to look at it.
pub(crate) fn open_to_look(
    node: &Node<Ipc>,
    name: &ServiceName,
    payload: &TypeDetail,
    user_header: &TypeDetail,
) -> Result<RawService, PublishSubscribeOpenError> {
    let builder = node
        .service_builder(name)
        .publish_subscribe::<[CustomPayloadMarker]>()
        .user_header::<CustomHeaderMarker>();
    // SAFETY: the details are those of the service itself, and no port is made from it.
    unsafe {
        builder
            .__internal_set_payload_type_details(payload)
            .__internal_set_user_header_type_details(user_header)
    }
    .open()
}

/// What to publish.
#[derive(Clone, Copy)]
pub(crate) enum Value<'a> {
    /// A value in its C layout, which has the size of the type.
    Plain(&'a [u8]),
    /// A value to be encoded, for slices, and the bytes of its message.
    Message(&'a Record, usize),
    /// A message, for slices.
    Encoded(&'a [u8]),
}

/// Publishes a copy of a value, which is encoded where it is published.
pub(crate) fn send(
    publisher: &RawPublisher,
    wire: &Wire,
    value: Value<'_>,
    stamp: Stamp,
    written: &mut Written,
) -> Result<(), SendError> {
    let elements = match value {
        Value::Plain(_) => 1,
        Value::Message(_, size) => size + STAMP,
        Value::Encoded(message) => message.len() + STAMP,
    };
    if matches!(value, Value::Plain(_)) == wire.slice {
        return Err(SendError::Refused);
    }
    // SAFETY: more than one element for slices only; the payload is written in full below.
    let loan = unsafe { publisher.loan_custom_payload(elements) };
    let mut sample = loan.map_err(|error| match error {
        iceoryx2::port::LoanError::OutOfMemory | iceoryx2::port::LoanError::ExceedsMaxLoans => {
            SendError::Full
        }
        _ => SendError::Refused,
    })?;
    let header = std::ptr::from_ref(sample.header()) as usize;
    let room = sample.payload_mut();
    let (to, count) = (room.as_mut_ptr().cast::<u8>(), room.len());
    if !written.may(to as usize, if wire.slice { count } else { wire.size }) {
        return Err(SendError::NoRoom);
    }
    let mark = stamp.to_bytes();
    match value {
        Value::Message(record, size) => {
            if count != elements {
                return Err(SendError::Refused);
            }
            // SAFETY: a marker is one byte, and the loan is ours alone.
            let room = unsafe { std::slice::from_raw_parts_mut(to.cast(), count) };
            // The stamp's place is the slack that encoding may use.
            let written = record.encode_message_to(room).map_err(|_| SendError::Serialization)?;
            if written != size {
                return Err(SendError::Serialization);
            }
            // SAFETY: the slice has room for the message and the stamp.
            unsafe { to.add(size).copy_from_nonoverlapping(mark.as_ptr(), STAMP) };
        }
        Value::Encoded(message) => {
            if count != elements {
                return Err(SendError::Refused);
            }
            // SAFETY: the slice has room for the message and the stamp, and is ours alone.
            unsafe {
                to.copy_from_nonoverlapping(message.as_ptr(), message.len());
                to.add(message.len()).copy_from_nonoverlapping(mark.as_ptr(), STAMP);
            }
        }
        Value::Plain(payload) => {
            if payload.len() != wire.size || count < payload.len() {
                return Err(SendError::Refused);
            }
            // SAFETY: the payload has room for a value of the type; when there is a gap before
            // it, the gap is part of the same chunk, which is ours until it is sent.
            unsafe {
                to.copy_from_nonoverlapping(payload.as_ptr(), payload.len());
                if has_gap(header, to as usize) {
                    to.sub(STAMP).copy_from_nonoverlapping(mark.as_ptr(), STAMP);
                }
            }
        }
    }
    // SAFETY: the payload was written in full above.
    let sample = unsafe { sample.assume_init() };
    sample.send().map(|_| ()).map_err(|_| SendError::Refused)
}

/// Whether a stamp fits between the header and the payload.
fn has_gap(header: usize, payload: usize) -> bool {
    payload.saturating_sub(header) >= size_of::<Header>() + STAMP
}

/// The value in a sample, and its stamp if it is one of ours.
pub(crate) fn open_sample<'a>(sample: &'a RawSample, wire: &Wire) -> (&'a [u8], Option<Stamp>) {
    let header = std::ptr::from_ref(sample.header()) as usize;
    let payload = sample.payload();
    let at = payload.as_ptr().cast::<u8>();
    // SAFETY: a marker is one byte, and publishers write samples in full before they send them;
    // a sample is not written while somebody holds it.
    let bytes = unsafe { std::slice::from_raw_parts(at, payload.len()) };
    if wire.slice {
        return match bytes.split_last_chunk::<STAMP>() {
            Some((value, mark)) if Stamp::from_bytes(mark).is_some() => {
                (value, Stamp::from_bytes(mark))
            }
            _ => (bytes, None),
        };
    }
    if !has_gap(header, at as usize) {
        return (bytes, None);
    }
    // SAFETY: the gap lies within the sample's chunk. It is zero until a publisher of ours
    // writes it, since iceoryx2 clears new memory.
    let mark = unsafe { &*at.sub(STAMP).cast::<[u8; STAMP]>() };
    (bytes, Stamp::from_bytes(mark))
}
