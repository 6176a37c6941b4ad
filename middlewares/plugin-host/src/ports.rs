//! The two ends of a port: queues between real-time threads and the library.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use genom_kit::intake::{Intake, Keeping};
use genom_kit::mailbox::PutError;
use genom_middleware::{
    OpenError, Policy, PortSpec, Ports, PublishError, Publisher, ReadError, Reading, Subscription,
};
use genom_plugin_abi::Code;
use genom_plugin_abi::table::can;
use genom_types::Record;

use crate::callbacks::give;
use crate::calls::Handle;
use crate::describe::{sides_of_port, with_port};
use crate::form::Form;
use crate::given::{Given, Inbox};
use crate::middleware::{Core, Open};
use crate::outlet::{Line, Outlet};

/// Samples of an out port that may wait to be sent, unless its quality of service asks for more or
/// they are large.
const UNSENT: usize = 16;

/// Most that may be asked for.
const MOST_UNSENT: usize = 1024;

/// Limit in bytes for those that wait.
const UNSENT_BYTES: usize = 4 << 20;

impl Ports for Open {
    fn publisher(&self, port: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError> {
        let core = Arc::clone(&self.0);
        let opened = with_port(port, Policy::Latest, |port| core.backend.publisher(port));
        let sides = || sides_of_port(core.library.name(), port);
        let handle = Arc::new(opened.map_err(|failure| failure.opening(&sides()))?);
        let form = Form::new(port.ty, core.can(can::LAYOUT));
        if core.can(can::RT_PUBLISH) {
            let buffer = Vec::with_capacity(form.room());
            return Ok(Box::new(Direct { handle, form, buffer, refused: 0, _core: core }));
        }
        let most = port.quality.depth.unwrap_or(UNSENT).clamp(UNSENT, MOST_UNSENT);
        let depth = (UNSENT_BYTES / form.room()).clamp(1, most);
        let outlet = Arc::new(Outlet::new(form, depth));
        let line = Line { outlet: Arc::clone(&outlet), handle: Arc::clone(&handle) };
        let line = core.sender.orders().add(line);
        Ok(Box::new(Out { outlet, line, handle, core }))
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let core = Arc::clone(&self.0);
        let form = Form::new(port.ty, core.can(can::LAYOUT));
        let keeping = Keeping::of(policy, core.library.name(), port.ty)?;
        let inbox = Arc::new(Inbox::new(keeping, form.room()));
        let to = give(Given::Inbox(Arc::clone(&inbox)));
        let opened = with_port(port, policy, |port| core.backend.subscription(port, to));
        let sides = || sides_of_port(core.library.name(), port);
        let handle = opened.map_err(|failure| failure.opening(&sides()))?;
        let intake = Intake::new(port.ty);
        Ok(Box::new(In { handle, inbox, intake, form, seen: false, _core: core }))
    }
}

/// An out port. Fields are dropped in order.
struct Out {
    outlet: Arc<Outlet>,
    line: usize,
    handle: Arc<Handle>,
    core: Arc<Core>,
}

impl Publisher for Out {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        let Outlet { form, mailbox, .. } = &*self.outlet;
        if !value.ty().same_as(&form.ty) {
            return Err(PublishError::Refused);
        }
        mailbox.put(|buffer| form.pack(value, buffer)).map_err(|error| match error {
            PutError::Fill(error) => error,
            PutError::Busy => PublishError::Refused,
        })?;
        self.core.sender.orders().mark(self.line);
        Ok(())
    }

    fn publish_message(&mut self, message: &[u8]) -> Option<Result<(), PublishError>> {
        let Outlet { form, mailbox, .. } = &*self.outlet;
        if form.layout {
            return None;
        }
        let Ok(size) = form.ty.check_message(message) else {
            return Some(Err(PublishError::Serialization));
        };
        let put = mailbox.put(|buffer| {
            buffer.extend_from_slice(message.get(..size).unwrap_or(message));
            Ok::<_, Infallible>(())
        });
        self.core.sender.orders().mark(self.line);
        Some(put.map_err(|_| PublishError::Refused))
    }

    fn dropped(&self) -> u64 {
        let Outlet { mailbox, refused, .. } = &*self.outlet;
        mailbox.lost() + refused.load(Ordering::Relaxed) + self.handle.lost_by_publisher()
    }
}

impl Drop for Out {
    fn drop(&mut self) {
        // What waits is sent before the end is closed.
        self.core.sender.orders().remove(self.line, |_, line| drop(line));
    }
}

/// An out port whose library says that tasks may call it. Fields are dropped in order.
struct Direct {
    handle: Arc<Handle>,
    form: Form,
    buffer: Vec<u8>,
    refused: u64,
    _core: Arc<Core>,
}

impl Direct {
    fn send(&mut self) -> Result<(), PublishError> {
        match self.handle.publish(&self.buffer) {
            Code::OK => Ok(()),
            Code::BAD_DATA => Err(PublishError::Serialization),
            _ => {
                self.refused += 1;
                Err(PublishError::Refused)
            }
        }
    }
}

impl Publisher for Direct {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        if !value.ty().same_as(&self.form.ty) {
            return Err(PublishError::Refused);
        }
        self.buffer.clear();
        self.form.pack(value, &mut self.buffer)?;
        self.send()
    }

    fn dropped(&self) -> u64 {
        self.refused + self.handle.lost_by_publisher()
    }
}

/// An in port. Fields are dropped in order.
struct In {
    handle: Handle,
    inbox: Arc<Inbox>,
    intake: Intake,
    form: Form,
    /// Whether a sample in C layout has been read yet.
    seen: bool,
    _core: Arc<Core>,
}

impl In {
    fn read_layout(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        if !into.ty().same_as(&self.form.ty) {
            return Err(ReadError::Broken);
        }
        match self.inbox.mailbox.take(|sample| self.form.unpack(sample, into)) {
            None if self.seen => Ok(Reading::Same),
            None => Ok(Reading::Never),
            Some(false) => Err(ReadError::Serialization),
            Some(true) => {
                self.seen = true;
                Ok(Reading::New)
            }
        }
    }

    fn counted(&self, read: Result<Reading, ReadError>) -> Result<Reading, ReadError> {
        if read == Err(ReadError::Serialization) {
            self.inbox.undecodable.fetch_add(1, Ordering::Relaxed);
        }
        read
    }
}

impl Subscription for In {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        if self.form.layout {
            let read = self.read_layout(into);
            return self.counted(read);
        }
        let mailbox = &self.inbox.mailbox;
        let read = self.intake.read(into, |decode| mailbox.take(|sample| decode(sample)));
        self.counted(read)
    }

    fn read_message(&mut self, into: &mut Vec<u8>) -> Option<Result<Reading, ReadError>> {
        if self.form.layout {
            return None;
        }
        let mailbox = &self.inbox.mailbox;
        let read = self.intake.read_message(into, |see| mailbox.take(|sample| see(sample)));
        Some(self.counted(read))
    }

    fn on_arrival(&mut self, told: Box<dyn Fn() + Send + Sync>) -> bool {
        self.inbox.told.set(told).is_ok()
    }

    fn arrived(&self) -> Option<u64> {
        self.inbox.mailbox.put_at()
    }

    fn dropped(&self) -> u64 {
        self.inbox.lost() + self.handle.lost_by_subscription()
    }
}
