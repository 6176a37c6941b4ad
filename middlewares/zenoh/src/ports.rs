//! Ports: how they are opened, and their ends as the runtime sees them.

use std::collections::hash_map::RandomState;
use std::hash::BuildHasher;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;

use genom_kit::intake::{Intake, Keeping};
use genom_kit::out_port::OutPort;
use genom_kit::outlet::{Outlet, room_of};
use genom_middleware::{
    EndpointKind, OpenError, Policy, PortSpec, Ports, Publisher, ReadError, Reading, Subscription,
};
use genom_types::Record;
use zenoh::Wait;
use zenoh::qos::CongestionControl;

use crate::backend::Zenoh;
use crate::core::{Core, ask};
use crate::error::BACKEND;
use crate::graph::Claim;
use crate::inbox::Inbox;
use crate::sending::{LastValue, Line};
use crate::wire::{self, Expected, Mark};

/// Greatest number of unsent samples per out port, and greatest number of bytes that they may take.
const UNSENT: usize = 16;
const UNSENT_BYTES: usize = 1 << 20;

/// A number that differs between any two writers of a session, and almost certainly between all.
fn new_writer() -> u64 {
    RandomState::new().hash_one(thread::current().id())
}

impl Ports for Zenoh {
    fn publisher(&self, port: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError> {
        let PortSpec { address: at, ty, .. } = *port;
        let core = &self.core;
        let key = core.key(at)?;
        let claim = core.claim_port(at, EndpointKind::Publisher, ty)?;
        let failed = |error| core.failed(at, error);
        let encoding = wire::encoding_of(ty);
        let last = Arc::new(LastValue::default());
        let offered = {
            let (last, key, encoding) = (Arc::clone(&last), key.clone(), encoding.clone());
            move |query: zenoh::query::Query| {
                let Some((payload, mark)) = last.get() else { return };
                let reply = query.reply(key.clone(), payload).encoding(encoding.clone());
                if let Err(error) = reply.attachment(&mark.to_bytes()[..]).wait() {
                    tracing::debug!(%key, %error, "the last value was not sent");
                }
            }
        };
        let queryable = core.session().declare_queryable(key.clone()).callback(offered);
        let queryable = queryable.wait().map_err(failed)?;
        let publisher = core
            .session()
            .declare_publisher(key)
            .encoding(encoding)
            // A reader that cannot keep up blocks the sending thread, not the writers: their oldest
            // samples are dropped, and the last one arrives.
            .congestion_control(CongestionControl::Block)
            .wait()
            .map_err(failed)?;
        let room = room_of(ty);
        let depth = (UNSENT_BYTES / room.max(1)).clamp(1, UNSENT);
        let outlet = Arc::new(Outlet::new(ty, depth, room));
        // The token is declared last, so that a reader that sees it can already query the last
        // value.
        let claim = core.show(at, claim)?;
        let line = core.orders().add(Line {
            publisher,
            outlet: Arc::clone(&outlet),
            last,
            mark: Mark { writer: new_writer(), number: 0 },
        });
        // What announces it to others is dropped after the last sample was sent.
        let (core, shown) = (Arc::clone(core), (queryable, claim));
        Ok(Box::new(OutPort::new(outlet, self.core.orders(), line, move |line| {
            core.orders().remove(line, |_, line| {
                drop(line);
                drop(shown);
            });
        })))
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let PortSpec { address: at, ty, .. } = *port;
        let core = &self.core;
        let keeping = Keeping::of(policy, BACKEND, ty)?;
        let key = core.key(at)?;
        let claim = core.claim_port(at, EndpointKind::Subscription, ty)?;
        let expected = Expected::of(ty);
        let inbox = Arc::new(Inbox::new(at.to_string(), expected, keeping, ty.size() + 64));
        let arriving = Arc::clone(&inbox);
        let subscriber = core.session().declare_subscriber(key.clone());
        let subscriber = subscriber.callback(move |sample| arriving.arrive(&sample, None));
        let subscriber = subscriber.wait().map_err(|error| core.failed(at, error))?;
        let claim = core.show(at, claim)?;
        // Writers that appear later are queried then.
        core.graph().add_reader(at, &inbox);
        ask(core.session(), &key, Arc::clone(&inbox));
        Ok(Box::new(ZenohSubscription {
            intake: Intake::new(ty),
            inbox,
            _subscriber: subscriber,
            _claim: claim,
            _core: Arc::clone(core),
        }))
    }
}

/// An in port. Fields are dropped in order.
pub(crate) struct ZenohSubscription {
    intake: Intake,
    inbox: Arc<Inbox>,
    _subscriber: zenoh::pubsub::Subscriber<()>,
    _claim: Claim,
    _core: Arc<Core>,
}

impl ZenohSubscription {
    fn counted(&self, reading: Result<Reading, ReadError>) -> Result<Reading, ReadError> {
        if reading == Err(ReadError::Serialization) {
            self.inbox.undecodable.fetch_add(1, Ordering::Relaxed);
        }
        reading
    }
}

impl Subscription for ZenohSubscription {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        let mailbox = &self.inbox.mailbox;
        let reading = self.intake.read(into, |decode| mailbox.take(|one| one.read(decode)));
        self.counted(reading)
    }

    fn read_message(&mut self, into: &mut Vec<u8>) -> Option<Result<Reading, ReadError>> {
        let mailbox = &self.inbox.mailbox;
        let reading = self.intake.read_message(into, |see| mailbox.take(|one| one.read(see)));
        Some(self.counted(reading))
    }

    fn on_arrival(&mut self, told: Box<dyn Fn() + Send + Sync>) -> bool {
        self.inbox.tell(told)
    }

    fn arrived(&self) -> Option<u64> {
        self.inbox.mailbox.put_at()
    }

    fn dropped(&self) -> u64 {
        self.inbox.lost()
    }
}
