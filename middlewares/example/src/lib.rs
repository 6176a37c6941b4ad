//! An example of a backend, explained step by step in `docs/backend.md`: ports between the
//! participants of one process that use the same board.

#![forbid(unsafe_code)]

mod board;

use std::io;
use std::sync::{Arc, OnceLock};

use genom_kit::intake::{Intake, Keeping};
use genom_kit::mailbox::Mailbox;
use genom_kit::outlet::Outlet;
use genom_kit::sender::{self, Duty, Sender};
use genom_middleware::{
    Address, Backend, Capabilities, Middleware, OpenError, Policy, PortSpec, Ports, PublishError,
    Publisher, ReadError, Reading, Subscription,
};
use genom_types::Record;
use serde::Deserialize;

use board::{Board, Inbox};

/// Section `[backends.example]` of the configuration.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Name of the board. Participants with the same board see each other.
    pub board: String,
}

/// A participant.
pub struct Example(Arc<Core>);

/// Shared by all ends of a participant.
struct Core {
    board: Arc<Board>,
    sender: Sender<Nothing>,
}

/// Duty of the sending thread beside sending: none.
struct Nothing;

impl Duty for Nothing {
    type Line = Line;
}

/// An out port as the sending thread sees it.
struct Line {
    outlet: Arc<Outlet>,
    at: Address,
    board: Arc<Board>,
}

impl sender::Line for Line {
    fn send(&mut self) -> bool {
        let Some(sample) = self.outlet.take() else { return false };
        // A real backend calls its library here; the call may take any time.
        self.board.deliver(&self.at, sample.as_ref());
        true
    }
}

impl Backend for Example {
    const NAME: &'static str = "example";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    type Options = Options;
    type Error = io::Error;

    fn open(options: Options) -> io::Result<Arc<dyn Middleware>> {
        let sender = Sender::start(Self::NAME, true, Nothing)?;
        Ok(Arc::new(Self(Arc::new(Core { board: Board::named(&options.board), sender }))))
    }
}

impl Middleware for Example {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            variable_size: true,
            zero_copy: false,
            cross_process: false,
            cross_host: false,
            services: false,
            native_services: false,
        }
    }
}

impl Ports for Example {
    fn publisher(&self, port: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError> {
        let PortSpec { address: at, ty, .. } = *port;
        let core = Arc::clone(&self.0);
        core.board.open(port, |port| {
            let taken = std::mem::replace(&mut port.has_writer, true);
            if taken { Err(OpenError::Taken { address: at.clone() }) } else { Ok(()) }
        })?;
        // Keeps few large samples or many small ones. CDR is seldom larger than the C layout.
        let depth = if ty.size() > 1 << 16 { 2 } else { 16 };
        let outlet = Arc::new(Outlet::new(ty, depth, ty.size() * 2 + 64));
        let (at, board) = (at.clone(), Arc::clone(&core.board));
        let line = Line { outlet: Arc::clone(&outlet), at: at.clone(), board };
        let line = core.sender.orders().add(line);
        Ok(Box::new(Out { outlet, line, at, core }))
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let Keeping { depth, full, counts } = Keeping::of(policy, Self::NAME, port.ty)?;
        let mailbox = Mailbox::new(depth, port.ty.size() * 2 + 64, full);
        let inbox = Arc::new(Inbox { mailbox, told: OnceLock::new() });
        self.0.board.open(port, |port| {
            port.join(&inbox);
            Ok(())
        })?;
        Ok(Box::new(In { intake: Intake::new(port.ty), inbox, counts, _core: Arc::clone(&self.0) }))
    }
}

/// The writing end.
struct Out {
    outlet: Arc<Outlet>,
    line: usize,
    at: Address,
    core: Arc<Core>,
}

impl Publisher for Out {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        self.outlet.put(value)?;
        self.core.sender.orders().mark(self.line);
        Ok(())
    }

    fn dropped(&self) -> u64 {
        self.outlet.dropped()
    }
}

impl Drop for Out {
    fn drop(&mut self) {
        self.core.sender.orders().remove(self.line, |_, line| drop(line));
        self.core.board.leave(&self.at);
    }
}

/// The reading end.
struct In {
    intake: Intake,
    inbox: Arc<Inbox>,
    /// Whether overwritten samples count as lost.
    counts: bool,
    _core: Arc<Core>,
}

impl Subscription for In {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        let mailbox = &self.inbox.mailbox;
        self.intake.read(into, |decode| mailbox.take(|sample| decode(sample)))
    }

    fn on_arrival(&mut self, told: Box<dyn Fn() + Send + Sync>) -> bool {
        self.inbox.told.set(told).is_ok()
    }

    fn dropped(&self) -> u64 {
        if self.counts { self.inbox.mailbox.lost() } else { 0 }
    }
}
