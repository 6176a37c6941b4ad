//! The ends of ports, as codels use them through the runtime.

use genom_bench::pair::{Receive, Send};
use genom_bench::{FloorError, octets};
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

fn values(bytes: usize) -> [(Address, Record); 2] {
    let at = |kind| Address::new("bench", format!("{kind}{bytes}"));
    [(at("array"), octets::array(bytes)), (at("sequence"), octets::sequence(bytes))]
}

pub(crate) fn writers(of: &dyn Middleware, bytes: usize) -> [Box<dyn Send>; 2] {
    values(bytes).map(|(at, value)| {
        Box::new(Out(of.publisher(&PortSpec::new(&at, value.ty())).unwrap(), value))
            as Box<dyn Send>
    })
}

pub(crate) fn readers(of: &dyn Middleware, bytes: usize) -> [Box<dyn Receive>; 2] {
    values(bytes).map(|(at, value)| {
        let reader = of.subscription(&PortSpec::new(&at, value.ty()), Policy::Latest).unwrap();
        Box::new(In(reader, value)) as Box<dyn Receive>
    })
}
