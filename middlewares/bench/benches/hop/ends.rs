//! The ends of ports, as codels use them through the runtime.

use genom_bench::FloorError;
use genom_bench::pair::{Receive, Send};
use genom_middleware::{Address, Middleware, Policy, PortSpec, Publisher, Reading, Subscription};
use genom_types::Record;

struct Out(Box<dyn Publisher>, Record);

struct In(Box<dyn Subscription>, Record);

impl Send for Out {
    fn send(&mut self) -> Result<(), FloorError> {
        self.0.publish(&self.1).unwrap();
        Ok(())
    }
}

impl Receive for In {
    fn arrived(&mut self) -> Result<bool, FloorError> {
        Ok(self.0.read(&mut self.1) == Ok(Reading::New))
    }
}

/// An out port that writes this value.
pub(crate) fn writer(of: &dyn Middleware, at: &Address, value: Record) -> Box<dyn Send> {
    Box::new(Out(of.publisher(&PortSpec::new(at, value.ty())).unwrap(), value))
}

/// An in port that reads values of this type.
pub(crate) fn reader(
    of: &dyn Middleware,
    at: &Address,
    value: Record,
    policy: Policy,
) -> Box<dyn Receive> {
    Box::new(In(of.subscription(&PortSpec::new(at, value.ty()), policy).unwrap(), value))
}
