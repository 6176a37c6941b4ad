//! How ends are opened for proxies.

use std::sync::{Arc, Mutex, OnceLock};

use genom_middleware::{OpenError, PortSpec, Subscription};
use genom_types::{DataType, DefinitionError};

use super::guest::Guest;
use super::held::{End, Feed, Writer};
use super::requests::PassOn;
use crate::words::{Down, Refusal, What};

impl From<DefinitionError> for Refusal {
    fn from(error: DefinitionError) -> Self {
        Self::Own(error.to_string())
    }
}

impl From<OpenError> for Refusal {
    fn from(error: OpenError) -> Self {
        Self::Open(error)
    }
}

impl Guest {
    /// Opens an end, and tells the proxy.
    pub(super) fn open(self: &Arc<Self>, end: u32, what: What) {
        match self.make(end, what) {
            Ok(made) => match self.keep(end, made) {
                Ok(()) => {
                    self.say(&Down::Opened { end }, &[]);
                    // What came before is sent now.
                    if let Some(line) = self.line(end)
                        && let Some(orders) = self.orders()
                    {
                        orders.mark(line);
                    }
                }
                // Closed meanwhile, or the proxy has gone.
                Err(made) => self.end(Some(made)),
            },
            Err(why) => {
                self.forget(end);
                self.say(&Down::Refused { end, why }, &[]);
            }
        }
    }

    fn make(self: &Arc<Self>, end: u32, what: What) -> Result<End, Refusal> {
        let on = &self.middleware;
        Ok(match what {
            What::Publisher { address, ty, quality } => {
                let ty = ty.read()?;
                let publisher = on.publisher(&PortSpec::new(&address, &ty).of(quality))?;
                End::Publisher(Arc::new(Mutex::new(Writer::new(end, publisher, &ty))))
            }
            What::Subscription { address, ty, quality, policy } => {
                let ty = ty.read()?;
                let port = PortSpec::new(&address, &ty).of(quality);
                let subscription = on.subscription(&port, policy)?;
                self.feed(end, subscription, &ty)?
            }
            What::Served { address, service } => {
                let service = service.read()?;
                let handler = PassOn::new(self, end, &service);
                End::Served(on.serve(&address, &service, Arc::new(handler))?)
            }
            What::Client { address, service } => {
                let service = service.read()?;
                End::Client(Arc::new(Mutex::new((on.client(&address, &service)?, service))))
            }
            What::Announcement { name } => {
                let relay = on.relay();
                let relay = relay.ok_or_else(|| Refusal::Own("it relays no messages".into()))?;
                let announced = relay.announce(&name, self.messages_for(end));
                End::Announcement(announced.map_err(Refusal::Announce)?)
            }
        })
    }

    fn feed(
        self: &Arc<Self>,
        end: u32,
        mut subscription: Box<dyn Subscription>,
        ty: &DataType,
    ) -> Result<End, Refusal> {
        let orders = self.orders().ok_or_else(|| Refusal::Own("the gateway ends".into()))?;
        let number = Arc::new(OnceLock::new());
        let (line, bell) = (Arc::clone(&number), orders.clone());
        let told = move || {
            // Before it has a number, what arrived is sent when it gets one.
            if let Some(line) = line.get() {
                bell.mark(*line);
            }
        };
        if !subscription.on_arrival(Box::new(told)) {
            return Err(Refusal::Own("it does not tell of samples that arrive".into()));
        }
        let line = orders.add(Feed::new(end, subscription, ty, self.mouth()));
        let _ = number.set(line);
        Ok(End::Subscription(line))
    }
}
