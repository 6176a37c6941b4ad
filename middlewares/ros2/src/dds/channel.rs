//! One ROS service: a request topic and a reply topic, whose bodies are bytes.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use crate::dds::rustdds::bytes::Bytes;
use crate::dds::rustdds::dds::CreateResult;
use crate::dds::rustdds::mio1::Token;
use crate::dds::rustdds::rpc::SampleIdentity;
use crate::dds::rustdds::{
    GUID, RTPSEntity, SequenceNumber, Timestamp, WriteOptions, WriteOptionsBuilder,
};
use genom_kit::complaints::Complaints;

use crate::body::Fields;
use crate::dds::participant::Dds;
use crate::dds::post::{Matches, Post, Prefix, prefix};
use crate::dds::receiver::{Inlet, Sample, Sink};
use crate::dds::sender::Orders;
use crate::dds::wire::{self, HEADER, Payload, Reader};
use crate::options::ServiceMapping;
use crate::rmw::{Answer, ClientEnd, Entities, Gid, Named, OnRequest, Reply, ServerEnd, Target};

/// Greatest number of requests or replies of one service that wait for the receiving thread.
const CACHED: i32 = 1024;

/// Size in bytes of the header that the Cyclone mapping puts before a body.
const CYCLONE: usize = 16;

/// What is needed to create the ends of a service.
#[derive(Clone)]
pub(crate) struct Maker {
    pub(crate) inlet: Arc<Inlet>,
    pub(crate) orders: Orders,
    pub(crate) matches: Arc<Matches>,
    pub(crate) mapping: ServiceMapping,
}

/// DDS names of a service.
#[derive(Clone, Debug)]
pub(crate) struct Names {
    /// What its topic names have in common: `demo/goto` in `rq/demo/gotoRequest`.
    pub(crate) path: String,
    pub(crate) request: String,
    pub(crate) reply: String,
}

impl Names {
    pub(crate) fn of(service: &Named) -> Self {
        Self {
            path: service.name.clone(),
            request: service.ty.to_dds("_Request"),
            reply: service.ty.to_dds("_Response"),
        }
    }

    fn request_topic(&self) -> String {
        format!("rq/{}Request", self.path)
    }

    fn reply_topic(&self) -> String {
        format!("rr/{}Reply", self.path)
    }
}

/// Identifies the request that a reply belongs to.
#[derive(Clone, Copy, Debug)]
struct RequestId {
    asker: GUID,
    identity: SampleIdentity,
    /// Header of the Cyclone mapping, half a GUID and a number; sent back unchanged.
    half: u64,
    number: u64,
}

/// The serving end.
pub(crate) struct Server {
    maker: Maker,
    replies: Arc<Post>,
    token: Token,
    reader: GUID,
}

/// Where the reply to one request goes.
struct ToClient {
    id: RequestId,
    mapping: ServiceMapping,
    replies: Arc<Post>,
    orders: Orders,
}

struct Requests {
    mapping: ServiceMapping,
    replies: Arc<Post>,
    orders: Orders,
    since: Timestamp,
    ourselves: Prefix,
    on_request: OnRequest,
    bad: Complaints,
}

impl Sink for Requests {
    fn arrive(&mut self, sample: Sample<'_>) {
        let asker = sample.writer;
        if sample.received < self.since || prefix(&asker) == self.ourselves {
            return;
        }
        let Some((identity, half, number, body)) = self.open(&sample) else {
            if let Some(requests) = self.bad.add() {
                tracing::warn!(requests, "left out, without header: other service mapping?");
            }
            return;
        };
        let id = RequestId { asker, identity, half, number };
        let (replies, orders) = (Arc::clone(&self.replies), self.orders.clone());
        let reply = ToClient { id, mapping: self.mapping, replies, orders };
        (self.on_request)(Box::new(reply), &body);
    }

    fn garbled(&mut self) {
        if let Some(requests) = self.bad.add() {
            tracing::warn!(requests, "left out: not plain CDR");
        }
    }
}

impl Requests {
    fn open(&self, sample: &Sample<'_>) -> Option<(SampleIdentity, u64, u64, Vec<u8>)> {
        let actual = SequenceNumber::from(sample.number);
        match self.mapping {
            ServiceMapping::Enhanced => {
                let mut identity = sample.related.unwrap_or_default();
                // Only some clients say under which id they expect the reply.
                if prefix(&identity.writer_guid) != prefix(&sample.writer) {
                    identity.writer_guid = sample.writer;
                    identity.sequence_number = actual;
                }
                if i64::from(identity.sequence_number) <= 0 {
                    identity.sequence_number = actual;
                }
                Some((identity, 0, 0, sample.message.to_vec()))
            }
            ServiceMapping::Cyclone => {
                let (half, number, body) = split_cyclone(sample.message)?;
                let identity =
                    SampleIdentity { writer_guid: sample.writer, sequence_number: actual };
                Some((identity, half, number, body))
            }
        }
    }
}

/// Splits a message of the Cyclone mapping into id, number and the message without them.
fn split_cyclone(message: &[u8]) -> Option<(u64, u64, Vec<u8>)> {
    let mut fields = Fields::of(message)?;
    let (half, number) = (fields.long()?, fields.long()?);
    let (header, body) = (message.get(..HEADER)?, message.get(HEADER + CYCLONE..)?);
    Some((half, number, [header, body].concat()))
}

/// Puts id and number before a body.
fn join_cyclone(half: u64, number: u64, body: &[u8]) -> Bytes {
    [&half.to_le_bytes()[..], &number.to_le_bytes(), body].concat().into()
}

fn write(writer: &wire::Writer, payload: Bytes, options: WriteOptions) -> Option<SequenceNumber> {
    match writer.write_with_options(Payload(payload), options) {
        Ok(identity) => Some(identity.sequence_number),
        Err(error) => {
            tracing::warn!(%error, "DDS refused a request or reply");
            None
        }
    }
}

impl Server {
    pub(crate) fn open(
        dds: &Dds,
        maker: &Maker,
        names: &Names,
        on_request: OnRequest,
    ) -> CreateResult<Self> {
        let qos = wire::qos(true, false, CACHED);
        let writer = dds.writer(&names.reply_topic(), &names.reply, &qos)?;
        let ourselves = prefix(&writer.guid());
        let replies = Post::new(writer, &maker.matches, Box::new(|_| {}));
        let since = Timestamp::now();
        let reader = dds.reader(&names.request_topic(), &names.request, &qos)?;
        let guid = reader.guid();
        let bad = Complaints::default();
        let sink = Requests {
            mapping: maker.mapping,
            replies: Arc::clone(&replies),
            orders: maker.orders.clone(),
            since,
            ourselves,
            on_request,
            bad,
        };
        let token = maker.inlet.add(reader, Box::new(sink));
        Ok(Self { maker: maker.clone(), replies, token, reader: guid })
    }
}

impl ServerEnd for Server {
    fn entities(&self) -> Entities {
        let (writer, reader) = (self.replies.guid(), self.reader);
        Entities { writers: vec![writer.to_bytes()], readers: vec![reader.to_bytes()] }
    }

    // Others hear of it by an announcement (`settle`).
    fn withdraw(&self) {}

    fn flush(&self) {
        self.maker.orders.settle(&self.replies);
    }
}

impl Reply for ToClient {
    /// Sends a reply as soon as the client's reader is connected.
    fn send(self: Box<Self>, body: Vec<u8>) {
        let Self { id: to, mapping, replies: post, orders } = *self;
        orders.submit(move || {
            let letter = move |writer: &wire::Writer| {
                let options = WriteOptionsBuilder::new().source_timestamp(Timestamp::now());
                _ = match mapping {
                    ServiceMapping::Enhanced => {
                        let options = options.related_sample_identity(to.identity);
                        write(writer, body.into(), options.build())
                    }
                    ServiceMapping::Cyclone => {
                        write(writer, join_cyclone(to.half, to.number, &body), options.build())
                    }
                };
            };
            post.send(Target::Beside(to.asker.to_bytes()), Box::new(letter));
        });
    }

    fn asker(&self) -> Gid {
        self.id.asker.to_bytes()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.maker.inlet.remove(self.token);
    }
}

/// Requests without a reply so far.
#[derive(Default)]
struct Pending(Mutex<Asked>);

#[derive(Default)]
struct Asked {
    /// By number; with the server that was called.
    answers: HashMap<u64, (Target, Answer)>,
    /// The last number that this side assigned, where it assigns them.
    last: u64,
}

impl Pending {
    fn lock(&self) -> MutexGuard<'_, Asked> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Drops the requests whose servers are gone and will not reply.
    fn give_up(&self, reaches: &dyn Fn(Target) -> bool) {
        let mut asked = self.lock();
        let all = std::mem::take(&mut asked.answers);
        let (rest, given_up) = all.into_iter().partition(|(_, (of, _))| reaches(*of));
        asked.answers = rest;
        drop(asked);
        let given_up: HashMap<_, _> = given_up;
        drop(given_up);
    }
}

/// The calling end, shared by all callers of a service in this daemon.
pub(crate) struct Caller {
    maker: Maker,
    requests: Arc<Post>,
    token: Token,
    reader: GUID,
    pending: Arc<Pending>,
}

struct Answers {
    mapping: ServiceMapping,
    since: Timestamp,
    ids: [GUID; 2],
    half: u64,
    pending: Weak<Pending>,
}

impl Sink for Answers {
    fn arrive(&mut self, sample: Sample<'_>) {
        if sample.received < self.since {
            return;
        }
        let Some(pending) = self.pending.upgrade() else { return };
        let (number, body) = match self.mapping {
            ServiceMapping::Enhanced => {
                let Some(related) = sample.related else { return };
                if !self.ids.contains(&related.writer_guid) {
                    return;
                }
                (i64::from(related.sequence_number).cast_unsigned(), sample.message.to_vec())
            }
            ServiceMapping::Cyclone => match split_cyclone(sample.message) {
                Some((half, number, body)) if half == self.half => (number, body),
                _ => return,
            },
        };
        let answer = pending.lock().answers.remove(&number);
        if let Some((_, answer)) = answer {
            answer.give(Ok(&body));
        }
    }
}

/// The second half of a GUID, which distinguishes clients in the Cyclone mapping.
fn half(of: &GUID) -> u64 {
    of.to_bytes().last_chunk().map_or(0, |half| u64::from_le_bytes(*half))
}

impl Caller {
    pub(crate) fn open(dds: &Dds, maker: &Maker, names: &Names) -> CreateResult<Self> {
        let qos = wire::qos(true, false, CACHED);
        let since = Timestamp::now();
        let reader: Reader = dds.reader(&names.reply_topic(), &names.reply, &qos)?;
        let guid = reader.guid();
        let writer = dds.writer(&names.request_topic(), &names.request, &qos)?;
        let writes = writer.guid();
        let pending = Arc::new(Pending::default());
        let waits = Arc::downgrade(&pending);
        let on_lost = move |reaches: &dyn Fn(Target) -> bool| {
            if let Some(pending) = waits.upgrade() {
                pending.give_up(reaches);
            }
        };
        let requests = Post::new(writer, &maker.matches, Box::new(on_lost));
        let sink = Answers {
            mapping: maker.mapping,
            since,
            ids: [guid, writes],
            half: half(&writes),
            pending: Arc::downgrade(&pending),
        };
        let token = maker.inlet.add(reader, Box::new(sink));
        Ok(Self { maker: maker.clone(), requests, token, reader: guid, pending })
    }
}

impl ClientEnd for Caller {
    /// Sends a request as soon as the server's reader is connected.
    fn call(&self, to: Target, body: Vec<u8>, answer: Answer) {
        let (post, pending) = (Arc::clone(&self.requests), Arc::clone(&self.pending));
        let (mapping, reader) = (self.maker.mapping, self.reader);
        self.maker.orders.submit(move || {
            let half = half(&post.guid());
            let letter = move |writer: &wire::Writer| {
                let options = WriteOptionsBuilder::new().source_timestamp(Timestamp::now());
                // Locked until the number is known, since the reply may come at once.
                let mut waiting = pending.lock();
                let number = match mapping {
                    ServiceMapping::Enhanced => {
                        let identity = SampleIdentity {
                            writer_guid: reader,
                            sequence_number: SequenceNumber::UNKNOWN,
                        };
                        let options = options.related_sample_identity(identity);
                        write(writer, body.into(), options.build())
                            .map(|number| i64::from(number).cast_unsigned())
                    }
                    ServiceMapping::Cyclone => {
                        waiting.last += 1;
                        let number = waiting.last;
                        let payload = join_cyclone(half, number, &body);
                        write(writer, payload, options.build()).map(|_| number)
                    }
                };
                let refused = match number {
                    Some(number) => waiting.answers.insert(number, (to, answer)),
                    None => Some((to, answer)),
                };
                drop(waiting);
                drop(refused);
            };
            post.send(to, Box::new(letter));
        });
    }
}

impl Drop for Caller {
    fn drop(&mut self) {
        self.maker.inlet.remove(self.token);
    }
}
