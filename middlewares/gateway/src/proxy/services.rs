//! Services: requests and their replies pass through the gateway under numbers.

use std::sync::{Arc, Mutex};

use genom_middleware::describe::types_of_service;
use genom_middleware::{
    Address, CallError, Client, OpenError, Replies, Running, Served, ServiceHandler, ServiceType,
    Services,
};
use genom_types::Record;

use super::book::{Call, Kind, Shared};
use super::core::{Held, Proxy};
use crate::words::{Service, Up, What};

impl Services for Proxy {
    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        let what = What::Served { address: at.clone(), service: Service::of(service) };
        let held = self.hold(at, what, Kind::Served(service.clone(), handler))?;
        Ok(Box::new(ProxyServed(held)))
    }

    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError> {
        let what = What::Client { address: at.clone(), service: Service::of(service) };
        let held = self.hold(at, what, Kind::Client)?;
        Ok(Box::new(ProxyClient { at: at.clone(), service: service.clone(), held }))
    }
}

impl Proxy {
    fn hold(&self, at: &Address, what: What, kind: Kind) -> Result<Held, OpenError> {
        let (shared, end) = (self.shared(), self.shared().end_number());
        shared.open(end, what, kind).map_err(|why| shared.open_error(why, at))?;
        Ok(Held { end, core: Arc::clone(&self.core) })
    }
}

struct ProxyServed(#[allow(dead_code, reason = "closes the service when dropped")] Held);

impl Served for ProxyServed {}

/// The calling end.
struct ProxyClient {
    at: Address,
    service: ServiceType,
    held: Held,
}

impl Client for ProxyClient {
    fn request(
        &mut self,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Result<Box<dyn Running>, CallError> {
        if !input.ty().same_as(&self.service.input) {
            let ours = types_of_service(&self.service);
            let address = self.at.clone();
            return Err(CallError::TypeMismatch { address, theirs: ours.clone(), ours });
        }
        let mut message = Vec::new();
        let encoded = input.encode_message(&mut message);
        encoded.map_err(|error| CallError::Serialization(error.to_string()))?;
        let replies = Arc::new(Mutex::new(Some(replies)));
        let call = Call { replies, output: self.service.output.clone() };
        let shared = &self.held.core.shared;
        let number = shared.call(self.held.end, call, &message)?;
        Ok(Box::new(ProxyRunning { shared: Arc::clone(shared), number }))
    }
}

/// A request under way.
struct ProxyRunning {
    shared: Arc<Shared>,
    number: u64,
}

impl Running for ProxyRunning {
    fn cancel(&self) {
        // Without a gateway it has ended.
        let _ = self.shared.say(&Up::Cancel { call: self.number }, &[]);
    }
}
