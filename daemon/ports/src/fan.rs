//! The writing end of an out port on one middleware or several, which may be exchanged while
//! the component runs.

use std::sync::{Arc, Mutex, PoisonError, TryLockError};

use genom_middleware::{PublishError, Publisher};
use genom_runtime::Clock;
use genom_types::{DataType, Record};

use crate::gauge::Gauge;
use crate::tape::Tapes;

/// What an out port publishes on: middlewares by name, in the order given.
pub type Ends = Vec<(String, Box<dyn Publisher>)>;

/// The supervisor's handle on an out port's publishers.
#[derive(Clone)]
pub struct Fan {
    /// Taken by the codel at each write, and by the supervisor only with all codels excluded:
    /// a codel never waits for it.
    ends: Arc<Mutex<Ends>>,
    gauge: Arc<Gauge>,
    tapes: Arc<Tapes>,
}

impl Fan {
    /// A port of this type on these.
    pub fn new(ends: Ends, clock: &Clock, ty: &DataType) -> Self {
        Self {
            ends: Arc::new(Mutex::new(ends)),
            gauge: Arc::new(Gauge::new(clock, ty)),
            tapes: Arc::default(),
        }
    }

    /// What the component writes to.
    pub fn publisher(&self) -> Box<dyn Publisher> {
        Box::new(FanPublisher { fan: self.clone(), scratch: Vec::new() })
    }

    /// What passed.
    pub fn gauge(&self) -> &Arc<Gauge> {
        &self.gauge
    }

    /// Where values are recorded.
    pub fn tapes(&self) -> &Arc<Tapes> {
        &self.tapes
    }

    /// Exchanges the ends: `change` gets the present ones and gives back those to drop later,
    /// which may take its time. To be called with all codels excluded.
    pub fn exchange(&self, change: impl FnOnce(&mut Ends) -> Ends) -> Ends {
        change(&mut self.ends.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Closes the ends of a component that did not stop, unless a codel is within `write`;
    /// whether it could.
    pub fn cut(&self) -> bool {
        let ends = match self.ends.try_lock() {
            Ok(mut ends) => std::mem::take(&mut *ends),
            Err(TryLockError::Poisoned(poisoned)) => std::mem::take(&mut *poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => return false,
        };
        // Closed without holding up the codel that returns in this moment.
        drop(ends);
        true
    }
}

impl std::fmt::Debug for Fan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fan").field("gauge", &self.gauge).finish_non_exhaustive()
    }
}

struct FanPublisher {
    fan: Fan,
    /// For weighing samples.
    scratch: Vec<u8>,
}

impl Publisher for FanPublisher {
    /// Publishes on all; the first failure is told when none took the value.
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        let Fan { ends, gauge, tapes } = &self.fan;
        let mut ends = ends.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut taken, mut dropped, mut failure) = (false, 0, None);
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
                gauge.weigh(value, &mut self.scratch);
                tapes.take(value);
                Ok(())
            }
        }
    }

    fn dropped(&self) -> u64 {
        let ends = self.fan.ends.lock().unwrap_or_else(PoisonError::into_inner);
        ends.iter().map(|(_, end)| end.dropped()).sum()
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
        // The address is free on the middleware it left.
        drop(one.publisher(&PortSpec::new(&at, &ty)).unwrap());
        publisher.publish(&value).unwrap();
        assert_eq!(fan.gauge().counts().samples, 2);
    }
}
