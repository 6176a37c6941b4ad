//! The value that an out port wrote last, unchanged bit by bit: when the port moves, it is the
//! first value that readers get on the new middleware.
//!
//! The component keeps a copy of values up to 64 KiB. It keeps a copy of larger ones only while
//! somebody watches them; otherwise the value is read back from the old middleware, which offers it
//! to late readers.

use std::time::{Duration, Instant};

use genom_configuration::BackendNames;
use genom_middleware::{Address, Policy, PortSpec, Reading, Subscription};
use genom_ports::{Fan, PortKey};
use genom_types::{DataType, Record};

use super::core::{Connections, LOOK_AGAIN, NETWORK};
use crate::components::Hosted;

/// How long to wait for the last value on a middleware within the machine.
const MACHINE: Duration = Duration::from_millis(500);

/// The value that a port wrote last, at some moment.
#[derive(Default)]
pub(super) struct LastValue {
    /// `None` if nothing was written, or if the value cannot be read back.
    pub(super) value: Option<Record>,
    /// Number of samples written by then.
    samples: u64,
    /// The subscription it was read back from.
    back: Option<Box<dyn Subscription>>,
}

impl Connections {
    /// The value that a port wrote last. May wait for a middleware.
    pub(super) fn last_value(
        &self,
        hosted: &Hosted,
        key: &PortKey,
        fan: &Fan,
        ty: &DataType,
    ) -> LastValue {
        let samples = fan.gauge().counts().samples;
        let value = hosted.last_value(key).filter(|_| samples > 0);
        let mut last = LastValue { value, samples, back: None };
        if samples > 0 && last.value.is_none() {
            let (address, on) = (hosted.port_address(key), hosted.backends_of(key));
            last.read_back(self, &address, &on, ty);
            if last.value.is_none() {
                tracing::warn!(
                    "the last value of {address} cannot be read back from {on}: readers where it \
                     moves to wait for the next one"
                );
            }
        }
        last
    }
}

impl LastValue {
    fn read_back(
        &mut self,
        connections: &Connections,
        address: &Address,
        on: &BackendNames,
        ty: &DataType,
    ) {
        let open = on.names().iter().filter_map(|name| connections.backends.get(name).ok());
        let mut open: Vec<_> = open.collect();
        open.sort_by_key(|middleware| middleware.capabilities().cross_host);
        for middleware in open {
            let port = PortSpec::new(address, ty);
            let Ok(mut reader) = middleware.subscription(&port, Policy::Latest) else { continue };
            let network = middleware.capabilities().cross_host;
            let patience = if network { NETWORK } else { MACHINE };
            if let Some(value) = sample(reader.as_mut(), ty, patience) {
                (self.value, self.back) = (Some(value), Some(reader));
                return;
            }
        }
    }

    /// Updates the value if samples were written since. Returns whether it changed. All codels must
    /// be excluded during the call.
    pub(super) fn renew(&mut self, hosted: &Hosted, key: &PortKey, fan: &Fan) -> bool {
        let samples = fan.gauge().counts().samples;
        if samples == self.samples {
            return false;
        }
        self.samples = samples;
        match (&mut self.back, &mut self.value) {
            (Some(reader), Some(value)) => reader.read(value) == Ok(Reading::New),
            _ => {
                let last = hosted.last_value(key);
                let there = last.is_some();
                self.value = last.or(self.value.take());
                there
            }
        }
    }
}

/// The next sample; none if it does not arrive within this time.
fn sample(reader: &mut dyn Subscription, ty: &DataType, patience: Duration) -> Option<Record> {
    let end = Instant::now() + patience;
    let mut value = Record::new(ty);
    while reader.read(&mut value) != Ok(Reading::New) {
        if Instant::now() >= end {
            return None;
        }
        std::thread::park_timeout(LOOK_AGAIN);
    }
    Some(value)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use genom_middleware::ReadError;
    use genom_types::{Kind, TypeTable};

    use super::*;

    /// A subscription to what nobody publishes.
    struct Silent;

    impl Subscription for Silent {
        fn read(&mut self, _: &mut Record) -> Result<Reading, ReadError> {
            Ok(Reading::Never)
        }

        fn dropped(&self) -> u64 {
            0
        }
    }

    #[test]
    fn a_last_value_that_does_not_arrive_is_none_and_not_zeros() {
        let mut types = TypeTable::default();
        let id = types.add(Kind::Double);
        let ty = DataType::new(&Arc::new(types), id).unwrap();
        assert!(sample(&mut Silent, &ty, Duration::ZERO).is_none());
    }
}
