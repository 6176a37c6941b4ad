//! Ports: how they are opened, and their ends as the runtime sees them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use genom_kit::intake::{Intake, Keeping};
use genom_kit::out_port::OutPort;
use genom_kit::outlet::Outlet;
use genom_middleware::{
    Address, OpenError, Policy, PortSpec, Ports, Publisher, ReadError, Reading, Subscription,
};
use genom_types::{DataType, Definition, Record};

use super::book::{Kind, Shared};
use super::core::{Held, Proxy};
use super::lines::{Inbox, Line, Lost};
use crate::words::{Refusal, What};

/// Samples of an out port that may wait to be sent, unless its quality of service asks for more or
/// they are large.
const UNSENT: usize = 16;

/// Most that may be asked for.
const MOST_UNSENT: usize = 1024;

/// Limit in bytes for those that wait.
const UNSENT_BYTES: usize = 4 << 20;

/// Initial size in bytes of the buffers for messages of a type.
fn room(ty: &DataType) -> usize {
    let size = ty.size();
    if ty.is_fixed_size() { size + size / 8 + 64 } else { size * 4 + 64 }
}

impl Shared {
    pub(super) fn open_error(&self, refusal: Refusal, address: &Address) -> OpenError {
        let why = match refusal {
            Refusal::Open(error) => return error,
            Refusal::Announce(error) => error.to_string(),
            Refusal::Own(why) => why,
        };
        OpenError::Failed { backend: self.name.to_owned(), address: address.clone(), why }
    }

    /// A number for an end.
    pub(super) fn end_number(&self) -> u32 {
        // Wraps after four thousand million ends; those that are still open then are few.
        self.number() as u32
    }
}

impl Ports for Proxy {
    fn publisher(&self, port: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError> {
        let PortSpec { address, ty, quality, .. } = *port;
        let shared = self.shared();
        let Some(orders) = shared.orders.get().cloned() else {
            return Err(shared.open_error(Refusal::Own("it is closed".into()), address));
        };
        let room = room(ty);
        let most = quality.depth.unwrap_or(UNSENT).clamp(UNSENT, MOST_UNSENT);
        let outlet = Arc::new(Outlet::new(ty, (UNSENT_BYTES / room).clamp(1, most), room));
        let (live, lost) = (Arc::new(AtomicBool::new(false)), Arc::<Lost>::default());
        let end = shared.end_number();
        let line = orders.add(Line::new(end, &outlet, &shared.channel, &live));
        let what = What::Publisher { address: address.clone(), ty: Definition::of(ty), quality };
        let kind = Kind::Publisher { line, live, lost: Arc::clone(&lost) };
        if let Err(why) = shared.open(end, what, kind) {
            orders.remove(line, |_, _| {});
            return Err(shared.open_error(why, address));
        }
        let held = Held { end, core: Arc::clone(&self.core) };
        let sending = orders.clone();
        let port = OutPort::new(outlet, &orders, line, move |line| {
            // What waits is sent before the end is closed.
            sending.remove(line, |_, _| {});
            drop(held);
        });
        Ok(Box::new(port.and_lost(move || lost.count())))
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let PortSpec { address, ty, quality, .. } = *port;
        let shared = self.shared();
        let keeping = Keeping::of(policy, shared.name, ty)?;
        let inbox = Arc::new(Inbox::new(keeping, room(ty)));
        let ty_sent = Definition::of(ty);
        let what = What::Subscription { address: address.clone(), ty: ty_sent, quality, policy };
        let end = shared.end_number();
        let opened = shared.open(end, what, Kind::Subscription(Arc::clone(&inbox)));
        opened.map_err(|why| shared.open_error(why, address))?;
        let held = Held { end, core: Arc::clone(&self.core) };
        Ok(Box::new(ProxySubscription { intake: Intake::new(ty), inbox, _held: held }))
    }
}

/// An in port. Fields are dropped in order.
struct ProxySubscription {
    intake: Intake,
    inbox: Arc<Inbox>,
    _held: Held,
}

impl Subscription for ProxySubscription {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        let inbox = &self.inbox;
        let next =
            |decode: &mut dyn FnMut(&[u8]) -> bool| inbox.mailbox.take(|message| decode(message));
        let reading = self.intake.read(into, next);
        if reading == Err(ReadError::Serialization) {
            inbox.undecodable.fetch_add(1, Ordering::Relaxed);
        }
        reading
    }

    fn on_arrival(&mut self, told: Box<dyn Fn() + Send + Sync>) -> bool {
        self.inbox.told.set(told).is_ok()
    }

    fn arrived(&self) -> Option<u64> {
        self.inbox.mailbox.put_at()
    }

    fn dropped(&self) -> u64 {
        self.inbox.lost()
    }
}
