//! All uses of iceoryx2's interface for types known only at run time, which is pinned to one
//! version.
//!
//! Our samples also carry a [`Stamp`], so that readers can count lost samples, which iceoryx2 does
//! not report. In samples of fixed size it lies in the gap between iceoryx2's header and a payload
//! aligned to 64 bytes, which nothing else uses; in slices it is the last 16 bytes. Programs that
//! use only iceoryx2 neither see it nor have to write it.

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

/// iceoryx2's variant whose ports may move between threads.
pub(crate) type Ipc = ipc_threadsafe::Service;
pub(crate) type RawService = PubSubFactory<Ipc, [CustomPayloadMarker], CustomHeaderMarker>;
pub(crate) type RawPublisher = Publisher<Ipc, [CustomPayloadMarker], CustomHeaderMarker>;
pub(crate) type RawSubscriber = Subscriber<Ipc, [CustomPayloadMarker], CustomHeaderMarker>;
pub(crate) type RawSample = Sample<Ipc, [CustomPayloadMarker], CustomHeaderMarker>;
pub(crate) type RawBuilder = Builder<[CustomPayloadMarker], CustomHeaderMarker, Ipc>;

/// Alignment in bytes of payloads in our services: leaves a gap after the 48 bytes of the header.
const ALIGN: usize = 64;

/// Size of a stamp in bytes.
const STAMP: usize = 16;
const _: () = assert!(STAMP >= genom_types::cdr::SLACK);

/// Distinguishes stamps from other bytes in their place.
const MAGIC: u32 = u32::from_ne_bytes(*b"gn3\x01");

/// Identifies a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stamp {
    /// Identifies the publisher, also among earlier ones at the same address; the same on all
    /// services that it writes to.
    pub(crate) writer: u32,
    /// Number of the sample among those of its publisher, from 1.
    pub(crate) number: u64,
}

/// The form in which stamps hold the id of a publisher.
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
    /// No sample memory is free: the readers hold all samples.
    Full,
    /// The value cannot be encoded.
    Serialization,
    /// Shared memory is full.
    NoRoom,
    /// iceoryx2 refused it.
    Refused,
}

/// A builder for a service of this type: for creating one if `own`, else for opening one.
pub(crate) fn builder(
    node: &Node<Ipc>,
    name: &ServiceName,
    wire: &Wire,
    own: bool,
) -> Option<RawBuilder> {
    let variant = if wire.slice { TypeVariant::Dynamic } else { TypeVariant::FixedSize };
    // In slices the alignment applies to each element, so they keep their own.
    let align = if own && !wire.slice { wire.align.max(ALIGN) } else { wire.align };
    let size = wire.size.max(1);
    let payload = TypeDetail::__internal_new_from_parts(variant, &wire.name, size, align).ok()?;
    let header = TypeDetail::__internal_new_from_parts(TypeVariant::FixedSize, "()", 0, 1).ok()?;
    let builder = node
        .service_builder(name)
        .publish_subscribe::<[CustomPayloadMarker]>()
        .user_header::<CustomHeaderMarker>();
    // SAFETY: the details describe the type itself, and every access to a payload below follows
    // them.
    Some(unsafe {
        builder
            .__internal_set_payload_type_details(&payload)
            .__internal_set_user_header_type_details(&header)
    })
}

/// Opens a service of any type, only to inspect it.
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
    // SAFETY: the details are those of the service itself, and no port is created from it.
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
    /// A value to be encoded, for slices, with the size of its message in bytes.
    Message(&'a Record, usize),
    /// An encoded message, for slices.
    Encoded(&'a [u8]),
}

/// Publishes a copy of a value; encodes it directly into the sample.
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
    // SAFETY: there is more than one element only in slices, and the payload is written in full
    // below.
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
            // SAFETY: the element type has a size of one byte, and nobody else accesses the loan.
            let room = unsafe { std::slice::from_raw_parts_mut(to.cast(), count) };
            // Encoding may use the place of the stamp as slack.
            let written = record.encode_message_to(room).map_err(|_| SendError::Serialization)?;
            if written != size {
                return Err(SendError::Serialization);
            }
            // SAFETY: the slice has space for the message and the stamp.
            unsafe { to.add(size).copy_from_nonoverlapping(mark.as_ptr(), STAMP) };
        }
        Value::Encoded(message) => {
            if count != elements {
                return Err(SendError::Refused);
            }
            // SAFETY: the slice has space for the message and the stamp, and nobody else accesses
            // it.
            unsafe {
                to.copy_from_nonoverlapping(message.as_ptr(), message.len());
                to.add(message.len()).copy_from_nonoverlapping(mark.as_ptr(), STAMP);
            }
        }
        Value::Plain(payload) => {
            if payload.len() != wire.size || count < payload.len() {
                return Err(SendError::Refused);
            }
            // SAFETY: the payload has space for a value of the type. The gap before it, if there is
            // one, is part of the same chunk, which only this side accesses until it is sent.
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

/// Whether there is space for a stamp between the header and the payload.
fn has_gap(header: usize, payload: usize) -> bool {
    payload.saturating_sub(header) >= size_of::<Header>() + STAMP
}

/// The value in a sample, and its stamp if it is one of ours.
pub(crate) fn open_sample<'a>(sample: &'a RawSample, wire: &Wire) -> (&'a [u8], Option<Stamp>) {
    let header = std::ptr::from_ref(sample.header()) as usize;
    let payload = sample.payload();
    let at = payload.as_ptr().cast::<u8>();
    // SAFETY: the element type has a size of one byte. Publishers write samples in full before they
    // send them, and a sample is not written while somebody holds it.
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
    // SAFETY: the gap is part of the sample's chunk. It is initialised: iceoryx2 zeroes new memory,
    // and only our publishers write there.
    let mark = unsafe { &*at.sub(STAMP).cast::<[u8; STAMP]>() };
    (bytes, Stamp::from_bytes(mark))
}
