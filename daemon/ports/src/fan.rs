//! The writing side of an out port: its publishers, on one middleware or several, can be exchanged
//! while the component runs.

use std::sync::Arc;

use genom_middleware::{PublishError, Publisher};
use genom_runtime::Clock;
use genom_types::{DataType, Record};

use crate::gauge::Gauge;
use crate::held::Held;
use crate::tape::{Tapes, Way};

/// The publishers of an out port, each with the name of its middleware, in the order requested.
pub type Ends = Vec<(String, Box<dyn Publisher>)>;

/// The supervisor's handle on an out port's publishers.
#[derive(Clone)]
pub struct Fan {
    ends: Arc<Held<Ends>>,
    gauge: Arc<Gauge>,
    tapes: Arc<Tapes>,
}

impl Fan {
    /// A port of type `ty` with these publishers.
    pub fn new(ends: Ends, clock: &Clock, ty: &DataType) -> Self {
        Self {
            ends: Arc::new(Held::new(ends, Vec::new)),
            gauge: Arc::new(Gauge::new(clock, ty)),
            tapes: Arc::default(),
        }
    }

    /// The publisher that is given to the component.
    pub fn publisher(&self) -> Box<dyn Publisher> {
        Box::new(FanPublisher { fan: self.clone(), scratch: Vec::new() })
    }

    /// Counters of the samples written.
    pub fn gauge(&self) -> &Arc<Gauge> {
        &self.gauge
    }

    /// The recordings that take samples of this port.
    pub fn tapes(&self) -> &Arc<Tapes> {
        &self.tapes
    }

    /// Changes the publishers. `change` receives the present ones and returns those to be dropped
    /// by the caller, since dropping one may take long. All codels must be excluded during the
    /// call.
    pub fn exchange(&self, change: impl FnOnce(&mut Ends) -> Ends) -> Ends {
        self.ends.with(change)
    }

    /// Drops the publishers of a component that did not stop. Returns `false` if a codel stays inside
    /// `write`: they are dropped when it comes back.
    pub fn cut(&self) -> bool {
        self.ends.cut()
    }
}

impl std::fmt::Debug for Fan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fan").field("gauge", &self.gauge).finish_non_exhaustive()
    }
}

struct FanPublisher {
    fan: Fan,
    /// Encoding buffer for measuring samples of variable size.
    scratch: Vec<u8>,
}

impl Publisher for FanPublisher {
    /// Publishes on every middleware. Fails, with the first error, only if none of them took the
    /// value.
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        let Fan { ends, gauge, tapes } = &self.fan;
        let scratch = &mut self.scratch;
        ends.used(|ends| {
            let (mut taken, mut dropped, mut failure) = (false, 0, None);
            let begun = tapes.begin();
            for (_, end) in ends.iter_mut() {
                match end.publish(value) {
                    Ok(()) => taken = true,
                    Err(error) => {
                        gauge.failed();
                        failure = failure.or(Some(error));
                    }
                }
                dropped += end.dropped();
            }
            match failure {
                Some(error) if !taken => Err(error),
                _ => {
                    gauge.passed(dropped);
                    gauge.weigh(value, scratch);
                    tapes.take(value, Way { begun, arrived: None });
                    Ok(())
                }
            }
        })
    }

    fn dropped(&self) -> u64 {
        self.fan.ends.with(|ends| ends.iter().map(|(_, end)| end.dropped()).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_middleware::{Address, Middleware, Policy, PortSpec, Ports as _, Reading};
    use genom_types::{DataType, Kind, TypeTable};

    fn double() -> DataType {
        let mut table = TypeTable::default();
        let id = table.add(Kind::Double);
        DataType::new(&Arc::new(table), id).unwrap()
    }

    #[test]
    fn a_value_goes_to_all_ends_and_to_the_new_one_after_an_exchange() {
        let (one, two) = (genom_local::Local::new(), genom_local::Local::new());
        let (ty, at) = (double(), Address::new("demo", "position"));
        let end = |on: &dyn Middleware| on.publisher(&PortSpec::new(&at, &ty)).unwrap();
        let ends = vec![("one".into(), end(&one)), ("two".into(), end(&two))];
        let fan = Fan::new(ends, &Clock::Monotonic, &ty);
        let mut publisher = fan.publisher();
        let mut value = Record::new(&ty);
        value.merge_json(&0.5.into()).unwrap();
        publisher.publish(&value).unwrap();
        for on in [&one, &two] {
            let mut reader = on.subscription(&PortSpec::new(&at, &ty), Policy::Latest).unwrap();
            let mut read = Record::new(&ty);
            assert_eq!(reader.read(&mut read), Ok(Reading::New));
            assert_eq!(read.to_json(), 0.5);
        }
        let old = fan.exchange(|ends| vec![ends.remove(0)]);
        assert_eq!(old[0].0, "one");
        drop(old);
        // The address is free again on the middleware that the port left.
        drop(one.publisher(&PortSpec::new(&at, &ty)).unwrap());
        publisher.publish(&value).unwrap();
        assert_eq!(fan.gauge().counts().samples, 2);
    }
}
