//! The reading side of a connection: its subscription can be exchanged while codels read.

use std::sync::Arc;

use genom_middleware::{ReadError, Reading, Subscription};
use genom_runtime::Clock;
use genom_types::{DataType, Record};

use crate::gauge::Gauge;
use crate::held::Held;
use crate::tape::{Tapes, Way};

/// The supervisor's handle on the subscription of an in port.
#[derive(Clone)]
pub struct Tap {
    end: Arc<Held<Box<dyn Subscription>>>,
    gauge: Arc<Gauge>,
    tapes: Arc<Tapes>,
}

impl Tap {
    /// A connection of type `ty` that reads from `end`.
    pub fn new(end: Box<dyn Subscription>, clock: &Clock, ty: &DataType) -> Self {
        let (gauge, tapes) = (Arc::new(Gauge::new(clock, ty)), Arc::default());
        Self { end: Arc::new(Held::new(end, || Box::new(Nothing))), gauge, tapes }
    }

    /// The subscription that is given to the component.
    pub fn subscription(&self) -> Box<dyn Subscription> {
        Box::new(TapSubscription { tap: self.clone(), read: false, scratch: Vec::new() })
    }

    /// Counters of the samples read.
    pub fn gauge(&self) -> &Arc<Gauge> {
        &self.gauge
    }

    /// The recordings that take samples of this connection.
    pub fn tapes(&self) -> &Arc<Tapes> {
        &self.tapes
    }

    /// Replaces the subscription, and returns the previous one to be dropped by the caller. All
    /// codels must be excluded during the call.
    pub fn exchange(&self, end: Box<dyn Subscription>) -> Box<dyn Subscription> {
        self.end.with(|present| std::mem::replace(present, end))
    }

    /// Drops the subscription of a component that did not stop. Returns `false` if a codel stays inside
    /// `read`: it is dropped when that comes back.
    pub fn cut(&self) -> bool {
        self.end.cut()
    }
}

/// Replaces the subscription of a component that did not stop; never has a sample.
struct Nothing;

impl Subscription for Nothing {
    fn read(&mut self, _: &mut Record) -> Result<Reading, ReadError> {
        Ok(Reading::Never)
    }

    fn dropped(&self) -> u64 {
        0
    }
}

impl std::fmt::Debug for Tap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tap").field("gauge", &self.gauge).finish_non_exhaustive()
    }
}

struct TapSubscription {
    tap: Tap,
    /// Whether a sample was ever read. If so the reader has a last value, even if a new
    /// subscription has none yet.
    read: bool,
    /// Encoding buffer for measuring samples of variable size.
    scratch: Vec<u8>,
}

impl Subscription for TapSubscription {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        let Tap { end, gauge, tapes } = &self.tap;
        let (read, scratch) = (&mut self.read, &mut self.scratch);
        end.used(|end| {
            let begun = tapes.begin();
            let reading = end.read(into);
            // Some middlewares detect losses only when there is nothing more to read.
            gauge.lost(end.dropped());
            match reading {
                Ok(Reading::New) => {
                    *read = true;
                    gauge.passed(end.dropped());
                    gauge.weigh(into, scratch);
                    tapes.take(into, Way { begun, arrived: end.arrived() });
                    Ok(Reading::New)
                }
                Ok(Reading::Never) if *read => Ok(Reading::Same),
                Ok(other) => Ok(other),
                Err(error) => {
                    gauge.failed();
                    Err(error)
                }
            }
        })
    }

    fn dropped(&self) -> u64 {
        self.tap.end.with(|end| end.dropped())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_middleware::{Address, Middleware, Policy, PortSpec, Ports as _};
    use genom_types::{DataType, Kind, TypeTable};

    /// Has no sample, and reports three more lost ones at each read.
    struct Lossy(u64);

    impl Subscription for Lossy {
        fn read(&mut self, _: &mut Record) -> Result<Reading, ReadError> {
            self.0 += 3;
            Ok(Reading::Same)
        }

        fn dropped(&self) -> u64 {
            self.0
        }
    }

    #[test]
    fn losses_that_show_after_the_last_sample_are_counted() {
        let mut table = TypeTable::default();
        let id = table.add(Kind::Double);
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        let tap = Tap::new(Box::new(Lossy(0)), &Clock::Monotonic, &ty);
        assert_eq!(tap.subscription().read(&mut Record::new(&ty)), Ok(Reading::Same));
        assert_eq!(tap.gauge().counts().dropped, 3);
    }

    #[test]
    fn a_reader_keeps_its_last_value_when_the_middleware_is_exchanged() {
        let mut table = TypeTable::default();
        let id = table.add(Kind::Double);
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        let (one, two) = (genom_local::Local::new(), genom_local::Local::new());
        let at = Address::new("demo", "position");
        let open = |on: &dyn Middleware| {
            on.subscription(&PortSpec::new(&at, &ty), Policy::Latest).unwrap()
        };
        let tap = Tap::new(open(&one), &Clock::Monotonic, &ty);
        let (mut reader, mut into) = (tap.subscription(), Record::new(&ty));
        assert_eq!(reader.read(&mut into), Ok(Reading::Never));
        let mut value = Record::new(&ty);
        value.merge_json(&0.5.into()).unwrap();
        one.publisher(&PortSpec::new(&at, &ty)).unwrap().publish(&value).unwrap();
        assert_eq!(reader.read(&mut into), Ok(Reading::New));
        drop(tap.exchange(open(&two)));
        assert_eq!(reader.read(&mut into), Ok(Reading::Same));
        assert_eq!(into.to_json(), 0.5);
        two.publisher(&PortSpec::new(&at, &ty)).unwrap().publish(&value).unwrap();
        assert_eq!(reader.read(&mut into), Ok(Reading::New));
        assert_eq!(tap.gauge().counts().samples, 2);
    }
}
